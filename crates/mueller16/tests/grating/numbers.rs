//! Numbers that make no grating are refused, and what is not refused answers.

use csdm::JonesMatrix;
use mueller16::{
    Blaze, CoupledOrders, Grating, Mount, PolarizationPattern, Profile, Relief, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::Wavelength;

/// Anything that is an f64.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1.0, 1.5, 5e-324, 1e-300, -1e-9, 1e-7,
            1e30, -1e300, f64::MAX,
        ]),
        1 => any::<f64>(),
        2 => -2.0..2.0f64,
    ]
}

proptest! {
    // a profile of 1e5 rad has tens of thousands of orders to list
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn no_number_makes_a_profile_panic(n in prop::array::uniform4(wild()), q in any::<i32>(), phi_z in wild()) {
        let profiles = [
            Profile::sinusoidal(n[0]),
            Profile::lamellar(n[0], n[1]),
            Profile::blazed(n[0], Blaze::Falling),
            Profile::triangular(n[0], n[1]),
            Profile::piecewise_linear(vec![[0.0, n[0]], [n[1], n[2]], [1.0, n[3]]]),
            Profile::sampled(n.to_vec()),
        ];
        for profile in profiles.into_iter().flatten() {
            let t = profile.amplitude(phi_z, q);
            let phase = phi_z.abs() * profile.depth();
            // one rounding of the phase for each part of a profile
            let bound = 1.0 + 8.0 * f64::EPSILON * (1.0 + phase);
            prop_assert_eq!(t.norm() <= bound, phase <= 1e5, "{:?} {} {}", profile, t, phase);
            let pitch = if n[1] > 0.0 && n[1] < 1.0 { n[1] } else { 1e-6 };
            let Ok(grating) = Grating::lines(pitch, Vector2::x(), profile.clone()) else { continue };
            let _ = grating.clone().through_aperture(&Matrix2::new(n[0], n[1], n[2], n[3]));
            let within = grating.clone().within_reach(n[2]).unwrap_or(grating);
            if let Ok((r, _)) = within.autocorrelation(phi_z, Tolerance::relative(0.1).unwrap()) {
                prop_assert!(r.at_zero() >= 0.0 && r.at_zero() <= 1.0 + 1e-9);
            }
        }
    }
}

proptest! {
    #[test]
    fn no_number_makes_a_mount_panic(n in prop::array::uniform6(wild())) {
        let light = Wavelength::from_metres(500e-9).unwrap();
        let grating = Grating::lines(2e-6, Vector2::x(), Profile::sinusoidal(1e-7).unwrap()).unwrap();
        let source = Vector3::new(n[0], n[1], n[2]);
        let axes = [Vector3::x(), Vector3::y()];
        for mount in [
            Mount::reflection(source, axes, light, n[3]),
            Mount::transmission(source, axes, light, [n[3], n[4]]),
            Mount::reflection(Vector3::z(), [source, Vector3::y()], light, 1.0),
        ].into_iter().flatten() {
            let _ = mount.diffracted(&Vector2::new(n[4], n[5]));
            if let Ok(coupled) = CoupledOrders::new(&grating, &mount) {
                prop_assert!(coupled.efficiencies().iter().sum::<f64>() <= 1.0 + 1e-12);
            }
        }
    }

    #[test]
    fn no_number_makes_a_pattern_panic(n in prop::array::uniform6(wild())) {
        let jones = |a: f64, b: f64| JonesMatrix::new(Complex64::new(a, b), n[2].into(), n[3].into(), Complex64::ONE);
        for pitch in [n[4], 1e-6] {
            let pattern = PolarizationPattern::of_samples(pitch, Vector2::new(1.0, n[5]), [jones(n[0], n[1]), jones(n[1], n[0])]);
            if let Ok(pattern) = pattern {
                let finite = pattern.orders().iter().all(|(_, t)| t.to_matrix().iter().all(|z| z.is_finite()));
                prop_assert!(finite);
            }
        }
    }
}

#[test]
fn gratings_that_are_too_deep_say_how_deep() {
    let deep = Grating::lines(1e-6, Vector2::x(), Profile::sinusoidal(0.25).unwrap()).unwrap();
    let found = deep.autocorrelation(1e6, Tolerance::ROUNDING).unwrap_err();
    assert_eq!(
        found.to_string(),
        "autocorrelation: the phase depth of a grating is 250000.0 rad at φ_z = 1000000.0 rad/m and a depth of 0.25 m, \
         expected 0 to 1e5 rad"
    );
    assert!(deep.amplitude(1e6, [0, 0]).is_nan());
}
