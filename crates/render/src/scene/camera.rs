//! How the scene is to be seen: integrator, film, filter, sampler.

use super::build::Overrides;
use super::error::SceneError;
use super::object::Object;
use super::plugins;
use super::tag::Tag;
use crate::film::FilmGeometry;
use crate::filter::Filter;
use crate::path::PathOptions;

/// Largest film edge, pixels.
const LARGEST_FILM: i64 = 65_536;

/// A whole number within bounds.
pub(super) fn bounded(
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

pub(super) fn read_integrator(object: &Object) -> Result<PathOptions, SceneError> {
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
                patch: read_patch(object)?,
            };
            object.without_effect(&["block_size", "samples_per_pass", "timeout"]);
            object.finish()?;
            Ok(options)
        }
        _ => Err(plugins::refuse(object)),
    }
}

/// Half-width of emitter patches over the lobe that sees them.
fn read_patch(object: &Object) -> Result<f32, SceneError> {
    let patch = object.float("patch", f64::from(PathOptions::default().patch))?;
    if (0.0..=1e3).contains(&patch) {
        Ok(patch as f32)
    } else {
        Err(object.error_at(
            "patch",
            format!("a patch size of {patch} lobe widths, expected a number from 0 (single points) to 1000"),
        ))
    }
}

/// The film of a sensor, its sample count and the name of its sampler.
pub(super) fn read_recording(
    object: &Object,
    overrides: Overrides,
) -> Result<(FilmGeometry, u64, String), SceneError> {
    let film = match object.child(Tag::Film)? {
        Some(film) => read_film(&film, overrides)?,
        None => default_film(overrides),
    };
    let (samples, sampler) = match object.child(Tag::Sampler)? {
        Some(sampler) => read_sampler(&sampler)?,
        None => (4, "independent".to_owned()),
    };
    Ok((film, samples, sampler))
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
        products: false,
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
        products: false,
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
