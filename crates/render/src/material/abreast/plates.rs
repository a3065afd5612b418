//! Flat optical elements that light goes straight through, a path a lane.

use glam::Vec3A;

use super::super::circular::Circular;
use super::super::null::Null;
use super::super::polarizer::Polarizer;
use super::super::retarder::Retarder;
use super::{Vertices, values};
use crate::lanes::{Axes, Real, V3, sin_cos_turns};
use crate::light::Element;
use crate::light::abreast::{Abreast, Elements};

/// An axis of a plate projected across `k`, unit; the plate's normal where the two are parallel.
#[inline(always)]
fn projected<R: Real>(axis: V3<R>, k: V3<R>) -> V3<R> {
    let across = axis - k * axis.dot(k);
    let squared = across.squared();
    let clear = squared.gt(R::splat(1e-12));
    V3::select(clear, across * squared.sqrt().recip(), V3::splat(Vec3A::Z))
}

impl Polarizer {
    #[inline(always)]
    pub(super) fn pass<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
    ) -> L::Answers<R> {
        let element = Elements::splat(self.element());
        let mut elements = L::diagonals(element);
        for (to, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *to = element.scaled(values(self.transmittance(), *wave));
        }
        let axis = match self.absorbing_axis() {
            // perpendicular to the ray and to the absorbing axis
            Some(axis) => at.o.cross(projected(V3::splat(axis), at.o)),
            None => Axes::around(at.o).s,
        };
        L::diagonal_lanes(axis, &elements)
    }
}

impl Retarder {
    #[inline(always)]
    pub(super) fn pass<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
    ) -> L::Answers<R> {
        let (sin, cos) = self.turn();
        let u = projected(V3::splat(Vec3A::X), at.o);
        // the second axis on the wavefront is the one on the side of V, whichever way the light goes
        let v = at.o.cross(u) * R::one().copysign(at.o.z);
        let axis = u * R::splat(cos as f32) + v * R::splat(sin as f32);
        let [delta, transmittance] = self.spectra();
        let mut elements = L::diagonals(Elements::splat(Element::BLACK));
        for (to, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            let turns = values(delta, *wave) * at.o.z.abs() * R::splat(1.0 / 360.0);
            // whole turns do nothing
            let turns = turns - turns.round();
            let turns = turns + R::one().only(turns.lt(R::zero()));
            let (sine, cosine) = sin_cos_turns(turns);
            *to = Elements {
                mean: R::one(),
                difference: R::zero(),
                cosine,
                sine,
            }
            .scaled(values(transmittance, *wave));
        }
        L::diagonal_lanes(axis, &elements)
    }
}

impl Circular {
    #[inline(always)]
    pub(super) fn pass<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
    ) -> L::Answers<R> {
        let mut factors = *wavelengths;
        for factor in factors.as_mut() {
            *factor = values(self.transmittance(), *factor);
        }
        // the matrix does not depend on the frame
        L::general_lanes(Axes::around(at.o).s, self.matrix(), &factors)
    }
}

impl Null {
    #[inline(always)]
    pub(super) fn pass<R: Real, L: Abreast>(&self, at: &Vertices<R>) -> L::Answers<R> {
        let nothing = Elements::splat(Element {
            mean: 1.0,
            difference: 0.0,
            cosine: 1.0,
            sine: 0.0,
        });
        L::diagonal_lanes(Axes::around(at.o).s, &L::diagonals(nothing))
    }
}
