//! The unit square and the unit disk cut into cells, the moments of each, and which of them holds a point.
//!
//! A square is cut into equal cells, a disk into rings and these into cells of about equal width.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, vec2};

/// A cell of the unit square [−1, 1]² or of the unit disk: moments of the uniform distribution over it.
pub(super) struct Cell {
    pub(super) mean: Vec2,
    pub(super) root: [Vec2; 2],
    /// Share of the whole area.
    pub(super) share: f32,
}

/// How a unit outline is cut.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cells {
    /// The square, into columns × rows.
    Square { columns: u32, rows: u32 },
    /// The disk, into rings of equal width.
    Disk { rings: u32 },
}

/// Finest cut across one axis: numbers of cells stay exact in single precision.
const FINEST: f32 = 1024.0;

pub(super) fn pieces(half_width: f32, largest: f32) -> u32 {
    // a largest half-width of 0 asks for the finest cut
    (half_width / largest).ceil().clamp(1.0, FINEST) as u32
}

/// Cells in ring `ring`: about as wide along the ring as across it.
fn sectors(ring: u32) -> u32 {
    if ring == 0 {
        1
    } else {
        (PI * (2 * ring + 1) as f32).ceil() as u32
    }
}

impl Cells {
    /// Cells of at most the given half-width; `widths` are those of the outline's half axes.
    pub(super) fn of(round: bool, [u, v]: [f32; 2], largest: f32) -> Self {
        if round {
            Self::Disk {
                // the disk in the middle has the width of a whole ring on both sides
                rings: pieces(u.max(v), largest),
            }
        } else {
            Self::Square {
                columns: pieces(u, largest),
                rows: pieces(v, largest),
            }
        }
    }

    pub(super) fn len(self) -> u32 {
        match self {
            Self::Square { columns, rows } => columns * rows,
            Self::Disk { rings } => (0..rings).map(sectors).sum(),
        }
    }

    /// Ring and sector of a cell of the disk.
    fn ring_of(mut index: u32) -> (u32, u32) {
        let mut ring = 0;
        while index >= sectors(ring) {
            index -= sectors(ring);
            ring += 1;
        }
        (ring, index)
    }

    pub(super) fn cell(self, index: u32) -> Cell {
        match self {
            Self::Square { columns, rows } => {
                let (width, height) = (2.0 / columns as f32, 2.0 / rows as f32);
                let (column, row) = (index % columns, index / columns);
                // a uniform distribution of width w has standard deviation w/√12
                let deviation = 12f32.sqrt().recip();
                Cell {
                    mean: vec2(
                        (column as f32 + 0.5) * width - 1.0,
                        (row as f32 + 0.5) * height - 1.0,
                    ),
                    root: [vec2(width * deviation, 0.0), vec2(0.0, height * deviation)],
                    share: (columns as f32 * rows as f32).recip(),
                }
            }
            Self::Disk { rings } => {
                let (ring, sector) = Self::ring_of(index);
                let step = (rings as f32).recip();
                if ring == 0 {
                    return Cell {
                        mean: Vec2::ZERO,
                        root: [vec2(0.5 * step, 0.0), vec2(0.0, 0.5 * step)],
                        share: step * step,
                    };
                }
                let count = sectors(ring);
                let (a, b) = (ring as f32 * step, (ring + 1) as f32 * step);
                let half = PI / count as f32;
                // moments of r over the ring, of cos and cos 2φ over the sector
                let area = b * b - a * a;
                let radius = 2.0 / 3.0 * (b * b * b - a * a * a) / area;
                let square = 0.5 * (b * b + a * a);
                let (sinc, sinc2) = (half.sin() / half, (2.0 * half).sin() / (2.0 * half));
                let along = radius * sinc;
                let radial = (0.5 * square * (1.0 + sinc2) - along * along)
                    .max(0.0)
                    .sqrt();
                let tangential = (0.5 * square * (1.0 - sinc2)).sqrt();
                let axis = Vec2::from_angle((2 * sector + 1) as f32 * half);
                Cell {
                    mean: axis * along,
                    root: [axis * radial, axis.perp() * tangential],
                    share: area / count as f32,
                }
            }
        }
    }

    /// A point uniform over a cell.
    pub(super) fn point(self, index: u32, u: [f32; 2]) -> Vec2 {
        match self {
            Self::Square { columns, rows } => vec2(
                2.0 * ((index % columns) as f32 + u[0]) / columns as f32 - 1.0,
                2.0 * ((index / columns) as f32 + u[1]) / rows as f32 - 1.0,
            ),
            Self::Disk { rings } => {
                let (ring, sector) = Self::ring_of(index);
                let step = (rings as f32).recip();
                let (a, b) = (ring as f32 * step, (ring + 1) as f32 * step);
                let radius = (a * a + u[0] * (b * b - a * a)).sqrt();
                let angle = (sector as f32 + u[1]) * TAU / sectors(ring) as f32;
                Vec2::from_angle(angle) * radius
            }
        }
    }

    /// The cell that holds a point.
    pub(super) fn find(self, at: Vec2) -> u32 {
        match self {
            Self::Square { columns, rows } => {
                let place =
                    |x: f32, count: u32| ((0.5 * (x + 1.0) * count as f32) as u32).min(count - 1);
                place(at.y, rows) * columns + place(at.x, columns)
            }
            Self::Disk { rings } => {
                let ring = ((at.length() * rings as f32) as u32).min(rings - 1);
                let turn = (at.y.atan2(at.x) / TAU).rem_euclid(1.0);
                let sector = ((turn * sectors(ring) as f32) as u32).min(sectors(ring) - 1);
                (0..ring).map(sectors).sum::<u32>() + sector
            }
        }
    }
}
