//! Gauss-Legendre rules whose number of nodes follows from the oscillations they meet.
//!
//! A Hermite-Gauss function of order n lives in `|t| <` [`reach`]`(n)` and, being its own Fourier transform, contains
//! no frequency beyond the same number, both to 1e-17. The n-point rule on `[−1, 1]` integrates `e^{iωx}` with an
//! error below `(eω/4n)^{2n}`.

use gauss_quad::GaussLegendre;

/// Where `h_0 … h_order`, and their Fourier transforms, have fallen below 1e-17.
///
/// Beyond the last turning point `√(2n+1)` the decay is that of the Gaussian or faster.
pub(crate) fn reach(order: usize) -> f64 {
    ((2 * order + 1) as f64).sqrt() + 8.5
}

/// Nodes that integrate `e^{iωx}` over `[−1, 1]` to rounding, |ω| ≤ `phase`.
pub(crate) fn node_count(phase: f64) -> usize {
    // 2n ln(4n/eω) ≥ 40, from below
    let enough =
        |n: f64| 2.0 * n * (4.0 * n / (std::f64::consts::E * phase.max(1e-300))).ln() >= 40.0;
    let mut n = (0.68 * phase).floor().max(1.0);
    while !enough(n) {
        n += 1.0;
    }
    n as usize
}

/// The rules that were needed so far.
#[derive(Default)]
pub(crate) struct Rules {
    rules: Vec<Option<GaussLegendre>>,
}

impl Rules {
    /// Nodes and weights on `[low, high]` for integrands whose phase runs over less than `2·phase` there.
    pub(crate) fn on(
        &mut self,
        low: f64,
        high: f64,
        phase: f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        let count = node_count(phase);
        if self.rules.len() <= count {
            self.rules.resize(count + 1, None);
        }
        let degree = std::num::NonZeroUsize::new(count).unwrap_or(std::num::NonZeroUsize::MIN);
        let rule = self.rules[count].get_or_insert_with(|| GaussLegendre::new(degree));
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        rule.iter()
            .map(move |(node, weight)| (centre + half * node, half * weight))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hermite::hermite;

    #[test]
    fn functions_end_where_they_are_said_to() {
        for order in [0, 1, 7, 64, 256] {
            let edge = reach(order);
            assert!(hermite(order, edge).abs() < 1e-17, "{order}");
            // and not much earlier, or quadrature would waste its nodes
            assert!(hermite(order, 0.6 * edge).abs() > 1e-17, "{order}");
        }
    }

    #[test]
    fn a_wave_is_integrated_to_rounding() {
        let mut rules = Rules::default();
        for phase in [1e-9, 0.3, 1.0, 4.0, 30.0, 200.0, 1500.0f64] {
            let sum: f64 = rules
                .on(-1.0, 1.0, phase)
                .map(|(x, w)| w * (phase * x).cos())
                .sum();
            let expected = 2.0 * phase.sin() / phase;
            // the argument of the cosine is rounded: ε·phase at worst, ε·√phase as a sum of many
            let tolerance = 4.0 * f64::EPSILON * phase.max(1.0).sqrt();
            assert!(
                (sum - expected).abs() < tolerance,
                "{phase} {sum} {expected}"
            );
        }
    }
}
