//! Legends: what a picture's colours and lengths mean.

use std::f64::consts::PI;

use super::colours::stripes;
use super::drawing::{Anchor, GREY, INK, Item, Picture, Rgb, text_width, wrapped};

/// What explains the colours; stacked from the top of the right column.
pub(super) enum Legend {
    /// A colour bar, its ticks at 0 (below) to 1 (above).
    Bar {
        title: String,
        colours: Vec<Rgb>,
        ticks: Vec<(f64, String)>,
    },
    /// A wheel of angles.
    Wheel {
        title: String,
        disc: Box<dyn Fn(f64, f64) -> Rgb>,
        rim: Option<String>,
    },
    /// |χ| upwards against DoP to the right.
    Patch {
        title: String,
        picture: Picture,
        full: String,
    },
    /// A filled square and what it means.
    Swatch(Rgb, String),
    /// A line of that colour in a dark box, and what it means.
    Stroke(Rgb, String),
    /// A length in pixels and what it means.
    Length(f32, String),
    /// The stripes of masked pixels.
    Striped(String),
}

const BAR_STEPS: usize = 256;

impl Legend {
    pub(super) fn bar(title: &str, colour: impl Fn(f64) -> Rgb, ticks: Vec<(f64, String)>) -> Self {
        Self::Bar {
            title: title.to_owned(),
            colours: (0..BAR_STEPS)
                .map(|i| colour((i as f64 + 0.5) / BAR_STEPS as f64))
                .collect(),
            ticks,
        }
    }

    /// `disc` gives the colour of an angle in radians and a weight of 0 to 1.
    pub(super) fn wheel(
        title: &str,
        disc: impl Fn(f64, f64) -> Rgb + 'static,
        rim: Option<String>,
    ) -> Self {
        Self::Wheel {
            title: title.to_owned(),
            disc: Box::new(disc),
            rim,
        }
    }

    /// `colour` takes |χ|/45° and DoP in units of `full`.
    pub(super) fn patch(title: &str, colour: impl Fn(f64, f64) -> Rgb, full: String) -> Self {
        const N: usize = 100;
        let at = |i: usize| (i as f64 + 0.5) / N as f64;
        Self::Patch {
            full,
            title: title.to_owned(),
            picture: Picture::from_fn(N, N, |x, y| colour(1.0 - at(y), at(x))),
        }
    }
}

/// Width of the right column in units.
pub(super) const COLUMN: f32 = 186.0;

/// Where the next thing goes, and how large a unit is: 1 for pictures of a screen, more for larger ones.
pub(super) struct Pen {
    pub(super) items: Vec<Item>,
    pub(super) unit: f32,
}

impl Pen {
    pub(super) fn text(
        &mut self,
        x: f32,
        y: f32,
        size: f32,
        colour: Rgb,
        anchor: Anchor,
        text: &str,
    ) {
        let size = size * self.unit;
        self.items.push(Item::Text {
            x,
            y,
            size,
            colour,
            anchor,
            text: text.to_owned(),
        });
    }
}

impl Pen {
    /// Draws a legend with its upper left corner at (x, y); returns where the next one starts.
    pub(super) fn legend(&mut self, legend: &Legend, x: f32, y: f32, height: f32) -> f32 {
        let u = self.unit;
        match legend {
            Legend::Bar {
                title,
                colours,
                ticks,
            } => {
                self.text(x, y + 12.0 * u, 14.0, INK, Anchor::Start, title);
                let (top, width) = ((y + 26.0 * u).round(), (22.0 * u).round());
                let long = (height - 110.0 * u).clamp(170.0 * u, 330.0 * u).round();
                let rows = long as usize;
                let colour = |_, row: usize| colours[(rows - 1 - row) * colours.len() / rows];
                self.items.push(Item::Image {
                    x,
                    y: top,
                    scale: 1,
                    picture: Picture::from_fn(width as usize, rows, colour),
                });
                self.items.push(Item::Rectangle {
                    x: x - 0.5,
                    y: top - 0.5,
                    w: width + 1.0,
                    h: long + 1.0,
                    colour: GREY,
                    line: Some(1.0),
                });
                for (t, label) in ticks {
                    let at = top + long * (1.0 - *t as f32);
                    self.items.push(Item::Line {
                        from: [x + width, at],
                        to: [x + width + 5.0 * u, at],
                        colour: GREY,
                        width: u,
                    });
                    self.text(
                        x + width + 10.0 * u,
                        at + 4.5 * u,
                        13.0,
                        INK,
                        Anchor::Start,
                        label,
                    );
                }
                top + long + 22.0 * u
            }
            Legend::Wheel { title, disc, rim } => self.wheel(title, disc, rim.as_deref(), x, y),
            Legend::Patch {
                title,
                picture,
                full,
            } => self.patch(title, picture, full, x, y),
            Legend::Swatch(colour, text) => {
                let side = 16.0 * u;
                self.items.push(Item::Rectangle {
                    x,
                    y,
                    w: side,
                    h: side,
                    colour: *colour,
                    line: None,
                });
                self.caption(text, x + 24.0 * u, y + 12.5 * u)
            }
            Legend::Stroke(colour, text) => {
                let side = 16.0 * u;
                self.items.push(Item::Rectangle {
                    x,
                    y,
                    w: side,
                    h: side,
                    colour: [70, 73, 80],
                    line: None,
                });
                let line = Item::Line {
                    from: [x + 3.0 * u, y + 13.0 * u],
                    to: [x + 13.0 * u, y + 3.0 * u],
                    colour: *colour,
                    width: 2.4 * u,
                };
                self.items.push(line);
                self.caption(text, x + 24.0 * u, y + 12.5 * u)
            }
            Legend::Length(length, text) => {
                let at = y + 8.0 * u;
                let ends = [x + u, x + u + length];
                self.items.push(Item::Line {
                    from: [ends[0], at],
                    to: [ends[1], at],
                    colour: INK,
                    width: 1.8 * u,
                });
                for end in ends {
                    self.items.push(Item::Line {
                        from: [end, at - 4.0 * u],
                        to: [end, at + 4.0 * u],
                        colour: INK,
                        width: 1.2 * u,
                    });
                }
                self.caption(text, x + length.max(16.0 * u) + 10.0 * u, y + 12.5 * u)
            }
            Legend::Striped(text) => {
                let side = (16.0 * u) as usize;
                let period = (5.0 * u) as usize;
                self.items.push(Item::Image {
                    x,
                    y,
                    scale: 1,
                    picture: Picture::from_fn(side, side, |x, y| stripes(x, y, period)),
                });
                self.caption(text, x + 24.0 * u, y + 12.5 * u)
            }
        }
    }

    /// Small text beside a swatch; returns where the next legend starts.
    fn caption(&mut self, text: &str, x: f32, y: f32) -> f32 {
        let u = self.unit;
        let mut at = y;
        for (i, line) in wrapped(text, 12.0 * u, (COLUMN - 24.0) * u)
            .iter()
            .enumerate()
        {
            at = y + i as f32 * 15.0 * u;
            self.text(x, at, 12.0, INK, Anchor::Start, line);
        }
        at + 14.0 * u
    }

    fn wheel(
        &mut self,
        title: &str,
        disc: &dyn Fn(f64, f64) -> Rgb,
        rim: Option<&str>,
        x: f32,
        y: f32,
    ) -> f32 {
        let u = self.unit;
        self.text(x, y + 12.0 * u, 14.0, INK, Anchor::Start, title);
        let outer = 44.0 * u;
        let inner = if rim.is_some() { 0.0 } else { 0.5 * outer };
        // room for a label on the left
        let (cx, cy) = (
            (x + 34.0 * u + outer).round(),
            (y + 48.0 * u + outer).round(),
        );
        let side = 2 * outer.round() as usize;
        let polar = |px: f64, py: f64| (px.hypot(-py), (-py).atan2(px));
        let sample = |px: usize, py: usize| {
            let mut sum = [0.0; 3];
            // 4×4 points per pixel: smooth rims
            for i in 0..16 {
                let at = |p: usize, i: usize| p as f64 + (i as f64 + 0.5) / 4.0 - side as f64 / 2.0;
                let (r, angle) = polar(at(px, i % 4), at(py, i / 4));
                let inside = r <= f64::from(outer) && r >= f64::from(inner);
                let colour = if inside {
                    disc(angle.rem_euclid(PI), r / f64::from(outer))
                } else {
                    [255; 3]
                };
                (0..3).for_each(|c| sum[c] += f64::from(colour[c]) / 16.0);
            }
            sum.map(|c| c.round() as u8)
        };
        let corner = side as f32 / 2.0;
        self.items.push(Item::Image {
            x: cx - corner,
            y: cy - corner,
            scale: 1,
            picture: Picture::from_fn(side, side, sample),
        });
        let labels = [
            (0.0_f32, "0°"),
            (45.0, "45°"),
            (90.0, "90°"),
            (135.0, "135°"),
            (180.0, "180°"),
        ];
        for (degrees, label) in labels {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let point = |r: f32| [cx + r * cos, cy - r * sin];
            self.items.push(Item::Line {
                from: point(outer),
                to: point(outer + 5.0 * u),
                colour: GREY,
                width: u,
            });
            let anchor = if cos > 0.3 {
                Anchor::Start
            } else if cos < -0.3 {
                Anchor::End
            } else {
                Anchor::Middle
            };
            let [tx, ty] = point(outer + 8.0 * u);
            self.text(
                tx,
                ty + if sin > 0.9 { -u } else { 4.0 * u },
                12.5,
                INK,
                anchor,
                label,
            );
        }
        let mut at = cy + outer + 20.0 * u;
        let meaning = rim.map_or_else(
            || "the colour in a direction is that of light that vibrates along it".to_owned(),
            |rim| format!("direction: AoLP; centre: DoLP 0, rim: DoLP {rim}"),
        );
        for line in wrapped(&meaning, 12.0 * u, COLUMN * u) {
            self.text(x, at, 12.0, GREY, Anchor::Start, &line);
            at += 15.0 * u;
        }
        at + 8.0 * u
    }

    fn patch(&mut self, title: &str, picture: &Picture, full: &str, x: f32, y: f32) -> f32 {
        let u = self.unit;
        self.text(x, y + 12.0 * u, 14.0, INK, Anchor::Start, title);
        let left = (x + text_width("45°", 12.5 * u) + 10.0 * u).round();
        let top = (y + 28.0 * u).round();
        let side = (104.0 * u).round() as usize;
        let enlarged = Picture::from_fn(side, side, |px, py| {
            picture.pixels[py * picture.height / side * picture.width + px * picture.width / side]
        });
        let side = side as f32;
        self.items.push(Item::Image {
            x: left,
            y: top,
            scale: 1,
            picture: enlarged,
        });
        for (t, label) in [(0.0, "0°"), (0.5, "22.5°"), (1.0, "45°")] {
            let at = top + side * (1.0 - t);
            self.items.push(Item::Line {
                from: [left - 4.0 * u, at],
                to: [left, at],
                colour: GREY,
                width: u,
            });
            // the middle label is wider than the margin
            if t != 0.5 {
                self.text(left - 7.0 * u, at + 4.5 * u, 12.5, INK, Anchor::End, label);
            }
        }
        for (t, label) in [(0.0, "0"), (0.5, "DoP"), (1.0, full)] {
            self.text(
                left + side * t,
                top + side + 16.0 * u,
                12.5,
                INK,
                Anchor::Middle,
                label,
            );
        }
        let mut at = top + side + 38.0 * u;
        for line in ["above: circular", "below: linear"] {
            self.text(x, at, 12.0, GREY, Anchor::Start, line);
            at += 15.0 * u;
        }
        at + 8.0 * u
    }
}
