//! The integrator: a path tracer from the camera, with next-event estimation and multiple importance sampling.
//!
//! Matter that answers to coherence is evaluated late. Its direction toward the light is drawn first; only when the
//! light's origin is known, and with it the coherence, its matrix is multiplied into the throughput. Until then the
//! specular matter on the way is kept apart (`way.rs`).
//!
//! Emitters are cut into patches for such a vertex. Connections average its transfer over a patch; if the patches are
//! few all of them are summed and only visibility is left to chance. Rays that hit a patch use the same average, and
//! the weights of both are constant on a patch, so that the expected image does not depend on the cut.
//!
//! `connect.rs` looks for light from a vertex, `lobe.rs` from one that answers to coherence, `hit.rs` takes what a ray has
//! met, `way.rs` follows specular matter, `witness.rs` asks where the light came from, `plane.rs` begins paths on a bare
//! sensor plane.

mod connect;
mod hit;
mod lobe;
#[cfg(test)]
mod patch_tests;
mod plane;
pub mod wavefront;
mod way;
pub mod witness;

use glam::Vec3A;

use crate::coherence::Coherence;
use crate::geometry::bvh::Stack;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, offset_origin};
use crate::light::{Light, Sight};
use crate::material::{Departure, Material, Matter, Part, Vertex};
use crate::sampler::SampleStream;
use crate::scene::{Encounter, Scene};
pub use plane::{PlanePoint, Start};
use way::Way;
use witness::Witness;

/// Length of paths and how they end.
#[derive(Clone, Copy, Debug)]
pub struct PathOptions {
    /// Longest path: 1 sees emitters only, 2 one bounce, … `u32::MAX`: no limit.
    pub max_depth: u32,
    /// Paths longer than this may be ended by Russian roulette.
    pub rr_depth: u32,
    /// Whether the camera does not see emitters directly.
    pub hide_emitters: bool,
    /// Half-width of emitter patches, in widths of the lobe that sees them; 0: single points, no patches.
    pub patch: f32,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self {
            max_depth: u32::MAX,
            rr_depth: 5,
            hide_emitters: false,
            patch: 0.5,
        }
    }
}

/// What tracing has cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counters {
    /// Paths from the camera: one for each group of wavelengths of a sample that goes together, and as many again where
    /// coherence is followed.
    pub paths: u64,
    /// Closest-hit and shadow rays.
    pub rays: u64,
}

/// The last vertex with a continuous lobe: what weighs its direction against connections.
struct Origin {
    position: Vec3A,
    /// The vertex's frame with its normal on the camera's side.
    lit_frame: Frame,
    /// Of the direction that was drawn.
    density: f32,
}

/// That vertex while its response waits for the coherence of the light, and is not yet in the throughput.
struct Waiting<'a> {
    material: &'a Material,
    vertex: Vertex,
    /// Half-widths of the box that contains the true point, and the geometric normal: where its rays start.
    start: (Vec3A, Vec3A),
    departure: Departure,
    /// Width of its lobe.
    lobe: f32,
}

/// Random dimensions: the film takes 0 and 1, the wavelength 2; then eight a vertex, in pairs, drawn when they are needed.
const FIRST_VERTEX: u32 = 4;
const PER_VERTEX: u32 = 8;
/// Of a vertex: a point on a light source.
const POINT: u32 = 0;
/// Which light source, and which part of the matter.
const CHOICES: u32 = 2;
/// The direction that the path takes.
const DIRECTION: u32 = 4;
/// Whether it ends, and which of several patches.
const ROULETTE: u32 = 6;

/// A camera sample: where it looks and the wavelengths that it carries.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample<'a> {
    /// Where its path begins.
    pub start: &'a Start<'a>,
    /// Wavelengths in nm, one a lane.
    pub wavelengths: &'a [f32],
    /// Its random numbers.
    pub stream: SampleStream,
}

/// One camera sample on its way.
struct Walk<'a, L: Light, W: Witness> {
    scene: &'a Scene,
    options: &'a PathOptions,
    wavelengths: &'a [f32],
    stream: SampleStream,
    stack: &'a mut Stack,
    counters: &'a mut Counters,
    witness: &'a mut W,
    /// The specular matter since the last vertex with a continuous lobe.
    way: Way<L>,
    seen: L::Stokes,
}

/// The Stokes vector that one camera sample sees, in the frame of its start; `witness` hears of every contribution.
pub fn trace<L: Light, W: Witness>(
    scene: &Scene,
    options: &PathOptions,
    sample: CameraSample<'_>,
    stack: &mut Stack,
    counters: &mut Counters,
    witness: &mut W,
) -> L::Stokes {
    counters.paths += 1;
    Walk::<L, W>::new(scene, options, &sample, stack, counters, witness).follow(sample.start)
}

impl<'a, L: Light, W: Witness> Walk<'a, L, W> {
    #[inline]
    fn new(
        scene: &'a Scene,
        options: &'a PathOptions,
        sample: &CameraSample<'a>,
        stack: &'a mut Stack,
        counters: &'a mut Counters,
        witness: &'a mut W,
    ) -> Self {
        Self {
            scene,
            options,
            wavelengths: sample.wavelengths,
            stream: sample.stream,
            stack,
            counters,
            witness,
            way: Way::new(Vec3A::Z),
            seen: L::dark(),
        }
    }

    /// The light that a path from its start collects.
    #[inline]
    fn follow(mut self, start: &Start<'_>) -> L::Stokes {
        match start {
            Start::Ray { ray, axis } => {
                self.way.begin(ray.direction);
                self.run(*ray, L::identity(*axis), None);
                self.seen
            }
            Start::Plane(point) => {
                if let Some((ray, throughput, origin)) = self.leave_plane(point) {
                    self.run(ray, throughput, Some(origin));
                }
                self.seen_in(point.scale)
            }
        }
    }

    #[inline(never)]
    fn run(&mut self, mut ray: Ray, mut throughput: L::Throughput, mut origin: Option<Origin>) {
        let (scene, options) = (self.scene, self.options);
        let mut waiting: Option<Waiting<'a>> = None;
        // ratio of the indices along the path: roulette looks at power, not at radiance
        let mut eta = 1.0f32;

        self.counters.rays += 1;
        let mut encounter = scene.intersect(&ray, self.stack);
        let mut shows_emitters = true;
        if options.hide_emitters && origin.is_none() {
            encounter = self.beyond_emitters(ray, encounter);
            shows_emitters = false;
        }
        for depth in 1..=options.max_depth {
            // light that the surface or the surroundings send out
            let source = match &encounter {
                Some(e) => e
                    .owner
                    .emitter
                    .filter(|_| ray.direction.dot(e.surface.normal) < 0.0),
                None => scene.environment,
            };
            if let Some(emitter) = source.filter(|_| shows_emitters) {
                self.collect_hit(
                    &throughput,
                    origin.as_ref(),
                    waiting.as_ref(),
                    emitter,
                    encounter.as_ref(),
                    &ray,
                );
            }
            let Some(Encounter { surface, owner }) = encounter else {
                break;
            };
            if depth == options.max_depth {
                break;
            }
            let material = &scene.materials[owner.material as usize];
            let traits = scene.traits_of(owner.material);
            if traits.black {
                break;
            }

            let arm = (surface.position - ray.origin).length();

            // light that matter scatters comes to the vertex behind from a point; what that matter lets through
            // unscattered still has to tell where it comes from
            let mut scattered = waiting
                .as_ref()
                .filter(|_| !traits.discrete)
                .map(|from| self.point_through(&throughput, from, arm));
            if scattered.as_ref().is_some_and(|s| L::strength(s) <= 0.0) {
                break;
            }
            let known = scattered.is_some() || waiting.is_none();

            // end weak paths: those that no light can make strong at the sensor
            let dimension = FIRST_VERTEX + PER_VERTEX * (depth - 1);
            if depth > options.rr_depth && known {
                let [roulette, _] = self.stream.pair(dimension + ROULETTE);
                let reach = scattered.as_ref().unwrap_or(&throughput);
                let survival = (L::reach(reach) * eta * eta).min(0.95);
                if roulette >= survival {
                    break;
                }
                L::scale(&mut throughput, survival.recip());
                if let Some(scattered) = &mut scattered {
                    L::scale(scattered, survival.recip());
                }
            }

            let frame = surface.frame;
            let o_world = -ray.direction;
            let vertex = Vertex {
                o: frame.to_local(o_world),
                position: surface.position,
                frame,
                viewer_distance: arm,
                sight: if L::POLARIZED && traits.chooses && waiting.is_none() {
                    L::sight(&throughput).map_axis(|v| frame.to_local(v))
                } else {
                    Sight::BLIND
                },
            };
            let lit_frame = if vertex.o.z < 0.0 {
                frame.flipped()
            } else {
                frame
            };
            let lobe = if traits.coherent && options.patch > 0.0 {
                material.lobe_width(&vertex, self.wavelengths)
            } else {
                None
            };

            if !traits.discrete {
                self.witness.meets(lit_frame.n, eta);
            }

            // connect to a light source
            let [choice, drawn] = self.stream.pair(dimension + CHOICES);
            if !traits.discrete {
                let place = connect::Place {
                    material,
                    surface: &surface,
                    vertex: &vertex,
                    lit_frame: &lit_frame,
                    lobe,
                    // links that a way through flat matter may still have
                    room: options.max_depth - depth - 1,
                };
                let reach = scattered.as_ref().unwrap_or(&throughput);
                self.connect(reach, &place, choice, dimension);
            }

            // the last ray is for light alone
            if depth + 1 == options.max_depth && scene.emitters_are_unmet() {
                break;
            }

            // go on toward the light
            let [u, v] = self.stream.pair(dimension + DIRECTION);
            let Some(departure) = material.sample(&vertex, self.wavelengths, [drawn, u, v]) else {
                break;
            };
            let direction = frame.to_world(departure.direction);
            self.witness.departs(
                ray.direction,
                direction,
                departure.direction.z * vertex.o.z > 0.0,
            );
            eta *= departure.eta;
            shows_emitters = true;
            ray = Ray {
                origin: offset_origin(surface.position, surface.error, surface.normal, direction),
                direction,
                t_max: f32::INFINITY,
            };
            self.counters.rays += 1;
            encounter = scene.intersect(&ray, self.stack);
            // nothing is evaluated for a ray that brings no light
            if encounter.is_none() && scene.environment.is_none() {
                break;
            }

            let continuous = departure.part == Part::Continuous;
            if continuous && let Some(scattered) = scattered {
                throughput = scattered;
                waiting = None;
            }
            if continuous && let Some(lobe) = lobe {
                waiting = Some(Waiting {
                    material,
                    vertex,
                    start: (surface.error, surface.normal),
                    departure,
                    lobe,
                });
            } else {
                // matter that answers to coherence, without patches: light comes from a point
                let coherence = match &encounter {
                    Some(next) if traits.coherent => {
                        let arm = (next.surface.position - surface.position).length();
                        Coherence::from_point(arm)
                    }
                    _ => Coherence::PLANE_WAVE,
                };
                let (response, _) = material.respond::<L>(
                    &vertex,
                    departure.direction,
                    departure.part,
                    self.wavelengths,
                    &coherence,
                );
                let response = L::map_axes(response, |v| frame.to_world(v));
                let weight = departure.density.recip();
                if let Some(from) = waiting.as_ref() {
                    self.way
                        .extend(response, weight, o_world, vertex.viewer_distance);
                    self.way.note(departure.part, owner.material);
                    if self.way.is_lost() {
                        throughput = self.point_through(&throughput, from, 0.0);
                        waiting = None;
                    }
                } else {
                    L::lengthen(&mut throughput, response, weight, o_world);
                    self.way.straight &= departure.part == Part::Straight;
                }
            }
            if continuous {
                origin = Some(Origin {
                    position: surface.position,
                    lit_frame,
                    density: departure.density,
                });
                self.way.begin(direction);
            }
            if L::strength(&throughput) <= 0.0 {
                break;
            }
        }
    }

    /// What the vertex behind makes of light along local `i`, its axes in the world, and the density of the direction.
    #[inline]
    fn respond_behind(
        &self,
        from: &Waiting<'_>,
        i: Vec3A,
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let frame = from.vertex.frame;
        let (response, density) = from.material.respond::<L>(
            &from.vertex,
            i,
            from.departure.part,
            self.wavelengths,
            coherence,
        );
        (L::map_axes(response, |v| frame.to_world(v)), density)
    }

    /// The throughput with the vertex behind and the specular matter since.
    #[inline]
    fn through(
        &self,
        throughput: &L::Throughput,
        from: &Waiting<'_>,
        response: L::Response,
    ) -> L::Throughput {
        let o = from.vertex.frame.to_world(from.vertex.o);
        let weight = from.departure.density.recip();
        self.way.after(L::extend(throughput, response, weight, o))
    }

    /// The same for light from a point in the direction that was drawn, as far beyond the way so far as `arm`.
    #[inline]
    fn point_through(
        &self,
        throughput: &L::Throughput,
        from: &Waiting<'_>,
        arm: f32,
    ) -> L::Throughput {
        let i = from.departure.direction;
        let coherence = Coherence::from_point(self.way.length + arm);
        let (response, _) = self.respond_behind(from, i, &coherence);
        self.through(throughput, from, response)
    }

    /// Light that has arrived at the sensor; `arrival` as [`Witness::hears`] has it.
    #[inline]
    fn add_light(&mut self, light: L::Stokes, weight: f32, arrival: Option<(Vec3A, Coherence)>) {
        self.witness.hears(light.as_ref(), weight, arrival);
        L::accumulate(&mut self.seen, light, weight);
    }

    /// The first surface along the ray that does not shine.
    fn beyond_emitters(
        &mut self,
        mut ray: Ray,
        mut encounter: Option<Encounter>,
    ) -> Option<Encounter> {
        while let Some(e) = encounter.filter(|e| e.owner.emitter.is_some()) {
            ray.origin = offset_origin(
                e.surface.position,
                e.surface.error,
                e.surface.normal,
                ray.direction,
            );
            self.counters.rays += 1;
            encounter = self.scene.intersect(&ray, self.stack);
        }
        encounter
    }
}

/// Weight of a sample drawn with density `own` where another strategy has density `other`.
///
/// Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997, section 9.2.4 (β = 2).
#[inline]
fn power_heuristic(own: f32, other: f32) -> f32 {
    // as a ratio: squares of large densities overflow
    let ratio = other / own;
    (1.0 + ratio * ratio).recip()
}
