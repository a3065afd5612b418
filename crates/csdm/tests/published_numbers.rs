//! Fields against numbers that others have published or measured: interfaces, plates, polarizers, random retarders.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use csdm::film::{Stack, StackAmplitudes};
use csdm::{
    CorrelationLengths, CrossSpectralDensity, Element, JonesMatrix, PhaseScreen, RoughRetarder,
};
use nalgebra::Vector2;
use num_complex::Complex64;
use stokes::{Handedness, Mueller, StokesVector, Wavelength};

fn interface(n1: f64, n2: Complex64, degrees: f64) -> StackAmplitudes {
    // without layers no wavelength enters
    let light = Wavelength::from_metres(550e-9).expect("positive");
    let bare = Stack::new(n1, vec![], n2).expect("passive media");
    bare.amplitudes(degrees.to_radians().cos(), light)
}

fn metal(eta: f64, k: f64, degrees: f64) -> Mueller {
    interface(1.0, Complex64::new(eta, -k), degrees).reflection_mueller()
}

/// The matrix `[[A, B, 0, 0], [B, A, 0, 0], [0, 0, c, s], [0, 0, −s, c]]`.
fn assert_blocks(found: Mueller, [a, b, c, s]: [f64; 4], tolerance: f64) {
    let expected = Mueller::from_rows([
        [a, b, 0.0, 0.0],
        [b, a, 0.0, 0.0],
        [0.0, 0.0, c, s],
        [0.0, 0.0, -s, c],
    ]);
    let error = (found.to_matrix() - expected.to_matrix()).amax();
    assert!(error < tolerance, "{found:?} is off by {error}");
}

fn near(found: StokesVector, expected: StokesVector, tolerance: f64) -> bool {
    (found - expected).to_vector().norm() < tolerance
}

#[test]
fn metals_reflect_as_another_program_computes() {
    // Mitsuba 3: silver at 635.8 nm, gold at 633 nm; all printed digits
    let silver = metal(0.136_125, 4.010_625, 45.0);
    assert_blocks(
        silver,
        [0.967_348_9, 0.010_723_4, -0.910_787_2, -0.325_754],
        6e-7,
    );
    let gold = metal(0.183, 3.43, 75.0);
    assert_blocks(
        gold,
        [0.939_455_7, 0.046_389_4, 0.009_813_9, -0.938_258_4],
        6e-8,
    );
}

#[test]
fn phases_of_reflection_have_the_sign_that_another_program_measures() {
    // Mitsuba 3: elements (2, 2) and (2, 3), five digits
    for (mueller, cosine, sine) in [
        (metal(0.2, 3.2, 60.0), -0.612_04, -0.693_62),
        (metal(1.5, 4.0, 70.0), -0.332_79, -0.574_19),
        (
            interface(1.51, 1.0.into(), 54.6).reflection_mueller(),
            0.706_96,
            -0.707_26,
        ),
    ] {
        assert!((mueller.element(2, 2) - cosine).abs() < 5.1e-6);
        assert!((mueller.element(2, 3) - sine).abs() < 5.1e-6);
        assert!((mueller.element(3, 2) + sine).abs() < 5.1e-6);
    }
}

#[test]
fn glass_at_45_degrees_splits_light_as_tabulated() {
    // Mitsuba 3, seven digits
    let glass = interface(1.0, 1.5.into(), 45.0);
    assert_blocks(
        glass.reflection_mueller(),
        [0.050_239_9, 0.041_773_5, -0.027_911_1, 0.0],
        6e-8,
    );
    let passed = glass.transmission_mueller().unwrap();
    assert_blocks(passed, [0.949_760_1, -0.041_773_5, 0.948_841, 0.0], 6e-7);
}

#[test]
fn glass_at_brewsters_angle_reflects_s_light_only() {
    // Mitsuba 3, test_mueller.py, in single precision
    let brewster = 1.5f64.atan().to_degrees();
    let glass = interface(1.0, 1.5.into(), brewster);
    assert_blocks(
        glass.reflection_mueller(),
        [0.073_964_5, 0.073_964_5, 0.0, 0.0],
        6e-8,
    );
    let passed = glass.transmission_mueller().unwrap();
    assert_blocks(
        passed,
        [0.926_035_5, -0.073_964_51, 0.923_077_05, 0.0],
        2e-7,
    );
}

#[test]
fn a_mirror_at_normal_incidence_is_a_half_wave_plate() {
    // Mitsuba 3, test_mueller.py: 0.04 times a retarder of π for an index of 1.5
    let mirror = interface(1.0, 1.5.into(), 0.0).reflection_mueller();
    let expected = JonesMatrix::half_wave_plate().mueller() * 0.04;
    assert!((mirror.to_matrix() - expected.to_matrix()).amax() < 1e-16);
}

#[test]
fn a_pile_of_plates_polarizes_as_tabulated() {
    // index 1.5 at Brewster's angle, reflected light left out; n surfaces
    let into = interface(1.0, 1.5.into(), 1.5f64.atan().to_degrees());
    let out_of = interface(1.5, 1.0.into(), (1.0 / 1.5f64).atan().to_degrees());
    let plate = out_of.transmission_mueller().unwrap() * into.transmission_mueller().unwrap();
    let mut light = StokesVector::UNPOLARIZED;
    for surfaces in 1..=8 {
        light = plate * light;
        let expected = match surfaces {
            1 => 0.158_73,
            2 => 0.309_66,
            4 => 0.565_13,
            8 => 0.856_67,
            _ => continue,
        };
        assert!((light.degree_of_polarization() - expected).abs() < 5.1e-6);
        // what is left vibrates in the plane of incidence
        assert!(light.s1() < 0.0);
    }
}

#[test]
fn total_reflection_reaches_the_phase_of_azzam() {
    // Azzam 2004: cos² θ = (1 − N²)/(1 + N²), tan(δ/2) = (1 − N²)/(2N) with N = 1/1.5
    let n = 1.0 / 1.5f64;
    let angle = ((1.0 - n * n) / (1.0 + n * n)).sqrt().acos();
    let delta = 2.0 * ((1.0 - n * n) / (2.0 * n)).atan();
    let mirror = interface(1.5, 1.0.into(), angle.to_degrees()).reflection_mueller();
    assert_blocks(mirror, [1.0, 0.0, delta.cos(), -delta.sin()], 1e-15);
}

#[test]
fn a_fresnel_rhomb_gives_45_degrees_a_bounce_and_right_circular_light() {
    // Mitsuba 3, polarization.rst: n = 1.49661 at 51.782°; the angle's last digit is worth 3e-6
    let bounce = interface(1.496_61, 1.0.into(), 51.782);
    let delta = (bounce.reflected.p / bounce.reflected.s).arg();
    assert!((delta.abs().to_degrees() - 45.0).abs() < 1e-3, "{delta}");
    let jones = bounce.reflection() * bounce.reflection();
    let out = jones.mueller() * StokesVector::DIAGONAL;
    assert!(near(out, StokesVector::RIGHT_CIRCULAR, 4e-5));
    assert_eq!(out.ellipse().handedness, Handedness::Right);
}

#[test]
fn crossed_polarizers_are_dark_and_turned_ones_obey_malus() {
    let first = JonesMatrix::linear_polarizer();
    for degrees in (0..=90).step_by(15) {
        let angle = f64::from(degrees).to_radians();
        let pair = (first.rotated(angle) * first).mueller();
        let passed = (pair * StokesVector::UNPOLARIZED).s0();
        assert!((passed - 0.5 * angle.cos().powi(2)).abs() < 1e-15);
    }
    let [parallel, crossed] = [0.0, FRAC_PI_2].map(|angle| first.rotated(angle) * first);
    assert!((parallel.to_matrix() - first.to_matrix()).norm() < 1e-15);
    assert!(crossed.to_matrix().norm() < 1e-15);
}

#[test]
fn quarter_and_half_wave_plates_have_the_matrices_of_the_textbook() {
    // Goldstein, Polarized Light, 3rd ed., Eqs. (6.46), (6.47); fast axis along x
    let quarter = JonesMatrix::quarter_wave_plate().mueller();
    assert_blocks(quarter, [1.0, 0.0, 0.0, 1.0], 1e-15);
    let half = JonesMatrix::half_wave_plate().mueller();
    assert_blocks(half, [1.0, 0.0, -1.0, 0.0], 1e-15);
    let out = quarter * StokesVector::DIAGONAL;
    assert!(near(out, StokesVector::LEFT_CIRCULAR, 1e-15));
    let turned = JonesMatrix::half_wave_plate().rotated(FRAC_PI_4).mueller();
    let out = turned * StokesVector::HORIZONTAL;
    assert!(near(out, StokesVector::VERTICAL, 1e-15));
    // Collett: a half-wave plate swaps the hand of circular light
    let out = half * StokesVector::RIGHT_CIRCULAR;
    assert!(near(out, StokesVector::LEFT_CIRCULAR, 1e-15));
}

#[test]
fn a_random_retarder_leaves_the_degree_of_polarization_of_its_closed_form() {
    // e^{−s²/2} for light at 45° to the axes
    let light = CrossSpectralDensity::from_stokes(StokesVector::DIAGONAL).unwrap();
    let here = Vector2::zeros();
    for (s, expected) in [(0.25, 0.9692), (0.5, 0.8825), (1.0, 0.6065), (2.0, 0.1353)] {
        let length = 1e-4;
        let lengths = CorrelationLengths {
            xx: length,
            yy: length,
            xy: length,
        };
        // phases ±s/2, and the plate whose two indices do the same
        let screen = PhaseScreen::new([0.5 * s, 0.5 * s], -1.0, lengths).unwrap();
        let red = Wavelength::from_metres(632.8e-9).unwrap();
        let roughness = s / (red.wavenumber().radians_per_metre() * 0.2);
        let plate = RoughRetarder::new(red, [1.4, 1.6], 1.5, 0.0, roughness, length).unwrap();
        let elements: [&dyn Element; 2] = [&screen, &plate];
        for element in elements {
            let behind = element.act_on(&light, &here, &here);
            let degree = behind.degree_of_polarization().unwrap();
            assert!((degree - (-0.5 * s * s).exp()).abs() < 1e-15);
            assert!((degree - expected).abs() < 5.1e-5, "{s}");
        }
    }
}
