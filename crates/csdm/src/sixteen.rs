//! From Jones matrices to the sixteen, at one point and at two.

use std::ops::Mul;

use nalgebra::{Matrix2, Matrix4, Vector4};
use num_complex::Complex64;
use stokes::Mueller;
use thiserror::Error;

use crate::csdm::CrossSpectralDensity;
use crate::jones::{JonesMatrix, pauli};

/// Why sixteen numbers are no Mueller matrix of one point.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "generalized Mueller matrix: element ({row}, {column}) is {value}, expected an imaginary part of at most {limit} \
     where the two points are one"
)]
pub struct NotReal {
    /// Row of the element, from 0.
    pub row: usize,
    /// Column of the element, from 0.
    pub column: usize,
    /// What was found.
    pub value: Complex64,
    /// Largest imaginary part allowed.
    pub limit: f64,
}

/// Second moments `⟨T_ap(r₁) T*_bq(r₂)⟩` of an element's Jones matrix at two points: 4×4, complex, dimensionless.
///
/// An element whose realizations are `T(r)` takes `C` to `⟨T(r₁) C T(r₂)†⟩` (Eq. (S4.12)). Two matrices say so, and
/// each gives the other:
///
/// ```text
/// E_(ap),(bq) = ⟨T_ap(r₁) T*_bq(r₂)⟩                 C'_ab = Σ_pq E_(ap),(bq) C_pq         TransferTensor
/// M_lj = ½ ⟨tr(σ_l T(r₁) σ_j T(r₂)†)⟩                C'_l  = Σ_j M_lj C_j                 GeneralizedMueller
///      = ½ Σ (σ_l)_ba (σ_j)_pq E_(ap),(bq)
/// ```
///
/// Rows of `E` are pairs `(a, p)`, columns pairs `(b, q)`, counted `xx, xy, yx, yy`: `E = ⟨vec T(r₁) vec T(r₂)†⟩`. At
/// one point `E` is Hermitian with no negative eigenvalue, twice Cloude's coherency matrix, and `M` is the real Mueller
/// matrix.
///
/// How many numbers: a deterministic element has 4 complex values of `T` at each of two points, but `E` does not notice
/// a factor that multiplies one and divides the other, so 14 real numbers remain. An ensemble has 16 complex numbers, at
/// one point 16 real ones. The "16 real values" printed below Eq. (S4.12) for `T` at two points are neither.
///
/// Source: Eqs. (S4.5), (S4.6), (S4.12) of the supplemental of Steinberg & Yan 2021, fields in `exp(+iωt)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferTensor(Matrix4<Complex64>);

impl TransferTensor {
    /// The tensor of one realization with `first = T(r₁)` and `second = T(r₂)`.
    #[must_use]
    pub fn of_jones(first: &JonesMatrix, second: &JonesMatrix) -> Self {
        Self(vec(first) * vec(second).adjoint())
    }

    /// The tensor of an element that keeps the axes apart, from `[[xx, xy], [yx, yy]]` with
    /// `ij = ⟨T_ii(r₁) T*_jj(r₂)⟩`.
    #[must_use]
    pub fn of_diagonal(moments: Matrix2<Complex64>) -> Self {
        let mut tensor = Matrix4::zeros();
        for (i, row) in [0, 3].into_iter().enumerate() {
            for (j, column) in [0, 3].into_iter().enumerate() {
                tensor[(row, column)] = moments[(i, j)];
            }
        }
        Self(tensor)
    }

    /// The matrix as nalgebra holds it: rows `(a, p)`, columns `(b, q)`, counted `xx, xy, yx, yy`.
    #[must_use]
    pub fn to_matrix(self) -> Matrix4<Complex64> {
        self.0
    }

    /// The tensor of the same two points in the other order: the adjoint.
    #[must_use]
    pub fn exchanged(&self) -> Self {
        Self(self.0.adjoint())
    }

    /// This tensor plus `weight` times another.
    #[must_use]
    pub fn plus(&self, weight: f64, other: &Self) -> Self {
        Self(self.0 + other.0 * Complex64::from(weight))
    }

    /// All moments times `factor`, such as a mean transmittance.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self(self.0 * Complex64::from(factor))
    }

    /// What the element makes of light with this matrix between the same two points: `⟨T(r₁) C T(r₂)†⟩`.
    ///
    /// Source: Eq. (S4.12).
    #[must_use]
    pub fn apply(&self, light: &CrossSpectralDensity) -> CrossSpectralDensity {
        let c = light.to_matrix();
        let field_map = exchange_inner(&self.0);
        let out = field_map * Vector4::new(c[(0, 0)], c[(0, 1)], c[(1, 0)], c[(1, 1)]);
        CrossSpectralDensity(Matrix2::new(out[0], out[1], out[2], out[3]))
    }

    /// The same element as it acts on the four parameters.
    #[must_use]
    pub fn generalized_mueller(&self) -> GeneralizedMueller {
        let a = parameters_of_elements();
        GeneralizedMueller(a * exchange_inner(&self.0) * a.adjoint() * Complex64::from(0.5))
    }
}

impl From<Matrix4<Complex64>> for TransferTensor {
    fn from(matrix: Matrix4<Complex64>) -> Self {
        Self(matrix)
    }
}

/// The sixteen numbers `M_lj(r₁, r₂)` that take the generalized Stokes parameters before an element to those behind it:
/// 4×4, complex, dimensionless; real where the two points are one.
///
/// Acts on the parameters of a [`CrossSpectralDensity`]; see [`GeneralizedMueller::scattering`] for light in the phase
/// convention of [`stokes::GeneralizedStokes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralizedMueller(Matrix4<Complex64>);

impl GeneralizedMueller {
    /// `M_lj = ½ tr(σ_l T(r₁) σ_j T(r₂)†)` of one realization with `first = T(r₁)` and `second = T(r₂)`.
    ///
    /// Error of a few `f64::EPSILON` times the product of the two norms.
    #[must_use]
    pub fn of_jones(first: &JonesMatrix, second: &JonesMatrix) -> Self {
        TransferTensor::of_jones(first, second).generalized_mueller()
    }

    /// `M_lj` with `l` = `row` and `j` = `column`, both in `0..4`.
    ///
    /// # Panics
    ///
    /// When an index is not below 4.
    #[must_use]
    pub fn element(&self, row: usize, column: usize) -> Complex64 {
        self.0[(row, column)]
    }

    /// The matrix as nalgebra holds it.
    #[must_use]
    pub fn to_matrix(self) -> Matrix4<Complex64> {
        self.0
    }

    /// The second moments of the Jones matrix that these numbers belong to: `E_(ap),(bq) = ½ Σ M_lj (σ_l)_ab (σ_j*)_pq`.
    #[must_use]
    pub fn transfer(&self) -> TransferTensor {
        let a = parameters_of_elements();
        TransferTensor(exchange_inner(
            &(a.adjoint() * self.0 * a * Complex64::from(0.5)),
        ))
    }

    /// The generalized Stokes parameters behind the element, of light that had `parameters` before it.
    #[must_use]
    pub fn apply(&self, parameters: [Complex64; 4]) -> [Complex64; 4] {
        (self.0 * Vector4::from(parameters)).into()
    }

    /// The mutual scattering functions `Σ^(j→l)(r₁, r₂) = M_lj(r₁, r₂)*`, with `l` the row and `j` the column.
    ///
    /// This is what multiplies the parameters of [`stokes::GeneralizedStokes`] and what the theorem of light-matter
    /// interaction takes: spatial phases there are `e^{+ikr}`, the conjugate of those of fields in `exp(+iωt)`, while the
    /// polarization keeps its sign. Without the conjugate a polarization grating sends its light to the wrong side.
    ///
    /// Source: Eq. (S2.3) with Theorem S4.1.
    #[must_use]
    pub fn scattering(&self) -> Matrix4<Complex64> {
        self.0.conjugate()
    }

    /// The Mueller matrix of one point.
    ///
    /// # Errors
    ///
    /// When an imaginary part exceeds `tolerance` times the largest element: the two points are not one.
    pub fn to_mueller(&self, tolerance: f64) -> Result<Mueller, NotReal> {
        let limit = tolerance * self.0.camax();
        for row in 0..4 {
            for column in 0..4 {
                let value = self.0[(row, column)];
                if value.im.abs() > limit {
                    return Err(NotReal {
                        row,
                        column,
                        value,
                        limit,
                    });
                }
            }
        }
        Ok(self.real_part())
    }

    /// The real parts, where one knows that there are no others.
    pub(crate) fn real_part(&self) -> Mueller {
        Mueller::from(self.0.map(|element| element.re))
    }
}

impl From<Mueller> for GeneralizedMueller {
    fn from(mueller: Mueller) -> Self {
        Self(mueller.to_matrix().map(Complex64::from))
    }
}

impl From<Matrix4<Complex64>> for GeneralizedMueller {
    fn from(matrix: Matrix4<Complex64>) -> Self {
        Self(matrix)
    }
}

/// Statistically independent elements in sequence: the right factor is met first.
impl Mul for GeneralizedMueller {
    type Output = Self;
    fn mul(self, first: Self) -> Self {
        Self(self.0 * first.0)
    }
}

/// `(T_xx, T_xy, T_yx, T_yy)`.
fn vec(jones: &JonesMatrix) -> Vector4<Complex64> {
    let m = jones.to_matrix();
    Vector4::new(m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)])
}

/// `F_(ab),(pq) = E_(ap),(bq)`: from moments to the map of `vec C`, and back.
fn exchange_inner(tensor: &Matrix4<Complex64>) -> Matrix4<Complex64> {
    Matrix4::from_fn(|row, column| {
        let (a, b, p, q) = (row / 2, row % 2, column / 2, column % 2);
        tensor[(2 * a + p, 2 * b + q)]
    })
}

/// `A_l,(ab) = (σ_l)_ba`: parameters `tr(σ_l C)` from the elements of `C`; its inverse is half its adjoint.
fn parameters_of_elements() -> Matrix4<Complex64> {
    let sigma = pauli();
    Matrix4::from_fn(|l, pair| sigma[l][(pair % 2, pair / 2)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || prop_oneof![4 => -1.0..1.0f64, 1 => -1e-9..1e-9f64, 1 => Just(0.0)];
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        prop::array::uniform4(complex()).prop_map(|[a, b, c, d]| JonesMatrix::new(a, b, c, d))
    }

    /// A Jones matrix from eight numbers without any pattern.
    fn jones(n: &[f64]) -> JonesMatrix {
        let c = |i: usize| Complex64::new(n[2 * i], n[2 * i + 1]);
        JonesMatrix::new(c(0), c(1), c(2), c(3))
    }

    fn patternless(index: usize) -> f64 {
        (0.7 + 1.3 * index as f64 * (index as f64 + 0.37)).sin()
    }

    #[test]
    fn a_deterministic_element_has_14_numbers_at_two_points_and_not_the_printed_16() {
        let parameters: Vec<f64> = (0..16).map(patternless).collect();
        let numbers = |n: &[f64]| -> Vec<f64> {
            let m = GeneralizedMueller::of_jones(&jones(&n[..8]), &jones(&n[8..])).to_matrix();
            m.iter().flat_map(|c| [c.re, c.im]).collect()
        };
        // bilinear in the parameters of the two points: central differences are exact
        let step = 0.5;
        let jacobian = DMatrix::from_fn(32, 16, |row, column| {
            let mut moved = parameters.clone();
            moved[column] += step;
            let ahead = numbers(&moved)[row];
            moved[column] -= 2.0 * step;
            (ahead - numbers(&moved)[row]) / (2.0 * step)
        });
        let values = jacobian.singular_values();
        let mut values: Vec<f64> = values.iter().copied().collect();
        values.sort_by(|a, b| b.total_cmp(a));
        assert!(values[13] > 0.1 && values[14] < 1e-14 * values[0]);
    }

    #[test]
    fn an_ensemble_has_16_complex_numbers() {
        // any tensor is a combination of deterministic ones: 16 pairs without pattern are linearly independent
        let columns = DMatrix::from_fn(16, 16, |row, sample| {
            let n: Vec<f64> = (0..16).map(|i| patternless(16 * sample + i)).collect();
            let tensor = TransferTensor::of_jones(&jones(&n[..8]), &jones(&n[8..]));
            tensor.to_matrix()[(row / 4, row % 4)]
        });
        assert!(columns.singular_values().min() > 1e-3);
    }

    #[test]
    fn no_deterministic_element_depolarizes() {
        // the printed claim would make "both formalisms equally powerful" without the average: a depolarizer is four
        // equal terms, the best single one leaves √3/2 of it
        let tensor = GeneralizedMueller::from(Mueller::depolarizer(1.0)).transfer();
        let values = tensor.to_matrix().singular_values();
        assert!((values - Vector4::repeat(0.5)).norm() < 1e-15);
    }

    #[test]
    fn imaginary_parts_are_refused_with_their_place() {
        let there = JonesMatrix::linear_retarder(0.3);
        let sixteen = GeneralizedMueller::of_jones(&JonesMatrix::identity(), &there);
        let error = sixteen.to_mueller(1e-9).unwrap_err();
        assert!((error.row, error.column) == (0, 0) && error.value.im != 0.0);
    }

    proptest! {
        #[test]
        fn sixteen_numbers_are_traces_with_pauli_matrices(t1 in matrix(), t2 in matrix()) {
            let sixteen = GeneralizedMueller::of_jones(&t1, &t2);
            let sigma = pauli();
            for l in 0..4 {
                for j in 0..4 {
                    let product = sigma[l] * t1.to_matrix() * sigma[j] * t2.to_matrix().adjoint();
                    prop_assert!((sixteen.element(l, j) - product.trace() * 0.5).norm() < 2e-15);
                }
            }
            let here = GeneralizedMueller::of_jones(&t1, &t1).to_mueller(1e-15);
            let here = here.unwrap_or(Mueller::identity()).to_matrix();
            prop_assert!((here - t1.mueller().to_matrix()).amax() < 4e-15);
        }

        #[test]
        fn tensor_and_sixteen_give_each_other_and_act_alike(
            t1 in matrix(), t2 in matrix(), t3 in matrix(), t4 in matrix(),
            c in prop::array::uniform4(complex()),
        ) {
            let tensor = TransferTensor::of_jones(&t1, &t2)
                .plus(0.7, &TransferTensor::of_jones(&t3, &t4));
            let sixteen = tensor.generalized_mueller();
            prop_assert!((sixteen.transfer().to_matrix() - tensor.to_matrix()).camax() < 4e-15);
            let light = CrossSpectralDensity::new(Matrix2::new(c[0], c[1], c[2], c[3])).unwrap();
            let by_fields = t1.to_matrix() * light.to_matrix() * t2.to_matrix().adjoint()
                + t3.to_matrix() * light.to_matrix() * t4.to_matrix().adjoint() * Complex64::from(0.7);
            let out = tensor.apply(&light);
            prop_assert!((out.to_matrix() - by_fields).camax() < 1e-14);
            let by_parameters = sixteen.apply(light.generalized_stokes());
            for (a, b) in out.generalized_stokes().iter().zip(by_parameters) {
                prop_assert!((a - b).norm() < 4e-14);
            }
            let exchanged = tensor.exchanged().generalized_mueller().to_matrix();
            prop_assert!((exchanged - sixteen.scattering()).camax() < 1e-14);
        }

        #[test]
        fn products_of_elements_are_products_of_sixteen(
            a1 in matrix(), a2 in matrix(), b1 in matrix(), b2 in matrix(),
        ) {
            let product = GeneralizedMueller::of_jones(&(a1 * b1), &(a2 * b2)).to_matrix();
            let factors = GeneralizedMueller::of_jones(&a1, &a2) * GeneralizedMueller::of_jones(&b1, &b2);
            prop_assert!((product - factors.to_matrix()).camax() < 2e-14);
        }
    }
}
