//! From numbers to pictures: ranges, masks, exposure, and the notes below each map.

use stokes::StokesVector;

use super::colours::{HandednessColours, diverging, handed, hue, kind, sequential, srgb, stripes};
use super::drawing::{Drawing, Picture, Rgb};
use super::legend::Legend;
use super::measure::{Measured, Statistics, percentile};
use super::numbers::{percent, plain, round_up, two_digits};
use super::page::Page;
use super::report::{FRAME, HANDEDNESS, MapReport, MapRow};
use super::{
    FULL, LEAST_DEGREE, Map, MapOptions, Needs, Observable, Range, SEPARATION, Style, coherence,
    ellipses,
};
use crate::image::StokesImage;
use crate::output::{ImageError, display};

/// Pictures smaller than this many pixels are enlarged.
const READABLE: usize = 560;

/// An image ready to be drawn.
pub(super) struct Scene<'a> {
    pub(super) measured: Measured,
    pub(super) statistics: Statistics,
    pub(super) options: &'a MapOptions,
    pub(super) exposure: f64,
    /// How many picture pixels one image pixel is wide.
    pub(super) scale: usize,
    /// As [`StokesImage::coherence`].
    pub(super) coherence: Option<Vec<[f32; 4]>>,
    /// Of the degree of coherence, in words.
    pub(super) separation: Option<String>,
    stem: &'a str,
    intensity: [Vec<f32>; 3],
}

impl<'a> Scene<'a> {
    pub(super) fn new(
        image: &StokesImage,
        options: &'a MapOptions,
        stem: &'a str,
    ) -> Result<Self, ImageError> {
        if options
            .exposure
            .is_some_and(|e| !(e.is_finite() && e > 0.0))
        {
            return Err(ImageError::Request(
                "the exposure is not a positive number; leave --exposure out to let the image choose".to_owned(),
            ));
        }
        if options.ellipse_spacing == Some(0) {
            return Err(ImageError::Request(
                "the distance of ellipses is 0 pixels, expected 1 or more".to_owned(),
            ));
        }
        let measured = Measured::new(image, options.colour, options.threshold)?;
        let intensity = match options.colour {
            super::ColourChoice::Luminance => display::intensity_rgb(image),
            super::ColourChoice::Index(index) => std::array::from_fn(|_| image.plane(0, index)),
        };
        let bright = measured
            .stokes
            .iter()
            .map(StokesVector::s0)
            .filter(|s| *s > 0.0)
            .collect();
        // nineteen twentieths of the picture below four fifths of white: lamps may burn out, the rest is seen
        let white = percentile(bright, 0.95).map_or(1.0, |p| two_digits(p / 0.8));
        let longest = image.width.max(image.height);
        Ok(Self {
            statistics: measured.statistics(),
            exposure: options.exposure.unwrap_or(1.0 / white),
            scale: ((READABLE as f64 / longest as f64).round() as usize).clamp(1, 64),
            measured,
            options,
            coherence: image.coherence.clone(),
            separation: image.metadata.get(SEPARATION).cloned(),
            stem,
            intensity,
        })
    }

    /// The report, without maps.
    pub(super) fn report(&self) -> MapReport {
        MapReport {
            image: self.stem.to_owned(),
            width: self.measured.width,
            height: self.measured.height,
            colour: self.measured.colour.clone(),
            frame: FRAME,
            handedness: HANDEDNESS,
            handedness_colours: self.options.handedness_colours.name(),
            threshold: self.measured.threshold,
            exposure: self.exposure,
            statistics: self.statistics,
            maps: Vec::new(),
            files: Vec::new(),
        }
    }

    /// Draws one map; the row lacks only the names of files.
    pub(super) fn draw(&self, map: &'static Map) -> (Drawing, MapRow) {
        if let Style::Coherence(kind) = map.style {
            return coherence::draw(self, map, kind);
        }
        let limits = self.limits(map);
        let clipped = limits
            .filter(|_| map.range != Range::Tone)
            .map(|limits| self.clipped(map, limits));
        let mut page = Page {
            title: map.title.to_owned(),
            subtitle: self.subtitle(map),
            legends: self.legends(map, limits),
            notes: self.notes(map, clipped),
            scale: 1,
            picture: self.picture(map, limits),
            overlay: Vec::new(),
        };
        if map.style == Style::Ellipses {
            let overlay = ellipses::overlay(self);
            (page.scale, page.overlay) = (self.scale, overlay.items);
            page.legends = overlay.legends;
            page.notes.insert(0, overlay.note);
        }
        let row = MapRow {
            name: map.name,
            title: map.title,
            formula: map.formula,
            file: String::new(),
            data: None,
            channels: map.channels,
            unit: map.unit,
            limits: limits.map(|(low, high)| [low, high]),
            full_brightness: self.full_brightness(map),
            clipped_share: clipped,
        };
        (page.layout(), row)
    }

    /// The map's numbers: shape and values; NaN where masked.
    pub(super) fn data(&self, map: &Map) -> (Vec<u64>, Vec<f32>) {
        if let Style::Coherence(kind) = map.style {
            return coherence::data(self, kind);
        }
        let m = &self.measured;
        let mut shape = vec![m.height as u64, m.width as u64];
        if map.planes.len() > 1 {
            shape.push(map.planes.len() as u64);
        }
        let numbers = |pixel: usize| {
            let shown = self.shown(map, pixel);
            map.planes.iter().map(move |plane| {
                if shown {
                    plane(&m.stokes[pixel]) as f32
                } else {
                    f32::NAN
                }
            })
        };
        (shape, (0..m.stokes.len()).flat_map(numbers).collect())
    }

    /// Whether the map has a meaning at a pixel.
    fn shown(&self, map: &Map, pixel: usize) -> bool {
        let m = &self.measured;
        let s = &m.stokes[pixel];
        let above = |part: f64, components| {
            part >= LEAST_DEGREE * s.s0() && part >= 2.0 * m.noise(pixel, components)
        };
        map.style == Style::Tone
            || !m.masked[pixel]
                && match map.needs {
                    None => true,
                    Some(Needs::LinearPart) => above(s.linear_intensity(), 1..3),
                    Some(Needs::PolarizedPart) => above(s.polarized_intensity(), 1..4),
                }
    }

    fn limits(&self, map: &Map) -> Option<(f64, f64)> {
        Some(match map.range {
            Range::Tone if map.style == Style::Ellipses => return None,
            Range::Tone => (0.0, 1.0 / self.exposure),
            Range::Fixed(low, high) => (low, high),
            Range::Degree => (0.0, self.widest(map.planes[0])),
            Range::Symmetric => {
                let wide = self.widest(map.planes[0]);
                (-wide, wide)
            }
        })
    }

    /// A round number that all but a few pixels stay below, at most 1.
    fn widest(&self, observable: Observable) -> f64 {
        if self.options.full_range {
            return 1.0;
        }
        let sizes = self
            .measured
            .bright()
            .map(|(_, s)| observable(s).abs())
            .collect();
        round_up(percentile(sizes, 0.995).unwrap_or(0.0)).clamp(0.01, 1.0)
    }

    /// The degree that is shown at full brightness, for maps that show one so.
    fn full_brightness(&self, map: &Map) -> Option<f64> {
        map.planes.get(1).map(|&degree| self.widest(degree))
    }

    fn clipped(&self, map: &Map, (low, high): (f64, f64)) -> f64 {
        let beyond = |s: &StokesVector| {
            let v = map.planes[0](s).abs();
            v > high.max(-low) * (1.0 + 1e-5)
        };
        let (mut n, mut out) = (0_usize, 0_usize);
        for (_, s) in self.measured.bright() {
            n += 1;
            out += usize::from(beyond(s));
        }
        out as f64 / n.max(1) as f64
    }

    fn picture(&self, map: &Map, limits: Option<(f64, f64)>) -> Picture {
        let (w, h) = (self.measured.width, self.measured.height);
        if map.style == Style::Ellipses {
            return self.tones();
        }
        let (low, high) = limits.unwrap_or((0.0, 1.0));
        let full = self.full_brightness(map).unwrap_or(1.0);
        let colour = |pixel: usize| {
            self.shown(map, pixel).then(|| {
                let s = &self.measured.stokes[pixel];
                let weight = map.planes.get(1).map_or(1.0, |degree| degree(s) / full);
                match map.style {
                    Style::Tone | Style::Ellipses | Style::Coherence(_) => self.tone(pixel),
                    _ => styled(
                        map.style,
                        map.planes[0](s),
                        (low, high),
                        weight,
                        self.options.handedness_colours,
                    ),
                }
            })
        };
        let colours: Vec<Option<Rgb>> = (0..w * h).map(colour).collect();
        let scale = self.scale;
        Picture::from_fn(w * scale, h * scale, |x, y| {
            colours[y / scale * w + x / scale].unwrap_or_else(|| stripes(x, y, 5))
        })
    }

    /// The tone-mapped intensity.
    pub(super) fn tones(&self) -> Picture {
        let (w, h) = (self.measured.width, self.measured.height);
        Picture::from_fn(w, h, |x, y| self.tone(y * w + x))
    }

    /// The tone-mapped intensity of a pixel.
    fn tone(&self, pixel: usize) -> Rgb {
        std::array::from_fn(|i| srgb(f64::from(self.intensity[i][pixel]) * self.exposure))
    }

    fn legends(&self, map: &Map, limits: Option<(f64, f64)>) -> Vec<Legend> {
        let (low, high) = limits.unwrap_or((0.0, 1.0));
        let hands = self.options.handedness_colours;
        let degrees = map.unit == "rad";
        let full = plain(self.full_brightness(map).unwrap_or(1.0));
        let bar = |title: &str| {
            let colour =
                |t: f64| styled(map.style, low + t * (high - low), (low, high), 1.0, hands);
            let steps = if map.style == Style::Tone { 2 } else { 4 };
            let tick = |i: usize| {
                let t = i as f64 / steps as f64;
                let value = low + t * (high - low);
                (
                    t,
                    if degrees {
                        format!("{}°", plain(value.to_degrees()))
                    } else {
                        plain(value)
                    },
                )
            };
            Legend::bar(title, colour, (0..=steps).map(tick).collect())
        };
        let mut out = match map.style {
            Style::Tone => vec![bar("S0")],
            Style::Sequential => vec![bar(map.formula.split(' ').next().unwrap_or(""))],
            Style::Diverging => vec![bar(map.formula.split(',').next().unwrap_or(""))],
            Style::Handed => vec![
                bar(if degrees { "χ" } else { "DoCP" }),
                Legend::Swatch(hands.right(), "right-handed ↻ (S3 > 0)".to_owned()),
                Legend::Swatch(hands.left(), "left-handed ↺ (S3 < 0)".to_owned()),
            ],
            Style::Hue => vec![Legend::wheel("AoLP", |angle, _| hue(angle, 1.0), None)],
            Style::WeightedHue => vec![Legend::wheel("AoLP × DoLP", hue, Some(full))],
            Style::Kind => vec![Legend::patch("|χ| and DoP", kind, full)],
            Style::Ellipses | Style::Coherence(_) => Vec::new(),
        };
        if (0..self.measured.stokes.len()).any(|pixel| !self.shown(map, pixel)) {
            let what = match map.needs {
                None => "masked: too dark",
                Some(_) => "masked: too dark or unpolarized",
            };
            out.push(Legend::Striped(what.to_owned()));
        }
        out
    }

    pub(super) fn subtitle(&self, map: &Map) -> String {
        let m = &self.measured;
        let colour = if m.colour.is_empty() {
            String::new()
        } else {
            format!(", {}", m.colour)
        };
        let enlarged = if self.scale > 1 {
            format!(", shown ×{}", self.scale)
        } else {
            String::new()
        };
        format!(
            "{}  ·  {}  ·  {}×{} px{colour}{enlarged}",
            map.formula, self.stem, m.width, m.height
        )
    }

    fn notes(&self, map: &Map, clipped: Option<f64>) -> Vec<String> {
        let st = &self.statistics;
        let mut out = Vec::new();
        if matches!(map.style, Style::Tone | Style::Ellipses) {
            out.push(format!(
                "Exposure: white is S0 = {}; sRGB tone curve.",
                plain(1.0 / self.exposure)
            ));
        }
        if map.style == Style::Tone {
            return out;
        }
        let mut mask = format!(
            "Mask: S0 < {} ({} of the mean): {} of the pixels.",
            plain(self.measured.threshold),
            plain(self.options.threshold),
            percent(st.masked_share)
        );
        if let Some(needs) = map.needs {
            let part = if needs == Needs::LinearPart {
                "DoLP"
            } else {
                "DoP"
            };
            let noise = if self.measured.errors.is_some() {
                " or twice its noise"
            } else {
                ""
            };
            mask += &format!(" Angles need {part} ≥ {LEAST_DEGREE}{noise}.");
        }
        out.push(mask);
        if let Some(share) = clipped.filter(|share| *share > 0.0) {
            out.push(format!(
                "{} of the pixels lie beyond the scale and have the colours of its ends.",
                percent(share)
            ));
        }
        if matches!(map.name, "dop" | "dolp" | "type" | "ellipses" | "aolp-dolp") {
            let above = format!(
                "DoP > 1: {} of the pixels, greatest {}.",
                percent(st.dop_above_one_share),
                plain(st.greatest_dop)
            );
            out.push(format!("{above} {}", bias(st.dop_of_noise)));
        }
        match map.style {
            Style::Hue | Style::WeightedHue => out.push("Angles counter-clockwise from the image's right, as seen in the image.".to_owned()),
            Style::Handed | Style::Ellipses => out.push(format!(
                "Right-handed: clockwise as seen in the image, by an observer who faces the source. Colours as {}.",
                self.options.handedness_colours.name()
            )),
            _ => {}
        }
        out
    }
}

fn bias(noise: Option<f64>) -> String {
    match noise {
        Some(noise) if noise < 1e-4 => "Noise adds less than 0.0001 to DoP (median).".to_owned(),
        Some(noise) => format!(
            "Noise biases DoP upwards: unpolarized light would read about {} here (median).",
            plain(noise)
        ),
        None => "Noise biases DoP upwards; the file has no variances that would say by how much."
            .to_owned(),
    }
}

/// The colour of a number in a style.
fn styled(
    style: Style,
    value: f64,
    (low, high): (f64, f64),
    weight: f64,
    hands: HandednessColours,
) -> Rgb {
    let t = (value - low) / (high - low);
    match style {
        Style::Tone | Style::Ellipses | Style::Coherence(_) => [srgb(t); 3],
        Style::Sequential => sequential(t),
        Style::Diverging => diverging(t),
        Style::Handed => handed(t, hands),
        Style::Hue => hue(value, 1.0),
        Style::WeightedHue => hue(value, weight),
        Style::Kind => kind(value.abs() / FULL, weight),
    }
}
