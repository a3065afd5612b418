//! Directions and efficiencies of a grating's orders: the grating equation, energy and reciprocity.

use std::f64::consts::TAU;

use mueller16::{Blaze, CoupledOrders, Grating, GratingError, Mount, Profile};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;
use stokes::Wavelength;

const AXES: [Vector3<f64>; 2] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];

fn metres(wavelength: f64) -> Wavelength {
    Wavelength::from_metres(wavelength).expect("numbers are in range")
}

/// A direction at `theta` from the normal, turned by `azimuth`.
fn toward(theta: f64, azimuth: f64) -> Vector3<f64> {
    let (sin, cos) = theta.sin_cos();
    Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

fn degrees(theta: f64) -> Vector3<f64> {
    toward(theta.to_radians(), 0.0)
}

fn lines(pitch: f64, profile: Profile) -> Grating {
    Grating::lines(pitch, Vector2::x(), profile).expect("numbers are in range")
}

/// Lengths in wavelengths.
fn in_air(source: Vector3<f64>) -> Mount {
    Mount::reflection(source, AXES, metres(1e-6), 1.0).expect("numbers are in range")
}

#[test]
fn a_disc_sends_red_light_where_a_ruler_finds_it() {
    // helium-neon light on a disc of 1.6 µm: 23.3° and 52.3°
    let disc = lines(1.6e-6, Profile::lamellar(120e-9, 0.3).unwrap());
    let mount = Mount::reflection(Vector3::z(), AXES, metres(632.8e-9), 1.0).unwrap();
    let angle = |q| {
        let order = disc.order(&mount, [q, 0]).unwrap();
        order.geometry.to_observer().x.asin().to_degrees()
    };
    assert!((angle(1) - 23.30).abs() < 5e-3 && (angle(2) - 52.28).abs() < 5e-3);
    assert!((angle(-1) + 23.30).abs() < 5e-3);
    // and no third order: sine 3 · 632.8/1600
    let third = disc.order(&mount, [3, 0]).unwrap_err();
    let GratingError::Evanescent {
        order: [3, 0],
        sine,
    } = third
    else {
        panic!("{third}");
    };
    assert!((sine - 3.0 * 632.8 / 1600.0).abs() < 1e-15);
    let text = third.to_string();
    assert!(
        text.starts_with(
            "grating: order (3, 0) is evanescent: the sine of its angle would be 1.18"
        )
    );
}

#[test]
fn order_zero_is_the_mirror_and_snells_direction() {
    let grating = lines(2e-6, Profile::sinusoidal(1e-7).unwrap());
    let source = toward(0.7, 0.4);
    let mirror = grating
        .order(&in_air(source), [0, 0])
        .unwrap()
        .geometry
        .to_observer();
    assert!((mirror - Vector3::new(-source.x, -source.y, source.z)).norm() < 1e-15);
    let into = Mount::transmission(source, AXES, metres(1e-6), [1.0, 1.5]).unwrap();
    let order = grating.order(&into, [0, 0]).unwrap().geometry;
    let refracted = order.to_observer();
    assert!((refracted.x + source.x / 1.5).abs() < 1e-15 && refracted.z < 0.0);
    // φ_z = k₀ (n_i cos_i − n_o |cos_o|)
    let expected = TAU / 1e-6 * (source.z + 1.5 * refracted.z);
    assert!((order.normal_component() - expected).abs() < 1e-8);
}

#[test]
fn a_blaze_sends_all_light_to_the_mirror_direction_of_its_facets() {
    for (sense, sign) in [(Blaze::Rising, 1.0), (Blaze::Falling, -1.0)] {
        for m in [1, 2, 3] {
            // normal incidence, order −sign·m; 2 tan(facet) = −φ_t/φ_z
            let pitch = 10e-6;
            let source = Vector3::z();
            let sine = f64::from(m) / 10.0;
            let phi_z = TAU / 1e-6 * (1.0 + (1.0 - sine * sine).sqrt());
            let depth = TAU * f64::from(m) / phi_z;
            let facet = Vector3::new(-sign * depth / pitch, 0.0, 1.0).normalize();
            let mirrored = facet * (2.0 * facet.dot(&source)) - source;
            let grating = lines(pitch, Profile::blazed(depth, sense).unwrap());
            let orders = grating.orders(&in_air(source)).unwrap();
            let best = orders
                .iter()
                .max_by(|a, b| a.share.total_cmp(&b.share))
                .unwrap();
            assert_eq!(best.index, [-(sign as i32) * m, 0]);
            assert!((best.share - 1.0).abs() < 1e-14);
            assert!((best.geometry.to_observer() - mirrored).norm() < 1e-14);
        }
    }
}

#[test]
fn orders_hold_more_or_less_than_what_came_until_it_is_shared() {
    // in wavelengths: 1.6 µm and 5.5 µm pitch, 120, 150 and 300 nm deep, at 550 nm; a blaze of 3 by ½
    let nm = 1e-9 / 0.55;
    let sine = |depth: f64| Profile::sinusoidal(depth).unwrap();
    let blaze = Profile::blazed(0.5e-6, Blaze::Rising).unwrap();
    let cases = [
        (lines(1600.0 * nm, sine(120.0 * nm)), 0.0, 0.946),
        (lines(5500.0 * nm, sine(150.0 * nm)), 0.0, 0.993),
        (lines(1600.0 * nm, sine(300.0 * nm)), 45.0, 0.483),
        (lines(3e-6, blaze), -60.0, 1.155),
    ];
    for (grating, angle, expected) in cases {
        let mount = in_air(degrees(angle));
        let coupled = CoupledOrders::new(&grating, &mount).unwrap();
        assert!(
            (coupled.total_share() - expected).abs() < 5e-4,
            "{angle}: {}",
            coupled.total_share()
        );
        let listed: f64 = grating
            .orders(&mount)
            .unwrap()
            .iter()
            .map(|o| o.share)
            .sum();
        assert!((listed - coupled.total_share()).abs() < 1e-13);
        let capped: f64 = coupled.efficiencies().iter().sum();
        assert!(capped <= 1.0 + 1e-15 && capped <= listed + 1e-13);
        let lossless = coupled.lossless().unwrap();
        let total: f64 = lossless.efficiencies.iter().sum();
        assert!(lossless.has_converged(), "{lossless:?}");
        assert!((total - 1.0).abs() < 1e-12);
        assert!(lossless.moved > (expected - 1.0).abs() / 20.0);
    }
}

#[test]
fn orders_need_no_obliquity_at_a_pass_off() {
    // order 1 leaves at 89.5°: the obliquity of rough height surfaces would multiply it without bound
    let grating = lines(3e-6, Profile::sinusoidal(0.25e-6).unwrap());
    let sine = 1.0 / 3.0 - 89.5f64.to_radians().sin();
    let mount = in_air(toward(sine.asin(), 0.0));
    let coupled = CoupledOrders::new(&grating, &mount).unwrap();
    let total: f64 = coupled.efficiencies().iter().sum();
    assert!(total <= 1.0);
    let grazing = grating.order(&mount, [1, 0]).unwrap();
    assert!((grazing.geometry.to_observer().x - 89.5f64.to_radians().sin()).abs() < 1e-15);
    assert!(grazing.share * grazing.geometry.obliquity().unwrap() > 1.0);
    assert!(grazing.share < 0.2);
}

#[test]
fn a_pitch_below_half_a_wavelength_has_order_zero_only() {
    let fine = lines(0.49e-6, Profile::lamellar(1e-7, 0.5).unwrap());
    let validity = fine.validity(metres(1e-6), 1.0);
    assert!(validity.has_order_zero_only() && !validity.is_trusted());
    for theta in [0.0, 0.5, 1.2, 1.55, -1.5] {
        let mount = in_air(toward(theta, 0.3));
        let orders = fine.orders(&mount).unwrap();
        assert_eq!(orders.len(), 1);
        assert_eq!(orders[0].index, [0, 0]);
        let lossless = CoupledOrders::new(&fine, &mount)
            .unwrap()
            .lossless()
            .unwrap();
        assert!((lossless.efficiencies[0] - 1.0).abs() < 1e-15);
    }
    let coarse = lines(5.1e-6, Profile::lamellar(1e-7, 0.5).unwrap());
    assert!(coarse.validity(metres(1e-6), 1.0).is_trusted());
    // denser media make waves shorter, lines deeper than a quarter of the pitch shade each other
    assert!(!fine.validity(metres(1e-6), 1.5).has_order_zero_only());
    let deep = lines(5.1e-6, Profile::sinusoidal(1.3e-6).unwrap());
    assert!(!deep.validity(metres(1e-6), 1.0).is_trusted());
}

#[test]
fn too_many_orders_are_an_error_with_their_number() {
    let long = lines(1.0, Profile::sinusoidal(1e-7).unwrap());
    let found = long.orders(&in_air(Vector3::z())).unwrap_err();
    assert!(
        matches!(found, GratingError::TooMany { found, most: 100_000 } if (found / 2e6 - 1.0).abs() < 1e-3)
    );
    let coupled = CoupledOrders::new(
        &lines(1e-2, Profile::sinusoidal(1e-7).unwrap()),
        &in_air(Vector3::z()),
    );
    assert!(matches!(
        coupled,
        Err(GratingError::TooMany { most: 1000, .. })
    ));
    // grazing incidence is none
    assert!(Mount::reflection(Vector3::x(), AXES, metres(1e-6), 1.0).is_err());
    assert!(Mount::transmission(Vector3::z(), AXES, metres(1e-6), [1.0, 0.0]).is_err());
}

#[test]
fn unequal_media_cannot_share_without_loss() {
    let grating = lines(2e-6, Profile::sinusoidal(2e-7).unwrap());
    let mount = Mount::transmission(degrees(20.0), AXES, metres(1e-6), [1.0, 1.5]).unwrap();
    let coupled = CoupledOrders::new(&grating, &mount).unwrap();
    let found = coupled.lossless().unwrap_err();
    assert_eq!(
        found,
        GratingError::Unpaired {
            incident: 4,
            outgoing: 6
        }
    );
}

fn some_grating() -> impl Strategy<Value = Grating> {
    let profile = || {
        prop_oneof![
            (0.0..6e-7f64).prop_map(|d| Profile::sinusoidal(d).expect("numbers are in range")),
            (0.0..6e-7f64, 0.05..0.95f64)
                .prop_map(|(d, f)| Profile::lamellar(d, f).expect("numbers are in range")),
            (0.0..6e-7f64)
                .prop_map(|d| Profile::blazed(d, Blaze::Falling).expect("numbers are in range")),
            (0.0..6e-7f64, 0.0..1.0f64)
                .prop_map(|(d, a)| Profile::triangular(d, a).expect("numbers are in range")),
        ]
    };
    let across = (0.0..TAU).prop_map(|a: f64| Vector2::new(a.cos(), a.sin()));
    prop_oneof![
        (0.3e-6..6e-6f64, across.clone(), profile())
            .prop_map(|(p, g, h)| Grating::lines(p, g, h).expect("numbers are in range")),
        (
            0.5e-6..2e-6f64,
            0.5e-6..2e-6f64,
            across,
            profile(),
            profile()
        )
            .prop_map(|(p, r, g, a, b)| Grating::crossed([p, r], g, [a, b])
                .expect("numbers are in range")),
    ]
}

fn some_mount() -> impl Strategy<Value = Mount> {
    let theta = prop_oneof![0.0..1.5f64, Just(0.0), Just(1.55f64)];
    (theta, 0.0..TAU, any::<bool>(), any::<bool>(), 1.0..1.6f64).prop_map(
        |(theta, azimuth, below, through, n)| {
            let mut source = toward(theta, azimuth);
            if below {
                source.z = -source.z;
            }
            // tangents that are not the axes, right-handed
            let axes = [Vector3::new(0.8, 0.6, 0.0), Vector3::new(-0.6, 0.8, 0.0)];
            if through {
                Mount::transmission(source, axes, metres(1e-6), [1.0, n])
                    .expect("numbers are in range")
            } else {
                Mount::reflection(source, axes, metres(1e-6), n).expect("numbers are in range")
            }
        },
    )
}

proptest! {
    #[test]
    fn every_order_obeys_the_grating_equation(grating in some_grating(), mount in some_mount()) {
        let k0 = TAU / 1e-6;
        let orders = grating.orders(&mount).unwrap();
        for order in &orders {
            let g = &order.geometry;
            prop_assert!((g.to_observer().norm() - 1.0).abs() < 1e-14);
            prop_assert!((g.tangential() - grating.shift(order.index)).norm() < 1e-14 * k0);
            let expected = grating.amplitude(g.normal_component(), order.index).norm_sqr();
            prop_assert_eq!(order.share, expected);
        }
        // none is missing: all others to ±20 are evanescent
        let line = grating.lattice()[1].norm() == 0.0;
        let mut found = 0;
        for q1 in -20..=20 {
            for q2 in if line { 0..=0 } else { -20..=20 } {
                found += usize::from(mount.diffracted(&grating.shift([q1, q2])).is_some());
            }
        }
        prop_assert_eq!(found, orders.len());
    }

    #[test]
    fn efficiencies_are_reciprocal_and_passive(grating in some_grating(), mount in some_mount()) {
        let coupled = CoupledOrders::new(&grating, &mount).unwrap();
        let efficiencies = coupled.efficiencies();
        prop_assert!(efficiencies.iter().sum::<f64>() <= 1.0 + 1e-14);
        for (order, efficiency) in coupled.orders().iter().zip(&efficiencies) {
            prop_assert!(*efficiency <= order.share + 1e-13 && *efficiency >= 0.0);
            // a sine of 1 − 1e-6 has lost half its digits by then
            if order.geometry.cos_outgoing().abs() < 1e-3 {
                continue;
            }
            let back = CoupledOrders::new(&grating, &mount.reversed(order).unwrap()).unwrap();
            let same = back.orders().iter().position(|o| o.index == order.index).unwrap();
            let (there, home) = (efficiency, back.efficiencies()[same]);
            // cos² of 1e-6 keeps ten digits; so do directions that are rebuilt from it
            prop_assert!((there - home).abs() < 1e-9, "{there} {home}");
        }
    }

    #[test]
    fn lossless_efficiencies_are_reciprocal_and_whole(
        depth in 0.02e-6..0.3e-6f64, pitch in 0.6e-6..6e-6f64, theta in 0.0..1.2f64, azimuth in 0.0..TAU,
    ) {
        let grating = lines(pitch, Profile::sinusoidal(depth).unwrap());
        let mount = in_air(toward(theta, azimuth));
        let coupled = CoupledOrders::new(&grating, &mount).unwrap();
        let lossless = coupled.lossless().unwrap();
        if !lossless.has_converged() {
            prop_assert_eq!(lossless.sweeps, 2000);
            return Ok(());
        }
        prop_assert!((lossless.efficiencies.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for (at, order) in coupled.orders().iter().enumerate() {
            if order.geometry.cos_outgoing() < 1e-3 {
                continue;
            }
            let back = CoupledOrders::new(&grating, &mount.reversed(order).unwrap()).unwrap();
            let same = back.orders().iter().position(|o| o.index == order.index).unwrap();
            let home = back.lossless().unwrap();
            // what is left of the sums, and as much again for each sweep that would follow: they shrink by one part
            // in sweeps/27; and the digits of a grazing direction
            let bound = 1e-12 * (lossless.sweeps + home.sweeps) as f64 + 1e-9;
            prop_assert!((lossless.efficiencies[at] - home.efficiencies[same]).abs() < bound);
        }
    }
}
