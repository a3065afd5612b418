//! Operations of the crate `mueller16` on autocorrelations: lobes, and what they make of one incident mode.

use mueller16::{Autocorrelation, GaussianTerm};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{HermiteSeries, MAX_ORDER, ShapeMatrix, mode_count, mode_index};

use super::entry::{Entry, MATRIX, VECTOR};
use super::functions::{order, shape_with_root};
use super::result::Item;
use super::schema::CaseError;

pub(super) const AUTOCORRELATION: &str = "an autocorrelation: an object with 'kind'";
const KINDS: &str = "'constant', 'gaussian', 'gaussian_sum', 'grating' or 'rough'";
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
        "rough" => rough(spec)?,
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
    let covariance = spec.get("S", MATRIX)?;
    let shape =
        ShapeMatrix::from_covariance(&covariance.matrix()?).map_err(|e| covariance.refuse(e))?;
    let g = spec.get("G", VECTOR)?.vector()?;
    let mut terms = vec![];
    for (q, weight) in spec.get("orders", NUMBERS)?.list()?.iter().enumerate() {
        let weight = weight.number()?;
        let term = |weight, shift: Vector2<f64>| GaussianTerm {
            shift,
            ..GaussianTerm::centred(weight, 1.0)
        };
        if q == 0 {
            terms.push(term(weight, Vector2::zeros()));
        } else {
            terms.extend([g, -g].map(|g| term(0.5 * weight, g * q as f64)));
        }
    }
    Autocorrelation::of_family(shape.root(), terms).map_err(|e| spec.refuse(e))
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
    let terms = poisson(number)
        .into_iter()
        .map(|(m, weight)| GaussianTerm::centred(weight, m as f64));
    Autocorrelation::of_family(&root, terms).map_err(|e| length.refuse(e))
}

/// The probabilities `e^(−g) g^m/m!` above the least weight, with their m.
///
/// They are ratios to the most likely one, over the sum of all, which is 1: no logarithm of a factorial, whose rounding an
/// exponential would multiply. Relative error of a weight: ε for each step from the most likely one, at most `12 √g + 30`
/// of them.
fn poisson(g: f64) -> Vec<(u32, f64)> {
    // what is below this against the most likely weight is below the least weight by itself
    let kept = |ratio: &f64| *ratio > LEAST_WEIGHT;
    let mode = g.floor() as u32;
    let below = (1..=mode).rev().scan(1.0, |ratio, m| {
        *ratio *= f64::from(m) / g;
        kept(ratio).then_some((m - 1, *ratio))
    });
    let above = (mode + 1..).scan(1.0, |ratio, m| {
        *ratio *= g / f64::from(m);
        kept(ratio).then_some((m, *ratio))
    });
    let mut ratios: Vec<_> = below.chain([(mode, 1.0)]).chain(above).collect();
    let total: f64 = ratios.iter().map(|(_, ratio)| ratio).sum();
    for (_, ratio) in &mut ratios {
        *ratio /= total;
    }
    ratios.retain(|(_, weight)| *weight > LEAST_WEIGHT);
    ratios
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_roughness_are_those_of_poisson() {
        // e^(−g) g^m/m! with 40 digits
        for (g, m, expected) in [
            (0.0, 0, 1.0),
            (0.5, 0, 0.606_530_659_712_633_4),
            (4.0, 9, 0.013_231_191_691_050_3),
            (70.0, 0, 3.975_449_735_908_647e-31),
            (400.0, 400, 0.019_942_958_805_033_05),
            (5000.0, 4800, 9.987_733_294_132_51e-5),
        ] {
            let weights = poisson(g);
            let found = weights.iter().find(|(power, _)| *power == m).unwrap().1;
            let bound = (12.0 * g.sqrt() + 30.0) * f64::EPSILON;
            assert!(
                (found / expected - 1.0).abs() < bound,
                "{g} {m}: {found} {expected}"
            );
            let mean: f64 = weights.iter().map(|(m, w)| f64::from(*m) * w).sum();
            assert!((mean - g).abs() <= bound * g, "{mean} {g}");
        }
        // e^(−80) is 1.8e-35
        assert!(poisson(80.0).iter().all(|(m, _)| *m > 0));
    }
}
