//! A drawing as pixels: PNG.

use ab_glyph::{Font, ScaleFont};
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

use super::drawing::{Anchor, Drawing, Item, PAPER, Picture, Rgb, font, font_height, text_width};

/// The drawing as a PNG file; an error text where it is too large to be held.
pub(super) fn png(drawing: &Drawing) -> Result<Vec<u8>, String> {
    let too_large = || {
        format!(
            "a picture of {}x{} pixels cannot be held",
            drawing.width, drawing.height
        )
    };
    let size = |n: usize| u32::try_from(n).map_err(|_| too_large());
    let mut page =
        Pixmap::new(size(drawing.width)?, size(drawing.height)?).ok_or_else(too_large)?;
    page.fill(Color::from_rgba8(PAPER[0], PAPER[1], PAPER[2], 255));
    for item in &drawing.items {
        draw(&mut page, item);
    }
    let pixels = page
        .pixels()
        .iter()
        .map(|p| [p.red(), p.green(), p.blue()])
        .collect();
    encode(&Picture {
        width: drawing.width,
        height: drawing.height,
        pixels,
    })
}

/// A bitmap as a PNG file.
pub(super) fn encode(picture: &Picture) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer
        .write_image_data(picture.pixels.as_flattened())
        .map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

fn draw(page: &mut Pixmap, item: &Item) {
    match item {
        Item::Image {
            x,
            y,
            scale,
            picture,
        } => blit(page, [*x, *y], *scale, picture),
        Item::Rectangle {
            x,
            y,
            w,
            h,
            colour,
            line,
        } => {
            let Some(rect) = Rect::from_xywh(*x, *y, *w, *h) else {
                return;
            };
            match line {
                None => page.fill_rect(rect, &paint(*colour), Transform::identity(), None),
                Some(width) => stroke(
                    page,
                    Some(PathBuilder::from_rect(rect)),
                    *colour,
                    *width,
                    Transform::identity(),
                ),
            }
        }
        Item::Line {
            from,
            to,
            colour,
            width,
        } => {
            let mut path = PathBuilder::new();
            path.move_to(from[0], from[1]);
            path.line_to(to[0], to[1]);
            stroke(page, path.finish(), *colour, *width, Transform::identity());
        }
        Item::Ellipse {
            centre,
            radii,
            angle,
            colour,
            width,
        } => {
            let oval = Rect::from_xywh(-radii[0], -radii[1], 2.0 * radii[0], 2.0 * radii[1])
                .and_then(PathBuilder::from_oval);
            let turn =
                Transform::from_rotate(angle.to_degrees()).post_translate(centre[0], centre[1]);
            stroke(page, oval, *colour, *width, turn);
        }
        Item::Polygon { points, colour } => {
            let mut path = PathBuilder::new();
            for (i, p) in points.iter().enumerate() {
                if i == 0 {
                    path.move_to(p[0], p[1]);
                } else {
                    path.line_to(p[0], p[1]);
                }
            }
            path.close();
            if let Some(path) = path.finish() {
                page.fill_path(
                    &path,
                    &paint(*colour),
                    FillRule::Winding,
                    Transform::identity(),
                    None,
                );
            }
        }
        Item::Text {
            x,
            y,
            size,
            colour,
            anchor,
            text,
        } => write(page, [*x, *y], *size, *colour, *anchor, text),
    }
}

fn paint(colour: Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(colour[0], colour[1], colour[2], 255);
    paint.anti_alias = true;
    paint
}

fn stroke(
    page: &mut Pixmap,
    path: Option<tiny_skia::Path>,
    colour: Rgb,
    width: f32,
    transform: Transform,
) {
    let Some(path) = path else { return };
    let pen = Stroke {
        width,
        line_cap: tiny_skia::LineCap::Round,
        ..Stroke::default()
    };
    page.stroke_path(&path, &paint(colour), &pen, transform, None);
}

/// Copies a bitmap, each of its pixels as a square.
fn blit(page: &mut Pixmap, at: [f32; 2], scale: usize, picture: &Picture) {
    let (left, top) = (at[0].round() as usize, at[1].round() as usize);
    let (width, height) = (page.width() as usize, page.height() as usize);
    let pixels = page.pixels_mut();
    for y in 0..(picture.height * scale).min(height.saturating_sub(top)) {
        for x in 0..(picture.width * scale).min(width.saturating_sub(left)) {
            let [r, g, b] = picture.pixels[y / scale * picture.width + x / scale];
            pixels[(top + y) * width + left + x] =
                tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
        }
    }
}

fn write(page: &mut Pixmap, at: [f32; 2], size: f32, colour: Rgb, anchor: Anchor, text: &str) {
    let font = font();
    let scaled = font.as_scaled(font_height(&font, size));
    let mut x = match anchor {
        Anchor::Start => at[0],
        Anchor::Middle => at[0] - 0.5 * text_width(text, size),
        Anchor::End => at[0] - text_width(text, size),
    };
    for c in text.chars() {
        let id = scaled.glyph_id(c);
        let glyph = id.with_scale_and_position(scaled.scale(), ab_glyph::point(x, at[1].round()));
        x += scaled.h_advance(id);
        if let Some(outline) = scaled.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|i, j, cover| {
                blend(
                    page,
                    corner.x as i64 + i64::from(i),
                    corner.y as i64 + i64::from(j),
                    colour,
                    cover,
                );
            });
        }
    }
}

fn blend(page: &mut Pixmap, x: i64, y: i64, colour: Rgb, cover: f32) {
    if x < 0 || y < 0 || x >= i64::from(page.width()) || y >= i64::from(page.height()) {
        return;
    }
    let at = y as usize * page.width() as usize + x as usize;
    let old = page.pixels()[at];
    let mix = |old: u8, new: u8| {
        (f32::from(old) + (f32::from(new) - f32::from(old)) * cover.clamp(0.0, 1.0)).round() as u8
    };
    let [r, g, b] = [
        mix(old.red(), colour[0]),
        mix(old.green(), colour[1]),
        mix(old.blue(), colour[2]),
    ];
    page.pixels_mut()[at] = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
}
