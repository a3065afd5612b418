//! Rough metal, a path a lane.

use super::super::roughconductor::RoughConductor;
use super::facets::Facets;
use super::{Departures, Vertices, axes_s, mirrored};
use crate::lanes::{Real, V3};
use crate::light::Element;
use crate::light::abreast::{Abreast, Elements};

impl RoughConductor {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
    ) -> Departures<R, L::Answers<R>> {
        let (m, facets) = Facets(self.facets()).sample(at.o, [u[1], u[2]]);
        let direction = mirrored(at.o, m);
        let (answers, density) = self.mirror::<R, L>([at.o, direction], m, facets, wavelengths);
        // the density of a facet next to the plane may be too much for single precision
        let exist = density.gt(R::zero()) & density.lt(R::splat(f32::INFINITY));
        Departures {
            exist,
            direction,
            density,
            continuous: exist,
            straight: R::nowhere(),
            eta: R::one(),
            answers,
        }
    }

    #[inline(always)]
    pub(super) fn answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let h = (at.o + i).normalize();
        let facets = Facets(self.facets()).density(h);
        self.mirror::<R, L>([at.o, i], h, facets, wavelengths)
    }

    /// What facets with normals `h` do, and the density of directions; `facets` is D(h).
    #[inline(always)]
    fn mirror<R: Real, L: Abreast>(
        &self,
        [o, i]: [V3<R>; 2],
        h: V3<R>,
        facets: R,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let lit = o.z.gt(R::zero()) & i.z.gt(R::zero());
        let (weight, density) = Facets(self.facets()).mirrored(o, i, h, facets);
        let cos = i.dot(h).min(R::one());
        let mut elements = L::diagonals(Elements::splat(Element::BLACK));
        for (to, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *to = self.metal().reflections(cos, *wave).scaled(weight);
        }
        (
            L::diagonal_lanes(axes_s(h, i), &elements),
            density.only(lit),
        )
    }
}
