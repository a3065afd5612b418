//! Smooth metal and smooth glass, a path a lane.

use super::super::conductor::{Conductor, Metal};
use super::super::dielectric::Dielectric;
use super::fresnel::{conductor, dielectric};
use super::{Departures, Vertices, axes_s, mirrored, upright, values};
use crate::lanes::{Double, Real, V3};
use crate::light::Element;
use crate::light::abreast::{Abreast, Elements};

impl Metal {
    /// Reflection at angles of incidence, at one wavelength a lane; first axis perpendicular to the plane of incidence.
    #[inline(always)]
    pub(super) fn reflections<R: Real>(&self, cos_i: R, wavelengths: R) -> Elements<R> {
        let [eta, k, reflectance] = self.spectra();
        conductor(cos_i, values(eta, wavelengths), values(k, wavelengths))
            .scaled(values(reflectance, wavelengths))
    }
}

impl Conductor {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
    ) -> Departures<R, L::Answers<R>> {
        let direction = mirrored(at.o, upright());
        let axis = axes_s(upright(), direction);
        let mut elements = L::diagonals(Elements::splat(Element::BLACK));
        for (element, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *element = self.metal().reflections(direction.z, *wave);
        }
        Departures {
            exist: at.o.z.gt(R::zero()),
            direction,
            density: R::one(),
            continuous: R::nowhere(),
            straight: R::nowhere(),
            eta: R::one(),
            answers: L::diagonal_lanes(axis, &elements),
        }
    }
}

impl Dielectric {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
    ) -> Departures<R, L::Answers<R>> {
        let o = at.o;
        let above = o.z.gt(R::zero());
        let [outside, inside] = self.indices();
        // 1 and 0: the index where light comes from, and the other
        let up = R::D::wide(R::one().only(above));
        let down = R::D::splat(1.0) - up;
        let (outer, inner) = (R::D::splat(outside), R::D::splat(inside));
        let (n1, n2) = (outer * up + inner * down, inner * up + outer * down);
        let interface = dielectric::<R>(o.z.abs(), n1, n2);
        // in proportion to what the sensor sees of unpolarized light on either way
        let s = axes_s(upright(), o);
        let seen = at.sights.along(s, o);
        let element = &interface.reflection;
        let chance = (element.mean + seen * element.difference).clamp(0.0, 1.0);
        let reflected = u[0].lt(chance);
        let (ratio, inverse) = ((inside / outside) as f32, (outside / inside) as f32);
        let eta = R::select(above, R::splat(ratio), R::splat(inverse));
        let shrink = R::select(above, R::splat(inverse), R::splat(ratio));
        let over_n2 = R::D::splat(inside.recip()) * up + R::D::splat(outside.recip()) * down;
        let away = (interface.grazing * over_n2).narrow().copysign(o.z);
        // Snell's law across, the cosine along: normalised once more in single precision
        let refracted = V3::new(-(o.x * shrink), -(o.y * shrink), -away).normalize();
        let direction = V3::select(reflected, mirrored(o, upright()), refracted);
        // radiance counts by the squared index of its medium
        let dense = shrink * shrink;
        let ways = [interface.reflection, interface.transmission.scaled(dense)];
        let [back, on] = self.factors();
        let mut elements = L::diagonals(ways[0]);
        for (element, wave) in elements.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            let (back, on) = (values(back, *wave), values(on, *wave));
            *element = Elements::select(reflected, ways[0].scaled(back), ways[1].scaled(on));
        }
        let exist = (reflected | interface.passes) & o.z.abs().gt(R::zero());
        Departures {
            exist,
            direction,
            density: R::select(reflected, chance, R::one() - chance),
            continuous: R::nowhere(),
            straight: R::nowhere(),
            eta: R::select(reflected, R::one(), eta),
            answers: L::diagonal_lanes(axes_s(upright(), direction), &elements),
        }
    }
}
