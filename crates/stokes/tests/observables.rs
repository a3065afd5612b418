//! What one reads off a Stokes vector, against fields followed in time, exact arithmetic and textbook states.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use proptest::prelude::*;
use stokes::{Handedness, StokesVector};

/// Samples the real field `Re[(ax, ay e^{iφ}) e^{iωt}]` over a period: an oracle without Stokes parameters.
fn field(ax: f64, ay: f64, phase: f64) -> Vec<[f64; 2]> {
    (0..7200)
        .map(|i| {
            let wt = 2.0 * PI * f64::from(i) / 7200.0;
            [ax * wt.cos(), ay * (wt + phase).cos()]
        })
        .collect()
}

/// Stokes parameters as six intensity measurements would give them, circular ones by sense of rotation.
fn stokes_of(ax: f64, ay: f64, phase: f64) -> StokesVector {
    StokesVector::new(
        ax * ax + ay * ay,
        ax * ax - ay * ay,
        2.0 * ax * ay * phase.cos(),
        2.0 * ax * ay * phase.sin(),
    )
}

#[test]
fn the_ellipse_is_the_one_that_the_field_draws() {
    for (ax, ay, phase) in [
        (1.0, 0.4, 0.7),
        (0.3, 1.2, -2.0),
        (1.0, 1.0, FRAC_PI_2),
        (0.8, 0.8, -0.3),
    ] {
        let points = field(ax, ay, phase);
        let length = |p: &[f64; 2]| p[0].hypot(p[1]);
        let longest = points
            .iter()
            .max_by(|a, b| length(a).total_cmp(&length(b)))
            .expect("the field has points");
        let shortest = points.iter().map(length).fold(f64::INFINITY, f64::min);
        // twice the signed area swept: positive when counter-clockwise for x right, y up
        let area: f64 = points
            .iter()
            .zip(points.iter().cycle().skip(1))
            .map(|(p, q)| p[0] * q[1] - p[1] * q[0])
            .sum();
        let ellipse = stokes_of(ax, ay, phase).ellipse();
        // 7200 samples place an extremum within 4.4e-4 rad: lengths to 1e-7
        assert!((ellipse.semi_major - length(longest)).abs() < 1e-6);
        assert!((ellipse.semi_minor - shortest).abs() < 1e-6);
        let clockwise = area < 0.0;
        assert_eq!(ellipse.handedness == Handedness::Right, clockwise);
        if ellipse.semi_major - ellipse.semi_minor > 1e-3 {
            let psi = longest[1].atan2(longest[0]).rem_euclid(PI);
            assert!((ellipse.orientation - psi).abs() < 2e-3);
        }
    }
}

#[test]
fn named_states_have_their_angles() {
    let angle = |s: StokesVector| s.angle_of_linear_polarization();
    assert_eq!(angle(StokesVector::HORIZONTAL), 0.0);
    assert_eq!(angle(StokesVector::DIAGONAL), FRAC_PI_4);
    assert_eq!(angle(StokesVector::VERTICAL), FRAC_PI_2);
    assert_eq!(angle(StokesVector::ANTIDIAGONAL), 3.0 * FRAC_PI_4);
    assert_eq!(StokesVector::RIGHT_CIRCULAR.ellipticity_angle(), FRAC_PI_4);
    assert_eq!(StokesVector::LEFT_CIRCULAR.ellipticity_angle(), -FRAC_PI_4);
}

#[test]
fn dark_and_unpolarized_light_have_no_ellipse() {
    for light in [
        StokesVector::DARK,
        StokesVector::UNPOLARIZED,
        StokesVector::new(1.0, -0.0, 0.0, -0.0),
    ] {
        assert_eq!(light.degree_of_polarization(), 0.0);
        assert_eq!(light.degree_of_circular_polarization(), 0.0);
        let ellipse = light.ellipse();
        assert_eq!((ellipse.semi_major, ellipse.semi_minor), (0.0, 0.0));
        assert_eq!((ellipse.orientation, ellipse.ellipticity), (0.0, 0.0));
        assert_eq!(ellipse.handedness, Handedness::Linear);
    }
}

#[test]
fn a_thin_ellipse_keeps_its_minor_axis() {
    // b/a = tan χ ≈ S3/2 for unit linear light; (p − l)/2 would cancel to 0 here
    let ellipse = StokesVector::new(1.0, 1.0, 0.0, 1e-9).ellipse();
    assert!((ellipse.semi_minor / 0.5e-9 - 1.0).abs() < 1e-14);
    assert_eq!(ellipse.handedness, Handedness::Right);
}

#[test]
fn an_angle_just_below_zero_wraps_below_pi() {
    let angle = StokesVector::new(1.0, 1.0, -1e-300, 0.0).angle_of_linear_polarization();
    assert!((0.0..PI).contains(&angle));
}

#[test]
fn orientation_keeps_the_quadrant() {
    let angle = |s1: f64, s2: f64| StokesVector::new(1.0, s1, s2, 0.2).orientation_angle();
    assert_eq!(angle(-0.5, 0.0), FRAC_PI_2);
    assert_eq!(angle(-0.5, -0.0), FRAC_PI_2);
    assert_eq!(angle(-0.5, -1e-300), FRAC_PI_2);
    assert_eq!(angle(0.0, -0.5), -FRAC_PI_4);
    assert_eq!(angle(-0.0, -0.0), 0.0);
    // printed without its quadrant this would be −π/8
    assert_eq!(angle(-0.3, 0.3), 3.0 * FRAC_PI_4 / 2.0);
}

#[test]
fn almost_polarized_light_keeps_its_smaller_eigenvalue() {
    // Pythagorean quadruple 2² + 3² + 6² = 7²: exactly on the cone
    let on_cone = StokesVector::new(7.0, 2.0, 3.0, 6.0);
    assert_eq!(on_cone.unpolarized_intensity(), 0.0);
    assert_eq!(on_cone.eigenvalues(), [7.0, 0.0]);
    // 7 + e above it: S0 − p = e exactly, for any e that 7 + e still holds
    for e in [1e-3, 1e-9, 8.0 * f64::EPSILON, -8.0 * f64::EPSILON] {
        let s0 = 7.0 + e;
        let unpolarized = StokesVector::new(s0, 2.0, 3.0, 6.0).unpolarized_intensity();
        let expected = s0 - 7.0;
        assert!((unpolarized / expected - 1.0).abs() <= 2.0 * f64::EPSILON);
    }
    // S3 → 0 and units in which no square is a number
    for scale in [1e-250, 1.0, 1e300] {
        let [larger, smaller] = (StokesVector::new(1.0, 1.0, 0.0, 1e-9) * scale).eigenvalues();
        // √(1 + 1e-18) = 1 + 5e-19
        assert!((larger / scale - 1.0).abs() <= f64::EPSILON);
        assert!((smaller / scale / -2.5e-19 - 1.0).abs() <= 8.0 * f64::EPSILON);
    }
    assert_eq!(StokesVector::DARK.eigenvalues(), [0.0, 0.0]);
    // the mirror image in the cone's tip
    let negative = StokesVector::new(-7.0 - 1e-9, 2.0, 3.0, 6.0).eigenvalues();
    let positive = StokesVector::new(7.0 + 1e-9, 2.0, 3.0, 6.0).eigenvalues();
    assert_eq!(negative, [-positive[1], -positive[0]]);
}

proptest! {
    #[test]
    fn eigenvalues_are_those_of_the_coherency_matrix(
        s in prop::array::uniform3(prop_oneof![-1.0..1.0f64, -1e-9..1e-9]),
        above in prop_oneof![-1.0..2.0f64, -1e-12..1e-12, Just(0.0)],
    ) {
        let p = StokesVector::new(0.0, s[0], s[1], s[2]).polarized_intensity();
        let light = StokesVector::new(p + above, s[0], s[1], s[2]);
        let [larger, smaller] = light.eigenvalues();
        // trace, and determinant xx·yy − |xy|² in an order of its own
        let (xx, yy) = (0.5 * (light.s0() + s[0]), 0.5 * (light.s0() - s[0]));
        let det = xx * yy - 0.25 * (s[1] * s[1] + s[2] * s[2]);
        let scale = light.s0().abs() + p;
        prop_assert!((larger + smaller - xx - yy).abs() <= 4.0 * f64::EPSILON * scale);
        prop_assert!((larger * smaller - det).abs() <= 4.0 * f64::EPSILON * scale * scale);
        prop_assert!(larger >= smaller);
    }

    #[test]
    fn near_the_cone_the_unpolarized_part_is_that_of_exact_arithmetic(
        s in prop::array::uniform3(-(1i64 << 50)..1 << 50), above in -5i64..=5,
    ) {
        let [s1, s2, s3] = s.map(|s| s as f64);
        let p = StokesVector::new(0.0, s1, s2, s3).polarized_intensity();
        let s0 = p.round() as i64 + above;
        let square = |s: i64| i128::from(s) * i128::from(s);
        let form = square(s0) - s.map(square).iter().sum::<i128>();
        let light = StokesVector::new(s0 as f64, s1, s2, s3);
        let expected = form as f64 / (s0 as f64 + p);
        // p, sum and quotient round once each, the form twice, and 1e-31 of S0 is left of its squares
        let tolerance = 8.0 * f64::EPSILON * expected.abs() + 1e-31 * s0 as f64;
        prop_assert!((light.unpolarized_intensity() - expected).abs() <= tolerance);
    }

    #[test]
    fn ellipse_and_vector_say_the_same(
        psi in 0.0..PI,
        chi in prop_oneof![-FRAC_PI_4..FRAC_PI_4, -1e-12..1e-12, Just(FRAC_PI_4)],
        degree in prop_oneof![1e-12..1.0f64, Just(1.0)],
    ) {
        let light = StokesVector::new(
            3.0,
            3.0 * degree * (2.0 * chi).cos() * (2.0 * psi).cos(),
            3.0 * degree * (2.0 * chi).cos() * (2.0 * psi).sin(),
            3.0 * degree * (2.0 * chi).sin(),
        );
        let e = light.ellipse();
        prop_assert!((light.degree_of_polarization() / degree - 1.0).abs() < 1e-14);
        prop_assert!((e.ellipticity - chi).abs() < 1e-15);
        prop_assert!((e.semi_minor - e.semi_major * chi.abs().tan()).abs() < 2e-15);
        let power = e.semi_major.powi(2) + e.semi_minor.powi(2);
        prop_assert!((power / (3.0 * degree) - 1.0).abs() < 1e-14);
        // the direction of a nearly circular ellipse is lost with its linear part
        let off = (e.orientation - psi + 0.5 * PI).rem_euclid(PI) - 0.5 * PI;
        prop_assert!(off.abs() * (2.0 * chi).cos() < 1e-15 * 4.0);
    }
}
