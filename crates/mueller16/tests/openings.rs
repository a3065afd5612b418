//! Slits: closed forms, the double integral of Lemma 4.3, signs, reciprocity and errors.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::{CloudeSpectrum, JonesMatrix};
use gauss_quad::GaussLegendre;
use mueller16::{
    AngularSpectrum, Geometry, IncidentCoherence, LitOpenings, Opening, OpeningError, Openings,
    PlaneWave, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use stokes::{HermiteSeries, Wavelength};

const GREEN: f64 = 550e-9;

fn slit(x: f64, width: f64, height: f64) -> Opening {
    Opening::clear(Vector2::new(x, 0.0), width, height)
}

fn power(lit: &LitOpenings<'_>, phi: &Vector2<f64>) -> f64 {
    lit.response(phi).element(0, 0)
}

fn gaussian(v: Matrix2<f64>) -> IncidentCoherence {
    IncidentCoherence::new(v, &HermiteSeries::fundamental(1.0)).unwrap()
}

fn waves(light: &IncidentCoherence, openings: &Openings, tolerance: f64) -> AngularSpectrum {
    let tolerance = Tolerance::relative(tolerance).unwrap();
    AngularSpectrum::of_coherence(light, openings.extent(), tolerance).unwrap()
}

#[test]
fn equal_slits_make_the_grating_function() {
    let (a, b, d) = (4e-6, 30e-6, 10e-6);
    let count = 7;
    let slits = (0..count).map(|n| slit(f64::from(n) * d, a, b)).collect();
    let slits = Openings::new(slits, 1e-6).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    for i in 0..400 {
        let phi = Vector2::new(3e3 * (f64::from(i) + 0.5), 1e4);
        let sinc = |t: f64| t.sin() / t;
        let one = a * b * sinc(0.5 * phi.x * a) * sinc(0.5 * phi.y * b);
        let lattice = (0.5 * f64::from(count) * phi.x * d).sin() / (0.5 * phi.x * d).sin();
        let expected = (one * lattice).powi(2);
        // relative to the peak (N a b)²: rounding of the phases, of which the closed form loses more near its poles
        let peak = (f64::from(count) * a * b).powi(2);
        let phase = f64::from(count) * phi.x * d;
        let tolerance = 4.0 * f64::EPSILON * (1.0 + phase / (0.5 * phi.x * d).sin().abs());
        let found = power(&lit, &phi);
        assert!(
            (found - expected).abs() < tolerance * peak,
            "{i} {found} {expected}"
        );
    }
}

#[test]
fn touching_openings_are_one_wide_opening() {
    let (a, b, count) = (3e-6, 5e-6, 6);
    let many = (0..count)
        .map(|n| slit((f64::from(n) - 2.5) * a, a, b))
        .collect();
    let many = Openings::new(many, 1e-9).unwrap();
    let one = Openings::new(vec![slit(0.0, f64::from(count) * a, b)], 1e-9).unwrap();
    let light = gaussian(Matrix2::new(2e5, 4e4, -1e5, 3e5));
    let light = waves(&light, &one, 1e-9);
    let (many, one) = (many.lit_by(&light).unwrap(), one.lit_by(&light).unwrap());
    let peak = power(&one, &Vector2::zeros());
    for phi in [[0.0, 0.0], [1e5, 2e5], [-7e5, 1e6], [4e6, -3e6]] {
        let phi = Vector2::from(phi);
        // a sum of six fields instead of one: rounding
        assert!((power(&many, &phi) - power(&one, &phi)).abs() < 1e-14 * peak);
    }
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

#[test]
fn the_average_over_waves_is_the_double_integral_of_the_coherence() {
    let openings = [
        Opening::clear(Vector2::new(-6e-6, 1e-6), 3e-6, 5e-6),
        Opening::clear(Vector2::new(7e-6, -2e-6), 4e-6, 2e-6),
    ];
    let openings = Openings::new(openings.to_vec(), 1e-9).unwrap();
    let series = [1.0, 0.1, -0.2, 0.15, 0.05, -0.1, 0.02, 0.07, -0.04, 0.03];
    let series = HermiteSeries::from_real_coefficients(&series).unwrap();
    let root = Matrix2::new(1.2e5, 0.5e5, -0.3e5, 1.6e5);
    for light in [
        gaussian(root),
        IncidentCoherence::new(root, &series).unwrap(),
    ] {
        let list = waves(&light, &openings, 1e-12);
        let lit = openings.lit_by(&list).unwrap();
        // phases of up to 3 rad within an opening, and a Gaussian of 0.8: 14 nodes leave less than 1e-13
        let points = points(&openings, 14);
        for phi in [[0.0, 0.0], [2.3e5, -1.1e5], [6e5, 8e5]] {
            let phi = Vector2::from(phi);
            let mut sum = Complex64::ZERO;
            for (x1, p1, _) in &points {
                for (x2, p2, _) in &points {
                    let x = x1 - x2;
                    sum += Complex64::cis(-phi.dot(&x)) * light.value(&x) * p1 * p2;
                }
            }
            let area = openings.open_area();
            let error = (power(&lit, &phi) - sum.re) / (area * area);
            println!("{} waves, error {error:e}", list.waves().len());
            assert!(
                error.abs() < 3e-12 && sum.im.abs() < 1e-13 * area * area,
                "{error:e}"
            );
        }
    }
}

#[test]
fn fringes_move_toward_the_delayed_slit() {
    let d = 40e-6;
    let delay = 0.9;
    let plate = JonesMatrix::identity().scaled(Complex64::cis(-delay));
    let second = Opening {
        jones: plate,
        ..slit(0.5 * d, 2e-6, 10e-6)
    };
    let slits = Openings::new(vec![slit(-0.5 * d, 2e-6, 10e-6), second], 1e-9).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    let envelope = |phi: &Vector2<f64>| slit(0.0, 2e-6, 10e-6).fourier(phi).norm_sqr();
    // the delayed slit at +d/2 must have the shorter way: k sin θ d = +delay
    let at = |phase: f64| {
        let phi = Vector2::new(phase / d, 0.0);
        power(&lit, &phi) / envelope(&phi)
    };
    assert!((at(delay) - 4.0).abs() < 1e-13);
    assert!(at(delay + PI) < 1e-13);
    assert!((at(-delay) - 2.0 * (1.0 + (2.0 * delay).cos())).abs() < 1e-13);
}

#[test]
fn light_from_the_right_is_sent_to_the_left() {
    // a source at +x: the bright fringe is straight on, toward −x behind the screen, and so is that of its waves
    let slits = Openings::new(vec![slit(-2e-5, 2e-6, 1e-5), slit(2e-5, 2e-6, 1e-5)], 1e-9).unwrap();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let sin = 2e-3;
    let q = Vector2::new(TAU / GREEN * sin, 0.0);
    let wave = PlaneWave {
        wave_vector: q,
        weight: 1.0,
    };
    let aside = AngularSpectrum::of_waves(vec![wave]).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let to = |x: f64, z: f64| Vector3::new(x, 0.0, z * (1.0 - x * x).sqrt());
    let f = |to_source, light, x| {
        let geometry = Geometry::on_plane(to_source, to(x, -1.0), green).unwrap();
        slits
            .lit_by(light)
            .unwrap()
            .transfer(&geometry)
            .unwrap()
            .element(0, 0)
    };
    let straight = f(Vector3::z(), &plane, 0.0);
    assert!((f(to(sin, 1.0), &plane, -sin) / straight - 1.0).abs() < 1e-12);
    assert!((f(Vector3::z(), &aside, -sin) / straight - 1.0).abs() < 1e-12);
    assert!(f(Vector3::z(), &aside, sin) / straight < 0.99);
}

#[test]
fn reversed_light_meets_the_same_screen() {
    let openings = vec![slit(-5e-6, 3e-6, 4e-6), slit(4e-6, 2e-6, 6e-6)];
    let openings = Openings::new(openings, 1e-9).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = openings.lit_by(&plane).unwrap();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let i = Vector3::new(0.1, 0.2, 0.9).normalize();
    let o = Vector3::new(-0.2, 0.05, -0.8).normalize();
    let there = Geometry::on_plane(i, o, green)
        .unwrap()
        .between(1.0, 1.5)
        .unwrap();
    let f = |g: &Geometry| lit.transfer(g).unwrap().element(0, 0) / g.n_outgoing().powi(2);
    assert!((f(&there) / f(&there.reversed()) - 1.0).abs() < 1e-12);
    // and the list of directions says the same, with its cosines
    let pattern = lit.pattern(&there, &[o, -Vector3::z()]).unwrap();
    let [ci, co] = there.cosines().unwrap();
    let expected = lit.transfer(&there).unwrap().element(0, 0) * (ci * co).abs() * 1e-9;
    assert!((pattern[0].element(0, 0) / expected - 1.0).abs() < 1e-14);
    assert_eq!(pattern.len(), 2);
}

#[test]
fn bad_screens_are_refused_with_their_numbers() {
    let text =
        |openings: Vec<Opening>, area: f64| Openings::new(openings, area).unwrap_err().to_string();
    assert_eq!(text(vec![], 1.0), "openings: none, expected at least one");
    assert_eq!(
        text(vec![slit(0.0, -1.0, 1.0)], 1.0),
        "openings: the width of opening 0 is -1, expected a length between 1e-30 and 1e30 m"
    );
    assert_eq!(
        text(vec![slit(0.0, 2.0, 1.0), slit(1.5, 2.0, 3.0)], 9.0),
        "openings: openings 0 and 1 overlap by 0.5 m × 1 m, expected openings apart or touching"
    );
    assert_eq!(
        text(vec![slit(0.0, 2.0, 1.0)], 1.5),
        "openings: the screen has an area of 1.5 m², expected at least the 2 m² that are open"
    );
    let good = Openings::new(vec![slit(0.0, 1e-5, 1e-5)], 1e-9).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let grazing = Geometry::on_plane(Vector3::z(), Vector3::x(), green).unwrap();
    let error = good.lit_by(&plane).unwrap().transfer(&grazing).unwrap_err();
    assert!(matches!(error, OpeningError::Geometry(_)));
}

/// Two openings with a polarizer and a plate.
fn filled() -> Openings {
    let with = |x: f64, y: f64, jones| Opening {
        jones,
        ..Opening::clear(Vector2::new(x, y), 4e-6, 3e-6)
    };
    let plate = JonesMatrix::linear_retarder(1.1).rotated(0.4);
    let openings = vec![
        with(-9e-6, 0.0, JonesMatrix::linear_polarizer()),
        with(0.0, 4e-6, plate),
    ];
    Openings::new(openings, 1e-9).unwrap()
}

proptest! {
    #[test]
    fn shared_sines_are_those_of_every_wave(
        x in -3e6..3e6f64, y in -3e6..3e6f64, dx in -1.0..1.0f64, dy in -1.0..1.0f64, small in -9.0..1.0f64,
    ) {
        // a wave that nearly cancels the direction: sin(t)/t of small t from sines of large angles
        let phi = Vector2::new(x, y);
        let q = -phi + Vector2::new(dx, dy) * 1e6 * 10f64.powf(small);
        let wave = PlaneWave { wave_vector: q, weight: 1.0 };
        let list = AngularSpectrum::of_waves(vec![wave]).unwrap();
        for openings in [filled(), Openings::new(vec![slit(-5e-6, 3e-6, 4e-6), slit(4e-6, 2e-6, 6e-6)], 1e-9).unwrap()] {
            let found = openings.lit_by(&list).unwrap().response(&phi).to_matrix();
            let expected = openings.jones(&(phi + q)).mueller().to_matrix();
            // angles of up to 3e6 × 10 µm
            let tolerance = 64.0 * f64::EPSILON * 30.0 * openings.open_area().powi(2);
            prop_assert!((found - expected).amax() < tolerance);
        }
    }

    #[test]
    fn what_passes_is_realizable(
        n in prop::array::uniform16(-1.0..1.0f64), v in prop::array::uniform4(-3e5..3e5f64),
        x in -1e6..1e6f64, y in -1e6..1e6f64,
    ) {
        let jones = |n: &[f64]| JonesMatrix::new(
            Complex64::new(n[0], n[1]), Complex64::new(n[2], n[3]),
            Complex64::new(n[4], n[5]), Complex64::new(n[6], n[7]));
        let openings = vec![
            Opening { jones: jones(&n[..8]), ..slit(-5e-6, 3e-6, 4e-6) },
            Opening { jones: jones(&n[8..]), ..slit(4e-6, 2e-6, 6e-6) },
        ];
        let openings = Openings::new(openings, 1e-9).unwrap();
        let list = waves(&gaussian(Matrix2::new(v[0], v[1], v[2], v[3])), &openings, 1e-3);
        let response = openings.lit_by(&list).unwrap().response(&Vector2::new(x, y));
        // negative eigenvalues are rounding of what was added up
        let least = 1e-13 * openings.open_area().powi(2);
        let spectrum = CloudeSpectrum::of(&response).unwrap();
        prop_assert!(spectrum.eigenvalues()[3] >= -least);
    }
}
