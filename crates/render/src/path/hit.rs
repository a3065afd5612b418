//! Light of emitters that a path has met, weighed against the connections that could have found it.

use glam::Vec3A;

use super::witness::Witness;
use super::{Origin, Waiting, Walk, lobe, power_heuristic};
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
            (Some(origin), Some(from)) => {
                self.collect_patch(throughput, origin, from, emitter, encounter, ray);
                return;
            }
            (Some(origin), _) => self.plane_wave_share(origin, emitter, encounter),
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
                .density_of_miss(from.position, &from.lit_frame, self.way.direction),
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
        let largest = lobe::largest_patch(self.options, from.lobe);
        let cut = match encounter {
            Some(_) if self.way.straight => source.cut(scene, from.vertex.position, largest),
            _ => None,
        };
        let arm = encounter.map_or(f32::INFINITY, |_| (position - ray.origin).length());
        let drawn = (
            from.departure.direction,
            Coherence::from_point(self.way.length + arm),
        );
        let (share, position, (i, coherence)) = if let Some(cut) = cut {
            if lobe::sums_all(&cut) {
                // connections have seen all of it
                return;
            }
            // weighed as the whole patch is, so that connections and hits share each patch as a whole; within it the
            // direction that was drawn keeps its own response: the patch's over this density has no bound
            let patch = cut.patch(cut.find(position, self.way.direction));
            let toward = from.vertex.frame.to_local(patch.direction);
            let own = self.respond_behind(from, toward, &patch.coherence()).1;
            let chance = scene.chance_of_emitter(emitter, from.vertex.position);
            let other = lobe::patch_density(chance, &cut, &patch);
            (power_heuristic(own, other), position, drawn)
        } else if !self.way.straight
            && let Some(e) = encounter
            && let Some(patch) = self.patch_through(from, source, &e.surface, ray, largest)
        {
            let i = from.vertex.frame.to_local(patch.direction);
            (1.0, patch.centre, (i, patch.coherence()))
        } else {
            let share = self.plane_wave_share(origin, emitter, encounter);
            (share, position, drawn)
        };
        let (response, _) = self.respond_behind(from, i, &coherence);
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
