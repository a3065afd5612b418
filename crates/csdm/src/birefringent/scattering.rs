//! What a layer does to waves from both sides, and how layers are put together without growing exponentials.

use nalgebra::{ComplexField, Matrix2, Matrix4, SMatrix, SymmetricEigen};
use num_complex::Complex64;

use super::generator::Generator;

/// Reflection and transmission from the front (light along +z) and from the back: N×N each, Jones (2) or Mueller (4).
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattering<T, const N: usize> {
    pub(super) reflection: SMatrix<T, N, N>,
    pub(super) transmission: SMatrix<T, N, N>,
    pub(super) back_reflection: SMatrix<T, N, N>,
    pub(super) back_transmission: SMatrix<T, N, N>,
}

impl<T: ComplexField, const N: usize> Scattering<T, N> {
    /// Nothing in the way.
    pub(super) fn transparent() -> Self {
        Self {
            reflection: SMatrix::zeros(),
            transmission: SMatrix::identity(),
            back_reflection: SMatrix::zeros(),
            back_transmission: SMatrix::identity(),
        }
    }

    /// This in front of `next`, all reflections between the two summed: Redheffer's star product.
    ///
    /// `1 − R'R` is singular only where both reflect everything, and then nothing gets in between.
    pub(super) fn then(&self, next: &Self) -> Self {
        let one = SMatrix::<T, N, N>::identity();
        let inverse = |m: SMatrix<T, N, N>| m.try_inverse().unwrap_or_else(SMatrix::zeros);
        // amplitudes that run forward and backward between the two
        let forward = inverse(&one - &self.back_reflection * &next.reflection) * &self.transmission;
        let backward =
            inverse(one - &next.reflection * &self.back_reflection) * &next.back_transmission;
        Self {
            reflection: &self.reflection + &self.back_transmission * &next.reflection * &forward,
            transmission: &next.transmission * forward,
            back_reflection: &next.back_reflection
                + &next.transmission * &self.back_reflection * &backward,
            back_transmission: &self.back_transmission * backward,
        }
    }

    /// This in front of `next`, which reflects nothing.
    pub(super) fn before_clear(&self, next: &Self) -> Self {
        Self {
            reflection: self.reflection.clone(),
            transmission: &next.transmission * &self.transmission,
            back_reflection: &next.transmission * &self.back_reflection * &next.back_transmission,
            back_transmission: &self.back_transmission * &next.back_transmission,
        }
    }
}

impl Scattering<Complex64, 2> {
    /// A layer of `depth` radians, `k₀ d`, of a medium: a thin slice, doubled until it is the layer.
    ///
    /// Waves are those of [`Generator`]. Every slice of passive matter is a contraction, so nothing grows, whether the
    /// medium has four different waves, coinciding ones, or (along a singular axis) fewer than four.
    pub(super) fn of_layer(generator: &Generator, depth: f64, lossless: bool) -> Self {
        let (mut layer, doublings) = Self::slice(generator, depth);
        for _ in 0..doublings {
            layer = layer.then(&layer);
            layer = if lossless {
                layer.made_unitary()
            } else {
                layer.made_passive()
            };
        }
        layer
    }

    /// A slice of thickness `depth/2^m`, and m, so that `k₀ h |M| ≤ 1/2`.
    pub(super) fn slice(generator: &Generator, depth: f64) -> (Self, i32) {
        let m = generator.matrix();
        let doublings = (2.0 * depth * m.norm()).log2().ceil().max(0.0);
        // at most 2000 for the largest finite arguments
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a logarithm of a finite number"
        )]
        let doublings = doublings as i32;
        let h = depth * 0.5f64.powi(doublings);
        let transfer = exponential(&(m * (-Complex64::I * h)));
        let block = |r, c| transfer.fixed_view::<2, 2>(r, c).into_owned();
        let (aa, ab, ba, bb) = (block(0, 0), block(0, 2), block(2, 0), block(2, 2));
        // |bb − 1| < 0.65: never singular
        let inverse = bb.try_inverse().unwrap_or_else(Matrix2::zeros);
        let slice = Self {
            reflection: -inverse * ba,
            transmission: aa - ab * inverse * ba,
            back_reflection: ab * inverse,
            back_transmission: inverse,
        };
        (slice, doublings)
    }

    /// The nearest unitary matrix, to second order: what rounding has added to a lossless layer is taken off.
    fn made_unitary(&self) -> Self {
        let s = self.matrix();
        let three = Matrix4::identity() * Complex64::from(3.0);
        let s = (s * (three - s.adjoint() * s)).scale(0.5);
        Self::from_blocks(&s)
    }

    /// The nearest contraction: what rounding has added to an absorbing layer, and doubling would make a gain, is
    /// taken off.
    fn made_passive(&self) -> Self {
        let s = self.matrix();
        let power = s.adjoint() * s;
        // Gershgorin: most absorbing layers need no eigenvalues
        let bound = (0..4).map(|row| power.row(row).iter().map(|c| c.norm()).sum::<f64>());
        if bound.fold(0.0, f64::max) <= 1.0 {
            return *self;
        }
        let eigen = SymmetricEigen::new(power);
        let excess = eigen
            .eigenvalues
            .map(|x| Complex64::from(1.0 - x.max(1.0).sqrt().recip()));
        let vectors = eigen.eigenvectors;
        // as a difference, which leaves alone what has no excess
        let gain = vectors * Matrix4::from_diagonal(&excess) * vectors.adjoint();
        Self::from_blocks(&(s - s * gain))
    }

    /// From the matrix that gives `(b_front, a_back)` from `(a_front, b_back)`.
    pub(super) fn from_blocks(s: &Matrix4<Complex64>) -> Self {
        let block = |r, c| s.fixed_view::<2, 2>(r, c).into_owned();
        Self {
            reflection: block(0, 0),
            back_transmission: block(0, 2),
            transmission: block(2, 0),
            back_reflection: block(2, 2),
        }
    }

    /// `(b_front, a_back)` from `(a_front, b_back)`.
    fn matrix(&self) -> Matrix4<Complex64> {
        joined(
            &self.reflection,
            &self.back_transmission,
            &self.transmission,
            &self.back_reflection,
        )
    }
}

/// `[[xx, xy], [yx, yy]]`
pub(super) fn joined(
    xx: &Matrix2<Complex64>,
    xy: &Matrix2<Complex64>,
    yx: &Matrix2<Complex64>,
    yy: &Matrix2<Complex64>,
) -> Matrix4<Complex64> {
    Matrix4::from_fn(|row, column| {
        let block = match (row < 2, column < 2) {
            (true, true) => xx,
            (true, false) => xy,
            (false, true) => yx,
            (false, false) => yy,
        };
        block[(row % 2, column % 2)]
    })
}

/// `e^x` of a matrix of norm at most 1/2, by its series.
fn exponential(x: &Matrix4<Complex64>) -> Matrix4<Complex64> {
    // 0.5^16/16! = 7e-19; summed from the smallest term
    let one = Matrix4::identity();
    let mut sum = one;
    for n in (1..=15).rev() {
        sum = one + (x * sum).unscale(f64::from(n));
    }
    sum
}
