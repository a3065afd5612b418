//! `roughsurface`: random heights of any size against the wavelength, from a mirror that scatters a little to facets.
//!
//! | parameter                | type             | meaning                                                       | default    |
//! |--------------------------|------------------|---------------------------------------------------------------|------------|
//! | `height`                 | length           | root mean square height σ (`"50nm"`, or metres)               | required   |
//! | `length`                 | length           | correlation length l (`"5um"`, or metres)                     | required   |
//! | `correlation`            | string           | `gaussian` e^(−x²/l²), `exponential` e^(−x/l), or `k`         | `gaussian` |
//! | `exponent`               | float            | c of `k`: the spectrum of heights falls as (1 + l²q²)^(−c)    | 2.5        |
//! | `material`, or `eta`, `k`| string, spectrum | the metal, as `conductor`                                     | 0, 1       |
//! | `int_ior`, `ext_ior`     | float or string  | instead of a metal: indices behind and before, as `dielectric`| –, `air`   |
//! | `specular_reflectance`   | spectrum         | factor on the reflected power (not physical)                  | 1          |
//! | `specular_transmittance` | spectrum         | factor on the transmitted power, glass only (not physical)    | 1          |
//!
//! ```xml
//! <bsdf type="roughsurface">
//!     <string name="material" value="Au"/><string name="height" value="60nm"/><string name="length" value="5um"/>
//! </bsdf>
//! ```
//!
//! Of the phase variance `g = (φ_z σ)²`, φ_z the vertical part of the wave vector that light gives to the surface
//! (4π cos θ/λ in a mirror), a share e^(−g) stays a sharp mirror image, or refraction. The rest is a lobe: that of the
//! spectrum of heights for small g, of width λ/l; `roughconductor`'s Beckmann lobe with alpha = 2σ/l for large g and
//! Gaussian correlation, in reflection and in refraction. Fresnel's equations hold on the facet that mirrors or refracts,
//! with polarization. `exponential` is `k` with `exponent` 1.5: steps without slopes, and a far-reaching lobe.
//!
//! Where slopes exist Smith's shadowing is on the lobe; a reciprocal factor keeps it from making light at grazing
//! incidence, reflected and refracted together. Light that would meet a second facet is lost. The lobe answers to the
//! coherence of light: emitters are cut into patches. A metal is one-sided, glass has two sides. Lobes are good to 5e-4 of
//! their peak.
//!
//! Source: Beckmann and Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces, 1963, chapter 5;
//! Theorem S4.1 of Steinberg and Yan's supplemental; facets: Walter et al., EGSR 2007, Eqs. 20, 21.

mod cap;
mod lobe;
mod pair;
mod relief;
#[cfg(test)]
mod tests;

use glam::Vec3A;

use super::conductor::Metal;
use super::dielectric::{Faces, glass_parameter};
use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, dark, mirror};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;
use cap::Cap;
use pair::{Blur, Lit, Media};
use relief::Heights;

/// Least chance, beside Fresnel's, of a diffuse lobe that facets away from the mean may fill.
const LEAST_LOBE: f32 = 0.05;

/// A rough surface.
#[derive(Clone, Debug)]
pub struct RoughSurface {
    heights: Heights,
    facet: Facet,
    cap: Cap,
}

/// What every facet does.
#[derive(Clone, Debug)]
enum Facet {
    Metal(Metal),
    Glass(Box<Glass>),
}

#[derive(Clone, Debug)]
struct Glass {
    faces: Faces,
    reflectance: Spectrum,
    transmittance: Spectrum,
}

/// Draws yes with a probability; `u` is uniform before and after.
#[inline]
fn choose(u: &mut f32, probability: f32) -> bool {
    if *u < probability {
        *u /= probability;
        true
    } else {
        *u = ((*u - probability) / (1.0 - probability)).min(1.0 - f32::EPSILON);
        false
    }
}

/// The direction with the other side made the upper one.
#[inline]
fn above(v: Vec3A, side: f32) -> Vec3A {
    Vec3A::new(v.x, v.y, v.z * side)
}

impl RoughSurface {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let heights = Heights::read(object)?;
        let Some(parameter) = glass_parameter(object)? else {
            let media = Media {
                n_i: 1.0,
                n_o: 1.0,
                transmitted: false,
            };
            return Ok(Self {
                heights,
                facet: Facet::Metal(Metal::read(object)?),
                cap: Cap::new(vec![vec![media]]),
            });
        };
        let faces = Faces::read(object, "bk7")?;
        let [outside, inside] = faces.indices();
        if (inside - outside).abs() < 1e-6 * inside {
            return Err(object.error_at(
                parameter,
                format!("an index of {inside} on both sides, expected two different ones; 'null' is no surface"),
            ));
        }
        let glass = Glass {
            faces,
            reflectance: object.factor("specular_reflectance")?,
            transmittance: object.factor("specular_transmittance")?,
        };
        let n = [outside as f32, inside as f32];
        let passage = |from: usize, to: usize| Media {
            n_i: n[from],
            n_o: n[to],
            transmitted: from != to,
        };
        Ok(Self {
            heights,
            facet: Facet::Glass(Box::new(glass)),
            cap: Cap::new(vec![
                vec![passage(0, 0), passage(0, 1)],
                vec![passage(1, 1), passage(1, 0)],
            ]),
        })
    }

    /// Whether it has one side only.
    pub fn is_metal(&self) -> bool {
        matches!(self.facet, Facet::Metal(_))
    }

    /// Passages of light that leaves on the side of `o`: reflected, and transmitted.
    #[inline]
    fn passages(&self, o: Vec3A) -> [Option<Media>; 2] {
        let media = |n_i, n_o, transmitted| Media {
            n_i,
            n_o,
            transmitted,
        };
        match &self.facet {
            Facet::Metal(_) => [Some(media(1.0, 1.0, false)), None],
            Facet::Glass(glass) => {
                let face = glass.faces.side(o.z > 0.0);
                let [n_o, n_i] = [face.n_incident() as f32, face.n_transmitted() as f32];
                [Some(media(n_o, n_o, false)), Some(media(n_i, n_o, true))]
            }
        }
    }

    /// Chances of the parts for light that leaves along `o`: sharp reflection, sharp refraction, and both lobes.
    #[inline]
    fn chances(&self, o: Vec3A, wavelengths: &[f32]) -> [f32; 4] {
        let cos = o.z.abs();
        let [reflected, least] = match &self.facet {
            Facet::Metal(_) => [1.0, 0.0],
            Facet::Glass(glass) => [
                glass
                    .faces
                    .side(o.z > 0.0)
                    .reflection(f64::from(cos.min(1.0)))
                    .mean as f32,
                LEAST_LOBE,
            ],
        };
        let powers = [reflected, 1.0 - reflected];
        let mut chances = [0.0; 4];
        for wavelength in wavelengths {
            let lit = Lit::new(&self.heights, *wavelength);
            for (place, media) in self.passages(o).into_iter().enumerate() {
                let Some(media) = media else { continue };
                let g = lit.specular_variance(media, cos);
                chances[place] += powers[place] * (-g).exp();
                chances[2 + place] += powers[place].max(least) * -(-g).exp_m1();
            }
        }
        let sum: f32 = chances.iter().sum();
        chances.map(|c| c / sum)
    }

    /// `1/max(1, A(i), A(o))`.
    #[inline]
    fn cap(&self, i: Vec3A, o: Vec3A, wavelength: f32) -> f32 {
        let ratio = |v: Vec3A| {
            let side = usize::from(v.z < 0.0 && !self.is_metal());
            let share = |media: &Media, cos: f32| self.share(side, media, cos);
            self.cap
                .log_ratio(&self.heights, side, wavelength, v.z, share)
        };
        let most = ratio(i).max(ratio(o)).max(0.0);
        if most > 0.0 { (-most).exp() } else { 1.0 }
    }

    /// The power by which a facet answers light from a side; of a metal, one without loss.
    fn share(&self, side: usize, media: &Media, cos: f32) -> f32 {
        match &self.facet {
            Facet::Metal(_) => 1.0,
            Facet::Glass(glass) => {
                let face = glass.faces.side(side == 0);
                let reflected = face.reflection(f64::from(cos)).mean as f32;
                if media.transmitted {
                    1.0 - reflected
                } else {
                    reflected
                }
            }
        }
    }

    /// The matrix of a facet at `cos` for light from `i`'s side, radiance not counted by indices.
    #[inline]
    fn facet(&self, i: Vec3A, cos: f32, transmitted: bool, wavelength: f32) -> Element {
        match &self.facet {
            Facet::Metal(metal) => metal.reflection(cos, wavelength),
            Facet::Glass(glass) => {
                let (face, cos) = (glass.faces.side(i.z > 0.0), f64::from(cos));
                if transmitted {
                    face.transmission(cos).map_or(Element::BLACK, |t| {
                        Element::from(t.element).scaled(glass.transmittance.value(wavelength))
                    })
                } else {
                    Element::from(face.reflection(cos)).scaled(glass.reflectance.value(wavelength))
                }
            }
        }
    }

    /// Where sharply refracted light comes from.
    #[inline]
    fn refracted(&self, media: Media, o: Vec3A) -> Option<Vec3A> {
        let eta = media.n_i / media.n_o;
        let cos2 = 1.0 - (1.0 - o.z * o.z) / (eta * eta);
        (cos2 > 0.0)
            .then(|| Vec3A::new(-o.x / eta, -o.y / eta, -cos2.sqrt().copysign(o.z)).normalize())
    }

    fn sharp<L: Light>(
        &self,
        media: Media,
        i: Vec3A,
        o: Vec3A,
        wavelengths: &[f32],
    ) -> L::Response {
        let cos = i.z.abs().min(1.0);
        // radiance counts by the squared index of its medium
        let scale = (media.n_o / media.n_i).powi(2);
        L::diattenuating_retarder(axis_s(Vec3A::Z, i), |lane| {
            let wavelength = wavelengths[lane];
            let g = Lit::new(&self.heights, wavelength).specular_variance(media, o.z);
            self.facet(i, cos, media.transmitted, wavelength)
                .scaled(scale * (-g).exp())
        })
    }
}

impl Matter for RoughSurface {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        if o.z == 0.0 || (o.z < 0.0 && self.is_metal()) {
            return None;
        }
        let chances = self.chances(o, wavelengths);
        let passages = self.passages(o);
        let [mut choice, v, w] = u;
        let transmitted = choose(&mut choice, chances[1] + chances[3]);
        let media = passages[usize::from(transmitted)]?;
        let part = usize::from(transmitted);
        let eta = media.n_i / media.n_o;
        if choose(
            &mut choice,
            chances[part] / (chances[part] + chances[2 + part]),
        ) {
            let direction = if transmitted {
                self.refracted(media, o)?
            } else {
                mirror(o, Vec3A::Z)
            };
            return Some(Departure {
                direction,
                density: chances[part],
                part: Part::Discrete(part as u32),
                eta,
            });
        }
        // one wavelength leads, the density is that of all
        let lane = ((choice * wavelengths.len() as f32) as usize).min(wavelengths.len() - 1);
        let choice =
            (choice * wavelengths.len() as f32 - lane as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let side = o.z.signum();
        let lit = Lit::new(&self.heights, wavelengths[lane]);
        let direction = above(lit.draw(media, above(o, side), choice, [v, w])?, side);
        let density = self.density(direction, o, wavelengths);
        Departure::continuous(direction, density, eta)
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        if i.z == 0.0 || o.z == 0.0 || (o.z < 0.0 && self.is_metal()) {
            return dark::<L>();
        }
        let transmitted = o.z * i.z < 0.0;
        let Some(media) = self.passages(o)[usize::from(transmitted)] else {
            return dark::<L>();
        };
        if part != Part::Continuous {
            return (self.sharp::<L>(media, i, o, wavelengths), 0.0);
        }
        let density = self.density(i, o, wavelengths);
        let h = media.momentum(i, o).normalize_or_zero();
        let cos = i.dot(h).abs().min(1.0);
        let blur = Blur::of(coherence, &at.frame);
        let response = L::diattenuating_retarder(axis_s(h, i), |lane| {
            let wavelength = wavelengths[lane];
            let power = Lit::new(&self.heights, wavelength).power(media, i, o, &blur);
            if power <= 0.0 {
                return Element::BLACK;
            }
            let weight = power * self.cap(i, o, wavelength) / o.z.abs();
            self.facet(i, cos, transmitted, wavelength).scaled(weight)
        });
        (response, density)
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }

    fn left_out(&self) -> Option<String> {
        Some(format!(
            "all but at most {} Gaussians of its lobe, the rest is below {} of the peak",
            self.heights.lobes.most_terms(),
            lobe::TOLERANCE
        ))
    }

    fn lobe_width(&self, at: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        let widths = wavelengths.iter().flat_map(|wavelength| {
            let lit = Lit::new(&self.heights, *wavelength);
            let media = self.passages(at.o).into_iter().flatten();
            media.map(move |media| lit.narrowest(media, at.o.z) / media.n_i)
        });
        Some(widths.fold(f32::INFINITY, f32::min))
    }

    fn bend(&self, at: &Vertex, part: Part, _: &[f32]) -> Option<Vec3A> {
        match part {
            Part::Discrete(0) => Some(mirror(at.o, Vec3A::Z)),
            _ => self.refracted(self.passages(at.o)[1]?, at.o),
        }
    }

    fn traits(&self) -> Traits {
        Traits {
            coherent: true,
            ..Traits::default()
        }
    }
}

impl RoughSurface {
    /// Density per steradian of the diffuse directions that `sample` draws.
    #[inline]
    fn density(&self, i: Vec3A, o: Vec3A, wavelengths: &[f32]) -> f32 {
        let part = usize::from(o.z * i.z < 0.0);
        let Some(media) = self.passages(o)[part] else {
            return 0.0;
        };
        let side = o.z.signum();
        let (i, o_above) = (above(i, side), above(o, side));
        let sum: f32 = wavelengths
            .iter()
            .map(|w| Lit::new(&self.heights, *w).density(media, i, o_above))
            .sum();
        self.chances(o, wavelengths)[2 + part] * sum / wavelengths.len() as f32
    }
}
