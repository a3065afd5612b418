//! The names of EXR channels: what each stands for, both ways.
//!
//! ```text
//! one wavelength   S0 … S3               S0.var … S3.var
//! colour           S0.R … S3.B           S0.var.R … S3.var.B        (Mitsuba's names)
//! bands            S0.550,000000nm …     S0.var.550,000000nm …      (Fichet et al. 2021, JCGT 10(3))
//! copies of S0     R G B, for readers that know plain colour only
//! coherence        coherence.major, .minor (m), .angle (rad), .degree: one number a pixel, whatever the colours
//! ```
//!
//! Wavelengths carry six decimals with a comma, since a dot separates layers in EXR.

use crate::image::Colour;

/// What an EXR channel holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Channel {
    /// Stokes component, 0 to 3.
    pub(super) component: usize,
    /// Whether it is the variance of the component.
    pub(super) variance: bool,
    /// Which colour of the component.
    pub(super) part: Part,
}

/// The colour that a channel's name ends in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Part {
    /// Plain `S0`, `S0.Y`, `S0.V`, `S0.L`.
    One,
    /// `S0.R`, `S0.G`, `S0.B`: 0, 1, 2.
    Rgb(usize),
    /// `S0.550,000000nm`.
    Wavelength(f64),
}

/// The channels of coherence, in the order of [`crate::image::StokesImage::coherence`].
pub(super) const COHERENCE: [&str; 4] = [
    "coherence.major",
    "coherence.minor",
    "coherence.angle",
    "coherence.degree",
];

/// The channel of the numbers of samples, where they differ.
pub(super) const SAMPLES: &str = "samples";

/// The name under which we write a channel.
pub(super) fn name(component: usize, variance: bool, colour: &Colour, index: usize) -> String {
    let var = if variance { ".var" } else { "" };
    match colour {
        Colour::Mono { .. } => format!("S{component}{var}"),
        Colour::Rgb => format!("S{component}{var}.{}", colour.name(index)),
        Colour::Bands { wavelengths_nm } => {
            let nm = format!("{:.6}", wavelengths_nm[index]).replace('.', ",");
            format!("S{component}{var}.{nm}nm")
        }
    }
}

/// What a channel's name says; `None` for channels that are no part of a Stokes image.
pub(super) fn parse(name: &str) -> Option<Channel> {
    let lower = name.to_lowercase();
    let (head, mut rest) = lower.split_once('.').unwrap_or((&lower, ""));
    let component = match head {
        "s0" => 0,
        "s1" => 1,
        "s2" => 2,
        "s3" => 3,
        _ => return None,
    };
    let mut variance = false;
    if let Some(after) = rest.strip_prefix("var")
        && (after.is_empty() || after.starts_with('.'))
    {
        variance = true;
        rest = after.trim_start_matches('.');
    }
    let part = match rest {
        "" | "y" | "v" | "l" => Part::One,
        "r" => Part::Rgb(0),
        "g" => Part::Rgb(1),
        "b" => Part::Rgb(2),
        // the case of a metric prefix matters: M and m
        _ => Part::Wavelength(wavelength(&name[name.len() - rest.len()..])?),
    };
    Some(Channel {
        component,
        variance,
        part,
    })
}

/// The wavelength of `550,000000nm`, `0,55um`, `545THz` in nanometres.
fn wavelength(text: &str) -> Option<f64> {
    let end = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E')?;
    let number: f64 = text[..end].replace(',', ".").parse().ok()?;
    let unit = &text[end..];
    let nm = if let Some(prefix) = unit.strip_suffix("Hz") {
        const LIGHT_NM_PER_S: f64 = 299_792_458e9;
        LIGHT_NM_PER_S / (number * metric(prefix)?)
    } else {
        number * metric(unit.strip_suffix('m')?)? * 1e9
    };
    (nm.is_finite() && nm > 0.0).then_some((nm * 1e6).round() / 1e6)
}

fn metric(prefix: &str) -> Option<f64> {
    Some(match prefix {
        "T" => 1e12,
        "G" => 1e9,
        "M" => 1e6,
        "k" => 1e3,
        "" => 1.0,
        "c" => 1e-2,
        "m" => 1e-3,
        "u" => 1e-6,
        "n" => 1e-9,
        "p" => 1e-12,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str) -> Option<(usize, bool, Part)> {
        parse(name).map(|c| (c.component, c.variance, c.part))
    }

    #[test]
    fn names_of_all_layouts_are_understood() {
        assert_eq!(part("S2"), Some((2, false, Part::One)));
        assert_eq!(part("S0.Y"), Some((0, false, Part::One)));
        assert_eq!(part("s3.g"), Some((3, false, Part::Rgb(1))));
        assert_eq!(part("S1.var"), Some((1, true, Part::One)));
        assert_eq!(part("S1.var.B"), Some((1, true, Part::Rgb(2))));
        assert_eq!(
            part("S0.550,000000nm"),
            Some((0, false, Part::Wavelength(550.0)))
        );
        assert_eq!(
            part("S0.var.550,5nm"),
            Some((0, true, Part::Wavelength(550.5)))
        );
        assert_eq!(part("S0.0,55um"), Some((0, false, Part::Wavelength(550.0))));
        assert_eq!(
            part("S0.5,5e-1um"),
            Some((0, false, Part::Wavelength(550.0)))
        );
        assert_eq!(
            part("S3.500THz"),
            Some((3, false, Part::Wavelength(599.584916)))
        );
    }

    #[test]
    fn other_channels_are_passed_over() {
        for name in [
            "R",
            "A",
            "Y",
            "S4",
            "S0.foo",
            "S0.550",
            "S0.nm",
            "S",
            "",
            "albedo.S0",
            "S0.variance",
            "S0.-1nm",
            "S0.ünm",
        ] {
            assert_eq!(parse(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        let bands = Colour::Bands {
            wavelengths_nm: vec![400.0, 650.125],
        };
        assert_eq!(name(2, false, &bands, 1), "S2.650,125000nm");
        assert_eq!(
            part(&name(2, true, &bands, 1)),
            Some((2, true, Part::Wavelength(650.125)))
        );
        assert_eq!(name(3, true, &Colour::Rgb, 2), "S3.var.B");
    }
}
