//! Reconstruction filters, sampled: a camera sample is drawn from the filter around its pixel and counts fully.
//!
//! The expected image is the one that splatting gives; no two pixels share a sample, so pixels can be computed in any
//! order. At the border of the image the filter is cut off and renormalised, as splatting renderers do.
//!
//! Source: Ernst, Stamminger, Greiner, Filter Importance Sampling, IEEE Symposium on Interactive Ray Tracing 2006.

use std::num::Wrapping;

use crate::lanes::{Bits, MOST, Mask, Real, each};

/// A separable filter, by the name of Mitsuba's plugin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant over half a pixel to each side.
    Box,
    /// Linear down to zero at `radius` pixels.
    Tent {
        /// Half width, pixels.
        radius: f32,
    },
    /// Gaussian lowered so that it ends in zero at 4 standard deviations.
    Gaussian {
        /// Standard deviation, pixels.
        stddev: f32,
    },
}

impl Filter {
    /// Where it ends, pixels from the centre.
    pub fn radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => 4.0 * stddev,
        }
    }

    /// Integral from −radius to `x`, as a fraction of the whole.
    fn cumulative(self, x: f32) -> f64 {
        let radius = f64::from(self.radius());
        let x = f64::from(x).clamp(-radius, radius);
        match self {
            Self::Box => x + 0.5,
            Self::Tent { .. } => {
                let f = x / radius;
                0.5 + f - 0.5 * f * f.abs()
            }
            Self::Gaussian { stddev } => {
                let scale = f64::from(stddev) * std::f64::consts::SQRT_2;
                let floor = (-8f64).exp();
                let primitive = |x: f64| {
                    f64::from(stddev) * (0.5 * std::f64::consts::TAU).sqrt()
                        / std::f64::consts::SQRT_2
                        * libm::erf(x / scale)
                        - floor * x
                };
                0.5 + 0.5 * primitive(x) / primitive(radius)
            }
        }
    }
}

/// A filter ready for drawing offsets from it.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    filter: Filter,
    /// Distance from the centre at equal steps of √(2p), p the probability of lying farther out on one side; empty for
    /// the box. The root makes the outer ends, where the filters fall linearly to zero, straight lines.
    distance: Vec<f32>,
}

const STEPS: usize = 1024;

impl FilterSampler {
    /// Tabulates the inverse of the cumulative distribution (1,024 steps, linear in between: error of an offset below
    /// 1e-4 pixels).
    pub fn new(filter: Filter) -> Self {
        let invert = |tail: f64| {
            let (mut near, mut far) = (0.0, filter.radius());
            for _ in 0..40 {
                let middle = 0.5 * (near + far);
                if filter.cumulative(-middle) > tail {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            0.5 * (near + far)
        };
        let distance = match filter {
            Filter::Box => Vec::new(),
            _ => (0..=STEPS)
                .map(|i| invert(0.5 * (i as f64 / STEPS as f64).powi(2)))
                .collect(),
        };
        Self { filter, distance }
    }

    /// A position along one axis of the film, drawn around the centre of `pixel` within `[first, last]` pixels.
    #[inline]
    pub fn position(&self, pixel: u32, u: f32, first: u32, last: u32) -> f32 {
        self.positions(Wrapping(pixel), u, first, last)
    }

    /// The same, a position a lane.
    #[inline(always)]
    pub fn positions<R: Real>(&self, pixels: R::B, u: R, first: u32, last: u32) -> R {
        if self.distance.is_empty() {
            return R::of_int(pixels) + u;
        }
        let (half, one) = (R::splat(0.5), R::one());
        let (first, last) = (first as f32, last as f32);
        let centre = R::of_int(pixels) + half;
        let radius = R::splat(self.filter.radius());
        let (low, high) = (R::splat(first) - centre, R::splat(last) - centre);
        let cut = low.gt(-radius) | high.lt(radius);
        let mut u = u;
        if cut.any() {
            // only the part of the filter that lies on the film
            let (low, high) = (low.lanes(), high.lanes());
            let (mut from, mut to) = ([0.0; MOST], [0.0; MOST]);
            each(cut.bits(), |lane| {
                from[lane] = self.filter.cumulative(low[lane]) as f32;
                to[lane] = self.filter.cumulative(high[lane]) as f32;
            });
            let (from, to) = (R::load(&from, 0), R::load(&to, 0));
            u = R::select(cut, from + u * (to - from), u);
        }
        let tail = u.min(one - u).max(R::zero());
        let place = (tail + tail).sqrt() * R::splat(STEPS as f32);
        let step = place.min(R::splat((STEPS - 1) as f32)).to_int();
        let outer = R::gather(&self.distance, step);
        let inner = R::gather(&self.distance, step + R::B::splat(1));
        let distance = outer + (inner - outer) * (place - R::of_int(step));
        (centre + distance.copysign(u - half))
            .max(R::splat(first))
            .min(R::splat(last))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of drawn offsets against the filter's own integrals, by trapezoid over its definition.
    fn moments_agree(filter: Filter, density: impl Fn(f64) -> f64) {
        let r = f64::from(filter.radius());
        let n = 20_000;
        let (mut mass, mut second) = (0.0, 0.0);
        for i in 0..n {
            let x = -r + 2.0 * r * (i as f64 + 0.5) / n as f64;
            mass += density(x);
            second += density(x) * x * x;
        }
        let expected = second / mass;
        let sampler = FilterSampler::new(filter);
        let drawn: f64 = (0..n)
            .map(|i| {
                f64::from(sampler.position(50, (i as f32 + 0.5) / n as f32, 0, 100) - 50.5).powi(2)
            })
            .sum::<f64>()
            / n as f64;
        // 20,000 midpoints leave out h²-terms of 1e-4; the table's error of 1e-4 pixels adds as much
        assert!(
            (drawn / expected - 1.0).abs() < 5e-4,
            "{filter:?}: {drawn} {expected}"
        );
    }

    #[test]
    fn offsets_follow_the_filter() {
        moments_agree(Filter::Box, |_| 1.0);
        moments_agree(Filter::Tent { radius: 1.0 }, |x| 1.0 - x.abs());
        moments_agree(Filter::Tent { radius: 2.5 }, |x| 1.0 - x.abs() / 2.5);
        let gauss = |s: f64| move |x: f64| (-x * x / (2.0 * s * s)).exp() - (-8f64).exp();
        moments_agree(Filter::Gaussian { stddev: 0.5 }, gauss(0.5));
        moments_agree(Filter::Gaussian { stddev: 1.3 }, gauss(f64::from(1.3f32)));
    }

    #[test]
    fn no_offset_leaves_the_film() {
        let sampler = FilterSampler::new(Filter::Gaussian { stddev: 0.5 });
        for i in 0..1000 {
            let x = sampler.position(0, i as f32 / 1000.0, 0, 3);
            assert!((0.0..=3.0).contains(&x));
        }
    }
}
