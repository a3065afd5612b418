//! The order of the modes in which matter scatters, chosen for a tolerance.

use stokes::{EnvelopeModes, MAX_ORDER, ModeWidth};

use crate::accuracy::Tolerance;
use crate::population::{Matter, MatterError};

/// The order chosen for an envelope, and whether it is enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeChoice {
    /// The order.
    pub order: usize,
    /// The L² norm of what the modes leave out of the far field, over that of the whole
    /// ([`EnvelopeModes::relative_error`]).
    pub error: f64,
    /// Whether the error is within the tolerance. A hard edge converges as N^(−1/4) and does not get below some per cent
    /// at any order: split such an envelope into Gaussians instead ([`stokes::Envelope::patches_for`]).
    pub reached: bool,
}

impl Matter {
    /// The modes of every envelope of the lowest order whose error is within the tolerance, at most `most`, and what was
    /// chosen for each.
    ///
    /// ```
    /// use mueller16::{Autocorrelation, Matter, Population, Tolerance};
    /// use nalgebra::Matrix2;
    /// use stokes::{Envelope, ModeWidth, Mueller};
    /// let square = Population::of_mueller(
    ///     &Mueller::identity(),
    ///     Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10))?,
    ///     Envelope::rectangle(1e-3, 1e-3)?,
    /// )?;
    /// let matter = Matter::new(vec![square])?;
    /// // a square has 0.51 at order 0 and not yet a tenth at order 256
    /// let (_, half) = matter.modes_for(ModeWidth::VarianceMatched, Tolerance::relative(0.4)?, 64)?;
    /// let (_, tenth) = matter.modes_for(ModeWidth::VarianceMatched, Tolerance::relative(0.1)?, 64)?;
    /// assert!(half[0].reached && half[0].order > 0);
    /// assert!(!tenth[0].reached && tenth[0].order == 64 && tenth[0].error > 0.1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Matter::modes`].
    pub fn modes_for(
        &self,
        width: ModeWidth,
        tolerance: Tolerance,
        most: usize,
    ) -> Result<(Vec<EnvelopeModes>, Vec<ModeChoice>), MatterError> {
        let most = most.min(MAX_ORDER);
        let mut chosen = (vec![], vec![]);
        for envelope in self.envelopes() {
            let all = envelope.modes(width, most)?;
            let order = lowest(&all, tolerance.get());
            let modes = envelope.modes(width, order)?;
            chosen.1.push(ModeChoice {
                order,
                error: modes.relative_error(),
                reached: modes.relative_error() <= tolerance.get(),
            });
            chosen.0.push(modes);
        }
        Ok(chosen)
    }
}

/// The lowest order whose error is below the tolerance by Parseval, or the order of `modes`.
fn lowest(modes: &EnvelopeModes, tolerance: f64) -> usize {
    let (kept, rest) = (modes.series().norm(), modes.relative_error());
    // whole² = kept² + rest² whole²
    let whole = kept / ((1.0 - rest) * (1.0 + rest)).sqrt();
    let error = |n: usize| (modes.series().truncated(n).1 / whole).hypot(rest);
    (0..modes.series().order())
        .find(|n| error(*n) <= tolerance)
        .unwrap_or(modes.series().order())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Autocorrelation, Population};
    use nalgebra::{Matrix2, Vector2};
    use stokes::{Envelope, GaussianPeak, Mueller};

    #[test]
    fn no_lower_order_would_do() {
        let peak = |x: f64| GaussianPeak {
            peak: 1.0,
            centre: Vector2::new(x, 0.2 * x),
            covariance: Matrix2::identity(),
        };
        let envelopes = [
            Envelope::mixture(&[peak(-1.0), peak(1.4)]).unwrap(),
            Envelope::gaussian(&Matrix2::identity()).unwrap(),
            Envelope::disk(1.0).unwrap(),
        ];
        let populations = envelopes.iter().map(|e| {
            let r = Autocorrelation::constant(1.0);
            Population::of_sixteen(&Mueller::identity(), r, e.clone())
        });
        let matter = Matter::new(populations.collect()).unwrap();
        for tolerance in [0.3, 1e-2, 1e-6] {
            let asked = Tolerance::relative(tolerance).unwrap();
            let (modes, choices) = matter
                .modes_for(ModeWidth::VarianceMatched, asked, 40)
                .unwrap();
            for ((envelope, modes), choice) in envelopes.iter().zip(modes).zip(choices) {
                let error = |n| {
                    let modes = envelope.modes(ModeWidth::VarianceMatched, n).unwrap();
                    modes.relative_error()
                };
                assert_eq!(modes.series().order(), choice.order);
                assert_eq!(choice.error, error(choice.order));
                assert_eq!(choice.reached, choice.error <= tolerance);
                assert!(choice.reached || choice.order == 40);
                assert!(choice.order == 0 || error(choice.order - 1) > tolerance);
            }
        }
    }
}
