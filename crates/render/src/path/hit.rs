//! Light of emitters that a path has met, weighed against the connections that could have found it.

use glam::Vec3A;

use super::witness::Witness;
use super::{Behind, Walk, connect, power_heuristic};
use crate::coherence::Coherence;
use crate::geometry::ray::Ray;
use crate::light::Light;
use crate::material::{Matter, Part};
use crate::scene::Encounter;

impl<'a, L: Light, W: Witness> Walk<'a, L, W> {
    /// Light of an emitter that the path has met.
    pub(super) fn collect_hit(
        &mut self,
        throughput: &L::Throughput,
        behind: Option<&Behind<'a, L>>,
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
        // how connections from the vertex behind sample the same light
        let other = |from: &Behind<'a, L>| match encounter {
            _ if !from.way.straight => 0.0,
            Some(e) => scene.density_of_hit(emitter, from.vertex.position, &e.surface),
            None => scene.density_of_miss(&from.lit_frame, from.way.direction),
        };
        let Some(from) = behind else {
            let emission = source.emit::<L>(k, position, self.wavelengths);
            self.add_light(L::collect(throughput, &emission, k), 1.0, None);
            return;
        };
        let density = from.departure.density;
        let Some(lobe) = from.waits else {
            let emission = source.emit::<L>(k, position, self.wavelengths);
            let share = power_heuristic(density, other(from));
            self.add_light(L::collect(throughput, &emission, k), share, None);
            return;
        };

        let largest = connect::largest_patch(self.options, lobe);
        let cut = match encounter {
            Some(_) if from.way.straight => source.cut(scene, from.vertex.position, largest),
            _ => None,
        };
        let (share, i, coherence, position) = if let Some(cut) = cut {
            if cut.len() <= connect::MOST_SUMMED {
                // connections have seen all of it
                return;
            }
            let patch = cut.patch(cut.find(position, from.way.direction));
            let i = from.vertex.frame.to_local(patch.direction);
            let coherence = patch.coherence();
            let (_, own) = from.material.respond::<L>(
                &from.vertex,
                i,
                Part::Continuous,
                self.wavelengths,
                &coherence,
            );
            let other = (patch.solid_angle * cut.len() as f32).recip();
            (power_heuristic(own, other), i, coherence, patch.centre)
        } else if !from.way.straight
            && let Some(e) = encounter
            && let Some(patch) = self.patch_through(from, source, &e.surface, ray, largest)
        {
            let i = from.vertex.frame.to_local(patch.direction);
            (1.0, i, patch.coherence(), patch.centre)
        } else {
            let share = power_heuristic(density, other(from));
            (
                share,
                from.departure.direction,
                Coherence::PLANE_WAVE,
                position,
            )
        };
        let throughput = self.through(throughput, from, i, &coherence);
        let emission = source.emit::<L>(k, position, self.wavelengths);
        let toward = from.vertex.frame.to_world(i);
        self.add_light(
            L::collect(&throughput, &emission, k),
            share,
            Some((toward, coherence)),
        );
    }
}
