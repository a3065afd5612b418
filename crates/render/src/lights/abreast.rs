//! The choice of light sources for vertices side by side.
//!
//! Up to eight sources are weighed in all lanes at once; more, and beams, are left to the choice for one vertex.

use glam::Vec3A;

use super::bundle::Seen;
use super::tree::FEW;
use super::{BLIND, Lights};
use crate::emitter::Emitter;
use crate::lanes::{Bits, MOST, Mask, Real, V3, each};

impl Seen {
    /// See [`Seen::irradiance`].
    #[inline(always)]
    fn irradiances<R: Real>(&self, from: V3<R>) -> R {
        if self.intensity <= 0.0 {
            return R::zero();
        }
        let (zero, one) = (R::zero(), R::one());
        let to = from - V3::splat(self.centre);
        let squared = to.squared();
        let squared_distance = squared.max(R::splat(self.least_square));
        let mut falloff = one;
        let mut lit = R::everywhere();
        if self.cos_spread > -1.0 {
            let outside = squared.gt(R::splat(self.squared_radius));
            // (cos, sin) of the angle to the axis times the distance, less the cone's, less that of the box
            let along = V3::splat(self.axis).dot(to);
            let across = (squared - along * along).max(zero).sqrt();
            let (c, s) = (R::splat(self.cos_spread), R::splat(self.sin_spread));
            let (c, s) = (along * c + across * s, across * c - along * s);
            let size = (squared - R::splat(self.squared_radius)).max(zero).sqrt();
            let radius = R::splat(self.radius);
            let (near, far) = (c * size + s * radius, s * size - c * radius);
            let beyond = s.gt(zero) & far.gt(zero);
            let fallen = R::select(beyond, near / squared, one);
            let dark = outside & fallen.lt(R::splat(self.cos_edge));
            lit = lit & !dark;
            falloff = R::select(outside, fallen.max(R::splat(super::bundle::LEAST)), one);
        }
        (R::splat(self.intensity) / squared_distance * falloff)
            .clamp(f32::MIN_POSITIVE, f32::MAX * 0.25)
            .only(lit)
    }
}

/// The chances of all sources for vertices side by side, or those of one lane after the other.
pub struct Chances<R: Real> {
    count: usize,
    /// Of each source, without the blind part.
    each: [R; FEW],
    /// Where there are too many: the positions.
    from: Option<[Vec3A; MOST]>,
}

impl Lights {
    /// The chances of all sources.
    #[inline(always)]
    pub fn chances<R: Real>(&self, from: V3<R>) -> Chances<R> {
        let mut chances = Chances {
            count: self.count,
            each: [R::one(); FEW],
            from: None,
        };
        if self.count < 2 {
            return chances;
        }
        if self.count > FEW || !self.beams.is_empty() {
            chances.from = Some(from.lanes());
            return chances;
        }
        let even = R::splat((self.count as f32).recip());
        chances.each = [even; FEW];
        let outer = self.outside.last().map_or(0.0, |(_, sum)| *sum);
        let sources = self.tree.sources();
        let mut part = R::zero();
        if sources.is_empty() {
            if outer <= 0.0 {
                return chances;
            }
            part = R::one();
        } else if outer > 0.0 {
            part = R::splat(outer) / (R::splat(outer) + self.tree.whole().irradiances(from));
        }
        let mut before = 0.0;
        for (number, sum) in &self.outside {
            let share = if outer > 0.0 {
                (sum - before) / outer
            } else {
                0.0
            };
            chances.each[*number as usize] = part * R::splat(share);
            before = *sum;
        }
        let mut irradiances = [R::zero(); FEW];
        let mut all = R::zero();
        for (irradiance, source) in irradiances.iter_mut().zip(sources) {
            *irradiance = source.irradiances(from);
            all = all + *irradiance;
        }
        let dark = !all.gt(R::zero());
        let alike = R::splat((sources.len().max(1) as f32).recip());
        let over = all.recip();
        let rest = R::one() - part;
        for (irradiance, number) in irradiances.iter().zip(self.tree.numbers()) {
            let share = R::select(dark, alike, *irradiance * over);
            chances.each[*number as usize] = rest * share;
        }
        chances
    }
}

impl<R: Real> Chances<R> {
    #[inline(always)]
    fn mixed(&self, chance: R) -> R {
        let even = BLIND / self.count as f32;
        R::splat(1.0 - BLIND) * chance + R::splat(even)
    }

    /// Draws a source a lane: its number, and with which chance. There must be one.
    #[inline(always)]
    pub fn draw(&self, lights: &Lights, emitters: &[Emitter], u: R, lanes: R::M) -> (R::B, R) {
        if self.count == 1 {
            return (R::B::splat(0), R::one());
        }
        if let Some(from) = &self.from {
            let (mut numbers, mut chances) = ([0; MOST], [1.0; MOST]);
            let u = u.lanes();
            each(lanes.bits(), |lane| {
                if let Some(drawn) = lights.choose(emitters, from[lane], u[lane]) {
                    (numbers[lane], chances[lane]) = drawn;
                }
            });
            return (
                R::B::from_fn(|lane| numbers[lane]),
                R::from_fn(|lane| chances[lane]),
            );
        }
        let blind = u.lt(R::splat(BLIND));
        let rest = (u - R::splat(BLIND)) * R::splat((1.0 - BLIND).recip());
        let place = u * R::splat(self.count as f32 / BLIND);
        let (mut sum, mut chance) = (R::zero(), R::zero());
        let (mut open, mut numbers) = (R::everywhere(), R::B::splat(0));
        // the last with any chance takes what rounding leaves
        for k in 0..self.count {
            let own = self.each[k];
            sum = sum + own;
            let reached = R::splat((k + 1) as f32);
            let stops = (blind & place.lt(reached)) | (!blind & rest.lt(sum));
            let takes = open & ((!blind & own.gt(R::zero())) | (blind & stops));
            chance = R::select(takes, own, chance);
            numbers = R::select_bits(takes, R::B::splat(k as u32), numbers);
            open = open & !stops;
        }
        (numbers, self.mixed(chance))
    }

    /// The chance of a source.
    #[inline(always)]
    pub fn of(&self, lights: &Lights, emitters: &[Emitter], source: u32, lanes: R::M) -> R {
        if self.count == 1 {
            return R::one();
        }
        if let Some(from) = &self.from {
            let mut chances = [1.0; MOST];
            each(lanes.bits(), |lane| {
                chances[lane] = lights.chance(emitters, source, from[lane]);
            });
            return R::from_fn(|lane| chances[lane]);
        }
        self.mixed(self.each[source as usize])
    }
}
