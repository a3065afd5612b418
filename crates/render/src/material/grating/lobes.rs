//! Orders as lobes: the aperture of a finite grating, and the haloes of roughness.
//!
//! Wave vectors are in units of k₀ = 2π/λ unless they have a unit.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Grating;
use super::orders::{Order, View};
use crate::coherence::Coherence;
use crate::material::Vertex;

/// Beyond this phase variance a halo is one Gaussian: its error is 1/g of the peak.
const LARGE: f64 = 60.0;

/// Poisson weights below this are left out.
const LEAST: f64 = 1e-7;

/// Standard deviations beyond which a lobe is dark: e^(−32).
const FAR: f64 = 8.0;

/// What spreads the light of an order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobes {
    /// rms height, metres.
    pub(super) height: f64,
    /// Correlation length of the heights, metres.
    pub(super) length: f64,
    /// Size of the grating, metres; infinite: sharp orders.
    pub(super) size: f64,
}

impl Lobes {
    /// Whether some light leaves in lobes.
    pub(super) fn exist(&self) -> bool {
        self.height > 0.0 || self.size.is_finite()
    }

    /// g = (φ_z σ)²
    pub(super) fn phase_variance(&self, phi_z: f64) -> f64 {
        (phi_z * self.height).powi(2)
    }

    /// Standard deviation of the narrowest lobe along one axis, rad/m.
    pub(super) fn narrowest(&self) -> Option<f64> {
        if self.size.is_finite() {
            Some(self.size.recip())
        } else if self.height > 0.0 {
            Some(2f64.sqrt() / self.length)
        } else {
            None
        }
    }

    /// Orders with smaller sines than this have lobes among the directions that propagate.
    pub(super) fn reach(&self, k0: f64) -> f64 {
        1.0 + self.narrowest().map_or(0.0, |width| 4.0 * width / k0)
    }

    /// Variance along one axis of light that roughness has scattered `m` times, rad²/m².
    fn variance(&self, m: f64) -> f64 {
        let rough = if m > 0.0 {
            2.0 * m / (self.length * self.length)
        } else {
            0.0
        };
        rough + (self.size * self.size).recip()
    }

    /// Visits weight and variance of the lobes of an order with phase variance g; not the sharp part.
    fn visit(&self, g: f64, mut visit: impl FnMut(f64, f64)) {
        if g > LARGE {
            return visit(1.0, self.variance(g));
        }
        let weight = (-g).exp();
        if self.size.is_finite() {
            visit(weight, self.variance(0.0));
        }
        if g > 0.0 {
            self.visit_halo(g, weight, visit);
        }
    }

    /// The lobes of light that roughness has scattered, once and more often; `weight` is e^(−g).
    fn visit_halo(&self, g: f64, mut weight: f64, mut visit: impl FnMut(f64, f64)) {
        let mut m = 1.0;
        loop {
            weight *= g / m;
            if m > g && weight < LEAST {
                return;
            }
            visit(weight, self.variance(m));
            m += 1.0;
        }
    }

    /// Draws how far the light of an order is turned aside; `None`: not at all, it is in the sharp part.
    pub(super) fn draw(&self, view: &View, order: &Order, u: f64, v: [f32; 2]) -> Option<DVec2> {
        if !self.exist() {
            return None;
        }
        let g = self.phase_variance(order.phi_z);
        let sharp = self.sharp(g);
        let mut rest = u;
        if order.propagates() {
            rest -= sharp;
        } else {
            rest *= 1.0 - sharp;
        }
        if rest < 0.0 {
            return None;
        }
        let mut variance = self.variance(0.0);
        let mut found = false;
        self.visit(g, |weight, of_this| {
            if !found {
                variance = of_this;
                rest -= weight;
                found = rest < 0.0;
            }
        });
        let radius = (-2.0 * variance * (1.0 - f64::from(v[0])).max(1e-12).ln()).sqrt() / view.k0;
        Some(DVec2::from_angle(TAU * f64::from(v[1])) * radius)
    }

    /// Share of the light of an order that stays sharp.
    fn sharp(&self, g: f64) -> f64 {
        if self.size.is_finite() || g > LARGE {
            0.0
        } else {
            (-g).exp()
        }
    }
}

/// Covariance of the light's own wave vectors along the axes of the grating: xx, xy, yy.
pub(super) type Spread = [f64; 3];

impl Grating {
    pub(super) fn spread(
        &self,
        view: &View,
        at: &Vertex,
        i: DVec3,
        coherence: &Coherence,
    ) -> Spread {
        if coherence.is_point() {
            return [0.0; 3];
        }
        let n_i = self.boundary.index(i.z > 0.0);
        let [a, b] = coherence.angular_root.map(|row| {
            let local = at.frame.to_local(row).as_dvec3();
            view.along(local.truncate()) * n_i
        });
        [
            a.x * a.x + b.x * b.x,
            a.x * a.y + b.x * b.y,
            a.y * a.y + b.y * b.y,
        ]
    }

    /// The lobes of all orders at the wave vector that i and o give, averaged over the light's own directions; per unit of
    /// (k₀ × k₀).
    pub(super) fn lobe(&self, view: &View, i: DVec3, o: DVec3, spread: &Spread) -> f64 {
        if !self.lobes.exist() {
            return 0.0;
        }
        let [n_i, n_o] = [i, o].map(|d| self.boundary.index(d.z > 0.0));
        let kappa = view.along(o.truncate() * n_o + i.truncate() * n_i);
        let phi_z = view.k0 * (n_i * i.z + n_o * o.z);
        let mut sum = 0.0;
        let scale = (view.k0 * view.k0).recip();
        self.lobes
            .visit(self.lobes.phase_variance(phi_z), |weight, variance| {
                let v = variance * scale;
                let [xx, xy, yy] = [spread[0] + v, spread[1], spread[2] + v];
                let determinant = xx * yy - xy * xy;
                let norm = weight / (TAU * determinant.sqrt());
                let far = DVec2::new(xx, yy).map(f64::sqrt) * FAR;
                for q1 in near(kappa.x, view.steps[0], far.x) {
                    for q2 in near(kappa.y, view.steps[1], far.y) {
                        let d = kappa
                            - DVec2::new(
                                f64::from(q1) * view.steps[0],
                                f64::from(q2) * view.steps[1],
                            );
                        let square =
                            (yy * d.x * d.x - 2.0 * xy * d.x * d.y + xx * d.y * d.y) / determinant;
                        if square < FAR * FAR {
                            let share = self.lines.share([q1, q2], phi_z);
                            sum += share * norm * (-0.5 * square).exp();
                        }
                    }
                }
            });
        sum
    }

    /// Density per steradian around i of directions drawn in lobes for a viewer at o.
    pub(super) fn density(&self, view: &View, i: DVec3, o: DVec3) -> f64 {
        let n_i = self.boundary.index(i.z > 0.0);
        let reach = self.lobes.reach(view.k0);
        let scale = (view.k0 * view.k0).recip();
        let (mut sum, mut weights) = (0.0, 0.0);
        for &side in self.sides(o) {
            self.visit(view, o, side, reach, |order| {
                let weight = self.importance(view, o, order);
                weights += weight;
                if side * i.z < 0.0 || weight <= 0.0 {
                    return;
                }
                let square = ((i.truncate() - order.tangential()) * n_i).length_squared();
                let g = self.lobes.phase_variance(order.phi_z);
                let whole = if order.propagates() {
                    1.0
                } else {
                    1.0 - self.lobes.sharp(g)
                };
                self.lobes.visit(g, |share, variance| {
                    let v = variance * scale;
                    if square < FAR * FAR * v {
                        sum += weight * share / whole * (-0.5 * square / v).exp() / (TAU * v);
                    }
                });
            });
        }
        if weights > 0.0 {
            sum / weights * n_i * n_i * i.z.abs()
        } else {
            0.0
        }
    }
}

/// Orders whose place is within `far` of `kappa`; where there are no lines 0 alone, if at all.
fn near(kappa: f64, step: f64, far: f64) -> std::ops::Range<i32> {
    if step > 0.0 {
        ((kappa - far) / step).ceil() as i32..((kappa + far) / step).floor() as i32 + 1
    } else {
        0..i32::from(kappa.abs() < far)
    }
}
