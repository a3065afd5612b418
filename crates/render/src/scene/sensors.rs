//! Which sensor a scene is rendered for, and what it is.

use std::rc::Rc;

use super::build::Overrides;
use super::camera::read_recording;
use super::error::{SceneError, nearest};
use super::object::Object;
use super::plugins;
use super::tag::Tag;
use crate::emitter::patch::Outline;
use crate::film::FilmGeometry;
use crate::filter::Filter;
use crate::sensor::Camera;
use crate::sensor::irradiancemeter::IrradianceMeter;
use crate::sensor::perspective::Perspective;
use crate::shape::disk::Disk;
use crate::shape::rectangle::Rectangle;

/// A sensor with its film.
pub(super) struct Sensor {
    pub(super) camera: Camera,
    pub(super) film: FilmGeometry,
    pub(super) samples: u64,
    /// Name of the sampler plugin.
    pub(super) sampler: String,
}

/// Reads the first sensor of a scene; those that stand alone come before those in shapes.
pub(super) fn read_sensor(root: &Object, overrides: Overrides) -> Result<Sensor, SceneError> {
    let shapes = root.children(Tag::Shape);
    let mut sensors: Vec<(Rc<Object>, Option<&Object>)> = root
        .children(Tag::Sensor)
        .into_iter()
        .map(|sensor| (sensor, None))
        .collect();
    for shape in &shapes {
        if let Some(sensor) = shape.child(Tag::Sensor)? {
            sensors.push((sensor, Some(shape)));
        }
    }
    let Some(((sensor, shape), unused)) = sensors.split_first() else {
        return Err(
            root.error("the scene has no sensor, expected one <sensor type=\"perspective\">")
        );
    };
    for (unused, _) in unused {
        unused.notice_at(
            "",
            "only the first sensor of a scene is rendered; this one is not looked at",
        );
    }
    if !plugins::supported(Tag::Sensor).contains(&sensor.plugin.as_str()) {
        return Err(plugins::refuse(sensor));
    }
    if let Some(shape) = shape
        && !plugins::supported(Tag::Shape).contains(&shape.plugin.as_str())
    {
        return Err(plugins::refuse(shape));
    }
    let (film, samples, sampler) = read_recording(sensor, overrides)?;
    let camera = match (sensor.plugin.as_str(), shape) {
        ("irradiancemeter", Some(shape)) => {
            let meter = read_meter(sensor, shape, &shapes, &film)?;
            Camera::IrradianceMeter(Box::new(meter))
        }
        ("irradiancemeter", None) => {
            return Err(sensor.error(format!(
                "{} stands alone, expected it inside a rectangle or a disk",
                sensor.describe()
            )));
        }
        (_, Some(shape)) => {
            return Err(sensor.error(format!(
                "{} inside {}, expected 'irradiancemeter' there",
                sensor.describe(),
                shape.describe()
            )));
        }
        (_, None) => Camera::Perspective(Perspective::read(sensor, film.size)?),
    };
    sensor.finish()?;
    Ok(Sensor {
        camera,
        film,
        samples,
        sampler,
    })
}

fn read_meter(
    sensor: &Object,
    shape: &Object,
    shapes: &[Rc<Object>],
    film: &FilmGeometry,
) -> Result<IrradianceMeter, SceneError> {
    let outline = flat_outline(shape)?.ok_or_else(|| {
        sensor.error(format!(
            "{} inside {}, expected it inside a rectangle or a disk",
            sensor.describe(),
            shape.describe()
        ))
    })?;
    if sensor.has("to_world") {
        return Err(sensor.error_at(
            "to_world",
            format!(
                "a transform of {}, expected none: its shape places it",
                sensor.describe()
            ),
        ));
    }
    if film.filter != Filter::Box {
        sensor.notice_at(
            "",
            format!(
                "pixels of {} mix with their neighbours under this filter; <rfilter type=\"box\"/> makes each of them \
                 the mean over its own piece of the shape",
                sensor.describe()
            ),
        );
    }
    let toward = match sensor.optional_string("toward")? {
        Some(id) => Some(read_toward(sensor, shape, shapes, &id)?),
        None => None,
    };
    Ok(IrradianceMeter::new(outline, toward, film.size))
}

/// The shape through which the sensor sees.
fn read_toward(
    sensor: &Object,
    own: &Object,
    shapes: &[Rc<Object>],
    id: &str,
) -> Result<Outline, SceneError> {
    let wrong = |found: String| sensor.error_at("toward", found);
    let named = |shape: &&Rc<Object>| shape.id.as_deref() == Some(id);
    let Some(shape) = shapes.iter().find(named) else {
        let ids = shapes.iter().filter_map(|shape| shape.id.as_deref());
        return Err(wrong(match nearest(id, ids) {
            Some(near) => format!("no shape has the id '{id}', did you mean '{near}'?"),
            None => format!("no shape has the id '{id}', expected that of a rectangle or a disk"),
        }));
    };
    if std::ptr::eq(&raw const **shape, own) {
        return Err(wrong(format!(
            "'{id}' is the sensor's own shape, expected one in front of it"
        )));
    }
    flat_outline(shape)?.ok_or_else(|| {
        wrong(format!(
            "'{id}' is {}, expected a rectangle or a disk (of bsdf 'null' before other shapes)",
            shape.describe()
        ))
    })
}

/// The outline of a rectangle or a disk; `None` for other shapes.
fn flat_outline(shape: &Object) -> Result<Option<Outline>, SceneError> {
    let to_world = shape.transform("to_world")?;
    let flip = shape.boolean("flip_normals", false)?;
    Ok(match shape.plugin.as_str() {
        "rectangle" => Some(Rectangle::new(&to_world, flip).outline()),
        "disk" => Some(Disk::new(&to_world, flip).outline()),
        _ => None,
    })
}
