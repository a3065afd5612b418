//! `|t_q|²` of one profile, tabulated over φ_z.

use mueller16::Profile;

/// Step of the table, radians of phase depth. `|t_q|²` holds no faster cosine than that of the phase depth itself, so that
/// a cubic through four points errs by at most 3/128 of the step's fourth power: 1.5e-7.
const STEP: f64 = 0.05;

/// Most numbers in a table; what lies beyond is computed each time.
const MOST: usize = 1 << 23;

/// The shares of all orders of a profile.
#[derive(Clone, Debug)]
pub(super) struct Shares {
    profile: Profile,
    /// Steps per φ_z, m.
    per_phi: f64,
    /// Orders −last..=last in a row.
    last: i32,
    rows: Vec<f32>,
}

impl Shares {
    /// Of orders up to `last` for φ_z up to `highest`, rad/m.
    pub(super) fn new(profile: Profile, highest: f64, last: i32) -> Self {
        let per_phi = profile.depth() / STEP;
        // one row before 0, two behind the end
        let wanted = (highest * per_phi).ceil() as usize + 4;
        let last = last.min((MOST / wanted.max(1) / 2) as i32).max(8);
        let rows = wanted.min(MOST / (2 * last as usize + 1));
        let rows = (0..rows)
            .flat_map(|row| {
                let phi_z = if per_phi > 0.0 {
                    (row as f64 - 1.0) / per_phi
                } else {
                    0.0
                };
                profile.amplitudes(phi_z, -last..=last)
            })
            .map(|t| t.norm_sqr() as f32)
            .collect();
        Self {
            profile,
            per_phi,
            last,
            rows,
        }
    }

    /// `|t_q|²` at φ_z, rad/m; absolute error below 3e-7.
    #[inline]
    pub(super) fn get(&self, phi_z: f64, q: i32) -> f64 {
        // real heights: t_q(−φ) is t_(−q)(φ) conjugated
        let (phi, order) = if phi_z < 0.0 {
            (-phi_z, -q)
        } else {
            (phi_z, q)
        };
        let place = phi * self.per_phi;
        let (row, x) = (place as usize, place.fract());
        let width = 2 * self.last as usize + 1;
        if order.abs() > self.last || (row + 4) * width > self.rows.len() {
            return self.profile.amplitude(phi_z, q).norm_sqr();
        }
        let start = row * width + (order + self.last) as usize;
        let value = |k: usize| f64::from(self.rows[start + k * width]);
        // Lagrange through −1, 0, 1, 2
        let (a, b, c) = (x + 1.0, x - 1.0, x - 2.0);
        let sum = -x * b * c / 6.0 * value(0) + a * b * c / 2.0 * value(1)
            - a * x * c / 2.0 * value(2)
            + a * x * b / 6.0 * value(3);
        sum.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mueller16::Blaze;

    #[test]
    fn the_table_holds_the_shares_of_every_profile() {
        let profiles = [
            Profile::sinusoidal(0.4e-6),
            Profile::lamellar(0.4e-6, 0.3),
            Profile::blazed(0.4e-6, Blaze::Rising),
            Profile::triangular(0.4e-6, 0.2),
            Profile::sinusoidal(0.0),
        ];
        for profile in profiles {
            let profile = profile.unwrap();
            let table = Shares::new(profile.clone(), 4e7, 20);
            for n in 0..2000 {
                let phi_z = -5e7 + 5e4 * f64::from(n);
                for q in [-21, -7, -1, 0, 1, 2, 20] {
                    let exact = profile.amplitude(phi_z, q).norm_sqr();
                    let found = table.get(phi_z, q);
                    assert!((found - exact).abs() < 3e-7, "{q} {phi_z}: {found} {exact}");
                }
            }
        }
    }
}
