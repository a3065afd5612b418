//! The values of parameters, `<float>` to `<transform>`, as read from the file.

use std::path::Path;
use std::sync::Arc;

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
fn table_from_file(path: &Path) -> Result<Vec<(f64, f64)>, SceneError> {
    let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
    let file: Arc<Path> = path.into();
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn read(text: &str) -> Result<Value, String> {
        let source = Source::new(Path::new("s.xml"), text);
        let document = roxmltree::Document::parse(&source.text).unwrap();
        let mut defines = Defines::new(&[]).unwrap();
        let search = Search::beside(Path::new("s.xml"), None);
        Element::new(document.root_element(), &source, &mut defines)
            .and_then(|element| Value::read(&element, &source, &mut defines, &search))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn every_form_of_a_value_is_read() {
        for (text, value) in [
            ("<float value='1e-3'/>", Value::Float(1e-3)),
            ("<integer value='-2'/>", Value::Integer(-2)),
            ("<boolean value='False'/>", Value::Boolean(false)),
            ("<string value=''/>", Value::String(String::new())),
            ("<point x='1' y='2' z='3'/>", Value::Point([1.0, 2.0, 3.0])),
            ("<vector value='1, 2 3'/>", Value::Vector([1.0, 2.0, 3.0])),
            ("<rgb value='.5'/>", Value::Rgb([0.5; 3])),
            ("<rgb r='1' g='2' b='3'/>", Value::Rgb([1.0, 2.0, 3.0])),
            ("<rgb value='#0000ff'/>", Value::Rgb([0.0, 0.0, 1.0])),
            ("<spectrum value='2'/>", Value::Uniform(2.0)),
            (
                "<spectrum value='400:1, 500:2'/>",
                Value::Table(vec![(400.0, 1.0), (500.0, 2.0)]),
            ),
            ("<transform/>", Value::Transform(DMat4::IDENTITY)),
        ] {
            assert_eq!(read(text), Ok(value));
        }
    }

    #[test]
    fn values_of_the_wrong_form_are_refused() {
        for (text, message) in [
            (
                "<float value='1.0abc'/>",
                "1:8: attribute 'value' of float is '1.0abc', expected a number",
            ),
            (
                "<integer value='1.5'/>",
                "1:10: attribute 'value' of integer is '1.5', expected an integer",
            ),
            (
                "<boolean value='yes'/>",
                "1:10: attribute 'value' of boolean is 'yes', expected 'true' or 'false'",
            ),
            (
                "<string/>",
                "1:1: element 'string' has no attribute 'value', expected value=\"…\"",
            ),
            (
                "<point x='1' y='2'/>",
                "1:1: element 'point' has no attribute 'z', expected z=\"…\"",
            ),
            (
                "<vector value='1 2 3' y='2'/>",
                "1:23: attribute 'value' beside 'x', 'y' or 'z', expected one of the two forms",
            ),
            (
                "<rgb value='1 2'/>",
                "1:6: attribute 'value' of rgb is '1 2', expected one or three numbers",
            ),
            (
                "<spectrum value='x'/>",
                "1:11: attribute 'value' of spectrum is 'x', expected a number",
            ),
            (
                "<spectrum value='500:1, 400:1'/>",
                "1:11: attribute 'value' of spectrum is '500:1, 400:1', expected rising wavelengths",
            ),
            (
                "<spectrum/>",
                "1:1: element 'spectrum' has neither 'value' nor 'filename', expected one of the two",
            ),
            (
                "<spectrum filename='none.spd'/>",
                "1:11: no file 'none.spd', looked in '.'",
            ),
        ] {
            assert_eq!(read(text), Err(format!("s.xml:{message}")));
        }
    }

    #[test]
    fn a_table_from_a_file_names_the_line_that_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gold.spd");
        let table = |text: &str| {
            fs::write(&path, text).unwrap();
            table_from_file(&path).map_err(|error| {
                let text = error.to_string();
                text[text.find("gold.spd").unwrap()..].to_owned()
            })
        };
        assert_eq!(
            table("# nm value\n400 1.5 # blue\r\n\n 700\t2\n"),
            Ok(vec![(400.0, 1.5), (700.0, 2.0)])
        );
        for (text, message) in [
            (
                "400 1\n500\n",
                "gold.spd:2: '500' found, expected a wavelength in nm and a value",
            ),
            (
                "400 1\n500 x\n",
                "gold.spd:2: '500 x' found, expected a number",
            ),
            (
                "400 1\n400 2\n",
                "gold.spd:2: '400 2' found, expected rising wavelengths",
            ),
            (
                "# nothing\n",
                "gold.spd: the table has 0 lines, expected at least two wavelengths, or one number for all of them",
            ),
        ] {
            assert_eq!(table(text), Err(message.to_owned()));
        }
    }
}
