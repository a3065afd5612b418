//! `thindielectric`: a pane too thin to bend light, with all its internal reflections.
//!
//! | parameter                | type            | meaning                                         | default |
//! |--------------------------|-----------------|-------------------------------------------------|---------|
//! | `int_ior`                | float or string | index of the pane                               | `bk7`   |
//! | `ext_ior`                | float or string | index on both sides of it                       | `air`   |
//! | `specular_reflectance`   | spectrum        | factor on the reflected power (not physical)    | 1       |
//! | `specular_transmittance` | spectrum        | factor on the transmitted power (not physical)  | 1       |
//!
//! ```xml
//! <shape type="rectangle"><bsdf type="thindielectric"><float name="int_ior" value="1.5"/></bsdf></shape>
//! ```
//!
//! Both sides. Light goes straight through, and emitters are seen through it. The powers of the internal reflections add
//! up, without interference, each polarization by itself: with Fresnel's Mueller matrices R₁, T₁ of light that enters and
//! R₂, T₂ inside,
//!
//! ```text
//! T = T₂ (1 − R₂²)⁻¹ T₁        R = R₁ + T₂ R₂ (1 − R₂²)⁻¹ T₁
//! ```
//!
//! Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5, for the matrices.

use glam::Vec3A;
use mueller16::DielectricInterface;
use num_complex::Complex64;
use stokes::DiattenuatingRetarder;

use super::dielectric::read_index;
use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;

/// Cosines below this are taken for it: the sums are 0/0 at grazing incidence.
const LEAST_COSINE: f64 = 1e-6;

/// A thin pane.
#[derive(Clone, Debug)]
pub struct ThinDielectric {
    face: DielectricInterface,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

/// An element by what it does to the power of s, to that of p and to `E_s E_p*`: products go number by number.
#[derive(Clone, Copy)]
struct Powers {
    s: f64,
    p: f64,
    across: Complex64,
}

impl Powers {
    fn map2(self, other: Self, f: impl Fn(Complex64, Complex64) -> Complex64) -> Self {
        Self {
            s: f(self.s.into(), other.s.into()).re,
            p: f(self.p.into(), other.p.into()).re,
            across: f(self.across, other.across),
        }
    }

    fn then(self, next: Self) -> Self {
        self.map2(next, |a, b| a * b)
    }

    /// `(1 − self²)⁻¹`
    fn repeated(self) -> Self {
        self.map2(self, |a, b| (Complex64::ONE - a * b).inv())
    }

    fn plus(self, other: Self) -> Self {
        self.map2(other, |a, b| a + b)
    }
}

impl From<DiattenuatingRetarder> for Powers {
    fn from(m: DiattenuatingRetarder) -> Self {
        Self {
            s: m.mean + m.difference,
            p: m.mean - m.difference,
            across: Complex64::new(m.cosine, m.sine),
        }
    }
}

impl From<Powers> for Element {
    /// Narrows to single precision: costs 6e-8 relative.
    fn from(m: Powers) -> Self {
        Self {
            mean: (0.5 * (m.s + m.p)) as f32,
            difference: (0.5 * (m.s - m.p)) as f32,
            cosine: m.across.re as f32,
            sine: m.across.im as f32,
        }
    }
}

impl ThinDielectric {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let inside = read_index(object, "int_ior", "bk7")?;
        let outside = read_index(object, "ext_ior", "air")?;
        Ok(Self {
            face: DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?,
            reflectance: object.factor("specular_reflectance")?,
            transmittance: object.factor("specular_transmittance")?,
        })
    }

    /// What it reflects and what it transmits.
    #[inline]
    fn both(&self, cos: f32) -> [Element; 2] {
        let cos = f64::from(cos.abs()).clamp(LEAST_COSINE, 1.0);
        let first = Powers::from(self.face.reflection(cos));
        let back = self.face.reversed();
        let Some(enters) = self.face.transmission(cos) else {
            return [first.into(), Element::BLACK];
        };
        let Some(leaves) = back.transmission(enters.cos_t) else {
            return [first.into(), Element::BLACK];
        };
        let inner = Powers::from(back.reflection(enters.cos_t));
        let through = Powers::from(enters.element)
            .then(leaves.element.into())
            .then(inner.repeated());
        [first.plus(through.then(inner)).into(), through.into()]
    }
}

impl Matter for ThinDielectric {
    #[inline]
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z == 0.0 {
            return None;
        }
        let [reflected, _] = self.both(o.z);
        // in proportion to what the sensor sees of unpolarized light on either way
        let seen = at.sight.along(axis_s(Vec3A::Z, o), o);
        let reflected = (reflected.mean + seen * reflected.difference).clamp(0.0, 1.0);
        Some(if u[0] < reflected {
            Departure::mirrored(o, reflected)
        } else {
            Departure::straight(o, 1.0 - reflected)
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
        let [reflected, transmitted] = self.both(at.o.z);
        let (element, factor) = if part == Part::Straight {
            (transmitted, &self.transmittance)
        } else {
            (reflected, &self.reflectance)
        };
        let response = L::diattenuating_retarder(axis_s(Vec3A::Z, i), |lane| {
            element.scaled(factor.value(wavelengths[lane]))
        });
        (response, 0.0)
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        Some(match part {
            Part::Straight => -at.o,
            _ => mirror(at.o, Vec3A::Z),
        })
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: true,
            straight: true,
            chooses: true,
            ..Traits::default()
        }
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.reflectance.is_constant_over(range) && self.transmittance.is_constant_over(range)
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            // a pane that is thinner matter than its surroundings reflects totally
            retards: self.face.n_incident() > self.face.n_transmitted(),
            ..Effect::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::testing::{
        difference, material_of, of_indices, respond, reversed, toward,
    };

    fn pane(inside: f64, outside: f64) -> crate::material::Material {
        of_indices("thindielectric", [inside, outside], "")
    }

    #[test]
    fn internal_reflections_add_up_one_by_one() {
        for (inside, outside, theta) in [
            (1.5, 1.0, 0.0),
            (1.5, 1.0, 56.0),
            (2.4, 1.0, 80.0),
            (1.0, 1.33, 40.0),
        ] {
            let o = toward(theta, 30.0);
            let cos = f64::from(o.z);
            let face = DielectricInterface::new(outside, inside).unwrap();
            let enters = face.transmission(cos).unwrap();
            let leaves = face.reversed().transmission(enters.cos_t).unwrap();
            let inner = face
                .reversed()
                .reflection(enters.cos_t)
                .to_mueller()
                .to_matrix();
            let (enters, leaves) = [enters, leaves]
                .map(|t| t.element.to_mueller().to_matrix())
                .into();
            let mut inside_now = enters;
            let (mut reflected, mut transmitted) = (
                face.reflection(cos).to_mueller().to_matrix(),
                nalgebra::Matrix4::zeros(),
            );
            for _ in 0..200 {
                transmitted += leaves * inside_now;
                inside_now = inner * inside_now;
                reflected += leaves * inside_now;
                inside_now = inner * inside_now;
            }
            let pane = pane(inside, outside);
            for (expected, part, i) in [
                (reflected, Part::Discrete(0), mirror(o, Vec3A::Z)),
                (transmitted, Part::Straight, -o),
            ] {
                let found = respond(&pane, o, i, part).0;
                let expected = glam::Mat4::from_cols_array(&std::array::from_fn(|k| {
                    expected.as_slice()[k] as f32
                }));
                // single precision
                assert!(
                    difference(&found, &expected) < 1e-6,
                    "{theta}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn nothing_is_lost_at_any_angle_and_from_either_side() {
        for theta in [0.0, 30.0, 60.0, 89.0, 89.999] {
            for side in [1.0, -1.0] {
                let o = toward(theta, 10.0) * side;
                let pane = pane(1.5, 1.0);
                let r = respond(&pane, o, mirror(o, Vec3A::Z), Part::Discrete(0)).0;
                let t = respond(&pane, o, -o, Part::Straight).0;
                assert!((r.x_axis.x + t.x_axis.x - 1.0).abs() < 1e-6);
                assert!((r.x_axis.y + t.x_axis.y).abs() < 1e-6);
                assert!(difference(&t, &reversed(&t)) < 1e-6);
            }
        }
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected_and_retarded() {
        let o = toward(60.0, 0.0);
        let pane = pane(1.0, 1.5);
        let (m, _) = respond(&pane, o, mirror(o, Vec3A::Z), Part::Discrete(0));
        assert!((m.x_axis.x - 1.0).abs() < 1e-6 && m.z_axis.w.abs() > 0.1);
        assert_eq!(respond(&pane, o, -o, Part::Straight).0.x_axis.x, 0.0);
        assert!(pane.effect().retards);
    }

    #[test]
    fn a_part_is_drawn_as_often_as_it_sends_light() {
        let pane = pane(1.5, 1.0);
        let o = toward(70.0, 0.0);
        let at = crate::material::testing::vertex(o);
        for (u, part) in [(0.0, Part::Discrete(0)), (0.999, Part::Straight)] {
            let drawn = pane.sample(&at, &[550.0], [u, 0.5, 0.5]).unwrap();
            let (m, _) = respond(&pane, o, drawn.direction, drawn.part);
            assert_eq!(drawn.part, part);
            assert!((drawn.density - m.x_axis.x).abs() < 1e-6);
        }
    }

    #[test]
    fn an_impossible_index_is_refused() {
        let error =
            material_of("<bsdf type='thindielectric'><float name='int_ior' value='0'/></bsdf>");
        assert_eq!(
            error.unwrap_err().to_string(),
            "test.xml:2:29: an index of refraction of 0, expected a positive number"
        );
    }
}
