//! The generalized Stokes vector in Hermite-Gauss space: light on one ray, with its polarization and coherence.

use nalgebra::Vector2;
use num_complex::Complex64;
use thiserror::Error;

use crate::components::Components;
use crate::frame::Frame;
use crate::mueller::Mueller;
use crate::series::{HermiteSeries, SeriesError};
use crate::shape::ShapeMatrix;
use crate::units::Wavelength;
use crate::vector::{FramedStokes, StokesVector};

/// Least `k r` of the far field, in which light is described here.
pub const LEAST_FAR_FIELD: f64 = 100.0;

/// Why light cannot be described, or two descriptions cannot be joined.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum LightError {
    /// The distance is not that of a far field.
    #[error(
        "light: distance {distance} m at wavelength {wavelength} m has k r = {kr}, expected a finite distance with k r ≥ 100: \
         the far-field expansion does not hold nearer"
    )]
    NotFarField {
        /// Distance from the last source or scatterer, m.
        distance: f64,
        /// Wavelength, m.
        wavelength: f64,
        /// `k r`.
        kr: f64,
    },
    /// A Stokes amplitude is infinite or not a number.
    #[error("light: amplitude S{component} is {value}, expected a finite number")]
    NotFinite {
        /// Which of the four.
        component: usize,
        /// What was found.
        value: f64,
    },
    /// Two lights differ in what they would have to share.
    #[error("light: the two differ in their {what}; bring one into the other's first")]
    Mismatch {
        /// `"shape"`, `"wavelength"`, `"distance"` or `"frame"`.
        what: &'static str,
    },
    /// A coefficient is infinite or not a number.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// A frame belongs to another ray.
    #[error(
        "light: the frame's propagation is off the ray's by {angle} rad, expected the same direction (to 1e-6)"
    )]
    OtherRay {
        /// Angle between the two directions, rad.
        angle: f64,
    },
}

/// What an approximation took from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// L² norm of what is lost, over that of the whole (all four components together), in `0.0..=1.0`.
    pub norm: f64,
    /// What the Stokes vector lost, `before − after` at zero separation, in the unit of the light. May have either
    /// sign: a truncated series is not below the whole everywhere.
    pub stokes: StokesVector,
}

/// Light on one ray in the far field of its last source or scatterer: four series over the same shape.
///
/// ```text
/// C_j(ξ) = (1/r²) Σ c^(j)_ab φ_ab(w; W),      w = (k/r) ξ,      j = 0..3
/// ```
///
/// `ξ = ξ₁ − ξ₂` is a transverse separation in the frame's axes, in metres; the phase `e^{ik r̂·ξ}` of Eq. (S3.2) is 1
/// for it. Coefficients, shape and frame do not change along the ray in free space.
///
/// Source: Definition 4.1 of the paper, Eqs. (S3.2) and (S4.6).
///
/// ```
/// use nalgebra::{Matrix2, Vector2, Vector3};
/// use stokes::*;
/// // Betelgeuse, 47 mas across (Michelson & Pease 1921), as a Gaussian of the disk's variance, α/4 along each axis, in
/// // green light; for its coherence only the angle matters, not the distance
/// let distance = 1e9;
/// let spread = 47e-3 / 3600.0 / 180.0 * std::f64::consts::PI / 4.0 * distance;
/// let light = GeneralizedStokes::new(
///     Components::Shared {
///         modes: HermiteSeries::fundamental(1.0),
///         stokes: StokesVector::UNPOLARIZED,
///     },
///     ShapeMatrix::from_root(&Matrix2::from_diagonal_element(spread))?,
///     Frame::with_x_along(Vector3::z(), Vector3::x())?,
///     Wavelength::from_metres(550e-9)?,
///     distance,
/// )?;
/// // Gaussian coherence falls to e^(−1/2) at the separation r/(k·spread) = 1.54 m
/// let [c0, ..] = light.at_separation(&Vector2::new(1.536, 0.0));
/// assert!((c0.re / light.stokes().stokes.s0() - (-0.5f64).exp()).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralizedStokes {
    components: Components,
    shape: ShapeMatrix,
    frame: Frame,
    wavelength: Wavelength,
    distance: f64,
}

impl GeneralizedStokes {
    /// Light with these components over `shape`, written in `frame` (both its polarization and its transverse
    /// coordinates), at `distance` metres from its last source or scatterer.
    ///
    /// # Errors
    ///
    /// When the distance is not in the far field (`k r <` [`LEAST_FAR_FIELD`]), or an amplitude or a coefficient is not
    /// finite.
    pub fn new(
        components: Components,
        shape: ShapeMatrix,
        frame: Frame,
        wavelength: Wavelength,
        distance: f64,
    ) -> Result<Self, LightError> {
        components.finite()?;
        far_field(wavelength, distance)?;
        Ok(Self {
            components,
            shape,
            frame,
            wavelength,
            distance,
        })
    }

    /// The four series.
    #[must_use]
    pub fn components(&self) -> &Components {
        &self.components
    }

    /// The common shape matrix.
    #[must_use]
    pub fn shape(&self) -> &ShapeMatrix {
        &self.shape
    }

    /// The frame in which polarization and separations are written.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The wavelength in vacuum.
    #[must_use]
    pub fn wavelength(&self) -> Wavelength {
        self.wavelength
    }

    /// Distance r from the last source or scatterer, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The far-field argument `w = (k/r) ξ` of a transverse separation `ξ` in metres; 1/m.
    ///
    /// `k` is that of the vacuum wavelength. In a medium of index n, where `w = (n k/r) ξ`, ask for the separation `nξ`, here
    /// and in [`GeneralizedStokes::at_separation`].
    #[must_use]
    pub fn far_field_argument(&self, separation: &Vector2<f64>) -> Vector2<f64> {
        separation * (self.wavelength.wavenumber().radians_per_metre() / self.distance)
    }

    /// The generalized Stokes parameters `[C0, C1, C2, C3]` of two points `separation` metres apart across the ray.
    ///
    /// Source: Eqs. (S3.2), (S4.6).
    #[must_use]
    pub fn at_separation(&self, separation: &Vector2<f64>) -> [Complex64; 4] {
        let w = self.far_field_argument(separation);
        self.components
            .map(|series| series.value(&self.shape, &w))
            .map(|value| value / (self.distance * self.distance))
    }

    /// The classical Stokes vector: the parameters at zero separation, where they are real.
    ///
    /// Source: section S4.1, last paragraph.
    #[must_use]
    pub fn stokes(&self) -> FramedStokes {
        let stokes = self
            .components
            .map(|series| series.value_at_zero(&self.shape))
            .map(|value| value / (self.distance * self.distance));
        FramedStokes {
            stokes: stokes.into(),
            frame: self.frame,
        }
    }

    /// The same light further along its ray, or back: nothing but the distance changes.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector2, Vector3};
    /// use stokes::*;
    /// # let near = GeneralizedStokes::new(
    /// #     Components::Shared { modes: HermiteSeries::fundamental(1.0), stokes: StokesVector::UNPOLARIZED },
    /// #     ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3))?,
    /// #     Frame::with_x_along(Vector3::z(), Vector3::x())?,
    /// #     Wavelength::from_metres(550e-9)?,
    /// #     1.0,
    /// # )?;
    /// // three times as far: a ninth of the intensity, coherent over three times the separation
    /// let far = near.clone().propagated_to(3.0 * near.distance())?;
    /// assert!((far.intensity() / near.intensity() - 1.0 / 9.0).abs() < 1e-15);
    /// let xi = Vector2::new(60e-6, -20e-6);
    /// let difference = far.degree_of_coherence(&(xi * 3.0)) - near.degree_of_coherence(&xi);
    /// assert!(difference.norm() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When `distance` is not in the far field.
    pub fn propagated_to(mut self, distance: f64) -> Result<Self, LightError> {
        far_field(self.wavelength, distance)?;
        self.distance = distance;
        Ok(self)
    }

    /// The same light written in another frame of the same ray: the polarization and the transverse coordinates
    /// turn together.
    ///
    /// Coefficients stay, the root becomes `W Rᵀ`; only `C1` and `C2` mix.
    ///
    /// # Errors
    ///
    /// When the frame's propagation is another direction.
    pub fn in_frame(&self, frame: Frame) -> Result<Self, LightError> {
        let angle = (frame.z() - self.frame.z()).norm();
        if angle.is_nan() || angle > 1e-6 {
            return Err(LightError::OtherRay { angle });
        }
        let (cos, sin) = (
            self.frame.x().dot(&frame.x()),
            self.frame.y().dot(&frame.x()),
        );
        let length = cos.hypot(sin);
        let rotation = self.frame.rotation_to(&frame);
        let turned = self.through(&Mueller::rotation(rotation), frame)?;
        Ok(Self {
            shape: self.shape.in_turned_axes(cos / length, sin / length),
            ..turned
        })
    }

    /// The light after an element that multiplies the four parameters by a Mueller matrix and leaves the coherence as
    /// it is, written in `frame` afterwards.
    ///
    /// Separations are across the ray, along the axes of `frame` from now on. Absent components stay absent unless the
    /// matrix feeds them.
    ///
    /// # Errors
    ///
    /// When an element of the matrix, or a product, is not finite.
    pub fn through(&self, element: &Mueller, frame: Frame) -> Result<Self, LightError> {
        let components = match &self.components {
            Components::Shared { modes, stokes } => Components::Shared {
                modes: modes.clone(),
                stokes: *element * *stokes,
            },
            Components::Separate(series) => Components::Separate(std::array::from_fn(|l| {
                (0..4).fold(None, |sum: Option<HermiteSeries>, j| {
                    let factor = element.element(l, j);
                    match (&series[j], sum) {
                        (Some(series), sum) if factor != 0.0 => Some(match sum {
                            Some(sum) => sum.plus(factor, series),
                            None => series.scaled(factor),
                        }),
                        (_, sum) => sum,
                    }
                })
            })),
        };
        self.with_components(components, frame)
    }

    /// All four components times `factor`.
    ///
    /// # Errors
    ///
    /// When `factor`, or a product, is not finite.
    pub fn scaled(&self, factor: f64) -> Result<Self, LightError> {
        let components = match &self.components {
            Components::Shared { modes, stokes } => Components::Shared {
                modes: modes.clone(),
                stokes: *stokes * factor,
            },
            Components::Separate(series) => Components::Separate(
                series
                    .each_ref()
                    .map(|series| series.as_ref().map(|series| series.scaled(factor))),
            ),
        };
        self.with_components(components, self.frame)
    }

    /// The incoherent superposition of two lights on the same ray.
    ///
    /// Two lights that share their modes keep sharing them.
    ///
    /// # Errors
    ///
    /// When they differ in shape, wavelength, distance or frame, or a sum is not finite.
    pub fn plus(&self, other: &Self) -> Result<Self, LightError> {
        let same = [
            ("wavelength", self.wavelength == other.wavelength),
            ("distance", self.distance == other.distance),
            ("frame", self.frame == other.frame),
            ("shape", self.shape == other.shape),
        ];
        if let Some((what, _)) = same.into_iter().find(|(_, same)| !same) {
            return Err(LightError::Mismatch { what });
        }
        let components = match (&self.components, &other.components) {
            (
                Components::Shared { modes, stokes },
                Components::Shared {
                    modes: also,
                    stokes: more,
                },
            ) if modes == also => Components::Shared {
                modes: modes.clone(),
                stokes: *stokes + *more,
            },
            (mine, others) => Components::Separate(std::array::from_fn(|j| {
                match (mine.series(j), others.series(j)) {
                    (Some(a), Some(b)) => Some(a.plus(1.0, &b)),
                    (a, b) => a.or(b),
                }
            })),
        };
        self.with_components(components, self.frame)
    }

    /// The light without its modes above `order`, and what that took from it.
    #[must_use]
    pub fn truncated(&self, order: usize) -> (Self, Loss) {
        self.with_series(self.shape, |series| series.truncated(order))
    }

    /// The same light over another shape matrix, by modes up to `order`, and what that took from it.
    ///
    /// Converges geometrically when the widths differ by a factor below 2; beyond 4 split the source instead
    /// ([`crate::Envelope::patches_for`]).
    #[must_use]
    pub fn in_shape(&self, shape: ShapeMatrix, order: usize) -> (Self, Loss) {
        self.with_series(shape, |series| series.in_shape(&self.shape, &shape, order))
    }

    /// The same ray with other components, written in `frame`.
    fn with_components(&self, components: Components, frame: Frame) -> Result<Self, LightError> {
        Self::new(
            components,
            self.shape,
            frame,
            self.wavelength,
            self.distance,
        )
    }

    fn with_series(
        &self,
        shape: ShapeMatrix,
        change: impl Fn(&HermiteSeries) -> (HermiteSeries, f64),
    ) -> (Self, Loss) {
        let (components, lost) = self.components.map_series(change);
        let whole = self.components.norm();
        let changed = Self {
            components,
            shape,
            frame: self.frame,
            wavelength: self.wavelength,
            distance: self.distance,
        };
        let loss = Loss {
            norm: if lost > 0.0 { lost / whole } else { 0.0 },
            stokes: self.stokes().stokes - changed.stokes().stokes,
        };
        (changed, loss)
    }
}

fn far_field(wavelength: Wavelength, distance: f64) -> Result<(), LightError> {
    let kr = wavelength.wavenumber().radians_per_metre() * distance;
    if kr.is_finite() && kr >= LEAST_FAR_FIELD {
        Ok(())
    } else {
        Err(LightError::NotFarField {
            distance,
            wavelength: wavelength.metres(),
            kr,
        })
    }
}
