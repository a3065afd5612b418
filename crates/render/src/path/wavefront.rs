//! Paths side by side: the path tracer for matter that does not ask for the coherence of light.
//!
//! Some hundred camera paths go on together, link by link: first all find what they meet, then each kind of matter that
//! was met sends on its own, as many at a time as there are lanes. What the paths collect, their random numbers and their
//! weights are those of [`trace`](super::trace), which scenes with matter that answers to coherence need.
//!
//! Source: Laine, Karras, Aila, Megakernels Considered Harmful: Wavefront Path Tracing on GPUs, HPG 2013.

use glam::Vec3A;

use super::{CHOICES, Counters, DIRECTION, FIRST_VERTEX, PER_VERTEX, POINT, PathOptions, ROULETTE};
use crate::emitter::abreast::Connections;
use crate::geometry::bvh::Stack;
use crate::lanes::{Axes, Bits, Columns, MOST, Mask, Packed, Real, Rows, V3, each, part};
use crate::light::abreast::{Abreast, Shine, Sights};
use crate::material::Material;
use crate::material::abreast::Vertices;
use crate::sampler::{STREAM_ROWS, Stream};
use crate::scene::Scene;
use crate::scene::abreast::{Encounters, NONE, groups};
use crate::shape::abreast::{Rays, Surfaces, offset_origins};

/// Most wavelengths of a path.
const WAVES: usize = 4;

// rows of camera samples
const STREAM: usize = 0;
const WAVELENGTHS: usize = STREAM + STREAM_ROWS;
const SAMPLE_ROWS: usize = WAVELENGTHS + WAVES;

// rows of paths: the camera sample; the next ray; the ratio of the indices along the path; the last vertex with a
// continuous lobe, if there was one, its normal on the camera's side, the density of its direction, that direction, and
// whether nothing has bent the path since; the throughput
const SAMPLE: usize = 0;
const ORIGIN: usize = SAMPLE + 1;
const HEADING: usize = ORIGIN + 3;
const ETA: usize = HEADING + 3;
const WEIGHED: usize = ETA + 1;
const LAST: usize = WEIGHED + 1;
const LIT: usize = LAST + 3;
const DENSITY: usize = LIT + 3;
const DEPARTURE: usize = DENSITY + 1;
const THROUGHPUT: usize = DEPARTURE + 3;
const PATH_ROWS: usize = THROUGHPUT + 3 + 16 * WAVES;

// rows of surfaces
const POSITION: usize = 0;
const ERROR: usize = POSITION + 3;
const NORMAL: usize = ERROR + 3;
const AXES: usize = NORMAL + 3;
const SURFACE_ROWS: usize = AXES + 9;

/// Paths on their way, and room for them.
pub struct Wavefront {
    count: usize,
    samples: Rows<SAMPLE_ROWS>,
    stratified: bool,
    paths: Rows<PATH_ROWS>,
    longer: Rows<PATH_ROWS>,
    met: Rows<SURFACE_ROWS>,
    waiting: Waiting,
}

/// Paths that wait for their matter, by its side.
struct Waiting {
    lists: Vec<Vec<u32>>,
    /// Lists with anyone in them.
    begun: Vec<usize>,
}

impl Waiting {
    fn clear(&mut self) {
        for list in self.begun.drain(..) {
            self.lists[list].clear();
        }
    }

    #[inline(always)]
    fn push(&mut self, list: usize, path: u32) {
        let paths = &mut self.lists[list];
        if paths.is_empty() {
            self.begun.push(list);
        }
        paths.push(path);
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
    /// Room for the paths of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self {
            count: 0,
            samples: Rows::default(),
            stratified: false,
            paths: Rows::default(),
            longer: Rows::default(),
            met: Rows::default(),
            waiting: Waiting {
                lists: vec![vec![]; 2 * scene.materials.len()],
                begun: vec![],
            },
        }
    }

    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.count = 0;
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
        let columns = Packed::<R>::new(self.count, R::everywhere());
        self.stratified = stream.stratified;
        stream.put(&mut self.samples, STREAM, columns);
        for (w, value) in wavelengths.as_ref().iter().enumerate() {
            self.samples.put(WAVELENGTHS + w, columns, *value);
        }
        let first = self.count as u32;
        let sample = R::B::from_fn(|lane| first + lane as u32);
        let unknown = V3::splat(Vec3A::Z);
        Paths::<R, L> {
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
            throughput: L::beginning(start.axis),
        }
        .put(&mut self.paths, columns);
        self.count += count;
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
        counters.paths += self.count as u64;
        let mut depth = 1;
        while self.count > 0 && depth <= options.max_depth {
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
        self.count = 0;
    }
}

/// Paths side by side.
struct Paths<R: Real, L: Abreast> {
    sample: R::B,
    rays: Rays<R>,
    eta: R,
    /// Where connections could have found what the path meets next.
    weighed: R::M,
    last: V3<R>,
    lit: V3<R>,
    density: R,
    departure: V3<R>,
    throughput: L::Throughputs<R>,
}

impl<R: Real, L: Abreast> Paths<R, L> {
    #[inline(always)]
    fn put(&self, rows: &mut Rows<PATH_ROWS>, columns: Packed<R>) {
        rows.put(SAMPLE, columns, R::of_bits(self.sample));
        rows.put_vector(ORIGIN, columns, self.rays.origin);
        rows.put_vector(HEADING, columns, self.rays.direction);
        rows.put(ETA, columns, self.eta);
        rows.put(WEIGHED, columns, R::one().only(self.weighed));
        rows.put_vector(LAST, columns, self.last);
        rows.put_vector(LIT, columns, self.lit);
        rows.put(DENSITY, columns, self.density);
        rows.put_vector(DEPARTURE, columns, self.departure);
        L::put(rows, THROUGHPUT, columns, &self.throughput);
    }

    #[inline(always)]
    fn taken(rows: &Rows<PATH_ROWS>, columns: Columns<R>) -> Self {
        Self {
            sample: rows.get(SAMPLE, columns).bits(),
            rays: rays(rows, columns),
            eta: rows.get(ETA, columns),
            weighed: rows.get(WEIGHED, columns).gt(R::zero()),
            last: rows.vector(LAST, columns),
            lit: rows.vector(LIT, columns),
            density: rows.get(DENSITY, columns),
            departure: rows.vector(DEPARTURE, columns),
            throughput: L::taken(rows, THROUGHPUT, columns),
        }
    }
}

/// The next rays of paths.
#[inline(always)]
fn rays<R: Real>(rows: &Rows<PATH_ROWS>, columns: Columns<R>) -> Rays<R> {
    Rays {
        origin: rows.vector(ORIGIN, columns),
        direction: rows.vector(HEADING, columns),
        t_max: R::splat(f32::INFINITY),
    }
}

/// The wavelengths of camera samples.
#[inline(always)]
fn wavelengths<R: Real, L: Abreast>(rows: &Rows<SAMPLE_ROWS>, columns: Columns<R>) -> L::Values<R> {
    let mut all = L::values(R::zero());
    for (w, value) in all.as_mut().iter_mut().enumerate() {
        *value = rows.get(WAVELENGTHS + w, columns);
    }
    all
}

impl<R: Real> Surfaces<R> {
    #[inline(always)]
    fn put(&self, rows: &mut Rows<SURFACE_ROWS>, columns: Packed<R>) {
        rows.put_vector(POSITION, columns, self.position);
        rows.put_vector(ERROR, columns, self.error);
        rows.put_vector(NORMAL, columns, self.normal);
        rows.put_vector(AXES, columns, self.axes.s);
        rows.put_vector(AXES + 3, columns, self.axes.t);
        rows.put_vector(AXES + 6, columns, self.axes.n);
    }

    #[inline(always)]
    fn taken(rows: &Rows<SURFACE_ROWS>, columns: Columns<R>) -> Self {
        Self {
            position: rows.vector(POSITION, columns),
            error: rows.vector(ERROR, columns),
            normal: rows.vector(NORMAL, columns),
            axes: Axes {
                s: rows.vector(AXES, columns),
                t: rows.vector(AXES + 3, columns),
                n: rows.vector(AXES + 6, columns),
            },
        }
    }
}

#[inline(always)]
fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let ratio = other / own;
    (R::one() + ratio * ratio).recip()
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
struct Looked<R: Real, V> {
    connections: Connections<R>,
    /// Density of the connection, the choice of its source included.
    density: R,
    shine: Shine<V, R>,
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

part!(Leave<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, list: usize, columns: Columns<R>, lanes: R::M,
    longer: usize) -> usize: Link::<L::Stokes>::leave_one::<R, L>);
part!(AddSources<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, columns: Columns<R>, rays: &'a Rays<R>,
    met: &'a Encounters<R>, numbers: &'a [u32; MOST], sources: u32) -> (): Link::<L::Stokes>::add_sources::<R, L>);
part!(PassOn<'a, 'b; R, L: Abreast>(link: &'a mut Link<'b, L::Stokes>, from: &'a Surfaces<R>,
    connections: &'a Connections<R>, wavelengths: &'a L::Values<R>, through: &'a mut L::Throughputs<R>, room: u32,
    lanes: R::M) -> R::M: Link::<L::Stokes>::pass_on::<R, L>);
part!(Look<'a; R, L: Abreast>(scene: &'a Scene, at: &'a Surfaces<R>, lit: &'a Axes<R>, choice: R, u: [R; 2],
    wavelengths: &'a L::Values<R>, lanes: R::M) -> Option<Looked<R, L::Values<R>>>: look::<R, L>);

impl<S> Link<'_, S> {
    /// Finds what paths meet; collects the light of sources, and sorts paths by the matter that they have met.
    #[inline(always)]
    fn meet<R: Real, L: Abreast<Stokes = S>>(&mut self) {
        let (scene, depth) = (self.scene, self.depth);
        self.front.waiting.clear();
        for first in (0..self.front.count).step_by(R::LANES) {
            let lanes = R::first(self.front.count - first);
            let columns = Columns::From(first);
            let mut rays = rays::<R>(&self.front.paths, columns);
            self.counters.rays += count(lanes.bits());
            let mut met = scene.meet(&rays, lanes, self.stack);
            let show = !self.options.hide_emitters || depth > 1;
            if !show {
                self.look_beyond(&mut rays, &mut met, lanes);
            }
            self.collect::<R, L>(columns, &rays, &met, lanes, show);
            let alive = lanes & met.exist;
            if depth >= self.options.max_depth || !alive.any() {
                continue;
            }
            met.surfaces
                .put(&mut self.front.met, Packed::new(first, R::everywhere()));
            let behind = rays.direction.dot(met.surfaces.axes.n).gt(R::zero()).bits();
            each(alive.bits(), |lane| {
                let material = met.materials[lane];
                if !scene.traits_of(material).black {
                    let back = (behind >> lane & 1) as usize;
                    let list = 2 * material as usize + back;
                    self.front.waiting.push(list, (first + lane) as u32);
                }
            });
        }
    }

    /// Sends paths on, one kind of matter after the other.
    #[inline(always)]
    fn leave<R: Real, L: Abreast<Stokes = S>>(&mut self) {
        let mut longer = 0;
        for list in 0..self.front.waiting.begun.len() {
            let list = self.front.waiting.begun[list];
            let paths = std::mem::take(&mut self.front.waiting.lists[list]);
            for some in paths.chunks(R::LANES) {
                let lanes = R::first(some.len());
                let columns = Columns::listed(some);
                longer += R::apart(Leave::<R, L> {
                    link: &mut *self,
                    list,
                    columns,
                    lanes,
                    longer,
                });
            }
            self.front.waiting.lists[list] = paths;
        }
        std::mem::swap(&mut self.front.paths, &mut self.front.longer);
        self.front.count = longer;
    }

    /// Sends on paths that have met the same matter on the same side; those that go on are put from column `first` on.
    /// Returns how many do.
    #[inline(always)]
    fn leave_one<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        list: usize,
        columns: Columns<R>,
        lanes: R::M,
        first: usize,
    ) -> usize {
        let (scene, depth) = (self.scene, self.depth);
        let last = self.options.max_depth;
        let mut paths = Paths::<R, L>::taken(&self.front.paths, columns);
        let surfaces = Surfaces::taken(&self.front.met, columns);
        let of_samples = Columns::Each(paths.sample);
        let stratified = self.front.stratified;
        let stream = Stream::taken(&self.front.samples, STREAM, of_samples, stratified);
        let wavelengths = wavelengths::<R, L>(&self.front.samples, of_samples);
        let dimension = FIRST_VERTEX + PER_VERTEX * (depth - 1);
        let mut alive = lanes;

        // end weak paths: those that no light can make strong at the sensor
        if depth > self.options.rr_depth {
            let [roulette, _] = stream.pairs(R::B::splat(dimension + ROULETTE));
            let reach = L::reaches(&paths.throughput);
            let survival = (reach * paths.eta * paths.eta).min(R::splat(0.95));
            alive = alive & roulette.lt(survival);
            L::scale_lanes(&mut paths.throughput, survival.recip());
            if !alive.any() {
                return 0;
            }
        }

        let (number, back) = (list / 2, list % 2 == 1);
        let traits = scene.traits_of(number as u32);
        let material = side(&scene.materials[number], back);
        let axes = surfaces.axes;
        let o_world = -paths.rays.direction;
        let o = axes.to_local(o_world);
        let lit = axes.flipped_where(o.z.lt(R::zero()));
        let mut at = Vertices {
            o,
            position: surfaces.position,
            axes,
            sights: L::sights(&paths.throughput),
        };
        at.sights.axis = axes.to_local(at.sights.axis);
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
                self.connect(ways, &surfaces, &looked, alive);
            }
        }
        // a longer path would meet nothing that shines
        if scene.emitters_are_unmet() && depth.saturating_add(1) >= last {
            return 0;
        }

        let mut numbers = [drawn; 3];
        if material.numbers() > 1 {
            let [u, v] = stream.pairs(R::B::splat(dimension + DIRECTION));
            numbers = [drawn, u, v];
        }
        let way = material.depart::<R, L>(&at, &wavelengths, numbers, alive);
        let answers = L::to_world(&way.answers, &at.axes);
        let direction = at.axes.to_world(way.direction);
        let weight = way.density.recip();
        let throughput = L::extended(&paths.throughput, &answers, weight, o_world, direction);
        let on = alive & way.exist & L::strengths(&throughput).gt(R::zero());
        let kept = on.bits();
        if kept == 0 {
            return 0;
        }
        Paths::<R, L> {
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
            throughput,
        }
        .put(&mut self.front.longer, Packed::new(first, on));
        kept.count_ones() as usize
    }

    /// Adds the light of sources that vertices have looked for.
    #[inline(always)]
    fn connect<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        (paths, material, at, wavelengths): (&Paths<R, L>, &Material, &Vertices<R>, &L::Values<R>),
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
        let (answers, own) = material.answer::<R, L>(at, i, wavelengths, ask);
        let lit = ask & own.gt(R::zero());
        if !lit.any() {
            return;
        }
        let answers = L::to_world(&answers, &at.axes);
        let share = power_heuristic(looked.density, own);
        let share = R::select(found.discrete, R::one(), share);
        let weight = share * found.weight / looked.density;
        let (o, k) = (-paths.rays.direction, -found.direction);
        if scene.traits().straight {
            let mut through = L::extended(&paths.throughput, &answers, weight, o, found.direction);
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
                let more =
                    L::seen_through(&paths.throughput, &answers, o, &looked.shine, k, weight);
                L::add_to(self.sums, paths.sample, &more, free);
            }
        }
    }

    /// The first surfaces that do not shine.
    #[inline(always)]
    fn look_beyond<R: Real>(&mut self, rays: &mut Rays<R>, met: &mut Encounters<R>, lanes: R::M) {
        loop {
            let mut shining = 0;
            each((lanes & met.exist).bits(), |lane| {
                shining |= u32::from(met.emitters[lane] != NONE) << lane;
            });
            if shining == 0 {
                return;
            }
            self.counters.rays += count(shining);
            let lanes = R::M::from_bits(shining);
            let s = &met.surfaces;
            let origin = offset_origins(s.position, s.error, s.normal, rays.direction);
            rays.origin = V3::select(lanes, origin, rays.origin);
            let behind = self.scene.meet(rays, lanes, self.stack);
            met.exist = (met.exist & !lanes) | (behind.exist & lanes);
            met.surfaces = Surfaces::select(lanes, &behind.surfaces, &met.surfaces);
            each(shining, |lane| {
                met.materials[lane] = behind.materials[lane];
                met.emitters[lane] = behind.emitters[lane];
            });
        }
    }

    /// Collects the light of emitters that paths have met.
    #[inline(always)]
    fn collect<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        columns: Columns<R>,
        rays: &Rays<R>,
        met: &Encounters<R>,
        lanes: R::M,
        show: bool,
    ) {
        let scene = self.scene;
        let front = rays.direction.dot(met.surfaces.normal).lt(R::zero());
        let mut numbers = met.emitters;
        let mut sources = 0;
        each((lanes & met.exist & front).bits(), |lane| {
            sources |= u32::from(numbers[lane] != NONE) << lane;
        });
        let missed = (lanes & !met.exist).bits();
        if let Some(all_around) = scene.environment {
            each(missed, |lane| numbers[lane] = all_around);
            sources |= missed;
        }
        if sources != 0 && show {
            R::apart(AddSources::<R, L> {
                link: &mut *self,
                columns,
                rays,
                met,
                numbers: &numbers,
                sources,
            });
        }
    }

    /// The same for each emitter.
    #[inline(always)]
    fn add_sources<R: Real, L: Abreast<Stokes = S>>(
        &mut self,
        columns: Columns<R>,
        rays: &Rays<R>,
        met: &Encounters<R>,
        numbers: &[u32; MOST],
        sources: u32,
    ) {
        let scene = self.scene;
        let k = -rays.direction;
        let rows = &self.front.paths;
        let sample = rows.get(SAMPLE, columns).bits();
        let wavelengths = wavelengths::<R, L>(&self.front.samples, Columns::Each(sample));
        let throughput = L::taken(rows, THROUGHPUT, columns);
        let all_weighed = rows.get(WEIGHED, columns).gt(R::zero());
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
            each(open.bits(), |lane| {
                let straight = scene.traits_of(met.materials[lane]).straight;
                flat |= u32::from(straight) << lane;
            });
            open = open & R::M::from_bits(flat);
            let axes = met.surfaces.axes;
            let front = Vertices {
                o: axes.to_local(-direction),
                position: met.surfaces.position,
                axes,
                sights: Sights {
                    axis: axes.s,
                    linear: [R::zero(); 2],
                },
            };
            let behind = front.o.z.le(R::zero());
            for (number, group) in groups::<R>(&met.materials, open.bits()) {
                let material = &scene.materials[number as usize];
                for back in [false, true] {
                    let lanes = group & if back { behind } else { !behind };
                    if !lanes.any() {
                        continue;
                    }
                    let turned = back && matches!(material, Material::TwoSided(_));
                    let at = if turned { front.turned() } else { front };
                    let answers = side(material, back).pass::<R, L>(&at, wavelengths, lanes);
                    let answers = L::to_world(&answers, &at.axes);
                    let longer = L::extended(through, &answers, R::one(), -direction, direction);
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
fn look<R: Real, L: Abreast>(
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
    for (number, mask) in groups::<R>(&numbers, lanes.bits()) {
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
