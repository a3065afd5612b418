//! Typed reading of parameters: each getter names what it expects and marks what it has read.

use std::path::PathBuf;

use glam::{DMat4, DVec4};

use super::error::{SceneError, alternatives, nearest, quoted};
use super::object::Object;
use super::value::Value;

impl Object {
    /// A number, or `default` where the file gives none. Takes `<float>`, `<integer>` and `<spectrum value="1.5"/>`.
    ///
    /// # Errors
    ///
    /// A parameter of another type, at its place; so for all the getters below.
    pub fn float(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        Ok(self.optional_float(name)?.unwrap_or(default))
    }

    /// A number, if the file gives one.
    pub fn optional_float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        self.get(name, "a number", |value| match *value {
            Value::Float(v) | Value::Uniform(v) => Some(v),
            Value::Integer(v) => Some(v as f64),
            _ => None,
        })
    }

    /// A number that the file must give.
    pub fn required_float(&self, name: &str) -> Result<f64, SceneError> {
        self.optional_float(name)?
            .ok_or_else(|| self.lacks(name, "a number"))
    }

    /// A length in metres, or `default`: a plain number of metres, or a text with a unit such as `550nm` or `1.6 um`.
    ///
    /// For lengths about as long as light waves. Finite; may be negative or zero.
    pub fn micro_length(
        &self,
        name: &str,
        default: Option<f64>,
    ) -> Result<Option<f64>, SceneError> {
        if !self.is_string(name) {
            let expected = "a number of metres or a text with a unit ('550nm')";
            let value = self.get(name, expected, |value| match *value {
                Value::Float(v) | Value::Uniform(v) => Some(v),
                Value::Integer(v) => Some(v as f64),
                _ => None,
            })?;
            return Ok(value.or(default));
        }
        let text = self.required_string(name)?;
        metres(&text).map(Some).ok_or_else(|| {
            self.error_at(
                name,
                format!(
                    "length '{name}' of {} is {}, expected a number and a unit out of nm, um, mm, cm and m ('550nm')",
                    self.describe(),
                    quoted(&text)
                ),
            )
        })
    }

    /// An integer, or `default`.
    pub fn integer(&self, name: &str, default: i64) -> Result<i64, SceneError> {
        let value = self.get(name, "an integer", |value| match *value {
            Value::Integer(v) => Some(v),
            _ => None,
        })?;
        Ok(value.unwrap_or(default))
    }

    /// True or false, or `default`.
    pub fn boolean(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        let value = self.get(name, "a boolean", |value| match *value {
            Value::Boolean(v) => Some(v),
            _ => None,
        })?;
        Ok(value.unwrap_or(default))
    }

    /// A text, or `default`.
    pub fn string(&self, name: &str, default: &str) -> Result<String, SceneError> {
        let value = self.optional_string(name)?;
        Ok(value.unwrap_or_else(|| default.to_owned()))
    }

    /// A text, if the file gives one.
    pub fn optional_string(&self, name: &str) -> Result<Option<String>, SceneError> {
        self.get(name, "a string", |value| match value {
            Value::String(v) => Some(v.clone()),
            _ => None,
        })
    }

    /// A text that the file must give.
    pub fn required_string(&self, name: &str) -> Result<String, SceneError> {
        self.optional_string(name)?
            .ok_or_else(|| self.lacks(name, "a string"))
    }

    /// Whether the file gives this parameter as a text. Does not count as reading it.
    pub fn is_string(&self, name: &str) -> bool {
        self.parameters
            .iter()
            .any(|p| p.name == name && matches!(p.value, Value::String(_)))
    }

    /// One of the `allowed` texts, or `default`.
    pub fn choice(
        &self,
        name: &str,
        default: &str,
        allowed: &[&str],
    ) -> Result<String, SceneError> {
        let value = self.string(name, default)?;
        if allowed.contains(&value.as_str()) || !self.has(name) {
            return Ok(value);
        }
        let near = nearest(&value, allowed.iter().copied())
            .map(|near| format!(", did you mean '{near}'?"))
            .unwrap_or_default();
        Err(self.error_at(
            name,
            format!(
                "parameter '{name}' of {} is {}, expected {}{near}",
                self.describe(),
                quoted(&value),
                alternatives(allowed)
            ),
        ))
    }

    /// A point, if the file gives one. Takes `<point>` and `<vector>`, as Mitsuba does.
    pub fn optional_point(&self, name: &str) -> Result<Option<[f64; 3]>, SceneError> {
        self.triple(name, "a point")
    }

    /// A vector, if the file gives one. Takes `<vector>` and `<point>`, as Mitsuba does.
    pub fn optional_vector(&self, name: &str) -> Result<Option<[f64; 3]>, SceneError> {
        self.triple(name, "a vector")
    }

    fn triple(&self, name: &str, expected: &str) -> Result<Option<[f64; 3]>, SceneError> {
        self.get(name, expected, |value| match *value {
            Value::Point(v) | Value::Vector(v) => Some(v),
            _ => None,
        })
    }

    /// An affine map, local to world, finite and invertible; the identity where the file gives none.
    pub fn transform(&self, name: &str) -> Result<DMat4, SceneError> {
        let value = self.get(name, "a transform", |value| match *value {
            Value::Transform(v) => Some(v),
            _ => None,
        })?;
        let Some(matrix) = value else {
            return Ok(DMat4::IDENTITY);
        };
        if !is_invertible(&matrix) {
            return Err(self.error_at(
                name,
                format!(
                    "transform '{name}' of {} maps space to a plane, a line or a point, \
                     expected one that can be inverted",
                    self.describe()
                ),
            ));
        }
        Ok(matrix)
    }

    /// A file that the file must give and that exists; looked for beside the scene file, then in its `<path>` folders.
    pub fn path(&self, name: &str) -> Result<PathBuf, SceneError> {
        let text = self
            .optional_string(name)?
            .ok_or_else(|| self.lacks(name, "the name of a file"))?;
        let found = self.search.find(&text);
        found.map_err(|message| self.error_at(name, message))
    }

    /// An error for a parameter that the file does not give.
    pub(super) fn lacks(&self, name: &str, expected: &str) -> SceneError {
        let whose = self.describe();
        self.error(format!(
            "{whose} has no parameter '{name}', expected {expected}"
        ))
    }

    /// Reads a parameter with `take`, which returns `None` for values of another type than `expected` says.
    pub(super) fn get<T>(
        &self,
        name: &str,
        expected: &str,
        take: impl Fn(&Value) -> Option<T>,
    ) -> Result<Option<T>, SceneError> {
        self.asked.borrow_mut().insert(name.to_owned());
        let wrong = |found: String| {
            let whose = self.describe();
            let message = format!("parameter '{name}' of {whose} is {found}, expected {expected}");
            self.error_at(name, message)
        };
        if let Some(parameter) = self.parameters.iter().find(|p| p.name == name) {
            parameter.read.set(true);
            let value = take(&parameter.value);
            return value
                .map(Some)
                .ok_or_else(|| wrong(parameter.value.describe()));
        }
        let mut children = self.children.iter();
        match children.find(|c| c.name.as_deref() == Some(name)) {
            Some(child) => Err(wrong(format!("a {}", child.object.describe()))),
            None => Ok(None),
        }
    }
}

/// Reads a number with a unit of length.
pub(crate) fn metres(text: &str) -> Option<f64> {
    let text = text.trim();
    let unit = text.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E'))?;
    let (number, unit) = text.split_at(unit);
    // divided, not multiplied: 550/1e9 is the number nearest to 550e-9
    let units_per_metre = match unit {
        "nm" => 1e9,
        // both code points of the letter
        "um" | "\u{b5}m" | "\u{3bc}m" => 1e6,
        "mm" => 1e3,
        "cm" => 1e2,
        "m" => 1.0,
        _ => return None,
    };
    let value: f64 = number.trim().parse().ok()?;
    Some(value / units_per_metre).filter(|value| value.is_finite())
}

/// Whether the columns span a volume, relative to their lengths, that survives rounding.
fn is_invertible(matrix: &DMat4) -> bool {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
    let [Some(x), Some(y), Some(z)] = columns.map(|c| (c / c.abs().max_element()).try_normalize())
    else {
        return false;
    };
    x.cross(y).dot(z).abs() > 1e-12
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use glam::DVec3;

    use super::*;
    use crate::scene::xml::tests::scene;

    fn bsdf(parameters: &str) -> Rc<Object> {
        let document = scene(&format!(
            "<bsdf type='roughconductor'>\n      {parameters}</bsdf>"
        ));
        document.definitions()[0].clone()
    }

    #[test]
    fn numbers_come_from_float_integer_and_one_number_spectra() {
        let object = bsdf(
            "<float name='a' value='1.5'/><integer name='b' value='2'/><spectrum name='c' value='3'/>",
        );
        assert_eq!(object.float("a", 0.0), Ok(1.5));
        assert_eq!(object.required_float("b"), Ok(2.0));
        assert_eq!(object.optional_float("c"), Ok(Some(3.0)));
        assert_eq!(object.float("d", 7.0), Ok(7.0));
        assert_eq!(object.integer("b", 0), Ok(2));
        assert!(object.finish().is_ok());
    }

    #[test]
    fn short_lengths_come_in_metres_or_with_a_unit() {
        let read = |parameter: &str| bsdf(parameter).micro_length("d", Some(2.0));
        let text = |value: &str| read(&format!("<string name='d' value='{value}'/>"));
        assert_eq!(read(""), Ok(Some(2.0)));
        assert_eq!(bsdf("").micro_length("d", None), Ok(None));
        assert_eq!(read("<float name='d' value='1e-6'/>"), Ok(Some(1e-6)));
        assert_eq!(read("<integer name='d' value='1'/>"), Ok(Some(1.0)));
        assert_eq!(text("550nm"), Ok(Some(550e-9)));
        for micron in ["1.6um", " 1.6 um ", "1.6\u{b5}m", "1.6\u{3bc}m", "1.6e-3mm"] {
            assert!((text(micron).unwrap().unwrap() - 1.6e-6).abs() < 1e-20);
        }
        assert_eq!(text("-2cm"), Ok(Some(-0.02)));
        assert_eq!(text("3e0m"), Ok(Some(3.0)));
        for wrong in ["550", "nm", "550 inch", "5 5nm", "1e999m", ""] {
            assert_eq!(
                text(wrong).unwrap_err().to_string(),
                format!(
                    "scene.xml:2:7: length 'd' of bsdf 'roughconductor' is '{wrong}', \
                     expected a number and a unit out of nm, um, mm, cm and m ('550nm')"
                )
            );
        }
        assert_eq!(
            read("<boolean name='d' value='true'/>")
                .unwrap_err()
                .to_string(),
            "scene.xml:2:7: parameter 'd' of bsdf 'roughconductor' is a boolean (true), \
             expected a number of metres or a text with a unit ('550nm')"
        );
    }

    #[test]
    fn texts_booleans_and_triples_are_read() {
        let object = bsdf(
            "<string name='s' value='x y'/><boolean name='b' value='TRUE'/><point name='p' x='1' y='2' z='3'/>\
             <vector name='v' value='4 5 6'/>",
        );
        assert_eq!(object.string("s", ""), Ok("x y".to_owned()));
        assert_eq!(object.boolean("b", false), Ok(true));
        assert_eq!(object.optional_vector("p"), Ok(Some([1.0, 2.0, 3.0])));
        assert_eq!(object.optional_point("v"), Ok(Some([4.0, 5.0, 6.0])));
        assert_eq!(object.optional_point("w"), Ok(None));
        assert!(object.has("s") && !object.has("w"));
    }

    #[test]
    fn a_wrong_type_is_refused_with_what_was_found_and_expected() {
        let message = |error: SceneError| error.to_string();
        let object = bsdf("<string name='alpha' value='rough'/>");
        assert_eq!(
            message(object.float("alpha", 0.1).unwrap_err()),
            "scene.xml:2:7: parameter 'alpha' of bsdf 'roughconductor' is a string ('rough'), expected a number"
        );
        let object = bsdf("<float name='n' value='1.5'/>");
        assert_eq!(
            message(object.integer("n", 1).unwrap_err()),
            "scene.xml:2:7: parameter 'n' of bsdf 'roughconductor' is a float (1.5), expected an integer"
        );
        let object = bsdf("<texture name='alpha' type='bitmap'/>");
        assert_eq!(
            message(object.float("alpha", 0.1).unwrap_err()),
            "scene.xml:2:7: parameter 'alpha' of bsdf 'roughconductor' is a texture 'bitmap', expected a number"
        );
        assert_eq!(
            message(object.required_string("file").unwrap_err()),
            "scene.xml:1:24: bsdf 'roughconductor' has no parameter 'file', expected a string"
        );
    }

    #[test]
    fn a_choice_lists_what_is_allowed() {
        let object = bsdf("<string name='distribution' value='becmann'/>");
        let allowed = ["beckmann", "ggx"];
        assert_eq!(
            object
                .choice("distribution", "ggx", &allowed)
                .unwrap_err()
                .to_string(),
            "scene.xml:2:7: parameter 'distribution' of bsdf 'roughconductor' is 'becmann', \
             expected 'beckmann' or 'ggx', did you mean 'beckmann'?"
        );
        assert_eq!(
            object.choice("other", "ggx", &allowed),
            Ok("ggx".to_owned())
        );
    }

    #[test]
    fn singular_transforms_are_refused_and_small_ones_are_not() {
        let read = |inside: &str| {
            bsdf(&format!("<transform name='t'>{inside}</transform>")).transform("t")
        };
        for inside in [
            "<scale x='0'/>",
            "<matrix value='1 2 3 2 4 6 0 0 1'/>",
            "<scale value='0'/>",
        ] {
            assert_eq!(
                read(inside).unwrap_err().to_string(),
                "scene.xml:2:7: transform 't' of bsdf 'roughconductor' maps space to a plane, a line or a point, \
                 expected one that can be inverted"
            );
        }
        let small = read("<scale value='1e-150'/><rotate x='1' y='2' angle='40'/>").unwrap();
        assert!(small.transform_vector3(DVec3::X).length() > 0.0);
        assert_eq!(bsdf("").transform("t"), Ok(DMat4::IDENTITY));
    }

    #[test]
    fn a_missing_file_is_refused_at_the_parameter() {
        let object = bsdf("<string name='filename' value='none.obj'/>");
        let message = object.path("filename").unwrap_err().to_string();
        assert_eq!(message, "scene.xml:2:7: no file 'none.obj', looked in '.'");
    }
}
