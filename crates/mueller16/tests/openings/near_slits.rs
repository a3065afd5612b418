//! Slits too near for one plane phase, against the integral of spherical waves over every opening.

use csdm::JonesMatrix;
use gauss_quad::GaussLegendre;
use mueller16::{
    AngularSpectrum, Geometry, IncidentCoherence, Opening, OpeningError, Openings, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use std::f64::consts::TAU;
use stokes::{HermiteSeries, Wavelength};

const GREEN: f64 = 550e-9;
const K: f64 = TAU / GREEN;

fn green() -> Wavelength {
    Wavelength::from_metres(GREEN).unwrap()
}

/// Three slits over 3.7 mm, of these widths.
fn three(widths: [f64; 3]) -> Openings {
    let at = |x: f64, width: f64| Opening::clear(Vector2::new(x, 0.0), width, 12e-6);
    let [a, b, c] = widths;
    Openings::new(vec![at(-1.85e-3, a), at(0.4e-3, b), at(1.85e-3, c)], 1e-6).unwrap()
}

/// `|∫ e^(ik(s + r)) s₀ r₀/(s r) d²x|²` over all openings: the diffraction integral of Eq. (S2.2).
fn spherical(openings: &Openings, source: &Vector3<f64>, observer: &Vector3<f64>) -> f64 {
    let rule = GaussLegendre::new(16.try_into().unwrap());
    let (s0, r0) = (source.norm(), observer.norm());
    let mut sum = Complex64::ZERO;
    for o in openings.openings() {
        for (u, p) in &rule {
            for (v, q) in &rule {
                let x = o.centre + Vector2::new(0.5 * o.width * u, 0.5 * o.height * v);
                let x = x.push(0.0);
                let (s, r) = ((source - x).norm(), (observer - x).norm());
                let weight = 0.25 * o.area() * p * q * s0 * r0 / (s * r);
                sum += Complex64::from_polar(weight, K * ((s - s0) + (r - r0)));
            }
        }
    }
    sum.norm_sqr()
}

/// Receivers over some fringes, 1 m behind the screen.
fn receivers() -> impl Iterator<Item = Vector3<f64>> {
    (0..200).map(|i| Vector3::new(2e-5 * f64::from(i) - 1.7e-3, 3e-4, -1.0))
}

#[test]
fn each_slit_with_its_own_path_is_the_diffraction_integral() {
    let source = Vector3::new(2e-3, -1e-3, 2.0);
    let accepted = Tolerance::relative(2e-3).unwrap();
    let peak = |o: &Openings| o.open_area().powi(2);
    for widths in [[12e-6; 3], [8e-6, 12e-6, 15e-6]] {
        let slits = three(widths);
        let plane = AngularSpectrum::plane_wave();
        let lit = slits.lit_by(&plane).unwrap();
        let (mut own, mut global) = (0.0f64, 0.0f64);
        for observer in receivers() {
            let exact = spherical(&slits, &source, &observer) / peak(&slits);
            let view = slits
                .seen_between(source, observer, green(), accepted)
                .unwrap();
            let found = view.jones().mueller().element(0, 0) / peak(&slits);
            own = own.max((found - exact).abs());
            let to = [source.normalize(), observer.normalize()];
            let geometry = Geometry::on_plane(to[0], to[1], green()).unwrap();
            let plane = lit.response(&geometry.tangential()).element(0, 0) / peak(&slits);
            global = global.max((plane - exact).abs());
            // the transfer is the same in other units
            let f = view.transfer().element(0, 0) * GREEN * GREEN * 1e-6;
            assert!((f / peak(&slits) - found).abs() < 1e-14);
        }
        println!("{widths:?}: own paths {own:e}, one phase {global:e} of the peak");
        // the phase ψ = k a²(1/s + 1/r)/8 at the edge of an opening has the mean ψ (1/3 − 2 t²/45 …) under the lobe,
        // t = κ a/2: the first part is kept, the second counts twice; of higher order is its square, in both directions
        let edge = |a: f64| K * a * a * (1.0 / 2.0 + 1.0) / 8.0;
        let t = 0.5 * K * widths[2] * ((2.3e-3 + 1.85e-3) + (2e-3 + 1.85e-3) / 2.0);
        let lobe = 2.0 / 45.0 * t * t * edge(widths[2]);
        let square = (edge(widths[2]) + edge(12e-6)).powi(2);
        // distances of 1 m are known to 2e-16 m, the reference's phases hence to 4 × 2.5e-9
        let bound = 2.0 * lobe + square + 1e-8;
        assert!(own < bound, "{own:e} {bound:e}");
        assert!(global > 0.8);
    }
}

#[test]
fn an_opening_off_the_centre_is_as_bright_as_its_own_distances_say() {
    let x = Vector3::new(0.3, 0.0, 0.0);
    let hole = Opening::clear(x.xy(), 12e-6, 12e-6);
    let hole = Openings::new(vec![hole], 1e-6).unwrap();
    let (source, observer) = (x + 2.0 * Vector3::z(), x - Vector3::z());
    let accepted = Tolerance::relative(2e-3).unwrap();
    let view = hole
        .seen_between(source, observer, green(), accepted)
        .unwrap();
    let found = view.jones().mueller().element(0, 0) / hole.open_area().powi(2);
    let expected = (source.norm() * observer.norm() / 2.0).powi(2);
    // straight on: the square of the phase at the corner, 6e-4
    assert!((found / expected - 1.0).abs() < 4e-7);
}

#[test]
fn far_away_both_forms_agree() {
    let slits = three([8e-6, 12e-6, 15e-6]);
    let delayed = JonesMatrix::linear_retarder(0.7).scaled(Complex64::cis(-0.4));
    let mut openings = slits.openings().to_vec();
    openings[1].jones = delayed;
    let slits = Openings::new(openings, 1e-6).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    let to_source = Vector3::new(0.01, -0.02, 1.0).normalize();
    let accepted = Tolerance::relative(1e-6).unwrap();
    for x in [-2e-4, -5e-5, 0.0, 1.3e-4] {
        let to_observer = Vector3::new(x, 1e-3, -1.0).normalize();
        let geometry = Geometry::on_plane(to_source, to_observer, green()).unwrap();
        let geometry = geometry.between(1.0, 1.33).unwrap();
        let far = lit.transfer(&geometry).unwrap().to_matrix();
        let distance = 1e8;
        let view = slits.seen_between(
            to_source * distance,
            to_observer * distance,
            green(),
            accepted,
        );
        let view = view.unwrap().between(1.0, 1.33).unwrap();
        let near = view.transfer().to_matrix();
        // what the spherical waves still differ by: k e² (1/s + n/r)/2 for e = 1.9 mm
        let left = K * 1.9e-3f64.powi(2) * 2.33 / distance;
        let peak = far
            .amax()
            .max(slits.open_area().powi(2) * 1e6 / GREEN.powi(2));
        assert!((near - far).amax() < (left + 1e-9) * peak);
    }
}

#[test]
fn a_wide_source_is_the_sum_of_its_points() {
    let slits = three([8e-6, 12e-6, 15e-6]);
    let source = Vector3::new(2e-3, -1e-3, 1.5);
    let observer = Vector3::new(3e-4, 0.0, -1.0);
    let accepted = Tolerance::relative(2e-3).unwrap();
    let view = slits
        .seen_between(source, observer, green(), accepted)
        .unwrap();
    // a Gaussian lamp of 0.1 mm, 1.5 m away: coherent over 1.3 mm
    let sigma = 1e-4;
    let root = Matrix2::from_diagonal_element(K * sigma / 1.5);
    let light = IncidentCoherence::new(root, &HermiteSeries::fundamental(1.0)).unwrap();
    let tolerance = Tolerance::relative(1e-9).unwrap();
    let list = AngularSpectrum::of_coherence(&light, slits.extent(), tolerance).unwrap();
    let found = view.transfer_of(&list).unwrap().element(0, 0);
    // by hand: points of the lamp over ±6 sigma
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in -30..=30 {
        for j in -30..=30 {
            let (u, v) = (0.2 * f64::from(i), 0.2 * f64::from(j));
            let weight = (-0.5 * (u * u + v * v)).exp();
            let at = source + Vector3::new(u, v, 0.0) * sigma;
            let view = slits.seen_between(at, observer, green(), accepted).unwrap();
            sum += weight * view.transfer().element(0, 0);
            weights += weight;
        }
    }
    let expected = sum / weights;
    let point = view.transfer().element(0, 0);
    println!("point {point:e}, lamp {found:e}, by hand {expected:e}");
    // a direction cosine is u/s (1 − sin²/2 …) of the place, of which sines of 2e-3 take 4e-6 at 0.1 of a fringe width;
    // the tails beyond 6 sigma are 2e-9
    assert!((found / expected - 1.0).abs() < 2e-5);
    assert!((point / expected - 1.0).abs() > 0.05);
}

#[test]
fn too_near_is_refused_with_the_phase() {
    let slits = three([8e-6, 12e-6, 15e-6]);
    let accepted = Tolerance::relative(1e-3).unwrap();
    let straight = Geometry::on_plane(Vector3::z(), -Vector3::z(), green()).unwrap();
    let error = slits
        .check_global_phase(&straight, [1.5, 1.0], accepted)
        .unwrap_err();
    let OpeningError::GlobalPhase { extent, phase, .. } = error else {
        panic!("{error}");
    };
    assert!((extent - 1.8575e-3).abs() < 1e-7);
    assert!((phase - 0.5 * K * extent * extent * (1.0 + 1.0 / 1.5)).abs() < 1e-9);
    assert!(
        slits
            .check_global_phase(&straight, [1e6, 1e6], accepted)
            .is_ok()
    );
    let (source, observer) = (Vector3::z(), -Vector3::z());
    let error = slits
        .seen_between(source * 1e-3, observer, green(), accepted)
        .unwrap_err();
    assert!(matches!(
        error,
        OpeningError::NearField {
            index: 0,
            limit: 1e-3,
            ..
        }
    ));
    let text = error.to_string();
    assert!(
        text.contains("opening 0 of 0.000008 m × 0.000012 m")
            && text.ends_with("divide the opening"),
        "{text}"
    );
    assert!(
        slits
            .seen_between(Vector3::x(), observer, green(), accepted)
            .is_err()
    );
    assert!(
        slits
            .seen_between(Vector3::zeros(), observer, green(), accepted)
            .is_err()
    );
}
