//! Gaussian heights against the full Poisson sum of their phase, for plane waves and for light of any coherence.

use mueller16::{Approximation, GaussianHeights, GaussianTerm, Method, Relief, Tolerance};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// Rounding of a sum of up to 2e4 weights from a recurrence of as many steps, each within 1e-16: 1e-14 at random signs.
const ROUNDING: f64 = 2e-14;

/// Heights whose `g` is exactly that for `φ_z = 1`, with the root 1.
fn heights(g: f64) -> GaussianHeights {
    GaussianHeights::new(g.sqrt(), &Matrix2::identity()).unwrap()
}

fn chosen(g: f64, tolerance: f64) -> (Vec<GaussianTerm>, Approximation) {
    let tolerance = Tolerance::relative(tolerance).unwrap();
    let (r, chosen) = heights(g).autocorrelation(1.0, tolerance).unwrap();
    let terms = r.families().iter().flat_map(|f| f.terms().to_vec());
    (terms.filter(|t| t.rate > 0.0).collect(), chosen)
}

/// All `e^(−g) g^m/m!`, m ≥ 1, that f64 tells from 0: ratios from the mode on, brought to the sum `1 − e^(−g)`.
fn poisson(g: f64) -> Vec<GaussianTerm> {
    let mode = g.floor().max(1.0);
    let mut pairs = vec![(mode, 1.0)];
    let (mut m, mut weight) = (mode, 1.0);
    while m > 1.0 && weight > 1e-26 {
        weight *= m / g;
        m -= 1.0;
        pairs.push((m, weight));
    }
    (m, weight) = (mode, 1.0);
    while weight > 1e-26 {
        m += 1.0;
        weight *= g / m;
        pairs.push((m, weight));
    }
    pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
    let scale = -(-g).exp_m1() / pairs.iter().map(|p| p.1).sum::<f64>();
    let term = |(m, w): (f64, f64)| GaussianTerm::centred(w * scale, m);
    pairs.into_iter().map(term).collect()
}

/// `F{R γ}(q)/2π` over the root 1, of light `γ = e^(−(d₁² x² + d₂² y²)/2)`.
fn lobe(terms: &[GaussianTerm], [d1, d2]: [f64; 2], q: &Vector2<f64>) -> f64 {
    let one = |t: &GaussianTerm| {
        let (a, b) = (t.rate + d1 * d1, t.rate + d2 * d2);
        t.weight / (a * b).sqrt() * (-0.5 * (q.x * q.x / a + q.y * q.y / b)).exp()
    };
    terms.iter().map(one).sum()
}

/// Wave vectors and widths of light, in units of the lobe's own width `√g`.
fn scan(g: f64) -> impl Iterator<Item = ([f64; 2], Vector2<f64>)> {
    let unit = g.max(1.0).sqrt();
    let lights = [
        [0.0, 0.0],
        [0.3, 0.3],
        [0.0, 1.0],
        [1.0, 1.0],
        [0.0, 10.0],
        [4.0, 4.0],
        [300.0, 300.0],
    ];
    lights.into_iter().flat_map(move |light| {
        (0..40).map(move |i| {
            let q = 0.18 * f64::from(i);
            (light.map(|d| d * unit), Vector2::new(0.8, 0.6) * q * unit)
        })
    })
}

/// Largest difference over the scan, of the largest value of the lobe for the same light.
fn difference(a: &[GaussianTerm], b: &[GaussianTerm], g: f64) -> f64 {
    let of = |(light, q): ([f64; 2], Vector2<f64>)| {
        let peak = lobe(b, light, &Vector2::zeros());
        (lobe(a, light, &q) - lobe(b, light, &q)).abs() / peak
    };
    scan(g).map(of).fold(0.0, f64::max)
}

/// g from 1e-12 to 1e6, closest where the methods change.
fn roughnesses() -> Vec<f64> {
    let mut list: Vec<f64> = (-24..0).map(|i| 10f64.powf(0.5 * f64::from(i))).collect();
    list.extend((0..=48).map(|i| 10f64.powf(0.05 * f64::from(i))));
    list.extend((1..=8).map(|i| 10f64.powf(2.4 + 0.45 * f64::from(i))));
    list
}

const TOLERANCES: [f64; 8] = [0.5, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12];

#[test]
fn errors_are_below_their_bound_and_bounds_are_no_more_than_thirty_times_the_error() {
    let mut loosest: (f64, f64, f64) = (0.0, 0.0, 0.0);
    println!("tolerance  method, largest error/tolerance, most terms at g");
    for tolerance in TOLERANCES {
        let mut worst = [(0.0f64, 0usize, 0.0f64); 3];
        for g in roughnesses() {
            let (terms, chosen) = chosen(g, tolerance);
            assert!(
                chosen.error <= 0.5 * tolerance,
                "{g} {tolerance} {chosen:?}"
            );
            let error = difference(&terms, &poisson(g), g);
            assert!(
                error <= chosen.error + ROUNDING,
                "g {g}, tolerance {tolerance}: {error:e} {chosen:?}"
            );
            if error > 10.0 * ROUNDING && chosen.error / error > loosest.0 {
                loosest = (chosen.error / error, g, tolerance);
            }
            let place = match chosen.method {
                Method::PoissonSum => 0,
                Method::GaussCharlier => 1,
                _ => 2,
            };
            let slot = &mut worst[place];
            slot.0 = slot.0.max(error / tolerance);
            if terms.len() > slot.1 {
                (slot.1, slot.2) = (terms.len(), g);
            }
        }
        println!("{tolerance:e}: Poisson, Gauss, geometric {worst:.3?}");
    }
    println!("loosest bound: {loosest:?} (bound/error, g, tolerance)");
    assert!(loosest.0 < 30.0, "{loosest:?}");
}

#[test]
fn no_step_where_one_method_takes_over_from_another() {
    for tolerance in TOLERANCES.into_iter().chain([1e-14, 1e-15]) {
        let kind = |g: f64| {
            let (terms, chosen) = chosen(g, tolerance);
            (terms.len(), chosen.method)
        };
        let mut switches = 0;
        let mut before = 1e-6;
        while before < 1e6 {
            let after = before * 1.05;
            // every change of method or count between them that bisection finds
            let (mut low, mut high) = (before, after);
            if kind(low) != kind(high) {
                while high > low * (1.0 + 1e-15) {
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        break;
                    }
                    if kind(middle) == kind(low) {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                switches += 1;
                let jump = difference(&chosen(low, tolerance).0, &chosen(high, tolerance).0, low);
                assert!(
                    jump < tolerance + ROUNDING,
                    "{tolerance:e}: {jump:e} at {low} {:?} {:?}",
                    kind(low),
                    kind(high)
                );
            }
            before = after;
        }
        assert!(switches > 0, "{tolerance}: {switches}");
    }
}

#[test]
fn slight_roughness_has_all_digits() {
    // e^(−g)(e^(gρ) − 1) = g ρ (1 + O(g)): lobe 2π g/m at m = 1
    for g in [1e-300, 1e-30, 1e-16, 1e-12, 1e-9] {
        for tolerance in [1e-2, 1e-12, 1e-15] {
            let (terms, _) = chosen(g, tolerance);
            let peak = lobe(&terms, [0.0; 2], &Vector2::zeros());
            // the next order is −g + g/4
            assert!((peak / g - (1.0 - 0.75 * g)).abs() < 1e-15, "{g} {peak}");
        }
    }
    let (r, chosen) = heights(0.0)
        .autocorrelation(1.0, Tolerance::ROUNDING)
        .unwrap();
    assert_eq!((r.delta_weight(), r.term_count()), (1.0, 1));
    assert_eq!((chosen.method, chosen.error), (Method::Exact, 0.0));
}

#[test]
fn the_mirror_keeps_its_part_and_nothing_is_lost() {
    for g in roughnesses() {
        for tolerance in TOLERANCES {
            let tolerance = Tolerance::relative(tolerance).unwrap();
            let (r, chosen) = heights(g).autocorrelation(1.0, tolerance).unwrap();
            assert!((r.at_zero() - 1.0).abs() < 1e-14, "{g} {}", r.at_zero());
            let g = heights(g).phase_variance(1.0);
            assert_eq!(r.delta_weight(), (-g).exp());
            assert_eq!(chosen.terms, r.term_count());
            assert!(r.is_positive());
        }
    }
    // below the smallest number there is no delta left for a plane wave to stumble over
    let (r, _) = heights(800.0)
        .autocorrelation(1.0, Tolerance::ROUNDING)
        .unwrap();
    assert_eq!(r.deltas().count(), 0);
}

/// Lobes of independent multi-precision sums: g, l, φ, F{R}(φ) without the coherent part, its weight.
const MULTI_PRECISION: [(f64, f64, [f64; 2], f64, f64); 5] = [
    (
        1.0000000000000001e-01,
        5.0000000000000004e-06,
        [2.2627416997969523e+05, 1.6970562748477139e+05],
        4.4521301015831276e-12,
        9.0483741803595952e-01,
    ),
    (
        3.0,
        5.0000000000000004e-06,
        [7.8383671769061685e+05, 5.8787753826796263e+05],
        2.8740352495127068e-12,
        4.9787068367863944e-02,
    ),
    (
        30.0,
        5.0000000000000004e-06,
        [1.2393546707863733e+06, 9.2951600308977999e+05],
        1.5927944206902994e-12,
        9.3576229688401748e-14,
    ),
    (
        400.0,
        2.0000000000000002e-05,
        [1.6970562748477142e+06, 1.2727922061357854e+06],
        1.0183454703563720e-12,
        0.0,
    ),
    (
        5000.0,
        1.0000000000000001e-05,
        [2.4000000000000000e+07, 1.7999999999999996e+07],
        6.9829541985771371e-16,
        0.0,
    ),
];

#[test]
fn lobes_are_those_of_multi_precision_sums() {
    for (g, length, phi, value, coherent) in MULTI_PRECISION {
        let surface = GaussianHeights::isotropic(1e-7, length).unwrap();
        let phi_z = g.sqrt() / 1e-7;
        let at = |tolerance: Tolerance| surface.autocorrelation(phi_z, tolerance).unwrap().0;
        let peak = at(Tolerance::ROUNDING).spectrum(&Vector2::zeros());
        let phi = Vector2::from(phi);
        for tolerance in TOLERANCES.into_iter().chain([1e-15]) {
            let r = at(Tolerance::relative(tolerance).unwrap());
            let error = (r.spectrum(&phi) - value).abs();
            // g from φ_z σ_h is a rounding or two off, and the exponent c = 36 of the last multiplies it
            let rounding = 1e-14 * value + 1e-15 * peak;
            assert!(
                error <= 0.5 * tolerance * peak + rounding,
                "{g} {tolerance}"
            );
            // below 1e-12 of the mirror, weights are absolute
            assert!((r.delta_weight() - coherent).abs() <= 1e-14 * coherent + 1e-160);
        }
    }
}

#[test]
fn great_roughness_is_beckmanns_lobe_of_slopes() {
    let (deviation, length) = (4e-6, 30e-6);
    let surface = GaussianHeights::isotropic(deviation, length).unwrap();
    let slopes = surface.slope_covariance().unwrap();
    let variance = 2.0 * (deviation / length).powi(2);
    assert!((slopes - Matrix2::from_diagonal_element(variance)).norm() < 1e-15 * variance);
    let phi_z = 2.0e7;
    let g = surface.phase_variance(phi_z);
    let tolerance = Tolerance::relative(1e-2).unwrap();
    let (r, chosen) = surface.autocorrelation(phi_z, tolerance).unwrap();
    assert_eq!(chosen.method, Method::GeometricOptics);
    // F{R} d²φ_t/(2π)² is the distribution of the slopes −φ_t/φ_z
    for slope in [0.0, 0.1, 0.3] {
        let beckmann =
            (-0.5 * slope * slope / variance).exp() / (2.0 * std::f64::consts::PI * variance);
        let phi = Vector2::new(slope * phi_z, 0.0);
        let found = r.spectrum(&phi) * (phi_z / (2.0 * std::f64::consts::PI)).powi(2);
        assert!((found / beckmann - 1.0).abs() < 1e-12, "{slope}");
    }
    assert!(g > 6000.0);
}

#[test]
fn slopes_of_anisotropic_heights_are_the_curvature_of_their_correlation() {
    let root = Matrix2::new(3e-6, 1e-6, -0.5e-6, 2e-6);
    let surface = GaussianHeights::new(2e-7, &root).unwrap();
    let slopes = surface.slope_covariance().unwrap();
    let inverse = (root.transpose() * root).try_inverse().unwrap();
    assert!((slopes - inverse * 4e-14).norm() < 1e-13 * slopes.norm());
    // R = 1 − g (1 − ρ) for small g: −∂²R = φ_z² ⟨slope²⟩
    let (r, _) = surface.autocorrelation(10.0, Tolerance::ROUNDING).unwrap();
    let step = Vector2::new(1e-9, 2e-9);
    let expected = 0.5 * 100.0 * step.dot(&(slopes * step));
    let rough = r.without_deltas();
    let drop = rough.at_zero() * (1.0 - rough.value(&step).re / rough.at_zero());
    // 1 − e^(−4e-7) has a relative rounding of 3e-10
    assert!((drop / expected - 1.0).abs() < 1e-6, "{drop} {expected}");
}

#[test]
fn what_is_no_surface_is_refused_with_its_numbers() {
    let text =
        |r: Result<_, mueller16::AutocorrelationError>| r.map(|_: ()| ()).unwrap_err().to_string();
    assert_eq!(
        text(GaussianHeights::isotropic(-1e-9, 1e-6).map(drop)),
        "autocorrelation: the standard deviation of the heights is -1e-9, expected a number between 0 and 1e24 m"
    );
    assert!(GaussianHeights::isotropic(f64::NAN, 1e-6).is_err());
    assert!(GaussianHeights::isotropic(1e-9, 0.0).is_err());
    assert!(GaussianHeights::isotropic(1e-9, f64::INFINITY).is_err());
    assert!(GaussianHeights::new(1e-9, &Matrix2::new(1.0, 1.0, 1.0, 1.0)).is_err());
    let surface = GaussianHeights::isotropic(1.0, 1.0).unwrap();
    let error = text(surface.autocorrelation(1e13, Tolerance::ROUNDING).map(drop));
    assert!(
        error.contains("is 1e26 at φ_z = 10000000000000.0 rad/m")
            && error.contains("expected 0 to 1e24"),
        "{error}"
    );
    assert!(
        surface
            .autocorrelation(f64::NAN, Tolerance::ROUNDING)
            .is_err()
    );
    // any g up to there has an answer
    let (terms, _) = chosen(1e20, 1e-15);
    assert!((terms[0].rate / 1e20 - 1.0).abs() < 1e-9);
}

/// Seeds once found wrong, from the package's root.
fn with_seeds() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(
            "proptest-regressions/heights.txt",
        ))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(with_seeds())]

    /// Sources of several points, whose coherence has any sign: the bound is for the largest value of *their* lobe.
    #[test]
    fn the_bound_holds_for_light_of_any_coherence(
        log_g in -3.0..4.0f64,
        log_tolerance in -9.0..-0.4f64,
        points in prop::collection::vec((-4.0..4.0f64, -4.0..4.0f64, 0.0..1.0f64), 1..12),
        width in 0.0..2.0f64,
    ) {
        let (g, tolerance) = (10f64.powf(log_g), 10f64.powf(log_tolerance));
        let (terms, chosen) = chosen(g, tolerance);
        let exact = poisson(g);
        let unit = g.max(1.0).sqrt();
        let average = |terms: &[GaussianTerm], q: &Vector2<f64>| -> f64 {
            let one = |(x, y, weight): &(f64, f64, f64)| {
                weight * lobe(terms, [width * unit; 2], &(q - Vector2::new(*x, *y) * unit))
            };
            points.iter().map(one).sum()
        };
        let (mut peak, mut error) = (0.0f64, 0.0f64);
        for i in -8..=8 {
            for j in -8..=8 {
                let q = Vector2::new(f64::from(i), f64::from(j)) * 0.5 * unit;
                let expected = average(&exact, &q);
                peak = peak.max(expected);
                error = error.max((average(&terms, &q) - expected).abs());
            }
        }
        prop_assert!(error <= (chosen.error + ROUNDING) * peak, "{} {} {:?}", g, error / peak, chosen);
    }
}
