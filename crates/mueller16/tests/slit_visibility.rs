//! Visibility of two slits against the degree of coherence of the light, source by source.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::JonesMatrix;
use mueller16::{
    AngularSpectrum, IncidentCoherence, Opening, Openings, Tolerance, fringe_visibility,
};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};
use stokes::{Envelope, HermiteSeries, ModeWidth, StokesVector};

/// Between the middles of the slits, m.
const APART: f64 = 1e-4;

fn slits(widths: [f64; 2]) -> Openings {
    let [a, b] = widths;
    let at = |x: f64, width: f64| Opening::clear(Vector2::new(x, 0.0), width, 1e-6);
    Openings::new(vec![at(-0.5 * APART, a), at(0.5 * APART, b)], 1e-6).unwrap()
}

/// Visibility of two slits of one width from their pattern at a crest and a trough, under the envelope of one.
fn measured(width: f64, light: &AngularSpectrum) -> f64 {
    let two = slits([width; 2]);
    let one = Openings::new(vec![Opening::clear(Vector2::zeros(), width, 1e-6)], 1e-6).unwrap();
    let (two, one) = (two.lit_by(light).unwrap(), one.lit_by(light).unwrap());
    let at = |phase: f64| {
        let phi = Vector2::new(phase / APART, 0.0);
        two.response(&phi).element(0, 0) / one.response(&phi).element(0, 0)
    };
    let (crest, trough) = (at(0.0), at(PI));
    ((crest - trough) / (crest + trough)).abs()
}

/// How far the visibility of slits of this width may be from |γ|, for light of wave vectors up to `reach`.
///
/// The mean of γ over two slits is `γ + (a²/12) γ''`, of one slit with itself `1 + (a²/12) γ''(0)`, |γ''| ≤ reach²; under
/// the envelope at `φ = π/d`, also the cross terms `a² φ q/6`.
fn finite_width(width: f64, reach: f64) -> f64 {
    let a2 = width * width;
    a2 / 6.0 * reach * reach + a2 / 6.0 * reach * PI / APART + 1e-10
}

fn tolerance() -> Tolerance {
    Tolerance::relative(1e-11).unwrap()
}

#[test]
fn gaussian_light_has_gaussian_visibility() {
    let width = 2e-7;
    for v in [1e3, 1e4, 2e4, 3.5e4] {
        let root = Matrix2::from_diagonal_element(v);
        let light = IncidentCoherence::new(root, &HermiteSeries::fundamental(1.0)).unwrap();
        let list = AngularSpectrum::of_coherence(&light, slits([width; 2]).extent(), tolerance());
        let found = measured(width, &list.unwrap());
        let expected = (-0.5 * (v * APART).powi(2)).exp();
        // the mean of q² is v²
        let error = (found - expected).abs();
        println!("V d = {}: |γ| = {expected}, off by {error:e}", v * APART);
        assert!(error < finite_width(width, 1.5 * v), "{error:e}");
        assert!((light.value(&Vector2::new(APART, 0.0)).norm() - expected).abs() < 1e-15);
    }
}

#[test]
fn a_disk_has_the_visibility_of_airys_function() {
    let width = 2e-7;
    for u in [0.3, 1.0, 2.5, 3.831_705_970_207_512, 5.1, 9.0] {
        let k_alpha = u / APART;
        let spread = Matrix2::from_diagonal_element(k_alpha);
        let light =
            AngularSpectrum::disk(&spread, slits([width; 2]).extent(), tolerance()).unwrap();
        let found = measured(width, &light);
        let expected = (2.0 * libm::j1(u) / u).abs();
        let error = (found - expected).abs();
        println!("u = {u}: |2J₁/u| = {expected}, off by {error:e}");
        assert!(
            error < finite_width(width, k_alpha) && error < 1e-5,
            "{error:e}"
        );
    }
}

#[test]
fn a_disk_of_hermite_gauss_modes_has_the_visibility_of_its_series() {
    let (width, alpha) = (2e-7, 2e4);
    let disk = Envelope::disk(1.0).unwrap();
    for order in [0usize, 8, 32] {
        let modes = disk.modes(ModeWidth::Sigmas(2.0), order).unwrap();
        let (shape, series) = modes
            .in_direction(&Matrix2::from_diagonal_element(alpha))
            .unwrap();
        let light = IncidentCoherence::new(*shape.root(), &series).unwrap();
        let list = AngularSpectrum::of_coherence(&light, slits([width; 2]).extent(), tolerance());
        let found = measured(width, &list.unwrap());
        let expected = light.value(&Vector2::new(APART, 0.0)).norm();
        let airy = 2.0 * libm::j1(alpha * APART) / (alpha * APART);
        println!("order {order}: {found}, of the series {expected}, of the disk {airy}");
        // wave vectors of order N: up to the turning point and some more, at α/2 a unit
        let reach = (((2 * order + 1) as f64).sqrt() + 2.0) * 0.5 * alpha;
        assert!(
            (found - expected).abs() < finite_width(width, reach),
            "{order}"
        );
    }
}

#[test]
fn a_slit_source_has_the_visibility_of_a_sinc() {
    let width = 2e-7;
    for half in [0.4, 1.3, PI, 4.4, 7.0] {
        let k_alpha = half / APART;
        let spread = Matrix2::new(k_alpha, 0.0, 0.0, 3e4);
        let light = AngularSpectrum::rectangle(&spread, slits([width; 2]).extent(), tolerance());
        let found = measured(width, &light.unwrap());
        let expected = (half.sin() / half).abs();
        let error = (found - expected).abs();
        println!(
            "α d/λ = {}: |sinc| = {expected}, off by {error:e}",
            half / PI
        );
        assert!(
            error < finite_width(width, k_alpha) && error < 1e-5,
            "{error:e}"
        );
    }
}

#[test]
fn unequal_slits_have_less_visible_fringes() {
    let root = Matrix2::from_diagonal_element(1.2e4);
    let light = IncidentCoherence::new(root, &HermiteSeries::fundamental(1.0)).unwrap();
    let widths = [2e-7, 5e-7];
    let openings = slits(widths);
    let list = AngularSpectrum::of_coherence(&light, openings.extent(), tolerance()).unwrap();
    let lit = openings.lit_by(&list).unwrap();
    let at = |phase: f64| {
        lit.response(&Vector2::new(phase / APART, 0.0))
            .element(0, 0)
    };
    let (crest, trough) = (at(0.0), at(PI));
    let found = (crest - trough) / (crest + trough);
    let gamma = light.value(&Vector2::new(APART, 0.0));
    // powers as the squares of the widths: 2·2·5/(4 + 25)
    let expected = 20.0 / 29.0 * gamma.norm();
    // between crest and trough the wider slit's envelope falls by (φa)²/12
    let envelope = (PI / APART * widths[1]).powi(2) / 12.0;
    assert!((found - expected).abs() < envelope + finite_width(widths[1], 1.8e4));
    let phi = Vector2::zeros();
    let said = openings
        .visibility([0, 1], &phi, StokesVector::UNPOLARIZED, gamma)
        .unwrap();
    assert!((said - expected).abs() < 1e-15);
    assert!((fringe_visibility([4.0, 25.0], gamma) - expected).abs() < 1e-15);
    assert_eq!(fringe_visibility([0.0, 0.0], gamma), 0.0);
    assert!(
        openings
            .visibility([0, 2], &phi, StokesVector::UNPOLARIZED, gamma)
            .is_err()
    );
}

#[test]
fn crossed_polarizers_leave_no_fringes_and_turned_ones_the_cosine_of_their_angle() {
    for angle in [0.0, 0.4, 1.1, FRAC_PI_2] {
        let polarizer = |x: f64, angle: f64| Opening {
            jones: JonesMatrix::linear_polarizer().rotated(angle),
            ..Opening::clear(Vector2::new(x, 0.0), 1e-6, 1e-6)
        };
        let both = vec![
            polarizer(-0.5 * APART, 0.2),
            polarizer(0.5 * APART, 0.2 + angle),
        ];
        let both = Openings::new(both, 1e-6).unwrap();
        let gamma = Complex64::from_polar(0.8, 0.5);
        let phi = Vector2::zeros();
        // natural light through two polarizers: |tr P₁P₂| = cos² of the angle between them
        let found = both
            .visibility([0, 1], &phi, StokesVector::UNPOLARIZED, gamma)
            .unwrap();
        assert!((found - 0.8 * angle.cos().powi(2)).abs() < 1e-15);
    }
}
