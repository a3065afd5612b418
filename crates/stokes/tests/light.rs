//! Light on one ray: what its constructors refuse and in which words, and what a turned frame does to it.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, LightError, Mueller, ShapeMatrix,
    StokesVector, Wavelength,
};

fn wavelength(metres: f64) -> Wavelength {
    Wavelength::from_metres(metres).unwrap()
}

fn along_z() -> Frame {
    Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap()
}

fn shape() -> ShapeMatrix {
    ShapeMatrix::from_root(&Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3)).unwrap()
}

fn shared(real: &[f64], stokes: [f64; 4]) -> Components {
    Components::Shared {
        modes: HermiteSeries::from_real_coefficients(real).unwrap(),
        stokes: stokes.into(),
    }
}

fn light(components: Components) -> GeneralizedStokes {
    GeneralizedStokes::new(components, shape(), along_z(), wavelength(500e-9), 2.0).unwrap()
}

/// Four different series with odd modes.
fn lopsided() -> GeneralizedStokes {
    let series = |real: &[f64]| HermiteSeries::from_real_coefficients(real).ok();
    light(Components::Separate([
        series(&[1.0, 0.3, -0.2, 0.1, 0.2, -0.3]),
        series(&[0.2, -0.4, 0.1]),
        series(&[0.3]),
        series(&[-0.1, 0.1, 0.2, 0.3, -0.2, 0.1]),
    ]))
}

#[test]
fn the_near_field_is_refused_with_its_numbers() {
    for (distance, starts) in [
        // k r = 2π · 10 < 100
        (
            5e-6,
            "light: distance 0.000005 m at wavelength 0.0000005 m has k r = 62.8318530717",
        ),
        (
            f64::INFINITY,
            "light: distance inf m at wavelength 0.0000005 m has k r = inf, ",
        ),
        (
            f64::NAN,
            "light: distance NaN m at wavelength 0.0000005 m has k r = NaN, ",
        ),
        (
            -2.0,
            "light: distance -2 m at wavelength 0.0000005 m has k r = -",
        ),
    ] {
        let components = shared(&[1.0], [1.0, 0.0, 0.0, 0.0]);
        let error =
            GeneralizedStokes::new(components, shape(), along_z(), wavelength(500e-9), distance)
                .unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with(starts), "{text}");
        assert!(text.ends_with("expected a finite distance with k r ≥ 100: the far-field expansion does not hold nearer"), "{text}");
        // and light that exists cannot be brought there
        let again = lopsided().propagated_to(distance).unwrap_err();
        assert_eq!(again.to_string(), text);
    }
}

#[test]
fn amplitudes_are_numbers() {
    for (component, value) in [(0, f64::NAN), (3, f64::INFINITY), (1, f64::NEG_INFINITY)] {
        let mut stokes = [1.0, 0.1, 0.2, 0.3];
        stokes[component] = value;
        let error = GeneralizedStokes::new(
            shared(&[1.0], stokes),
            shape(),
            along_z(),
            wavelength(500e-9),
            2.0,
        )
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("light: amplitude S{component} is {value}, expected a finite number")
        );
    }
}

#[test]
fn coefficients_are_numbers() {
    let nan = HermiteSeries::fundamental(f64::NAN);
    for components in [
        Components::Shared {
            modes: nan.clone(),
            stokes: StokesVector::UNPOLARIZED,
        },
        Components::Separate([Some(HermiteSeries::fundamental(1.0)), None, Some(nan), None]),
    ] {
        let made = GeneralizedStokes::new(components, shape(), along_z(), wavelength(500e-9), 2.0);
        assert_eq!(
            made.unwrap_err().to_string(),
            "series: coefficient (0, 0) is NaN+0i, expected a finite number"
        );
    }
}

#[test]
fn what_is_made_of_light_is_made_of_numbers() {
    let bright = shared(&[1.0, 0.3, 0.0], [f64::MAX, 0.0, 0.0, 0.0]);
    let broken = Mueller::from_rows([[f64::NAN; 4]; 4]);
    for components in [bright, lopsided().components().clone()] {
        let one = light(components);
        for factor in [f64::NAN, f64::INFINITY] {
            assert!(one.scaled(factor).is_err(), "{factor}");
        }
        assert!(one.through(&broken, along_z()).is_err());
    }
    let one = light(shared(&[1.0], [f64::MAX, 0.0, 0.0, 0.0]));
    let error = one.plus(&one).unwrap_err();
    assert_eq!(
        error.to_string(),
        "light: amplitude S0 is inf, expected a finite number"
    );
}

#[test]
fn only_lights_of_one_ray_are_added() {
    let light = lopsided();
    let others = [
        (
            "wavelength",
            GeneralizedStokes::new(
                light.components().clone(),
                shape(),
                along_z(),
                wavelength(501e-9),
                2.0,
            ),
        ),
        ("distance", light.clone().propagated_to(2.5)),
        ("frame", light.in_frame(along_z().turned(0.1))),
        (
            "shape",
            GeneralizedStokes::new(
                light.components().clone(),
                shape().fourier_dual(),
                along_z(),
                wavelength(500e-9),
                2.0,
            ),
        ),
    ];
    for (what, other) in others {
        let error = light.plus(&other.unwrap()).unwrap_err();
        assert_eq!(error, LightError::Mismatch { what });
        assert_eq!(
            error.to_string(),
            format!("light: the two differ in their {what}; bring one into the other's first")
        );
    }
}

#[test]
fn a_frame_of_another_ray_is_refused() {
    let tilted = Frame::with_x_along(Vector3::new(1e-3, 0.0, 1.0), Vector3::x()).unwrap();
    let error = lopsided().in_frame(tilted).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("light: the frame's propagation is off the ray's by 0.00099999"),
        "{text}"
    );
    assert!(
        text.ends_with("rad, expected the same direction (to 1e-6)"),
        "{text}"
    );
}

#[test]
fn lights_that_share_their_modes_keep_sharing_them() {
    let a = light(shared(&[1.0, 0.3, 0.0], [1.0, 0.5, 0.0, 0.0]));
    let b = light(shared(&[1.0, 0.3, 0.0], [2.0, 0.0, 0.0, -1.0]));
    let expected = shared(&[1.0, 0.3, 0.0], [3.0, 0.5, 0.0, -1.0]);
    assert_eq!(*a.plus(&b).unwrap().components(), expected);
    // one that does not share them makes four series, without those that are absent from both
    let c = light(shared(&[1.0], [1.0, 0.0, 0.0, 0.0]));
    let sum = a.plus(&c).unwrap();
    let Components::Separate([s0, s1, s2, s3]) = sum.components() else {
        panic!("{sum:?}");
    };
    assert_eq!(s0.as_ref().unwrap().real_coefficients(), [2.0, 0.3, 0.0]);
    assert_eq!(s1.as_ref().unwrap().real_coefficients(), [0.5, 0.15, 0.0]);
    assert_eq!((s2, s3), (&None, &None));
}

#[test]
fn an_element_feeds_absent_components_only_where_its_matrix_does() {
    let modes = HermiteSeries::from_real_coefficients(&[1.0, 0.3, 0.0]).unwrap();
    let unpolarized = light(Components::Separate([
        Some(modes.clone()),
        None,
        None,
        None,
    ]));
    // a horizontal polarizer: ½ [1 1; 1 1]
    let polarizer = Mueller::from_rows([
        [0.5, 0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.0; 4],
        [0.0; 4],
    ]);
    let polarized = unpolarized.through(&polarizer, along_z()).unwrap();
    let half = Some(modes.scaled(0.5));
    let expected = Components::Separate([half.clone(), half, None, None]);
    assert_eq!(*polarized.components(), expected);
}

#[test]
fn a_frame_turned_by_an_eighth_takes_c1_for_c2() {
    // C1' = c C1 + s C2, C2' = −s C1 + c C2 with 2t = π/2; the place at which they are read turns with the axes
    let light = lopsided();
    let turned = light.in_frame(along_z().turned(FRAC_PI_4)).unwrap();
    let xi = Vector2::new(90e-6, 40e-6);
    let [c0, c1, c2, c3] = light.at_separation(&xi);
    // the same two points, written along the new axes
    let written = Vector2::new(xi.x + xi.y, xi.y - xi.x) / 2f64.sqrt();
    let scale = c0.norm();
    for (found, expected) in turned
        .at_separation(&written)
        .into_iter()
        .zip([c0, c2, -c1, c3])
    {
        assert!(
            (found - expected).norm() < 1e-14 * scale,
            "{found} {expected}"
        );
    }
    // C1 and C2 are different numbers with phases, so that no exchange or sign is hidden
    assert!((c1 - c2).norm() > 0.01 * scale && c1.im.abs() > 0.01 * scale);
}

#[test]
fn a_quarter_turn_of_the_frame_is_a_quarter_turn_of_the_separation() {
    let light = lopsided();
    let turned = light.in_frame(along_z().turned(FRAC_PI_2)).unwrap();
    // x' = y, y' = −x: the point (p, q) in new axes is (−q, p) in the old ones
    for [p, q] in [[90e-6, 40e-6], [-30e-6, 70e-6]] {
        let [c0, c1, c2, c3] = light.at_separation(&Vector2::new(-q, p));
        let found = turned.at_separation(&Vector2::new(p, q));
        for (found, expected) in found.into_iter().zip([c0, -c1, -c2, c3]) {
            assert!((found - expected).norm() < 1e-14 * c0.norm());
        }
        // odd modes tell a turn from its inverse: the inverse would be the conjugate
        assert!(c0.im.abs() > 0.01 * c0.norm());
        let [wrong, ..] = light.at_separation(&Vector2::new(q, -p));
        assert!((wrong - c0.conj()).norm() < 1e-15 * c0.norm());
    }
    // radiances turn alike: the source point stays where it is
    let m = Vector2::new(0.4e-3, -0.9e-3);
    let here = light.generalized_radiance(&m).to_array();
    let there = turned
        .generalized_radiance(&Vector2::new(m.y, -m.x))
        .to_array();
    for (found, expected) in there
        .into_iter()
        .zip([here[0], -here[1], -here[2], here[3]])
    {
        assert!((found - expected).abs() < 1e-14 * here[0].abs());
    }
    // and horizontal light has become vertical
    let linear = self::light(shared(&[1.0], [1.0, 1.0, 0.0, 0.0]));
    let seen = linear
        .in_frame(along_z().turned(FRAC_PI_2))
        .unwrap()
        .stokes();
    assert!((seen.stokes.degree_of_polarization() - 1.0).abs() < 1e-15);
    assert!((seen.stokes.orientation_angle() - FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn a_loss_is_what_the_sum_of_both_parts_lacks() {
    let light = lopsided();
    let (kept, loss) = light.truncated(1);
    // C0 loses 0.1² + 0.2² + 0.3², C3 0.3² + 0.2² + 0.1²; the whole has 1.27 + 0.21 + 0.09 + 0.20
    assert!(
        (loss.norm - (0.28f64 / 1.77).sqrt()).abs() < 1e-15,
        "{}",
        loss.norm
    );
    let sum = kept.stokes().stokes + loss.stokes;
    let difference = sum - light.stokes().stokes;
    assert!(difference.to_vector().norm() < 1e-15 * light.stokes().stokes.s0());
    assert_eq!(kept.components().order(), 1);
}

#[test]
fn the_stokes_vector_is_the_coherence_of_a_point_with_itself() {
    let light = lopsided();
    let stokes: StokesVector = light.stokes().stokes;
    let at_zero = light.at_separation(&Vector2::zeros());
    assert_eq!(stokes.to_array().map(Complex64::from), at_zero);
    assert_eq!(light.intensity(), stokes.s0());
    // C2 has the one mode 0.3 φ_00
    let expected = 0.3 * (shape().root_determinant() / std::f64::consts::PI).sqrt() / 4.0;
    assert!((stokes.s2() / expected - 1.0).abs() < 4.0 * f64::EPSILON);
}
