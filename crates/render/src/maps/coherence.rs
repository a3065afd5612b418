//! Maps of coherence: how far apart two points may lie and still see coherent light, and in which direction.
//!
//! The light is that at the first vertex behind the pixel that is not specular; lengths are measured there, in the tangent
//! plane, angles counter-clockwise from the axis that looks like the image's right.

use std::f64::consts::PI;

use super::Map;
use super::colours::{sequential, stripes};
use super::drawing::{Drawing, Item, Picture, Rgb};
use super::ellipses::{HALO, grid};
use super::legend::Legend;
use super::measure::percentile;
use super::numbers::{percent, plain, round_up};
use super::page::Page;
use super::paint::Scene;
use super::report::MapRow;

/// What of the coherence is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The radius of the circle as large as the ellipse.
    Width,
    /// The degree at one separation.
    Degree,
    /// The ellipses over the intensity.
    Ellipses,
}

/// The metadata that tell the separation of the degree of coherence.
pub const SEPARATION: &str = "coherenceSeparation";

/// Ellipses shorter than this share of the longest are drawn so long.
const SHORTEST: f64 = 0.1;

/// A length in the unit that suits it.
fn metres(length: f64) -> String {
    let (unit, factor) = match length {
        l if l < 0.999e-6 => ("nm", 1e9),
        l if l < 0.999e-3 => ("µm", 1e6),
        l if l < 0.999 => ("mm", 1e3),
        _ => ("m", 1.0),
    };
    format!("{} {unit}", plain(length * factor))
}

/// Colours by the logarithm of a length, between two round lengths.
#[derive(Debug, Clone, Copy)]
struct LengthScale {
    low: f64,
    high: f64,
}

impl LengthScale {
    fn of(lengths: Vec<f64>) -> Self {
        let round = |p| percentile(lengths.clone(), p).filter(|l| *l > 0.0);
        let low = round(0.01).map_or(1e-6, |l| round_up(l.recip()).recip());
        let high = round(0.99).map_or(1e-5, round_up);
        Self {
            low,
            high: high.max(2.0 * low),
        }
    }

    fn place(self, length: f64) -> f64 {
        (length / self.low).ln() / (self.high / self.low).ln()
    }

    fn bar(self, title: &str) -> Legend {
        // 1, 2, 5 × 10ⁿ, or the decades alone if those would crowd
        let steps: &[f64] = if self.high / self.low > 200.0 {
            &[1.0]
        } else {
            &[1.0, 2.0, 5.0]
        };
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let ticks = (first..=last)
            .flat_map(|decade| steps.iter().map(move |s| s * 10f64.powi(decade)))
            .map(|length| (self.place(length), metres(length)))
            .filter(|(t, _)| (-1e-6..=1.0 + 1e-6).contains(t))
            .collect();
        Legend::bar(title, sequential, ticks)
    }
}

/// The ellipse of a pixel: semi-axes and angle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ellipse {
    major: f64,
    minor: f64,
    angle: f64,
}

impl Ellipse {
    fn width(self) -> f64 {
        (self.major * self.minor).sqrt()
    }

    /// The ellipse of the mean of the spreads of direction, 1/m².
    fn mean(all: &[Self]) -> Option<Self> {
        let (mut a, mut b, mut d) = (0.0, 0.0, 0.0);
        for e in all {
            let (large, small) = (e.minor.powi(-2), e.major.powi(-2));
            let (sin, cos) = e.angle.sin_cos();
            a += small * cos * cos + large * sin * sin;
            d += small * sin * sin + large * cos * cos;
            b += (small - large) * sin * cos;
        }
        let n = all.len() as f64;
        let (middle, half) = (0.5 * (a + d) / n, (0.5 * (a - d)).hypot(b) / n);
        let angle = 0.5 * (2.0 * b).atan2(a - d) + 0.5 * PI;
        (middle > 0.0).then(|| Self {
            major: (middle - half).max(1e-12 * middle).sqrt().recip(),
            minor: (middle + half).sqrt().recip(),
            angle: angle.rem_euclid(PI),
        })
    }
}

/// The ellipse and the degree of coherence of a pixel that is not masked.
fn at(scene: &Scene<'_>, pixel: usize) -> Option<(Ellipse, f64)> {
    let [major, minor, angle, degree] = scene.coherence.as_ref()?.get(pixel)?.map(f64::from);
    let ellipse = Ellipse {
        major,
        minor,
        angle,
    };
    let sound = minor > 0.0 && major >= minor && angle.is_finite() && degree.is_finite();
    (sound && !scene.measured.masked[pixel]).then_some((ellipse, degree))
}

/// The map's numbers: shape and values; NaN where masked.
pub(super) fn data(scene: &Scene<'_>, kind: Kind) -> (Vec<u64>, Vec<f32>) {
    let m = &scene.measured;
    let value = |pixel| {
        at(scene, pixel).map_or(f64::NAN, |(ellipse, degree)| match kind {
            Kind::Degree => degree,
            _ => ellipse.width(),
        }) as f32
    };
    (
        vec![m.height as u64, m.width as u64],
        (0..m.stokes.len()).map(value).collect(),
    )
}

/// Draws one map; the row lacks only the names of files.
pub(super) fn draw(scene: &Scene<'_>, map: &'static Map, kind: Kind) -> (Drawing, MapRow) {
    let found: Vec<Option<(Ellipse, f64)>> = (0..scene.measured.stokes.len())
        .map(|pixel| at(scene, pixel))
        .collect();
    let scale = LengthScale::of(found.iter().flatten().map(|(e, _)| e.width()).collect());
    let place = |(ellipse, degree): (Ellipse, f64)| match kind {
        Kind::Degree => degree,
        _ => scale.place(ellipse.width()),
    };
    let mut page = Page {
        title: map.title.to_owned(),
        subtitle: scene.subtitle(map),
        legends: Vec::new(),
        notes: Vec::new(),
        scale: 1,
        picture: Picture::from_fn(0, 0, |_, _| [0; 3]),
        overlay: Vec::new(),
    };
    let title = "radius of coherence";
    match kind {
        Kind::Ellipses => {
            page.scale = scene.scale;
            page.picture = scene.tones();
            page.legends.push(scale.bar(title));
            overlay(scene, &found, scale, &mut page);
        }
        Kind::Width => page.legends.push(scale.bar(title)),
        Kind::Degree => {
            let tick = |i: u32| (0.25 * f64::from(i), plain(0.25 * f64::from(i)));
            page.legends.push(Legend::bar(
                "|γ(ξ)|",
                sequential,
                (0..=4).map(tick).collect(),
            ));
            page.notes.push(match &scene.separation {
                Some(separation) => format!("Separation ξ: {separation}."),
                None => "The file does not tell the separation ξ.".to_owned(),
            });
        }
    }
    if kind != Kind::Ellipses {
        let colours: Vec<Option<Rgb>> = found
            .iter()
            .map(|pixel| pixel.map(|p| sequential(place(p))))
            .collect();
        page.picture = enlarged(scene, &colours);
        if found.iter().any(Option::is_none) {
            page.legends
                .push(Legend::Striped("masked: too dark".to_owned()));
        }
    }
    page.notes.push(
        "Of the light where it first meets matter that is not specular, in the tangent plane there; lamps seen directly: of a pixel's cone."
            .to_owned(),
    );
    let (shown, beyond) = found
        .iter()
        .flatten()
        .fold((0_usize, 0_usize), |(n, out), &p| {
            let t = place(p);
            (n + 1, out + usize::from(!(-1e-6..=1.0 + 1e-6).contains(&t)))
        });
    let clipped = beyond as f64 / shown.max(1) as f64;
    if clipped > 0.0 {
        page.notes.push(format!(
            "{} of the pixels lie beyond the scale and have the colours of its ends.",
            percent(clipped)
        ));
    }
    let row = MapRow {
        name: map.name,
        title: map.title,
        formula: map.formula,
        file: String::new(),
        data: None,
        channels: map.channels,
        unit: map.unit,
        limits: Some(match kind {
            Kind::Degree => [0.0, 1.0],
            _ => [scale.low, scale.high],
        }),
        full_brightness: None,
        clipped_share: Some(clipped),
    };
    (page.layout(), row)
}

fn enlarged(scene: &Scene<'_>, colours: &[Option<Rgb>]) -> Picture {
    let (w, h, scale) = (scene.measured.width, scene.measured.height, scene.scale);
    Picture::from_fn(w * scale, h * scale, |x, y| {
        colours[y / scale * w + x / scale].unwrap_or_else(|| stripes(x, y, 5))
    })
}

/// One ellipse per square of pixels, as it lies in the tangent plane.
fn overlay(
    scene: &Scene<'_>,
    found: &[Option<(Ellipse, f64)>],
    scale: LengthScale,
    page: &mut Page,
) {
    let (spacing, squares) = grid(scene);
    let means: Vec<([f64; 2], Ellipse)> = squares
        .into_iter()
        .filter_map(|(centre, pixels)| {
            let all: Vec<Ellipse> = pixels
                .iter()
                .filter_map(|&p| found[p].map(|(e, _)| e))
                .collect();
            (2 * all.len() >= pixels.len())
                .then(|| Ellipse::mean(&all))
                .flatten()
                .map(|mean| (centre, mean))
        })
        .collect();
    let reference =
        percentile(means.iter().map(|(_, e)| e.major).collect(), 0.95).map_or(scale.high, round_up);
    let longest = 0.86 * (spacing * scene.scale) as f64;
    let width = (0.075 * longest).clamp(1.2, 6.0) as f32;
    for (centre, e) in &means {
        let major = 0.5 * longest * (e.major / reference).sqrt().clamp(SHORTEST, 1.0);
        let minor = major * (e.minor / e.major);
        let centre = centre.map(|c| (c * scene.scale as f64) as f32);
        let tint = sequential(scale.place(e.width()));
        for (colour, width) in [(HALO, 2.1 * width), (tint, width)] {
            page.overlay.push(Item::Ellipse {
                centre,
                radii: [major as f32, minor as f32],
                // rows go down, angles count upwards
                angle: -e.angle as f32,
                colour,
                width,
            });
        }
    }
    page.legends.push(Legend::Length(
        (longest * 0.999) as f32,
        format!("semi-major axis {}", metres(reference)),
    ));
    page.legends.push(Legend::Length(
        (longest * 0.5) as f32,
        format!("semi-major axis {}", metres(0.25 * reference)),
    ));
    page.notes.push(format!(
        "One ellipse per {spacing}×{spacing} pixels, of the mean spread of directions, as it lies in the surface; its shape is true, its size grows with the square root of the semi-major axis."
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_two_crossed_ellipses_is_a_circle() {
        let along = Ellipse {
            major: 4.0,
            minor: 1.0,
            angle: 0.3,
        };
        let same = Ellipse::mean(&[along; 3]).unwrap();
        assert!((same.major - 4.0).abs() < 1e-12 && (same.minor - 1.0).abs() < 1e-12);
        assert!((same.angle - 0.3).abs() < 1e-12);
        let across = Ellipse {
            angle: 0.3 + 0.5 * PI,
            ..along
        };
        let round = Ellipse::mean(&[along, across]).unwrap();
        // ½ (1/16 + 1)
        let expected = (0.5f64 * 1.0625).sqrt().recip();
        assert!((round.major - expected).abs() < 1e-7 && (round.minor - expected).abs() < 1e-7);
        // light of one direction spreads nothing
        let coherent = Ellipse {
            major: f64::INFINITY,
            minor: f64::INFINITY,
            angle: 0.0,
        };
        assert_eq!(Ellipse::mean(&[coherent]), None);
    }

    #[test]
    fn lengths_have_their_unit() {
        assert_eq!(metres(550e-9), "550 nm");
        assert_eq!(metres(37.65e-6), "37.6 µm");
        assert_eq!(metres(1e-3), "1 mm");
        let scale = LengthScale::of(vec![3e-6, 40e-6]);
        assert!((scale.low - 2e-6).abs() < 1e-12 && (scale.high - 50e-6).abs() < 1e-12);
        assert!((scale.place(10e-6) - 0.5).abs() < 1e-12);
    }
}
