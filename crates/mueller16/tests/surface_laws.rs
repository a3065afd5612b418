//! Laws of what surfaces do to polarized light: reciprocity, passivity, realizability, energy, and known interfaces.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod surface_relief;

use std::f64::consts::{FRAC_PI_2, PI};

use csdm::CloudeSpectrum;
use csdm::birefringent::{Crystal, CrystalLayer};
use csdm::film::Layer;
use mueller16::surface::{
    Boundary, CrystalPlate, Film, InternalReflections, Passage, PlaneElement, RayFrames, Surface,
    SurfaceError,
};
use mueller16::{
    ConductorInterface, DielectricInterface, Energy, Flat, Geometry, IncidentCoherence, Matter,
    Tolerance, element,
};
use nalgebra::{Matrix2, Matrix3, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Components, Envelope, Frame, GeneralizedStokes, HermiteSeries, ModeWidth, Mueller, ShapeMatrix,
    StokesVector,
};
use surface_relief::{direction, green, heights};

fn dielectric() -> Boundary {
    Boundary::Dielectric(DielectricInterface::new(1.0, 1.5).unwrap())
}

fn gold() -> Boundary {
    Boundary::Conductor(ConductorInterface::new(1.0, 0.3, 2.8).unwrap())
}

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

/// A biaxial, absorbing and optically active plate on glass.
fn crystal(reflections: InternalReflections) -> Boundary {
    let indices = [
        Complex64::new(1.5, 0.0),
        Complex64::new(1.6, -0.01),
        Complex64::new(1.75, 0.0),
    ];
    let medium = Crystal::biaxial(
        indices,
        Vector3::new(1.0, 0.4, 0.3),
        Vector3::new(0.1, 1.0, -0.5),
    )
    .unwrap();
    let medium = medium.with_gyration(&(Matrix3::identity() * 2e-3)).unwrap();
    let layers = vec![CrystalLayer {
        crystal: medium,
        thickness: 700e-9,
    }];
    Boundary::Crystal(CrystalPlate::new(1.0, layers, 1.5.into(), reflections).unwrap())
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

/// Air above, glass below.
fn between(i: Vector3<f64>, o: Vector3<f64>) -> Geometry {
    let index = |z: f64| if z < 0.0 { 1.5 } else { 1.0 };
    Geometry::on_plane(i, o, green())
        .unwrap()
        .between(index(i.z), index(o.z))
        .unwrap()
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
            let mut tolerance = rounding(&geometry);
            if let Boundary::Crystal(_) = boundary {
                // a tilted crystal notices the sine of the angle of incidence, which its cosine tells to 1e-16/sine and at
                // worst to 2e-8; matrices change by up to k₀ d |ε − ε̄| = 5 for each unit of it
                let sine = i.xy().norm().min(o.xy().norm());
                tolerance += (2e-15 / sine).min(2e-7);
            }
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
    // light from above and light that leaves below on the same side of the facet's plane
    let geometry = between(
        direction(1.4, 0.0),
        -direction(1.4, 0.0) + 2.0 * Vector3::z() * 0.0,
    );
    let frames = RayFrames::of_surface(&geometry).unwrap();
    let h = geometry.half_vector().unwrap();
    let same_side = geometry.to_source().dot(&h) * geometry.to_observer().dot(&h) > 0.0;
    let m = Boundary::Window.mueller(&geometry, &frames).unwrap();
    assert_eq!(same_side, m.element(0, 0) == 0.0);
    let grazing = between(direction(1.4, 0.0), -direction(0.9, PI));
    let h = grazing.half_vector().unwrap();
    assert!(grazing.to_source().dot(&h) < 0.0 || grazing.to_observer().dot(&h) > 0.0);
    let frames = RayFrames::of_surface(&grazing).unwrap();
    assert_eq!(
        Boundary::Window
            .mueller(&grazing, &frames)
            .unwrap()
            .element(0, 0),
        0.0
    );
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
fn a_polarizer_in_a_surface_passes_along_the_first_tangent() {
    let m = element::linear_polarizer().to_mueller();
    let polarizer = Boundary::Element(PlaneElement::new(&(m * 0.0), &m).unwrap());
    let i = direction(0.5, 0.8);
    let geometry = Geometry::on_plane(i, -i, green())
        .unwrap()
        .between(1.0, 1.0 + 1e-9)
        .unwrap();
    let frame = Frame::with_x_along(-i, Vector3::x()).unwrap();
    let frames = RayFrames {
        incident: frame,
        outgoing: frame,
    };
    let surface = Surface::of_phases(polarizer, Flat);
    let beams = surface
        .specular(&geometry, frame, Tolerance::ROUNDING)
        .unwrap();
    let to_frame = frame.rotation_to(&beams[0].frames.outgoing);
    let out = (beams[0].mueller * StokesVector::UNPOLARIZED).rotated(to_frame.inverse());
    assert!(
        (out - StokesVector::HORIZONTAL * 0.5).to_vector().norm() < 1e-8,
        "{out:?} {frames:?}"
    );
}

#[test]
fn a_crystal_without_birefringence_is_a_film() {
    let n = Complex64::new(1.8, -0.05);
    let layers = vec![CrystalLayer {
        crystal: Crystal::isotropic(n).unwrap(),
        thickness: 150e-9,
    }];
    let plate = CrystalPlate::new(1.0, layers, 1.5.into(), InternalReflections::Coherent).unwrap();
    let film = Film::new(
        1.0,
        vec![Layer {
            index: n,
            thickness: 150e-9,
        }],
        1.5.into(),
    )
    .unwrap();
    for (i, o) in [
        (direction(0.4, 0.2), direction(0.9, 2.0)),
        (direction(0.4, 0.2), -direction(0.2, 0.9)),
        (-direction(0.4, 0.2), direction(0.3, 0.2)),
        (-direction(0.3, 0.2), -direction(0.1, 2.0)),
    ] {
        let geometry = between(i, o);
        let frames = RayFrames::of_surface(&geometry).unwrap();
        let [a, b] = [
            Boundary::Crystal(plate.clone()),
            Boundary::Film(film.clone()),
        ]
        .map(|boundary| boundary.mueller(&geometry, &frames).unwrap().to_matrix());
        assert!((a - b).amax() < 1e-12 && a[(0, 0)] > 0.0, "{a} {b}");
    }
}

#[test]
fn a_plate_turned_with_the_surface_does_the_same() {
    // turning tangents, and with them the crystal, by an angle about the normal is turning the rays back
    let (plate, turn) = (crystal(InternalReflections::Coherent), 0.7);
    let geometry = |shift: f64, axes: f64| {
        let (sin, cos) = f64::sin_cos(axes);
        let tangents = [Vector3::new(cos, sin, 0.0), Vector3::new(-sin, cos, 0.0)];
        let (i, o) = (direction(0.6, 0.3 + shift), direction(0.9, 2.0 + shift));
        Geometry::new(i, o, tangents, green()).unwrap()
    };
    let of = |geometry: Geometry| {
        let frames = RayFrames::of_surface(&geometry).unwrap();
        plate.mueller(&geometry, &frames).unwrap().to_matrix()
    };
    assert!((of(geometry(0.0, turn)) - of(geometry(-turn, 0.0))).amax() < 1e-13);
    assert!((of(geometry(0.0, turn)) - of(geometry(0.0, 0.0))).amax() > 1e-3);
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
