//! The specular matter between a vertex and its light, and what it makes of the light's coherence.
//!
//! A mirror, a smooth interface or an order of a grating has infinite correlation: the coherence of the light passes on.
//! How, ray differentials tell: with the displacement dm on the source that a turn dθ of the ray at the vertex makes
//! through the whole chain, a displacement m on the source is seen under the angle (dm/dθ)⁻¹ m. Flat mirrors are the case
//! dm/dθ = sum of lengths.
//!
//! Source: the mixed derivative K of the optical path between source and receiver, K' = n (dm/dθ)⁻¹; Walther, JOSA 58, 1968.

use glam::{Vec3A, vec2};

use super::witness::Witness;
use super::{Waiting, Walk};
use crate::emitter::Emitter;
use crate::emitter::patch::{Outline, Patch};
use crate::geometry::frame::Frame;
use crate::geometry::ray::{Ray, offset_origin};
use crate::light::{Light, Sight};
use crate::material::{Matter, Part, Vertex};
use crate::shape::Surface;

/// Longest chain through which coherence is followed; behind longer ones light comes from points.
const LONGEST: usize = 6;

/// Turn of the neighbouring rays, radians: small against lenses, large against rounding of positions.
const TURN: f32 = 1e-3;

/// Effective distances below this share of the length of the way count as a caustic: TURN errs by 3 % of them.
const CAUSTIC: f32 = 0.03;

/// The specular matter since a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<L: Light> {
    /// Its direction at the vertex, world.
    pub(super) direction: Vec3A,
    /// Whether nothing has bent it.
    pub(super) straight: bool,
    /// How it went at each specular vertex, and on which material.
    parts: [(Part, u32); LONGEST],
    count: usize,
    /// What the matter does to the light, in the frame of `axis` at the vertex; kept while the vertex waits.
    matrix: Option<(Vec3A, L::Throughput)>,
    /// From the vertex to the last matter on it, metres.
    pub(super) length: f32,
}

impl<L: Light> Way<L> {
    /// A way without matter so far.
    #[inline]
    pub(super) fn new(direction: Vec3A) -> Self {
        Self {
            direction,
            straight: true,
            parts: [(Part::Straight, 0); LONGEST],
            count: 0,
            matrix: None,
            length: 0.0,
        }
    }

    /// Starts anew at a vertex.
    #[inline]
    pub(super) fn begin(&mut self, direction: Vec3A) {
        self.direction = direction;
        self.straight = true;
        self.count = 0;
        self.matrix = None;
        self.length = 0.0;
    }

    /// Notes how it went on.
    #[inline]
    pub(super) fn note(&mut self, part: Part, material: u32) {
        self.straight &= part == Part::Straight;
        if let Some(place) = self.parts.get_mut(self.count) {
            *place = (part, material);
        }
        self.count += 1;
    }

    /// Whether it is too long to be followed a second time.
    #[inline]
    pub(super) fn is_lost(&self) -> bool {
        !self.straight && self.count > LONGEST
    }

    /// Multiplies matter into it, after a stretch of given length.
    pub(super) fn extend(&mut self, response: L::Response, weight: f32, k_out: Vec3A, length: f32) {
        let (axis, before) = self.matrix.unwrap_or_else(|| {
            let axis = Frame::around(self.direction).s;
            (axis, L::identity(axis))
        });
        self.matrix = Some((axis, L::extend(&before, response, weight, k_out)));
        self.length += length;
    }

    /// A throughput that ends at the vertex, prolonged to the end of the way.
    #[inline]
    pub(super) fn after(&self, throughput: L::Throughput) -> L::Throughput {
        match &self.matrix {
            None => throughput,
            Some((axis, matrix)) => L::extend(
                &throughput,
                L::as_response(matrix, *axis),
                1.0,
                -self.direction,
            ),
        }
    }
}

impl<'a, L: Light, W: Witness> Walk<'a, L, W> {
    /// The patch of a flat emitter that a way through specular matter has hit, as the vertex behind sees it.
    ///
    /// `None` where neighbouring rays go other ways, near a caustic, and for emitters that are not flat.
    pub(super) fn patch_through(
        &mut self,
        from: &Waiting<'a>,
        emitter: &Emitter,
        hit: &Surface,
        last: &Ray,
        largest: f32,
    ) -> Option<Patch> {
        let outline = emitter.outline(self.scene)?;
        let way = self.way;
        let axes = Frame::around(way.direction);
        let (error, normal) = from.start;
        let start = Surface {
            position: from.vertex.position,
            error,
            normal,
            frame: from.vertex.frame,
        };
        let mut shifts = [Vec3A::ZERO; 2];
        for (shift, axis) in shifts.iter_mut().zip([axes.s, axes.t]) {
            let direction = (way.direction + axis * TURN).normalize();
            let end = self.neighbour(&way, &start, direction, &outline)?;
            *shift = (end - hit.position) / TURN;
        }
        let length = way.length + (hit.position - last.origin).length();
        outline.patch_through(
            hit.position,
            shifts,
            (way.direction, [axes.s, axes.t]),
            length,
            largest,
        )
    }

    /// Where a ray next to a way arrives in the plane of the source.
    fn neighbour(
        &mut self,
        way: &Way<L>,
        start: &Surface,
        mut direction: Vec3A,
        outline: &Outline,
    ) -> Option<Vec3A> {
        let mut from = *start;
        for (part, material) in way.parts.get(..way.count)? {
            self.counters.rays += 1;
            let ray = Ray {
                origin: offset_origin(from.position, from.error, from.normal, direction),
                direction,
                t_max: f32::INFINITY,
            };
            let met = self
                .scene
                .intersect(&ray, self.stack)
                .filter(|met| met.owner.material == *material)?;
            let frame = met.surface.frame;
            let vertex = Vertex {
                o: frame.to_local(-direction),
                position: met.surface.position,
                frame,
                viewer_distance: (met.surface.position - from.position).length(),
                sight: Sight::BLIND,
            };
            if *part != Part::Straight {
                let material = &self.scene.materials[met.owner.material as usize];
                direction = frame.to_world(material.bend(&vertex, *part, self.wavelengths)?);
            }
            from = met.surface;
        }
        let along = direction.dot(outline.normal);
        let t = (outline.centre - from.position).dot(outline.normal) / along;
        (t.is_finite() && t > 0.0).then(|| from.position + direction * t)
    }
}

impl Outline {
    /// The patch that holds `hit`, seen through specular matter.
    ///
    /// `shifts` are the displacements in its plane per radian of the two axes of the view.
    fn patch_through(
        &self,
        hit: Vec3A,
        shifts: [Vec3A; 2],
        (direction, axes): (Vec3A, [Vec3A; 2]),
        distance: f32,
        largest: f32,
    ) -> Option<Patch> {
        // coordinates of the outline per radian
        let columns = shifts.map(|shift| self.coordinates(self.centre + shift));
        let determinant = columns[0].perp_dot(columns[1]);
        // near a caustic the way back is lost: rays that turn by TURN no longer tell how those next to them go
        let area = shifts[0].cross(shifts[1]).length();
        let largest_shift = shifts[0].length().max(shifts[1].length());
        if !determinant.is_finite() || area <= CAUSTIC * distance * largest_shift {
            return None;
        }
        let angle = |x: glam::Vec2| {
            let turn = vec2(x.perp_dot(columns[1]), columns[0].perp_dot(x)) / determinant;
            axes[0] * turn.x + axes[1] * turn.y
        };
        let widths = [angle(glam::Vec2::X).length(), angle(glam::Vec2::Y).length()];
        let (centre, root, share) = self.cell_at(hit, widths, largest);
        let off = self.coordinates(hit) - centre;
        Some(Patch {
            direction: (direction - angle(off)).normalize(),
            centre: self.at(centre),
            distance,
            angular_root: root.map(angle),
            solid_angle: share * self.unit_area() / determinant.abs(),
        })
    }
}

#[cfg(test)]
#[path = "way_tests.rs"]
mod tests;
