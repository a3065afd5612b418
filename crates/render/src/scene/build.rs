//! From what the scene file says to a scene that can be rendered: every plugin reads its own parameters.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::document::Document;
use super::error::SceneError;
use super::mesh::load_obj;
use super::object::Object;
use super::plugins;
use super::tag::Tag;
use super::world::{Body, Owner, Scene};
use crate::emitter::{
    Emitter, area::Area, constant::Constant, directional::Directional, point::Point, spot::Spot,
};
use crate::film::FilmGeometry;
use crate::filter::Filter;
use crate::material::Material;
use crate::material::circular::Circular;
use crate::material::conductor::Conductor;
use crate::material::dielectric::Dielectric;
use crate::material::diffuse::Diffuse;
use crate::material::null::Null;
use crate::material::polarizer::Polarizer;
use crate::material::pplastic::Pplastic;
use crate::material::retarder::Retarder;
use crate::material::roughconductor::RoughConductor;
use crate::material::twosided::TwoSided;
use crate::path::PathOptions;
use crate::sensor::perspective::Perspective;
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
    /// The camera.
    pub camera: Perspective,
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
/// Largest film edge, pixels.
const LARGEST_FILM: i64 = 65_536;

/// Builds the scene that a document describes.
///
/// # Errors
///
/// The first thing in the file that cannot be used, with its place.
pub fn build(document: &Document, overrides: Overrides) -> Result<BuiltScene, SceneError> {
    let root = &document.root;
    let paths = match root.child(Tag::Integrator)? {
        Some(integrator) => read_integrator(&integrator)?,
        None => PathOptions {
            max_depth: u32::MAX,
            rr_depth: 5,
            hide_emitters: false,
        },
    };
    let sensors = root.children(Tag::Sensor);
    let sensor = sensors.first().ok_or_else(|| {
        root.error("the scene has no sensor, expected one <sensor type=\"perspective\">")
    })?;
    for unused in &sensors[1..] {
        unused.notice_at(
            "",
            "only the first sensor of a scene is rendered; this one is not looked at",
        );
    }
    let (camera, film, samples, sampler) = read_sensor(sensor, overrides)?;

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

/// A whole number within bounds.
fn bounded(
    object: &Object,
    name: &str,
    default: i64,
    low: i64,
    high: i64,
) -> Result<i64, SceneError> {
    let value = object.integer(name, default)?;
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(object.error_at(
            name,
            format!(
                "'{name}' of {} is {value}, expected a number from {low} to {high}",
                object.describe()
            ),
        ))
    }
}

fn read_integrator(object: &Object) -> Result<PathOptions, SceneError> {
    match object.plugin.as_str() {
        "stokes" => {
            let nested = object.child(Tag::Integrator)?.ok_or_else(|| {
                object.error("integrator 'stokes' is empty, expected another integrator in it, such as 'path'")
            })?;
            object.finish()?;
            read_integrator(&nested)
        }
        "path" => {
            let depth = bounded(object, "max_depth", -1, -1, i64::from(u32::MAX) - 1)?;
            let options = PathOptions {
                max_depth: u32::try_from(depth).unwrap_or(u32::MAX),
                rr_depth: bounded(object, "rr_depth", 5, 1, i64::from(u32::MAX))? as u32,
                hide_emitters: object.boolean("hide_emitters", false)?,
            };
            object.without_effect(&["block_size", "samples_per_pass", "timeout"]);
            object.finish()?;
            Ok(options)
        }
        _ => Err(plugins::refuse(object)),
    }
}

fn read_sensor(
    object: &Object,
    overrides: Overrides,
) -> Result<(Perspective, FilmGeometry, u64, String), SceneError> {
    if object.plugin != "perspective" {
        return Err(plugins::refuse(object));
    }
    let film = match object.child(Tag::Film)? {
        Some(film) => read_film(&film, overrides)?,
        None => default_film(overrides),
    };
    let (samples, sampler) = match object.child(Tag::Sampler)? {
        Some(sampler) => read_sampler(&sampler)?,
        None => (4, "independent".to_owned()),
    };
    let camera = Perspective::read(object, film.size)?;
    object.finish()?;
    Ok((camera, film, samples, sampler))
}

fn read_sampler(object: &Object) -> Result<(u64, String), SceneError> {
    if !plugins::supported(Tag::Sampler).contains(&object.plugin.as_str()) {
        return Err(plugins::refuse(object));
    }
    let count = bounded(object, "sample_count", 4, 1, 1 << 40)?;
    object.without_effect(&["seed", "jitter", "strength"]);
    if object.plugin != "independent" {
        object.notice_at(
            "",
            format!(
                "{} sets the sample count only; --sampler chooses the generator",
                object.describe()
            ),
        );
    }
    object.finish()?;
    Ok((count as u64, object.plugin.clone()))
}

fn default_film(overrides: Overrides) -> FilmGeometry {
    let size = overrides.size.unwrap_or([768, 576]);
    let [x, y, width, height] = overrides.crop.unwrap_or([0, 0, size[0], size[1]]);
    FilmGeometry {
        size,
        crop_offset: [x, y],
        crop_size: [width, height],
        filter: Filter::Gaussian { stddev: 0.5 },
    }
}

fn read_film(object: &Object, overrides: Overrides) -> Result<FilmGeometry, SceneError> {
    if object.plugin != "hdrfilm" {
        return Err(plugins::refuse(object));
    }
    let file_size = [
        bounded(object, "width", 768, 1, LARGEST_FILM)? as u32,
        bounded(object, "height", 576, 1, LARGEST_FILM)? as u32,
    ];
    let size = overrides.size.unwrap_or(file_size);
    // a crop window of the file belongs to the file's size
    let fitting = |axis: usize, value: i64| -> u32 {
        (value as f64 * f64::from(size[axis]) / f64::from(file_size[axis])).round() as u32
    };
    let mut offset = [0; 2];
    let mut crop = [0; 2];
    for (axis, (at, along)) in [
        ("crop_offset_x", "crop_width"),
        ("crop_offset_y", "crop_height"),
    ]
    .iter()
    .enumerate()
    {
        let whole = i64::from(file_size[axis]);
        let first = bounded(object, at, 0, 0, whole - 1)?;
        let length = bounded(object, along, whole - first, 1, whole - first)?;
        offset[axis] = fitting(axis, first).min(size[axis] - 1);
        crop[axis] = fitting(axis, length).clamp(1, size[axis] - offset[axis]);
    }
    if let Some([x, y, width, height]) = overrides.crop {
        (offset, crop) = ([x, y], [width, height]);
    }
    let filter = match object.child(Tag::Rfilter)? {
        Some(filter) => read_filter(&filter)?,
        None => Filter::Gaussian { stddev: 0.5 },
    };
    object.without_effect(&[
        "file_format",
        "pixel_format",
        "component_format",
        "compensate",
        "banner",
        "sample_border",
    ]);
    object.finish()?;
    Ok(FilmGeometry {
        size,
        crop_offset: offset,
        crop_size: crop,
        filter,
    })
}

fn read_filter(object: &Object) -> Result<Filter, SceneError> {
    let length = |name: &str, default: f64| {
        let value = object.float(name, default)?;
        if value > 0.0 && value <= 100.0 {
            Ok(value as f32)
        } else {
            Err(object.error_at(
                name,
                format!(
                    "'{name}' of {} is {value}, expected pixels, up to 100",
                    object.describe()
                ),
            ))
        }
    };
    let filter = match object.plugin.as_str() {
        "box" => Filter::Box,
        "tent" => Filter::Tent {
            radius: length("radius", 1.0)?,
        },
        "gaussian" => Filter::Gaussian {
            stddev: length("stddev", 0.5)?,
        },
        _ => return Err(plugins::refuse(object)),
    };
    object.finish()?;
    Ok(filter)
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
        let emitter = match object.plugin.as_str() {
            "constant" => {
                if self.scene.environment.is_some() {
                    return Err(object
                        .error("second emitter that surrounds the scene, expected at most one"));
                }
                Emitter::Constant(Constant::read(object)?)
            }
            "point" => Emitter::Point(Point::read(object)?),
            "spot" => Emitter::Spot(Spot::read(object)?),
            "directional" => Emitter::Directional(Directional::read(object)?),
            "area" => {
                return Err(object.error("emitter 'area' stands alone, expected it inside a shape"));
            }
            _ => return Err(plugins::refuse(object)),
        };
        object.finish()?;
        let surrounds = matches!(emitter, Emitter::Constant(_));
        let index = self.add_emitter(emitter, object);
        if surrounds {
            self.scene.environment = Some(index);
        }
        Ok(())
    }

    fn shape(&mut self, object: &Rc<Object>) -> Result<(), SceneError> {
        if !plugins::supported(Tag::Shape).contains(&object.plugin.as_str()) {
            return Err(plugins::refuse(object));
        }
        let material = match object.child(Tag::Bsdf)? {
            Some(bsdf) => self.material(&bsdf)?,
            None => self.add_material(
                Material::Diffuse(Diffuse::default()),
                "diffuse (default)".to_owned(),
            ),
        };
        let emitter = object.child(Tag::Emitter)?;
        let body = self.body(object, emitter.is_some())?;
        let emitter = match emitter {
            Some(emitter) if emitter.plugin == "area" => {
                let area = Area::read(&emitter, body)?;
                emitter.finish()?;
                Some(self.add_emitter(Emitter::Area(area), &emitter))
            }
            Some(emitter)
                if plugins::supported(Tag::Emitter).contains(&emitter.plugin.as_str()) =>
            {
                return Err(emitter.error(format!(
                    "{} inside a shape, expected 'area'",
                    emitter.describe()
                )));
            }
            Some(emitter) => return Err(plugins::refuse(&emitter)),
            None => None,
        };
        let owner = Owner { material, emitter };
        match body {
            Body::Shape(_) => self.scene.shape_owners.push(owner),
            Body::Mesh(_) => self.scene.mesh_owners.push(owner),
        }
        object.finish()
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
            "a transform that stretches or skews {}, expected one that moves, turns, mirrors and scales evenly",
            object.describe()
        ),
    )
}

fn within_reach(object: &Object, reach: f32) -> Result<(), SceneError> {
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
        "dielectric" => Material::Dielectric(Dielectric::read(object)?),
        "pplastic" => Material::Pplastic(Pplastic::read(object)?),
        "polarizer" => Material::Polarizer(Polarizer::read(object)?),
        "retarder" => Material::Retarder(Retarder::read(object)?),
        "circular" => Material::Circular(Circular::read(object)?),
        "null" => Material::Null(Null),
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
