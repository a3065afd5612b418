//! Which share of the light each order of a surface's grating gets, so that no more leaves than comes.

use nalgebra::Vector2;

use super::mount::{MOST_LISTED, Mount, cosine};
use super::{CoupledOrders, Grating, GratingError, Order};
use crate::accuracy::Tolerance;
use crate::geometry::Geometry;
use crate::relief::SharpOrder;

/// How the light of a grating that is the relief of a [`crate::Surface`] is shared among its orders.
///
/// The phase alone says `p_q = |t_q|²` for the `φ_z` of each order; over the propagating orders of one direction of
/// incidence these add up to `N(i)`, which may be more or less than 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// `p_q` as they are: not passive.
    Phase,
    /// `p_q/max(1, N(i), N(o_q))`: reciprocal, and at most 1 together.
    #[default]
    Capped,
    /// [`CoupledOrders::lossless`]: reciprocal, and 1 together. Where no such sharing exists or is found, capped.
    Lossless,
}

impl Grating {
    /// The same grating with its light shared in this way when it is the relief of a surface.
    #[must_use]
    pub fn shared(mut self, sharing: Sharing) -> Self {
        self.sharing = sharing;
        self
    }

    /// `N = Σ p_q` over the propagating orders of a mount. Cost: an amplitude for each.
    ///
    /// # Errors
    ///
    /// As [`Grating::orders`].
    pub fn total_share(&self, mount: &Mount) -> Result<f64, GratingError> {
        let centre = mount.outgoing_tangential(&Vector2::zeros());
        let unit = mount.wavenumber() * mount.indices()[1];
        let [k_i, k_o] = mount.signed_wavenumbers();
        let mut sum = 0.0;
        for order in self.propagating(&centre, unit, MOST_LISTED)? {
            let at = centre + self.shift(order) / unit;
            let Some(cos_o) = cosine(&at) else { continue };
            let phi_z = k_i * mount.cos_incident() + k_o * cos_o;
            self.check_phase(phi_z)?;
            sum += self.amplitude(phi_z, order).norm_sqr();
        }
        Ok(sum)
    }

    /// The sharp orders of the source of an encounter, on the side of its observer. Together those that are left out have
    /// less than the tolerance of the largest.
    ///
    /// Cost: an amplitude for each propagating order, and for each that is kept as many again; of a lossless sharing, for
    /// each pair.
    pub(super) fn sharp_orders(
        &self,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<Vec<SharpOrder>, GratingError> {
        let mount = Mount::of(geometry)?;
        if self.sharing == Sharing::Lossless
            && let Some(orders) = self.lossless_orders(&mount, tolerance)?
        {
            return Ok(orders);
        }
        let all = self.orders(&mount)?;
        let own = all.iter().map(|order| order.share).sum::<f64>().max(1.0);
        let shares = all.iter().map(|order| order.share);
        let mut sharp = self.sharp(&all, shares, tolerance);
        if self.sharing != Sharing::Phase {
            for order in &mut sharp {
                let back = self.total_share(&Mount::toward(&order.geometry.reversed()))?;
                order.weight /= own.max(back);
            }
        }
        Ok(sharp)
    }

    fn lossless_orders(
        &self,
        mount: &Mount,
        tolerance: Tolerance,
    ) -> Result<Option<Vec<SharpOrder>>, GratingError> {
        let coupled = CoupledOrders::new(self, mount)?;
        let shared = match coupled.lossless() {
            Ok(shared) if shared.has_converged() => shared,
            Ok(_) | Err(GratingError::Unpaired { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        Ok(Some(self.sharp(
            coupled.orders(),
            shared.efficiencies,
            tolerance,
        )))
    }

    /// Orders within reach, without those that together have less than the tolerance of the largest.
    fn sharp(
        &self,
        orders: &[Order],
        weights: impl IntoIterator<Item = f64>,
        tolerance: Tolerance,
    ) -> Vec<SharpOrder> {
        let all = orders
            .iter()
            .zip(weights)
            .map(|(order, weight)| SharpOrder {
                geometry: order.geometry,
                place: self.shift(order.index),
                weight,
            });
        let mut sharp: Vec<SharpOrder> = all
            .filter(|order| order.place.norm() <= self.reach)
            .collect();
        let largest = sharp.iter().map(|order| order.weight).fold(0.0, f64::max);
        let least = tolerance.get() * largest / sharp.len() as f64;
        sharp.retain(|order| order.weight > least);
        sharp
    }

    /// `1/max(1, N(i), N(o))` of an encounter.
    pub(super) fn cap(&self, geometry: &Geometry) -> Result<f64, GratingError> {
        if self.sharing == Sharing::Phase {
            return Ok(1.0);
        }
        let there = self.total_share(&Mount::of(geometry)?)?;
        let back = self.total_share(&Mount::of(&geometry.reversed())?)?;
        Ok(1.0 / there.max(back).max(1.0))
    }
}
