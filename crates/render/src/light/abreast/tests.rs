//! Claim: a throughput of any kind, of four Stokes components or three, does what the whole matrices do that it stands for.

use std::num::Wrapping;

use glam::Vec4;

use super::polarized::{Answers, Stokes};
use super::throughput::Throughputs;
use super::{Abreast, Elements, KINDS, Shine};
use crate::lanes::{Columns, Packed, Rows, V3};
use crate::sampler::{SampleStream, uniform_sphere};

/// Wavelengths.
const N: usize = 2;
type T<const S: usize> = Throughputs<f32, N, S>;

/// Numbers are sums of at most sixteen products of factors up to 1; both ways round each at most twelve times.
const LIMIT: f32 = 2.0 * 12.0 * 16.0 * (0.5 * f32::EPSILON);

/// Random numbers from −1 to 1.
struct Numbers(SampleStream, u32);

impl Numbers {
    fn new(case: u64) -> Self {
        Self(SampleStream::new(3, 1, case), 0)
    }
    fn pair(&mut self) -> [f32; 2] {
        self.1 += 2;
        self.0.pair(self.1)
    }
    fn next(&mut self) -> f32 {
        2.0 * self.pair()[0] - 1.0
    }
    fn vector<const S: usize>(&mut self) -> [f32; S] {
        std::array::from_fn(|_| self.next())
    }
    fn matrices<const S: usize>(&mut self) -> [[[f32; S]; S]; N] {
        std::array::from_fn(|_| std::array::from_fn(|_| self.vector()))
    }
    /// A direction, and axes across it.
    fn frame(&mut self) -> (V3<f32>, [V3<f32>; 3]) {
        let k = uniform_sphere(self.pair());
        let (a, b) = k.any_orthonormal_pair();
        let mut axis = || {
            let (sin, cos) = (4.0 * self.next()).sin_cos();
            V3::splat(a * cos + b * sin)
        };
        (V3::splat(k), [axis(), axis(), axis()])
    }
    fn throughput<const S: usize>(&mut self, kind: usize, axis: V3<f32>) -> T<S> {
        let columns = std::array::from_fn(|_| self.vector());
        let rows = std::array::from_fn(|_| self.vector());
        let all = [
            Throughputs::Unit { axis },
            Throughputs::Whole {
                axis,
                matrices: self.matrices(),
            },
            Throughputs::Product {
                axis,
                columns,
                rows,
            },
            Throughputs::Column { columns },
            Throughputs::Row { axis, rows },
            Throughputs::Scalar {
                factors: rows.map(|row| row[0]),
            },
        ];
        assert_eq!(all[kind].kind(), kind);
        all[kind]
    }
    fn answers<const S: usize>(
        &mut self,
        out: V3<f32>,
        inward: V3<f32>,
    ) -> [Answers<f32, N, S>; 3] {
        let elements = std::array::from_fn(|_| {
            let [mean, difference, cosine, sine] = self.vector();
            Elements {
                mean,
                difference,
                cosine,
                sine,
            }
        });
        [
            Answers::Depolarizing(std::array::from_fn(|_| self.next())),
            Answers::Diagonal(out, elements),
            Answers::General(out, inward, self.matrices()),
        ]
    }
}

fn as_whole<const S: usize>(throughput: &T<S>, axis: V3<f32>) -> T<S> {
    let matrices = throughput.whole().1;
    Throughputs::Whole { axis, matrices }
}

/// Whether both are the same matrices in the same frame; what has no frame fits any.
fn agree<const S: usize>(a: &T<S>, b: &T<S>) -> bool {
    let ((axis_a, a_whole), (axis_b, b_whole)) = (a.whole(), b.whole());
    let free = |t: &T<S>| matches!(t, Throughputs::Column { .. } | Throughputs::Scalar { .. });
    let same = free(a) || free(b) || (axis_a - axis_b).squared() == 0.0;
    let (a, b) = (
        a_whole.as_flattened().as_flattened(),
        b_whole.as_flattened().as_flattened(),
    );
    same && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= LIMIT)
}

fn near<const S: usize>(a: [f32; S], b: [f32; S]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= LIMIT)
}

/// Every kind in turn, in random cases, with the whole matrices.
fn each_case<const S: usize>(
    mut check: impl FnMut(&T<S>, &T<S>, &mut Numbers, V3<f32>, [V3<f32>; 3]),
) {
    for case in 0..100 {
        for kind in 0..KINDS {
            let mut numbers = Numbers::new(case);
            let (k, axes) = numbers.frame();
            let throughput = numbers.throughput(kind, axes[0]);
            check(
                &throughput,
                &as_whole(&throughput, axes[0]),
                &mut numbers,
                k,
                axes,
            );
        }
    }
}

#[test]
fn matter_lengthens_all_kinds_alike() {
    lengthens::<3>();
    lengthens::<4>();
}

fn lengthens<const S: usize>() {
    each_case::<S>(|throughput, whole, numbers, k, [_, out, inward]| {
        for answer in numbers.answers(out, inward) {
            let weight = numbers.next();
            let longer = throughput.extended(&answer, weight, k);
            let expected = whole.extended(&answer, weight, k);
            assert!(agree(&longer, &expected), "{longer:?} {expected:?}");
            assert!(agree(&longer.scaled(0.7), &expected.scaled(0.7)));
        }
    });
}

#[test]
fn light_passes_all_kinds_alike() {
    passes::<3>();
    passes::<4>();
}

fn passes<const S: usize>() {
    each_case::<S>(|throughput, whole, numbers, k, [_, axis, _]| {
        let v: [f32; S] = numbers.vector();
        let (turn, turn_of_whole) = (throughput.turn_to(axis, k), whole.turn_to(axis, k));
        for w in 0..N {
            assert!(near(
                throughput.times(w, v, turn),
                whole.times(w, v, turn_of_whole)
            ));
            let linear = throughput.times_linear(w, [v[0], v[1]], turn);
            let mut state = [0.0; S];
            state[..2].copy_from_slice(&v[..2]);
            let expected = whole.times(w, state, turn_of_whole);
            assert!(near(linear, expected));
            assert!(near(throughput.first_column(w), whole.first_column(w)));
            // lanes with a polarized source and lanes without one share a function
            let mut state = [0.0; S];
            state[0] = v[0];
            let seen = throughput.times_unpolarized(w, v[0]);
            assert!(seen == throughput.times(w, state, turn));
        }
    });
}

#[test]
fn sensors_see_the_same_light_through_all_kinds() {
    shines::<3>();
    shines::<4>();
}

/// What is added to the sums of a camera sample.
fn added<const S: usize>(seen: <Stokes<N, S> as Abreast>::Seen<f32>) -> [Vec4; N] {
    let mut sums = [[Vec4::ZERO; N]; 2];
    Stokes::<N, S>::add_to::<f32>(&mut sums, Wrapping(1), &seen, true);
    assert_eq!(sums[0], [Vec4::ZERO; N]);
    sums[1]
}

fn shines<const S: usize>() {
    type L<const S: usize> = Stokes<N, S>;
    each_case::<S>(|throughput, whole, numbers, k, [axis, out, inward]| {
        let mut radiance = || std::array::from_fn(|_| numbers.next());
        let (radiance, state) = (radiance(), [radiance(), radiance(), radiance()]);
        for state in [None, Some((axis, state))] {
            let (light, weight) = (Shine { radiance, state }, numbers.next());
            let [seen, expected] =
                [throughput, whole].map(|t| added::<S>(L::<S>::seen(t, &light, k, weight)));
            for w in 0..N {
                assert!(near(seen[w].to_array(), expected[w].to_array()));
            }
            for answer in numbers.answers(out, inward) {
                let [seen, expected] = [throughput, whole]
                    .map(|t| added::<S>(L::<S>::seen_through(t, &answer, k, &light, k, weight)));
                for w in 0..N {
                    let (seen, expected) = (seen[w].to_array(), expected[w].to_array());
                    assert!(near(seen, expected), "{seen:?} {expected:?}");
                }
            }
        }
    });
}

#[test]
fn one_of_two_is_chosen_whatever_their_kinds() {
    chooses::<3>();
    chooses::<4>();
}

fn chooses<const S: usize>() {
    each_case::<S>(|throughput, _, numbers, _, [axis, ..]| {
        for kind in 0..KINDS {
            let other = numbers.throughput(kind, axis);
            assert!(agree(
                &Throughputs::select(true, throughput, &other),
                throughput
            ));
            assert!(agree(
                &Throughputs::select(false, throughput, &other),
                &other
            ));
        }
    });
}

#[test]
fn sensors_see_the_same_polarization_through_all_kinds() {
    sees::<3>();
    sees::<4>();
}

fn sees<const S: usize>() {
    each_case::<S>(|throughput, whole, _, k, [_, axis, _]| {
        let (sights, expected) = (throughput.sights(), whole.sights());
        let sum: f32 = (0..N).map(|w| whole.first_column(w)[0]).sum();
        // numbers below 0.05 make quotients of rounding
        if sum.abs() > 0.05 {
            let difference = sights.along(axis, k) - expected.along(axis, k);
            assert!(difference.abs() <= LIMIT / 0.05, "{difference}");
        }
    });
}

#[test]
fn what_waits_comes_back() {
    waits::<3>();
    waits::<4>();
}

fn waits<const S: usize>() {
    each_case::<S>(|throughput, _, _, _, [axis, ..]| {
        let mut rows = Rows::<{ 3 + 16 * N }>::default();
        throughput.put(&mut rows, 0, Packed::new(5, true));
        let kind = throughput.kind();
        let back = T::<S>::taken(&rows, 0, Columns::From(5), kind);
        assert!(back.kind() == kind && agree(&back, throughput));
        let mut light = [0.0; S];
        light[0] = 0.3;
        let part = T::<S>::taken_for_unpolarized(&rows, 0, Columns::From(5), kind);
        for w in 0..N {
            assert!(near(part.first_column(w), throughput.first_column(w)));
            let seen = part.times(w, light, (1.0, 0.0));
            assert!(near(
                seen,
                as_whole(throughput, axis).times(w, light, (1.0, 0.0))
            ));
        }
    });
}
