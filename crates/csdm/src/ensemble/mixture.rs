//! Elements made of elements: mixtures, sequences, turned ones.

use nalgebra::{Rotation2, Vector2};
use stokes::{FrameRotation, Mueller};
use thiserror::Error;

use super::Element;
use crate::decompose::{CloudeSpectrum, NotRealizable};
use crate::jones::JonesMatrix;
use crate::sixteen::{GeneralizedMueller, TransferTensor};

/// Largest deviation of the sum of probabilities from 1.
const WEIGHT_SUM: f64 = 1e-12;

/// Why weights are no probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BadWeights {
    /// A weight is negative or not finite.
    #[error("mixture: weight {index} is {weight}, expected a finite number that is not negative")]
    Negative {
        /// Which, from 0.
        index: usize,
        /// What was found.
        weight: f64,
    },
    /// The weights do not add up.
    #[error("mixture: the {count} weights add up to {sum}, expected 1 (to 1e-12)")]
    Sum {
        /// How many there are.
        count: usize,
        /// Their sum.
        sum: f64,
    },
}

/// An ensemble of elements: each realization of the light meets one of them, with its probability, over the whole
/// aperture.
///
/// ```
/// use csdm::{Element, JonesMatrix, Mixture};
/// // a polarizer along x in half of the realizations, along y in the others: unpolarized light stays so
/// let x = JonesMatrix::linear_polarizer();
/// let mixture = Mixture::new(vec![(0.5, x), (0.5, x.rotated(std::f64::consts::FRAC_PI_2))])?;
/// let mueller = mixture.mueller_at(&nalgebra::Vector2::zeros());
/// assert!((mueller * stokes::StokesVector::UNPOLARIZED).degree_of_polarization() < 1e-15);
/// # Ok::<(), csdm::BadWeights>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture<T> {
    elements: Vec<(f64, T)>,
}

impl<T: Element> Mixture<T> {
    /// The mixture of these elements with these probabilities.
    ///
    /// # Errors
    ///
    /// When a weight is negative or not finite, or they do not add up to 1.
    pub fn new(elements: Vec<(f64, T)>) -> Result<Self, BadWeights> {
        for (index, (weight, _)) in elements.iter().enumerate() {
            if !(weight.is_finite() && *weight >= 0.0) {
                return Err(BadWeights::Negative {
                    index,
                    weight: *weight,
                });
            }
        }
        let sum: f64 = elements.iter().map(|(weight, _)| weight).sum();
        if (sum - 1.0).abs() > WEIGHT_SUM {
            return Err(BadWeights::Sum {
                count: elements.len(),
                sum,
            });
        }
        Ok(Self { elements })
    }

    /// The elements with their probabilities.
    #[must_use]
    pub fn elements(&self) -> &[(f64, T)] {
        &self.elements
    }
}

impl Mixture<JonesMatrix> {
    /// At most four Jones matrices that together have this Mueller matrix; see [`CloudeSpectrum::jones_matrices`].
    ///
    /// # Errors
    ///
    /// When the matrix is not finite, or an eigenvalue of its coherency matrix is below `−tolerance` times the largest.
    pub fn of_mueller(mueller: &Mueller, tolerance: f64) -> Result<Self, NotRealizable> {
        let parts = CloudeSpectrum::of(mueller)?.jones_matrices(tolerance)?;
        let elements = parts.into_iter().map(|part| (part.weight, part.jones));
        Ok(Self {
            elements: elements.collect(),
        })
    }
}

impl<T: Element> Element for Mixture<T> {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let nothing = TransferTensor::from(nalgebra::Matrix4::zeros());
        self.elements
            .iter()
            .fold(nothing, |sum, (weight, element)| {
                sum.plus(*weight, &element.transfer(first, second))
            })
    }
}

/// Elements one behind the other, statistically independent of each other and close enough that nothing diffracts in
/// between; the first is met first. Interfaces between them do not reflect.
#[derive(Default)]
pub struct Sequence {
    elements: Vec<Box<dyn Element>>,
}

impl Sequence {
    /// Nothing in the way of the light yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The sequence with one more element behind it.
    #[must_use]
    pub fn then(mut self, element: impl Element + 'static) -> Self {
        self.elements.push(Box::new(element));
        self
    }
}

impl Element for Sequence {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        self.generalized_mueller(first, second).transfer()
    }

    fn generalized_mueller(
        &self,
        first: &Vector2<f64>,
        second: &Vector2<f64>,
    ) -> GeneralizedMueller {
        let nothing = GeneralizedMueller::from(Mueller::identity());
        self.elements.iter().fold(nothing, |so_far, element| {
            element.generalized_mueller(first, second) * so_far
        })
    }
}

/// An element turned about the ray by an angle, with its pattern; the frame stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned<T> {
    element: T,
    angle: f64,
}

impl<T: Element> Turned<T> {
    /// `element` turned by `angle` radians, counter-clockwise for a receiver who faces the source.
    #[must_use]
    pub fn new(element: T, angle: f64) -> Self {
        Self { element, angle }
    }
}

impl<T: Element> Element for Turned<T> {
    fn transfer(&self, first: &Vector2<f64>, second: &Vector2<f64>) -> TransferTensor {
        let back = Rotation2::new(-self.angle);
        let inner = self
            .element
            .generalized_mueller(&(back * first), &(back * second));
        let into = Mueller::rotation(FrameRotation::from_angle(self.angle));
        let out = Mueller::rotation(FrameRotation::from_angle(-self.angle));
        (GeneralizedMueller::from(out) * inner * GeneralizedMueller::from(into)).transfer()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::{GaussianAperture, PhaseScreen, Varying};
    use num_complex::Complex64;
    use proptest::prelude::*;
    use stokes::StokesVector;

    fn complex() -> impl Strategy<Value = Complex64> {
        (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(re, im)| Complex64::new(re, im))
    }

    fn matrix() -> impl Strategy<Value = JonesMatrix> {
        prop::array::uniform4(complex()).prop_map(|[a, b, c, d]| JonesMatrix::new(a, b, c, d))
    }

    fn here() -> Vector2<f64> {
        Vector2::zeros()
    }

    #[test]
    fn weights_that_are_no_probabilities_are_refused_with_their_numbers() {
        let plate = JonesMatrix::identity();
        let error = Mixture::new(vec![(0.5, plate), (0.6, plate)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "mixture: the 2 weights add up to 1.1, expected 1 (to 1e-12)"
        );
        let error = Mixture::new(vec![(1.5, plate), (-0.5, plate)]).unwrap_err();
        assert_eq!(
            error,
            BadWeights::Negative {
                index: 1,
                weight: -0.5
            }
        );
        assert!(Mixture::<JonesMatrix>::new(Vec::new()).is_err());
    }

    #[test]
    fn all_half_wave_plates_together_leave_only_circular_light() {
        // linear light is turned to all azimuths, S3 is reversed
        let plates = (0..8).map(|i| {
            let plate = JonesMatrix::half_wave_plate();
            (
                0.125,
                plate.rotated(std::f64::consts::PI * f64::from(i) / 8.0),
            )
        });
        let mueller = Mixture::new(plates.collect()).unwrap().mueller_at(&here());
        let out = mueller * StokesVector::linear(0.4);
        assert!((out - StokesVector::UNPOLARIZED).to_vector().norm() < 1e-15);
        let out = mueller * StokesVector::RIGHT_CIRCULAR;
        assert!((out - StokesVector::LEFT_CIRCULAR).to_vector().norm() < 1e-15);
    }

    #[test]
    fn independent_screens_in_sequence_add_their_variances() {
        let screen = |s: f64| PhaseScreen::independent([s, 0.5 * s], [2e-4, 2e-4]).unwrap();
        let sequence = Sequence::new().then(screen(0.6)).then(screen(0.8));
        let there = Vector2::new(1e-4, 5e-5);
        let difference = sequence.transfer(&here(), &there).to_matrix()
            - screen(1.0).transfer(&here(), &there).to_matrix();
        assert!(difference.camax() < 1e-15);
    }

    #[test]
    fn the_first_element_of_a_sequence_is_met_first() {
        let quarter = JonesMatrix::quarter_wave_plate().rotated(std::f64::consts::FRAC_PI_4);
        let sequence = Sequence::new()
            .then(JonesMatrix::linear_polarizer())
            .then(quarter);
        let out = sequence.mueller_at(&here()) * StokesVector::UNPOLARIZED;
        assert!(
            (out - StokesVector::RIGHT_CIRCULAR * 0.5)
                .to_vector()
                .norm()
                < 1e-15
        );
    }

    proptest! {
        #[test]
        fn a_turned_plate_is_a_rotated_jones_matrix(t in matrix(), angle in -4.0..4.0f64) {
            let turned = Turned::new(t, angle).transfer(&here(), &here()).to_matrix();
            let rotated = t.rotated(angle).transfer(&here(), &here()).to_matrix();
            prop_assert!((turned - rotated).camax() < 1e-14);
        }

        #[test]
        fn a_turned_pattern_turns_with_its_element(angle in -4.0..4.0f64, x in -1.0..1.0f64, y in -1.0..1.0f64) {
            let pattern = |r: &Vector2<f64>| JonesMatrix::diagonal(Complex64::cis(r.x), Complex64::cis(3.0 * r.y));
            let point = Vector2::new(x, y);
            let turned = Turned::new(Varying::new(pattern), angle).transfer(&point, &here());
            let back = Rotation2::new(-angle) * point;
            let by_hand = TransferTensor::of_jones(
                &pattern(&back).rotated(angle), &pattern(&here()).rotated(angle));
            prop_assert!((turned.to_matrix() - by_hand.to_matrix()).camax() < 1e-14);
        }

        #[test]
        fn any_mixture_is_its_four_jones_matrices(ts in prop::collection::vec(matrix(), 1..6)) {
            let weight = 1.0 / ts.len() as f64;
            let mixture = Mixture::new(ts.iter().map(|t| (weight, *t)).collect()).unwrap();
            let mueller = mixture.mueller_at(&here());
            let found = Mixture::of_mueller(&mueller, 1e-14).unwrap();
            prop_assert!(found.elements().len() <= 4);
            let difference = found.mueller_at(&here()).to_matrix() - mueller.to_matrix();
            prop_assert!(difference.amax() < 1e-13);
        }

        #[test]
        fn the_order_of_two_points_only_takes_the_adjoint(t in matrix(), x in -1.0..1.0f64, y in -1.0..1.0f64) {
            let screen = PhaseScreen::independent([0.7, 1.2], [0.5, 0.8]).unwrap();
            let aperture = GaussianAperture::new([0.7, 1.3]).unwrap();
            let sequence = Sequence::new().then(t).then(screen).then(aperture);
            let point = Vector2::new(x, y);
            let forth = sequence.transfer(&point, &here()).exchanged().to_matrix();
            prop_assert!((forth - sequence.transfer(&here(), &point).to_matrix()).camax() < 1e-14);
        }
    }
}
