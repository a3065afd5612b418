//! Shapes and rays side by side: one shape, a ray a lane.

use std::f32::consts::TAU;

use glam::{DVec3, Vec3A};

use super::cube::Cube;
use super::rectangle::{FAR, LOW, Rectangle};
use super::sphere::Sphere;
use crate::geometry::ray::{Ray, gamma};
use crate::lanes::{Axes, Double, MOST, Mask, Real, V3, atan2, sin_cos_turns};

/// A [`Ray`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Rays<R> {
    /// Where they start, metres.
    pub origin: V3<R>,
    /// Their directions.
    pub direction: V3<R>,
    /// Where they end.
    pub t_max: R,
}

impl<R: Real> Rays<R> {
    /// One by one.
    #[inline(always)]
    pub fn lanes(&self) -> [Ray; MOST] {
        let (origin, direction) = (self.origin.lanes(), self.direction.lanes());
        let t_max = self.t_max.lanes();
        let mut all = [Ray {
            origin: Vec3A::ZERO,
            direction: Vec3A::Z,
            t_max: 0.0,
        }; MOST];
        for (lane, ray) in all.iter_mut().enumerate().take(R::LANES) {
            ray.origin = origin[lane];
            ray.direction = direction[lane];
            ray.t_max = t_max[lane];
        }
        all
    }
}

/// A [`Surface`](super::Surface) a lane.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<R> {
    /// Position, metres.
    pub position: V3<R>,
    /// Half-widths of the box that contains the true point.
    pub error: V3<R>,
    /// Geometric normal.
    pub normal: V3<R>,
    /// Shading normal and axis U.
    pub axes: Axes<R>,
}

impl<R: Real> Surfaces<R> {
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: &Self, b: &Self) -> Self {
        Self {
            position: V3::select(mask, a.position, b.position),
            error: V3::select(mask, a.error, b.error),
            normal: V3::select(mask, a.normal, b.normal),
            axes: Axes::select(mask, a.axes, b.axes),
        }
    }
}

/// Where rays meet a shape: distance and two parameters.
#[derive(Clone, Copy, Debug)]
pub struct Hits<R: Real> {
    /// Where they do.
    pub exist: R::M,
    /// Distance in lengths of the direction.
    pub t: R,
    /// First parameter.
    pub u: R,
    /// Second parameter.
    pub v: R,
}

/// Points on light sources.
#[derive(Clone, Copy, Debug)]
pub struct AreaSamples<R: Real> {
    /// Where there is one.
    pub exist: R::M,
    /// Position.
    pub position: V3<R>,
    /// Half-widths of the box that contains the true point.
    pub error: V3<R>,
    /// Front-side normal.
    pub normal: V3<R>,
    /// Density per steradian.
    pub pdf: R,
}

/// Start points off surfaces: see [`offset_origin`](crate::geometry::ray::offset_origin).
#[inline(always)]
pub fn offset_origins<R: Real>(p: V3<R>, error: V3<R>, normal: V3<R>, direction: V3<R>) -> V3<R> {
    let reach = error * R::splat(1.0 + gamma(16)) + p.abs() * R::splat(f32::EPSILON);
    let distance = normal.abs().dot(reach);
    p + normal * distance.copysign(direction.dot(normal))
}

/// What rays contribute to tests against flat shapes: see `geometry/flat.rs`.
#[derive(Clone, Copy, Debug)]
pub struct Shears<R> {
    origin: V3<R>,
    /// Rows of the matrix that puts a ray along its largest axis and shears the others by it. Of each row one number is
    /// 1, so that a product with it rounds as the shear by itself does.
    rows: [V3<R>; 3],
    inverse: R,
}

impl<R: Real> Shears<R> {
    /// The frames in which the rays run along their third axis.
    #[inline(always)]
    pub fn new(rays: &Rays<R>) -> Self {
        let d = rays.direction;
        let size = d.abs();
        let x_over_y = size.x.gt(size.y);
        let x = x_over_y & size.x.gt(size.z);
        let y = !x_over_y & size.y.gt(size.z);
        let one = R::one();
        let (x, y, z) = (one.only(x), one.only(y), one.only(!(x | y)));
        // along z: (x, y, z); along x: (y, z, x); along y: (z, x, y)
        let (first, second, third) = (V3::new(z, x, y), V3::new(y, z, x), V3::new(x, y, z));
        let along = d.dot(third);
        // the same sense of rotation seen along the ray
        let swapped = along.lt(R::zero());
        let (first, second) = (
            V3::select(swapped, second, first),
            V3::select(swapped, first, second),
        );
        let inverse = along.recip();
        Self {
            origin: rays.origin,
            rows: [
                first - third * (d.dot(first) * inverse),
                second - third * (d.dot(second) * inverse),
                third,
            ],
            inverse,
        }
    }

    #[inline(always)]
    fn sheared(&self, corner: Vec3A) -> [R; 3] {
        let to = V3::splat(corner) - self.origin;
        let [x, y, z] = self.rows;
        [to.dot(x), to.dot(y), to.dot(z)]
    }

    /// Where the rays meet the parallelogram of three corners closer than `t_max`.
    #[inline(always)]
    pub fn meet(&self, corners: [Vec3A; 3], t_max: R) -> Hits<R> {
        let [ax, ay, az] = self.sheared(corners[0]);
        let [bx, by, bz] = self.sheared(corners[1]);
        let [cx, cy, cz] = self.sheared(corners[2]);
        let u = cx * by - bx * cy;
        let v = ax * cy - cx * ay;
        let w = bx * ay - ax * by;
        let det = u + v + w;
        let (p, q) = (det - v, det - w);
        let lowest = p.min(q).min(v).min(w);
        let highest = p.max(q).max(v).max(w);
        let zero = R::zero();
        let inside = zero.le(lowest) | highest.le(zero);
        let inverse = det.recip();
        let t = (u * az + v * bz + w * cz) * self.inverse * inverse;
        Hits {
            exist: inside & zero.lt(t) & t.lt(t_max),
            t,
            u: v * inverse,
            v: w * inverse,
        }
    }
}

/// A vector a lane in double precision.
#[derive(Clone, Copy)]
struct Wide<D>([D; 3]);

impl<D: Double> Wide<D> {
    #[inline(always)]
    fn of(v: V3<D::Single>) -> Self {
        Self([D::wide(v.x), D::wide(v.y), D::wide(v.z)])
    }
    #[inline(always)]
    fn splat(v: DVec3) -> Self {
        Self([D::splat(v.x), D::splat(v.y), D::splat(v.z)])
    }
    #[inline(always)]
    fn along(self, v: Vec3A) -> D {
        self.dot(Self::splat(v.as_dvec3()))
    }
    #[inline(always)]
    fn minus(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
    #[inline(always)]
    fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }
    #[inline(always)]
    fn dot(self, o: Self) -> D {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }
}

impl Sphere {
    /// Where rays meet it.
    #[inline(always)]
    pub(crate) fn meet<R: Real>(&self, rays: &Rays<R>, t_max: R) -> Hits<R> {
        let d = Wide::<R::D>::of(rays.direction);
        let to_centre = Wide::splat(self.centre_f64).minus(Wide::of(rays.origin));
        let (squared, along) = (d.dot(d), to_centre.dot(d));
        let across = to_centre.cross(d);
        let radius2 = R::D::splat(self.radius_f64 * self.radius_f64);
        let half = radius2 * squared - across.dot(across);
        let missed = half.is_negative();
        let half = half.max(R::D::splat(0.0)).sqrt();
        let scale = R::D::splat(1.0) / squared;
        let (near, far) = (
            ((along - half) * scale).narrow(),
            ((along + half) * scale).narrow(),
        );
        let t = R::select(near.gt(R::zero()), near, far);
        Hits {
            exist: !missed & t.gt(R::zero()) & t.lt(t_max),
            t,
            u: R::zero(),
            v: R::zero(),
        }
    }

    /// Its surface at hits.
    #[inline(always)]
    pub(crate) fn surfaces<R: Real>(&self, rays: &Rays<R>, t: R) -> Surfaces<R> {
        let centre = V3::splat(self.centre);
        let from_centre = rays.origin - centre + rays.direction * t;
        let sense = R::splat(self.sense);
        let along_u = V3::splat(self.pole).cross(from_centre) * sense;
        let (distance2, across2) = (from_centre.squared(), along_u.squared());
        let outward = from_centre * distance2.sqrt().recip();
        let u = along_u * across2.sqrt().recip();
        let normal = outward * R::splat(self.side);
        let mut axes = Axes {
            s: u,
            t: normal.cross(u),
            n: normal,
        };
        let clear = across2.gt(R::splat(0.25) * distance2);
        if (!clear & R::everywhere()).any() {
            // next to a pole
            let tangent = V3::splat(self.pole).cross(outward) * sense;
            let s = tangent - normal * normal.dot(tangent);
            let length = s.squared().sqrt();
            let s = s * length.recip();
            let near = Axes {
                s,
                t: normal.cross(s),
                n: normal,
            };
            let known = length.gt(R::zero());
            let near = Axes::select(known, near, Axes::around(normal));
            axes = Axes::select(clear, axes, near);
        }
        Surfaces {
            position: centre + outward * R::splat(self.radius),
            error: V3::splat(self.error),
            normal,
            axes,
        }
    }

    /// sin² of the half angle under which it is seen, and where that is from outside.
    #[inline(always)]
    fn half_angles<R: Real>(&self, from: V3<R>) -> (R, R::M) {
        let distance2 = (V3::splat(self.centre) - from).squared();
        let sin2 = R::splat(self.radius * self.radius) / distance2;
        (sin2, sin2.lt(R::splat(1.0 - 1e-4)))
    }

    /// Points on it, for light that reaches `from`.
    #[inline(always)]
    pub(crate) fn samples<R: Real>(&self, from: V3<R>, [u, v]: [R; 2]) -> AreaSamples<R> {
        let (one, centre) = (R::one(), V3::splat(self.centre));
        let (sin2_max, outside) = self.half_angles(from);
        let (sin_phi, cos_phi) = sin_cos_turns(v);
        let cap = sin2_max / (one + (one - sin2_max).max(R::zero()).sqrt());
        let rise = cap * u;
        let sin2 = rise * (R::splat(2.0) - rise);
        let share = sin2 / sin2_max;
        let cos_alpha =
            sin2 * sin2_max.sqrt().recip() + (one - rise) * (one - share).max(R::zero()).sqrt();
        let sin_alpha = (one - cos_alpha * cos_alpha).max(R::zero()).sqrt();
        let axis = Axes::around((from - centre).normalize());
        let seen = axis.to_world(V3::new(sin_alpha * cos_phi, sin_alpha * sin_phi, cos_alpha));
        // all of it, from inside or very near
        let z = one - u - u;
        let r = (one - z * z).max(R::zero()).sqrt();
        let any = V3::new(cos_phi * r, sin_phi * r, z);
        let outward = V3::select(outside, seen, any);
        let position = centre + outward * R::splat(self.radius);
        let normal = outward * R::splat(self.side);
        let by_cone = (R::splat(TAU) * cap).recip();
        let by_area = area_densities(self.area(), from, position, normal);
        let pdf = R::select(outside, by_cone, by_area);
        AreaSamples {
            exist: pdf.gt(R::zero()) & pdf.lt(R::splat(f32::INFINITY)),
            position,
            error: V3::splat(self.error),
            normal,
            pdf,
        }
    }

    /// Densities of [`Sphere::samples`].
    #[inline(always)]
    pub(crate) fn densities<R: Real>(&self, from: V3<R>, at: &Surfaces<R>) -> R {
        let one = R::one();
        let (sin2, outside) = self.half_angles(from);
        let cap = sin2 / (one + (one - sin2).max(R::zero()).sqrt());
        let by_area = area_densities(self.area(), from, at.position, at.normal);
        R::select(outside, (R::splat(TAU) * cap).recip(), by_area)
    }
}

impl Cube {
    /// Where rays meet it; the first parameter is the index of the face.
    #[inline(always)]
    pub(crate) fn meet<R: Real>(&self, rays: &Rays<R>, t_max: R) -> Hits<R> {
        let from = rays.origin - V3::splat(self.centre);
        let (zero, one) = (R::zero(), R::one());
        let (mut near, mut far) = (R::splat(f32::NEG_INFINITY), R::splat(f32::INFINITY));
        let (mut near_face, mut far_face) = (zero, zero);
        for (axis, row) in self.rows.iter().enumerate() {
            let row = V3::splat(*row);
            let o = row.dot(from);
            let inverse = row.dot(rays.direction).recip();
            let (a, b) = ((-one - o) * inverse, (one - o) * inverse);
            let low_first = inverse.ge(zero);
            let (enter, leave) = (R::select(low_first, a, b), R::select(low_first, b, a));
            let (low, high) = (R::splat((2 * axis) as f32), R::splat((2 * axis + 1) as f32));
            // comparisons are false for what is not a number: a ray within the plane of a face is not clipped by it
            let enters = enter.gt(near);
            near = R::select(enters, enter, near);
            near_face = R::select(enters, R::select(low_first, low, high), near_face);
            let leaves = leave.lt(far);
            far = R::select(leaves, leave, far);
            far_face = R::select(leaves, R::select(low_first, high, low), far_face);
        }
        let outside = near.gt(zero);
        let t = R::select(outside, near, far);
        Hits {
            exist: near.le(far) & t.gt(zero) & t.lt(t_max),
            t,
            u: R::select(outside, near_face, far_face),
            v: zero,
        }
    }

    /// Its surface at hits.
    #[inline(always)]
    pub(crate) fn surfaces<R: Real>(&self, rays: &Rays<R>, t: R, face: R) -> Surfaces<R> {
        let centre = V3::splat(self.centre);
        let p = rays.origin - centre + rays.direction * t;
        let mut position = centre;
        let none = V3::splat(Vec3A::ZERO);
        let mut axes = Axes {
            s: none,
            t: none,
            n: none,
        };
        for axis in 0..3 {
            let mut along = V3::splat(self.rows[axis]).dot(p).clamp(-1.0, 1.0);
            for (side, place) in [(2 * axis, -1.0), (2 * axis + 1, 1.0)] {
                let here = face.eq(R::splat(side as f32));
                along = R::select(here, R::splat(place), along);
                let frame = &self.faces[side];
                let own = Axes {
                    s: V3::splat(frame.s),
                    t: V3::splat(frame.t),
                    n: V3::splat(frame.n),
                };
                axes = Axes::select(here, own, axes);
            }
            position = position + V3::splat(self.edges[axis]) * along;
        }
        Surfaces {
            position,
            error: V3::splat(self.error),
            normal: axes.n,
            axes,
        }
    }
}

/// See [`solid_angle_density`](super::solid_angle_density).
#[inline(always)]
fn area_densities<R: Real>(area: f32, from: V3<R>, position: V3<R>, normal: V3<R>) -> R {
    let to = position - from;
    let squared = to.squared();
    squared * squared.sqrt() / (to.dot(normal).abs() * R::splat(area))
}

/// Rectangles on the spheres of directions: see `spherical_rectangle.rs`.
struct Seen<R: Real> {
    x: [R::D; 2],
    y: [R::D; 2],
    height: R::D,
    start: [R::D; 2],
    solid_angle: R,
    foot: [R::D; 2],
    /// Where they are drawn from.
    known: R::M,
}

/// Both sides of an edge, from the foot of the perpendicular.
#[inline(always)]
fn sides<D: Double>(half: f64, foot: D) -> [D; 2] {
    [D::splat(-half) - foot, D::splat(half) - foot]
}

/// A corner as a complex number.
#[inline(always)]
fn corner<D: Double>(h: D, x: D, y: D) -> [D; 2] {
    [h * (h * h + x * x + y * y).sqrt(), x * y]
}

/// −a b* of complex numbers.
#[inline(always)]
fn minus_product<D: Double>(a: [D; 2], b: [D; 2]) -> [D; 2] {
    [-(a[0] * b[0] + a[1] * b[1]), a[0] * b[1] - a[1] * b[0]]
}

/// A place from the middle as a parameter in [0, 1].
#[inline(always)]
fn share<R: Real>(along: R::D, half: f32) -> R {
    let half = R::D::splat(0.5 / f64::from(half));
    (R::D::splat(0.5) + half * along)
        .max(R::D::splat(0.0))
        .min(R::D::splat(1.0))
        .narrow()
}

/// y/√(across + y²).
#[inline(always)]
fn sine<D: Double>(y: D, across: D) -> D {
    y / (across + y * y).sqrt()
}

impl Rectangle {
    /// Three of its corners, as the search tree knows it.
    #[inline(always)]
    pub(crate) fn corners(&self) -> [Vec3A; 3] {
        let corner = self.centre - self.half_u - self.half_v;
        [
            corner,
            corner + self.half_u * 2.0,
            corner + self.half_v * 2.0,
        ]
    }

    /// Its surface at parameters in [0, 1].
    #[inline(always)]
    pub(crate) fn surfaces<R: Real>(&self, u: R, v: R) -> Surfaces<R> {
        let (u, v) = (u + u - R::one(), v + v - R::one());
        Surfaces {
            position: V3::splat(self.centre)
                + V3::splat(self.half_u) * u
                + V3::splat(self.half_v) * v,
            error: V3::splat(self.error),
            normal: V3::splat(self.frame.n),
            axes: Axes {
                s: V3::splat(self.frame.s),
                t: V3::splat(self.frame.t),
                n: V3::splat(self.frame.n),
            },
        }
    }

    #[inline(always)]
    fn seen_from<R: Real>(&self, from: V3<R>) -> Option<Seen<R>> {
        let [a, b] = self.half;
        let squared = a * a + b * b;
        let distance2 = (from - V3::splat(self.centre)).squared();
        let near = distance2.le(R::splat(FAR * squared));
        if !near.any() {
            return None;
        }
        let [a, b] = self.half.map(f64::from);
        let to = Wide::<R::D>::of(from).minus(Wide::splat(self.centre.as_dvec3()));
        let height = to.along(self.frame.n);
        let height = height.max(-height);
        let least = LOW * LOW * f64::from(squared);
        let high = (R::D::splat(least) - height * height).is_negative();
        let foot = [
            to.along(self.half_u) * R::D::splat(a.recip()),
            to.along(self.half_v) * R::D::splat(b.recip()),
        ];
        let (x, y) = (sides::<R::D>(a, foot[0]), sides::<R::D>(b, foot[1]));
        let h = height;
        let start = minus_product(corner(h, x[0], y[1]), corner(h, x[0], y[0]));
        let end = minus_product(corner(h, x[1], y[1]), corner(h, x[1], y[0]));
        // of complex numbers; the second conjugate, so that the sign goes
        let whole = minus_product([-end[0], -end[1]], start);
        let size = (whole[0] * whole[0] + whole[1] * whole[1]).sqrt();
        let solid_angle = atan2((whole[1] / size).narrow(), (whole[0] / size).narrow());
        let under =
            x[0].is_negative() & (-x[1]).is_negative() & y[0].is_negative() & (-y[1]).is_negative();
        let turned = solid_angle.lt(R::zero()) & under;
        let solid_angle = R::select(turned, solid_angle + R::splat(TAU), solid_angle);
        let norm = (start[0] * start[0] + start[1] * start[1]).sqrt();
        Some(Seen {
            x,
            y,
            height,
            start: [start[0] / norm, start[1] / norm],
            solid_angle,
            foot,
            known: near & high & solid_angle.ge(R::splat(super::spherical_rectangle::LEAST)),
        })
    }

    /// Points on it, for light that reaches `from`.
    #[inline(always)]
    pub(crate) fn samples<R: Real>(&self, from: V3<R>, [u, v]: [R; 2]) -> AreaSamples<R> {
        let (mut at_u, mut at_v) = (u, v);
        let seen = self.seen_from(from);
        if let Some(seen) = &seen {
            let [x, y] = seen.points([u, v]);
            at_u = R::select(seen.known, share::<R>(x + seen.foot[0], self.half[0]), u);
            at_v = R::select(seen.known, share::<R>(y + seen.foot[1], self.half[1]), v);
        }
        let at = self.surfaces(at_u, at_v);
        let by_area = area_densities(self.area(), from, at.position, at.normal);
        let pdf = match &seen {
            Some(seen) => R::select(seen.known, seen.solid_angle.recip(), by_area),
            None => by_area,
        };
        AreaSamples {
            exist: pdf.gt(R::zero()) & pdf.lt(R::splat(f32::INFINITY)),
            position: at.position,
            error: at.error,
            normal: at.normal,
            pdf,
        }
    }

    /// Densities of [`Rectangle::samples`].
    #[inline(always)]
    pub(crate) fn densities<R: Real>(&self, from: V3<R>, at: &Surfaces<R>) -> R {
        let by_area = area_densities(self.area(), from, at.position, at.normal);
        match self.seen_from(from) {
            Some(seen) => R::select(seen.known, seen.solid_angle.recip(), by_area),
            None => by_area,
        }
    }
}

impl<R: Real> Seen<R> {
    /// Points uniform in solid angle, from the foot of the perpendicular.
    #[inline(always)]
    fn points(&self, [u, v]: [R; 2]) -> [R::D; 2] {
        let ([x0, x1], [y0, y1], h) = (self.x, self.y, self.height);
        let h2 = h * h;
        let turns = u * self.solid_angle * R::splat(0.5 / TAU);
        let (sin, cos) = sin_cos_turns(turns);
        let (sin, cos) = (R::D::wide(sin), R::D::wide(cos));
        let norm = R::D::splat(1.0) / (sin * sin + cos * cos);
        // twice the half angle
        let (cos2, sin2) = ((cos * cos - sin * sin) * norm, (cos + cos) * sin * norm);
        let phi = [
            self.start[0] * cos2 - self.start[1] * sin2,
            self.start[0] * sin2 + self.start[1] * cos2,
        ];
        let near = h2 + y0 * y0;
        let f = -(y0 / near.sqrt() * phi[0]) - y1 / (h2 + y1 * y1).sqrt();
        let zero = R::D::splat(0.0);
        let rest = f * f - h2 / near * phi[1] * phi[1];
        let sign = R::D::wide(R::one().copysign(f.narrow()));
        let x = h * phi[1] * sign / rest.max(zero).sqrt();
        let x = x.max(x0).min(x1);
        let across = h2 + x * x;
        let (g0, g1) = (sine(y0, across), sine(y1, across));
        let g = g0 + R::D::wide(v) * (g1 - g0);
        let y = g * (across / (R::D::splat(1.0) - g * g).max(zero)).sqrt();
        [x, y.max(y0).min(y1)]
    }
}
