//! Reliefs of surfaces as cases describe them.

use mueller16::{
    Approximation, Autocorrelation, AutocorrelationError, ExponentialHeights, Flat,
    GaussianHeights, KCorrelatedHeights, KCorrelation, Method, Relief, Tolerance,
};
use nalgebra::{Matrix2, Vector2};

use super::entry::Entry;
use super::fields::number;
use super::grating;
use super::schema::CaseError;

const KINDS: &str = "'none', 'gaussian', 'exponential', 'k_correlation' or 'grating'";
pub(super) const RELIEF: &str = "a relief: an object with 'kind'";
const LENGTH: &str = "a length in metres, or one along x and one along y";

/// A relief of any kind.
pub(super) struct AnyRelief(Box<dyn Relief>);

impl Relief for AnyRelief {
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        self.0.autocorrelation(phi_z, tolerance)
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        self.0.slope_covariance()
    }
}

/// The relief of an object with `kind`; no order of a grating beyond the tangential wave vector `reach`, rad/m.
pub(super) fn relief(spec: &Entry<'_>, reach: f64) -> Result<AnyRelief, CaseError> {
    let kind = spec.get("kind", KINDS)?;
    let refused = |e| spec.refuse(e);
    let deviation = || number(spec, "sigma");
    let made: Box<dyn Relief> = match kind.word()? {
        "none" => Box::new(Flat),
        "gaussian" => {
            let root = lengths(spec)? * std::f64::consts::FRAC_1_SQRT_2;
            Box::new(GaussianHeights::new(deviation()?, &root).map_err(refused)?)
        }
        "exponential" => {
            let heights = ExponentialHeights::new(deviation()?, &lengths(spec)?);
            Box::new(heights.map_err(refused)?)
        }
        "k_correlation" => {
            let heights = KCorrelatedHeights::new(deviation()?, k_correlation(spec)?);
            Box::new(heights.map_err(refused)?)
        }
        "grating" => {
            let grating = grating::described(spec)?.within_reach(reach);
            Box::new(grating.map_err(|e| spec.refuse(e))?)
        }
        other => return Err(kind.refuse(format!("found '{other}', expected {KINDS}"))),
    };
    Ok(AnyRelief(made))
}

/// The K-correlation of `l`, `exponent` and `inner`.
pub(super) fn k_correlation(spec: &Entry<'_>) -> Result<KCorrelation, CaseError> {
    let (root, exponent) = (lengths(spec)?, number(spec, "exponent")?);
    match spec.find("inner")? {
        Some(inner) => KCorrelation::with_inner_scale(&root, exponent, inner.number()?),
        None => KCorrelation::new(&root, exponent),
    }
    .map_err(|e| spec.refuse(e))
}

/// `l`: a length, or two along x and y; on a diagonal.
pub(super) fn lengths(spec: &Entry<'_>) -> Result<Matrix2<f64>, CaseError> {
    let l = spec.get("l", LENGTH)?;
    if l.is_list() {
        let [x, y] = l.array_of(Entry::number)?;
        return Ok(Matrix2::from_diagonal(&Vector2::new(x, y)));
    }
    l.number().map(Matrix2::from_diagonal_element)
}

/// `tolerance`, or what rounding leaves.
pub(super) fn tolerance(inputs: &Entry<'_>) -> Result<Tolerance, CaseError> {
    let Some(entry) = inputs.find("tolerance")? else {
        return Ok(Tolerance::ROUNDING);
    };
    Tolerance::relative(entry.number()?).map_err(|e| entry.refuse(e))
}

/// The word for a method in results.
pub(super) fn name(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::PoissonSum => "poisson_sum",
        Method::GaussCharlier => "gauss_charlier",
        Method::GeometricOptics => "geometric_optics",
        Method::WidthQuadrature => "width_quadrature",
        Method::WidthFit => "width_fit",
        Method::Orders => "orders",
    }
}
