//! Light for matter that answers to coherence: lamps in patches, each with the coherence that it has at the vertex.

use glam::Vec3A;

use super::connect::{Arrival, Place};
use super::witness::Witness;
use super::{PathOptions, Walk, power_heuristic};
use crate::emitter::patch::{Cut, Patch};
use crate::emitter::{Emitter, Target};
use crate::light::Light;

/// As many patches of a lamp as this are summed at one vertex; of more one is drawn.
///
/// By `path::patch_tests::what_summing_patches_costs`, which prints variance times time of either: where nothing hides the
/// lamp the sum has no noise at all, at the edge of a shadow it costs its time: 5 times as much as one patch for 16
/// patches, 20 times for 64.
const MOST_SUMMED: u32 = 16;

/// Of so many lamps those with few patches are all summed; of more one is drawn.
const MOST_LAMPS: usize = 8;

#[cfg(test)]
thread_local! {
    /// What tests want instead of [`MOST_SUMMED`].
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

/// Density per steradian of connections to a patch of a cut of which one is drawn, of an emitter of a given chance.
#[inline]
pub(super) fn patch_density(chance: f32, cut: &Cut<'_>, patch: &Patch) -> f32 {
    chance / (patch.solid_angle * cut.len() as f32)
}

/// Where a shadow ray goes.
enum End<'a> {
    /// Into a patch.
    Patch(Cut<'a>, u32),
    /// To one point, or out of the scene.
    Point(Vec3A, Option<Target>),
}

impl End<'_> {
    /// Its direction and its end, a random one of a patch.
    fn point(&self, u: [f32; 2]) -> Option<(Vec3A, Option<Target>)> {
        match self {
            Self::Patch(cut, index) => cut.point(*index, u),
            Self::Point(direction, target) => Some((*direction, *target)),
        }
    }
}

/// A weighted reservoir of one: what is in it stands for the sum of all that it was shown.
///
/// Source: Chao, A General Purpose Unequal Probability Sampling Plan, Biometrika 69(3), 1982.
struct Reservoir<'a, L: Light> {
    /// Uniform in [0, 1), whatever has been shown.
    u: f32,
    sum: f32,
    standing: Option<(Arrival<L>, End<'a>, f32)>,
}

impl<'a, L: Light> Reservoir<'a, L> {
    fn new(u: f32) -> Self {
        Self {
            u,
            sum: 0.0,
            standing: None,
        }
    }

    /// Shows light of a given power.
    fn show(&mut self, arrival: Arrival<L>, end: End<'a>, power: f32) {
        if power <= 0.0 {
            return;
        }
        self.sum += power;
        // what is left of `u` is uniform again
        let share = power / self.sum;
        if self.u < share {
            self.u /= share;
            self.standing = Some((arrival, end, power));
        } else {
            self.u = (self.u - share) / (1.0 - share);
        }
    }

    /// What stands for all of it.
    fn drawn(&mut self) -> Option<(Arrival<L>, End<'a>)> {
        let (mut arrival, end, power) = self.standing.take()?;
        arrival.weight *= self.sum / power;
        Some((arrival, end))
    }
}

impl<'a, L: Light, W: Witness> Walk<'a, L, W> {
    /// Adds the light that matter finds which answers to coherence; its lobe has the given width.
    ///
    /// Lamps that send their light from one direction or in few patches are summed, all of them: one stands for the sum,
    /// drawn in proportion to its light, so that only visibility is left to chance. Of the others one is drawn.
    #[inline(never)]
    pub(super) fn connect_lobe(
        &mut self,
        throughput: &L::Throughput,
        place: &Place<'_>,
        lobe: f32,
        choice: f32,
        u: [f32; 3],
    ) {
        let scene = self.scene;
        let largest = largest_patch(self.options, lobe);
        let Some((chosen, chance)) = scene.choose_emitter(place.surface.position, choice) else {
            return;
        };
        let cut = chosen.cut(scene, place.surface.position, largest);
        let summed = cut
            .as_ref()
            .map_or_else(|| chosen.has_one_direction(), sums_all);
        let mut sum = Reservoir::new(u[2]);
        if scene.emitters.len() <= MOST_LAMPS {
            for emitter in &scene.emitters {
                self.weigh(&mut sum, throughput, place, emitter, largest);
            }
        } else if summed {
            self.weigh(&mut sum, throughput, place, chosen, largest);
            sum.sum /= chance;
        }
        let at = [u[0], u[1]];
        if let Some((arrival, end)) = sum.drawn()
            && let Some((direction, target)) = end.point(at)
        {
            self.add(throughput, place, direction, target.as_ref(), |_| arrival);
        }
        match cut {
            _ if summed => {}
            None => self.connect_point(throughput, place, chosen, chance, at),
            Some(cut) => {
                if let Some((arrival, index)) = self.one_patch(place, (chosen, chance), &cut, sum.u)
                    && let Some((direction, target)) = cut.point(index, at)
                {
                    self.add(throughput, place, direction, target.as_ref(), |_| arrival);
                }
            }
        }
    }

    /// One patch, drawn evenly, against rays that hit it.
    fn one_patch(
        &self,
        place: &Place<'_>,
        (emitter, chance): (&Emitter, f32),
        cut: &Cut<'_>,
        u: f32,
    ) -> Option<(Arrival<L>, u32)> {
        let count = cut.len();
        let index = ((u * count as f32) as u32).min(count - 1);
        let patch = cut.patch(index);
        let toward = (patch.direction, patch.centre);
        let density = patch_density(chance, cut, &patch);
        let coherence = patch.coherence();
        let (response, own) = self.answer(place, patch.direction, &coherence)?;
        let mut weight = density.recip();
        if emitter.can_be_met() {
            weight *= power_heuristic(density, own);
        }
        let arrival = self.arrival(place, emitter, toward, response, coherence, weight);
        Some((arrival, index))
    }

    /// Shows a sum the light of an emitter, if it comes from one direction or in few patches.
    fn weigh(
        &self,
        sum: &mut Reservoir<'a, L>,
        throughput: &L::Throughput,
        place: &Place<'_>,
        emitter: &Emitter,
        largest: f32,
    ) {
        let o = place.vertex.frame.to_world(place.vertex.o);
        let position = place.surface.position;
        let mut show = |toward: (Vec3A, Vec3A), coherence, weight, end| {
            if let Some((response, _)) = self.answer(place, toward.0, &coherence) {
                let arrival = self.arrival(place, emitter, toward, response, coherence, weight);
                let k = -arrival.direction;
                let light =
                    L::collect_through(throughput, arrival.response, o, &arrival.emission, k);
                let most = light.as_ref().iter().fold(0.0, |m: f32, s| m.max(s.x));
                sum.show(arrival, end, most * weight);
            }
        };
        if emitter.has_one_direction() {
            let connection = emitter.connect(self.scene, position, place.lit_frame, [0.5; 2]);
            if let Some(c) = connection {
                let source = c.target.map_or(Vec3A::ZERO, |t| t.position);
                let end = End::Point(c.direction, c.target);
                show((c.direction, source), c.coherence, c.weight, end);
            }
            return;
        }
        let cut = emitter.cut(self.scene, position, largest);
        if let Some(cut) = cut.filter(sums_all) {
            for index in 0..cut.len() {
                let patch = cut.patch(index);
                show(
                    (patch.direction, patch.centre),
                    patch.coherence(),
                    patch.solid_angle,
                    End::Patch(cut, index),
                );
            }
        }
    }
}
