//! Surfaces of exponentially and K-correlated heights: numerical Hankel transforms and the limits of small and large g.

use mueller16::{
    Approximation, Autocorrelation, ExponentialHeights, KCorrelatedHeights, KCorrelation, Relief,
    Tolerance,
};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn unit() -> Matrix2<f64> {
    Matrix2::identity()
}

/// R of heights with σ = 1 at `φ_z = √g`.
fn rough(surface: &dyn Relief, g: f64, tolerance: f64) -> (Autocorrelation, Approximation) {
    let tolerance = Tolerance::relative(tolerance).unwrap();
    surface.autocorrelation(g.sqrt(), tolerance).unwrap()
}

fn exponential() -> ExponentialHeights {
    ExponentialHeights::new(1.0, &unit()).unwrap()
}

fn k_correlated(c: f64) -> KCorrelatedHeights {
    KCorrelatedHeights::new(1.0, KCorrelation::new(&unit(), c).unwrap()).unwrap()
}

fn lobe(r: &Autocorrelation, q: f64) -> f64 {
    r.spectrum(&Vector2::new(0.8 * q, -0.6 * q))
}

/// `J₀(z) = (1/n) Σ cos(z sin(2πk/n))`, whose error is `2 J_n(z)`: none for n > z + 40.
fn bessel_j0(z: f64) -> f64 {
    let n = 60 + (1.2 * z) as i32;
    let sum: f64 = (0..n)
        .map(|k| (z * (TAU * f64::from(k) / f64::from(n)).sin()).cos())
        .sum();
    sum / f64::from(n)
}

/// `2π ∫ (e^(−g D) − e^(−g)) J₀(qu) u du` over `ln u` by the trapezoidal rule; x is q in widths of the lobe.
fn hankel(g: f64, structure: impl Fn(f64) -> f64, q: f64, x: f64) -> f64 {
    // the phase q u turns by at most a radian in a step where there is something to turn
    let per_unit = 96 * (1 + x as i32);
    let h = 1.0 / f64::from(per_unit);
    let term = |k: i32| {
        let u = (h * f64::from(k)).exp();
        let value = (-g * structure(u)).exp() - (-g).exp();
        // the bound on |J₀| keeps the long and useless sums away
        if value * u * u < 1e-16 / (1.0 + g * g) {
            0.0
        } else {
            value * bessel_j0(q * u) * u * u
        }
    };
    TAU * h * (-26 * per_unit..5 * per_unit).map(term).sum::<f64>()
}

/// `1 − (1 + u) e^(−u)`, of the exponent 5/2, without cancellation.
fn structure_five_halves(u: f64) -> f64 {
    if u < 1e-2 {
        u * u * (0.5 - u / 3.0 + u * u / 8.0 - u * u * u / 30.0)
    } else {
        -(-u).exp_m1() - u * (-u).exp()
    }
}

#[test]
fn the_lobe_is_the_hankel_transform() {
    for g in [0.01, 1.0, 7.0, 60.0, 1e3] {
        let exact = |q: f64, x: f64| hankel(g, |u| -(-u).exp_m1(), q, x);
        let also = |q: f64, x: f64| hankel(g, structure_five_halves, q, x);
        // in units of the lobe's width
        for x in [0.0, 0.5, 2.0, 6.0] {
            let (q, s) = (x * (1.0 + g), x * (1.0 + g.sqrt()));
            let (exponential_lobe, smooth_lobe) = (exact(q, x), also(s, x));
            let (peak, smooth_peak) = (exact(0.0, 0.0), also(0.0, 0.0));
            for tolerance in [1e-2, 1e-4, 1e-6] {
                let cases: [(&dyn Relief, f64, f64, f64); 3] = [
                    (&exponential(), q, exponential_lobe, peak),
                    (&k_correlated(1.5), q, exponential_lobe, peak),
                    (&k_correlated(2.5), s, smooth_lobe, smooth_peak),
                ];
                for (i, (surface, at, expected, peak)) in cases.into_iter().enumerate() {
                    let (r, chosen) = rough(surface, g, tolerance);
                    let error = (lobe(&r, at) - expected).abs() / peak;
                    assert!(chosen.error <= tolerance, "{i} {g} {chosen:?}");
                    // 1e-9: the series for small u and the rule of the test
                    assert!(
                        error <= chosen.error + 1e-9,
                        "{i} g {g} x {x}: {error} {chosen:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_mirror_keeps_its_weight_and_all_is_one() {
    let surfaces: [&dyn Relief; 4] = [
        &exponential(),
        &k_correlated(1.5),
        &k_correlated(2.0),
        &k_correlated(8.0),
    ];
    for surface in surfaces {
        for g in [0.0, 1e-12, 1e-3, 0.125, 0.5, 3.0, 40.0, 1e4, 1e6] {
            let (r, chosen) = rough(surface, g, 1e-3);
            let mirror: f64 = (-g).exp();
            assert!(
                (r.delta_weight() - mirror).abs() <= 4e-16 * mirror * (1.0 + g),
                "{g}"
            );
            assert!((r.at_zero() - 1.0).abs() < 1e-14, "{g}");
            assert!(r.is_positive() && chosen.error <= 1e-3, "{g} {chosen:?}");
            // one mixture, not Poisson times as many
            assert!(chosen.terms < 70, "{g} {chosen:?}");
        }
    }
}

#[test]
fn both_ways_to_the_exponential_agree() {
    for g in [1e-4, 0.3, 5.0, 200.0, 3e5] {
        let (a, first) = rough(&exponential(), g, 1e-5);
        let (b, second) = rough(&k_correlated(1.5), g, 1e-5);
        for x in [0.0, 1.0, 4.0, 20.0] {
            let q = x * (1.0 + g);
            let error = (lobe(&a, q) - lobe(&b, q)).abs() / lobe(&a, 0.0);
            assert!(error <= first.error + second.error, "{g} {x}: {error}");
        }
    }
}

#[test]
fn a_slightly_rough_surface_shows_its_spectrum() {
    let (g, tolerance) = (1e-7, 1e-6);
    for q in [0.0_f64, 0.5, 2.0, 5.0] {
        for c in [1.2, 1.5, 2.5, 6.0] {
            let expected = 4.0 * PI * (c - 1.0) * (1.0 + q * q).powf(-c);
            let peak = 4.0 * PI * (c - 1.0);
            let error = (lobe(&rough(&k_correlated(c), g, tolerance).0, q) / g - expected) / peak;
            assert!(error.abs() <= tolerance + g, "{c} {q}: {error}");
        }
        // relative in the tail, too
        let (r, _) = rough(&exponential(), g, tolerance);
        let expected = TAU * (1.0 + 400.0 * q * q).powf(-1.5);
        let error = lobe(&r, 20.0 * q) / g / expected - 1.0;
        assert!(error.abs() <= tolerance + 4.0 * g, "{q}: {error}");
    }
}

#[test]
fn a_very_rough_exponential_surface_has_a_cusp_of_width_one_over_g() {
    // F(0) = (2π/g²)(1 + 3/g + 11/g² + …), from 1 − e^(−u) = u − u²/2 + u³/6
    for g in [300.0, 1e4, 1e6] {
        for surface in [&exponential() as &dyn Relief, &k_correlated(1.5)] {
            let (r, chosen) = rough(surface, g, 1e-6);
            let ratio = lobe(&r, 0.0) / (TAU / (g * g)) - (1.0 + 3.0 / g + 11.0 / (g * g));
            assert!(
                ratio.abs() <= chosen.error + 200.0 / g.powi(3),
                "{g}: {ratio} {chosen:?}"
            );
            // and its tail is that of e^(−gu), far beyond every Gaussian
            let q = 10.0 * g;
            let tail = lobe(&r, q) / (TAU * g / (g * g + q * q).powf(1.5)) - 1.0;
            assert!(
                tail.abs() <= chosen.error * 1030.0 + 10.0 / g,
                "{g}: {tail}"
            );
        }
    }
}

#[test]
fn a_very_rough_smooth_surface_shows_its_slopes() {
    // c = 5/2: D = u²/2 − u³/3, F(0) = (2π/g)(1 + √(π/2g) + O(1/g)); slopes of variance 1 per axis
    let surface = k_correlated(2.5);
    assert!((surface.slope_covariance().unwrap() - unit()).amax() < 1e-12);
    for g in [1e4, 1e6] {
        let (r, chosen) = rough(&surface, g, 1e-6);
        let ratio = lobe(&r, 0.0) / (TAU / g) - 1.0 - (PI / (2.0 * g)).sqrt();
        assert!(ratio.abs() <= chosen.error + 10.0 / g, "{g}: {ratio}");
        // one standard deviation of slope
        let drop = lobe(&r, g.sqrt()) / lobe(&r, 0.0) - (-0.5f64).exp();
        assert!(drop.abs() < 2.0 / g.sqrt(), "{g}: {drop}");
    }
}

#[test]
fn slopes_are_those_of_the_curvature_at_zero() {
    let root = Matrix2::new(2e-6, 0.0, 1e-6, 5e-6);
    let inner = KCorrelation::with_inner_scale(&root, 1.5, 0.1).unwrap();
    let surface = KCorrelatedHeights::new(1e-7, inner).unwrap();
    let slopes = surface.slope_covariance().unwrap();
    // exponential of √(u² + b²): ρ'' = −1/b, with 1 − ρ = u²/2b
    let covariance = root.transpose() * root;
    let expected = covariance.try_inverse().unwrap() * (1e-14 / 0.1);
    assert!(
        (slopes - expected).amax() < 1e-10 * expected.amax(),
        "{slopes} {expected}"
    );
    assert_eq!(exponential().slope_covariance(), None);
    assert_eq!(k_correlated(2.0).slope_covariance(), None);
    let c3 = k_correlated(3.0).slope_covariance().unwrap();
    assert!((c3 - unit() * 0.5).amax() < 1e-12);
}

#[test]
fn nothing_jumps_where_the_number_of_squares_does() {
    let surface = k_correlated(1.7);
    for doubling in -4..14 {
        let g = f64::from(doubling).exp2();
        let (below, first) = rough(&surface, g * (1.0 - 1e-12), 1e-4);
        let (above, second) = rough(&surface, g * (1.0 + 1e-12), 1e-4);
        for x in [0.0, 1.0, 3.0] {
            let q = x * (1.0 + g).powf(0.5 / 0.7);
            let jump = (lobe(&below, q) - lobe(&above, q)).abs() / lobe(&below, 0.0);
            assert!(
                jump <= first.error + second.error + 1e-11,
                "{g} {x}: {jump}"
            );
            assert!(jump <= 1e-4);
        }
    }
}

#[test]
fn anisotropic_roughness_follows_its_root() {
    let root = Matrix2::new(2e-6, 1e-6, -4e-7, 9e-6);
    let tolerance = Tolerance::relative(1e-4).unwrap();
    let stretched = ExponentialHeights::new(1e-7, &root).unwrap();
    let (r, _) = stretched.autocorrelation(2e7, tolerance).unwrap();
    let (plain, _) = rough(&exponential(), 4.0, 1e-4);
    let q = Vector2::new(0.7, -1.9);
    let at = root.try_inverse().unwrap() * q;
    let expected = plain.spectrum(&q) * root.determinant().abs();
    assert!((r.spectrum(&at) / expected - 1.0).abs() < 1e-12);
}

#[test]
fn what_cannot_be_held_is_said() {
    let tolerance = Tolerance::relative(1e-3).unwrap();
    let text = exponential()
        .autocorrelation(1e5, tolerance)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("(φ_z σ_h)² is 1") && text.contains("expected 0 to 100000000.0"),
        "{text}"
    );
    assert!(exponential().autocorrelation(f64::NAN, tolerance).is_err());
    assert!(ExponentialHeights::new(-1.0, &unit()).is_err());
    assert!(ExponentialHeights::new(1.0, &Matrix2::zeros()).is_err());
    let text = k_correlated(1.1)
        .autocorrelation(1e3, tolerance)
        .unwrap_err()
        .to_string();
    assert!(text.contains("inner scale"), "{text}");
}

#[test]
fn a_narrow_core_does_not_hide_the_wide_lobe_below_it() {
    // a millionth of R decays over a correlation length and makes most of the lobe, the rest over the inner scale
    for (exponent, inner) in [(0.6, 1e-3), (0.6, 1e-4), (0.5, 1e-3), (1.0, 1e-3)] {
        let correlation = KCorrelation::with_inner_scale(&unit(), exponent, inner).unwrap();
        let surface = KCorrelatedHeights::new(1.0, correlation).unwrap();
        for g in [1.0, 10.05, 30.0] {
            for tolerance in [1e-3, 2e-4, 1e-6] {
                let (_, chosen) = rough(&surface, g, tolerance);
                assert!(
                    chosen.error <= tolerance,
                    "{exponent} {inner} {g} {tolerance:e}: {chosen:?}"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn every_roughness_keeps_what_it_was_asked_for(
        exponent in -8.0..4.0f64,
        c in prop_oneof![Just(1.5), 1.4..2.2f64, 2.2..20.0f64],
        inner in prop_oneof![Just(0.0), 0.001..1.0f64],
        tolerance in -4.0..-1.0f64,
    ) {
        let (g, tolerance) = (10f64.powf(exponent), 10f64.powf(tolerance));
        let correlation = if inner == 0.0 {
            KCorrelation::new(&unit(), c)
        } else {
            KCorrelation::with_inner_scale(&unit(), c - 0.9, inner)
        };
        let surface = KCorrelatedHeights::new(1.0, correlation.unwrap()).unwrap();
        for surface in [&surface as &dyn Relief, &exponential()] {
            let (r, chosen) = rough(surface, g, tolerance);
            prop_assert!(r.is_positive());
            prop_assert!((r.at_zero() - 1.0).abs() < 1e-14);
            prop_assert!(chosen.error <= tolerance, "{:?}", chosen);
        }
    }
}

/// Prints number of terms, error and time: `cargo test -p mueller16 --release --test autocorrelation -- --ignored --nocapture`.
#[test]
#[ignore = "prints figures"]
fn figures() {
    println!("tolerance g: surface terms error microseconds");
    for tolerance in [1e-2, 1e-4, 1e-6] {
        for g in [1e-6_f64, 1e-2, 1.0, 30.0, 1e3, 1e6] {
            let rows: [(&str, &dyn Relief); 4] = [
                ("exponential", &exponential()),
                ("c=1.3", &k_correlated(1.3)),
                ("c=1.5", &k_correlated(1.5)),
                ("c=2.5", &k_correlated(2.5)),
            ];
            for (name, surface) in rows {
                let start = std::time::Instant::now();
                let found =
                    surface.autocorrelation(g.sqrt(), Tolerance::relative(tolerance).unwrap());
                let time = start.elapsed().as_micros();
                match found {
                    Ok((_, a)) => println!(
                        "{tolerance:e} {g:e}: {name} {} {:.1e} {time}",
                        a.terms, a.error
                    ),
                    Err(error) => println!("{tolerance:e} {g:e}: {name} {error}"),
                }
            }
        }
    }
}
