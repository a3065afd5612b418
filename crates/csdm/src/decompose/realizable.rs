//! Whether any ensemble of Jones matrices has a given Mueller matrix, and the nearest matrix that one has.

use nalgebra::Matrix4;
use num_complex::Complex64;
use stokes::Mueller;
use thiserror::Error;

use super::cloude::CloudeSpectrum;
use crate::sixteen::TransferTensor;

/// Why a Mueller matrix belongs to no ensemble of Jones matrices, or not to a single one.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NotRealizable {
    /// An element is infinite or not a number.
    #[error("Mueller matrix: element ({row}, {column}) is {value}, expected a finite number")]
    NotFinite {
        /// Row of the element, from 0.
        row: usize,
        /// Column of the element, from 0.
        column: usize,
        /// What was found.
        value: f64,
    },
    /// The coherency matrix has a negative eigenvalue.
    #[error(
        "Mueller matrix: eigenvalue {index} of its coherency matrix is {eigenvalue} at M00 = {transmittance}, expected \
         at least {least}: no mixture of Jones matrices makes it; the nearest one that does is nearest_realizable"
    )]
    NegativeEigenvalue {
        /// Which eigenvalue, from 0 for the largest; 3 is the most negative.
        index: usize,
        /// Its value.
        eigenvalue: f64,
        /// `M00`, the sum of the four.
        transmittance: f64,
        /// Least eigenvalue allowed.
        least: f64,
    },
    /// One Jones matrix was asked for, and the element depolarizes.
    #[error(
        "Mueller matrix: the second eigenvalue of its coherency matrix is {second} beside the first, {first}, expected at \
         most {limit}: it depolarizes, no single Jones matrix makes it"
    )]
    Depolarizing {
        /// The largest eigenvalue.
        first: f64,
        /// The second.
        second: f64,
        /// Largest second eigenvalue allowed.
        limit: f64,
    },
    /// A matrix with the same `M00` was asked for, and `M00` is not positive.
    #[error("Mueller matrix: M00 is {transmittance}, expected a positive transmittance to keep")]
    NoTransmittance {
        /// `M00`.
        transmittance: f64,
    },
}

impl CloudeSpectrum {
    /// Asks whether no eigenvalue is below `−tolerance` times the largest modulus.
    ///
    /// # Errors
    ///
    /// With the most negative eigenvalue.
    pub fn check_realizable(&self, tolerance: f64) -> Result<(), NotRealizable> {
        let (eigenvalue, least) = (self.eigenvalues[3], -tolerance * self.scale());
        if eigenvalue < least {
            return Err(NotRealizable::NegativeEigenvalue {
                index: 3,
                eigenvalue,
                transmittance: self.transmittance,
                least,
            });
        }
        Ok(())
    }

    /// The realizable Mueller matrix nearest to this one in the Frobenius norm: negative eigenvalues become 0.
    ///
    /// `M00` grows by what is clipped. Passivity is not asked for; see [`Mueller::is_passive`].
    #[must_use]
    pub fn nearest_realizable(&self) -> Mueller {
        self.with_eigenvalues(self.eigenvalues.map(|value| value.max(0.0)))
    }

    /// The realizable Mueller matrix of the same `M00` that is nearest in the Frobenius norm: all eigenvalues are lowered
    /// by one amount, those that would become negative are 0.
    ///
    /// # Errors
    ///
    /// When `M00` is not positive.
    pub fn nearest_realizable_of_same_transmittance(&self) -> Result<Mueller, NotRealizable> {
        let transmittance = self.transmittance;
        if transmittance <= 0.0 {
            return Err(NotRealizable::NoTransmittance { transmittance });
        }
        // the number of positive ones is the largest n whose n-th stays positive when the first n give up the excess
        let (mut sum, mut shift) = (0.0, 0.0);
        for (i, value) in self.eigenvalues.iter().enumerate() {
            sum += value;
            let excess = (sum - transmittance) / (i + 1) as f64;
            if value - excess > 0.0 {
                shift = excess;
            }
        }
        Ok(self.with_eigenvalues(self.eigenvalues.map(|value| (value - shift).max(0.0))))
    }

    fn with_eigenvalues(&self, eigenvalues: [f64; 4]) -> Mueller {
        let matrix = eigenvalues
            .into_iter()
            .zip(&self.vectors)
            .map(|(value, vector)| vector * vector.adjoint() * Complex64::from(2.0 * value))
            .fold(Matrix4::zeros(), |sum, term| sum + term);
        TransferTensor::from(matrix)
            .generalized_mueller()
            .real_part()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jones::JonesMatrix;
    use nalgebra::Vector4;
    use proptest::prelude::*;

    fn diagonal(d: [f64; 4]) -> Mueller {
        Mueller::from(Matrix4::from_diagonal(&Vector4::from(d)))
    }

    #[test]
    fn a_mirror_of_the_sphere_is_refused_with_its_eigenvalue() {
        // diag(1, 1, 1, −1): λ = ½, ½, ½, −½
        let spectrum = CloudeSpectrum::of(&diagonal([1.0, 1.0, 1.0, -1.0])).unwrap();
        let error = spectrum.jones_matrices(1e-9).unwrap_err();
        let NotRealizable::NegativeEigenvalue {
            index, eigenvalue, ..
        } = error
        else {
            panic!("{error}");
        };
        assert!(index == 3 && (eigenvalue + 0.5).abs() < 1e-15);
        assert!(spectrum.entropy(1e-9).is_err());
        // of the same M00 and nearest: eigenvalues ⅓, ⅓, ⅓, 0, that is diag(1, ⅓, ⅓, −⅓)
        let nearest = spectrum
            .nearest_realizable_of_same_transmittance()
            .unwrap()
            .to_matrix();
        let expected = diagonal([1.0, 1.0 / 3.0, 1.0 / 3.0, -1.0 / 3.0]).to_matrix();
        assert!((nearest - expected).amax() < 1e-15);
        // and without that condition three halves: diag(1.5, ½, ½, −½)
        let nearest = spectrum.nearest_realizable().to_matrix();
        assert!((nearest - diagonal([1.5, 0.5, 0.5, -0.5]).to_matrix()).amax() < 1e-15);
    }

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || prop_oneof![4 => -1.0..1.0f64, 1 => -1e-9..1e-9f64, 1 => Just(0.0)];
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        prop::array::uniform4(complex()).prop_map(|[a, b, c, d]| JonesMatrix::new(a, b, c, d))
    }

    proptest! {
        #[test]
        fn the_nearest_realizable_matrix_is_realizable_and_no_other_is_nearer(
            elements in prop::array::uniform16(-1.0..1.0f64), others in prop::collection::vec(matrix(), 4),
        ) {
            let mueller = Matrix4::from_column_slice(&elements);
            let spectrum = CloudeSpectrum::of(&Mueller::from(mueller)).unwrap();
            let nearest = spectrum.nearest_realizable();
            prop_assert!(CloudeSpectrum::of(&nearest).unwrap().check_realizable(1e-14).is_ok());
            // the cone of realizable matrices is convex: the error is at a right angle to the nearest one and at an
            // obtuse one to every other
            let error = mueller - nearest.to_matrix();
            prop_assert!(error.dot(&nearest.to_matrix()).abs() < 1e-13);
            for other in others {
                prop_assert!(error.dot(&other.mueller().to_matrix()) < 1e-13);
            }
            if mueller[(0, 0)] > 0.0 {
                let same = spectrum.nearest_realizable_of_same_transmittance().unwrap();
                prop_assert!((same.element(0, 0) - mueller[(0, 0)]).abs() < 1e-14);
                prop_assert!(CloudeSpectrum::of(&same).unwrap().check_realizable(1e-14).is_ok());
                let farther = (same.to_matrix() - mueller).norm();
                prop_assert!(farther >= error.norm() - 1e-14);
            }
        }
    }
}
