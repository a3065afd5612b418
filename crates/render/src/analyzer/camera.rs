//! A polarization camera: four polarizers at 0, 45, 90 and 135 degrees, one on each pixel of a 2×2 cell.
//!
//! ```text
//! 90   45      the cell at the image's top left, seen from the sensor's front, as on Sony's IMX250MZR; it repeats
//! 135   0
//! ```
//!
//! Raw pictures are 16-bit PNG, linear, with one white for all: 65535 is the greatest intensity behind any of the four
//! polarizers, but at most [`HEADROOM`] times the white of the `s0` map, above which pixels saturate as on a sensor.

use super::{Analyzer, Incident};
use crate::image::{Colour, StokesImage};
use crate::output::display;

/// Angles of a camera's polarizers, degrees.
pub(super) const ANGLES: [u32; 4] = [0, 45, 90, 135];
/// The angle on each pixel of a cell: rows from the top, columns from the left.
pub const MOSAIC: [[u32; 2]; 2] = [[90, 45], [135, 0]];
/// Whites of the `s0` map that a raw picture holds at most.
const HEADROOM: f64 = 16.0;

/// What a pixel behind a polarizer at an angle in degrees reads of S0, S1, S2, S3.
pub fn frame_row(degrees: u32) -> [f64; 4] {
    // exact where cosines of radians are not
    let [c, s] = match degrees % 180 {
        0 => [1.0, 0.0],
        45 => [0.0, 1.0],
        90 => [-1.0, 0.0],
        135 => [0.0, -1.0],
        other => return Analyzer::linear(f64::from(other)).rows()[0],
    };
    [0.5, 0.5 * c, 0.5 * s, 0.0]
}

/// The intensity behind the camera's polarizers of one angle, at every pixel.
pub(super) fn frame(light: &Incident<'_>, degrees: u32) -> StokesImage {
    let row = frame_row(degrees);
    light.detected(
        &format!("polarization camera, polarizers at {degrees} degrees"),
        |_, _| row,
    )
}

/// The intensity behind the polarizer of each pixel's place in its cell.
pub(super) fn mosaic(light: &Incident<'_>) -> StokesImage {
    let rows = MOSAIC.map(|row| row.map(frame_row));
    light.detected(
        "polarization camera, mosaic of polarizers at 90 45 / 135 0 degrees",
        |x, y| rows[y % 2][x % 2],
    )
}

/// The intensity that raw pictures show as 65535; `white` is that of the `s0` map.
pub(super) fn white(light: &Incident<'_>, white: f64) -> f64 {
    let greatest = ANGLES
        .iter()
        .flat_map(|&angle| planes(&frame(light, angle)))
        .flatten()
        .filter(|v| v.is_finite())
        .fold(0.0, f32::max);
    let greatest = f64::from(greatest);
    if greatest > 0.0 {
        greatest.min(HEADROOM * white)
    } else {
        white
    }
}

/// A frame as numbers that a sensor gives out.
pub(super) struct Raw {
    /// PNG, 16 bits, linear; grey, or red, green and blue.
    pub(super) png: Vec<u8>,
    /// Share of the numbers that are beyond 0 or white.
    pub(super) clipped: f64,
}

/// A frame as a raw picture; bands in the colours of the display.
pub(super) fn raw(frame: &StokesImage, white: f64) -> Result<Raw, String> {
    let planes = planes(frame);
    let mut bytes = Vec::with_capacity(2 * planes.len() * planes[0].len());
    let mut clipped = 0_usize;
    for pixel in 0..planes[0].len() {
        for plane in &planes {
            let level = f64::from(plane[pixel]) / white * 65535.0;
            clipped += usize::from(!(-0.5..65535.5).contains(&level));
            bytes.extend((level.round() as u16).to_be_bytes());
        }
    }
    let mut png = Vec::new();
    let size = |n: usize| {
        u32::try_from(n).map_err(|_| format!("a picture {n} pixels wide cannot be held"))
    };
    let mut encoder = png::Encoder::new(&mut png, size(frame.width)?, size(frame.height)?);
    encoder.set_color(if planes.len() == 1 {
        png::ColorType::Grayscale
    } else {
        png::ColorType::Rgb
    });
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&bytes).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(Raw {
        png,
        clipped: clipped as f64 / (planes.len() * planes[0].len()) as f64,
    })
}

/// One plane of numbers, or red, green and blue.
fn planes(frame: &StokesImage) -> Vec<Vec<f32>> {
    if matches!(frame.colour, Colour::Mono { .. }) {
        vec![frame.plane(0, 0)]
    } else {
        display::intensity_rgb(frame).to_vec()
    }
}
