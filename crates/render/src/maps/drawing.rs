//! A drawing as a list of shapes, which `raster.rs` turns into pixels and `svg.rs` into text.

use ab_glyph::{Font, FontRef, ScaleFont};

/// Red, green, blue, sRGB.
pub(super) type Rgb = [u8; 3];

/// Text and lines.
pub(super) const INK: Rgb = [24, 26, 30];
/// Secondary text.
pub(super) const GREY: Rgb = [88, 93, 102];
/// Page.
pub(super) const PAPER: Rgb = [255, 255, 255];

/// A bitmap: rows from the top.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<Rgb>,
}

impl Picture {
    /// A picture whose pixel (x, y) is `f(x, y)`.
    pub(super) fn from_fn(width: usize, height: usize, f: impl Fn(usize, usize) -> Rgb) -> Self {
        let pixels = (0..width * height)
            .map(|i| f(i % width, i / width))
            .collect();
        Self {
            width,
            height,
            pixels,
        }
    }
}

/// Which point of a text its position names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// One shape; lengths in pixels, y downwards.
#[derive(Debug, Clone)]
pub(super) enum Item {
    /// A bitmap with its upper left corner at (x, y), each pixel `scale` wide.
    Image {
        x: f32,
        y: f32,
        scale: usize,
        picture: Picture,
    },
    /// A rectangle; `line` is the width of an outline instead of a filling.
    Rectangle {
        x: f32,
        y: f32,
        w: f32,
        h: f32,
        colour: Rgb,
        line: Option<f32>,
    },
    /// A straight line.
    Line {
        from: [f32; 2],
        to: [f32; 2],
        colour: Rgb,
        width: f32,
    },
    /// An ellipse's outline, its major axis turned by `angle` radians clockwise on the page from the right.
    Ellipse {
        centre: [f32; 2],
        radii: [f32; 2],
        angle: f32,
        colour: Rgb,
        width: f32,
    },
    /// A filled polygon.
    Polygon { points: Vec<[f32; 2]>, colour: Rgb },
    /// One line of text; y is its base line.
    Text {
        x: f32,
        y: f32,
        size: f32,
        colour: Rgb,
        anchor: Anchor,
        text: String,
    },
}

/// Shapes on a page, in painting order.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) items: Vec<Item>,
}

/// The typeface of all pictures: DejaVu Sans, in the program itself.
pub(super) fn font() -> FontRef<'static> {
    const BYTES: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");
    FontRef::try_from_slice(BYTES).expect("the embedded font is whole")
}

/// Size of an em on the page to the font's own measure: CSS and SVG sizes count the em, ab_glyph the line.
pub(super) fn font_height(font: &FontRef<'_>, size: f32) -> f32 {
    let em = font
        .units_per_em()
        .expect("the embedded font states its em");
    size * font.height_unscaled() / em
}

/// Width of a text in pixels.
pub(super) fn text_width(text: &str, size: f32) -> f32 {
    let font = font();
    let scaled = font.as_scaled(font_height(&font, size));
    text.chars()
        .map(|c| scaled.h_advance(scaled.glyph_id(c)))
        .sum()
}

/// Breaks a text into lines of at most `width` pixels, at spaces.
pub(super) fn wrapped(text: &str, size: f32, width: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text.split(' ') {
        let longer = if line.is_empty() {
            word.to_owned()
        } else {
            format!("{line} {word}")
        };
        if !line.is_empty() && text_width(&longer, size) > width {
            lines.push(std::mem::replace(&mut line, word.to_owned()));
        } else {
            line = longer;
        }
    }
    lines.push(line);
    lines
}

/// Cuts a text that is wider than `width`, in its middle.
pub(super) fn shortened(text: &str, size: f32, width: f32) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let chars: Vec<char> = text.chars().collect();
    let cut = |keep: usize| -> String {
        let (head, tail) = (keep.div_ceil(2), keep / 2);
        chars[..head]
            .iter()
            .chain(&['…'])
            .chain(&chars[chars.len() - tail..])
            .collect()
    };
    (0..chars.len())
        .rev()
        .map(cut)
        .find(|text| text_width(text, size) <= width)
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_no_wider_than_asked() {
        let text = "pixels darker than a hundredth of the mean are masked, since noise makes them look polarized";
        let lines = wrapped(text, 12.0, 200.0);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| text_width(line, 12.0) <= 200.0));
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrapped("unbreakable", 12.0, 1.0), ["unbreakable"]);
    }

    #[test]
    fn long_names_keep_both_ends() {
        let short = shortened("a_very_long_scene_name_that_goes_on.exr", 12.0, 120.0);
        assert!(
            short.starts_with("a_v") && short.ends_with(".exr") && short.contains('…'),
            "{short}"
        );
        assert_eq!(shortened("a.exr", 12.0, 120.0), "a.exr");
    }

    #[test]
    fn an_em_is_the_size_asked_for() {
        // DejaVu Sans: the em dash is one em wide
        assert!((text_width("—", 20.0) - 20.0).abs() < 0.1);
    }
}
