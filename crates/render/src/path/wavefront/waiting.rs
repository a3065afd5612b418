//! What of paths waits in rows until lanes take it up.

use glam::Vec3A;

use crate::lanes::{Axes, Columns, Packed, Real, Rows, V3};
use crate::light::abreast::Abreast;
use crate::sampler::STREAM_ROWS;
use crate::shape::abreast::{Rays, Surfaces};

/// Most wavelengths of a path.
pub(super) const WAVES: usize = 4;

// rows of camera samples
pub(super) const STREAM: usize = 0;
pub(super) const WAVELENGTHS: usize = STREAM + STREAM_ROWS;
pub(super) const SAMPLE_ROWS: usize = WAVELENGTHS + WAVES;

// rows of paths: the camera sample; the next ray; the ratio of the indices along the path; the last vertex with a
// continuous lobe, if there was one, its normal on the camera's side, the density of its direction, that direction, and
// whether nothing has bent the path since; the throughput
pub(super) const SAMPLE: usize = 0;
pub(super) const ORIGIN: usize = SAMPLE + 1;
pub(super) const HEADING: usize = ORIGIN + 3;
pub(super) const ETA: usize = HEADING + 3;
pub(super) const WEIGHED: usize = ETA + 1;
pub(super) const LAST: usize = WEIGHED + 1;
pub(super) const LIT: usize = LAST + 3;
pub(super) const DENSITY: usize = LIT + 3;
pub(super) const DEPARTURE: usize = DENSITY + 1;
pub(super) const THROUGHPUT: usize = DEPARTURE + 3;
pub(super) const PATH_ROWS: usize = THROUGHPUT + 3 + 16 * WAVES;

// rows of surfaces
pub(super) const POSITION: usize = 0;
pub(super) const ERROR: usize = POSITION + 3;
pub(super) const NORMAL: usize = ERROR + 3;
pub(super) const AXES: usize = NORMAL + 3;
pub(super) const SURFACE_ROWS: usize = AXES + 9;

/// Paths side by side.
pub(super) struct Paths<R: Real> {
    pub(super) sample: R::B,
    pub(super) rays: Rays<R>,
    pub(super) eta: R,
    /// Where connections could have found what the path meets next.
    pub(super) weighed: R::M,
    pub(super) last: V3<R>,
    pub(super) lit: V3<R>,
    pub(super) density: R,
    pub(super) departure: V3<R>,
}

impl<R: Real> Paths<R> {
    /// Lets them wait, with their throughputs; what weighs light that is met only if there is any.
    #[inline(always)]
    pub(super) fn put<L: Abreast>(
        &self,
        throughput: &L::Throughputs<R>,
        rows: &mut Rows<PATH_ROWS>,
        columns: Packed<R>,
        weighs: bool,
    ) {
        rows.put(SAMPLE, columns, R::of_bits(self.sample));
        rows.put_vector(ORIGIN, columns, self.rays.origin);
        rows.put_vector(HEADING, columns, self.rays.direction);
        rows.put(ETA, columns, self.eta);
        if weighs {
            rows.put(WEIGHED, columns, R::one().only(self.weighed));
            rows.put_vector(LAST, columns, self.last);
            rows.put_vector(LIT, columns, self.lit);
            rows.put(DENSITY, columns, self.density);
            rows.put_vector(DEPARTURE, columns, self.departure);
        }
        L::put(rows, THROUGHPUT, columns, throughput);
    }

    /// Takes them up, but for their throughputs: those are large, and are best made where they stay.
    #[inline(always)]
    pub(super) fn taken(rows: &Rows<PATH_ROWS>, columns: Columns<R>, weighs: bool) -> Self {
        let unknown = V3::splat(Vec3A::Z);
        let mut paths = Self {
            sample: rows.get(SAMPLE, columns).bits(),
            rays: rays(rows, columns),
            eta: rows.get(ETA, columns),
            weighed: R::nowhere(),
            last: unknown,
            lit: unknown,
            density: R::one(),
            departure: unknown,
        };
        if weighs {
            paths.weighed = rows.get(WEIGHED, columns).gt(R::zero());
            paths.last = rows.vector(LAST, columns);
            paths.lit = rows.vector(LIT, columns);
            paths.density = rows.get(DENSITY, columns);
            paths.departure = rows.vector(DEPARTURE, columns);
        }
        paths
    }
}

/// The next rays of paths.
#[inline(always)]
pub(super) fn rays<R: Real>(rows: &Rows<PATH_ROWS>, columns: Columns<R>) -> Rays<R> {
    Rays {
        origin: rows.vector(ORIGIN, columns),
        direction: rows.vector(HEADING, columns),
        t_max: R::splat(f32::INFINITY),
    }
}

impl<R: Real> Surfaces<R> {
    #[inline(always)]
    pub(super) fn put(&self, rows: &mut Rows<SURFACE_ROWS>, columns: Packed<R>) {
        rows.put_vector(POSITION, columns, self.position);
        rows.put_vector(ERROR, columns, self.error);
        rows.put_vector(NORMAL, columns, self.normal);
        rows.put_vector(AXES, columns, self.axes.s);
        rows.put_vector(AXES + 3, columns, self.axes.t);
        rows.put_vector(AXES + 6, columns, self.axes.n);
    }

    #[inline(always)]
    pub(super) fn taken(rows: &Rows<SURFACE_ROWS>, columns: Columns<R>) -> Self {
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
