//! Hermite-Gauss moments of a piecewise constant function of one variable.
//!
//! With `F_n` the antiderivative of `h_n`, and jumps `v_{i−1} − v_i` at the edges `x_i`,
//!
//! ```text
//! ∫ v(x) h_n(p x + q) dx = (1/p) Σ (v_{i−1} − v_i) F_n(p x_i + q)
//! F_0 = (π^{1/4}/√2) erf(t/√2),   F_1 = −√2 h_0,   F_{n+1} = √(n/(n+1)) F_{n−1} − √(2/(n+1)) h_n
//! ```
//!
//! The sum over edges is linear and the recurrence too, so the edges are summed first. Where the whole function is
//! narrow beside the oscillations of `h_n` the jumps would cancel, and each step is integrated by a few nodes.

use crate::hermite::{self, MAX_ORDER, Real};

use super::quadrature::{Rules, reach};

/// π^(1/4)/√2
const HALF_LINE: f64 = 0.941_396_263_776_714_8;

/// Phase over a whole function below which its jumps would cancel too much.
const NARROW: f64 = 4.0;

/// A piecewise constant function: `values[i]` between `edges[i]` and `edges[i + 1]`, 0 outside.
#[derive(Clone, Copy)]
pub(crate) struct Staircase<'a> {
    pub(crate) edges: &'a [f64],
    pub(crate) values: &'a [f64],
}

impl Staircase<'_> {
    /// `∫ v(x) h_n(p x + q) dx` for n = 0, 1 …, into `moments` (at most [`MAX_ORDER`] + 1).
    ///
    /// Error of a few `order·ε` times the integral of `|v|` or `1/|p|`, whichever is smaller.
    pub(crate) fn moments(&self, p: f64, q: f64, rules: &mut Rules, moments: &mut [f64]) {
        moments.fill(0.0);
        let order = moments.len() - 1;
        let width = self.edges[self.edges.len() - 1] - self.edges[0];
        if 0.5 * reach(order) * (p * width).abs() < NARROW {
            self.by_nodes(p, q, rules, moments);
        } else {
            self.by_jumps(p, q, moments);
        }
    }

    fn by_nodes(&self, p: f64, q: f64, rules: &mut Rules, moments: &mut [f64]) {
        let order = moments.len() - 1;
        let mut table = [0.0; MAX_ORDER + 1];
        for (edges, value) in self.edges.windows(2).zip(self.values) {
            if *value == 0.0 {
                continue;
            }
            let phase = 0.5 * reach(order) * (p * (edges[1] - edges[0])).abs();
            for (x, weight) in rules.on(edges[0], edges[1], phase) {
                hermite::fill(p * x + q, &mut table[..=order]);
                for (moment, h) in moments.iter_mut().zip(&table) {
                    *moment += value * weight * h;
                }
            }
        }
    }

    fn by_jumps(&self, p: f64, q: f64, moments: &mut [f64]) {
        let order = moments.len() - 1;
        let far = reach(order);
        let mut sums = [0.0; MAX_ORDER + 1];
        let mut table = [0.0; MAX_ORDER + 1];
        let mut start = 0.0;
        let mut before = 0.0;
        for (i, x) in self.edges.iter().enumerate() {
            let after = self.values.get(i).copied().unwrap_or(0.0);
            let jump = before - after;
            before = after;
            if jump == 0.0 {
                continue;
            }
            let t = p * x + q;
            start += jump * libm::erf(t * std::f64::consts::FRAC_1_SQRT_2);
            if t.abs() < far && order > 0 {
                hermite::fill(t, &mut table[..order]);
                for (sum, h) in sums.iter_mut().zip(&table[..order]) {
                    *sum += jump * h;
                }
            }
        }
        moments[0] = HALF_LINE * start / p;
        let steps = f64::steps();
        for n in 0..order {
            let [up, down] = steps[n];
            let lower = if n > 0 { moments[n - 1] } else { 0.0 };
            moments[n + 1] = down * lower - up * sums[n] / p;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hermite::hermite;
    use proptest::prelude::*;

    /// Composite Gauss-Legendre rule of many panels, step by step.
    fn quadrature(edges: &[f64], values: &[f64], f: impl Fn(f64) -> f64) -> f64 {
        let rule = gauss_quad::GaussLegendre::new(20.try_into().unwrap());
        let mut sum = 0.0;
        for (edge, value) in edges.windows(2).zip(values) {
            let panels = 40;
            let step = (edge[1] - edge[0]) / f64::from(panels);
            for i in 0..panels {
                let low = edge[0] + f64::from(i) * step;
                sum += value * step * rule.integrate(0.0, 1.0, |t| f(low + step * t));
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn moments_are_the_integrals(
            widths in prop::collection::vec(0.01..1.0f64, 1..6),
            level in prop::collection::vec(0.0..2.0f64, 6),
            scale in prop_oneof![-5.0..5.0f64, -1e-3..1e-3f64, -1e-9..1e-9f64],
            shift in -6.0..6.0f64,
            order in 0usize..40,
        ) {
            let mut edges = vec![-1.0];
            for width in &widths {
                edges.push(edges[edges.len() - 1] + width);
            }
            let values = &level[..widths.len()];
            let mut found = vec![0.0; order + 1];
            Staircase { edges: &edges, values }.moments(scale, shift, &mut Rules::default(), &mut found);
            let area: f64 = widths.iter().zip(values).map(|(w, v)| w * v).sum();
            for (n, moment) in found.iter().enumerate() {
                let expected = quadrature(&edges, values, |x| hermite(n, scale * x + shift));
                // |h_n| < 0.76; each of the recurrence's steps rounds once
                let tolerance = (8 + order) as f64 * f64::EPSILON * area.max(0.5);
                prop_assert!((moment - expected).abs() <= tolerance, "{n}: {moment} {expected}");
            }
        }
    }

    #[test]
    fn a_wide_box_holds_the_whole_function() {
        // ∫ h_2n = √2 π^{1/4} √((2n)!)/(2ⁿ n!), so ∫ h_2 / ∫ h_0 = 1/√2
        let mut moments = [0.0; 3];
        let wide = Staircase {
            edges: &[-40.0, 40.0],
            values: &[1.0],
        };
        wide.moments(1.0, 0.0, &mut Rules::default(), &mut moments);
        assert!((moments[0] - 2f64.sqrt() * std::f64::consts::PI.powf(0.25)).abs() < 4e-16);
        assert_eq!(moments[1], 0.0);
        assert!((moments[2] / moments[0] - 0.5f64.sqrt()).abs() < 2e-16);
    }
}
