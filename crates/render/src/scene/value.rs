//! The values of parameters, `<float>` to `<transform>`, as read from the file.

use glam::DMat4;

use super::defines::Defines;
use super::element::{Attribute, Element};
use super::error::{Position, SceneError, quoted};
use super::number;
use super::search::Search;
use super::source::{Source, read_bytes};
use super::transform;

/// The elements that give a value to a parameter.
pub(super) const VALUE_TAGS: [&str; 9] = [
    "float",
    "integer",
    "boolean",
    "string",
    "point",
    "vector",
    "rgb",
    "spectrum",
    "transform",
];

/// The value of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Float(f64),
    Integer(i64),
    Boolean(bool),
    String(String),
    Point([f64; 3]),
    Vector([f64; 3]),
    Rgb([f64; 3]),
    /// One number for every wavelength.
    Uniform(f64),
    /// (nm, value), rising.
    Table(Vec<(f64, f64)>),
    Transform(DMat4),
}

impl Value {
    /// What the value is, with its text where that is short: `a string ('rough')`.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Float(v) => format!("a float ({v})"),
            Self::Integer(v) => format!("an integer ({v})"),
            Self::Boolean(v) => format!("a boolean ({v})"),
            Self::String(v) => format!("a string ({})", quoted(v)),
            Self::Point(_) => "a point".to_owned(),
            Self::Vector(_) => "a vector".to_owned(),
            Self::Rgb(_) => "an rgb colour".to_owned(),
            Self::Uniform(v) => format!("a spectrum ({v})"),
            Self::Table(_) => "a spectrum with several wavelengths".to_owned(),
            Self::Transform(_) => "a transform".to_owned(),
        }
    }

    /// Reads an element whose tag is one of [`VALUE_TAGS`].
    pub(super) fn read(
        element: &Element<'_>,
        source: &Source,
        defines: &mut Defines,
        search: &Search,
    ) -> Result<Self, SceneError> {
        if element.tag == "transform" {
            element.allow(&["name"])?;
            return transform::read(element, source, defines).map(Self::Transform);
        }
        element.no_children()?;
        match element.tag {
            "float" => Ok(Self::Float(only_value(element)?.parse(number::float)?)),
            "integer" => Ok(Self::Integer(only_value(element)?.parse(number::integer)?)),
            "boolean" => Ok(Self::Boolean(only_value(element)?.parse(number::boolean)?)),
            "string" => {
                element.allow(&["name", "value"])?;
                Ok(Self::String(element.present("value")?.value.clone()))
            }
            "point" => triple(element, ["x", "y", "z"], number::one_or_triple).map(Self::Point),
            "vector" => triple(element, ["x", "y", "z"], number::one_or_triple).map(Self::Vector),
            "rgb" => triple(element, ["r", "g", "b"], colour).map(Self::Rgb),
            "spectrum" => spectrum(element, search),
            other => Err(element.error(format!("'{other}' gives no value to a parameter"))),
        }
    }
}

fn only_value<'e>(element: &'e Element<'_>) -> Result<&'e Attribute, SceneError> {
    element.allow(&["name", "value"])?;
    element.require("value")
}

fn colour(text: &str) -> Result<[f64; 3], &'static str> {
    if text.trim_start().starts_with('#') {
        number::hex_colour(text)
    } else {
        number::one_or_triple(text)
    }
}

/// Three attributes with one number each, or `value` with all of them.
fn triple(
    element: &Element<'_>,
    names: [&str; 3],
    read: fn(&str) -> Result<[f64; 3], &'static str>,
) -> Result<[f64; 3], SceneError> {
    let [a, b, c] = names;
    element.allow(&["name", "value", a, b, c])?;
    if let Some(value) = element.get("value") {
        if let Some(other) = names.iter().find_map(|name| element.get(name)) {
            return Err(other.position.error(format!(
                "attribute 'value' beside '{a}', '{b}' or '{c}', expected one of the two forms"
            )));
        }
        return value.parse(read);
    }
    let number = |name| element.require(name)?.parse(number::float);
    Ok([number(a)?, number(b)?, number(c)?])
}

fn spectrum(element: &Element<'_>, search: &Search) -> Result<Value, SceneError> {
    element.allow(&["name", "value", "filename"])?;
    match (element.get("value"), element.get("filename")) {
        (Some(value), None) => {
            if let Ok(number) = number::float(&value.value) {
                return Ok(Value::Uniform(number));
            }
            if number::items(&value.value).count() == 1 && !value.value.contains(':') {
                return value.parse(number::float).map(Value::Uniform);
            }
            value.parse(number::pairs).map(Value::Table)
        }
        (None, Some(filename)) => {
            let path = search
                .find(&filename.value)
                .map_err(|message| filename.position.error(message))?;
            table_from_file(&path).map(Value::Table)
        }
        (Some(_), Some(both)) => Err(both
            .position
            .error("attribute 'filename' beside 'value', expected one of the two")),
        (None, None) => Err(element.error(
            "element 'spectrum' has neither 'value' nor 'filename', expected one of the two",
        )),
    }
}

/// Lines of `wavelength value`, wavelengths in nm; `#` starts a comment.
fn table_from_file(path: &std::path::Path) -> Result<Vec<(f64, f64)>, SceneError> {
    let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
    let file: std::sync::Arc<std::path::Path> = path.into();
    let mut pairs: Vec<(f64, f64)> = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let place = |what: &str| Position::line(file.clone(), number).error(what);
        let data = line.split('#').next().unwrap_or_default();
        let data = data.trim_start_matches('\u{feff}').trim();
        if data.is_empty() {
            continue;
        }
        let expected = |what| place(&format!("{} found, expected {what}", quoted(data)));
        let pair = match number::floats(data).map_err(expected)?[..] {
            [nm, value] => (nm, value),
            _ => return Err(expected("a wavelength in nm and a value")),
        };
        if pairs.last().is_some_and(|last| last.0 >= pair.0) {
            return Err(expected("rising wavelengths"));
        }
        pairs.push(pair);
    }
    number::check_pairs(&pairs).map_err(|what| {
        Position::whole(path).error(format!(
            "the table has {} lines, expected {what}",
            pairs.len()
        ))
    })?;
    Ok(pairs)
}
