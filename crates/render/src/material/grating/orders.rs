//! The orders that a direction is coupled with, and how they share the light.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Boundary, Grating};
use crate::material::Vertex;

/// The least cosine of an order that is counted: next to grazing the direction is lost in single precision.
const LEAST_COSINE: f64 = 1e-4;

/// Numbers of orders are kept in 15 bits each.
const OFFSET: i32 = 1 << 14;

/// A grating in the axes of a vertex, at one wavelength.
pub(super) struct View {
    /// nm.
    pub(super) wavelength: f32,
    /// 2π/λ, rad/m.
    pub(super) k0: f64,
    /// Unit vectors across the grooves and a quarter turn from it.
    pub(super) axes: [DVec2; 2],
    /// λ/pitch of each; the second is 0 for lines.
    pub(super) steps: [f64; 2],
}

/// A direction that order q couples with the one it was asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    pub(super) q: [i32; 2],
    /// Local; for an order that does not propagate in the surface and longer than 1.
    pub(super) direction: DVec3,
    /// +1 above, −1 below the surface.
    pub(super) side: f64,
    /// Index of refraction there.
    pub(super) index: f64,
    /// φ_z of both directions, rad/m.
    pub(super) phi_z: f64,
    /// `|t_q|²`
    pub(super) share: f64,
}

impl Order {
    pub(super) fn tangential(&self) -> DVec2 {
        self.direction.truncate()
    }

    pub(super) fn propagates(&self) -> bool {
        self.direction.z.abs() >= LEAST_COSINE
    }

    /// Its numbers and side, for [`crate::material::Part::Discrete`].
    pub(super) fn code(&self) -> u32 {
        let [a, b] = self.q.map(|q| (q + OFFSET) as u32 & 0x7fff);
        a | b << 15 | u32::from(self.side < 0.0) << 30
    }

    /// Numbers and side of a code.
    pub(super) fn of_code(code: u32) -> ([i32; 2], f64) {
        let q = [code & 0x7fff, (code >> 15) & 0x7fff].map(|q| q as i32 - OFFSET);
        (q, if code >> 30 == 0 { 1.0 } else { -1.0 })
    }
}

impl View {
    /// A tangential vector along the axes of the grating.
    pub(super) fn along(&self, v: DVec2) -> DVec2 {
        DVec2::new(self.axes[0].dot(v), self.axes[1].dot(v))
    }
}

impl Grating {
    pub(super) fn view(&self, at: &Vertex, wavelength: f32) -> View {
        let lambda = f64::from(wavelength) * 1e-9;
        let first = self.lines.direction(&at.frame);
        let second = self.lines.second.as_ref();
        View {
            wavelength,
            k0: TAU / lambda,
            axes: [first, first.perp()],
            steps: [
                lambda / self.lines.pitch,
                second.map_or(0.0, |(pitch, _)| lambda / pitch),
            ],
        }
    }

    /// Visits the orders of a direction on one side of the surface whose sine is below `reach`.
    pub(super) fn visit(
        &self,
        view: &View,
        from: DVec3,
        side: f64,
        reach: f64,
        mut visit: impl FnMut(&Order),
    ) {
        let [n, index] = [from.z, side].map(|z| self.boundary.index(z > 0.0));
        let centre = view.along(-from.truncate()) * n;
        let limit = index * reach;
        let [a, b] = view.steps;
        let range = |middle: f64, half: f64, step: f64| {
            let bound = f64::from(OFFSET - 1);
            let low = ((-half - middle) / step).ceil().max(-bound);
            let high = ((half - middle) / step).floor().min(bound);
            low as i32..=high as i32
        };
        let rest = if b > 0.0 { 0.0 } else { centre.y * centre.y };
        let half = limit * limit - rest;
        if half <= 0.0 {
            return;
        }
        for q1 in range(centre.x, half.sqrt(), a) {
            let x = centre.x + f64::from(q1) * a;
            let seconds = if b > 0.0 {
                range(centre.y, (limit * limit - x * x).max(0.0).sqrt(), b)
            } else {
                0..=0
            };
            for q2 in seconds {
                let y = centre.y + f64::from(q2) * b;
                let t = (view.axes[0] * x + view.axes[1] * y) / index;
                let cos = (1.0 - t.length_squared()).max(0.0).sqrt();
                let direction = t.extend(cos * side);
                let phi_z = view.k0 * (n * from.z + index * direction.z);
                let order = Order {
                    q: [q1, q2],
                    direction,
                    side,
                    index,
                    phi_z,
                    share: self.lines.share([q1, q2], phi_z),
                };
                if reach > 1.0 || order.propagates() {
                    visit(&order);
                }
            }
        }
    }

    /// Sides on which light leaves.
    pub(super) fn sides(&self, from: DVec3) -> &'static [f64] {
        match (&self.boundary, from.z > 0.0) {
            (Boundary::Metal(_), _) => &[1.0],
            (_, true) => &[1.0, -1.0],
            (_, false) => &[-1.0, 1.0],
        }
    }

    /// What the orders of a direction carry together on its own side and on the other, and at most together.
    fn totals(&self, view: &View, from: DVec3) -> [f64; 3] {
        let mut totals = [0.0; 3];
        for &side in self.sides(from) {
            let other = usize::from(side * from.z < 0.0);
            self.visit(view, from, side, 1.0, |order| {
                totals[other] += order.share;
                if let Boundary::Glass(_) = self.boundary
                    && let Some((_, m)) =
                        self.boundary.facet(from, order.direction, view.wavelength)
                {
                    totals[2] += order.share * f64::from(m.mean + m.difference.abs());
                }
            });
        }
        totals
    }

    /// The factor that keeps orders from carrying more than arrives, the same from both ends.
    pub(super) fn cap(&self, view: &View, i: DVec3, o: DVec3) -> f64 {
        if !self.capped {
            return 1.0;
        }
        let side = usize::from(i.z * o.z < 0.0);
        let [from_i, from_o] = [i, o].map(|d| {
            let totals = self.totals(view, d);
            totals[side].max(totals[2])
        });
        from_i.max(from_o).max(1.0).recip()
    }

    /// Weight of an order when one is drawn: its share of the power, Fresnel's factor included where it varies much.
    pub(super) fn importance(&self, view: &View, o: DVec3, order: &Order) -> f64 {
        match &self.boundary {
            Boundary::Metal(_) => order.share,
            boundary @ Boundary::Glass(_) => {
                let mut i = order.direction;
                if !order.propagates() {
                    i = DVec3::new(i.x, i.y, LEAST_COSINE * order.side).normalize();
                }
                let m = boundary.facet(i, o, view.wavelength);
                order.share * m.map_or(0.0, |(_, m)| f64::from(m.mean))
            }
        }
    }

    /// Draws an order for a viewer at `o`: it, its probability, and what is left of the uniform number.
    pub(super) fn draw_order(&self, view: &View, o: DVec3, u: f32) -> Option<(Order, f64, f64)> {
        let mut u = f64::from(u);
        let (mut sum, mut drawn) = (0.0, None);
        let reach = self.lobes.reach(view.k0);
        for &side in self.sides(o) {
            self.visit(view, o, side, reach, |order| {
                let weight = self.importance(view, o, order);
                if weight <= 0.0 {
                    return;
                }
                // weighted reservoir of one; what is left of `u` is uniform again
                sum += weight;
                let share = weight / sum;
                if u < share {
                    u /= share;
                    drawn = Some((*order, weight));
                } else {
                    u = (u - share) / (1.0 - share);
                }
            });
        }
        drawn.map(|(order, weight)| (order, weight / sum, u))
    }

    /// The direction of an order by its code, where it propagates.
    pub(super) fn order_of(&self, view: &View, o: DVec3, code: u32) -> Option<DVec3> {
        let (q, side) = Order::of_code(code);
        let [n_o, n_i] = [o.z, side].map(|z| self.boundary.index(z > 0.0));
        let [x, y] = [0, 1].map(|k| view.axes[k] * (f64::from(q[k]) * view.steps[k]));
        let t = (x + y - o.truncate() * n_o) / n_i;
        let cos2 = 1.0 - t.length_squared();
        (cos2 > LEAST_COSINE * LEAST_COSINE).then(|| t.extend(cos2.sqrt() * side))
    }
}
