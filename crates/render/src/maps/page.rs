//! A page: title on top, picture on the left, legends on the right, notes below.

use super::drawing::{Anchor, Drawing, GREY, INK, Item, Picture, shortened, wrapped};
use super::legend::{COLUMN, Legend, Pen};

/// Everything on a page.
pub(super) struct Page {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) picture: Picture,
    /// Page pixels per picture pixel.
    pub(super) scale: usize,
    /// Shapes over the picture, relative to its corner.
    pub(super) overlay: Vec<Item>,
    pub(super) legends: Vec<Legend>,
    pub(super) notes: Vec<String>,
}

impl Page {
    /// Places everything.
    pub(super) fn layout(self) -> Drawing {
        let (w, h) = (
            self.picture.width * self.scale,
            self.picture.height * self.scale,
        );
        let unit = (w.max(h) as f32 / 800.0).clamp(1.0, 6.0);
        let margin = 26.0 * unit;
        // narrow pictures still leave room for the title
        let area = (w as f32).max(380.0 * unit);
        let width = margin + area + 28.0 * unit + COLUMN * unit + margin * 0.5;
        let text_room = width - 2.0 * margin;
        let mut pen = Pen {
            items: Vec::new(),
            unit,
        };
        let mut y = margin + 15.0 * unit;
        pen.text(
            margin,
            y,
            21.0,
            INK,
            Anchor::Start,
            &shortened(&self.title, 21.0 * unit, text_room),
        );
        for line in wrapped(&self.subtitle, 12.5 * unit, text_room) {
            y += 19.0 * unit;
            pen.text(
                margin,
                y,
                12.5,
                GREY,
                Anchor::Start,
                &shortened(&line, 12.5 * unit, text_room),
            );
        }
        let top = (y + 16.0 * unit).round();
        let left = (margin + 0.5 * (area - w as f32)).round();
        pen.items.push(Item::Image {
            x: left,
            y: top,
            scale: self.scale,
            picture: self.picture,
        });
        pen.items
            .extend(self.overlay.into_iter().map(|item| moved(item, left, top)));
        let frame = (left - 0.5, top - 0.5, w as f32 + 1.0, h as f32 + 1.0);
        pen.items.push(Item::Rectangle {
            x: frame.0,
            y: frame.1,
            w: frame.2,
            h: frame.3,
            colour: GREY,
            line: Some(1.0),
        });
        let column = margin + area + 28.0 * unit;
        let mut below = top;
        for legend in &self.legends {
            below = pen.legend(legend, column, below, h as f32);
        }
        let mut y = (top + h as f32).max(below) + 8.0 * unit;
        for note in &self.notes {
            for line in wrapped(note, 12.0 * unit, text_room) {
                y += 16.5 * unit;
                pen.text(margin, y, 12.0, GREY, Anchor::Start, &line);
            }
        }
        Drawing {
            width: width.ceil() as usize,
            height: (y + 0.8 * margin).ceil() as usize,
            items: pen.items,
        }
    }
}

/// A shape of the overlay, moved to the picture's corner.
fn moved(item: Item, dx: f32, dy: f32) -> Item {
    let shift = |[x, y]: [f32; 2]| [x + dx, y + dy];
    match item {
        Item::Line {
            from,
            to,
            colour,
            width,
        } => Item::Line {
            from: shift(from),
            to: shift(to),
            colour,
            width,
        },
        Item::Ellipse {
            centre,
            radii,
            angle,
            colour,
            width,
        } => Item::Ellipse {
            centre: shift(centre),
            radii,
            angle,
            colour,
            width,
        },
        Item::Polygon { points, colour } => Item::Polygon {
            points: points.into_iter().map(shift).collect(),
            colour,
        },
        other => other,
    }
}
