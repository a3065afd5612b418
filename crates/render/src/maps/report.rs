//! What was drawn, for the side-car file and for the caller.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::measure::Statistics;

/// What [`super::write_all`] wrote, and what it found on the way.
#[derive(Debug, Clone, Serialize)]
pub struct MapReport {
    /// Name of the image that was drawn.
    pub image: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Which colours of the pixels; empty for images of one number per component.
    pub colour: String,
    /// Frame of the angles.
    pub frame: &'static str,
    /// Meaning of the sign of S3.
    pub handedness: &'static str,
    /// Which colours tell the senses of rotation.
    pub handedness_colours: &'static str,
    /// Pixels with S0 below this are masked.
    pub threshold: f64,
    /// Factor from S0 to display white.
    pub exposure: f64,
    /// Shares of masked and of impossible pixels; bias by noise.
    pub statistics: Statistics,
    /// One entry per map.
    pub maps: Vec<MapRow>,
    /// Everything that was written.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
}

/// One map in the side-car file.
#[derive(Debug, Clone, Serialize)]
pub struct MapRow {
    /// Name as on the command line.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What is drawn.
    pub formula: &'static str,
    /// The picture's file.
    pub file: String,
    /// The numbers' file, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<String>,
    /// Planes of the numbers' file.
    pub channels: &'static [&'static str],
    /// Unit of the numbers.
    pub unit: &'static str,
    /// Numbers at the ends of the colours, in that unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// Degree at full brightness, where brightness shows one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_brightness: Option<f64>,
    /// Share of drawn pixels beyond the limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clipped_share: Option<f64>,
}

pub(crate) const FRAME: &str = "per pixel: x = image right, y = image up, light towards the viewer; angles counter-clockwise from x";
pub(crate) const HANDEDNESS: &str =
    "S3 > 0 is right-handed: clockwise for an observer who faces the source";

pub(crate) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
