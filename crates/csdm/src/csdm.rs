//! The cross-spectral density matrix: how the field at one point goes with the field at another.

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{FrameRotation, GeneralizedStokes, StokesVector};

use crate::positivity::CoherenceError;

/// Cross-spectral density matrix of a pair of points across a ray: 2×2, complex, unit of `|E|²`.
///
/// ```text
/// C(r₁, r₂) = ⟨E(r₁) E(r₂)†⟩ = ½ Σ C_j σ_j,      C_j = tr(σ_j C),      E in exp(+iωt)
/// ```
///
/// The `C_j(r₁, r₂)` are the generalized Stokes parameters of the two points. [`GeneralizedStokes`] writes the spatial
/// phase of a forward wave as `e^{+ikr}`, fields in `exp(+iωt)` as `e^{−ikr}`: its parameters at `ξ₁ − ξ₂` belong to
/// this matrix with the points exchanged. [`CrossSpectralDensity::of_light`] does that exchange, and nobody else has
/// to. At one point, and wherever the parameters are real, there is nothing to exchange.
///
/// Written in a transverse frame that the caller keeps.
///
/// Source: Eqs. (S4.1) to (S4.6) of the supplemental of Steinberg & Yan 2021.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossSpectralDensity(pub(crate) Matrix2<Complex64>);

impl CrossSpectralDensity {
    /// The matrix `⟨E(r₁) E(r₂)†⟩` with these elements.
    ///
    /// # Errors
    ///
    /// When an element is infinite or not a number.
    pub fn new(matrix: Matrix2<Complex64>) -> Result<Self, CoherenceError> {
        for row in 0..2 {
            for column in 0..2 {
                let value = matrix[(row, column)];
                if !(value.re.is_finite() && value.im.is_finite()) {
                    return Err(CoherenceError::NotFinite { row, column, value });
                }
            }
        }
        Ok(Self(matrix))
    }

    /// The matrix `½ Σ C_j σ_j` of generalized Stokes parameters `C_j(r₁, r₂) = tr(σ_j ⟨E(r₁) E(r₂)†⟩)`.
    ///
    /// Source: Eqs. (S4.5), (S4.6).
    ///
    /// # Errors
    ///
    /// When a parameter is infinite or not a number.
    pub fn from_generalized_stokes(parameters: [Complex64; 4]) -> Result<Self, CoherenceError> {
        let [c0, c1, c2, c3] = parameters.map(|c| 0.5 * c);
        let i_c3 = Complex64::new(-c3.im, c3.re);
        Self::new(Matrix2::new(c0 + c1, c2 - i_c3, c2 + i_c3, c0 - c1))
    }

    /// The matrix of two points that share the light `stokes`: fully coherent between them, as in a plane wave.
    ///
    /// # Errors
    ///
    /// When a parameter is infinite or not a number.
    pub fn from_stokes(stokes: StokesVector) -> Result<Self, CoherenceError> {
        Self::from_generalized_stokes(stokes.to_array().map(Complex64::from))
    }

    /// The matrix of `light` at two points with `r₁ − r₂ = separation` metres, in the axes of the light's frame.
    ///
    /// Takes the light at `−separation`: its phases are the conjugates of those of the fields, see above.
    ///
    /// # Errors
    ///
    /// When the light is too strong for a finite number.
    pub fn of_light(
        light: &GeneralizedStokes,
        separation: &Vector2<f64>,
    ) -> Result<Self, CoherenceError> {
        Self::from_generalized_stokes(light.at_separation(&-separation))
    }

    /// The matrix of one realization of the field: `E(r₁) E(r₂)†`.
    #[must_use]
    pub fn of_fields(first: Vector2<Complex64>, second: Vector2<Complex64>) -> Self {
        Self(first * second.adjoint())
    }

    /// The generalized Stokes parameters `C_j(r₁, r₂) = tr(σ_j C)`: complex for two points, real for one.
    ///
    /// Source: Eq. (S4.6).
    ///
    /// ```
    /// use num_complex::Complex64;
    /// let parameters = [2.0, 0.5, -0.25, 1.0].map(|c| Complex64::new(c, 0.125 * c));
    /// let matrix = csdm::CrossSpectralDensity::from_generalized_stokes(parameters)?;
    /// assert_eq!(matrix.generalized_stokes(), parameters);
    /// # Ok::<(), csdm::CoherenceError>(())
    /// ```
    #[must_use]
    pub fn generalized_stokes(&self) -> [Complex64; 4] {
        let m = &self.0;
        let cross = m[(0, 1)] - m[(1, 0)];
        [
            m[(0, 0)] + m[(1, 1)],
            m[(0, 0)] - m[(1, 1)],
            m[(0, 1)] + m[(1, 0)],
            Complex64::new(-cross.im, cross.re),
        ]
    }

    /// The matrix as nalgebra holds it.
    #[must_use]
    pub fn to_matrix(self) -> Matrix2<Complex64> {
        self.0
    }

    /// The matrix of the same two points in the other order, `C(r₂, r₁) = C(r₁, r₂)†`.
    #[must_use]
    pub fn exchanged(&self) -> Self {
        Self(self.0.adjoint())
    }

    /// The incoherent superposition of two lights at the same points.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self(self.0 + other.0)
    }

    /// The same light written in a frame turned by `rotation` (the two points stay where they are).
    #[must_use]
    pub fn in_turned_frame(&self, rotation: FrameRotation) -> Self {
        let FrameRotation { cos2, sin2 } = rotation;
        let [c0, c1, c2, c3] = self.generalized_stokes().map(|c| 0.5 * c);
        let (c1, c2) = (c1 * cos2 + c2 * sin2, c2 * cos2 - c1 * sin2);
        let i_c3 = Complex64::new(-c3.im, c3.re);
        Self(Matrix2::new(c0 + c1, c2 - i_c3, c2 + i_c3, c0 - c1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jones::{JonesMatrix, pauli};
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use stokes::{Components, Frame, HermiteSeries, ShapeMatrix, Wavelength};

    fn complex() -> impl Strategy<Value = Complex64> {
        let number = || prop_oneof![4 => -2.0..2.0f64, 1 => -1e-9..1e-9f64, 1 => Just(0.0)];
        (number(), number()).prop_map(|(re, im)| Complex64::new(re, im))
    }

    #[test]
    fn one_field_has_the_stokes_vector_that_its_jones_vector_has() {
        let field = Vector2::new(Complex64::new(0.3, -0.8), Complex64::new(1.1, 0.4));
        let csd = CrossSpectralDensity::of_fields(field, field);
        let difference = csd.stokes().unwrap() - crate::stokes_vector(field);
        assert!(difference.to_vector().norm() < 1e-15);
    }

    #[test]
    fn a_matrix_of_infinite_elements_is_refused_with_its_place() {
        let mut matrix = Matrix2::zeros();
        matrix[(1, 0)] = Complex64::new(f64::NAN, 0.0);
        let error = CrossSpectralDensity::new(matrix).unwrap_err().to_string();
        assert!(error.starts_with("cross-spectral density: element (1, 0) is NaN"));
    }

    /// Light from a source beside the axis: two modes, the odd one imaginary, C3 with another mix than C0.
    fn skew_light() -> GeneralizedStokes {
        let modes = |c00: f64, c10: f64| {
            Some(
                HermiteSeries::from_modes(&[
                    (0, 0, Complex64::from(c00)),
                    (1, 0, Complex64::new(0.0, c10)),
                ])
                .unwrap(),
            )
        };
        GeneralizedStokes::new(
            Components::Separate([modes(1.0, 0.4), modes(0.2, 0.1), None, modes(-0.3, 0.2)]),
            ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3)).unwrap(),
            Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
            Wavelength::from_metres(500e-9).unwrap(),
            2.0,
        )
        .unwrap()
    }

    #[test]
    fn light_from_one_side_has_the_phase_of_a_wave_from_there() {
        // exp(+ikr) of the light: positive odd modes i·h₁ grow the phase along +x, that is k_x > 0, and a field in
        // exp(+iωt) with k_x > 0 is e^{−i k_x x}: ⟨E(x₁) E*(x₂)⟩ has the phase −k_x (x₁ − x₂)
        let separation = Vector2::new(1e-5, 0.0);
        let light = skew_light();
        assert!(light.at_separation(&separation)[0].im > 0.0);
        let csd = CrossSpectralDensity::of_light(&light, &separation).unwrap();
        assert!(csd.to_matrix().trace().im < 0.0);
        // and its polarization is not conjugated with it: S3 = −2 Im C_xy at one point
        let here = CrossSpectralDensity::of_light(&light, &Vector2::zeros()).unwrap();
        let s3 = light.stokes().stokes.s3();
        assert!(s3 < 0.0);
        assert!((-2.0 * here.to_matrix()[(0, 1)].im / s3 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn exchanging_the_points_is_going_to_the_opposite_separation() {
        let (light, separation) = (skew_light(), Vector2::new(2e-4, -1e-4));
        let there = CrossSpectralDensity::of_light(&light, &separation).unwrap();
        let back = CrossSpectralDensity::of_light(&light, &-separation).unwrap();
        let difference = there.exchanged().to_matrix() - back.to_matrix();
        assert!(difference.norm() < 1e-15 * there.to_matrix().norm());
    }

    proptest! {
        #[test]
        fn parameters_are_traces_with_pauli_matrices(elements in prop::array::uniform4(complex())) {
            let [a, b, c, d] = elements;
            let csd = CrossSpectralDensity::new(Matrix2::new(a, b, c, d)).unwrap();
            let parameters = csd.generalized_stokes();
            for (parameter, sigma) in parameters.iter().zip(pauli()) {
                prop_assert!((parameter - (sigma * csd.to_matrix()).trace()).norm() < 1e-15);
            }
            let back = CrossSpectralDensity::from_generalized_stokes(parameters).unwrap();
            prop_assert!((back.to_matrix() - csd.to_matrix()).norm() < 2e-15);
        }

        #[test]
        fn a_turned_frame_is_a_rotated_field(
            first in (complex(), complex()), second in (complex(), complex()), angle in -4.0..4.0f64,
        ) {
            // components in axes turned by +t are those of the field turned by −t
            let (e1, e2) = (Vector2::new(first.0, first.1), Vector2::new(second.0, second.1));
            let back = JonesMatrix::rotator(-angle);
            let by_fields = CrossSpectralDensity::of_fields(back.apply(e1), back.apply(e2));
            let turned = CrossSpectralDensity::of_fields(e1, e2)
                .in_turned_frame(FrameRotation::from_angle(angle));
            prop_assert!((turned.to_matrix() - by_fields.to_matrix()).norm() < 1e-14);
        }
    }
}
