//! Which light source a vertex connects to: drawn by an estimate of the irradiance that each sends there.
//!
//! Sources in the scene stand in a tree (`tree.rs`) of boxes with cones of normals (`bundle.rs`), so that one of n takes
//! about log₂ n steps; up to eight are compared one by one. Sources outside the scene count by their irradiance, beams by theirs where they pass.
//!
//! The estimate does not know what stands in the way, nor the matter at the vertex. One choice in eight is therefore made
//! blindly: no source is ever rarer than an eighth of an even share, whatever hides the others. With a single source there
//! is nothing to choose.
//!
//! Source: the blind part as in Hesterberg, Weighted Average Importance Sampling and Defensive Mixture Distributions,
//! Technometrics 37(2), 1995.

pub mod abreast;
mod bundle;
#[cfg(test)]
mod choice_tests;
#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod testing;
mod tree;

use glam::Vec3A;

use crate::emitter::{Emitter, Kind};
pub use bundle::Bundle;
use tree::{BELOW_ONE, Tree, share};

/// A source as a choice sees it; strengths are means over the wavelengths.
#[derive(Clone, Copy, Debug)]
pub enum Glance {
    /// In the scene.
    Near(Bundle),
    /// Outside of it, the same for all points: irradiance, W/m².
    Outside(f64),
    /// A beam of this power, W.
    Beam(f64),
}

/// Chance of a choice that looks at nothing.
const BLIND: f32 = 0.125;

/// The sources of a scene, to be chosen from.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    count: usize,
    tree: Tree,
    /// Sources outside the scene, and the running sum of their irradiance.
    outside: Vec<(u32, f32)>,
    beams: Vec<(u32, f32)>,
}

impl Lights {
    /// From what is seen of each source, in the order of their numbers.
    pub fn new(glances: &[Glance]) -> Self {
        let mut lights = Self {
            count: glances.len(),
            ..Self::default()
        };
        // with one source nothing is ever asked
        if glances.len() < 2 {
            return lights;
        }
        let unit = unit(glances);
        let mut near = Vec::new();
        let mut sum = 0.0;
        for (number, glance) in (0..).zip(glances) {
            match glance {
                Glance::Near(bundle) => near.push((number, *bundle)),
                Glance::Outside(irradiance) => {
                    sum += irradiance / unit;
                    lights.outside.push((number, sum as f32));
                }
                Glance::Beam(power) => lights.beams.push((number, (power / unit) as f32)),
            }
        }
        lights.tree = Tree::new(near, glances.len(), unit);
        lights
    }

    /// Draws a source for a vertex, and says with which chance; `None` if there is none.
    #[inline]
    pub fn choose(&self, emitters: &[Emitter], from: Vec3A, u: f32) -> Option<(u32, f32)> {
        match self.count {
            0 => None,
            1 => Some((0, 1.0)),
            _ => Some(self.choose_of_several(emitters, from, u)),
        }
    }

    /// The chance with which [`Lights::choose`] draws a source.
    #[inline]
    pub fn chance(&self, emitters: &[Emitter], source: u32, from: Vec3A) -> f32 {
        if self.count == 1 {
            return 1.0;
        }
        let outer = self.outer(emitters, from);
        let Some(part) = self.outer_share(outer, from) else {
            return self.even();
        };
        self.mixed(match self.outer_irradiance(emitters, source, from) {
            Some(irradiance) => part * (irradiance / outer),
            None => (1.0 - part) * self.tree.chance(source, from),
        })
    }

    /// The chance of each source in a blind choice.
    #[inline]
    fn even(&self) -> f32 {
        (self.count as f32).recip()
    }

    /// A chance together with that of a blind choice.
    #[inline]
    fn mixed(&self, chance: f32) -> f32 {
        (1.0 - BLIND) * chance + BLIND * self.even()
    }

    /// A blind choice.
    fn any(&self, u: f32) -> u32 {
        ((u * self.count as f32) as usize).min(self.count - 1) as u32
    }

    fn choose_of_several(&self, emitters: &[Emitter], from: Vec3A, u: f32) -> (u32, f32) {
        if u < BLIND {
            let number = self.any(u / BLIND);
            return (number, self.chance(emitters, number, from));
        }
        let u = (u - BLIND) / (1.0 - BLIND);
        let outer = self.outer(emitters, from);
        let Some(part) = self.outer_share(outer, from) else {
            return (self.any(u), self.even());
        };
        let (number, chance) = if u < part {
            let (number, irradiance) = self.draw_outer(emitters, from, u / part * outer);
            (number, part * (irradiance / outer))
        } else {
            let (number, chance) = self.tree.draw(from, (u - part) / (1.0 - part));
            (number, (1.0 - part) * chance)
        };
        (number, self.mixed(chance))
    }

    /// Irradiance of all sources that are not in the tree.
    #[inline]
    fn outer(&self, emitters: &[Emitter], from: Vec3A) -> f32 {
        let outside = self.outside.last().map_or(0.0, |(_, sum)| *sum);
        self.beams.iter().fold(outside, |sum, &(number, power)| {
            sum + power * spot_of(&emitters[number as usize], from)
        })
    }

    /// The chance of all that is not in the tree; `None` if that is all there is, and dark.
    #[inline]
    fn outer_share(&self, outer: f32, from: Vec3A) -> Option<f32> {
        if self.tree.is_empty() {
            (outer > 0.0).then_some(1.0)
        } else if outer > 0.0 {
            Some(share(outer, self.tree.irradiance(from)))
        } else {
            Some(0.0)
        }
    }

    /// The source at which a running sum of the irradiance outside the tree passes `at`, and its irradiance.
    fn draw_outer(&self, emitters: &[Emitter], from: Vec3A, at: f32) -> (u32, f32) {
        let outside = self.outside.last().map_or(0.0, |(_, sum)| *sum);
        // rounding may reach the end of the sum
        let at = if self.beams.is_empty() {
            at.min(outside * BELOW_ONE)
        } else {
            at
        };
        let place = self.outside.partition_point(|(_, sum)| *sum <= at);
        if let Some((number, _)) = self.outside.get(place) {
            return (*number, self.outside_irradiance(place));
        }
        let mut rest = at - outside;
        let mut drawn = (0, 0.0);
        for &(number, power) in &self.beams {
            let irradiance = power * spot_of(&emitters[number as usize], from);
            if irradiance > 0.0 {
                drawn = (number, irradiance);
                if rest < irradiance {
                    break;
                }
                rest -= irradiance;
            }
        }
        drawn
    }

    /// Irradiance of a source outside the scene, by its place in the list.
    #[inline]
    fn outside_irradiance(&self, place: usize) -> f32 {
        let before = place.checked_sub(1).map_or(0.0, |k| self.outside[k].1);
        self.outside[place].1 - before
    }

    /// Irradiance of a source that is not in the tree; `None` for others.
    #[inline]
    fn outer_irradiance(&self, emitters: &[Emitter], source: u32, from: Vec3A) -> Option<f32> {
        // both lists are in the order of the numbers
        let find = |list: &[(u32, f32)]| list.binary_search_by_key(&source, |entry| entry.0).ok();
        if let Some(place) = find(&self.outside) {
            return Some(self.outside_irradiance(place));
        }
        let (_, power) = self.beams[find(&self.beams)?];
        Some(power * spot_of(&emitters[source as usize], from))
    }
}

/// Irradiance that a beam of 1 W makes at a point, across itself.
#[inline]
fn spot_of(emitter: &Emitter, at: Vec3A) -> f32 {
    match &emitter.kind {
        Kind::Laser(beam) => beam.irradiance(at),
        _ => 0.0,
    }
}

/// The intensity, or irradiance, that counts as 1, so that single precision has room on both sides.
fn unit(glances: &[Glance]) -> f64 {
    let near = glances.iter().filter_map(|glance| match glance {
        Glance::Near(bundle) => Some(*bundle),
        _ => None,
    });
    let size = near
        .reduce(|all, one| all.and(&one))
        .map_or(0.0, |all| f64::from(all.squared_diameter()));
    let largest = glances.iter().fold(0.0, |largest: f64, glance| {
        largest.max(match glance {
            Glance::Near(bundle) if size > 0.0 => bundle.intensity / size,
            Glance::Near(bundle) => bundle.intensity,
            Glance::Outside(strength) | Glance::Beam(strength) => *strength,
        })
    });
    if largest > 0.0 { largest } else { 1.0 }
}
