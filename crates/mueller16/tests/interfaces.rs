//! Interfaces against published numbers, textbook laws, and the slow way through Jones matrices.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use csdm::{JonesMatrix, fresnel};
use mueller16::{ConductorInterface, DielectricInterface, IndexError, element};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{DiattenuatingRetarder, Handedness, Mueller, StokesVector};

fn dielectric(n1: f64, n2: f64) -> DielectricInterface {
    DielectricInterface::new(n1, n2).expect("indices are in range")
}

fn conductor(n1: f64, eta: f64, k: f64) -> ConductorInterface {
    ConductorInterface::new(n1, eta, k).expect("indices are in range")
}

fn cos_of(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

fn assert_numbers(m: DiattenuatingRetarder, expected: [f64; 4], tolerance: f64) {
    let found = [m.mean, m.difference, m.cosine, m.sine];
    for (f, e) in found.iter().zip(expected) {
        assert!(
            (f - e).abs() < tolerance,
            "found {found:?}, expected {expected:?}"
        );
    }
}

#[test]
fn metals_reflect_as_measured_with_another_program() {
    // Mitsuba 3.9.1, seven digits; the sign of the last number is that of S3
    let silver = conductor(1.0, 0.136125, 4.010625).reflection(cos_of(45.0));
    assert_numbers(silver, [0.9673489, 0.0107234, -0.9107872, -0.325754], 1e-6);
    let gold = conductor(1.0, 0.183, 3.43).reflection(cos_of(75.0));
    assert_numbers(gold, [0.9394557, 0.0463894, 0.0098139, -0.9382584], 1e-6);
}

#[test]
fn the_phase_of_reflection_has_the_sign_that_another_program_measures() {
    let block = |m: DiattenuatingRetarder, cosine: f64, sine: f64| {
        assert!((m.cosine - cosine).abs() < 6e-6, "{} {cosine}", m.cosine);
        assert!((m.sine - sine).abs() < 6e-6, "{} {sine}", m.sine);
    };
    block(
        conductor(1.0, 0.2, 3.2).reflection(cos_of(60.0)),
        -0.61204,
        -0.69362,
    );
    block(
        conductor(1.0, 1.5, 4.0).reflection(cos_of(70.0)),
        -0.33279,
        -0.57419,
    );
    block(
        dielectric(1.51, 1.0).reflection(cos_of(54.6)),
        0.70696,
        -0.70726,
    );
}

#[test]
fn a_perfect_mirror_of_imaginary_index_is_a_retarder_at_an_angle() {
    let mirror = conductor(1.0, 0.0, 1.0).reflection(cos_of(60.0));
    assert_numbers(mirror, [1.0, 0.0, 0.125, -0.992156741649], 1e-12);
}

#[test]
fn glass_at_45_degrees_splits_light_as_tabulated() {
    let glass = dielectric(1.0, 1.5);
    let reflected = glass.reflection(cos_of(45.0));
    assert_numbers(reflected, [0.0502399, 0.0417735, -0.0279111, 0.0], 5e-8);
    let passed = glass
        .transmission(cos_of(45.0))
        .expect("no total reflection");
    assert_numbers(passed.element, [0.9497601, -0.0417735, 0.948841, 0.0], 5e-7);
}

#[test]
fn light_reflected_at_brewsters_angle_is_s_polarized() {
    let glass = dielectric(1.0, 1.5);
    let cos_b = 1.5f64.atan().cos();
    assert_numbers(
        glass.reflection(cos_b),
        [0.0739645, 0.0739645, 0.0, 0.0],
        5e-8,
    );
    let passed = glass.transmission(cos_b).expect("no total reflection");
    assert_numbers(
        passed.element,
        [0.9260355, -0.07396451, 0.92307705, 0.0],
        5e-7,
    );
    // out of the glass, Brewster's angle is the angle of refraction
    let back = glass.reversed().reflection(passed.cos_t);
    assert_numbers(back, [0.0739645, 0.0739645, 0.0, 0.0], 5e-8);
}

#[test]
fn glass_at_normal_incidence_is_a_weak_half_wave_mirror() {
    let m = dielectric(1.0, 1.5).reflection(1.0);
    let half_wave = element::linear_retarder(PI).to_mueller() * 0.04;
    assert!((m.to_mueller().to_matrix() - half_wave.to_matrix()).amax() < 1e-16);
}

#[test]
fn total_reflection_is_a_pure_retarder_of_the_greatest_phase_at_azzams_angle() {
    let n: f64 = 1.0 / 1.5;
    let cos_i = ((1.0 - n * n) / (1.0 + n * n)).sqrt();
    let delta = 2.0 * ((1.0 - n * n) / (2.0 * n)).atan();
    let m = dielectric(1.5, 1.0).reflection(cos_i);
    assert_numbers(m, [1.0, 0.0, delta.cos(), -delta.sin()], 1e-15);
}

#[test]
fn a_fresnel_rhomb_makes_right_circular_light() {
    // two total reflections of 45° each; every inner surface turns +45° light further the same way
    let cases = [(1.49661, 51.782, 1e-4), (1.51, 54.6, 1e-3)];
    for (n, angle, tolerance) in cases {
        let bounce = dielectric(n, 1.0).reflection(cos_of(angle)).to_mueller();
        let out = bounce * bounce * StokesVector::DIAGONAL;
        assert!(
            (out - StokesVector::RIGHT_CIRCULAR).to_vector().norm() < tolerance,
            "{out:?}"
        );
        assert_eq!(out.ellipse().handedness, Handedness::Right);
    }
}

#[test]
fn mirrors_swap_the_hand_of_circular_light() {
    for m in [
        dielectric(1.0, 1.5).reflection(1.0),
        conductor(1.0, 0.2, 3.0).reflection(1.0),
    ] {
        let out = m.apply(StokesVector::RIGHT_CIRCULAR);
        assert!((out.degree_of_circular_polarization() + 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_mirrored_field_turns_as_its_stokes_vector_says() {
    // +45° light off gold: follow the real field Re[r E e^{iωt}] in time, without any Stokes vector
    let n2 = Complex64::new(0.183, -3.43);
    let r = fresnel::reflection(cos_of(75.0), 1.0, n2);
    let at = |t: f64| {
        let wave = Complex64::cis(t);
        ((r.s * wave).re, (r.p * wave).re)
    };
    let area: f64 = (0..360)
        .map(|i| {
            let (x0, y0) = at(f64::from(i).to_radians());
            let (x1, y1) = at(f64::from(i + 1).to_radians());
            x0 * y1 - x1 * y0
        })
        .sum();
    let out = conductor(1.0, 0.183, 3.43)
        .reflection(cos_of(75.0))
        .apply(StokesVector::DIAGONAL);
    let clockwise = area < 0.0;
    assert!(out.s3().abs() > 0.9);
    assert_eq!(out.s3() > 0.0, clockwise);
}

#[test]
fn wrong_indices_are_refused_with_a_reason() {
    let text = |e: IndexError| e.to_string();
    assert_eq!(
        DielectricInterface::new(1.0, -1.5).map_err(text),
        Err("refractive index: found -1.5, expected a number between 1e-70 and 1e70".into())
    );
    assert!(DielectricInterface::new(f64::NAN, 1.0).is_err());
    assert!(ConductorInterface::new(1.0, 0.0, 0.0).is_err());
    assert!(ConductorInterface::new(1.0, 0.2, -3.0).is_err());
}

#[test]
fn grazing_light_is_reflected_whole() {
    for m in [
        dielectric(1.0, 1.5).reflection(0.0),
        conductor(1.0, 0.2, 3.2).reflection(0.0),
    ] {
        assert_numbers(m, [1.0, 0.0, 1.0, 0.0], 1e-15);
    }
    let through = dielectric(1.0, 1.5)
        .transmission(0.0)
        .expect("refracted along the critical cone");
    assert_numbers(through.element, [0.0; 4], 1e-300);
}

#[test]
fn at_the_critical_angle_nothing_passes() {
    // one rounding step to either side of cos θ = 0.6 in 1.25 → 1
    let interface = dielectric(1.25, 1.0);
    for cos_i in [0.6f64.next_down(), 0.6, 0.6f64.next_up()] {
        let m = interface.reflection(cos_i);
        let passed = interface
            .transmission(cos_i)
            .map_or(0.0, |t| t.element.mean);
        assert!(passed < 1e-6);
        assert!((m.mean + passed - 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_most_extreme_conductors_are_finite_and_passive() {
    let sizes = [0.0, 1e-300, 1e-70, 1e-9, 1.0, 1e9, 1e70];
    for cos_i in [0.0, 1e-300, 1e-160, 1e-8, 0.5, 1.0f64.next_down(), 1.0] {
        for n1 in [1e-70, 1.0, 1e70] {
            for eta in sizes {
                for k in sizes {
                    let Ok(metal) = ConductorInterface::new(n1, eta, k) else {
                        assert!(eta.max(k) < 1e-70);
                        continue;
                    };
                    let m = metal.reflection(cos_i);
                    assert!(m.to_mueller().is_passive(1e-14), "{cos_i} {metal:?} {m:?}");
                    assert!(m.mean >= 0.0 && m.cosine.hypot(m.sine) <= m.mean + 1e-14);
                }
            }
        }
    }
}

fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..=1.0, 1 => 0.0..1e-9, 1 => 1.0 - 1e-9..=1.0, 1 => Just(0.0), 1 => Just(1.0)]
}

fn ratio() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.3..4.0f64, 1 => 1.0 - 1e-9..1.0 + 1e-9, 1 => Just(1.0)]
}

fn loss() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..8.0f64, 1 => 0.0..1e-9, 1 => 1e8..1e60, 1 => Just(0.0)]
}

proptest! {
    #[test]
    fn interfaces_conserve_energy_and_stay_passive(cos_i in cosine(), n1 in 0.5..2.0f64, ratio in ratio()) {
        let interface = dielectric(n1, n1 * ratio);
        let reflected = interface.reflection(cos_i);
        prop_assert!(reflected.to_mueller().is_passive(1e-14));
        match interface.transmission(cos_i) {
            Some(t) => {
                prop_assert!((reflected.mean + t.element.mean - 1.0).abs() < 1e-14);
                prop_assert!((reflected.difference + t.element.difference).abs() < 1e-14);
                prop_assert!(t.element.to_mueller().is_passive(1e-14));
                prop_assert!((0.0..=1.0 + 1e-15).contains(&t.cos_t));
            }
            None => prop_assert!((reflected.mean - 1.0).abs() < 1e-14 && reflected.difference.abs() < 1e-14),
        }
    }

    #[test]
    fn conductors_are_passive_and_do_not_depolarize(
        cos_i in cosine(), n1 in 0.5..2.0f64, eta in 1e-9..5.0f64, k in loss(),
    ) {
        let m = conductor(n1, eta, k).reflection(cos_i);
        prop_assert!(m.to_mueller().is_passive(1e-14));
        // a² = b² + c² + s²: one Jones matrix
        let squares = m.difference.powi(2) + m.cosine.powi(2) + m.sine.powi(2);
        prop_assert!((m.mean * m.mean - squares).abs() < 1e-14);
    }

    #[test]
    fn the_fast_forms_agree_with_jones_matrices(cos_i in cosine(), n1 in 0.5..2.0f64, ratio in ratio(), k in 0.0..5.0f64) {
        let n2 = n1 * ratio;
        let slow = |r: fresnel::Amplitudes| JonesMatrix::diagonal(r.s, r.p).mueller().to_matrix();
        let glass = dielectric(n1, n2).reflection(cos_i).to_mueller().to_matrix();
        prop_assert!((glass - slow(fresnel::reflection_dielectric(cos_i, n1, n2))).amax() < 1e-14);
        let metal = conductor(n1, n2, k).reflection(cos_i).to_mueller().to_matrix();
        prop_assert!((metal - slow(fresnel::reflection(cos_i, n1, Complex64::new(n2, -k)))).amax() < 1e-14);
        if let (Some(m), Some(t)) =
            (dielectric(n1, n2).transmission(cos_i), fresnel::transmission_dielectric(cos_i, n1, n2))
        {
            let weighted = slow(fresnel::Amplitudes { s: t.s.into(), p: t.p.into() }) * t.power_weight;
            prop_assert!((m.element.to_mueller().to_matrix() - weighted).amax() < 1e-13);
            prop_assert!((m.cos_t - t.cos_t).abs() < 1e-15);
        }
    }

    #[test]
    fn an_interface_passes_the_same_both_ways(cos_i in 0.01..=1.0f64, n1 in 0.5..2.0f64, ratio in ratio()) {
        let forward = dielectric(n1, n1 * ratio);
        let Some(there) = forward.transmission(cos_i) else { return Ok(()) };
        // an angle of refraction near 90° loses the digits of its cosine
        prop_assume!(there.cos_t > 1e-3);
        let back = forward.reversed().transmission(there.cos_t).map(|t| t.element.to_mueller());
        let expected = there.element.to_mueller().reversed().to_matrix();
        prop_assert!(back.is_some_and(|m: Mueller| (m.to_matrix() - expected).amax() < 1e-11));
    }

    #[test]
    fn indices_matter_only_by_their_ratio(cos_i in cosine(), ratio in ratio(), k in 0.0..5.0f64) {
        let (a, b) = (conductor(1.0, ratio, k), conductor(2.0, 2.0 * ratio, 2.0 * k));
        prop_assert_eq!(a.reflection(cos_i), b.reflection(cos_i));
    }
}

#[test]
fn a_quarter_wave_plate_makes_left_circular_light_of_diagonal_light() {
    let out = element::linear_retarder(FRAC_PI_2).apply(StokesVector::DIAGONAL);
    assert!((out.s3() + 1.0).abs() < 1e-15);
    // linear (1, −1) through the same plate: S3 = +S0
    let out = element::linear_retarder(FRAC_PI_2).apply(StokesVector::ANTIDIAGONAL);
    assert!((out.s3() - 1.0).abs() < 1e-15);
}

#[test]
fn plates_turned_by_45_degrees_act_as_goldstein_prints_them() {
    // fast axis at 45°: Goldstein, Polarized Light, 3rd ed., section 6.3, quarter wave; S1 ↔ S3
    let plate = element::linear_retarder(FRAC_PI_2)
        .to_mueller()
        .rotated(FRAC_PI_4);
    let expected = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
    ];
    assert!((plate.to_matrix() - Mueller::from_rows(expected).to_matrix()).amax() < 1e-15);
    let from_behind = element::linear_retarder(FRAC_PI_2)
        .to_mueller()
        .rotated(-FRAC_PI_4);
    assert!((plate.reversed().to_matrix() - from_behind.to_matrix()).amax() < 1e-15);
}

#[test]
fn elements_agree_with_their_jones_matrices() {
    let pairs = [
        (
            element::linear_polarizer().to_mueller(),
            JonesMatrix::linear_polarizer(),
        ),
        (
            element::linear_retarder(0.7).to_mueller(),
            JonesMatrix::linear_retarder(0.7),
        ),
        (
            element::circular_polarizer(false),
            JonesMatrix::right_circular_polarizer(),
        ),
        (
            element::circular_polarizer(true),
            JonesMatrix::left_circular_polarizer(),
        ),
    ];
    for (matrix, jones) in pairs {
        assert!((matrix.to_matrix() - jones.mueller().to_matrix()).amax() < 1e-15);
        assert!(matrix.is_passive(1e-15));
    }
}
