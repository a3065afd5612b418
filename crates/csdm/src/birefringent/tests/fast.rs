//! Closed forms and short cuts against the general solution.

use super::super::half_space::{Directions, HalfSpace};
use super::super::scattering::Scattering;
use super::*;
use nalgebra::Vector3;

fn crystals() -> [Crystal; 5] {
    let n = |values: [f64; 3]| values.map(Complex64::from);
    let axes = (Vector3::new(0.3, -0.5, 0.8), Vector3::new(0.1, 0.9, 0.4));
    [
        Crystal::biaxial(n([1.66, 1.49, 1.66]), axes.0, axes.1).unwrap(),
        Crystal::uniaxial(1.5.into(), 2.4.into(), axes.0).unwrap(),
        Crystal::uniaxial(1.66.into(), 1.49.into(), Vector3::z()).unwrap(),
        Crystal::uniaxial(1.66.into(), 1.49.into(), Vector3::x()).unwrap(),
        isotropic(1.7),
    ]
}

/// Largest difference of the waves and of how they go on, over their size.
fn off(a: &Directions, b: &Directions) -> f64 {
    let pairs = [
        (a.waves.b_forward, b.waves.b_forward),
        (a.waves.a_backward, b.waves.a_backward),
        (a.forward, b.forward),
        (a.backward, b.backward),
    ];
    pairs.iter().fold(0.0, |m, (a, b)| {
        f64::max(m, (a - b).norm() / (1.0 + b.norm()))
    })
}

#[test]
fn uniaxial_waves_in_closed_form_are_those_of_the_general_solution() {
    for crystal in crystals() {
        for xi in [0.0, 1e-12, 1e-8, 1e-4, 0.3, 0.8, 1.0, 1.3] {
            for azimuth in [0.0, 0.7, 2.0, -2.5] {
                let closed = Directions::of_uniaxial(&crystal, xi, azimuth).unwrap();
                let general = Directions::of_any(&crystal, xi, azimuth);
                let off = off(&closed, &general);
                assert!(off < 1e-13, "{crystal:?} {xi} {azimuth}: {off:e}");
            }
        }
    }
}

fn biaxial() -> Crystal {
    let axes = (Vector3::new(0.3, -0.5, 0.8), Vector3::new(0.1, 0.9, 0.4));
    Crystal::biaxial([1.5, 1.6, 1.9].map(Complex64::from), axes.0, axes.1).unwrap()
}

#[test]
fn waves_of_clear_crystals_in_real_numbers_are_those_of_the_general_solution() {
    for crystal in crystals().iter().chain([&biaxial()]) {
        for xi in [0.0, 1e-12, 1e-8, 1e-4, 0.3, 0.8, 1.0, 1.3] {
            for azimuth in [0.0, 0.7, 2.0, -2.5] {
                let clear = Directions::of_clear(crystal, xi, azimuth).unwrap();
                let general = Directions::of_any(crystal, xi, azimuth);
                let off = off(&clear, &general);
                assert!(off < 1e-13, "{crystal:?} {xi} {azimuth}: {off:e}");
            }
        }
    }
    // along the optic axes of a biaxial crystal both waves are one
    let n = [1.5, 1.6, 1.9];
    let [a, b, c] = n.map(|n: f64| n.powi(-2));
    let axis = ((a - b) / (a - c)).sqrt();
    let crystal = Crystal::biaxial(n.map(Complex64::from), Vector3::y(), Vector3::x()).unwrap();
    for angle in [0.0, 1e-14, 1e-9, 1e-5] {
        let xi = 1.6 * (axis.asin() + angle).sin();
        for azimuth in [0.0, std::f64::consts::PI] {
            let clear = Directions::of_clear(&crystal, xi, azimuth).unwrap();
            let off = off(&clear, &Directions::of_any(&crystal, xi, azimuth));
            assert!(off < 1e-13, "{angle}: {off:e}");
        }
    }
}

#[test]
fn crystals_that_are_not_clear_or_reflect_totally_are_left_to_the_general_solution() {
    let axis = Vector3::x();
    let absorbing = Crystal::uniaxial(1.6.into(), Complex64::new(1.5, -0.01), axis).unwrap();
    let active = biaxial().with_gyration(&(nalgebra::Matrix3::identity() * 1e-3));
    for crystal in [&absorbing, &active.unwrap()] {
        assert!(Directions::of_clear(crystal, 0.3, 0.1).is_none());
    }
    for xi in [1.6, 1.75, 1.89, 1.95, 3.0] {
        for azimuth in [0.0, 0.7, 2.0] {
            if let Some(clear) = Directions::of_clear(&biaxial(), xi, azimuth) {
                // where it finds waves, they are those of the general solution
                let off = off(&clear, &Directions::of_any(&biaxial(), xi, azimuth));
                assert!(off < 1e-12, "{xi} {azimuth}: {off:e}");
            }
        }
    }
    assert!(Directions::of_clear(&biaxial(), 1.95, 0.0).is_none());
}

#[test]
fn waves_near_the_optic_axis_lose_no_digits() {
    // light along the axis inside, but for a small angle
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let crystal = Crystal::uniaxial(1.66.into(), 1.49.into(), axis).unwrap();
    for angle in [0.0, 1e-15, 1e-11, 1e-8, 1e-6, 1e-3] {
        let xi = 1.66 * (0.6f64.asin() + angle).sin();
        let closed = Directions::of_uniaxial(&crystal, xi, 0.0).unwrap();
        let off = off(&closed, &Directions::of_any(&crystal, xi, 0.0));
        assert!(off < 1e-13, "{angle}: {off:e}");
    }
}

#[test]
fn crystals_that_need_more_are_left_to_the_general_solution() {
    let n = 1.6.into();
    let axis = Vector3::x();
    let absorbing = Crystal::uniaxial(n, Complex64::new(1.5, -0.01), axis).unwrap();
    let active = Crystal::isotropic(n).unwrap();
    let active = active.with_gyration(&(nalgebra::Matrix3::identity() * 1e-3));
    let biaxial = Crystal::biaxial([1.5.into(), n, 1.7.into()], axis, Vector3::y()).unwrap();
    for crystal in [&absorbing, &active.unwrap(), &biaxial] {
        assert!(Directions::of_uniaxial(crystal, 0.3, 0.1).is_none());
    }
    // total reflection, and a little before
    let clear = Crystal::uniaxial(n, 1.5.into(), axis).unwrap();
    for xi in [1.599_99, 1.6, 1.7] {
        assert!(Directions::of_uniaxial(&clear, xi, 0.0).is_none());
    }
}

#[test]
fn faces_in_small_matrices_are_those_of_the_whole_system() {
    let media: Vec<HalfSpace> = crystals()
        .iter()
        .map(|crystal| Directions::of_any(crystal, 0.8, 0.4).waves)
        .chain([1.0, 1.3, 2.0].map(|n: f64| {
            let w = Complex64::from((n * n - 0.64).sqrt());
            HalfSpace::isotropic(n.into(), w)
        }))
        .chain([HalfSpace::isotropic(
            Complex64::new(0.2, -3.0),
            Complex64::new(0.19, -3.11),
        )])
        .collect();
    for before in &media {
        for behind in &media {
            let small = Scattering::face(before, behind);
            let whole = Scattering::transparent().between(before, behind);
            for (a, b) in [
                (small.reflection, whole.reflection),
                (small.transmission, whole.transmission),
                (small.back_reflection, whole.back_reflection),
                (small.back_transmission, whole.back_transmission),
            ] {
                assert!((a - b).norm() < 1e-13 * (1.0 + b.norm()), "{a} {b}");
            }
        }
    }
}

#[test]
fn coherent_plates_face_by_face_are_those_of_doubled_slices() {
    // a gyration of nothing keeps the crystal from its closed form
    let nothing = nalgebra::Matrix3::zeros();
    for crystal in crystals() {
        let general = crystal.clone().with_gyration(&nothing).unwrap();
        for (cos_i, azimuth) in [(1.0, 0.0), (0.8, 0.7), (0.3, -2.0), (0.01, 1.0)] {
            let plates = [&crystal, &general].map(|crystal| {
                let layers = vec![
                    layer(crystal, 3.3),
                    layer(&isotropic(1.4), 0.2),
                    layer(crystal, 0.7),
                ];
                stack(1.0, layers, 1.2).coherent(&at(cos_i, azimuth), light())
            });
            let [a, b] = plates.map(|plate| [plate.front, plate.back.unwrap()]);
            for (a, b) in a.iter().zip(&b) {
                let off = distance(&a.reflection, &b.reflection)
                    .max(distance(&a.transmission, &b.transmission));
                assert!(off < 2e-13, "{crystal:?} {cos_i}: {off:e}");
            }
        }
    }
}

/// Time of one solution; `cargo test --release -p csdm --lib fast::cost -- --ignored --nocapture`
#[test]
#[ignore = "a measurement"]
fn cost() {
    let axes = (Vector3::new(0.3, -0.5, 0.8), Vector3::new(0.1, 0.9, 0.4));
    let biaxial = Crystal::biaxial([1.5, 1.6, 1.7].map(Complex64::from), axes.0, axes.1).unwrap();
    let absorbing = Crystal::uniaxial(1.5.into(), Complex64::new(1.6, -0.001), axes.0).unwrap();
    for (name, crystal) in [
        ("uniaxial", &crystals()[0]),
        ("biaxial", &biaxial),
        ("absorbing", &absorbing),
    ] {
        let plate = stack(1.0, vec![layer(crystal, 100.0)], 1.0);
        let time = |what: &dyn Fn(&Incidence) -> f64| {
            // the least of many: other programs may run
            let mut least = f64::INFINITY;
            for batch in 0..200 {
                let (count, mut sum) = (50, 0.0);
                let start = std::time::Instant::now();
                for step in 0..count {
                    let cos_i = 0.3 + 0.7 * f64::from(step) / f64::from(count);
                    sum += what(&at(cos_i, 0.1 * f64::from(batch)));
                }
                assert!(sum.is_finite());
                least = least.min(start.elapsed().as_secs_f64() / f64::from(count) * 1e9);
            }
            least
        };
        let single = time(&|i| {
            plate
                .single_pass(i, light())
                .front
                .transmission_mueller()
                .unwrap()
                .to_matrix()[(0, 0)]
        });
        let incoherent = time(&|i| {
            plate
                .incoherent(i, light(), 0.0)
                .unwrap()
                .front
                .transmission
                .to_matrix()[(0, 0)]
        });
        let coherent = time(&|i| {
            plate
                .coherent(i, light())
                .front
                .transmission_mueller()
                .unwrap()
                .to_matrix()[(0, 0)]
        });
        let any = time(&|i| {
            Directions::of_any(crystal, i.tangential_index(1.0), i.azimuth())
                .forward
                .norm()
        });
        let waves = time(&|i| {
            Directions::new(crystal, i.tangential_index(1.0), i.azimuth())
                .forward
                .norm()
        });
        eprintln!(
            "{name}: single {single:.0} ns, incoherent {incoherent:.0} ns, coherent {coherent:.0} ns; waves {waves:.0} ns, in general {any:.0} ns"
        );
    }
}
