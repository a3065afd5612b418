//! Crystals, films and given matrices in a surface, against known ones.

use crate::boundaries::{between, crystal};
use crate::relief::{direction, green};
use csdm::birefringent::{Crystal, CrystalLayer};
use csdm::film::Layer;
use mueller16::{
    Boundary, CrystalPlate, Film, Flat, Geometry, InternalReflections, PlaneElement, RayFrames,
    Surface, Tolerance, element,
};
use nalgebra::Vector3;
use num_complex::Complex64;
use stokes::{Frame, Mueller, StokesVector};

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
fn a_quarter_wave_plate_lies_in_the_surface_as_documented() {
    // slow along x + y of the plate, z into the surface: along t1 − t2
    let axis = Vector3::new(1.0, 1.0, 0.0);
    let quartz = Crystal::uniaxial(1.54424.into(), 1.55335.into(), axis).unwrap();
    let layers = vec![CrystalLayer {
        crystal: quartz,
        thickness: crate::relief::WAVELENGTH / (4.0 * (1.55335 - 1.54424)),
    }];
    let single = InternalReflections::SinglePass;
    let plate = Boundary::Crystal(CrystalPlate::new(1.55, layers, 1.55.into(), single).unwrap());
    let surface = Surface::of_phases(plate, Flat);
    // from above a receiver has t1 right and −t2 up and sees it at +45°, from behind at −45°
    for (side, expected) in [
        (1.0, StokesVector::LEFT_CIRCULAR),
        (-1.0, StokesVector::RIGHT_CIRCULAR),
    ] {
        let i = Vector3::new(0.0, 0.0, side);
        let geometry = Geometry::on_plane(i, -i, green())
            .unwrap()
            .between(1.55, 1.55)
            .unwrap();
        let frame = Frame::with_x_along(-i, Vector3::x()).unwrap();
        let beams = surface
            .specular(&geometry, frame, Tolerance::ROUNDING)
            .unwrap();
        // all but 1e-5 of reflected light
        let out = beams[0].mueller * StokesVector::HORIZONTAL;
        assert!(
            (out - expected).to_vector().norm() < 1e-4,
            "{side}: {out:?}"
        );
    }
}

#[test]
fn light_along_the_axis_of_a_tilted_crystal_is_not_retarded() {
    // the axis leans toward the first tangent, into the surface; the medium matches the ordinary index
    let tilt: f64 = 0.6;
    let axis = Vector3::new(tilt.sin(), 0.0, tilt.cos());
    let crystal = Crystal::uniaxial(1.54.into(), 1.60.into(), axis).unwrap();
    let layers = vec![CrystalLayer {
        crystal,
        thickness: 5e-6,
    }];
    let coherent = InternalReflections::Coherent;
    let plate = Boundary::Crystal(CrystalPlate::new(1.54, layers, 1.54.into(), coherent).unwrap());
    let surface = Surface::of_phases(plate, Flat);
    let off = |i: Vector3<f64>| {
        let geometry = Geometry::on_plane(i, -i, green()).unwrap();
        let geometry = geometry.between(1.54, 1.54).unwrap();
        let frame = Frame::with_x_across(-i, Vector3::z()).unwrap();
        let beams = surface
            .specular(&geometry, frame, Tolerance::ROUNDING)
            .unwrap();
        (beams[0].mueller.to_matrix() - Mueller::identity().to_matrix()).amax()
    };
    // light travels along (sin, 0, −cos) in space, (sin, 0, cos) in the plate; errors of 4 ε k₀ d |M| = 3e-13
    assert!(off(Vector3::new(-tilt.sin(), 0.0, tilt.cos())) < 1e-12);
    assert!(off(Vector3::new(tilt.sin(), 0.0, tilt.cos())) > 0.1);
}

#[test]
fn near_the_normal_a_tilted_crystal_follows_the_sine() {
    // an axis halfway between normal and face: the retardance grows with the angle toward it, in its first power
    let axis = Vector3::new(1.0, 0.0, 1.0);
    let crystal = Crystal::uniaxial(1.54.into(), 1.60.into(), axis).unwrap();
    let layers = vec![CrystalLayer {
        crystal,
        thickness: 5e-6,
    }];
    let single = InternalReflections::SinglePass;
    let plate = Boundary::Crystal(CrystalPlate::new(1.0, layers, 1.0.into(), single).unwrap());
    let at = |sine: f64, azimuth: f64| {
        let i = Vector3::new(sine * azimuth.cos(), sine * azimuth.sin(), 1.0);
        let geometry = Geometry::on_plane(i, -i, green()).unwrap();
        let x = Frame::with_x_along(-i, Vector3::x()).unwrap();
        let frames = RayFrames {
            incident: x,
            outgoing: x,
        };
        // media of equal index: no facet but the surface itself
        let surface = Surface::of_phases(plate.clone(), Flat);
        let beams = surface.specular(&geometry, x, Tolerance::ROUNDING).unwrap();
        let turn = x.rotation_to(&beams[0].frames.outgoing);
        assert!((beams[0].mueller.to_matrix()).amax() <= 1.0, "{frames:?}");
        beams[0]
            .mueller
            .in_frames(stokes::FrameRotation::IDENTITY, turn.inverse())
            .to_matrix()
    };
    let straight = at(0.0, 0.0);
    for azimuth in [0.0, 0.7, 2.0] {
        // from 1e-4 on a parabola bends away by 1e-8·k₀d
        let slope = (at(1e-6, azimuth) - straight) / 1e-6;
        assert!(slope.amax() > 0.3, "{slope}");
        for sine in [1e-13, 1e-11, 1e-9, 3e-9, 1e-8, 1e-7] {
            let off = (at(sine, azimuth) - straight - slope * sine).amax();
            // roundings of phases of 100 rad; curvature 100 of the slope
            assert!(off < 1e-13 + 100.0 * sine * 1e-6, "{azimuth} {sine}: {off}");
        }
    }
}
