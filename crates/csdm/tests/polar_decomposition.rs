//! Lu and Chipman's decomposition finds planted factors, and those of a Jones matrix.

use csdm::{JonesMatrix, PolarDecomposition};
use nalgebra::{Matrix3, Matrix4, Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;
use stokes::Mueller;

fn close(a: Mueller, b: Mueller, tolerance: f64) -> bool {
    (a.to_matrix() - b.to_matrix()).amax() < tolerance
}

fn depolarizer(p: Vector3<f64>, block: Matrix3<f64>) -> Mueller {
    let mut matrix = Matrix4::identity();
    matrix.fixed_view_mut::<3, 1>(1, 0).copy_from(&p);
    matrix.fixed_view_mut::<3, 3>(1, 1).copy_from(&block);
    Mueller::from(matrix)
}

fn diagonal(factors: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(factors))
}

fn direction() -> impl Strategy<Value = (f64, f64)> {
    (-1.5..1.5f64, -0.7..0.7f64)
}

proptest! {
    #[test]
    fn planted_factors_are_found(
        axis in direction(), ratio in prop_oneof![0.05..1.0f64, 0.9999..1.0f64],
        fast in direction(), delta in prop_oneof![4 => 0.0..PI, 1 => 3.13..PI],
        factors in prop::array::uniform3(0.1..1.0f64), turn in prop::array::uniform3(-3.0..3.0f64),
        p in prop::array::uniform3(-0.2..0.2f64), negative in any::<bool>(),
    ) {
        let mean = 0.5 * (1.0 + ratio * ratio);
        let diattenuator = JonesMatrix::homogeneous(axis.0, axis.1, 1.0.into(), ratio.into()).mueller();
        let plate = JonesMatrix::elliptical_retarder(fast.0, fast.1, delta).mueller();
        let turn = Rotation3::new(Vector3::from(turn)).into_inner();
        let sign = if negative { -1.0 } else { 1.0 };
        let block = turn * diagonal(factors) * turn.transpose() * sign;
        let mueller = depolarizer(Vector3::from(p), block) * plate * diattenuator;
        let found = PolarDecomposition::of(&mueller).unwrap();
        // m_D⁻¹ enlarges rounding by 1/a ≤ 1/ratio twice, factors down to 0.1 by ten
        let tolerance = 2e-14 / (ratio * ratio);
        prop_assert!((found.transmittance - mean).abs() < 1e-15);
        prop_assert!(close(found.diattenuator, diattenuator * (1.0 / mean), tolerance));
        prop_assert!(close(found.depolarizer, depolarizer(Vector3::from(p), block), tolerance));
        prop_assert!(close(found.retarder, plate, 10.0 * tolerance));
        prop_assert!(close(found.product(), mueller, tolerance));
        let delta_found = Vector3::from(found.retardance());
        prop_assert!((delta_found.norm() - delta).abs() < 10.0 * tolerance);
        let (sin_psi, cos_psi) = (2.0 * fast.0).sin_cos();
        let (sin_chi, cos_chi) = (2.0 * fast.1).sin_cos();
        let expected = Vector3::new(cos_chi * cos_psi, cos_chi * sin_psi, sin_chi) * delta;
        if delta < PI - 1e-3 {
            prop_assert!((delta_found - expected).norm() < 100.0 * tolerance);
        }
    }

    #[test]
    fn a_jones_matrix_has_the_same_factors_as_its_mueller_matrix(
        n in prop::array::uniform8(-1.0..1.0f64),
    ) {
        let c = |i: usize| num_complex::Complex64::new(n[2 * i], n[2 * i + 1]);
        let jones = JonesMatrix::new(c(0), c(1), c(2), c(3));
        let [best, worst] = jones.singular_values();
        prop_assume!(worst > 0.05 * best && best > 0.05);
        let found = PolarDecomposition::of(&jones.mueller()).unwrap();
        let polar = jones.polar();
        // a = 2 σ₁σ₂/(σ₁² + σ₂²) is at least the ratio of the two
        let tolerance = 4e-14 * (best / worst).powi(2);
        prop_assert!(close(found.retarder, polar.retarder.mueller(), tolerance));
        let diattenuator = polar.diattenuator.mueller() * (1.0 / found.transmittance);
        prop_assert!(close(found.diattenuator, diattenuator, tolerance));
        prop_assert!(close(found.depolarizer, Mueller::identity(), tolerance));
        prop_assert!((Vector3::from(found.diattenuation()).norm() - jones.diattenuation()).abs() < 1e-13);
        prop_assert!((Vector3::from(found.retardance()).norm() - jones.retardance()).abs() < tolerance);
    }
}
