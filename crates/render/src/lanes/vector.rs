//! Vectors and frames, one a lane.

use std::ops::{Add, Mul, Neg, Sub};

use glam::Vec3A;

use super::{MOST, Real};

/// A vector a lane.
#[derive(Clone, Copy, Debug)]
pub struct V3<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Add for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<R: Real> Sub for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<R: Real> Mul<R> for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: R) -> Self {
        Self::new(self.x * o, self.y * o, self.z * o)
    }
}

impl<R: Real> Neg for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> V3<R> {
    /// From its components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
    /// The same in all lanes.
    #[inline(always)]
    pub fn splat(v: Vec3A) -> Self {
        Self::new(R::splat(v.x), R::splat(v.y), R::splat(v.z))
    }
    /// Lane by lane.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> Vec3A) -> Self {
        let (mut x, mut y, mut z) = ([0.0; MOST], [0.0; MOST], [0.0; MOST]);
        let places = x.iter_mut().zip(&mut y).zip(&mut z);
        for (lane, ((x, y), z)) in places.enumerate().take(R::LANES) {
            [*x, *y, *z] = f(lane).to_array();
        }
        Self::new(
            R::from_fn(|lane| x[lane]),
            R::from_fn(|lane| y[lane]),
            R::from_fn(|lane| z[lane]),
        )
    }
    /// All lanes; of [`MOST`](super::MOST) only as many count as there are.
    #[inline(always)]
    pub fn lanes(self) -> [Vec3A; MOST] {
        let (x, y, z) = (self.x.lanes(), self.y.lanes(), self.z.lanes());
        let mut all = [Vec3A::ZERO; MOST];
        for (lane, v) in all.iter_mut().enumerate().take(R::LANES) {
            *v = Vec3A::new(x[lane], y[lane], z[lane]);
        }
        all
    }
    /// From all lanes.
    #[inline(always)]
    pub fn from_lanes(all: &[Vec3A; MOST]) -> Self {
        Self::from_fn(|lane| all[lane])
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> R {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(
            self.y * o.z - self.z * o.y,
            self.z * o.x - self.x * o.z,
            self.x * o.y - self.y * o.x,
        )
    }
    /// Squared length.
    #[inline(always)]
    pub fn squared(self) -> R {
        self.dot(self)
    }
    /// Of unit length.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.squared().sqrt().recip()
    }
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: Self, b: Self) -> Self {
        Self::new(
            R::select(mask, a.x, b.x),
            R::select(mask, a.y, b.y),
            R::select(mask, a.z, b.z),
        )
    }
    /// Each component without its sign.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
}

/// A right-handed orthonormal frame a lane: see [`Frame`](crate::geometry::frame::Frame).
#[derive(Clone, Copy, Debug)]
pub struct Axes<R> {
    /// First tangent.
    pub s: V3<R>,
    /// Second tangent.
    pub t: V3<R>,
    /// Normal.
    pub n: V3<R>,
}

impl<R: Real> Axes<R> {
    /// Some frame around unit normals; source as for [`Frame::around`](crate::geometry::frame::Frame::around).
    #[inline(always)]
    pub fn around(n: V3<R>) -> Self {
        let one = R::one();
        let sign = one.copysign(n.z);
        let a = -(sign + n.z).recip();
        let b = n.x * n.y * a;
        Self {
            s: V3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)),
            t: V3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }
    /// World to local coordinates.
    #[inline(always)]
    pub fn to_local(self, v: V3<R>) -> V3<R> {
        V3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }
    /// Local to world coordinates.
    #[inline(always)]
    pub fn to_world(self, v: V3<R>) -> V3<R> {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
    /// Seen from the other side where the mask holds: U stays, V and the normal turn round.
    #[inline(always)]
    pub fn flipped_where(self, mask: R::M) -> Self {
        Self {
            s: self.s,
            t: V3::select(mask, -self.t, self.t),
            n: V3::select(mask, -self.n, self.n),
        }
    }
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: Self, b: Self) -> Self {
        Self {
            s: V3::select(mask, a.s, b.s),
            t: V3::select(mask, a.t, b.t),
            n: V3::select(mask, a.n, b.n),
        }
    }
}
