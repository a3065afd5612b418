//! Single plates against closed forms and an independent 40-digit calculation.

use super::*;
use nalgebra::{Matrix2, Matrix3, Matrix4, Vector3};
use std::f64::consts::{PI, TAU};

/// Columns: s and p from the front, s and p from the back; rows: reflected s, p, then transmitted s, p (from the front;
/// from the back the other way round).
fn all(plate: &PlateJones) -> Matrix4<Complex64> {
    let back = plate.back.unwrap();
    let mut m = Matrix4::zeros();
    for (row, column, jones) in [
        (0, 0, plate.front.reflection),
        (2, 0, plate.front.transmission),
        (0, 2, back.transmission),
        (2, 2, back.reflection),
    ] {
        m.fixed_view_mut::<2, 2>(row, column)
            .copy_from(&jones.to_matrix());
    }
    m
}

fn biaxial_absorbing_active() -> Crystal {
    let indices = [(1.5, -0.01), (1.6, -0.03), (1.75, -0.002)];
    Crystal::biaxial(
        indices.map(|(re, im)| Complex64::new(re, im)),
        Vector3::new(0.3, -0.5, 0.8),
        Vector3::new(0.1, 0.9, 0.4),
    )
    .unwrap()
    .with_gyration(&Matrix3::new(
        0.01, 0.003, 0.0, //
        0.003, -0.02, 0.004, //
        0.0, 0.004, 0.015,
    ))
    .unwrap()
}

#[test]
fn an_active_absorbing_biaxial_film_on_calcite_has_the_amplitudes_of_a_40_digit_calculation() {
    // matrix exponential of the fields in plate axes, by mpmath
    let first = Vector3::new(1.0, 0.0, 0.0);
    let calcite = Crystal::biaxial(
        [1.658, 1.658, 1.486].map(Complex64::from),
        first,
        Vector3::new(0.0, 1.0, 0.5),
    );
    let layers = vec![
        layer(&biaxial_absorbing_active(), 0.8),
        layer(&calcite.unwrap(), 0.37),
    ];
    let plate = stack(1.2, layers, 1.33);
    for (degrees, expected) in [(27.0f64, &AT_27_DEGREES), (70.0, &AT_70_DEGREES)] {
        let found = all(&plate.coherent(&at(degrees.to_radians().cos(), 0.7), light()));
        for row in 0..4 {
            for column in 0..4 {
                let (re, im) = expected[row][column];
                let error = (found[(row, column)] - Complex64::new(re, im)).norm();
                assert!(error < 2e-14, "{degrees}, ({row}, {column}): {error}");
            }
        }
    }
}

type Table = [[(f64, f64); 4]; 4];

const AT_27_DEGREES: Table = [
    [
        (-0.22574310121763245, 0.080767961938079013),
        (-0.004096745186726519, -0.049462403292039022),
        (0.51078553598913367, 0.72319368884843646),
        (0.3137244879556721, -0.18948772716600289),
    ],
    [
        (0.003452471722138412, 0.038328622005464869),
        (0.17562811834239855, -0.049386850303154708),
        (0.37705212361734451, -0.081570929862943867),
        (0.43419006026155811, 0.77321852714069732),
    ],
    [
        (0.45291657206643949, 0.65042562028547699),
        (-0.29625928607871156, -0.0040695438940497416),
        (-0.13092775486994583, 0.16625640347492004),
        (0.046916809526725309, 0.081776562127831198),
    ],
    [
        (-0.28520668758530507, 0.048916049782090497),
        (-0.19423762045645885, 0.79063169444294305),
        (-0.013354263025256652, -0.081684921366213106),
        (0.15322230726810191, -0.005917861678216308),
    ],
];

const AT_70_DEGREES: Table = [
    [
        (-0.3715266495441, 0.089613754253653636),
        (-0.0036813926107322759, -0.0020793884587202855),
        (-0.92614631719205486, -0.36426407221811066),
        (-0.25043385962740439, 0.38167839586448483),
    ],
    [
        (0.067613350727979409, -0.038923230977808804),
        (-0.22866000232524006, 0.021080711036759877),
        (-0.40359759123298178, 0.33546379230037924),
        (-0.87252913791177764, -0.50113912528618436),
    ],
    [
        (-0.54794260229518897, -0.24241391070912697),
        (0.18481687063110498, -0.018340242041302794),
        (0.0072355158165439704, 0.2464362054059293),
        (0.091927890203422885, -0.14100747505264617),
    ],
    [
        (0.1542832044769431, -0.096579407076634689),
        (0.33031571450053979, -0.57196029228267515),
        (-0.055561705085538885, 0.069828280266137289),
        (-0.15225717329708341, 0.1055012627761128),
    ],
];

/// A uniaxial plate at normal incidence: each axis is a film of its own.
#[test]
fn a_plate_at_normal_incidence_is_two_films_along_its_axes() {
    use crate::film::{Layer, Stack};
    let (ordinary, extraordinary) = (Complex64::new(1.66, 0.0), Complex64::new(1.49, -0.02));
    for (angle, depth) in [(0.0f64, 0.3), (0.5, 3.3), (2.0, 20.25)] {
        let axis = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let crystal = Crystal::uniaxial(ordinary, extraordinary, axis).unwrap();
        let plate = stack(1.0, vec![layer(&crystal, depth)], 1.5).coherent(&at(1.0, 0.0), light());
        let film = |index| {
            let film = Layer {
                index,
                thickness: depth * LAMBDA,
            };
            Stack::new(1.0, vec![film], 1.5.into())
                .unwrap()
                .amplitudes(1.0, light())
        };
        let (x, y) = (film(extraordinary), film(ordinary));
        let t = JonesMatrix::diagonal(x.transmitted.s, y.transmitted.s).rotated(angle);
        let tolerance = 1e-14 * (1.0 + 10.0 * depth);
        assert!(distance(&plate.front.transmission, &t) < tolerance);
        // the reflected frame has its y axis reversed
        let r = JonesMatrix::diagonal(x.reflected.s, y.reflected.s).rotated(angle);
        let r = JonesMatrix::diagonal(Complex64::ONE, -Complex64::ONE) * r;
        assert!(distance(&plate.front.reflection, &r) < tolerance);
    }
}

#[test]
fn one_pass_through_a_plate_is_a_retarder_between_two_faces() {
    let (no, ne) = (1.544, 1.553);
    for (angle, depth) in [(0.0f64, 27.8), (0.7, 500.0)] {
        let axis = Vector3::new(-angle.sin(), angle.cos(), 0.0);
        let crystal = Crystal::uniaxial(no.into(), ne.into(), axis).unwrap();
        let plate = stack(1.0, vec![layer(&crystal, depth)], 1.0);
        let t = plate.single_pass(&at(1.0, 0.0), light()).front.transmission;
        // positive crystal: fast across the axis
        let delay = JonesMatrix::linear_retarder(TAU * depth * (ne - no));
        let faces = |n: f64| Complex64::from(4.0 * n / (1.0 + n).powi(2));
        let losses = JonesMatrix::diagonal(faces(no), faces(ne));
        let expected = scaled(
            (delay * losses).rotated(angle),
            (-I * TAU * depth * no).exp(),
        );
        // the error that the page of this module states
        let error = 4.0 * f64::EPSILON * TAU * depth * 2.0 * (1.0 + ne * ne);
        assert!(distance(&t, &expected) < error);
    }
}

#[test]
fn refracted_waves_obey_the_two_sheets_of_a_uniaxial_crystal() {
    // κ·κ = n_o² with the ray along κ, and κ·εκ = n_o² n_e² with the ray along εκ
    let (no, ne) = (1.6584, 1.4864);
    for (cos_i, azimuth, axis) in [
        (1.0, 0.3, Vector3::new(0.3, 0.4, 0.9)),
        (0.7, -1.1, Vector3::new(0.3, 0.4, 0.9)),
        (0.05, 2.0, Vector3::new(-0.8, 0.1, 0.5)),
        (0.5, 0.0, Vector3::new(1.0, 0.0, 0.0)),
    ] {
        let crystal = Crystal::uniaxial(no.into(), ne.into(), axis).unwrap();
        let epsilon = crystal.permittivity().map(|c| c.re);
        let [slow, fast] = crystal.refracted(1.0, &at(cos_i, azimuth)).unwrap();
        let (o, e) = (slow, fast);
        assert!((o.index - no).abs() < 1e-14);
        assert!((o.ray - o.wave_normal).norm() < 1e-13);
        let kappa = e.wave_normal * e.index;
        assert!((kappa.dot(&(epsilon * kappa)) - (no * ne).powi(2)).abs() < 1e-13);
        assert!((e.ray - (epsilon * kappa).normalize()).norm() < 1e-13);
        // Snell: the tangential part is that of the incident wave, along z × s
        let tangential = (1.0 - cos_i * cos_i).sqrt();
        for wave in [o, e] {
            let along = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0) * tangential;
            assert!((wave.wave_normal * wave.index - along).xy().norm() < 1e-14);
        }
    }
}

#[test]
fn light_along_the_optic_axis_of_a_biaxial_crystal_finds_one_index() {
    // tan² V = (1/n₁² − 1/n₂²)/(1/n₂² − 1/n₃²), V from the axis of n₃ toward that of n₁
    let n: [f64; 3] = [1.5, 1.6, 1.8];
    let [a, b, c] = n.map(|n| 1.0 / (n * n));
    let v = ((a - b) / (b - c)).sqrt().atan();
    let first = Vector3::new(v.cos(), 0.0, -v.sin());
    let crystal = Crystal::biaxial(n.map(Complex64::from), first, Vector3::y()).unwrap();
    let waves = crystal.refracted(1.0, &at(1.0, 0.0)).unwrap();
    for wave in waves {
        assert!((wave.index - 1.6).abs() < 1e-7, "{}", wave.index);
    }
    let plate = stack(1.6, vec![layer(&crystal, 10.0)], 1.6).coherent(&at(1.0, 0.0), light());
    let expected = scaled(JonesMatrix::identity(), (-I * TAU * 16.0).exp());
    assert!(distance(&plate.front.transmission, &expected) < 1e-12);
}

#[test]
fn natural_activity_turns_the_field_counter_clockwise_from_both_sides() {
    // an isotropic active medium has the impedance of its mean index: no reflection when immersed
    let gyration = Matrix3::identity() * 2e-3;
    let crystal = isotropic(1.5).with_gyration(&gyration).unwrap();
    for depth in [0.3, 40.0] {
        let plate = stack(1.5, vec![layer(&crystal, depth)], 1.5);
        for azimuth in [0.0, 1.0] {
            let through = plate.coherent(&at(1.0, azimuth), light());
            let turned = scaled(
                JonesMatrix::rotator(TAU * depth * 2e-3),
                (-I * TAU * depth * 1.5).exp(),
            );
            let tolerance = 4e-15 * (1.0 + 10.0 * depth);
            let back = through.back.unwrap();
            assert!(distance(&through.front.transmission, &turned) < tolerance);
            assert!(distance(&back.transmission, &turned) < tolerance);
            assert!(through.front.reflection.to_matrix().norm() < tolerance);
            let direct = plate.single_pass(&at(1.0, azimuth), light());
            assert!(distance(&direct.front.transmission, &turned) < tolerance);
        }
    }
}

#[test]
fn the_gyration_along_the_optic_axis_sets_the_rotatory_power() {
    // quartz at 589 nm: 21.7°/mm along the axis, γ = ρ λ₀/2π; transverse values do not matter there
    let lambda = 589.3e-9;
    let power = 21.7f64.to_radians() / 1e-3;
    let along = power * lambda / TAU;
    let gyration = Matrix3::from_diagonal(&Vector3::new(-0.45 * along, -0.45 * along, along));
    let quartz = Crystal::uniaxial(1.54424.into(), 1.55335.into(), Vector3::z())
        .unwrap()
        .with_gyration(&gyration)
        .unwrap();
    let plate = vec![CrystalLayer {
        crystal: quartz,
        thickness: 1e-3,
    }];
    let plate = stack(1.54424, plate, 1.54424);
    let sodium = Wavelength::from_metres(lambda).unwrap();
    let m = plate
        .single_pass(&at(1.0, 0.0), sodium)
        .front
        .transmission_mueller()
        .unwrap();
    let expected = JonesMatrix::rotator(21.7f64.to_radians()).mueller();
    // faces of the circular waves: (γ/n)² of power
    assert!((m.to_matrix() - expected.to_matrix()).amax() < 1e-8);
}

#[test]
fn activity_and_birefringence_make_an_elliptical_retarder() {
    // phase difference k₀ d 2√((Δn/2)² + γ²); cross terms of order Δn γ are left out
    let (n, half, gamma, depth) = (1.5, 2e-4, 3e-4, 400.0);
    let crystal = Crystal::uniaxial((n - half).into(), (n + half).into(), Vector3::x())
        .unwrap()
        .with_gyration(&(Matrix3::identity() * gamma))
        .unwrap();
    let plate = stack(n, vec![layer(&crystal, depth)], n);
    let t = plate.single_pass(&at(1.0, 0.0), light()).front.transmission;
    let x = TAU * depth * half.hypot(gamma);
    let (c, s) = (Complex64::from(x.cos()), x.sin() / half.hypot(gamma));
    let expected = JonesMatrix::new(
        c - I * half * s,
        (-gamma * s).into(),
        (gamma * s).into(),
        c + I * half * s,
    );
    let expected = scaled(expected, (-I * TAU * depth * n).exp());
    assert!(distance(&t, &expected) < 1e-6 * TAU * depth * half);
}

#[test]
fn a_thick_dichroic_plate_is_a_polarizer() {
    // one axis absorbs over 1e4 and more wavelengths, the other passes
    for depth in [1e4, 1e7] {
        let axis = Vector3::new(1.0, 1.0, 0.0);
        let film = Crystal::uniaxial(1.5.into(), Complex64::new(1.5, -0.5), axis).unwrap();
        let plate = stack(1.5, vec![layer(&film, depth)], 1.5);
        let cross = JonesMatrix::linear_polarizer().rotated(-PI / 4.0).mueller();
        for found in [
            plate.single_pass(&at(1.0, 0.0), light()).front,
            plate.coherent(&at(1.0, 0.0), light()).front,
        ] {
            let m = found.transmission_mueller().unwrap();
            // 4 f64::EPSILON k₀ d |M| with |M| = 7
            assert!((m.to_matrix() - cross.to_matrix()).amax() < 4e-14 * depth);
            assert!(found.reflection.to_matrix().iter().all(|c| c.norm() < 1.0));
        }
    }
}

#[test]
fn a_turned_plate_has_a_turned_matrix_at_normal_incidence() {
    let crystal = biaxial_absorbing_active();
    let jones = |crystal: &Crystal| {
        let plate = stack(1.3, vec![layer(crystal, 2.7)], 1.0);
        plate.coherent(&at(1.0, 0.0), light()).front
    };
    let (front, turned) = (jones(&crystal), jones(&crystal.turned(0.6)));
    let expected = front.transmission.rotated(0.6);
    assert!(distance(&turned.transmission, &expected) < 1e-13);
    // the reflected frame turns the other way round
    let r = JonesMatrix::rotator(-0.6) * front.reflection * JonesMatrix::rotator(-0.6);
    assert!(distance(&turned.reflection, &r) < 1e-13);
}

#[test]
fn at_an_exceptional_point_there_is_one_wave_for_two() {
    // linear dichroism δ against gyration γ: √(γ² − δ²) = 0 leaves one eigenvector; T = 1 − i k₀ d N with N² = 0
    let (delta, depth) = (1e-3, 50.0);
    for off in [0.0, 1e-15, -1e-12, 1e-8, 1e-4] {
        let gamma = delta * (1.0 + off);
        let indices = [Complex64::new(1.5, 0.0), Complex64::new(1.5, -2.0 * delta)];
        let crystal = Crystal::uniaxial(indices[0], indices[1], Vector3::x())
            .unwrap()
            .with_gyration(&(Matrix3::identity() * gamma))
            .unwrap();
        let plate = stack(1.5, vec![layer(&crystal, depth)], 1.5);
        let k0d = TAU * depth;
        let x = Complex64::from(delta * delta - gamma * gamma).sqrt() * k0d;
        let sinhc = if x == Complex64::ZERO {
            Complex64::ONE
        } else {
            x.sinh() / x
        };
        let generator = Matrix2::new((-delta).into(), (-gamma).into(), gamma.into(), delta.into());
        let t = (Matrix2::identity() * x.cosh() + generator.map(|c: Complex64| c * k0d) * sinhc)
            * ((-I * k0d * Complex64::new(1.5, -delta)).exp());
        let t = JonesMatrix::new(t[(0, 0)], t[(0, 1)], t[(1, 0)], t[(1, 1)]);
        let direct = plate.single_pass(&at(1.0, 0.0), light()).front.transmission;
        // left out: terms of second order in δ, γ over n, times k₀ d, and reflections of δ/2n
        let model = 4.0 * delta * delta / 1.5 * k0d;
        assert!(
            distance(&direct, &t) < model,
            "{off}: {}",
            distance(&direct, &t)
        );
        let coherent = plate.coherent(&at(1.0, 0.0), light()).front.transmission;
        assert!(distance(&direct, &coherent) < 2e-6);
    }
}

#[test]
fn plates_multiply_where_interfaces_do_not_reflect_and_only_there() {
    // birefringence 1e-4 in a medium of that index: amplitudes of reflection of 3e-5
    let (no, ne, depth) = (1.5, 1.5001, 2500.0);
    let along = |angle: f64| {
        let axis = Vector3::new(angle.cos(), angle.sin(), 0.0);
        layer(
            &Crystal::uniaxial(no.into(), ne.into(), axis).unwrap(),
            depth,
        )
    };
    let through = |layers: Vec<CrystalLayer>, outside: f64| {
        let plate = stack(outside, layers, outside).coherent(&at(1.0, 0.0), light());
        plate.front.transmission
    };
    let error = |outside: f64| {
        let [first, second] = [0.3, 1.1].map(|angle| through(vec![along(angle)], outside));
        let both = through(vec![along(0.3), along(1.1)], outside);
        distance(&both, &(second * first))
    };
    assert!(error(no) < 1e-8, "{}", error(no));
    // in air r = 0.2 and 4 % of the power interferes with the rest
    assert!(error(1.0) > 0.03, "{}", error(1.0));
}
