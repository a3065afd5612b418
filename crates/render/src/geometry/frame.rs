//! Local frames at a surface point.

use glam::Vec3A;

/// A right-handed orthonormal frame: `s × t = n`. Matter is described in it, with `n` as third axis.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent: the axis U of anisotropic matter and of optical elements.
    pub s: Vec3A,
    /// Second tangent.
    pub t: Vec3A,
    /// Normal.
    pub n: Vec3A,
}

impl Frame {
    /// Some frame around a unit normal.
    ///
    /// Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
    #[inline]
    pub fn around(n: Vec3A) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            s: Vec3A::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3A::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// The frame around unit normal `n` whose first tangent is `tangent` projected; any frame if that is degenerate.
    #[inline]
    pub fn with_tangent(n: Vec3A, tangent: Vec3A) -> Self {
        let s = tangent - n * n.dot(tangent);
        let length = s.length();
        if length > 0.0 && length.is_finite() {
            let s = s / length;
            Self {
                s,
                t: n.cross(s),
                n,
            }
        } else {
            Self::around(n)
        }
    }

    /// The frame seen from the other side: U stays, V and the normal turn round. A proper rotation, so that the
    /// handedness of polarization is kept.
    #[inline]
    pub fn flipped(self) -> Self {
        Self {
            s: self.s,
            t: -self.t,
            n: -self.n,
        }
    }

    /// World to local coordinates.
    #[inline]
    pub fn to_local(self, v: Vec3A) -> Vec3A {
        Vec3A::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world coordinates.
    #[inline]
    pub fn to_world(self, v: Vec3A) -> Vec3A {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}
