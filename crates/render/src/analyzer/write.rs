//! Everything that `--analyzer` asks for, as files.
//!
//! ```text
//! STEM.linear30.exr  STEM.rcp.npy …                  Stokes images; pictures of them as STEM.linear30_s0.png
//! STEM.camera000.exr … camera045 camera090 camera135    intensities, with a 16-bit PNG of the same name
//! STEM.mosaic.exr, .png                              the raw frame
//! STEM_analyzers.json                                what they are: matrices, variances, levels
//! ```

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::camera::{self, ANGLES, MOSAIC};
use super::{Incident, Request, Requests};
use crate::image::StokesImage;
use crate::maps::{self, FRAME, HANDEDNESS, MapOptions};
use crate::output::{self, ImageError, WriteOptions};

/// Where the files go, and which there are.
#[derive(Debug)]
pub struct Destination<'a> {
    /// Folder, created where it is missing.
    pub folder: &'a Path,
    /// First part of every name.
    pub stem: &'a str,
    /// Arrays instead of EXR files.
    pub npy: bool,
    /// Channels of EXR files.
    pub write: WriteOptions,
    /// How pictures are drawn; exposures are those of the image before the analyzers.
    pub pictures: &'a MapOptions,
    /// Whether Stokes images behind analyzers get a picture of their intensity.
    pub draw: bool,
}

/// What [`write_all`] wrote.
#[derive(Debug, Clone, Serialize)]
pub struct AnalyzerReport {
    /// Name of the image before the analyzers.
    pub image: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frame of the matrices.
    pub frame: &'static str,
    /// Meaning of the sign of S3.
    pub handedness: &'static str,
    /// What the variances are.
    pub variance: &'static str,
    /// Intensity that raw pictures show as 65535.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white: Option<f64>,
    /// One entry per image.
    pub images: Vec<AnalyzerRow>,
    /// Everything that was written.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
}

/// One image in the side-car file.
#[derive(Debug, Clone, Serialize)]
pub struct AnalyzerRow {
    /// Name as in the file's.
    pub name: String,
    /// What stands before the film.
    pub description: String,
    /// The image's file.
    pub file: String,
    /// Rows of the Mueller matrix that the image shows: all four, or the intensity's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mueller: Vec<[f64; 4]>,
    /// Degrees of the polarizers of a mosaic: rows from the top, columns from the left; it repeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<[[u32; 2]; 2]>,
    /// The picture's file, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// Share of a raw picture's numbers that are beyond 0 or white.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clipped_share: Option<f64>,
}

/// Writes the images behind all analyzers, their pictures, and `STEM_analyzers.json`.
///
/// # Errors
/// An option does not fit the image, or a file cannot be written.
pub fn write_all(
    light: &Incident<'_>,
    requests: &Requests,
    destination: &Destination<'_>,
) -> Result<AnalyzerReport, ImageError> {
    std::fs::create_dir_all(destination.folder).map_err(|source| ImageError::Write {
        path: destination.folder.to_owned(),
        source,
    })?;
    let image = light.image();
    let exposure = maps::exposure(image, destination.pictures)?;
    let raw = |request: &Request| matches!(request, Request::Camera | Request::Mosaic);
    let white = match destination.pictures.exposure {
        Some(exposure) => 1.0 / exposure,
        None => camera::white(light, 1.0 / exposure),
    };
    let mut writer = Writer {
        destination,
        exposure,
        white,
        report: AnalyzerReport {
            image: destination.stem.to_owned(),
            width: image.width,
            height: image.height,
            frame: FRAME,
            handedness: HANDEDNESS,
            variance: light.variance(),
            white: requests.list.iter().any(raw).then_some(white),
            images: Vec::new(),
            files: Vec::new(),
        },
    };
    for request in &requests.list {
        match request {
            Request::Analyzer(analyzer) => {
                let behind = light.behind(analyzer);
                let rows = analyzer.rows().to_vec();
                writer.stokes(&analyzer.name, &behind, rows)?;
            }
            Request::Camera => {
                for angle in ANGLES {
                    let frame = camera::frame(light, angle);
                    let rows = vec![camera::frame_row(angle)];
                    writer.raw(&format!("camera{angle:03}"), &frame, rows, None)?;
                }
            }
            Request::Mosaic => {
                let frame = camera::mosaic(light);
                writer.raw("mosaic", &frame, Vec::new(), Some(MOSAIC))?;
            }
        }
    }
    writer.finish()
}

struct Writer<'a> {
    destination: &'a Destination<'a>,
    exposure: f64,
    white: f64,
    report: AnalyzerReport,
}

impl Writer<'_> {
    /// Writes a Stokes image and perhaps a picture of its intensity.
    fn stokes(
        &mut self,
        name: &str,
        image: &StokesImage,
        mueller: Vec<[f64; 4]>,
    ) -> Result<(), ImageError> {
        let mut row = self.image(name, image, mueller)?;
        if self.destination.draw {
            let options = MapOptions {
                maps: vec!["s0".to_owned()],
                exposure: Some(self.exposure),
                ..self.destination.pictures.clone()
            };
            let stem = format!("{}.{name}", self.destination.stem);
            let drawn = maps::write_all(image, &options, self.destination.folder, &stem)?;
            row.picture = drawn.maps.first().map(|map| map.file.clone());
            self.report.files.extend(drawn.files);
        }
        self.report.images.push(row);
        Ok(())
    }

    /// Writes the intensities of detectors, and a raw picture.
    fn raw(
        &mut self,
        name: &str,
        frame: &StokesImage,
        mueller: Vec<[f64; 4]>,
        pattern: Option<[[u32; 2]; 2]>,
    ) -> Result<(), ImageError> {
        let mut row = self.image(name, frame, mueller)?;
        let path = self.path(name, "png");
        let raw = camera::raw(frame, self.white).map_err(ImageError::Request)?;
        output::write_atomically(&path, &raw.png)?;
        row.pattern = pattern;
        row.picture = Some(maps::file_name(&path));
        row.clipped_share = Some(raw.clipped);
        self.report.files.push(path);
        self.report.images.push(row);
        Ok(())
    }

    fn image(
        &mut self,
        name: &str,
        image: &StokesImage,
        mueller: Vec<[f64; 4]>,
    ) -> Result<AnalyzerRow, ImageError> {
        let path = self.path(name, if self.destination.npy { "npy" } else { "exr" });
        output::write(&path, image, &self.destination.write)?;
        let file = maps::file_name(&path);
        self.report.files.push(path);
        Ok(AnalyzerRow {
            name: name.to_owned(),
            description: image.metadata.get("analyzer").cloned().unwrap_or_default(),
            file,
            mueller,
            pattern: None,
            picture: None,
            clipped_share: None,
        })
    }

    fn path(&self, name: &str, extension: &str) -> PathBuf {
        let Destination { folder, stem, .. } = self.destination;
        folder.join(format!("{stem}.{name}.{extension}"))
    }

    fn finish(mut self) -> Result<AnalyzerReport, ImageError> {
        let Destination { folder, stem, .. } = self.destination;
        let path = folder.join(format!("{stem}_analyzers.json"));
        let json = serde_json::to_string_pretty(&self.report)
            .map_err(|e| ImageError::content(&path, e.to_string()))?;
        output::write_atomically(&path, (json + "\n").as_bytes())?;
        self.report.files.push(path);
        Ok(self.report)
    }
}
