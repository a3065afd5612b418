//! Flat outlines in space, rectangles and disks.

use std::f32::consts::PI;

use glam::{Vec2, Vec3A, vec2};

use super::cells::Cells;

/// A flat outline in space: the image of the unit square or disk.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// Where (0, 0) is.
    pub centre: Vec3A,
    /// Where (1, 0) is, from the centre.
    pub half_u: Vec3A,
    /// Where (0, 1) is, from the centre.
    pub half_v: Vec3A,
    /// Front-side normal, unit.
    pub normal: Vec3A,
    /// Whether it is round.
    pub round: bool,
    /// Half-widths of the box that holds a point's rounding error.
    pub error: Vec3A,
}

impl Outline {
    /// Mean, root of the covariance and share of the area of the cell that holds a point, in coordinates of the outline.
    ///
    /// `widths`: angles under which its half axes are seen, cut into pieces of at most `largest`.
    pub(crate) fn cell_at(
        &self,
        at: Vec3A,
        widths: [f32; 2],
        largest: f32,
    ) -> (Vec2, [Vec2; 2], f32) {
        let cells = Cells::of(self.round, widths, largest);
        let cell = cells.cell(cells.find(self.coordinates(at)));
        (cell.mean, cell.root, cell.share)
    }

    pub(crate) fn area(&self) -> f32 {
        self.unit_area() * self.half_u.cross(self.half_v).length()
    }

    /// Area in its own coordinates.
    pub(crate) fn unit_area(&self) -> f32 {
        if self.round { PI } else { 4.0 }
    }

    /// Whether coordinates are within it.
    pub(crate) fn holds(&self, x: Vec2) -> bool {
        if self.round {
            x.length_squared() <= 1.0
        } else {
            x.abs().max_element() <= 1.0
        }
    }

    /// Coordinates of a point of the plane.
    pub(crate) fn coordinates(&self, at: Vec3A) -> Vec2 {
        let offset = at - self.centre;
        let n = self.half_u.cross(self.half_v);
        let scale = n.length_squared().recip();
        vec2(
            offset.cross(self.half_v).dot(n) * scale,
            self.half_u.cross(offset).dot(n) * scale,
        )
    }

    /// The point at given coordinates.
    pub(crate) fn at(&self, x: Vec2) -> Vec3A {
        self.centre + self.half_u * x.x + self.half_v * x.y
    }
}
