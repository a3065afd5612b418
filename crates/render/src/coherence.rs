//! What travels from light to camera: the coherence of the light that reaches a vertex.
//!
//! A camera path learns it late. A direction is sampled first; which light comes from there, an emitter patch, a
//! specular chain, another scattering vertex, is known only after the next hit, and only then the vertex is evaluated.

use glam::Vec3A;

/// Mutual coherence of the light that arrives at a vertex, as an angular root Ω (two rows, dimensionless).
///
/// The light's apparent angular distribution has covariance `Ωᵀ Ω` across the ray; with the wavenumber k of the medium
/// and the tangent frame Tm of the vertex, `V = k Ω Tm` is all that a locally stationary scatterer needs to know.
///
/// Source: theory of the factorised transfer, Theorem S4.1 of Steinberg and Yan's supplemental; Ω vanishes for a plane wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherence {
    /// Rows of Ω in world space, radians.
    pub angular_root: [Vec3A; 2],
    /// Length of the way to the source, metres; infinite for light from outside the scene.
    pub distance: f32,
}

impl Coherence {
    /// Light of a single direction from infinitely far: coherent over the whole vertex.
    pub const PLANE_WAVE: Self = Self {
        angular_root: [Vec3A::ZERO; 2],
        distance: f32::INFINITY,
    };

    /// Light of a single direction from a source at a distance in metres.
    pub const fn from_point(distance: f32) -> Self {
        Self {
            angular_root: [Vec3A::ZERO; 2],
            distance,
        }
    }

    /// Whether the light has one direction only.
    pub fn is_point(&self) -> bool {
        self.angular_root == [Vec3A::ZERO; 2]
    }
}
