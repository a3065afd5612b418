//! Slits: closed forms, the double integral of Lemma 4.3, polarization, energy and signs.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::{CloudeSpectrum, JonesMatrix};
use gauss_quad::GaussLegendre;
use mueller16::{
    AngularSpectrum, Energy, Geometry, IncidentCoherence, LitOpenings, Opening, OpeningError,
    Openings, PointScatterer, PointScatterers, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector, Wavelength,
};

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
    let wave = mueller16::PlaneWave {
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

/// Two slits of these Jones matrices in a plane wave: the Stokes vectors over one fringe.
fn fringes(first: JonesMatrix, second: JonesMatrix, light: StokesVector) -> Vec<StokesVector> {
    let d = 50e-6;
    let with = |x: f64, jones| Opening {
        jones,
        ..slit(x, 1e-6, 1e-5)
    };
    let slits = Openings::new(vec![with(-0.5 * d, first), with(0.5 * d, second)], 1e-9).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    (0..64)
        .map(|i| {
            let phi = Vector2::new(TAU * f64::from(i) / 64.0 / d, 0.0);
            lit.response(&phi) * (1.0 / slit(0.0, 1e-6, 1e-5).fourier(&phi).norm_sqr()) * light
        })
        .collect()
}

/// `(max − min)/2` of each parameter, in units of the intensity of one empty slit.
fn swing(fringes: &[StokesVector]) -> [f64; 4] {
    std::array::from_fn(|l| {
        let values = fringes.iter().map(|s| s.to_array()[l]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        0.5 * (values.fold(f64::NEG_INFINITY, f64::max) - low)
    })
}

#[test]
fn the_four_laws_of_fresnel_and_arago() {
    let horizontal = JonesMatrix::linear_polarizer();
    let vertical = horizontal.rotated(FRAC_PI_2);
    let natural = StokesVector::UNPOLARIZED;
    // 1: light of one polarization interferes as natural light does
    let [s0, ..] = swing(&fringes(horizontal, horizontal, natural));
    assert!((s0 - 1.0).abs() < 1e-13);
    // 2: perpendicular polarizations never make fringes of intensity, whatever the light
    for light in [
        natural,
        StokesVector::DIAGONAL,
        StokesVector::RIGHT_CIRCULAR,
    ] {
        assert!(swing(&fringes(horizontal, vertical, light))[0] < 1e-13);
    }
    // 3: parts of natural light that are brought to one plane afterwards do not, either
    let analyzer = horizontal.rotated(FRAC_PI_2 / 2.0);
    let brought = |light| swing(&fringes(analyzer * horizontal, analyzer * vertical, light));
    assert!(brought(natural)[0] < 1e-13);
    // 4: parts of polarized light do: 2 √(1/4 · 1/4)
    assert!((brought(StokesVector::DIAGONAL)[0] - 0.5).abs() < 1e-13);
    // behind crossed polarizers the fringes are in the polarization: S2 and S3 in quadrature, S0 and S1 at rest
    let crossed = fringes(horizontal, vertical, StokesVector::DIAGONAL);
    let [s0, s1, s2, s3] = swing(&crossed);
    assert!(s0 < 1e-13 && s1 < 1e-13);
    assert!((s2 - 1.0).abs() < 1e-13 && (s3 - 1.0).abs() < 1e-13);
    // the vertical slit is at +d/2: toward +x its way is the shorter, its field ahead, (1, e^(+iδ)): S3 = 2 Im(E_x* E_y)
    let quarter = crossed[16].to_array();
    assert!((quarter[3] - 1.0).abs() < 1e-13 && quarter[2].abs() < 1e-13);
}

/// `∫_{-c}^{c} sin²t/t² dt/π` by parts and the alternating tail of the sine integral's series.
fn inside(c: f64) -> f64 {
    let rule = GaussLegendre::new(40.try_into().unwrap());
    let pieces = c.ceil() as usize;
    let width = c / pieces as f64;
    let mut sum = 0.0;
    for i in 0..pieces {
        for (u, p) in &rule {
            let t = (i as f64 + 0.5 + 0.5 * u) * width;
            sum += 0.5 * width * p * (t.sin() / t).powi(2);
        }
    }
    2.0 * sum / PI
}

#[test]
fn albedo_is_the_open_fraction_less_what_is_evanescent() {
    // 1D: slits of 8, 12 and 15 µm at 550 nm keep .9952
    let slits = [(-20e-6, 8e-6), (0.0, 12e-6), (22e-6, 15e-6)].map(|(x, a)| slit(x, a, 1e-3));
    let slits = Openings::new(slits.to_vec(), 1e-6).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    let rule = GaussLegendre::new(20.try_into().unwrap());
    let (k, pieces) = (TAU / GREEN, 400);
    let width = 2.0 * k / f64::from(pieces);
    let mut sum = 0.0;
    for i in 0..pieces {
        for (u, p) in &rule {
            let phi = Vector2::new(-k + (f64::from(i) + 0.5 + 0.5 * u) * width, 0.0);
            sum += 0.5 * width * p * power(&lit, &phi) / 1e-6;
        }
    }
    let kept = sum / TAU / 35e-6;
    println!("1D: {kept}");
    assert!((kept - 0.9952).abs() < 5e-5);
    // 2D, over the hemisphere: between the square in the circle of propagating waves and the square around it
    let (a, b) = (3e-6, 2e-6);
    let hole = Openings::new(vec![slit(1e-6, a, b)], 4e-11).unwrap();
    let lit = hole.lit_by(&plane).unwrap();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let rows = 48;
    let rule = GaussLegendre::new(24.try_into().unwrap());
    let mut albedo = 0.0;
    for row in 0..rows {
        for (u, p) in &rule {
            // y = sin t, dy = cos t dt; x across the chord the same way
            let t = PI * ((f64::from(row) + 0.5 + 0.5 * u) / f64::from(rows) - 0.5);
            let (y, chord) = t.sin_cos();
            for column in 0..rows {
                for (v, q) in &rule {
                    let s = PI * ((f64::from(column) + 0.5 + 0.5 * v) / f64::from(rows) - 0.5);
                    let (x, z) = (chord * s.sin(), chord * s.cos());
                    let to_observer = Vector3::new(x, y, z);
                    let geometry = Geometry::on_plane(-Vector3::z(), to_observer, green).unwrap();
                    let f = lit.transfer(&geometry).unwrap().element(0, 0);
                    // cos_o dω = dx dy = chord² cos s dt ds... with dy = chord dt, dx = chord cos s ds
                    let cell = (PI / f64::from(rows) * 0.5).powi(2) * p * q;
                    albedo += cell * f * chord * chord * s.cos();
                }
            }
        }
    }
    let half = |size: f64, fraction: f64| inside(0.5 * k * fraction * size);
    let outer = half(a, 1.0) * half(b, 1.0);
    let inner = half(a, 0.5f64.sqrt()) * half(b, 0.5f64.sqrt());
    let fraction = albedo / hole.open_fraction();
    println!("2D: {inner} < {fraction} < {outer}");
    assert!(inner < fraction && fraction < outer);
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

proptest! {
    #[test]
    fn shared_sines_are_those_of_every_wave(
        x in -3e6..3e6f64, y in -3e6..3e6f64, dx in -1.0..1.0f64, dy in -1.0..1.0f64, small in -9.0..1.0f64,
    ) {
        // a wave that nearly cancels the direction: sin(t)/t of small t from sines of large angles
        let phi = Vector2::new(x, y);
        let q = -phi + Vector2::new(dx, dy) * 1e6 * 10f64.powf(small);
        let wave = mueller16::PlaneWave { wave_vector: q, weight: 1.0 };
        let list = AngularSpectrum::of_waves(vec![wave]).unwrap();
        for openings in [polarizing(), Openings::new(vec![slit(-5e-6, 3e-6, 4e-6), slit(4e-6, 2e-6, 6e-6)], 1e-9).unwrap()] {
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
