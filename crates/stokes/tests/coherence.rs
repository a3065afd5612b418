//! Coherence as one measures it: its degree, the ellipse over which it lasts, the degree of cross-polarization.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use stokes::{
    CoherenceError, Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector,
    Wavelength, mode_count, modes,
};

const DISTANCE: f64 = 2.0;

fn light(components: Components, root: Matrix2<f64>) -> GeneralizedStokes {
    GeneralizedStokes::new(
        components,
        ShapeMatrix::from_root(&root).unwrap(),
        Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
        Wavelength::from_metres(500e-9).unwrap(),
        DISTANCE,
    )
    .unwrap()
}

fn shared(real: &[f64], root: Matrix2<f64>) -> GeneralizedStokes {
    let modes = HermiteSeries::from_real_coefficients(real).unwrap();
    let stokes = StokesVector::new(2.0, 0.6, 0.0, 0.8);
    light(Components::Shared { modes, stokes }, root)
}

fn separate(real: [&[f64]; 4]) -> GeneralizedStokes {
    let series = real.map(|real| HermiteSeries::from_real_coefficients(real).ok());
    light(
        Components::Separate(series),
        Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3),
    )
}

/// Separation at whitened coordinates `y`.
fn separation(light: &GeneralizedStokes, y: [f64; 2]) -> Vector2<f64> {
    let k = light.wavelength().wavenumber().radians_per_metre();
    light.shape().unwhiten(&y.into()) * (DISTANCE / k)
}

#[test]
fn a_long_source_makes_a_coherence_ellipse_across_it() {
    // a source 10 mm by 1 mm, its length at 0.5 rad: coherence is widest at 0.5 + π/2
    let (sin, cos) = 0.5f64.sin_cos();
    let root = Matrix2::new(10e-3, 0.0, 0.0, 1e-3) * Matrix2::new(cos, sin, -sin, cos);
    let light = shared(&[1.0], root);
    let ellipse = light.coherence_ellipse().unwrap();
    let k = light.wavelength().wavenumber().radians_per_metre();
    assert!((ellipse.semi_major * k * 1e-3 / DISTANCE - 1.0).abs() < 1e-14);
    assert!((ellipse.semi_minor * k * 10e-3 / DISTANCE - 1.0).abs() < 1e-14);
    assert!((ellipse.orientation - 0.5 - FRAC_PI_2).abs() < 1e-15);
    // and there the degree of coherence is e^(−1/2), for order 0 exactly
    for (length, angle) in [
        (ellipse.semi_major, 0.5 + FRAC_PI_2),
        (ellipse.semi_minor, 0.5),
    ] {
        let xi = Vector2::new(angle.cos(), angle.sin()) * length;
        let gamma = light.degree_of_coherence(&xi);
        assert!((gamma - (-0.5f64).exp()).norm() < 1e-14, "{gamma}");
    }
}

#[test]
fn the_ellipse_is_the_spread_of_directions() {
    // k²Γ by quadrature of the Wigner function: an average over directions, no derivative
    for real in [
        &[1.0][..],
        &[1.0, 0.3, -0.2],
        &[1.0, 0.2, -0.3, -0.1, 0.25, 0.3],
        &[
            1.0, 0.2, -0.3, -0.1, 0.25, 0.3, 0.1, 0.0, -0.2, 0.15, 0.2, -0.1, 0.3, 0.1, -0.2,
        ],
    ] {
        let root = Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3);
        let light = shared(real, root);
        let k = light.wavelength().wavenumber().radians_per_metre();
        let (mut sum, mut first, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
        // the trapezoidal rule, exact to rounding: h_4 is below 1e-16 at 9.5
        for i in -80..=80 {
            for j in -80..=80 {
                let y = Vector2::new(f64::from(i), f64::from(j)) * 0.125;
                let direction = root.transpose() * y / DISTANCE;
                let weight = light.wigner(&(direction * k)).s0();
                sum += weight;
                first += direction * weight;
                second += direction * direction.transpose() * weight;
            }
        }
        let mean: Vector2<f64> = first / sum;
        let gamma = second / sum - mean * mean.transpose();
        let eigen = gamma.symmetric_eigen();
        let (major, minor) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
            (0, 1)
        } else {
            (1, 0)
        };
        let ellipse = light.coherence_ellipse().unwrap();
        let expected = [major, minor].map(|i| 1.0 / (k * eigen.eigenvalues[i].sqrt()));
        // moments of 26,000 terms, by a difference that may halve
        assert!((ellipse.semi_major / expected[0] - 1.0).abs() < 1e-12);
        assert!((ellipse.semi_minor / expected[1] - 1.0).abs() < 1e-12);
        let axis = eigen.eigenvectors.column(major);
        let off = (ellipse.orientation - axis[1].atan2(axis[0]) + FRAC_PI_2).rem_euclid(PI);
        assert!((off - FRAC_PI_2).abs() < 1e-12);
    }
}

#[test]
fn high_orders_have_the_curvature_of_their_differences() {
    // order 64, along both axes and across: −∂² ln|γ| by a central difference
    let mut real = vec![0.0; mode_count(64)];
    for (place, (a, b)) in modes(64).enumerate() {
        let n = (a + b) as f64;
        real[place] = if a + b == 0 {
            1.0
        } else {
            0.1 * (place as f64).sin() / (n * n * n)
        };
    }
    let light = shared(&real, Matrix2::from_diagonal_element(1e-3));
    let ellipse = light.coherence_ellipse().unwrap();
    let step = 1e-3;
    for [x, y] in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]] {
        let xi = separation(&light, [x * step, y * step]);
        let found = -2.0 * light.degree_of_coherence(&xi).norm().ln();
        // on the ellipse the Gaussian of this curvature is e^(−1/2)
        let (sin, cos) = ellipse.orientation.sin_cos();
        let along = (xi.x * cos + xi.y * sin) / ellipse.semi_major;
        let across = (xi.y * cos - xi.x * sin) / ellipse.semi_minor;
        let expected = along * along + across * across;
        // the next term is of order (2N+1)²·step²/12 of the coefficients there, rounding 2ε/step²
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn thin_and_round_shapes_keep_their_axes() {
    for ratio in [1.0, 1.0 + 1e-9, 1e3, 1e6, 1e11] {
        let light = shared(&[1.0], Matrix2::new(1e-3, 0.0, 0.0, 1e-3 / ratio));
        let ellipse = light.coherence_ellipse().unwrap();
        let radius = DISTANCE / (light.wavelength().wavenumber().radians_per_metre() * 1e-3);
        assert!((ellipse.semi_minor / radius - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((ellipse.semi_major / radius / ratio - 1.0).abs() < 8.0 * f64::EPSILON);
        let expected = if ratio > 1.0 { FRAC_PI_2 } else { 0.0 };
        assert!((ellipse.orientation - expected).abs() < 1e-15, "{ratio}");
    }
    // a circle that is round but for its rounding has no orientation
    let (sin, cos) = 1.1f64.sin_cos();
    let round = shared(&[1.0], Matrix2::new(cos, sin, -sin, cos) * 1e-3);
    assert_eq!(round.coherence_ellipse().unwrap().orientation, 0.0);
}

#[test]
fn light_without_a_maximum_says_so() {
    // c2 = 1/2: f(0) = 1 − 1/√8, −f'' = 1 − 5/√8 along the first axis
    let light = shared(&[1.0, 0.0, 0.0, -0.5, 0.0, 0.0], Matrix2::identity());
    let error = light.coherence_ellipse().unwrap_err();
    let expected = (1.0 - 5.0 / 8f64.sqrt()) / (1.0 - 1.0 / 8f64.sqrt());
    match error {
        CoherenceError::NoMaximum {
            larger,
            smaller,
            rounding,
        } => {
            assert!((larger - 1.0).abs() < 1e-15);
            assert!((smaller - expected).abs() < 1e-14);
            assert!(rounding < 1e-13);
        }
        CoherenceError::Dark { .. } => panic!("{error}"),
    }
    let text = error.to_string();
    assert!(text.starts_with("coherence: the curvature of −ln |C0| at zero separation is "));
    assert!(text.contains("expected both positive"), "{text}");
    for stokes in [StokesVector::DARK, StokesVector::new(-1.0, 0.0, 0.0, 0.0)] {
        let modes = HermiteSeries::fundamental(1.0);
        let dark = light_of(modes, stokes);
        let text = dark.coherence_ellipse().unwrap_err().to_string();
        assert!(text.starts_with("coherence: the intensity is "), "{text}");
        assert_eq!(
            dark.degree_of_coherence(&Vector2::new(1e-4, 0.0)),
            Complex64::ZERO
        );
    }
}

fn light_of(modes: HermiteSeries, stokes: StokesVector) -> GeneralizedStokes {
    light(Components::Shared { modes, stokes }, Matrix2::identity())
}

#[test]
fn an_off_axis_source_shifts_the_fringes_and_not_their_visibility() {
    // e^(−|y|²/2)(1 + i ε √2 y1): phase atan(ε √2 y1)
    let light = shared(&[1.0, 0.3, 0.0], Matrix2::from_diagonal_element(1e-3));
    let gamma = light.degree_of_coherence(&separation(&light, [0.7, 0.0]));
    let expected = Complex64::new(1.0, 0.3 * 2f64.sqrt() * 0.7) * (-0.245f64).exp();
    assert!(
        (gamma - expected).norm() < 4.0 * f64::EPSILON,
        "{gamma} {expected}"
    );
    assert_eq!(light.degree_of_coherence(&Vector2::zeros()), Complex64::ONE);
}

#[test]
fn cross_polarization_exceeds_one_and_ends_in_infinity() {
    let c = [0.1, 0.2, 0.3];
    // C0 = h2-like vanishes on a ring that the others do not know
    let light = separate([&[0.0, 1.0, 0.0], &c, &[0.0], &[0.0]]);
    assert_eq!(
        light.degree_of_cross_polarization(&Vector2::zeros()),
        f64::INFINITY
    );
    assert_eq!(
        light.complex_degree_of_cross_polarization(&Vector2::zeros()),
        None
    );
    // far out all are below the smallest number
    let far = separation(&light, [60.0, 60.0]);
    assert_eq!(light.degree_of_cross_polarization(&far), 0.0);
    // shared modes: the degree of polarization everywhere, even there
    let light = shared(&[1.0, 0.3, 0.0], Matrix2::from_diagonal_element(1e-3));
    for y in [[0.0, 0.0], [1.0, -2.0], [60.0, 60.0]] {
        let xi = separation(&light, y);
        assert_eq!(light.degree_of_cross_polarization(&xi), 0.5);
        let complex = light.complex_degree_of_cross_polarization(&xi).unwrap();
        assert!((complex - 0.5).norm() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn cross_polarization_survives_extreme_units() {
    let unit = [
        [1.0, 0.2, 0.1],
        [0.3, 0.1, -0.2],
        [-0.2, 0.0, 0.1],
        [0.1, 0.2, 0.3],
    ];
    let values = |scale: f64| {
        let scaled = unit.map(|series| series.map(|s| s * scale));
        let light = separate(scaled.each_ref().map(|series| &series[..]));
        let xi = separation(&light, [0.8, -0.5]);
        (
            light.degree_of_cross_polarization(&xi),
            light.complex_degree_of_cross_polarization(&xi).unwrap(),
        )
    };
    let (degree, complex) = values(1.0);
    for scale in [1e-280, 1e-170, 1e170, 1e280] {
        let (d, c) = values(scale);
        assert!((d / degree - 1.0).abs() < 1e-14, "{scale}");
        assert!((c - complex).norm() < 1e-14, "{scale}");
    }
}

/// Seeds once found wrong, from the package's root.
fn with_seeds() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(
            "proptest-regressions/coherence.txt",
        ))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(with_seeds())]

    #[test]
    fn cross_polarization_is_that_of_the_coherence_matrix(
        s in prop::array::uniform12(-1.0..1.0f64),
        y in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let light = separate([&s[0..3], &s[3..6], &s[6..9], &s[9..12]]);
        let xi = separation(&light, y);
        let [c0, c1, c2, c3] = light.at_separation(&xi);
        let i = Complex64::I;
        // [[xx, xy], [yx, yy]] with C3 = i(xy − yx)
        let (xx, yy) = (0.5 * (c0 + c1), 0.5 * (c0 - c1));
        let (xy, yx) = (0.5 * (c2 - i * c3), 0.5 * (c2 + i * c3));
        let trace = (xx + yy).norm_sqr();
        let squares = [xx, yy, xy, yx].map(|c| c.norm_sqr()).iter().sum::<f64>();
        prop_assume!(trace > 1e-6 * squares);
        // the square has the roundings of 2 squares/trace; the trace, summed here from its two parts, those of
        // √(squares/trace) on top
        let degree = light.degree_of_cross_polarization(&xi).powi(2);
        let eps = 32.0 * f64::EPSILON * squares / trace;
        let cancelled = eps * (1.0 + (squares / trace).sqrt());
        prop_assert!((degree - (2.0 * squares / trace - 1.0)).abs() <= cancelled);
        let complex = light.complex_degree_of_cross_polarization(&xi).unwrap();
        let expected = 1.0 - 4.0 * (xx * yy - xy * yx) / (c0 * c0);
        prop_assert!((complex.powi(2) - expected).norm() <= eps);
        prop_assert!(complex.re >= 0.0 && complex.norm() <= degree.sqrt() * (1.0 + 1e-14));
    }
}
