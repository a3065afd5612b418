//! Numbers that make no surface are refused, and what is not refused answers.

use csdm::birefringent::{Crystal, CrystalLayer};
use csdm::film::Layer;
use mueller16::{
    Boundary, ConductorInterface, CrystalPlate, DielectricInterface, Film, Flat, Geometry,
    GeometryError, InternalReflections, Passage, PlaneElement, RayFrames, Surface, SurfaceError,
    Tolerance,
};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::Mueller;

use crate::relief::{direction, green, heights};

/// Anything that is an f64.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1.0, 1.5, 5e-324, 1e-300, -1e-9, 1e-7,
            1e30, -1e300, f64::MAX,
        ]),
        1 => any::<f64>(),
        2 => -2.0..2.0f64,
    ]
}

#[test]
fn albedos_of_no_angle_and_no_medium_are_refused_at_once() {
    let surface = Surface::of_heights(Boundary::Mirror, heights(0.1, 2.0));
    let tolerance = Tolerance::relative(1e-3).unwrap();
    let albedo =
        |cosine, index, passage| surface.diffuse_albedo(cosine, green(), index, passage, tolerance);
    for cosine in [f64::NAN, f64::INFINITY, -0.5, 0.0, 1.5] {
        let found = albedo(cosine, 1.0, Passage::Reflection).unwrap_err();
        assert_eq!(
            found.to_string(),
            format!(
                "surface: the cosine of incidence is {cosine}, expected a number from 1e-9 to 1"
            )
        );
    }
    for index in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        let side = |found: SurfaceError| match found {
            SurfaceError::Geometry(GeometryError::Index { side, .. }) => side,
            other => panic!("{other}"),
        };
        assert_eq!(
            side(albedo(0.5, index, Passage::Reflection).unwrap_err()),
            "incident"
        );
        let into = Passage::TransmissionInto(index);
        assert_eq!(side(albedo(0.5, 1.0, into).unwrap_err()), "outgoing");
        assert!(
            surface
                .clone()
                .with_cap(green(), 1.0, into, tolerance)
                .is_err()
        );
    }
}

proptest! {
    #[test]
    fn no_number_makes_a_boundary_panic(n in prop::array::uniform6(wild()), m in prop::array::uniform16(wild()), side in any::<bool>()) {
        let layers = || vec![Layer { index: Complex64::new(n[1], n[2]), thickness: n[3] }];
        let mut boundaries = vec![];
        boundaries.extend(DielectricInterface::new(n[0], n[1]).map(Boundary::Dielectric));
        boundaries.extend(ConductorInterface::new(n[0], n[1], n[2]).map(Boundary::Conductor));
        boundaries.extend(Film::new(n[0], layers(), Complex64::new(n[4], n[5])).map(Boundary::Film));
        if let Ok(crystal) = Crystal::uniaxial(n[1].into(), n[2].into(), nalgebra::Vector3::new(n[3], n[4], n[5])) {
            let layer = vec![CrystalLayer { crystal, thickness: 1e-6 }];
            let plate = CrystalPlate::new(n[0], layer, 1.5.into(), InternalReflections::Coherent);
            boundaries.extend(plate.map(Boundary::Crystal));
        }
        let rows = |scale: f64| Mueller::from_rows([0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| scale * m[4 * r + c])));
        boundaries.extend(PlaneElement::new(&rows(0.0), &rows(1.0)).map(Boundary::Element));
        for boundary in boundaries {
            let [front, back] = boundary.indices();
            let i = direction(0.3, 0.4);
            let o = if side { direction(0.5, 3.0) } else { -direction(0.2, 0.4) };
            let (n_i, n_o) = (front.unwrap_or(1.0), if side { front } else { back }.unwrap_or(1.0));
            let Ok(geometry) = Geometry::on_plane(i, o, green()).unwrap().between(n_i, n_o) else { continue };
            let frames = RayFrames::of_surface(&geometry).unwrap();
            // an answer that is a number, or an error
            if let Ok(found) = boundary.mueller(&geometry, &frames) {
                prop_assert!(found.to_matrix().iter().all(|x| x.is_finite()), "{boundary:?} {found:?}");
            }
        }
    }

    #[test]
    fn no_number_makes_a_smooth_surface_panic(n in prop::array::uniform3(wild())) {
        let surface = Surface::of_heights(Boundary::Window, Flat);
        let tolerance = Tolerance::relative(1e-3).unwrap();
        for passage in [Passage::Reflection, Passage::TransmissionInto(n[2])] {
            if let Ok(albedo) = surface.diffuse_albedo(n[0], green(), n[1], passage, tolerance) {
                prop_assert_eq!(albedo, 0.0);
            }
            if let Ok(capped) = surface.clone().with_cap(green(), n[1], passage, tolerance) {
                prop_assert_eq!(capped.caps()[0].albedo_ratio(0.5).max(1e-200), 1e-200);
            }
        }
    }
}
