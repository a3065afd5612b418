//! Channels of random phase screens against the sixteen of their ensemble at two points, and against their fields.

use csdm::{CloudeSpectrum, CorrelationLengths, Element, PhaseScreen, RoughRetarder};
use mueller16::{ChannelSet, Channels, Tolerance};
use nalgebra::{Matrix4, Vector2};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use stokes::{Mueller, Wavelength};

fn screen(deviations: [f64; 2], correlation: f64, [xx, yy, xy]: [f64; 3]) -> PhaseScreen {
    PhaseScreen::new(deviations, correlation, CorrelationLengths { xx, yy, xy }).unwrap()
}

fn channels(screen: &PhaseScreen, tolerance: f64) -> Channels {
    let tolerance = Tolerance::relative(tolerance).unwrap();
    let (channels, chosen) = Channels::of_phase_screen(screen, tolerance).unwrap();
    assert!(chosen.error <= 0.5 * tolerance.get(), "{chosen:?}");
    channels
}

/// Each channel by a function of its autocorrelation.
fn sixteen(channels: &Channels, of: impl Fn(mueller16::Autocorrelation) -> f64) -> Matrix4<f64> {
    Matrix4::from_fn(|l, j| channels.autocorrelation(j, l, 0).map_or(0.0, &of))
}

#[test]
fn channels_are_the_sixteen_of_the_ensemble_at_every_separation() {
    let cases = [
        screen([0.7, 1.3], -0.6, [2e-4, 3e-4, 2.6e-4]),
        screen([0.7, 1.3], 0.6, [2e-4, 3e-4, 2.6e-4]),
        screen([1e-4, 2.0], -0.9, [2e-4, 2e-4, 2.05e-4]),
        screen([0.0, 2.0], 0.5, [2e-4, 3e-4, 2.6e-4]),
        screen([5.0, 5.0], 1.0, [2e-4, 2e-4, 2e-4]),
        screen([3.0, 3.5], -0.8, [2e-4, 2e-4, 2.1e-4]),
        screen([12.0, 10.0], -0.5, [2e-4, 2e-4, 2.2e-4]),
        screen([12.0, 12.0], 0.98, [2e-4, 2e-4, 2e-4]),
        PhaseScreen::independent([0.3, 40.0], [2e-4, 3e-4]).unwrap(),
    ];
    for case in cases {
        let found = channels(&case, 1e-15);
        for distance in [0.0, 1e-6, 3e-5, 1e-4, 2e-4, 6e-4] {
            let x = Vector2::new(0.6, -0.8) * distance;
            let expected = case.generalized_mueller(&x, &Vector2::zeros()).scattering();
            let values = sixteen(&found, |r| r.value(&x).re);
            // exponents up to 1600 in the ensemble, each known to 1e-16 of itself
            let difference = (values - expected.map(|e| e.re)).abs().max();
            assert!(difference < 1e-13, "{case:?} {distance}: {difference:e}");
            assert!(expected.iter().all(|e| e.im == 0.0));
        }
    }
}

#[test]
fn rough_plates_are_the_sixteen_of_their_ensemble() {
    let light = Wavelength::from_metres(600e-9).unwrap();
    let tolerance = Tolerance::relative(1e-15).unwrap();
    // phases together, against each other, alone, and none
    let cases = [
        ([1.5, 1.6], 1.0, 150e-9),
        ([1.4, 1.6], 1.5, 300e-9),
        ([1.5, 1.6], 1.5, 500e-9),
        ([1.6, 1.45], 1.0, 0.0),
    ];
    for (indices, outside, roughness) in cases {
        let plate = RoughRetarder::new(light, indices, outside, 2.1e-6, roughness, 2e-4).unwrap();
        let (found, _) = Channels::of_rough_retarder(&plate, tolerance).unwrap();
        for distance in [0.0, 3e-5, 2e-4, 6e-4] {
            let x = Vector2::new(0.6, -0.8) * distance;
            let expected = plate
                .generalized_mueller(&x, &Vector2::zeros())
                .scattering();
            let values = sixteen(&found, |r| r.value(&x).re);
            let difference = (values - expected.map(|e| e.re)).abs().max();
            assert!(difference < 1e-13, "{indices:?} {distance}: {difference:e}");
        }
    }
}

#[test]
fn phases_of_multi_precision_sums() {
    // sx = sy = 1, c = 0, l_xx = 0.2 mm, l_yy = 0.3 mm, separation 0.1 mm
    let case = screen([1.0, 1.0], 0.0, [2e-4, 3e-4, 3e-4]);
    let found = sixteen(&channels(&case, 1e-15), |r| {
        r.value(&Vector2::new(1e-4, 0.0)).re
    });
    assert!((found[(0, 0)] - 8.5086842392976914e-01).abs() < 1e-14);
    assert!((found[(1, 0)] + 4.9311443266261995e-02).abs() < 1e-14);
    assert!((found[(3, 3)] - 3.6787944117144233e-01).abs() < 1e-14);
}

#[test]
fn only_what_is_there_is_computed() {
    let equal = screen([0.8, 0.8], 0.5, [2e-4; 3]);
    assert_eq!(channels(&equal, 1e-6).set(), ChannelSet::DIAGONAL);
    let unequal = screen([0.8, 0.9], 0.5, [2e-4; 3]);
    let set = channels(&unequal, 1e-6).set();
    assert!(set.is_within(ChannelSet::BLOCKS) && set.len() == 6, "{set}");
    // one phase for both axes: one autocorrelation for all of polarization
    let scalar = channels(&screen([0.8, 0.8], 1.0, [2e-4; 3]), 1e-6);
    assert_eq!(scalar.set(), ChannelSet::DIAGONAL);
    assert_eq!(
        scalar.autocorrelation(0, 0, 0),
        scalar.autocorrelation(3, 3, 0)
    );
}

#[test]
fn opposed_phases_keep_the_digits_of_their_lobe_within_the_tolerance() {
    for product in [1e-6f64, 0.3, 2.0, 8.0, 20.0, 39.9] {
        let s = product.sqrt();
        let case = PhaseScreen::without_spectral_check(
            [s, s],
            -1.0,
            CorrelationLengths {
                xx: 1e-4,
                yy: 1e-4,
                xy: 1e-4,
            },
        )
        .unwrap();
        // what is lost in the alternating sum, beside the intensity
        let fine = channels(&case, 1e-15);
        let intensity = fine.autocorrelation(0, 0, 0).unwrap();
        for tolerance in [1e-2, 1e-4, 1e-8, 1e-12] {
            let coarse = channels(&case, tolerance);
            for q in [0.0, 1e4, 5e4] {
                let phi = Vector2::new(q, 0.0);
                let peak = Vector2::zeros();
                let [a, b] = [&coarse, &fine].map(|c| c.autocorrelation(2, 2, 0).unwrap());
                let difference = (a.spectrum(&phi) - b.spectrum(&phi)).abs();
                let allowed =
                    0.5 * tolerance * b.spectrum(&peak).abs() + 1e-15 * intensity.spectrum(&peak);
                assert!(
                    difference <= allowed,
                    "{product} {tolerance} {difference:e}"
                );
            }
        }
        // the lobe is a hole: ∫ (e^(−a) − 1) < 0
        let hole = fine
            .autocorrelation(2, 2, 0)
            .unwrap()
            .spectrum(&Vector2::zeros());
        let ein: f64 = (0..20_000)
            .map(|i| {
                // ∫_0^1 (1 − e^(−at))/t dt by the midpoint rule
                let t = (f64::from(i) + 0.5) / 20_000.0;
                -(-product * t).exp_m1() / t / 20_000.0
            })
            .sum();
        let expected = -std::f64::consts::PI * 1e-8 * ein * (-product).exp();
        let scale = expected.abs() * 1e-6 + 1e-15 * intensity.spectrum(&Vector2::zeros());
        assert!(
            (hole - expected).abs() < scale,
            "{product}: {hole:e} {expected:e}"
        );
    }
}

#[test]
fn screens_beyond_the_arithmetic_are_refused_with_their_numbers() {
    let strong = PhaseScreen::independent([1e13, 1.0], [1e-4, 1e-4]).unwrap();
    let error = Channels::of_phase_screen(&strong, Tolerance::ROUNDING).unwrap_err();
    assert_eq!(
        error.to_string(),
        "autocorrelation: the variance of the phase is 1e26, expected a number between 0 and 1e24 rad²"
    );
    let thin = PhaseScreen::independent([1.0, 1.0], [1e-40, 1e-4]).unwrap();
    assert!(Channels::of_phase_screen(&thin, Tolerance::ROUNDING).is_err());
}

/// Seeds once found wrong, from the package's root.
fn with_seeds() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(
            "proptest-regressions/phase_screen.txt",
        ))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(with_seeds())]

    /// Bochner: the sixteen lobes of a screen that exists are a realizable Mueller matrix in every direction.
    #[test]
    fn lobes_of_a_screen_are_realizable_in_every_direction(
        sx in 0.0..6.0f64,
        sy in 0.0..6.0f64,
        c in -1.0..1.0f64,
        ratio in 0.5..2.0f64,
        position in 0.0..1.0f64,
        q in 0.0..5.0f64,
    ) {
        let (xx, yy) = (1.0, ratio);
        let least = ((xx * xx + yy * yy) / 2.0f64).sqrt();
        let most = (xx * yy / c.abs()).sqrt();
        prop_assume!(least < most);
        let xy = least + position * (most.min(10.0 * least) - least);
        let case = screen([sx, sy], c, [xx, yy, xy]);
        let found = channels(&case, 1e-12);
        let phi = Vector2::new(q, 0.3) * sx.max(sy).max(1.0);
        let mueller = Mueller::from(sixteen(&found, |r| r.spectrum(&phi)));
        let peak = found.autocorrelation(0, 0, 0).unwrap().spectrum(&Vector2::zeros());
        // three lobes, each within half of the tolerance of its largest value
        let slack = 2e-12 * peak / mueller.element(0, 0).max(1e-300);
        prop_assert!(CloudeSpectrum::of(&mueller).unwrap().check_realizable(slack).is_ok());
    }
}
