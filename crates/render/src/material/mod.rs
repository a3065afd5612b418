//! Matter on surfaces: one file a plugin, each with its manual page on top; here the enum and what all of them answer.
//!
//! Directions are local (z along the shading normal, x along axis U), unit, and point away from the surface:
//! `o` toward the camera, `i` toward the light. Light propagates along `−i` before and `o` after the surface.

pub mod abreast;
pub mod birefringent;
pub mod circular;
pub mod coated;
pub mod conductor;
pub mod detector;
pub mod dielectric;
pub mod diffuse;
pub mod grating;
pub mod index;
pub mod layered;
#[cfg(test)]
pub mod lobe;
pub mod microfacet;
pub mod mueller;
pub mod null;
pub mod plastic;
pub mod polarizer;
pub mod pplastic;
pub mod retarder;
pub mod rotator;
pub mod roughconductor;
pub mod roughdielectric;
pub mod roughplastic;
pub mod roughsurface;
pub mod scatterer16;
pub mod slits;
#[cfg(test)]
pub mod testing;
pub mod thindielectric;
pub mod twosided;
pub mod wedge;

use glam::{DMat4, Mat4, Vec3A};
use stokes::Mueller;

use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::light::{Light, Sight};
use crate::scene::{Object, SceneError, nearest};

/// A point on matter, as a camera path meets it.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Toward the camera, local.
    pub o: Vec3A,
    /// Where it is, metres.
    pub position: Vec3A,
    /// Shading normal and axis U: what "local" means.
    pub frame: Frame,
    /// Length of the path to the vertex before, toward the camera, metres; told where matter answers to coherence.
    pub viewer_distance: f32,
    /// What polarization the sensor sees from here, local; told where matter chooses by it ([`Traits::chooses`]).
    pub sight: Sight,
}

/// Which part of what matter does a direction belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Directions with a density per steradian: emitters can be connected to.
    Continuous,
    /// Straight through, unbent: emitters can be connected to across it.
    Straight,
    /// One of a few directions (mirror, refraction, an order of a grating), by the matter's own number.
    Discrete(u32),
}

/// A direction toward the light that has been drawn at a vertex, not yet evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// Direction toward the light, local.
    pub direction: Vec3A,
    /// Density per steradian, or the probability if the direction is discrete.
    pub density: f32,
    /// What it belongs to.
    pub part: Part,
    /// Index of refraction on the light's side over that on the camera's side.
    pub eta: f32,
}

impl Departure {
    /// Mirrored by the surface, with this probability.
    #[inline]
    fn mirrored(o: Vec3A, probability: f32) -> Self {
        Self {
            direction: mirror(o, Vec3A::Z),
            density: probability,
            part: Part::Discrete(0),
            eta: 1.0,
        }
    }

    /// Straight through, with this probability.
    #[inline]
    fn straight(o: Vec3A, probability: f32) -> Self {
        Self {
            direction: -o,
            density: probability,
            part: Part::Straight,
            eta: 1.0,
        }
    }

    /// In a drawn direction toward light; `None` where its density is not a positive number.
    #[inline]
    fn continuous(direction: Vec3A, density: f32, eta: f32) -> Option<Self> {
        (density > 0.0 && density.is_finite()).then_some(Self {
            direction,
            density,
            part: Part::Continuous,
            eta,
        })
    }
}

/// What transport has to know of matter before it meets it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traits {
    /// All its directions are discrete: emitters cannot be connected to.
    pub discrete: bool,
    /// Some light goes straight through: [`Part::Straight`].
    pub straight: bool,
    /// It answers to the coherence of light: [`Matter::lobe_width`] may be `Some`.
    pub coherent: bool,
    /// Its directions depend on the wavelength: paths carry one wavelength each.
    pub disperses: bool,
    /// It chooses between reflection and passage by [`Vertex::sight`].
    pub chooses: bool,
    /// It swallows all light.
    pub black: bool,
}

impl Traits {
    /// Whatever either does; discrete, or black, if both are.
    pub fn or(self, other: Self) -> Self {
        Self {
            discrete: self.discrete && other.discrete,
            straight: self.straight || other.straight,
            coherent: self.coherent || other.coherent,
            disperses: self.disperses || other.disperses,
            chooses: self.chooses || other.chooses,
            black: self.black && other.black,
        }
    }
}

/// What matter can do to the state of polarization: for `inspect`, and for what a scene needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effect {
    /// Some light forgets its polarization here.
    pub depolarizes: bool,
    /// Unpolarized light becomes partly linearly polarized.
    pub makes_linear: bool,
    /// Unpolarized light becomes partly circularly polarized.
    pub makes_circular: bool,
    /// Linear and circular polarization turn into each other.
    pub retards: bool,
}

impl Effect {
    /// Both effects.
    pub fn and(self, other: Self) -> Self {
        Self {
            depolarizes: self.depolarizes || other.depolarizes,
            makes_linear: self.makes_linear || other.makes_linear,
            makes_circular: self.makes_circular || other.makes_circular,
            retards: self.retards || other.retards,
        }
    }
}

/// Any matter that a scene may hold.
#[derive(Clone, Debug)]
pub enum Material {
    /// Lambert.
    Diffuse(diffuse::Diffuse),
    /// Smooth metal.
    Conductor(conductor::Conductor),
    /// Rough metal.
    RoughConductor(roughconductor::RoughConductor),
    /// Random heights, on metal or glass.
    RoughSurface(Box<roughsurface::RoughSurface>),
    /// Smooth glass.
    Dielectric(dielectric::Dielectric),
    /// Plastic with a rough surface: `pplastic`, `roughplastic`.
    RoughlyCoated(coated::RoughlyCoated),
    /// Linear polarizer.
    Polarizer(polarizer::Polarizer),
    /// Linear retarder.
    Retarder(retarder::Retarder),
    /// Circular polarizer.
    Circular(circular::Circular),
    /// Nothing.
    Null(null::Null),
    /// Thin films.
    Layered(Box<layered::Layered>),
    /// Crystal plate.
    Birefringent(Box<birefringent::Birefringent>),
    /// Optical activity.
    Rotator(rotator::Rotator),
    /// Any Mueller matrix.
    Mueller(mueller::MuellerElement),
    /// Rough glass.
    RoughDielectric(roughdielectric::RoughDielectric),
    /// A pane of glass.
    ThinDielectric(thindielectric::ThinDielectric),
    /// Smooth plastic.
    Plastic(plastic::Plastic),
    /// Any locally stationary matter.
    Scatterer16(Box<scatterer16::Scatterer16>),
    /// Grating.
    Grating(Box<grating::Grating>),
    /// Openings in an opaque screen.
    Slits(Box<slits::Slits>),
    /// Matter with two sides.
    TwoSided(twosided::TwoSided),
    /// The plane of a sensor.
    Detector(detector::Detector),
    /// Matter for tests.
    #[cfg(test)]
    Lobe(lobe::Lobe),
}

/// One match for all questions.
macro_rules! ask {
    ($material:expr, $m:ident => $answer:expr) => {
        match $material {
            Material::Diffuse($m) => $answer,
            Material::Conductor($m) => $answer,
            Material::RoughConductor($m) => $answer,
            Material::RoughSurface($m) => $answer,
            Material::Dielectric($m) => $answer,
            Material::RoughlyCoated($m) => $answer,
            Material::Polarizer($m) => $answer,
            Material::Retarder($m) => $answer,
            Material::Circular($m) => $answer,
            Material::Null($m) => $answer,
            Material::Layered($m) => $answer,
            Material::Birefringent($m) => $answer,
            Material::Rotator($m) => $answer,
            Material::Mueller($m) => $answer,
            Material::RoughDielectric($m) => $answer,
            Material::ThinDielectric($m) => $answer,
            Material::Plastic($m) => $answer,
            Material::Scatterer16($m) => $answer,
            Material::Grating($m) => $answer,
            Material::Slits($m) => $answer,
            Material::TwoSided($m) => $answer,
            Material::Detector($m) => $answer,
            #[cfg(test)]
            Material::Lobe($m) => $answer,
        }
    };
}

/// What each kind of matter answers.
pub trait Matter {
    /// Draws a direction toward the light for light that leaves along `at.o`, from three uniform numbers.
    ///
    /// If directions depend on the wavelength ([`Traits::disperses`]) `wavelengths` has one element.
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure>;

    /// The Mueller matrix from `−i` to `at.o`, with the density of [`Matter::sample`] (0 for discrete directions).
    ///
    /// For [`Part::Continuous`] BRDF × |cos i|, per steradian; for a discrete direction that `sample` has drawn, and for
    /// `i = −at.o` with [`Part::Straight`], the plain matrix. Frames are local. `coherence` is that of the incident light.
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32);

    /// What it can do to polarization.
    fn effect(&self) -> Effect;

    /// Angular width (standard deviation, radians) of the narrowest continuous lobe with which it answers at a vertex.
    ///
    /// Emitters are cut into patches by it. `None`: it ignores coherence, and light may come from single points.
    fn lobe_width(&self, _: &Vertex, _: &[f32]) -> Option<f32> {
        None
    }

    /// The direction toward the light of a discrete part, for neighbouring rays of a path that took it.
    ///
    /// `None`: the coherence of light is not followed through it.
    fn bend(&self, _: &Vertex, _: Part, _: &[f32]) -> Option<Vec3A> {
        None
    }

    /// What it is, as far as transport treats it differently.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// Whether it does the same to light of all wavelengths of a range, nm.
    fn is_grey(&self, _: [f64; 2]) -> bool {
        false
    }

    /// Which part of the theorem's sums it leaves out, for `--explain`.
    fn left_out(&self) -> Option<String> {
        None
    }

    /// Refuses a rendering from the first to the second wavelength, nm, where the scene has no data for it.
    ///
    /// # Errors
    ///
    /// At the table of the scene file that ends too early.
    fn check_wavelengths(&self, _: [f64; 2]) -> Result<(), SceneError> {
        Ok(())
    }

    /// What the user should know of a rendering from the first to the second wavelength, nm, with the place in the scene
    /// file.
    fn doubts(&self, _: [f64; 2]) -> Vec<String> {
        Vec::new()
    }
}

impl Material {
    /// Whether light meets it from both sides by itself.
    pub fn is_two_sided(&self) -> bool {
        match self {
            Self::Diffuse(_)
            | Self::Conductor(_)
            | Self::RoughConductor(_)
            | Self::Plastic(_)
            | Self::RoughlyCoated(_) => false,
            Self::Layered(layered) => !layered.is_opaque(),
            Self::RoughSurface(surface) => !surface.is_metal(),
            Self::Mueller(element) => !element.is_mirror(),
            Self::Grating(grating) => grating.is_two_sided(),
            Self::Dielectric(_)
            | Self::Polarizer(_)
            | Self::Retarder(_)
            | Self::Circular(_)
            | Self::Null(_)
            | Self::Birefringent(_)
            | Self::Rotator(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::Scatterer16(_)
            | Self::Slits(_)
            | Self::TwoSided(_)
            | Self::Detector(_) => true,
            #[cfg(test)]
            Self::Lobe(_) => false,
        }
    }
}

impl Matter for Material {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        ask!(self, m => m.sample(at, wavelengths, u))
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        ask!(self, m => m.respond::<L>(at, i, part, wavelengths, coherence))
    }

    fn effect(&self) -> Effect {
        ask!(self, m => m.effect())
    }

    #[inline]
    fn lobe_width(&self, at: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        ask!(self, m => m.lobe_width(at, wavelengths))
    }

    fn bend(&self, at: &Vertex, part: Part, wavelengths: &[f32]) -> Option<Vec3A> {
        ask!(self, m => m.bend(at, part, wavelengths))
    }

    fn traits(&self) -> Traits {
        ask!(self, m => m.traits())
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        ask!(self, m => m.is_grey(range))
    }

    fn left_out(&self) -> Option<String> {
        ask!(self, m => m.left_out())
    }

    fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        ask!(self, m => m.check_wavelengths(range))
    }

    fn doubts(&self, range: [f64; 2]) -> Vec<String> {
        ask!(self, m => m.doubts(range))
    }
}

/// The response, and its density, of matter that sends nothing from one direction to the other.
#[inline]
fn dark<L: Light>() -> (L::Response, f32) {
    (L::depolarizing(|_| 0.0), 0.0)
}

/// The axis perpendicular to the plane of incidence, first axis of the Stokes frames of an interface.
///
/// `normal` and `i` are unit. Next to normal incidence the plane is lost in rounding, and with it the difference
/// between s and p: any axis across `i` serves.
#[inline]
pub fn axis_s(normal: Vec3A, i: Vec3A) -> Vec3A {
    let across = normal.cross(i);
    let squared = across.length_squared();
    if squared > 1e-8 {
        across / squared.sqrt()
    } else {
        Frame::around(i).s
    }
}

/// A Mueller matrix in single precision: costs 6e-8 relative.
fn narrowed(mueller: &Mueller) -> Mat4 {
    DMat4::from_cols_array_2d(&mueller.to_matrix().into()).as_mat4()
}

/// The direction mirrored at a normal.
#[inline]
pub fn mirror(o: Vec3A, normal: Vec3A) -> Vec3A {
    normal * (2.0 * o.dot(normal)) - o
}

/// The error for a medium that no table knows.
fn unknown_name(
    object: &Object,
    parameter: &str,
    name: &str,
    known: impl Iterator<Item = &'static str>,
) -> SceneError {
    let known: Vec<&str> = known.collect();
    object.error_at(
        parameter,
        match nearest(name, known.iter().copied()) {
            Some(near) => format!("unknown material '{name}', did you mean '{near}'?"),
            None => format!(
                "unknown material '{name}', expected one of: {}",
                known.join(", ")
            ),
        },
    )
}
