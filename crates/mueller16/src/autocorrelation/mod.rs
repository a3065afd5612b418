//! Stationary autocorrelation functions R of matter, each a sum of Gaussians.
//!
//! ```text
//! R(x) = Σ_families Σ_terms p e^(−m xᵀ (DᵀD)⁻¹ x/2) e^(iG·x)          p weight, m rate, G shift
//! ```
//!
//! Real weights make R Hermitian, `R(−x) = R(x)*`, and its transform real; positive ones make it a lobe that is
//! nowhere negative. Terms of one family differ in width and place only, so that what they share is computed once.

mod charlier;
mod error;
mod exponential_heights;
mod heights;
mod k_correlated_heights;
mod k_correlation;
mod least_squares;
mod phase;
mod poisson;
mod rates;
mod tabulated;

pub use error::AutocorrelationError;
pub use exponential_heights::ExponentialHeights;
pub use heights::GaussianHeights;
pub use k_correlated_heights::KCorrelatedHeights;
pub use k_correlation::KCorrelation;
pub use tabulated::{TableError, TabulatedSpectrum};

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use smallvec::{SmallVec, smallvec};
use stokes::plane;

/// Singular values of a correlation root lie in this range, in metres.
const ROOT_RANGE: [f64; 2] = [1e-30, 1e30];

/// One Gaussian of a family: `weight · e^(−rate xᵀ (DᵀD)⁻¹ x/2) e^(i shift·x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianTerm {
    /// Value at 0, dimensionless, of either sign.
    pub weight: f64,
    /// Narrowness beside the family's root, dimensionless and not negative; 0 is a function that does not decay, whose
    /// lobe is a delta for a plane wave.
    pub rate: f64,
    /// Centre of the lobe, rad/m: `q G` of a grating's order.
    pub shift: Vector2<f64>,
}

impl GaussianTerm {
    /// A term about the mirror direction.
    #[must_use]
    pub fn centred(weight: f64, rate: f64) -> Self {
        Self {
            weight,
            rate,
            shift: Vector2::zeros(),
        }
    }
}

/// Gaussians of one shape: `DᵀD` is the covariance, m², of the Gaussian of rate 1.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianFamily {
    root: Matrix2<f64>,
    determinant: f64,
    terms: SmallVec<[GaussianTerm; 4]>,
}

impl GaussianFamily {
    /// The sum of `terms` over the shape of `root`, D, in metres.
    ///
    /// # Errors
    ///
    /// When the root is singular or outside 1e-30 to 1e30 m, a weight or shift is not finite, or a rate is negative.
    pub fn new(
        root: &Matrix2<f64>,
        terms: impl IntoIterator<Item = GaussianTerm>,
    ) -> Result<Self, AutocorrelationError> {
        let shape = stokes::ShapeMatrix::from_root(root)?;
        let bounds = plane::singular_values(root).values;
        if let Some(value) = bounds
            .into_iter()
            .find(|v| !(ROOT_RANGE[0]..=ROOT_RANGE[1]).contains(v))
        {
            return Err(AutocorrelationError::Length { value });
        }
        let terms: SmallVec<_> = terms.into_iter().collect();
        for (index, term) in terms.iter().enumerate() {
            check(index, term)?;
        }
        Ok(Self {
            root: *root,
            determinant: shape.root_determinant() * plane::determinant(root).signum(),
            terms,
        })
    }

    /// Other Gaussians, made of some that were checked, over the same root.
    pub(crate) fn with_terms(&self, terms: SmallVec<[GaussianTerm; 4]>) -> Self {
        Self {
            terms,
            ..self.clone()
        }
    }

    /// The root D, 2×2, m.
    #[must_use]
    pub fn root(&self) -> &Matrix2<f64> {
        &self.root
    }

    /// `det D`, m², with its sign.
    #[must_use]
    pub fn root_determinant(&self) -> f64 {
        self.determinant
    }

    /// The Gaussians.
    #[must_use]
    pub fn terms(&self) -> &[GaussianTerm] {
        &self.terms
    }
}

fn check(index: usize, term: &GaussianTerm) -> Result<(), AutocorrelationError> {
    let wrong = |what, value, expected| AutocorrelationError::Term {
        index,
        what,
        value,
        expected,
    };
    if !term.weight.is_finite() {
        return Err(wrong("weight", term.weight, "a finite number"));
    }
    if !(0.0..=1e30).contains(&term.rate) {
        return Err(wrong("rate", term.rate, "a number between 0 and 1e30"));
    }
    match term.shift.iter().find(|s| s.is_nan() || s.abs() > 1e30) {
        Some(shift) => Err(wrong("shift", *shift, "a number of at most 1e30 rad/m")),
        None => Ok(()),
    }
}

/// The stationary autocorrelation R of a scatterer, as a sum of Gaussians; dimensionless.
///
/// ```
/// use mueller16::Autocorrelation;
/// use nalgebra::{Matrix2, Vector2};
/// // a lobe of 10 µm correlation on top of 30 % mirror
/// let rough = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10))?;
/// let surface = Autocorrelation::constant(0.3).plus(&rough.scaled(0.7));
/// assert!((surface.at_zero() - 1.0).abs() < 1e-15);
/// // F{R}(0) of the lobe is 2π 1e-10 m², the mirror is a delta
/// assert!((surface.spectrum(&Vector2::zeros()) - 0.7 * 6.283_185_307e-10).abs() < 1e-18);
/// assert!((surface.delta_weight() - 0.3).abs() < 1e-15);
/// # Ok::<(), mueller16::AutocorrelationError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Autocorrelation {
    families: SmallVec<[GaussianFamily; 1]>,
}

impl Autocorrelation {
    /// The same everywhere: matter without structure, a mirror.
    ///
    /// Not checked: [`crate::Matter::new`] refuses a value that is not finite, and so does light that would carry it.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self {
            families: smallvec![GaussianFamily {
                root: Matrix2::identity(),
                determinant: 1.0,
                terms: smallvec![GaussianTerm::centred(value, 0.0)],
            }],
        }
    }

    /// The Gaussian `e^(−xᵀ covariance⁻¹ x/2)`; covariance 2×2, m².
    ///
    /// # Errors
    ///
    /// When the covariance is not finite, not symmetric or not positive definite.
    pub fn gaussian(covariance: &Matrix2<f64>) -> Result<Self, AutocorrelationError> {
        let shape = stokes::ShapeMatrix::from_covariance(covariance)?;
        Self::of_family(shape.root(), [GaussianTerm::centred(1.0, 1.0)])
    }

    /// The sum of Gaussians of one shape.
    ///
    /// # Errors
    ///
    /// As [`GaussianFamily::new`].
    pub fn of_family(
        root: &Matrix2<f64>,
        terms: impl IntoIterator<Item = GaussianTerm>,
    ) -> Result<Self, AutocorrelationError> {
        Ok(GaussianFamily::new(root, terms)?.into())
    }

    /// The families of which it is the sum.
    #[must_use]
    pub fn families(&self) -> &[GaussianFamily] {
        &self.families
    }

    /// Number of Gaussians.
    #[must_use]
    pub fn term_count(&self) -> usize {
        self.families.iter().map(|family| family.terms.len()).sum()
    }

    /// Every weight times `factor`, which is checked where [`Autocorrelation::constant`] is.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for term in self.terms_mut() {
            term.weight *= factor;
        }
        self
    }

    /// `R(x) e^(i shift·x)`: the lobe moved by `shift` rad/m, which [`crate::Matter::new`] checks.
    #[must_use]
    pub fn shifted(mut self, shift: &Vector2<f64>) -> Self {
        for term in self.terms_mut() {
            term.shift += shift;
        }
        self
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        for family in &other.families {
            match self.families.iter_mut().find(|f| f.root == family.root) {
                Some(same) => same.terms.extend_from_slice(&family.terms),
                None => self.families.push(family.clone()),
            }
        }
        self
    }

    /// The product of two: every Gaussian of one with every one of the other.
    ///
    /// # Errors
    ///
    /// When the sum of two inverse covariances has no root.
    pub fn times(&self, other: &Self) -> Result<Self, AutocorrelationError> {
        let mut product = Self::default();
        for (mine, term) in self.all_terms() {
            for (theirs, factor) in other.all_terms() {
                product = product.plus(&joint(mine, term, theirs, factor)?);
            }
        }
        Ok(product)
    }

    /// `R(x)`, a separation x in metres; `R(−x) = R(x)*`.
    #[must_use]
    pub fn value(&self, x: &Vector2<f64>) -> Complex64 {
        self.all_terms()
            .map(|(family, term)| {
                let y = plane::apply(&plane::inverse(&family.root).transpose(), x);
                let height = term.weight * (-0.5 * term.rate * y.norm_squared()).exp();
                Complex64::from_polar(height, term.shift.dot(x))
            })
            .sum()
    }

    /// `R(0)`, which is real.
    #[must_use]
    pub fn at_zero(&self) -> f64 {
        self.all_terms().map(|(_, term)| term.weight).sum()
    }

    /// The lobe `F{R}(φ) = ∫ R(x) e^(−iφ·x) d²x` of a plane wave, m², without its deltas; `phi` in rad/m.
    #[must_use]
    pub fn spectrum(&self, phi: &Vector2<f64>) -> f64 {
        self.all_terms()
            .filter(|(_, term)| term.rate > 0.0)
            .map(|(family, term)| {
                let q = plane::apply(&family.root, &(phi - term.shift));
                let peak = std::f64::consts::TAU * family.determinant.abs() / term.rate;
                term.weight * peak * (-0.5 * q.norm_squared() / term.rate).exp()
            })
            .sum()
    }

    /// The terms that do not decay, as weight and place: for a plane wave `(2π)² weight δ(φ − place)` each.
    pub fn deltas(&self) -> impl Iterator<Item = (f64, Vector2<f64>)> + '_ {
        self.all_terms()
            .filter(|(_, term)| term.rate == 0.0)
            .map(|(_, term)| (term.weight, term.shift))
    }

    /// The sum of the weights of the terms that do not decay.
    #[must_use]
    pub fn delta_weight(&self) -> f64 {
        self.deltas().map(|(weight, _)| weight).sum()
    }

    /// The same without the terms that do not decay.
    #[must_use]
    pub fn without_deltas(mut self) -> Self {
        for family in &mut self.families {
            family.terms.retain(|term| term.rate > 0.0);
        }
        self.families.retain(|family| !family.terms.is_empty());
        self
    }

    /// Whether no weight is negative, by which the lobe is nowhere negative (Bochner).
    #[must_use]
    pub fn is_positive(&self) -> bool {
        self.all_terms().all(|(_, term)| term.weight >= 0.0)
    }

    fn all_terms(&self) -> impl Iterator<Item = (&GaussianFamily, &GaussianTerm)> + '_ {
        self.families
            .iter()
            .flat_map(|family| family.terms.iter().map(move |term| (family, term)))
    }

    fn terms_mut(&mut self) -> impl Iterator<Item = &mut GaussianTerm> {
        self.families
            .iter_mut()
            .flat_map(|family| family.terms.iter_mut())
    }
}

impl From<GaussianFamily> for Autocorrelation {
    fn from(family: GaussianFamily) -> Self {
        Self {
            families: smallvec![family],
        }
    }
}

/// The product of two Gaussians.
fn joint(
    a: &GaussianFamily,
    s: &GaussianTerm,
    b: &GaussianFamily,
    t: &GaussianTerm,
) -> Result<Autocorrelation, AutocorrelationError> {
    let term = |rate| GaussianTerm {
        weight: s.weight * t.weight,
        rate,
        shift: s.shift + t.shift,
    };
    if a.root == b.root {
        return Autocorrelation::of_family(&a.root, [term(s.rate + t.rate)]);
    }
    if t.rate == 0.0 {
        return Autocorrelation::of_family(&a.root, [term(s.rate)]);
    }
    if s.rate == 0.0 {
        return Autocorrelation::of_family(&b.root, [term(t.rate)]);
    }
    // K⁻¹ = m S⁻¹ + m' S'⁻¹; with A = D'⁻ᵀDᵀ it is D⁻¹ (m + m' AᵀA) D⁻ᵀ
    let between = plane::product(&plane::inverse(&b.root).transpose(), &a.root.transpose());
    let gram = plane::product(&between.transpose(), &between) * t.rate
        + Matrix2::from_diagonal_element(s.rate);
    let inverse_root = plane::inverse(&plane::symmetric_root(&gram));
    let root = plane::product(&inverse_root, &a.root);
    Autocorrelation::of_family(&root, [term(1.0)])
}
