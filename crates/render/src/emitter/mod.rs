//! Light sources: one file a plugin, with its manual page on top; here the enum and what all of them answer.

pub mod abreast;
pub mod area;
pub mod constant;
pub mod directional;
pub mod egsm;
pub mod laser;
pub mod patch;
pub mod point;
pub mod polarization;
pub mod rayleighsky;
pub mod spot;

use glam::Vec3A;

use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Emission, Light};
use crate::lights::Glance;
use crate::scene::{Body, Scene};
use crate::shape::Surface;
use crate::spectrum::Spectrum;
use patch::{Cut, Outline};
use polarization::Polarization;

/// Any light source.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// What it is.
    pub kind: Kind,
    /// The state of all its light, if the scene file gives one.
    pub polarization: Option<Polarization>,
}

/// What a light source is.
#[derive(Clone, Debug)]
pub enum Kind {
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
    /// A flat spot of partial coherence.
    Schell(Box<egsm::Schell>),
    /// The clear sky.
    RayleighSky(Box<rayleighsky::RayleighSky>),
    /// A parallel beam.
    Laser(laser::Laser),
}

/// How the light of a source depends on the wavelength.
enum Colour<'a> {
    /// As a spectrum times a factor, the same in all directions.
    Spectrum(&'a Spectrum, f32),
    /// In every direction otherwise.
    Schell(&'a egsm::Schell),
    /// In every direction otherwise.
    RayleighSky(&'a rayleighsky::RayleighSky),
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
    /// The way to one point of an area at a distance in metres, or of the surroundings, infinitely far.
    pub fn to_point(
        (direction, distance): (Vec3A, f32),
        target: Option<Target>,
        density: f32,
    ) -> Self {
        Self {
            direction,
            target,
            density,
            discrete: false,
            weight: 1.0,
            coherence: Coherence::from_point(distance),
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
        match &self.kind {
            Kind::Area(e) => e.connect(scene, from, u),
            Kind::Constant(e) => e.connect(frame, u),
            Kind::Point(e) => e.connect(from),
            Kind::Spot(e) => e.connect(from),
            Kind::Directional(e) => e.connect(u),
            Kind::Schell(e) => e.connect(from, u),
            Kind::RayleighSky(e) => e.connect(frame, u),
            Kind::Laser(e) => e.connect(from),
        }
    }

    /// Density per steradian of [`Emitter::connect`] for a surface point that a ray from `from` has hit.
    #[inline]
    pub fn density_of_hit(&self, scene: &Scene, from: Vec3A, at: &Surface) -> f32 {
        match &self.kind {
            Kind::Area(e) => e.density(scene, from, at),
            Kind::Schell(e) => e.density(from, at.position),
            _ => 0.0,
        }
    }

    /// Density per steradian of [`Emitter::connect`] for a direction in which nothing was hit.
    #[inline]
    pub fn density_of_miss(&self, frame: &Frame, direction: Vec3A) -> f32 {
        match &self.kind {
            Kind::Constant(e) => e.density(frame, direction),
            Kind::RayleighSky(e) => e.density(frame, direction),
            _ => 0.0,
        }
    }

    /// Whether it surrounds the scene: rays that leave meet it.
    pub fn surrounds(&self) -> bool {
        matches!(self.kind, Kind::Constant(_) | Kind::RayleighSky(_))
    }

    /// Whether rays can meet it, so that connections are not the only way to its light.
    #[inline]
    pub fn can_be_met(&self) -> bool {
        matches!(self.kind, Kind::Area(_) | Kind::Schell(_)) || self.surrounds()
    }

    /// Whether each point sees it in one direction.
    pub fn has_one_direction(&self) -> bool {
        match &self.kind {
            Kind::Point(_) | Kind::Spot(_) | Kind::Laser(_) => true,
            Kind::Directional(e) => e.is_parallel(),
            _ => false,
        }
    }

    /// How its light depends on the wavelength.
    #[inline(always)]
    fn colour(&self) -> Colour<'_> {
        match &self.kind {
            Kind::Area(e) => Colour::Spectrum(&e.radiance, 1.0),
            Kind::Constant(e) => Colour::Spectrum(&e.radiance, 1.0),
            Kind::Point(e) => Colour::Spectrum(&e.intensity, 1.0),
            Kind::Spot(e) => Colour::Spectrum(&e.intensity, 1.0),
            Kind::Directional(e) => Colour::Spectrum(&e.irradiance, e.scale),
            Kind::Laser(e) => Colour::Spectrum(&e.power, 1.0),
            Kind::Schell(e) => Colour::Schell(e),
            Kind::RayleighSky(e) => Colour::RayleighSky(e),
        }
    }

    /// The light that it sends along `k` from a point on it: radiance, or intensity, irradiance or power of emitters
    /// that have no radiance.
    ///
    /// `from` means nothing for sources outside the scene.
    #[inline]
    pub fn emit<L: Light>(&self, k: Vec3A, from: Vec3A, wavelengths: &[f32]) -> Emission<L> {
        let (spectrum, scale) = match self.colour() {
            Colour::Spectrum(spectrum, scale) => (spectrum, scale),
            Colour::Schell(e) => return e.emit(k, from, wavelengths),
            Colour::RayleighSky(e) => return e.emit(k, wavelengths),
        };
        let radiance = |lane: usize| spectrum.value(wavelengths[lane]) * scale;
        match &self.polarization {
            Some(p) if L::POLARIZED => Emission::polarized(radiance, p.axis_across(k), |_| p.state),
            _ => Emission::unpolarized(radiance),
        }
    }

    /// Whether its light can be linearly, and circularly, polarized.
    pub fn polarizes(&self) -> (bool, bool) {
        match (&self.kind, &self.polarization) {
            (Kind::Schell(e), _) => e.polarizes(),
            (Kind::RayleighSky(e), _) => (e.dop_max > 0.0, false),
            (_, Some(p)) => (p.state.x != 0.0 || p.state.y != 0.0, p.state.z != 0.0),
            (_, None) => (false, false),
        }
    }

    /// Whether its light is the same at all wavelengths of a range, nm.
    pub fn is_grey(&self, range: [f64; 2]) -> bool {
        match self.colour() {
            Colour::Spectrum(spectrum, _) => spectrum.is_constant_over(range),
            Colour::RayleighSky(e) => e.is_grey(range),
            Colour::Schell(_) => false,
        }
    }

    /// The name of its plugin.
    pub fn plugin(&self) -> &'static str {
        match &self.kind {
            Kind::Area(_) => "area",
            Kind::Constant(_) => "constant",
            Kind::Point(_) => "point",
            Kind::Spot(_) => "spot",
            Kind::Directional(_) => "directional",
            Kind::Schell(_) => "egsm",
            Kind::RayleighSky(_) => "rayleighsky",
            Kind::Laser(_) => "laser",
        }
    }

    /// Makes it ready for light from the first to the second wavelength, nm.
    pub fn fit(&mut self, range: [f64; 2]) {
        if let Kind::Schell(e) = &mut self.kind {
            e.fit(range);
        }
    }

    /// It as a choice between sources sees it, by its mean over wavelengths from the first to the second, nm.
    pub fn glance(&self, scene: &Scene, range: [f64; 2]) -> Glance {
        match &self.kind {
            Kind::Area(e) => e.glance(scene, range),
            Kind::Constant(e) => e.glance(range),
            Kind::Point(e) => e.glance(range),
            Kind::Spot(e) => e.glance(range),
            Kind::Directional(e) => e.glance(range),
            Kind::Schell(e) => e.glance(scene),
            Kind::RayleighSky(e) => e.glance(range),
            Kind::Laser(e) => e.glance(range),
        }
    }

    /// Its outline, if it is flat.
    pub fn outline(&self, scene: &Scene) -> Option<Outline> {
        scene.shapes[self.shape()? as usize].outline()
    }

    /// The shape that it is, if it is one.
    fn shape(&self) -> Option<u32> {
        match &self.kind {
            Kind::Area(area::Area {
                body: Body::Shape(index),
                ..
            }) => Some(*index),
            Kind::Schell(e) => Some(e.shape),
            _ => None,
        }
    }

    /// It in patches of at most `largest` (half-width, radians) for a vertex at `from`; `None` if it is not cut.
    #[inline]
    pub fn cut<'a>(&self, scene: &'a Scene, from: Vec3A, largest: f32) -> Option<Cut<'a>> {
        let largest = match &self.kind {
            Kind::Directional(e) => return e.cut(largest),
            Kind::Schell(e) => e.largest_patch(from, largest),
            _ => largest,
        };
        scene.shapes[self.shape()? as usize].cut(from, largest)
    }
}
