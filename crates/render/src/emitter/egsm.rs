//! `egsm`: an electromagnetic Gaussian Schell-model source, a flat spot whose polarization depends on direction.
//!
//! | parameter  | type   | meaning                                                                     | default |
//! |------------|--------|-----------------------------------------------------------------------------|---------|
//! | `sigma`    | length | radius of the spot: its intensity falls as exp(−r²/2σ²) from the middle     | –       |
//! | `delta_xx` | length | width of the correlation of E_x with itself                                 | –       |
//! | `delta_yy` | length | of E_y with itself                                                          | `delta_xx` |
//! | `delta_xy` | length | of E_x with E_y                                                             | the least that can be: √((δxx² + δyy²)/2) |
//! | `A_x`      | float  | amplitude of E_x in the middle, √(W/m²)                                     | 1       |
//! | `A_y`      | float  | of E_y                                                                      | 1       |
//! | `B_xy`     | float, or string | correlation of E_x with E_y at one point: `"re, im"`              | 0       |
//!
//! Lengths are numbers of metres or texts with a unit (`2um`).
//!
//! ```xml
//! <shape type="disk"><emitter type="egsm">
//!     <string name="sigma" value="2mm"/><string name="delta_xx" value="1um"/><string name="delta_yy" value="2um"/>
//! </emitter></shape>
//! ```
//!
//! Inside a `rectangle` or a `disk`, whose middle is the middle of the spot and whose outline cuts it off. E_x is along
//! the shape's local x, E_y along n × x, with the normal n of the side that shines; x is projected across the ray. The
//! radiance toward a direction at the angle θ from n, with 1/l² = 1/4σ² + 1/δ² for each pair of components,
//!
//! ```text
//! L_ij = A_i A_j B_ij exp(−r²/2σ²) (k² l_ij²/2π) exp(−k² l_ij² sin²θ/2)
//! S = (L_xx + L_yy, L_xx − L_yy, 2 Re L_xy, −2 Im L_xy)
//! ```
//!
//! is that of Walther without one cosine, so that a point of the spot sends out A_i² (1 − exp(−k² l²/2)) per square metre.
//! Such a source can exist if and only if (δxx² + δyy²)/2 ≤ δxy² ≤ δxx δyy/|B_xy|.
//!
//! Source: Gori, Santarsiero, Piquero, Borghi, Mondello and Simon, Partially polarized Gaussian Schell-model beams,
//! J. Opt. A 3, 2001; Walther, Radiometry and coherence, JOSA 58, 1968.

use std::f64::consts::TAU;

use glam::{Vec2, Vec3, Vec3A, Vec4, vec2, vec4};

use super::patch::Outline;
use super::polarization::across;
use super::{Connection, Target};
use crate::colour::FIRST_NM;
use crate::light::{Emission, Light};
use crate::lights::{Bundle, Glance};
use crate::scene::{Object, Scene, SceneError};
use crate::shape::{by_area, solid_angle_density};

/// Half-width of patches, in σ: the Gaussian is taken at their middles, which errs by 1 % where it is most curved and by
/// far less in sums over them.
const PATCH_OF_SPOT: f32 = 0.25;

/// Half-width of patches, in widths of the narrowest cone of light at the wavelength for which they are cut.
const PATCH_OF_CONE: f32 = 0.25;

/// Patches are cut for this wavelength, nm, or for a shorter one that is rendered: images of all visible light, and of
/// one wavelength of it, have the same.
const SHORTEST: f64 = FIRST_NM;

/// A spot of partially coherent, partially polarized light.
#[derive(Clone, Debug)]
pub struct Schell {
    /// Index of the shape in the scene.
    pub(super) shape: u32,
    outline: Outline,
    axis: Vec3A,
    spare: Vec3A,
    sigma: f32,
    /// l² of xx, yy, xy, square metres.
    lengths: [f64; 3],
    /// A_x², A_y², A_x A_y Re B_xy, A_x A_y Im B_xy.
    strengths: [f64; 4],
    /// Whether points are drawn from the Gaussian; of a small part of it evenly.
    gaussian: bool,
    /// Wavelength for which patches are cut, nm.
    shortest: f64,
}

impl Schell {
    /// Reads its parameters. `outline` is that of the shape that it is in, `shape` its number.
    pub fn read(object: &Object, shape: u32, outline: Outline) -> Result<Self, SceneError> {
        let length = |name: &str, default: Option<f64>| {
            let value = object.micro_length(name, default)?.ok_or_else(|| {
                object.error(format!(
                    "{} has no parameter '{name}', expected a length ('1um')",
                    object.describe()
                ))
            })?;
            if value > 0.0 {
                Ok(value)
            } else {
                Err(object.error_at(
                    name,
                    format!(
                        "'{name}' of {} is {value} m, expected a positive length",
                        object.describe()
                    ),
                ))
            }
        };
        let sigma = length("sigma", None)?;
        let xx = length("delta_xx", None)?;
        let yy = length("delta_yy", Some(xx))?;
        let least = (0.5 * (xx * xx + yy * yy)).sqrt();
        let xy = length("delta_xy", Some(least))?;
        let [a_x, a_y] = [amplitude(object, "A_x")?, amplitude(object, "A_y")?];
        let (re, im) = correlation(object)?;
        let modulus = re.hypot(im);
        if modulus > 0.0 && a_x * a_y > 0.0 {
            let named = |name: &'static str, other: &'static str| {
                if object.has(name) { name } else { other }
            };
            // the least value as its square root is rounded
            if xy < least * (1.0 - 1e-9) {
                return Err(object.error_at(
                    named("delta_xy", "B_xy"),
                    format!(
                        "no source has 'delta_xy' {xy:e} m with 'delta_xx' {xx:e} m and 'delta_yy' {yy:e} m, \
                         expected at least √((δxx² + δyy²)/2) = {least:e} m"
                    ),
                ));
            }
            let most = (xx * yy / modulus).sqrt();
            if xy > most * (1.0 + 1e-9) {
                return Err(object.error_at(
                    named("B_xy", "delta_xy"),
                    format!(
                        "no source has |B_xy| = {modulus} with 'delta_xy' {xy:e} m, 'delta_xx' {xx:e} m and 'delta_yy' {yy:e} m, \
                         expected |B_xy| of at most δxx δyy/δxy² = {:.6}",
                        xx * yy / (xy * xy)
                    ),
                ));
            }
        }
        let halves = [outline.half_u.length(), outline.half_v.length()];
        let smaller = halves[0].min(halves[1]);
        if f64::from(smaller) < 2.5 * sigma {
            object.notice_at(
                "sigma",
                format!(
                    "the shape of {} reaches {smaller} m from the middle of a spot with sigma {sigma} m and cuts it off",
                    object.describe()
                ),
            );
        }
        let l2 = |delta: f64| (0.25 / (sigma * sigma) + (delta * delta).recip()).recip();
        let axis = outline.half_u.normalize();
        Ok(Self {
            shape,
            outline,
            axis,
            spare: outline.normal.cross(axis),
            sigma: sigma as f32,
            lengths: [l2(xx), l2(yy), l2(xy)],
            strengths: [a_x * a_x, a_y * a_y, a_x * a_y * re, a_x * a_y * im],
            gaussian: f64::from(smaller) > 1.5 * sigma,
            shortest: SHORTEST,
        })
    }

    /// Whether its light can be linearly and circularly polarized somewhere.
    pub(super) fn polarizes(&self) -> (bool, bool) {
        let [xx, yy, re, im] = self.strengths;
        let linear = xx != yy || self.lengths[0] != self.lengths[1] || re != 0.0;
        (linear, im != 0.0)
    }

    /// The light that leaves a point along `k`, in the frame of the projected x.
    fn stokes(&self, k: Vec3A, from: Vec3A, wavelength_nm: f32) -> Vec4 {
        let normal = self.outline.normal;
        if k.dot(normal) <= 0.0 {
            return Vec4::ZERO;
        }
        let off = (from - self.outline.centre).length() / self.sigma;
        let spot = f64::from(-0.5 * off * off).exp();
        let sine2 = f64::from(normal.cross(k).length_squared());
        let k2 = (TAU / (f64::from(wavelength_nm) * 1e-9)).powi(2);
        let cone = self
            .lengths
            .map(|l2| spot * k2 * l2 / TAU * (-0.5 * k2 * l2 * sine2).exp());
        let [a_xx, a_yy, re, im] = self.strengths;
        let (xx, yy) = (a_xx * cone[0], a_yy * cone[1]);
        vec4(
            (xx + yy) as f32,
            (xx - yy) as f32,
            (2.0 * re * cone[2]) as f32,
            (-2.0 * im * cone[2]) as f32,
        )
    }

    pub(super) fn emit<L: Light>(&self, k: Vec3A, from: Vec3A, wavelengths: &[f32]) -> Emission<L> {
        let stokes = |lane: usize| self.stokes(k, from, wavelengths[lane]);
        Emission::polarized(
            |lane| stokes(lane).x,
            across(self.axis, self.spare, k),
            |lane| {
                let s = stokes(lane);
                if s.x > 0.0 {
                    Vec3::new(s.y, s.z, s.w) / s.x
                } else {
                    Vec3::ZERO
                }
            },
        )
    }

    /// Density of drawn points per square metre, at a place in the outline's coordinates.
    fn density_at(&self, offset: Vec3A) -> f32 {
        let off = offset.length() / self.sigma;
        (-0.5 * off * off).exp() / (std::f32::consts::TAU * self.sigma * self.sigma)
    }

    pub(super) fn connect(&self, from: Vec3A, u: [f32; 2]) -> Option<Connection> {
        let Outline {
            centre,
            normal,
            round,
            error,
            ..
        } = self.outline;
        let (position, density) = if self.gaussian {
            let radius = self.sigma * (-2.0 * (1.0 - u[0]).ln()).max(0.0).sqrt();
            let across = Vec2::from_angle(std::f32::consts::TAU * u[1]) * radius;
            let position = centre + self.axis * across.x + self.spare * across.y;
            let at = self.outline.coordinates(position);
            // what falls off the shape is no light
            if (round && at.length() > 1.0) || (!round && at.abs().max_element() > 1.0) {
                return None;
            }
            (position, self.density_at(position - centre))
        } else {
            let at = if round {
                crate::sampler::unit_disk(u).into()
            } else {
                vec2(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0)
            };
            (self.outline.at(at), self.outline.area().recip())
        };
        let sample = by_area((position, error, normal), density.recip(), from)?;
        let to = position - from;
        let distance = to.length();
        let direction = to / distance;
        let target = Target {
            position,
            error,
            normal,
        };
        (direction.dot(normal) < 0.0)
            .then(|| Connection::to_point((direction, distance), Some(target), sample.pdf))
    }

    /// Density of [`Schell::connect`] per steradian.
    pub(super) fn density(&self, from: Vec3A, position: Vec3A) -> f32 {
        let density = if self.gaussian {
            self.density_at(position - self.outline.centre)
        } else {
            self.outline.area().recip()
        };
        // far out the Gaussian has no density at all
        if density <= 0.0 {
            return 0.0;
        }
        solid_angle_density(density.recip(), from, position, self.outline.normal)
    }

    /// By all its power, as if it came by the cosine: its cone has no edge.
    pub(super) fn glance(&self, scene: &Scene) -> Glance {
        let [xx, yy, ..] = self.strengths;
        let power = f64::from(self.sigma).powi(2) * TAU * (xx + yy);
        let bounds = scene.shapes[self.shape as usize].bounds();
        Glance::Near(Bundle::facing(
            self.outline.normal,
            bounds,
            power * std::f64::consts::FRAC_1_PI,
        ))
    }

    /// Cuts patches for light from the first to the second wavelength, nm.
    pub(super) fn fit(&mut self, [shortest, _]: [f64; 2]) {
        self.shortest = shortest.min(SHORTEST);
    }

    /// Largest half-width of a patch for a vertex at `from`, radians.
    pub(super) fn largest_patch(&self, from: Vec3A, largest: f32) -> f32 {
        let l2 = self.lengths.into_iter().fold(0.0, f64::max);
        let cone = (self.shortest / 1e9 / (TAU * l2.sqrt())) as f32;
        let distance = (from - self.outline.centre).length();
        largest
            .min(PATCH_OF_CONE * cone)
            .min(PATCH_OF_SPOT * self.sigma / distance)
    }
}

fn amplitude(object: &Object, name: &str) -> Result<f64, SceneError> {
    let value = object.float(name, 1.0)?;
    if value >= 0.0 {
        Ok(value)
    } else {
        Err(object.error_at(
            name,
            format!(
                "'{name}' of {} is {value}, expected 0 or more: a phase belongs to B_xy",
                object.describe()
            ),
        ))
    }
}

/// Real and imaginary part of B_xy.
fn correlation(object: &Object) -> Result<(f64, f64), SceneError> {
    if !object.is_string("B_xy") {
        return Ok((object.float("B_xy", 0.0)?, 0.0));
    }
    let text = object.string("B_xy", "")?;
    let numbers: Vec<Option<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    match numbers[..] {
        [Some(re), Some(im)] => Ok((re, im)),
        _ => Err(object.error_at(
            "B_xy",
            format!(
                "'B_xy' of {} is '{text}', expected a real and an imaginary part ('0.3, 0.2')",
                object.describe()
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitter::{Emitter, Kind};
    use crate::scene::{Overrides, build, read_text};

    #[test]
    fn patches_are_a_quarter_of_the_cone_of_every_wavelength() {
        let text = "<scene version='3.0.0'><sensor type='perspective'/><shape type='disk'><emitter type='egsm'>
            <string name='sigma' value='2mm'/><string name='delta_xx' value='1um'/></emitter></shape></scene>";
        let document = read_text(text, "test.xml".as_ref(), &[]).unwrap();
        let mut scene = build(&document, Overrides::default()).unwrap().scene;
        // 1/l² = 1/4σ² + 1/δ²
        let width = 1e-6 * (1.0f64 + 0.25 * (1e-6 / 2e-3f64).powi(2)).powf(-0.5);
        for (range, cut_for) in [
            ([100.0; 2], 100.0),
            ([550.0; 2], 360.0),
            ([200.0, 900.0], 200.0),
            ([360.0, 830.0], 360.0),
        ] {
            scene.weigh_lights(range);
            let [
                Emitter {
                    kind: Kind::Schell(spot),
                    ..
                },
            ] = &scene.emitters[..]
            else {
                panic!("one spot");
            };
            // so near that the spot itself asks for no smaller ones
            let found = f64::from(spot.largest_patch(Vec3A::new(0.0, 0.0, 1e-4), 1.0));
            let expected = 0.25 * cut_for * 1e-9 / (TAU * width);
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{range:?}: {found} {expected}"
            );
        }
    }
}
