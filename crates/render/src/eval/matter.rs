//! Operations of the crate `mueller16` on autocorrelations: lobes, and what they make of one incident mode.

use mueller16::{
    Autocorrelation, AutocorrelationError, GaussianFamily, GaussianTerm, KCorrelation, Relief,
    Tolerance,
};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{HermiteSeries, MAX_ORDER, ShapeMatrix, mode_count, mode_index};

use super::entry::{Entry, MATRIX, VECTOR};
use super::fields::number;
use super::functions::{order, shape_with_root};
use super::relief;
use super::result::Item;
use super::schema::CaseError;

pub(super) const AUTOCORRELATION: &str = "an autocorrelation: an object with 'kind'";
const KINDS: &str = "'constant', 'gaussian', 'gaussian_sum', 'grating', 'orders', 'rough', 'exponential', 'k_correlation' \
                     or 'relief'";
const NUMBERS: &str = "a list of numbers";

/// Roughness above which the Poisson sum is not worth its length.
const LARGEST_G: f64 = 1e6;

/// Powers of the height correlation of less weight are no part of `rough`.
const LEAST_WEIGHT: f64 = 1e-32;

pub(super) fn scatter(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let r = inputs.get("R", AUTOCORRELATION)?;
    let (amplitude, matter) = autocorrelation(&r)?;
    let (n, m) = (order(inputs, "n")?, order(inputs, "m")?);
    if n + m > MAX_ORDER {
        return Err(inputs.refuse(format!("n + m = {}, expected at most {MAX_ORDER}", n + m)));
    }
    let (shape, mode) = one_mode(inputs, n, m)?;
    let map = inputs.get("B", MATRIX)?.matrix()?;
    let phi = inputs.get("phi", VECTOR)?.vector()?;
    let lobe = matter
        .lobe_for(&shape, &map, &mode, &phi)
        .map_err(|e| r.refuse(e))?;
    Ok(Item::value(amplitude * quarter_turns(n + m).conj() * lobe))
}

/// The function of the coefficient `i^(n+m)` over the mode (n, m) of the family asked for: it is Hermitian, so that its
/// lobe is real.
fn one_mode(
    inputs: &Entry<'_>,
    n: usize,
    m: usize,
) -> Result<(ShapeMatrix, HermiteSeries), CaseError> {
    let family = inputs.get("family", "'white' or 'cov'")?;
    let coefficient = quarter_turns(n + m);
    match family.word()? {
        "white" => {
            let shape = shape_with_root(inputs, "shape")?;
            let series = HermiteSeries::from_modes(&[(n, m, coefficient)]);
            Ok((shape, series.map_err(|e| inputs.refuse(e))?))
        }
        "cov" => {
            let theta = inputs.get("shape", MATRIX)?;
            let shape = ShapeMatrix::from_theta(&theta.matrix()?).map_err(|e| theta.refuse(e))?;
            let mut coefficients = vec![Complex64::ZERO; mode_count(n + m)];
            coefficients[mode_index(n, m)] = coefficient;
            let series = HermiteSeries::from_covariant(&shape, &coefficients);
            Ok((shape, series.map_err(|e| theta.refuse(e))?))
        }
        other => Err(family.refuse(format!("found '{other}', expected 'white' or 'cov'"))),
    }
}

/// `iⁿ`
fn quarter_turns(n: usize) -> Complex64 {
    Complex64::I.powu((n % 4) as u32)
}

pub(super) fn lobe(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let (amplitude, matter) = autocorrelation(&inputs.get("R", AUTOCORRELATION)?)?;
    let phi = inputs.get("phi", VECTOR)?.vector()?;
    let times = |x: f64| -> Item {
        if amplitude.im == 0.0 {
            (amplitude.re * x).into()
        } else {
            (amplitude * x).into()
        }
    };
    Ok(Item::Group(vec![
        ("value", times(matter.spectrum(&phi))),
        ("coherent_weight", times(matter.delta_weight())),
    ]))
}

/// The amplitude of an autocorrelation and the function of amplitude 1 behind it.
///
/// A complex amplitude belongs to no matter; the arithmetic does not mind.
pub(super) fn autocorrelation(spec: &Entry<'_>) -> Result<(Complex64, Autocorrelation), CaseError> {
    let kind = spec.get("kind", KINDS)?;
    let made = match kind.word()? {
        "constant" => Autocorrelation::constant(1.0),
        "gaussian" => gaussian(&spec.get("S", MATRIX)?)?,
        "gaussian_sum" => gaussian_sum(spec)?,
        "grating" => grating(spec)?,
        "orders" => orders(spec)?,
        "rough" => rough(spec)?,
        "exponential" => k_correlated(spec, KCorrelation::exponential(&relief::lengths(spec)?))?,
        "k_correlation" => k_correlated(spec, Ok(relief::k_correlation(spec)?))?,
        "relief" => of_relief(spec)?,
        other => return Err(kind.refuse(format!("found '{other}', expected {KINDS}"))),
    };
    let amplitude = match spec.find("amp")? {
        Some(amplitude) => amplitude.complex_or_parts()?,
        None => Complex64::ONE,
    };
    Ok((amplitude, made))
}

fn gaussian(covariance: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    Autocorrelation::gaussian(&covariance.matrix()?).map_err(|e| covariance.refuse(e))
}

fn gaussian_sum(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    let weights = spec.get("weights", NUMBERS)?.list()?;
    let covariances = spec.get("S_list", "a list of matrices")?;
    let list = covariances.list()?;
    if list.len() != weights.len() {
        return Err(covariances.refuse(format!(
            "found {} matrices for {} weights, expected one for each",
            list.len(),
            weights.len()
        )));
    }
    let mut sum = Autocorrelation::default();
    for (weight, covariance) in weights.iter().zip(&list) {
        sum = sum.plus(&gaussian(covariance)?.scaled(weight.number()?));
    }
    Ok(sum)
}

/// `e^(−xᵀS⁻¹x/2) Σ orders_q cos(q G·x)`
fn grating(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    let g = spec.get("G", VECTOR)?.vector()?;
    let mut terms = vec![];
    for (q, weight) in spec.get("orders", NUMBERS)?.list()?.iter().enumerate() {
        let weight = weight.number()?;
        if q == 0 {
            terms.push((weight, Vector2::zeros()));
        } else {
            terms.extend([g, -g].map(|g| (0.5 * weight, g * q as f64)));
        }
    }
    through_aperture(spec, terms)
}

/// `e^(−xᵀS⁻¹x/2) Σ p e^(iq G·x)`
fn orders(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    let g = spec.get("G", VECTOR)?.vector()?;
    let list = spec.get("orders", "a list of [order, weight]")?.list()?;
    let order = |entry: &Entry<'_>| {
        let [q, p] = entry.array_of(Entry::number)?;
        Ok((p, g * q))
    };
    through_aperture(spec, list.iter().map(order).collect::<Result<_, _>>()?)
}

/// Weights at tangential wave vectors, times `e^(−xᵀS⁻¹x/2)`.
fn through_aperture(
    spec: &Entry<'_>,
    orders: Vec<(f64, Vector2<f64>)>,
) -> Result<Autocorrelation, CaseError> {
    let covariance = spec.get("S", MATRIX)?;
    let shape =
        ShapeMatrix::from_covariance(&covariance.matrix()?).map_err(|e| covariance.refuse(e))?;
    let terms = orders.into_iter().map(|(weight, shift)| GaussianTerm {
        shift,
        ..GaussianTerm::centred(weight, 1.0)
    });
    Autocorrelation::of_family(shape.root(), terms).map_err(|e| spec.refuse(e))
}

/// `R` itself K-correlated.
fn k_correlated(
    spec: &Entry<'_>,
    correlation: Result<KCorrelation, AutocorrelationError>,
) -> Result<Autocorrelation, CaseError> {
    let tolerance = relief::tolerance(spec)?;
    let made = correlation.and_then(|correlation| correlation.autocorrelation(tolerance));
    made.map(|(r, _)| r).map_err(|e| spec.refuse(e))
}

/// What a relief does to light of the vertical wave vector `phi_z`.
fn of_relief(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    let relief = spec.get("relief", relief::RELIEF)?;
    let (made, phi_z) = (relief::relief(&relief, f64::MAX)?, number(spec, "phi_z")?);
    let found = made.autocorrelation(phi_z, relief::tolerance(spec)?);
    found.map(|(r, _)| r).map_err(|e| relief.refuse(e))
}

/// `e^(−g(1 − e^(−|x|²/l²)))`, the constant part with it.
fn rough(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    let (g, length) = (
        spec.get("g", "a number, 0 or more")?,
        spec.get("l", "a length in metres")?,
    );
    let number = g.number()?;
    if !(0.0..=LARGEST_G).contains(&number) {
        return Err(g.refuse(format!(
            "found {number}, expected a number between 0 and {LARGEST_G:e}"
        )));
    }
    let root = Matrix2::from_diagonal_element(length.number()? * std::f64::consts::FRAC_1_SQRT_2);
    let (r, _) = Autocorrelation::of_gaussian_phase(number, &root, Tolerance::ROUNDING)
        .map_err(|e| length.refuse(e))?;
    let terms = r.families().iter().flat_map(GaussianFamily::terms);
    let terms = terms.filter(|term| term.weight > LEAST_WEIGHT).copied();
    Autocorrelation::of_family(&root, terms).map_err(|e| length.refuse(e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::schema::Case;
    use serde_json::{Value, json};

    fn result(inputs: Value) -> Value {
        let case = Case {
            id: String::new(),
            op: String::new(),
            inputs,
        };
        lobe(&Entry::of(&case)).unwrap().to_json().unwrap()
    }

    fn real(value: &Value) -> f64 {
        value.as_str().unwrap().parse().unwrap()
    }

    #[test]
    fn orders_keep_their_side() {
        let at = |x: f64| {
            let r = json!({"kind": "orders", "S": [[1e-10, 0], [0, 1e-10]], "G": [1e6, 0], "orders": [[1, 0.7], [-1, 0.2]]});
            real(&result(json!({"R": r, "phi": [x, 0]}))["value"])
        };
        let area = std::f64::consts::TAU * 1e-10;
        assert!((at(1e6) / (0.7 * area) - 1.0).abs() < 1e-14);
        assert!((at(-1e6) / (0.2 * area) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_lobe_of_an_exponential_is_known() {
        // 2π l² (1 + q² l²)^(−3/2), also as K-correlation of exponent 3/2
        let expected = std::f64::consts::TAU * 4e-12 * 2_f64.powf(-1.5);
        for r in [
            json!({"kind": "exponential", "l": 2e-6, "tolerance": 1e-9}),
            json!({"kind": "k_correlation", "exponent": 1.5, "l": 2e-6, "tolerance": 1e-9}),
        ] {
            let found = result(json!({"R": r, "phi": [0, 5e5]}));
            assert!((real(&found["value"]) / expected - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn rough_is_what_gaussian_heights_do() {
        let rough = json!({"kind": "rough", "g": 4, "l": 3e-6});
        let heights = json!({"kind": "relief", "relief": {"kind": "gaussian", "sigma": 1e-7, "l": 3e-6}, "phi_z": 2e7});
        let [rough, heights] = [rough, heights].map(|r| {
            let found = result(json!({"R": r, "phi": [1e6, 0]}));
            [real(&found["value"]), real(&found["coherent_weight"])]
        });
        assert!((rough[0] / heights[0] - 1.0).abs() < 1e-13);
        assert!((rough[1] / (-4_f64).exp() - 1.0).abs() < 1e-14);
        assert!((rough[1] / heights[1] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_blaze_answers_with_all_orders_but_the_furthest() {
        // of |t_q|² = sin²(ψ/2)/(πq + ψ/2)² those beyond 10,000 to each side are left out
        let depth = 3e-7;
        let blaze = json!({"kind": "grating", "pitch": 2e-6,
            "profile": {"kind": "blazed", "depth": depth, "sense": "rising"}});
        let relief = json!({"kind": "relief", "relief": blaze, "phi_z": 2e7});
        let found = result(json!({"R": relief, "phi": [1e5, 0]}));
        let psi: f64 = 2e7 * depth;
        let beyond = 2.0 * (psi / 2.0).sin().powi(2) / (std::f64::consts::PI.powi(2) * 10_000.5);
        let missing = 1.0 - real(&found["coherent_weight"]);
        // the sum beyond N as an integral from N + 1/2: relative error 1/(12 N²), and rounding of 20,001 numbers
        assert!(
            (missing - beyond).abs() < 1e-7 * beyond + 1e-12,
            "{missing:e} {beyond:e}"
        );
        assert_eq!(real(&found["value"]), 0.0);
    }

    #[test]
    fn powers_of_rough_below_the_least_weight_are_left_out() {
        // e^(−80) = 1.8e-35
        let found =
            |g: f64| result(json!({"R": {"kind": "rough", "g": g, "l": 3e-6}, "phi": [0, 0]}));
        assert_eq!(real(&found(80.0)["coherent_weight"]), 0.0);
        let kept = real(&found(70.0)["coherent_weight"]);
        assert!((kept / 3.975_449_735_908_647e-31 - 1.0).abs() < 1e-13);
    }
}
