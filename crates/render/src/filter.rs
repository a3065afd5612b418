//! Reconstruction filters, sampled: a camera sample is drawn from the filter around its pixel and counts fully.
//!
//! The expected image is the one that splatting gives; no two pixels share a sample, so pixels can be computed in any
//! order. At the border of the image the filter is cut off and renormalised, as splatting renderers do.
//!
//! Source: Ernst, Stamminger, Greiner, Filter Importance Sampling, IEEE Symposium on Interactive Ray Tracing 2006.

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
                    f64::from(stddev) * (0.5 * std::f64::consts::TAU).sqrt() / std::f64::consts::SQRT_2
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
    /// Offsets at equal steps of the cumulative distribution; empty for the box.
    inverse: Vec<f32>,
}

const STEPS: usize = 1024;

impl FilterSampler {
    /// Tabulates the inverse of the cumulative distribution (1,024 steps, linear in between: error of an offset below
    /// 1e-3 pixels).
    pub fn new(filter: Filter) -> Self {
        let radius = filter.radius();
        let invert = |target: f64| {
            let (mut low, mut high) = (-radius, radius);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if filter.cumulative(middle) < target { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let inverse = match filter {
            Filter::Box => Vec::new(),
            _ => (0..=STEPS).map(|i| invert(i as f64 / STEPS as f64)).collect(),
        };
        Self { filter, inverse }
    }

    /// A position along one axis of the film, drawn around the centre of `pixel` within `[first, last]` pixels.
    #[inline]
    pub fn position(&self, pixel: u32, u: f32, first: u32, last: u32) -> f32 {
        if self.inverse.is_empty() {
            return pixel as f32 + u;
        }
        let centre = pixel as f32 + 0.5;
        let radius = self.filter.radius();
        let (low, high) = (first as f32 - centre, last as f32 - centre);
        let u = if low > -radius || high < radius {
            // only the part of the filter that lies on the film
            let (a, b) = (self.filter.cumulative(low) as f32, self.filter.cumulative(high) as f32);
            a + u * (b - a)
        } else {
            u
        };
        let place = u * STEPS as f32;
        let step = (place as usize).min(STEPS - 1);
        let fraction = place - step as f32;
        let offset = self.inverse[step] + (self.inverse[step + 1] - self.inverse[step]) * fraction;
        (centre + offset).clamp(first as f32, last as f32)
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
            .map(|i| f64::from(sampler.position(50, (i as f32 + 0.5) / n as f32, 0, 100) - 50.5).powi(2))
            .sum::<f64>()
            / n as f64;
        // table of 1,024 linear pieces: relative error of the variance below 2e-3
        assert!((drawn / expected - 1.0).abs() < 2e-3, "{filter:?}: {drawn} {expected}");
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
