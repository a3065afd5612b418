//! The geometry of a scene: shapes and meshes, within reach of single precision.

use glam::{DMat4, DVec3};

use super::Builder;
use crate::scene::error::SceneError;
use crate::scene::mesh::load_obj;
use crate::scene::object::Object;
use crate::scene::world::Body;
use crate::shape::{
    Shape, cube::Cube, cylinder::Cylinder, disk::Disk, mesh::PlacedMesh, rectangle::Rectangle,
    sphere::Sphere,
};

/// Largest distance from the origin that a scene may reach, metres: cubes of distances must fit into single precision.
const FARTHEST: f32 = 1e12;

impl Builder {
    /// The geometry of a shape.
    pub(super) fn body(&mut self, object: &Object, emits: bool) -> Result<Body, SceneError> {
        let to_world = object.transform("to_world")?;
        let flip = object.boolean("flip_normals", false)?;
        if object.plugin == "obj" {
            return self.mesh(object, &to_world, flip, emits);
        }
        let shape = match object.plugin.as_str() {
            "rectangle" => Shape::Rectangle(Rectangle::new(&to_world, flip)),
            "disk" => Shape::Disk(Disk::new(&to_world, flip)),
            "cube" => Shape::Cube(Box::new(Cube::new(&to_world, flip))),
            "sphere" => {
                let radius = positive(object, "radius", 1.0)?;
                let centre: DVec3 = object.optional_point("center")?.unwrap_or_default().into();
                notice_inside_out(object, &to_world, flip);
                Shape::Sphere(
                    Sphere::new(centre, radius, &to_world, flip)
                        .ok_or_else(|| not_rigid(object))?,
                )
            }
            _ => {
                let radius = positive(object, "radius", 1.0)?;
                let p0: DVec3 = object.optional_point("p0")?.unwrap_or([0.0; 3]).into();
                let p1: DVec3 = object
                    .optional_point("p1")?
                    .unwrap_or([0.0, 0.0, 1.0])
                    .into();
                if p0 == p1 {
                    return Err(object.error_at(
                        "p1",
                        "'p0' and 'p1' are the same point, expected a tube of some length",
                    ));
                }
                Shape::Cylinder(
                    Cylinder::new(p0, p1, radius, &to_world, flip)
                        .ok_or_else(|| not_rigid(object))?,
                )
            }
        };
        let bounds = shape.bounds();
        within_reach(object, bounds.min.abs().max(bounds.max.abs()).max_element())?;
        self.scene.shapes.push(shape);
        Ok(Body::Shape(self.scene.shapes.len() as u32 - 1))
    }

    fn mesh(
        &mut self,
        object: &Object,
        to_world: &DMat4,
        flip: bool,
        emits: bool,
    ) -> Result<Body, SceneError> {
        let path = object.path("filename")?;
        let mesh = load_obj(&path, object.boolean("flip_tex_coords", true)?)?;
        for notice in &mesh.notices {
            object.notice_at("filename", notice);
        }
        let face_normals = object.boolean("face_normals", false)?;
        if face_normals || mesh.normals.is_none() {
            notice_inside_out(object, to_world, flip);
        }
        let placed = PlacedMesh::new(mesh, to_world, face_normals, flip, emits);
        within_reach(object, placed.reach())?;
        if emits && placed.area() <= 0.0 {
            return Err(object.error_at(
                "filename",
                "an emitter on a mesh without area, expected triangles that can shine",
            ));
        }
        let known: usize = self.scene.meshes.iter().map(PlacedMesh::len).sum();
        if known + placed.len() >= crate::geometry::bvh::MAX_PRIMITIVES {
            return Err(object.error_at(
                "filename",
                "more than a thousand million triangles in the scene, expected fewer",
            ));
        }
        self.scene.meshes.push(placed);
        Ok(Body::Mesh(self.scene.meshes.len() as u32 - 1))
    }
}

fn positive(object: &Object, name: &str, default: f64) -> Result<f64, SceneError> {
    let value = object.float(name, default)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err(object.error_at(
            name,
            format!(
                "'{name}' of {} is {value}, expected a positive number",
                object.describe()
            ),
        ))
    }
}

fn not_rigid(object: &Object) -> SceneError {
    object.error_at(
        "to_world",
        format!(
            "a transform that stretches or skews {}, expected one that moves, turns, mirrors and scales evenly \
             (a <rotate> stretches if its axis is not of unit length)",
            object.describe()
        ),
    )
}

/// Tells the user of a mirroring transform that turns a shape inside out, unless `flip_normals` turns it back.
fn notice_inside_out(object: &Object, to_world: &DMat4, flip: bool) {
    if to_world.determinant() < 0.0 && !flip {
        object.notice_at(
            "to_world",
            format!(
                "the transform mirrors {}: its normals now point inward, as in Mitsuba; 'flip_normals' turns them back",
                object.describe()
            ),
        );
    }
}

/// Refuses what lies so far from the origin that single precision fails.
pub(crate) fn within_reach(object: &Object, reach: f32) -> Result<(), SceneError> {
    if reach <= FARTHEST {
        Ok(())
    } else {
        Err(object.error(format!(
            "{} reaches {reach:e} m from the origin, expected less than {FARTHEST:e} m; choose a larger unit of length",
            object.describe()
        )))
    }
}
