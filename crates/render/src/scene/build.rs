//! From what the scene file says to a scene that can be rendered: every plugin reads its own parameters.
//!
//! Here everything finds its place: which matter and which source a shape has, and what fits to what. Geometry is made
//! in `build/bodies.rs`, matter in `build/materials.rs`.

mod bodies;
mod materials;

use std::collections::HashMap;
use std::rc::Rc;

use glam::DMat4;

use super::camera::read_integrator;
use super::document::Document;
use super::error::SceneError;
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
use crate::material::Material;
use crate::material::diffuse::Diffuse;
use crate::path::PathOptions;
use crate::sensor::Camera;
pub(crate) use bodies::within_reach;
use materials::read_material;

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
}
