//! The elements that have a name: polarizers, retarders and partial polarizers of any eigenpolarization.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use thiserror::Error;

use crate::jones::{JonesMatrix, pauli};

const ONE: Complex64 = Complex64::new(1.0, 0.0);

/// Sine of the angle between two eigenpolarizations below which they count as one.
const LEAST_SINE: f64 = 1e-12;

/// Why an element cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ElementError {
    /// An amplitude transmittance of a passive element is out of range.
    #[error("partial polarizer: amplitude transmittance {value}, expected 0 to 1")]
    Transmittance {
        /// What was found.
        value: f64,
    },
    /// An eigenpolarization has no direction.
    #[error("eigenpolarization: the field ({x}, {y}) is zero or not finite")]
    NoField {
        /// Amplitude along `x`.
        x: Complex64,
        /// Amplitude along `y`.
        y: Complex64,
    },
    /// Two eigenpolarizations coincide.
    #[error(
        "eigenpolarizations: the sine of the angle between the two fields is {sine}, expected more than 1e-12: no \
         element has only one"
    )]
    OneEigenpolarization {
        /// `|E₁ × E₂|/(|E₁||E₂|)`.
        sine: f64,
    },
}

impl JonesMatrix {
    /// Partial polarizer: real amplitude transmittances along the axes `x` and `y`, each in `0.0..=1.0`.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    ///
    /// # Errors
    ///
    /// When a transmittance is out of range.
    ///
    /// ```
    /// // amplitude 0.6 along y passes 0.36 of that power: (1 + 0.36)/2 of unpolarized light
    /// let out = csdm::JonesMatrix::partial_polarizer(1.0, 0.6)?.mueller() * stokes::StokesVector::UNPOLARIZED;
    /// assert!((out.s0() - 0.68).abs() < 1e-15 && (out.s1() - 0.32).abs() < 1e-15);
    /// # Ok::<(), csdm::ElementError>(())
    /// ```
    #[doc(alias = "diattenuator_linear")]
    pub fn partial_polarizer(x: f64, y: f64) -> Result<Self, ElementError> {
        for value in [x, y] {
            if !(0.0..=1.0).contains(&value) {
                return Err(ElementError::Transmittance { value });
            }
        }
        Ok(Self::diagonal(x.into(), y.into()))
    }

    /// Quarter-wave plate with its fast axis along `x`: `diag(1, −i)`.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    #[must_use]
    #[doc(alias = "quarter_waveplate")]
    pub fn quarter_wave_plate() -> Self {
        Self::diagonal(ONE, Complex64::new(0.0, -1.0))
    }

    /// Half-wave plate with its fast axis along `x`: `diag(1, −1)`.
    ///
    /// Source: Jones 1941, A new calculus for the treatment of optical systems I, J. Opt. Soc. Am. 31, 488.
    #[must_use]
    #[doc(alias = "half_waveplate")]
    pub fn half_wave_plate() -> Self {
        Self::diagonal(ONE, -ONE)
    }

    /// Circular retarder whose fast eigenpolarization is right circular light; `retardance` δ in radians.
    ///
    /// Turns the plane of linear light by `−δ/2`, that is, clockwise for the receiver when δ > 0.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    /// let out = csdm::JonesMatrix::circular_retarder(FRAC_PI_2).mueller() * stokes::StokesVector::HORIZONTAL;
    /// assert!((out - stokes::StokesVector::ANTIDIAGONAL).to_vector().norm() < 1e-15);
    /// ```
    #[must_use]
    pub fn circular_retarder(retardance: f64) -> Self {
        Self::rotator(-0.5 * retardance).scaled(Complex64::cis(-0.5 * retardance))
    }

    /// Element with orthogonal eigenpolarizations: light of the given ellipse is multiplied by `first`, light of the
    /// opposite one by `second`.
    ///
    /// The ellipse has `azimuth` ψ (radians from `x`, counter-clockwise for a receiver who faces the source) and
    /// `ellipticity` χ (radians, in `-π/4..=π/4`, positive for right-handed light), as
    /// [`stokes::PolarizationEllipse`] reports them:
    ///
    /// ```text
    /// f = (cos 2χ cos 2ψ, cos 2χ sin 2ψ, sin 2χ)
    /// T = t₁ P(f) + t₂ P(−f),     P(f) = ½ (1 + f·σ)
    /// ```
    ///
    /// Every normal Jones matrix is one of these: polarizers, retarders, and both at once.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_4;
    /// let element = csdm::JonesMatrix::homogeneous(0.0, FRAC_PI_4, 1.0.into(), 0.0.into());
    /// let polarizer = csdm::JonesMatrix::right_circular_polarizer();
    /// assert!((element.to_matrix() - polarizer.to_matrix()).norm() < 1e-15);
    /// ```
    #[must_use]
    pub fn homogeneous(
        azimuth: f64,
        ellipticity: f64,
        first: Complex64,
        second: Complex64,
    ) -> Self {
        let (sin_psi, cos_psi) = (2.0 * azimuth).sin_cos();
        let (sin_chi, cos_chi) = (2.0 * ellipticity).sin_cos();
        let [identity, s1, s2, s3] = pauli();
        let (f1, f2, f3) = (cos_chi * cos_psi, cos_chi * sin_psi, sin_chi);
        let along_f =
            s1 * Complex64::from(f1) + s2 * Complex64::from(f2) + s3 * Complex64::from(f3);
        Self::from(identity * (0.5 * (first + second)) + along_f * (0.5 * (first - second)))
    }

    /// Ideal polarizer that passes light of the given ellipse; angles as in [`JonesMatrix::homogeneous`], in radians.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    #[must_use]
    #[doc(alias = "diattenuator_azimuth_ellipticity")]
    pub fn elliptical_polarizer(azimuth: f64, ellipticity: f64) -> Self {
        Self::homogeneous(azimuth, ellipticity, ONE, Complex64::from(0.0))
    }

    /// Retarder whose fast eigenpolarization has the given ellipse: amplitude 1 there, `e^{−iδ}` for the opposite
    /// one; all three in radians, angles as in [`JonesMatrix::homogeneous`].
    ///
    /// Its Mueller matrix turns the Poincaré sphere by `−retardance` about the fast eigenpolarization.
    ///
    /// Source: Chipman, Lam & Young, Polarized Light and Optical Systems (2018), chapter 5.
    #[must_use]
    #[doc(alias = "retarder_azimuth_ellipticity")]
    pub fn elliptical_retarder(azimuth: f64, ellipticity: f64, retardance: f64) -> Self {
        Self::homogeneous(azimuth, ellipticity, ONE, Complex64::cis(-retardance))
    }

    /// Element with any two eigenpolarizations, orthogonal or not: field `first_field` is multiplied by `first`, field
    /// `second_field` by `second`. The fields' lengths and phases do not matter.
    ///
    /// Relative error of a few `f64::EPSILON` over the sine of the angle between the fields.
    ///
    /// Source: Lu & Chipman 1994, Homogeneous and inhomogeneous Jones matrices, J. Opt. Soc. Am. A 11, 766.
    ///
    /// # Errors
    ///
    /// When a field is zero or not finite, or the two are the same up to a factor.
    #[doc(alias = "general_eigenstates")]
    pub fn from_eigenpolarizations(
        first_field: Vector2<Complex64>,
        first: Complex64,
        second_field: Vector2<Complex64>,
        second: Complex64,
    ) -> Result<Self, ElementError> {
        let [e1, e2] = [unit(first_field)?, unit(second_field)?];
        let cross = e1.x * e2.y - e1.y * e2.x;
        let sine = cross.norm();
        if sine <= LEAST_SINE {
            return Err(ElementError::OneEigenpolarization { sine });
        }
        // rows of the inverse of [e1 e2] are the dual fields
        let (dual1, dual2) = (
            nalgebra::RowVector2::new(e2.y, -e2.x) / cross,
            nalgebra::RowVector2::new(-e1.y, e1.x) / cross,
        );
        let matrix: Matrix2<Complex64> = e1 * dual1 * first + e2 * dual2 * second;
        Ok(Self::from(matrix))
    }
}

/// The field over its length, without overflow.
fn unit(field: Vector2<Complex64>) -> Result<Vector2<Complex64>, ElementError> {
    let largest = field.x.norm().max(field.y.norm());
    let finite = field.iter().all(|e| e.re.is_finite() && e.im.is_finite());
    if !finite || largest < f64::MIN_POSITIVE {
        return Err(ElementError::NoField {
            x: field.x,
            y: field.y,
        });
    }
    let scaled = field.map(|e| e / largest);
    Ok(scaled.map(|e| e / scaled.norm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stokes_vector;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    use stokes::StokesVector;

    fn close(a: JonesMatrix, b: JonesMatrix, tolerance: f64) -> bool {
        (a.to_matrix() - b.to_matrix()).norm() < tolerance
    }

    fn near(a: StokesVector, b: StokesVector) -> bool {
        (a - b).to_vector().norm() < 4e-15
    }

    #[test]
    fn two_polarizers_obey_malus_as_jones_matrices() {
        for degrees in (0..=180).step_by(15) {
            let angle = f64::from(degrees).to_radians();
            let second = JonesMatrix::linear_polarizer().rotated(angle);
            let pair = (second * JonesMatrix::linear_polarizer()).mueller();
            let out = pair * StokesVector::UNPOLARIZED;
            assert!((out.s0() - 0.5 * angle.cos().powi(2)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_quarter_wave_plate_makes_circular_light_and_two_make_a_half_wave_plate() {
        let plate = JonesMatrix::quarter_wave_plate();
        assert!(close(plate, JonesMatrix::linear_retarder(FRAC_PI_2), 1e-15));
        assert!(close(plate * plate, JonesMatrix::half_wave_plate(), 1e-15));
        // fast axis at +45°: horizontal light, 45° clockwise of it, becomes right circular
        let turned = plate.rotated(FRAC_PI_4).mueller();
        assert!(near(
            turned * StokesVector::HORIZONTAL,
            StokesVector::RIGHT_CIRCULAR
        ));
        let half = JonesMatrix::half_wave_plate().mueller();
        assert!(near(
            half * StokesVector::RIGHT_CIRCULAR,
            StokesVector::LEFT_CIRCULAR
        ));
    }

    #[test]
    fn right_circular_light_is_ahead_in_a_circular_retarder() {
        // the slow light lags: e^{−iδ} on the left circular field (1, −i)/√2, nothing on (1, i)/√2
        let plate = JonesMatrix::circular_retarder(0.7);
        let i = Complex64::new(0.0, 1.0);
        let (right, left) = (Vector2::new(ONE, i), Vector2::new(ONE, -i));
        assert!((plate.apply(right) - right).norm() < 1e-15);
        assert!((plate.apply(left) - left * Complex64::cis(-0.7)).norm() < 1e-15);
        assert!(close(
            plate,
            JonesMatrix::elliptical_retarder(0.3, FRAC_PI_4, 0.7),
            1e-15
        ));
    }

    #[test]
    fn a_retarder_turns_the_sphere_backwards_about_its_fast_eigenpolarization() {
        // fast +45° light (S2), δ = 90°: −90° about S2 takes S1 to S3
        let plate = JonesMatrix::elliptical_retarder(FRAC_PI_4, 0.0, FRAC_PI_2).mueller();
        assert!(near(
            plate * StokesVector::HORIZONTAL,
            StokesVector::RIGHT_CIRCULAR
        ));
    }

    #[test]
    fn bad_elements_are_refused_with_their_numbers() {
        let error = JonesMatrix::partial_polarizer(0.5, 1.5).unwrap_err();
        assert_eq!(
            error.to_string(),
            "partial polarizer: amplitude transmittance 1.5, expected 0 to 1"
        );
        assert!(JonesMatrix::partial_polarizer(f64::NAN, 0.5).is_err());
        let x = Vector2::new(ONE, Complex64::from(0.0));
        let also_x = x * Complex64::new(0.0, -3.0);
        assert_eq!(
            JonesMatrix::from_eigenpolarizations(x, ONE, also_x, ONE),
            Err(ElementError::OneEigenpolarization { sine: 0.0 })
        );
        let none = Vector2::new(Complex64::from(0.0), Complex64::from(0.0));
        assert!(JonesMatrix::from_eigenpolarizations(x, ONE, none, ONE).is_err());
    }

    fn complex() -> impl Strategy<Value = Complex64> {
        (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(re, im)| Complex64::new(re, im))
    }

    proptest! {
        #[test]
        fn an_elliptical_polarizer_passes_its_ellipse_and_stops_the_opposite(
            azimuth in 0.0..PI, ellipticity in -FRAC_PI_4..FRAC_PI_4,
        ) {
            let mueller = JonesMatrix::elliptical_polarizer(azimuth, ellipticity).mueller();
            let out = mueller * StokesVector::UNPOLARIZED;
            let ellipse = out.ellipse();
            prop_assert!((ellipse.ellipticity - ellipticity).abs() < 1e-14);
            if ellipticity.abs() < FRAC_PI_4 - 1e-3 {
                let turn = 2.0 * (ellipse.orientation - azimuth);
                prop_assert!(turn.sin().abs() < 1e-12 && turn.cos() > 0.0);
            }
            let [_, s1, s2, s3] = (out * 2.0).to_array();
            prop_assert!((mueller * StokesVector::new(1.0, -s1, -s2, -s3)).to_vector().norm() < 1e-15);
        }

        #[test]
        fn eigenpolarizations_come_out_multiplied(
            fields in prop::array::uniform4(complex()), t1 in complex(), t2 in complex(),
        ) {
            let e1 = Vector2::new(fields[0], fields[1]);
            let e2 = Vector2::new(fields[2], fields[3]);
            let sine = (e1.x * e2.y - e1.y * e2.x).norm() / (e1.norm() * e2.norm());
            prop_assume!(sine > 1e-3);
            let element = JonesMatrix::from_eigenpolarizations(e1, t1, e2, t2).unwrap();
            prop_assert!((element.apply(e1) - e1 * t1).norm() < 1e-14 / sine);
            prop_assert!((element.apply(e2) - e2 * t2).norm() < 1e-14 / sine);
        }

        #[test]
        fn a_homogeneous_element_is_one_with_orthogonal_eigenpolarizations(
            x in complex(), y in complex(), t1 in complex(), t2 in complex(),
        ) {
            let field = Vector2::new(x, y);
            prop_assume!(field.norm() > 1e-3);
            let across = Vector2::new(-y.conj(), x.conj());
            let ellipse = stokes_vector(field).ellipse();
            let by_angles = JonesMatrix::homogeneous(ellipse.orientation, ellipse.ellipticity, t1, t2);
            let by_fields = JonesMatrix::from_eigenpolarizations(field, t1, across, t2).unwrap();
            prop_assert!(close(by_angles, by_fields, 1e-14));
        }
    }
}
