//! A scene ready for rendering: geometry in world space, matter, light, and what rays find in it.

use glam::Vec3A;

use super::error::SceneError;
use crate::colour::{FIRST_NM, LAST_NM};
use crate::emitter::{Emitter, Target};
use crate::geometry::bvh::{Bvh, Primitive, Stack};
use crate::geometry::flat::Flat;
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Hit, Ray, offset_origin};
#[cfg(test)]
use crate::lights::Glance;
use crate::lights::Lights;
use crate::material::{Material, Matter, Traits};
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
    /// Of all matter in use together, and of each material.
    traits: Traits,
    material_traits: Vec<Traits>,
    /// Whether no ray can meet an emitter.
    unmet: bool,
    /// Whether rays side by side are tested against one shape after the other.
    pub(super) few: bool,
    /// Boxes around those shapes of which most rays miss the box.
    pub(super) boxes: Vec<Option<[Vec3A; 2]>>,
    pub(crate) lights: Lights,
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
    /// Builds the search tree over all shapes and meshes, notes what the matter needs, and weighs the light sources by
    /// their visible light.
    pub fn index(&mut self) {
        self.mesh_of.clear();
        self.first_triangle.clear();
        for (index, mesh) in self.meshes.iter().enumerate() {
            let first = self.mesh_of.len();
            self.first_triangle.push(first as u32);
            self.mesh_of.resize(first + mesh.len(), index as u32);
        }
        let triangles = self.mesh_of.len();
        self.bvh = Bvh::over(triangles + self.shapes.len(), |index| {
            let index = index as usize;
            if index >= triangles {
                return self.shapes[index - triangles].primitive();
            }
            let (mesh, triangle) = self.triangle(index);
            Primitive::Flat(Flat {
                corners: self.meshes[mesh].corners(triangle),
                parallelogram: false,
            })
        });
        self.material_traits = self.materials.iter().map(Matter::traits).collect();
        self.traits = self
            .used_materials()
            .into_iter()
            .map(|material| self.traits_of(material))
            .reduce(Traits::or)
            .unwrap_or_default();
        self.few = triangles == 0 && self.shapes.len() <= super::abreast::FEW;
        self.boxes = super::abreast::boxes(&self.shapes);
        self.unmet = !self.emitters.iter().any(Emitter::can_be_met);
        self.weigh_lights([FIRST_NM, LAST_NM]);
    }

    /// Indices of the materials that shapes are made of, in their order.
    pub fn used_materials(&self) -> Vec<u32> {
        let owners = self.shape_owners.iter().chain(&self.mesh_owners);
        let mut used: Vec<u32> = owners.map(|owner| owner.material).collect();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// Has paths look for flat elements and for emitters where there are none, and go on behind what is black: the image
    /// stays the same.
    pub fn follow_everything(&mut self) {
        for traits in &mut self.material_traits {
            traits.black = false;
        }
        self.traits.straight = true;
        self.unmet = false;
    }

    /// What transport has to know of the matter in the scene.
    pub fn traits(&self) -> Traits {
        self.traits
    }

    /// Whether no ray can meet an emitter: all of them are points or single directions.
    #[inline]
    pub fn emitters_are_unmet(&self) -> bool {
        self.unmet
    }

    /// Refuses a rendering from the first to the second wavelength, nm, where the scene's tables end earlier.
    ///
    /// # Errors
    ///
    /// At the table in the scene file.
    pub fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        self.materials
            .iter()
            .try_for_each(|material| material.check_wavelengths(range))
    }

    /// What the user should know of a rendering from the first to the second wavelength, nm; each thing once.
    pub fn doubts(&self, range: [f64; 2]) -> Vec<String> {
        let mut doubts: Vec<String> = vec![];
        for doubt in self.materials.iter().flat_map(|m| m.doubts(range)) {
            if !doubts.contains(&doubt) {
                doubts.push(doubt);
            }
        }
        doubts
    }

    /// What transport has to know of one material.
    #[inline]
    pub fn traits_of(&self, material: u32) -> Traits {
        self.material_traits[material as usize]
    }

    /// Number of triangles, and of nodes and leaf blocks of the search tree.
    pub fn size(&self) -> (usize, (usize, usize)) {
        (self.mesh_of.len(), self.bvh.size())
    }

    /// Scratch space for tracing, one a thread.
    pub fn stack(&self) -> Stack {
        self.bvh.stack()
    }

    /// The mesh of a triangle of the scene, and its number in it.
    #[inline]
    fn triangle(&self, index: usize) -> (usize, usize) {
        let mesh = self.mesh_of[index] as usize;
        (mesh, index - self.first_triangle[mesh] as usize)
    }

    #[inline]
    fn trace<const ANY: bool>(&self, ray: &Ray, stack: &mut Stack) -> Option<Hit> {
        let triangles = self.mesh_of.len();
        self.bvh.traverse::<ANY>(ray, stack, |primitive, t_max| {
            let hit = self.shapes[primitive as usize - triangles].intersect(ray, t_max);
            hit.map(Vec3A::into)
        })
    }

    /// The nearest surface along a ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray, stack: &mut Stack) -> Option<Encounter> {
        let hit = self.trace::<false>(ray, stack)?;
        let triangle = hit.primitive as usize;
        let (surface, owner) = if triangle < self.mesh_of.len() {
            let (mesh, local) = self.triangle(triangle);
            (
                self.meshes[mesh].surface(local, hit.u, hit.v),
                self.mesh_owners[mesh],
            )
        } else {
            let shape = triangle - self.mesh_of.len();
            (
                self.shapes[shape].surface(ray, (hit.t, hit.u, hit.v)),
                self.shape_owners[shape],
            )
        };
        // vector by vector: whole it would be copied from place to place
        let Surface {
            position,
            error,
            normal,
            frame: Frame { s, t, n },
        } = surface;
        let frame = Frame { s, t, n };
        Some(Encounter {
            surface: Surface {
                position,
                error,
                normal,
                frame,
            },
            owner,
        })
    }

    /// The ray from a surface point toward a light source: `direction` is its unit direction, `target` its end if it
    /// has one. Lengths along it count in lengths of the whole way.
    #[inline]
    pub fn shadow_ray(from: &Surface, direction: Vec3A, target: Option<&Target>) -> Ray {
        let origin = offset_origin(from.position, from.error, from.normal, direction);
        let Some(target) = target else {
            return Ray {
                origin,
                direction,
                t_max: f32::INFINITY,
            };
        };
        let end = if target.normal == Vec3A::ZERO {
            target.position
        } else {
            offset_origin(target.position, target.error, target.normal, -direction)
        };
        // the source itself lies beyond t = 1
        Ray {
            origin,
            direction: end - origin,
            t_max: 1.0 - 1e-6,
        }
    }

    /// Whether nothing stands in a ray's way.
    #[inline]
    pub fn is_free(&self, ray: &Ray, stack: &mut Stack) -> bool {
        self.trace::<true>(ray, stack).is_none()
    }

    /// Weighs the light sources against each other by their light from the first to the second wavelength, nm, and makes
    /// them ready for it.
    pub fn weigh_lights(&mut self, range: [f64; 2]) {
        for emitter in &mut self.emitters {
            emitter.fit(range);
        }
        let glances: Vec<_> = self
            .emitters
            .iter()
            .map(|e| e.glance(self, range))
            .collect();
        self.lights = Lights::new(&glances);
    }

    /// Gives all light sources the same chance everywhere.
    #[cfg(test)]
    pub(crate) fn weigh_lights_evenly(&mut self) {
        self.lights = Lights::new(&vec![Glance::Outside(1.0); self.emitters.len()]);
    }

    /// Draws a light source for a vertex at `from`, and says with which probability.
    #[inline]
    pub fn choose_emitter(&self, from: Vec3A, choice: f32) -> Option<(&Emitter, f32)> {
        let (number, chance) = self.lights.choose(&self.emitters, from, choice)?;
        Some((self.emitters.get(number as usize)?, chance))
    }

    /// The probability of a light source in [`Scene::choose_emitter`].
    #[inline]
    pub fn chance_of_emitter(&self, emitter: u32, from: Vec3A) -> f32 {
        self.lights.chance(&self.emitters, emitter, from)
    }

    /// Density of connections to the point that a ray from `from` has hit.
    #[inline]
    pub fn density_of_hit(&self, emitter: u32, from: Vec3A, at: &Surface) -> f32 {
        self.emitters[emitter as usize].density_of_hit(self, from, at)
            * self.chance_of_emitter(emitter, from)
    }

    /// Density of connections for a direction in which a ray from `from` has left the scene.
    #[inline]
    pub fn density_of_miss(&self, from: Vec3A, frame: &Frame, direction: Vec3A) -> f32 {
        self.environment.map_or(0.0, |e| {
            let density = self.emitters[e as usize].density_of_miss(frame, direction);
            density * self.chance_of_emitter(e, from)
        })
    }
}
