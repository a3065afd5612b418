//! Paths side by side: the path tracer for matter that does not ask for the coherence of light.
//!
//! Some hundred camera paths go on together, link by link: first all find what they meet, then each kind of matter that
//! was met sends on its own, as many at a time as there are lanes. What the paths collect, their random numbers and their
//! weights are those of [`trace`](super::trace), which scenes with matter that answers to coherence need.
//!
//! Source: Laine, Karras, Aila, Megakernels Considered Harmful: Wavefront Path Tracing on GPUs, HPG 2013.

mod light;
#[cfg(test)]
mod precision;
#[cfg(test)]
mod tests;
mod waiting;

use glam::Vec3A;

use super::{CHOICES, Counters, DIRECTION, FIRST_VERTEX, PER_VERTEX, POINT, PathOptions, ROULETTE};
use crate::geometry::bvh::Stack;
use crate::lanes::{Axes, Bits, Columns, Mask, Packed, Real, Rows, V3, part};
use crate::light::abreast::{Abreast, KINDS, Sights};
use crate::material::Material;
use crate::material::abreast::Vertices;
use crate::sampler::Stream;
use crate::scene::Scene;
use crate::scene::abreast::{Encounters, groups};
use crate::sensor::Camera;
use crate::shape::abreast::{Rays, Surfaces, offset_origins};
use light::{Looked, look};
use waiting::{
    PATH_ROWS, Paths, SAMPLE_ROWS, STREAM, SURFACE_ROWS, THROUGHPUT, WAVELENGTHS, WAVES, rays,
};

/// Paths on their way, and room for them.
pub struct Wavefront {
    samples: Rows<SAMPLE_ROWS>,
    /// How many camera samples have begun.
    begun: usize,
    stratified: bool,
    /// Their wavelengths, where all have the same.
    same: Option<[f32; WAVES]>,
    /// Paths by the kind of their throughput.
    banks: [Bank; KINDS],
    waiting: Waiting,
    /// Whether some light can be met that vertices have also looked for.
    weighs: bool,
    /// Whether some light is polarized where it is met.
    polarized: bool,
}

/// Paths whose throughputs are of one kind.
#[derive(Default)]
struct Bank {
    count: usize,
    paths: Rows<PATH_ROWS>,
    /// What they have met.
    met: Rows<SURFACE_ROWS>,
    /// Those that have been sent on.
    longer: Rows<PATH_ROWS>,
    sent: usize,
}

/// Paths that wait for their matter, by its side and the kind of their throughput.
struct Waiting {
    lists: Vec<Vec<u32>>,
    /// Lists with anyone in them.
    begun: Vec<usize>,
}

/// Paths of one kind that have met one side of some matter.
#[derive(Clone, Copy, Debug)]
struct List {
    material: u32,
    back: bool,
    kind: usize,
}

impl List {
    #[inline(always)]
    fn number(self) -> usize {
        (2 * self.material as usize + usize::from(self.back)) * KINDS + self.kind
    }

    #[inline(always)]
    fn of_number(number: usize) -> Self {
        Self {
            material: (number / (2 * KINDS)) as u32,
            back: number / KINDS % 2 == 1,
            kind: number % KINDS,
        }
    }
}

impl Waiting {
    fn clear(&mut self) {
        for list in self.begun.drain(..) {
            self.lists[list].clear();
        }
    }

    #[inline(always)]
    fn push<R: Real>(&mut self, list: List, first: usize, lanes: R::M) {
        let list = list.number();
        let paths = &mut self.lists[list];
        let before = paths.len();
        if before == 0 {
            self.begun.push(list);
        }
        // as many as lanes could be, of which the first ones stay
        let places = R::order(lanes) + R::B::splat(first as u32);
        paths.extend_from_slice(&places.lanes());
        paths.truncate(before + lanes.bits().count_ones() as usize);
    }
}

/// Where paths begin.
#[derive(Clone, Copy, Debug)]
pub struct Beginnings<R> {
    /// Start points, metres.
    pub origin: V3<R>,
    /// Directions in which the camera looks.
    pub direction: V3<R>,
    /// First axes of the Stokes frames.
    pub axis: V3<R>,
}

impl Wavefront {
    /// Whether paths of a scene go side by side: matter that asks for the coherence of light has them follow one by one, and
    /// so has a sensor that is not a pinhole.
    pub fn follows(scene: &Scene, camera: &Camera) -> bool {
        !scene.traits().coherent && matches!(camera, Camera::Perspective(_))
    }

    /// Room for the paths of a scene.
    pub fn new(scene: &Scene) -> Self {
        let scatters = |material: u32| !scene.traits_of(material).discrete;
        Self {
            weighs: !scene.emitters_are_unmet() && scene.used_materials().into_iter().any(scatters),
            polarized: scene
                .emitters
                .iter()
                .any(|e| e.polarizes() != (false, false)),
            samples: Rows::default(),
            begun: 0,
            stratified: false,
            same: None,
            banks: Default::default(),
            waiting: Waiting {
                lists: vec![vec![]; 2 * KINDS * scene.materials.len()],
                begun: vec![],
            },
        }
    }

    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.begun = 0;
        for bank in &mut self.banks {
            bank.count = 0;
        }
    }

    /// Begins a path in each of the first `count` lanes: the next camera samples.
    #[inline(always)]
    pub fn begin<R: Real, L: Abreast>(
        &mut self,
        start: &Beginnings<R>,
        wavelengths: &L::Values<R>,
        stream: &Stream<R>,
        count: usize,
    ) {
        let columns = Packed::<R>::new(self.begun, R::everywhere());
        self.stratified = stream.stratified;
        stream.put(&mut self.samples, STREAM, columns);
        let (mut own, mut same) = ([0.0; WAVES], true);
        for (w, value) in wavelengths.as_ref().iter().enumerate() {
            self.samples.put(WAVELENGTHS + w, columns, *value);
            own[w] = value.lane(0);
            same &= value.eq(R::splat(own[w])).bits() == R::everywhere().bits();
        }
        let like_those_before = self.begun == 0 || self.same == Some(own);
        self.same = (same && like_those_before).then_some(own);
        let first = self.begun as u32;
        let sample = R::B::from_fn(|lane| first + lane as u32);
        let unknown = V3::splat(Vec3A::Z);
        let throughput = L::beginning(start.axis);
        let bank = &mut self.banks[L::kind(&throughput)];
        Paths {
            sample,
            rays: Rays {
                origin: start.origin,
                direction: start.direction,
                t_max: R::splat(f32::INFINITY),
            },
            eta: R::one(),
            weighed: R::nowhere(),
            last: unknown,
            lit: unknown,
            density: R::one(),
            departure: unknown,
        }
        .put::<L>(&throughput, &mut bank.paths, columns, self.weighs);
        self.begun += count;
        bank.count = self.begun;
    }

    /// The wavelengths of camera samples.
    #[inline(always)]
    fn wavelengths<R: Real, L: Abreast>(&self, samples: Columns<R>) -> L::Values<R> {
        let mut all = L::values(R::zero());
        for (w, value) in all.as_mut().iter_mut().enumerate() {
            *value = match &self.same {
                Some(same) => R::splat(same[w]),
                None => self.samples.get(WAVELENGTHS + w, samples),
            };
        }
        all
    }

    /// How many paths are on their way.
    fn count(&self) -> usize {
        self.banks.iter().map(|bank| bank.count).sum()
    }

    /// Follows all paths to their ends; what they collect is added to the sums of their samples.
    #[inline(always)]
    pub fn trace<R: Real, L: Abreast>(
        &mut self,
        scene: &Scene,
        options: &PathOptions,
        stack: &mut Stack,
        counters: &mut Counters,
        sums: &mut [L::Stokes],
    ) {
        counters.paths += self.begun as u64;
        let mut depth = 1;
        while self.count() > 0 && depth <= options.max_depth {
            let mut link = Link {
                scene,
                options,
                depth,
                front: &mut *self,
                stack: &mut *stack,
                counters: &mut *counters,
                sums: &mut *sums,
            };
            link.meet::<R, L>();
            link.leave::<R, L>();
            depth += 1;
        }
        self.clear();
    }
}

#[inline(always)]
fn count(lanes: u32) -> u64 {
    u64::from(lanes.count_ones())
}

/// The side of a piece of matter that is seen.
#[inline(always)]
fn side(material: &Material, back: bool) -> &Material {
    match material {
        Material::TwoSided(both) => both.sides()[usize::from(back)],
        one => one,
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

/// One link of all paths: from where they are to the next matter, and the directions in which they leave it.
struct Link<'a, S> {
    scene: &'a Scene,
    options: &'a PathOptions,
    /// Number of the link: 1 from the camera.
    depth: u32,
    front: &'a mut Wavefront,
    stack: &'a mut Stack,
    counters: &'a mut Counters,
    sums: &'a mut [S],
}

part!(Leave<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, list: List, columns: Columns<R>, lanes: R::M) -> ():
    Link::<L::Stokes>::leave_one::<R, L>);
part!(Look<'a; R, L: Abreast>(scene: &'a Scene, at: &'a Surfaces<R>, lit: &'a Axes<R>, choice: R, u: [R; 2],
    wavelengths: &'a L::Values<R>, lanes: R::M) -> Option<Looked<R, L::Values<R>>>: look::<R, L>);

impl<S> Link<'_, S> {
    /// Finds what paths meet; collects the light of sources, and sorts paths by the matter that they have met.
    #[inline(always)]
    fn meet<R: Real, L: Abreast<Stokes = S>>(&mut self) {
        self.front.waiting.clear();
        for kind in 0..KINDS {
            for first in (0..self.front.banks[kind].count).step_by(R::LANES) {
                self.meet_some::<R, L>(kind, first);
            }
        }
    }

    /// The same for paths of one kind, from column `first` on.
    #[inline(always)]
    fn meet_some<R: Real, L: Abreast<Stokes = S>>(&mut self, kind: usize, first: usize) {
        let (scene, depth) = (self.scene, self.depth);
        let bank = &self.front.banks[kind];
        let lanes = R::first(bank.count - first);
        let columns = Columns::From(first);
        let mut rays = rays::<R>(&bank.paths, columns);
        self.counters.rays += count(lanes.bits());
        let mut met = scene.meet(&rays, lanes, self.stack);
        let show = !self.options.hide_emitters || depth > 1;
        if !show {
            self.look_beyond(&mut rays, &mut met, lanes);
        }
        self.collect::<R, L>((kind, columns), &rays, &met, lanes, show);
        let alive = lanes & met.exist;
        if depth >= self.options.max_depth || !alive.any() {
            return;
        }
        let rows = &mut self.front.banks[kind].met;
        met.surfaces.put(rows, Packed::new(first, R::everywhere()));
        let behind = rays.direction.dot(met.surfaces.axes.n).gt(R::zero());
        for (material, lanes) in groups::<R>(met.materials, alive) {
            if scene.traits_of(material).black {
                continue;
            }
            for (back, lanes) in [(false, lanes & !behind), (true, lanes & behind)] {
                if lanes.any() {
                    let list = List {
                        material,
                        back,
                        kind,
                    };
                    self.front.waiting.push::<R>(list, first, lanes);
                }
            }
        }
    }

    /// Sends paths on, one kind of matter after the other.
    #[inline(always)]
    fn leave<R: Real, L: Abreast<Stokes = S>>(&mut self) {
        for list in 0..self.front.waiting.begun.len() {
            let list = self.front.waiting.begun[list];
            let paths = std::mem::take(&mut self.front.waiting.lists[list]);
            for some in paths.chunks(R::LANES) {
                R::apart(Leave::<R, L> {
                    link: &mut *self,
                    list: List::of_number(list),
                    columns: Columns::listed(some),
                    lanes: R::first(some.len()),
                });
            }
            self.front.waiting.lists[list] = paths;
        }
        for bank in &mut self.front.banks {
            std::mem::swap(&mut bank.paths, &mut bank.longer);
            bank.count = std::mem::take(&mut bank.sent);
        }
    }

    /// Sends on some paths of a list.
    #[inline(always)]
    fn leave_one<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        list: List,
        columns: Columns<R>,
        lanes: R::M,
    ) {
        let (scene, depth) = (self.scene, self.depth);
        let last = self.options.max_depth;
        let weighs = self.front.weighs;
        let (number, back) = (list.material as usize, list.back);
        let traits = scene.traits_of(list.material);
        let material = side(&scene.materials[number], back);
        let bank = &self.front.banks[list.kind];
        let rows = &bank.paths;
        let mut throughput = if material.forgets_polarization() {
            L::taken_for_unpolarized(rows, THROUGHPUT, columns, list.kind)
        } else {
            L::taken(rows, THROUGHPUT, columns, list.kind)
        };
        let paths = Paths::taken(rows, columns, weighs);
        let surfaces = Surfaces::taken(&bank.met, columns);
        let of_samples = Columns::named(paths.sample);
        let stratified = self.front.stratified;
        let wavelengths = self.front.wavelengths::<R, L>(of_samples);
        let dimension = FIRST_VERTEX + PER_VERTEX * (depth - 1);
        let mut alive = lanes;
        let long = depth > self.options.rr_depth;

        let mut stream = Stream::nothing(stratified);
        if long || !traits.discrete || material.numbers() > 0 {
            stream = Stream::taken(&self.front.samples, STREAM, of_samples, stratified);
        }

        // end weak paths: those that no light can make strong at the sensor
        if long {
            let [roulette, _] = stream.pairs(R::B::splat(dimension + ROULETTE));
            let reach = L::reaches(&throughput);
            let survival = (reach * paths.eta * paths.eta).min(R::splat(0.95));
            alive = alive & roulette.lt(survival);
            throughput = L::scaled_lanes(&throughput, survival.recip());
            if !alive.any() {
                return;
            }
        }

        let axes = surfaces.axes;
        let o_world = -paths.rays.direction;
        let o = axes.to_local(o_world);
        let lit = axes.flipped_where(o.z.lt(R::zero()));
        let mut at = Vertices {
            o,
            position: surfaces.position,
            axes,
            sights: Sights::blind(axes.s),
        };
        if traits.chooses {
            at.sights = L::sights(&throughput);
            at.sights.axis = axes.to_local(at.sights.axis);
        }
        if back && matches!(scene.materials[number], Material::TwoSided(_)) {
            at = at.turned();
        }

        let [mut choice, mut drawn] = [R::zero(); 2];
        if !traits.discrete || material.numbers() > 0 {
            [choice, drawn] = stream.pairs(R::B::splat(dimension + CHOICES));
        }
        if !traits.discrete && !scene.emitters.is_empty() {
            let u = stream.pairs(R::B::splat(dimension + POINT));
            let looking = Look::<R, L> {
                scene,
                at: &surfaces,
                lit: &lit,
                choice,
                u,
                wavelengths: &wavelengths,
                lanes: alive,
            };
            if let Some(looked) = R::apart(looking) {
                let ways = (&paths, material, &at, &wavelengths);
                self.connect::<R, L>(ways, &throughput, &surfaces, &looked, alive);
            }
        }
        // a longer path would meet nothing that shines
        if scene.emitters_are_unmet() && depth.saturating_add(1) >= last {
            return;
        }

        let mut numbers = [drawn; 3];
        if material.numbers() > 1 {
            let [u, v] = stream.pairs(R::B::splat(dimension + DIRECTION));
            numbers = [drawn, u, v];
        }
        let mut way = material.depart::<R, L>(&at, &wavelengths, numbers, alive);
        L::to_world(&mut way.answers, &at.axes);
        let direction = at.axes.to_world(way.direction);
        let weight = way.density.recip();
        let throughput = L::extended(&throughput, &way.answers, weight, o_world);
        let on = alive & way.exist & L::strengths(&throughput).gt(R::zero());
        let kept = on.bits();
        if kept == 0 {
            return;
        }
        let bank = &mut self.front.banks[L::kind(&throughput)];
        Paths {
            sample: paths.sample,
            rays: Rays {
                origin: offset_origins(
                    surfaces.position,
                    surfaces.error,
                    surfaces.normal,
                    direction,
                ),
                direction,
                t_max: paths.rays.t_max,
            },
            eta: paths.eta * way.eta,
            weighed: way.continuous | (paths.weighed & way.straight),
            last: V3::select(way.continuous, surfaces.position, paths.last),
            lit: V3::select(way.continuous, lit.n, paths.lit),
            density: R::select(way.continuous, way.density, paths.density),
            departure: V3::select(way.continuous, direction, paths.departure),
        }
        .put::<L>(
            &throughput,
            &mut bank.longer,
            Packed::new(bank.sent, on),
            weighs,
        );
        bank.sent += kept.count_ones() as usize;
    }

    /// The first surfaces that do not shine.
    #[inline(always)]
    fn look_beyond<R: Real>(&mut self, rays: &mut Rays<R>, met: &mut Encounters<R>, lanes: R::M) {
        loop {
            let lanes = lanes & met.exist & met.shine();
            if !lanes.any() {
                return;
            }
            self.counters.rays += count(lanes.bits());
            let s = &met.surfaces;
            let origin = offset_origins(s.position, s.error, s.normal, rays.direction);
            rays.origin = V3::select(lanes, origin, rays.origin);
            let behind = self.scene.meet(rays, lanes, self.stack);
            met.exist = (met.exist & !lanes) | (behind.exist & lanes);
            met.surfaces = Surfaces::select(lanes, &behind.surfaces, &met.surfaces);
            met.materials = R::select_bits(lanes, behind.materials, met.materials);
            met.emitters = R::select_bits(lanes, behind.emitters, met.emitters);
        }
    }
}
