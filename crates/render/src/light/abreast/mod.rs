//! The algebra of light for paths side by side: the same products as for one, a path a lane.

mod algebra;
mod intensity;
mod polarized;
#[cfg(test)]
mod tests;
mod throughput;

use glam::{Mat4, Vec3A, Vec4};

use super::{Element, Light, Sight};
use crate::lanes::{Axes, Columns, MOST, Packed, Real, Rows, V3};
use algebra::double_angles;

pub use polarized::Stokes;

/// Arrays of wavelengths, written out: closures that are not inlined would lose the instructions.
macro_rules! each_wavelength {
    ($i:ident, $initial:expr, $value:expr) => {{
        let mut all = [$initial; N];
        for ($i, place) in all.iter_mut().enumerate() {
            *place = $value;
        }
        all
    }};
}
use each_wavelength;

/// An [`Element`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Elements<R> {
    /// M00 = M11.
    pub mean: R,
    /// M01 = M10.
    pub difference: R,
    /// M22 = M33.
    pub cosine: R,
    /// M23 = −M32.
    pub sine: R,
}

impl<R: Real> Elements<R> {
    /// The same in all lanes.
    #[inline(always)]
    pub fn splat(element: Element) -> Self {
        Self {
            mean: R::splat(element.mean),
            difference: R::splat(element.difference),
            cosine: R::splat(element.cosine),
            sine: R::splat(element.sine),
        }
    }
    /// All four numbers times `weight`.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, weight: R) -> Self {
        Self {
            mean: self.mean * weight,
            difference: self.difference * weight,
            cosine: self.cosine * weight,
            sine: self.sine * weight,
        }
    }
    /// `a` where the mask holds, elsewhere `b`.
    #[inline(always)]
    pub fn select(mask: R::M, a: Self, b: Self) -> Self {
        Self {
            mean: R::select(mask, a.mean, b.mean),
            difference: R::select(mask, a.difference, b.difference),
            cosine: R::select(mask, a.cosine, b.cosine),
            sine: R::select(mask, a.sine, b.sine),
        }
    }
}

/// What light arrives with: radiance, and the state if it is polarized.
#[derive(Clone, Copy, Debug)]
pub struct Shine<V, R> {
    /// Radiance, or what the emitter has instead, a wavelength each.
    pub radiance: V,
    /// First axis of its Stokes frame, and S1, S2, S3 over S0, a wavelength each.
    pub state: Option<(V3<R>, [V; 3])>,
}

/// Which linearly polarized light a sensor sees rather than other light: [`Sight`] a lane.
#[derive(Clone, Copy, Debug)]
pub struct Sights<R> {
    /// First axis of its frame, across the ray.
    pub axis: V3<R>,
    /// S0 at the sensor that unit S1 and S2 make, over that of unit S0.
    pub linear: [R; 2],
}

impl<R: Real> Sights<R> {
    /// No polarization rather than another.
    #[inline(always)]
    pub fn blind(axis: V3<R>) -> Self {
        Self {
            axis,
            linear: [R::zero(); 2],
        }
    }
    /// One by one.
    #[inline(always)]
    pub fn lanes(&self) -> [Sight; MOST] {
        let axes = self.axis.lanes();
        let [a, b] = [self.linear[0].lanes(), self.linear[1].lanes()];
        let mut all = [Sight::BLIND; MOST];
        for (lane, sight) in all.iter_mut().enumerate().take(R::LANES) {
            *sight = Sight::new(axes[lane], [1.0, a[lane], b[lane]]);
        }
        all
    }
    /// How much rather it sees light polarized along `axis` than across it; `k` is the light's direction.
    #[inline(always)]
    pub fn along(&self, axis: V3<R>, k: V3<R>) -> R {
        let (cos, sin) = double_angles(self.axis, axis, k);
        self.linear[0] * cos + self.linear[1] * sin
    }
}

/// Kinds of throughputs, at most.
pub const KINDS: usize = 6;

/// Light along paths side by side.
pub trait Abreast: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// The same light along one path.
    type Single: Light<Stokes = Self::Stokes, Response = Self::Response>;
    /// See [`Light::Stokes`].
    type Stokes: Copy + AsRef<[Vec4]>;
    /// See [`Light::Response`].
    type Response: Copy;
    /// See [`Light::LANES`].
    const LANES: usize;
    /// See [`Light::POLARIZED`].
    const POLARIZED: bool;
    /// One number a wavelength.
    type Values<R: Real>: Copy + std::fmt::Debug + AsRef<[R]> + AsMut<[R]>;
    /// One element a wavelength.
    type Diagonals<R: Real>: Copy + AsMut<[Elements<R>]>;
    /// What matter does to light.
    type Answers<R: Real>: Copy;
    /// Products of these from the sensor to here.
    type Throughputs<R: Real>: Copy;
    /// One Stokes vector a wavelength.
    type Seen<R: Real>: Copy;

    /// The same number for each wavelength, to be filled in.
    fn values<R: Real>(value: R) -> Self::Values<R>;
    /// The same element for each wavelength, to be filled in.
    fn diagonals<R: Real>(element: Elements<R>) -> Self::Diagonals<R>;
    /// Matter that forgets polarization.
    fn depolarizing_lanes<R: Real>(m00: Self::Values<R>) -> Self::Answers<R>;
    /// Matter that is diagonal in the frame of `axis`.
    fn diagonal_lanes<R: Real>(axis: V3<R>, elements: &Self::Diagonals<R>) -> Self::Answers<R>;
    /// Matter with the same matrix in all lanes, times a factor, in the frame of `axis` on both sides.
    fn general_lanes<R: Real>(
        axis: V3<R>,
        matrix: &Mat4,
        factors: &Self::Values<R>,
    ) -> Self::Answers<R>;
    /// Reflection by a surface, diagonal in the frame of an axis across `o` and `i`, and beside it a depolarizer between two
    /// passages with their axes: see [`Light::depolarizer_between`] and [`Light::sum`]. `o` is the direction toward the
    /// sensor, `i` that toward the light.
    fn coated_lanes<R: Real>(
        surface: (V3<R>, &Self::Diagonals<R>),
        last: (V3<R>, Elements<R>),
        weights: &Self::Values<R>,
        first: (V3<R>, Elements<R>),
        ways: [V3<R>; 2],
    ) -> Self::Answers<R>;
    /// The answers of lanes that were asked one by one; `o` is the direction toward the sensor, `i` that toward the light.
    fn gathered<R: Real>(
        lanes: u32,
        o: &[Vec3A; MOST],
        i: &[Vec3A; MOST],
        f: impl FnMut(usize) -> Self::Response,
    ) -> Self::Answers<R>;
    /// Turns its axes, which are local, into the world.
    fn to_world<R: Real>(answer: &mut Self::Answers<R>, axes: &Axes<R>);
    /// The empty path in the frame of `axis`.
    fn beginning<R: Real>(axis: V3<R>) -> Self::Throughputs<R>;
    /// Longer by a vertex, weighted; `k_out` is the direction of light that leaves it.
    fn extended<R: Real>(
        throughput: &Self::Throughputs<R>,
        answer: &Self::Answers<R>,
        weight: R,
        k_out: V3<R>,
    ) -> Self::Throughputs<R>;
    /// `a` where the mask holds, elsewhere `b`.
    fn select<R: Real>(
        mask: R::M,
        a: &Self::Throughputs<R>,
        b: &Self::Throughputs<R>,
    ) -> Self::Throughputs<R>;
    /// Light of a source, times `weight`, as the sensor sees it; `k` is its direction.
    fn seen<R: Real>(
        throughput: &Self::Throughputs<R>,
        light: &Shine<Self::Values<R>, R>,
        k: V3<R>,
        weight: R,
    ) -> Self::Seen<R>;
    /// The same with one more vertex in between.
    fn seen_through<R: Real>(
        throughput: &Self::Throughputs<R>,
        answer: &Self::Answers<R>,
        k_out: V3<R>,
        light: &Shine<Self::Values<R>, R>,
        k_in: V3<R>,
        weight: R,
    ) -> Self::Seen<R>;
    /// Adds what lanes see to the sums of their camera samples.
    fn add_to<R: Real>(sums: &mut [Self::Stokes], samples: R::B, seen: &Self::Seen<R>, lanes: R::M);
    /// Of which kind throughputs are: a number below [`KINDS`].
    fn kind<R: Real>(throughput: &Self::Throughputs<R>) -> usize;
    /// Throughputs of a kind that wait in rows from `row` on.
    fn taken<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Self::Throughputs<R>;
    /// Of such throughputs what acts on unpolarized light.
    fn taken_for_unpolarized<R: Real, const ROWS: usize>(
        rows: &Rows<ROWS>,
        row: usize,
        columns: Columns<R>,
        kind: usize,
    ) -> Self::Throughputs<R>;
    /// Lets throughputs wait in rows from `row` on.
    fn put<R: Real, const ROWS: usize>(
        rows: &mut Rows<ROWS>,
        row: usize,
        columns: Packed<R>,
        throughput: &Self::Throughputs<R>,
    );
    /// See [`Light::strength`].
    fn strengths<R: Real>(throughput: &Self::Throughputs<R>) -> R;
    /// See [`Light::reach`].
    fn reaches<R: Real>(throughput: &Self::Throughputs<R>) -> R;
    /// See [`Light::sight`].
    fn sights<R: Real>(throughput: &Self::Throughputs<R>) -> Sights<R>;
    /// Times a number a path.
    fn scaled_lanes<R: Real>(throughput: &Self::Throughputs<R>, weight: R) -> Self::Throughputs<R>;
}
