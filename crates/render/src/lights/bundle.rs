//! Light sources as seen from afar: where they are, which way they face, and how strong they are.
//!
//! Source: cones of normals, the cost of a cut and the estimate for a vertex as in Conty Estevez and Kulla, Importance
//! Sampling of Many Lights with Adaptive Tree Splitting, PACMCGIT 1(2), 2018.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3A;

use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;

/// Sources in a box, or one of them.
#[derive(Clone, Copy, Debug)]
pub struct Bundle {
    /// Contains all of them.
    pub bounds: Bounds,
    /// Middle of the cone of their normals, unit.
    pub axis: Vec3A,
    /// Half angle of that cone, radians; π: they face all ways.
    pub spread: f32,
    /// Angle from a normal within which there is light, radians.
    pub edge: f32,
    /// Radiant intensity along the normals, W/sr; it falls with the cosine to them.
    pub intensity: f64,
}

impl Bundle {
    /// A source that looks the same from everywhere.
    pub fn even(bounds: Bounds, intensity: f64) -> Self {
        Self {
            bounds,
            axis: Vec3A::Z,
            spread: PI,
            edge: FRAC_PI_2,
            intensity,
        }
    }

    /// A source that shines into the half space of a normal, by the cosine to it.
    pub fn facing(axis: Vec3A, bounds: Bounds, intensity: f64) -> Self {
        Self {
            axis,
            spread: 0.0,
            ..Self::even(bounds, intensity)
        }
    }

    /// Both together.
    pub fn and(&self, other: &Self) -> Self {
        let (a, b) = (self.bounds, other.bounds);
        let (axis, spread) = cone_around((self.axis, self.spread), (other.axis, other.spread));
        Self {
            bounds: Bounds {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            },
            axis,
            spread,
            edge: self.edge.max(other.edge),
            intensity: self.intensity + other.intensity,
        }
    }

    pub(super) fn centre(&self) -> Vec3A {
        0.5 * self.bounds.min + 0.5 * self.bounds.max
    }

    /// Squared diameter of the box.
    pub(super) fn squared_diameter(&self) -> f32 {
        (self.bounds.max - self.bounds.min).length_squared()
    }

    /// What it costs to know no more than this bundle: intensity × measure of its directions × its size.
    ///
    /// The size is the squared diameter of the box, for the estimate takes its sphere; its surface, as in the source, would
    /// be nothing for lamps in a row.
    pub(super) fn cost(&self) -> f64 {
        let spread = f64::from(self.spread);
        let wide = (spread + f64::from(self.edge)).min(std::f64::consts::PI);
        let (sin, cos) = spread.sin_cos();
        let beyond = 2.0 * wide * sin - (spread - 2.0 * wide).cos() - 2.0 * spread * sin + cos;
        let directions = std::f64::consts::TAU * (1.0 - cos) + std::f64::consts::FRAC_PI_2 * beyond;
        self.intensity * directions * f64::from(self.squared_diameter())
    }
}

/// The smallest cone around two cones, each an axis and a half angle.
fn cone_around(a: (Vec3A, f32), b: (Vec3A, f32)) -> (Vec3A, f32) {
    let (wide, narrow) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    let across = wide.0.cross(narrow.0).length();
    let apart = across.atan2(wide.0.dot(narrow.0));
    if (apart + narrow.1).min(PI) <= wide.1 {
        return wide;
    }
    let spread = 0.5 * (wide.1 + apart + narrow.1);
    if spread >= PI {
        return (wide.0, PI);
    }
    // the axis turns toward the narrow cone; opposite ones leave the way open
    let toward = Frame::with_tangent(wide.0, narrow.0).s;
    let (sin, cos) = (spread - wide.1).sin_cos();
    ((wide.0 * cos + toward * sin).normalize(), spread)
}

/// Least falloff where there may be light: spots fall more slowly than the cosine.
pub(super) const LEAST: f32 = 0.02;

/// Rounding of the cosines that say where there is none.
const SLACK: f32 = 1e-4;

/// Least squared distance that counts, in squared radii of the box: of one source, so that a square panel and a ball send
/// about π times their radiance to who touches them; of many, since over a cube 1/d² from the middle is 5.9/r² in the mean.
const NEAREST: f32 = 0.5;
const NEAREST_OF_MANY: f32 = 1.0 / 6.0;

/// A bundle, ready to be looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) centre: Vec3A,
    pub(super) axis: Vec3A,
    pub(super) radius: f32,
    pub(super) squared_radius: f32,
    pub(super) least_square: f32,
    pub(super) cos_spread: f32,
    pub(super) sin_spread: f32,
    pub(super) cos_edge: f32,
    pub(super) intensity: f32,
}

impl Seen {
    /// One source; `unit` is the intensity that counts as 1.
    pub(super) fn one(bundle: &Bundle, unit: f64) -> Self {
        Self::new(bundle, unit, NEAREST)
    }

    /// Many sources.
    pub(super) fn many(bundle: &Bundle, unit: f64) -> Self {
        Self::new(bundle, unit, NEAREST_OF_MANY)
    }

    fn new(bundle: &Bundle, unit: f64, nearest: f32) -> Self {
        let squared_radius = 0.25 * bundle.squared_diameter();
        let all_ways = bundle.spread >= PI;
        Self {
            centre: bundle.centre(),
            axis: bundle.axis,
            radius: squared_radius.sqrt(),
            squared_radius,
            least_square: nearest * squared_radius,
            cos_spread: if all_ways { -1.0 } else { bundle.spread.cos() },
            sin_spread: if all_ways { 0.0 } else { bundle.spread.sin() },
            cos_edge: bundle.edge.cos() - SLACK,
            intensity: (bundle.intensity / unit) as f32,
        }
    }

    /// The irradiance that it may send to a point: intensity × cosine of the least possible angle to a normal, over the
    /// squared distance of the centre.
    ///
    /// Zero only where no light can come.
    #[inline]
    pub(super) fn irradiance(&self, from: Vec3A) -> f32 {
        let to = from - self.centre;
        let squared = to.length_squared();
        let squared_distance = squared.max(self.least_square);
        let outside = squared > self.squared_radius;
        let mut falloff = 1.0;
        if outside && self.cos_spread > -1.0 {
            // the angle to the axis, less the cone's, less that under which the box is seen: (cos, sin) times the distance
            let along = self.axis.dot(to);
            let across = (squared - along * along).max(0.0).sqrt();
            let size = ((squared - self.squared_radius).sqrt(), self.radius);
            let (c, s) = less((along, across), (self.cos_spread, self.sin_spread));
            if s > 0.0 {
                let (c, s) = less((c, s), size);
                if s > 0.0 {
                    falloff = c / squared;
                }
            }
            if falloff < self.cos_edge {
                return 0.0;
            }
            falloff = falloff.max(LEAST);
        }
        // nothing overflows, and what is not zero stays so
        if self.intensity > 0.0 {
            (self.intensity / squared_distance * falloff).clamp(f32::MIN_POSITIVE, f32::MAX * 0.25)
        } else {
            0.0
        }
    }
}

/// Cosine and sine of the difference of two angles, each a cosine and a sine.
#[inline]
fn less(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    (a.0 * b.0 + a.1 * b.1, a.1 * b.0 - a.0 * b.1)
}
