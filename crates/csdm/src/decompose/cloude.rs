//! Cloude's decomposition: a Mueller matrix as a mixture of at most four Jones matrices.

use nalgebra::{Matrix4, Vector4};
use num_complex::Complex64;
use stokes::Mueller;

use super::not_finite;
use super::realizable::NotRealizable;
use crate::jones::JonesMatrix;
use crate::sixteen::GeneralizedMueller;

/// One realization of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedJones {
    /// Its probability; those of a mixture add up to 1.
    pub weight: f64,
    /// Its Jones matrix, with the largest element real and positive.
    pub jones: JonesMatrix,
}

/// Eigenvalues and eigenvectors of the coherency matrix of a Mueller matrix.
///
/// ```text
/// H = ¼ Σ M_lj σ_l ⊗ σ_j* = ½ ⟨vec T vec T†⟩,     tr H = M00,     ‖H‖_F = ½ ‖M‖_F
/// H = Σ λ_i v_i v_i†                              T_i: the element of power M00 along v_i, weight λ_i/Σλ
/// ```
///
/// `M` belongs to an ensemble of Jones matrices if and only if no `λ_i` is negative.
///
/// Source: Cloude 1986, Group theory and polarisation algebra, Optik 75, 26.
///
/// Eigenvalues have an error of a few `f64::EPSILON` times the largest.
///
/// ```
/// // half of a depolarizer: ⅝ of its power is one identity, the rest three other elements of ⅛
/// let mueller = stokes::Mueller::from_rows([
///     [1.0, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0], [0.0, 0.0, 0.0, 0.5]]);
/// let [first, .., last] = csdm::CloudeSpectrum::of(&mueller)?.eigenvalues();
/// assert!((first - 0.625).abs() < 1e-15 && (last - 0.125).abs() < 1e-15);
/// # Ok::<(), csdm::NotRealizable>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudeSpectrum {
    pub(super) eigenvalues: [f64; 4],
    pub(super) vectors: [Vector4<Complex64>; 4],
    pub(super) transmittance: f64,
}

impl CloudeSpectrum {
    /// The spectrum of a Mueller matrix, realizable or not.
    ///
    /// # Errors
    ///
    /// When an element is infinite or not a number.
    pub fn of(mueller: &Mueller) -> Result<Self, NotRealizable> {
        let m = mueller.to_matrix();
        if let Some((row, column, value)) = not_finite(&m) {
            return Err(NotRealizable::NotFinite { row, column, value });
        }
        // scaled, so that no sum overflows
        let scale = if m.amax() > 0.0 { m.amax() } else { 1.0 };
        let eigen = coherency_matrix(&Mueller::from(m / scale)).symmetric_eigen();
        let mut order = [0, 1, 2, 3];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        Ok(Self {
            eigenvalues: order.map(|i| eigen.eigenvalues[i] * scale),
            vectors: order.map(|i| eigen.eigenvectors.column(i).into_owned()),
            transmittance: m[(0, 0)],
        })
    }

    /// The eigenvalues, the largest first; their sum is `M00`.
    #[must_use]
    pub fn eigenvalues(&self) -> [f64; 4] {
        self.eigenvalues
    }

    /// Up to four Jones matrices whose mixture has this Mueller matrix.
    ///
    /// Eigenvalues of modulus up to `tolerance` times the largest are left out, which moves the Mueller matrix by at most
    /// `4 · tolerance · M00` in the Frobenius norm. An opaque element is one Jones matrix of zeros.
    ///
    /// # Errors
    ///
    /// When an eigenvalue is more negative than that.
    pub fn jones_matrices(&self, tolerance: f64) -> Result<Vec<WeightedJones>, NotRealizable> {
        self.check_realizable(tolerance)?;
        let limit = tolerance * self.scale();
        let kept = self.eigenvalues.into_iter().zip(self.vectors);
        let kept: Vec<_> = kept.filter(|(value, _)| *value > limit).collect();
        let power: f64 = kept.iter().map(|(value, _)| value).sum();
        if kept.is_empty() {
            let dark = Complex64::from(0.0);
            return Ok(vec![WeightedJones {
                weight: 1.0,
                jones: JonesMatrix::diagonal(dark, dark),
            }]);
        }
        let elements = kept.into_iter().map(|(value, vector)| WeightedJones {
            weight: value / power,
            jones: jones_of(&vector, (2.0 * power).sqrt()),
        });
        Ok(elements.collect())
    }

    /// The one Jones matrix whose Mueller matrix this is; its largest element is real and positive.
    ///
    /// # Errors
    ///
    /// When a second eigenvalue exceeds `tolerance` times the first, or one is as negative.
    pub fn jones_matrix(&self, tolerance: f64) -> Result<JonesMatrix, NotRealizable> {
        self.check_realizable(tolerance)?;
        let [first, second, ..] = self.eigenvalues;
        let limit = tolerance * self.scale();
        if second > limit {
            return Err(NotRealizable::Depolarizing {
                first,
                second,
                limit,
            });
        }
        Ok(jones_of(&self.vectors[0], (2.0 * first.max(0.0)).sqrt()))
    }

    /// Entropy `−Σ p_i log₄ p_i` with `p_i = λ_i/Σλ`, in `0.0..=1.0`: 0 for a single Jones matrix, 1 for an ideal
    /// depolarizer. 0 for an opaque element.
    ///
    /// Eigenvalues from `−tolerance` times the largest up to 0 count as 0.
    ///
    /// # Errors
    ///
    /// When an eigenvalue is more negative than that.
    pub fn entropy(&self, tolerance: f64) -> Result<f64, NotRealizable> {
        self.check_realizable(tolerance)?;
        let power: f64 = self.eigenvalues.iter().map(|value| value.max(0.0)).sum();
        let terms = self.eigenvalues.iter().map(|value| {
            let p = value / power;
            if p > 0.0 { -p * p.ln() } else { 0.0 }
        });
        Ok(terms.sum::<f64>() / 4f64.ln())
    }

    /// Depolarization index `√((Σ M_lj² − M00²)/(3 M00²))`, in `0.0..=1.0` for a realizable matrix: 1 for a single Jones
    /// matrix, 0 for an ideal depolarizer and for an opaque element.
    ///
    /// From differences of the eigenvalues, without cancellation near 0.
    ///
    /// Source: Gil & Bernabeu 1986, Optica Acta 33, 185.
    #[must_use]
    pub fn depolarization_index(&self) -> f64 {
        if self.transmittance == 0.0 {
            return 0.0;
        }
        let mut squares = 0.0;
        for (i, larger) in self.eigenvalues.iter().enumerate() {
            for smaller in &self.eigenvalues[i + 1..] {
                squares += ((larger - smaller) / self.transmittance).powi(2);
            }
        }
        (squares / 3.0).sqrt()
    }

    /// The largest modulus of an eigenvalue.
    pub(super) fn scale(&self) -> f64 {
        self.eigenvalues[0].abs().max(self.eigenvalues[3].abs())
    }
}

/// Cloude's coherency matrix `H = ¼ Σ M_lj σ_l ⊗ σ_j*`: 4×4, Hermitian, trace `M00`; rows and columns counted
/// `xx, xy, yx, yy` as in a [`crate::TransferTensor`], of which it is half.
#[must_use]
pub fn coherency_matrix(mueller: &Mueller) -> Matrix4<Complex64> {
    GeneralizedMueller::from(*mueller)
        .transfer()
        .scaled(0.5)
        .to_matrix()
}

/// The Jones matrix of Frobenius norm `norm` along a unit vector, its largest element real and positive.
fn jones_of(vector: &Vector4<Complex64>, norm: f64) -> JonesMatrix {
    let largest = vector
        .iter()
        .fold(Complex64::from(0.0), |largest, element| {
            // a clear lead decides, so that equal moduli do not leave the choice to rounding
            if element.norm() > largest.norm() * (1.0 + 1e-9) {
                *element
            } else {
                largest
            }
        });
    let phase = largest.conj() / largest.norm() * norm;
    let [xx, xy, yx, yy] = [0, 1, 2, 3].map(|i| vector[i] * phase);
    JonesMatrix::new(xx, xy, yx, yy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jones::pauli;
    use proptest::prelude::*;

    #[test]
    fn the_coherency_matrix_is_the_sum_of_kronecker_products() {
        let mueller = Mueller::from(Matrix4::from_fn(|l, j| {
            (1.0 + 3.0 * l as f64 + 0.7 * (j * j) as f64).sin()
        }));
        let sigma = pauli();
        let mut expected = Matrix4::zeros();
        for l in 0..4 {
            for j in 0..4 {
                let factor = Complex64::from(0.25 * mueller.element(l, j));
                expected += sigma[l].kronecker(&sigma[j].conjugate()) * factor;
            }
        }
        assert!((coherency_matrix(&mueller) - expected).camax() < 1e-15);
    }

    #[test]
    fn an_ideal_depolarizer_has_entropy_1_and_a_retarder_0() {
        let spectrum = CloudeSpectrum::of(&Mueller::depolarizer(0.3)).unwrap();
        assert!((spectrum.entropy(0.0).unwrap() - 1.0).abs() < 1e-15);
        assert!(spectrum.depolarization_index() < 1e-15);
        let plate = JonesMatrix::elliptical_retarder(0.3, 0.2, 1.0).mueller();
        let spectrum = CloudeSpectrum::of(&plate).unwrap();
        assert!(spectrum.entropy(1e-14).unwrap() < 1e-13);
        assert!((spectrum.depolarization_index() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn nothing_passes_an_opaque_element() {
        let spectrum = CloudeSpectrum::of(&Mueller::depolarizer(0.0)).unwrap();
        let [only] = spectrum.jones_matrices(1e-12).unwrap()[..] else {
            panic!("one Jones matrix of zeros");
        };
        assert_eq!(only.jones.mueller(), Mueller::depolarizer(0.0));
        assert!(spectrum.nearest_realizable_of_same_transmittance().is_err());
        let error = CloudeSpectrum::of(&Mueller::depolarizer(f64::NAN)).unwrap_err();
        assert!(matches!(
            error,
            NotRealizable::NotFinite {
                row: 0,
                column: 0,
                ..
            }
        ));
    }

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || prop_oneof![4 => -1.0..1.0f64, 1 => -1e-9..1e-9f64, 1 => Just(0.0)];
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        prop::array::uniform4(complex()).prop_map(|[a, b, c, d]| JonesMatrix::new(a, b, c, d))
    }

    fn mixture(elements: &[WeightedJones]) -> Matrix4<f64> {
        elements
            .iter()
            .map(|element| element.jones.mueller().to_matrix() * element.weight)
            .sum()
    }

    proptest! {
        #[test]
        fn a_jones_matrix_comes_back_from_its_sixteen(t in matrix()) {
            let found = CloudeSpectrum::of(&t.mueller()).unwrap().jones_matrix(1e-13).unwrap();
            // up to a phase, which the Mueller matrix does not hold
            let (a, b) = (t.to_matrix(), found.to_matrix());
            let overlap = (b.adjoint() * a).trace();
            prop_assume!(overlap.norm() > 0.0);
            let difference = a - b * (overlap / overlap.norm());
            prop_assert!(difference.norm() <= 1e-13 * a.norm(), "{}", difference.norm() / a.norm());
        }

        #[test]
        fn a_mixture_comes_back_as_a_mixture_with_the_same_sixteen(
            elements in prop::collection::vec(matrix(), 1..7),
        ) {
            let mueller: Matrix4<f64> = elements.iter().map(|t| t.mueller().to_matrix()).sum();
            let spectrum = CloudeSpectrum::of(&Mueller::from(mueller)).unwrap();
            let found = spectrum.jones_matrices(1e-14).unwrap();
            prop_assert!(found.len() <= elements.len().min(4));
            prop_assert!((mixture(&found) - mueller).norm() <= 1e-13 * (mueller.norm() + 1e-300));
            let weights: f64 = found.iter().map(|element| element.weight).sum();
            prop_assert!((weights - 1.0).abs() < 1e-15);
            let index = spectrum.depolarization_index();
            let square = (mueller.norm_squared() / mueller[(0, 0)].powi(2) - 1.0) / 3.0;
            prop_assume!(mueller[(0, 0)] > 0.0);
            prop_assert!((index * index - square).abs() < 1e-13);
        }
    }
}
