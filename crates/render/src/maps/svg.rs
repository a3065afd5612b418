//! A drawing as SVG: one file that needs no other.

use std::fmt::Write;

use super::drawing::{Anchor, Drawing, Item, PAPER, Rgb};
use super::raster;

/// The drawing as an SVG file; bitmaps are embedded as PNG.
pub(super) fn svg(drawing: &Drawing) -> Result<String, String> {
    let (w, h) = (drawing.width, drawing.height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"DejaVu Sans, Verdana, sans-serif\" fill=\"none\" stroke-linecap=\"round\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        hex(PAPER)
    );
    for item in &drawing.items {
        element(&mut out, item)?;
    }
    out.push_str("</svg>\n");
    Ok(out)
}

fn element(out: &mut String, item: &Item) -> Result<(), String> {
    let written = match item {
        Item::Image {
            x,
            y,
            scale,
            picture,
        } => {
            let (w, h) = (picture.width * scale, picture.height * scale);
            let data = base64(&raster::encode(picture)?);
            writeln!(
                out,
                "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"none\" \
                 style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{data}\"/>"
            )
        }
        Item::Rectangle {
            x,
            y,
            w,
            h,
            colour,
            line,
        } => {
            let style = match line {
                None => format!("fill=\"{}\"", hex(*colour)),
                Some(width) => format!("stroke=\"{}\" stroke-width=\"{width}\"", hex(*colour)),
            };
            writeln!(
                out,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {style}/>"
            )
        }
        Item::Line {
            from: [x1, y1],
            to: [x2, y2],
            colour,
            width,
        } => writeln!(
            out,
            "<line x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\" stroke=\"{}\" stroke-width=\"{width:.2}\"/>",
            hex(*colour)
        ),
        Item::Ellipse {
            centre: [x, y],
            radii: [a, b],
            angle,
            colour,
            width,
        } => writeln!(
            out,
            "<ellipse rx=\"{a:.2}\" ry=\"{b:.2}\" transform=\"translate({x:.2} {y:.2}) rotate({:.2})\" \
             stroke=\"{}\" stroke-width=\"{width:.2}\"/>",
            angle.to_degrees(),
            hex(*colour)
        ),
        Item::Polygon { points, colour } => {
            let points: Vec<String> = points
                .iter()
                .map(|[x, y]| format!("{x:.2},{y:.2}"))
                .collect();
            writeln!(
                out,
                "<polygon points=\"{}\" fill=\"{}\"/>",
                points.join(" "),
                hex(*colour)
            )
        }
        Item::Text {
            x,
            y,
            size,
            colour,
            anchor,
            text,
        } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            writeln!(
                out,
                "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size:.2}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
                hex(*colour),
                escaped(text)
            )
        }
    };
    written.map_err(|e| e.to_string())
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text that XML takes: its own signs escaped, control characters dropped.
fn escaped(text: &str) -> String {
    let clean: String = text.chars().filter(|c| !c.is_control()).collect();
    clean
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk
            .iter()
            .fold(0_u32, |word, &byte| word << 8 | u32::from(byte))
            << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() {
                char::from(letter)
            } else {
                '='
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        let cases = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn names_cannot_break_the_markup() {
        let text = Item::Text {
            x: 0.0,
            y: 0.0,
            size: 10.0,
            colour: [0; 3],
            anchor: Anchor::Start,
            text: "<a & \"b\"\u{1}>".to_owned(),
        };
        let drawing = Drawing {
            width: 10,
            height: 10,
            items: vec![text],
        };
        let svg = svg(&drawing).unwrap();
        assert!(
            svg.contains("&lt;a &amp; &quot;b&quot;&gt;</text>"),
            "{svg}"
        );
        assert!(roxmltree::Document::parse(&svg).is_ok());
    }
}
