//! Intensity side by side: polarization left aside.

use glam::{Mat4, Vec3A, Vec4};

use super::{Abreast, Elements, Shine, Sights, each_wavelength};
use crate::lanes::{Axes, Bits, Columns, MOST, Mask, Packed, Real, Rows, V3, each};
use crate::light::Intensity;

impl<const N: usize> Abreast for Intensity<N> {
    type Single = Self;
    type Stokes = [Vec4; N];
    type Response = [f32; N];
    const LANES: usize = N;
    const POLARIZED: bool = false;

    type Values<R: Real> = [R; N];
    type Diagonals<R: Real> = [Elements<R>; N];
    type Answers<R: Real> = [R; N];
    type Throughputs<R: Real> = [R; N];
    type Seen<R: Real> = [R; N];

    #[inline(always)]
    fn values<R: Real>(value: R) -> [R; N] {
        [value; N]
    }
    #[inline(always)]
    fn diagonals<R: Real>(element: Elements<R>) -> [Elements<R>; N] {
        [element; N]
    }
    #[inline(always)]
    fn depolarizing_lanes<R: Real>(m00: [R; N]) -> [R; N] {
        m00
    }
    #[inline(always)]
    fn diagonal_lanes<R: Real>(_: V3<R>, elements: &[Elements<R>; N]) -> [R; N] {
        each_wavelength!(i, R::zero(), elements[i].mean)
    }
    #[inline(always)]
    fn general_lanes<R: Real>(_: V3<R>, matrix: &Mat4, factors: &[R; N]) -> [R; N] {
        each_wavelength!(i, R::zero(), R::splat(matrix.x_axis.x) * factors[i])
    }
    #[inline(always)]
    fn coated_lanes<R: Real>(
        (_, surface): (V3<R>, &[Elements<R>; N]),
        (_, last): (V3<R>, Elements<R>),
        weights: &[R; N],
        (_, first): (V3<R>, Elements<R>),
        _: [V3<R>; 2],
    ) -> [R; N] {
        let both = last.mean * first.mean;
        each_wavelength!(w, R::zero(), surface[w].mean + both * weights[w])
    }
    #[inline(always)]
    fn gathered<R: Real>(
        lanes: u32,
        _: &[Vec3A; MOST],
        _: &[Vec3A; MOST],
        mut f: impl FnMut(usize) -> [f32; N],
    ) -> [R; N] {
        let mut all = [[0.0; MOST]; N];
        each(lanes, |lane| {
            for (to, value) in all.iter_mut().zip(f(lane)) {
                to[lane] = value;
            }
        });
        each_wavelength!(w, R::zero(), R::from_fn(|lane| all[w][lane]))
    }
    #[inline(always)]
    fn to_world<R: Real>(_: &mut [R; N], _: &Axes<R>) {}
    #[inline(always)]
    fn beginning<R: Real>(_: V3<R>) -> [R; N] {
        [R::one(); N]
    }
    #[inline(always)]
    fn extended<R: Real>(throughput: &[R; N], answer: &[R; N], weight: R, _: V3<R>) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * answer[w] * weight)
    }
    #[inline(always)]
    fn select<R: Real>(mask: R::M, a: &[R; N], b: &[R; N]) -> [R; N] {
        each_wavelength!(w, R::zero(), R::select(mask, a[w], b[w]))
    }
    #[inline(always)]
    fn seen<R: Real>(throughput: &[R; N], light: &Shine<[R; N], R>, _: V3<R>, weight: R) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * (light.radiance[w] * weight))
    }
    #[inline(always)]
    fn seen_through<R: Real>(
        throughput: &[R; N],
        answer: &[R; N],
        _: V3<R>,
        light: &Shine<[R; N], R>,
        _: V3<R>,
        weight: R,
    ) -> [R; N] {
        each_wavelength!(
            w,
            R::zero(),
            throughput[w] * (answer[w] * light.radiance[w] * weight)
        )
    }
    #[inline(always)]
    fn add_to<R: Real>(sums: &mut [[Vec4; N]], samples: R::B, seen: &[R; N], lanes: R::M) {
        let samples = samples.lanes();
        for w in 0..N {
            let s0 = seen[w].lanes();
            each(lanes.bits(), |lane| {
                sums[samples[lane] as usize][w].x += s0[lane];
            });
        }
    }
    #[inline(always)]
    fn kind<R: Real>(_: &[R; N]) -> usize {
        0
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        _: usize,
    ) -> [R; N] {
        each_wavelength!(w, R::zero(), rows.get(row + w, columns))
    }
    #[inline(always)]
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> [R; N] {
        Self::taken(rows, row, columns, kind)
    }
    #[inline(always)]
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &[R; N],
    ) {
        for (w, value) in throughput.iter().enumerate() {
            rows.put(row + w, columns, *value);
        }
    }
    #[inline(always)]
    fn strengths<R: Real>(throughput: &[R; N]) -> R {
        let mut most = throughput[0];
        for value in &throughput[1..] {
            most = most.max(*value);
        }
        most
    }
    #[inline(always)]
    fn reaches<R: Real>(throughput: &[R; N]) -> R {
        Self::strengths(throughput)
    }
    #[inline(always)]
    fn sights<R: Real>(_: &[R; N]) -> Sights<R> {
        Sights::blind(V3::splat(Vec3A::X))
    }
    #[inline(always)]
    fn scaled_lanes<R: Real>(throughput: &[R; N], weight: R) -> [R; N] {
        each_wavelength!(w, R::zero(), throughput[w] * weight)
    }
}
