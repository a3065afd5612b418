//! Beams against the Collins integral, against elements that act point by point, and the laws of both.

use super::*;
use crate::abcd::RayTransfer;
use crate::ensemble::{Element as _, GaussianAperture};
use crate::schell::SchellSource;
use proptest::prelude::*;
use std::f64::consts::PI;

const RED: f64 = 632.8e-9;

fn source(amplitudes: [f64; 2], b: Complex64, sigma: f64, widths: [f64; 3]) -> SchellSource {
    let red = Wavelength::from_metres(RED).unwrap();
    SchellSource::new(red, amplitudes, b, sigma, widths).unwrap()
}

/// The Collins integral of both points by brute force, one axis, as an oracle without moments.
fn collins([sigma, delta]: [f64; 2], system: &RayTransfer, out: [f64; 2]) -> Complex64 {
    let k = 2.0 * PI / RED;

    let points = 1600;
    let reach = 9.0 * sigma;
    let step = 2.0 * reach / f64::from(points);
    let grid: Vec<f64> = (0..=points).map(|i| f64::from(i) * step - reach).collect();
    let kernel = |x: f64, x_out: f64| {
        let phase = system.a() * x * x - 2.0 * x * x_out + system.d() * x_out * x_out;
        Complex64::cis(0.5 * k / system.b() * phase) * (-x * x / (4.0 * sigma * sigma)).exp()
    };
    let first: Vec<_> = grid.iter().map(|x| kernel(*x, out[0])).collect();
    let second: Vec<_> = grid.iter().map(|x| kernel(*x, out[1]).conj()).collect();
    let mut sum = Complex64::new(0.0, 0.0);
    for (x1, f) in grid.iter().zip(&first) {
        for (x2, g) in grid.iter().zip(&second) {
            let d = x1 - x2;
            sum += f * g * (-d * d / (2.0 * delta * delta)).exp();
        }
    }
    sum * step * step * k / (2.0 * PI * system.b().abs())
}

#[test]
fn a_lens_and_free_space_agree_with_the_collins_integral() {
    let (sigma, delta) = (1e-3, 4e-4);
    let source = source([1.0, 1.0], Complex64::new(0.0, 0.0), sigma, [delta; 3]);
    let system = RayTransfer::free_space(3.0).unwrap()
        * RayTransfer::thin_lens(2.0).unwrap()
        * RayTransfer::free_space(1.5).unwrap();
    let beam = source.beam().through(&AstigmaticTransfer::round(&system));
    let centre = collins([sigma, delta], &system, [0.0, 0.0]);
    for (r1, r2) in [(0.0, 0.0), (4e-4, -1e-4), (-8e-4, 3e-4)] {
        let element = |r1: f64, r2: f64| {
            let points = [r1, r2].map(|x| Vector2::new(x, 0.0));
            let csd = beam.cross_spectral_density(&points[0], &points[1]);
            csd.to_matrix()[(0, 0)]
        };
        // the integral is over e^{+ikr}, fields in exp(+iωt) are e^{−ikr}
        let found = element(r1, r2).conj();
        let expected = collins([sigma, delta], &system, [r1, r2]);
        // the y axis contributes the same factor to every point of the x axis
        let on_axis = element(0.0, 0.0);
        let difference = (found / on_axis - expected / centre).norm();
        assert!(difference < 1e-10, "{difference}");
        // and is the root of the value on the axis
        assert!((on_axis.re.sqrt() - centre.re).abs() < 1e-10);
    }
}

#[test]
fn a_screen_of_independent_phases_depolarizes() {
    // fully correlated fields: linear light at 45°
    let source = source(
        [1.0, 1.0],
        Complex64::new(1.0, 0.0),
        1e-3,
        [1e-4, 1e-4, 1e-4],
    );
    let screen = |deviations: [f64; 2], correlation: f64, l: f64| {
        let lengths = CorrelationLengths {
            xx: l,
            yy: l,
            xy: l,
        };
        PhaseScreen::new(deviations, correlation, lengths).unwrap()
    };
    let beam = source.beam();
    let degree = |correlation: f64| {
        let screen = screen([1.0, 1.0], correlation, 1e-3);
        let behind = beam.through_phase_screen(&screen).unwrap();
        behind.stokes(&Vector2::zeros()).degree_of_polarization()
    };
    assert!((degree(0.0) - (-1.0f64).exp()).abs() < 1e-15);
    assert!((degree(1.0) - 1.0).abs() < 1e-15);
    let opposed = beam.through_phase_screen(&screen([4.0, 4.0], -1.0, 1e-5));
    let text = opposed.unwrap_err().to_string();
    assert!(text.contains("anticorrelated"), "{text}");
}

/// A beam without symmetry between x and y, its coherence complex, behind 2 m of free space and a tilted lens.
fn beam_without_symmetry() -> SchellBeam {
    let widths = [1e-4, 2e-4, 1.6e-4];
    let lens = RayTransfer::thin_lens(1.3).unwrap();
    let lens = AstigmaticTransfer::along_axes(&lens, &RayTransfer::identity()).rotated(0.4);
    let space = AstigmaticTransfer::round(&RayTransfer::free_space(2.0).unwrap());
    source([1.0, 0.7], Complex64::new(0.2, 0.1), 1e-3, widths)
        .beam()
        .through(&(lens * space))
}

#[test]
fn a_screen_acts_as_the_same_screen_does_as_an_element() {
    let beam = beam_without_symmetry();
    let lengths = CorrelationLengths {
        xx: 1e-3,
        yy: 1.4e-3,
        xy: 1.3e-3,
    };
    let screen = PhaseScreen::new([0.8, 1.3], 0.6, lengths).unwrap();
    let behind = beam.through_phase_screen(&screen).unwrap();
    let first = Vector2::new(1e-4, -2e-4);
    for step in [0.0, 2e-5, 4e-5, 8e-5] {
        let second = first + Vector2::new(step, -2.0 * step);
        let expected = screen.act_on(
            &beam.cross_spectral_density(&first, &second),
            &first,
            &second,
        );
        let difference =
            behind.cross_spectral_density(&first, &second).to_matrix() - expected.to_matrix();
        // the next term of e^{−d²/l²}: s² (d/l)⁴/2
        let ratio = 5.0 * step * step / (1e-3 * 1e-3);
        let tolerance = 0.5 * 1.3 * 1.3 * ratio * ratio + 1e-14;
        assert!(difference.norm() < tolerance * expected.to_matrix().norm());
    }
}

#[test]
fn a_round_aperture_acts_as_the_same_aperture_does_as_an_element() {
    let beam = beam_without_symmetry();
    let behind = beam.through_aperture([4e-4; 2]).unwrap();
    let aperture = GaussianAperture::new([4e-4; 2]).unwrap();
    let (r1, r2) = (Vector2::new(1e-4, -2e-4), Vector2::new(-5e-5, 3e-4));
    let found = behind.cross_spectral_density(&r1, &r2);
    let expected = aperture.act_on(&beam.cross_spectral_density(&r1, &r2), &r1, &r2);
    let difference = found.to_matrix() - expected.to_matrix();
    assert!(difference.norm() < 1e-14 * expected.to_matrix().norm());
}

#[test]
fn the_matrix_of_a_beam_is_one_of_fields() {
    // positive between any two points, the adjoint when they are exchanged
    let beam = beam_without_symmetry();
    let points = [(3e-4, 1e-4), (-2e-4, 5e-4), (3.1e-4, 1.2e-4)].map(|(x, y)| Vector2::new(x, y));
    for first in &points {
        for second in &points {
            let pair = beam.cross_spectral_density(first, second);
            let [here, there] = [first, second].map(|r| beam.cross_spectral_density(r, r));
            pair.check_pair(&here, &there, 1e-13).unwrap();
            let back = beam.cross_spectral_density(second, first).exchanged();
            assert!((back.to_matrix() - pair.to_matrix()).norm() < 1e-15);
            let difference = here.stokes().unwrap() - beam.stokes(first);
            assert!(difference.to_vector().norm() < 1e-15);
        }
    }
}

#[test]
fn an_aperture_multiplies_the_two_transmittances() {
    let beam = source(
        [1.0, 0.7],
        Complex64::new(0.2, 0.1),
        1e-3,
        [1e-4, 2e-4, 1.6e-4],
    )
    .beam();
    let (wx, wy) = (4e-4, 9e-4);
    let behind = beam.through_aperture([wx, wy]).unwrap();
    let (r1, r2) = (Vector2::new(1e-4, -2e-4), Vector2::new(-5e-5, 3e-4));
    let t = |r: &Vector2<f64>| (-(r.x / wx).powi(2) - (r.y / wy).powi(2)).exp();
    let found = behind.cross_spectral_density(&r1, &r2).to_matrix();
    let before = beam.cross_spectral_density(&r1, &r2).to_matrix();
    let expected = before * Complex64::from(t(&r1) * t(&r2));
    assert!((found - expected).norm() < 1e-14);
    assert!(beam.through_aperture([0.0, 1.0]).is_err());
    let open = beam.through_aperture([f64::INFINITY; 2]).unwrap();
    assert!((open.stokes(&r1) - beam.stokes(&r1)).to_vector().norm() < 1e-15);
}

proptest! {
    #[test]
    fn systems_compose(
        f in prop_oneof![0.2..5.0f64, -5.0..-0.2f64], z in 0.0..4.0f64, angle in 0.0..3.0f64,
    ) {
        let beam = source([1.0, 0.7], Complex64::new(0.2, 0.1), 1e-3, [1e-4, 2e-4, 1.6e-4]).beam();
        let lens = AstigmaticTransfer::along_axes(
            &RayTransfer::thin_lens(f).unwrap(), &RayTransfer::identity(),
        ).rotated(angle);
        let space = AstigmaticTransfer::round(&RayTransfer::free_space(z).unwrap());
        let steps = beam.through(&lens).through(&space).through(&lens);
        let at_once = beam.through(&(lens * space * lens));
        let (first, second) = (Vector2::new(2e-4, -1e-4), Vector2::new(1.7e-4, -1.5e-4));
        let a = steps.cross_spectral_density(&first, &second).to_matrix();
        let b = at_once.cross_spectral_density(&first, &second).to_matrix();
        prop_assert!((a - b).norm() <= 1e-10 * b.norm(), "{}", (a - b).norm() / b.norm());
    }

    #[test]
    fn a_lossless_system_keeps_the_power(f in 0.2..5.0f64, z in 0.0..1e6f64) {
        let beam = source([1.0, 0.7], Complex64::new(0.2, 0.1), 1e-3, [1e-4, 2e-4, 1.6e-4]).beam();
        let system = RayTransfer::free_space(z).unwrap() * RayTransfer::thin_lens(f).unwrap();
        let behind = beam.through(&AstigmaticTransfer::round(&system));
        let power = |beam: &SchellBeam| {
            let [xx, yy, _] = beam.elements.map(|e| e.amplitude.re * e.spread.determinant().sqrt());
            xx + yy
        };
        prop_assert!((power(&behind) / power(&beam) - 1.0).abs() < 1e-12);
    }
}
