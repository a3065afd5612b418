//! Operations of the crate `stokes` on light: intensity profiles, series of one component, observables.

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Envelope, Frame, GaussianPeak, GeneralizedStokes, HermiteSeries, MAX_ORDER,
    ShapeMatrix, StokesVector, Wavelength, mode_count, mode_index,
};

use super::entry::{Entry, MATRIX, VECTOR};
use super::functions::{order, shape_with_root};
use super::result::Item;
use super::schema::CaseError;

pub(super) fn projection(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    /// Coefficients over the covariant family are asked for up to this order.
    const COVARIANT: usize = 6;
    let envelope = envelope(&inputs.get("I", ENVELOPE)?)?;
    let p = inputs.get("P", MATRIX)?;
    let shape = match inputs.find("W")? {
        Some(_) => shape_with_root(inputs, "W")?,
        None => envelope.shape(&p.matrix()?).map_err(|e| p.refuse(e))?,
    };
    let modes = envelope
        .project(&p.matrix()?, &shape, order(inputs, "N")?)
        .map_err(|e| p.refuse(e))?;
    let coefficients: Vec<_> = stokes::modes(modes.order())
        .map(|(a, b)| modes.coefficient(a, b))
        .collect();
    let white = by_order(modes.order(), |place| coefficients[place]);
    let low = modes.truncated(COVARIANT).0;
    let covariant = low.to_covariant(&shape);
    Ok(Item::Group(vec![
        ("W", (*shape.root()).into()),
        ("Theta", shape.theta().into()),
        ("white", white),
        ("cov", by_order(low.order(), |place| covariant[place])),
        ("f0", envelope.area().into()),
    ]))
}

pub(super) fn shape(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let envelope = envelope(&inputs.get("I", ENVELOPE)?)?;
    let p = inputs.get("P", MATRIX)?;
    let shape = envelope.shape(&p.matrix()?).map_err(|e| p.refuse(e))?;
    Ok(Item::Group(vec![
        ("Theta", shape.theta().into()),
        ("minus_hessian", shape.covariance().into()),
    ]))
}

/// The coefficients of a series up to `order` in rows, one for each total order.
pub(super) fn by_order(order: usize, coefficient: impl Fn(usize) -> Complex64) -> Item {
    let row = |n| (mode_index(n, 0)..mode_count(n)).map(&coefficient);
    let rows = (0..=order).map(|n| row(n).collect::<Vec<_>>());
    rows.collect::<Vec<_>>().into()
}

/// An intensity profile of peak 1, or a sum of such.
pub(super) fn envelope(spec: &Entry<'_>) -> Result<Envelope, CaseError> {
    let number = |key| spec.get(key, "a length in metres")?.number();
    let kind = spec.get("kind", KINDS)?;
    let made = match kind.word()? {
        "gaussian" => Envelope::gaussian(&spec.get("S", MATRIX)?.matrix()?),
        "rect" => Envelope::rectangle(number("hx")?, number("hy")?),
        "disk" => Envelope::disk(number("radius")?),
        "gaussian_mixture" => Envelope::mixture(&peaks(spec)?),
        other => return Err(kind.refuse(format!("found '{other}', expected {KINDS}"))),
    };
    made.map_err(|e| spec.refuse(e))
}

fn peaks(mixture: &Entry<'_>) -> Result<Vec<GaussianPeak>, CaseError> {
    let weights = mixture.get("weights", "a list of numbers")?.list()?;
    let covariances = mixture.get("S_list", "a list of matrices")?;
    let list = covariances.list()?;
    if list.len() != weights.len() {
        return Err(covariances.refuse(format!(
            "found {} matrices for {} weights, expected one for each",
            list.len(),
            weights.len()
        )));
    }
    let peak = |(weight, covariance): (&Entry<'_>, &Entry<'_>)| {
        Ok(GaussianPeak {
            peak: weight.number()?,
            centre: Vector2::zeros(),
            covariance: covariance.matrix()?,
        })
    };
    weights.iter().zip(&list).map(peak).collect()
}

pub(super) fn wvd(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let light = one_component(inputs)?;
    let zeta = in_axes_of_theta(inputs, "zeta")?;
    Ok(Item::Group(vec![
        ("W", joined(&light.wigner(&zeta)).into()),
        ("intensity", joined(&light.stokes().stokes).into()),
    ]))
}

pub(super) fn csd(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let light = one_component(inputs)?;
    let xi = in_axes_of_theta(inputs, "xi")?;
    let [hermitian, rest, ..] = light.at_separation(&xi);
    Ok(Item::Group(vec![(
        "C",
        (hermitian + Complex64::I * rest).into(),
    )]))
}

/// Light whose first component is the Hermitian part `f` of the function with the covariant coefficients `modes`, whose second
/// is `g` in the other part `i g`: the schema allows any complex coefficients, light does not.
fn one_component(inputs: &Entry<'_>) -> Result<GeneralizedStokes, CaseError> {
    let theta = inputs.get("Theta", MATRIX)?;
    let shape = ShapeMatrix::from_theta(&theta.matrix()?).map_err(|e| theta.refuse(e))?;
    let modes = inputs.get("modes", "a list of modes [n, m, c]")?;
    let [hermitian, rest] = both_parts(&modes)?.map(|coefficients| {
        HermiteSeries::from_covariant(&shape, &coefficients)
            .map(Some)
            .map_err(|e| modes.refuse(e))
    });
    let wavelength = inputs.get("lambda", "a wavelength in metres")?;
    let distance = inputs.get("r", "a distance in metres")?;
    let frame =
        Frame::with_x_along(Vector3::z(), Vector3::x()).expect("the axes are perpendicular");
    GeneralizedStokes::new(
        Components::Separate([hermitian?, rest?, None, None]),
        shape,
        frame,
        Wavelength::from_metres(wavelength.number()?).map_err(|e| wavelength.refuse(e))?,
        distance.number()?,
    )
    .map_err(|e| distance.refuse(e))
}

/// The coefficients of `f` and of `g` from the modes `[n, m, c]`, for all modes in order: real where n + m is even, imaginary
/// where it is odd.
fn both_parts(modes: &Entry<'_>) -> Result<[Vec<Complex64>; 2], CaseError> {
    let mut parts = [vec![Complex64::ZERO], vec![Complex64::ZERO]];
    for mode in modes.list()? {
        let [n, m, c] = mode.array()?;
        let (n, m, c) = (n.order()?, m.order()?, c.complex()?);
        if n + m > MAX_ORDER {
            return Err(mode.refuse(format!("order {}, expected at most {MAX_ORDER}", n + m)));
        }
        let split = if (n + m) % 2 == 0 {
            [c.re.into(), c.im.into()]
        } else {
            [Complex64::new(0.0, c.im), Complex64::new(0.0, -c.re)]
        };
        for (part, coefficient) in parts.iter_mut().zip(split) {
            part.resize(part.len().max(mode_count(n + m)), Complex64::ZERO);
            part[mode_index(n, m)] += coefficient;
        }
    }
    Ok(parts)
}

fn joined(parts: &StokesVector) -> Complex64 {
    Complex64::new(parts.s0(), parts.s1())
}

/// The vector under `key`, turned by `Q` into the axes in which Θ is written.
fn in_axes_of_theta(inputs: &Entry<'_>, key: &str) -> Result<Vector2<f64>, CaseError> {
    let q: Matrix2<f64> = inputs.get("Q", MATRIX)?.matrix()?;
    Ok(q * inputs.get(key, VECTOR)?.vector()?)
}

pub(super) fn observables(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let [s0, s1, s2, s3] = inputs
        .get("stokes", "a list of four numbers")?
        .array()?
        .map(|s| s.number());
    let light = StokesVector::new(s0?, s1?, s2?, s3?);
    let ellipse = light.ellipse();
    Ok(Item::Group(vec![
        ("I", light.intensity().into()),
        ("DoP", light.degree_of_polarization().into()),
        ("DoLP", light.degree_of_linear_polarization().into()),
        ("DoCP", light.degree_of_circular_polarization().into()),
        ("AoLP", light.orientation_angle().into()),
        ("chi", light.ellipticity_angle().into()),
        ("semi_major", ellipse.semi_major.into()),
        ("semi_minor", ellipse.semi_minor.into()),
        ("eig", light.eigenvalues().to_vec().into()),
    ]))
}

pub(super) const ENVELOPE: &str = "an intensity profile: an object with 'kind'";
const KINDS: &str = "'gaussian', 'rect', 'disk' or 'gaussian_mixture'";
#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::schema::Case;
    use stokes::hermite;

    #[test]
    fn coefficients_that_are_not_hermitian_are_no_less_right() {
        // λ = 2π m, so that k = 1 and with r = 100 m: w = ξ/100, and the whitened point of ζ is 100 ζ
        let inputs = serde_json::json!({
            "lambda": std::f64::consts::TAU, "r": 100, "Theta": [[1, 0], [0, 1]], "Q": [[0, 1], [1, 0]],
            "modes": [[1, 0, {"re": 3, "im": 4}], [1, 0, -1], [0, 0, {"re": 0, "im": 1}]],
            "xi": [20, 70], "zeta": [2e-3, 7e-3],
        });
        let case = Case {
            id: String::new(),
            op: String::new(),
            inputs,
        };
        // Q swaps the axes: the first coordinate over Θ is 0.7, the second 0.2
        let h = |n: usize| hermite(n, 0.7) * hermite(0, 0.2);
        let (c10, c00) = (Complex64::new(2.0, 4.0), Complex64::I);
        let close = |found: &Item, expected: Complex64| match found {
            Item::Complex(found) => {
                assert!(
                    (found - expected).norm() < 8.0 * f64::EPSILON * expected.norm(),
                    "{found} {expected}"
                );
            }
            other => panic!("{other:?}"),
        };
        let entry = Entry::of(&case);
        let Ok(Item::Group(found)) = csd(&entry) else {
            panic!("no result");
        };
        close(&found[0].1, (c10 * h(1) + c00 * h(0)) / 1e4);
        let Ok(Item::Group(found)) = wvd(&entry) else {
            panic!("no result");
        };
        // (2π/k²) Σ (−i)^n c h, and C(0) = c_00/(√π r²)
        let sum = -Complex64::I * c10 * h(1) + c00 * h(0);
        close(&found[0].1, sum * std::f64::consts::TAU);
        close(&found[1].1, c00 / std::f64::consts::PI.sqrt() / 1e4);
    }
}
