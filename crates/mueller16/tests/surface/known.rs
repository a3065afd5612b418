//! Surfaces with a known answer: smooth ones, mirrors inside, hidden facets, the cap, and the theorem itself.

use std::f64::consts::PI;

use crate::boundaries::{between, dielectric, gold};
use crate::relief::{direction, green, heights};
use mueller16::{Boundary, Passage, PlaneElement, RayFrames, Surface, SurfaceError};
use mueller16::{
    ConductorInterface, DielectricInterface, Energy, Flat, Geometry, IncidentCoherence, Matter,
    Tolerance, element,
};
use nalgebra::{Matrix2, Vector3};
use stokes::{
    Components, Envelope, Frame, GeneralizedStokes, HermiteSeries, ModeWidth, Mueller, ShapeMatrix,
    StokesVector,
};

#[test]
fn a_smooth_surface_is_its_interface() {
    for degrees in [0.0, 30.0, 56.3, 80.0, 89.9f64] {
        let i = direction(degrees.to_radians(), 0.7);
        for (boundary, expected) in [
            (
                dielectric(),
                DielectricInterface::new(1.0, 1.5).unwrap().reflection(i.z),
            ),
            (
                gold(),
                ConductorInterface::new(1.0, 0.3, 2.8)
                    .unwrap()
                    .reflection(i.z),
            ),
        ] {
            let geometry = between(i, direction(0.3, 0.1));
            let incident = RayFrames::of_surface(&geometry).unwrap().incident;
            let surface = Surface::of_heights(boundary, Flat);
            let beams = surface
                .specular(&geometry, incident, Tolerance::ROUNDING)
                .unwrap();
            assert_eq!(beams.len(), 1);
            let off = beams[0].mueller.to_matrix() - expected.to_mueller().to_matrix();
            assert!(off.amax() < 1e-13, "{degrees}: {off}");
            let mirror = beams[0].geometry.to_observer() - Vector3::new(-i.x, -i.y, i.z);
            assert!(mirror.norm() < 1e-15);
            // and no diffuse light
            let frames = RayFrames::of_surface(&geometry).unwrap();
            let light = IncidentCoherence::plane_wave();
            let f = surface
                .scattering_function(&geometry, &frames, &light, Tolerance::ROUNDING)
                .unwrap();
            assert_eq!(f.to_matrix().amax(), 0.0);
        }
    }
}

#[test]
fn the_mirror_of_a_rough_surface_has_its_share_and_nothing_else_on_it() {
    let i = direction(1.2, 0.0);
    let geometry = between(i, Vector3::z());
    let incident = RayFrames::of_surface(&geometry).unwrap().incident;
    let surface = Surface::of_heights(Boundary::Mirror, heights(0.1, 2.0))
        .with_shadowing()
        .unwrap();
    let surface = surface
        .with_cap(
            green(),
            1.0,
            Passage::Reflection,
            Tolerance::relative(1e-2).unwrap(),
        )
        .unwrap();
    let beams = surface
        .specular(&geometry, incident, Tolerance::ROUNDING)
        .unwrap();
    let g = (4.0 * PI * 0.1 * i.z).powi(2);
    assert!((beams[0].weight - (-g).exp()).abs() < 1e-14);
    let half_wave = Mueller::from_rows([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
    ]);
    assert!((beams[0].mueller.to_matrix() - half_wave.to_matrix()).amax() < 1e-14);
}

#[test]
fn total_reflection_and_the_backs_of_facets_pass_nothing() {
    // from glass at 60°, straight out: the facet is met from its back
    let geometry = between(-direction(1.0, 0.0), direction(1.5, PI));
    let frames = RayFrames::of_surface(&geometry).unwrap();
    assert_eq!(
        dielectric()
            .mueller(&geometry, &frames)
            .unwrap()
            .to_matrix()
            .amax(),
        0.0
    );
    // mirrored inside: all of it, with the phase of total reflection
    let i = -direction(1.0, 0.0);
    let mirror = between(i, Vector3::new(-i.x, -i.y, i.z));
    let frames = RayFrames::of_surface(&mirror).unwrap();
    let m = dielectric().mueller(&mirror, &frames).unwrap();
    let expected = DielectricInterface::new(1.5, 1.0)
        .unwrap()
        .reflection(1f64.cos())
        .to_mueller();
    assert!((m.to_matrix() - expected.to_matrix()).amax() < 1e-13);
    assert!(m.element(2, 3).abs() > 0.1);
}

#[test]
fn a_hidden_facet_neither_reflects_nor_refracts() {
    let through = |i: Vector3<f64>, o: Vector3<f64>| {
        let geometry = between(i, o);
        let frames = RayFrames::of_surface(&geometry).unwrap();
        Boundary::Window
            .mueller(&geometry, &frames)
            .unwrap()
            .element(0, 0)
    };
    // both on one side of the plane of the facet, which stands too steep
    let (i, o) = (direction(1.4, 0.0), -direction(0.9, PI));
    let h = between(i, o).half_vector().unwrap();
    assert!(i.dot(&h) * o.dot(&h) > 0.0);
    assert_eq!(through(i, o), 0.0);
    // Snell's pair
    let refracted = -direction((1.4f64.sin() / 1.5).asin(), 0.0);
    assert!((through(i, refracted) - 1.0).abs() < 1e-15);
}

#[test]
fn near_normal_incidence_the_matrix_does_not_depend_on_the_plane() {
    let x = |k: Vector3<f64>| Frame::with_x_along(k, Vector3::x()).unwrap();
    let at = |polar: f64, azimuth: f64| {
        let i = direction(polar, azimuth);
        let geometry = between(i, Vector3::new(-i.x, -i.y, i.z));
        let frames = RayFrames {
            incident: x(-i),
            outgoing: x(geometry.to_observer()),
        };
        gold().mueller(&geometry, &frames).unwrap().to_matrix()
    };
    let upright = at(0.0, 0.0);
    // seen by x, a mirror turns S2 and S3
    assert!(upright[(0, 0)] > 0.4 && (upright[(2, 2)] + upright[(0, 0)]).abs() < 1e-14);
    for polar in [1e-16, 1e-12, 3e-9, 1e-8, 1.1e-8, 1e-7] {
        for azimuth in [0.0, 0.5, 1.3, 2.9] {
            // anisotropy is of the order of polar²; the axis is known to 1e-16/polar and multiplies that
            let off = (at(polar, azimuth) - upright).amax();
            assert!(off < 1e-13, "{polar} {azimuth}: {off}");
        }
    }
}

#[test]
fn the_theorem_scatters_what_the_scattering_function_says() {
    let surface = Surface::of_heights(gold(), heights(0.3, 6.0))
        .with_shadowing()
        .unwrap();
    let (i, o) = (direction(0.6, 0.2), direction(0.7, 3.0));
    let geometry = between(i, o);
    let frames = RayFrames::of_surface(&geometry).unwrap();
    let tolerance = Tolerance::relative(1e-10).unwrap();
    let opening = Envelope::gaussian(&Matrix2::new(1e-8, 2e-9, 2e-9, 3e-8)).unwrap();
    let (distance, incident) = (2.0, StokesVector::new(3.0, 0.5, -1.0, 0.7));
    let shape = ShapeMatrix::isotropic(4e-6).unwrap();
    let components = Components::Shared {
        modes: HermiteSeries::fundamental(1.0),
        stokes: incident,
    };
    let light =
        GeneralizedStokes::new(components, shape, frames.incident, green(), distance).unwrap();
    let matter = Matter::new(vec![
        surface
            .diffuse(&geometry, &frames, opening.clone(), tolerance)
            .unwrap(),
    ])
    .unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let (r, energy) = (3.0, surface.energy());
    assert_eq!(energy, Energy::HeightSurface);
    let out = matter
        .scatter(&modes, &geometry, &light, energy, frames.outgoing, r)
        .unwrap();
    // r² S = area cos_o cos_i f E
    let root =
        light.shape().root() * (geometry.wavelength().wavenumber().radians_per_metre() / distance);
    let axes = nalgebra::Matrix2x3::from_rows(&[
        frames.incident.x().transpose(),
        frames.incident.y().transpose(),
    ]);
    let tangents = nalgebra::Matrix3x2::from_columns(&[Vector3::x(), Vector3::y()]);
    let coherence =
        IncidentCoherence::new(root * (axes * tangents), &HermiteSeries::fundamental(1.0)).unwrap();
    let f = surface
        .scattering_function(&geometry, &frames, &coherence, tolerance)
        .unwrap();
    let irradiance = light.stokes().stokes;
    let expected = f * irradiance * (opening.area() * i.z * o.z / (r * r));
    let found = out[0].stokes().stokes;
    let off = (found - expected).to_vector().norm() / expected.s0();
    assert!(off < 1e-12, "{found:?} {expected:?}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let geometry = Geometry::on_plane(direction(0.3, 0.0), direction(0.2, 1.0), green()).unwrap();
    let frames = RayFrames::of_surface(&geometry).unwrap();
    let water = geometry.between(1.33, 1.33).unwrap();
    let medium = dielectric().mueller(&water, &frames).unwrap_err();
    assert_eq!(
        medium.to_string(),
        "surface: the geometry has the index 1.33 on the front side of the surface and the boundary 1, expected the same (to 1e-9)"
    );
    let swapped = RayFrames {
        incident: frames.outgoing,
        outgoing: frames.incident,
    };
    assert!(matches!(
        dielectric().mueller(&geometry, &swapped),
        Err(SurfaceError::Frame {
            ray: "incident",
            ..
        })
    ));
    let m = element::circular_polarizer(false);
    assert!(matches!(
        PlaneElement::new(&m, &m),
        Err(SurfaceError::Active { .. })
    ));
    let odd = Mueller::from_rows([[0.5, 0.2, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0; 4]]);
    assert!(PlaneElement::new(&odd, &Mueller::depolarizer(0.0)).is_err());
    let unreal = Mueller::from_rows([
        [0.1, 0.0, 0.0, 0.0],
        [0.0, 0.9, 0.0, 0.0],
        [0.0; 4],
        [0.0; 4],
    ]);
    assert!(matches!(
        PlaneElement::new(&Mueller::depolarizer(0.0), &unreal),
        Err(SurfaceError::NotRealizable {
            what: "transmission",
            ..
        })
    ));
}

#[test]
fn the_cap_is_reciprocal() {
    let tolerance = Tolerance::relative(1e-2).unwrap();
    let surface = Surface::of_heights(dielectric(), heights(0.3, 3.0))
        .with_cap(green(), 1.0, Passage::Reflection, tolerance)
        .unwrap()
        .with_cap(green(), 1.0, Passage::TransmissionInto(1.5), tolerance)
        .unwrap();
    let free = Surface::of_heights(dielectric(), heights(0.3, 3.0));
    let light = IncidentCoherence::plane_wave();
    for (i, o) in [
        (direction(1.45, 0.1), direction(0.9, 3.0)),
        (direction(0.9, 0.1), direction(1.45, 3.0)),
        (direction(1.5, 0.0), -direction(0.7, 0.1)),
        (-direction(0.7, 0.2), direction(1.5, 0.1)),
    ] {
        let geometry = between(i, o);
        let frames = RayFrames::of_surface(&geometry).unwrap();
        let of = |surface: &Surface<_>, geometry: &Geometry, frames: &RayFrames| {
            let f = surface.scattering_function(geometry, frames, &light, Tolerance::ROUNDING);
            f.unwrap() * geometry.n_outgoing().powi(-2)
        };
        let there = of(&surface, &geometry, &frames);
        let back = of(&surface, &geometry.reversed(), &frames.reversed());
        let scale = there.element(0, 0);
        let off = (back.to_matrix() - there.reversed().to_matrix()).amax();
        assert!(scale > 0.0 && off < 1e-11 * scale, "{off} {scale}");
        if o.z > 0.0 {
            // one of the two directions is near enough to grazing for the cap
            assert!(scale < 0.9 * of(&free, &geometry, &frames).element(0, 0));
        }
    }
}
