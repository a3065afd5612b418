//! Layers between half-spaces: from the waves (a, b) to the waves of the media before and behind.

use nalgebra::{ComplexField, Matrix2};
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
        leaving
            .lu()
            .solve(&coming)
            .map_or_else(Self::mirror, |s| Self::from_blocks(&s))
    }

    /// A single face between two media: as [`Scattering::between`] of nothing, in 2×2 matrices.
    pub(super) fn face(before: &HalfSpace, behind: &HalfSpace) -> Self {
        let found = match (before.as_real(), behind.as_real()) {
            (Some(before), Some(behind)) => solved_face(&before, &behind).map(|face| Self {
                reflection: face.reflection.map(Complex64::from),
                transmission: face.transmission.map(Complex64::from),
                back_reflection: face.back_reflection.map(Complex64::from),
                back_transmission: face.back_transmission.map(Complex64::from),
            }),
            _ => solved_face(before, behind),
        };
        found.unwrap_or_else(Self::mirror)
    }

    fn mirror() -> Self {
        let mirror = -Matrix2::identity();
        Self {
            reflection: mirror,
            back_reflection: mirror,
            transmission: Matrix2::zeros(),
            back_transmission: Matrix2::zeros(),
        }
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

/// With waves x forward and y backward before, z forward and w backward behind, all as in [`HalfSpace::as_graphs`]:
/// `x + B y = z + B' w`, `F x + y = F' z + w`.
fn solved_face<T: ComplexField + Copy>(
    before: &HalfSpace<T>,
    behind: &HalfSpace<T>,
) -> Option<Scattering<T, 2>> {
    let (near, far) = (before.as_graphs()?, behind.as_graphs()?);
    let one = Matrix2::identity();
    let inverse = (one - near.a_backward * far.b_forward).try_inverse()?;
    let z_x = inverse * (one - near.a_backward * near.b_forward);
    let z_w = inverse * (near.a_backward - far.a_backward);
    let to_y = before.b_backward.try_inverse()?;
    let to_z = behind.a_forward.try_inverse()?;
    Some(Scattering {
        reflection: to_y * (far.b_forward * z_x - near.b_forward) * before.a_forward,
        transmission: to_z * z_x * before.a_forward,
        back_reflection: to_z * z_w * behind.b_backward,
        back_transmission: to_y * (far.b_forward * z_w + one) * behind.b_backward,
    })
}
