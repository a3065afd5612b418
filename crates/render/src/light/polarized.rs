//! Vector transport: light as Stokes vectors, matter and paths as Mueller matrices.

use glam::{Mat4, Vec3, Vec3A, Vec4};

use super::{Element, Emission, Light, MuellerResponse, MuellerThroughput, Sight};

/// Vector transport: S0, S1, S2, S3.
#[derive(Clone, Copy, Debug)]
pub struct Polarized<const N: usize>;

impl<const N: usize> Light for Polarized<N> {
    const LANES: usize = N;
    const POLARIZED: bool = true;
    type Response = MuellerResponse<N>;
    type Throughput = MuellerThroughput<N>;
    type Lanes = [f32; N];
    type States = [Vec3; N];
    type Stokes = [Vec4; N];

    #[inline]
    fn lanes(value: impl Fn(usize) -> f32) -> [f32; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn states(value: impl Fn(usize) -> Vec3) -> [Vec3; N] {
        std::array::from_fn(value)
    }
    #[inline]
    fn dark() -> [Vec4; N] {
        [Vec4::ZERO; N]
    }
    #[inline]
    fn depolarizing(value: impl Fn(usize) -> f32) -> Self::Response {
        MuellerResponse::Depolarizing(std::array::from_fn(value))
    }
    #[inline]
    fn diattenuating_retarder(axis: Vec3A, element: impl Fn(usize) -> Element) -> Self::Response {
        MuellerResponse::Diagonal {
            axis,
            elements: std::array::from_fn(element),
        }
    }
    #[inline]
    fn depolarizer_between(
        last: (Vec3A, Element),
        weight: impl Fn(usize) -> f32,
        first: (Vec3A, Element),
    ) -> Self::Response {
        MuellerResponse::depolarizer_between(last, weight, first)
    }
    #[inline]
    fn general(axis_out: Vec3A, axis_in: Vec3A, matrix: impl Fn(usize) -> Mat4) -> Self::Response {
        MuellerResponse::General {
            axis_out,
            axis_in,
            matrices: std::array::from_fn(matrix),
        }
    }
    #[inline]
    fn sum(a: Self::Response, b: Self::Response, k_out: Vec3A, k_in: Vec3A) -> Self::Response {
        MuellerResponse::sum(a, b, k_out, k_in)
    }
    #[inline]
    fn map_axes(response: Self::Response, turn: impl Fn(Vec3A) -> Vec3A) -> Self::Response {
        response.map_axes(turn)
    }

    #[inline]
    fn identity(axis: Vec3A) -> Self::Throughput {
        MuellerThroughput::Full {
            axis,
            matrices: [Mat4::IDENTITY; N],
        }
    }

    #[inline]
    fn lengthen(
        throughput: &mut Self::Throughput,
        response: Self::Response,
        weight: f32,
        k_out: Vec3A,
    ) {
        throughput.lengthen(response, weight, k_out);
    }
    fn as_response(throughput: &Self::Throughput, axis: Vec3A) -> Self::Response {
        throughput.as_response(axis)
    }
    #[inline]
    fn collect(throughput: &Self::Throughput, source: &Emission<Self>, k: Vec3A) -> [Vec4; N] {
        throughput.collect(source, k)
    }
    #[inline]
    fn collect_through(
        throughput: &Self::Throughput,
        response: Self::Response,
        k_out: Vec3A,
        source: &Emission<Self>,
        k_in: Vec3A,
    ) -> [Vec4; N] {
        throughput.collect_through(response, k_out, source, k_in)
    }
    #[inline]
    fn accumulate(sum: &mut [Vec4; N], more: [Vec4; N], weight: f32) {
        for lane in 0..N {
            sum[lane] += more[lane] * weight;
        }
    }

    #[inline]
    fn strength(throughput: &Self::Throughput) -> f32 {
        throughput.strength()
    }
    #[inline]
    fn reach(throughput: &Self::Throughput) -> f32 {
        throughput.reach()
    }
    #[inline]
    fn sight(throughput: &Self::Throughput) -> Sight {
        throughput.sight()
    }
    #[inline]
    fn scale(throughput: &mut Self::Throughput, weight: f32) {
        throughput.scale(weight);
    }
}
