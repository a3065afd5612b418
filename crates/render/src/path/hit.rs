//! Light of emitters that a path has met, weighed against the connections that could have found it.

use glam::Vec3A;

use super::witness::Witness;
use super::{Origin, Waiting, Walk, connect, power_heuristic};
use crate::coherence::Coherence;
use crate::geometry::ray::Ray;
use crate::light::Light;
use crate::scene::Encounter;

impl<'a, L: Light, W: Witness> Walk<'a, L, W> {
    /// Light of an emitter that the path has met.
    #[inline]
    pub(super) fn collect_hit(
        &mut self,
        throughput: &L::Throughput,
        origin: Option<&Origin>,
        waiting: Option<&Waiting<'a>>,
        emitter: u32,
        encounter: Option<&Encounter>,
        ray: &Ray,
    ) {
        let source = &self.scene.emitters[emitter as usize];
        let k = -ray.direction;
        let share = match (origin, waiting) {
            (None, _) => 1.0,
            (Some(origin), None) => self.plane_wave_share(origin, emitter, encounter),
            (Some(origin), Some(from)) => {
                self.collect_patch(throughput, origin, from, emitter, encounter, ray);
                return;
            }
        };
        let position = encounter.map_or(Vec3A::ZERO, |e| e.surface.position);
        let emission = source.emit::<L>(k, position, self.wavelengths);
        self.add_light(L::collect(throughput, &emission, k), share, None);
    }

    /// Weight of a hit beside connections from the vertex behind to single directions of the same light.
    #[inline]
    fn plane_wave_share(&self, from: &Origin, emitter: u32, encounter: Option<&Encounter>) -> f32 {
        let other = match encounter {
            _ if !self.way.straight => return 1.0,
            Some(e) => self
                .scene
                .density_of_hit(emitter, from.position, &e.surface),
            None => self
                .scene
                .density_of_miss(&from.lit_frame, self.way.direction),
        };
        power_heuristic(from.density, other)
    }

    /// Light of an emitter for a vertex behind that has waited for it: with the coherence of the patch that was hit.
    #[inline(never)]
    fn collect_patch(
        &mut self,
        throughput: &L::Throughput,
        origin: &Origin,
        from: &Waiting<'a>,
        emitter: u32,
        encounter: Option<&Encounter>,
        ray: &Ray,
    ) {
        let scene = self.scene;
        let source = &scene.emitters[emitter as usize];
        let (k, position) = (
            -ray.direction,
            encounter.map_or(Vec3A::ZERO, |e| e.surface.position),
        );
        let largest = connect::largest_patch(self.options, from.lobe);
        let cut = match encounter {
            Some(_) if self.way.straight => source.cut(scene, from.vertex.position, largest),
            _ => None,
        };
        let (response, share, position, i, coherence) = if let Some(cut) = cut {
            if connect::sums_all(&cut) {
                // connections have seen all of it
                return;
            }
            let patch = cut.patch(cut.find(position, self.way.direction));
            let i = from.vertex.frame.to_local(patch.direction);
            let (response, own) = self.respond_behind(from, i, &patch.coherence());
            let other = connect::patch_density(scene, &cut, &patch);
            (
                response,
                power_heuristic(own, other),
                patch.centre,
                i,
                patch.coherence(),
            )
        } else if !self.way.straight
            && let Some(e) = encounter
            && let Some(patch) = self.patch_through(from, source, &e.surface, ray, largest)
        {
            let i = from.vertex.frame.to_local(patch.direction);
            let (response, _) = self.respond_behind(from, i, &patch.coherence());
            (response, 1.0, patch.centre, i, patch.coherence())
        } else {
            let i = from.departure.direction;
            let (response, _) = self.respond_behind(from, i, &Coherence::PLANE_WAVE);
            (
                response,
                self.plane_wave_share(origin, emitter, encounter),
                position,
                i,
                Coherence::PLANE_WAVE,
            )
        };
        let throughput = self.through(throughput, from, response);
        let emission = source.emit::<L>(k, position, self.wavelengths);
        let toward = from.vertex.frame.to_world(i);
        self.add_light(
            L::collect(&throughput, &emission, k),
            share,
            Some((toward, coherence)),
        );
    }
}
