//! Refractive indices of films, plates and substrates, as scenes give them.
//!
//! | in the file                                           | index                                            |
//! |-------------------------------------------------------|--------------------------------------------------|
//! | `<float value="1.46"/>`, `1.46` in a text             | real, at every wavelength                        |
//! | `0.2-3.4i` in a text                                  | η − i k, at every wavelength                     |
//! | `<spectrum value="400:1.47, 700:1.455"/>`             | real, linear between the wavelengths in nm       |
//! | `water`, `Al`, … in a text                            | of the named media; end values held              |
//! | `quartz_o`, `quartz_e`, `calcite_o`, `calcite_e`      | of these crystals, by formula                    |
//! | `film.csv`, or any name in `.csv`, `.txt`, `.spd`     | rows of wavelength in nm, η and, if any, k       |
//!
//! A rendering at wavelengths outside a table of the scene is refused.

use num_complex::Complex64;

use super::unknown_name;
use crate::ior;
use crate::scene::{Object, Position, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// n² = A + B₁λ²/(λ² − C₁) + B₂λ²/(λ² − C₂), λ in µm.
///
/// Source: Ghosh, Opt. Commun. 163, 95 (1999).
const CRYSTALS: [(&str, [f64; 5]); 4] = [
    (
        "quartz_o",
        [1.28604141, 1.07044083, 1.00585997e-2, 1.10202242, 100.0],
    ),
    (
        "quartz_e",
        [1.28851804, 1.09509924, 1.02101864e-2, 1.15662475, 100.0],
    ),
    (
        "calcite_o",
        [1.73358749, 0.96464345, 1.94325203e-2, 1.82831454, 120.0],
    ),
    (
        "calcite_e",
        [1.35859695, 0.82427830, 1.06689543e-2, 0.14429128, 120.0],
    ),
];

/// A refractive index η − i k by wavelength.
#[derive(Clone, Debug)]
pub struct Index {
    data: Data,
    known: Option<Known>,
}

#[derive(Clone, Debug)]
enum Data {
    Constant(Complex64),
    Spectra { eta: Spectrum, k: Option<Spectrum> },
    Formula([f64; 5]),
}

/// The wavelengths for which the scene has data, and where in the scene file.
#[derive(Clone, Debug)]
pub struct Known {
    /// First and last wavelength, nm.
    pub range: [f64; 2],
    /// The parameter.
    pub place: Position,
    /// What it is, in words.
    pub what: String,
}

impl Known {
    /// Refuses wavelengths outside.
    ///
    /// # Errors
    ///
    /// At the parameter, with both ranges.
    pub fn check(&self, [from, to]: [f64; 2]) -> Result<(), SceneError> {
        let [first, last] = self.range;
        if first <= from && to <= last {
            return Ok(());
        }
        let wanted = if from == to {
            format!("{from} nm")
        } else {
            format!("{from} to {to} nm")
        };
        Err(self.place.error(format!(
            "{} is known from {first} to {last} nm, expected a table that holds {wanted}; --wavelength or --bands \
             choose others",
            self.what
        )))
    }
}

impl Index {
    /// The same index at every wavelength.
    pub fn constant(index: Complex64) -> Self {
        Self {
            data: Data::Constant(index),
            known: None,
        }
    }

    /// Reads a parameter: a number, a spectrum or a text.
    ///
    /// # Errors
    ///
    /// At the parameter: what is no index, an unknown name, a file that cannot be read.
    pub fn read(object: &Object, name: &str, default: &str) -> Result<Self, SceneError> {
        if object.is_string(name) || !object.has(name) {
            let text = object.string(name, default)?;
            return Self::of_text(object, name, &text);
        }
        let Some(spectrum) = object.optional_spectrum(name, SpectrumUse::Unbounded)? else {
            return Self::of_text(object, name, default);
        };
        if spectrum.is_constant() {
            // once more, in double precision
            let value = object.float(name, 1.0)?;
            return Self::constant(value.into()).checked(object, name);
        }
        let Some(range) = spectrum.domain() else {
            return Err(object.error_at(
                name,
                format!(
                    "'{name}' of {} is a colour, expected an index of refraction",
                    object.describe()
                ),
            ));
        };
        Self {
            data: Data::Spectra {
                eta: spectrum,
                k: None,
            },
            known: Some(Known {
                range,
                place: object.place_of(name).clone(),
                what: format!("'{name}' of {}", object.describe()),
            }),
        }
        .checked(object, name)
    }

    /// Reads the text of a parameter, or a part of it.
    ///
    /// # Errors
    ///
    /// As [`Index::read`].
    pub fn of_text(object: &Object, name: &str, text: &str) -> Result<Self, SceneError> {
        if let Some(number) = complex(text) {
            return Self::constant(number).checked(object, name);
        }
        if [".csv", ".txt", ".spd"]
            .iter()
            .any(|end| text.ends_with(end))
        {
            return Self::of_file(object, name, text)?.checked(object, name);
        }
        if let Some(n) = ior::named_dielectric(text) {
            return Ok(Self::constant(n.into()));
        }
        if let Some((_, formula)) = CRYSTALS.iter().find(|(known, _)| *known == text) {
            return Ok(Self {
                data: Data::Formula(*formula),
                known: None,
            });
        }
        match ior::named_conductor(text) {
            Some((eta, k)) if text != "none" => Ok(Self {
                data: Data::Spectra { eta, k: Some(k) },
                known: None,
            }),
            _ => {
                let crystals = CRYSTALS.iter().map(|(known, _)| *known);
                let metals = ior::conductor_names().filter(|known| *known != "none");
                let known = ior::dielectric_names().chain(crystals).chain(metals);
                Err(unknown_name(object, name, text, known))
            }
        }
    }

    fn of_file(object: &Object, name: &str, text: &str) -> Result<Self, SceneError> {
        let path = object.file(name, text)?;
        let content = std::fs::read_to_string(&path)
            .map_err(|e| object.error_at(name, format!("'{text}' cannot be read: {e}")))?;
        let (mut eta, mut k) = (Vec::new(), Vec::new());
        for (number, row) in rows_of(&content) {
            let wrong = || {
                Position::line(path.as_path().into(), number).error(
                    "expected a wavelength in nm, an index and, if any, an extinction coefficient",
                )
            };
            let row = row.map_err(|_| wrong())?;
            let (nm, n, extinction) = match row[..] {
                [nm, n] => (nm, n, 0.0),
                [nm, n, extinction] => (nm, n, extinction),
                _ => return Err(wrong()),
            };
            eta.push((nm, n));
            k.push((nm, extinction));
        }
        let range = [eta.first(), eta.last()].map(|row| row.map_or(0.0, |row| row.0));
        let absorbs = k.iter().any(|row| row.1 != 0.0);
        let spectrum = |knots| {
            Spectrum::tabulated_held(knots)
                .map_err(|e| object.error_at(name, format!("'{text}': {e}")))
        };
        Ok(Self {
            data: Data::Spectra {
                eta: spectrum(eta)?,
                k: absorbs.then(|| spectrum(k)).transpose()?,
            },
            known: Some(Known {
                range,
                place: object.place_of(name).clone(),
                what: format!("'{text}' of {}", object.describe()),
            }),
        })
    }

    /// Refuses numbers that are no index of passive matter.
    fn checked(self, object: &Object, name: &str) -> Result<Self, SceneError> {
        let values: Vec<Complex64> = match &self.data {
            Data::Constant(n) => vec![*n],
            Data::Formula(_) => Vec::new(),
            Data::Spectra { eta, k } => {
                let knots = eta.knots().iter().map(|&(nm, n)| {
                    let k = k.as_ref().map_or(0.0, |k| k.value(nm as f32));
                    Complex64::new(n, -f64::from(k))
                });
                knots.collect()
            }
        };
        let sound = |n: &Complex64| n.re >= 0.0 && n.im <= 0.0 && (1e-4..=1e4).contains(&n.norm());
        match values.iter().find(|n| !sound(n)) {
            None => Ok(self),
            Some(n) => Err(object.error_at(
                name,
                format!(
                    "an index of refraction of {} - {}i in '{name}' of {}, expected eta - ki with eta and k not \
                     negative, and a modulus between 1e-4 and 1e4",
                    n.re,
                    -n.im,
                    object.describe()
                ),
            )),
        }
    }

    /// The index at a wavelength in nm.
    #[inline]
    pub fn at(&self, wavelength: f32) -> Complex64 {
        match &self.data {
            Data::Constant(n) => *n,
            Data::Spectra { eta, k } => {
                let k = k.as_ref().map_or(0.0, |k| k.value(wavelength));
                Complex64::new(f64::from(eta.value(wavelength)), -f64::from(k))
            }
            Data::Formula([a, b1, c1, b2, c2]) => {
                // within the range where the formula was fitted
                let micrometres = f64::from(wavelength).clamp(200.0, 2050.0) * 1e-3;
                let square = micrometres * micrometres;
                let n2 = a + b1 * square / (square - c1) + b2 * square / (square - c2);
                n2.sqrt().into()
            }
        }
    }

    /// Whether it is the same at every wavelength.
    pub fn is_constant(&self) -> bool {
        matches!(self.data, Data::Constant(_))
    }

    /// Whether it absorbs at any wavelength.
    pub fn absorbs(&self) -> bool {
        match &self.data {
            Data::Constant(n) => n.im != 0.0,
            Data::Spectra { k, .. } => k.is_some(),
            Data::Formula(_) => false,
        }
    }

    /// Refuses wavelengths outside a table of the scene.
    ///
    /// # Errors
    ///
    /// At the table.
    pub fn check(&self, range: [f64; 2]) -> Result<(), SceneError> {
        self.known
            .as_ref()
            .map_or(Ok(()), |known| known.check(range))
    }
}

/// Rows of numbers between commas or blanks, with the numbers of their lines; comments start with `#`, and words on top
/// are a header.
///
/// A row that does not consist of numbers is an `Err`.
pub fn rows_of(text: &str) -> impl Iterator<Item = (u32, Result<Vec<f64>, ()>)> {
    let lines = text.lines().enumerate().map(|(i, line)| {
        let line = line.split('#').next().unwrap_or_default().trim();
        (i as u32 + 1, line)
    });
    let mut header = true;
    lines
        .filter(|(_, line)| !line.is_empty())
        .filter_map(move |(number, line)| {
            let fields = line
                .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
                .filter(|field| !field.is_empty());
            let row: Result<Vec<f64>, ()> = fields
                .map(|field| match field.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => Err(()),
                })
                .collect();
            let is_header = header && row.is_err();
            header = false;
            (!is_header).then_some((number, row))
        })
}

/// Reads `1.46`, `0.2-3.4i` or `3.4i`.
fn complex(text: &str) -> Option<Complex64> {
    let text = text.trim();
    let Some(inner) = text.strip_suffix('i') else {
        return text
            .parse()
            .ok()
            .filter(|n: &f64| n.is_finite())
            .map(Complex64::from);
    };
    // the last sign that belongs to no exponent
    let sign = inner
        .char_indices()
        .rev()
        .find(|&(at, c)| matches!(c, '+' | '-') && !inner[..at].ends_with(['e', 'E']))
        .map_or(0, |(at, _)| at);
    let (re, im) = inner.split_at(sign);
    let number = |part: &str| {
        let part: String = part.chars().filter(|c| !c.is_whitespace()).collect();
        part.parse::<f64>().ok().filter(|n| n.is_finite())
    };
    let re = if re.trim().is_empty() {
        0.0
    } else {
        number(re)?
    };
    Some(Complex64::new(re, number(im)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complex_numbers_are_read() {
        let n = |re, im| Some(Complex64::new(re, im));
        for (text, expected) in [
            ("1.46", n(1.46, 0.0)),
            ("0.2-3.4i", n(0.2, -3.4)),
            ("2 - 0.5i", n(2.0, -0.5)),
            ("1e-1-2e-1i", n(0.1, -0.2)),
            ("-3i", n(0.0, -3.0)),
            ("water", None),
            ("i", None),
            ("1.2.3", None),
            ("nan", None),
        ] {
            assert_eq!(complex(text), expected, "{text}");
        }
    }

    #[test]
    fn quartz_and_calcite_have_the_indices_of_the_handbooks() {
        // at the sodium D line, CRC Handbook of Chemistry and Physics; samples and fits differ by 3e-4
        for (name, n) in [
            ("quartz_o", 1.54424),
            ("quartz_e", 1.55335),
            ("calcite_o", 1.65835),
            ("calcite_e", 1.48640),
        ] {
            let (_, formula) = CRYSTALS.iter().find(|(known, _)| *known == name).unwrap();
            let index = Index {
                data: Data::Formula(*formula),
                known: None,
            };
            assert!((index.at(589.3).re - n).abs() < 4e-4, "{name}");
        }
    }

    #[test]
    fn rows_skip_headers_and_comments_only() {
        let rows: Vec<_> = rows_of("# made up\nnm, n\n400, 1.5\n\n500 1.4 # green\nx,y").collect();
        assert_eq!(
            rows,
            [
                (3, Ok(vec![400.0, 1.5])),
                (5, Ok(vec![500.0, 1.4])),
                (6, Err(()))
            ]
        );
    }
}
