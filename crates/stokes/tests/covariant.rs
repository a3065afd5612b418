//! The covariant family and its dual against explicit sums in 400 digits (validation/covariant.py).

use nalgebra::{Matrix2, Vector2};
use stokes::{
    Family, covariant_mode, covariant_mode_at_zero, covariant_mode_fourier, symmetric_power,
};

struct Row {
    family: Family,
    n: usize,
    m: usize,
    theta: Matrix2<f64>,
    x: Vector2<f64>,
    value: f64,
    zeta: Vector2<f64>,
    transform: f64,
    zero: f64,
}

fn rows() -> Vec<Row> {
    let table = include_str!("data/covariant.csv").lines().skip(2);
    let rows: Vec<Row> = table
        .map(|line| {
            let mut fields = line.split(',');
            let family = match fields.next() {
                Some("dual") => Family::Dual,
                _ => Family::Covariant,
            };
            let number: Vec<f64> = fields
                .map(|field| field.parse().expect("a number"))
                .collect();
            Row {
                family,
                n: number[0] as usize,
                m: number[1] as usize,
                theta: Matrix2::new(number[2], number[3], number[3], number[4]),
                x: Vector2::new(number[5], number[6]),
                value: number[7],
                zeta: Vector2::new(number[8], number[9]),
                transform: number[10],
                zero: number[11],
            }
        })
        .collect();
    assert_eq!(rows.len(), 72);
    rows
}

#[test]
fn modes_are_right_to_the_last_digits_for_any_shape() {
    // the double-word sum is right beyond f64; what remains are the roundings of the norm (3), of the exponential
    // (1 and the 1/2 of its argument's rest) and of the products (4), each of half an ε
    let tolerance = 5.0 * f64::EPSILON;
    for row in rows() {
        let found = covariant_mode(row.family, row.n, row.m, &row.theta, &row.x).unwrap();
        let error = (found - row.value).abs();
        assert!(
            error <= tolerance * row.value.abs(),
            "{:?} {} {} {}: {found}, expected {}",
            row.family,
            row.n,
            row.m,
            row.theta,
            row.value
        );
    }
}

#[test]
fn transforms_are_right_to_the_last_digits_for_any_shape() {
    let tolerance = 6.0 * f64::EPSILON;
    for row in rows() {
        let found =
            covariant_mode_fourier(row.family, row.n, row.m, &row.theta, &row.zeta).unwrap();
        let turned = found * num_complex::Complex64::i().powu((row.n + row.m) as u32);
        assert_eq!(turned.im, 0.0);
        assert!(
            (turned.re - row.transform).abs() <= tolerance * row.transform.abs(),
            "{:?} {} {} {}: {found}, expected {}",
            row.family,
            row.n,
            row.m,
            row.theta,
            row.transform
        );
    }
}

#[test]
fn values_at_zero_are_the_sum_over_compositions() {
    for row in rows() {
        let found = covariant_mode_at_zero(row.family, row.n, row.m, &row.theta).unwrap();
        let recurrence =
            covariant_mode(row.family, row.n, row.m, &row.theta, &Vector2::zeros()).unwrap();
        // each of n + m factors q carries a few roundings; no two terms cancel
        let tolerance = 8.0 * (row.n + row.m + 1) as f64 * f64::EPSILON * row.zero.abs();
        assert!(
            (found - row.zero).abs() <= tolerance,
            "{found} {}",
            row.zero
        );
        assert!((recurrence - row.zero).abs() <= 5.0 * f64::EPSILON * row.zero.abs());
    }
}

#[test]
fn both_families_are_symmetric_powers_of_whitened_modes() {
    // Ψ = |Θ|^(−1/4) Sym(Wᵀ) h(Wx), Ψ̃ = |Θ|^(−1/4) Sym(W⁻¹) h(Wx), for a root that is not symmetric
    let root: Matrix2<f64> = Matrix2::new(1.3, -0.4, 0.9, 0.7);
    let inverse = root.try_inverse().unwrap();
    let theta = inverse * inverse.transpose();
    let theta = Matrix2::new(theta.m11, theta.m12, theta.m12, theta.m22);
    let x = Vector2::new(0.8, -0.3);
    let y = root * x;
    let norm = root.determinant().abs().sqrt();
    for order in 0..=12 {
        let h = nalgebra::DVector::from_fn(order + 1, |b, _| {
            stokes::hermite(order - b, y.x) * stokes::hermite(b, y.y)
        });
        for (family, map) in [
            (Family::Covariant, root.transpose()),
            (Family::Dual, inverse),
        ] {
            let power = symmetric_power(&map, order);
            let expected = norm * &power * &h;
            // the roundings of Θ, of the power and of the sum, relative to |map|^order
            let tolerance =
                64.0 * (order + 1) as f64 * f64::EPSILON * map.norm().powi(order as i32);
            for m in 0..=order {
                let found = covariant_mode(family, order - m, m, &theta, &x).unwrap();
                assert!(
                    (found - expected[m]).abs() <= tolerance,
                    "{family:?} {order} {m}"
                );
            }
        }
    }
}

#[test]
fn a_footprint_in_metres_reaches_values_beyond_f64_and_says_so() {
    // Θ⁻¹ = (0.1 nm)² makes Ψ̃_nm a 1e10 to the power n + m
    let theta = Matrix2::from_diagonal_element(1e20);
    let at = |family, n| covariant_mode(family, n, 0, &theta, &Vector2::zeros()).unwrap();
    assert!(at(Family::Dual, 28).is_finite());
    assert_eq!(at(Family::Dual, 40), f64::INFINITY);
    assert_eq!(at(Family::Dual, 42), f64::NEG_INFINITY);
    assert_eq!(at(Family::Covariant, 42), 0.0);
}

#[test]
fn far_points_are_dark_whatever_the_unit() {
    for scale in [1e-140f64, 1e-8, 1.0, 1e8, 1e140] {
        let theta = Matrix2::new(2.0, 0.3, 0.3, 1.0) * scale;
        for far in [1e5f64, 1e60, 1e200, f64::MAX] {
            let x = Vector2::new(far, -far) * scale.sqrt().min(1.0);
            let zeta = Vector2::new(far, -far);
            let value = covariant_mode(Family::Covariant, 3, 2, &theta, &x).unwrap();
            if far * scale.sqrt().min(1.0) > 1e3 * scale.sqrt() {
                assert_eq!(value, 0.0, "{scale} {far}");
            }
            let transform = covariant_mode_fourier(Family::Dual, 3, 2, &theta, &zeta).unwrap();
            if far * scale.sqrt() > 1e3 {
                assert_eq!(transform.norm(), 0.0, "{scale} {far}");
            }
            assert!(value.is_finite() && !transform.is_nan());
        }
    }
}

#[test]
fn bad_shapes_points_and_orders_are_refused_with_their_numbers() {
    let (good, origin) = (Matrix2::identity(), Vector2::zeros());
    let text = |theta: &Matrix2<f64>, x: &Vector2<f64>, n| {
        covariant_mode(Family::Covariant, n, 0, theta, x)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        text(&good, &Vector2::new(0.0, f64::NAN), 0),
        "shape: entry (1, 0) of the point is NaN, expected a finite number"
    );
    assert_eq!(
        text(&good, &origin, 257),
        "shape: a mode of order 257 along one axis, expected at most 256"
    );
    assert_eq!(
        text(&Matrix2::new(1.0, 2.0, 2.0, 1.0), &origin, 0),
        "shape: the shape matrix Θ has eigenvalues 3 and -1, expected both positive (beyond 4e-16 of the larger)"
    );
    assert_eq!(
        text(&Matrix2::new(1.0, 0.5, 0.25, 1.0), &origin, 0),
        "shape: the shape matrix Θ is not symmetric: found 0.5 and 0.25 off the diagonal, expected the same number \
         (to 1e-12 of √(m11 m22))"
    );
}
