//! Matter for paths side by side: one kind of matter, a path a lane.
//!
//! The kinds that scenes are mostly made of answer all lanes at once; the others are asked lane by lane, as
//! [`Matter`] answers one path.

mod coated;
mod facets;
mod fresnel;
mod plates;
mod rough;
mod smooth;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::diffuse::Diffuse;
use super::{Departure, Material, Matter, Part, Vertex};
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::lanes::{Axes, MOST, Mask, Real, V3, each, part, sin_cos_turns};
use crate::light::Sight;
use crate::light::abreast::{Abreast, Sights};
use crate::spectrum::Spectrum;

/// Points on matter, as camera paths meet it: [`Vertex`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<R> {
    /// Toward the camera, local.
    pub o: V3<R>,
    /// Where they are, metres.
    pub position: V3<R>,
    /// Shading normal and axis U.
    pub axes: Axes<R>,
    /// What polarization the sensor sees, local; blind where matter does not choose by it.
    pub sights: Sights<R>,
}

impl<R: Real> Vertices<R> {
    /// One by one.
    #[inline(always)]
    fn lanes(&self) -> [Vertex; MOST] {
        let (o, position) = (self.o.lanes(), self.position.lanes());
        let axes = [
            self.axes.s.lanes(),
            self.axes.t.lanes(),
            self.axes.n.lanes(),
        ];
        let sights = self.sights.lanes();
        let mut all = [Vertex {
            o: Vec3A::Z,
            position: Vec3A::ZERO,
            frame: Frame {
                s: Vec3A::X,
                t: Vec3A::Y,
                n: Vec3A::Z,
            },
            viewer_distance: f32::INFINITY,
            sight: Sight::BLIND,
        }; MOST];
        for (lane, vertex) in all.iter_mut().enumerate().take(R::LANES) {
            vertex.o = o[lane];
            vertex.position = position[lane];
            vertex.frame.s = axes[0][lane];
            vertex.frame.t = axes[1][lane];
            vertex.frame.n = axes[2][lane];
            vertex.sight = sights[lane];
        }
        all
    }
}

/// Directions toward the light that have been drawn, and what the matter makes of light from there.
#[derive(Clone, Copy, Debug)]
pub struct Departures<R: Real, A> {
    /// Where there is one.
    pub exist: R::M,
    /// Toward the light, local.
    pub direction: V3<R>,
    /// Density per steradian, or the probability where they are discrete.
    pub density: R,
    /// Where emitters can be connected to instead.
    pub continuous: R::M,
    /// Where light goes straight through.
    pub straight: R::M,
    /// Index of refraction on the light's side over that on the camera's side.
    pub eta: R,
    /// The Mueller matrices; axes are local.
    pub answers: A,
}

/// A spectrum at the wavelengths of the lanes.
#[inline(always)]
pub fn values<R: Real>(spectrum: &Spectrum, wavelengths: R) -> R {
    let first = wavelengths.lane(0);
    let same = wavelengths.eq(R::splat(first)).bits() == R::everywhere().bits();
    if same || spectrum.is_constant() {
        return R::splat(spectrum.value(first));
    }
    let all = wavelengths.lanes();
    R::from_fn(|lane| spectrum.value(all[lane]))
}

/// The direction mirrored at a normal.
#[inline(always)]
fn mirrored<R: Real>(o: V3<R>, normal: V3<R>) -> V3<R> {
    let twice = o.dot(normal);
    normal * (twice + twice) - o
}

/// The axis perpendicular to the plane of incidence: see [`axis_s`](super::axis_s).
#[inline(always)]
fn axes_s<R: Real>(normal: V3<R>, i: V3<R>) -> V3<R> {
    let across = normal.cross(i);
    let squared = across.squared();
    let clear = squared.gt(R::splat(1e-8));
    let s = across * squared.sqrt().recip();
    if (!clear & R::everywhere()).any() {
        V3::select(clear, s, Axes::around(i).s)
    } else {
        s
    }
}

/// Local z.
#[inline(always)]
fn upright<R: Real>() -> V3<R> {
    V3::splat(Vec3A::Z)
}

part!(Depart<'a; R, L: Abreast>(material: &'a Material, at: &'a Vertices<R>, wavelengths: &'a L::Values<R>, u: [R; 3],
    lanes: R::M) -> Departures<R, L::Answers<R>>: Material::depart_here::<R, L>);
part!(Answer<'a; R, L: Abreast>(material: &'a Material, at: &'a Vertices<R>, i: V3<R>, wavelengths: &'a L::Values<R>,
    lanes: R::M) -> (L::Answers<R>, R): Material::answer_here::<R, L>);
part!(Pass<'a; R, L: Abreast>(material: &'a Material, at: &'a Vertices<R>, wavelengths: &'a L::Values<R>, lanes: R::M)
    -> L::Answers<R>: Material::pass_here::<R, L>);
part!(EachAnswer<'a; R, L: Abreast>(material: &'a Material, at: &'a Vertices<R>, i: V3<R>,
    wavelengths: &'a L::Values<R>, lanes: R::M, part: Part) -> (L::Answers<R>, R): Material::each_answer::<R, L>);
part!(EachDeparture<'a; R, L: Abreast>(material: &'a Material, at: &'a Vertices<R>, wavelengths: &'a L::Values<R>,
    u: [R; 3], lanes: R::M) -> Departures<R, L::Answers<R>>: Material::each_departure::<R, L>);

impl Material {
    /// How many of the three uniform numbers [`Material::depart`] looks at.
    #[inline(always)]
    pub fn numbers(&self) -> usize {
        match self {
            Self::Conductor(_)
            | Self::Polarizer(_)
            | Self::Retarder(_)
            | Self::Circular(_)
            | Self::Null(_) => 0,
            Self::Dielectric(_) => 1,
            _ => 3,
        }
    }

    /// Whether all that it answers is depolarizing.
    #[inline(always)]
    pub fn forgets_polarization(&self) -> bool {
        matches!(self, Self::Diffuse(_))
    }

    /// Draws directions toward the light, from three uniform numbers each, and evaluates them; lanes outside `lanes` mean
    /// nothing.
    #[inline(always)]
    pub fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        R::apart(Depart::<R, L> {
            material: self,
            at,
            wavelengths,
            u,
            lanes,
        })
    }

    #[inline(always)]
    fn depart_here<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        match self {
            Self::Diffuse(m) => m.depart::<R, L>(at, wavelengths, u),
            Self::Conductor(m) => m.depart::<R, L>(at, wavelengths),
            Self::Dielectric(m) => m.depart::<R, L>(at, wavelengths, u),
            Self::RoughConductor(m) => m.depart::<R, L>(at, wavelengths, u),
            Self::RoughlyCoated(m) => m.depart::<R, L>(at, wavelengths, u, lanes),
            Self::Plastic(m) => m.depart::<R, L>(at, wavelengths, u),
            Self::Polarizer(_) | Self::Retarder(_) | Self::Circular(_) | Self::Null(_) => {
                Departures {
                    exist: lanes,
                    direction: -at.o,
                    density: R::one(),
                    continuous: R::nowhere(),
                    straight: lanes,
                    eta: R::one(),
                    answers: self.pass::<R, L>(at, wavelengths, lanes),
                }
            }
            _ => self.depart_one_by_one::<R, L>(at, wavelengths, u, lanes),
        }
    }

    /// What it makes of light from local directions `i` with a density per steradian, and that density.
    #[inline(always)]
    pub fn answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> (L::Answers<R>, R) {
        R::apart(Answer::<R, L> {
            material: self,
            at,
            i,
            wavelengths,
            lanes,
        })
    }

    #[inline(always)]
    fn answer_here<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> (L::Answers<R>, R) {
        match self {
            Self::Diffuse(m) => m.answer::<R, L>(at, i, wavelengths),
            Self::RoughConductor(m) => m.answer::<R, L>(at, i, wavelengths),
            Self::RoughlyCoated(m) => m.answer::<R, L>(at, i, wavelengths),
            Self::Plastic(m) => m.answer::<R, L>(at, i, wavelengths),
            _ => self.answer_one_by_one::<R, L>(at, i, wavelengths, lanes, Part::Continuous),
        }
    }

    /// What it makes of light that goes straight through.
    #[inline(always)]
    pub fn pass<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> L::Answers<R> {
        R::apart(Pass::<R, L> {
            material: self,
            at,
            wavelengths,
            lanes,
        })
    }

    #[inline(always)]
    fn pass_here<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> L::Answers<R> {
        match self {
            Self::Polarizer(m) => m.pass::<R, L>(at, wavelengths),
            Self::Retarder(m) => m.pass::<R, L>(at, wavelengths),
            Self::Circular(m) => m.pass::<R, L>(at, wavelengths),
            Self::Null(m) => m.pass::<R, L>(at),
            _ => {
                self.answer_one_by_one::<R, L>(at, -at.o, wavelengths, lanes, Part::Straight)
                    .0
            }
        }
    }

    #[inline(always)]
    fn answer_one_by_one<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
        part: Part,
    ) -> (L::Answers<R>, R) {
        R::apart(EachAnswer::<R, L> {
            material: self,
            at,
            i,
            wavelengths,
            lanes,
            part,
        })
    }

    #[inline(always)]
    fn each_answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
        part: Part,
    ) -> (L::Answers<R>, R) {
        let waves = lane_wavelengths::<R, L>(wavelengths);
        let (vertices, o, i) = (at.lanes(), at.o.lanes(), i.lanes());
        let mut densities = [0.0; MOST];
        let answers = L::gathered(lanes.bits(), &o, &i, |lane| {
            let (response, density) = self.respond::<L::Single>(
                &vertices[lane],
                i[lane],
                part,
                &waves[lane][..L::LANES],
                &Coherence::PLANE_WAVE,
            );
            densities[lane] = density;
            response
        });
        (answers, R::from_fn(|lane| densities[lane]))
    }

    #[inline(always)]
    fn depart_one_by_one<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        R::apart(EachDeparture::<R, L> {
            material: self,
            at,
            wavelengths,
            u,
            lanes,
        })
    }

    #[inline(always)]
    fn each_departure<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        let waves = lane_wavelengths::<R, L>(wavelengths);
        let (vertices, o) = (at.lanes(), at.o.lanes());
        let numbers = [u[0].lanes(), u[1].lanes(), u[2].lanes()];
        let mut drawn = [None::<Departure>; MOST];
        let mut directions = [Vec3A::Z; MOST];
        let (mut density, mut eta) = ([1.0; MOST], [1.0; MOST]);
        let (mut exist, mut continuous, mut straight) = (0, 0, 0);
        each(lanes.bits(), |lane| {
            let numbers = [numbers[0][lane], numbers[1][lane], numbers[2][lane]];
            let way = self.sample(&vertices[lane], &waves[lane][..L::LANES], numbers);
            if let Some(way) = &way {
                exist |= 1 << lane;
                continuous |= u32::from(way.part == Part::Continuous) << lane;
                straight |= u32::from(way.part == Part::Straight) << lane;
                directions[lane] = way.direction;
                density[lane] = way.density;
                eta[lane] = way.eta;
            }
            drawn[lane] = way;
        });
        let answers = L::gathered(exist, &o, &directions, |lane| {
            let part = drawn[lane].map_or(Part::Straight, |way| way.part);
            let waves = &waves[lane][..L::LANES];
            let (at, i) = (&vertices[lane], directions[lane]);
            self.respond::<L::Single>(at, i, part, waves, &Coherence::PLANE_WAVE)
                .0
        });
        Departures {
            exist: R::M::from_bits(exist),
            direction: V3::from_lanes(&directions),
            density: R::from_fn(|lane| density[lane]),
            continuous: R::M::from_bits(continuous),
            straight: R::M::from_bits(straight),
            eta: R::from_fn(|lane| eta[lane]),
            answers,
        }
    }
}

/// Most wavelengths of a path.
const WAVES: usize = 4;

/// The wavelengths of each lane.
#[inline(always)]
fn lane_wavelengths<R: Real, L: Abreast>(wavelengths: &L::Values<R>) -> [[f32; WAVES]; MOST] {
    let mut all = [[0.0; WAVES]; MOST];
    for (k, wavelength) in wavelengths.as_ref().iter().enumerate() {
        for (lane, value) in wavelength.lanes().into_iter().enumerate().take(R::LANES) {
            all[lane][k] = value;
        }
    }
    all
}

/// Directions around +z with density cos/π, as [`cosine_hemisphere`](crate::sampler::cosine_hemisphere) draws them.
#[inline(always)]
pub fn cosine_hemispheres<R: Real>([u, v]: [R; 2]) -> V3<R> {
    let (x, y) = (u + u - R::one(), v + v - R::one());
    let wide = x.abs().gt(y.abs());
    let (r, other) = (R::select(wide, x, y), R::select(wide, y, x));
    // eighths of a turn from the axis of the longer one
    let some = r.abs().gt(R::zero());
    let eighth = R::select(some, other / r, R::zero()) * R::splat(0.125);
    let turns = R::select(wide, eighth, R::splat(0.25) - eighth);
    let negative = turns.lt(R::zero());
    let (sin, cos) = sin_cos_turns(R::select(negative, turns + R::one(), turns));
    let (x, y) = (r * cos, r * sin);
    V3::new(x, y, (R::one() - x * x - y * y).max(R::zero()).sqrt())
}

impl Diffuse {
    #[inline(always)]
    fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
    ) -> Departures<R, L::Answers<R>> {
        let direction = cosine_hemispheres([u[1], u[2]]);
        let (m00, density) = self.reflected::<R, L>(at, direction, wavelengths);
        let exist = density.gt(R::zero());
        Departures {
            exist,
            direction,
            density,
            continuous: exist,
            straight: R::nowhere(),
            eta: R::one(),
            answers: L::depolarizing_lanes(m00),
        }
    }

    #[inline(always)]
    fn answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let (m00, density) = self.reflected::<R, L>(at, i, wavelengths);
        (L::depolarizing_lanes(m00), density)
    }

    /// M00 times the cosine, and the density of directions.
    #[inline(always)]
    fn reflected<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Values<R>, R) {
        let lit = at.o.z.gt(R::zero()) & i.z.gt(R::zero());
        let density = (i.z * R::splat(FRAC_1_PI)).only(lit);
        let mut m00 = *wavelengths;
        for value in m00.as_mut() {
            *value = values(self.reflectance(), *value) * density;
        }
        (m00, density)
    }
}
