//! Gauss rules for the Poisson weights of rough surfaces: few Gaussians in place of hundreds.
//!
//! The lobe of `R = e^(−g(1−ρ))` is `Σ w_m F{ρ^m}`, `w_m = e^(−g) g^m/m!`, and `F{ρ^m} ∝ e^(−c/m)/m` with
//! `c = |Dφ|²/2`. The rule of n nodes for the measure `u_m = w_m/m`, `m ≥ 1`, takes `e^(−c/m)` as its integrand: the
//! lobe's peak and `R(0)` are exact, and the coherent `m = 0` never meets the pole at 0.
//!
//! **Coefficients.** `m w_m` is a Poisson measure moved by 1, whose Jacobi matrix `diag(k + 1 + g)`, `√(g k)` is that of
//! Charlier's polynomials. Each division by m (Geronimus' transformation) turns `J' = U L` into `J = L U`:
//!
//! ```text
//! a'_k = q_k + e_k,   b'_(k+1) = e_k q_(k+1)   →   a_k = q_k + e_(k−1),   b_(k+1) = q_k e_k        q_0 = μ'_0/μ_0
//! ```
//!
//! `μ_0`: `g` of `m w_m`, `1 − e^(−g)` of `w_m`, `e^(−g) Σ g^m/(m m!)` of `u_m`.
//!
//! **Error.** `∂^k/k!` of `e^(−c/m)` is `m^(−k) e^(−t) (L_k − L_(k−1))(t)`, `t = c/m`, in modulus at most `κ m^(−k) e^(−t/a)`.
//! A rule misses `Σ u_m π_n(m)² [x₁ x₁ … x_n x_n m] e^(−c/·)`; with divided differences as means of derivatives, Jensen's
//! inequality, and `Σ u π_n²/(μ_0 π_n(0)²) = Π e_k/q_k`,
//!
//! ```text
//! error/peak ≤ a κ_2n Π_(k<n) (e_k/q_k) · [r_n^(2n) Π q_k²]^(1/(2n+1)),      r_n = ⟨1/m⟩ over u π_n²
//! ```
//!
//! Light of any coherence averages the lobe over its directions p ≥ 0. `e^(−t/a)` is a Gaussian a times wider, whose
//! average is at most as large as that of the lobe itself (its factor a is in the bound): the bound holds for it too, up to
//! the ratio of nodes to g where they spread. `r_n` is taken from the arcsine law between the turning points
//! `(√g ± √n)²` of the polynomials.

/// Most nodes of a rule.
pub(super) const MAX_NODES: usize = 24;

/// Above it `e^(−g)` is below rounding and the asymptotic series of `Σ w_m/m` has every digit.
pub(super) const ROUGH: f64 = 45.0;

/// `min over a of a max over t of |L_2n − L_(2n−1)| e^(−t(1 − 1/a))`, rounded up, for n = 1 … 24.
const CAPS: [f64; MAX_NODES] = [
    0.857, 0.504, 0.366, 0.297, 0.248, 0.217, 0.194, 0.175, 0.160, 0.148, 0.138, 0.129, 0.121,
    0.115, 0.109, 0.104, 0.0990, 0.0947, 0.0908, 0.0875, 0.0844, 0.0815, 0.0788, 0.0763,
];

/// Nodes and weights of sum 1.
pub(super) struct Rule {
    pub(super) nodes: [f64; MAX_NODES],
    pub(super) weights: [f64; MAX_NODES],
    pub(super) count: usize,
    /// Bound on the error of the lobe over its peak.
    pub(super) error: f64,
}

/// The rule for `w_m/m` of the fewest nodes whose error is at most `target`; `None` where [`MAX_NODES`] do not suffice.
///
/// The recurrences amplify rounding by `g^k/k!` while the error falls as its inverse: what rounding costs stays below
/// the error for targets above 1e-13, or `g ≤ 1`.
pub(super) fn divided(g: f64, target: f64) -> Option<Rule> {
    let diffuse = -(-g).exp_m1();
    // q of the measure w_m, then q and e of w_m/m
    let mut outer = g / diffuse;
    let (mut q, mut e) = start(g, diffuse, outer);
    let (mut diagonal, mut squares) = ([0.0; MAX_NODES], [0.0; MAX_NODES]);
    diagonal[0] = q;
    let (mut product, mut at_zero) = (1.0, 1.0);
    for n in 1..=MAX_NODES {
        if e.is_nan() || (e < 0.0 && g > 1.0) {
            return None;
        }
        // at g below 1 a negative difference is rounding of 0
        e = e.max(0.0);
        product *= e / q;
        at_zero *= q;
        let error = CAPS[n - 1] * product;
        // the last factor of the bound is at least 1/e: the power is not worth taking yet
        if error < 4.0 * target {
            let error = (error * spread(g, n, at_zero)).max(f64::EPSILON);
            if error <= target.max(f64::EPSILON) {
                return Some(rule(diagonal, squares, n, error, |x| x));
            }
        }
        if n == MAX_NODES {
            break;
        }
        // from w_(m+1) (m + 1) to w_m, coefficient n, and on to w_m/m
        let order = n as f64;
        let below = if g < ROUGH { order + g - outer } else { order };
        let square = outer * below;
        outer = g * order / below;
        let next = square / e;
        squares[n - 1] = q * e;
        diagonal[n] = next + e;
        q = next;
        e = outer + below - q;
    }
    None
}

/// `q_0` and `e_0` of the measure `w_m/m`.
fn start(g: f64, diffuse: f64, outer: f64) -> (f64, f64) {
    if g < ROUGH {
        let q = diffuse / inverse_mean(g);
        return (q, outer - q);
    }
    // g Σ w_m/m = 1 + Σ k!/g^k
    let (mut sum, mut term, mut k) = (0.0, 1.0 / g, 1.0);
    while term > 1e-18 && k < g {
        sum += term;
        k += 1.0;
        term *= k / g;
    }
    (g / (1.0 + sum), g * sum / (1.0 + sum))
}

/// `Σ w_m/m = e^(−g) Σ g^m/(m m!)`, for g below [`ROUGH`].
fn inverse_mean(g: f64) -> f64 {
    let (mut sum, mut power, mut m) = (0.0, 1.0, 1.0);
    loop {
        power *= g / m;
        let term: f64 = power / m;
        sum += term;
        if m > g && term <= 1e-18 * sum {
            return sum * (-g).exp();
        }
        m += 1.0;
    }
}

/// `[r_n^(2n) π_n(0)²]^(1/(2n+1))`.
fn spread(g: f64, n: usize, at_zero: f64) -> f64 {
    let order = n as f64;
    let (far, near) = (g.sqrt() + order.sqrt(), g - order);
    // the weights start at 1, which keeps the lower turning point from 0
    let between = near * near + far * far;
    let exponent = 2.0 * at_zero.ln() - order * between.ln();
    (exponent / (2.0 * order + 1.0)).exp()
}

/// The rule for `w_m` itself, Gauss-Charlier, of the fewest nodes whose error is at most `target`; g at least [`ROUGH`].
///
/// Nothing cancels, so that it serves for any target. By `e^(−c/m)/m = ∫ e^(−ms) J₀(2√(cs)) ds` and `|J₀| ≤ 1` its error
/// is largest at the peak, where it is `(n!/g^n) ⟨g/m⟩`; twice that for light of any coherence, and `m = 0`, which the
/// rule does not tell from the rest, adds at most `2 n g e^(−g)`.
pub(super) fn charlier(g: f64, target: f64) -> Option<Rule> {
    let (mut diagonal, mut squares) = ([0.0; MAX_NODES], [0.0; MAX_NODES]);
    diagonal[0] = g;
    let mut product = 1.0;
    for n in 1..=MAX_NODES {
        let order = n as f64;
        product *= order / g;
        let error = 2.0 * product * g / (g - order) + 2.0 * order * g * (-g).exp();
        if error <= target {
            return Some(rule(diagonal, squares, n, error, |_| 1.0));
        }
        if n < MAX_NODES {
            diagonal[n] = g + order;
            squares[n - 1] = g * order;
        }
    }
    None
}

/// The rule of a Jacobi matrix, its weights times `factor` of the node and brought to sum 1.
fn rule(
    mut nodes: [f64; MAX_NODES],
    squares: [f64; MAX_NODES],
    count: usize,
    error: f64,
    factor: impl Fn(f64) -> f64,
) -> Rule {
    let mut off = squares;
    for entry in &mut off[..count - 1] {
        *entry = entry.sqrt();
    }
    let mut weights = eigen(&mut nodes[..count], off);
    let mut sum = 0.0;
    for (weight, node) in weights.iter_mut().zip(nodes).take(count) {
        *weight = weight.powi(2) * factor(node);
        sum += *weight;
    }
    for weight in &mut weights[..count] {
        *weight /= sum;
    }
    Rule {
        nodes,
        weights,
        count,
        error,
    }
}

/// Turns the diagonal of a symmetric tridiagonal matrix into its eigenvalues; returns the first entries of its
/// eigenvectors.
///
/// Source: implicit QL of Golub and Welsch 1969, Mathematics of Computation 23, 221.
fn eigen(d: &mut [f64], mut off: [f64; MAX_NODES]) -> [f64; MAX_NODES] {
    let count = d.len();
    let mut first = [0.0; MAX_NODES];
    first[0] = 1.0;
    for l in 0..count {
        // two or three sweeps are enough; the bound keeps a NaN from looping
        for _ in 0..60 {
            let small = |m: &usize| off[*m].abs() <= f64::EPSILON * (d[*m] + d[*m + 1]).abs();
            let m = (l..count - 1).find(small).unwrap_or(count - 1);
            if m == l {
                break;
            }
            let shift = (d[l + 1] - d[l]) / (2.0 * off[l]);
            let root = (shift * shift + 1.0).sqrt().copysign(shift);
            let mut bulge = d[m] - d[l] + off[l] / (shift + root);
            let (mut sine, mut cosine, mut moved) = (1.0, 1.0, 0.0);
            for i in (l..m).rev() {
                let (across, along) = (sine * off[i], cosine * off[i]);
                // entries lie between 1 and 1e24 or are rounding: squares are numbers
                let radius = (across * across + bulge * bulge).sqrt();
                off[i + 1] = radius;
                // 0 only where both vanish: nothing to turn
                (sine, cosine) = if radius > 0.0 {
                    let inverse = 1.0 / radius;
                    (across * inverse, bulge * inverse)
                } else {
                    (0.0, 1.0)
                };
                let before = d[i + 1] - moved;
                let turned = (d[i] - before) * sine + 2.0 * cosine * along;
                moved = sine * turned;
                d[i + 1] = before + moved;
                bulge = cosine * turned - along;
                let (upper, lower) = (first[i + 1], first[i]);
                first[i + 1] = sine * lower + cosine * upper;
                first[i] = cosine * lower - sine * upper;
            }
            d[l] -= moved;
            off[l] = bulge;
            off[m] = 0.0;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Σ_(m≥1) w_m f(m) / Σ_(m≥1) w_m`.
    fn poisson_mean(g: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (mut weight, mut sum, mut total, mut m) = (1.0, 0.0, 0.0, 0.0);
        while m < g || weight > 1e-25 * total {
            m += 1.0;
            weight *= g / m;
            sum += weight * f(m);
            total += weight;
        }
        sum / total
    }

    fn mean(rule: &Rule, f: impl Fn(f64) -> f64) -> f64 {
        let pairs = rule.weights.iter().zip(rule.nodes).take(rule.count);
        pairs.map(|(weight, node)| weight * f(node)).sum()
    }

    #[test]
    fn rules_integrate_powers_from_the_inverse_on() {
        for (g, target) in [
            (1e-3, 1e-9),
            (0.1, 1e-12),
            (1.0, 1e-6),
            (3.0, 1e-9),
            (10.0, 1e-3),
            (30.0, 1e-6),
            (60.0, 1e-6),
            (400.0, 1e-9),
        ] {
            let rule = divided(g, target).unwrap();
            let highest = 2 * rule.count as i32 - 2;
            for power in -1..=highest {
                let found = mean(&rule, |x| x.powi(power));
                let expected = poisson_mean(g, |m| m.powi(power));
                // the recurrences lose g^n/n! roundings, at most 1e-16 over the target
                let tolerance = 1e-13 + 1e-15 / target * f64::from(power).abs();
                assert!(
                    (found / expected - 1.0).abs() < tolerance,
                    "g {g}, {} nodes, power {power}: {found} {expected}",
                    rule.count
                );
            }
            let beyond = mean(&rule, |x| x.powi(highest + 1));
            let expected = poisson_mean(g, |m| m.powi(highest + 1));
            assert!(beyond < expected, "g {g}");
        }
    }

    #[test]
    fn charlier_rules_integrate_powers_from_the_first_on() {
        for (g, target) in [(50.0, 1e-9), (100.0, 1e-15), (1e4, 1e-15), (1e6, 1e-15)] {
            let rule = charlier(g, target).unwrap();
            for power in 0..2 * rule.count as i32 {
                // factorial moments of a Poisson distribution: ⟨m (m − 1) … (m − k + 1)⟩ = g^k
                let falling = |x: f64| (0..power).map(|k| (x - f64::from(k)) / g).product::<f64>();
                assert!(
                    (mean(&rule, falling) - 1.0).abs() < 1e-13,
                    "g {g}, power {power}"
                );
            }
        }
    }

    #[test]
    fn caps_are_the_largest_derivatives_over_a_wider_gaussian() {
        // e^(−t/2) L_k(t) on a grid that resolves its fastest oscillation, π/√(8k) of √t at k = 48
        let grid: Vec<f64> = (0..4000).map(|i| (0.005 * f64::from(i)).powi(2)).collect();
        let mut last: Vec<f64> = grid.iter().map(|t| (-0.5 * t).exp()).collect();
        let mut next: Vec<f64> = grid.iter().zip(&last).map(|(t, e)| (1.0 - t) * e).collect();
        for n in 1..=MAX_NODES {
            // L_(k+1) = ((2k + 1 − t) L_k − k L_(k−1))/(k + 1), up to k + 1 = 2n
            for k in 2 * n - 2..2 * n {
                if k == 0 {
                    continue;
                }
                let k = k as f64;
                for ((t, l), m) in grid.iter().zip(&mut last).zip(&mut next) {
                    let more = ((2.0 * k + 1.0 - t) * *m - k * *l) / (k + 1.0);
                    (*l, *m) = (*m, more);
                }
            }
            let wider = |a: f64| -> f64 {
                let values = grid.iter().zip(last.iter().zip(&next));
                let one =
                    |(t, (l, m)): (&f64, (&f64, &f64))| (m - l).abs() * (t / a - 0.5 * t).exp();
                a * values.map(one).fold(0.0, f64::max)
            };
            let least = (0..80)
                .map(|i| wider(2.0 + 0.05 * f64::from(i)))
                .fold(f64::INFINITY, f64::min);
            let cap = CAPS[n - 1];
            assert!(least < cap && cap < 1.02 * least, "{n}: {least} {cap}");
        }
    }
}
