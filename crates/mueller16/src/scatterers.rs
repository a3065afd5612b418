//! Lemma 4.3 for matter that is not locally stationary: a finite set of point scatterers.
//!
//! Scatterers of Jones matrix `T_a` and strength `α_a` (m²) at places `x_a`, which may lie off the surface's plane:
//!
//! ```text
//! Σ^(j→l)(x₁, x₂) = Σ_ab α_a α_b M_lj(T_a, T_b)* δ(x₁ − x_a) δ(x₂ − x_b)
//! C_l(w)  = Σ_ab K^l_ab e^(−i w·E(x_a + x_b)/2)                           E rows of the outgoing frame, w = (n_o k₀/r) ξ
//! K^l_ab  = (n_o/λ₀)² e^(−iφ·(x_a − x_b)) α_a α_b Σ_j M_lj(T_a, T_b)* C'_j(x_a − x_b)
//! c^(l)_ab = 2π (−i)^(a+b) Σ_pairs K^l φ_ab(E(x_a + x_b)/2; W^(−T))                                   Eq. (S2.9)
//! ```
//!
//! `K_ba = K_ab*`: a pair and its reverse have one midpoint, so that only the real part of K remains, and every real
//! coefficient is a real sum. A point radiates into all directions alike: the far field does not fall off with w, its
//! series does not converge in the mean, and what a truncated one keeps are its projections on the modes.

use csdm::{GeneralizedMueller, JonesMatrix};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{Components, Frame, GeneralizedStokes, HermiteSeries, LightError, ShapeMatrix};
use thiserror::Error;

use crate::geometry::Geometry;
use crate::incident;
use crate::theorem::{Energy, InteractionError};

/// Largest coordinate of a scatterer, m.
const FARTHEST: f64 = 1e30;

/// Why points are no set of scatterers.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ScattererError {
    /// There is none.
    #[error("scatterers: none, expected at least one")]
    Nothing,
    /// A number of a scatterer is out of its domain.
    #[error("scatterers: the {what} of scatterer {index} is {value}, expected {expected}")]
    Number {
        /// Place in the list, from 0.
        index: usize,
        /// `"place"`, `"strength"` or `"Jones matrix"`.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What should be there.
        expected: &'static str,
    },
}

/// One point that scatters: the limit of a small opening or particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointScatterer {
    /// Where it is, m: along the surface's two tangents and its normal, from the phase centre of the scattered light.
    pub place: Vector3<f64>,
    /// Strength, m²: the area of a small opening; for a particle of scattering length b (m), `λ b`. Of either sign.
    pub strength: f64,
    /// What it does to the field, in `exp(+iωt)`; a delay δ is a factor `e^(−iδ)`.
    pub jones: JonesMatrix,
}

/// Point scatterers at fixed places: deterministic matter, with interference between every two of them.
///
/// ```
/// use csdm::JonesMatrix;
/// use mueller16::{Energy, Geometry, PointScatterer, PointScatterers};
/// use nalgebra::{Matrix2, Vector3};
/// use stokes::*;
/// // two pinholes 0.1 mm apart, lit along their normal by a small star; observed where their paths differ by λ/2
/// let green = Wavelength::from_metres(550e-9)?;
/// let light = GeneralizedStokes::new(
///     Components::Shared { modes: HermiteSeries::fundamental(1.0), stokes: StokesVector::UNPOLARIZED },
///     ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3))?,
///     Frame::with_x_along(Vector3::z(), Vector3::x())?,
///     green,
///     1e6,
/// )?;
/// let hole = |x| PointScatterer { place: Vector3::new(x, 0.0, 0.0), strength: 1e-12, jones: JonesMatrix::identity() };
/// let holes = PointScatterers::new(vec![hole(-5e-5), hole(5e-5)])?;
/// let sin = 0.5 * 550e-9 / 1e-4;
/// let to_observer = Vector3::new(sin, 0.0, (1.0f64 - sin * sin).sqrt());
/// let seen = |to_observer| {
///     let geometry = Geometry::on_plane(-Vector3::z(), to_observer, green)?;
///     let frame = Frame::with_x_along(to_observer, Vector3::y())?;
///     let field = holes.scatter(&geometry, &light, Energy::Printed, &frame)?;
///     Ok::<f64, Box<dyn std::error::Error>>(field.stokes().s0())
/// };
/// assert!(seen(to_observer)? < 1e-6 * seen(Vector3::z())?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PointScatterers(Vec<PointScatterer>);

impl PointScatterers {
    /// The set of these scatterers.
    ///
    /// # Errors
    ///
    /// When there is none, or a place, a strength or an element of a Jones matrix is not a finite number (of at most
    /// 1e30).
    pub fn new(scatterers: Vec<PointScatterer>) -> Result<Self, ScattererError> {
        if scatterers.is_empty() {
            return Err(ScattererError::Nothing);
        }
        for (index, scatterer) in scatterers.iter().enumerate() {
            let jones = scatterer.jones.to_matrix();
            let lengths = scatterer.place.iter().map(|x| ("place", *x));
            let elements = jones.iter().flat_map(|z| [z.re, z.im]);
            let numbers = lengths
                .chain([("strength", scatterer.strength)])
                .chain(elements.map(|value| ("Jones matrix", value)));
            for (what, value) in numbers {
                if value.is_nan() || value.abs() > FARTHEST {
                    let expected = "a number of at most 1e30";
                    return Err(ScattererError::Number {
                        index,
                        what,
                        value,
                        expected,
                    });
                }
            }
        }
        Ok(Self(scatterers))
    }

    /// The set of scatterers whose numbers have been checked.
    pub(crate) fn from_checked(scatterers: Vec<PointScatterer>) -> Self {
        Self(scatterers)
    }

    /// The scatterers.
    #[must_use]
    pub fn scatterers(&self) -> &[PointScatterer] {
        &self.0
    }

    /// The far field of these scatterers in `light`, toward the geometry's observer, exactly; outgoing light is written
    /// in the frame `outgoing`.
    ///
    /// The incident components may share their modes or not, and be of any order. Cost: for each pair one evaluation of
    /// the incident series and one generalized Mueller matrix.
    ///
    /// # Errors
    ///
    /// When the light comes from elsewhere than the geometry says or has another wavelength, the frame is not that of
    /// the ray to the observer, or a direction is at grazing incidence (never for [`Energy::Printed`]).
    pub fn scatter(
        &self,
        geometry: &Geometry,
        light: &GeneralizedStokes,
        energy: Energy,
        outgoing: &Frame,
    ) -> Result<PairFarField, InteractionError> {
        incident::root_of(light, geometry)?;
        let angle = (outgoing.z() - geometry.to_observer()).norm();
        if angle.is_nan() || angle > 1e-6 {
            return Err(LightError::OtherRay { angle }.into());
        }
        let wave = geometry.n_outgoing() / geometry.wavelength().metres();
        let scale = wave * wave * energy.factor(geometry)?;
        let [t1, t2] = geometry.tangents();
        let place = |at: &Vector3<f64>| t1 * at.x + t2 * at.y + geometry.normal() * at.z;
        let mut pairs = Vec::with_capacity(self.0.len() * (self.0.len() + 1) / 2);
        for (index, first) in self.0.iter().enumerate() {
            for (offset, second) in self.0[index..].iter().enumerate() {
                let (x1, x2) = (place(&first.place), place(&second.place));
                let separation = x1 - x2;
                let middle = 0.5 * (x1 + x2);
                let both = if offset == 0 { 1.0 } else { 2.0 };
                let turn = Complex64::cis(-geometry.momentum_transfer().dot(&separation));
                let factor = turn * (both * scale * first.strength * second.strength);
                let sixteen = GeneralizedMueller::of_jones(&first.jones, &second.jones);
                let scattering = sixteen.scattering();
                let incident = incident_at(light, geometry, &separation);
                pairs.push(Pair {
                    middle: Vector2::new(outgoing.x().dot(&middle), outgoing.y().dot(&middle)),
                    weights: std::array::from_fn(|l| {
                        let sum: Complex64 = (0..4).map(|j| scattering[(l, j)] * incident[j]).sum();
                        (factor * sum).re
                    }),
                });
            }
        }
        Ok(PairFarField { pairs })
    }
}

/// `C'_j` of two points of the matter, without the phase `e^(−ik ŝ·x)` of the ray.
fn incident_at(
    light: &GeneralizedStokes,
    geometry: &Geometry,
    separation: &Vector3<f64>,
) -> [Complex64; 4] {
    let (frame, s) = (light.frame(), light.distance());
    let k = geometry.n_incident() * geometry.wavelength().wavenumber().radians_per_metre();
    let w = Vector2::new(frame.x().dot(separation), frame.y().dot(separation)) * (k / s);
    let value = |series: &HermiteSeries| series.value(light.shape(), &w) / (s * s);
    match light.components() {
        Components::Shared { modes, stokes } => {
            let common = value(modes);
            stokes.to_array().map(|amplitude| common * amplitude)
        }
        Components::Separate(series) => {
            std::array::from_fn(|j| series[j].as_ref().map_or(Complex64::ZERO, value))
        }
    }
}

/// The midpoint of two scatterers in the outgoing frame, and what both orders of the pair add to the four parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    middle: Vector2<f64>,
    weights: [f64; 4],
}

/// The exact far field of pairs of points in one direction: `r² C_l(w) = Σ weight_l e^(−i w·middle)`.
#[derive(Clone, Debug, PartialEq)]
pub struct PairFarField {
    pairs: Vec<Pair>,
}

impl PairFarField {
    /// The four parameters times r², at the far-field argument `w = (n_o k₀/r) ξ` in 1/m.
    ///
    /// Source: Eq. (S2.3).
    #[must_use]
    pub fn at(&self, w: &Vector2<f64>) -> [Complex64; 4] {
        let mut sums = [Complex64::ZERO; 4];
        for pair in &self.pairs {
            let turn = Complex64::cis(-w.dot(&pair.middle));
            for (sum, weight) in sums.iter_mut().zip(pair.weights) {
                *sum += turn * weight;
            }
        }
        sums
    }

    /// The Stokes parameters times r²: the radiant intensity toward the observer, in the unit of the incident light
    /// times m².
    #[must_use]
    pub fn stokes(&self) -> stokes::StokesVector {
        let sum = |l: usize| self.pairs.iter().map(|pair| pair.weights[l]).sum();
        std::array::from_fn(sum).into()
    }

    /// The shape matrix of Lemma 4.4: `Θ⁻¹ = −∂²/∂w² ln|C_0|` at w = 0, the covariance of the midpoints weighted by what
    /// each pair adds to the intensity.
    ///
    /// # Errors
    ///
    /// When it is not positive definite: the midpoints lie on a line, or pairs of negative weight have the larger
    /// spread. Lemma 4.3 holds for every other shape as well.
    pub fn shape(&self) -> Result<ShapeMatrix, stokes::ShapeError> {
        let total = self.stokes().s0();
        let mean = |f: &dyn Fn(&Vector2<f64>) -> Matrix2<f64>| -> Matrix2<f64> {
            let sum: Matrix2<f64> = self
                .pairs
                .iter()
                .map(|pair| f(&pair.middle) * pair.weights[0])
                .sum();
            sum / total
        };
        let centre = mean(&|m| Matrix2::new(m.x, 0.0, m.y, 0.0))
            .column(0)
            .into_owned();
        let covariance = mean(&|m| {
            let d = m - centre;
            Matrix2::new(d.x * d.x, d.x * d.y, d.x * d.y, d.y * d.y)
        });
        ShapeMatrix::from_covariance(&covariance)
    }

    /// The outgoing coefficients up to total order `order` over `shape`, one series for each parameter that is there.
    ///
    /// Error of a few `order·ε` of the sum of the moduli of the weights.
    ///
    /// Source: Eq. (S2.9), with the factors of two dimensions.
    ///
    /// # Errors
    ///
    /// When `order` exceeds [`stokes::MAX_ORDER`] or a coefficient is not finite.
    pub fn modes(&self, shape: &ShapeMatrix, order: usize) -> Result<Components, LightError> {
        if order > stokes::MAX_ORDER {
            return Err(stokes::SeriesError::Order { order }.into());
        }
        let dual = shape.fourier_dual();
        let count = stokes::mode_count(order);
        let mut modes = vec![0.0; count];
        let mut sums = vec![[0.0; 4]; count];
        for pair in &self.pairs {
            let y = dual.whiten(&pair.middle);
            stokes::all_modes(order, [-y.x, -y.y], &mut modes);
            for (sum, mode) in sums.iter_mut().zip(&modes) {
                for (sum, weight) in sum.iter_mut().zip(pair.weights) {
                    *sum += weight * mode;
                }
            }
        }
        // (−i)^(a+b) twice is the parity of the mode, which stands in the sign of its argument
        let factor = std::f64::consts::TAU * dual.root_determinant().sqrt();
        let series = |l: usize| {
            let real: Vec<f64> = sums.iter().map(|sum| factor * sum[l]).collect();
            let present = self.pairs.iter().any(|pair| pair.weights[l] != 0.0);
            present
                .then(|| HermiteSeries::from_real_coefficients(&real))
                .transpose()
        };
        Ok(Components::Separate([
            series(0)?,
            series(1)?,
            series(2)?,
            series(3)?,
        ]))
    }
}
