//! Light that a vertex finds by looking for it: connections to single points of emitters, and what stands on the way.

use glam::Vec3A;

use super::witness::Witness;
use super::{POINT, ROULETTE, Walk, power_heuristic};
use crate::coherence::Coherence;
use crate::emitter::{Connection, Emitter, Target};
use crate::geometry::frame::Frame;
use crate::geometry::ray::offset_origin;
use crate::light::{Emission, Light, Sight};
use crate::material::{Material, Matter, Part, Vertex};
use crate::scene::Scene;
use crate::shape::Surface;

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
pub(super) struct Arrival<L: Light> {
    pub(super) response: L::Response,
    pub(super) emission: Emission<L>,
    /// Toward the centre of what is averaged: the light comes along `−direction`.
    pub(super) direction: Vec3A,
    pub(super) coherence: Coherence,
    pub(super) weight: f32,
}

impl<L: Light, W: Witness> Walk<'_, L, W> {
    /// Adds the light of one emitter, or of several if the matter answers to coherence; `dimension` is the vertex's first.
    #[inline]
    pub(super) fn connect(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        choice: f32,
        dimension: u32,
    ) {
        if let Some(lobe) = place.lobe {
            let [u, v] = self.stream.pair(dimension + POINT);
            let [_, which] = self.stream.pair(dimension + ROULETTE);
            self.connect_lobe(throughput, place, lobe, choice, [u, v, which]);
        } else if let Some((emitter, chosen)) =
            self.scene.choose_emitter(place.surface.position, choice)
        {
            let u = self.stream.pair(dimension + POINT);
            self.connect_point(throughput, place, emitter, chosen, u);
        }
    }

    /// Adds the light of one emitter, chosen with probability `chosen`.
    #[inline]
    pub(super) fn connect_point(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        emitter: &Emitter,
        chosen: f32,
        u: [f32; 2],
    ) {
        let position = place.surface.position;
        let Some(connection) = emitter.connect(self.scene, position, place.lit_frame, u) else {
            return;
        };
        let Connection {
            direction,
            target,
            coherence,
            ..
        } = connection;
        let Some((response, own)) = self.answer(place, direction, &coherence) else {
            return;
        };
        self.add(throughput, place, direction, target.as_ref(), |walk| {
            let density = connection.density * chosen;
            let share = if connection.discrete {
                1.0
            } else {
                power_heuristic(density, own)
            };
            let weight = share * connection.weight / density;
            let source = target.map_or(Vec3A::ZERO, |t| t.position);
            walk.arrival(
                place,
                emitter,
                (direction, source),
                response,
                coherence,
                weight,
            )
        });
    }

    /// What the matter makes of light from a direction, with the density of that direction; `None` if it ignores it.
    #[inline]
    pub(super) fn answer(
        &self,
        place: &Place<'_>,
        direction: Vec3A,
        coherence: &Coherence,
    ) -> Option<(L::Response, f32)> {
        let (response, own) = place.material.respond::<L>(
            place.vertex,
            place.vertex.frame.to_local(direction),
            Part::Continuous,
            self.wavelengths,
            coherence,
        );
        // a density of zero: matter sends nothing that way
        (own > 0.0).then_some((response, own))
    }

    /// The light of an emitter from a point of it in a direction, for matter that answers it with `response`.
    #[inline]
    pub(super) fn arrival(
        &self,
        place: &Place<'_>,
        emitter: &Emitter,
        (direction, source): (Vec3A, Vec3A),
        response: L::Response,
        coherence: Coherence,
        weight: f32,
    ) -> Arrival<L> {
        let frame = place.vertex.frame;
        Arrival {
            response: L::map_axes(response, |v| frame.to_world(v)),
            emission: emitter.emit(-direction, source, self.wavelengths),
            direction,
            coherence,
            weight,
        }
    }

    /// Adds light if nothing stands between the vertex and a point of the source; it is asked for once that is known.
    #[inline]
    pub(super) fn add(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        direction: Vec3A,
        target: Option<&Target>,
        arrival: impl FnOnce(&Self) -> Arrival<L>,
    ) {
        if self.scene.traits().straight {
            let arrival = arrival(self);
            self.add_through(throughput, place, &arrival, direction, target);
            return;
        }
        self.counters.rays += 1;
        let ray = Scene::shadow_ray(place.surface, direction, target);
        if self.scene.is_free(&ray, self.stack) {
            let arrival = arrival(self);
            let o = place.vertex.frame.to_world(place.vertex.o);
            let k = -arrival.direction;
            let light = L::collect_through(throughput, arrival.response, o, &arrival.emission, k);
            let source = Some((arrival.direction, arrival.coherence));
            self.add_light(light, arrival.weight, source);
        }
    }

    /// Adds the light if nothing stands on the way but flat matter, which it passes.
    #[inline(never)]
    pub(super) fn add_through(
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
                sight: Sight::BLIND,
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
