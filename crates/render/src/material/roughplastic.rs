//! `roughplastic`: a diffuse base under a rough dielectric surface, with the light that goes to and fro between them.
//!
//! | parameter              | type            | meaning                                                     | default         |
//! |------------------------|-----------------|-------------------------------------------------------------|-----------------|
//! | `diffuse_reflectance`  | spectrum        | reflected fraction of the base                              | 0.5             |
//! | `nonlinear`            | boolean         | whether light between base and surface shifts the colour    | false           |
//! | `int_ior`              | float or string | index of the plastic                                        | `polypropylene` |
//! | `ext_ior`              | float or string | index outside, another one                                  | `air`           |
//! | `distribution`         | string          | `beckmann` or `ggx`                                         | `beckmann`      |
//! | `alpha`                | float           | roughness, the same in all directions                       | 0.1             |
//! | `sample_visible`       | boolean         | draw only facets that the viewer sees                       | true            |
//! | `specular_reflectance` | spectrum        | factor on the reflection at the surface (not physical)      | 1               |
//!
//! ```xml
//! <bsdf type="roughplastic"><float name="alpha" value="0.3"/><string name="distribution" value="ggx"/></bsdf>
//! ```
//!
//! The surface of `roughdielectric` over the base of `plastic`,
//!
//! ```text
//! f = M(h) D G1(i) G1(o)/(4 cos i cos o) + T(o) diag(ρ, 0, 0, 0) T(i)/(π η² (1 − F))        1 − ρF if nonlinear
//! ```
//!
//! where the passages T are sums over the facets that a ray meets, each with its own plane of incidence, tabulated over
//! the cosine; `pplastic` has those of a smooth surface. For unpolarized light S0 is Mitsuba's, its table with 64
//! cosines and the mean over them that stands for F. One-sided.
//!
//! Source: Walter et al., EGSR 2007, Eqs. 20, 21.

use glam::Vec3A;
use mueller16::DielectricInterface;

use super::coated::{Base, Coat, Passages, RoughlyCoated};
use super::microfacet::Microfacets;
use super::roughdielectric::read_two_indices;
use super::{axis_s, mirror};
use crate::light::Element;
use crate::scene::{Object, SceneError};

/// Cosines of the tables.
const COSINES: usize = 64;

/// Facets that are summed for each cosine, along each of two random numbers.
const FACETS: usize = 48;

/// What passes a rough surface, over the cosine outside.
#[derive(Clone, Debug)]
pub(super) struct RoughPassages {
    /// See [`Element::mean`].
    pub(super) mean: [f32; COSINES],
    /// See [`Element::difference`].
    pub(super) difference: [f32; COSINES],
}

impl RoughPassages {
    fn new(surface: &DielectricInterface, facets: &Microfacets) -> Self {
        let [mut mean, mut difference] = [[0.0; COSINES]; 2];
        for place in 0..COSINES {
            let o = direction(place);
            let mut sum = Element::BLACK;
            let eta = (surface.n_transmitted() / surface.n_incident()) as f32;
            over_facets(facets, o, |m, cos| {
                let Some(passage) = surface.transmission(f64::from(cos)) else {
                    return;
                };
                let within = m * (cos / eta - passage.cos_t as f32) - o / eta;
                let weight = facets.shadowing(within, m);
                let element = Element::from(passage.element);
                // the facet's axis across the ray against that of the whole surface
                let turn = axis_s(m, o).dot(axis_s(Vec3A::Z, o));
                sum.mean += weight * element.mean;
                sum.difference += weight * element.difference * (2.0 * turn * turn - 1.0);
            });
            let share = ((FACETS * FACETS) as f32).recip();
            mean[place] = sum.mean * share;
            difference[place] = sum.difference * share;
        }
        Self { mean, difference }
    }

    #[inline]
    pub(super) fn at(&self, cos: f32) -> Element {
        let x = cos.clamp(0.0, 1.0) * (COSINES - 1) as f32;
        let place = (x as usize).min(COSINES - 2);
        let t = x - place as f32;
        let between = |values: &[f32; COSINES]| {
            let (a, b) = (values[place], values[place + 1]);
            a + t * (b - a)
        };
        Element {
            mean: between(&self.mean),
            difference: between(&self.difference),
            ..Element::BLACK
        }
    }
}

/// The direction of a place in the tables.
fn direction(place: usize) -> Vec3A {
    let cos = (place as f32 / (COSINES - 1) as f32).max(1e-6);
    Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// Calls `each` with the facets that are seen from `o` and their cosines, as often as they are seen.
fn over_facets(facets: &Microfacets, o: Vec3A, mut each: impl FnMut(Vec3A, f32)) {
    let at = |place: usize| (place as f32 + 0.5) / FACETS as f32;
    for place in 0..FACETS * FACETS {
        let m = facets.sample(o, [at(place / FACETS), at(place % FACETS)]);
        let cos = o.dot(m);
        if cos > 0.0 {
            each(m, cos.min(1.0));
        }
    }
}

/// Reflectance of the rough surface for diffuse light from inside: a mean over the cosines of the table.
fn inner_reflectance(surface: &DielectricInterface, facets: &Microfacets) -> f64 {
    let inside = surface.reversed();
    let mut sum = 0.0;
    for place in 0..COSINES {
        let o = direction(place);
        over_facets(facets, o, |m, cos| {
            let away = mirror(o, m);
            if away.z > 0.0 {
                let reflected = inside.reflection(f64::from(cos)).mean;
                sum += reflected * f64::from(facets.shadowing(away, m) * o.z);
            }
        });
    }
    2.0 * sum / (COSINES * FACETS * FACETS) as f64
}

/// Reads its parameters.
pub fn read(object: &Object) -> Result<RoughlyCoated, SceneError> {
    let surface = *read_two_indices(object, "polypropylene")?.side(true);
    let facets = Microfacets::read(object)?;
    if !facets.is_isotropic() {
        return Err(object.error_at(
            "alpha_u",
            "'alpha_u' and 'alpha_v' differ, expected one roughness: the passages through the surface are tabulated \
             for facets without direction",
        ));
    }
    let seen = facets.seen();
    let passages = Passages::Rough(Box::new(RoughPassages::new(&surface, &seen)));
    let base = Base::read_under(object, &surface, inner_reflectance(&surface, &seen))?;
    Ok(RoughlyCoated {
        coat: Coat::read(object, surface, passages, base)?,
        facets,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::microfacet::Kind;
    use crate::material::testing::{
        assert_drawn_as_dense, assert_retraced, material_of, mean_over_draws, of_indices,
        reflectances, toward,
    };

    fn plastic(more: &str) -> crate::material::Material {
        of_indices("roughplastic", [1.5, 1.0], more)
    }

    const ROUGH: &str = "<float name='alpha' value='0.3'/>";
    const GGX: &str = "<float name='alpha' value='0.4'/><string name='distribution' value='ggx'/>";

    #[test]
    fn drawn_directions_follow_their_density() {
        for more in [ROUGH, GGX] {
            assert_drawn_as_dense(more, &plastic(more), toward(50.0, 20.0), 12);
        }
    }

    #[test]
    fn light_retraces_its_path() {
        for more in [ROUGH, GGX] {
            for way in [
                (toward(60.0, 10.0), toward(50.0, 170.0)),
                (toward(30.0, 10.0), toward(75.0, 50.0)),
            ] {
                assert_retraced(&plastic(more), way, |_| 1.0, 1e-5);
            }
        }
    }

    #[test]
    fn white_plastic_gains_nothing() {
        // light that would meet a second facet is lost, in the mirror and in both passages
        for (more, least) in [(ROUGH, 0.8), (GGX, 0.4)] {
            let white = format!("{more}<float name='diffuse_reflectance' value='1'/>");
            for theta in [0.0, 45.0, 75.0] {
                let (sum, error) =
                    mean_over_draws(&plastic(&white), toward(theta, 0.0), 40_000, |_, _| 1.0);
                let albedo = f64::from(sum.x_axis.x);
                assert!(
                    albedo < 1.0 + 5.0 * error + 1e-5 && albedo > least,
                    "{more} {theta}: {albedo} ± {error}"
                );
            }
        }
    }

    #[test]
    fn passages_through_smooth_surfaces_are_fresnels() {
        let surface = DielectricInterface::new(1.0, 1.5).unwrap();
        let facets = Microfacets::new(Kind::Beckmann, 1e-3, 1e-3);
        let passages = RoughPassages::new(&surface, &facets);
        for place in [5, 20, 40, 63] {
            let cos = place as f32 / 63.0;
            let exact = surface.transmission(f64::from(cos)).unwrap().element;
            let found = passages.at(cos);
            // facets tilted by 1e-3 against cosines of 0.08 and more
            assert!((f64::from(found.mean) - exact.mean).abs() < 2e-3, "{cos}");
            assert!(
                (f64::from(found.difference) - exact.difference).abs() < 2e-3,
                "{cos}"
            );
        }
    }

    /// A sum over slopes of what facets transmit and how they polarize, against the table's sum over drawn facets.
    #[test]
    fn passages_are_sums_over_facets() {
        let (alpha, eta) = (0.4, 1.5);
        let surface = DielectricInterface::new(1.0, eta).unwrap();
        let facets = Microfacets::new(Kind::Beckmann, 0.4, 0.4);
        let passages = RoughPassages::new(&surface, &facets);
        for place in [20, 40] {
            let o = direction(place);
            let od = o.as_dvec3();
            let mut sum = [0.0; 3];
            let n = 800;
            for cell in 0..n * n {
                let slope = |k: usize| ((k as f64 + 0.5) / n as f64 * 2.0 - 1.0) * 4.5 * alpha;
                let (x, y) = (slope(cell / n), slope(cell % n));
                let m = glam::DVec3::new(-x, -y, 1.0).normalize();
                let cos = od.dot(m);
                if cos <= 1e-9 {
                    continue;
                }
                let [r_s, r_p] = reflectances(eta, cos);
                let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
                let within = (m * (cos / eta - cos_t) - od / eta).as_vec3a();
                let density = (-(x * x + y * y) / (alpha * alpha)).exp() * cos / m.z;
                let axis = m
                    .cross(od)
                    .normalize()
                    .dot(glam::DVec3::Z.cross(od).normalize());
                let through = density * f64::from(facets.shadowing(within, m.as_vec3a()));
                sum[0] += density;
                sum[1] += through * (1.0 - 0.5 * (r_s + r_p));
                sum[2] += through * 0.5 * (r_p - r_s) * (2.0 * axis * axis - 1.0);
            }
            let found = passages.at(o.z);
            // 48 × 48 facets by the midpoint rule
            assert!(
                (f64::from(found.mean) - sum[1] / sum[0]).abs() < 2e-3,
                "{place}: {found:?} {sum:?}"
            );
            assert!(
                (f64::from(found.difference) - sum[2] / sum[0]).abs() < 2e-3,
                "{place}: {found:?} {sum:?}"
            );
            assert!(found.difference < -0.01 || place > 20);
        }
    }

    #[test]
    fn facets_with_a_direction_are_refused() {
        let error = material_of(
            "<bsdf type='roughplastic'><float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.2'/></bsdf>",
        );
        let message = error.unwrap_err().to_string();
        assert!(
            message.starts_with(
                "test.xml:2:27: 'alpha_u' and 'alpha_v' differ, expected one roughness"
            ),
            "{message}"
        );
    }
}
