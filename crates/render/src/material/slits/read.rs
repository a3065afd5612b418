//! A screen with openings from its parameters.

use glam::DVec2;

use super::{Opening, Slits};
use crate::scene::{Object, SceneError, metres};

/// Most openings: each response is a sum over their pairs.
const MOST: usize = 64;

impl Slits {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let (openings, at) = match object.optional_string("openings")? {
            Some(text) => (read_list(object, &text)?, "openings"),
            None => (read_row(object)?, "width"),
        };
        if openings.is_empty() || openings.len() > MOST {
            return Err(object.error_at(
                if object.has("openings") {
                    "openings"
                } else {
                    "count"
                },
                format!(
                    "{} openings, expected 1 to {MOST}; bsdf 'grating' holds more",
                    openings.len()
                ),
            ));
        }
        let screened = openings
            .iter()
            .map(|o| {
                mueller16::Opening::clear(
                    nalgebra::Vector2::new(o.centre.x, o.centre.y),
                    o.width,
                    o.height,
                )
            })
            .collect();
        // refuses what overlaps or has no size; the screen is known later
        let checked =
            mueller16::Openings::new(screened, f64::MAX).map_err(|e| object.error_at(at, e))?;
        let [x, y] = checked.extent();
        Ok(Self {
            extent: x.hypot(y),
            open_area: checked.open_area(),
            openings,
            place: None,
        })
    }
}

fn read_row(object: &Object) -> Result<Vec<Opening>, SceneError> {
    let count = object.integer("count", 2)?;
    if !(1..=MOST as i64).contains(&count) {
        return Err(object.error_at(
            "count",
            format!("{count} openings, expected 1 to {MOST}; bsdf 'grating' holds more"),
        ));
    }
    let width = size(object, "width")?;
    let height = size(object, "height")?;
    let spacing = if count > 1 || object.has("spacing") {
        size(object, "spacing")?
    } else {
        0.0
    };
    let at = |n: i64| (n as f64 - 0.5 * (count - 1) as f64) * spacing;
    Ok((0..count)
        .map(|n| Opening {
            centre: DVec2::new(at(n), 0.0),
            width,
            height,
        })
        .collect())
}

fn size(object: &Object, name: &str) -> Result<f64, SceneError> {
    let value = object.micro_length(name, None)?.ok_or_else(|| {
        object.error(format!(
            "{} has no parameter '{name}', expected a length such as '50um'",
            object.describe()
        ))
    })?;
    if value > 0.0 && value <= 1.0 {
        Ok(value)
    } else {
        Err(object.error_at(
            name,
            format!(
                "'{name}' of {} is {value:e} m, expected a positive length of at most 1 m",
                object.describe()
            ),
        ))
    }
}

fn read_list(object: &Object, text: &str) -> Result<Vec<Opening>, SceneError> {
    let wrong = |part: &str| {
        object.error_at(
            "openings",
            format!(
                "the opening '{}', expected four lengths x, y, width, height such as '-50um 0um 20um 1mm'",
                part.trim()
            ),
        )
    };
    text.split(';')
        .filter(|part| !part.trim().is_empty())
        .map(|part| {
            let lengths: Option<Vec<f64>> = part
                .split(|c: char| c == ',' || c.is_whitespace())
                .filter(|item| !item.is_empty())
                .map(metres)
                .collect();
            match lengths.as_deref() {
                Some(&[x, y, width, height]) if width > 0.0 && height > 0.0 => Ok(Opening {
                    centre: DVec2::new(x, y),
                    width,
                    height,
                }),
                _ => Err(wrong(part)),
            }
        })
        .collect()
}
