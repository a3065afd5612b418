//! From what the scene file says to a scene that can be rendered: every plugin reads its own parameters.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::camera::read_integrator;
use super::document::Document;
use super::error::SceneError;
use super::mesh::load_obj;
use super::object::Object;
use super::plugins;
use super::sensors::{Sensor, read_sensor};
use super::tag::Tag;
use super::world::{Body, Owner, Scene};
use crate::emitter::polarization::Polarization;
use crate::emitter::{
    Emitter, Kind, area::Area, constant::Constant, directional::Directional, egsm::Schell,
    laser::Laser, point::Point, rayleighsky::RayleighSky, spot::Spot,
};
use crate::film::FilmGeometry;
use crate::material::birefringent::Birefringent;
use crate::material::circular::Circular;
use crate::material::conductor::Conductor;
use crate::material::dielectric::Dielectric;
use crate::material::diffuse::Diffuse;
use crate::material::grating::Grating;
use crate::material::layered::Layered;
use crate::material::mueller::MuellerElement;
use crate::material::null::Null;
use crate::material::plastic::Plastic;
use crate::material::polarizer::Polarizer;
use crate::material::retarder::Retarder;
use crate::material::rotator::Rotator;
use crate::material::roughconductor::RoughConductor;
use crate::material::roughdielectric::RoughDielectric;
use crate::material::roughsurface::RoughSurface;
use crate::material::scatterer16::Scatterer16;
use crate::material::slits::Slits;
use crate::material::thindielectric::ThinDielectric;
use crate::material::twosided::TwoSided;
use crate::material::{Material, pplastic, roughplastic};
use crate::path::PathOptions;
use crate::sensor::Camera;
use crate::shape::{
    Shape, cube::Cube, cylinder::Cylinder, disk::Disk, mesh::PlacedMesh, rectangle::Rectangle,
    sphere::Sphere,
};

/// What the command line says instead of the scene file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// Size of the film, pixels.
    pub size: Option<[u32; 2]>,
    /// Crop window: x, y, width, height.
    pub crop: Option<[u32; 4]>,
}

/// A scene file, built.
#[derive(Debug)]
pub struct BuiltScene {
    /// Geometry, matter, light.
    pub scene: Scene,
    /// The sensor.
    pub camera: Camera,
    /// The film.
    pub film: FilmGeometry,
    /// The paths.
    pub paths: PathOptions,
    /// Samples a pixel.
    pub samples: u64,
    /// Name of the sampler plugin, which sets the sample count only.
    pub sampler: String,
    /// Plugin and place of each material, as the scene numbers them.
    pub material_names: Vec<String>,
    /// Plugin of each emitter.
    pub emitter_names: Vec<String>,
}

/// Largest distance from the origin that a scene may reach, metres: cubes of distances must fit into single precision.
const FARTHEST: f32 = 1e12;
/// Builds the scene that a document describes.
///
/// # Errors
///
/// The first thing in the file that cannot be used, with its place.
pub fn build(document: &Document, overrides: Overrides) -> Result<BuiltScene, SceneError> {
    let root = &document.root;
    let paths = match root.child(Tag::Integrator)? {
        Some(integrator) => read_integrator(&integrator)?,
        None => PathOptions::default(),
    };
    let Sensor {
        camera,
        film,
        samples,
        sampler,
    } = read_sensor(root, overrides)?;

    let mut builder = Builder::default();
    for emitter in root.children(Tag::Emitter) {
        builder.emitter(&emitter)?;
    }
    for shape in root.children(Tag::Shape) {
        builder.shape(&shape)?;
    }
    // definitions that nothing refers to are checked all the same
    for definition in document.definitions() {
        match definition.tag {
            Tag::Bsdf => builder.material(&definition).map(|_| ())?,
            _ => return Err(plugins::refuse(&definition)),
        }
    }
    root.finish()?;
    builder.scene.index();
    Ok(BuiltScene {
        scene: builder.scene,
        camera,
        film,
        paths,
        samples,
        sampler,
        material_names: builder.material_names,
        emitter_names: builder.emitter_names,
    })
}

/// A scene under construction.
#[derive(Default)]
struct Builder {
    scene: Scene,
    material_names: Vec<String>,
    emitter_names: Vec<String>,
    /// Materials that exist already, by their object in the file.
    known: HashMap<*const Object, u32>,
}

impl Builder {
    fn add_material(&mut self, material: Material, name: String) -> u32 {
        self.scene.materials.push(material);
        self.material_names.push(name);
        self.scene.materials.len() as u32 - 1
    }

    /// The material of an object, made once however often it is referred to.
    fn material(&mut self, object: &Rc<Object>) -> Result<u32, SceneError> {
        if let Some(&known) = self.known.get(&Rc::as_ptr(object)) {
            return Ok(known);
        }
        let material = read_material(object)?;
        let name = match &object.id {
            Some(id) => format!("{} '{id}' ({})", object.plugin, object.position),
            None => format!("{} ({})", object.plugin, object.position),
        };
        let index = self.add_material(material, name);
        self.known.insert(Rc::as_ptr(object), index);
        Ok(index)
    }

    fn add_emitter(&mut self, emitter: Emitter, object: &Object) -> u32 {
        self.scene.emitters.push(emitter);
        self.emitter_names
            .push(format!("{} ({})", object.plugin, object.position));
        self.scene.emitters.len() as u32 - 1
    }

    /// A source that is no shape.
    fn emitter(&mut self, object: &Object) -> Result<(), SceneError> {
        let (kind, placed) = match object.plugin.as_str() {
            "constant" => (Kind::Constant(Constant::read(object)?), DMat4::IDENTITY),
            "point" => (
                Kind::Point(Point::read(object)?),
                object.transform("to_world")?,
            ),
            "spot" => (
                Kind::Spot(Spot::read(object)?),
                object.transform("to_world")?,
            ),
            "directional" => {
                let (directional, placed) = Directional::read(object)?;
                (Kind::Directional(directional), placed)
            }
            "laser" => {
                let (laser, placed) = Laser::read(object)?;
                (Kind::Laser(laser), placed)
            }
            "rayleighsky" => (
                Kind::RayleighSky(Box::new(RayleighSky::read(object)?)),
                DMat4::IDENTITY,
            ),
            "area" | "egsm" => {
                return Err(object.error(format!(
                    "{} stands alone, expected it inside a shape",
                    object.describe()
                )));
            }
            _ => return Err(plugins::refuse(object)),
        };
        let polarization = match kind {
            // polarized by itself
            Kind::RayleighSky(_) => None,
            _ => Polarization::read(object, &placed)?,
        };
        object.finish()?;
        let emitter = Emitter { kind, polarization };
        let surrounds = emitter.surrounds();
        if surrounds && self.scene.environment.is_some() {
            return Err(
                object.error("second emitter that surrounds the scene, expected at most one")
            );
        }
        let index = self.add_emitter(emitter, object);
        if surrounds {
            self.scene.environment = Some(index);
        }
        Ok(())
    }

    /// A source that is a shape.
    fn shining(&mut self, emitter: &Object, shape: &Object, body: Body) -> Result<u32, SceneError> {
        let (kind, polarization) = match emitter.plugin.as_str() {
            "area" => (
                Kind::Area(Area::read(emitter, body)?),
                Polarization::read(emitter, &shape.transform("to_world")?)?,
            ),
            "egsm" => {
                let flat = match body {
                    Body::Shape(index) => self.scene.shapes[index as usize]
                        .outline()
                        .map(|outline| (index, outline)),
                    Body::Mesh(_) => None,
                };
                let (index, outline) = flat.ok_or_else(|| {
                    emitter.error(format!(
                        "{} inside {}, expected it inside a rectangle or a disk",
                        emitter.describe(),
                        shape.describe()
                    ))
                })?;
                let schell = Schell::read(emitter, index, outline)?;
                (Kind::Schell(Box::new(schell)), None)
            }
            plugin if plugins::supported(Tag::Emitter).contains(&plugin) => {
                return Err(emitter.error(format!(
                    "{} inside a shape, expected 'area' or 'egsm'",
                    emitter.describe()
                )));
            }
            _ => return Err(plugins::refuse(emitter)),
        };
        emitter.finish()?;
        Ok(self.add_emitter(Emitter { kind, polarization }, emitter))
    }

    fn shape(&mut self, object: &Rc<Object>) -> Result<(), SceneError> {
        if !plugins::supported(Tag::Shape).contains(&object.plugin.as_str()) {
            return Err(plugins::refuse(object));
        }
        let emitter = object.child(Tag::Emitter)?;
        let bsdf = object.child(Tag::Bsdf)?;
        let material = match &bsdf {
            Some(bsdf) => self.material(bsdf)?,
            None if emitter.is_some() => self.add_material(
                Material::Diffuse(Diffuse::black()),
                "black (default)".to_owned(),
            ),
            None => self.add_material(
                Material::Diffuse(Diffuse::default()),
                "diffuse (default)".to_owned(),
            ),
        };
        let body = self.body(object, emitter.is_some())?;
        let material = match &bsdf {
            Some(bsdf) => self.placed(material, bsdf, object, body)?,
            None => material,
        };
        let emitter = match emitter {
            Some(emitter) => Some(self.shining(&emitter, object, body)?),
            None => None,
        };
        let owner = Owner { material, emitter };
        match body {
            Body::Shape(_) => self.scene.shape_owners.push(owner),
            Body::Mesh(_) => self.scene.mesh_owners.push(owner),
        }
        object.finish()
    }

    /// Matter that has to know its shape, made for this one; other matter as it is.
    fn placed(
        &mut self,
        material: u32,
        bsdf: &Object,
        shape: &Object,
        body: Body,
    ) -> Result<u32, SceneError> {
        let Material::Slits(slits) = &self.scene.materials[material as usize] else {
            return Ok(material);
        };
        let outline = match body {
            Body::Shape(index) if shape.plugin == "rectangle" => {
                self.scene.shapes[index as usize].outline()
            }
            _ => None,
        };
        let outline = outline.ok_or_else(|| {
            bsdf.error(format!(
                "bsdf 'slits' on {}, expected it on a rectangle",
                shape.describe()
            ))
        })?;
        let slits = slits.placed(&outline).map_err(|e| shape.error(e))?;
        let name = self.material_names[material as usize].clone();
        Ok(self.add_material(Material::Slits(Box::new(slits)), name))
    }

    /// The geometry of a shape.
    fn body(&mut self, object: &Object, emits: bool) -> Result<Body, SceneError> {
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

fn read_material(object: &Rc<Object>) -> Result<Material, SceneError> {
    let material = match object.plugin.as_str() {
        "diffuse" => Material::Diffuse(Diffuse::read(object)?),
        "conductor" => Material::Conductor(Conductor::read(object)?),
        "roughconductor" => Material::RoughConductor(RoughConductor::read(object)?),
        "roughsurface" => Material::RoughSurface(Box::new(RoughSurface::read(object)?)),
        "dielectric" => Material::Dielectric(Dielectric::read(object)?),
        "pplastic" => Material::RoughlyCoated(pplastic::read(object)?),
        "polarizer" => Material::Polarizer(Polarizer::read(object)?),
        "retarder" => Material::Retarder(Retarder::read(object)?),
        "circular" => Material::Circular(Circular::read(object)?),
        "layered" => Material::Layered(Box::new(Layered::read(object)?)),
        "birefringent" => Material::Birefringent(Box::new(Birefringent::read(object)?)),
        "rotator" => Material::Rotator(Rotator::read(object)?),
        "mueller" => Material::Mueller(MuellerElement::read(object)?),
        "grating" => Material::Grating(Box::new(Grating::read(object)?)),
        "slits" => Material::Slits(Box::new(Slits::read(object)?)),
        "null" => Material::Null(Null),
        "roughdielectric" => Material::RoughDielectric(RoughDielectric::read(object)?),
        "thindielectric" => Material::ThinDielectric(ThinDielectric::read(object)?),
        "plastic" => Material::Plastic(Plastic::read(object)?),
        "roughplastic" => Material::RoughlyCoated(roughplastic::read(object)?),
        "scatterer16" => Material::Scatterer16(Box::new(Scatterer16::read(object)?)),
        "twosided" => {
            let sides = object.children(Tag::Bsdf);
            let [front, back] = match &sides[..] {
                [both] => [both, both],
                [front, back] => [front, back],
                _ => {
                    return Err(object.error(format!(
                        "bsdf 'twosided' holds {} bsdfs, expected one for both sides or one for each",
                        sides.len()
                    )));
                }
            };
            let [front, back] = [front, back].map(|side| {
                let material = read_material(side)?;
                if material.is_two_sided() {
                    return Err(side.error(format!(
                        "{} has two sides already, expected matter with one",
                        side.describe()
                    )));
                }
                Ok(material)
            });
            Material::TwoSided(TwoSided::new(front?, back?))
        }
        _ => return Err(plugins::refuse(object)),
    };
    object.finish()?;
    Ok(material)
}
