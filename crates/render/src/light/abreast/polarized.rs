//! Polarized light side by side.

use glam::{Mat4, Vec3A, Vec4, vec4};

use super::algebra::{
    Matrices, arriving, element_beside, element_times_vector, polarized_along, scaled_vector,
    state_of, times_vector,
};
use super::throughput::Throughputs;
use super::{Abreast, Elements, Shine, Sights, each_wavelength};
use crate::lanes::{Axes, Bits, Columns, MOST, Mask, Packed, Real, Rows, V3, each};
use crate::light::{MuellerResponse, Polarized};

/// Polarized light of `N` wavelengths and `S` Stokes components: all four, or three where no light is circular.
#[derive(Clone, Copy, Debug)]
pub struct Stokes<const N: usize, const S: usize>;

/// What matter does to light, a path a lane; `N` wavelengths, `S` Stokes components.
#[derive(Clone, Copy, Debug)]
pub enum Answers<R, const N: usize, const S: usize> {
    /// Only M00.
    Depolarizing([R; N]),
    /// Diagonal in the frame of an axis on both sides.
    Diagonal(V3<R>, [Elements<R>; N]),
    /// Any matrix, from the frame of the second axis to that of the first.
    General(V3<R>, V3<R>, [Matrices<R, S>; N]),
}

/// What sensors see, a path a lane.
#[derive(Clone, Copy, Debug)]
pub enum Seen<R, const N: usize, const S: usize> {
    /// A Stokes vector a wavelength.
    Polarized([[R; S]; N]),
    /// S0 a wavelength, where the path makes no polarized light.
    Intensity([R; N]),
}

/// What of a throughput is seen: a Stokes vector each wavelength, or where it shows no more its first component.
macro_rules! seen_through {
    ($throughput:expr, $w:ident, $value:expr) => {
        if $throughput.shows_intensity_alone() {
            Seen::Intensity(each_wavelength!($w, R::zero(), $value[0]))
        } else {
            Seen::Polarized(each_wavelength!($w, [R::zero(); S], $value))
        }
    };
}

impl<const N: usize, const S: usize> Abreast for Stokes<N, S> {
    type Single = Polarized<N>;
    type Stokes = [Vec4; N];
    type Response = MuellerResponse<N>;
    const LANES: usize = N;
    const POLARIZED: bool = true;

    type Values<R: Real> = [R; N];
    type Diagonals<R: Real> = [Elements<R>; N];
    type Answers<R: Real> = Answers<R, N, S>;
    type Throughputs<R: Real> = Throughputs<R, N, S>;
    type Seen<R: Real> = Seen<R, N, S>;

    #[inline(always)]
    fn values<R: Real>(value: R) -> [R; N] {
        [value; N]
    }
    #[inline(always)]
    fn diagonals<R: Real>(element: Elements<R>) -> [Elements<R>; N] {
        [element; N]
    }
    #[inline(always)]
    fn depolarizing_lanes<R: Real>(m00: [R; N]) -> Answers<R, N, S> {
        Answers::Depolarizing(m00)
    }
    #[inline(always)]
    fn diagonal_lanes<R: Real>(axis: V3<R>, elements: &[Elements<R>; N]) -> Answers<R, N, S> {
        Answers::Diagonal(axis, *elements)
    }
    #[inline(always)]
    fn general_lanes<R: Real>(axis: V3<R>, matrix: &Mat4, factors: &[R; N]) -> Answers<R, N, S> {
        let columns = matrix.to_cols_array_2d();
        let none = [[R::zero(); S]; S];
        let matrices = each_wavelength!(w, none, {
            let mut m = none;
            for (to, from) in m.iter_mut().zip(&columns) {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = R::splat(*from) * factors[w];
                }
            }
            m
        });
        Answers::General(axis, axis, matrices)
    }
    #[inline(always)]
    fn coated_lanes<R: Real>(
        (axis, surface): (V3<R>, &[Elements<R>; N]),
        last: (V3<R>, Elements<R>),
        weights: &[R; N],
        first: (V3<R>, Elements<R>),
        [o, i]: [V3<R>; 2],
    ) -> Answers<R, N, S> {
        let column = polarized_along(axis, last, o);
        let row = polarized_along(axis, first, -i);
        let none = [[R::zero(); S]; S];
        let matrices = each_wavelength!(
            w,
            none,
            element_beside(&surface[w], column, weights[w], row)
        );
        Answers::General(axis, axis, matrices)
    }
    #[inline(always)]
    fn gathered<R: Real>(
        lanes: u32,
        o: &[Vec3A; MOST],
        i: &[Vec3A; MOST],
        mut f: impl FnMut(usize) -> MuellerResponse<N>,
    ) -> Answers<R, N, S> {
        let mut axes = [[Vec3A::X; MOST]; 2];
        let mut matrices = [[[[0.0; MOST]; S]; S]; N];
        each(lanes, |lane| {
            let ([out, inward], matrix) = f(lane).whole(o[lane], i[lane]);
            axes[0][lane] = out;
            axes[1][lane] = inward;
            for (to, from) in matrices.iter_mut().zip(matrix) {
                for (column, values) in to.iter_mut().enumerate() {
                    for (row, value) in values.iter_mut().enumerate() {
                        value[lane] = from.col(column)[row];
                    }
                }
            }
        });
        let mut all = [[[R::zero(); S]; S]; N];
        for (to, from) in all.iter_mut().zip(&matrices) {
            for column in 0..S {
                for row in 0..S {
                    to[column][row] = R::from_fn(|lane| from[column][row][lane]);
                }
            }
        }
        Answers::General(V3::from_lanes(&axes[0]), V3::from_lanes(&axes[1]), all)
    }
    #[inline(always)]
    fn to_world<R: Real>(answer: &mut Answers<R, N, S>, axes: &Axes<R>) {
        match answer {
            Answers::Depolarizing(_) => {}
            Answers::Diagonal(axis, _) => *axis = axes.to_world(*axis),
            Answers::General(out, inward, _) => {
                *out = axes.to_world(*out);
                *inward = axes.to_world(*inward);
            }
        }
    }
    #[inline(always)]
    fn beginning<R: Real>(axis: V3<R>) -> Throughputs<R, N, S> {
        Throughputs::Unit { axis }
    }
    #[inline(always)]
    fn extended<R: Real>(
        throughput: &Throughputs<R, N, S>,
        answer: &Answers<R, N, S>,
        weight: R,
        k_out: V3<R>,
    ) -> Throughputs<R, N, S> {
        throughput.extended(answer, weight, k_out)
    }
    #[inline(always)]
    fn select<R: Real>(
        mask: R::M,
        a: &Throughputs<R, N, S>,
        b: &Throughputs<R, N, S>,
    ) -> Throughputs<R, N, S> {
        Throughputs::select(mask, a, b)
    }
    #[inline(always)]
    fn seen<R: Real>(
        throughput: &Throughputs<R, N, S>,
        light: &Shine<[R; N], R>,
        k: V3<R>,
        weight: R,
    ) -> Seen<R, N, S> {
        match &light.state {
            None => seen_through!(
                throughput,
                w,
                throughput.times_unpolarized(w, light.radiance[w] * weight)
            ),
            Some((axis, states)) => {
                let turn = throughput.turn_to(*axis, k);
                seen_through!(throughput, w, {
                    let s0 = light.radiance[w] * weight;
                    let state = state_of(s0, [states[0][w], states[1][w], states[2][w]]);
                    throughput.times(w, state, turn)
                })
            }
        }
    }
    #[inline(always)]
    fn seen_through<R: Real>(
        throughput: &Throughputs<R, N, S>,
        answer: &Answers<R, N, S>,
        k_out: V3<R>,
        light: &Shine<[R; N], R>,
        k_in: V3<R>,
        weight: R,
    ) -> Seen<R, N, S> {
        match answer {
            // a first depolarizer hides what the sensor sees of polarization
            Answers::Depolarizing(m00) if matches!(throughput, Throughputs::Unit { .. }) => {
                Seen::Intensity(each_wavelength!(
                    w,
                    R::zero(),
                    m00[w] * light.radiance[w] * weight
                ))
            }
            Answers::Depolarizing(m00) => seen_through!(
                throughput,
                w,
                scaled_vector(
                    throughput.first_column(w),
                    m00[w] * light.radiance[w] * weight
                )
            ),
            Answers::Diagonal(axis, elements) => {
                let turn = throughput.turn_to(*axis, k_out);
                if light.state.is_none() {
                    // of the element the first column is enough
                    return seen_through!(throughput, w, {
                        let (e, radiance) = (&elements[w], light.radiance[w] * weight);
                        let after = [e.mean * radiance, e.difference * radiance];
                        throughput.times_linear(w, after, turn)
                    });
                }
                let light = arriving(*axis, light, k_in, weight);
                seen_through!(throughput, w, {
                    let (e, v) = (&elements[w], light[w]);
                    throughput.times(w, element_times_vector(e, v), turn)
                })
            }
            Answers::General(out, inward, matrices) => {
                let turn = throughput.turn_to(*out, k_out);
                if light.state.is_none() {
                    return seen_through!(throughput, w, {
                        let column = matrices[w][0];
                        let after = scaled_vector(column, light.radiance[w] * weight);
                        throughput.times(w, after, turn)
                    });
                }
                let light = arriving(*inward, light, k_in, weight);
                seen_through!(throughput, w, {
                    throughput.times(w, times_vector(&matrices[w], light[w]), turn)
                })
            }
        }
    }
    #[inline(always)]
    fn add_to<R: Real>(sums: &mut [[Vec4; N]], samples: R::B, seen: &Seen<R, N, S>, lanes: R::M) {
        let samples = samples.lanes();
        match seen {
            Seen::Intensity(seen) => {
                for w in 0..N {
                    let s0 = seen[w].lanes();
                    each(lanes.bits(), |lane| {
                        sums[samples[lane] as usize][w].x += s0[lane];
                    });
                }
            }
            Seen::Polarized(seen) => {
                for w in 0..N {
                    let mut components = [[0.0; MOST]; 4];
                    for (to, component) in components.iter_mut().zip(&seen[w]) {
                        *to = component.lanes();
                    }
                    let [a, b, c, d] = components;
                    each(lanes.bits(), |lane| {
                        let more = vec4(a[lane], b[lane], c[lane], d[lane]);
                        sums[samples[lane] as usize][w] += more;
                    });
                }
            }
        }
    }
    #[inline(always)]
    fn kind<R: Real>(throughput: &Throughputs<R, N, S>) -> usize {
        throughput.kind()
    }
    #[inline(always)]
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Throughputs<R, N, S> {
        Throughputs::taken(rows, row, columns, kind)
    }
    #[inline(always)]
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Throughputs<R, N, S> {
        Throughputs::taken_for_unpolarized(rows, row, columns, kind)
    }
    #[inline(always)]
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &Throughputs<R, N, S>,
    ) {
        throughput.put(rows, row, columns);
    }
    #[inline(always)]
    fn strengths<R: Real>(throughput: &Throughputs<R, N, S>) -> R {
        let mut most = throughput.first_column(0)[0];
        for w in 1..N {
            most = most.max(throughput.first_column(w)[0]);
        }
        most
    }
    #[inline(always)]
    fn reaches<R: Real>(throughput: &Throughputs<R, N, S>) -> R {
        let mut most = R::zero();
        for w in 0..N {
            let [s0, across @ ..] = &throughput.first_column(w)[..] else {
                continue;
            };
            let mut squared = R::zero();
            for component in across {
                squared = squared + *component * *component;
            }
            most = most.max(*s0 + squared.sqrt());
        }
        most
    }
    #[inline(always)]
    fn sights<R: Real>(throughput: &Throughputs<R, N, S>) -> Sights<R> {
        throughput.sights()
    }
    #[inline(always)]
    fn scaled_lanes<R: Real>(throughput: &Throughputs<R, N, S>, weight: R) -> Throughputs<R, N, S> {
        throughput.scaled(weight)
    }
}
