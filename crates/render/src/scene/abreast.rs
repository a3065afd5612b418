//! What rays side by side find in a scene.
//!
//! In scenes of few shapes every ray is tested against all of them, a shape at a time; elsewhere each ray goes down the
//! search tree by itself.

use glam::Vec3A;

use super::world::Scene;
use crate::geometry::bvh::Stack;
use crate::lanes::{Axes, Bits, MOST, Mask, Real, V3, each, part};
use crate::shape::Shape;
use crate::shape::abreast::{Hits, Rays, Shears, Surfaces};

/// No emitter.
const NONE: u32 = u32::MAX;

/// As many shapes are tested one by one.
pub(super) const FEW: usize = 24;

/// Shapes with a smaller share of the surface of the box around all have their own box tested first. About that share of
/// scattered rays meets it: of eight at once, all miss it in four cases of ten and more, and the box has some thirty
/// operations to the rectangle's ninety.
const SMALL: f32 = 0.1;

/// Boxes around those shapes for which it pays to test them first.
pub(super) fn boxes(shapes: &[Shape]) -> Vec<Option<[Vec3A; 2]>> {
    let bounds: Vec<[Vec3A; 2]> = shapes
        .iter()
        .map(|shape| {
            let bounds = shape.bounds();
            [bounds.min, bounds.max]
        })
        .collect();
    let area = |[min, max]: [Vec3A; 2]| {
        let size = max - min;
        size.x * size.y + size.y * size.z + size.z * size.x
    };
    let all = bounds
        .iter()
        .copied()
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        .map_or(0.0, area);
    let small = |bounds: &[Vec3A; 2]| area(*bounds) < SMALL * all;
    bounds
        .into_iter()
        .map(|bounds| Some(bounds).filter(small))
        .collect()
}

/// What rays contribute to tests against boxes: the inverse of their directions, finite.
struct Slabs<R> {
    origin: V3<R>,
    inverse: V3<R>,
}

/// So much farther a box may end: what rounding can make of a distance, three times over.
///
/// Source: Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013.
const FARTHER: f32 = 1.0 + 6.0 * f32::EPSILON;

impl<R: Real> Slabs<R> {
    #[inline(always)]
    fn new(rays: &Rays<R>) -> Self {
        let mut inverse = rays.direction;
        for d in [&mut inverse.x, &mut inverse.y, &mut inverse.z] {
            *d = d.abs().max(R::splat(1e-20)).copysign(*d).recip();
        }
        Self {
            origin: rays.origin,
            inverse,
        }
    }

    /// Whether any of the rays may meet a box closer than `t_max`.
    #[inline(always)]
    fn may_meet(&self, [min, max]: [Vec3A; 2], t_max: R, lanes: R::M) -> bool {
        let (low, high) = (V3::splat(min) - self.origin, V3::splat(max) - self.origin);
        let inverse = self.inverse;
        let (x, x2) = (low.x * inverse.x, high.x * inverse.x);
        let (y, y2) = (low.y * inverse.y, high.y * inverse.y);
        let (z, z2) = (low.z * inverse.z, high.z * inverse.z);
        let near = x.min(x2).max(y.min(y2)).max(z.min(z2));
        let far = x.max(x2).min(y.max(y2)).min(z.max(z2));
        let end = far.min(t_max) * R::splat(FARTHER);
        (near.le(end) & lanes).any()
    }
}

/// Surfaces that rays have met.
#[derive(Clone, Copy, Debug)]
pub struct Encounters<R: Real> {
    /// Where there is one.
    pub exist: R::M,
    /// Where.
    pub surfaces: Surfaces<R>,
    /// Index of the matter.
    pub materials: R::B,
    /// Index of the emitter, for those that [shine](Self::shine).
    pub emitters: R::B,
}

impl<R: Real> Encounters<R> {
    /// Where the surface belongs to an emitter.
    #[inline(always)]
    pub fn shine(&self) -> R::M {
        !R::same(self.emitters, R::B::splat(NONE))
    }
}

/// Lanes with the same number, one number after the other.
pub struct Groups<R: Real> {
    numbers: R::B,
    each: [u32; MOST],
    rest: u32,
}

/// The groups of some lanes.
#[inline(always)]
pub fn groups<R: Real>(numbers: R::B, lanes: R::M) -> Groups<R> {
    Groups {
        numbers,
        each: numbers.lanes(),
        rest: lanes.bits(),
    }
}

impl<R: Real> Iterator for Groups<R> {
    type Item = (u32, R::M);

    #[inline(always)]
    fn next(&mut self) -> Option<(u32, R::M)> {
        if self.rest == 0 {
            return None;
        }
        let number = self.each[self.rest.trailing_zeros() as usize % MOST];
        let same = R::same(self.numbers, R::B::splat(number)).bits();
        let group = same & self.rest;
        self.rest &= !group;
        Some((number, R::M::from_bits(group)))
    }
}

part!(Meet<'a; R>(scene: &'a Scene, rays: &'a Rays<R>, lanes: R::M, stack: &'a mut Stack)
    -> Encounters<R>: Scene::nearest);
part!(Free<'a; R>(scene: &'a Scene, rays: &'a Rays<R>, lanes: R::M, stack: &'a mut Stack)
    -> R::M: Scene::unblocked);

/// Position, error, normal and frame, one by one.
#[inline(always)]
fn gathered<R: Real>(vectors: &[[Vec3A; MOST]; 6]) -> Surfaces<R> {
    let [position, error, normal, s, t, n] = vectors;
    Surfaces {
        position: V3::from_lanes(position),
        error: V3::from_lanes(error),
        normal: V3::from_lanes(normal),
        axes: Axes {
            s: V3::from_lanes(s),
            t: V3::from_lanes(t),
            n: V3::from_lanes(n),
        },
    }
}

impl Scene {
    /// The nearest surfaces along rays.
    #[inline(always)]
    pub fn meet<R: Real>(&self, rays: &Rays<R>, lanes: R::M, stack: &mut Stack) -> Encounters<R> {
        R::apart(Meet {
            scene: self,
            rays,
            lanes,
            stack,
        })
    }

    #[inline(always)]
    fn nearest<R: Real>(&self, rays: &Rays<R>, lanes: R::M, stack: &mut Stack) -> Encounters<R> {
        if self.few {
            return self.meet_few(rays, lanes);
        }
        let mut exist = 0;
        let mut materials = [0; MOST];
        let mut emitters = [NONE; MOST];
        let mut vectors = [[Vec3A::Z; MOST]; 6];
        let rays = rays.lanes();
        each(lanes.bits(), |lane| {
            if let Some(met) = self.intersect(&rays[lane], stack) {
                exist |= 1 << lane;
                materials[lane] = met.owner.material;
                emitters[lane] = met.owner.emitter.unwrap_or(NONE);
                let s = &met.surface;
                let all = [
                    s.position, s.error, s.normal, s.frame.s, s.frame.t, s.frame.n,
                ];
                for (to, v) in vectors.iter_mut().zip(all) {
                    to[lane] = v;
                }
            }
        });
        Encounters {
            exist: R::M::from_bits(exist),
            surfaces: gathered(&vectors),
            materials: R::B::from_fn(|lane| materials[lane]),
            emitters: R::B::from_fn(|lane| emitters[lane]),
        }
    }

    /// Where nothing stands in the way of rays.
    #[inline(always)]
    pub fn free<R: Real>(&self, rays: &Rays<R>, lanes: R::M, stack: &mut Stack) -> R::M {
        R::apart(Free {
            scene: self,
            rays,
            lanes,
            stack,
        })
    }

    #[inline(always)]
    fn unblocked<R: Real>(&self, rays: &Rays<R>, lanes: R::M, stack: &mut Stack) -> R::M {
        if self.few {
            let (shears, slabs) = (Shears::new(rays), Slabs::new(rays));
            let mut free = lanes;
            for (shape, bounds) in self.shapes.iter().zip(&self.boxes) {
                if let Some(bounds) = bounds
                    && !slabs.may_meet(*bounds, rays.t_max, free)
                {
                    continue;
                }
                let hits = self.hits(shape, rays, &shears, rays.t_max, free);
                free = free & !hits.exist;
                if !free.any() {
                    break;
                }
            }
            return free;
        }
        let mut free = 0;
        let rays = rays.lanes();
        each(lanes.bits(), |lane| {
            free |= u32::from(self.is_free(&rays[lane], stack)) << lane;
        });
        R::M::from_bits(free)
    }

    #[inline(always)]
    fn hits<R: Real>(
        &self,
        shape: &Shape,
        rays: &Rays<R>,
        shears: &Shears<R>,
        t_max: R,
        lanes: R::M,
    ) -> Hits<R> {
        match shape {
            Shape::Rectangle(s) => shears.meet(s.corners(), t_max),
            Shape::Sphere(s) => s.meet(rays, t_max),
            Shape::Cube(s) => s.meet(rays, t_max),
            _ => {
                let mut found = [Vec3A::ZERO; MOST];
                let mut exist = 0;
                let (rays, t_max) = (rays.lanes(), t_max.lanes());
                each(lanes.bits(), |lane| {
                    if let Some(hit) = shape.intersect(&rays[lane], t_max[lane]) {
                        exist |= 1 << lane;
                        found[lane] = hit;
                    }
                });
                Hits {
                    exist: R::M::from_bits(exist),
                    t: R::from_fn(|lane| found[lane].x),
                    u: R::from_fn(|lane| found[lane].y),
                    v: R::from_fn(|lane| found[lane].z),
                }
            }
        }
    }

    #[inline(always)]
    fn meet_few<R: Real>(&self, rays: &Rays<R>, lanes: R::M) -> Encounters<R> {
        let (shears, slabs) = (Shears::new(rays), Slabs::new(rays));
        let mut t = rays.t_max;
        let (mut u, mut v) = (R::zero(), R::zero());
        let mut exist = R::nowhere();
        let mut numbers = R::B::splat(0);
        for (number, (shape, bounds)) in self.shapes.iter().zip(&self.boxes).enumerate() {
            if let Some(bounds) = bounds
                && !slabs.may_meet(*bounds, t, lanes)
            {
                continue;
            }
            let hits = self.hits(shape, rays, &shears, t, lanes);
            let nearer = hits.exist & lanes;
            if !nearer.any() {
                continue;
            }
            exist = exist | nearer;
            t = R::select(nearer, hits.t, t);
            u = R::select(nearer, hits.u, u);
            v = R::select(nearer, hits.v, v);
            numbers = R::select_bits(nearer, R::B::splat(number as u32), numbers);
        }
        let nothing = V3::splat(Vec3A::ZERO);
        let mut surfaces = Surfaces {
            position: nothing,
            error: nothing,
            normal: nothing,
            axes: Axes {
                s: nothing,
                t: nothing,
                n: nothing,
            },
        };
        let mut materials = R::B::splat(0);
        let mut emitters = R::B::splat(NONE);
        for (number, mask) in groups::<R>(numbers, exist) {
            let found = match &self.shapes[number as usize] {
                Shape::Rectangle(s) => s.surfaces(u, v),
                Shape::Sphere(s) => s.surfaces(rays, t),
                Shape::Cube(s) => s.surfaces(rays, t, u),
                shape => {
                    let mut vectors = [[Vec3A::Z; MOST]; 6];
                    let (rays, t, u, v) = (rays.lanes(), t.lanes(), u.lanes(), v.lanes());
                    each(mask.bits(), |lane| {
                        let s = shape.surface(&rays[lane], (t[lane], u[lane], v[lane]));
                        let all = [
                            s.position, s.error, s.normal, s.frame.s, s.frame.t, s.frame.n,
                        ];
                        for (to, v) in vectors.iter_mut().zip(all) {
                            to[lane] = v;
                        }
                    });
                    gathered(&vectors)
                }
            };
            surfaces = Surfaces::select(mask, &found, &surfaces);
            let owner = &self.shape_owners[number as usize];
            materials = R::select_bits(mask, R::B::splat(owner.material), materials);
            let emitter = R::B::splat(owner.emitter.unwrap_or(NONE));
            emitters = R::select_bits(mask, emitter, emitters);
        }
        Encounters {
            exist,
            surfaces,
            materials,
            emitters,
        }
    }
}
