//! Parameters that are lists in one text, and files that are named inside one.

use std::path::PathBuf;

use super::error::{SceneError, quoted};
use super::object::Object;
use super::params::metres;

impl Object {
    /// The parts of a text between commas, blanks around them left out; empty where the file gives none.
    ///
    /// # Errors
    ///
    /// A parameter of another type, or an empty part, at its place.
    pub fn texts(&self, name: &str) -> Result<Vec<String>, SceneError> {
        let Some(text) = self.optional_string(name)? else {
            return Ok(Vec::new());
        };
        let parts: Vec<String> = text.split(',').map(|part| part.trim().to_owned()).collect();
        if parts.iter().any(String::is_empty) {
            return Err(self.error_at(
                name,
                format!(
                    "'{name}' of {} is {}, expected texts separated by commas",
                    self.describe(),
                    quoted(&text)
                ),
            ));
        }
        Ok(parts)
    }

    /// Lengths in metres from a list such as `100nm, 1.6um`, or from one plain number of metres.
    ///
    /// # Errors
    ///
    /// As [`Object::texts`]; a part that is no length.
    pub fn micro_lengths(&self, name: &str) -> Result<Vec<f64>, SceneError> {
        if !self.is_string(name) {
            return Ok(self.micro_length(name, None)?.into_iter().collect());
        }
        let lengths = self.texts(name)?.into_iter().map(|part| {
            metres(&part).ok_or_else(|| {
                self.error_at(
                    name,
                    format!(
                        "length {} in '{name}' of {}, expected a number and a unit out of nm, um, mm, cm and m \
                         ('100nm, 1.6um')",
                        quoted(&part),
                        self.describe()
                    ),
                )
            })
        });
        lengths.collect()
    }

    /// A length that is longer than nothing, in metres, if the file gives one.
    ///
    /// # Errors
    ///
    /// As [`Object::micro_length`]; a length that is not positive.
    pub fn positive_length(&self, name: &str) -> Result<Option<f64>, SceneError> {
        let length = self.micro_length(name, None)?;
        match length {
            Some(metres) if metres <= 0.0 => Err(self.error_at(
                name,
                format!(
                    "'{name}' of {} is {metres} m, expected a positive length",
                    self.describe()
                ),
            )),
            _ => Ok(length),
        }
    }

    /// A file that the text of a parameter names, looked for where files of the scene are.
    ///
    /// # Errors
    ///
    /// No such file, at the parameter.
    pub fn file(&self, name: &str, text: &str) -> Result<PathBuf, SceneError> {
        let found = self.search.find(text);
        found.map_err(|message| self.error_at(name, message))
    }
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use super::*;
    use crate::scene::xml::tests::scene;

    fn bsdf(parameters: &str) -> Rc<Object> {
        let document = scene(&format!("<bsdf type='layered'>\n{parameters}</bsdf>"));
        document.definitions()[0].clone()
    }

    #[test]
    fn lists_of_lengths_have_units() {
        let read =
            |text: &str| bsdf(&format!("<string name='d' value='{text}'/>")).micro_lengths("d");
        assert_eq!(read("100nm, 60 nm"), Ok(vec![100e-9, 60e-9]));
        assert_eq!(read("1mm"), Ok(vec![1e-3]));
        assert_eq!(
            bsdf("<float name='d' value='1e-7'/>").micro_lengths("d"),
            Ok(vec![1e-7])
        );
        assert_eq!(bsdf("").micro_lengths("d"), Ok(vec![]));
        assert_eq!(
            read("100nm, 60").unwrap_err().to_string(),
            "scene.xml:2:1: length '60' in 'd' of bsdf 'layered', expected a number and a unit out of nm, um, mm, cm \
             and m ('100nm, 1.6um')"
        );
        assert_eq!(
            read("100nm,").unwrap_err().to_string(),
            "scene.xml:2:1: 'd' of bsdf 'layered' is '100nm,', expected texts separated by commas"
        );
    }

    #[test]
    fn lengths_of_nothing_are_refused() {
        assert_eq!(
            bsdf("<string name='d' value='0nm'/>")
                .positive_length("d")
                .unwrap_err()
                .to_string(),
            "scene.xml:2:1: 'd' of bsdf 'layered' is 0 m, expected a positive length"
        );
    }
}
