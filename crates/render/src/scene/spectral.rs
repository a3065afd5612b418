//! Parameters that are spectra: a number, a table of wavelengths, or a colour.

use super::error::SceneError;
use super::object::Object;
use super::value::Value;
use crate::spectrum::{Spectrum, SpectrumUse};

const EXPECTED: &str = "a number, a spectrum or an rgb colour";

impl Object {
    /// A spectrum, or `default` where the file gives none. `use_` says what the numbers of an `<rgb>` mean.
    ///
    /// # Errors
    ///
    /// A parameter of another type; a reflectance outside `0.0..=1.0` or a negative emission.
    pub fn spectrum(
        &self,
        name: &str,
        use_: SpectrumUse,
        default: Spectrum,
    ) -> Result<Spectrum, SceneError> {
        Ok(self.optional_spectrum(name, use_)?.unwrap_or(default))
    }

    /// A factor on what is reflected or transmitted, in `0.0..=1.0`; 1 where the file gives none.
    ///
    /// # Errors
    ///
    /// As for [`Object::spectrum`].
    pub fn factor(&self, name: &str) -> Result<Spectrum, SceneError> {
        self.spectrum(name, SpectrumUse::Reflectance, Spectrum::constant(1.0))
    }

    /// A spectrum, if the file gives one.
    ///
    /// # Errors
    ///
    /// As for [`Object::spectrum`].
    pub fn optional_spectrum(
        &self,
        name: &str,
        use_: SpectrumUse,
    ) -> Result<Option<Spectrum>, SceneError> {
        let Some(value) = self.get(name, EXPECTED, numbers)? else {
            return Ok(None);
        };
        self.check_range(name, use_, &value)?;
        let spectrum = match value {
            Numbers::Uniform(v) => Ok(Spectrum::constant(v)),
            Numbers::Table(pairs) => Spectrum::tabulated(pairs),
            Numbers::Rgb(rgb) => Ok(Spectrum::rgb(rgb, use_)),
        };
        spectrum.map(Some).map_err(|message| {
            let whose = self.describe();
            self.error_at(name, format!("spectrum '{name}' of {whose}: {message}"))
        })
    }

    fn check_range(
        &self,
        name: &str,
        use_: SpectrumUse,
        value: &Numbers,
    ) -> Result<(), SceneError> {
        let (range, what) = match use_ {
            SpectrumUse::Reflectance => (0.0..=1.0, "a fraction between 0 and 1"),
            SpectrumUse::Emission => (0.0..=LARGEST, "a number from 0 to 3.4e38"),
            SpectrumUse::Unbounded => (
                -LARGEST..=LARGEST,
                "a number of single precision, up to 3.4e38",
            ),
        };
        let Some(outside) = value.all().into_iter().find(|v| !range.contains(v)) else {
            return Ok(());
        };
        let whose = self.describe();
        let message = format!("spectrum '{name}' of {whose} contains {outside}, expected {what}");
        Err(self.error_at(name, message))
    }
}

/// Spectra are single precision where they are used.
const LARGEST: f64 = f32::MAX as f64;

enum Numbers {
    Uniform(f64),
    Table(Vec<(f64, f64)>),
    Rgb([f64; 3]),
}

impl Numbers {
    fn all(&self) -> Vec<f64> {
        match self {
            Self::Uniform(v) => vec![*v],
            Self::Table(pairs) => pairs.iter().map(|&(_, v)| v).collect(),
            Self::Rgb(rgb) => rgb.to_vec(),
        }
    }
}

fn numbers(value: &Value) -> Option<Numbers> {
    match value {
        Value::Float(v) | Value::Uniform(v) => Some(Numbers::Uniform(*v)),
        Value::Integer(v) => Some(Numbers::Uniform(*v as f64)),
        Value::Table(pairs) => Some(Numbers::Table(pairs.clone())),
        Value::Rgb(rgb) => Some(Numbers::Rgb(*rgb)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::SpectrumUse::{Emission, Reflectance, Unbounded};
    use super::*;
    use crate::scene::xml::tests::scene;

    fn read(parameter: &str, use_: SpectrumUse) -> Result<Option<Spectrum>, String> {
        let document = scene(&format!("<bsdf type='diffuse'>{parameter}</bsdf>"));
        let object = &document.definitions()[0];
        object
            .optional_spectrum("r", use_)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn every_written_form_gives_the_same_constant() {
        for parameter in [
            "<float name='r' value='1'/>",
            "<integer name='r' value='1'/>",
            "<spectrum name='r' value=' 1.0 '/>",
        ] {
            assert_eq!(
                read(parameter, Reflectance),
                Ok(Some(Spectrum::constant(1.0)))
            );
        }
        assert_eq!(read("", Emission), Ok(None));
    }

    #[test]
    fn tables_and_colours_keep_their_numbers() {
        assert_eq!(
            read("<spectrum name='r' value='400:2, 700:3'/>", Unbounded),
            Ok(Some(
                Spectrum::tabulated(vec![(400.0, 2.0), (700.0, 3.0)]).unwrap()
            ))
        );
        let rgb = [0.25, 0.5, 1.0];
        for (use_, expected) in [
            (Reflectance, Spectrum::rgb_reflectance(rgb)),
            (Emission, Spectrum::rgb_emission(rgb)),
            (Unbounded, Spectrum::rgb_unbounded(rgb)),
        ] {
            assert_eq!(
                read("<rgb name='r' value='.25 .5 1'/>", use_),
                Ok(Some(expected.clone()))
            );
            assert_eq!(
                read("<rgb name='r' r='.25' g='.5' b='1'/>", use_),
                Ok(Some(expected))
            );
        }
    }

    #[test]
    fn a_reflectance_is_a_fraction_and_an_emission_is_not_negative() {
        let message = "scene.xml:1:45: spectrum 'r' of bsdf 'diffuse' contains";
        for (parameter, use_, end) in [
            (
                "<float name='r' value='1.5'/>",
                Reflectance,
                "1.5, expected a fraction between 0 and 1",
            ),
            (
                "<rgb name='r' value='1 2 1'/>",
                Reflectance,
                "2, expected a fraction between 0 and 1",
            ),
            (
                "<spectrum name='r' value='400:0 500:-1'/>",
                Emission,
                "-1, expected a number from 0 to 3.4e38",
            ),
        ] {
            assert_eq!(read(parameter, use_), Err(format!("{message} {end}")));
        }
        assert!(read("<float name='r' value='-2'/>", Unbounded).is_ok());
    }
}
