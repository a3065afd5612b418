//! Axis-aligned boxes, and what stands in them.

use glam::Vec3A;

use super::flat::Flat;
use super::ray::gamma;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Lowest corner.
    pub min: Vec3A,
    /// Highest corner.
    pub max: Vec3A,
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub fn of(points: impl IntoIterator<Item = Vec3A>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// Grown by `margin` on every side.
    pub fn grown(self, margin: Vec3A) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// Grown by at least `margin` on every side, rounded outward.
    fn grown_outward(self, margin: Vec3A) -> Self {
        let Self { min, max } = self.grown(margin);
        Self {
            min: Vec3A::from_array(min.to_array().map(f32::next_down)),
            max: Vec3A::from_array(max.to_array().map(f32::next_up)),
        }
    }
}

/// What the tree holds.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// A triangle or a parallelogram.
    Flat(Flat),
    /// Something else, known by its box.
    Other(Bounds),
}

impl Primitive {
    /// The box that contains every point of the primitive, and of a flat one every point that the intersection test
    /// may find although it lies beside the primitive by what its extent adds to roundings (see [`super::node`]).
    pub(super) fn bounds(&self) -> Bounds {
        match self {
            Self::Flat(Flat {
                corners: [a, b, c],
                parallelogram,
            }) => {
                let triangle = Bounds::of([*a, *b, *c]);
                if !parallelogram {
                    let extent = (triangle.max - triangle.min).max_element();
                    return triangle.grown_outward(Vec3A::splat(gamma(8) * extent));
                }
                let whole = Bounds::of([*a, *b, *c, *b + *c - *a]);
                // the fourth corner is rounded, and three others stand for it in the test; across a side that is
                // parallel to two axes nothing is added for that, so that rays that leave it do not meet it again
                let coordinate = whole.min.abs().max(whole.max.abs());
                let extent = whole.max - whole.min;
                let margin = Vec3A::select(
                    extent.cmpgt(Vec3A::ZERO),
                    Vec3A::splat(gamma(24) * extent.max_element()),
                    Vec3A::ZERO,
                );
                whole.grown_outward(coordinate * gamma(4) + margin)
            }
            Self::Other(bounds) => *bounds,
        }
    }
}
