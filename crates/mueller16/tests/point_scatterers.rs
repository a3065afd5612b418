//! Lemma 4.3 for points against fields summed by hand and modes projected by quadrature.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::JonesMatrix;
use mueller16::{Energy, Geometry, PointScatterer, PointScatterers};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector, Wavelength,
    hermite,
};

const GREEN: f64 = 550e-9;

/// Numbers without pattern in −1..1.
fn patternless(seed: usize) -> f64 {
    let x = (seed as f64 * 0.754_877_666_246_692_7 + 0.1).fract();
    2.0 * (x * 977.3).fract() - 1.0
}

fn jones(seed: usize) -> JonesMatrix {
    let z = |i: usize| Complex64::new(patternless(seed + 2 * i), patternless(seed + 2 * i + 1));
    JonesMatrix::new(z(0), z(1), z(2), z(3))
}

fn wavelength() -> Wavelength {
    Wavelength::from_metres(GREEN).unwrap()
}

/// Four points in three dimensions, tens of wavelengths apart.
fn four(seed: usize) -> Vec<PointScatterer> {
    (0..4)
        .map(|a| {
            let at = |i| patternless(seed + 100 * a + i);
            PointScatterer {
                place: Vector3::new(20e-6 * at(1), 15e-6 * at(2), 2e-6 * at(3)),
                strength: 1e-12 * (1.0 + 0.5 * at(4)),
                jones: jones(seed + 100 * a + 10),
            }
        })
        .collect()
}

/// An oblique encounter on a tilted surface, and light of separate series in it.
fn encounter() -> (Geometry, GeneralizedStokes, Frame) {
    let to_source = Vector3::new(0.3, -0.2, 0.9).normalize();
    let to_observer = Vector3::new(-0.25, 0.35, 0.8).normalize();
    let normal = Vector3::new(0.1, 0.05, 1.0).normalize();
    let t1 = Vector3::new(1.0, 0.4, 0.0).cross(&normal).normalize();
    let tangents = [t1, normal.cross(&t1)];
    let geometry = Geometry::new(to_source, to_observer, tangents, wavelength()).unwrap();
    let series = |count: usize, seed| {
        let real: Vec<f64> = (0..count).map(|i| patternless(seed + i)).collect();
        Some(HermiteSeries::from_real_coefficients(&real).unwrap())
    };
    let components = Components::Separate([series(10, 1), series(6, 40), None, series(3, 80)]);
    let frame = Frame::with_x_across(-to_source, Vector3::new(0.2, 1.0, 0.3)).unwrap();
    let root = Matrix2::new(3e-3, 1e-3, -0.5e-3, 2e-3);
    let shape = ShapeMatrix::from_root(&root).unwrap();
    let light = GeneralizedStokes::new(components, shape, frame, wavelength(), 0.7).unwrap();
    let outgoing = Frame::with_x_across(to_observer, Vector3::new(-0.3, 0.9, 0.1)).unwrap();
    (geometry, light, outgoing)
}

/// `C_j(x)` of the light, one Hermite-Gauss function after the other.
fn incident(light: &GeneralizedStokes, j: usize, x: &Vector3<f64>) -> Complex64 {
    let Some(series) = light.components().series(j) else {
        return Complex64::ZERO;
    };
    let (frame, s) = (light.frame(), light.distance());
    let w = Vector2::new(frame.x().dot(x), frame.y().dot(x)) * (TAU / GREEN / s);
    let y = light.shape().root() * w;
    let mut sum = Complex64::ZERO;
    for (a, b) in stokes::modes(series.order()) {
        sum += series.coefficient(a, b) * hermite(a, y.x) * hermite(b, y.y);
    }
    sum * light.shape().root().determinant().abs().sqrt() / (s * s)
}

fn sigma() -> [Matrix2<Complex64>; 4] {
    let (o, i, z) = (Complex64::ONE, Complex64::I, Complex64::ZERO);
    [
        Matrix2::new(o, z, z, o),
        Matrix2::new(o, z, z, -o),
        Matrix2::new(z, o, o, z),
        Matrix2::new(z, -i, i, z),
    ]
}

/// `r² C_l = tr(σ_l ⟨E(2) E(1)†⟩)`, the fields of every scatterer with its own phase.
fn by_fields(
    points: &[PointScatterer],
    geometry: &Geometry,
    light: &GeneralizedStokes,
    outgoing: &Frame,
    w: &Vector2<f64>,
) -> [Complex64; 4] {
    let [t1, t2] = geometry.tangents();
    let world = |p: &Vector3<f64>| t1 * p.x + t2 * p.y + geometry.normal() * p.z;
    let k = TAU / GREEN;
    let phi = (geometry.to_source() + geometry.to_observer()) * k;
    let half = (outgoing.x() * w.x + outgoing.y() * w.y) * 0.5;
    let mut total = Matrix2::zeros();
    for a in points {
        for b in points {
            let (x1, x2) = (world(&a.place), world(&b.place));
            let matrix: Matrix2<Complex64> = (0..4)
                .map(|j| sigma()[j] * (incident(light, j, &(x1 - x2)) * 0.5))
                .sum();
            let phase = Complex64::cis(-(phi + half).dot(&x1) + (phi - half).dot(&x2));
            total += b.jones.to_matrix()
                * matrix
                * a.jones.to_matrix().adjoint()
                * (phase * a.strength * b.strength / (GREEN * GREEN));
        }
    }
    sigma().map(|s| (s * total).trace())
}

#[test]
fn the_far_field_is_the_sum_of_the_fields() {
    let (geometry, light, outgoing) = encounter();
    for seed in [0, 1000, 2000] {
        let points = four(seed);
        let set = PointScatterers::new(points.clone()).unwrap();
        let field = set
            .scatter(&geometry, &light, Energy::Printed, &outgoing)
            .unwrap();
        let scale = field.stokes().s0().abs();
        for w in [[0.0, 0.0], [3e4, -2e4], [-8e4, 5e4], [2e5, 1e5]] {
            let w = Vector2::from(w);
            let expected = by_fields(&points, &geometry, &light, &outgoing, &w);
            for (found, expected) in field.at(&w).into_iter().zip(expected) {
                // phases of k·50 µm = 600 rad are known to 1e-13
                assert!(
                    (found - expected).norm() < 2e-12 * scale,
                    "{found} {expected}"
                );
            }
        }
    }
}

#[test]
fn coefficients_are_projections_of_the_exact_far_field() {
    let (geometry, light, outgoing) = encounter();
    let order = 6;
    for seed in [0, 1000] {
        let points = four(seed);
        let set = PointScatterers::new(points.clone()).unwrap();
        let field = set
            .scatter(&geometry, &light, Energy::Printed, &outgoing)
            .unwrap();
        let root = Matrix2::new(9e-6, 4e-6, -2e-6, 11e-6);
        let shape = ShapeMatrix::from_root(&root).unwrap();
        let modes = field.modes(&shape, order).unwrap();
        // ⟨C|φ_ab⟩ = √|det W|⁻¹ ∫ C(W⁻¹y) h_a h_b d²y: beyond 12 the functions are below 1e-17, and a step of 0.25
        // has its first alias at a frequency 25 − 4 (of the midpoints), where their transforms are, too
        let (step, half) = (0.25, 48_i32);
        let inverse = root.try_inverse().unwrap();
        let determinant = root.determinant().abs();
        let mut sums = [[Complex64::ZERO; 28]; 4];
        let mut scale = 0.0f64;
        for p in -half..=half {
            for q in -half..=half {
                let y = Vector2::new(f64::from(p), f64::from(q)) * step;
                let c = by_fields(&points, &geometry, &light, &outgoing, &(inverse * y));
                scale = scale.max(c[0].norm());
                for (place, (a, b)) in stokes::modes(order).enumerate() {
                    let mode = hermite(a, y.x) * hermite(b, y.y) * step * step;
                    for l in 0..4 {
                        sums[l][place] += c[l] * mode / determinant.sqrt();
                    }
                }
            }
        }
        let scale = scale / determinant.sqrt();
        let mut worst = 0.0f64;
        for (l, sums) in sums.iter().enumerate() {
            let series = modes.series(l).unwrap();
            for (place, (a, b)) in stokes::modes(order).enumerate() {
                worst = worst.max((series.coefficient(a, b) - sums[place]).norm() / scale);
            }
        }
        println!("largest error of a coefficient {worst:e}");
        // the phases are known to 1e-13, the sum of 9409 values adds its rounding
        assert!(worst < 1e-12, "{worst:e}");
    }
}

#[test]
fn a_raised_point_has_the_phase_of_its_path() {
    // two points on the normal, 3 µm apart: true paths to a source and an observer 100 m away
    let (to_source, to_observer) = (
        Vector3::new(0.5, 0.2, 0.8).normalize(),
        Vector3::new(-0.3, 0.1, 0.9).normalize(),
    );
    let geometry = Geometry::on_plane(to_source, to_observer, wavelength()).unwrap();
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes: StokesVector::UNPOLARIZED,
        },
        ShapeMatrix::isotropic(1e6).unwrap(),
        Frame::with_x_across(-to_source, Vector3::y()).unwrap(),
        wavelength(),
        100.0,
    )
    .unwrap();
    let outgoing = Frame::with_x_across(to_observer, Vector3::y()).unwrap();
    let heights = [0.0, 3e-6];
    let delay = 0.8;
    let point = |(h, delay): (f64, f64)| PointScatterer {
        place: Vector3::new(0.0, 0.0, h),
        strength: 1e-12,
        jones: JonesMatrix::identity().scaled(Complex64::cis(-delay)),
    };
    let set =
        PointScatterers::new(vec![point((heights[0], 0.0)), point((heights[1], delay))]).unwrap();
    let seen = set
        .scatter(&geometry, &light, Energy::Printed, &outgoing)
        .unwrap();
    let alone = PointScatterers::new(vec![point((0.0, 0.0))]).unwrap();
    let alone = alone
        .scatter(&geometry, &light, Energy::Printed, &outgoing)
        .unwrap();
    let path = |h: f64| {
        let at = Vector3::new(0.0, 0.0, h);
        (to_source * 100.0 - at).norm() + (to_observer * 100.0 - at).norm()
    };
    // the raised one has the shorter path and a plate that delays
    let phase = TAU / GREEN * (path(heights[1]) - path(heights[0])) + delay;
    let expected = 2.0 + 2.0 * phase.cos();
    // ways of 100 m are known to 1e-14 m, 2e-7 rad; their curvature over 3 µm is k h²/r = 1e-6 rad
    assert!((seen.stokes().s0() / alone.stokes().s0() - expected).abs() < 3e-6);
}

#[test]
fn lemma_4_4_is_the_curvature_of_the_far_field() {
    let (geometry, light, outgoing) = encounter();
    let set = PointScatterers::new(four(3000)).unwrap();
    let field = set
        .scatter(&geometry, &light, Energy::Printed, &outgoing)
        .unwrap();
    let log = |x: f64, y: f64| field.at(&Vector2::new(x, y))[0].norm().ln();
    let h = 200.0;
    let second = |dx: f64, dy: f64| {
        (log(h * dx, h * dy) - 2.0 * log(0.0, 0.0) + log(-h * dx, -h * dy)) / (h * h)
    };
    let across = 0.5 * (second(1.0, 1.0) - second(1.0, 0.0) - second(0.0, 1.0));
    let expected = -Matrix2::new(second(1.0, 0.0), across, across, second(0.0, 1.0));
    let shape = field.shape().unwrap();
    // differences: rounding 4ε/h² = 2e-20 m², fourth derivative h² x⁴ = 4e-15·Cov... of 1e-10 m²
    assert!((shape.covariance() - expected).amax() < 1e-4 * expected.amax());
}

#[test]
fn bad_scatterers_are_refused_with_their_numbers() {
    let error = PointScatterers::new(vec![]).unwrap_err();
    assert_eq!(error.to_string(), "scatterers: none, expected at least one");
    let mut points = four(0);
    points[2].strength = f64::NAN;
    let error = PointScatterers::new(points).unwrap_err().to_string();
    assert_eq!(
        error,
        "scatterers: the strength of scatterer 2 is NaN, expected a number of at most 1e30"
    );
}

proptest! {
    #[test]
    fn scattered_light_is_physical_where_the_incident_light_is(
        seed in 0usize..100_000, p in 0.0..1.0f64, psi in 0.0..PI, chi in -0.7..0.7f64, width in 1e-5..1e-1f64,
    ) {
        let (geometry, light, outgoing) = encounter();
        let (s2, c2) = (2.0 * psi).sin_cos();
        let (s3, cc) = (2.0f64 * chi).sin_cos();
        let stokes = StokesVector::new(1.0, p * c2 * cc, p * s2 * cc, p * s3);
        let light = GeneralizedStokes::new(
            Components::Shared { modes: HermiteSeries::fundamental(1.0), stokes },
            ShapeMatrix::isotropic(1.0 / (width * width)).unwrap(),
            *light.frame(),
            wavelength(),
            0.7,
        ).unwrap();
        let set = PointScatterers::new(four(seed)).unwrap();
        let out = set.scatter(&geometry, &light, Energy::default(), &outgoing).unwrap().stokes();
        // destructive interference leaves the rounding of what interfered
        let sum: f64 = set.scatterers().iter()
            .map(|s| s.strength * s.jones.to_matrix().norm()).sum::<f64>() / GREEN;
        let s00 = light.stokes().stokes.s0();
        let rest = out.to_vector().fixed_rows::<3>(1).norm();
        prop_assert!(rest - out.s0() <= 1e-12 * sum * sum * s00);
    }
}
