//! Paths side by side: the path tracer for matter that does not ask for the coherence of light.
//!
//! Each lane is a camera path, at whatever depth it is; a lane whose path has ended takes up the next one. What the
//! paths collect, their random numbers and their weights are those of [`Walk`](super::Walk), which scenes with matter
//! that answers to coherence need.

use glam::Vec3A;

use super::{CHOICES, Counters, DIRECTION, FIRST_VERTEX, PER_VERTEX, POINT, PathOptions, ROULETTE};
use crate::emitter::abreast::Connections;
use crate::geometry::bvh::Stack;
use crate::lanes::{Axes, Bits, MOST, Mask, Real, V3, each};
use crate::light::abreast::{Abreast, Shine};
use crate::material::abreast::Vertices;
use crate::material::{Material, Traits};
use crate::sampler::{Stream, Streams};
use crate::scene::Scene;
use crate::scene::abreast::{Encounters, NONE, groups};
use crate::shape::abreast::{Rays, Surfaces, offset_origins};

/// Most camera samples that are handed over at once: lanes whose path has ended take the next of these.
pub const QUEUE: usize = 64;

/// Camera samples as they begin, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Queue {
    /// How many there are.
    pub count: usize,
    origin: [[f32; QUEUE]; 3],
    direction: [[f32; QUEUE]; 3],
    axes: [[f32; QUEUE]; 3],
    wavelengths: [[f32; QUEUE]; WAVES],
    streams: Streams<QUEUE>,
}

/// Most wavelengths of a path.
const WAVES: usize = 4;

impl Default for Queue {
    fn default() -> Self {
        Self {
            count: 0,
            origin: [[0.0; QUEUE]; 3],
            direction: [[0.0; QUEUE]; 3],
            axes: [[0.0; QUEUE]; 3],
            wavelengths: [[0.0; QUEUE]; WAVES],
            streams: Streams::new(),
        }
    }
}

#[inline(always)]
fn put<R: Real>(to: &mut [f32; QUEUE], first: usize, value: R) {
    to[first..first + R::LANES].copy_from_slice(&value.lanes()[..R::LANES]);
}

#[inline(always)]
fn take<R: Real>(from: &[f32; QUEUE], places: &[usize; MOST], mask: R::M, before: R) -> R {
    let fresh = R::from_fn(|lane| from[places[lane] % QUEUE]);
    R::select(mask, fresh, before)
}

#[inline(always)]
fn put_vector<R: Real>(to: &mut [[f32; QUEUE]; 3], first: usize, v: V3<R>) {
    put(&mut to[0], first, v.x);
    put(&mut to[1], first, v.y);
    put(&mut to[2], first, v.z);
}

#[inline(always)]
fn take_vector<R: Real>(
    from: &[[f32; QUEUE]; 3],
    places: &[usize; MOST],
    mask: R::M,
    before: V3<R>,
) -> V3<R> {
    V3::new(
        take(&from[0], places, mask, before.x),
        take(&from[1], places, mask, before.y),
        take(&from[2], places, mask, before.z),
    )
}

impl Queue {
    /// Appends one sample a lane; those beyond `count` are overwritten by the next.
    #[inline(always)]
    pub fn append<R: Real>(
        &mut self,
        (origin, direction, axes): (V3<R>, V3<R>, V3<R>),
        wavelengths: &[R],
        stream: &Stream<R>,
        count: usize,
    ) {
        let first = self.count;
        put_vector(&mut self.origin, first, origin);
        put_vector(&mut self.direction, first, direction);
        put_vector(&mut self.axes, first, axes);
        for (to, value) in self.wavelengths.iter_mut().zip(wavelengths) {
            put(to, first, *value);
        }
        self.streams.put(first, stream);
        self.count += count;
    }
}

/// Paths on their way.
struct Paths<R: Real, L: Abreast> {
    rays: Rays<R>,
    wavelengths: L::Values<R>,
    stream: Stream<R>,
    alive: R::M,
    depth: R,
    throughput: L::Throughputs<R>,
    /// Ratio of the indices along the path.
    eta: R,
    /// Whether there was a vertex with a continuous lobe, where, its normal on the camera's side, and the density.
    scattered: R::M,
    origin: V3<R>,
    lit: V3<R>,
    density: R,
    /// The direction at that vertex, and whether nothing has bent the path since.
    departure: V3<R>,
    straight: R::M,
    seen: L::Seen<R>,
}

/// What paths side by side collect, in the order of the queue.
#[inline(always)]
pub fn trace<R: Real, L: Abreast>(
    scene: &Scene,
    options: &PathOptions,
    queue: &Queue,
    stack: &mut Stack,
    counters: &mut Counters,
    seen: &mut [L::Stokes; QUEUE],
) {
    counters.paths += queue.count as u64;
    if options.max_depth == 0 {
        seen.fill(L::dark());
        return;
    }
    let nothing = V3::splat(Vec3A::Z);
    let mut paths = Paths::<R, L> {
        rays: Rays {
            origin: nothing,
            direction: nothing,
            t_max: R::splat(f32::INFINITY),
        },
        wavelengths: L::values(R::one()),
        stream: Stream::nothing(),
        alive: R::nowhere(),
        depth: R::one(),
        throughput: L::beginning(nothing),
        eta: R::one(),
        scattered: R::nowhere(),
        origin: nothing,
        lit: nothing,
        density: R::one(),
        departure: nothing,
        straight: R::everywhere(),
        seen: L::dark_lanes(),
    };
    // whose path each lane follows; `QUEUE`: nobody's
    let mut places = [QUEUE; MOST];
    let mut next = 0;
    loop {
        let idle = (!paths.alive & R::everywhere()).bits();
        let waiting = queue.count - next;
        // taking up paths costs the same for one lane as for all
        if idle.count_ones() as usize >= PATIENCE.min(R::LANES) && waiting > 0 {
            paths.hand_in(&mut places, idle, seen);
            let mut fresh = 0;
            each(idle, |lane| {
                if next < queue.count {
                    places[lane] = next;
                    next += 1;
                    fresh |= 1 << lane;
                }
            });
            paths.take_up(queue, &places, R::M::from_bits(fresh));
        }
        if !paths.alive.any() {
            break;
        }
        paths.step(scene, options, stack, counters);
    }
    let all = R::everywhere().bits();
    paths.hand_in(&mut places, all, seen);
}

/// So many lanes stand idle before they take up new paths.
const PATIENCE: usize = 2;

#[inline(always)]
fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let ratio = other / own;
    (R::one() + ratio * ratio).recip()
}

#[inline(always)]
fn count(lanes: u32) -> u64 {
    u64::from(lanes.count_ones())
}

/// Lanes of matter that pass a test.
#[inline(always)]
fn lanes_of(
    scene: &Scene,
    materials: &[u32; MOST],
    lanes: u32,
    test: impl Fn(Traits) -> bool,
) -> u32 {
    let mut found = 0;
    each(lanes, |lane| {
        found |= u32::from(test(scene.traits_of(materials[lane]))) << lane;
    });
    found
}

/// The side of a piece of matter that lanes see: the matter, the lanes, and whether it is the back of something.
#[inline(always)]
fn sides<R: Real>(material: &Material, o_z: R, lanes: R::M) -> [(&Material, R::M, bool); 2] {
    match material {
        Material::TwoSided(both) => {
            let [front, back] = both.sides();
            let above = o_z.gt(R::zero());
            [(front, lanes & above, false), (back, lanes & !above, true)]
        }
        one => [(one, lanes, false), (one, R::nowhere(), false)],
    }
}

impl<R: Real> Vertices<R> {
    /// Seen by matter whose normal is on the other side.
    #[inline(always)]
    fn turned(&self) -> Self {
        let (o, axis) = (self.o, self.sights.axis);
        let mut turned = *self;
        turned.o = V3::new(o.x, -o.y, -o.z);
        turned.axes = self.axes.flipped_where(R::everywhere());
        turned.sights.axis = V3::new(axis.x, -axis.y, -axis.z);
        turned
    }
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
fn select<R: Real, L: Abreast>(
    mask: R::M,
    a: &L::Values<R>,
    b: &L::Values<R>,
) -> L::Values<R> {
    let mut chosen = *b;
    for (to, a) in chosen.as_mut().iter_mut().zip(a.as_ref()) {
        *to = R::select(mask, *a, *to);
    }
    chosen
}

/// Light that vertices look for.
struct Looked<R: Real, V> {
    connections: Connections<R>,
    /// Density of the connection, the choice of its source included.
    density: R,
    shine: Shine<V, R>,
}

impl<R: Real, L: Abreast> Paths<R, L> {
    /// Hands in what lanes have collected.
    #[inline(always)]
    fn hand_in(
        &self,
        places: &mut [usize; MOST],
        lanes: u32,
        seen: &mut [L::Stokes; QUEUE],
    ) {
        let collected = L::all_lanes(&self.seen);
        each(lanes, |lane| {
            if let Some(to) = seen.get_mut(places[lane]) {
                *to = collected[lane];
            }
            places[lane] = QUEUE;
        });
    }

    /// Begins the paths at some places of the queue.
    #[inline(always)]
    fn take_up(&mut self, queue: &Queue, places: &[usize; MOST], lanes: R::M) {
        let rays = &mut self.rays;
        rays.origin = take_vector(&queue.origin, places, lanes, rays.origin);
        rays.direction = take_vector(&queue.direction, places, lanes, rays.direction);
        let axes = take_vector(&queue.axes, places, lanes, self.lit);
        for (value, from) in self.wavelengths.as_mut().iter_mut().zip(&queue.wavelengths) {
            *value = take(from, places, lanes, *value);
        }
        self.stream = queue.streams.take(places, lanes, &self.stream);
        self.throughput = L::select(lanes, &L::beginning(axes), &self.throughput);
        self.depth = R::select(lanes, R::one(), self.depth);
        self.eta = R::select(lanes, R::one(), self.eta);
        self.density = R::select(lanes, R::one(), self.density);
        self.scattered = self.scattered & !lanes;
        self.straight = self.straight | lanes;
        self.departure = V3::select(lanes, rays.direction, self.departure);
        L::clear(&mut self.seen, lanes);
        self.alive = self.alive | lanes;
    }

    /// One link further: from where the paths are to the next matter, and the direction in which they leave it.
    #[inline(always)]
    fn step(
        &mut self,
        scene: &Scene,
        options: &PathOptions,
        stack: &mut Stack,
        counters: &mut Counters,
    ) {
        counters.rays += count(self.alive.bits());
        let mut met = scene.meet(&self.rays, self.alive, stack);
        let mut show = R::everywhere();
        if options.hide_emitters {
            let first = self.alive & self.depth.le(R::one());
            show = !first;
            if first.any() {
                self.look_beyond(scene, &mut met, first, stack, counters);
            }
        }
        self.collect(scene, &met, show);
        let k = self.rays.direction;
        let mut alive = self.alive & met.exist;
        let last = R::splat(options.max_depth as f32);
        alive = alive & self.depth.lt(last);
        let black = lanes_of(scene, &met.materials, alive.bits(), |t| t.black);
        alive = alive & !R::M::from_bits(black);
        if !alive.any() {
            self.alive = alive;
            return;
        }
        let dimension = R::B::splat(FIRST_VERTEX)
            + R::B::splat(PER_VERTEX) * ((self.depth - R::one()).to_int());
        let stream = self.stream;

        // end weak paths: those that no light can make strong at the sensor
        let long = alive & self.depth.gt(R::splat(options.rr_depth as f32));
        if long.any() {
            let [roulette, _] = stream.pairs(dimension + R::B::splat(ROULETTE));
            let reach = L::reaches(&self.throughput);
            let survival = (reach * self.eta * self.eta).min(R::splat(0.95));
            alive = alive & !(long & roulette.ge(survival));
            let scale = R::select(long, survival.recip(), R::one());
            L::scale_lanes(&mut self.throughput, scale);
            if !alive.any() {
                self.alive = alive;
                return;
            }
        }

        let surfaces = met.surfaces;
        let axes = surfaces.axes;
        let o_world = -k;
        let o = axes.to_local(o_world);
        let behind = o.z.lt(R::zero());
        let lit = axes.flipped_where(behind);
        let mut vertices = Vertices {
            o,
            position: surfaces.position,
            axes,
            sights: L::sights(&self.throughput),
        };
        vertices.sights.axis = axes.to_local(vertices.sights.axis);

        let [choice, drawn] = stream.pairs(dimension + R::B::splat(CHOICES));
        let [u, v] = stream.pairs(dimension + R::B::splat(DIRECTION));
        let scattering =
            R::M::from_bits(lanes_of(scene, &met.materials, alive.bits(), |t| !t.discrete));
        let looked = if scattering.any() && !scene.emitters.is_empty() {
            let point = stream.pairs(dimension + R::B::splat(POINT));
            self.look(scene, &surfaces, &lit, (choice, point), scattering)
        } else {
            None
        };
        let on = !(R::splat(if scene.emitters_are_unmet() { 1.0 } else { 0.0 })
            .gt(R::zero())
            & (self.depth + R::one()).ge(last));

        let mut next = self.throughput;
        let mut direction = k;
        let (mut density, mut eta) = (R::one(), R::one());
        let (mut exist, mut continuous, mut straight) =
            (R::nowhere(), R::nowhere(), R::nowhere());
        let mut light = L::dark_lanes();
        let mut through = self.throughput;
        let mut lighted = R::nowhere();
        for (number, group) in groups(&met.materials, alive.bits()) {
            let traits = scene.traits_of(number);
            let all = R::M::from_bits(group);
            for (material, lanes, back) in sides(&scene.materials[number as usize], o.z, all) {
                if !lanes.any() {
                    continue;
                }
                let at = if back { vertices.turned() } else { vertices };
                if let Some(looked) = looked.as_ref().filter(|_| !traits.discrete) {
                    let found = &looked.connections;
                    let i = at.axes.to_local(found.direction);
                    let ask = lanes & found.exist;
                    if ask.any() {
                        let (answers, own) =
                            material.answer::<R, L>(&at, i, &self.wavelengths, ask);
                        let lit = ask & own.gt(R::zero());
                        if lit.any() {
                            let answers = L::to_world(&answers, &at.axes);
                            let share = power_heuristic(looked.density, own);
                            let share = R::select(found.discrete, R::one(), share);
                            let weight = share * found.weight / looked.density;
                            if scene.traits().straight {
                                let longer = L::extended(
                                    &self.throughput,
                                    &answers,
                                    weight,
                                    o_world,
                                    found.direction,
                                );
                                through = L::select(lit, &longer, &through);
                            } else {
                                let more = L::seen_through(
                                    &self.throughput,
                                    &answers,
                                    o_world,
                                    &looked.shine,
                                    -found.direction,
                                    weight,
                                );
                                L::add(&mut light, &more, lit);
                            }
                            lighted = lighted | lit;
                        }
                    }
                }
                let lanes = lanes & on;
                if !lanes.any() {
                    continue;
                }
                let way =
                    material.depart::<R, L>(&at, &self.wavelengths, [drawn, u, v], lanes);
                let goes = lanes & way.exist;
                let answers = L::to_world(&way.answers, &at.axes);
                let i = at.axes.to_world(way.direction);
                let weight = way.density.recip();
                let longer = L::extended(&self.throughput, &answers, weight, o_world, i);
                next = L::select(goes, &longer, &next);
                direction = V3::select(goes, i, direction);
                density = R::select(goes, way.density, density);
                eta = R::select(goes, way.eta, eta);
                exist = exist | goes;
                continuous = continuous | (goes & way.continuous);
                straight = straight | (goes & way.straight);
            }
        }

        if let Some(looked) = looked.filter(|_| lighted.any()) {
            if scene.traits().straight {
                let room = last - self.depth - R::one();
                let free = self.pass_on(
                    scene,
                    (&surfaces, &looked.connections, &mut through),
                    room,
                    lighted,
                    stack,
                    counters,
                );
                let k = -looked.connections.direction;
                let more = L::seen(&through, &looked.shine, k, R::one());
                L::add(&mut self.seen, &more, free);
            } else {
                counters.rays += count(lighted.bits());
                let rays = shadow_rays(&surfaces, &looked.connections);
                let free = scene.free(&rays, lighted, stack) & lighted;
                L::add(&mut self.seen, &light, free);
            }
        }

        // go on toward the light
        alive = alive & exist & L::strengths(&next).gt(R::zero());
        self.throughput = next;
        self.eta = self.eta * eta;
        self.scattered = self.scattered | continuous;
        self.origin = V3::select(continuous, surfaces.position, self.origin);
        self.lit = V3::select(continuous, lit.n, self.lit);
        self.density = R::select(continuous, density, self.density);
        self.departure = V3::select(continuous, direction, self.departure);
        self.straight = continuous | (self.straight & straight);
        self.rays = Rays {
            origin: offset_origins(
                surfaces.position,
                surfaces.error,
                surfaces.normal,
                direction,
            ),
            direction,
            t_max: R::splat(f32::INFINITY),
        };
        self.depth = self.depth + R::one();
        self.alive = alive;
    }

    /// The first surfaces that do not shine.
    #[inline(always)]
    fn look_beyond(
        &mut self,
        scene: &Scene,
        met: &mut Encounters<R>,
        first: R::M,
        stack: &mut Stack,
        counters: &mut Counters,
    ) {
        loop {
            let mut shining = 0;
            each((first & met.exist).bits(), |lane| {
                shining |= u32::from(met.emitters[lane] != NONE) << lane;
            });
            if shining == 0 {
                return;
            }
            counters.rays += count(shining);
            let lanes = R::M::from_bits(shining);
            let s = &met.surfaces;
            let origin = offset_origins(s.position, s.error, s.normal, self.rays.direction);
            self.rays.origin = V3::select(lanes, origin, self.rays.origin);
            let behind = scene.meet(&self.rays, lanes, stack);
            met.exist = (met.exist & !lanes) | (behind.exist & lanes);
            met.surfaces = Surfaces::select(lanes, &behind.surfaces, &met.surfaces);
            each(shining, |lane| {
                met.materials[lane] = behind.materials[lane];
                met.emitters[lane] = behind.emitters[lane];
            });
        }
    }

    /// Light of emitters that the paths have met.
    #[inline(always)]
    fn collect(&mut self, scene: &Scene, met: &Encounters<R>, show: R::M) {
        let front = self.rays.direction.dot(met.surfaces.normal).lt(R::zero());
        let lanes = self.alive & show;
        let mut numbers = met.emitters;
        if let Some(all_around) = scene.environment {
            each((lanes & !met.exist).bits(), |lane| numbers[lane] = all_around);
        }
        let mut sources = 0;
        each((lanes & (front | !met.exist)).bits(), |lane| {
            sources |= u32::from(numbers[lane] != NONE) << lane;
        });
        // where nothing is met and nothing surrounds the scene the number says nothing
        if scene.environment.is_none() {
            sources &= met.exist.bits();
        }
        let k = -self.rays.direction;
        for (number, group) in groups(&numbers, sources) {
            let lanes = R::M::from_bits(group);
            let emitter = &scene.emitters[number as usize];
            let weighed = lanes & self.scattered & self.straight;
            let mut share = R::one();
            if weighed.any() {
                let density = if emitter.surrounds() {
                    emitter.densities_of_misses(self.lit, self.departure, weighed)
                } else {
                    emitter.densities_of_hits(scene, self.origin, &met.surfaces, weighed)
                };
                let chances = scene.lights.chances(self.origin);
                let chance = chances.of(&scene.lights, &scene.emitters, number, weighed);
                let share_there = power_heuristic(self.density, density * chance);
                share = R::select(weighed, share_there, share);
            }
            let shine = emitter.shine::<R, L>(k, met.surfaces.position, &self.wavelengths, lanes);
            let more = L::seen(&self.throughput, &shine, k, share);
            L::add(&mut self.seen, &more, lanes);
        }
    }

    /// Looks for one light source a vertex.
    #[inline(always)]
    fn look(
        &self,
        scene: &Scene,
        at: &Surfaces<R>,
        lit: &Axes<R>,
        (choice, u): (R, [R; 2]),
        lanes: R::M,
    ) -> Option<Looked<R, L::Values<R>>> {
        let chances = scene.lights.chances(at.position);
        let (numbers, chance) = chances.draw(&scene.lights, &scene.emitters, choice, lanes);
        let mut all: Option<Looked<R, L::Values<R>>> = None;
        for (number, group) in groups(&numbers, lanes.bits()) {
            let mask = R::M::from_bits(group);
            let emitter = &scene.emitters[number as usize];
            let found = emitter.connections(scene, at.position, lit, u, mask);
            let k = -found.direction;
            let shine = emitter.shine::<R, L>(k, found.position, &self.wavelengths, mask);
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

    /// Lengthens throughputs by the flat matter on the way to a source, and says where nothing else stands there.
    #[inline(always)]
    fn pass_on(
        &self,
        scene: &Scene,
        (from, connections, through): (&Surfaces<R>, &Connections<R>, &mut L::Throughputs<R>),
        room: R,
        lanes: R::M,
        stack: &mut Stack,
        counters: &mut Counters,
    ) -> R::M {
        let (mut open, mut free) = (lanes, R::nowhere());
        let mut at = *from;
        let mut passed = R::zero();
        let direction = connections.direction;
        while open.any() {
            counters.rays += count(open.bits());
            let rays = shadow_rays(&at, connections);
            let met = scene.meet(&rays, open, stack);
            free = free | (open & !met.exist);
            open = open & met.exist;
            let flat = lanes_of(scene, &met.materials, open.bits(), |t| t.straight);
            open = open & R::M::from_bits(flat);
            for (number, group) in groups(&met.materials, open.bits()) {
                let all = R::M::from_bits(group);
                let axes = met.surfaces.axes;
                let o = axes.to_local(-direction);
                let vertices = Vertices {
                    o,
                    position: met.surfaces.position,
                    axes,
                    sights: crate::light::abreast::Sights {
                        axis: axes.s,
                        linear: [R::zero(); 2],
                    },
                };
                for (material, lanes, back) in sides(&scene.materials[number as usize], o.z, all)
                {
                    if !lanes.any() {
                        continue;
                    }
                    let at = if back { vertices.turned() } else { vertices };
                    let answers = material.pass::<R, L>(&at, &self.wavelengths, lanes);
                    let answers = L::to_world(&answers, &at.axes);
                    let longer =
                        L::extended(through, &answers, R::one(), -direction, direction);
                    *through = L::select(lanes, &longer, through);
                }
            }
            passed = passed + R::one();
            open = open & passed.le(room) & L::strengths(through).gt(R::zero());
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
        t_max: R::select(
            to.near,
            R::splat(1.0 - 1e-6),
            R::splat(f32::INFINITY),
        ),
    }
}
