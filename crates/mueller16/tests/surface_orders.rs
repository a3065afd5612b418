//! The sharp orders of a grating: where they are and what share each has.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::PI;

use mueller16::surface::{Boundary, RayFrames, Surface};
use mueller16::{
    Approximation, Autocorrelation, AutocorrelationError, GaussianTerm, Geometry, Method, Relief,
    Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
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
