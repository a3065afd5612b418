//! Scattering power of random heights between two directions, and the density with which directions are drawn.
//!
//! ```text
//! f = (n_o²/λ²) O F{Rγ}(φ_t) G1(i) G1(o),     O = |i·φ| |o·φ|/(|cos_i cos_o| φ_z²)
//! ```
//!
//! With `g = (φ_z σ)²` and `F{R} = (1 − e^(−g)) 2πD² S` the vertical wave vector cancels, so that f stays finite where
//! φ_z passes through zero between two media: `(1 − e^(−g))/φ_z² = σ² (1 − e^(−g))/g`.
//!
//! Directions are drawn from three densities: the lobe itself about the mirror or Snell direction, with the g of that
//! direction; facets of the slopes that the lobe has at normal incidence, of those that the viewer sees; the cosine.

use std::f32::consts::{SQRT_2, TAU};

use glam::Vec3A;

use super::super::microfacet::Microfacets;
use super::relief::Heights;
use crate::coherence::Coherence;
use crate::geometry::frame::Frame;
use crate::sampler::cosine_hemisphere;

/// Share of directions that are drawn by their cosine, so that no weight is unbounded.
const DEFENSIVE: f32 = 0.05;

/// The media of a passage: index on the light's and on the camera's side, and whether light is transmitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Media {
    pub(super) n_i: f32,
    pub(super) n_o: f32,
    pub(super) transmitted: bool,
}

impl Media {
    /// `φ/k₀` for two directions away from the surface.
    #[inline]
    pub(super) fn momentum(&self, i: Vec3A, o: Vec3A) -> Vec3A {
        i * self.n_i + o * self.n_o
    }

    /// Cosine on the light's side of the mirror or Snell direction; 0 beyond the critical angle.
    #[inline]
    pub(super) fn specular_cosine(&self, cos_o: f32) -> f32 {
        if !self.transmitted {
            return cos_o.abs();
        }
        let sin2 = (self.n_o / self.n_i).powi(2) * (1.0 - cos_o * cos_o);
        (1.0 - sin2).max(0.0).sqrt()
    }

    /// `|φ_z|/k₀` for two cosines.
    #[inline]
    pub(super) fn vertical(&self, cos_i: f32, cos_o: f32) -> f32 {
        let (a, b) = (self.n_i * cos_i.abs(), self.n_o * cos_o.abs());
        if self.transmitted {
            (a - b).abs()
        } else {
            a + b
        }
    }

    /// The other way round.
    pub(super) fn reversed(self) -> Self {
        Self {
            n_i: self.n_o,
            n_o: self.n_i,
            ..self
        }
    }
}

/// Covariance of the incident directions in `φ_t/(n_i k₀)`: axes and variances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blur {
    axis: [f32; 2],
    variances: [f32; 2],
}

impl Blur {
    pub(super) const NONE: Self = Self {
        axis: [1.0, 0.0],
        variances: [0.0; 2],
    };

    /// Of light at a vertex with this frame.
    #[inline]
    pub(super) fn of(coherence: &Coherence, frame: &Frame) -> Self {
        if coherence.is_point() {
            return Self::NONE;
        }
        let [a, b] = coherence.angular_root.map(|row| frame.to_local(row));
        let (xx, yy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y);
        let xy = a.x * a.y + b.x * b.y;
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = half.hypot(xy);
        let turn = 0.5 * xy.atan2(half);
        Self {
            axis: [turn.cos(), turn.sin()],
            variances: [mean + radius, (mean - radius).max(0.0)],
        }
    }
}

/// Heights at one wavelength.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lit<'a> {
    heights: &'a Heights,
    /// k₀σ.
    pub(super) sigma: f32,
    /// k₀D.
    pub(super) root: f32,
}

impl<'a> Lit<'a> {
    pub(super) fn new(heights: &'a Heights, wavelength: f32) -> Self {
        let k = TAU / wavelength;
        Self {
            heights,
            sigma: k * heights.deviation,
            root: k * heights.root,
        }
    }

    /// Phase variance for a vertical wave vector over k₀.
    #[inline]
    pub(super) fn variance(&self, vertical: f32) -> f32 {
        (self.sigma * vertical).powi(2)
    }

    /// Phase variance of the mirror or Snell pair.
    #[inline]
    pub(super) fn specular_variance(&self, media: Media, cos_o: f32) -> f32 {
        self.variance(media.vertical(media.specular_cosine(cos_o), cos_o))
    }

    /// Standard deviation of the narrowest lobe about the mirror or Snell direction, in `φ_t/k₀`.
    pub(super) fn narrowest(&self, media: Media, cos_o: f32) -> f32 {
        let lobe = self.heights.lobes.at(self.specular_variance(media, cos_o));
        lobe.narrowest().sqrt() / self.root
    }

    /// `f cos_i cos_o` without Fresnel and cap, 1/sr; 0 where no facet leads from one direction to the other.
    #[inline]
    pub(super) fn power(&self, media: Media, i: Vec3A, o: Vec3A, blur: &Blur) -> f32 {
        let phi = media.momentum(i, o);
        // the facet's normal on the light's side
        let side = (phi.z * i.z).signum();
        let (on_i, on_o) = (side * i.dot(phi), side * o.dot(phi));
        let on_o_front = if media.transmitted { -on_o } else { on_o };
        if phi.z == 0.0 || on_i <= 0.0 || on_o_front <= 0.0 {
            return 0.0;
        }
        let g = self.variance(phi.z);
        // 1 − g/2 where the difference would round
        let share = if g > 1e-3 {
            -(-g).exp_m1() / g
        } else {
            1.0 - 0.5 * g
        };
        let [c, s] = blur.axis;
        let p = [c * phi.x + s * phi.y, c * phi.y - s * phi.x].map(|p| p * self.root);
        let widths = blur.variances.map(|v| v * (self.root * media.n_i).powi(2));
        let lobe = self.heights.lobes.at(g).value(p, widths);
        let scale = media.n_o * self.sigma * self.root;
        let lit = self.shadowing(i) * self.shadowing(o);
        scale * scale / TAU * share * on_i * on_o_front * lobe * lit
    }

    /// Smith's G1 of a direction.
    #[inline]
    fn shadowing(&self, v: Vec3A) -> f32 {
        let slopes = self.heights.slopes.as_ref();
        slopes.map_or(1.0, |slopes| slopes.shadowing(v, Vec3A::Z))
    }

    /// Facets that make the lobe of normal incidence, and shares of the densities: lobe, facets.
    #[inline]
    fn mixture(&self, media: Media, cos_o: f32) -> (Microfacets, [f32; 2]) {
        let vertical = media.vertical(1.0, 1.0);
        let steepest = self.variance(vertical);
        let rate = self.heights.lobes.at(steepest).rate();
        let alpha = (SQRT_2 * rate.sqrt() / (self.root * vertical)).clamp(1e-4, 2.0);
        let facets = Microfacets::new(self.heights.tail, alpha, alpha);
        let g = self.specular_variance(media, cos_o);
        // at large g facets are drawn, but where the mirror direction is smooth it is the lobe's
        let rough = (g / (g + 3.0)).max(0.5 * steepest / (1.0 + steepest));
        let share = (1.0 - DEFENSIVE) * rough;
        (facets, [1.0 - DEFENSIVE - share, share])
    }

    /// Density per steradian of [`Lit::draw`]; `o` above the surface.
    #[inline]
    pub(super) fn density(&self, media: Media, i: Vec3A, o: Vec3A) -> f32 {
        let (facets, [by_lobe, by_facets]) = self.mixture(media, o.z);
        let phi = media.momentum(i, o);
        let lobe = self.heights.lobes.at(self.specular_variance(media, o.z));
        let p = [phi.x * self.root, phi.y * self.root];
        let cos_i = i.z.abs();
        let mut density = DEFENSIVE * cos_i / std::f32::consts::PI
            + by_lobe * lobe.value(p, [0.0; 2]) * (self.root * media.n_i).powi(2) * cos_i / TAU;
        let length2 = phi.length_squared();
        let h = phi * (phi.z.signum() / length2.sqrt());
        let (i_h, o_h) = (i.dot(h), o.dot(h));
        let across = if media.transmitted { -i_h } else { i_h };
        if length2 > 0.0 && o_h > 0.0 && across > 0.0 {
            density +=
                by_facets * facets.sampling_density(o, h) * media.n_i.powi(2) * across / length2;
        }
        density
    }

    /// A direction toward the light; `o` above the surface. `None`: the drawn facet or wave leads nowhere.
    #[inline]
    pub(super) fn draw(&self, media: Media, o: Vec3A, mut u: f32, uv: [f32; 2]) -> Option<Vec3A> {
        let (facets, [by_lobe, by_facets]) = self.mixture(media, o.z);
        let below = if media.transmitted { -1.0 } else { 1.0 };
        if super::choose(&mut u, DEFENSIVE) {
            let i = cosine_hemisphere(uv);
            return Some(Vec3A::new(i.x, i.y, below * i.z));
        }
        let across = if super::choose(&mut u, by_facets / (by_lobe + by_facets)) {
            let m = facets.sample(o, uv);
            let o_m = o.dot(m);
            if o_m <= 0.0 {
                return None;
            }
            if !media.transmitted {
                return Some(super::super::mirror(o, m)).filter(|i| i.z > 0.0);
            }
            let ratio = media.n_o / media.n_i;
            let cos2 = 1.0 - ratio * ratio * (1.0 - o_m * o_m);
            if cos2 <= 0.0 {
                return None;
            }
            let i = (m * o_m - o) * ratio - m * cos2.sqrt();
            return Some(i.normalize()).filter(|i| i.z < 0.0);
        } else {
            let m = self
                .heights
                .lobes
                .at(self.specular_variance(media, o.z))
                .draw(&mut u);
            // Box and Muller
            let radius = (-2.0 * m * (1.0 - uv[0]).ln()).sqrt() / self.root;
            let (sin, cos) = (TAU * uv[1]).sin_cos();
            [radius * cos, radius * sin]
        };
        let x = (across[0] - media.n_o * o.x) / media.n_i;
        let y = (across[1] - media.n_o * o.y) / media.n_i;
        let z2 = 1.0 - x * x - y * y;
        (z2 > 0.0).then(|| Vec3A::new(x, y, below * z2.sqrt()))
    }
}
