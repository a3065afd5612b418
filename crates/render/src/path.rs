//! The integrator: a path tracer from the camera, with next-event estimation and multiple importance sampling.
//!
//! Each vertex is evaluated late. Its direction toward the light is drawn first; only when the next hit tells where
//! the light comes from, and with which coherence, its matrix is multiplied into the throughput.

use glam::Vec3A;

use crate::emitter::Emitter;
use crate::geometry::bvh::Stack;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, offset_origin};
use crate::light::Light;
use crate::material::{Departure, Material, Matter};
use crate::sampler::SampleStream;
use crate::scene::{Encounter, Scene};

/// Length of paths and how they end.
#[derive(Clone, Copy, Debug)]
pub struct PathOptions {
    /// Longest path: 1 sees emitters only, 2 one bounce, … `u32::MAX`: no limit.
    pub max_depth: u32,
    /// Paths longer than this may be ended by Russian roulette.
    pub rr_depth: u32,
    /// Whether the camera does not see emitters directly.
    pub hide_emitters: bool,
}

/// What tracing has cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counters {
    /// Camera samples.
    pub paths: u64,
    /// Closest-hit and shadow rays.
    pub rays: u64,
}

/// A vertex whose direction toward the light is drawn, waiting for the next hit.
struct Pending<'a> {
    material: &'a Material,
    frame: Frame,
    o: Vec3A,
    departure: Departure,
    position: Vec3A,
    /// The vertex's frame with its normal on the camera's side.
    lit_frame: Frame,
}

/// Random dimensions: the film takes 0 and 1, the wavelength 2; then eight a vertex.
const FIRST_VERTEX: u32 = 4;
const PER_VERTEX: u32 = 8;

/// A camera sample: where it looks and the wavelengths that it carries.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample<'a> {
    /// The ray.
    pub ray: Ray,
    /// First axis of its Stokes frame.
    pub axis: Vec3A,
    /// Wavelengths in nm, one a lane.
    pub wavelengths: &'a [f32],
    /// Its random numbers.
    pub stream: SampleStream,
}

/// The Stokes vector that one camera sample sees, in the frame of its ray.
pub fn trace<L: Light>(
    scene: &Scene,
    options: &PathOptions,
    sample: CameraSample<'_>,
    stack: &mut Stack,
    counters: &mut Counters,
) -> L::Stokes {
    let CameraSample {
        mut ray,
        axis,
        wavelengths,
        stream,
    } = sample;
    let mut seen = L::dark();
    let mut throughput = L::identity(axis);
    let mut pending: Option<Pending<'_>> = None;
    // ratio of the indices along the path: roulette looks at power, not at radiance
    let mut eta = 1.0f32;
    counters.paths += 1;

    let mut depth = 1u32;
    while depth <= options.max_depth {
        // find what the ray meets
        counters.rays += 1;
        let mut encounter = scene.intersect(&ray, stack);
        if options.hide_emitters && pending.is_none() {
            encounter = beyond_emitters(scene, &mut ray, encounter, stack, counters);
        }
        let visible_source = !(options.hide_emitters && pending.is_none());
        let source = match &encounter {
            Some(e) => e
                .owner
                .emitter
                .filter(|_| ray.direction.dot(e.surface.normal) < 0.0),
            None => scene.environment,
        }
        .filter(|_| visible_source);
        if encounter.is_none() && source.is_none() {
            break;
        }

        // evaluate the vertex behind, now that its light is known
        let mut share = 1.0;
        if let Some(from) = pending.take() {
            let coherence = scene.coherence(encounter.as_ref());
            let Departure {
                direction: i,
                density,
                discrete,
                ..
            } = from.departure;
            let (response, _) = from
                .material
                .respond::<L>(from.o, i, wavelengths, &coherence);
            let response = L::map_axes(response, |v| from.frame.to_world(v));
            throughput = L::extend(
                &throughput,
                response,
                density.recip(),
                from.frame.to_world(from.o),
            );
            if L::strength(&throughput) <= 0.0 {
                break;
            }
            if let (Some(emitter), false) = (source, discrete) {
                let other = match &encounter {
                    Some(e) => scene.density_of_hit(emitter, from.position, &e.surface),
                    None => scene.density_of_miss(&from.lit_frame, ray.direction),
                };
                share = power_heuristic(density, other);
            }
        }

        // light that the surface or the surroundings send out
        if let Some(emitter) = source {
            let emitter = &scene.emitters[emitter as usize];
            let radiance = L::lanes(|lane| emitter.spectrum(wavelengths[lane]));
            L::accumulate(&mut seen, L::collect(&throughput, radiance), share);
        }
        let Some(encounter) = encounter else { break };
        if depth >= options.max_depth {
            break;
        }

        // end weak paths
        let dimension = FIRST_VERTEX + PER_VERTEX * (depth - 1);
        let [choice, roulette] = stream.pair(dimension + 2);
        if depth > options.rr_depth {
            let survival = (L::strength(&throughput) * eta * eta).min(0.95);
            if roulette >= survival {
                break;
            }
            L::scale(&mut throughput, survival.recip());
        }

        let surface = encounter.surface;
        let frame = surface.frame;
        let o_world = -ray.direction;
        let o = frame.to_local(o_world);
        let material = &scene.materials[encounter.owner.material as usize];
        let lit_frame = if o.z < 0.0 { frame.flipped() } else { frame };

        // connect to a light source
        if !material.is_discrete()
            && let Some((emitter, connection)) =
                scene.connect(surface.position, &lit_frame, choice, stream.pair(dimension))
        {
            let i = frame.to_local(connection.direction);
            let coherence = scene.coherence(None);
            let (response, density) = material.respond::<L>(o, i, wavelengths, &coherence);
            // a density of zero: matter sends nothing that way
            if density > 0.0 {
                counters.rays += 1;
                if scene.is_visible(&surface, &connection, stack) {
                    let share = if connection.discrete {
                        1.0
                    } else {
                        power_heuristic(connection.density, density)
                    };
                    let response = L::map_axes(response, |v| frame.to_world(v));
                    let light = L::collect_through(
                        &throughput,
                        response,
                        o_world,
                        radiance_of::<L>(emitter, wavelengths),
                    );
                    L::accumulate(
                        &mut seen,
                        light,
                        share * connection.weight / connection.density,
                    );
                }
            }
        }

        // go on toward the light
        let [u, v] = stream.pair(dimension + 4);
        let [lobe, _] = stream.pair(dimension + 6);
        let Some(departure) = material.sample(o, wavelengths, [lobe, u, v]) else {
            break;
        };
        let direction = frame.to_world(departure.direction);
        eta *= departure.eta;
        ray = Ray {
            origin: offset_origin(surface.position, surface.error, surface.normal, direction),
            direction,
            t_max: f32::INFINITY,
        };
        pending = Some(Pending {
            material,
            frame,
            o,
            departure,
            position: surface.position,
            lit_frame,
        });
        depth += 1;
    }
    seen
}

fn radiance_of<L: Light>(emitter: &Emitter, wavelengths: &[f32]) -> L::Lanes {
    L::lanes(|lane| emitter.spectrum(wavelengths[lane]))
}

/// The first surface along the ray that does not shine.
fn beyond_emitters(
    scene: &Scene,
    ray: &mut Ray,
    mut encounter: Option<Encounter>,
    stack: &mut Stack,
    counters: &mut Counters,
) -> Option<Encounter> {
    while let Some(e) = encounter.filter(|e| e.owner.emitter.is_some()) {
        ray.origin = offset_origin(
            e.surface.position,
            e.surface.error,
            e.surface.normal,
            ray.direction,
        );
        counters.rays += 1;
        encounter = scene.intersect(ray, stack);
    }
    encounter
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
