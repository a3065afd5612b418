//! Thin isotropic films: amplitudes of a stack of homogeneous layers between two half-spaces.
//!
//! In a layer of index n the tangential fields `(u, v)`, `u = E_s` or `H_p` and v the other one, obey
//! `u' = −i k₀ a v`, `v' = −i k₀ b u`, with z into the stack and
//!
//! ```text
//! s: a = 1    b = w²          p: a = n²   b = w²/n²         w = n cos θ = √(n² − n₁² sin² θ₁),  Im w ≤ 0
//! ```
//!
//! The wave that leaves into the exit medium has `(u, v) = (1, w/a)`. From there the fields are carried up to the
//! incident medium, layer by layer, by the characteristic matrix, times the decaying exponential `e^{−iφ}`, `φ = k₀ w d`,
//! wherever φ is not real:
//!
//! ```text
//! e^{−iφ} [cos φ    ia sin φ/w]      C = (1 + E)/2       E = e^{−2iφ}, |E| ≤ 1
//!         [ib sin φ/w    cos φ]      sin φ e^{−iφ}/w = (1 − E)/(2iw), and k₀ d where w = 0
//! ```
//!
//! No exponential grows, whatever the thickness; the factors `e^{−iφ}` are collected in the transmitted amplitude, which
//! underflows to 0. Nothing is divided by w or by an amplitude of reflection, so that layers met at their critical angle,
//! evanescent layers and guided waves behind an evanescent layer are no special cases. Fields are carried against the
//! direction in which they decay, so rounding errors decay: power is conserved to 1e-14 a layer. The phase has an
//! error of `f64::EPSILON` times `k₀ n d`, which no method can avoid.
//!
//! Source: Born & Wolf, Principles of Optics, 7th ed., section 1.6.2, with fields in `exp(+iωt)`.

use num_complex::Complex64;
use stokes::{DiattenuatingRetarder, Mueller, Wavelength};

use crate::JonesMatrix;
use crate::fresnel::{Amplitudes, normal_index_of};
use crate::layered::{self, checked_index, checked_thickness, transparent_index};
pub use crate::layered::{FilmError, Medium};

const I: Complex64 = Complex64::I;

/// A homogeneous isotropic layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Refractive index `η − ik`, `η, k ≥ 0`.
    pub index: Complex64,
    /// Thickness in metres.
    pub thickness: f64,
}

/// Layers between an incident and an exit half-space.
///
/// A quarter-wave layer of magnesium fluoride takes the reflection of glass from 4.26 % to 1.26 %:
/// ```
/// use csdm::film::{Layer, Stack};
/// use stokes::Wavelength;
/// let green = Wavelength::from_metres(550e-9)?;
/// let coating = Layer { index: 1.38.into(), thickness: 550e-9 / (4.0 * 1.38) };
/// let lens = Stack::new(1.0, vec![coating], 1.52.into())?;
/// assert!((lens.amplitudes(1.0, green).reflectance()[0] - 0.01260).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    incident: f64,
    layers: Vec<Layer>,
    exit: Complex64,
}

/// What a stack makes of the fields of plane waves of amplitude 1, along s and p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StackAmplitudes {
    /// Of the reflected light; the plane of reference is the front of the first layer.
    pub reflected: Amplitudes,
    /// Of the transmitted light, electric field behind the last layer to electric field before the first.
    pub transmitted: Amplitudes,
    /// `[s, p]`: the power that crosses is this times the squared modulus of the amplitude. Infinite at grazing
    /// incidence.
    pub power_weight: [f64; 2],
    exit: Complex64,
}

impl Stack {
    /// The stack of `layers`, the first one next to the incident medium of index `incident`, the last one next to the
    /// exit medium of index `exit`.
    ///
    /// # Errors
    ///
    /// When an index is not `η − ik` with `η, k ≥ 0` and a modulus between 1e-8 and 1e8, or a thickness not
    /// between 0 and 1e6 m.
    pub fn new(incident: f64, layers: Vec<Layer>, exit: Complex64) -> Result<Self, FilmError> {
        let incident = transparent_index(incident.into(), Medium::Incident)?;
        for (number, layer) in layers.iter().enumerate() {
            checked_index(layer.index, Medium::Layer(number))?;
            checked_thickness(layer.thickness, Medium::Layer(number))?;
        }
        Ok(Self {
            incident,
            layers,
            exit: checked_index(exit, Medium::Exit)?,
        })
    }

    /// The stack met from its other side.
    ///
    /// # Errors
    ///
    /// When the exit medium absorbs.
    pub fn reversed(&self) -> Result<Self, FilmError> {
        Ok(Self {
            incident: transparent_index(self.exit, Medium::Exit)?,
            layers: self.layers.iter().rev().copied().collect(),
            exit: self.incident.into(),
        })
    }

    /// Amplitudes of reflection and transmission for light that comes at an angle of cosine `cos_i`, in `0.0..=1.0`.
    ///
    /// Frames: s, p as on the page of [`crate::fresnel`]. Error of `f64::EPSILON` times the sum of the `k₀ n d`, times
    /// the finesse where the stack is a resonator.
    ///
    /// Source: Born & Wolf, 7th ed., section 1.6.2, Eqs. (51), (52); see the module page for the form that is used.
    #[must_use]
    pub fn amplitudes(&self, cos_i: f64, wavelength: Wavelength) -> StackAmplitudes {
        let n1 = self.incident;
        let w = normal_index_of(n1.into(), self.exit, cos_i);
        let (r_s, t_s) = self.fields(cos_i, wavelength, n1 * cos_i, w, |_| Complex64::ONE);
        let (r_p, t_p) = self.fields(
            cos_i,
            wavelength,
            cos_i / n1,
            w / self.exit / self.exit,
            |n| n * n,
        );
        StackAmplitudes {
            reflected: Amplitudes { s: r_s, p: r_p },
            transmitted: Amplitudes {
                s: t_s,
                // from the magnetic to the electric field
                p: t_p * (n1 / self.exit),
            },
            power_weight: layered::power_weight(n1, self.exit, cos_i),
            exit: self.exit,
        }
    }

    /// Reflected and transmitted u for one polarization: `rho` is v/u of the incident wave, `rho_exit` that of the
    /// transmitted one, `a_of` the coefficient a of the module page for a layer's index.
    fn fields(
        &self,
        cos_i: f64,
        wavelength: Wavelength,
        rho: f64,
        rho_exit: Complex64,
        a_of: impl Fn(Complex64) -> Complex64,
    ) -> (Complex64, Complex64) {
        let (mut u, mut v, mut passed) = (Complex64::ONE, rho_exit, Complex64::ONE);
        for layer in self.layers.iter().rev() {
            let w = normal_index_of(self.incident.into(), layer.index, cos_i);
            let a = a_of(layer.index);
            let depth = layered::optical_depth(layer.thickness, wavelength);
            let Characteristic {
                cosine,
                sine,
                decay,
            } = Characteristic::new(w, depth);
            (u, v) = (
                cosine * u + I * a * sine * v,
                cosine * v + I * (w * w / a) * sine * u,
            );
            let norm = u.norm().hypot(v.norm());
            (u, v) = (u / norm, v / norm);
            passed *= decay / norm;
        }
        let incoming = rho * u + v;
        if incoming == Complex64::ZERO {
            return (-Complex64::ONE, Complex64::ZERO);
        }
        ((rho * u - v) / incoming, 2.0 * rho * passed / incoming)
    }
}

impl StackAmplitudes {
    /// The Jones matrix of reflection, `diag(r_s, r_p)`.
    #[must_use]
    pub fn reflection(&self) -> JonesMatrix {
        JonesMatrix::diagonal(self.reflected.s, self.reflected.p)
    }

    /// The Jones matrix of transmission, `diag(t_s, t_p)`, without power weights.
    #[must_use]
    pub fn transmission(&self) -> JonesMatrix {
        JonesMatrix::diagonal(self.transmitted.s, self.transmitted.p)
    }

    /// Reflected share of the power, `[s, p]`.
    #[must_use]
    pub fn reflectance(&self) -> [f64; 2] {
        [self.reflected.s.norm_sqr(), self.reflected.p.norm_sqr()]
    }

    /// Share of the power that crosses into the exit medium, `[s, p]`.
    #[must_use]
    pub fn transmittance(&self) -> [f64; 2] {
        let of = |amplitude: Complex64, weight: f64| {
            if weight.is_finite() {
                amplitude.norm_sqr() * weight
            } else {
                0.0
            }
        };
        let [s, p] = self.power_weight;
        [of(self.transmitted.s, s), of(self.transmitted.p, p)]
    }

    /// The Mueller matrix of reflection.
    #[must_use]
    pub fn reflection_mueller(&self) -> Mueller {
        DiattenuatingRetarder::from_amplitudes(self.reflected.s, self.reflected.p).to_mueller()
    }

    /// The Mueller matrix of transmission, power weight included; all zeros beyond the critical angle of the exit medium.
    ///
    /// The change of radiance with the solid angle is not in it.
    ///
    /// # Errors
    ///
    /// When the exit medium absorbs: then s and p carry power with different weights.
    pub fn transmission_mueller(&self) -> Result<Mueller, FilmError> {
        layered::transmission_mueller(&self.transmission(), self.power_weight[0], self.exit)
    }
}

/// The functions of `φ = w k₀ d` in a layer's matrix, all of them times `decay`, which is `e^{−iφ}`, or 1 where the wave
/// does not decay.
struct Characteristic {
    cosine: Complex64,
    /// `sin φ/w`
    sine: Complex64,
    decay: Complex64,
}

impl Characteristic {
    fn new(w: Complex64, depth: f64) -> Self {
        let phase = w * depth;
        if w == Complex64::ZERO {
            return Self {
                cosine: Complex64::ONE,
                sine: depth.into(),
                decay: Complex64::ONE,
            };
        }
        if phase.im == 0.0 {
            // real numbers stay real: the phase of a totally reflected wave is kept apart from its modulus
            return Self {
                cosine: phase.re.cos().into(),
                sine: phase.re.sin() / w,
                decay: Complex64::ONE,
            };
        }
        let lost = -exp_m1(-2.0 * I * phase);
        Self {
            cosine: 1.0 - 0.5 * lost,
            sine: lost / (2.0 * I * w),
            decay: (-I * phase).exp(),
        }
    }
}

/// `e^z − 1` without cancellation for small z.
fn exp_m1(z: Complex64) -> Complex64 {
    let grown = z.re.exp_m1();
    let (sine, cosine) = z.im.sin_cos();
    let half = (0.5 * z.im).sin();
    Complex64::new(grown * cosine - 2.0 * half * half, (grown + 1.0) * sine)
}

#[cfg(test)]
mod tests;
