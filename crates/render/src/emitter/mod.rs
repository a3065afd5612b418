//! Light sources: one file a plugin, with its manual page on top; here the enum and what all of them answer.

pub mod area;
pub mod constant;
pub mod directional;
pub mod patch;
pub mod point;
pub mod spot;

use glam::Vec3A;

use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Emission, Light};
use crate::scene::{Body, Scene};
use crate::shape::Surface;
use patch::{Cut, Outline};

/// Any light source.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// The surface of a shape.
    Area(area::Area),
    /// The same radiance from everywhere.
    Constant(constant::Constant),
    /// A point.
    Point(point::Point),
    /// A point with a cone.
    Spot(spot::Spot),
    /// One direction.
    Directional(directional::Directional),
}

/// A way from a vertex to a light source.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Unit direction toward the source.
    pub direction: Vec3A,
    /// Where the source is; `None`: infinitely far.
    pub target: Option<Target>,
    /// Density per steradian; for a discrete source 1.
    pub density: f32,
    /// Whether no other way to sample it exists (a point, a single direction).
    pub discrete: bool,
    /// Factor on the source's emission: 1 for radiance, 1/r² for intensity, …
    pub weight: f32,
    /// Coherence of the light that comes this way.
    pub coherence: Coherence,
}

impl Connection {
    /// The way to one point of an area, or of the surroundings if there is no target: plane waves.
    pub fn to_point(direction: Vec3A, target: Option<Target>, density: f32) -> Self {
        Self {
            direction,
            target,
            density,
            discrete: false,
            weight: 1.0,
            coherence: Coherence::PLANE_WAVE,
        }
    }
}

/// The end of a shadow ray.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Position, metres.
    pub position: Vec3A,
    /// Half-widths of the box that contains the true point; zero for a point source.
    pub error: Vec3A,
    /// Normal of the source there; zero for a point source.
    pub normal: Vec3A,
}

impl Emitter {
    /// Draws a way from a vertex to the source. `frame` has its normal on the side from which the vertex can be lit.
    #[inline]
    pub fn connect(
        &self,
        scene: &Scene,
        from: Vec3A,
        frame: &Frame,
        u: [f32; 2],
    ) -> Option<Connection> {
        match self {
            Self::Area(e) => e.connect(scene, from, u),
            Self::Constant(e) => e.connect(frame, u),
            Self::Point(e) => e.connect(from),
            Self::Spot(e) => e.connect(from),
            Self::Directional(e) => e.connect(),
        }
    }

    /// Density per steradian of [`Emitter::connect`] for a surface point that a ray from `from` has hit.
    #[inline]
    pub fn density_of_hit(&self, scene: &Scene, from: Vec3A, at: &Surface) -> f32 {
        match self {
            Self::Area(e) => e.density(scene, from, at),
            _ => 0.0,
        }
    }

    /// The light that it sends along `k` from a point on it: radiance, or intensity or irradiance of emitters that
    /// have no radiance.
    ///
    /// `from` means nothing for sources outside the scene.
    #[inline]
    pub fn emit<L: Light>(&self, _k: Vec3A, _from: Vec3A, wavelengths: &[f32]) -> Emission<L> {
        let spectrum = match self {
            Self::Area(e) => &e.radiance,
            Self::Constant(e) => &e.radiance,
            Self::Point(e) => &e.intensity,
            Self::Spot(e) => &e.intensity,
            Self::Directional(e) => &e.irradiance,
        };
        Emission::unpolarized(|lane| spectrum.value(wavelengths[lane]))
    }

    /// Its outline, if it is flat.
    pub fn outline(&self, scene: &Scene) -> Option<Outline> {
        match self {
            Self::Area(area::Area {
                body: Body::Shape(index),
                ..
            }) => scene.shapes[*index as usize].outline(),
            _ => None,
        }
    }

    /// It in patches of at most `largest` (half-width, radians) for a vertex at `from`; `None` if it is not cut.
    #[inline]
    pub fn cut<'a>(&self, scene: &'a Scene, from: Vec3A, largest: f32) -> Option<Cut<'a>> {
        match self {
            Self::Area(area::Area {
                body: Body::Shape(index),
                ..
            }) => scene.shapes[*index as usize].cut(from, largest),
            _ => None,
        }
    }
}
