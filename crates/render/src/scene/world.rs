//! A scene ready for rendering: geometry in world space, matter, light, and what rays find in it.

use glam::Vec3A;

use crate::coherence::Coherence;
use crate::emitter::{Connection, Emitter};
use crate::geometry::bvh::{Bvh, Primitive, Stack};
use crate::geometry::flat::Flat;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Hit, Ray, offset_origin};
use crate::material::Material;
use crate::shape::mesh::PlacedMesh;
use crate::shape::{Shape, Surface};

/// One shape of the scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Index into [`Scene::shapes`].
    Shape(u32),
    /// Index into [`Scene::meshes`].
    Mesh(u32),
}

/// What a body is made of, and whether it shines.
#[derive(Clone, Copy, Debug)]
pub struct Owner {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::emitters`].
    pub emitter: Option<u32>,
}

/// Geometry, matter and light.
#[derive(Debug, Default)]
pub struct Scene {
    /// Shapes that are one primitive.
    pub shapes: Vec<Shape>,
    /// Triangle meshes.
    pub meshes: Vec<PlacedMesh>,
    /// Matter.
    pub materials: Vec<Material>,
    /// Light sources.
    pub emitters: Vec<Emitter>,
    /// The emitter that surrounds everything.
    pub environment: Option<u32>,
    /// Owner of each shape.
    pub shape_owners: Vec<Owner>,
    /// Owner of each mesh.
    pub mesh_owners: Vec<Owner>,
    /// Mesh of each triangle.
    mesh_of: Vec<u32>,
    /// First triangle of each mesh.
    first_triangle: Vec<u32>,
    bvh: Bvh,
}

/// A surface that a ray has met.
#[derive(Clone, Copy, Debug)]
pub struct Encounter {
    /// Where.
    pub surface: Surface,
    /// What.
    pub owner: Owner,
}

impl Scene {
    /// Builds the search tree over all shapes and meshes.
    pub fn index(&mut self) {
        let mut primitives = Vec::new();
        self.mesh_of.clear();
        self.first_triangle.clear();
        for (index, mesh) in self.meshes.iter().enumerate() {
            self.first_triangle.push(primitives.len() as u32);
            primitives.extend((0..mesh.len()).map(|t| {
                Primitive::Flat(Flat {
                    corners: mesh.corners(t),
                    parallelogram: false,
                })
            }));
            self.mesh_of.resize(primitives.len(), index as u32);
        }
        primitives.extend(self.shapes.iter().map(Shape::primitive));
        self.bvh = Bvh::build(&primitives);
    }

    /// Number of triangles, and of nodes and leaf blocks of the search tree.
    pub fn size(&self) -> (usize, (usize, usize)) {
        (self.mesh_of.len(), self.bvh.size())
    }

    /// Scratch space for tracing, one a thread.
    pub fn stack(&self) -> Stack {
        self.bvh.stack()
    }

    #[inline]
    fn trace<const ANY: bool>(&self, ray: &Ray, stack: &mut Stack) -> Option<Hit> {
        let triangles = self.mesh_of.len();
        self.bvh.traverse::<ANY>(ray, stack, |primitive, t_max| {
            self.shapes[primitive as usize - triangles].intersect(ray, t_max)
        })
    }

    /// The nearest surface along a ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray, stack: &mut Stack) -> Option<Encounter> {
        let hit = self.trace::<false>(ray, stack)?;
        let triangle = hit.primitive as usize;
        Some(if triangle < self.mesh_of.len() {
            let mesh = self.mesh_of[triangle] as usize;
            let local = triangle - self.first_triangle[mesh] as usize;
            Encounter {
                surface: self.meshes[mesh].surface(local, hit.u, hit.v),
                owner: self.mesh_owners[mesh],
            }
        } else {
            let shape = triangle - self.mesh_of.len();
            Encounter {
                surface: self.shapes[shape].surface(ray, (hit.t, hit.u, hit.v)),
                owner: self.shape_owners[shape],
            }
        })
    }

    /// Whether nothing stands between a surface point and a light source.
    #[inline]
    pub fn is_visible(&self, from: &Surface, connection: &Connection, stack: &mut Stack) -> bool {
        let origin = offset_origin(from.position, from.error, from.normal, connection.direction);
        let ray = match connection.target {
            None => Ray {
                origin,
                direction: connection.direction,
                t_max: f32::INFINITY,
            },
            Some(target) => {
                let end = if target.normal == Vec3A::ZERO {
                    target.position
                } else {
                    offset_origin(
                        target.position,
                        target.error,
                        target.normal,
                        -connection.direction,
                    )
                };
                // t counts in lengths of the whole way; the source itself lies beyond t = 1
                Ray {
                    origin,
                    direction: end - origin,
                    t_max: 1.0 - 1e-6,
                }
            }
        };
        self.trace::<true>(&ray, stack).is_none()
    }

    /// Draws a light source and a way to it; the density includes the choice of the source.
    #[inline]
    pub fn connect(
        &self,
        from: Vec3A,
        frame: &Frame,
        choice: f32,
        u: [f32; 2],
    ) -> Option<(&Emitter, Connection)> {
        let count = self.emitters.len();
        let emitter = self
            .emitters
            .get(((choice * count as f32) as usize).min(count.checked_sub(1)?))?;
        let connection = emitter.connect(self, from, frame, u)?;
        let share = (count as f32).recip();
        Some((
            emitter,
            Connection {
                density: connection.density * share,
                ..connection
            },
        ))
    }

    /// Density of [`Scene::connect`] for the point that a ray from `from` has hit.
    #[inline]
    pub fn density_of_hit(&self, emitter: u32, from: Vec3A, at: &Surface) -> f32 {
        self.emitters[emitter as usize].density_of_hit(self, from, at) / self.emitters.len() as f32
    }

    /// Density of [`Scene::connect`] for a direction in which a ray has left the scene.
    #[inline]
    pub fn density_of_miss(&self, frame: &Frame, direction: Vec3A) -> f32 {
        match self.environment.map(|e| &self.emitters[e as usize]) {
            Some(Emitter::Constant(e)) => e.density(frame, direction) / self.emitters.len() as f32,
            _ => 0.0,
        }
    }

    /// The coherence of the light that reaches a vertex from a surface, or from outside the scene (`None`).
    ///
    /// Plane waves for now: a path vertex has no footprint, and emitters are not cut into patches.
    #[inline]
    pub fn coherence(&self, _from: Option<&Encounter>) -> Coherence {
        Coherence::PLANE_WAVE
    }
}
