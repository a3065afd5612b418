//! Sources against published tables, their limits, and the beam that they send.

use super::*;

const RED: f64 = 632.8e-9;

fn source(amplitudes: [f64; 2], b: Complex64, sigma: f64, widths: [f64; 3]) -> SchellSource {
    let red = Wavelength::from_metres(RED).unwrap();
    SchellSource::new(red, amplitudes, b, sigma, widths).unwrap()
}

fn uncorrelated(amplitudes: [f64; 2], sigma: f64, dx: f64, dy: f64) -> SchellSource {
    source(
        amplitudes,
        Complex64::new(0.0, 0.0),
        sigma,
        [dx, dy, dx.hypot(dy)],
    )
}

/// S1/S0 on the axis at distance z, published to the digits given.
#[test]
fn an_unpolarized_source_becomes_polarized_on_the_way() {
    let equal = uncorrelated([1.0, 1.0], 1e-2, 2e-4, 4e-4);
    let weaker_y = uncorrelated([1.0, 0.5f64.sqrt()], 1e-2, 2e-4, 4e-4);
    let ratio = |source: &SchellSource, z: f64| {
        let light = source.stokes(&Vector2::zeros(), z).unwrap();
        light.s1() / light.s0()
    };
    for (z, expected, half_unit) in [
        (0.0, 0.0, 1e-15),
        (1.0, -0.000_949_416, 5e-10),
        (10.0, -0.082_081_2, 5e-8),
        (100.0, -0.564_304_0, 5e-8),
        (1000.0, -0.599_525_8, 5e-8),
        (1e7, -0.599_904_0, 5e-8),
    ] {
        assert!((ratio(&equal, z) - expected).abs() < half_unit, "{z}");
    }
    for (z, expected) in [
        (0.0, 0.333_333_3),
        (1.0, 0.332_489_1),
        (10.0, 0.258_319_8),
        (100.0, -0.284_482_1),
        (1000.0, -0.332_674_8),
        (1e7, -0.333_200_0),
    ] {
        assert!((ratio(&weaker_y, z) - expected).abs() < 5e-8, "{z}");
    }
}

/// S1/S0 against the angle from the axis; the radiance follows sin θ.
#[test]
fn polarization_depends_on_the_direction() {
    let source = uncorrelated([1.0, 1.0], 1e-2, 1e-6, 2e-6);
    for (theta, expected) in [
        (0.0f64, -0.6),
        (0.02, -0.580_74),
        (0.05, -0.468_73),
        (0.08, -0.217_40),
        (0.12, 0.350_93),
        (0.2, 0.976_93),
    ] {
        let light = source.radiance(theta.sin());
        assert!(
            (light.s1() / light.s0() - expected).abs() < 5.1e-6,
            "{theta}"
        );
    }
    assert!(
        source
            .radiance(0.096_972_7f64.sin())
            .degree_of_polarization()
            < 1e-5
    );
}

#[test]
fn correlated_fields_have_the_published_polarization() {
    let source = source(
        [1.0, 1.0],
        Complex64::new(0.3, 0.2),
        1e-2,
        [1e-6, 2e-6, 1.8e-6],
    );
    source.realizability().unwrap();
    let light = source.radiance(0.1f64.sin());
    let expected = [1.0, 0.043_778, 0.337_541, -0.225_027];
    for (found, expected) in light.to_array().into_iter().zip(expected) {
        assert!((found / light.s0() - expected).abs() < 6e-7, "{found}");
    }
    assert!((light.degree_of_polarization() - 0.408_029).abs() < 6e-7);
}

#[test]
fn the_limits_of_the_cross_coherence_are_sharp() {
    let at = |b: f64, width: f64| {
        source(
            [1.0, 1.0],
            Complex64::new(0.0, b),
            1e-2,
            [1e-6, 2e-6, width],
        )
        .realizability()
    };
    let edge = 2.5f64.sqrt() * 1e-6;
    assert!(at(0.8, edge).is_ok());
    let text = at(0.81, edge).unwrap_err().to_string();
    assert!(text.contains("δxy"), "{text}");
    assert!(at(0.8, 0.99 * edge).is_err() && at(0.0, 0.1 * edge).is_ok());
}

#[test]
fn wrong_numbers_are_named() {
    let red = Wavelength::from_metres(RED).unwrap();
    let make = |a: f64, b: f64, sigma: f64, width: f64| {
        SchellSource::new(
            red,
            [a, 1.0],
            Complex64::new(b, 0.0),
            sigma,
            [width, 1e-3, 1e-3],
        )
    };
    for (broken, what) in [
        (make(-1.0, 0.0, 1e-2, 1e-3), "amplitude"),
        (make(1.0, 1.1, 1e-2, 1e-3), "|Bxy|"),
        (make(1.0, f64::NAN, 1e-2, 1e-3), "|Bxy|"),
        (make(1.0, 0.0, 0.0, 1e-3), "width"),
        (make(1.0, 0.0, 1e-2, f64::INFINITY), "width"),
    ] {
        let text = broken.unwrap_err().to_string();
        assert!(text.contains(what), "{text}");
    }
}

#[test]
fn the_far_field_of_the_light_is_that_of_the_beam() {
    let source = source(
        [1.0, 0.8],
        Complex64::new(0.1, 0.2),
        1e-3,
        [1e-4, 1.2e-4, 1.3e-4],
    );
    let frame = Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap();
    let distance = 1e5;
    let tilt = 2e-4f64;
    let direction = Vector3::new(tilt, 0.0, (1.0 - tilt * tilt).sqrt());
    let light = source.light(&frame, &direction, distance).unwrap();
    let beam = source
        .stokes(&Vector2::new(tilt * distance, 0.0), distance)
        .unwrap();
    // paraxial against exact: tilt² in the distance, half of it in the cosine, both squared or once; near against far
    // field: (kσℓ/z)² = 1e-10
    let paraxial = 4.0 * tilt * tilt;
    let relative = (light.stokes().stokes - beam).to_vector().norm() / beam.s0();
    assert!(relative < paraxial, "{relative}");
    let widths = light.shape().theta();
    assert!((widths.m11 * 1e-6 - 1.0).abs() < paraxial);
}

#[test]
fn the_coherence_of_the_light_is_that_of_the_beam() {
    // between points that lie on opposite sides of the axis, where the beam has no phase of its own
    let source = source(
        [1.0, 0.8],
        Complex64::new(0.1, 0.2),
        1e-3,
        [1e-4, 1.2e-4, 1.3e-4],
    );
    let frame = Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap();
    let distance = 1e4;
    let light = source.light(&frame, &Vector3::z(), distance).unwrap();
    let space = AstigmaticTransfer::round(&RayTransfer::free_space(distance).unwrap());
    let beam = source.beam().through(&space);
    for half in [
        Vector2::zeros(),
        Vector2::new(0.3, -0.1),
        Vector2::new(0.0, 0.8),
    ] {
        let near = beam.cross_spectral_density(&half, &-half).to_matrix();
        let far = crate::CrossSpectralDensity::of_light(&light, &(2.0 * half)).unwrap();
        // the light keeps its direction: (half/distance)² (kℓ)²/2, and the far field (kσℓ/z)²
        let error = (far.to_matrix() - near).norm() / near.norm();
        assert!(error < 4e-3, "{error}");
    }
}

#[test]
fn light_from_any_distance_is_that_of_the_far_field() {
    // [S0, S1, S2, S3]/S0 has a limit; S0 falls as z⁻²
    let widths = [1e-4, 1.2e-4, 1.3e-4];
    let source = source([1.0, 0.8], Complex64::new(0.1, 0.2), 1e-3, widths);
    let at = |z: f64| source.stokes(&Vector2::zeros(), z).unwrap();
    let far = at(1e10);
    for z in [1e30, 1e100, 1e140] {
        let light = at(z);
        let ratio = light * (1.0 / light.s0()) - far * (1.0 / far.s0());
        assert!(ratio.to_vector().norm() < 1e-14);
        assert!((light.s0() * (z / 1e10).powi(2) / far.s0() - 1.0).abs() < 1e-13);
    }
}
