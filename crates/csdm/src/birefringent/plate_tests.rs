//! Plates and liquid-crystal cells against closed forms and an independent 40-digit calculation.

use super::*;
use crate::{JonesMatrix, stokes_vector};
use nalgebra::{Matrix2, Matrix3, Matrix4, Vector2, Vector3};
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use stokes::Wavelength;

const I: Complex64 = Complex64::I;
const LAMBDA: f64 = 500e-9;

fn light() -> Wavelength {
    Wavelength::from_metres(LAMBDA).unwrap()
}

fn layer(crystal: &Crystal, wavelengths: f64) -> CrystalLayer {
    CrystalLayer {
        crystal: crystal.clone(),
        thickness: wavelengths * LAMBDA,
    }
}

fn stack(before: f64, layers: Vec<CrystalLayer>, behind: f64) -> CrystalStack {
    CrystalStack::new(before, layers, behind.into()).unwrap()
}

fn at(cos_i: f64, azimuth: f64) -> Incidence {
    Incidence::new(cos_i, azimuth).unwrap()
}

fn distance(a: &JonesMatrix, b: &JonesMatrix) -> f64 {
    (a.to_matrix() - b.to_matrix()).norm()
}

fn scaled(jones: JonesMatrix, factor: Complex64) -> JonesMatrix {
    JonesMatrix::diagonal(factor, factor) * jones
}

fn isotropic(n: f64) -> Crystal {
    Crystal::isotropic(n.into()).unwrap()
}

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
        assert!(distance(&t, &expected) < 4e-15 * depth);
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

/// A layer of director along x at the front, turned by `twist` at the back, in `slices` slices.
fn twisted(no: f64, ne: f64, wavelengths: f64, twist: f64, slices: u32) -> Vec<CrystalLayer> {
    let director = Crystal::uniaxial(no.into(), ne.into(), Vector3::x()).unwrap();
    let slices_f = f64::from(slices);
    (0..slices)
        .map(|i| {
            let angle = twist * (f64::from(i) + 0.5) / slices_f;
            layer(&director.turned(angle), wavelengths / slices_f)
        })
        .collect()
}

#[test]
fn a_twisted_nematic_cell_is_dark_at_the_minima_of_gooch_and_tarry() {
    // u = 2 d Δn/λ: between parallel polarizers T = sin²(π/2 √(1 + u²))/(1 + u²)
    let (no, ne) = (1.5, 1.51);
    for (u, expected) in [(3f64.sqrt(), 0.0), (15f64.sqrt(), 0.0), (1.0, 0.31656)] {
        let cell = twisted(no, ne, u / (2.0 * (ne - no)), FRAC_PI_2, 300);
        let t = stack(1.505, cell, 1.505).single_pass(&at(1.0, 0.0), light());
        let parallel = t.front.transmission.to_matrix()[(0, 0)].norm_sqr();
        let closed = (FRAC_PI_2 * (1.0 + u * u).sqrt()).sin().powi(2) / (1.0 + u * u);
        assert!((closed - expected).abs() < 1e-5);
        // slices: (π/2/300)²; faces: (Δn/2n)² of power
        assert!((parallel - closed).abs() < 5e-5, "{u}: {parallel} {closed}");
    }
}

#[test]
fn a_twisted_cell_has_the_jones_matrix_of_its_closed_form() {
    let (no, ne, twist, depth) = (1.5, 1.501, 1.1f64, 700.0);
    let cell = twisted(no, ne, depth, twist, 400);
    let t = stack(1.5005, cell, 1.5005).single_pass(&at(1.0, 0.0), light());
    let half = PI * depth * (ne - no);
    let x = half.hypot(twist);
    let (c, s) = (Complex64::from(x.cos()), x.sin() / x);
    // in the frame that turns with the director, slow along x
    let inner = JonesMatrix::new(
        c - I * half * s,
        (twist * s).into(),
        (-twist * s).into(),
        c + I * half * s,
    );
    let mean = (-I * TAU * depth * 0.5 * (no + ne)).exp();
    let expected = scaled(JonesMatrix::rotator(twist) * inner, mean);
    // slices: error of the order (twist/400)² · half
    assert!(distance(&t.front.transmission, &expected) < 3e-5);
}

#[test]
fn a_slowly_twisted_cell_leads_the_polarization_along() {
    // Mauguin: twist ≪ π d Δn/λ; what is left behind is (twist/half)²
    let cell = twisted(1.5, 1.6, 200.0, FRAC_PI_2, 400);
    let t = stack(1.55, cell, 1.55).single_pass(&at(1.0, 0.0), light());
    let out = t
        .front
        .transmission
        .apply(Vector2::new(Complex64::ONE, Complex64::ZERO));
    let stokes = stokes_vector(out);
    let half: f64 = PI * 200.0 * 0.1;
    let left_behind = 0.5 * (1.0 + stokes.s1() / stokes.s0());
    assert!(left_behind < (FRAC_PI_2 / half).powi(2), "{left_behind}");
    assert!(stokes.s0() > 0.99);
}

#[test]
fn a_cholesteric_mirror_reflects_the_circular_light_of_its_own_helix() {
    // director (cos qz, sin qz): a right-handed screw, as is Re (1, i) e^{−ikz}, S3 > 0; R = tanh²(πΔn L/λ)
    let (no, ne) = (1.49, 1.51);
    let pitch = 1.0 / 1.5;
    let turns = 20.0;
    let cell = twisted(no, ne, turns * pitch, TAU * turns, 20 * 60);
    let r = stack(1.5, cell, 1.5)
        .coherent(&at(1.0, 0.0), light())
        .front
        .reflection_mueller();
    let right = r * stokes::StokesVector::RIGHT_CIRCULAR;
    let left = r * stokes::StokesVector::LEFT_CIRCULAR;
    let closed = (PI * 0.02 * turns * pitch).tanh().powi(2);
    // slices: (2π/60)²/6 of the coupling; indices: Δn/n of the band's centre
    assert!(
        (right.s0() - closed).abs() < 5e-3,
        "{} {closed}",
        right.s0()
    );
    assert!(left.s0() < 1e-3);
    // an ordinary mirror would turn S3 round
    assert!(right.s3() / right.s0() > 0.99);
}

#[test]
fn thick_incoherent_plates_average_the_fringes() {
    // isotropic, oblique: the mean over a period of thickness, exact for the trapezoidal rule with R^64 ≪ 1
    use crate::film::{Layer, Stack};
    let (n, cos_i) = (Complex64::from(2.0), 0.4f64);
    let w = crate::fresnel::normal_index_of(1.0.into(), n, cos_i).re;
    let plate = stack(1.0, vec![layer(&isotropic(2.0), 50.0)], 1.4);
    let sum = plate.incoherent(&at(cos_i, 0.0), light(), 0.0).unwrap();
    let mut mean = [Matrix4::zeros(), Matrix4::zeros()];
    for i in 0..64 {
        let thickness = (50.0 + f64::from(i) / 64.0 * 0.5 / w) * LAMBDA;
        let film = Stack::new(
            1.0,
            vec![Layer {
                index: n,
                thickness,
            }],
            1.4.into(),
        )
        .unwrap();
        let film = film.amplitudes(cos_i, light());
        mean[0] += film.reflection_mueller().to_matrix() / 64.0;
        mean[1] += film.transmission_mueller().unwrap().to_matrix() / 64.0;
    }
    assert!((sum.front.reflection.to_matrix() - mean[0]).amax() < 1e-12);
    assert!((sum.front.transmission.to_matrix() - mean[1]).amax() < 1e-12);
}

#[test]
fn a_thick_absorbing_window_obeys_the_series_of_powers() {
    // R = R₁ + T₁ T₁' R₂ A²/(1 − R₁ R₂ A²), with |t t'|² of the amplitudes, which differ from 1 − R
    let n = Complex64::new(1.8, -0.01);
    let window = layer(&Crystal::isotropic(n).unwrap(), 5.0);
    let found = stack(1.0, vec![window], 1.5)
        .incoherent(&at(1.0, 0.0), light(), 0.0)
        .unwrap();
    let r1 = ((n - 1.0) / (n + 1.0)).norm_sqr();
    let r2 = ((n - 1.5) / (n + 1.5)).norm_sqr();
    let through = (4.0 * n / (n + 1.0).powi(2)).norm_sqr();
    let a = (-4.0 * PI * 5.0 * 0.01f64).exp();
    let expected = r1 + through * r2 * a * a / (1.0 - r1 * r2 * a * a);
    assert!((found.front.reflection.to_matrix()[(0, 0)] - expected).abs() < 1e-14);
    let t = (4.0 * n / ((n + 1.0) * (n + 1.5))).norm_sqr() * 1.5 * a / (1.0 - r1 * r2 * a * a);
    assert!((found.front.transmission.to_matrix()[(0, 0)] - t).abs() < 1e-14);
}

#[test]
fn incoherent_retarders_sum_their_bounces() {
    // normal incidence: bounce by bounce, along the two axes
    let (no, ne, depth) = (1.66, 1.49, 31.3);
    let crystal = Crystal::uniaxial(no.into(), ne.into(), Vector3::x()).unwrap();
    let plate = stack(1.0, vec![layer(&crystal, depth)], 1.0);
    let found = plate.incoherent(&at(1.0, 0.0), light(), 0.0).unwrap();
    let mut expected = Matrix4::zeros();
    let along = |n: f64, bounce: i32| {
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        (1.0 - r) * r.powi(bounce) * (-I * TAU * depth * n * f64::from(2 * bounce + 1)).exp()
    };
    for bounce in 0..20 {
        let jones = JonesMatrix::diagonal(along(ne, bounce), along(no, bounce));
        expected += jones.mueller().to_matrix();
    }
    assert!((found.front.transmission.to_matrix() - expected).amax() < 1e-12);
}

#[test]
fn coatings_of_a_thick_plate_stay_coherent() {
    // a quarter wave of √n on both faces: nothing is reflected
    let n = 2.25;
    let coat = layer(&isotropic(1.5), 0.25 / 1.5);
    let window = layer(&isotropic(n), 1000.0);
    let plate = stack(1.0, vec![coat.clone(), window, coat], 1.0);
    let green = plate.incoherent(&at(1.0, 0.0), light(), LAMBDA).unwrap();
    assert!(green.front.reflection.to_matrix().amax() < 1e-15);
    assert!((green.front.transmission.to_matrix() - Matrix4::identity()).amax() < 1e-11);
    // without the films' interference: three times two faces of R = 4 %
    let dull = plate.incoherent(&at(1.0, 0.0), light(), 0.0).unwrap();
    assert!(dull.front.reflection.to_matrix()[(0, 0)] > 0.1);
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
fn where_circular_dichroism_of_the_eye_fails_there_is_one_wave_for_two() {
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
