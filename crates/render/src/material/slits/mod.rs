//! `slits`: openings in an opaque screen, under light of any coherence.
//!
//! | parameter | type | meaning | default |
//! |---|---|---|---|
//! | `count` | integer | equal openings side by side along axis U, about the middle of the shape | 2 |
//! | `width`, `height` | length | of each, along U and V | required |
//! | `spacing` | length | from centre to centre | required for two or more |
//! | `openings` | string | instead: `x y width height` of each, separated by `;`, from the middle of the shape | – |
//!
//! Lengths are numbers in metres or texts with a unit: `50um`, `0.2mm`; in `openings` units are needed.
//!
//! ```xml
//! <shape type="rectangle">
//!     <transform name="to_world"><scale value="0.001"/></transform>
//!     <bsdf type="slits">
//!         <string name="width" value="20um"/><string name="height" value="20um"/><string name="spacing" value="100um"/>
//!     </bsdf>
//! </shape>
//! ```
//!
//! On a `rectangle` only. Light passes and is diffracted; its polarization stays. With the transform `A_n` of opening n, source
//! point Y and viewer P,
//!
//! ```text
//! f = 1/(λ² A) Σ_nm A_n A_m γ(x_n − x_m) e^(−ik(l_n − l_m)),     l_n = |P − x_n| + |Y − x_n|
//! ```
//!
//! is spread evenly over the area A of the rectangle; γ is the degree of coherence of an emitter's patch. The emitter's patches
//! together make the fringes' visibility what van Cittert and Zernike's theorem says, `|sinc(αd/λ)|` for a slit source of
//! angular width α and `|2 J1(u)/u|`, `u = παd/λ`, for a disk. Each opening has its own path, so that viewer and source
//! may be near, as long as they are in the far field of each single opening. The screen absorbs what it does not pass.
//!
//! The viewer is where the path was before: behind a mirror or lens fringes are in place, their curvature is not.
//! At most 64 openings: the sum goes over pairs. `grating` holds more.
//!
//! Source: Goodman, Introduction to Fourier Optics, 3rd ed., section 4.3; Goodman, Statistical Optics, sections 5.2 and 5.6.

mod read;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Mat4, Vec3A};

use super::{Departure, Effect, Matter, Part, Traits, Vertex, dark};
use crate::coherence::Coherence;
use crate::emitter::patch::Outline;
use crate::light::Light;

/// A rectangular opening, metres in the axes U, V from the middle of the screen.
#[derive(Clone, Copy, Debug)]
struct Opening {
    centre: DVec2,
    width: f64,
    height: f64,
}

/// A screen with openings.
#[derive(Clone, Debug)]
pub struct Slits {
    openings: Vec<Opening>,
    /// Longest distance across all openings, metres.
    extent: f64,
    open_area: f64,
    /// Middle and area of the shape it is on, once that is known.
    place: Option<(Vec3A, f64)>,
}

/// One opening between a source point and a viewer: strength and phase.
#[derive(Clone, Copy)]
struct Wave {
    amplitude: f64,
    phase: f64,
    centre: DVec2,
}

impl Slits {
    /// The same on a shape.
    ///
    /// # Errors
    ///
    /// When an opening is not wholly on it.
    pub fn placed(&self, outline: &Outline) -> Result<Self, String> {
        let [u, v] = [outline.half_u, outline.half_v].map(|half| f64::from(half.length()));
        for o in &self.openings {
            let [x, y] = [
                o.centre.x.abs() + 0.5 * o.width,
                o.centre.y.abs() + 0.5 * o.height,
            ];
            if x > u * (1.0 + 1e-6) || y > v * (1.0 + 1e-6) {
                return Err(format!(
                    "an opening of bsdf 'slits' reaches to ({x:e}, {y:e}) m from the middle of a rectangle of half-widths \
                     ({u:e}, {v:e}) m, expected it to be on it"
                ));
            }
        }
        let area = 4.0 * f64::from(outline.half_u.cross(outline.half_v).length());
        Ok(Self {
            place: Some((outline.centre, area)),
            ..self.clone()
        })
    }

    /// 1/(λ²A) Σ… for light around direction `i` from the distance of `coherence`; 1/sr.
    fn transfer(&self, at: &Vertex, i: Vec3A, wavelength: f32, coherence: &Coherence) -> f64 {
        let Some((middle, area)) = self.place else {
            return 0.0;
        };
        let lambda = f64::from(wavelength) * 1e-9;
        let k = TAU / lambda;
        let off = at.frame.to_local(at.position - middle).as_dvec3();
        let viewer = Leg::new(off, at.o, at.viewer_distance);
        let source = Leg::new(off, i, coherence.distance);
        let roots = coherence
            .angular_root
            .map(|row| at.frame.to_local(row).as_dvec3().truncate() * k);
        let wave = |o: &Opening| {
            let (r, dr, near_r) = viewer.to(o.centre);
            let (s, ds, near_s) = source.to(o.centre);
            let kappa = (r + s) * k;
            let size =
                o.width * o.height * sinc(0.5 * kappa.x * o.width) * sinc(0.5 * kappa.y * o.height);
            Wave {
                amplitude: size * near_r * near_s,
                phase: k * (dr + ds),
                centre: o.centre,
            }
        };
        let mut sum = 0.0;
        for (n, o) in self.openings.iter().enumerate() {
            let a = wave(o);
            sum += a.amplitude * a.amplitude;
            for other in &self.openings[..n] {
                let b = wave(other);
                let x = a.centre - b.centre;
                let spread = roots[0].dot(x).powi(2) + roots[1].dot(x).powi(2);
                sum += 2.0
                    * a.amplitude
                    * b.amplitude
                    * (a.phase - b.phase).cos()
                    * (-0.5 * spread).exp();
            }
        }
        sum / (lambda * lambda * area)
    }

    /// Density per steradian of directions drawn: of wave vectors with Cauchy's distribution about straight passage, half as
    /// wide as the zeros of the opening's transform are apart, over π.
    fn density(&self, i: Vec3A, o: Vec3A, wavelength: f32) -> f32 {
        let k = TAU / (f64::from(wavelength) * 1e-9);
        let kappa = (i + o).as_dvec3().truncate() * k;
        let cauchy = |x: f64, scale: f64| scale / (PI * (scale * scale + x * x));
        let sum: f64 = self
            .openings
            .iter()
            .map(|a| {
                a.width
                    * a.height
                    * cauchy(kappa.x, 2.0 / a.width)
                    * cauchy(kappa.y, 2.0 / a.height)
            })
            .sum();
        (sum / self.open_area * k * k * f64::from(i.z.abs())) as f32
    }
}

/// From the middle of the screen to a point, in the screen's axes.
struct Leg {
    /// The point; a unit direction if it is infinitely far.
    point: DVec3,
    infinite: bool,
}

impl Leg {
    /// From a place `off` the middle along `direction`.
    fn new(off: DVec3, direction: Vec3A, distance: f32) -> Self {
        let direction = direction.as_dvec3().normalize();
        let infinite = !distance.is_finite();
        Self {
            point: if infinite {
                direction
            } else {
                off + direction * f64::from(distance)
            },
            infinite,
        }
    }

    /// Tangential direction from a place, how much longer the way is than from the middle, and how much stronger a
    /// spherical wave.
    fn to(&self, centre: DVec2) -> (DVec2, f64, f64) {
        let point = self.point;
        if self.infinite {
            return (point.truncate(), -point.truncate().dot(centre), 1.0);
        }
        let way = point - centre.extend(0.0);
        let (whole, length) = (point.length(), way.length());
        // from the square of the small one: the difference of the two ways is far below either
        let longer =
            (centre.length_squared() - 2.0 * point.truncate().dot(centre)) / (length + whole);
        (way.truncate() / length, longer, whole / length)
    }
}

/// sin x/x
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}

/// Axis V across a ray, or U where it is along V.
fn axis(k: Vec3A) -> Vec3A {
    let across = |v: Vec3A| v - k * k.dot(v);
    let v = across(Vec3A::Y);
    if v.length_squared() > 1e-6 {
        v.normalize()
    } else {
        across(Vec3A::X).normalize()
    }
}

impl Matter for Slits {
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let mut area = f64::from(u[0]) * self.open_area;
        let drawn = self.openings.iter().find(|o| {
            area -= o.width * o.height;
            area < 0.0
        });
        let opening = drawn.or(self.openings.last())?;
        let k = TAU / (f64::from(wavelengths[0]) * 1e-9);
        let cauchy = |u: f32, size: f64| 2.0 / (size * k) * (PI * (f64::from(u) - 0.5)).tan();
        let turn = DVec2::new(cauchy(u[1], opening.width), cauchy(u[2], opening.height));
        let tangential = turn - at.o.as_dvec3().truncate();
        let cos2 = 1.0 - tangential.length_squared();
        if cos2.is_nan() || cos2 <= 1e-12 || at.o.z == 0.0 {
            return None;
        }
        let side = -f64::from(at.o.z.signum());
        let direction = tangential.extend(cos2.sqrt() * side).as_vec3a().normalize();
        let density = self.density(direction, at.o, wavelengths[0]);
        (density > 0.0).then_some(Departure {
            direction,
            density,
            part: Part::Continuous,
            eta: 1.0,
        })
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        if at.o.z * i.z >= 0.0 {
            return dark::<L>();
        }
        let density = self.density(i, at.o, wavelengths[0]);
        let weight = self.transfer(at, i, wavelengths[0], coherence) * f64::from(i.z.abs());
        let matrix = Mat4::IDENTITY * weight as f32;
        (L::general(axis(at.o), axis(i), |_| matrix), density)
    }

    fn effect(&self) -> Effect {
        Effect::default()
    }

    /// A fringe of the outermost edges is 2π of these wide.
    fn lobe_width(&self, _: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        let k = TAU / (f64::from(wavelengths[0]) * 1e-9);
        Some((k * self.extent).recip() as f32)
    }

    fn traits(&self) -> Traits {
        Traits {
            coherent: true,
            disperses: true,
            ..Traits::default()
        }
    }
}
