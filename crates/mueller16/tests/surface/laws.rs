//! Laws of what surfaces do to polarized light: reciprocity, passivity, realizability, energy, and known interfaces.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::boundaries::{between, crystal, dielectric, gold};
use crate::relief::{direction, heights};
use csdm::CloudeSpectrum;
use csdm::film::Layer;
use mueller16::{
    Boundary, Film, InternalReflections, PlaneElement, RayFrames, Surface, SurfaceError,
};
use mueller16::{Flat, Geometry, IncidentCoherence, Tolerance, element};
use nalgebra::Vector3;
use num_complex::Complex64;
use proptest::prelude::*;

/// Between air and glass; `loss` is the extinction coefficient of its second layer.
fn film(loss: f64) -> Boundary {
    let layers = vec![
        Layer {
            index: 2.3.into(),
            thickness: 70e-9,
        },
        Layer {
            index: Complex64::new(1.8, -loss),
            thickness: 130e-9,
        },
    ];
    Boundary::Film(Film::new(1.0, layers, 1.5.into()).unwrap())
}

fn polarizer() -> Boundary {
    let m = element::linear_polarizer().to_mueller();
    Boundary::Element(PlaneElement::new(&(m.rotated(0.4) * 0.0), &m.rotated(0.4)).unwrap())
}

/// All of them, between air and a medium of index 1.5 behind.
fn boundaries() -> Vec<Boundary> {
    vec![
        dielectric(),
        gold(),
        film(0.0),
        film(0.1),
        crystal(InternalReflections::Coherent),
        crystal(InternalReflections::SinglePass),
        crystal(InternalReflections::Incoherent {
            coherent_below: 0.0,
        }),
        polarizer(),
        Boundary::Mirror,
        Boundary::Window,
    ]
}

fn turned(frames: RayFrames, a: f64, b: f64) -> RayFrames {
    RayFrames {
        incident: frames.incident.turned(a),
        outgoing: frames.outgoing.turned(b),
    }
}

fn any_direction() -> impl Strategy<Value = Vector3<f64>> {
    let polar = prop_oneof![
        6 => 0.0..FRAC_PI_2,
        1 => 0.0..1e-7f64,
        1 => (1e-7..1e-2f64).prop_map(|d| FRAC_PI_2 - d),
        1 => Just(0.0),
    ];
    (polar, -PI..PI, any::<bool>()).prop_map(|(polar, azimuth, below)| {
        let d = direction(polar, azimuth);
        if below {
            Vector3::new(d.x, d.y, -d.z)
        } else {
            d
        }
    })
}

/// Two directions: any, or a mirror or Snell pair and what is near it.
fn any_pair() -> impl Strategy<Value = (Vector3<f64>, Vector3<f64>)> {
    let off = prop_oneof![Just(0.0), -1e-9..1e-9f64, -1e-3..1e-3f64];
    let near =
        (any_direction(), any::<bool>(), off).prop_filter_map("propagates", |(i, passes, off)| {
            let n = |z: f64| if z < 0.0 { 1.5 } else { 1.0 };
            let side = if passes { -i.z.signum() } else { i.z.signum() };
            let t = -i.xy() * (n(i.z) / n(side)) + nalgebra::Vector2::new(off, -0.7 * off);
            let squared = 1.0 - t.norm_squared();
            (squared > 1e-9).then(|| (i, Vector3::new(t.x, t.y, side * squared.sqrt())))
        });
    prop_oneof![1 => (any_direction(), any_direction()), 1 => near]
}

/// A crystal met from glass beyond the critical angle has no answer, and says so.
fn answer<T>(found: Result<T, SurfaceError>) -> Option<T> {
    match found {
        Err(SurfaceError::CrystalFromBehind { .. }) => None,
        other => Some(other.unwrap()),
    }
}

/// Relative rounding of matrices: that of the cosines on the surface and on the facet, and of h itself where φ is short.
fn rounding(geometry: &Geometry) -> f64 {
    let (i, o) = (geometry.to_source(), geometry.to_observer());
    let h = geometry.half_vector().unwrap_or(Vector3::z());
    let cosines = [i.z, o.z, i.dot(&h), o.dot(&h)];
    let least = cosines.into_iter().fold(1.0, |m: f64, c| m.min(c.abs()));
    let k0 = geometry.wavelength().wavenumber().radians_per_metre();
    let shortness = geometry.momentum_transfer().norm() / k0;
    1e-11 + 1e-13 / (least * shortness)
}

proptest! {
    #[test]
    fn facets_are_reciprocal_passive_and_realizable((i, o) in any_pair(), a in -4.0..4.0f64, b in -4.0..4.0f64) {
        let geometry = between(i, o);
        let frames = turned(RayFrames::of_surface(&geometry).unwrap(), a, b);
        for boundary in boundaries() {
            let Some(there) = answer(boundary.mueller(&geometry, &frames)) else { continue };
            let back = boundary.mueller(&geometry.reversed(), &frames.reversed()).unwrap();
            let (found, expected) = (back.to_matrix(), there.reversed().to_matrix());
            let tolerance = rounding(&geometry);
            prop_assert!((found - expected).amax() < tolerance,
                "{boundary:?} {i} {o} {}", (found - expected).amax());
            prop_assert!(there.is_passive(1e-12 + tolerance), "{boundary:?} {there:?}");
            if there.element(0, 0) > 0.0 {
                let spectrum = CloudeSpectrum::of(&there).unwrap();
                prop_assert!(spectrum.check_realizable(1e-9).is_ok(), "{boundary:?} {there:?}");
            }
        }
    }

    #[test]
    fn scattering_functions_are_reciprocal_and_realizable((i, o) in any_pair(), a in -4.0..4.0f64) {
        let geometry = between(i, o);
        let frames = turned(RayFrames::of_surface(&geometry).unwrap(), a, -0.3);
        let light = IncidentCoherence::plane_wave();
        let tolerance = Tolerance::relative(1e-12).unwrap();
        for boundary in [dielectric(), gold(), film(0.0), film(0.1)] {
            let surface = Surface::of_heights(boundary, heights(0.3, 3.0)).with_shadowing().unwrap();
            let there = surface.scattering_function(&geometry, &frames, &light, tolerance).unwrap();
            let (reversed, back) = (geometry.reversed(), frames.reversed());
            let back = surface.scattering_function(&reversed, &back, &light, tolerance).unwrap();
            let there = there * geometry.n_outgoing().powi(-2);
            let back = back * geometry.n_incident().powi(-2);
            let scale = there.element(0, 0).max(1e-30);
            prop_assert!(there.to_matrix().iter().all(|x| x.is_finite()));
            let off = (back.to_matrix() - there.reversed().to_matrix()).amax();
            // what the sum leaves out is counted by the peak of the lobe, π l²/λ²
            let peak = PI * 9.0 * geometry.obliquity().unwrap();
            let allowed = rounding(&geometry) * scale + 1e-12 * peak;
            prop_assert!(off < allowed, "{off} {scale} {i} {o}");
            if there.element(0, 0) > 0.0 {
                prop_assert!(CloudeSpectrum::of(&there).unwrap().check_realizable(1e-9).is_ok());
            }
        }
    }

    #[test]
    fn a_lossless_film_reflects_or_passes_everything(polar in 0.0..1.57f64, azimuth in -PI..PI, below in any::<bool>(), plain in any::<bool>()) {
        let up = direction(polar, azimuth);
        let i = if below { Vector3::new(up.x, up.y, -up.z) } else { up };
        let surface = Surface::of_heights(if plain { dielectric() } else { film(0.0) }, Flat);
        let mut total = [0.0; 2];
        for side in [1.0, -1.0] {
            let geometry = between(i, Vector3::new(0.0, 0.0, side));
            let incident = RayFrames::of_surface(&geometry).unwrap().incident;
            for beam in surface.specular(&geometry, incident, Tolerance::ROUNDING).unwrap() {
                prop_assert!(beam.weight == 1.0 && beam.geometry.tangential().norm() < 1e-7);
                let m = beam.mueller;
                // of s and of p light
                total[0] += m.element(0, 0) + m.element(0, 1);
                total[1] += m.element(0, 0) - m.element(0, 1);
            }
        }
        // power in films is conserved to 1e-12; the facet's cosine is the surface's to rounding over the shortest φ, 0.1 k₀
        prop_assert!((total[0] - 1.0).abs() < 1e-11 && (total[1] - 1.0).abs() < 1e-11, "{total:?}");
    }
}
