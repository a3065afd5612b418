//! Plates, polarizers, retarders and depolarizers as populations: one response, the same everywhere.
//!
//! Their autocorrelation is constant, so that they pass the light on as it came, with other polarization: the theorem's
//! image of the source. Frames are those of a ray that goes straight through; `angle` is that of the first axis,
//! counter-clockwise for a receiver who faces the source, radians.

use csdm::JonesMatrix;
use stokes::{Envelope, Mueller};

use crate::autocorrelation::Autocorrelation;
use crate::population::{MatterError, Population};

impl Population {
    /// A plate of any Jones matrix, such as one side of [`csdm::birefringent::PlateJones`] between equal media.
    #[must_use]
    pub fn uniform(jones: &JonesMatrix, envelope: Envelope) -> Self {
        Self::of_jones(jones, Autocorrelation::constant(1.0), envelope)
    }

    /// An ideal polarizer that passes light along `angle`.
    ///
    /// Malus's law, from two of them:
    /// ```
    /// use mueller16::{Matter, Population};
    /// use nalgebra::Matrix2;
    /// let opening = stokes::Envelope::gaussian(&Matrix2::from_diagonal_element(1e-6))?;
    /// let at = |angle: f64| Matter::new(vec![Population::polarizer(angle, opening.clone())]).map(|m| m.channels().mueller());
    /// let out = at(1.0)? * (at(0.0)? * stokes::StokesVector::UNPOLARIZED);
    /// assert!((out.s0() - 0.5 * 1f64.cos().powi(2)).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn polarizer(angle: f64, envelope: Envelope) -> Self {
        Self::uniform(&JonesMatrix::linear_polarizer().rotated(angle), envelope)
    }

    /// A linear retarder, fast along `angle`; `retardance` in radians.
    #[must_use]
    pub fn retarder(retardance: f64, angle: f64, envelope: Envelope) -> Self {
        Self::uniform(
            &JonesMatrix::linear_retarder(retardance).rotated(angle),
            envelope,
        )
    }

    /// An ideal depolarizer that passes the fraction `transmittance` of the intensity.
    ///
    /// # Errors
    ///
    /// When the transmittance is negative or not a number.
    pub fn depolarizer(transmittance: f64, envelope: Envelope) -> Result<Self, MatterError> {
        let mueller = Mueller::depolarizer(transmittance);
        Self::of_mueller(&mueller, Autocorrelation::constant(1.0), envelope)
    }

    /// A grey filter that passes the fraction `transmittance` of every light.
    ///
    /// # Errors
    ///
    /// When the transmittance is negative or not a number.
    pub fn absorber(transmittance: f64, envelope: Envelope) -> Result<Self, MatterError> {
        let mueller = Mueller::identity() * transmittance;
        Self::of_mueller(&mueller, Autocorrelation::constant(1.0), envelope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::population::Matter;
    use nalgebra::Matrix2;
    use stokes::StokesVector;

    fn through(population: Population, light: StokesVector) -> StokesVector {
        Matter::new(vec![population]).unwrap().channels().mueller() * light
    }

    fn opening() -> Envelope {
        Envelope::gaussian(&Matrix2::from_diagonal_element(1e-6)).unwrap()
    }

    #[test]
    fn a_quarter_wave_plate_at_45_degrees_makes_right_circular_light_of_horizontal() {
        // fast at +45°, light along −45° to the fast axis: the opposite hand of light along +45° to it, which is left
        let plate = Population::retarder(
            std::f64::consts::FRAC_PI_2,
            std::f64::consts::FRAC_PI_4,
            opening(),
        );
        let out = through(plate, StokesVector::HORIZONTAL);
        assert!((out - StokesVector::RIGHT_CIRCULAR).to_vector().norm() < 1e-15);
    }

    #[test]
    fn a_depolarizer_leaves_intensity_alone() {
        let out = through(
            Population::depolarizer(0.7, opening()).unwrap(),
            StokesVector::DIAGONAL,
        );
        assert!((out - StokesVector::UNPOLARIZED * 0.7).to_vector().norm() < 1e-15);
        let grey = through(
            Population::absorber(0.25, opening()).unwrap(),
            StokesVector::DIAGONAL,
        );
        assert!((grey - StokesVector::DIAGONAL * 0.25).to_vector().norm() < 1e-15);
    }

    #[test]
    fn negative_transmittances_are_no_matter() {
        assert!(Population::depolarizer(-0.1, opening()).is_err());
        assert!(Population::absorber(-0.1, opening()).is_err());
        assert!(Population::absorber(f64::NAN, opening()).is_err());
    }
}
