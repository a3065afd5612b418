//! Amplitudes of a grating's orders against quadrature, Parseval and each other.

use std::f64::consts::{PI, TAU};

use mueller16::{Blaze, Grating, Profile, Relief, Tolerance};
use nalgebra::Vector2;
use num_complex::Complex64;
use proptest::prelude::*;

/// Roundings of a phase of `psi` rad, of an order's phase and of a sum of a few terms.
fn rounding(psi: f64) -> f64 {
    8.0 * f64::EPSILON * (1.0 + psi.abs())
}

/// `∫₀¹ e^(−i(φ_z h(u) + 2πqu)) du` by three-point Gauss quadrature between breaks, where h is smooth.
///
/// The rule errs by `(a w)⁶/2,016,000` of each panel of width w for a phase of slope a: below 1e-14 for `a w < 0.05`.
fn quadrature(
    phi_z: f64,
    q: i32,
    breaks: &[f64],
    panels: usize,
    h: impl Fn(f64) -> f64,
) -> Complex64 {
    let nodes = [
        (-0.6f64.sqrt(), 5.0 / 18.0),
        (0.0, 4.0 / 9.0),
        (0.6f64.sqrt(), 5.0 / 18.0),
    ];
    let mut sum = Complex64::ZERO;
    for ends in breaks.windows(2) {
        let width = (ends[1] - ends[0]) / panels as f64;
        // sums of sums: at most 3·100 + 30·3 roundings of numbers up to 1
        for block in 0..panels.div_ceil(100) {
            let mut part = Complex64::ZERO;
            for panel in 100 * block..panels.min(100 * (block + 1)) {
                let middle = ends[0] + width * (panel as f64 + 0.5);
                for (node, weight) in nodes {
                    let u = middle + 0.5 * width * node;
                    let phase = phi_z * h(u) + TAU * f64::from(q) * u;
                    part += Complex64::cis(-phase) * weight;
                }
            }
            sum += part * width;
        }
    }
    sum
}

fn near(found: Complex64, expected: Complex64, tolerance: f64) -> bool {
    (found - expected).norm() <= tolerance
}

const DEPTH: f64 = 2e-7;

#[test]
fn every_profile_has_the_orders_of_its_definition() {
    let vertices = vec![
        [0.0, 1e-8],
        [0.2, 1.3e-7],
        [0.45, 0.0],
        [0.45, 9e-8],
        [1.0, 4e-8],
    ];
    let corner = |u: f64| {
        let i = vertices.iter().rposition(|v| v[0] <= u).unwrap();
        let (a, b) = (vertices[i], vertices[i + 1]);
        a[1] + (b[1] - a[1]) * (u - a[0]) / (b[0] - a[0])
    };
    type Height<'a> = Box<dyn Fn(f64) -> f64 + 'a>;
    let cases: Vec<(Profile, Vec<f64>, Height<'_>)> = vec![
        (
            Profile::sinusoidal(DEPTH).unwrap(),
            vec![0.0, 1.0],
            Box::new(|u| 0.5 * DEPTH * (TAU * u).cos()),
        ),
        (
            Profile::lamellar(DEPTH, 0.3).unwrap(),
            vec![0.0, 0.15, 0.85, 1.0],
            Box::new(|u| if (u - 0.5).abs() > 0.35 { DEPTH } else { 0.0 }),
        ),
        (
            Profile::blazed(DEPTH, Blaze::Rising).unwrap(),
            vec![0.0, 1.0],
            Box::new(|u| DEPTH * u),
        ),
        (
            Profile::blazed(DEPTH, Blaze::Falling).unwrap(),
            vec![0.0, 1.0],
            Box::new(|u| DEPTH * (1.0 - u)),
        ),
        (
            Profile::triangular(DEPTH, 0.7).unwrap(),
            vec![0.0, 0.7, 1.0],
            Box::new(|u| DEPTH * if u < 0.7 { u / 0.7 } else { (1.0 - u) / 0.3 }),
        ),
        (
            Profile::piecewise_linear(vertices.clone()).unwrap(),
            vec![0.0, 0.2, 0.45, 1.0],
            Box::new(corner),
        ),
    ];
    for (profile, breaks, h) in &cases {
        for phi_z in [0.0, 1.3e7, -4e7, 1e8] {
            let all = profile.amplitudes(phi_z, -12..=12);
            for (q, found) in (-12..=12).zip(all) {
                // slopes: at most 67 + 75 rad over the pitch
                let expected = quadrature(phi_z, q, breaks, 3000, h);
                assert!(
                    near(found, expected, 1e-13),
                    "{profile:?} {phi_z} {q}: {found} {expected}"
                );
                assert!(near(
                    profile.amplitude(phi_z, q),
                    found,
                    rounding(phi_z * DEPTH)
                ));
            }
        }
    }
}

#[test]
fn shares_are_those_of_the_textbook() {
    let phi_z = 2.2e7;
    let psi = phi_z * DEPTH;
    let f = 0.3;
    for q in -9..=9 {
        let sine = Profile::sinusoidal(DEPTH)
            .unwrap()
            .amplitude(phi_z, q)
            .norm_sqr();
        assert!((sine - libm::jn(q, 0.5 * psi).powi(2)).abs() < rounding(psi));
        let lamellar = Profile::lamellar(DEPTH, f)
            .unwrap()
            .amplitude(phi_z, q)
            .norm_sqr();
        let expected = match q {
            0 => 1.0 - 2.0 * f * (1.0 - f) * (1.0 - psi.cos()),
            _ => {
                2.0 * (1.0 - psi.cos()) * (PI * f64::from(q) * f).sin().powi(2)
                    / (PI * f64::from(q)).powi(2)
            }
        };
        assert!((lamellar - expected).abs() < rounding(psi), "{q}");
        let blazed = Profile::blazed(DEPTH, Blaze::Rising)
            .unwrap()
            .amplitude(phi_z, q)
            .norm_sqr();
        let u = PI * (f64::from(q) + psi / TAU);
        assert!(
            (blazed - (u.sin() / u).powi(2)).abs() < rounding(psi),
            "{q}"
        );
    }
}

#[test]
fn a_sampled_sine_is_a_sine_and_its_samples_come_in_order() {
    // a line that is not its own mirror image: sin, a quarter of a period from the cosine: t_q = J_q(ψ/2) (−1)^q
    let n = 64;
    let heights = (0..n).map(|i| 0.5 * DEPTH * (TAU * f64::from(i) / f64::from(n)).sin());
    let sampled = Profile::sampled(heights.collect()).unwrap();
    let phi_z = 3e7;
    for q in -12..=12 {
        let expected = libm::jn(q, 0.5 * phi_z * DEPTH) * if q % 2 == 0 { 1.0 } else { -1.0 };
        // aliases J_52(3) are below 1e-58
        let found = sampled.amplitude(phi_z, q);
        assert!(
            near(found, expected.into(), 1e-15),
            "{q} {found} {expected}"
        );
        assert!(near(sampled.amplitudes(phi_z, q..=q)[0], found, 1e-15));
    }
    assert_eq!(sampled.amplitude(phi_z, 40), Complex64::ZERO);
    assert_eq!(sampled.amplitudes(phi_z, 32..=32)[0], Complex64::ZERO);
}

fn some_profile() -> impl Strategy<Value = Profile> {
    prop_oneof![
        (0.0..1e-6f64).prop_map(|d| Profile::sinusoidal(d).expect("numbers are in range")),
        (
            0.0..1e-6f64,
            prop_oneof![0.0..=1.0f64, Just(0.0), Just(1.0), Just(0.5)]
        )
            .prop_map(|(d, f)| Profile::lamellar(d, f).expect("numbers are in range")),
        (0.0..1e-6f64)
            .prop_map(|d| Profile::blazed(d, Blaze::Falling).expect("numbers are in range")),
        (
            0.0..1e-6f64,
            prop_oneof![0.0..=1.0f64, Just(0.0), Just(1e-9), Just(1.0)]
        )
            .prop_map(|(d, apex)| Profile::triangular(d, apex).expect("numbers are in range")),
        prop::collection::vec(0.0..1e-6f64, 1..40)
            .prop_map(|h| Profile::sampled(h).expect("numbers are in range")),
    ]
}

proptest! {
    #[test]
    fn special_profiles_are_straight_segments(
        psi in prop_oneof![-20.0..20.0f64, -1e4..1e4f64, Just(0.0), Just(TAU), -1e-9..1e-9f64],
        q in prop_oneof![-20..20i32, -10_000..10_000i32],
        f in prop_oneof![0.0..1.0f64, Just(0.5), 0.0..1e-9f64],
    ) {
        let (d, phi_z) = (1e-7, psi / 1e-7);
        let linear = |v: Vec<[f64; 2]>| Profile::piecewise_linear(v).unwrap().amplitude(phi_z, q);
        let tolerance = rounding(psi);
        let rising = Profile::blazed(d, Blaze::Rising).unwrap().amplitude(phi_z, q);
        prop_assert!(near(rising, linear(vec![[0.0, 0.0], [1.0, d]]), tolerance));
        let falling = Profile::blazed(d, Blaze::Falling).unwrap().amplitude(phi_z, q);
        prop_assert!(near(falling, linear(vec![[0.0, d], [1.0, 0.0]]), tolerance));
        // half the ridge at each end
        let (a, b) = (0.5 * f, 1.0 - 0.5 * f);
        let ridge = vec![[0.0, d], [a, d], [a, 0.0], [b, 0.0], [b, d], [1.0, d]];
        let lamellar = Profile::lamellar(d, f).unwrap().amplitude(phi_z, q);
        // the place b is rounded, and seen with 2πq
        let place = TAU * f64::from(q.abs()) * f64::EPSILON;
        prop_assert!(near(lamellar, linear(ridge), tolerance + place), "{lamellar}");
    }

    #[test]
    fn all_orders_of_a_sine_together_are_the_whole(psi in 0.0..1e4f64) {
        let last = (0.5 * psi + 20.0 * psi.cbrt()) as i32 + 30;
        let sine = Profile::sinusoidal(1e-7).unwrap();
        let sum: f64 = sine.amplitudes(psi / 1e-7, -last..=last).iter().map(Complex64::norm_sqr).sum();
        prop_assert!((sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn all_orders_of_a_blaze_together_are_the_whole(psi in -1e4..1e4f64) {
        // Σ beyond Q is at most 2/(π² (Q − ψ/2π))
        let last = 8000;
        let blaze = Profile::blazed(1e-7, Blaze::Rising).unwrap();
        let sum: f64 = blaze.amplitudes(psi / 1e-7, -last..=last).iter().map(Complex64::norm_sqr).sum();
        let beyond = 2.0 / (PI * PI * (f64::from(last) - psi.abs() / TAU));
        prop_assert!(sum <= 1.0 + rounding(psi) && sum >= 1.0 - beyond - rounding(psi), "{sum}");
    }

    #[test]
    fn an_autocorrelation_leaves_out_less_than_it_says(
        profile in some_profile(), phi_z in -5e7..5e7f64, exponent in 1..12i32,
    ) {
        let tolerance = Tolerance::relative(10f64.powi(-exponent)).unwrap();
        let grating = Grating::lines(2e-6, Vector2::x(), profile.clone()).unwrap();
        let (r, chosen) = grating.autocorrelation(phi_z, tolerance).unwrap();
        let largest = profile.amplitudes(phi_z, -60..=60).iter().map(Complex64::norm_sqr).fold(0.0, f64::max);
        let missing = 1.0 - r.at_zero();
        prop_assert!(missing <= chosen.error * largest * (1.0 + 1e-9) + rounding(50.0), "{missing} {chosen:?}");
        prop_assert!(r.is_positive() && r.term_count() == chosen.terms);
        // where 10,000 orders are enough, and more than rounding is asked for
        if exponent <= 2 {
            prop_assert!(chosen.error <= tolerance.get());
        }
        for (weight, place) in r.deltas() {
            let q = (place.x * 2e-6 / TAU).round() as i32;
            prop_assert!((weight - profile.amplitude(phi_z, q).norm_sqr()).abs() < rounding(50.0));
        }
    }
}

#[test]
fn slopes_are_those_of_the_profile() {
    let pitch = 3e-6;
    let across = Vector2::new(0.6, 0.8);
    let covariance = |profile| {
        Grating::lines(pitch, across, profile)
            .unwrap()
            .slope_covariance()
    };
    // ⟨(πd/p sin)²⟩ = (πd/p)²/2
    let sine = covariance(Profile::sinusoidal(DEPTH).unwrap()).unwrap();
    let expected = 0.5 * (PI * DEPTH / pitch).powi(2) * across * across.transpose();
    assert!((sine - expected).amax() < 1e-17);
    // slopes d/(0.25 p) and −d/(0.75 p)
    let ridge = covariance(Profile::triangular(DEPTH, 0.25).unwrap()).unwrap();
    let expected = (DEPTH / pitch).powi(2) * (4.0 + 4.0 / 3.0) * across * across.transpose();
    assert!((ridge - expected).amax() < 1e-17, "{ridge} {expected}");
    assert!(covariance(Profile::lamellar(DEPTH, 0.5).unwrap()).is_none());
    assert!(covariance(Profile::triangular(DEPTH, 1.0).unwrap()).is_none());
    assert!(covariance(Profile::blazed(DEPTH, Blaze::Rising).unwrap()).is_none());
}

#[test]
fn what_is_no_grating_is_refused_with_its_numbers() {
    let text = |e: mueller16::GratingError| e.to_string();
    assert_eq!(
        text(Profile::lamellar(1e-7, 1.5).unwrap_err()),
        "grating: the ridge fraction is 1.5, expected a number from 0 to 1"
    );
    assert_eq!(
        text(
            Profile::piecewise_linear(vec![[0.0, 0.0], [0.6, 0.0], [0.5, 0.0], [1.0, 0.0]])
                .unwrap_err()
        ),
        "grating: the place of a vertex is 0.5, expected a number from 0.6 to 1"
    );
    assert_eq!(
        text(Profile::sampled(vec![]).unwrap_err()),
        "grating: 0 samples, expected at least 1"
    );
    for depth in [-1e-7, f64::NAN, f64::INFINITY] {
        assert!(Profile::sinusoidal(depth).is_err());
        assert!(Profile::blazed(depth, Blaze::Rising).is_err());
        assert!(Profile::sampled(vec![0.0, depth * 1e8]).is_err());
    }
    assert!(Profile::piecewise_linear(vec![]).is_err());
    assert!(Profile::piecewise_linear(vec![[0.0, 0.0]]).is_err());
    assert!(Profile::piecewise_linear(vec![[0.1, 0.0], [1.0, 0.0]]).is_err());
    let flat = || Profile::sinusoidal(0.0).unwrap();
    for pitch in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
        assert!(Grating::lines(pitch, Vector2::x(), flat()).is_err());
    }
    assert!(Grating::lines(1e-6, Vector2::new(1.0, 1.0), flat()).is_err());
    let deep = Grating::lines(1e-6, Vector2::x(), Profile::sinusoidal(1e-2).unwrap()).unwrap();
    for phi_z in [1e8, f64::NAN, f64::INFINITY] {
        assert!(deep.autocorrelation(phi_z, Tolerance::ROUNDING).is_err());
    }
}
