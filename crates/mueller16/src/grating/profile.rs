//! The profile of a grating's lines, and the amplitudes of its orders.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use num_complex::Complex64;

use super::bessel::bessel_j;
use super::samples::Samples;
use super::{DEEPEST, GratingError};

/// Orders of a sine beyond this are 0 for every phase that is not too deep: `J_q(z) ≤ (ez/2q)^q`.
const LAST_OF_SINE: u32 = 1 << 18;

/// Which way the long facet of a blazed grating rises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blaze {
    /// Along the grating's direction: in reflection the facet's mirror direction is on the side of negative orders.
    Rising,
    /// Against it.
    Falling,
}

/// Heights `h(x)` of one period, metres along the normal, and with them the amplitudes of all orders.
///
/// ```text
/// t_q = (1/p) ∫₀ᵖ e^(−iφ_z h(x)) e^(−iqGx) dx,     Σ_q |t_q|² = 1,     G = 2π/p
/// ```
///
/// Lengths along the period are fractions of the pitch, so that one profile serves gratings of any pitch.
///
/// Source: Goodman, Introduction to Fourier Optics, 3rd ed., section 4.4.4, for a thin sinusoidal phase grating.
///
/// ```
/// use mueller16::Profile;
/// use std::f64::consts::PI;
/// // a lamellar grating of half a wave sends 4/π² = 40.5 % into each first order and nothing straight on
/// let lamellar = Profile::lamellar(1e-7, 0.5)?;
/// let phi_z = PI / 1e-7;
/// assert!(lamellar.amplitude(phi_z, 0).norm() < 1e-15);
/// assert!((lamellar.amplitude(phi_z, 1).norm_sqr() - 4.0 / (PI * PI)).abs() < 1e-15);
/// # Ok::<(), mueller16::GratingError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Profile(Shape);

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Sinusoidal {
        depth: f64,
    },
    Lamellar {
        depth: f64,
        ridge: f64,
    },
    Blazed {
        depth: f64,
        sense: Blaze,
    },
    /// Vertices `(x/p, h)`.
    Linear(Vec<[f64; 2]>),
    Sampled(Samples),
}

impl Profile {
    /// `h = (depth/2) cos Gx`, depth from valley to peak, metres.
    ///
    /// # Errors
    ///
    /// When the depth is not a number between 0 and 1 m.
    pub fn sinusoidal(depth: f64) -> Result<Self, GratingError> {
        check_depth(depth)?;
        Ok(Self(Shape::Sinusoidal { depth }))
    }

    /// Ridges of height `depth` (metres) and of the share `ridge_fraction` of the pitch, centred on `x = 0`.
    ///
    /// # Errors
    ///
    /// When the depth is not a number between 0 and 1 m, or the fraction not one in `0.0..=1.0`.
    pub fn lamellar(depth: f64, ridge_fraction: f64) -> Result<Self, GratingError> {
        check_depth(depth)?;
        check("ridge fraction", ridge_fraction, [0.0, 1.0])?;
        let ridge = ridge_fraction;
        Ok(Self(Shape::Lamellar { depth, ridge }))
    }

    /// A sawtooth: one facet as long as the pitch, then a step of `depth` metres.
    ///
    /// The order nearest to `q = −φ_z depth/2π` (rising) has the most light: the facet's mirror direction.
    ///
    /// # Errors
    ///
    /// When the depth is not a number between 0 and 1 m.
    pub fn blazed(depth: f64, sense: Blaze) -> Result<Self, GratingError> {
        check_depth(depth)?;
        Ok(Self(Shape::Blazed { depth, sense }))
    }

    /// A ridge with two straight flanks: from 0 up to `depth` metres at the fraction `apex` of the pitch, and down.
    ///
    /// # Errors
    ///
    /// When the depth is not a number between 0 and 1 m, or the apex not one in `0.0..=1.0`.
    pub fn triangular(depth: f64, apex: f64) -> Result<Self, GratingError> {
        check_depth(depth)?;
        check("apex", apex, [0.0, 1.0])?;
        Self::piecewise_linear(vec![[0.0, 0.0], [apex, depth], [1.0, 0.0]])
    }

    /// Straight segments between `vertices` of (fraction of the pitch, height in metres); two vertices at one place are a
    /// step, and so are different heights at 0 and 1.
    ///
    /// # Errors
    ///
    /// When there are fewer than two vertices, they do not go from 0 to 1 without turning back, or a height is not a
    /// number between −1 and 1 m.
    pub fn piecewise_linear(vertices: Vec<[f64; 2]>) -> Result<Self, GratingError> {
        let (Some(first), Some(last)) = (vertices.first(), vertices.last()) else {
            return Err(GratingError::TooFew {
                what: "vertices",
                found: 0,
                least: 2,
            });
        };
        check("place of the first vertex", first[0], [0.0, 0.0])?;
        check("place of the last vertex", last[0], [1.0, 1.0])?;
        for (index, vertex) in vertices.iter().enumerate() {
            check("height of a vertex", vertex[1], [-1.0, 1.0])?;
            let before = vertices[index.saturating_sub(1)][0];
            check("place of a vertex", vertex[0], [before, 1.0])?;
        }
        Ok(Self(Shape::Linear(vertices)))
    }

    /// Heights (metres) at equal steps over one period, from x = 0; the phase between them is that of as many orders as
    /// there are samples.
    ///
    /// Good while the phase `φ_z h` changes by little from sample to sample, which steps in height do not:
    /// [`Profile::piecewise_linear`] holds them exactly.
    ///
    /// # Errors
    ///
    /// When there are none or more than 2²², or a height is not a number between −1 and 1 m.
    pub fn sampled(heights: Vec<f64>) -> Result<Self, GratingError> {
        let columns = heights.len();
        Ok(Self(Shape::Sampled(Samples::new(heights, columns)?)))
    }

    /// From the lowest to the highest point, metres.
    #[must_use]
    pub fn depth(&self) -> f64 {
        match &self.0 {
            Shape::Sinusoidal { depth }
            | Shape::Lamellar { depth, .. }
            | Shape::Blazed { depth, .. } => *depth,
            Shape::Linear(vertices) => {
                let heights = || vertices.iter().map(|v| v[1]);
                heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min)
            }
            Shape::Sampled(samples) => samples.depth(),
        }
    }

    /// The amplitude `t_q` of order `q` for the vertical wave vector `phi_z`, rad/m; complex, of modulus at most 1.
    ///
    /// Absolute error of a few `f64::EPSILON` times `1 + |φ_z| depth`; not a number where that phase is beyond 1e5, which
    /// surfaces refuse. A sinusoidal profile takes a sweep over
    /// `max(|q|, φ_z depth/2)` orders, a sampled one a sum over its samples, the others a step for each segment.
    #[must_use]
    pub fn amplitude(&self, phi_z: f64, q: i32) -> Complex64 {
        match &self.0 {
            Shape::Sampled(samples) if self.is_countable(phi_z) => samples.amplitude(phi_z, [q, 0]),
            _ => self.amplitudes(phi_z, q..=q)[0],
        }
    }

    /// The amplitudes of a range of orders, computed together.
    #[must_use]
    pub fn amplitudes(&self, phi_z: f64, orders: RangeInclusive<i32>) -> Vec<Complex64> {
        if !self.is_countable(phi_z) {
            return orders.map(|_| Complex64::new(f64::NAN, f64::NAN)).collect();
        }
        match &self.0 {
            Shape::Sinusoidal { depth } => {
                let [first, last] = [orders.start(), orders.end()].map(|q| q.unsigned_abs());
                let last = first.max(last).min(LAST_OF_SINE) as usize;
                let values = bessel_j(0.5 * phi_z * depth, last);
                // t_q = (−i)^q J_q, the same for −q
                let of = |q: i32| {
                    let value = values.get(q.unsigned_abs() as usize);
                    power_of_minus_i(q.unsigned_abs()) * value.copied().unwrap_or(0.0)
                };
                orders.map(of).collect()
            }
            Shape::Lamellar { depth, ridge } => {
                let psi = phi_z * depth;
                // e^(−iψ) − 1 without cancellation
                let step =
                    Complex64::new(0.0, -2.0 * (0.5 * psi).sin()) * Complex64::cis(-0.5 * psi);
                let of = |q: i32| match q {
                    0 => Complex64::from(1.0) + step * *ridge,
                    _ => step * ((PI * turns(q, *ridge)).sin() / (PI * f64::from(q))),
                };
                orders.map(of).collect()
            }
            Shape::Blazed { depth, sense } => {
                let psi = phi_z * depth;
                let slope = match sense {
                    Blaze::Rising => psi / TAU,
                    Blaze::Falling => -psi / TAU,
                };
                let middle = Complex64::cis(-0.5 * psi);
                let of = |q: i32| middle * (sign_of_power(q) * sinc(f64::from(q) + slope));
                orders.map(of).collect()
            }
            Shape::Linear(vertices) => orders
                .map(|q| linear_amplitude(vertices, phi_z, q))
                .collect(),
            Shape::Sampled(samples) => samples.line_amplitudes(phi_z, orders),
        }
    }

    /// Whether the phase is shallow enough for orders.
    fn is_countable(&self, phi_z: f64) -> bool {
        phi_z.abs() * self.depth() <= DEEPEST
    }

    /// Mean square slope for the pitch in metres; `None` where the profile has a step or is known at points only.
    pub(super) fn mean_square_slope(&self, pitch: f64) -> Option<f64> {
        match &self.0 {
            Shape::Sinusoidal { depth } => Some(0.5 * (PI * depth / pitch).powi(2)),
            Shape::Linear(vertices) => {
                let whole = vertices[0][1] == vertices[vertices.len() - 1][1];
                let mut sum = 0.0;
                for pair in vertices.windows(2) {
                    let (width, rise) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
                    if width == 0.0 && rise != 0.0 {
                        return None;
                    }
                    if width > 0.0 {
                        sum += rise * rise / (width * pitch * pitch);
                    }
                }
                whole.then_some(sum)
            }
            Shape::Lamellar { .. } | Shape::Blazed { .. } | Shape::Sampled(_) => None,
        }
    }

    /// The only orders that are not 0, where they are finitely many.
    pub(super) fn all_orders(&self) -> Option<RangeInclusive<i32>> {
        match &self.0 {
            Shape::Sampled(samples) => Some(samples.orders()[0].clone()),
            _ => None,
        }
    }
}

/// `Σ (w/p) e^(−i(φ_z h_m + qG x_m)) sinc((φ_z s + qG) w/2π)` over segments of width w, slope s and middle `(x_m, h_m)`.
fn linear_amplitude(vertices: &[[f64; 2]], phi_z: f64, q: i32) -> Complex64 {
    vertices
        .windows(2)
        .map(|pair| {
            let ([x0, h0], [x1, h1]) = (pair[0], pair[1]);
            let (width, middle) = (x1 - x0, 0.5 * (x0 + x1));
            let phase = phi_z * (0.5 * (h0 + h1)) + TAU * turns(q, middle);
            let height = width * sinc(phi_z * (h1 - h0) / TAU + f64::from(q) * width);
            Complex64::from_polar(1.0, -phase) * height
        })
        .sum()
}

/// `sin(πu)/(πu)`
fn sinc(u: f64) -> f64 {
    let x = PI * u;
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}

/// `q·fraction` less an even number, right to a rounding of the rest.
fn turns(q: i32, fraction: f64) -> f64 {
    let q = f64::from(q);
    let product = q * fraction;
    let error = q.mul_add(fraction, -product);
    product - 2.0 * (0.5 * product).round() + error
}

fn power_of_minus_i(n: u32) -> Complex64 {
    match n % 4 {
        0 => Complex64::new(1.0, 0.0),
        1 => Complex64::new(0.0, -1.0),
        2 => Complex64::new(-1.0, 0.0),
        _ => Complex64::new(0.0, 1.0),
    }
}

/// `(−1)^q`
fn sign_of_power(q: i32) -> f64 {
    if q % 2 == 0 { 1.0 } else { -1.0 }
}

fn check_depth(depth: f64) -> Result<(), GratingError> {
    check("depth", depth, [0.0, 1.0])
}

pub(super) fn check(what: &'static str, value: f64, range: [f64; 2]) -> Result<(), GratingError> {
    if (range[0]..=range[1]).contains(&value) {
        Ok(())
    } else {
        Err(GratingError::Value { what, value, range })
    }
}
