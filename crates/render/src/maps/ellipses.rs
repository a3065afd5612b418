//! The grid of polarization ellipses: one per square of pixels, the mean state of its light.
//!
//! An ellipse's size is proportional to the square's degree of polarization, its axes stand as the field's do, and its colour
//! tells the sense of rotation. Nearly linear light is a line.

use stokes::StokesVector;

use super::drawing::{Item, Rgb};
use super::legend::Legend;
use super::measure::percentile;
use super::numbers::{percent, plain, round_up};
use super::paint::Scene;

/// What lies over the intensity, and what explains it.
pub(super) struct Overlay {
    pub(super) items: Vec<Item>,
    pub(super) legends: Vec<Legend>,
    pub(super) note: String,
}

/// Ellipses flatter than this (minor over major axis) are lines: χ below 2°.
const FLAT: f64 = 0.035;
/// Ellipses of full size have at least this degree: noise is not blown up.
const LEAST_FULL_SIZE: f64 = 0.02;
/// Distance of ellipses in picture pixels where none is asked for.
const COMFORTABLE: f64 = 30.0;
const LINEAR: Rgb = [255, 255, 255];
pub(super) const HALO: Rgb = [12, 14, 20];

/// The ellipses of an image, in pixels from the picture's corner.
pub(super) fn overlay(scene: &Scene<'_>) -> Overlay {
    let (spacing, grid) = grid(scene);
    let squares = squares(scene, grid);
    let degrees = squares
        .iter()
        .map(|(_, s)| s.degree_of_polarization())
        .collect();
    let reference = round_up(percentile(degrees, 0.98).unwrap_or(1.0)).clamp(LEAST_FULL_SIZE, 1.0);
    let longest = 0.82 * (spacing * scene.scale) as f64;
    let pen = Pen {
        longest,
        reference,
        width: (0.075 * longest).clamp(1.2, 6.0) as f32,
        right: scene.options.handedness_colours.right(),
        left: scene.options.handedness_colours.left(),
    };
    let mut items = Vec::new();
    let mut drawn = 0;
    for (centre, s) in &squares {
        let scaled = centre.map(|c| (c * scene.scale as f64) as f32);
        drawn += usize::from(pen.draw(&mut items, scaled, s));
    }
    Overlay {
        items,
        legends: vec![
            Legend::Length(
                (longest * 0.999) as f32,
                format!("major axis at DoP {}", plain(reference)),
            ),
            Legend::Stroke(LINEAR, "linear (|χ| < 2°)".to_owned()),
            Legend::Stroke(pen.right, "right-handed ↻ (S3 > 0)".to_owned()),
            Legend::Stroke(pen.left, "left-handed ↺ (S3 < 0)".to_owned()),
        ],
        note: format!(
            "One ellipse per {spacing}×{spacing} pixels, of their mean Stokes vector; axes grow with DoP; {} of the squares with light are too little polarized to show.",
            percent(1.0 - drawn as f64 / squares.len().max(1) as f64)
        ),
    }
}

/// A square of pixels: its centre, and the indices of the pixels.
type Square = ([f64; 2], Vec<usize>);

/// The squares that have an ellipse each, and the length of their sides.
pub(super) fn grid(scene: &Scene<'_>) -> (usize, Vec<Square>) {
    let m = &scene.measured;
    // large pictures have larger ellipses, so that they survive being shown small
    let page = (m.width.max(m.height) * scene.scale) as f64;
    let comfortable = COMFORTABLE * (page / 800.0).max(1.0).sqrt();
    let spacing = scene
        .options
        .ellipse_spacing
        .unwrap_or(((comfortable / scene.scale as f64).round() as usize).max(1));
    // the grid is centred: what is left over is shared by both rims
    let first = |n: usize| if n >= spacing { n % spacing / 2 } else { 0 };
    let count = |n: usize| (n / spacing).max(1);
    let mut out = Vec::new();
    for j in 0..count(m.height) {
        for i in 0..count(m.width) {
            let (x0, y0) = (first(m.width) + i * spacing, first(m.height) + j * spacing);
            let (x1, y1) = ((x0 + spacing).min(m.width), (y0 + spacing).min(m.height));
            let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * m.width + x));
            let centre = [(x0 + x1) as f64 / 2.0, (y0 + y1) as f64 / 2.0];
            out.push((centre, pixels.collect()));
        }
    }
    (spacing, out)
}

/// Centres in image pixels and mean Stokes vectors of the squares that are not mostly masked.
fn squares(scene: &Scene<'_>, grid: Vec<Square>) -> Vec<([f64; 2], StokesVector)> {
    let m = &scene.measured;
    let mean = |(centre, pixels): Square| {
        let bright: Vec<usize> = pixels.iter().copied().filter(|&p| !m.masked[p]).collect();
        (2 * bright.len() >= pixels.len()).then(|| {
            let sum = bright
                .iter()
                .fold(StokesVector::DARK, |sum, &p| sum + m.stokes[p]);
            (centre, sum)
        })
    };
    grid.into_iter().filter_map(mean).collect()
}

struct Pen {
    longest: f64,
    reference: f64,
    width: f32,
    right: Rgb,
    left: Rgb,
}

impl Pen {
    /// Draws one state; false where it would be too small to see.
    fn draw(&self, items: &mut Vec<Item>, centre: [f32; 2], s: &StokesVector) -> bool {
        let ellipse = s.ellipse();
        let major = (s.degree_of_polarization() / self.reference).min(1.0) * self.longest / 2.0;
        if major < f64::from(self.width) {
            return false;
        }
        let flatness = if ellipse.semi_major > 0.0 {
            ellipse.semi_minor / ellipse.semi_major
        } else {
            0.0
        };
        // rows go down, angles count upwards
        // the axes of a circle are noise: a fixed direction keeps the arrows in line
        let angle = if flatness > 0.95 {
            0.0
        } else {
            -ellipse.orientation
        };
        let (sin, cos) = angle.sin_cos();
        let along = |t: f64| [centre[0] + (t * cos) as f32, centre[1] + (t * sin) as f32];
        let colour = if flatness < FLAT {
            LINEAR
        } else if s.s3() > 0.0 {
            self.right
        } else {
            self.left
        };
        for (colour, width) in [(HALO, 2.1 * self.width), (colour, self.width)] {
            items.push(if flatness < FLAT {
                Item::Line {
                    from: along(-major),
                    to: along(major),
                    colour,
                    width,
                }
            } else {
                let radii = [major as f32, (major * flatness) as f32];
                Item::Ellipse {
                    centre,
                    radii,
                    angle: angle as f32,
                    colour,
                    width,
                }
            });
        }
        if flatness * major > 3.5 * f64::from(self.width) {
            items.push(self.arrow(along(major), angle, s.s3() > 0.0, colour));
        }
        true
    }

    /// An arrowhead at the end of the major axis that points the way the field's tip goes.
    fn arrow(&self, at: [f32; 2], angle: f64, clockwise: bool, colour: Rgb) -> Item {
        let (sin, cos) = angle.sin_cos();
        // clockwise on the page, with y downwards, is the direction of growing angle
        let way = if clockwise { 1.0 } else { -1.0 };
        let size = 2.0 * f64::from(self.width);
        let point = |forward: f64, out: f64| {
            let (x, y) = (
                way * forward * -sin + out * cos,
                way * forward * cos + out * sin,
            );
            [at[0] + (size * x) as f32, at[1] + (size * y) as f32]
        };
        Item::Polygon {
            points: vec![point(1.0, 0.0), point(-0.6, 0.9), point(-0.6, -0.9)],
            colour,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEN: Pen = Pen {
        longest: 40.0,
        reference: 1.0,
        width: 2.0,
        right: [0, 0, 255],
        left: [255, 255, 0],
    };

    #[test]
    fn diagonal_light_is_a_line_to_the_upper_right() {
        let mut items = Vec::new();
        assert!(PEN.draw(&mut items, [100.0, 100.0], &StokesVector::DIAGONAL));
        let Item::Line {
            from, to, colour, ..
        } = &items[1]
        else {
            panic!("a line")
        };
        assert_eq!(*colour, LINEAR);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        assert!(
            dx * dy < 0.0 && (dx.abs() - dy.abs()).abs() < 1e-3,
            "rows go down: {dx} {dy}"
        );
        assert!((dx.hypot(dy) - 40.0).abs() < 1e-3);
    }

    #[test]
    fn right_circular_light_turns_clockwise_on_the_page() {
        let mut items = Vec::new();
        assert!(PEN.draw(&mut items, [0.0, 0.0], &StokesVector::RIGHT_CIRCULAR));
        let Item::Ellipse { radii, colour, .. } = &items[1] else {
            panic!("an ellipse")
        };
        assert_eq!((radii[0], radii[1], *colour), (20.0, 20.0, PEN.right));
        let Item::Polygon { points, .. } = &items[2] else {
            panic!("an arrow")
        };
        // at the right end, clockwise is downwards: y grows
        assert!(points[0][1] > 0.0);
        let mut items = Vec::new();
        assert!(PEN.draw(&mut items, [0.0, 0.0], &StokesVector::LEFT_CIRCULAR));
        let Item::Polygon { points, colour } = &items[2] else {
            panic!("an arrow")
        };
        assert!(points[0][1] < 0.0 && *colour == PEN.left);
    }

    #[test]
    fn unpolarized_light_has_no_ellipse() {
        let mut items = Vec::new();
        assert!(!PEN.draw(&mut items, [0.0, 0.0], &StokesVector::UNPOLARIZED));
        assert!(!PEN.draw(&mut items, [0.0, 0.0], &StokesVector::DARK));
        assert!(items.is_empty());
    }
}
