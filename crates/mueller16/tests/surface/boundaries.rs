//! Boundaries between air and glass.

use csdm::birefringent::{Crystal, CrystalLayer};
use mueller16::{Boundary, CrystalPlate, InternalReflections};
use mueller16::{ConductorInterface, DielectricInterface, Geometry};
use nalgebra::{Matrix3, Vector3};
use num_complex::Complex64;

pub(crate) fn dielectric() -> Boundary {
    Boundary::Dielectric(DielectricInterface::new(1.0, 1.5).unwrap())
}

pub(crate) fn gold() -> Boundary {
    Boundary::Conductor(ConductorInterface::new(1.0, 0.3, 2.8).unwrap())
}

/// A biaxial, absorbing and optically active plate on glass.
pub(crate) fn crystal(reflections: InternalReflections) -> Boundary {
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

/// Air above, glass below.
pub(crate) fn between(i: Vector3<f64>, o: Vector3<f64>) -> Geometry {
    let index = |z: f64| if z < 0.0 { 1.5 } else { 1.0 };
    Geometry::on_plane(i, o, crate::relief::green())
        .unwrap()
        .between(index(i.z), index(o.z))
        .unwrap()
}
