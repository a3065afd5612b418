//! `grating`: a periodic relief on metal or glass, with its orders in reflection and transmission.
//!
//! | parameter | type | meaning | default |
//! |---|---|---|---|
//! | `pitch` | length | period | required |
//! | `depth` | length | from valley to peak | required |
//! | `profile` | string | `sinusoidal`, `lamellar`, `blazed` (rises along the direction) or `triangular` | `sinusoidal` |
//! | `duty` | float | lamellar: share of the pitch that is ridge | 0.5 |
//! | `apex` | float | triangular: place of the peak, as a share of the pitch | 0.5 |
//! | `pitch_v` | length | a second grating added to the first, a quarter turn from it; with it `depth_v`, `profile_v`, `duty_v`, `apex_v` | none; those of the first |
//! | `angle` | float | degrees from axis U to the direction across the grooves, counter-clockwise from the front | 0 |
//! | `direction` | vector | the direction across the grooves in world space, projected on the surface, instead of `angle` | – |
//! | `height`, `length` | length | roughness on top: rms height, correlation length of Gaussian heights | 0, – |
//! | `size` | length | the grating is coherent over this size: e^(−1/2) of its aperture's autocorrelation | infinite |
//! | `sharing` | string | `capped`: orders share what arrives; `phase`: as the phase alone says, which may be more | `capped` |
//! | `material`, or `eta`, `k`; `specular_reflectance` | | a metal, as `conductor` | 0, 1; 1 |
//! | `int_ior`, `ext_ior` | float or string | glass instead, as `dielectric` | `bk7`, `air` |
//!
//! Lengths are numbers in metres or texts with a unit: `1.6um`, `120nm`.
//!
//! ```xml
//! <bsdf type="grating">
//!     <string name="pitch" value="1.6um"/><string name="depth" value="120nm"/>
//!     <string name="profile" value="lamellar"/><string name="material" value="Al"/>
//! </bsdf>
//! ```
//!
//! Light from i leaves in orders q along `n_o o = −n_i i + qG/k₀` (tangential parts, so also in conical mounts), `G = 2π/pitch`
//! across the grooves. Each carries `|t_q|²`, `t_q = (1/p) ∫ e^(−iφ_z h(x)) e^(−iqGx) dx` with `φ_z = k₀ (n_i cos i + n_o cos o)` of
//! its own two directions, times the Fresnel matrix of the facet that leads one into the other. Over all orders that
//! propagate these may add up to more than arrives, N > 1: all are then divided by the larger N of their two ends, which
//! keeps reciprocity. On glass N counts both sides, with the larger of the two Fresnel powers of every order. Where N < 1 the
//! rest is lost.
//!
//! Orders are sharp where `size` is infinite: directions of their own, through which mirror images of lamps are seen. With
//! a `size` s they are Gaussian lobes of variance 1/s² in wave vector, and light from emitters of any size is averaged over
//! them patch by patch. Roughness leaves `e^(−g)`, `g = (φ_z height)²`, in an order and spreads the rest about it, `m` times
//! scattered with the weight of Poisson and variance `2m/length²` (beyond g = 60 as one Gaussian, off by 1/g). No obliquity
//! factor: a rough order carries what the sharp one does. Haloes should be narrow, `length` longer than the wavelength.
//!
//! Scalar theory: good for pitches above five wavelengths and depths below a quarter of the pitch. A metal grating is one-sided.
//!
//! Source: Goodman, Introduction to Fourier Optics, 3rd ed., section 4.4; Born and Wolf, Principles of Optics, 7th ed., section
//! 8.6.1; Beckmann and Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces, 1963, for the haloes.

mod lines;
mod lobes;
mod orders;
mod read;
mod shares;
#[cfg(test)]
mod tests;

use glam::{DVec3, Vec3A};

use super::conductor::Metal;
use super::dielectric::Faces;
use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, dark};
use crate::coherence::Coherence;
use crate::light::{Element, Light};
use lines::Lines;
use lobes::Lobes;
use orders::{Order, View};

/// A grating.
#[derive(Clone, Debug)]
pub struct Grating {
    boundary: Boundary,
    lines: Lines,
    lobes: Lobes,
    capped: bool,
    doubts: [Doubt; 2],
}

/// Where scalar theory is not to be trusted.
#[derive(Clone, Debug)]
struct Doubt {
    /// Wavelength beyond which, nm.
    beyond: f64,
    /// Why, and the place in the scene file.
    text: String,
}

/// What the relief is made in.
#[derive(Clone, Debug)]
enum Boundary {
    Metal(Metal),
    Glass(Faces),
}

impl Boundary {
    /// Index of the medium on a side.
    fn index(&self, above: bool) -> f64 {
        match self {
            Self::Metal(_) => 1.0,
            Self::Glass(faces) => faces.side(above).n_incident(),
        }
    }

    /// The larger index of the two media.
    fn largest_index(&self) -> f64 {
        self.index(true).max(self.index(false))
    }

    /// Normal and Mueller matrix of the facet that leads light from `i` to `o`; `None` if it is met from its back or
    /// reflects all of what it should pass.
    fn facet(&self, i: DVec3, o: DVec3, wavelength: f32) -> Option<(DVec3, Element)> {
        let [n_i, n_o] = [i, o].map(|d| self.index(d.z > 0.0));
        let phi = n_o * o + n_i * i;
        let length = phi.length();
        // no refraction, no facet: straight through
        let mut h = if length > 1e-9 {
            phi / length
        } else {
            DVec3::Z
        };
        if h.z < 0.0 {
            h = -h;
        }
        if h.dot(i) * i.z <= 0.0 || h.dot(o) * o.z <= 0.0 {
            return None;
        }
        let cos = h.dot(i).abs().min(1.0);
        let element = match self {
            Self::Metal(metal) => metal.reflection(cos as f32, wavelength),
            Self::Glass(faces) => {
                let interface = faces.side(i.z > 0.0);
                if i.z * o.z > 0.0 {
                    interface.reflection(cos).into()
                } else {
                    interface.transmission(cos)?.element.into()
                }
            }
        };
        Some((h, element))
    }
}

impl Grating {
    /// Whether light meets it from both sides by itself.
    pub fn is_two_sided(&self) -> bool {
        matches!(self.boundary, Boundary::Glass(_))
    }

    /// Whether the surface can be seen from a direction.
    fn faces(&self, o: Vec3A) -> bool {
        o.z > 0.0 || (o.z < 0.0 && self.is_two_sided())
    }

    /// What every order from `i` to `o` has in common: the cap of its share, and its facet.
    fn passes(&self, view: &View, i: DVec3, o: DVec3) -> Option<(f64, DVec3, Element)> {
        let (h, element) = self.boundary.facet(i, o, view.wavelength)?;
        Some((self.cap(view, i, o), h, element))
    }

    /// A sharp order, seen from `o`.
    fn sharp<L: Light>(&self, view: &View, i: Vec3A, o: Vec3A, q: [i32; 2]) -> L::Response {
        let (i64, o64) = (unit(i), unit(o));
        let Some((cap, h, element)) = self.passes(view, i64, o64) else {
            return L::depolarizing(|_| 0.0);
        };
        let [n_i, n_o] = [i64, o64].map(|d| self.boundary.index(d.z > 0.0));
        let phi_z = view.k0 * (n_i * i64.z + n_o * o64.z);
        let left = (-self.lobes.phase_variance(phi_z)).exp();
        let weight = self.lines.share(q, phi_z) * cap * left * (n_o / n_i).powi(2);
        L::diattenuating_retarder(axis_s(h.as_vec3a(), i), |_| element.scaled(weight as f32))
    }
}

/// In double precision, of unit length.
fn unit(v: Vec3A) -> DVec3 {
    v.as_dvec3().normalize()
}

impl Matter for Grating {
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        if !self.faces(at.o) {
            return None;
        }
        let view = self.view(at, wavelengths[0]);
        let o = unit(at.o);
        let (order, probability, rest) = self.draw_order(&view, o, u[0])?;
        let n_o = self.boundary.index(o.z > 0.0);
        let Some(turn) = self.lobes.draw(&view, &order, rest, [u[1], u[2]]) else {
            // sharp
            let g = self.lobes.phase_variance(order.phi_z);
            return Some(Departure {
                direction: order.direction.as_vec3a().normalize(),
                density: (probability * (-g).exp()) as f32,
                part: Part::Discrete(order.code()),
                eta: (order.index / n_o) as f32,
            });
        };
        let tangential = order.tangential() + turn / order.index;
        let cos2 = 1.0 - tangential.length_squared();
        if cos2 <= 1e-12 {
            return None;
        }
        let i = tangential.extend(cos2.sqrt().copysign(order.side));
        let density = self.density(&view, i, o);
        Departure::continuous(
            i.as_vec3a().normalize(),
            density as f32,
            (order.index / n_o) as f32,
        )
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        if !self.faces(at.o) || !self.faces(i) {
            return dark::<L>();
        }
        let view = self.view(at, wavelengths[0]);
        if let Part::Discrete(code) = part {
            return (self.sharp::<L>(&view, i, at.o, Order::of_code(code).0), 0.0);
        }
        let (i64, o64) = (unit(i), unit(at.o));
        let lobe = self.lobe(&view, i64, o64, &self.spread(&view, at, i64, coherence));
        if lobe <= 0.0 {
            return dark::<L>();
        }
        let density = self.density(&view, i64, o64) as f32;
        let Some((cap, h, element)) = self.passes(&view, i64, o64) else {
            return (L::depolarizing(|_| 0.0), density);
        };
        let n_o = self.boundary.index(o64.z > 0.0);
        let weight = (n_o * n_o * lobe * cap * i64.z.abs()) as f32;
        let response =
            L::diattenuating_retarder(axis_s(h.as_vec3a(), i), |_| element.scaled(weight));
        (response, density)
    }

    fn effect(&self) -> Effect {
        Effect {
            makes_linear: true,
            retards: true,
            ..Effect::default()
        }
    }

    fn lobe_width(&self, _: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        let k0 = std::f64::consts::TAU / (f64::from(wavelengths[0]) * 1e-9);
        let width = self.lobes.narrowest()?;
        Some((width / (k0 * self.boundary.largest_index())) as f32)
    }

    fn bend(&self, at: &Vertex, part: Part, wavelengths: &[f32]) -> Option<Vec3A> {
        let Part::Discrete(code) = part else {
            return None;
        };
        if !self.faces(at.o) {
            return None;
        }
        let view = self.view(at, wavelengths[0]);
        self.order_of(&view, unit(at.o), code)
            .map(|direction| direction.as_vec3a().normalize())
    }

    fn traits(&self) -> Traits {
        Traits {
            discrete: !self.lobes.exist(),
            coherent: self.lobes.exist(),
            disperses: true,
            ..Traits::default()
        }
    }

    fn doubts(&self, [_, longest]: [f64; 2]) -> Vec<String> {
        // the graver first
        let found = self.doubts.iter().find(|doubt| longest > doubt.beyond);
        found.iter().map(|doubt| doubt.text.clone()).collect()
    }
}
