//! Emitters cut into patches, each of them one Gaussian in direction with the patch's own mean and covariance.
//!
//! An emitter is incoherent over its area. Seen from a vertex, a patch of it is an apparent angular distribution; the
//! vertex's transfer averaged over that distribution is what the theorem gives for the patch's coherence. A patch is
//! cut so small, for the vertex that asks, that its Gaussian does for its true outline: its half-width is at most a given
//! angle, some fraction of the lobe with which the matter there answers. Who asks twice with the same angle gets the
//! same cut, so that a connection to a patch and a ray that hits it agree on what the patch is.
//!
//! A rectangle is cut as the unit square is, a disk and the cone under which a sphere is seen as the unit disk
//! (`patch/cells.rs`).

mod cells;
mod outline;

use std::f32::consts::TAU;

use glam::{Vec2, Vec3A, vec2};

use super::Target;
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::shape::sphere::Sphere;
use cells::{Cells, pieces};
pub use outline::Outline;

/// A piece of an emitter, as a vertex sees it.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Unit direction toward its centre.
    pub direction: Vec3A,
    /// Its centre, metres; for a source outside the scene meaningless.
    pub centre: Vec3A,
    /// Distance of its centre, metres.
    pub distance: f32,
    /// Two vectors across `direction` whose outer products sum to the covariance of its directions.
    pub angular_root: [Vec3A; 2],
    /// Steradians.
    pub solid_angle: f32,
}

impl Patch {
    /// Coherence of its light at the vertex.
    #[inline]
    pub fn coherence(&self) -> Coherence {
        Coherence {
            angular_root: self.angular_root,
            distance: self.distance,
        }
    }
}

/// Which source is cut.
#[derive(Clone, Copy, Debug)]
enum Source<'a> {
    Flat(Outline),
    /// The cone around an axis, 1 − cos of its half angle; of a sphere, or of a source outside the scene.
    Cone {
        axis: Frame,
        cap: f32,
        sphere: Option<(&'a Sphere, f32)>,
    },
}

/// A source cut into patches for one vertex.
#[derive(Clone, Copy, Debug)]
pub struct Cut<'a> {
    from: Vec3A,
    source: Source<'a>,
    cells: Cells,
}

impl<'a> Cut<'a> {
    /// A flat source seen from `from`, in patches of at most the given half-width in radians. `None` from behind.
    pub fn flat(outline: Outline, from: Vec3A, largest: f32) -> Option<Self> {
        if outline.normal.dot(from - outline.centre) <= 0.0 {
            return None;
        }
        // the nearest point of the source is seen largest
        let mut near = outline.coordinates(from);
        near = if outline.round {
            near / near.length().max(1.0)
        } else {
            near.clamp(Vec2::NEG_ONE, Vec2::ONE)
        };
        let distance = (outline.at(near) - from).length();
        let widths = [outline.half_u, outline.half_v].map(|half| half.length() / distance);
        Some(Self {
            from,
            source: Source::Flat(outline),
            cells: Cells::of(outline.round, widths, largest),
        })
    }

    /// A sphere seen from outside.
    pub fn sphere(sphere: &'a Sphere, from: Vec3A, largest: f32) -> Option<Self> {
        let (axis, cap, distance) = sphere.cone(from)?;
        let mut cut = Self::cone(axis, cap, largest);
        cut.from = from;
        cut.source = Source::Cone {
            axis,
            cap,
            sphere: Some((sphere, distance)),
        };
        Some(cut)
    }

    /// All directions around the normal of `axis` within a half angle whose 1 − cos is `cap`.
    pub fn cone(axis: Frame, cap: f32, largest: f32) -> Self {
        Self {
            from: Vec3A::ZERO,
            source: Source::Cone {
                axis,
                cap,
                sphere: None,
            },
            cells: Cells::Disk {
                // the map from the disk is widest at the rim
                rings: pieces(cone_widths(cap, 1.0)[0], largest),
            },
        }
    }

    /// Number of patches.
    pub fn len(&self) -> u32 {
        self.cells.len()
    }

    /// Always false: there is at least one patch.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One of the patches.
    pub fn patch(&self, index: u32) -> Patch {
        let cell = self.cells.cell(index);
        match &self.source {
            Source::Flat(outline) => {
                let centre = outline.at(cell.mean);
                let to = centre - self.from;
                let distance = to.length();
                let direction = to / distance;
                let across = |root: Vec2| {
                    let v = outline.half_u * root.x + outline.half_v * root.y;
                    (v - direction * v.dot(direction)) / distance
                };
                let cos = -direction.dot(outline.normal);
                Patch {
                    direction,
                    centre,
                    distance,
                    angular_root: cell.root.map(across),
                    solid_angle: outline.area() * cell.share * cos.max(0.0) / (distance * distance),
                }
            }
            Source::Cone { axis, cap, sphere } => {
                let direction = cone_direction(axis, *cap, cell.mean);
                let [along, around] = cone_widths(*cap, cell.mean.length_squared());
                let outward = cell.mean.normalize_or(Vec2::X);
                let tangent = axis.to_world(vec2(-outward.y, outward.x).extend(0.0).into());
                let meridian = tangent.cross(direction);
                let across = |root: Vec2| {
                    meridian * (root.dot(outward) * along)
                        + tangent * (outward.perp_dot(root) * around)
                };
                let distance = sphere.map_or(f32::INFINITY, |(_, distance)| distance);
                Patch {
                    direction,
                    centre: match sphere {
                        Some((_, distance)) => self.from + direction * *distance,
                        None => Vec3A::ZERO,
                    },
                    distance,
                    angular_root: cell.root.map(across),
                    solid_angle: TAU * cap * cell.share,
                }
            }
        }
    }

    /// A random point of a patch: the direction of a shadow ray and its end.
    pub fn point(&self, index: u32, u: [f32; 2]) -> Option<(Vec3A, Option<Target>)> {
        let at = self.cells.point(index, u);
        match &self.source {
            Source::Flat(outline) => {
                let position = outline.at(at);
                Some((
                    (position - self.from).normalize(),
                    Some(Target {
                        position,
                        error: outline.error,
                        normal: outline.normal,
                    }),
                ))
            }
            Source::Cone { axis, cap, sphere } => {
                let direction = cone_direction(axis, *cap, at);
                let Some((sphere, _)) = sphere else {
                    return Some((direction, None));
                };
                Some((direction, Some(sphere.nearest_along(self.from, direction))))
            }
        }
    }

    /// The patch that a ray has hit, by the point and the ray's direction.
    pub fn find(&self, position: Vec3A, direction: Vec3A) -> u32 {
        self.cells.find(match &self.source {
            Source::Flat(outline) => outline.coordinates(position),
            Source::Cone { axis, cap, .. } => {
                let local = axis.to_local(direction);
                let across = vec2(local.x, local.y);
                let sin2 = across.length_squared();
                // 1 − cos without cancellation
                let rise = sin2 / (1.0 + local.z.max(0.0));
                across.normalize_or_zero() * (rise / cap).min(1.0).sqrt()
            }
        })
    }
}

/// How many radians the unit of the disk spans in [`cone_direction`], along the meridian and around the axis, at a
/// given squared distance from the centre.
fn cone_widths(cap: f32, squared: f32) -> [f32; 2] {
    let rest = 2.0 - cap * squared;
    [2.0 * (cap / rest).sqrt(), (cap * rest).sqrt()]
}

/// The direction at a point of the unit disk, which maps to the cone with equal areas.
pub(super) fn cone_direction(axis: &Frame, cap: f32, at: Vec2) -> Vec3A {
    let rise = cap * at.length_squared();
    let sin = (rise * (2.0 - rise)).max(0.0).sqrt();
    let across = at.normalize_or_zero() * sin;
    axis.to_world(Vec3A::new(across.x, across.y, 1.0 - rise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::SampleStream;

    fn cut(round: bool, largest: f32) -> Cut<'static> {
        let outline = Outline {
            centre: Vec3A::new(0.1, 0.2, 2.0),
            half_u: Vec3A::new(0.3, 0.0, 0.1),
            half_v: Vec3A::new(0.0, 0.2, 0.0),
            normal: Vec3A::new(0.1, 0.0, -0.3).normalize(),
            round,
            error: Vec3A::ZERO,
        };
        Cut::flat(outline, Vec3A::ZERO, largest).expect("seen from the front")
    }

    /// Mean and covariance of directions of a patch from its random points, and whether `find` knows them.
    fn sampled(cut: &Cut<'_>, index: u32, samples: u64) -> (Vec3A, [[f64; 3]; 3]) {
        let mut mean = [0.0f64; 3];
        let mut square = [[0.0f64; 3]; 3];
        let mut strays = 0;
        for sample in 0..samples {
            let u = SampleStream::new(7, u64::from(index), sample).pair(0);
            let (direction, target) = cut.point(index, u).expect("a point");
            let position = target.map_or(Vec3A::ZERO, |t| t.position);
            strays += u64::from(cut.find(position, direction) != index);
            let d = direction.as_dvec3().to_array();
            for a in 0..3 {
                mean[a] += d[a] / samples as f64;
                for b in 0..3 {
                    square[a][b] += d[a] * d[b] / samples as f64;
                }
            }
        }
        // next to a border rounding may choose the neighbour
        assert!(strays * 5000 <= samples, "{strays} points in other patches");
        for a in 0..3 {
            for b in 0..3 {
                square[a][b] -= mean[a] * mean[b];
            }
        }
        (glam::DVec3::from(mean).as_vec3a(), square)
    }

    #[test]
    fn patches_have_the_moments_of_their_points() {
        let sphere = Sphere::new(
            glam::DVec3::new(0.5, -0.3, 3.0),
            0.4,
            &glam::DMat4::IDENTITY,
            false,
        )
        .expect("a sphere");
        let cuts = [
            cut(false, 1.0),
            cut(false, 0.03),
            cut(true, 1.0),
            cut(true, 0.03),
            Cut::sphere(&sphere, Vec3A::ZERO, 1.0).expect("from outside"),
            Cut::sphere(&sphere, Vec3A::ZERO, 0.03).expect("from outside"),
            Cut::cone(Frame::around(Vec3A::Y), 0.01, 0.04),
            // a wide one, whose patches are foreshortened
            Cut::cone(Frame::around(Vec3A::Y), 0.7, 0.04),
        ];
        for cut in &cuts {
            let samples = 40_000;
            for index in (0..cut.len()).step_by(7) {
                let patch = cut.patch(index);
                let (mean, covariance) = sampled(cut, index, samples);
                let root = patch.angular_root.map(|v| v.as_dvec3().to_array());
                let width2: f64 = root.iter().flatten().map(|x| x * x).sum();
                // five standard errors, and what is left out: the second order of the patch's width
                let noise = 5.0 / (samples as f64).sqrt();
                assert!(
                    f64::from((mean - patch.direction).length())
                        < noise * width2.sqrt() + 2.0 * width2,
                    "{cut:?} {index}: {mean} for {}",
                    patch.direction
                );
                for a in 0..3 {
                    for b in 0..3 {
                        let expected = root[0][a] * root[0][b] + root[1][a] * root[1][b];
                        assert!(
                            (covariance[a][b] - expected).abs()
                                < width2 * (noise * 1.5 + 2.0 * width2.sqrt()),
                            "{cut:?} {index} [{a}][{b}]: {} for {expected}",
                            covariance[a][b]
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn patches_fill_the_source() {
        for round in [false, true] {
            for largest in [1.0, 0.1, 0.02] {
                let cut = cut(round, largest);
                let sum: f64 = (0..cut.len())
                    .map(|i| f64::from(cut.cells.cell(i).share))
                    .sum();
                assert!((sum - 1.0).abs() < 1e-5, "{round} {largest}: {sum}");
            }
        }
        let cone = Cut::cone(Frame::around(Vec3A::Y), 0.01, 0.02);
        let sum: f32 = (0..cone.len()).map(|i| cone.patch(i).solid_angle).sum();
        assert!((sum / (TAU * 0.01) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn borders_and_points_just_beyond_belong_to_a_patch() {
        for round in [false, true] {
            for largest in [1.0, 0.1, 0.02, 0.0] {
                let cells = cut(round, largest).cells;
                let ends = [-1.000_001, -1.0, -0.5, 0.0, -0.0, 0.5, 1.0, 1.000_001];
                for (x, y) in ends.iter().flat_map(|x| ends.map(|y| (*x, y))) {
                    assert!(cells.find(vec2(x, y)) < cells.len(), "{cells:?} {x} {y}");
                }
                assert!(cells.find(Vec2::NAN) < cells.len());
                // from the inside a border belongs to its own cell, but for rounding
                for index in (0..cells.len()).step_by(1 + cells.len() as usize / 50) {
                    for u in [[0.01, 0.5], [0.99, 0.5], [0.5, 0.01], [0.5, 0.99]] {
                        assert_eq!(cells.find(cells.point(index, u)), index, "{cells:?} {u:?}");
                    }
                }
            }
        }
    }
}
