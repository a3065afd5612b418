//! `rayleighsky`: a clear sky, sunlight that the air has scattered once.
//!
//! | parameter       | type     | meaning                                                                  | default |
//! |-----------------|----------|--------------------------------------------------------------------------|---------|
//! | `sun_direction` | vector   | toward the sun, above the horizon                                        | –       |
//! | `up`            | vector   | toward the zenith                                                        | +y      |
//! | `irradiance`    | spectrum | W/m² of the sun above the air, across its rays                           | 1       |
//! | `optical_depth` | float    | of the air along the vertical, at 550 nm                                 | 0.097   |
//! | `spectral`      | boolean  | the optical depth falls with the fourth power of the wavelength          | true    |
//! | `dop_max`       | float    | degree of polarization at 90° from the sun                               | 0.9457  |
//! | `ground`        | spectrum | radiance of all below the horizon, W/(m² sr), unpolarized                | 0       |
//!
//! ```xml
//! <emitter type="rayleighsky"><vector name="sun_direction" x="1" y="0.5" z="0"/></emitter>
//! ```
//!
//! Surrounds the scene. Of a plane layer of air, at the angle γ from the sun, with μ and μ₀ the cosines of the zenith
//! angles of the view and of the sun:
//!
//! ```text
//! L = E₀/4π · ¾ (1 + cos²γ) μ₀/(μ₀ − μ) (exp(−τ/μ₀) − exp(−τ/μ)),    DoP = dop_max sin²γ/(1 + cos²γ)
//! ```
//!
//! with E across the plane of sun and view. The default `dop_max` is that of air with its depolarization of 0.0279. The
//! sun itself is not in it: add a `directional` with `angular_diameter` 0.53 and the irradiance that is left below the
//! air, E₀ exp(−τ/μ₀).
//!
//! Source: Chandrasekhar, Radiative Transfer, 1960, chapter I (single scattering in a plane layer, Rayleigh's phase
//! matrix).

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{DVec3, Vec3, Vec3A};

use super::Connection;
use crate::geometry::frame::Frame;
use crate::light::{Emission, Light};
use crate::lights::Glance;
use crate::sampler::cosine_hemisphere;
use crate::scene::{Object, SceneError};
use crate::spectrum::{Spectrum, SpectrumUse};

/// Rows and columns of the table over the upper hemisphere: cells of equal solid angle in height and azimuth.
const ROWS: usize = 32;
const COLUMNS: usize = 64;

/// Where the table looks at spectra, nm.
const TABLE_AT: f32 = 550.0;

/// The sky.
#[derive(Clone, Debug)]
pub struct RayleighSky {
    /// Normal toward the zenith, first tangent toward the sun's azimuth.
    horizon: Frame,
    sun: Vec3A,
    irradiance: Spectrum,
    ground: Spectrum,
    optical_depth: f32,
    spectral: bool,
    pub(super) dop_max: f32,
    /// Running sums of the light of the cells; the last cell is the lower hemisphere.
    sums: Vec<f32>,
}

impl RayleighSky {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let unit = |name: &str, default: Option<[f64; 3]>| {
            let vector = object.optional_vector(name)?.or(default).ok_or_else(|| {
                object.error(format!(
                    "{} has no parameter '{name}', expected a vector toward the sun",
                    object.describe()
                ))
            })?;
            DVec3::from(vector).try_normalize().ok_or_else(|| {
                object.error_at(
                    name,
                    "a direction of no length, expected a vector other than 0",
                )
            })
        };
        let sun = unit("sun_direction", None)?;
        let up = unit("up", Some([0.0, 1.0, 0.0]))?;
        let height = sun.dot(up).asin().to_degrees();
        // single scattering in a plane layer has nothing to say of the sun at the horizon
        if height < 0.1 {
            return Err(object.error_at(
                "sun_direction",
                format!("the sun is {height:.3}° above the horizon, expected at least 0.1°"),
            ));
        }
        let optical_depth = object.float("optical_depth", 0.097)?;
        if optical_depth <= 0.0 {
            return Err(object.error_at(
                "optical_depth",
                format!("an optical depth of {optical_depth}, expected a positive number"),
            ));
        }
        if optical_depth > 0.5 {
            object.notice_at(
                "optical_depth",
                format!(
                    "an optical depth of {optical_depth}: light is scattered more than once, which is left out here"
                ),
            );
        }
        let dop_max = object.float("dop_max", 0.9457)?;
        if !(0.0..=1.0).contains(&dop_max) {
            return Err(object.error_at(
                "dop_max",
                format!("a degree of polarization of {dop_max}, expected one between 0 and 1"),
            ));
        }
        let spectrum = |name: &str, default: f64| {
            object.spectrum(name, SpectrumUse::Emission, Spectrum::constant(default))
        };
        let mut sky = Self {
            horizon: Frame::with_tangent(up.as_vec3a(), sun.as_vec3a()),
            sun: sun.as_vec3a(),
            irradiance: spectrum("irradiance", 1.0)?,
            ground: spectrum("ground", 0.0)?,
            optical_depth: optical_depth as f32,
            spectral: object.boolean("spectral", true)?,
            dop_max: dop_max as f32,
            sums: Vec::new(),
        };
        sky.tabulate();
        Ok(sky)
    }

    /// Whether its light is the same at all wavelengths of a range, nm.
    pub(super) fn is_grey(&self, range: [f64; 2]) -> bool {
        !self.spectral
            && self.irradiance.is_constant_over(range)
            && self.ground.is_constant_over(range)
    }

    /// Radiance from a direction toward the sky.
    fn radiance(&self, toward: Vec3A, wavelength_nm: f32) -> f32 {
        let mu = self.horizon.n.dot(toward);
        if mu <= 0.0 {
            return self.ground.value(wavelength_nm);
        }
        // the layer is plane: at the horizon it is infinitely thick
        let (mu, mu0) = (mu.max(1e-6), self.horizon.n.dot(self.sun));
        let tau = self.optical_depth
            * if self.spectral {
                (550.0 / wavelength_nm).powi(4)
            } else {
                1.0
            };
        let (a, b) = (tau / mu0, tau / mu);
        // (e^-a − e^-b)/(b − a) without cancellation where the view is as high as the sun
        let apart = (b - a).abs();
        let mean = if apart > 1e-4 {
            -(-apart).exp_m1() / apart
        } else {
            1.0 - 0.5 * apart
        };
        let layer = (-a.min(b)).exp() * b * mean;
        let cos = self.sun.dot(toward);
        self.irradiance.value(wavelength_nm) * 0.75 * (1.0 + cos * cos) * layer
            / (4.0 * std::f32::consts::PI)
    }

    pub(super) fn emit<L: Light>(&self, k: Vec3A, wavelengths: &[f32]) -> Emission<L> {
        let toward = -k;
        let radiance = |lane: usize| self.radiance(toward, wavelengths[lane]);
        if toward.dot(self.horizon.n) <= 0.0 {
            return Emission::unpolarized(radiance);
        }
        let across = self.sun.cross(toward);
        let sine2 = across.length_squared();
        // toward the sun and away from it there is neither polarization nor a plane
        if sine2 < 1e-12 {
            return Emission::unpolarized(radiance);
        }
        let degree = self.dop_max * sine2 / (2.0 - sine2);
        Emission::polarized(radiance, across / sine2.sqrt(), |_| {
            Vec3::new(degree, 0.0, 0.0)
        })
    }

    /// Fills the table with the light of each cell.
    fn tabulate(&mut self) {
        let mut sum = 0.0f64;
        let mut sums = Vec::with_capacity(ROWS * COLUMNS + 1);
        let cell = f64::from(TAU) / (ROWS * COLUMNS) as f64;
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let middle = self.direction(row, column, [0.5, 0.5]);
                sum += cell * f64::from(self.radiance(middle, TABLE_AT)).max(1e-30);
                sums.push(sum);
            }
        }
        sum += f64::from(TAU) * f64::from(self.ground.value(TABLE_AT).max(0.0));
        sums.push(sum);
        self.sums = sums.into_iter().map(|s| (s / sum) as f32).collect();
    }

    /// By the mean radiance of all directions, at five wavelengths.
    pub(super) fn glance(&self, [from, to]: [f64; 2]) -> Glance {
        const STEPS: usize = 5;
        let radiance = |step: usize| {
            let nm = (from + (to - from) * (step as f64 + 0.5) / STEPS as f64) as f32;
            let cells = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
            let sky: f32 = cells
                .map(|(row, column)| self.radiance(self.direction(row, column, [0.5, 0.5]), nm))
                .sum();
            0.5 * (sky / (ROWS * COLUMNS) as f32 + self.ground.value(nm))
        };
        let mean = (0..STEPS).map(radiance).sum::<f32>() / STEPS as f32;
        Glance::Outside(std::f64::consts::PI * f64::from(mean))
    }

    /// A direction in a cell of the upper hemisphere.
    fn direction(&self, row: usize, column: usize, u: [f32; 2]) -> Vec3A {
        let z = (row as f32 + u[0]) / ROWS as f32;
        let phi = (column as f32 + u[1]) / COLUMNS as f32 * TAU;
        let r = (1.0 - z * z).max(0.0).sqrt();
        self.horizon
            .to_world(Vec3A::new(r * phi.cos(), r * phi.sin(), z))
    }

    /// Half of the ways by the cosine at the vertex, half by the light of the sky.
    pub(super) fn connect(&self, frame: &Frame, u: [f32; 2]) -> Option<Connection> {
        let direction = if u[0] < 0.5 {
            frame.to_world(cosine_hemisphere([2.0 * u[0], u[1]]))
        } else {
            self.draw([2.0 * u[0] - 1.0, u[1]])
        };
        let density = self.density(frame, direction);
        (density > 0.0).then(|| Connection::to_point((direction, f32::INFINITY), None, density))
    }

    /// A direction drawn from the table.
    fn draw(&self, [u, v]: [f32; 2]) -> Vec3A {
        let last = self.sums.len() - 1;
        let cell = self.sums.partition_point(|&s| s <= u).min(last);
        let before = if cell == 0 { 0.0 } else { self.sums[cell - 1] };
        let share = self.sums[cell] - before;
        // what is left of u is uniform again
        let rest = ((u - before) / share).clamp(0.0, 1.0 - f32::EPSILON);
        if cell < last {
            self.direction(cell / COLUMNS, cell % COLUMNS, [rest, v])
        } else {
            let r = (1.0 - rest * rest).max(0.0).sqrt();
            let (sin, cos) = (TAU * v).sin_cos();
            self.horizon.to_world(Vec3A::new(r * cos, r * sin, -rest))
        }
    }

    /// Density of `RayleighSky::connect`.
    pub(super) fn density(&self, frame: &Frame, direction: Vec3A) -> f32 {
        let cosine = frame.n.dot(direction).max(0.0) * FRAC_1_PI;
        0.5 * (cosine + self.density_of_table(direction))
    }

    fn density_of_table(&self, direction: Vec3A) -> f32 {
        let local = self.horizon.to_local(direction);
        let last = self.sums.len() - 1;
        if local.z <= 0.0 {
            return (self.sums[last] - self.sums[last - 1]) / TAU;
        }
        let row = ((local.z * ROWS as f32) as usize).min(ROWS - 1);
        let turn = (local.y.atan2(local.x) / TAU).rem_euclid(1.0);
        let column = ((turn * COLUMNS as f32) as usize).min(COLUMNS - 1);
        let cell = row * COLUMNS + column;
        let before = if cell == 0 { 0.0 } else { self.sums[cell - 1] };
        (self.sums[cell] - before) * (ROWS * COLUMNS) as f32 / TAU
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{SampleStream, uniform_sphere};

    fn sky(sun: Vec3A, ground: f64) -> RayleighSky {
        let mut sky = RayleighSky {
            horizon: Frame::with_tangent(Vec3A::Y, sun),
            sun,
            irradiance: Spectrum::constant(1.0),
            ground: Spectrum::constant(ground),
            optical_depth: 0.1,
            spectral: true,
            dop_max: 0.9,
            sums: Vec::new(),
        };
        sky.tabulate();
        sky
    }

    #[test]
    fn directions_come_with_their_density() {
        let sky = sky(Vec3A::new(0.6, 0.3, -0.2).normalize(), 0.01);
        let frame = Frame::around(Vec3A::new(0.3, 0.5, 0.1).normalize());
        // the integral of the density, and a moment by both ways: 5 σ of 400,000 samples
        let count = 400_000u64;
        let (mut whole, mut drawn, mut weighed, mut square) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
        let test = |d: Vec3A| f64::from((d.x + 0.5 * d.y).abs());
        for sample in 0..count {
            let u = SampleStream::new(3, 1, sample).pair(0);
            let direction = uniform_sphere(u);
            let density = f64::from(sky.density(&frame, direction)) * 4.0 * std::f64::consts::PI;
            whole += density / count as f64;
            weighed += density * test(direction) / count as f64;
            square += (density * test(direction)).powi(2) / count as f64;
            let u = SampleStream::new(3, 2, sample).pair(0);
            let connection = sky.connect(&frame, u).unwrap();
            drawn += test(connection.direction) / count as f64;
        }
        let noise = 5.0 * (square / count as f64).sqrt();
        assert!((whole - 1.0).abs() < noise, "{whole}");
        assert!((drawn - weighed).abs() < noise, "{drawn} {weighed} {noise}");
    }

    #[test]
    fn radiance_is_the_sum_along_the_view() {
        let sun = Vec3A::new(0.6, 0.5, 0.0).normalize();
        let sky = sky(sun, 0.0);
        for view in [
            Vec3A::new(0.1, 0.9, 0.3),
            Vec3A::new(-0.9, 0.1, 0.3),
            Vec3A::new(0.0, 0.5, 0.6),
            Vec3A::new(0.0, 0.50001, 0.6),
        ] {
            let view = view.normalize();
            let (mu, mu0, c) = (
                f64::from(view.y),
                f64::from(sun.y),
                f64::from(view.dot(sun)),
            );
            let (tau, steps) = (0.1, 20_000);
            // depth t below the top: sunlight reaches it, a part is scattered, what is left arrives
            let sum: f64 = (0..steps)
                .map(|i| {
                    let t = tau * (f64::from(i) + 0.5) / f64::from(steps);
                    (-t / mu0 - (tau - t) / mu).exp() * tau / f64::from(steps) / mu
                })
                .sum();
            let expected = sum * 0.75 * (1.0 + c * c) / (4.0 * std::f64::consts::PI);
            let found = f64::from(sky.radiance(view, 550.0));
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
    }
}
