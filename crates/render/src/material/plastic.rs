//! `plastic`: a diffuse base under a smooth dielectric surface, with the light that goes to and fro between them.
//!
//! | parameter              | type            | meaning                                                     | default         |
//! |------------------------|-----------------|-------------------------------------------------------------|-----------------|
//! | `diffuse_reflectance`  | spectrum        | reflected fraction of the base                              | 0.5             |
//! | `nonlinear`            | boolean         | whether light between base and surface shifts the colour    | false           |
//! | `int_ior`              | float or string | index of the plastic                                        | `polypropylene` |
//! | `ext_ior`              | float or string | index outside                                               | `air`           |
//! | `specular_reflectance` | spectrum        | factor on the mirror reflection (not physical)              | 1               |
//!
//! ```xml
//! <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/><float name="int_ior" value="1.9"/></bsdf>
//! ```
//!
//! A mirror by Fresnel's Mueller matrix R, and a base between two passages T through the surface,
//!
//! ```text
//! f = T(o) diag(ρ, 0, 0, 0) T(i)/(π η² (1 − F))        1 − F: 1 − ρF if nonlinear
//! ```
//!
//! F is the diffuse reflectance of the surface from inside. Whatever the base returns is unpolarized, so that a passage
//! polarizes the light that leaves, along the plane of reflection near the rim. For unpolarized light S0 is Mitsuba's.
//! One-sided.
//!
//! Source: F by Egan and Hilgeman, Applied Optics 12(8), 1973, and d'Eon and Irving, TOG 30(4), 2011.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;
use mueller16::DielectricInterface;

use super::dielectric::read_index;
use super::{Departure, Effect, Matter, Part, Vertex, axis_s, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// A diffuse base that sends light back to a surface which keeps some of it inside.
#[derive(Clone, Debug)]
pub(super) struct Base {
    reflectance: Spectrum,
    /// Diffuse reflectance of the surface from inside.
    inner: f32,
    nonlinear: bool,
    /// 1/(π η²)
    scale: f32,
}

impl Base {
    /// Reads `diffuse_reflectance` and `nonlinear`; `inner` is the diffuse reflectance of the surface from inside.
    pub(super) fn read(object: &Object, eta: f64, inner: f64) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: object.spectrum(
                "diffuse_reflectance",
                SpectrumUse::Reflectance,
                Spectrum::constant(0.5),
            )?,
            inner: inner as f32,
            nonlinear: object.boolean("nonlinear", false)?,
            scale: FRAC_1_PI / (eta * eta) as f32,
        })
    }

    /// What it returns to outside between two passages, per steradian and projected solid angle.
    #[inline]
    pub(super) fn weight(&self, wavelength: f32) -> f32 {
        let r = self.reflectance.value(wavelength);
        let again = if self.nonlinear { r } else { 1.0 };
        r * self.scale / (1.0 - again * self.inner)
    }

    /// Probability of drawing the surface rather than the base, where it reflects `r`, at most 0.9 and at least 0.1:
    /// the wavelengths may differ.
    #[inline]
    pub(super) fn surface_probability(&self, r: f32, factor: f32, wavelength: f32) -> f32 {
        let (surface, base) = (r * factor, (1.0 - r) * self.reflectance.value(wavelength));
        let share = surface / (surface + base);
        if share.is_nan() {
            0.5
        } else {
            share.clamp(0.1, 0.9)
        }
    }
}

/// A diffuse base under a smooth dielectric surface.
#[derive(Clone, Debug)]
pub struct Plastic {
    surface: DielectricInterface,
    base: Base,
    reflectance: Spectrum,
}

/// Reflectance of a smooth surface for diffuse light, η the index behind it over that before it.
///
/// Fits, within 0.1 % for η from 1 to 2 and from 1/1.3 to 1/2, within 0.5 % between.
fn diffuse_reflectance(eta: f64) -> f64 {
    let inverse = eta.recip();
    let horner = |c: &[f64], x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    if eta < 1.0 {
        0.0636 * inverse + horner(&[0.6681, 0.7099, -1.4399], eta)
    } else {
        let fit = [0.919317, -3.4793, 6.75335, -7.80989, 4.98554, -1.36881];
        horner(&fit, inverse)
    }
}

impl Plastic {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let inside = read_index(object, "int_ior", "polypropylene")?;
        let outside = read_index(object, "ext_ior", "air")?;
        let eta = inside / outside;
        Ok(Self {
            surface: DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?,
            base: Base::read(object, eta, diffuse_reflectance(eta.recip()))?,
            reflectance: object.spectrum(
                "specular_reflectance",
                SpectrumUse::Reflectance,
                Spectrum::constant(1.0),
            )?,
        })
    }

    /// Passage through the surface, for light that arrives from or leaves to outside at `cos`.
    #[inline]
    fn passage(&self, cos: f32) -> Element {
        self.surface
            .transmission(f64::from(cos.min(1.0)))
            .map_or(Element::BLACK, |t| Element::from(t.element))
    }

    #[inline]
    fn mirror_probability(&self, o: Vec3A, wavelengths: &[f32]) -> f32 {
        let r = self.surface.reflection(f64::from(o.z.min(1.0))).mean as f32;
        let factor = self.reflectance.value(wavelengths[0]);
        self.base.surface_probability(r, factor, wavelengths[0])
    }
}

impl Matter for Plastic {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z <= 0.0 {
            return None;
        }
        let p = self.mirror_probability(o, wavelengths);
        let (direction, density, part) = if u[0] < p {
            (mirror(o, Vec3A::Z), p, Part::Discrete(0))
        } else {
            let i = cosine_hemisphere([u[1], u[2]]);
            (i, (1.0 - p) * i.z * FRAC_1_PI, Part::Continuous)
        };
        (density > 0.0).then_some(Departure {
            direction,
            density,
            part,
            eta: 1.0,
        })
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        if o.z <= 0.0 || i.z <= 0.0 {
            return (L::depolarizing(|_| 0.0), 0.0);
        }
        if part != Part::Continuous {
            let mirrored = Element::from(self.surface.reflection(f64::from(i.z.min(1.0))));
            let response = L::diattenuating_retarder(axis_s(Vec3A::Z, i), |lane| {
                mirrored.scaled(self.reflectance.value(wavelengths[lane]))
            });
            return (response, 0.0);
        }
        let response = L::depolarizer_between(
            (axis_s(Vec3A::Z, o), self.passage(o.z)),
            |lane| self.base.weight(wavelengths[lane]) * i.z,
            (axis_s(Vec3A::Z, i), self.passage(i.z)),
        );
        let p = self.mirror_probability(o, wavelengths);
        (response, (1.0 - p) * i.z * FRAC_1_PI)
    }

    fn is_discrete(&self) -> bool {
        false
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        matches!(part, Part::Discrete(_)).then(|| mirror(at.o, Vec3A::Z))
    }

    fn effect(&self) -> Effect {
        Effect {
            depolarizes: true,
            makes_linear: true,
            // plastic that is thinner matter than its surroundings reflects totally
            retards: self.surface.n_incident() > self.surface.n_transmitted(),
            ..Effect::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::testing::{
        assert_drawn_as_dense, difference, material_of, mean_over_draws, respond, reversed, toward,
    };

    fn plastic(more: &str) -> crate::material::Material {
        material_of(&format!(
            "<bsdf type='plastic'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>{more}</bsdf>"
        ))
        .unwrap()
    }

    /// Diffuse reflectance by quadrature over the cosine.
    fn exact_diffuse_reflectance(eta: f64) -> f64 {
        let surface = DielectricInterface::new(1.0, eta).unwrap();
        let n = 200_000;
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        2.0 * (0..n)
            .map(|k| surface.reflection(at(k)).mean * at(k))
            .sum::<f64>()
            / n as f64
    }

    #[test]
    fn the_fits_of_diffuse_reflectance_are_as_good_as_said() {
        for eta in [1.1, 1.33, 1.5, 1.8] {
            assert!(
                (diffuse_reflectance(eta) / exact_diffuse_reflectance(eta) - 1.0).abs() < 3e-3,
                "{eta}"
            );
        }
        for eta in [1.1, 1.33, 1.5] {
            let eta = f64::recip(eta);
            assert!(
                (diffuse_reflectance(eta) / exact_diffuse_reflectance(eta) - 1.0).abs() < 6e-3,
                "{eta}"
            );
        }
    }

    #[test]
    fn drawn_directions_follow_their_density() {
        assert_drawn_as_dense("plastic", &plastic(""), toward(60.0, 20.0), 12);
    }

    #[test]
    fn white_plastic_loses_nothing() {
        let white = "<float name='diffuse_reflectance' value='1'/>";
        for theta in [0.0, 45.0, 80.0] {
            let o = toward(theta, 0.0);
            let (sum, error) = mean_over_draws(&plastic(white), o, 40_000, |_, _| 1.0);
            // 0.2 % of the fit, times 1.5 for internal reflections
            let albedo = f64::from(sum.x_axis.x);
            assert!(
                (albedo - 1.0).abs() < 5.0 * error + 3e-3,
                "{theta}: {albedo} ± {error}"
            );
            let grey = plastic(
                "<float name='diffuse_reflectance' value='0.5'/><boolean name='nonlinear' value='true'/>",
            );
            let (shifted, _) = mean_over_draws(&grey, o, 40_000, |_, _| 1.0);
            assert!(shifted.x_axis.x < 0.5 * sum.x_axis.x + 0.5);
        }
    }

    #[test]
    fn light_retraces_its_path() {
        let plastic = plastic("");
        let f = |o: Vec3A, i: Vec3A| respond(&plastic, o, i, Part::Continuous).0 * i.z.recip();
        let (o, i) = (toward(70.0, 10.0), toward(50.0, 130.0));
        assert!(difference(&f(o, i), &reversed(&f(i, o))) < 1e-6);
    }

    #[test]
    fn the_base_polarizes_along_the_plane_of_reflection() {
        // light from the normal, seen at 60°: S1/S0 of the passage, (T_s − T_p)/(T_s + T_p), negative in the s frame
        let plastic = plastic("");
        let o = toward(60.0, 0.0);
        let column = respond(&plastic, o, toward(0.0, 0.0), Part::Continuous)
            .0
            .x_axis;
        let b = (f64::from(3f32.sqrt()) / 2.0 / 1.5f64).asin();
        let a = 60f64.to_radians();
        let (s, p) = ((a - b).sin() / (a + b).sin(), (a - b).tan() / (a + b).tan());
        let expected = (p * p - s * s) / (2.0 - s * s - p * p);
        assert!((f64::from(column.y / column.x) - expected).abs() < 1e-6);
        assert!(expected < -0.05 && column.w == 0.0);
    }
}
