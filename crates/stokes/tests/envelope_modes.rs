//! Claim: far-field modes of every profile, in any shape and from any direction, are the integrals they stand for.
//!
//! `data/envelope_modes.csv` holds them by plain quadrature in extended precision (`validation/envelope_modes.py`).
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use nalgebra::{Matrix2, Vector2};
use stokes::{Envelope, GaussianPeak, ModeWidth, ShapeMatrix};

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|n| n.parse().unwrap())
        .collect()
}

fn matrix(text: &str) -> Matrix2<f64> {
    Matrix2::from_row_slice(&numbers(text))
}

fn envelope(kind: &str, p: &[f64]) -> Envelope {
    match kind {
        "rectangle" => Envelope::rectangle(p[0], p[1]),
        "disk" => Envelope::disk(p[0]),
        "mixture" => {
            let peak = |q: &[f64]| GaussianPeak {
                peak: q[0],
                centre: Vector2::new(q[1], q[2]),
                covariance: Matrix2::from_row_slice(&q[3..]),
            };
            Envelope::mixture(&p.chunks_exact(7).map(peak).collect::<Vec<_>>())
        }
        "sampled" => Envelope::sampled(
            p[5..].to_vec(),
            p[0] as usize,
            [p[1], p[2]],
            Vector2::new(p[3], p[4]),
        ),
        _ => panic!("kind {kind}"),
    }
    .unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// The largest difference over the largest number.
fn error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let difference: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    largest(&difference) / largest(expected)
}

#[test]
fn modes_are_their_integrals_in_every_shape() {
    let table = include_str!("data/envelope_modes.csv");
    let mut worst = 0.0;
    for line in table.lines().filter(|line| !line.starts_with('#')) {
        let [kind, profile, projection, given, order, root, expected] =
            line.split(';').collect::<Vec<_>>().try_into().unwrap();
        let envelope = envelope(kind, &numbers(profile));
        let (projection, order) = (matrix(projection), order.parse().unwrap());
        let expected = numbers(expected);
        // each coefficient is reached by `order` steps that round a few times, and turned once more
        let tolerance = 16.0 * f64::EPSILON * (order + 1) as f64;

        let shape = if given == "native" {
            let modes = envelope.modes(ModeWidth::VarianceMatched, order).unwrap();
            let (shape, series) = modes.in_direction(&projection).unwrap();
            let off = error(series.real_coefficients(), &expected);
            // μ is right for the rounded W, whose determinant loses the digits of its condition number
            let rounded = 2.0 * f64::EPSILON * shape.condition_number().sqrt();
            assert!(off < tolerance + rounded, "{kind} in direction: {off}");
            assert!(error(shape.root().as_slice(), matrix(root).as_slice()) < 8.0 * f64::EPSILON);
            assert_eq!(shape, envelope.shape(&projection).unwrap());
            shape
        } else {
            ShapeMatrix::from_root(&matrix(given)).unwrap()
        };
        let exact = given != "native";
        let tolerance = if exact {
            tolerance
        } else {
            tolerance + 2.0 * f64::EPSILON * shape.condition_number().sqrt()
        };
        let series = envelope.project(&projection, &shape, order).unwrap();
        let off = error(series.real_coefficients(), &expected);
        println!("{kind} {given} {order} {off:e}");
        worst = f64::max(worst, off);
        assert!(off < tolerance, "{kind} {given}: {off}");
    }
    println!("worst {worst:e}");
    assert!(worst > 0.0, "nothing was compared");
}

/// `∫_disk h_a(y₁) h_b(y₂) d²x`, `y = T (x − origin)`, in polar coordinates: Simpson's rule along radii, the trapezoidal
/// rule around.
fn disk_moment(radius: f64, t: &Matrix2<f64>, origin: &Vector2<f64>, [a, b]: [usize; 2]) -> f64 {
    let (radii, angles) = (400, 200);
    let step = radius / f64::from(radii);
    let mut sum = 0.0;
    for i in 0..=radii {
        let r = step * f64::from(i);
        let weight = match i {
            0 => 1.0,
            _ if i == radii => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        for j in 0..angles {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / f64::from(angles)).sin_cos();
            let y = t * (Vector2::new(r * cos, r * sin) - origin);
            sum += weight * r * stokes::hermite(a, y.x) * stokes::hermite(b, y.y);
        }
    }
    sum * step / 3.0 * std::f64::consts::TAU / f64::from(angles)
}

#[test]
fn a_disk_about_another_phase_centre_has_the_modes_of_its_integrals() {
    let projection = Matrix2::new(1.0, 0.2, -0.1, 0.6);
    let shape = ShapeMatrix::from_root(&Matrix2::new(0.7, 0.2, -0.3, 0.5)).unwrap();
    let (radius, order) = (1.3, 6);
    let disk = Envelope::disk(radius).unwrap();
    let t = (projection * shape.root().try_inverse().unwrap()).transpose();
    let scale = std::f64::consts::TAU / shape.root_determinant().sqrt();
    for origin in [[0.0, 0.0], [0.4, -0.3], [-1.1, 0.9], [3.0, 1.0]] {
        let origin = Vector2::from(origin);
        let series = disk
            .project_about(&origin, &projection, &shape, order)
            .unwrap();
        for (a, b) in stokes::modes(order) {
            let sign = if (a + b) % 2 == 0 { 1.0 } else { -1.0 };
            let expected = sign * scale * disk_moment(radius, &t, &origin, [a, b]);
            // Simpson's rule with 400 steps over a few waves: (1/400)⁴ · 10⁴ of numbers of size 10
            let found = series.real_coefficient(a, b);
            assert!(
                (found - expected).abs() < 1e-6,
                "{origin} {a} {b}: {found} {expected}"
            );
        }
    }
    // and the far field has the phase of the place
    let gaussian = Envelope::gaussian(&Matrix2::new(1.0, 0.3, 0.3, 0.8)).unwrap();
    let origin = Vector2::new(0.3, -0.2);
    let series = gaussian
        .project_about(&origin, &projection, &shape, 40)
        .unwrap();
    let w = Vector2::new(0.4, -0.7);
    let phase = num_complex::Complex64::cis((projection * w).dot(&origin));
    let expected = gaussian.far_field(&projection, &w) * phase;
    // widths differ by a factor below 3: 0.8^20 of 40 orders, of squares
    assert!((series.value(&shape, &w) - expected).norm() < 1e-3 * gaussian.area());
    assert!((series.value(&shape, &w) - expected.conj()).norm() > 1e-2 * gaussian.area());
    assert!(
        disk.project_about(&Vector2::new(f64::NAN, 0.0), &projection, &shape, 2)
            .is_err()
    );
}
