//! Plastic, a path a lane: a diffuse base under a dielectric surface, smooth or rough.

use std::f32::consts::FRAC_1_PI;

use super::super::coated::{Base, Coat, Passages, RoughlyCoated};
use super::super::plastic::Plastic;
use super::super::roughplastic::RoughPassages;
use super::facets::Facets;
use super::fresnel::{Interface, dielectric};
use super::{Departures, Vertices, axes_s, cosine_hemispheres, mirrored, upright, values};
use crate::lanes::{Bits, Double, Mask, Real, V3};
use crate::light::abreast::{Abreast, Elements};

impl RoughPassages {
    /// See [`RoughPassages::at`].
    #[inline(always)]
    fn at_cosines<R: Real>(&self, cos: R) -> Elements<R> {
        let last = (self.mean.len() - 1) as f32;
        let x = cos.clamp(0.0, 1.0) * R::splat(last);
        let place = x.min(R::splat(last - 0.5)).to_int();
        let (next, t) = (place + R::B::splat(1), x - R::of_int(place));
        let (a, b) = (R::gather(&self.mean, place), R::gather(&self.mean, next));
        let c = R::gather(&self.difference, place);
        let d = R::gather(&self.difference, next);
        Elements {
            mean: a + t * (b - a),
            difference: c + t * (d - c),
            cosine: R::zero(),
            sine: R::zero(),
        }
    }
}

impl Base {
    /// See [`Base::weight`].
    #[inline(always)]
    fn weights<R: Real>(&self, wavelengths: R) -> R {
        let r = values(&self.reflectance, wavelengths);
        if self.nonlinear {
            r * R::splat(self.scale) / (R::one() - r * R::splat(self.inner))
        } else {
            r * R::splat(self.scale / (1.0 - self.inner))
        }
    }
}

/// What leaves through a surface, and how directions are chosen.
struct Leaving<R> {
    passage: Elements<R>,
    /// Probability of drawing the surface rather than the base.
    surface: R,
}

impl Coat {
    /// What a smooth surface does to light from outside.
    #[inline(always)]
    fn interface<R: Real>(&self, cos: R) -> Interface<R> {
        let [n1, n2] = [self.surface.n_incident(), self.surface.n_transmitted()];
        dielectric::<R>(cos.min(R::one()), R::D::splat(n1), R::D::splat(n2))
    }

    /// Passage through the surface and the fraction of unpolarized light that it keeps out: see [`Coat::passage`].
    #[inline(always)]
    fn passages<R: Real>(&self, cos: R) -> (Elements<R>, R) {
        match &self.passages {
            Passages::Smooth => {
                let interface = self.interface(cos);
                (interface.transmission, interface.reflection.mean)
            }
            Passages::Rough(table) => {
                let passage = table.at_cosines(cos);
                (passage, (R::one() - passage.mean).max(R::zero()))
            }
        }
    }

    /// See [`Coat::surface_probability`].
    #[inline(always)]
    fn leaving<R: Real>(&self, cos: R, first_wavelength: R) -> Leaving<R> {
        let (passage, r) = self.passages(cos);
        let surface = r * values(&self.reflectance, first_wavelength);
        let base = (R::one() - r) * values(&self.base.reflectance, first_wavelength);
        let whole = surface + base;
        let share = (surface / whole).clamp(0.3, 0.9);
        Leaving {
            passage,
            surface: R::select(whole.gt(R::zero()), share, R::splat(0.5)),
        }
    }

    /// Reflection where the normal is `h`, times `mirror`, and what the base returns, times `cos`.
    #[inline(always)]
    fn answers<R: Real, L: Abreast>(
        &self,
        [o, i]: [V3<R>; 2],
        h: V3<R>,
        [mirror, cos]: [R; 2],
        passage: Elements<R>,
        wavelengths: &L::Values<R>,
    ) -> L::Answers<R> {
        let reflection = self.interface(i.dot(h)).reflection.scaled(mirror);
        let (inward, _) = self.passages(i.z);
        let mut surface = L::diagonals(reflection);
        for (to, wave) in surface.as_mut().iter_mut().zip(wavelengths.as_ref()) {
            *to = reflection.scaled(values(&self.reflectance, *wave));
        }
        let mut base = *wavelengths;
        for value in base.as_mut() {
            *value = self.base.weights(*value) * cos;
        }
        L::coated_lanes(
            (axes_s(h, i), &surface),
            (axes_s(upright(), o), passage),
            &base,
            (axes_s(upright(), i), inward),
            [o, i],
        )
    }
}

/// See `joint_density` in `coated.rs`.
#[inline(always)]
fn joint_density<R: Real>(p: R, of_facets: R, i: V3<R>) -> R {
    p * of_facets + (R::one() - p) * i.z * R::splat(FRAC_1_PI)
}

/// Where both directions are above the surface.
#[inline(always)]
fn both_above<R: Real>(o: V3<R>, i: V3<R>) -> R::M {
    o.z.gt(R::zero()) & i.z.gt(R::zero())
}

impl RoughlyCoated {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
        lanes: R::M,
    ) -> Departures<R, L::Answers<R>> {
        let o = at.o;
        let leaving = self.coat.leaving(o.z, wavelengths.as_ref()[0]);
        let at_surface = u[0].lt(leaving.surface);
        let mut direction = cosine_hemispheres([u[1], u[2]]);
        let mut h = (o + direction).normalize();
        if (lanes & at_surface).any() {
            let (m, _) = Facets(&self.facets).sample(o, [u[1], u[2]]);
            direction = V3::select(at_surface, mirrored(o, m), direction);
            h = V3::select(at_surface, m, h);
        }
        let (answers, density) = self.through::<R, L>([o, direction], h, &leaving, wavelengths);
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
        let leaving = self.coat.leaving(at.o.z, wavelengths.as_ref()[0]);
        let h = (at.o + i).normalize();
        self.through::<R, L>([at.o, i], h, &leaving, wavelengths)
    }

    /// Answers and the density of directions; `h` halves them.
    #[inline(always)]
    fn through<R: Real, L: Abreast>(
        &self,
        [o, i]: [V3<R>; 2],
        h: V3<R>,
        leaving: &Leaving<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let facets = Facets(&self.facets);
        let (weight, of_facets) = facets.mirrored(o, i, h, facets.density(h));
        let parts = [weight, i.z];
        let answers = self
            .coat
            .answers::<R, L>([o, i], h, parts, leaving.passage, wavelengths);
        let density = joint_density(leaving.surface, of_facets, i);
        (answers, density.only(both_above(o, i)))
    }
}

impl Plastic {
    #[inline(always)]
    pub(super) fn depart<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        wavelengths: &L::Values<R>,
        u: [R; 3],
    ) -> Departures<R, L::Answers<R>> {
        let (o, coat) = (at.o, self.coat());
        let leaving = coat.leaving(o.z, wavelengths.as_ref()[0]);
        let p = leaving.surface;
        let reflected = u[0].lt(p);
        let below = cosine_hemispheres([u[1], u[2]]);
        let i = V3::select(reflected, mirrored(o, upright()), below);
        let h = V3::select(reflected, upright(), (o + i).normalize());
        let parts = [R::one().only(reflected), i.z.only(!reflected)];
        let density = R::select(reflected, p, joint_density(p, R::zero(), i));
        let exist = both_above(o, i) & density.gt(R::zero());
        Departures {
            exist,
            direction: i,
            density,
            continuous: exist & !reflected,
            straight: R::nowhere(),
            eta: R::one(),
            answers: coat.answers::<R, L>([o, i], h, parts, leaving.passage, wavelengths),
        }
    }

    #[inline(always)]
    pub(super) fn answer<R: Real, L: Abreast>(
        &self,
        at: &Vertices<R>,
        i: V3<R>,
        wavelengths: &L::Values<R>,
    ) -> (L::Answers<R>, R) {
        let (o, coat) = (at.o, self.coat());
        let leaving = coat.leaving(o.z, wavelengths.as_ref()[0]);
        let (h, parts) = ((o + i).normalize(), [R::zero(), i.z]);
        let answers = coat.answers::<R, L>([o, i], h, parts, leaving.passage, wavelengths);
        let density = joint_density(leaving.surface, R::zero(), i);
        (answers, density.only(both_above(o, i)))
    }
}
