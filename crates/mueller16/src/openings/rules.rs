//! Quadrature over a source: how many nodes keep its coherence to a given error.

use std::num::NonZeroUsize;

use gauss_quad::{GaussHermite, GaussLegendre};

use super::error::OpeningError;

/// Most plane waves of one spectrum.
const MOST_WAVES: usize = 1 << 20;

/// Most nodes of a Gauss-Hermite rule: beyond, the trapezoidal rule needs fewer.
const MOST_GAUSS: usize = 40;

/// Nodes and weights along one axis, and a bound on their error.
pub(super) struct Rule {
    pub(super) nodes: Vec<(f64, f64)>,
    pub(super) error: f64,
}

pub(super) fn check_count(needed: f64, phase: f64) -> Result<(), OpeningError> {
    if needed <= MOST_WAVES as f64 {
        return Ok(());
    }
    Err(OpeningError::Waves {
        needed,
        phase,
        limit: MOST_WAVES,
    })
}

/// For the weight `e^(−u²/2)/√(2π)`: Gauss-Hermite if that needs fewer nodes than the trapezoidal rule.
pub(super) fn gaussian_rule(phase: f64, epsilon: f64) -> Result<Rule, OpeningError> {
    let remainder =
        |n: f64| ln_factorial(n) - ln_factorial(2.0 * n) + 2.0 * n * phase.max(1e-300).ln();
    let mut trapezoid = trapezoidal_rule(0, phase, epsilon)?;
    let found =
        (1..=MOST_GAUSS.min(trapezoid.nodes.len())).find(|n| remainder(*n as f64) <= epsilon.ln());
    let Some(count) = found else {
        let density = 1.0 / std::f64::consts::TAU.sqrt();
        for (u, weight) in &mut trapezoid.nodes {
            *weight *= density * (-0.5 * *u * *u).exp();
        }
        return Ok(trapezoid);
    };
    let degree = NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN);
    let rule = GaussHermite::new(degree);
    let root_pi = std::f64::consts::PI.sqrt();
    let nodes = rule
        .iter()
        .map(|(t, weight)| (t * std::f64::consts::SQRT_2, weight / root_pi))
        .collect();
    Ok(Rule {
        nodes,
        error: remainder(count as f64).exp(),
    })
}

/// Equidistant nodes, all of the weight of the step, for functions `h_n(u)`, n ≤ `order`, times waves of this phase.
///
/// With c where all of them have fallen to a tenth of ε, `[−c, c]` leaves out less than ε/4, and a step of `2π/(Y + c)`
/// has its aliases at c and beyond, which add up to less than that again.
pub(super) fn trapezoidal_rule(
    order: usize,
    phase: f64,
    epsilon: f64,
) -> Result<Rule, OpeningError> {
    let c = edge(order, 0.1 * epsilon);
    let half = (c * (phase + c) / std::f64::consts::TAU).ceil();
    check_count(2.0 * half + 1.0, phase)?;
    let step = c / half;
    let half = half as i32;
    let nodes = (-half..=half)
        .map(|i| (f64::from(i) * step, step))
        .collect();
    Ok(Rule {
        nodes,
        error: epsilon,
    })
}

/// Where `h_0 … h_order` stay below `least`.
fn edge(order: usize, least: f64) -> f64 {
    let mut values = vec![0.0; order + 1];
    let mut t = ((2 * order + 1) as f64).sqrt();
    loop {
        stokes::hermite_all(order, t, &mut values);
        if values.iter().all(|h| h.abs() <= least) {
            return t;
        }
        t += 0.125;
    }
}

/// Gauss-Legendre for the mean over `[−1, 1]` of waves of phases up to `±phase` there.
pub(super) fn legendre_rule(phase: f64, epsilon: f64) -> Result<Rule, OpeningError> {
    // on −1..1, over the length 2: 2^(2n) × the remainder on 0..1
    let (count, error) = least_count(epsilon, phase, |n| {
        legendre_remainder(n) + 2.0 * n * (2.0 * phase).ln()
    })?;
    let nodes = legendre(count).iter().map(|(t, w)| (*t, 0.5 * w)).collect();
    Ok(Rule { nodes, error })
}

pub(super) fn legendre(count: usize) -> GaussLegendre {
    GaussLegendre::new(NonZeroUsize::new(count).unwrap_or(NonZeroUsize::MIN))
}

/// Logarithm of the factor of `f^(2n)` in the error of n Gauss-Legendre nodes on 0..1.
///
/// Source: Abramowitz & Stegun, Eq. (25.4.30).
pub(super) fn legendre_remainder(n: f64) -> f64 {
    4.0 * ln_factorial(n) - (2.0 * n + 1.0).ln() - 3.0 * ln_factorial(2.0 * n)
}

/// The least number of nodes whose error, given by its logarithm, is below ε, and that error.
pub(super) fn least_count(
    epsilon: f64,
    phase: f64,
    ln_error: impl Fn(f64) -> f64,
) -> Result<(usize, f64), OpeningError> {
    // every rule here is done when there are as many nodes as radians, and some
    check_count(phase, phase)?;
    let mut count = 1;
    loop {
        let error = ln_error(count as f64);
        if error <= epsilon.ln() || error == f64::NEG_INFINITY {
            return Ok((count, error.exp()));
        }
        count += 1;
    }
}

pub(super) fn ln_factorial(n: f64) -> f64 {
    libm::lgamma(n + 1.0)
}
