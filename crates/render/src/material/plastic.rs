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

use super::coated::{Base, Coat, Passages};
use super::dielectric::read_index;
use super::{Departure, Effect, Matter, Part, Vertex, dark, mirror};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};

/// A diffuse base under a smooth dielectric surface.
#[derive(Clone, Debug)]
pub struct Plastic(Coat);

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
    /// Its surface and its base.
    #[inline(always)]
    pub(super) fn coat(&self) -> &Coat {
        &self.0
    }

    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let inside = read_index(object, "int_ior", "polypropylene")?;
        let outside = read_index(object, "ext_ior", "air")?;
        let surface = DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?;
        let inner = diffuse_reflectance((inside / outside).recip());
        let base = Base::read_under(object, &surface, inner)?;
        Coat::read(object, surface, Passages::Smooth, base).map(Self)
    }
}

impl Matter for Plastic {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z <= 0.0 {
            return None;
        }
        let p = self.0.surface_probability(o, wavelengths);
        if u[0] < p {
            return Some(Departure::mirrored(o, p));
        }
        let i = cosine_hemisphere([u[1], u[2]]);
        Departure::continuous(i, (1.0 - p) * i.z * FRAC_1_PI, 1.0)
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
            return dark::<L>();
        }
        if part != Part::Continuous {
            return (self.0.mirrored::<L>(Vec3A::Z, i, 1.0, wavelengths), 0.0);
        }
        let p = self.0.surface_probability(o, wavelengths);
        (
            self.0.diffuse::<L>(o, i, wavelengths),
            (1.0 - p) * i.z * FRAC_1_PI,
        )
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        matches!(part, Part::Discrete(_)).then(|| mirror(at.o, Vec3A::Z))
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.0.is_grey(range)
    }

    fn effect(&self) -> Effect {
        self.0.effect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::testing::{
        assert_drawn_as_dense, assert_retraced, mean_over_draws, of_indices, reflectances, respond,
        toward,
    };

    fn plastic(more: &str) -> crate::material::Material {
        of_indices("plastic", [1.5, 1.0], more)
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
        }
    }

    #[test]
    fn light_between_base_and_surface_darkens_grey_plastic() {
        // the base alone, without the mirror: ρ/(1 − ρF) where it is ρ/(1 − F) for ρ = 1 between
        let base = |nonlinear: bool| {
            let grey = plastic(&format!(
                "<float name='diffuse_reflectance' value='0.5'/><boolean name='nonlinear' value='{nonlinear}'/>"
            ));
            let (o, i) = (toward(20.0, 0.0), toward(65.0, 130.0));
            f64::from(respond(&grey, o, i, Part::Continuous).0.x_axis.x)
        };
        let inner = exact_diffuse_reflectance(1.5f64.recip());
        let expected = (1.0 - inner) / (1.0 - 0.5 * inner);
        let found = base(true) / base(false);
        // 0.5 % of the fit
        assert!((found - expected).abs() < 4e-3, "{found} {expected}");
        assert!(expected < 0.6);
    }

    #[test]
    fn light_retraces_its_path() {
        let way = (toward(70.0, 10.0), toward(50.0, 130.0));
        assert_retraced(&plastic(""), way, |_| 1.0, 1e-5);
    }

    #[test]
    fn the_base_polarizes_along_the_plane_of_reflection() {
        // light from the normal, seen at 60°: S1/S0 of the passage, (T_s − T_p)/(T_s + T_p), negative in the s frame
        let plastic = plastic("");
        let o = toward(60.0, 0.0);
        let column = respond(&plastic, o, toward(0.0, 0.0), Part::Continuous)
            .0
            .x_axis;
        let [s, p] = reflectances(1.5, 0.5);
        let expected = (p - s) / (2.0 - s - p);
        assert!((f64::from(column.y / column.x) - expected).abs() < 1e-6);
        assert!(expected < -0.05 && column.w == 0.0);
    }
}
