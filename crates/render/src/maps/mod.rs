//! Pictures of a Stokes image: each map is a row of [`TABLE`], drawn with a legend.
//!
//! Angles are counter-clockwise for an observer who faces the source, from the image's right, in radians in data files and in
//! degrees in legends. S3 > 0 is right-handed: clockwise for that observer.

use std::path::{Path, PathBuf};

use stokes::StokesVector;

use crate::image::StokesImage;
use crate::output::{self, ImageError};

mod coherence;
mod colours;
mod drawing;
mod ellipses;
mod legend;
mod measure;
mod numbers;
mod page;
mod paint;
mod raster;
mod report;
mod svg;

pub use coherence::SEPARATION;
pub use colours::HandednessColours;
pub use measure::{ColourChoice, Statistics};
pub(crate) use report::{FRAME, HANDEDNESS, file_name};
pub use report::{MapReport, MapRow};

/// One kind of map.
#[derive(Debug)]
pub struct Map {
    /// What the command line and the file name call it.
    pub name: &'static str,
    /// Heading of the picture.
    pub title: &'static str,
    /// What is drawn, as a formula.
    pub formula: &'static str,
    /// Names of the planes in data files.
    pub channels: &'static [&'static str],
    /// Unit of the first plane.
    pub unit: &'static str,
    /// Which numbers the colours span.
    range: Range,
    /// How numbers become colours.
    style: Style,
    /// The planes' numbers for one Stokes vector.
    planes: &'static [Observable],
    /// The degree below which the map has no meaning, where there is one.
    needs: Option<Needs>,
}

type Observable = fn(&StokesVector) -> f64;

/// The numbers that the colours span.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Range {
    /// From the exposure.
    Tone,
    /// Always these.
    Fixed(f64, f64),
    /// Symmetric about zero, as wide as the image needs, at most 1.
    Symmetric,
    /// From zero to what the image needs, at most 1.
    Degree,
}

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    Tone,
    Sequential,
    Diverging,
    Handed,
    Hue,
    WeightedHue,
    Kind,
    Ellipses,
    Coherence(coherence::Kind),
}

impl Style {
    /// Whether shapes lie over the intensity: such maps are written as SVG too, and have no numbers.
    fn is_overlay(self) -> bool {
        matches!(
            self,
            Self::Ellipses | Self::Coherence(coherence::Kind::Ellipses)
        )
    }
}

/// What an angle needs to have a meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needs {
    LinearPart,
    PolarizedPart,
}

/// Degrees below this carry no angle.
const LEAST_DEGREE: f64 = 0.005;

const DOLP: Observable = StokesVector::degree_of_linear_polarization;
const DOP: Observable = StokesVector::degree_of_polarization;
const AOLP: Observable = StokesVector::angle_of_linear_polarization;
const CHI: Observable = StokesVector::ellipticity_angle;
const FULL: f64 = std::f64::consts::FRAC_PI_4;

fn per_s0(component: f64, s: &StokesVector) -> f64 {
    if s.s0() > 0.0 {
        component / s.s0()
    } else {
        0.0
    }
}

/// All maps, in the order in which they are made.
#[rustfmt::skip]
pub static TABLE: [Map; 15] = [
    Map { name: "s0", title: "Intensity", formula: "S0", channels: &["S0"], unit: "as the image",
          range: Range::Tone, style: Style::Tone, planes: &[StokesVector::intensity], needs: None },
    Map { name: "s1", title: "Horizontal minus vertical", formula: "S1/S0", channels: &["s1"], unit: "1",
          range: Range::Symmetric, style: Style::Diverging, planes: &[|s| per_s0(s.s1(), s)], needs: None },
    Map { name: "s2", title: "Diagonal minus antidiagonal", formula: "S2/S0, positive towards right and up", channels: &["s2"], unit: "1",
          range: Range::Symmetric, style: Style::Diverging, planes: &[|s| per_s0(s.s2(), s)], needs: None },
    Map { name: "s3", title: "Right minus left circular", formula: "S3/S0", channels: &["s3"], unit: "1",
          range: Range::Symmetric, style: Style::Diverging, planes: &[|s| per_s0(s.s3(), s)], needs: None },
    Map { name: "dop", title: "Degree of polarization", formula: "DoP = √(S1² + S2² + S3²)/S0", channels: &["dop"], unit: "1",
          range: Range::Degree, style: Style::Sequential, planes: &[DOP], needs: None },
    Map { name: "dolp", title: "Degree of linear polarization", formula: "DoLP = √(S1² + S2²)/S0", channels: &["dolp"], unit: "1",
          range: Range::Degree, style: Style::Sequential, planes: &[DOLP], needs: None },
    Map { name: "docp", title: "Degree of circular polarization", formula: "DoCP = S3/S0, positive right-handed", channels: &["docp"], unit: "1",
          range: Range::Symmetric, style: Style::Handed, planes: &[StokesVector::degree_of_circular_polarization], needs: None },
    Map { name: "aolp", title: "Angle of linear polarization", formula: "AoLP = ½ atan2(S2, S1)", channels: &["aolp"], unit: "rad",
          range: Range::Fixed(0.0, 4.0 * FULL), style: Style::Hue, planes: &[AOLP], needs: Some(Needs::LinearPart) },
    Map { name: "aolp-dolp", title: "Angle of linear polarization × DoLP", formula: "hue AoLP, brightness DoLP", channels: &["aolp", "dolp"], unit: "rad",
          range: Range::Fixed(0.0, 4.0 * FULL), style: Style::WeightedHue, planes: &[AOLP, DOLP], needs: None },
    Map { name: "ellipticity", title: "Ellipticity angle", formula: "χ = ½ atan2(S3, √(S1² + S2²))", channels: &["ellipticity"], unit: "rad",
          range: Range::Fixed(-FULL, FULL), style: Style::Handed, planes: &[CHI], needs: Some(Needs::PolarizedPart) },
    Map { name: "type", title: "Type of polarization × DoP", formula: "cyan linear, yellow circular, brightness DoP", channels: &["ellipticity", "dop"], unit: "rad",
          range: Range::Fixed(0.0, FULL), style: Style::Kind, planes: &[CHI, DOP], needs: None },
    Map { name: "ellipses", title: "Polarization ellipses", formula: "over the intensity; each ellipse the mean of its square", channels: &[], unit: "",
          range: Range::Tone, style: Style::Ellipses, planes: &[], needs: None },
    Map { name: "coherence", title: "Radius of coherence", formula: "√(a b) of the coherence ellipse", channels: &["radius"], unit: "m",
          range: Range::Tone, style: Style::Coherence(coherence::Kind::Width), planes: &[], needs: None },
    Map { name: "coherence-degree", title: "Degree of coherence", formula: "|γ(ξ)| at one separation", channels: &["degree"], unit: "1",
          range: Range::Fixed(0.0, 1.0), style: Style::Coherence(coherence::Kind::Degree), planes: &[], needs: None },
    Map { name: "coherence-ellipses", title: "Coherence ellipses", formula: "over the intensity; |γ| falls to e^(−½) on the ellipse", channels: &[], unit: "m",
          range: Range::Tone, style: Style::Coherence(coherence::Kind::Ellipses), planes: &[], needs: None },
];

/// What to draw, and how.
#[derive(Debug, Clone)]
pub struct MapOptions {
    /// Names of maps as in [`TABLE`]; empty for all that the image allows.
    pub maps: Vec<String>,
    /// Pixels darker than this times the mean S0 are masked.
    pub threshold: f64,
    /// Colours of the senses of rotation.
    pub handedness_colours: HandednessColours,
    /// Distance of the ellipses in image pixels; chosen by size where absent.
    pub ellipse_spacing: Option<usize>,
    /// Which colours of a pixel are drawn.
    pub colour: ColourChoice,
    /// Factor from S0 to display white; chosen by the image where absent.
    pub exposure: Option<f64>,
    /// Write the maps' numbers as `.npy` beside the pictures.
    pub data: bool,
    /// Span the possible numbers, 0 or −1 to 1, where the colours would follow the image.
    pub full_range: bool,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            maps: Vec::new(),
            threshold: 0.01,
            handedness_colours: HandednessColours::default(),
            ellipse_spacing: None,
            colour: ColourChoice::default(),
            exposure: None,
            data: false,
            full_range: false,
        }
    }
}

/// Writes the maps of an image as `STEM_NAME.png` into a folder, with `STEM_maps.json` beside them.
///
/// Ellipses are written as SVG too. The folder is created where it is missing.
///
/// # Errors
/// A map's name is unknown or the image cannot have it, an option does not fit the image, or a file cannot be written.
pub fn write_all(
    image: &StokesImage,
    options: &MapOptions,
    folder: &Path,
    stem: &str,
) -> Result<MapReport, ImageError> {
    let maps = chosen(image, &options.maps)?;
    let scene = paint::Scene::new(image, options, stem)?;
    std::fs::create_dir_all(folder).map_err(|source| ImageError::Write {
        path: folder.to_owned(),
        source,
    })?;
    let mut report = scene.report();
    for map in maps {
        let (drawing, mut row) = scene.draw(map);
        let mut save = |suffix: &str, bytes: &[u8]| -> Result<PathBuf, ImageError> {
            let path = folder.join(format!("{stem}_{}.{suffix}", map.name));
            output::write_atomically(&path, bytes)?;
            report.files.push(path.clone());
            Ok(path)
        };
        row.file = file_name(&save(
            "png",
            &raster::png(&drawing).map_err(ImageError::Request)?,
        )?);
        if map.style.is_overlay() {
            save(
                "svg",
                svg::svg(&drawing).map_err(ImageError::Request)?.as_bytes(),
            )?;
        } else if options.data {
            let path = folder.join(format!("{stem}_{}.npy", map.name));
            let (shape, values) = scene.data(map);
            output::npy::write_array(&path, &shape, &values)?;
            row.data = Some(file_name(&path));
            report.files.push(path);
        }
        report.maps.push(row);
    }
    let path = folder.join(format!("{stem}_maps.json"));
    let json = serde_json::to_string_pretty(&report)
        .map_err(|e| ImageError::content(&path, e.to_string()))?;
    output::write_atomically(&path, (json + "\n").as_bytes())?;
    report.files.push(path);
    Ok(report)
}

/// The factor from S0 to display white that the `s0` map of an image has.
///
/// # Errors
/// An option does not fit the image.
pub fn exposure(image: &StokesImage, options: &MapOptions) -> Result<f64, ImageError> {
    Ok(paint::Scene::new(image, options, "")?.exposure)
}

/// Refuses names that no map has, so that a long render need not run before a typing error shows.
///
/// # Errors
/// A name is not in [`TABLE`].
pub fn check_names(names: &[String]) -> Result<(), ImageError> {
    names.iter().try_for_each(|name| named(name).map(drop))
}

/// The maps of that name, or all that the image allows.
fn chosen(image: &StokesImage, names: &[String]) -> Result<Vec<&'static Map>, ImageError> {
    let possible = |map: &Map| match map.style {
        Style::Coherence(_) => image.coherence.is_some(),
        Style::Tone => true,
        _ => image.components == 4,
    };
    if names.is_empty() {
        return Ok(TABLE.iter().filter(|map| possible(map)).collect());
    }
    let find = |name: &String| {
        let map = named(name)?;
        if possible(map) {
            return Ok(map);
        }
        if needs_coherence(name) {
            return Err(ImageError::Request(format!(
                "the image has no coherence, map '{name}' needs it; render it with --coherence 10um"
            )));
        }
        Err(ImageError::Request(format!(
            "the image has S0 only, map '{name}' needs S1 to S3; render it without --unpolarized"
        )))
    };
    names.iter().map(find).collect()
}

/// Whether a map draws the coherence of an image, which is rendered only on request.
pub fn needs_coherence(name: &str) -> bool {
    named(name).is_ok_and(|map| matches!(map.style, Style::Coherence(_)))
}

fn named(name: &str) -> Result<&'static Map, ImageError> {
    TABLE.iter().find(|map| map.name == name).ok_or_else(|| {
        let known: Vec<&str> = TABLE.iter().map(|map| map.name).collect();
        let likeness = |other: &str| strsim::jaro(other, name);
        let nearest = known
            .iter()
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let remedy = nearest
            .filter(|other| likeness(other) > 0.7)
            .map_or_else(String::new, |n| format!("; did you mean '{n}'?"));
        ImageError::Request(format!(
            "unknown map '{name}', expected some of {}{remedy}",
            known.join(",")
        ))
    })
}

#[cfg(test)]
#[path = "map_tests.rs"]
mod tests;
