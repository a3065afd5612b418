//! Claim: two reliefs on each other keep the sum of their bounds, whatever the ratio of their widths.

use mueller16::{Autocorrelation, GaussianHeights, GaussianTerm, Relief, Superposed, Tolerance};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

/// `e^(−g) g^m/m!`
fn poisson(g: f64) -> Vec<f64> {
    let mut weights = vec![(-g).exp()];
    for m in 1..(g + 12.0 * g.sqrt() + 30.0) as usize {
        weights.push(weights[m - 1] * g / m as f64);
    }
    weights
}

/// The diffuse lobe of both at q, by the double sum over the powers of the two correlations `e^(−x²/l²)`.
fn double_sum(g: [f64; 2], l: [f64; 2], q: f64) -> f64 {
    let [first, second] = g.map(poisson);
    let mut sum = 0.0;
    for (m, w) in first.iter().enumerate() {
        for (n, v) in second.iter().enumerate().skip(usize::from(m == 0)) {
            let k = 0.5 / (m as f64 / (l[0] * l[0]) + n as f64 / (l[1] * l[1]));
            sum += w * v * TAU * k * (-0.5 * k * q * q).exp();
        }
    }
    sum
}

#[test]
fn the_bounds_of_two_reliefs_add_up() {
    let cases: [([f64; 2], [f64; 2]); 5] = [
        ([0.5, 0.3], [1.0, 1.0]),
        ([8.0, 2.0], [1.0, 0.1]),
        ([2.0, 30.0], [1.0, 0.2]),
        ([25.0, 0.1], [1.0, 8.0]),
        ([20.0, 20.0], [1.0, 3.0]),
    ];
    for (g, l) in cases {
        let relief = |i: usize| GaussianHeights::isotropic(g[i].sqrt(), l[i]).unwrap();
        let both = Superposed(relief(0), relief(1));
        for tolerance in [0.2, 1e-2, 1e-5] {
            let asked = Tolerance::relative(tolerance).unwrap();
            let (r, chosen) = both.autocorrelation(1.0, asked).unwrap();
            assert!(chosen.error <= tolerance, "{g:?} {l:?} {chosen:?}");
            let mirror = (-g[0] - g[1]).exp();
            assert!((r.delta_weight() - mirror).abs() < 1e-14 * mirror);
            let peak = double_sum(g, l, 0.0);
            for step in 0..30 {
                let q = f64::from(step) * 0.2 / l[0].min(l[1]);
                let off = r.spectrum(&Vector2::new(0.6, 0.8).scale(q)) - double_sum(g, l, q);
                // 1e-13: rounding of up to 1e5 positive terms
                assert!(
                    off.abs() <= (chosen.error + 1e-13) * peak,
                    "{g:?} {l:?} {tolerance} {q}: {} {}",
                    off / peak,
                    chosen.error
                );
            }
        }
    }
}

#[test]
fn products_of_skew_gaussians_are_products_of_their_values() {
    let of = |root: Matrix2<f64>, shift: [f64; 2]| {
        let term = |weight, rate| GaussianTerm {
            weight,
            rate,
            shift: shift.into(),
        };
        Autocorrelation::of_family(&root, [term(0.3, 0.0), term(0.7, 1.6)]).unwrap()
    };
    let first = of(Matrix2::new(1.3, -0.9, 0.2, 0.7), [0.4, -1.1]);
    let second = of(Matrix2::new(0.5, 1.1, -0.8, 0.6), [-0.3, 0.2]);
    let both = first.times(&second).unwrap();
    for x in [[0.0, 0.0], [0.9, 0.3], [-0.4, 1.2], [1.5, -1.0]] {
        let x = Vector2::from(x);
        let off = both.value(&x) - first.value(&x) * second.value(&x);
        // 4 terms of at most 1, roots of condition 4
        assert!(off.norm() < 1e-14, "{x} {off}");
    }
}
