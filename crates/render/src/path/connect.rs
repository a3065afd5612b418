//! Light that a vertex finds by looking for it: connections to points and to patches of emitters.

use glam::Vec3A;

use super::witness::Witness;
use super::{PathOptions, Walk, power_heuristic};
use crate::coherence::Coherence;
use crate::emitter::patch::{Cut, Patch};
use crate::emitter::{Connection, Emitter, Target};
use crate::geometry::frame::Frame;
use crate::geometry::ray::offset_origin;
use crate::light::{Emission, Light};
use crate::material::{Material, Matter, Part, Vertex};
use crate::scene::Scene;
use crate::shape::Surface;

/// As many patches as this are summed at one vertex; of more one is drawn.
///
/// By `path::patch_tests::what_summing_patches_costs`, which prints variance times time of either: where nothing hides the
/// lamp the sum has no noise at all, at the edge of a shadow it costs its time: 5 times as much as one patch for 16
/// patches, 20 times for 64.
const MOST_SUMMED: u32 = 16;

#[cfg(test)]
thread_local! {
    /// What tests want instead.
    pub(super) static MOST_SUMMED_HERE: std::cell::Cell<u32> = const { std::cell::Cell::new(MOST_SUMMED) };
}

/// Whether connections sum all patches of a cut, so that hits must not count.
#[inline]
pub(super) fn sums_all(cut: &Cut<'_>) -> bool {
    #[cfg(test)]
    let most = MOST_SUMMED_HERE.get();
    #[cfg(not(test))]
    let most = MOST_SUMMED;
    cut.len() <= most
}

/// Largest half-width of a patch, radians: cosines, distances and Fresnel coefficients are taken at its centre, which
/// errs by the square of it.
const WIDEST_PATCH: f32 = 0.05;

/// The half-width of patches for matter with a lobe of the given width.
#[inline]
pub(super) fn largest_patch(options: &PathOptions, lobe: f32) -> f32 {
    (options.patch * lobe).min(WIDEST_PATCH)
}

/// Density per steradian of connections to a patch of a cut of which one is drawn, with the choice of the emitter.
#[inline]
pub(super) fn patch_density(scene: &Scene, cut: &Cut<'_>, patch: &Patch) -> f32 {
    scene.chance_of_emitter() / (patch.solid_angle * cut.len() as f32)
}

/// A vertex that looks for light.
pub(super) struct Place<'a> {
    pub(super) material: &'a Material,
    pub(super) surface: &'a Surface,
    pub(super) vertex: &'a Vertex,
    /// The frame with its normal on the camera's side.
    pub(super) lit_frame: &'a Frame,
    /// Width of the lobe if the matter answers to coherence.
    pub(super) lobe: Option<f32>,
    /// How much matter may let the light straight through on its way.
    pub(super) room: u32,
}

/// Light on its way from a source to a vertex.
struct Arrival<L: Light> {
    response: L::Response,
    emission: Emission<L>,
    /// Toward the centre of what is averaged: the light comes along `−direction`.
    direction: Vec3A,
    coherence: Coherence,
    weight: f32,
}

impl<L: Light, W: Witness> Walk<'_, L, W> {
    /// Adds the light of one emitter, chosen with probability `chosen`.
    #[inline]
    pub(super) fn connect(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        emitter: &Emitter,
        chosen: f32,
        u: [f32; 3],
    ) {
        let position = place.surface.position;
        if let Some(lobe) = place.lobe
            && let Some(cut) = emitter.cut(self.scene, position, largest_patch(self.options, lobe))
        {
            self.connect_patch(throughput, place, emitter, chosen, &cut, u);
            return;
        }
        let Some(connection) = emitter.connect(self.scene, position, place.lit_frame, [u[0], u[1]])
        else {
            return;
        };
        let Connection {
            direction,
            target,
            coherence,
            ..
        } = connection;
        let frame = place.vertex.frame;
        let (response, own) = place.material.respond::<L>(
            place.vertex,
            frame.to_local(direction),
            Part::Continuous,
            self.wavelengths,
            &coherence,
        );
        // a density of zero: matter sends nothing that way
        if own <= 0.0 {
            return;
        }
        let straight = self.scene.traits().straight;
        if !straight {
            self.counters.rays += 1;
            let ray = Scene::shadow_ray(place.surface, direction, target.as_ref());
            if !self.scene.is_free(&ray, self.stack) {
                return;
            }
        }
        let density = connection.density * chosen;
        let share = if connection.discrete {
            1.0
        } else {
            power_heuristic(density, own)
        };
        let weight = share * connection.weight / density;
        let response = L::map_axes(response, |v| frame.to_world(v));
        let source = target.map_or(Vec3A::ZERO, |t| t.position);
        let emission = emitter.emit(-direction, source, self.wavelengths);
        if straight {
            let arrival = Arrival {
                response,
                emission,
                direction,
                coherence,
                weight,
            };
            self.add_through(throughput, place, &arrival, direction, target.as_ref());
        } else {
            let o = frame.to_world(place.vertex.o);
            let light = L::collect_through(throughput, response, o, &emission, -direction);
            self.add_light(light, weight, Some((direction, coherence)));
        }
    }

    /// Adds the light of the patches of an emitter.
    #[inline(never)]
    fn connect_patch(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        emitter: &Emitter,
        chosen: f32,
        cut: &Cut<'_>,
        u: [f32; 3],
    ) {
        let arrival = if sums_all(cut) {
            self.all_patches(throughput, place, emitter, cut, u[2])
                .map(|(mut arrival, index)| {
                    arrival.weight /= chosen;
                    (arrival, index)
                })
        } else {
            self.one_patch(place, emitter, cut, u[2])
        };
        if let Some((arrival, index)) = arrival
            && let Some((direction, target)) = cut.point(index, [u[0], u[1]])
        {
            self.add(throughput, place, &arrival, direction, target);
        }
    }

    /// The response of a vertex to light from a world direction, its axes in the world, and the density of the direction.
    #[inline]
    fn respond(
        &self,
        place: &Place<'_>,
        direction: Vec3A,
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let frame = place.vertex.frame;
        let (response, density) = place.material.respond::<L>(
            place.vertex,
            frame.to_local(direction),
            Part::Continuous,
            self.wavelengths,
            coherence,
        );
        (L::map_axes(response, |v| frame.to_world(v)), density)
    }

    /// One patch, drawn evenly, against rays that hit it.
    fn one_patch(
        &self,
        place: &Place<'_>,
        emitter: &Emitter,
        cut: &Cut<'_>,
        u: f32,
    ) -> Option<(Arrival<L>, u32)> {
        let count = cut.len();
        let index = ((u * count as f32) as u32).min(count - 1);
        let patch = cut.patch(index);
        let (response, own) = self.respond(place, patch.direction, &patch.coherence());
        if own <= 0.0 {
            return None;
        }
        let density = patch_density(self.scene, cut, &patch);
        let share = if emitter.can_be_met() {
            power_heuristic(density, own)
        } else {
            1.0
        };
        let arrival = Arrival {
            response,
            emission: emitter.emit(-patch.direction, patch.centre, self.wavelengths),
            direction: patch.direction,
            coherence: patch.coherence(),
            weight: share / density,
        };
        Some((arrival, index))
    }

    /// All patches: one stands for the sum, drawn in proportion to its light, so that only visibility is left to chance.
    fn all_patches(
        &self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        emitter: &Emitter,
        cut: &Cut<'_>,
        mut u: f32,
    ) -> Option<(Arrival<L>, u32)> {
        let o = place.vertex.frame.to_world(place.vertex.o);
        let mut standing = None;
        let (mut sum, mut standing_power) = (0.0, 0.0);
        for index in 0..cut.len() {
            let patch = cut.patch(index);
            let (response, own) = self.respond(place, patch.direction, &patch.coherence());
            if own <= 0.0 {
                continue;
            }
            let emission = emitter.emit(-patch.direction, patch.centre, self.wavelengths);
            let light = L::collect_through(throughput, response, o, &emission, -patch.direction);
            let power = light
                .as_ref()
                .iter()
                .fold(0.0, |most: f32, s| most.max(s.x))
                * patch.solid_angle;
            if power <= 0.0 {
                continue;
            }
            sum += power;
            // weighted reservoir of one; what is left of `u` is uniform again
            let share = power / sum;
            if u < share {
                u /= share;
                standing_power = power;
                let arrival = Arrival {
                    response,
                    emission,
                    direction: patch.direction,
                    coherence: patch.coherence(),
                    weight: patch.solid_angle,
                };
                standing = Some((arrival, index));
            } else {
                u = (u - share) / (1.0 - share);
            }
        }
        standing.map(|(mut arrival, index)| {
            arrival.weight *= sum / standing_power;
            (arrival, index)
        })
    }

    /// Adds the light if nothing stands between the vertex and a point of the source.
    #[inline]
    fn add(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        arrival: &Arrival<L>,
        direction: Vec3A,
        target: Option<Target>,
    ) {
        let o = place.vertex.frame.to_world(place.vertex.o);
        let k = -arrival.direction;
        let source = Some((arrival.direction, arrival.coherence));
        if self.scene.traits().straight {
            self.add_through(throughput, place, arrival, direction, target.as_ref());
            return;
        }
        self.counters.rays += 1;
        let ray = Scene::shadow_ray(place.surface, direction, target.as_ref());
        if self.scene.is_free(&ray, self.stack) {
            let light = L::collect_through(throughput, arrival.response, o, &arrival.emission, k);
            self.add_light(light, arrival.weight, source);
        }
    }

    /// The same where flat matter may stand on the way.
    #[inline(never)]
    fn add_through(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        arrival: &Arrival<L>,
        direction: Vec3A,
        target: Option<&Target>,
    ) {
        let o = place.vertex.frame.to_world(place.vertex.o);
        let k = -arrival.direction;
        let source = Some((arrival.direction, arrival.coherence));
        if let Some(passage) = self.straight_passage(place, direction, target) {
            let light = match passage {
                None => L::collect_through(throughput, arrival.response, o, &arrival.emission, k),
                Some(passage) => {
                    let before = L::extend(throughput, arrival.response, 1.0, o);
                    L::collect_through(&before, passage, k, &arrival.emission, k)
                }
            };
            self.add_light(light, arrival.weight, source);
        }
    }

    /// What flat matter on the way does to the light: `None` if something opaque stands there, `Some(None)` if nothing.
    fn straight_passage(
        &mut self,
        place: &Place<'_>,
        direction: Vec3A,
        target: Option<&Target>,
    ) -> Option<Option<L::Response>> {
        let axis = Frame::around(direction).s;
        let mut through: Option<L::Throughput> = None;
        let mut from = *place.surface;
        for _ in 0..=place.room {
            self.counters.rays += 1;
            let ray = Scene::shadow_ray(&from, direction, target);
            let Some(met) = self.scene.intersect(&ray, self.stack) else {
                return Some(through.map(|t| L::as_response(&t, axis)));
            };
            if !self.scene.traits_of(met.owner.material).straight {
                return None;
            }
            let frame = met.surface.frame;
            let i = frame.to_local(direction);
            let vertex = Vertex {
                o: -i,
                position: met.surface.position,
                frame,
                viewer_distance: (met.surface.position - from.position).length(),
            };
            let material = &self.scene.materials[met.owner.material as usize];
            let (response, _) = material.respond::<L>(
                &vertex,
                i,
                Part::Straight,
                self.wavelengths,
                &Coherence::PLANE_WAVE,
            );
            let response = L::map_axes(response, |v| frame.to_world(v));
            let before = through.unwrap_or_else(|| L::identity(axis));
            let after = L::extend(&before, response, 1.0, -direction);
            if L::strength(&after) <= 0.0 {
                return None;
            }
            through = Some(after);
            // the next ray starts behind this surface
            from = Surface {
                position: offset_origin(
                    met.surface.position,
                    met.surface.error,
                    met.surface.normal,
                    direction,
                ),
                error: Vec3A::ZERO,
                ..met.surface
            };
        }
        None
    }
}
