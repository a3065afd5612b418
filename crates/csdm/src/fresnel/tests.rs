//! Interfaces against tables, the textbook's formulas with angles, and the laws of energy.

use super::*;
use proptest::prelude::*;

/// The textbook formulas with angles, by num-complex: slow, and obviously what the book says.
fn by_the_book(cos_i: f64, n1: f64, n2: Complex64) -> Amplitudes {
    let sin_t = n1 * (1.0 - cos_i) * (1.0 + cos_i) * n1 / (n2 * n2);
    let mut cos_t = (1.0 - sin_t).sqrt();
    if (n2 * cos_t).im > 0.0 || ((n2 * cos_t).im == 0.0 && (n2 * cos_t).re < 0.0) {
        cos_t = -cos_t;
    }
    Amplitudes {
        s: (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t),
        p: (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t),
    }
}

fn degrees(angle: f64) -> f64 {
    angle.to_radians().cos()
}

fn close(a: Amplitudes, b: Amplitudes, tolerance: f64) -> bool {
    (a.s - b.s).norm() < tolerance && (a.p - b.p).norm() < tolerance
}

#[test]
fn glass_reflects_the_tabulated_amplitudes() {
    let r = reflection_dielectric(degrees(45.0), 1.0, 1.5);
    assert!((r.s.re + 0.3033370452904235).abs() < 1e-15);
    assert!((r.p.re - 0.09201336304552442).abs() < 1e-15);
    let r = reflection_dielectric(degrees(10.0), 1.5, 1.0);
    assert!((r.s.re - 0.20949431963852014).abs() < 1e-15);
    assert!((r.p.re + 0.19046797197779405).abs() < 1e-15);
    let t = transmission_dielectric(degrees(10.0), 1.5, 1.0).expect("below the critical angle");
    assert!((t.cos_t.acos().to_degrees() - 15.098086605159006).abs() < 1e-12);
}

#[test]
fn p_light_is_not_reflected_at_brewsters_angle() {
    assert!((1.5f64.atan().to_degrees() - 56.3099).abs() < 1e-4);
    let r = reflection_dielectric(1.5f64.atan().cos(), 1.0, 1.5);
    assert!((r.s.re + 0.3846150939598947).abs() < 1e-6);
    assert!((r.s.re + 5.0 / 13.0).abs() < 1e-15 && r.p.norm() < 1e-16);
}

#[test]
fn reflection_at_normal_incidence_is_the_same_mirror_for_s_and_p() {
    for n2 in [
        Complex64::new(1.5, 0.0),
        Complex64::new(0.2, -3.0),
        Complex64::new(1.0, -1e-12),
    ] {
        let r = reflection(1.0, 1.0, n2);
        assert!((r.s + r.p).norm() < 1e-15);
        assert!((r.s - (1.0 - n2) / (1.0 + n2)).norm() < 1e-15);
    }
}

#[test]
fn total_reflection_reaches_its_greatest_phase_difference() {
    // Azzam 2004: cos θ = √((1 − N²)/(1 + N²)), tan(δ/2) = (1 − N²)/(2N)
    let n: f64 = 1.0 / 1.5;
    let cos_i = ((1.0 - n * n) / (1.0 + n * n)).sqrt();
    let delta = 2.0 * ((1.0 - n * n) / (2.0 * n)).atan();
    let r = reflection_dielectric(cos_i, 1.5, 1.0);
    // x y* of the Mueller block, cos δ and −sin δ
    let product = r.s * r.p.conj();
    assert!((product - Complex64::new(delta.cos(), -delta.sin())).norm() < 1e-15);
}

#[test]
fn at_the_critical_angle_light_starts_to_be_totally_reflected() {
    // 3-4-5: n₁ = 1.25, n₂ = 1, sin θ = 0.8, cos θ = 0.6, exact up to the rounding of 0.6
    let r = reflection_dielectric(0.6, 1.25, 1.0);
    assert!((r.s - 1.0).norm() < 1e-7 && (r.p - 1.0).norm() < 1e-7);
    assert!(r.s.norm() <= 1.0 + 1e-15);
    let exact = reflection_dielectric(0.0, 1.0, 1.0);
    assert_eq!(exact.s.re, -1.0);
}

#[test]
fn extreme_indices_and_angles_stay_finite_and_passive() {
    let sizes = [0.0, 1e-300, 1e-9, 0.5, 1.0, 1.5, 1e8, 1e160, f64::MAX];
    for cos_i in [0.0, 1e-300, 1e-160, 1e-8, 0.5, 1.0] {
        for eta in sizes {
            for k in sizes {
                let r = reflection(cos_i, 1.0, Complex64::new(eta, -k));
                for amplitude in [r.s, r.p] {
                    assert!(
                        amplitude.norm_sqr() <= 1.0 + 4e-15,
                        "{cos_i} {eta} {k} {amplitude}"
                    );
                }
            }
        }
        for n in [1e-8, 1.0, 1.0 + 1e-15, 1e8] {
            let r = reflection_dielectric(cos_i, 1.0, n);
            assert!(r.s.norm_sqr() <= 1.0 + 4e-15 && r.p.norm_sqr() <= 1.0 + 4e-15);
        }
    }
}

#[test]
fn equal_media_do_not_reflect() {
    for cos_i in [1e-6, 0.3, 1.0] {
        let r = reflection_dielectric(cos_i, 1.33, 1.33);
        assert!(r.s.norm() < 1e-15 && r.p.norm() < 1e-15);
        let r = reflection(cos_i, 1.33, Complex64::new(1.33, 0.0));
        assert!(r.s.norm() < 1e-15 && r.p.norm() < 1e-15);
    }
}

#[test]
fn a_transmitted_wave_decays_in_the_direction_of_travel() {
    for (eta, k) in [(0.2, 3.2), (1.5, 4.0), (2.0, 1e-9), (0.0, 1.0)] {
        let w = normal_index(0.5, 1.0, Complex64::new(eta, -k));
        assert!(w.im <= 0.0 && w.re >= 0.0);
        let n2 = Complex64::new(eta, -k);
        assert!((w - n2 * refract(0.5, 1.0, n2)).norm() < 1e-14);
    }
}

fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..=1.0, 1 => 0.0..1e-9, 1 => 1.0 - 1e-9..=1.0, 1 => Just(1.0)]
}

fn ratio() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.3..4.0f64, 1 => 1.0 - 1e-9..1.0 + 1e-9, 1 => Just(1.0)]
}

proptest! {
    #[test]
    fn metals_follow_the_textbook(cos_i in cosine(), n1 in 1.0..2.0f64, eta in 0.01..5.0f64, k in 0.01..8.0f64) {
        let n2 = Complex64::new(eta, -k);
        prop_assert!(close(reflection(cos_i, n1, n2), by_the_book(cos_i, n1, n2), 1e-13));
    }

    #[test]
    fn a_transparent_metal_is_a_dielectric(cos_i in cosine(), n1 in 1.0..2.0f64, ratio in ratio()) {
        let n2 = n1 * ratio;
        let real = reflection_dielectric(cos_i, n1, n2);
        prop_assert!(close(reflection(cos_i, n1, Complex64::new(n2, 0.0)), real, 1e-14));
        // a loss k changes w² by 2 n₂ k: too little to see unless w vanishes
        if normal_index_squared(cos_i, n1, n2).abs() > 1e-9 {
            prop_assert!(close(reflection(cos_i, n1, Complex64::new(n2, -1e-25)), real, 1e-14));
        }
    }

    #[test]
    fn what_is_not_reflected_is_transmitted(cos_i in cosine(), n1 in 0.5..2.0f64, ratio in ratio()) {
        let n2 = n1 * ratio;
        let r = reflection_dielectric(cos_i, n1, n2);
        match transmission_dielectric(cos_i, n1, n2) {
            Some(t) => {
                prop_assert!((r.s.norm_sqr() + t.power_weight * t.s * t.s - 1.0).abs() < 1e-14);
                prop_assert!((r.p.norm_sqr() + t.power_weight * t.p * t.p - 1.0).abs() < 1e-14);
            }
            None => {
                prop_assert!((r.s.norm_sqr() - 1.0).abs() < 1e-14);
                prop_assert!((r.p.norm_sqr() - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_way_back_reflects_with_the_opposite_sign(cos_i in 0.01..=1.0f64, n1 in 0.5..2.0f64, ratio in ratio()) {
        // Stokes' relations: r' = −r, t t' = 1 − r²
        let n2 = n1 * ratio;
        let Some(t) = transmission_dielectric(cos_i, n1, n2) else { return Ok(()) };
        prop_assume!(t.cos_t > 1e-3);
        let (r, back) = (reflection_dielectric(cos_i, n1, n2), reflection_dielectric(t.cos_t, n2, n1));
        // w² = n₁² c² of the way back is a difference of terms n₂²: dr_p ≤ 2 n₂ dw/(n₁² cos θ₂), dw ≈ 4ε n₂²/(n₁ c)
        let tolerance = 16.0 * f64::EPSILON * ratio.max(1.0).powi(3) / (cos_i * t.cos_t);
        prop_assert!((r.s + back.s).norm() < tolerance && (r.p + back.p).norm() < tolerance);
    }
}
