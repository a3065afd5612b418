//! Shapes: exact quadrics and triangle meshes, their surfaces, and points on them for light sampling.

pub mod abreast;
pub mod cube;
pub mod cylinder;
pub mod disk;
pub mod mesh;
pub mod rectangle;
pub mod sphere;
mod spherical_rectangle;

use glam::{DMat4, DVec3, Vec3A};

use crate::emitter::patch::{Cut, Outline};
use crate::geometry::bvh::{Bounds, Primitive};
use crate::geometry::frame::Frame;
use crate::geometry::ray::Ray;

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Position, metres.
    pub position: Vec3A,
    /// Half-widths of a box around the position that contains the true surface point.
    pub error: Vec3A,
    /// Geometric normal, unit, on the shape's front side.
    pub normal: Vec3A,
    /// Frame in which matter is described: shading normal and axis U.
    pub frame: Frame,
}

/// A point on a light source.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// Position.
    pub position: Vec3A,
    /// Half-widths of the box that contains the true point.
    pub error: Vec3A,
    /// Front-side normal, unit.
    pub normal: Vec3A,
    /// Density: per steradian as seen from the reference point.
    pub pdf: f32,
}

/// A shape that is one primitive (a mesh is many triangles: see [`mesh`]).
#[derive(Clone, Debug)]
pub enum Shape {
    /// Flat parallelogram.
    Rectangle(rectangle::Rectangle),
    /// Sphere.
    Sphere(sphere::Sphere),
    /// Flat ellipse.
    Disk(disk::Disk),
    /// Open tube.
    Cylinder(cylinder::Cylinder),
    /// Parallelepiped, which is the largest of them.
    Cube(Box<cube::Cube>),
}

impl Shape {
    /// A box around it, with margin for rounding.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Rectangle(s) => s.bounds(),
            Self::Sphere(s) => s.bounds(),
            Self::Disk(s) => s.bounds(),
            Self::Cylinder(s) => s.bounds(),
            Self::Cube(s) => s.bounds(),
        }
    }

    /// Its area, m².
    pub fn area(&self) -> f32 {
        match self {
            Self::Rectangle(s) => s.area(),
            Self::Sphere(s) => s.area(),
            Self::Disk(s) => s.area(),
            Self::Cylinder(s) => s.area(),
            Self::Cube(s) => s.area(),
        }
    }

    /// What the search tree knows of it: the whole of a rectangle, the box of any other shape.
    pub fn primitive(&self) -> Primitive {
        match self {
            Self::Rectangle(s) => Primitive::Flat(s.flat()),
            _ => Primitive::Other(self.bounds()),
        }
    }

    /// The nearest hit with `0 < t < t_max`: distance and two parameters for [`Shape::surface`].
    #[inline]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Vec3A> {
        let hit = match self {
            // found by the search tree itself
            Self::Rectangle(_) => None,
            Self::Sphere(s) => s.intersect(ray, t_max),
            Self::Disk(s) => s.intersect(ray, t_max),
            Self::Cylinder(s) => s.intersect(ray, t_max),
            Self::Cube(s) => s.intersect(ray, t_max),
        };
        // one vector: three numbers would go through memory one by one, and be waited for
        hit.map(|(t, u, v)| Vec3A::new(t, u, v))
    }

    /// The surface at a hit.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: (f32, f32, f32)) -> Surface {
        match self {
            Self::Rectangle(s) => s.surface(hit.1, hit.2),
            Self::Sphere(s) => s.surface(ray, hit.0),
            Self::Disk(s) => s.surface(hit.1, hit.2),
            Self::Cylinder(s) => s.surface(ray, hit.0),
            Self::Cube(s) => s.surface(ray, hit),
        }
    }

    /// Its outline, if it is flat.
    pub fn outline(&self) -> Option<Outline> {
        match self {
            Self::Rectangle(s) => Some(s.outline()),
            Self::Disk(s) => Some(s.outline()),
            _ => None,
        }
    }

    /// It as a light source in patches of at most `largest` (half-width, radians) for a vertex at `from`.
    ///
    /// `None` for shapes that are not cut: tubes, cubes, and what is seen from behind or from inside.
    pub fn cut(&self, from: Vec3A, largest: f32) -> Option<Cut<'_>> {
        match self {
            Self::Sphere(s) => Cut::sphere(s, from, largest),
            _ => Cut::flat(self.outline()?, from, largest),
        }
    }

    /// A random point on it, for light that reaches `reference`.
    #[inline]
    pub fn sample(&self, reference: Vec3A, u: [f32; 2]) -> Option<AreaSample> {
        match self {
            Self::Rectangle(s) => s.sample(reference, u),
            Self::Sphere(s) => s.sample(reference, u),
            Self::Disk(s) => by_area(s.sample(u), s.area(), reference),
            Self::Cylinder(s) => by_area(s.sample(u), s.area(), reference),
            Self::Cube(s) => by_area(s.sample(u), s.area(), reference),
        }
    }

    /// Density of [`Shape::sample`], per steradian, for a point that a ray from `reference` has hit.
    #[inline]
    pub fn pdf(&self, reference: Vec3A, at: &Surface) -> f32 {
        match self {
            Self::Sphere(s) => s.pdf(reference, at),
            Self::Rectangle(s) => s.pdf(reference, at),
            Self::Disk(s) => solid_angle_density(s.area(), reference, at.position, at.normal),
            Self::Cylinder(s) => solid_angle_density(s.area(), reference, at.position, at.normal),
            Self::Cube(s) => solid_angle_density(s.area(), reference, at.position, at.normal),
        }
    }
}

/// A point chosen uniformly by area, with its density per steradian.
#[inline]
pub fn by_area(surface: (Vec3A, Vec3A, Vec3A), area: f32, reference: Vec3A) -> Option<AreaSample> {
    let (position, error, normal) = surface;
    let pdf = solid_angle_density(area, reference, position, normal);
    (pdf.is_finite() && pdf > 0.0).then_some(AreaSample {
        position,
        error,
        normal,
        pdf,
    })
}

/// Density per steradian of points that are uniform over `area`: r²/(A |cos|).
#[inline]
pub fn solid_angle_density(area: f32, reference: Vec3A, position: Vec3A, normal: Vec3A) -> f32 {
    let to = position - reference;
    let squared = to.length_squared();
    squared * squared.sqrt() / (to.dot(normal).abs() * area)
}

/// An affine map split into its columns, in double precision; the shapes narrow what they keep.
pub(crate) struct Columns {
    pub(crate) origin: DVec3,
    pub(crate) x: DVec3,
    pub(crate) y: DVec3,
    pub(crate) z: DVec3,
}

impl Columns {
    pub(crate) fn of(to_world: &DMat4) -> Self {
        Self {
            origin: to_world.w_axis.truncate(),
            x: to_world.x_axis.truncate(),
            y: to_world.y_axis.truncate(),
            z: to_world.z_axis.truncate(),
        }
    }

    /// The common length of the three columns if they are perpendicular and equally long within 1e-6.
    pub(crate) fn uniform_scale(&self) -> Option<f64> {
        let (a, b, c) = (self.x.length(), self.y.length(), self.z.length());
        let scale = (a * b * c).cbrt();
        let close = |x: f64| (x - scale).abs() <= 1e-6 * scale;
        let upright = [self.x.dot(self.y), self.y.dot(self.z), self.z.dot(self.x)]
            .iter()
            .all(|d| d.abs() <= 1e-6 * scale * scale);
        (close(a) && close(b) && close(c) && upright && scale > 0.0).then_some(scale)
    }
}
