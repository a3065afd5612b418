//! Light sources for vertices side by side: one source, a vertex a lane.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::area::Area;
use super::{Connection, Emitter, Kind};
use crate::geometry::frame::Frame;
use crate::lanes::{Axes, MOST, Mask, Real, V3, each};
use crate::light::abreast::{Abreast, Shine};
use crate::light::{Emission, Polarized};
use crate::material::abreast::{cosine_hemispheres, values};
use crate::scene::{Body, Scene};
use crate::shape::abreast::{AreaSamples, Surfaces};
use crate::shape::{Shape, Surface};

/// A [`Connection`] a lane.
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
        [u, v]: [R; 2],
        lanes: R::M,
    ) -> Connections<R> {
        let mut found = [None::<Connection>; MOST];
        let bits = |f: &dyn Fn(&Connection) -> bool, found: &[Option<Connection>; MOST]| {
            let mut bits = 0;
            for (lane, connection) in found.iter().enumerate() {
                bits |= u32::from(connection.as_ref().is_some_and(f)) << lane;
            }
            R::M::from_bits(bits)
        };
        each(lanes.bits(), |lane| {
            let frame = Frame {
                s: lit.s.lane(lane),
                t: lit.t.lane(lane),
                n: lit.n.lane(lane),
            };
            let u = [u.lane(lane), v.lane(lane)];
            found[lane] = self.connect(scene, from.lane(lane), &frame, u);
        });
        let number =
            |f: fn(&Connection) -> f32| R::from_fn(|lane| found[lane].as_ref().map_or(1.0, f));
        let target = |f: fn(&super::Target) -> Vec3A| {
            V3::from_fn(|lane| {
                let target = found[lane].and_then(|c| c.target);
                target.as_ref().map_or(Vec3A::ZERO, f)
            })
        };
        Connections {
            exist: bits(&|_| true, &found),
            direction: V3::from_fn(|lane| found[lane].map_or(Vec3A::Z, |c| c.direction)),
            position: target(|t| t.position),
            error: target(|t| t.error),
            normal: target(|t| t.normal),
            near: bits(&|c| c.target.is_some(), &found),
            density: number(|c| c.density),
            discrete: bits(&|c| c.discrete, &found),
            weight: number(|c| c.weight),
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
        each(lanes.bits(), |lane| {
            let surface = Surface {
                position: at.position.lane(lane),
                error: at.error.lane(lane),
                normal: at.normal.lane(lane),
                frame: Frame::around(at.normal.lane(lane)),
            };
            densities[lane] = self.density_of_hit(scene, from.lane(lane), &surface);
        });
        R::from_fn(|lane| densities[lane])
    }

    /// Densities of [`Emitter::connections`] for directions in which nothing was hit, from a vertex with that normal.
    #[inline(always)]
    pub fn densities_of_misses<R: Real>(
        &self,
        normal: V3<R>,
        direction: V3<R>,
        lanes: R::M,
    ) -> R {
        if let Kind::Constant(_) = &self.kind {
            return normal.dot(direction).max(R::zero()) * R::splat(FRAC_1_PI);
        }
        let mut densities = [0.0; MOST];
        each(lanes.bits(), |lane| {
            let frame = Frame::around(normal.lane(lane));
            densities[lane] = self.density_of_miss(&frame, direction.lane(lane));
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
        let (spectrum, scale) = match &self.kind {
            Kind::Area(e) => (&e.radiance, 1.0),
            Kind::Constant(e) => (&e.radiance, 1.0),
            Kind::Point(e) => (&e.intensity, 1.0),
            Kind::Spot(e) => (&e.intensity, 1.0),
            Kind::Directional(e) => (&e.irradiance, e.scale),
            Kind::Laser(e) => (&e.power, 1.0),
            Kind::Schell(_) | Kind::RayleighSky(_) => {
                return self.shine_one_by_one::<R, L>(k, from, wavelengths, lanes);
            }
        };
        let waves = wavelengths.as_ref();
        let radiance = L::values(|w| values(spectrum, waves[w]) * R::splat(scale));
        let state = self.polarization.as_ref().filter(|_| L::POLARIZED).map(|p| {
            let axis = V3::from_fn(|lane| p.axis_across(k.lane(lane)));
            let state = p.state.to_array().map(|s| L::values(|_| R::splat(s)));
            (axis, state)
        });
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
        let mut axes = [Vec3A::X; MOST];
        let mut numbers = [[[0.0; MOST]; 4]; 4];
        let mut polarized = false;
        each(lanes.bits(), |lane| {
            let (k, from) = (k.lane(lane), from.lane(lane));
            axes[lane] = Frame::around(k).s;
            for (w, wavelength) in wavelengths.as_ref().iter().enumerate() {
                let emission: Emission<Polarized<1>> =
                    self.emit(k, from, &[wavelength.lane(lane)]);
                numbers[w][0][lane] = emission.radiance[0];
                if let Some((axis, [state])) = emission.state {
                    axes[lane] = axis;
                    polarized = true;
                    for (to, s) in numbers[w][1..].iter_mut().zip(state.to_array()) {
                        to[lane] = s;
                    }
                }
            }
        });
        let of = |which: usize| L::values(|w| R::from_fn(|lane| numbers[w][which][lane]));
        Shine {
            radiance: of(0),
            state: (L::POLARIZED && polarized)
                .then(|| (V3::from_fn(|lane| axes[lane]), [of(1), of(2), of(3)])),
        }
    }
}
