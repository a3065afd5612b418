//! `e^(−g(1−ρ))` as a sum of powers `ρ^m`: which of them, for a tolerance.

use smallvec::SmallVec;

use super::GaussianTerm;
use super::charlier::{self, Rule};
use crate::accuracy::{Approximation, Method, Tolerance};

/// Below this target the nodes of the rule for `w_m/m` are no longer known to it, unless g is small.
const RECURRENCE: f64 = 1e-13;

/// Weights below this, of the largest, are not looked at.
const NOTHING: f64 = 1e-20;

/// Terms of `e^(−g(1−ρ))`, ρ a Gaussian of rate 1: first the one that does not decay, if it is not below all numbers.
///
/// The error is that of the rest, over the largest value of the rest's lobe, and at most half of the tolerance: two
/// methods that take over from each other differ by less than the tolerance. The weights add up to 1.
pub(super) fn exponential(
    g: f64,
    tolerance: Tolerance,
) -> (SmallVec<[GaussianTerm; 4]>, Approximation) {
    let mut terms = SmallVec::new();
    let coherent = (-g).exp();
    if coherent > 0.0 {
        terms.push(GaussianTerm::centred(coherent, 0.0));
    }
    let (method, error) = if g > 0.0 {
        diffuse(g, 0.5 * tolerance.get(), &mut terms)
    } else {
        (Method::Exact, 0.0)
    };
    let count = terms.len();
    let chosen = Approximation {
        method,
        terms: count,
        error,
    };
    (terms, chosen)
}

fn diffuse(g: f64, target: f64, terms: &mut SmallVec<[GaussianTerm; 4]>) -> (Method, f64) {
    let total = -(-g).exp_m1();
    // the rule of one node, twice its error at the peak for light of any coherence
    let leading = 2.0 / g * (1.0 + 2.0 / g);
    if leading <= target {
        terms.push(GaussianTerm::centred(total, g));
        return (Method::GeometricOptics, leading);
    }
    let rule = if target >= RECURRENCE || g <= 1.0 {
        charlier::divided(g, target)
    } else if g >= charlier::ROUGH {
        charlier::charlier(g, target)
    } else {
        None
    };
    if let Some(rule) = rule {
        let Rule { nodes, weights, .. } = rule;
        let pairs = weights.iter().zip(nodes).take(rule.count);
        terms.extend(pairs.map(|(weight, node)| GaussianTerm::centred(total * weight, node)));
        return (Method::GaussCharlier, rule.error);
    }
    let (first, weights, error) = window(g, target);
    let places = weights.into_iter().enumerate();
    terms.extend(places.map(|(m, weight)| GaussianTerm::centred(total * weight, first + m as f64)));
    (Method::PoissonSum, error)
}

/// The Poisson weights around their mode, of sum 1: the first rate, the weights, and a bound on the error of the lobe.
///
/// What is outside the window `m₁ … m₂` is moved to its ends. For every incoherent light `|∂F{ρ^m}/∂m|` averages to at most
/// `2/m` of the average of `F{ρ^m}` at its largest, which falls with m but slower than `1/m`. So the ends cost at most
///
/// ```text
/// 2 Σ_(m>m₂) w_m (m − m₂)/m₂ / Σ_(m≥M) w_m M/m   +   2 Σ_(m<m₁) w_m (m₁ − m)/m / Σ_(m≥m₁) w_m m₁/m
/// ```
///
/// M the mode. Only ratios of weights are taken: no factorial, no overflow.
fn window(g: f64, target: f64) -> (f64, Vec<f64>, f64) {
    let mode = g.floor().max(1.0);
    let mut weights = vec![1.0];
    let mut first = mode;
    while first > 1.0 && weights[weights.len() - 1] > NOTHING {
        let next = weights[weights.len() - 1] * first / g;
        weights.push(next);
        first -= 1.0;
    }
    weights.reverse();
    let at_mode = weights.len() - 1;
    let mut m = mode;
    while weights[weights.len() - 1] > NOTHING {
        m += 1.0;
        let next = weights[weights.len() - 1] * g / m;
        weights.push(next);
    }
    let lowest = first;
    let share = |place: usize| weights[place] / (lowest + place as f64);
    let beyond_mode: f64 = (at_mode..weights.len()).map(share).sum::<f64>() * mode;
    let peak: f64 = (0..weights.len()).map(share).sum();

    // from the top: Σ w and Σ w (m − m₂) over what is dropped
    let (mut last, mut above, mut upper) = (weights.len() - 1, 0.0, 0.0);
    while last > at_mode {
        let sum = above + weights[last];
        let moved = upper + sum;
        if 2.0 * moved > 0.5 * target * (m - 1.0) * beyond_mode {
            break;
        }
        (above, upper) = (sum, moved);
        last -= 1;
        m -= 1.0;
    }
    // from the bottom: Σ w, Σ w/m and Σ w (m₁ − m)/m
    let (mut start, mut below, mut shares, mut lower) = (0, 0.0, 0.0, 0.0);
    while start < at_mode {
        let sum = shares + share(start);
        let moved = lower + sum;
        if 2.0 * moved > 0.5 * target * (first + 1.0) * (peak - sum) {
            break;
        }
        below += weights[start];
        (shares, lower) = (sum, moved);
        start += 1;
        first += 1.0;
    }
    let error = 2.0 * upper / (m * beyond_mode) + 2.0 * lower / (first * (peak - shares));
    weights[last] += above;
    weights[start] += below;
    let total: f64 = weights[start..=last].iter().sum();
    let kept = weights[start..=last].iter().map(|w| w / total).collect();
    (first, kept, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_of_any_g_hold_the_moments_of_the_distribution() {
        for g in [1e-3f64, 0.5, 7.0, 150.0, 1e4, 1e6] {
            for target in [1e-3, 1e-9, 5e-16] {
                let (first, weights, error) = window(g, target);
                assert!(error <= target, "{g} {target} {error}");
                let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
                    let places = weights.iter().enumerate();
                    places.map(|(i, w)| w * f(first + i as f64)).sum()
                };
                assert!((moment(&|_| 1.0) - 1.0).abs() < 1e-13, "{g}");
                // w_m (m − m₂)/m₂ is what is moved, at most the target: so are first moments over g and second over g²
                let diffuse = -(-g).exp_m1();
                let mean = moment(&|m| m) * diffuse / g;
                assert!((mean - 1.0).abs() < target + 1e-12, "{g} {mean}");
                let variance = moment(&|m| (m - g).powi(2)) * diffuse + g * g * (-g).exp();
                let moved = 10.0 * target * g.max(1.0).powi(2) + 1e-9 * g;
                assert!((variance - g).abs() < moved, "{g} {target} {variance}");
            }
        }
        // 10 √g on either side at most
        let (first, weights, _) = window(1e6, 5e-16);
        assert!(
            weights.len() < 20_000 && first > 9.9e5,
            "{} {first}",
            weights.len()
        );
    }

    #[test]
    fn each_method_is_taken_where_it_has_the_fewest_terms() {
        let method = |g, tolerance| {
            let (_, chosen) = exponential(g, Tolerance::relative(tolerance).unwrap());
            chosen.method
        };
        assert_eq!(method(1e5, 1e-3), Method::GeometricOptics);
        assert_eq!(method(1e3, 1e-3), Method::GaussCharlier);
        assert_eq!(method(10.0, 1e-3), Method::GaussCharlier);
        assert_eq!(method(0.1, 1e-15), Method::GaussCharlier);
        assert_eq!(method(1e5, 1e-15), Method::GaussCharlier);
        assert_eq!(method(20.0, 1e-12), Method::PoissonSum);
    }
}
