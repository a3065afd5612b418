//! The light that paths side by side find: of sources that they meet, and of those that they look for.

use glam::Vec3A;

use super::waiting::{DENSITY, DEPARTURE, LAST, LIT, Paths, SAMPLE, THROUGHPUT, WEIGHED};
use super::{Link, count, side};
use crate::emitter::abreast::Connections;
use crate::lanes::{Axes, Bits, Columns, Mask, Real, V3, each, part};
use crate::light::abreast::{Abreast, Shine, Sights};
use crate::material::Material;
use crate::material::abreast::Vertices;
use crate::scene::Scene;
use crate::scene::abreast::{Encounters, groups};
use crate::shape::abreast::{Rays, Surfaces, offset_origins};

#[inline(always)]
fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let ratio = other / own;
    (R::one() + ratio * ratio).recip()
}

/// `a` where the mask holds, elsewhere `b`; `k` is the direction of the light.
#[inline(always)]
fn either<R: Real, L: Abreast>(
    mask: R::M,
    a: &Shine<L::Values<R>, R>,
    b: &Shine<L::Values<R>, R>,
    k: V3<R>,
) -> Shine<L::Values<R>, R> {
    let radiance = select::<R, L>(mask, &a.radiance, &b.radiance);
    let none = (Axes::around(k).s, [L::values(R::zero()); 3]);
    let ((axis_a, a), (axis_b, b)) = match (a.state, b.state) {
        (None, None) => {
            return Shine {
                radiance,
                state: None,
            };
        }
        (Some(a), None) => (a, none),
        (None, Some(b)) => (none, b),
        (Some(a), Some(b)) => (a, b),
    };
    let states = [
        select::<R, L>(mask, &a[0], &b[0]),
        select::<R, L>(mask, &a[1], &b[1]),
        select::<R, L>(mask, &a[2], &b[2]),
    ];
    Shine {
        radiance,
        state: Some((V3::select(mask, axis_a, axis_b), states)),
    }
}

/// `a` where the mask holds, elsewhere `b`.
#[inline(always)]
fn select<R: Real, L: Abreast>(mask: R::M, a: &L::Values<R>, b: &L::Values<R>) -> L::Values<R> {
    let mut chosen = *b;
    for (to, a) in chosen.as_mut().iter_mut().zip(a.as_ref()) {
        *to = R::select(mask, *a, *to);
    }
    chosen
}

/// Light that vertices look for.
pub(super) struct Looked<R: Real, V> {
    connections: Connections<R>,
    /// Density of the connection, the choice of its source included.
    density: R,
    shine: Shine<V, R>,
}

part!(AddSources<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, place: (usize, Columns<R>),
    rays: &'a Rays<R>, met: &'a Encounters<R>, numbers: R::B, sources: R::M) -> (): Link::<L::Stokes>::add_sources::<R, L>);
part!(PassOn<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, from: &'a Surfaces<R>,
    connections: &'a Connections<R>, wavelengths: &'a L::Values<R>, through: &'a mut L::Throughputs<R>, room: u32,
    lanes: R::M) -> R::M: Link::<L::Stokes>::pass_on::<R, L>);

impl<S> Link<'_, S> {
    /// Adds the light of sources that vertices have looked for.
    #[inline(always)]
    pub(super) fn connect<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        (paths, material, at, wavelengths): (&Paths<R>, &Material, &Vertices<R>, &L::Values<R>),
        throughput: &L::Throughputs<R>,
        surfaces: &Surfaces<R>,
        looked: &Looked<R, L::Values<R>>,
        lanes: R::M,
    ) {
        let scene = self.scene;
        let found = &looked.connections;
        let ask = lanes & found.exist;
        if !ask.any() {
            return;
        }
        let i = at.axes.to_local(found.direction);
        // answers are large, and stay where they are
        let mut answered = material.answer::<R, L>(at, i, wavelengths, ask);
        let own = answered.1;
        let lit = ask & own.gt(R::zero());
        if !lit.any() {
            return;
        }
        let answers = &mut answered.0;
        L::to_world(answers, &at.axes);
        let share = power_heuristic(looked.density, own);
        let share = R::select(found.discrete, R::one(), share);
        let weight = share * found.weight / looked.density;
        let (o, k) = (-paths.rays.direction, -found.direction);
        if scene.traits().straight {
            let mut through = L::extended(throughput, answers, weight, o);
            let room = self.options.max_depth - self.depth - 1;
            let free = R::apart(PassOn::<R, L> {
                link: &mut *self,
                from: surfaces,
                connections: found,
                wavelengths,
                through: &mut through,
                room,
                lanes: lit,
            });
            let more = L::seen(&through, &looked.shine, k, R::one());
            L::add_to(self.sums, paths.sample, &more, free);
        } else {
            self.counters.rays += count(lit.bits());
            let rays = shadow_rays(surfaces, found);
            let free = scene.free(&rays, lit, self.stack) & lit;
            if free.any() {
                let more = L::seen_through(throughput, answers, o, &looked.shine, k, weight);
                L::add_to(self.sums, paths.sample, &more, free);
            }
        }
    }

    /// Collects the light of emitters that paths have met; `place` is the kind of the paths and where they are.
    #[inline(always)]
    pub(super) fn collect<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        place: (usize, Columns<R>),
        rays: &Rays<R>,
        met: &Encounters<R>,
        lanes: R::M,
        show: bool,
    ) {
        let scene = self.scene;
        let front = rays.direction.dot(met.surfaces.normal).lt(R::zero());
        let mut numbers = met.emitters;
        let mut sources = lanes & met.exist & front & met.shine();
        let missed = lanes & !met.exist;
        if let Some(all_around) = scene.environment {
            numbers = R::select_bits(missed, R::B::splat(all_around), numbers);
            sources = sources | missed;
        }
        if show && sources.any() {
            R::apart(AddSources::<R, L> {
                link: &mut *self,
                place,
                rays,
                met,
                numbers,
                sources,
            });
        }
    }

    /// The same for each emitter.
    #[inline(always)]
    fn add_sources<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        (kind, columns): (usize, Columns<R>),
        rays: &Rays<R>,
        met: &Encounters<R>,
        numbers: R::B,
        sources: R::M,
    ) {
        let scene = self.scene;
        let k = -rays.direction;
        let rows = &self.front.banks[kind].paths;
        let sample = rows.get(SAMPLE, columns).bits();
        let wavelengths = self.front.wavelengths::<R, L>(Columns::named(sample));
        let throughput = if self.front.polarized {
            L::taken(rows, THROUGHPUT, columns, kind)
        } else {
            L::taken_for_unpolarized(rows, THROUGHPUT, columns, kind)
        };
        let mut all_weighed = R::nowhere();
        if self.front.weighs {
            all_weighed = rows.get(WEIGHED, columns).gt(R::zero());
        }
        for (number, lanes) in groups::<R>(numbers, sources) {
            let emitter = &scene.emitters[number as usize];
            let weighed = lanes & all_weighed;
            let mut share = R::one();
            if weighed.any() {
                let last = rows.vector(LAST, columns);
                let density = if emitter.surrounds() {
                    let lit = rows.vector(LIT, columns);
                    let departure = rows.vector(DEPARTURE, columns);
                    emitter.densities_of_misses(lit, departure, weighed)
                } else {
                    emitter.densities_of_hits(scene, last, &met.surfaces, weighed)
                };
                let chances = scene.lights.chances(last);
                let chance = chances.of(&scene.lights, &scene.emitters, number, weighed);
                let own = rows.get(DENSITY, columns);
                share = R::select(weighed, power_heuristic(own, density * chance), share);
            }
            let shine = emitter.shine::<R, L>(k, met.surfaces.position, &wavelengths, lanes);
            let more = L::seen(&throughput, &shine, k, share);
            L::add_to(self.sums, sample, &more, lanes);
        }
    }

    /// Lengthens throughputs by the flat matter on the way to a source, and says where nothing else stands there.
    #[inline(always)]
    fn pass_on<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        from: &Surfaces<R>,
        connections: &Connections<R>,
        wavelengths: &L::Values<R>,
        through: &mut L::Throughputs<R>,
        room: u32,
        lanes: R::M,
    ) -> R::M {
        let scene = self.scene;
        let (mut open, mut free) = (lanes, R::nowhere());
        let mut at = *from;
        let mut passed = 0;
        let direction = connections.direction;
        while open.any() {
            self.counters.rays += count(open.bits());
            let rays = shadow_rays(&at, connections);
            let met = scene.meet(&rays, open, self.stack);
            free = free | (open & !met.exist);
            open = open & met.exist;
            let mut flat = 0;
            let materials = met.materials.lanes();
            each(open.bits(), |lane| {
                let straight = scene.traits_of(materials[lane]).straight;
                flat |= u32::from(straight) << lane;
            });
            open = open & R::M::from_bits(flat);
            let axes = met.surfaces.axes;
            let front = Vertices {
                o: axes.to_local(-direction),
                position: met.surfaces.position,
                axes,
                sights: Sights::blind(axes.s),
            };
            let behind = front.o.z.le(R::zero());
            for (number, group) in groups::<R>(met.materials, open) {
                let material = &scene.materials[number as usize];
                for back in [false, true] {
                    let lanes = group & if back { behind } else { !behind };
                    if !lanes.any() {
                        continue;
                    }
                    let turned = back && matches!(material, Material::TwoSided(_));
                    let at = if turned { front.turned() } else { front };
                    let mut answers = side(material, back).pass::<R, L>(&at, wavelengths, lanes);
                    L::to_world(&mut answers, &at.axes);
                    let longer = L::extended(through, &answers, R::one(), -direction);
                    *through = L::select(lanes, &longer, through);
                }
            }
            passed += 1;
            if passed > room {
                break;
            }
            open = open & L::strengths(through).gt(R::zero());
            // the next rays start behind these surfaces
            let s = &met.surfaces;
            at = Surfaces {
                position: offset_origins(s.position, s.error, s.normal, direction),
                error: V3::splat(Vec3A::ZERO),
                ..met.surfaces
            };
        }
        free
    }
}

/// See [`Scene::shadow_ray`].
#[inline(always)]
fn shadow_rays<R: Real>(from: &Surfaces<R>, to: &Connections<R>) -> Rays<R> {
    let direction = to.direction;
    let origin = offset_origins(from.position, from.error, from.normal, direction);
    let end = offset_origins(to.position, to.error, to.normal, -direction);
    let point = to.normal.squared().eq(R::zero());
    let end = V3::select(point, to.position, end);
    Rays {
        origin,
        direction: V3::select(to.near, end - origin, direction),
        t_max: R::select(to.near, R::splat(1.0 - 1e-6), R::splat(f32::INFINITY)),
    }
}

/// Looks for one light source a vertex.
#[inline(always)]
pub(super) fn look<R: Real, L: Abreast>(
    scene: &Scene,
    at: &Surfaces<R>,
    lit: &Axes<R>,
    choice: R,
    u: [R; 2],
    wavelengths: &L::Values<R>,
    lanes: R::M,
) -> Option<Looked<R, L::Values<R>>> {
    let chances = scene.lights.chances(at.position);
    let (numbers, chance) = chances.draw(&scene.lights, &scene.emitters, choice, lanes);
    let mut all: Option<Looked<R, L::Values<R>>> = None;
    for (number, mask) in groups::<R>(numbers, lanes) {
        let emitter = &scene.emitters[number as usize];
        let found = emitter.connections(scene, at.position, lit, u, mask);
        let k = -found.direction;
        let shine = emitter.shine::<R, L>(k, found.position, wavelengths, mask);
        let found = Connections {
            exist: found.exist & mask,
            ..found
        };
        let looked = Looked {
            density: found.density * chance,
            connections: found,
            shine,
        };
        all = Some(match all {
            None => looked,
            Some(before) => {
                let connections =
                    Connections::select(mask, &looked.connections, &before.connections);
                let k = -connections.direction;
                Looked {
                    connections,
                    density: R::select(mask, looked.density, before.density),
                    shine: either::<R, L>(mask, &looked.shine, &before.shine, k),
                }
            }
        });
    }
    all
}
