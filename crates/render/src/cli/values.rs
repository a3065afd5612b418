//! Values on the command line: sizes, windows, wavelengths, times.

use std::str::FromStr;
use std::time::Duration;

use crate::scene::metres;

/// `640x480`, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = numbers(text, &['x', 'X']);
        match numbers.as_deref() {
            Some(&[width @ 1..=65_536, height @ 1..=65_536]) => Ok(Self([width, height])),
            _ => Err(format!(
                "'{text}', expected width and height in pixels from 1 to 65536, such as 640x480"
            )),
        }
    }
}

/// `X,Y,W,H`: a window of the film, pixels, from the top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop(pub [u32; 4]);

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text, &[',']).as_deref() {
            Some(&[x, y, width, height]) if width > 0 && height > 0 => {
                Ok(Self([x, y, width, height]))
            }
            _ => Err(format!(
                "'{text}', expected left, top, width and height in pixels, such as 100,50,64,64"
            )),
        }
    }
}

fn numbers(text: &str, separators: &[char]) -> Option<Vec<u32>> {
    text.split(separators)
        .map(|part| part.trim().parse().ok())
        .collect()
}

/// `FROM:TO:N`: equal bands, nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end of the first.
    pub from: f64,
    /// Upper end of the last.
    pub to: f64,
    /// How many.
    pub count: usize,
}

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "'{text}', expected FROM:TO:N with FROM < TO and N from 1 to 1000, such as 400nm:700nm:16"
            )
        };
        let parts: Vec<&str> = text.split(':').collect();
        let &[from, to, count] = &parts[..] else {
            return Err(wrong());
        };
        let (from, to) = (parse_wavelength(from)?, parse_wavelength(to)?);
        match count.trim().parse() {
            Ok(count @ 1..=1000) if from < to => Ok(Self { from, to, count }),
            _ => Err(wrong()),
        }
    }
}

/// `NAME=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Define {
    /// The name after `$`.
    pub name: String,
    /// What stands for it.
    pub value: String,
}

impl FromStr for Define {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, value)) if !name.is_empty() => Ok(Self {
                name: name.to_owned(),
                value: value.to_owned(),
            }),
            _ => Err(format!("'{text}', expected NAME=VALUE")),
        }
    }
}

/// A wavelength in nm from `550nm`, `550`, `1.6um`.
pub fn parse_wavelength(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) = match text {
        t if t.ends_with("nm") => (&t[..t.len() - 2], 1.0),
        t if t.ends_with("um") => (&t[..t.len() - 2], 1e3),
        t if t.ends_with("mm") => (&t[..t.len() - 2], 1e6),
        t => (t, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if (1.0..=1e9).contains(&(value * factor)) => Ok(value * factor),
        _ => Err(format!(
            "'{text}', expected a wavelength from 1nm to 1000mm, such as 550nm or 1.6um"
        )),
    }
}

/// A separation in metres: `10um` toward image right, or `10um,5um` toward image right and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation(pub [f64; 2]);

impl FromStr for Separation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "'{text}', expected a separation from 1nm to 1m such as 10um, or 10um,-5um toward image right and up"
            )
        };
        let lengths: Vec<f64> = text
            .split(',')
            .map(length)
            .collect::<Option<_>>()
            .ok_or_else(wrong)?;
        let separation = match lengths[..] {
            [x] => [x, 0.0],
            [x, y] => [x, y],
            _ => return Err(wrong()),
        };
        // a rounding error beyond the ends is theirs
        let long = separation[0].hypot(separation[1]);
        if (0.999_999e-9..=1.000_001).contains(&long) {
            Ok(Self(separation))
        } else {
            Err(wrong())
        }
    }
}

/// A length with its unit, in metres; 0 needs none.
fn length(text: &str) -> Option<f64> {
    if text.trim() == "0" {
        Some(0.0)
    } else {
        metres(text)
    }
}

/// A time from `60s`, `60`, `2m`, `1h`, `500ms`.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let (number, factor) = units
        .iter()
        .find_map(|(unit, factor)| text.strip_suffix(unit).map(|number| (number, *factor)))
        .unwrap_or((text, 1.0));
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * factor < 1e9 => {
            Ok(Duration::from_secs_f64(value * factor))
        }
        _ => Err(format!(
            "'{text}', expected a positive time such as 60s, 5m or 1h"
        )),
    }
}

/// `0.01` for all Stokes components, or `S0=0.01,S3=0.002` for some of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorTargets {
    /// Of each component; infinite of those without.
    pub targets: [f64; 4],
    /// Whether the components are named.
    pub named: bool,
}

impl ErrorTargets {
    /// The first component beyond S0 that is asked for by its name.
    pub fn beyond_s0(&self) -> Option<usize> {
        (1..4).find(|&k| self.named && self.targets[k].is_finite())
    }
}

impl FromStr for ErrorTargets {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "'{text}', expected a positive number such as 0.01 (1 %), or one for some components such as S0=0.01,S3=0.002"
            )
        };
        let number = |text: &str| {
            let value = text.trim().parse::<f64>().ok();
            (value.filter(|v| *v > 0.0 && v.is_finite())).ok_or_else(wrong)
        };
        if !text.contains('=') {
            return Ok(Self {
                targets: [number(text)?; 4],
                named: false,
            });
        }
        let mut targets = [f64::INFINITY; 4];
        for part in text.split(',') {
            let (name, value) = part.split_once('=').ok_or_else(wrong)?;
            let component = ["S0", "S1", "S2", "S3"]
                .iter()
                .position(|other| other.eq_ignore_ascii_case(name.trim()))
                .ok_or_else(wrong)?;
            if targets[component].is_finite() {
                return Err(wrong());
            }
            targets[component] = number(value)?;
        }
        Ok(Self {
            targets,
            named: true,
        })
    }
}

/// The size of emitter patches in widths of the lobe that sees them.
pub fn parse_patch(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if (0.0..=1e3).contains(&value) => Ok(value),
        _ => Err(format!(
            "'{text}', expected a number from 0 (single points) to 1000 such as 0.5"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_units_are_read() {
        assert_eq!("640x480".parse(), Ok(Size([640, 480])));
        assert_eq!("1, 2,3 ,4".parse(), Ok(Crop([1, 2, 3, 4])));
        assert_eq!(parse_wavelength("1.6um"), Ok(1600.0));
        assert_eq!(parse_wavelength("550"), Ok(550.0));
        assert_eq!(parse_duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("250ms"), Ok(Duration::from_millis(250)));
        assert_eq!(
            "400nm:700nm:16".parse(),
            Ok(Band {
                from: 400.0,
                to: 700.0,
                count: 16
            })
        );
        assert_eq!(
            "a=b=c".parse(),
            Ok(Define {
                name: "a".into(),
                value: "b=c".into()
            })
        );
    }

    #[test]
    fn separations_are_read_in_their_units() {
        let separation = |text: &str| text.parse::<Separation>().map(|s| s.0);
        assert_eq!(separation("10um"), Ok([1e-5, 0.0]));
        assert_eq!(separation("1 mm, -5 µm"), Ok([1e-3, -5e-6]));
        assert_eq!(separation("0,2cm"), Ok([0.0, 0.02]));
        assert_eq!(separation("1nm"), Ok([1e-9, 0.0]));
        for text in [
            "",
            "10",
            "0",
            "0,0",
            "1um,",
            "1um,2um,3um",
            "2m",
            "xum",
            "infm",
        ] {
            assert!(
                separation(text).is_err_and(|e| e.contains("such as 10um")),
                "{text}"
            );
        }
    }

    #[test]
    fn nonsense_is_refused_with_an_example() {
        for text in ["", "0x10", "10", "10x", "-1x5", "1e3x1", "99999999999x1"] {
            assert!(
                text.parse::<Size>().is_err_and(|e| e.contains("640x480")),
                "{text}"
            );
        }
        for text in ["700nm:400nm:3", "400:700:0", "400:700", "400:700:x"] {
            assert!(text.parse::<Band>().is_err(), "{text}");
        }
        for text in ["", "nm", "-5nm", "NaN", "inf", "0"] {
            assert!(parse_wavelength(text).is_err(), "{text}");
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }
}
