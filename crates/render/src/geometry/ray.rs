//! Rays, and how they leave a surface without hitting it again.

use glam::Vec3A;

/// A half line or a segment: `origin + t direction`, `0 < t < t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, metres.
    pub origin: Vec3A,
    /// Direction; not necessarily of unit length: `t` counts in its length.
    pub direction: Vec3A,
    /// End of the segment.
    pub t_max: f32,
}

/// A hit: how far along the ray, on what, and where on it.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Position along the ray, in lengths of its direction.
    pub t: f32,
    /// Which primitive of the scene.
    pub primitive: u32,
    /// First parameter of the point on the primitive.
    pub u: f32,
    /// Second parameter.
    pub v: f32,
}

/// Bound on the relative error of `n` roundings in single precision: n ε/(1 − n ε), ε = 2⁻²⁴.
///
/// Source: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., Lemma 3.1.
pub const fn gamma(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON * 0.5);
    e / (1.0 - e)
}

/// A start point off the surface at `p`, on the side of `direction`, outside the box of half-widths `error` around `p`.
///
/// The box bounds how far the computed point may be from the surface. The result is moved along the normal until the
/// plane across it is clear of the box, and further by what the move itself may round, so a ray from it cannot meet the
/// surface that it left, whatever the scale of the scene.
///
/// Source: Pharr, Jakob, Humphreys, Physically Based Rendering, 4th ed., section 6.8.6; they step to the next number
/// instead, coordinate by coordinate.
#[inline]
pub fn offset_origin(p: Vec3A, error: Vec3A, normal: Vec3A, direction: Vec3A) -> Vec3A {
    // with n the normal and d the distance: the sum rounds by ε (|p| + d |n|) at most, ε = 2⁻²⁴, the product by ε d |n|;
    // d itself has six roundings, and n a length within two of 1
    let reach = error * (1.0 + gamma(16)) + p.abs() * f32::EPSILON;
    let distance = normal.abs().dot(reach);
    p + normal * distance.copysign(direction.dot(normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::uniform_sphere;

    #[test]
    fn an_offset_point_leaves_the_error_box_at_every_scale() {
        for exponent in [-20, -6, 0, 6, 20] {
            let scale = 10f32.powi(exponent);
            let p = Vec3A::new(0.3, -0.7, 0.11) * scale;
            let error = p.abs() * gamma(5);
            let normal = Vec3A::new(0.6, 0.0, 0.8);
            for sign in [1.0, -1.0] {
                let moved = offset_origin(p, error, normal, normal * sign);
                let along = (moved - p).as_dvec3().dot(normal.as_dvec3()) * f64::from(sign);
                assert!(
                    along >= f64::from(error.abs().dot(normal.abs())) * 0.99,
                    "{exponent} {sign} {along}"
                );
            }
        }
    }

    #[test]
    fn no_rounding_takes_an_offset_point_back_into_the_error_box() {
        for k in 0..40_000u64 {
            let stream = crate::sampler::SampleStream::new(1, 2, k);
            let [scale, ratio] = stream.pair(0);
            // boxes from far below the spacing of numbers around p to as wide as p is long
            let p = uniform_sphere(stream.pair(2)) * (40.0 * scale - 20.0).exp2();
            let error = p.abs() * (-30.0 * ratio).exp2();
            let normal = uniform_sphere(stream.pair(4));
            let direction = uniform_sphere(stream.pair(6));
            let moved = offset_origin(p, error, normal, direction);
            let n = normal.as_dvec3();
            let along = (moved.as_dvec3() - p.as_dvec3()).dot(n);
            let reach = error.as_dvec3().dot(n.abs());
            assert!(
                along * f64::from(direction.dot(normal)).signum() > reach,
                "{k}: {along} {reach}"
            );
            // and not much farther: by the spacing of numbers around p and a millionth of the box
            assert!(along.abs() < reach * (1.0 + 2e-6) + 4e-7 * f64::from(p.length()));
        }
    }
}
