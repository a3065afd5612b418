//! Shape matrices: there and back within their condition number, and refusals that say what was found.

use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use stokes::{MAX_CONDITION, ShapeError, ShapeMatrix};

/// A turn, a stretch with singular values `size·√stretch` and `size/√stretch`, and another turn.
fn root(angles: [f64; 2], size: f64, stretch: f64) -> Matrix2<f64> {
    let turn = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        Matrix2::new(cos, -sin, sin, cos)
    };
    let stretch = Matrix2::new(stretch.sqrt(), 0.0, 0.0, 1.0 / stretch.sqrt());
    turn(angles[0]) * stretch * turn(angles[1]) * size
}

fn angles() -> impl Strategy<Value = [f64; 2]> {
    prop::array::uniform2(-3.2..3.2f64)
}

/// `|m − expected|` relative to the largest entry expected.
fn distance(m: &Matrix2<f64>, expected: &Matrix2<f64>) -> f64 {
    (m - expected).amax() / expected.amax()
}

fn text(result: Result<ShapeMatrix, ShapeError>) -> String {
    result.expect_err("a bad shape").to_string()
}

proptest! {
    #[test]
    fn theta_and_covariance_are_each_others_inverse(
        angles in angles(), size in -60.0..60.0f64, stretch in 0.0..6.0f64, mirrored in any::<bool>(),
    ) {
        let mut w = root(angles, 10f64.powf(size), 10f64.powf(stretch));
        if mirrored {
            w.swap_rows(0, 1);
        }
        let shape = ShapeMatrix::from_root(&w).unwrap();
        let product = shape.theta() * shape.covariance();
        let condition = shape.condition_number();
        prop_assert!((product - Matrix2::identity()).amax() <= 16.0 * f64::EPSILON * condition);
        // |W|² is |Θ⁻¹|, whose entries cancel
        prop_assert!((shape.root_determinant() - w.determinant().abs()).abs()
            <= 8.0 * f64::EPSILON * w.amax().powi(2));
        // the condition number is that of the stretch, as far as the rounded root knows it
        let expected = 10f64.powf(2.0 * stretch);
        prop_assert!((condition / expected - 1.0).abs() <= 16.0 * f64::EPSILON * expected.sqrt());
    }

    #[test]
    fn whitening_is_undone_by_unwhitening(
        angles in angles(), size in -30.0..30.0f64, stretch in 0.0..10.0f64, x in -9.0..9.0f64, y in -9.0..9.0f64,
    ) {
        let shape = ShapeMatrix::from_root(&root(angles, 10f64.powf(size), 10f64.powf(stretch))).unwrap();
        let w = Vector2::new(x, y);
        let again = shape.unwhiten(&shape.whiten(&w));
        // y is right to its last place, W⁻¹ magnifies that by √cond
        prop_assert!((again - w).norm() <= 16.0 * f64::EPSILON * shape.condition_number().sqrt() * w.norm());
    }

    #[test]
    fn the_three_ways_to_make_a_shape_agree(
        angles in angles(), size in -60.0..60.0f64, stretch in 0.0..6.0f64,
    ) {
        let w = root(angles, 10f64.powf(size), 10f64.powf(stretch));
        let given = ShapeMatrix::from_root(&w).unwrap();
        let condition = given.condition_number();
        let tolerance = 32.0 * f64::EPSILON * condition;
        // beyond 1e-1 nothing is known: the roundings of Θ are as large as its smaller eigenvalue
        prop_assume!(tolerance < 1e-1);
        let (theta, covariance) = (given.theta(), given.covariance());
        let from_covariance = ShapeMatrix::from_covariance(&covariance).unwrap();
        prop_assert!(distance(&from_covariance.covariance(), &covariance) <= 16.0 * f64::EPSILON);
        prop_assert!(distance(&from_covariance.theta(), &theta) <= tolerance);
        let from_theta = ShapeMatrix::from_theta(&theta).unwrap();
        prop_assert!(distance(&from_theta.theta(), &theta) <= 16.0 * f64::EPSILON * condition.sqrt());
        prop_assert!(distance(&from_theta.covariance(), &covariance) <= tolerance);
        prop_assert_eq!(ShapeMatrix::from_log_hessian(&-covariance).unwrap(), from_covariance);
        // all roots of one Θ have one determinant
        let ratio = from_theta.root_determinant() / from_covariance.root_determinant();
        prop_assert!((ratio - 1.0).abs() <= tolerance);
    }

    #[test]
    fn the_dual_of_the_dual_is_the_shape(
        angles in angles(), size in -60.0..60.0f64, stretch in 0.0..10.0f64,
    ) {
        let shape = ShapeMatrix::from_root(&root(angles, 10f64.powf(size), 10f64.powf(stretch))).unwrap();
        let dual = shape.fourier_dual();
        let again = dual.fourier_dual();
        prop_assert!(distance(again.root(), shape.root()) <= 8.0 * f64::EPSILON * shape.condition_number().sqrt());
        prop_assert!((again.root_determinant() / shape.root_determinant() - 1.0).abs() <= 4.0 * f64::EPSILON);
        // Θ of the dual is Θ⁻¹ of the shape
        prop_assert!(distance(&dual.covariance(), &shape.theta()) <= 16.0 * f64::EPSILON);
        prop_assert!(ShapeMatrix::from_root(dual.root()).is_ok());
    }

    #[test]
    fn a_turn_of_the_axes_leaves_the_function_alone(
        angles in angles(), size in -3.0..3.0f64, stretch in 0.0..10.0f64, angle in -4.0..4.0f64,
        x in -9.0..9.0f64, y in -9.0..9.0f64,
    ) {
        let shape = ShapeMatrix::from_root(&root(angles, 10f64.powf(size), 10f64.powf(stretch))).unwrap();
        let (sin, cos) = angle.sin_cos();
        let turned = shape.in_turned_axes(cos, sin);
        // the coordinates of one point in axes that are turned counter-clockwise by the angle
        let (w, there) = (Vector2::new(x, y), Vector2::new(cos * x + sin * y, cos * y - sin * x));
        let (old, new) = (shape.whiten(&w), turned.whiten(&there));
        prop_assert!((old - new).norm() <= 16.0 * f64::EPSILON * shape.root().norm() * w.norm());
        prop_assert_eq!(turned.root_determinant(), shape.root_determinant());
        let map = Matrix2::new(cos, -sin, sin, cos);
        let mapped = shape.in_coordinates(&map).unwrap();
        prop_assert_eq!(mapped.root(), turned.root());
    }

    #[test]
    fn roots_that_differ_by_a_turn_have_one_theta(angles in angles(), stretch in 0.0..6.0f64, angle in -4.0..4.0f64) {
        let shape = ShapeMatrix::from_root(&root(angles, 1.0, 10f64.powf(stretch))).unwrap();
        let (sin, cos) = angle.sin_cos();
        let turned = shape.with_root_turned_by(&Matrix2::new(cos, sin, sin, -cos)).unwrap();
        prop_assert!(distance(&turned.covariance(), &shape.covariance()) <= 16.0 * f64::EPSILON);
        prop_assert!(distance(&turned.theta(), &shape.theta()) <= 32.0 * f64::EPSILON * shape.condition_number().sqrt());
    }

    #[test]
    fn round_and_diagonal_shapes_are_recognized_in_any_root(angle in -4.0..4.0f64, variance in 1e-9..1e9f64, ratio in 1.001..1e6f64) {
        let (sin, cos) = angle.sin_cos();
        let u = Matrix2::new(cos, sin, sin, -cos);
        let round = ShapeMatrix::isotropic(variance).unwrap();
        prop_assert!(round.is_isotropic() && round.is_diagonal());
        prop_assert!(round.with_root_turned_by(&u).unwrap().is_isotropic());
        let wide = ShapeMatrix::from_theta(&Matrix2::new(variance, 0.0, 0.0, variance * ratio)).unwrap();
        prop_assert!(wide.is_diagonal() && !wide.is_isotropic());
        let tilt = (1.0 - 1.0 / ratio) * 1e-6;
        let tilted = Matrix2::new(variance, tilt * variance, tilt * variance, variance * ratio);
        prop_assert!(!ShapeMatrix::from_theta(&tilted).unwrap().is_diagonal());
    }

    #[test]
    fn any_numbers_make_a_shape_or_an_error(bits in prop::array::uniform4(any::<u64>())) {
        // every f64 there is: subnormal, infinite, not a number
        let [a, b, c, d] = bits.map(f64::from_bits);
        for m in [Matrix2::new(a, b, c, d), Matrix2::new(a.abs(), b, b, d.abs())] {
            for made in [
                ShapeMatrix::from_root(&m),
                ShapeMatrix::from_theta(&m),
                ShapeMatrix::from_covariance(&m),
                ShapeMatrix::from_log_hessian(&m),
            ] {
                match made {
                    Ok(shape) => {
                        prop_assert!(shape.root_determinant().is_normal());
                        prop_assert!(shape.theta().iter().chain(&shape.covariance()).all(|x| x.is_finite()));
                        prop_assert!(shape.condition_number() <= 1.0001 * MAX_CONDITION);
                    }
                    Err(error) => prop_assert!(error.to_string().starts_with("shape: ")),
                }
            }
        }
    }
}

#[test]
fn thin_shapes_are_kept_as_far_as_their_entries_go() {
    // cond Θ = 1e15, of exact entries: |Θ| = (1 + e)² − 1 with e = 2^(−49)
    let e = 2f64.powi(-49);
    let theta = Matrix2::new(1.0 + e, 1.0, 1.0, 1.0 + e);
    let shape = ShapeMatrix::from_theta(&theta).unwrap();
    // eigenvalues 2 + e and e
    let condition = (2.0 + e) / e;
    assert!((shape.condition_number() / condition - 1.0).abs() < 1e-7);
    let expected = 1.0 / (e * (2.0 + e)).sqrt();
    assert!((shape.root_determinant() / expected - 1.0).abs() < 1e-7);
    // the entries of the root are right to ε; only their difference, across the thin axis, is not
    let sum = shape.whiten(&Vector2::new(1.0, -1.0)).norm();
    assert!((sum / (2.0 / e).sqrt() - 1.0).abs() < 8.0 * f64::EPSILON);
}

#[test]
fn diagonal_roots_come_near_the_largest_condition_number() {
    for [a, b] in [[2e-12, 1.0], [2e58, 1e70], [1e-70, 5e-59], [-2e-6, 1e6]] {
        let shape = ShapeMatrix::from_root(&Matrix2::new(a, 0.0, 0.0, b)).unwrap();
        assert!(
            (shape.condition_number() / 2.5e23 - 1.0).abs() < 1e-14,
            "{a} {b}"
        );
        assert_eq!(shape.root_determinant(), (a * b).abs());
        let theta = shape.theta();
        assert!((theta.m11 * a * a - 1.0).abs() < 8.0 * f64::EPSILON);
        assert!((theta.m22 * b * b - 1.0).abs() < 8.0 * f64::EPSILON);
    }
}

#[test]
fn a_mirrored_root_is_a_shape_like_any_other() {
    let mirrored = ShapeMatrix::from_root(&Matrix2::new(0.0, 2.0, 1.0, 0.0)).unwrap();
    assert_eq!(mirrored.root_determinant(), 2.0);
    assert_eq!(mirrored.theta(), Matrix2::new(1.0, 0.0, 0.0, 0.25));
    assert_eq!(
        mirrored.unwhiten(&Vector2::new(2.0, 1.0)),
        Vector2::new(1.0, 1.0)
    );
}

#[test]
fn symmetry_is_asked_for_in_the_units_of_the_axes() {
    // axes of 1e6 and 1e-6: √(m11 m22) = 1, so that 1e-11 is an asymmetry although it is 1e-17 of the largest
    let m = |difference: f64| Matrix2::new(1e6, 0.25 + difference, 0.25, 1e-6);
    assert!(ShapeMatrix::from_covariance(&m(1e-13)).is_ok());
    assert!(matches!(
        ShapeMatrix::from_covariance(&m(1e-11)),
        Err(ShapeError::NotSymmetric { .. })
    ));
    // what is left of a difference below the tolerance is split
    let shape = ShapeMatrix::from_covariance(&Matrix2::new(1.0, 4e-13, 0.0, 1.0)).unwrap();
    assert!((shape.covariance().m12 - 2e-13).abs() < 1e-28 + f64::EPSILON);
}

#[test]
fn refusals_name_the_matrix_and_its_numbers() {
    assert_eq!(
        text(ShapeMatrix::from_root(&Matrix2::new(
            1.0,
            f64::NAN,
            0.0,
            1.0
        ))),
        "shape: entry (0, 1) of the root is NaN, expected a finite number"
    );
    assert_eq!(
        text(ShapeMatrix::from_covariance(&Matrix2::new(
            1.0,
            0.0,
            f64::INFINITY,
            1.0
        ))),
        "shape: entry (1, 0) of the covariance is inf, expected a finite number"
    );
    assert_eq!(
        text(ShapeMatrix::from_covariance(&Matrix2::new(
            1.0, 0.5, 0.2, 1.0
        ))),
        "shape: the covariance is not symmetric: found 0.5 and 0.2 off the diagonal, expected the same number (to \
         1e-12 of √(m11 m22))"
    );
    assert_eq!(
        text(ShapeMatrix::from_theta(&Matrix2::new(2.0, 0.0, 0.0, -0.5))),
        "shape: the shape matrix Θ has eigenvalues 2 and -0.5, expected both positive (beyond 4e-16 of the larger)"
    );
    assert_eq!(
        text(ShapeMatrix::from_log_hessian(&Matrix2::new(
            0.0, 0.0, 0.0, 0.0
        ))),
        "shape: the negated Hessian of ln |f| has eigenvalues 0 and 0, expected both positive (beyond 4e-16 of the \
         larger)"
    );
    assert_eq!(
        text(ShapeMatrix::from_root(&Matrix2::new(1.0, 1.0, 1.0, 1.0))),
        "shape: condition number inf of Θ, expected at most 1e24; the shape is a line: give its thin axis a width"
    );
    assert_eq!(
        text(ShapeMatrix::from_root(&Matrix2::new(1e80, 0.0, 0.0, 1e79))),
        format!(
            "shape: a singular value of the root is {}, expected 1e-70 to 1e70; choose another unit",
            1e80
        )
    );
    for variance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(ShapeMatrix::isotropic(variance).is_err(), "{variance}");
    }
}

#[test]
fn shapes_out_of_range_are_refused_for_their_size_and_not_for_their_form() {
    // round, so that nothing is wrong but the unit
    for size in [
        f64::MIN_POSITIVE,
        1e-300,
        1e-160,
        1e-71,
        1e71,
        1e160,
        1e300,
        f64::MAX,
    ] {
        let made = ShapeMatrix::from_root(&Matrix2::from_diagonal_element(size));
        assert!(
            matches!(made, Err(ShapeError::OutOfRange { .. })),
            "{size}: {made:?}"
        );
    }
    for variance in [
        5e-324,
        1e-300,
        1e-200,
        1e-142,
        1e142,
        1e200,
        1e300,
        f64::MAX,
    ] {
        let made = ShapeMatrix::from_theta(&Matrix2::from_diagonal_element(variance));
        assert!(
            matches!(made, Err(ShapeError::OutOfRange { .. })),
            "{variance}: {made:?}"
        );
        let made = ShapeMatrix::from_covariance(&Matrix2::from_diagonal_element(variance));
        assert!(
            matches!(made, Err(ShapeError::OutOfRange { .. })),
            "{variance}: {made:?}"
        );
    }
}
