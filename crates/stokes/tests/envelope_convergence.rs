//! Claim: series of hard-edged profiles converge as slowly as they are known to, and smooth ones to the far field.
//!
//! The tables are those of a box in one dimension and of a disk, computed in double-checked numpy outside this
//! repository: L² error, and relative error at zero separation (the total energy).
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use nalgebra::{Matrix2, Vector2, Vector3};
use stokes::{
    Envelope, EnvelopeError, EnvelopeModes, Frame, GaussianPeak, LightError, ModeWidth,
    ShapeMatrix, StokesVector, Wavelength, hermite,
};

/// L² error and error at zero of the modes (n, 0), n ≤ N, which are those of a box in one dimension.
fn of_a_box(modes: &EnvelopeModes, tau: f64, order: usize) -> (f64, f64) {
    let s =
        |n: usize| modes.series().real_coefficient(n, 0) / modes.series().real_coefficient(0, 0);
    // ∫ h_0 over the box; its half-width is τ in whitened coordinates
    let j0 = 2f64.sqrt() * std::f64::consts::PI.powf(0.25) * libm::erf(tau / 2f64.sqrt());
    let (mut square, mut sum) = (0.0, 0.0);
    for n in (0..=order).step_by(2) {
        let j = j0 * s(n);
        square += j * j;
        let sign = if n % 4 == 0 { 1.0 } else { -1.0 };
        sum += sign * std::f64::consts::TAU.sqrt() * j * hermite(n, 0.0);
    }
    ((1.0 - square / (2.0 * tau)).sqrt(), sum / (2.0 * tau) - 1.0)
}

#[test]
fn a_box_converges_as_the_table_says() {
    let half_digit = 5.01e-4;
    for (tau, table) in [
        (
            3f64.sqrt(),
            [
                (0, 0.374, -0.062),
                (4, 0.235, -0.030),
                (16, 0.185, -0.010),
                (64, 0.129, 0.003),
                (256, 0.090, 0.001),
            ],
        ),
        (
            2.5,
            [
                (0, 0.555, -0.300),
                (4, 0.239, 0.057),
                (16, 0.153, 0.011),
                (64, 0.107, -0.0003),
                (256, 0.075, 0.0),
            ],
        ),
    ] {
        let envelope = Envelope::rectangle(2e-3, 5e-4).unwrap();
        let modes = envelope.modes(ModeWidth::Sigmas(tau), 256).unwrap();
        for (order, norm, at_zero) in table {
            let found = of_a_box(&modes, tau, order);
            assert!(
                (found.0 - norm).abs() < half_digit,
                "{tau} {order}: {found:?}"
            );
            assert!(
                (found.1 - at_zero).abs() < half_digit,
                "{tau} {order}: {found:?}"
            );
        }
    }
    let modes = Envelope::rectangle(1.0, 1.0)
        .unwrap()
        .modes(ModeWidth::Sigmas(4.0), 256)
        .unwrap();
    for (order, norm) in [
        (0, 0.746),
        (4, 0.422),
        (16, 0.133),
        (64, 0.087),
        (256, 0.060),
    ] {
        let found = of_a_box(&modes, 4.0, order).0;
        assert!((found - norm).abs() < half_digit, "{order}: {found}");
    }
}

#[test]
fn a_disk_converges_as_the_table_says() {
    for (order, norm, at_zero) in [
        (0, 0.50, -0.135),
        (4, 0.32, -0.030),
        (16, 0.24, -0.044),
        (64, 0.17, -0.002),
    ] {
        let envelope = Envelope::disk(3e-3).unwrap();
        for width in [ModeWidth::VarianceMatched, ModeWidth::Sigmas(2.0)] {
            let modes = envelope.modes(width, order).unwrap();
            assert!(
                (modes.relative_error() - norm).abs() < 5.01e-3,
                "{order}: {}",
                modes.relative_error()
            );
            let found = modes.sum_at_zero() / modes.area() - 1.0;
            assert!((found - at_zero).abs() < 5.01e-4, "{order}: {found}");
        }
    }
}

#[test]
fn a_box_loses_what_both_its_axes_lose() {
    // a product of two series truncated by total order loses less than the square, more than one axis alone
    let modes = |order| {
        Envelope::rectangle(1.0, 3.0)
            .unwrap()
            .modes(ModeWidth::VarianceMatched, order)
            .unwrap()
            .relative_error()
    };
    let one = |norm: f64| 1.0 - norm * norm;
    assert!((modes(0) - (1.0 - one(0.374).powi(2)).sqrt()).abs() < 1e-3);
    for (order, half, whole) in [(32, 0.185, 0.15), (128, 0.129, 0.10)] {
        let square = (1.0 - one(half).powi(2)).sqrt();
        assert!(
            modes(order) < square && modes(order) > whole,
            "{order}: {}",
            modes(order)
        );
    }
}

/// Two Gaussians apart, neither centred.
fn pair(apart: f64) -> Envelope {
    Envelope::mixture(&[
        GaussianPeak {
            peak: 1.0,
            centre: Vector2::new(0.3, -0.1),
            covariance: Matrix2::new(1.0, 0.2, 0.2, 0.6),
        },
        GaussianPeak {
            peak: 0.5,
            centre: Vector2::new(0.3 + apart, -0.1 + 0.4 * apart),
            covariance: Matrix2::new(0.7, -0.1, -0.1, 0.9),
        },
    ])
    .unwrap()
}

#[test]
fn the_series_of_a_lopsided_source_is_its_far_field() {
    let envelope = pair(0.8);
    let projection = Matrix2::new(0.9, 0.3, -0.2, 0.4);
    let modes = envelope.modes(ModeWidth::VarianceMatched, 48).unwrap();
    assert!(modes.relative_error() < 1e-13, "{}", modes.relative_error());
    let (shape, series) = modes.in_direction(&projection).unwrap();
    // another shape, and another root of the same shape
    let other = ShapeMatrix::from_root(&Matrix2::new(0.9, 0.2, -0.3, 0.5)).unwrap();
    let again = envelope.project(&projection, &other, 96).unwrap();
    for (x, y) in [(0.0, 0.0), (0.4, 0.1), (-1.0, 0.7), (1.3, 2.0), (0.2, -1.9)] {
        let w = Vector2::new(x, y);
        let expected = envelope.far_field(&projection, &w);
        // rounding of 1225 terms of a series whose sum is the area, 8
        assert!(
            (series.value(&shape, &w) - expected).norm() < 1e-13 * envelope.area(),
            "{w}"
        );
        assert!(
            (again.value(&other, &w) - expected).norm() < 1e-13 * envelope.area(),
            "{w}"
        );
    }
    // light from a lopsided source has a phase of its own
    let phase = envelope
        .far_field(&projection, &Vector2::new(1.0, 1.0))
        .arg();
    assert!(phase.abs() > 1e-3, "{phase}");
}

#[test]
fn the_relative_error_is_that_of_the_function() {
    for (apart, order) in [(2.5, 0), (2.5, 3), (0.8, 4), (0.8, 10), (0.2, 8)] {
        let envelope = pair(apart);
        let modes = envelope.modes(ModeWidth::VarianceMatched, order).unwrap();
        let (shape, series) = modes.in_direction(&Matrix2::identity()).unwrap();
        let (mut lost, mut whole) = (0.0, 0.0);
        // whitened coordinates out to where Gaussians of these widths have ended
        for i in -60..=60 {
            for j in -60..=60 {
                let w = shape.unwhiten(&Vector2::new(f64::from(i) * 0.25, f64::from(j) * 0.25));
                let exact = envelope.far_field(&Matrix2::identity(), &w);
                lost += (exact - series.value(&shape, &w)).norm_sqr();
                whole += exact.norm_sqr();
            }
        }
        let expected = (lost / whole).sqrt();
        let found = modes.relative_error();
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{apart} {order}: {found} {expected}"
        );
    }
}

#[test]
fn rescaled_light_carries_the_energy_of_its_source() {
    let envelope = Envelope::rectangle(1e-3, 4e-4).unwrap();
    let frame = Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap();
    let green = Wavelength::from_metres(550e-9).unwrap();
    let stokes = StokesVector::new(2.0, 0.5, -0.25, 1.0);
    for order in [0, 4, 31] {
        let modes = envelope.modes(ModeWidth::VarianceMatched, order).unwrap();
        let (exact, factor) = modes.rescaled().unwrap();
        assert!((factor * modes.sum_at_zero() / envelope.area() - 1.0).abs() < 4.0 * f64::EPSILON);
        let light = exact
            .light(stokes, &Matrix2::new(1.0, 0.0, 0.0, 0.3), frame, green, 2.5)
            .unwrap();
        let expected = stokes * (1.6e-6 / 6.25);
        let off = (light.stokes().stokes - expected).to_vector().norm();
        assert!(off < 64.0 * f64::EPSILON * expected.s0(), "{order}: {off}");
    }
    let near = envelope
        .modes(ModeWidth::VarianceMatched, 0)
        .unwrap()
        .light(stokes, &Matrix2::identity(), frame, green, 1e-6);
    assert!(matches!(
        near,
        Err(EnvelopeError::Light(LightError::NotFarField { .. }))
    ));
}

#[test]
fn truncated_sums_of_positive_profiles_are_positive() {
    // for a ring of light they are partial sums of (−1)^k L_k(r²), which have no zero but at r = 0
    let disk = Envelope::disk(1.0).unwrap();
    for tau in [0.01, 0.3, 1.0, 3.0, 30.0] {
        for order in 0..20 {
            let modes = disk.modes(ModeWidth::Sigmas(tau), order).unwrap();
            assert!(modes.rescaled().is_ok(), "{tau} {order}");
        }
    }
}

#[test]
fn what_cannot_be_expanded_is_refused() {
    let disk = Envelope::disk(1.0).unwrap();
    assert_eq!(
        disk.modes(ModeWidth::VarianceMatched, 257),
        Err(EnvelopeError::Order { order: 257 })
    );
    assert_eq!(
        disk.modes(ModeWidth::Sigmas(-1.0), 2),
        Err(EnvelopeError::Sigmas { value: -1.0 })
    );
    assert_eq!(
        pair(1.0).modes(ModeWidth::Sigmas(2.0), 2),
        Err(EnvelopeError::NoEdge)
    );
    let edge_on = Matrix2::new(1.0, 0.0, 0.0, 0.0);
    assert!(disk.shape(&edge_on).is_err());
    let message = disk
        .modes(ModeWidth::Sigmas(f64::NAN), 2)
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "envelope: half-width of NaN standard deviations, expected 0.01 to 100 (√3 matches a rectangle's variance)"
    );
}
