//! Layers between half-spaces: from the waves (a, b) to the waves of the media before and behind.

use nalgebra::Matrix2;
use num_complex::Complex64;

use super::half_space::HalfSpace;
use super::scattering::{Scattering, joined};
use crate::JonesMatrix;

impl Scattering<Complex64, 2> {
    /// These layers with waves of the half-spaces before and behind in place of the waves (a, b).
    ///
    /// Where the system is singular (all waves graze) the light is reflected, amplitude −1.
    pub(super) fn between(&self, before: &HalfSpace, behind: &HalfSpace) -> Self {
        let (r, t) = (self.reflection, self.transmission);
        let (r_back, t_back) = (self.back_reflection, self.back_transmission);
        // unknown: waves that leave, backward before and forward behind; known: the two that come
        let leaving = joined(
            &(before.b_backward - r * before.a_backward),
            &(-(t_back * behind.b_forward)),
            &(-(t * before.a_backward)),
            &(behind.a_forward - r_back * behind.b_forward),
        );
        let coming = joined(
            &(r * before.a_forward - before.b_forward),
            &(t_back * behind.b_backward),
            &(t * before.a_forward),
            &(r_back * behind.b_backward - behind.a_backward),
        );
        let Some(s) = leaving.lu().solve(&coming) else {
            let mirror = -Matrix2::identity();
            return Self {
                reflection: mirror,
                back_reflection: mirror,
                transmission: Matrix2::zeros(),
                back_transmission: Matrix2::zeros(),
            };
        };
        Self::from_blocks(&s)
    }

    /// This, then `next`, without reflections between them.
    pub(super) fn passing(&self, next: &Self) -> Self {
        Self {
            transmission: next.transmission * self.transmission,
            back_transmission: self.back_transmission * next.back_transmission,
            ..*self
        }
    }

    /// The same for powers: Mueller matrices.
    pub(super) fn mueller(&self) -> Scattering<f64, 4> {
        let mueller = |m: &Matrix2<Complex64>| {
            JonesMatrix::new(m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)])
                .mueller()
                .to_matrix()
        };
        Scattering {
            reflection: mueller(&self.reflection),
            transmission: mueller(&self.transmission),
            back_reflection: mueller(&self.back_reflection),
            back_transmission: mueller(&self.back_transmission),
        }
    }
}
