//! Scalar transport: the algebra of S0 alone.

use glam::{Mat4, Vec3, Vec3A, Vec4, vec4};

use super::{Element, Emission, Light, Sight};

/// Scalar transport: S0 alone.
#[derive(Clone, Copy, Debug)]
pub struct Intensity<const N: usize>;

impl<const N: usize> Light for Intensity<N> {
    const LANES: usize = N;
    const POLARIZED: bool = false;
    type Response = [f32; N];
    type Throughput = [f32; N];
    type Lanes = [f32; N];
    type States = ();
    type Stokes = [Vec4; N];

    #[inline]
    fn lanes(value: impl Fn(usize) -> f32) -> [f32; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn states(_: impl Fn(usize) -> Vec3) {}
    #[inline]
    fn dark() -> [Vec4; N] {
        [Vec4::ZERO; N]
    }
    #[inline]
    fn depolarizing(value: impl Fn(usize) -> f32) -> [f32; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn diattenuating_retarder(_: Vec3A, element: impl Fn(usize) -> Element) -> [f32; N] {
        std::array::from_fn(|lane| element(lane).mean)
    }
    #[inline]
    fn depolarizer_between(
        last: (Vec3A, Element),
        weight: impl Fn(usize) -> f32,
        first: (Vec3A, Element),
    ) -> [f32; N] {
        std::array::from_fn(|lane| last.1.mean * weight(lane) * first.1.mean)
    }
    #[inline]
    fn general(_: Vec3A, _: Vec3A, matrix: impl Fn(usize) -> Mat4) -> [f32; N] {
        std::array::from_fn(|lane| matrix(lane).x_axis.x)
    }
    #[inline]
    fn sum(a: [f32; N], b: [f32; N], _: Vec3A, _: Vec3A) -> [f32; N] {
        std::array::from_fn(|lane| a[lane] + b[lane])
    }
    #[inline]
    fn map_axes(response: [f32; N], _: impl Fn(Vec3A) -> Vec3A) -> [f32; N] {
        response
    }
    #[inline]
    fn identity(_: Vec3A) -> [f32; N] {
        [1.0; N]
    }
    #[inline]
    fn lengthen(throughput: &mut [f32; N], response: [f32; N], weight: f32, _: Vec3A) {
        for lane in 0..N {
            throughput[lane] *= response[lane] * weight;
        }
    }
    #[inline]
    fn as_response(throughput: &[f32; N], _: Vec3A) -> [f32; N] {
        *throughput
    }
    #[inline]
    fn collect(throughput: &[f32; N], source: &Emission<Self>, _: Vec3A) -> [Vec4; N] {
        std::array::from_fn(|lane| vec4(throughput[lane] * source.radiance[lane], 0., 0., 0.))
    }
    #[inline]
    fn collect_through(
        throughput: &[f32; N],
        response: [f32; N],
        _: Vec3A,
        source: &Emission<Self>,
        _: Vec3A,
    ) -> [Vec4; N] {
        std::array::from_fn(|lane| {
            vec4(
                throughput[lane] * response[lane] * source.radiance[lane],
                0.,
                0.,
                0.,
            )
        })
    }
    #[inline]
    fn accumulate(sum: &mut [Vec4; N], more: [Vec4; N], weight: f32) {
        for lane in 0..N {
            sum[lane].x += more[lane].x * weight;
        }
    }
    #[inline]
    fn strength(throughput: &[f32; N]) -> f32 {
        throughput.iter().copied().fold(0.0, f32::max)
    }
    #[inline]
    fn reach(throughput: &[f32; N]) -> f32 {
        Self::strength(throughput)
    }
    #[inline]
    fn sight(_: &[f32; N]) -> Sight {
        Sight::BLIND
    }

    #[inline]
    fn scale(throughput: &mut [f32; N], weight: f32) {
        for t in throughput {
            *t *= weight;
        }
    }
}
