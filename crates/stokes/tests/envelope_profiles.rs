//! Claim: transforms, moments and patches of profiles are those of the profiles' own values.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Envelope, EnvelopeError, Frame, GaussianPeak, MAX_PATCHES, Patches, surface_projection,
};

fn covariance() -> impl Strategy<Value = Matrix2<f64>> {
    // condition numbers up to 1e6
    (0.2..2.0f64, prop_oneof![0.1..1.0f64, Just(1e-3)], 0.0..PI).prop_map(|(long, ratio, angle)| {
        let (sin, cos) = angle.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let m =
            turn * Matrix2::new(long * long, 0.0, 0.0, (long * ratio).powi(2)) * turn.transpose();
        Matrix2::new(m.m11, m.m12, m.m12, m.m22)
    })
}

fn gaussians() -> impl Strategy<Value = Envelope> {
    prop::collection::vec(
        (0.1..2.0f64, -1.0..1.0f64, -1.0..1.0f64, covariance()),
        1..4,
    )
    .prop_map(|peaks| {
        let peak = |(peak, x, y, covariance)| GaussianPeak {
            peak,
            centre: Vector2::new(x, y),
            covariance,
        };
        Envelope::mixture(&peaks.into_iter().map(peak).collect::<Vec<_>>()).unwrap()
    })
}

fn grids() -> impl Strategy<Value = Envelope> {
    (
        prop::collection::vec(prop_oneof![0.0..1.0f64, Just(0.0)], 12),
        prop::array::uniform2(0.1..1.0f64),
        prop::array::uniform2(-2.0..2.0f64),
    )
        .prop_filter_map("a dark grid", |(samples, pixel, centre)| {
            Envelope::sampled(samples, 4, pixel, centre.into()).ok()
        })
}

fn hard_edged() -> impl Strategy<Value = Envelope> {
    prop_oneof![
        (0.1..2.0f64, prop_oneof![0.1..2.0f64, Just(1e-5)])
            .prop_map(|(x, y)| Envelope::rectangle(x, y).unwrap()),
        (0.1..2.0f64).prop_map(|radius| Envelope::disk(radius).unwrap()),
        grids(),
    ]
}

fn profiles() -> impl Strategy<Value = Envelope> {
    prop_oneof![hard_edged(), gaussians()]
}

/// Sum of weights, mean and covariance of the patches.
fn moments(patches: &Patches) -> (f64, Vector2<f64>, Matrix2<f64>) {
    let list = patches.patches();
    let weight: f64 = list.iter().map(|patch| patch.weight).sum();
    let mean = list
        .iter()
        .map(|patch| patch.centre * patch.weight)
        .sum::<Vector2<f64>>()
        / weight;
    let spread = list
        .iter()
        .map(|patch| {
            let d = patch.centre - mean;
            (patch.covariance + d * d.transpose()) * patch.weight
        })
        .sum::<Matrix2<f64>>()
        / weight;
    (weight, mean, spread)
}

proptest! {
    #[test]
    fn the_transform_starts_with_the_moments(envelope in profiles(), angle in 0.0..PI) {
        // f(u) = area (1 − i u·m − u(C + mm)u/2 + O(u³)); Richardson from steps h and 2h leaves O(h⁴)
        let direction = Vector2::new(angle.cos(), angle.sin());
        let h = 1e-3;
        let f = |t: f64| envelope.fourier(&(direction * t)) / envelope.area();
        let mean = envelope.centroid().dot(&direction);
        let second = direction.dot(&(envelope.covariance() * direction)) + mean * mean;
        let odd = |t: f64| -f(t).im / t;
        let even = |t: f64| (1.0 - f(t).re) * 2.0 / (t * t);
        // moments of order 4 and 6 of places up to 5 m
        prop_assert!(((4.0 * odd(h) - odd(2.0 * h)) / 3.0 - mean).abs() < 1e-9);
        prop_assert!(((4.0 * even(h) - even(2.0 * h)) / 3.0 - second).abs() < 4e-9 + 64.0 * f64::EPSILON / (h * h));
    }

    #[test]
    fn the_far_field_is_the_transform_about_the_centroid(
        envelope in profiles(), p in prop::array::uniform4(-1.0..1.0f64), w in prop::array::uniform2(-3.0..3.0f64),
    ) {
        let projection = Matrix2::from_row_slice(&p);
        let w = Vector2::from(w);
        let f = envelope.far_field(&projection, &w);
        prop_assert!((envelope.far_field(&projection, &Vector2::zeros()) - envelope.area()).norm() <= 8.0 * f64::EPSILON * envelope.area());
        // of a positive function
        prop_assert!(f.norm() <= envelope.area() * (1.0 + 8.0 * f64::EPSILON));
        // no phase of first order is left
        let small = envelope.far_field(&projection, &(w * 1e-6)) / envelope.area();
        prop_assert!(small.im.abs() < 1e-14);
    }

    #[test]
    fn the_shape_is_the_curvature_of_the_far_field(envelope in hard_edged(), p in prop::array::uniform3(0.3..1.0f64)) {
        let projection = Matrix2::new(p[0], 0.2, -0.1, p[1]);
        let shape = envelope.shape(&projection).unwrap();
        // −d² ln|f| along a direction, in units of the shape's own width
        let y = Vector2::new(p[2].cos(), p[2].sin());
        let w = shape.unwhiten(&y);
        let log = |t: f64| (envelope.far_field(&projection, &(w * t)) / envelope.area()).norm().ln();
        let h = 2e-3;
        let curvature = |h: f64| -2.0 * log(h) / (h * h);
        // Richardson leaves the sixth cumulant times 4h⁴/90; a faint cell far out makes it 1e4 at most
        let found = (4.0 * curvature(h) - curvature(2.0 * h)) / 3.0;
        prop_assert!((found - 1.0).abs() < 1e-6, "{found}");
        let expected = projection.transpose() * envelope.covariance() * projection;
        prop_assert!((shape.covariance() - expected).amax() < 16.0 * f64::EPSILON * expected.amax());
    }

    #[test]
    fn patches_keep_the_first_moments(envelope in profiles(), across in prop::array::uniform2(0usize..9)) {
        let patches = envelope.patches(across).unwrap();
        let (weight, mean, spread) = moments(&patches);
        let expected = envelope.covariance();
        let scale = expected.amax() + envelope.centroid().norm_squared();
        prop_assert!((weight / envelope.area() - 1.0).abs() < 64.0 * f64::EPSILON);
        prop_assert!((mean - envelope.centroid()).norm() < 64.0 * f64::EPSILON * scale.sqrt());
        prop_assert!((spread - expected).amax() < 64.0 * f64::EPSILON * scale);
        for patch in patches.patches() {
            prop_assert!(patch.weight > 0.0);
            prop_assert!(patch.covariance.m11 > 0.0 && patch.covariance.determinant() > 0.0);
        }
    }

    #[test]
    fn no_place_is_worse_than_the_error(
        envelope in hard_edged(), across in prop::array::uniform2(1usize..5),
        lobe in 0.3..0.6f64, place in prop::array::uniform2(-1.0..1.0f64),
    ) {
        let patches = envelope.patches(across).unwrap();
        let error = patches.error(lobe).unwrap();
        let place = envelope.centroid() + Vector2::from(place);
        let exact = blurred(&envelope, lobe, &place);
        let found: f64 = patches.patches().iter().map(|patch| {
            let sum = patch.covariance + Matrix2::from_diagonal_element(lobe * lobe);
            let d = place - patch.centre;
            let exponent = d.dot(&(sum.try_inverse().unwrap() * d));
            patch.weight * (-0.5 * exponent).exp() / (2.0 * PI * sum.determinant().sqrt())
        }).sum();
        // the peak of the blurred profile is below both of these
        let peak = (envelope.area() / (2.0 * PI * lobe * lobe)).min(1.0);
        prop_assert!((exact - found).abs() <= 1.02 * error * peak + 1e-12);
    }
}

/// The profile against a normalised Gaussian, by the transforms of both.
fn blurred(envelope: &Envelope, lobe: f64, place: &Vector2<f64>) -> f64 {
    // ∫ I g = (2π)⁻² ∫ F{I}(u) e^{−σ²u²/2} e^{iu·x} d²u: a step of 1/2 repeats the profile every 12.6 m
    let step = 0.5;
    let count = (8.0 / lobe / step).ceil() as i32;
    let mut sum = Complex64::ZERO;
    for i in -count..=count {
        for j in -count..=count {
            let u = Vector2::new(f64::from(i), f64::from(j)) * step;
            let weight = (-0.5 * lobe * lobe * u.norm_squared()).exp();
            sum += envelope.fourier(&u) * Complex64::cis(u.dot(place)) * weight;
        }
    }
    sum.re * (step / (2.0 * PI)).powi(2)
}

#[test]
fn a_slit_is_told_from_its_patches_as_in_one_dimension() {
    let slit = Envelope::rectangle(1.0, 1e-4).unwrap();
    let normal =
        |x: f64, sigma: f64| (-0.5 * (x / sigma).powi(2)).exp() / sigma / (2.0 * PI).sqrt();
    // by the way: 15 %, 2 %, 2e-4, 8e-7 at 0.4 half-widths
    for (count, lobe) in [
        (1u32, 0.4),
        (2, 0.4),
        (5, 0.4),
        (20, 0.4),
        (1, 1.3),
        (3, 0.1),
    ] {
        let half = 1.0 / f64::from(count);
        let sigma = f64::hypot(lobe, half / 3f64.sqrt());
        let edge = |t: f64| 0.5 * libm::erf(t / lobe / 2f64.sqrt());
        let (mut most, mut peak): (f64, f64) = (0.0, 0.0);
        for i in 0..20_000 {
            let x = f64::from(i) * 3e-4;
            let exact = edge(1.0 - x) + edge(1.0 + x);
            let centre = |i: u32| f64::from(2 * i + 1) * half - 1.0;
            let sum: f64 = (0..count)
                .map(|i| 2.0 * half * normal(x - centre(i), sigma))
                .sum();
            most = most.max((exact - sum).abs());
            peak = peak.max(exact);
        }
        let found = slit
            .patches([count as usize, 1])
            .unwrap()
            .error(lobe)
            .unwrap();
        // the climb ends within a percent of the top
        assert!(
            (found / (most / peak) - 1.0).abs() < 1e-2,
            "{count}: {found} {}",
            most / peak
        );
    }
}

#[test]
fn patches_half_as_wide_as_the_lobe_are_good_to_a_thousandth() {
    for envelope in [
        Envelope::rectangle(1.0, 1.0).unwrap(),
        Envelope::disk(1.0).unwrap(),
    ] {
        for across in [1usize, 3, 5, 15] {
            let lobe = 2.0 / across as f64;
            let error = envelope.patches([across; 2]).unwrap().error(lobe).unwrap();
            // for the disk's middle patch, √3 times as wide as the others, and two axes at once
            assert!(error < 4e-3, "{across}: {error}");
        }
    }
    let slit = Envelope::rectangle(1.0, 1e-3).unwrap();
    assert!(slit.patches([15, 1]).unwrap().error(2.0 / 15.0).unwrap() < 1.03e-3);
}

#[test]
fn as_many_patches_are_made_as_the_tolerance_asks() {
    let grid = Envelope::sampled(
        vec![1.0, 0.2, 0.0, 0.5, 0.9, 0.3],
        3,
        [0.5, 0.6],
        Vector2::new(1.0, 2.0),
    )
    .unwrap();
    for envelope in [
        Envelope::rectangle(1.0, 0.3).unwrap(),
        Envelope::disk(0.8).unwrap(),
        grid,
    ] {
        let mut before = 0;
        for (lobe, tolerance) in [(2.0, 1e-2), (0.3, 1e-2), (0.3, 1e-4), (0.1, 1e-4)] {
            let patches = envelope.patches_for(lobe, tolerance).unwrap();
            assert!(patches.error(lobe).unwrap() <= tolerance);
            assert!(patches.patches().len() >= before);
            before = patches.patches().len();
        }
        let refused = envelope.patches_for(1e-4, 1e-6);
        assert!(
            matches!(refused, Err(EnvelopeError::LobeTooNarrow { needed, most: MAX_PATCHES, .. }) if needed > 65_536.0)
        );
        assert!(matches!(
            envelope.patches_for(0.0, 1e-3),
            Err(EnvelopeError::Length { .. })
        ));
        assert!(matches!(
            envelope.patches_for(1.0, f64::NAN),
            Err(EnvelopeError::NotAMeasure { .. })
        ));
    }
    let disk = Envelope::disk(1.0).unwrap();
    assert_eq!(disk.patches([5, 1]).unwrap().patches().len(), 19);
    assert!(matches!(
        disk.patches([1000, 1]),
        Err(EnvelopeError::TooManyPatches { .. })
    ));
    assert_eq!(
        disk.patches_for(1e-4, 1e-3).unwrap_err().to_string(),
        "envelope: 300030001 patches for a lobe of standard deviation 0.0001 m and a tolerance of 0.001, expected at \
         most 65536; a lobe this narrow resolves the source: sample its points instead"
    );
}

#[test]
fn a_row_of_gaussians_is_as_far_from_a_box_as_in_one_dimension() {
    let error = |count: usize| {
        Envelope::rectangle(1.0, 1.0)
            .unwrap()
            .patches([count, 1])
            .unwrap()
            .far_field_error()
    };
    // across the other axis one Gaussian: ∫I² = 2·2, ∫I I_p = ab, ∫I_p² = cd factorise
    let (one_cross, one_square) = {
        // erf(√(3/2)) of the Gaussian's weight is inside, and ∫g² = √3/(2√π) per unit half-width and weight 2
        let inside = libm::erf(1.5f64.sqrt());
        (2.0 * inside, 4.0 * 3f64.sqrt() / (2.0 * PI.sqrt()))
    };
    for count in [1, 3, 5, 9] {
        let width = 1.0 / count as f64;
        let sigma = width / 3f64.sqrt();
        let centres: Vec<f64> = (0..count)
            .map(|i| -1.0 + (2 * i + 1) as f64 * width)
            .collect();
        let weight = 2.0 * width;
        let edge = |t: f64| 0.5 * libm::erf(t / sigma / 2f64.sqrt());
        let cross: f64 = centres
            .iter()
            .map(|c| weight * (edge(1.0 - c) - edge(-1.0 - c)))
            .sum();
        let square: f64 = centres
            .iter()
            .flat_map(|a| centres.iter().map(move |b| (a - b) / sigma))
            .map(|d| weight * weight * (-0.25 * d * d).exp() / (2.0 * sigma * PI.sqrt()))
            .sum();
        let together = ((4.0 - 2.0 * cross * one_cross + square * one_square) / 4.0).sqrt();
        let found = error(count);
        assert!(
            (found - together).abs() < 1e-13,
            "{count}: {found} {together}"
        );
    }
}

#[test]
fn the_far_field_of_patches_differs_by_what_is_said() {
    let grid = Envelope::sampled(
        vec![1.0, 0.2, 0.0, 0.5, 0.9, 0.3],
        3,
        [0.5, 0.6],
        Vector2::new(1.0, 2.0),
    )
    .unwrap();
    for (envelope, across) in [(Envelope::disk(0.9).unwrap(), [3, 3]), (grid, [2, 1])] {
        let patches = envelope.patches(across).unwrap();
        // the profile's plane by the midpoint rule: an edge costs one cell in a thousand
        let (mut lost, mut whole) = (0.0, 0.0);
        let step = 5e-3;
        for i in -600..600 {
            for j in -600..600 {
                let place = envelope.centroid()
                    + Vector2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) * step;
                let exact = envelope.value(&place);
                let found: f64 = patches
                    .patches()
                    .iter()
                    .map(|patch| {
                        let d = place - patch.centre;
                        let exponent = d.dot(&(patch.covariance.try_inverse().unwrap() * d));
                        patch.weight * (-0.5 * exponent).exp()
                            / (2.0 * PI * patch.covariance.determinant().sqrt())
                    })
                    .sum();
                lost += (exact - found).powi(2);
                whole += exact * exact;
            }
        }
        let expected = (lost / whole).sqrt();
        let found = patches.far_field_error();
        assert!((found / expected - 1.0).abs() < 1e-2, "{found} {expected}");
    }
}

#[test]
fn a_disk_diffracts_as_airy_found() {
    // first dark ring at u R = 3.8317, and 0.2 % around it
    let disk = Envelope::disk(2.0).unwrap();
    assert!(
        disk.fourier(&Vector2::new(3.831_705_970_207_512 / 2.0, 0.0))
            .norm()
            < 1e-14
    );
    let slit = Envelope::rectangle(0.5, 3.0).unwrap();
    assert!(slit.fourier(&Vector2::new(0.0, PI / 3.0)).norm() < 1e-15);
    // no cancellation where sin z/z is 1
    for u in [0.0, 1e-300, 1e-160, 1e-9] {
        let u = Vector2::new(u, u);
        assert!((slit.fourier(&u).re / slit.area() - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((disk.fourier(&u).re / disk.area() - 1.0).abs() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn a_source_to_the_right_advances_its_phase_to_the_right() {
    // e^{−iu·m}: at u > 0 a source at +m has a negative phase
    let peak = |x: f64| GaussianPeak {
        peak: 1.0,
        centre: Vector2::new(x, 0.0),
        covariance: Matrix2::identity(),
    };
    let u = Vector2::new(0.1, 0.0);
    let right = Envelope::mixture(&[peak(2.0)]).unwrap();
    assert!((right.fourier(&u).arg() + 0.2).abs() < 1e-15);
    let pixel = Envelope::sampled(vec![0.0, 0.0, 1.0], 3, [2.0, 1.0], Vector2::zeros()).unwrap();
    assert!((pixel.fourier(&u).arg() + 0.2).abs() < 1e-15);
    assert_eq!(pixel.value(&Vector2::new(2.9, -0.4)), 1.0);
    assert_eq!(pixel.value(&Vector2::new(-2.9, -0.4)), 0.0);
}

#[test]
fn a_tilted_plane_is_foreshortened() {
    let angle = 1.0f64;
    let frame =
        Frame::with_x_along(Vector3::new(0.0, angle.sin(), angle.cos()), Vector3::x()).unwrap();
    let projection = surface_projection(&[Vector3::x(), Vector3::y()], &frame);
    let expected = Matrix2::new(1.0, 0.0, 0.0, angle.cos());
    assert!((projection - expected).amax() < 4.0 * f64::EPSILON);
}

#[test]
fn impossible_profiles_are_refused() {
    let refused = [
        (
            Envelope::rectangle(-1.0, 1.0),
            "envelope: the half-width along x is -1, expected a length from 1e-70 to 1e70",
        ),
        (
            Envelope::disk(f64::NAN),
            "envelope: the radius is NaN, expected a length from 1e-70 to 1e70",
        ),
        (
            Envelope::mixture(&[]),
            "envelope: the profile is dark everywhere, expected a positive intensity somewhere",
        ),
        (
            Envelope::sampled(vec![0.0, -1.0], 2, [1.0; 2], Vector2::zeros()),
            "envelope: sample (1, 0) is -1, expected 0 to 1e100: an intensity is not negative",
        ),
        (
            Envelope::sampled(vec![0.0; 5], 2, [1.0; 2], Vector2::zeros()),
            "envelope: found 5 samples, expected 2 × 2, at least one",
        ),
        (
            Envelope::sampled(vec![1.0], 0, [1.0; 2], Vector2::zeros()),
            "envelope: found 1 samples, expected 0 × 0, at least one",
        ),
    ];
    for (result, message) in refused {
        assert_eq!(result.unwrap_err().to_string(), message);
    }
    let line = Envelope::gaussian(&Matrix2::new(1.0, 1.0, 1.0, 1.0));
    assert!(matches!(line, Err(EnvelopeError::Shape(_))));
    assert!(Envelope::sampled(vec![0.0; 4], 2, [1.0; 2], Vector2::zeros()).is_err());
}
