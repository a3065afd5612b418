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
