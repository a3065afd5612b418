//! What a camera path carries: intensity alone, or the full Stokes vector, at `N` wavelengths at once.
//!
//! A path runs from the camera toward the light. Its throughput is the 4×4 matrix `T` that takes the Stokes vector
//! at the far end of the path to the sensor; every vertex multiplies a Mueller matrix from the right,
//!
//! ```text
//! S_sensor = T S,      T ← T R(T's frame ← vertex's outgoing frame) M
//! ```
//!
//! `frames.rs` is the only place where Stokes frames are turned into each other. A frame is named by its first axis, a
//! unit vector across the ray in world space; with the propagation direction `k` of the light the second is `k × x`.
//! Once a vertex depolarizes, `T` has rank one and is kept as a column times a row; an unpolarized source needs only
//! the first column of the last vertex. Both are exact.
//!
//! Single precision: each product rounds at 6e-8 relative, far below Monte Carlo noise at any affordable sample count.

pub mod abreast;
mod collect;
mod frames;
mod intensity;
mod polarized;
#[cfg(test)]
mod polarized_tests;
mod response;
mod sight;
mod throughput;

use glam::{Mat4, Vec3, Vec3A, Vec4, vec4};
use stokes::DiattenuatingRetarder;

/// The Mueller matrix of an element that is diagonal in its own frame, in single precision.
///
/// ```text
/// [ mean        difference  0       0    ]
/// [ difference  mean        0       0    ]
/// [ 0           0           cosine  sine ]
/// [ 0           0          −sine  cosine ]
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// M00 = M11.
    pub mean: f32,
    /// M01 = M10.
    pub difference: f32,
    /// M22 = M33.
    pub cosine: f32,
    /// M23 = −M32.
    pub sine: f32,
}

impl Element {
    /// Lets nothing through.
    pub const BLACK: Self = Self {
        mean: 0.0,
        difference: 0.0,
        cosine: 0.0,
        sine: 0.0,
    };

    /// All four numbers times `weight`.
    #[inline]
    pub fn scaled(self, weight: f32) -> Self {
        Self {
            mean: self.mean * weight,
            difference: self.difference * weight,
            cosine: self.cosine * weight,
            sine: self.sine * weight,
        }
    }

    fn matrix(self) -> Mat4 {
        let Self {
            mean: a,
            difference: b,
            cosine: c,
            sine: s,
        } = self;
        Mat4::from_cols(
            vec4(a, b, 0., 0.),
            vec4(b, a, 0., 0.),
            vec4(0., 0., c, -s),
            vec4(0., 0., s, c),
        )
    }
}

impl From<DiattenuatingRetarder> for Element {
    /// Narrows to single precision: costs 6e-8 relative.
    #[inline]
    fn from(m: DiattenuatingRetarder) -> Self {
        Self {
            mean: m.mean as f32,
            difference: m.difference as f32,
            cosine: m.cosine as f32,
            sine: m.sine as f32,
        }
    }
}

pub use intensity::Intensity;
pub use polarized::Polarized;
pub use response::MuellerResponse;
pub use sight::Sight;
pub use throughput::MuellerThroughput;

/// What a source sends along one ray, at every wavelength of the path.
#[derive(Clone, Copy, Debug)]
pub struct Emission<L: Light> {
    /// Radiance (or intensity, irradiance: see the emitter); S0.
    pub radiance: L::Lanes,
    /// First axis of its Stokes frame, across the ray, and S1, S2, S3 over S0; `None`: unpolarized.
    pub state: Option<(Vec3A, L::States)>,
}

impl<L: Light> Emission<L> {
    /// Light without polarization.
    #[inline]
    pub fn unpolarized(radiance: impl Fn(usize) -> f32) -> Self {
        Self {
            radiance: L::lanes(radiance),
            state: None,
        }
    }

    /// Light of a state (S1, S2, S3 over S0) in the frame of `axis`.
    #[inline]
    pub fn polarized(
        radiance: impl Fn(usize) -> f32,
        axis: Vec3A,
        state: impl Fn(usize) -> Vec3,
    ) -> Self {
        Self {
            radiance: L::lanes(radiance),
            state: L::POLARIZED.then(|| (axis, L::states(state))),
        }
    }
}

/// How light is described along a path: the scalar or the Stokes-vector algebra.
pub trait Light: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Wavelengths carried by one path.
    const LANES: usize;
    /// Whether S1, S2, S3 are followed.
    const POLARIZED: bool;
    /// What a vertex does to light that goes from one direction to another.
    type Response: Copy;
    /// The product of the responses from the sensor to here.
    type Throughput: Copy;
    /// One number a wavelength.
    type Lanes: Copy + std::fmt::Debug + AsRef<[f32]>;
    /// S1, S2, S3 over S0, one triple a wavelength.
    type States: Copy + std::fmt::Debug;
    /// One Stokes vector a wavelength, in the frame of the sensor ray.
    type Stokes: Copy + AsRef<[Vec4]>;

    /// One number for each wavelength.
    fn lanes(value: impl Fn(usize) -> f32) -> Self::Lanes;
    /// One state for each wavelength.
    fn states(value: impl Fn(usize) -> Vec3) -> Self::States;
    /// No light at all.
    fn dark() -> Self::Stokes;
    /// A response that forgets polarization: only M00.
    fn depolarizing(value: impl Fn(usize) -> f32) -> Self::Response;
    /// A response that is diagonal in the frame of `axis`, the same for the light that arrives and the light that leaves.
    fn diattenuating_retarder(axis: Vec3A, element: impl Fn(usize) -> Element) -> Self::Response;
    /// A depolarizer between two elements: `last · diag(weight, 0, 0, 0) · first`, with the axes of each element.
    fn depolarizer_between(
        last: (Vec3A, Element),
        weight: impl Fn(usize) -> f32,
        first: (Vec3A, Element),
    ) -> Self::Response;
    /// A general Mueller matrix from the frame of `axis_in` to that of `axis_out`.
    fn general(axis_out: Vec3A, axis_in: Vec3A, matrix: impl Fn(usize) -> Mat4) -> Self::Response;
    /// Both responses together; `k_out` and `k_in` are the propagation directions of the light that leaves and arrives.
    fn sum(a: Self::Response, b: Self::Response, k_out: Vec3A, k_in: Vec3A) -> Self::Response;
    /// Turns the axes of a response (from a surface's frame to the world, say).
    fn map_axes(response: Self::Response, turn: impl Fn(Vec3A) -> Vec3A) -> Self::Response;

    /// The empty path: light arrives at the sensor as it is, in the frame of `axis`.
    fn identity(axis: Vec3A) -> Self::Throughput;
    /// Lengthens the path by a vertex, weighted; `k_out` is the propagation direction of the light that leaves it.
    fn lengthen(
        throughput: &mut Self::Throughput,
        response: Self::Response,
        weight: f32,
        k_out: Vec3A,
    );
    /// The path lengthened by a vertex.
    #[inline]
    fn extend(
        throughput: &Self::Throughput,
        response: Self::Response,
        weight: f32,
        k_out: Vec3A,
    ) -> Self::Throughput {
        let mut longer = *throughput;
        Self::lengthen(&mut longer, response, weight, k_out);
        longer
    }
    /// A piece of path as one response: `throughput` began with `identity(axis)`.
    fn as_response(throughput: &Self::Throughput, axis: Vec3A) -> Self::Response;
    /// Light of a source at the end of the path, as the sensor sees it; `k` is its propagation direction there.
    fn collect(throughput: &Self::Throughput, source: &Emission<Self>, k: Vec3A) -> Self::Stokes;
    /// The same with one more vertex between the path and the source.
    fn collect_through(
        throughput: &Self::Throughput,
        response: Self::Response,
        k_out: Vec3A,
        source: &Emission<Self>,
        k_in: Vec3A,
    ) -> Self::Stokes;
    /// Adds `weight · more` to `sum`.
    fn accumulate(sum: &mut Self::Stokes, more: Self::Stokes, weight: f32);
    /// The largest T00 over the wavelengths: what reaches the sensor of unpolarized light of unit radiance.
    fn strength(throughput: &Self::Throughput) -> f32;
    /// The largest S0 at the sensor that light of unit radiance in any state can make, over the wavelengths: for
    /// realizable matter all of the sensor's components stay below it. At most twice [`Light::strength`].
    fn reach(throughput: &Self::Throughput) -> f32;
    /// Which linearly polarized light makes more S0 at the sensor than other light, all wavelengths together.
    fn sight(throughput: &Self::Throughput) -> Sight;
    /// Scales the path by `weight`.
    fn scale(throughput: &mut Self::Throughput, weight: f32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_of_an_element_is_laid_out_as_in_stokes() {
        let element = DiattenuatingRetarder {
            mean: 0.5,
            difference: 0.25,
            cosine: -0.125,
            sine: 0.375,
        };
        let matrix = Element::from(element).matrix();
        let expected = element.to_mueller();
        for row in 0..4 {
            for column in 0..4 {
                // powers of two: exact in both precisions
                assert_eq!(
                    f64::from(matrix.col(column)[row]),
                    expected.element(row, column)
                );
            }
        }
    }
}
