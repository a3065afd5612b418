//! Rotations of the Poincaré sphere: from a pair of states, and back to axis and angle.

use nalgebra::{Matrix3, Unit, Vector3};

/// The rotation by the least angle that takes unit vector `from` to `to`: half a turn about `from`, then one about the
/// bisector.
pub(super) fn least_rotation(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let half_turn = |axis: &Vector3<f64>| axis * axis.transpose() * 2.0 - Matrix3::identity();
    let (sum, difference) = (from + to, from - to);
    let bisector = if difference.norm_squared() < 2.0 {
        sum.normalize()
    } else {
        // nearly opposite: the sum has few digits left, but has to be across the difference
        let along = difference.normalize();
        let across = |v: Vector3<f64>| v - along * along.dot(&v);
        let any = across(Vector3::ith(along.iamin(), 1.0)).normalize();
        across(across(sum))
            .try_normalize(4.0 * f64::EPSILON)
            .unwrap_or(any)
    };
    half_turn(&bisector) * half_turn(from)
}

/// Axis times angle of a rotation matrix, angle in `0.0..=π`.
pub(super) fn rotation_vector(m: &Matrix3<f64>) -> Vector3<f64> {
    let twice_sin = Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    );
    let angle = twice_sin.norm().atan2(m.trace() - 1.0);
    if angle < 3.0 {
        let sine = twice_sin.norm();
        return if sine > 0.0 {
            twice_sin * (angle / sine)
        } else {
            Vector3::zeros()
        };
    }
    // near half a turn the axis is in the symmetric part, (1 − cos δ) n nᵀ, its sign in the other
    let symmetric = (m + m.transpose()) * 0.5 - Matrix3::identity() * angle.cos();
    let largest = symmetric.diagonal().imax();
    let axis = Unit::new_normalize(symmetric.column(largest).into_owned());
    let sign = if axis.dot(&twice_sin) < 0.0 {
        -1.0
    } else {
        1.0
    };
    axis.into_inner() * (sign * angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn the_least_rotation_is_a_rotation_for_all_pairs() {
        let from = Vector3::new(0.48, 0.6, 0.64);
        let across = from.cross(&Vector3::x()).normalize();
        for angle in [0.0, 1e-12, 1e-3, 1.5, PI - 1e-3, PI - 1e-9, PI - 1e-14, PI] {
            let to = from * f64::cos(angle) + across * f64::sin(angle);
            let turn = least_rotation(&from, &to);
            assert!((turn * from - to).norm() < 2e-15, "{angle}");
            assert!((turn.transpose() * turn - Matrix3::identity()).amax() < 2e-15);
            assert!((turn.determinant() - 1.0).abs() < 2e-15);
            assert!((turn.trace() - (1.0 + 2.0 * f64::cos(angle))).abs() < 4e-15);
        }
    }

    proptest! {
        #[test]
        fn axis_and_angle_come_back(
            axis in prop::array::uniform3(-1.0..1.0f64),
            angle in prop_oneof![0.0..PI, 0.0..1e-9f64, 3.13..PI],
        ) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 1e-3);
            let axis = axis.normalize();
            let found = rotation_vector(&Rotation3::new(axis * angle).into_inner());
            // the sense of a rotation by nearly π is in sin δ alone
            let difference = (found - axis * angle).norm();
            prop_assert!(difference < 4e-15 || (angle > PI - 1e-14 && (found + axis * angle).norm() < 4e-15));
        }
    }
}
