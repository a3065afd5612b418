//! Light sources for vertices side by side: one source, a vertex a lane.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::area::Area;
use super::{Colour, Emitter, Kind};
use crate::geometry::frame::Frame;
use crate::lanes::{Axes, MOST, Mask, Real, V3, each, part};
use crate::light::abreast::{Abreast, Shine};
use crate::light::{Emission, Polarized};
use crate::material::abreast::{cosine_hemispheres, values};
use crate::scene::{Body, Scene};
use crate::shape::abreast::{AreaSamples, Surfaces};
use crate::shape::{Shape, Surface};

/// A [`Connection`](super::Connection) a lane.
#[derive(Clone, Copy, Debug)]
pub struct Connections<R: Real> {
    /// Where there is one.
    pub exist: R::M,
    /// Unit direction toward the source.
    pub direction: V3<R>,
    /// Where the source is.
    pub position: V3<R>,
    /// Half-widths of the box that contains the true point.
    pub error: V3<R>,
    /// Normal of the source; zero for points.
    pub normal: V3<R>,
    /// Where the source is not infinitely far.
    pub near: R::M,
    /// Density per steradian.
    pub density: R,
    /// Where no other way to sample it exists.
    pub discrete: R::M,
    /// Factor on the emission.
    pub weight: R,
}

impl<R: Real> Connections<R> {
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: &Self, b: &Self) -> Self {
        let elsewhere = !mask;
        Self {
            exist: (a.exist & mask) | (b.exist & elsewhere),
            direction: V3::select(mask, a.direction, b.direction),
            position: V3::select(mask, a.position, b.position),
            error: V3::select(mask, a.error, b.error),
            normal: V3::select(mask, a.normal, b.normal),
            near: (a.near & mask) | (b.near & elsewhere),
            density: R::select(mask, a.density, b.density),
            discrete: (a.discrete & mask) | (b.discrete & elsewhere),
            weight: R::select(mask, a.weight, b.weight),
        }
    }
}

/// Shapes that answer all lanes at once.
enum Side<'a> {
    Rectangle(&'a crate::shape::rectangle::Rectangle),
    Sphere(&'a crate::shape::sphere::Sphere),
}

impl Area {
    #[inline(always)]
    fn side<'a>(&self, scene: &'a Scene) -> Option<Side<'a>> {
        let Body::Shape(index) = self.body else {
            return None;
        };
        match &scene.shapes[index as usize] {
            Shape::Rectangle(s) => Some(Side::Rectangle(s)),
            Shape::Sphere(s) => Some(Side::Sphere(s)),
            _ => None,
        }
    }
}

part!(EachConnection<'a; R>(emitter: &'a Emitter, scene: &'a Scene, from: V3<R>, lit: &'a Axes<R>, u: [R; 2],
    lanes: R::M) -> Connections<R>: Emitter::each_connection);
part!(EachShine<'a; R, L: Abreast>(emitter: &'a Emitter, k: V3<R>, from: V3<R>, wavelengths: &'a L::Values<R>,
    lanes: R::M) -> Shine<L::Values<R>, R>: Emitter::each_shine::<R, L>);

impl Emitter {
    /// Draws ways from vertices to the source; the normals of `lit` are on the side from which they can be lit.
    #[inline(always)]
    pub fn connections<R: Real>(
        &self,
        scene: &Scene,
        from: V3<R>,
        lit: &Axes<R>,
        u: [R; 2],
        lanes: R::M,
    ) -> Connections<R> {
        let samples = match &self.kind {
            Kind::Constant(_) => {
                let local = cosine_hemispheres(u);
                let density = local.z * R::splat(FRAC_1_PI);
                return Connections {
                    exist: density.gt(R::zero()),
                    direction: lit.to_world(local),
                    position: from,
                    error: V3::splat(Vec3A::ZERO),
                    normal: V3::splat(Vec3A::ZERO),
                    near: R::nowhere(),
                    density,
                    discrete: R::nowhere(),
                    weight: R::one(),
                };
            }
            Kind::Area(area) => match area.side(scene) {
                Some(Side::Rectangle(s)) => s.samples(from, u),
                Some(Side::Sphere(s)) => s.samples(from, u),
                None => return self.connections_one_by_one(scene, from, lit, u, lanes),
            },
            _ => return self.connections_one_by_one(scene, from, lit, u, lanes),
        };
        let AreaSamples {
            exist,
            position,
            error,
            normal,
            pdf,
        } = samples;
        let to = position - from;
        let direction = to * to.squared().sqrt().recip();
        Connections {
            exist: exist & direction.dot(normal).lt(R::zero()),
            direction,
            position,
            error,
            normal,
            near: R::everywhere(),
            density: pdf,
            discrete: R::nowhere(),
            weight: R::one(),
        }
    }

    #[inline(always)]
    fn connections_one_by_one<R: Real>(
        &self,
        scene: &Scene,
        from: V3<R>,
        lit: &Axes<R>,
        u: [R; 2],
        lanes: R::M,
    ) -> Connections<R> {
        R::apart(EachConnection {
            emitter: self,
            scene,
            from,
            lit,
            u,
            lanes,
        })
    }

    #[inline(always)]
    fn each_connection<R: Real>(
        &self,
        scene: &Scene,
        from: V3<R>,
        lit: &Axes<R>,
        [u, v]: [R; 2],
        lanes: R::M,
    ) -> Connections<R> {
        let (from, u, v) = (from.lanes(), u.lanes(), v.lanes());
        let axes = [lit.s.lanes(), lit.t.lanes(), lit.n.lanes()];
        let (mut exist, mut near, mut discrete) = (0, 0, 0);
        // direction, position, error, normal
        let mut vectors = [[Vec3A::ZERO; MOST]; 4];
        let (mut density, mut weight) = ([1.0; MOST], [1.0; MOST]);
        each(lanes.bits(), |lane| {
            let frame = Frame {
                s: axes[0][lane],
                t: axes[1][lane],
                n: axes[2][lane],
            };
            let u = [u[lane], v[lane]];
            let Some(way) = self.connect(scene, from[lane], &frame, u) else {
                return;
            };
            exist |= 1 << lane;
            discrete |= u32::from(way.discrete) << lane;
            vectors[0][lane] = way.direction;
            if let Some(target) = way.target {
                near |= 1 << lane;
                vectors[1][lane] = target.position;
                vectors[2][lane] = target.error;
                vectors[3][lane] = target.normal;
            }
            density[lane] = way.density;
            weight[lane] = way.weight;
        });
        let [direction, position, error, normal] = &vectors;
        Connections {
            exist: R::M::from_bits(exist),
            direction: V3::from_lanes(direction),
            position: V3::from_lanes(position),
            error: V3::from_lanes(error),
            normal: V3::from_lanes(normal),
            near: R::M::from_bits(near),
            density: R::from_fn(|lane| density[lane]),
            discrete: R::M::from_bits(discrete),
            weight: R::from_fn(|lane| weight[lane]),
        }
    }

    /// Densities of [`Emitter::connections`] for surface points that rays from `from` have hit.
    #[inline(always)]
    pub fn densities_of_hits<R: Real>(
        &self,
        scene: &Scene,
        from: V3<R>,
        at: &Surfaces<R>,
        lanes: R::M,
    ) -> R {
        if let Kind::Area(area) = &self.kind {
            match area.side(scene) {
                Some(Side::Rectangle(s)) => return s.densities(from, at),
                Some(Side::Sphere(s)) => return s.densities(from, at),
                None => {}
            }
        }
        let mut densities = [0.0; MOST];
        let (position, error) = (at.position.lanes(), at.error.lanes());
        let (normal, from) = (at.normal.lanes(), from.lanes());
        each(lanes.bits(), |lane| {
            let surface = Surface {
                position: position[lane],
                error: error[lane],
                normal: normal[lane],
                frame: Frame::around(normal[lane]),
            };
            densities[lane] = self.density_of_hit(scene, from[lane], &surface);
        });
        R::from_fn(|lane| densities[lane])
    }

    /// Densities of [`Emitter::connections`] for directions in which nothing was hit, from a vertex with that normal.
    #[inline(always)]
    pub fn densities_of_misses<R: Real>(&self, normal: V3<R>, direction: V3<R>, lanes: R::M) -> R {
        if let Kind::Constant(_) = &self.kind {
            return normal.dot(direction).max(R::zero()) * R::splat(FRAC_1_PI);
        }
        let mut densities = [0.0; MOST];
        let (normal, direction) = (normal.lanes(), direction.lanes());
        each(lanes.bits(), |lane| {
            let frame = Frame::around(normal[lane]);
            densities[lane] = self.density_of_miss(&frame, direction[lane]);
        });
        R::from_fn(|lane| densities[lane])
    }

    /// The light that it sends along `k` from points on it.
    #[inline(always)]
    pub fn shine<R: Real, L: Abreast>(
        &self,
        k: V3<R>,
        from: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> Shine<L::Values<R>, R> {
        let Colour::Spectrum(spectrum, scale) = self.colour() else {
            return self.shine_one_by_one::<R, L>(k, from, wavelengths, lanes);
        };
        let mut radiance = *wavelengths;
        for value in radiance.as_mut() {
            *value = values(spectrum, *value) * R::splat(scale);
        }
        let state = match &self.polarization {
            Some(p) if L::POLARIZED => {
                let k = k.lanes();
                let axis = V3::from_fn(|lane| p.axis_across(k[lane]));
                let [a, b, c] = p.state.to_array();
                let state = [
                    L::values(R::splat(a)),
                    L::values(R::splat(b)),
                    L::values(R::splat(c)),
                ];
                Some((axis, state))
            }
            _ => None,
        };
        Shine { radiance, state }
    }

    #[inline(always)]
    fn shine_one_by_one<R: Real, L: Abreast>(
        &self,
        k: V3<R>,
        from: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> Shine<L::Values<R>, R> {
        R::apart(EachShine::<R, L> {
            emitter: self,
            k,
            from,
            wavelengths,
            lanes,
        })
    }

    #[inline(always)]
    fn each_shine<R: Real, L: Abreast>(
        &self,
        k: V3<R>,
        from: V3<R>,
        wavelengths: &L::Values<R>,
        lanes: R::M,
    ) -> Shine<L::Values<R>, R> {
        let mut axes = [Vec3A::X; MOST];
        let mut numbers = [[[0.0; MOST]; 4]; 4];
        let mut polarized = false;
        let mut waves = [[0.0; MOST]; 4];
        for (to, wave) in waves.iter_mut().zip(wavelengths.as_ref()) {
            *to = wave.lanes();
        }
        let (k, from) = (k.lanes(), from.lanes());
        each(lanes.bits(), |lane| {
            axes[lane] = Frame::around(k[lane]).s;
            for (w, wavelength) in waves.iter().enumerate().take(L::LANES) {
                let emission: Emission<Polarized<1>> =
                    self.emit(k[lane], from[lane], &[wavelength[lane]]);
                numbers[0][w][lane] = emission.radiance[0];
                if let Some((axis, [state])) = emission.state {
                    axes[lane] = axis;
                    polarized = true;
                    for (to, s) in numbers[1..].iter_mut().zip(state.to_array()) {
                        to[w][lane] = s;
                    }
                }
            }
        });
        let mut all = [L::values(R::zero()); 4];
        for (to, from) in all.iter_mut().zip(&numbers) {
            for (value, from) in to.as_mut().iter_mut().zip(from) {
                *value = R::from_fn(|lane| from[lane]);
            }
        }
        let [radiance, a, b, c] = all;
        let state = if L::POLARIZED && polarized {
            Some((V3::from_lanes(&axes), [a, b, c]))
        } else {
            None
        };
        Shine { radiance, state }
    }
}
