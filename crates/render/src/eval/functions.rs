//! Operations of the crate `stokes` on single functions: whitened and covariant modes, changes of their root, overlaps.

use nalgebra::DVector;
use num_complex::Complex64;
use stokes::{
    Family, MAX_ORDER, ShapeMatrix, covariant_mode, covariant_mode_at_zero, covariant_mode_fourier,
    hermite, symmetric_power, whitened_mode,
};

use super::Precision;
use super::entry::{Entry, MATRIX, VECTOR};
use super::result::Item;
use super::schema::CaseError;

pub(super) fn hermite1d(inputs: &Entry<'_>, precision: Precision) -> Result<Item, CaseError> {
    let n = order(inputs, "n")?;
    let t = inputs.get("t", "a finite number")?.number()?;
    Ok(Item::value(match precision {
        Precision::Double => hermite(n, t),
        Precision::Single => in_single_precision(n, t),
    }))
}

/// `h_n(t)` by the functions in f32, of an argument that f32 need not hold.
///
/// The rounding of `t` to f32 alone would cost `|t h_n'|/2²⁴`, far more than the rounding of the function: what it drops is put
/// back to first order, `h_n(t) = h_n(t₃₂) + (t − t₃₂)(√(2n) h_{n−1}(t₃₂) − t₃₂ h_n(t₃₂))`.
fn in_single_precision(n: usize, t: f64) -> f64 {
    let near = t as f32;
    let value = hermite(n, near);
    if near.is_infinite() {
        return f64::from(value);
    }
    let below = if n > 0 { hermite(n - 1, near) } else { 0.0 };
    let slope = ((2 * n) as f32).sqrt() * below - near * value;
    f64::from(value) + (t - f64::from(near)) * f64::from(slope)
}

pub(super) fn phi(inputs: &Entry<'_>, precision: Precision) -> Result<Item, CaseError> {
    let (a, b) = (order(inputs, "a")?, order(inputs, "b")?);
    let shape = shape_with_root(inputs, "W")?;
    let x = inputs.get("x", VECTOR)?.vector()?;
    Ok(Item::value(match precision {
        Precision::Double => whitened_mode(a, b, &shape, &x),
        Precision::Single => {
            let y = shape.whiten(&x);
            let [along, across] = [in_single_precision(a, y.x), in_single_precision(b, y.y)];
            shape.root_determinant().sqrt() * along * across
        }
    }))
}

pub(super) fn psi(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let (n, m) = (order(inputs, "n")?, order(inputs, "m")?);
    let theta = inputs.get("Theta", MATRIX)?;
    let x = inputs.get("x", VECTOR)?.vector()?;
    covariant_mode(family(inputs)?, n, m, &theta.matrix()?, &x)
        .map(Item::value)
        .map_err(|e| theta.refuse(e))
}

pub(super) fn psi_zero(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let (n, m) = (order(inputs, "n")?, order(inputs, "m")?);
    let theta = inputs.get("Theta", MATRIX)?;
    covariant_mode_at_zero(Family::Covariant, n, m, &theta.matrix()?)
        .map(Item::value)
        .map_err(|e| theta.refuse(e))
}

pub(super) fn ft_psi(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let (n, m) = (order(inputs, "n")?, order(inputs, "m")?);
    let theta = inputs.get("Theta", MATRIX)?;
    let zeta = inputs.get("zeta", VECTOR)?.vector()?;
    covariant_mode_fourier(family(inputs)?, n, m, &theta.matrix()?, &zeta)
        .map(Item::value)
        .map_err(|e| theta.refuse(e))
}

fn family(inputs: &Entry<'_>) -> Result<Family, CaseError> {
    match inputs.find("dual")? {
        Some(dual) if dual.flag()? => Ok(Family::Dual),
        _ => Ok(Family::Covariant),
    }
}

pub(super) fn sym_power(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let a = inputs.get("A", MATRIX)?.matrix()?;
    let n = order(inputs, "N")?;
    Ok(Item::Group(vec![("matrix", symmetric_power(&a, n).into())]))
}

pub(super) fn cov_to_white(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let shape = shape_with_root(inputs, "W")?;
    let rows = inputs.get(
        "coeffs",
        "a list of 1, 2, 3, … coefficients, order by order",
    )?;
    let mut white = Vec::new();
    for (n, row) in rows.list()?.iter().enumerate() {
        white.push(whitened(&shape, n, row)?);
    }
    Ok(Item::Group(vec![
        ("coeffs_white", Item::List(white)),
        ("Theta", shape.theta().into()),
    ]))
}

/// `Sym^n(W) c` of the coefficients of one total order: real when they are.
fn whitened(shape: &ShapeMatrix, n: usize, row: &Entry<'_>) -> Result<Item, CaseError> {
    let coefficients = row.list()?;
    if n > MAX_ORDER || coefficients.len() != n + 1 {
        return Err(row.refuse(format!(
            "found {} coefficients of order {n}, expected {} and an order of at most {}",
            coefficients.len(),
            n + 1,
            MAX_ORDER
        )));
    }
    let power = symmetric_power(shape.root(), n);
    let c = coefficients
        .iter()
        .map(Entry::complex)
        .collect::<Result<Vec<_>, _>>()?;
    let part =
        |part: fn(&Complex64) -> f64| &power * DVector::from_iterator(n + 1, c.iter().map(part));
    let re = part(|z| z.re);
    if !coefficients.iter().any(Entry::is_complex) {
        return Ok(re.as_slice().to_vec().into());
    }
    let im = part(|z| z.im);
    let both = re.iter().zip(&im).map(|(re, im)| Complex64::new(*re, *im));
    Ok(both.collect::<Vec<_>>().into())
}

pub(super) fn overlap(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let first = (order(inputs, "a")?, order(inputs, "b")?);
    let second = (order(inputs, "n")?, order(inputs, "m")?);
    let (w1, w2) = (
        shape_with_root(inputs, "W1")?,
        shape_with_root(inputs, "W2")?,
    );
    Ok(Item::value(stokes::overlap(first, &w1, second, &w2)))
}

pub(super) fn order(inputs: &Entry<'_>, key: &str) -> Result<usize, CaseError> {
    inputs
        .get(key, "an order: a whole number, 0 or more")?
        .order()
}

/// The shape whose root stands under `key`.
pub(super) fn shape_with_root(inputs: &Entry<'_>, key: &str) -> Result<ShapeMatrix, CaseError> {
    let root = inputs.get(key, MATRIX)?;
    ShapeMatrix::from_root(&root.matrix()?).map_err(|problem| root.refuse(problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_argument_between_two_single_numbers_is_not_rounded() {
        // rounding t to f32 would change e^(−t²/2) by t·ulp/2 = 5e-6
        let half_ulp = 2f64.powi(-21);
        for t in [11.0 + half_ulp, -11.0 - half_ulp, 9.0 + 0.9 * half_ulp] {
            let (found, expected) = (in_single_precision(0, t), hermite(0, t));
            // the rounding of h_0 and that of the correction
            let error = (found / expected - 1.0).abs();
            assert!(error < 2.0 * f64::from(f32::EPSILON), "{t}: {error}");
        }
    }
}
