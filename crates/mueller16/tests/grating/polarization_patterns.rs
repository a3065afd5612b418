//! Elements of patterned polarization against the double Fourier sum over their two-point scattering functions.

use std::f64::consts::{PI, TAU};

use csdm::{Element, JonesMatrix, Varying, liquid_crystal_modulator, polarization_grating};
use mueller16::{
    Autocorrelation, Channels, Geometry, IncidentCoherence, PolarizationPattern, Tolerance,
};
use nalgebra::{Matrix2, Matrix4, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{StokesVector, Wavelength};

const PITCH: f64 = 10e-6;

fn tolerance() -> Tolerance {
    Tolerance::relative(1e-12).expect("it is in range")
}

fn channels(pattern: &PolarizationPattern) -> Channels {
    pattern
        .channels(&Autocorrelation::constant(1.0), tolerance())
        .0
}

fn near(found: StokesVector, expected: StokesVector) -> bool {
    (found - expected).to_vector().norm() < 1e-14
}

/// The Mueller matrix of order q from `Σ(x₁, x₂)` of a pair of points, kernel `e^(−iqG(x₁ − x₂))`.
fn double_sum<F: Fn(&Vector2<f64>) -> JonesMatrix>(
    element: &Varying<F>,
    along: Vector2<f64>,
    steps: i32,
    q: i32,
) -> Matrix4<Complex64> {
    let x = |i: i32| along * (PITCH * f64::from(i) / f64::from(steps));
    let mut sum = Matrix4::zeros();
    for i in 0..steps {
        for j in 0..steps {
            let phase = -TAU * f64::from(q * (i - j)) / f64::from(steps);
            sum += element.generalized_mueller(&x(i), &x(j)).scattering() * Complex64::cis(phase);
        }
    }
    sum / Complex64::from(f64::from(steps * steps))
}

#[test]
fn every_order_is_that_of_the_two_point_functions() {
    // nothing in it is symmetric
    let element = Varying::new(|r: &Vector2<f64>| {
        let u = TAU * (0.6 * r.x + 0.8 * r.y) / PITCH;
        let z = |a: f64, b: f64| Complex64::from_polar(a, b);
        JonesMatrix::new(
            z(0.5, u) + z(0.2, -2.0 * u),
            z(0.3, 0.4 - u),
            z(0.2 + 0.1 * u.cos(), 2.0 * u),
            z(0.4, 0.3 * u.sin()),
        )
    });
    let along = Vector2::new(0.6, 0.8);
    for steps in [12, 13] {
        let pattern =
            PolarizationPattern::new(PITCH, along, steps as usize, |r| element.at(r)).unwrap();
        assert_eq!(pattern.orders().len(), steps as usize);
        for q in -5..=5 {
            let expected = double_sum(&element, along, steps, q);
            let found = pattern.order(q).mueller().to_matrix().map(Complex64::from);
            assert!((found - expected).norm() < 1e-14, "{q}: {found} {expected}");
        }
        let all: Matrix4<f64> = pattern
            .orders()
            .iter()
            .map(|(_, t)| t.mueller().to_matrix())
            .sum();
        let total = channels(&pattern).mueller().to_matrix();
        assert!((all - total).norm() < 1e-11);
    }
}

#[test]
fn a_polarization_grating_sends_right_circular_light_to_the_order_minus_one_as_left() {
    let grating = polarization_grating(PITCH, PI).unwrap();
    let pattern = PolarizationPattern::new(PITCH, Vector2::x(), 16, |r| grating.at(r)).unwrap();
    for (q, _) in pattern.orders() {
        let right = pattern.order(*q).mueller() * StokesVector::RIGHT_CIRCULAR;
        let left = pattern.order(*q).mueller() * StokesVector::LEFT_CIRCULAR;
        let dark = StokesVector::DARK;
        assert!(
            near(
                right,
                if *q == -1 {
                    StokesVector::LEFT_CIRCULAR
                } else {
                    dark
                }
            ),
            "{q}"
        );
        assert!(
            near(
                left,
                if *q == 1 {
                    StokesVector::RIGHT_CIRCULAR
                } else {
                    dark
                }
            ),
            "{q}"
        );
    }
}

#[test]
fn through_the_theorem_the_circular_states_part() {
    let grating = polarization_grating(PITCH, PI).unwrap();
    let pattern = PolarizationPattern::new(PITCH, Vector2::x(), 16, |r| grating.at(r)).unwrap();
    let (matter, chosen) = pattern.channels(&Autocorrelation::constant(1.0), tolerance());
    assert_eq!(chosen.terms, 2);
    let wavelength = Wavelength::from_metres(1e-6).unwrap();
    let toward = |sine: f64| {
        let observer = Vector3::new(sine, 0.0, (1.0 - sine * sine).sqrt());
        let geometry = Geometry::on_plane(Vector3::z(), observer, wavelength).unwrap();
        let light =
            IncidentCoherence::gaussian(&geometry, &Matrix2::from_diagonal_element(1e-3)).unwrap();
        matter.transfer(&geometry, &light).unwrap().total() * StokesVector::RIGHT_CIRCULAR
    };
    let lobe = toward(-0.1);
    // peak 1/(2π σ²) per projected solid angle
    let peak = 1.0 / (TAU * 1e-6);
    assert!((lobe.s0() / peak - 1.0).abs() < 1e-12 && (lobe.s3() / peak + 1.0).abs() < 1e-12);
    assert!(toward(0.1).s0().abs() < 1e-12 * peak && toward(0.0).s0().abs() < 1e-12 * peak);
}

#[test]
fn a_modulators_ramp_deflects_its_axis_to_the_side_of_the_delay() {
    // δ = Gx on x: e^(−iGx) travels to +x
    let ramp = liquid_crystal_modulator(|r| TAU * r.x / PITCH);
    let pattern = PolarizationPattern::new(PITCH, Vector2::x(), 8, |r| ramp.at(r)).unwrap();
    let light = StokesVector::DIAGONAL;
    assert!(near(
        pattern.order(1).mueller() * light,
        StokesVector::HORIZONTAL * 0.5
    ));
    assert!(near(
        pattern.order(0).mueller() * light,
        StokesVector::VERTICAL * 0.5
    ));
    assert!(near(
        pattern.order(-1).mueller() * light,
        StokesVector::DARK
    ));
}

#[test]
fn orders_left_out_are_counted() {
    // diag(e^(−iδ), 1) with δ = a cos Gx: harmonics (−i)^q J_q(a) of x
    let a = 1.7;
    let cell = liquid_crystal_modulator(move |r| a * (TAU * r.x / PITCH).cos());
    let pattern = PolarizationPattern::new(PITCH, Vector2::x(), 64, |r| cell.at(r)).unwrap();
    let loose = Tolerance::relative(0.05).unwrap();
    let common = Autocorrelation::constant(1.0);
    let (matter, chosen) = pattern.channels(&common, loose);
    // half of unpolarized light is along x; y goes on straight
    let total = 1.0;
    let lost = total - matter.mueller().element(0, 0);
    let largest = 0.5 * (1.0 + libm::jn(0, a).powi(2));
    assert!(lost > 1e-3 && chosen.error <= 0.05);
    assert!(
        (chosen.error * largest - lost).abs() < 1e-14,
        "{} {lost}",
        chosen.error * largest
    );
    assert!(chosen.terms < 7);
    let envelope = stokes::Envelope::gaussian(&(Matrix2::identity() * 1e-6)).unwrap();
    let (populations, _) = pattern.populations(&common, &envelope, loose);
    let whole = mueller16::Matter::new(populations).unwrap();
    assert_eq!(whole.channels(), &matter);
}

#[test]
fn patterns_that_are_none_are_refused() {
    let plate = |_: &Vector2<f64>| JonesMatrix::identity();
    assert!(PolarizationPattern::new(PITCH, Vector2::x(), 0, plate).is_err());
    assert!(PolarizationPattern::new(-1.0, Vector2::x(), 4, plate).is_err());
    assert!(PolarizationPattern::new(PITCH, Vector2::new(1.0, 0.5), 4, plate).is_err());
    let broken = |_: &Vector2<f64>| JonesMatrix::identity().scaled(f64::NAN.into());
    assert!(PolarizationPattern::new(PITCH, Vector2::x(), 4, broken).is_err());
    assert!(PolarizationPattern::of_samples(PITCH, Vector2::x(), []).is_err());
    let whole = PolarizationPattern::new(PITCH, Vector2::x(), 1, plate).unwrap();
    assert_eq!(whole.order(0), JonesMatrix::identity());
    assert_eq!(whole.order(3).to_matrix(), Matrix2::zeros());
}
