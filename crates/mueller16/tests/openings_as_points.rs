//! Openings with polarizing elements against points that fill them: light of separate series, two observers, outgoing modes.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::JonesMatrix;
use gauss_quad::GaussLegendre;
use mueller16::{
    AngularSpectrum, Energy, Geometry, IncidentCoherence, Opening, Openings, PointScatterer,
    PointScatterers, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector, Wavelength,
};

const GREEN: f64 = 550e-9;

fn gaussian(v: Matrix2<f64>) -> IncidentCoherence {
    IncidentCoherence::new(v, &HermiteSeries::fundamental(1.0)).unwrap()
}

fn waves(light: &IncidentCoherence, openings: &Openings, tolerance: f64) -> AngularSpectrum {
    let tolerance = Tolerance::relative(tolerance).unwrap();
    AngularSpectrum::of_coherence(light, openings.extent(), tolerance).unwrap()
}

/// Points of Gauss-Legendre rules in every opening, with their weights as areas.
fn points(openings: &Openings, count: usize) -> Vec<(Vector2<f64>, f64, JonesMatrix)> {
    let rule = GaussLegendre::new(count.try_into().unwrap());
    let nodes: Vec<_> = rule.iter().copied().collect();
    let mut points = vec![];
    for o in openings.openings() {
        for (u, p) in &nodes {
            for (v, q) in &nodes {
                let at = o.centre + Vector2::new(0.5 * o.width * u, 0.5 * o.height * v);
                points.push((at, 0.25 * o.area() * p * q, o.jones));
            }
        }
    }
    points
}

/// Three openings with a polarizer, a wave plate and a rotator.
fn polarizing() -> Openings {
    let plate = JonesMatrix::linear_retarder(1.1).rotated(0.4);
    let with = |x: f64, y: f64, jones| Opening {
        jones,
        ..Opening::clear(Vector2::new(x, y), 4e-6, 3e-6)
    };
    let openings = vec![
        with(-9e-6, 0.0, JonesMatrix::linear_polarizer().rotated(0.3)),
        with(0.0, 4e-6, plate.scaled(Complex64::cis(-0.9))),
        with(8e-6, -1e-6, JonesMatrix::rotator(0.7)),
    ];
    Openings::new(openings, 1e-9).unwrap()
}

#[test]
fn polarized_light_of_separate_series_is_scattered_as_by_points() {
    let openings = polarizing();
    let to_source = Vector3::new(0.02, -0.03, 1.0).normalize();
    let to_observer = Vector3::new(-0.05, 0.04, -1.0).normalize();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let geometry = Geometry::on_plane(to_source, to_observer, green).unwrap();
    let series = |real: &[f64]| Some(HermiteSeries::from_real_coefficients(real).unwrap());
    let components = Components::Separate([
        series(&[2.0, 0.1, -0.2, -0.15, 0.05, -0.1]),
        series(&[0.5, 0.3, 0.2]),
        series(&[-0.4]),
        series(&[0.3, -0.2, 0.1, 0.1, 0.0, 0.2]),
    ]);
    let light = GeneralizedStokes::new(
        components,
        ShapeMatrix::from_root(&Matrix2::new(6e-3, 1e-3, -2e-3, 4e-3)).unwrap(),
        Frame::with_x_across(-to_source, Vector3::y()).unwrap(),
        green,
        0.8,
    )
    .unwrap();
    let found = openings
        .scatter(&geometry, &light, Tolerance::relative(1e-12).unwrap())
        .unwrap();
    let scatterers = points(&openings, 8)
        .into_iter()
        .map(|(at, area, jones)| PointScatterer {
            place: at.push(0.0),
            strength: area,
            jones,
        });
    let scatterers = PointScatterers::new(scatterers.collect()).unwrap();
    let outgoing = Frame::with_x_across(to_observer, Vector3::y()).unwrap();
    let field = scatterers
        .scatter(&geometry, &light, Energy::Printed, &outgoing)
        .unwrap();
    // phases of 1.5 rad within an opening: 8 nodes leave 1e-13 of the open area squared over λ²
    let scale = (openings.open_area() / GREEN).powi(2) * light.stokes().stokes.s0();
    let error = (found - field.stokes()).to_vector().amax() / scale;
    println!("Stokes parameters differ by {error:e}");
    assert!(error < 1e-11, "{error:e}");
}

#[test]
fn two_observers_see_the_mutual_response_of_points() {
    let openings = polarizing();
    let root = Matrix2::new(6e4, 1e4, -3e4, 5e4);
    let green = Wavelength::from_metres(GREEN).unwrap();
    let geometry = Geometry::on_plane(-Vector3::z(), Vector3::z(), green).unwrap();
    let stokes = StokesVector::new(1.0, 0.3, -0.5, 0.4);
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes,
        },
        ShapeMatrix::from_root(&(root * GREEN / TAU)).unwrap(),
        Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
        green,
        1.0,
    )
    .unwrap();
    let scatterers = points(&openings, 8)
        .into_iter()
        .map(|(at, area, jones)| PointScatterer {
            place: at.push(0.0),
            strength: area,
            jones,
        });
    let scatterers = PointScatterers::new(scatterers.collect()).unwrap();
    let field = scatterers
        .scatter(&geometry, &light, Energy::Printed, light.frame())
        .unwrap();
    let list = waves(&gaussian(root), &openings, 1e-12);
    let lit = openings.lit_by(&list).unwrap();
    let s = light.stokes().stokes.s0();
    for u in [[0.0, 0.0], [1e5, -2e5], [3e5, 3e5]] {
        let u = Vector2::from(u);
        let mutual = lit.mutual_response(&Vector2::zeros(), &u);
        let found = mutual * stokes.to_vector().map(Complex64::from) * Complex64::from(s);
        for (found, expected) in found.iter().zip(field.at(&u)) {
            let expected = expected * GREEN * GREEN;
            assert!((found - expected).norm() < 1e-11 * s * openings.open_area().powi(2));
        }
    }
    let response = lit.response(&Vector2::new(1e5, 0.0)).to_matrix();
    let mutual = lit.mutual_response(&Vector2::new(1e5, 0.0), &Vector2::zeros());
    assert!((response.map(Complex64::from) - mutual).camax() < 1e-14 * response.amax());
}

#[test]
fn outgoing_modes_of_openings_are_projections_of_their_mutual_response() {
    let openings = polarizing();
    let root = Matrix2::new(6e4, 1e4, -3e4, 5e4);
    let green = Wavelength::from_metres(GREEN).unwrap();
    let to_observer = Vector3::new(0.03, -0.02, 1.0).normalize();
    let geometry = Geometry::on_plane(-Vector3::z(), to_observer, green).unwrap();
    let stokes = StokesVector::new(1.0, 0.3, -0.5, 0.4);
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes,
        },
        ShapeMatrix::from_root(&(root * GREEN / TAU)).unwrap(),
        Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
        green,
        1.0,
    )
    .unwrap();
    let outgoing = Frame::with_x_across(to_observer, Vector3::y()).unwrap();
    let w_root = Matrix2::new(5e-6, 1e-6, -1e-6, 3e-6);
    let shape = ShapeMatrix::from_root(&w_root).unwrap();
    let order = 4;
    // φ_t 4e5 rad/m, the light 5 × 7e4, half of w up to 8/(2.5 µm)
    let reach = [2.3e6; 2];
    let points = openings
        .points(reach, Tolerance::relative(1e-9).unwrap())
        .unwrap();
    let field = points
        .scatter(&geometry, &light, Energy::Printed, &outgoing)
        .unwrap();
    let modes = field.modes(&shape, order).unwrap();
    let list = waves(&gaussian(root), &openings, 1e-11);
    let lit = openings.lit_by(&list).unwrap();
    let projection = geometry.outgoing_projection(&outgoing);
    let inverse = w_root.try_inverse().unwrap();
    let incident = stokes.to_vector().map(Complex64::from);
    let scale = light.stokes().stokes.s0() / (GREEN * GREEN);
    // functions of order 4 end at 8 (to 1e-13); a step of 0.4 has its first alias at a frequency 15.7, midpoints at 3.5 of
    // which leave 12
    let (step, half) = (0.4, 20_i32);
    let mut sums = [[Complex64::ZERO; 15]; 4];
    for p in -half..=half {
        for q in -half..=half {
            let y = Vector2::new(f64::from(p), f64::from(q)) * step;
            let u = projection * inverse * y;
            let c = lit.mutual_response(&geometry.tangential(), &u) * incident;
            for (place, (a, b)) in stokes::modes(order).enumerate() {
                let mode = stokes::hermite(a, y.x) * stokes::hermite(b, y.y) * step * step;
                for l in 0..4 {
                    sums[l][place] += c[l] * (mode * scale);
                }
            }
        }
    }
    let determinant = w_root.determinant().abs().sqrt();
    let size = scale * openings.open_area().powi(2) * PI / determinant;
    let mut worst = 0.0f64;
    for (l, sums) in sums.iter().enumerate() {
        let series = modes.series(l).unwrap();
        for (place, (a, b)) in stokes::modes(order).enumerate() {
            let error = (series.coefficient(a, b) - sums[place] / determinant).norm();
            worst = worst.max(error / size);
        }
    }
    println!(
        "{} points, coefficients differ by {worst:e}",
        points.scatterers().len()
    );
    // twice the fields' 1e-9, and three openings' worth of them at most
    assert!(worst < 6e-9, "{worst:e}");
    assert!(openings.points([1e9; 2], Tolerance::ROUNDING).is_err());
}
