//! The Gaussians of an autocorrelation as lobes of directions, and its parts that do not decay as sharp orders.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, Vec3A};
use mueller16::{GaussianFamily, GaussianTerm};
use nalgebra::{Matrix2, Matrix4, Vector2};
use stokes::plane;

use crate::sampler::cosine_hemisphere;

/// Standard deviation, in units of direction cosines, beyond which a lobe is drawn from the cosine of the hemisphere.
const BROAD: f64 = 0.5;

/// One Gaussian in the tangential wave vector φ: `e^(−|A(φ − centre)|²/2)`, A = D/√m.
#[derive(Clone, Debug)]
pub(super) struct Lobe {
    /// A, m.
    narrowness: Matrix2<f64>,
    /// A⁻¹, rad/m.
    width: Matrix2<f64>,
    determinant: f64,
    centre: Vector2<f64>,
    /// Its weight in R.
    weight: f64,
    /// Largest and least standard deviation, rad/m.
    deviations: [f64; 2],
}

impl Lobe {
    /// Adds a term to lobes; those of one shape are one.
    pub(super) fn add(lobes: &mut Vec<Self>, family: &GaussianFamily, term: &GaussianTerm) {
        let narrowness = family.root() / term.rate.sqrt();
        let known = |lobe: &&mut Self| lobe.centre == term.shift && lobe.narrowness == narrowness;
        if let Some(same) = lobes.iter_mut().find(known) {
            same.weight += term.weight;
            return;
        }
        let width = plane::inverse(&narrowness);
        let values = plane::singular_values(&width).values;
        lobes.push(Self {
            narrowness,
            width,
            determinant: plane::determinant(&narrowness).abs(),
            centre: term.shift,
            weight: term.weight,
            deviations: [values[0].max(values[1]), values[0].min(values[1])],
        });
    }

    /// Least standard deviation, rad/m.
    pub(super) fn narrowest(&self) -> f64 {
        self.deviations[1]
    }

    /// Its weight in R, less than nothing where it is taken off other lobes.
    #[inline]
    pub(super) fn weight(&self) -> f64 {
        self.weight
    }

    /// Transform of the Gaussian of R over 2π, m²: for a plane wave, and averaged over light of directions `VᵀV` in φ.
    ///
    /// ```text
    /// |det A| e^(−|q|²/2),   |det A|/√Δ e^(−(|q|² + |Bᵀq⊥|²)/2Δ)     q = A(φ − c),  B = A Vᵀ,  Δ = 1 + ‖B‖² + (det B)²
    /// ```
    ///
    /// All sums are of one sign: no digits are lost for any shape of lobe and light.
    #[inline]
    pub(super) fn values(&self, phi: &Vector2<f64>, light: Option<&Matrix2<f64>>) -> (f64, f64) {
        let a = &self.narrowness;
        let q = a * (phi - self.centre);
        let square = q.norm_squared();
        let plane = (-0.5 * square).exp() * self.determinant;
        let Some(v) = light else {
            return (plane, plane);
        };
        let b = a * v.transpose();
        let determinant = b.determinant();
        let delta = 1.0 + b.norm_squared() + determinant * determinant;
        let across = b.tr_mul(&Vector2::new(-q.y, q.x)).norm_squared();
        let exponent = -0.5 * (square + across) / delta;
        (plane, exponent.exp() * self.determinant / delta.sqrt())
    }

    /// Density per steradian of directions toward the light at this cosine, for light of wavenumber k; `plane` is the
    /// first of [`Lobe::values`].
    #[inline]
    pub(super) fn density(&self, plane: f64, cos: f64, k: f64) -> f64 {
        if self.deviations[0] > BROAD * k {
            cos * FRAC_1_PI
        } else {
            plane / TAU * k * k * cos
        }
    }

    /// Draws a direction toward the light, above the surface or below.
    #[inline]
    pub(super) fn sample(&self, o: Vec3A, up: bool, k: f64, u: [f32; 2]) -> Option<Vec3A> {
        if self.deviations[0] > BROAD * k {
            let i = cosine_hemisphere(u);
            return Some(if up { i } else { Vec3A::new(i.x, i.y, -i.z) });
        }
        let radius = (-2.0 * (1.0 - f64::from(u[0])).ln()).sqrt();
        let (sin, cos) = (TAU * f64::from(u[1])).sin_cos();
        let q = Vector2::new(radius * cos, radius * sin);
        let phi = self.centre + self.width * q;
        from_tangential(phi, o, up, k)
    }
}

/// The direction `i` with `φ = k (o + i)_t`; `None` if it is evanescent.
fn from_tangential(phi: Vector2<f64>, o: Vec3A, up: bool, k: f64) -> Option<Vec3A> {
    let i = DVec2::new(phi.x, phi.y) / k - DVec2::new(f64::from(o.x), f64::from(o.y));
    let squared = 1.0 - i.length_squared();
    if squared.is_nan() || squared <= 0.0 {
        return None;
    }
    let z = if up { squared.sqrt() } else { -squared.sqrt() };
    Some(Vec3A::new(i.x as f32, i.y as f32, z as f32))
}

/// A part that does not decay: light from one direction leaves in one direction.
#[derive(Clone, Debug)]
pub(super) struct Order {
    transmits: bool,
    /// φ of it, rad/m.
    shift: Vector2<f64>,
    /// Envelope and matrix.
    terms: Vec<(usize, Matrix4<f64>)>,
}

impl Order {
    /// Adds a matrix to orders; those of one direction are one.
    pub(super) fn add(
        orders: &mut Vec<Self>,
        transmits: bool,
        shift: Vector2<f64>,
        term: (usize, Matrix4<f64>),
    ) {
        let known = |order: &&mut Self| order.transmits == transmits && order.shift == shift;
        match orders.iter_mut().find(known) {
            Some(same) => same.terms.push(term),
            None => orders.push(Self {
                transmits,
                shift,
                terms: vec![term],
            }),
        }
    }

    /// Straight through.
    pub(super) fn is_straight(&self) -> bool {
        self.transmits && self.shift == Vector2::zeros()
    }

    /// Whether its direction is the same at all wavelengths.
    pub(super) fn is_mirror_or_straight(&self) -> bool {
        self.shift == Vector2::zeros()
    }

    /// Where its light comes from; `None` if it is evanescent.
    pub(super) fn direction(&self, o: Vec3A, k: f64) -> Option<Vec3A> {
        from_tangential(self.shift, o, (o.z > 0.0) != self.transmits, k)
    }

    /// What it does at a place.
    pub(super) fn matrix(&self, intensities: &[f64]) -> Matrix4<f64> {
        let terms = self.terms.iter();
        terms.map(|(envelope, m)| m * intensities[*envelope]).sum()
    }

    /// Share of the choice.
    #[inline]
    pub(super) fn share(&self, intensities: &[f64]) -> f64 {
        let terms = self.terms.iter();
        let sum: f64 = terms
            .map(|(envelope, m)| m[(0, 0)] * intensities[*envelope])
            .sum();
        sum.max(0.0)
    }
}
