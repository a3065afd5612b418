//! The sharp orders of a grating: where they are and what share each has.

use std::f64::consts::PI;

use mueller16::{
    Approximation, Autocorrelation, AutocorrelationError, Blaze, CoupledOrders, GaussianTerm,
    Geometry, Grating, IncidentCoherence, Method, Mount, Profile, Relief, Sharing, Superposed,
    Tolerance,
};
use mueller16::{Boundary, RayFrames, Surface};
use nalgebra::{Matrix2, Vector2, Vector3};
use proptest::prelude::*;
use stokes::Wavelength;

const WAVELENGTH: f64 = 500e-9;

fn green() -> Wavelength {
    Wavelength::from_metres(WAVELENGTH).unwrap()
}

/// `h = (d/2) cos Gx`: orders q with the efficiencies J_q(φ_z d/2)².
#[derive(Clone, Debug)]
struct Sinusoid {
    depth: f64,
    pitch: f64,
}

impl Relief for Sinusoid {
    fn autocorrelation(
        &self,
        phi_z: f64,
        _: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let orders = (-6..=6).map(|q| GaussianTerm {
            weight: libm::jn(q, 0.5 * phi_z * self.depth).powi(2),
            rate: 0.0,
            shift: Vector2::new(f64::from(q) * 2.0 * PI / self.pitch, 0.0),
        });
        let r = Autocorrelation::of_family(&Matrix2::identity(), orders)?;
        let approximation = Approximation {
            method: Method::Orders,
            terms: 13,
            error: 0.0,
        };
        Ok((r, approximation))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        None
    }
}

#[test]
fn orders_obey_the_grating_equation_and_have_their_own_efficiency() {
    let (pitch, depth) = (2.9 * WAVELENGTH, 0.22 * WAVELENGTH);
    let surface = Surface::of_phases(Boundary::Mirror, Sinusoid { depth, pitch });
    // conical mounting: 25° out of the plane across the grooves
    let (sin, cos) = 25f64.to_radians().sin_cos();
    let i = Vector3::new(0.5f64.sin() * cos, 0.5f64.sin() * sin, 0.5f64.cos());
    let geometry = Geometry::on_plane(i, Vector3::z(), green()).unwrap();
    let incident = RayFrames::of_surface(&geometry).unwrap().incident;
    let beams = surface
        .specular(&geometry, incident, Tolerance::ROUNDING)
        .unwrap();
    let mut seen = vec![];
    for beam in &beams {
        let o = beam.geometry.to_observer();
        let q = (o.x + i.x) * 2.9;
        assert!((q - q.round()).abs() < 1e-12 && (o.y + i.y).abs() < 1e-15 && o.z > 0.0);
        seen.push(q.round() as i32);
        let psi = 2.0 * PI * (i.z + o.z) * 0.22;
        let expected = libm::jn(q.round() as i32, 0.5 * psi).powi(2);
        assert!((beam.weight - expected).abs() < 1e-14);
        assert!((beam.mueller.element(0, 0) - 1.0).abs() < 1e-14);
    }
    seen.sort_unstable();
    // |q/2.9 − 0.434| and the conical part inside the unit circle
    assert_eq!(seen, [-1, 0, 1, 2, 3, 4]);
}

#[test]
fn a_sinusoidal_grating_at_normal_incidence_keeps_the_known_share() {
    // period 1.6 µm and depth 0.12 µm at 550 nm: with the φ_z of each order .946 of the power propagates
    let scale = WAVELENGTH / 550e-9;
    let (pitch, depth) = (1.6e-6 * scale, 0.12e-6 * scale);
    let surface = Surface::of_phases(Boundary::Mirror, Sinusoid { depth, pitch });
    let geometry = Geometry::on_plane(Vector3::z(), Vector3::z(), green()).unwrap();
    let incident = RayFrames::of_surface(&geometry).unwrap().incident;
    let beams = surface
        .specular(&geometry, incident, Tolerance::ROUNDING)
        .unwrap();
    let sum: f64 = beams.iter().map(|beam| beam.weight).sum();
    assert!((sum - 0.946).abs() < 5e-4, "{sum}");
}

/// In wavelengths: a blaze of 3 by ½, of which 1.155 of the light would leave from 60°.
const PITCH: f64 = 3.0;
const DEPTH: f64 = 0.5;

fn blaze() -> Grating {
    let profile = Profile::blazed(DEPTH * WAVELENGTH, Blaze::Rising).unwrap();
    Grating::lines(PITCH * WAVELENGTH, Vector2::x(), profile).unwrap()
}

/// `sinc²(q + (cos_i + cos_o) d)` for each order q of light from the sine `i`, with the sine of the order.
fn by_hand(i: f64) -> Vec<(f64, f64)> {
    let orders = (-20..=20).map(|q| (f64::from(q), f64::from(q) / PITCH - i));
    let cos = |sine: f64| (1.0 - sine * sine).sqrt();
    orders
        .filter(|(_, o)| o.abs() < 1.0)
        .map(|(q, o)| {
            let u = PI * (q + (cos(i) + cos(o)) * DEPTH);
            (o, (u.sin() / u).powi(2))
        })
        .collect()
}

fn total_by_hand(i: f64) -> f64 {
    by_hand(i).iter().map(|(_, p)| p).sum()
}

fn from_sine(sine: f64) -> Geometry {
    let i = Vector3::new(sine, 0.0, (1.0 - sine * sine).sqrt());
    Geometry::on_plane(i, Vector3::z(), green()).unwrap()
}

#[test]
fn a_grating_makes_no_light() {
    let sine = -60f64.to_radians().sin();
    assert!((total_by_hand(sine) - 1.155).abs() < 5e-4);
    let geometry = from_sine(sine);
    let incident = RayFrames::of_surface(&geometry).unwrap().incident;
    let beams = |grating| {
        Surface::of_phases(Boundary::Mirror, grating)
            .specular(&geometry, incident, Tolerance::ROUNDING)
            .unwrap()
    };
    let capped = beams(blaze());
    assert_eq!(capped.len(), by_hand(sine).len());
    for (beam, (o, p)) in capped.iter().zip(by_hand(sine)) {
        assert!((beam.geometry.to_observer().x - o).abs() < 1e-14);
        let expected = p / total_by_hand(sine).max(total_by_hand(o)).max(1.0);
        // sines near 1 have lost some digits of their cosines
        assert!((beam.weight - expected).abs() < 1e-12, "{o}: {expected}");
    }
    // all of them by N(i): the largest here
    assert!((capped.iter().map(|b| b.weight).sum::<f64>() - 1.0).abs() < 1e-13);
    let raw = beams(blaze().shared(Sharing::Phase));
    assert!((raw.iter().map(|b| b.weight).sum::<f64>() - total_by_hand(sine)).abs() < 1e-13);
    let whole = beams(blaze().shared(Sharing::Lossless));
    assert!((whole.iter().map(|b| b.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    // both are those of the coupled set
    let coupled = CoupledOrders::new(&blaze(), &Mount::of(&geometry).unwrap()).unwrap();
    let lossless = coupled.lossless().unwrap().efficiencies;
    let known = coupled.efficiencies().into_iter().zip(lossless);
    for ((a, b), (capped, lossless)) in capped.iter().zip(&whole).zip(known) {
        assert!((a.weight - capped).abs() < 1e-12 && (b.weight - lossless).abs() < 1e-15);
    }
}

#[test]
fn roughness_on_a_grating_takes_from_its_shares() {
    let sine = -60f64.to_radians().sin();
    let geometry = from_sine(sine);
    let frames = RayFrames::of_surface(&geometry).unwrap();
    let rough = crate::relief::heights(0.05, 4.0);
    let of = |grating| Surface::of_phases(Boundary::Mirror, Superposed(grating, rough));
    let surface = of(blaze());
    let beams = surface
        .specular(&geometry, frames.incident, Tolerance::ROUNDING)
        .unwrap();
    for (beam, (o, p)) in beams.iter().zip(by_hand(sine)) {
        let cap = total_by_hand(sine).max(total_by_hand(o)).max(1.0);
        let phi_z = 2.0 * PI * (geometry.to_source().z + (1.0 - o * o).sqrt());
        let expected = p / cap * (-(phi_z * 0.05).powi(2)).exp();
        assert!((beam.weight - expected).abs() < 1e-12, "{o}: {expected}");
    }
    // the halo is capped by the same rule, between the orders too
    let light = IncidentCoherence::plane_wave();
    for o in [0.0f64, 0.35, 0.8] {
        let observer = Vector3::new(o, 0.0, (1.0 - o * o).sqrt());
        let seen = Geometry::on_plane(geometry.to_source(), observer, green()).unwrap();
        let frames = RayFrames::of_surface(&seen).unwrap();
        let [capped, free] = [of(blaze()), of(blaze().shared(Sharing::Phase))].map(|surface| {
            let f = surface.scattering_function(
                &seen,
                &frames,
                &light,
                Tolerance::relative(1e-6).unwrap(),
            );
            f.unwrap().element(0, 0)
        });
        let cap = total_by_hand(sine).max(total_by_hand(o)).max(1.0);
        assert!(
            cap > 1.1 && (capped / free * cap - 1.0).abs() < 1e-12,
            "{o}"
        );
    }
}

proptest! {
    #[test]
    fn orders_of_a_surface_are_reciprocal_and_passive(
        depth in 0.02..0.6f64, pitch in 0.6..6.0f64, theta in -1.3..1.3f64, azimuth in 0.0..PI,
        passes in any::<bool>(), lossless in any::<bool>(),
    ) {
        let profile = Profile::triangular(depth * WAVELENGTH, 0.8).unwrap();
        let sharing = if lossless { Sharing::Lossless } else { Sharing::Capped };
        let grating = Grating::lines(pitch * WAVELENGTH, Vector2::x(), profile).unwrap().shared(sharing);
        let boundary = if passes { Boundary::Window } else { Boundary::Mirror };
        let surface = Surface::of_phases(boundary, grating);
        let i = Vector3::new(theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos());
        let o = if passes { -Vector3::z() } else { Vector3::z() };
        let geometry = Geometry::on_plane(i, o, green()).unwrap();
        let geometry = geometry.between(1.0, if passes { 1.5 } else { 1.0 }).unwrap();
        let from = |geometry: &Geometry| {
            let incident = RayFrames::of_surface(geometry).unwrap().incident;
            surface.specular(geometry, incident, Tolerance::ROUNDING).unwrap()
        };
        let beams = from(&geometry);
        prop_assert!(beams.iter().map(|beam| beam.weight).sum::<f64>() <= 1.0 + 1e-12);
        for beam in &beams {
            // a sine of 1 − 1e-4 has lost digits of its cosine
            if beam.geometry.cos_outgoing().abs() < 1e-2 || lossless && !passes {
                continue;
            }
            let back = from(&beam.geometry.reversed());
            let home = back.iter().find(|b| (b.place - beam.place).norm() < 1.0).unwrap();
            prop_assert!((home.weight - beam.weight).abs() < 1e-10, "{} {}", home.weight, beam.weight);
        }
    }
}
