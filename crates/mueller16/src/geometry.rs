//! Where light meets matter: two directions, a surface, two media, and the wave vectors that follow.

use nalgebra::{Matrix2, Vector2, Vector3};
use stokes::{Frame, Wavelength};
use thiserror::Error;

/// Least cosine of an angle with the normal at which the energy factors are still numbers.
pub const LEAST_COSINE: f64 = 1e-9;

/// Largest deviation of a given vector from unit length, or of two axes from a right angle.
const UNIT: f64 = 1e-6;

/// What rounding does to the squared length of a unit vector.
const ROUNDING: f64 = 1e-14;

/// Why directions, media and a surface make no encounter of light with matter.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GeometryError {
    /// A vector is not of unit length.
    #[error("geometry: the vector {what} has length {length}, expected 1 (to 1e-6)")]
    NotUnit {
        /// Which vector.
        what: &'static str,
        /// Its length.
        length: f64,
    },
    /// The surface's axes are not perpendicular.
    #[error("geometry: the tangents have the dot product {dot}, expected 0 (to 1e-6)")]
    NotPerpendicular {
        /// Their dot product.
        dot: f64,
    },
    /// An index is not that of a medium that light crosses without loss.
    #[error(
        "geometry: the refractive index of the {side} medium is {index}, expected a number between 1e-3 and 1e3"
    )]
    Index {
        /// `"incident"` or `"outgoing"`.
        side: &'static str,
        /// What was found.
        index: f64,
    },
    /// A direction lies in the surface.
    #[error(
        "geometry: the direction to the {to} is at cosine {cosine} from the normal, expected a modulus of at least 1e-9: \
         at grazing incidence the surface has no size"
    )]
    Grazing {
        /// `"source"` or `"observer"`.
        to: &'static str,
        /// The cosine.
        cosine: f64,
    },
    /// No facet takes the one direction into the other with a change of phase.
    #[error(
        "geometry: the wave vector along the normal changes by {phi_z} rad/m, expected at least 1e-9 of that of the light: heights \
         do not change its phase, and no obliquity factor separates from their lobe"
    )]
    NoFacet {
        /// The change, rad/m.
        phi_z: f64,
    },
    /// No direction has the tangential wave vector that was asked for.
    #[error(
        "geometry: the outgoing light would need a sine of {sine} with the normal, expected at most 1: it is evanescent and \
         reaches no observer"
    )]
    Evanescent {
        /// The length of the outgoing tangential wave vector over that of the medium.
        sine: f64,
    },
}

/// An encounter of light with a surface: direction to the source, direction to the observer, the surface's axes, the
/// wavelength and the media on both sides.
///
/// Reflection when both directions are on one side, transmission otherwise. All wave vectors are in rad/m.
///
/// ```text
/// φ = k₀ (n_o r̂ + n_i ŝ),    φ_t = Tᵀφ,    φ_z = n·φ
/// ```
///
/// ```
/// use mueller16::Geometry;
/// use nalgebra::Vector3;
/// use stokes::Wavelength;
/// let green = Wavelength::from_metres(550e-9)?;
/// let (sin, cos) = 30f64.to_radians().sin_cos();
/// let mirror = Geometry::on_plane(Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos), green)?;
/// assert_eq!(mirror.tangential().norm(), 0.0);
/// // 2 k cos 30°
/// assert!((mirror.normal_component() / (4.0 * std::f64::consts::PI / 550e-9 * cos) - 1.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    to_source: Vector3<f64>,
    to_observer: Vector3<f64>,
    tangents: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    wavelength: Wavelength,
    /// Of the medium on the source's side, and of that on the observer's.
    indices: [f64; 2],
    /// φ
    momentum: Vector3<f64>,
}

impl Geometry {
    /// Light from `to_source` met by a surface with axes `tangents`, seen from `to_observer`, all unit vectors that
    /// point away from the surface. Both media have index 1; see [`Geometry::between`].
    ///
    /// Vectors are used as they are given, not brought to unit length.
    ///
    /// # Errors
    ///
    /// When a vector is not of unit length or the tangents are not perpendicular (to 1e-6).
    pub fn new(
        to_source: Vector3<f64>,
        to_observer: Vector3<f64>,
        tangents: [Vector3<f64>; 2],
        wavelength: Wavelength,
    ) -> Result<Self, GeometryError> {
        let [t1, t2] = tangents;
        check_unit("to the source", &to_source)?;
        check_unit("to the observer", &to_observer)?;
        check_axes(&tangents)?;
        let indices = [1.0; 2];
        Ok(Self {
            to_source,
            to_observer,
            tangents,
            normal: t1.cross(&t2),
            wavelength,
            indices,
            momentum: momentum(to_source, to_observer, wavelength, indices),
        })
    }

    /// As [`Geometry::new`] in the axes of the surface: tangents x and y, normal z.
    ///
    /// # Errors
    ///
    /// As [`Geometry::new`].
    pub fn on_plane(
        to_source: Vector3<f64>,
        to_observer: Vector3<f64>,
        wavelength: Wavelength,
    ) -> Result<Self, GeometryError> {
        let tangents = [Vector3::x(), Vector3::y()];
        Self::new(to_source, to_observer, tangents, wavelength)
    }

    /// The same encounter between media of index `incident`, where the source is, and `outgoing`, where the observer is.
    ///
    /// # Errors
    ///
    /// When an index is not a number between 1e-3 and 1e3.
    pub fn between(mut self, incident: f64, outgoing: f64) -> Result<Self, GeometryError> {
        check_index("incident", incident)?;
        check_index("outgoing", outgoing)?;
        self.indices = [incident, outgoing];
        self.momentum = momentum(
            self.to_source,
            self.to_observer,
            self.wavelength,
            self.indices,
        );
        Ok(self)
    }

    /// The encounter of light that goes the other way: source and observer, with their media, exchanged.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let [incident, outgoing] = self.indices;
        Self {
            to_source: self.to_observer,
            to_observer: self.to_source,
            indices: [outgoing, incident],
            ..*self
        }
    }

    /// The same encounter with light from another direction: from another point of the source.
    ///
    /// # Errors
    ///
    /// When the vector is not of unit length (to 1e-6).
    pub fn lit_from(&self, to_source: Vector3<f64>) -> Result<Self, GeometryError> {
        Self::new(to_source, self.to_observer, self.tangents, self.wavelength)?
            .between(self.indices[0], self.indices[1])
    }

    /// The same light seen from where the matter must give it the tangential wave vector `phi`, rad/m, on the side of the
    /// present observer: `phi = 0` is the mirror's or Snell's direction, `phi = q G` a grating's order.
    ///
    /// ```
    /// use mueller16::Geometry;
    /// use nalgebra::{Vector2, Vector3};
    /// use stokes::Wavelength;
    /// // 600 lines per mm at normal incidence, 500 nm: the first order at sin = 0.3
    /// let light = Wavelength::from_metres(500e-9)?;
    /// let normal = Geometry::on_plane(Vector3::z(), Vector3::z(), light)?;
    /// let first = normal.observed_at(&Vector2::new(2.0 * std::f64::consts::PI * 600e3, 0.0))?;
    /// assert!((first.to_observer().x - 0.3).abs() < 1e-15);
    /// // the fourth would need a sine of 1.2
    /// assert!(normal.observed_at(&Vector2::new(2.0 * std::f64::consts::PI * 2400e3, 0.0)).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there is no such direction: the light is evanescent (total reflection, an order beyond the last).
    pub fn observed_at(&self, phi: &Vector2<f64>) -> Result<Self, GeometryError> {
        let [t1, t2] = self.tangents;
        let k = self.wavelength.wavenumber().radians_per_metre();
        let [incident, outgoing] = self.indices;
        let given = Vector2::new(t1.dot(&self.to_source), t2.dot(&self.to_source));
        let (turned, ratio) = (phi / (k * outgoing), incident / outgoing);
        let o = turned - given * ratio;
        // 1 − |o|² from the cosine of the source, so that a mirror keeps its digits at grazing incidence
        let excess = self.to_source.norm_squared() - 1.0;
        let excess = if excess.abs() < ROUNDING { 0.0 } else { excess };
        let squared = (1.0 - ratio) * (1.0 + ratio)
            + ratio * ratio * (self.cos_incident().powi(2) - excess)
            + (2.0 * ratio * given - turned).dot(&turned);
        if squared.is_nan() || squared < 0.0 {
            return Err(GeometryError::Evanescent { sine: o.norm() });
        }
        let height = squared.sqrt().copysign(self.cos_outgoing());
        let to_observer = t1 * o.x + t2 * o.y + self.normal * height;
        Self::new(self.to_source, to_observer, self.tangents, self.wavelength)?
            .between(incident, outgoing)
    }

    /// The direction to the source, against the incident light's propagation.
    #[must_use]
    pub fn to_source(&self) -> Vector3<f64> {
        self.to_source
    }

    /// The direction to the observer.
    #[must_use]
    pub fn to_observer(&self) -> Vector3<f64> {
        self.to_observer
    }

    /// The surface's axes.
    #[must_use]
    pub fn tangents(&self) -> [Vector3<f64>; 2] {
        self.tangents
    }

    /// The surface's normal, `t1 × t2`.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// The vacuum wavelength.
    #[must_use]
    pub fn wavelength(&self) -> Wavelength {
        self.wavelength
    }

    /// Index of the medium on the source's side.
    #[must_use]
    pub fn n_incident(&self) -> f64 {
        self.indices[0]
    }

    /// Index of the medium on the observer's side.
    #[must_use]
    pub fn n_outgoing(&self) -> f64 {
        self.indices[1]
    }

    /// Cosine between the normal and the direction to the source, in `−1.0..=1.0`.
    #[must_use]
    pub fn cos_incident(&self) -> f64 {
        self.normal.dot(&self.to_source)
    }

    /// Cosine between the normal and the direction to the observer, in `−1.0..=1.0`.
    #[must_use]
    pub fn cos_outgoing(&self) -> f64 {
        self.normal.dot(&self.to_observer)
    }

    /// Whether source and observer are on one side.
    #[must_use]
    pub fn is_reflection(&self) -> bool {
        self.cos_incident() * self.cos_outgoing() > 0.0
    }

    /// The wave vector given to the matter, `φ = k_out − k_in`, rad/m.
    ///
    /// Source: Eq. (S2.3) and the phase of Eq. (S2.5); in one medium `φ = k (r̂ + ŝ)`.
    #[must_use]
    pub fn momentum_transfer(&self) -> Vector3<f64> {
        self.momentum
    }

    /// Its part in the surface, `φ_t`, in the axes of the tangents, rad/m; 0 for a mirror and for Snell's direction.
    #[inline]
    #[must_use]
    pub fn tangential(&self) -> Vector2<f64> {
        let [t1, t2] = self.tangents;
        Vector2::new(t1.dot(&self.momentum), t2.dot(&self.momentum))
    }

    /// Its part along the normal, `φ_z`, rad/m.
    #[inline]
    #[must_use]
    pub fn normal_component(&self) -> f64 {
        self.normal.dot(&self.momentum)
    }

    /// The unit normal `h = φ/|φ|` of the facet that reflects or refracts the one direction into the other, on the
    /// side of the surface's normal; `None` where no facet does (`φ = 0`).
    #[must_use]
    pub fn half_vector(&self) -> Option<Vector3<f64>> {
        let h = self.momentum.try_normalize(0.0)?;
        Some(if h.dot(&self.normal) < 0.0 { -h } else { h })
    }

    /// `P`, the outgoing light's transverse axes in those of the surface, `P_rc = t_r·e_c`; 2×2.
    #[must_use]
    pub fn outgoing_projection(&self, outgoing: &Frame) -> Matrix2<f64> {
        stokes::surface_projection(&self.tangents, outgoing)
    }

    /// The obliquity factor of a rough height surface, `|i·h||o·h||φ|²/(|cos_i cos_o| φ_z²)`; dimensionless, 1 in every
    /// mirror direction and at every pair of Snell's law, and the same for the reversed encounter.
    ///
    /// With it the limit of great roughness is the Beckmann microfacet model in reflection and in transmission. It
    /// belongs to the diffuse part of height surfaces alone: phase screens and discrete orders have the factor 1.
    ///
    /// # Errors
    ///
    /// When a direction is at a cosine below [`LEAST_COSINE`] from the surface, or `φ_z` vanishes: light that goes straight
    /// on between media of one index, and pairs of directions that heights cannot tell apart.
    pub fn obliquity(&self) -> Result<f64, GeometryError> {
        let [cos_i, cos_o] = self.cosines()?;
        let phi_z = self.normal_component();
        let k = self.wavelength.wavenumber().radians_per_metre();
        let [incident, outgoing] = self.indices;
        if phi_z.abs() < LEAST_COSINE * k * incident.max(outgoing) {
            return Err(GeometryError::NoFacet { phi_z });
        }
        let facets = self.momentum.dot(&self.to_source) * self.momentum.dot(&self.to_observer);
        Ok(facets.abs() / ((cos_i * cos_o).abs() * phi_z * phi_z))
    }

    /// Both cosines.
    ///
    /// # Errors
    ///
    /// As [`Geometry::obliquity`].
    pub fn cosines(&self) -> Result<[f64; 2], GeometryError> {
        let cosines = [self.cos_incident(), self.cos_outgoing()];
        for (to, cosine) in ["source", "observer"].into_iter().zip(cosines) {
            if cosine.abs() < LEAST_COSINE {
                return Err(GeometryError::Grazing { to, cosine });
            }
        }
        Ok(cosines)
    }
}

/// The index of a medium that light crosses without loss.
pub(crate) fn check_index(side: &'static str, index: f64) -> Result<(), GeometryError> {
    if (1e-3..=1e3).contains(&index) {
        Ok(())
    } else {
        Err(GeometryError::Index { side, index })
    }
}

/// Two perpendicular unit vectors.
pub(crate) fn check_axes(tangents: &[Vector3<f64>; 2]) -> Result<(), GeometryError> {
    let [t1, t2] = tangents;
    check_unit("of the first tangent", t1)?;
    check_unit("of the second tangent", t2)?;
    let dot = t1.dot(t2);
    if dot.is_nan() || dot.abs() > UNIT {
        return Err(GeometryError::NotPerpendicular { dot });
    }
    Ok(())
}

fn check_unit(what: &'static str, vector: &Vector3<f64>) -> Result<(), GeometryError> {
    let length = vector.norm();
    if length.is_nan() || (length - 1.0).abs() > UNIT {
        return Err(GeometryError::NotUnit { what, length });
    }
    Ok(())
}

fn momentum(
    to_source: Vector3<f64>,
    to_observer: Vector3<f64>,
    wavelength: Wavelength,
    [incident, outgoing]: [f64; 2],
) -> Vector3<f64> {
    (to_observer * outgoing + to_source * incident) * wavelength.wavenumber().radians_per_metre()
}
