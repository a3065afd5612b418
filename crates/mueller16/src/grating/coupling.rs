//! What orders carry: shares made reciprocal and passive, or lossless.

use nalgebra::Vector2;

use super::mount::{Mount, Order, cosine};
use super::{Grating, GratingError};

/// Most directions of a coupled set: the shares of all pairs are held.
const MOST_COUPLED: usize = 1000;

/// Sums that differ from 1 by no more are 1.
const LOSSLESS: f64 = 1e-12;

/// Sweeps after which the lossless sharing is given up.
const MOST_SWEEPS: usize = 2000;

/// All directions that a grating couples with one direction of incidence: `{i_t + mG}` and `{−i_t + qG}`, with the share
/// of every pair.
///
/// Shares `p_q` are of unit sum for one `φ_z`; each order has its own, and the evanescent ones take what they would
/// have. The orders of one direction of incidence may thus hold more or less than what came.
///
/// ```
/// use mueller16::{CoupledOrders, Grating, Mount, Profile};
/// use nalgebra::{Vector2, Vector3};
/// use stokes::Wavelength;
/// let disc = Grating::lines(1.6e-6, Vector2::x(), Profile::sinusoidal(120e-9)?)?;
/// let green = Wavelength::from_metres(550e-9)?;
/// let mount = Mount::reflection(Vector3::z(), [Vector3::x(), Vector3::y()], green, 1.0)?;
/// let coupled = CoupledOrders::new(&disc, &mount)?;
/// // what the phase alone says falls short by 5 % here
/// assert!((coupled.total_share() - 0.946).abs() < 5e-4);
/// let lossless = coupled.lossless()?;
/// assert!((lossless.efficiencies.iter().sum::<f64>() - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledOrders {
    orders: Vec<Order>,
    /// Shares of all pairs, a row for each direction of incidence.
    shares: Vec<Vec<f64>>,
    /// The row of the given direction of incidence.
    here: usize,
}

/// Shares that are reciprocal and add up to 1 from every direction of the coupled set.
#[derive(Clone, Debug, PartialEq)]
pub struct LosslessOrders {
    /// Efficiencies, in `0.0..=1.0`, of [`CoupledOrders::orders`].
    pub efficiencies: Vec<f64>,
    /// Largest change of a share of any pair.
    pub moved: f64,
    /// Sweeps over rows and columns.
    pub sweeps: usize,
    /// Largest difference of a sum from 1 that is left.
    pub residual: f64,
}

impl LosslessOrders {
    /// Whether all sums are 1 to 1e-12. Sets of shares among which too many are 0 have no such sums.
    #[must_use]
    pub fn has_converged(&self) -> bool {
        self.residual <= LOSSLESS
    }
}

impl CoupledOrders {
    /// The directions that `grating` couples with the source of `mount`.
    ///
    /// Cost: an amplitude for each pair of directions.
    ///
    /// # Errors
    ///
    /// When a set has more than 1000 directions, or the phase depth exceeds 1e5.
    pub fn new(grating: &Grating, mount: &Mount) -> Result<Self, GratingError> {
        let k0 = mount.wavenumber();
        let indices = mount.indices();
        let centres = [
            mount.incident_tangential(),
            mount.outgoing_tangential(&Vector2::zeros()),
        ];
        let [k_i, k_o] = mount.signed_wavenumbers();
        let mut sources = vec![];
        let unit = k0 * indices[0];
        for index in grating.propagating(&centres[0], unit, MOST_COUPLED)? {
            let at = centres[0] + grating.shift(index) / unit;
            sources.extend(cosine(&at).map(|cosine| (index, cosine)));
        }
        let listed = grating.propagating(&centres[1], k0 * indices[1], MOST_COUPLED)?;
        let mut orders = Vec::with_capacity(listed.len());
        for index in listed {
            // rounding at a pass-off may leave none of it
            if let Some(geometry) = mount.diffracted(&grating.shift(index)) {
                orders.push(grating.order_at(index, geometry)?);
            }
        }
        // as it was given, not by way of its sine
        let here = match sources.iter().position(|(m, _)| *m == [0, 0]) {
            Some(here) => here,
            None => {
                sources.push(([0, 0], 0.0));
                sources.len() - 1
            }
        };
        sources[here].1 = mount.cos_incident();
        let mut shares = Vec::with_capacity(sources.len());
        for (m, cos_i) in &sources {
            let mut row = Vec::with_capacity(orders.len());
            for order in &orders {
                let phi_z = k_i * cos_i + k_o * order.geometry.cos_outgoing().abs();
                grating.check_phase(phi_z)?;
                let q = order.index;
                let order = [m[0] + q[0], m[1] + q[1]];
                row.push(grating.amplitude(phi_z, order).norm_sqr());
            }
            shares.push(row);
        }
        Ok(Self {
            orders,
            shares,
            here,
        })
    }

    /// The propagating orders of the given direction of incidence.
    #[must_use]
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// `N(i) = Σ p_q` over the propagating orders.
    #[must_use]
    pub fn total_share(&self) -> f64 {
        self.shares[self.here].iter().sum()
    }

    /// `η_q = p_q/max(1, N(i), N(o_q))` for each order, in `0.0..=1.0`: the same from both ends, and at most 1 together.
    #[must_use]
    pub fn efficiencies(&self) -> Vec<f64> {
        let row = &self.shares[self.here];
        let own = self.total_share().max(1.0);
        let capped = row.iter().enumerate().map(|(q, share)| {
            let other: f64 = self.shares.iter().map(|row| row[q]).sum();
            share / own.max(other)
        });
        capped.collect()
    }

    /// Efficiencies that leave nothing out: the shares of all pairs scaled by a factor of each direction until every
    /// direction sends, and receives, exactly 1.
    ///
    /// Energy that the phase would send into evanescent orders is given to those that propagate. Where few shares are
    /// not 0, no such factors exist: see [`LosslessOrders::has_converged`].
    ///
    /// Source: Sinkhorn, "A relationship between arbitrary positive matrices and doubly stochastic matrices", Ann. Math.
    /// Stat. 35 (1964).
    ///
    /// # Errors
    ///
    /// When the two media have different numbers of directions.
    pub fn lossless(&self) -> Result<LosslessOrders, GratingError> {
        let (incident, outgoing) = (self.shares.len(), self.orders.len());
        if incident != outgoing {
            return Err(GratingError::Unpaired { incident, outgoing });
        }
        let (rows, columns, sweeps, residual) = balance(&self.shares);
        let scaled = |m: usize, q: usize| rows[m] * self.shares[m][q] * columns[q];
        let mut moved: f64 = 0.0;
        for (m, row) in self.shares.iter().enumerate() {
            for (q, share) in row.iter().enumerate() {
                moved = moved.max((scaled(m, q) - share).abs());
            }
        }
        Ok(LosslessOrders {
            efficiencies: (0..outgoing).map(|q| scaled(self.here, q)).collect(),
            moved,
            sweeps,
            residual,
        })
    }
}

/// Factors of the rows and columns of a square matrix by which all its sums are 1, the sweeps it took, and the largest
/// difference that is left.
fn balance(matrix: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>, usize, f64) {
    let n = matrix.len();
    let (mut rows, mut columns) = (vec![1.0; n], vec![1.0; n]);
    let mut sums = vec![0.0; n];
    let (mut sweeps, mut residual) = (0, f64::INFINITY);
    loop {
        sums.fill(0.0);
        for (row, factor) in matrix.iter().zip(&rows) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += value * factor;
            }
        }
        // rows are exact after the first sweep; what they leave to the columns is the error
        let worst = sums
            .iter()
            .zip(&columns)
            .map(|(sum, column)| (sum * column - 1.0).abs())
            .fold(0.0, f64::max);
        if sweeps > 0 {
            residual = worst;
        }
        if residual <= LOSSLESS || sweeps == MOST_SWEEPS {
            return (rows, columns, sweeps, residual);
        }
        for (column, sum) in columns.iter_mut().zip(&sums) {
            *column = inverse_of(*sum);
        }
        for (factor, row) in rows.iter_mut().zip(matrix) {
            *factor = inverse_of(row.iter().zip(&columns).map(|(v, c)| v * c).sum());
        }
        sweeps += 1;
    }
}

/// A direction without any share keeps it.
fn inverse_of(sum: f64) -> f64 {
    if sum > 0.0 { 1.0 / sum } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balanced_matrix_has_the_known_factors() {
        // of [1 2; 2 1]: 1/3 of each; of [1 4; 1 1] with the invariant (m11 m22)/(m12 m21) = 1/4: 1/3 and 2/3
        for (matrix, diagonal) in [
            ([[1.0, 2.0], [2.0, 1.0]], 1.0 / 3.0),
            ([[1.0, 4.0], [1.0, 1.0]], 1.0 / 3.0),
        ] {
            let matrix = matrix.map(|row| row.to_vec());
            let (rows, columns, _, residual) = balance(&matrix);
            assert!(residual <= LOSSLESS);
            for i in 0..2 {
                assert!((rows[i] * matrix[i][i] * columns[i] - diagonal).abs() < 1e-12);
                assert!(
                    (rows[i] * matrix[i][1 - i] * columns[1 - i] - 1.0 + diagonal).abs() < 1e-12
                );
            }
        }
    }

    #[test]
    fn shares_that_cannot_be_balanced_are_said_to_be_so() {
        // a direction without any share, and zeros that force another share to 0: the sums close in as 1/sweeps
        for matrix in [
            [[1.0, 1.0], [0.0, 0.0]],
            [[1.0, 1.0], [1.0, 0.0]],
            [[0.0; 2]; 2],
        ] {
            let (rows, columns, sweeps, residual) = balance(&matrix.map(|row| row.to_vec()));
            assert!(
                residual > LOSSLESS && residual <= 1.0 && sweeps == MOST_SWEEPS,
                "{residual}"
            );
            assert!(rows.iter().chain(&columns).all(|factor| factor.is_finite()));
        }
    }
}
