//! `irradiancemeter`: a bare sensor plane without lens, nested in the flat shape that it covers.
//!
//! | parameter | type   | meaning                                                                          | default |
//! |-----------|--------|----------------------------------------------------------------------------------|---------|
//! | `toward`  | string | id of a rectangle or disk: light that comes through any other place is not recorded | –    |
//!
//! ```xml
//! <shape type="rectangle">
//!     <sensor type="irradiancemeter">
//!         <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/><rfilter type="box"/></film>
//!     </sensor>
//! </shape>
//! ```
//!
//! Nested: `film`, `sampler`. On a `rectangle` or a `disk`, whose `to_world` places it; other shapes are refused. Each pixel
//! is a piece of the shape and records the irradiance on its front, W/m²:
//!
//! ```text
//! E = ∫ S(i) cos_i dω_i
//! ```
//!
//! **Image.** Columns run along the shape's local x. The image is the one on a ground-glass screen seen from behind, against
//! the light: row 0 is at local y = −1, the last row at +1 (as in Mitsuba). A transform that mirrors and `flip_normals`
//! turn the rows round, so that this stays true. On a disk the film is wrapped around the middle by the concentric map,
//! which keeps areas: one pixel is the whole disk.
//!
//! **Frame.** For light along k the first axis is local x, projected across k; along local x itself local y takes its
//! place. On the axis these are image right and, second, image up; where light comes from all sides the sum over
//! directions is a paraxial convention.
//!
//! **`toward`.** Emitters are looked for from every point of the plane, and directions are drawn by their cosine. These
//! seldom meet a small opening behind which the light is: `toward` draws directions to points uniform over a shape instead,
//! and cuts the field of view to it. A rectangle of `null` matter serves as such a window before anything else.
//!
//! The shape stays in the scene with its bsdf and reflects (`diffuse` by default). `hide_emitters` does not apply: a plane has
//! no other way to see light. It lies in air. Use a `box` filter: wider ones mix neighbouring pixels.

use glam::{Vec2, Vec3A, vec2};

use crate::emitter::patch::Outline;
use crate::geometry::frame::Frame;
use crate::material::Material;
use crate::material::detector::Detector;
use crate::path::witness::View;
use crate::path::{PlanePoint, Start};
use crate::sampler::unit_disk;
use crate::shape::Surface;

/// A bare sensor plane.
#[derive(Clone, Debug)]
pub struct IrradianceMeter {
    outline: Outline,
    /// Image right, image down, toward the light.
    frame: Frame,
    /// Local y of the lowest row.
    bottom: f32,
    detector: Material,
    toward: Option<Outline>,
    /// Film size, pixels.
    size: [f32; 2],
}

impl IrradianceMeter {
    /// On a flat shape, with a film of `size` pixels.
    pub fn new(outline: Outline, toward: Option<Outline>, size: [u32; 2]) -> Self {
        let frame = Frame::with_tangent(outline.normal, outline.half_u);
        Self {
            outline,
            frame,
            bottom: 1f32.copysign(frame.t.dot(outline.half_v)),
            detector: Material::Detector(Detector {
                toward: toward.map(Box::new),
            }),
            toward,
            size: size.map(|n| n as f32),
        }
    }

    /// Where a film position in pixels (0, 0 is the top left corner) is on the plane.
    pub fn start(&self, x: f32, y: f32) -> Start<'_> {
        let film = vec2(x, y) / Vec2::from_array(self.size);
        let place = if self.outline.round {
            Vec2::from(unit_disk(film.to_array()))
        } else {
            2.0 * film - 1.0
        };
        let position = self.outline.at(vec2(place.x, place.y * self.bottom));
        Start::Plane(PlanePoint {
            surface: Surface {
                position,
                error: self.outline.error,
                normal: self.frame.n,
                frame: self.frame,
            },
            detector: &self.detector,
            scale: self.scale(position),
        })
    }

    /// About the irradiance of unit radiance from all that the plane sees, steradians: what paths count in.
    fn scale(&self, position: Vec3A) -> f32 {
        let whole = std::f32::consts::PI;
        self.toward.map_or(whole, |window| {
            let squared = (window.centre - position).length_squared();
            let seen = window.area() / squared;
            if seen > 0.0 { seen.min(whole) } else { whole }
        })
    }

    /// What it sees of coherence: all light at one point, in the frame of the plane.
    pub fn view(&self) -> View {
        View {
            direction: self.frame.n,
            right: self.frame.s,
            root: [Vec3A::ZERO; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::shape::Shape;
    use crate::shape::disk::Disk;
    use crate::shape::rectangle::Rectangle;

    fn meter(to_world: &DMat4, flip: bool, round: bool) -> IrradianceMeter {
        let shape = if round {
            Shape::Disk(Disk::new(to_world, flip))
        } else {
            Shape::Rectangle(Rectangle::new(to_world, flip))
        };
        IrradianceMeter::new(shape.outline().expect("flat"), None, [4, 2])
    }

    fn point(meter: &IrradianceMeter, x: f32, y: f32) -> Surface {
        match meter.start(x, y) {
            Start::Plane(point) => point.surface,
            Start::Ray { .. } => panic!("a plane expected"),
        }
    }

    #[test]
    fn the_image_is_seen_against_the_light() {
        let scaled = DMat4::from_scale(DVec3::new(2.0, 1.0, 1.0));
        let mirrored = DMat4::from_scale(DVec3::new(2.0, -1.0, 1.0));
        for (to_world, flip) in [
            (scaled, false),
            (scaled, true),
            (mirrored, false),
            (mirrored, true),
        ] {
            let meter = meter(&to_world, flip, false);
            let [corner, right, down] =
                [(0.0, 0.0), (4.0, 0.0), (0.0, 2.0)].map(|(x, y)| point(&meter, x, y).position);
            let (right, up) = ((right - corner) / 4.0, (corner - down) / 2.0);
            // for an observer who faces the light, that is along the normal: right × up points back to him
            let normal = point(&meter, 0.0, 0.0).normal;
            assert!(
                (right.cross(up) + normal).length() < 1e-6,
                "{flip}: {right} {up} {normal}"
            );
            assert!((right - Vec3A::X).length() < 1e-6);
            assert_eq!(point(&meter, 0.0, 0.0).frame.s, Vec3A::X);
            assert_eq!(normal.z > 0.0, !flip);
        }
        // Mitsuba's: row 0 at local y = −1
        let top = point(&meter(&scaled, false, false), 0.0, 0.0).position;
        assert!((top - Vec3A::new(-2.0, -1.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn a_disk_is_covered_evenly() {
        let meter = meter(&DMat4::from_scale(DVec3::splat(3.0)), false, true);
        let n = 100;
        let mut squares = 0.0;
        for row in 0..n {
            for column in 0..n {
                let at = |k: i32, length: f32| (k as f32 + 0.5) / n as f32 * length;
                let p = point(&meter, at(column, 4.0), at(row, 2.0)).position;
                squares += f64::from(p.length_squared()) / f64::from(n * n);
            }
        }
        // mean of r² over a disk: R²/2; the midpoint rule errs by the square of its step
        assert!((squares / 4.5 - 1.0).abs() < 3e-4, "{squares}");
    }
}
