//! The waves that run forward and the waves that run backward in a medium, as two subspaces.
//!
//! Forward waves are those that carry power along +z, or decay along +z. In the waves `(a, b)` of [`Generator`] they
//! form a graph `b = R a` with |R| ≤ 1, because `|a|² ≥ |b|²` for all their sums, and R is the reflection matrix of the
//! half-space filled with the medium. It solves
//!
//! ```text
//! M_ba + M_bb R − R M_aa − R M_ab R = 0,          a' = −i k₀ A a,   A = M_aa + M_ab R
//! ```
//!
//! and is found by Newton's method from the reflection of a similar isotropic medium or, where that does not lead to it,
//! of a very thick and slightly lossy layer, which picks the right one of the solutions. Single eigenvectors are never needed: equal indices (isotropic matter, light along an optic
//! axis, where eigenvectors are arbitrary) and singular axes of absorbing crystals (where there is one eigenvector
//! for two waves) are no special cases. Accuracy is lost only where a forward wave meets a backward one, at the
//! critical angle inside the medium: error `√f64::EPSILON` there.

use nalgebra::{ComplexField, Matrix2, Matrix4, Vector2, Vector4};
use num_complex::Complex64;

use super::crystal::Crystal;
use super::generator::Generator;
use super::scattering::Scattering;

const I: Complex64 = Complex64::I;

/// Waves of a half-space in the waves `(a, b)`: columns of `[a_forward; b_forward]` and `[a_backward; b_backward]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace<T = Complex64> {
    pub(super) a_forward: Matrix2<T>,
    pub(super) b_forward: Matrix2<T>,
    pub(super) a_backward: Matrix2<T>,
    pub(super) b_backward: Matrix2<T>,
}

/// The two directions of travel in a medium, and how the amplitudes of each change with depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    pub(super) waves: HalfSpace,
    /// A in `a' = −i k₀ A a` of the forward waves.
    pub(super) forward: Matrix2<Complex64>,
    /// The same for the backward waves' b.
    pub(super) backward: Matrix2<Complex64>,
}

impl HalfSpace {
    /// The s and p waves of an isotropic medium of index n, `w = n cos θ`: amplitudes of electric fields.
    ///
    /// ```text
    /// forward:  s: u = (1, 0), v = (w, 0)     p: u = (0, w/n),  v = (0, n)
    /// backward: s: u = (1, 0), v = (−w, 0)    p: u = (0, −w/n), v = (0, n)
    /// ```
    pub(super) fn isotropic(n: Complex64, w: Complex64) -> Self {
        let cos = w / n;
        let half = Complex64::from(std::f64::consts::FRAC_1_SQRT_2);
        let diagonal =
            |s: Complex64, p: Complex64| Matrix2::from_diagonal(&Vector2::new(s, p)) * half;
        Self {
            a_forward: diagonal(1.0 + w, cos + n),
            b_forward: diagonal(1.0 - w, cos - n),
            a_backward: diagonal(1.0 - w, n - cos),
            b_backward: diagonal(1.0 + w, -n - cos),
        }
    }
}

impl HalfSpace {
    /// The waves of the isotropic medium that the crystal most resembles, as `a_forward = b_backward = 1`.
    fn near(crystal: &Crystal, xi: f64) -> Self {
        let square = crystal.permittivity().trace() / 3.0;
        let (n, w) = (square.sqrt(), (square - xi * xi).sqrt());
        Self::isotropic(n, w).as_graphs().unwrap_or_else(|| {
            let (zero, one) = (Matrix2::zeros(), Matrix2::identity());
            Self {
                a_forward: one,
                b_forward: zero,
                a_backward: zero,
                b_backward: one,
            }
        })
    }

    /// The same waves where all of them propagate in a medium that neither absorbs nor turns light.
    pub(super) fn as_real(&self) -> Option<HalfSpace<f64>> {
        let matrices = [
            &self.a_forward,
            &self.b_forward,
            &self.a_backward,
            &self.b_backward,
        ];
        let [a_forward, b_forward, a_backward, b_backward] =
            matrices.map(|m| m.iter().all(|c| c.im == 0.0).then(|| m.map(|c| c.re)));
        Some(HalfSpace {
            a_forward: a_forward?,
            b_forward: b_forward?,
            a_backward: a_backward?,
            b_backward: b_backward?,
        })
    }
}

impl<T: ComplexField + Copy> HalfSpace<T> {
    /// The same waves in other sums: `a_forward = b_backward = 1`.
    pub(super) fn as_graphs(&self) -> Option<Self> {
        let one = Matrix2::identity();
        Some(Self {
            a_forward: one,
            b_forward: self.b_forward * self.a_forward.try_inverse()?,
            a_backward: self.a_backward * self.b_backward.try_inverse()?,
            b_backward: one,
        })
    }
}

impl Directions {
    /// The forward and backward waves of a crystal at tangential index ξ.
    pub(super) fn new(crystal: &Crystal, xi: f64, azimuth: f64) -> Self {
        Self::of_uniaxial(crystal, xi, azimuth)
            .or_else(|| Self::of_clear(crystal, xi, azimuth))
            .unwrap_or_else(|| Self::of_any(crystal, xi, azimuth))
    }

    /// The same for any crystal.
    pub(super) fn of_any(crystal: &Crystal, xi: f64, azimuth: f64) -> Self {
        let generator = Generator::new(crystal, xi, azimuth);
        let Generator { aa, ab, ba, bb, .. } = generator;
        let near = HalfSpace::near(crystal, xi);
        let forward = graph_near(near.b_forward, &aa, &ab, &ba, &bb);
        let backward = graph_near(near.a_backward, &bb, &ba, &ab, &aa);
        let (forward, backward) = match (forward, backward) {
            (Some(forward), Some(backward)) => (forward, backward),
            _ => {
                const LOSS: f64 = 1e-3;
                let start = very_thick(&Generator::with_loss(crystal, xi, azimuth, LOSS));
                (
                    invariant_graph(start.reflection, &aa, &ab, &ba, &bb),
                    invariant_graph(start.back_reflection, &bb, &ba, &ab, &aa),
                )
            }
        };
        let one = Matrix2::identity();
        Self {
            waves: HalfSpace {
                a_forward: one,
                b_forward: forward,
                a_backward: backward,
                b_backward: one,
            },
            forward: aa + ab * forward,
            backward: bb + ba * backward,
        }
    }

    /// What a layer of `depth` radians does to its own waves, which it does not reflect.
    pub(super) fn propagation(&self, depth: f64) -> Scattering<Complex64, 2> {
        Scattering {
            transmission: decaying_exponential(&self.forward, depth),
            back_transmission: decaying_exponential(&-self.backward, depth),
            ..Scattering::transparent()
        }
    }
}

/// The reflection of a layer so thick that its back does not matter.
fn very_thick(generator: &Generator) -> Scattering<Complex64, 2> {
    let (mut layer, _) = Scattering::slice(generator, 1.0);
    for _ in 0..100 {
        layer = layer.then(&layer);
        if layer.transmission.norm() < 1e-9 {
            break;
        }
    }
    layer
}

/// R of the module page by Newton's method from the R of a similar medium, where it finds one with |R| < 1.
///
/// All waves of such an R carry power forward, in passive matter more than they do further on: it is the right one.
/// Evanescent waves carry none.
pub(super) fn graph_near<T: ComplexField<RealField = f64> + Copy>(
    start: Matrix2<T>,
    aa: &Matrix2<T>,
    ab: &Matrix2<T>,
    ba: &Matrix2<T>,
    bb: &Matrix2<T>,
) -> Option<Matrix2<T>> {
    const LEAST_FLUX: f64 = 1e-3;
    let one = Matrix2::identity();
    let mut r = start;
    for _ in 0..12 {
        let (left, right) = (bb - r * ab, aa + ab * r);
        let c = r * right - ba - bb * r;
        // left X − X right = C, by the characteristic polynomial of `right`
        let (trace, determinant) = (right.trace(), right.determinant());
        let polynomial = left * (left - one * trace) + one * determinant;
        let step = polynomial.try_inverse()? * (left * c + c * right - c * trace);
        let size = step.norm();
        if !size.is_finite() {
            return None;
        }
        r += step;
        // the next step would be its square, times 1/LEAST_FLUX at most
        if size < 1e-10 {
            let flux = one - r.adjoint() * r;
            let sound = flux[(0, 0)].real() > LEAST_FLUX
                && flux[(1, 1)].real() > LEAST_FLUX
                && flux.determinant().real() > LEAST_FLUX * LEAST_FLUX;
            return sound.then_some(r);
        }
    }
    None
}

/// R of the module page by Newton's method from `start`.
fn invariant_graph(
    start: Matrix2<Complex64>,
    aa: &Matrix2<Complex64>,
    ab: &Matrix2<Complex64>,
    ba: &Matrix2<Complex64>,
    bb: &Matrix2<Complex64>,
) -> Matrix2<Complex64> {
    let mut r = start;
    let mut last = f64::INFINITY;
    for _ in 0..60 {
        let (left, right) = (bb - r * ab, aa + ab * r);
        let residual = ba + bb * r - r * right;
        // left X − X right = −residual
        let one = Matrix2::identity();
        let system: Matrix4<Complex64> = one.kronecker(&left) - right.transpose().kronecker(&one);
        let Some(step) = system
            .lu()
            .solve(&Vector4::from_column_slice(residual.as_slice()))
        else {
            break;
        };
        let size = step.norm();
        // quadratic, then as small as rounding allows
        if !size.is_finite() || (size < 1e-9 && size >= last) {
            break;
        }
        r -= Matrix2::from_column_slice(step.as_slice());
        last = size;
        if size < 1e-17 {
            break;
        }
    }
    r
}

/// `e^{−i A depth}` where the eigenvalues of A have no positive imaginary part but for rounding.
///
/// `f(A) = (f₊ + f₋)/2 + (f₊ − f₋)/(2s) (A − m)` with the eigenvalues `m ± s`; also right where s = 0.
fn decaying_exponential(a: &Matrix2<Complex64>, depth: f64) -> Matrix2<Complex64> {
    let (m, s) = eigenvalues(a);
    if m.im == 0.0 && s.im == 0.0 {
        // nothing decays
        let (sin, cos) = (s.re * depth).sin_cos();
        let sinc = if s.re * depth == 0.0 {
            depth
        } else {
            sin / s.re
        };
        let one = Matrix2::identity();
        let turned = one * Complex64::from(cos) - (a - one * m) * (I * sinc);
        return turned * Complex64::cis(-m.re * depth);
    }
    // absorption below the rounding of A is none
    let rounding = 4.0 * f64::EPSILON * a.norm();
    let f = |lambda: Complex64| {
        let im = if lambda.im < -rounding {
            lambda.im
        } else {
            0.0
        };
        (-I * Complex64::new(lambda.re, im) * depth).exp()
    };
    let (plus, minus) = (f(m + s), f(m - s));
    let turn = s * depth;
    let slope = if turn.norm() > 0.5 {
        (plus - minus) / (2.0 * s)
    } else {
        let sinc = if turn == Complex64::ZERO {
            Complex64::ONE
        } else {
            turn.sin() / turn
        };
        -I * depth * f(m) * sinc
    };
    let one = Matrix2::identity();
    one * (0.5 * (plus + minus)) + (a - one * m) * slope
}

/// Mean m and half difference s of the eigenvalues `m ± s`.
pub(super) fn eigenvalues(a: &Matrix2<Complex64>) -> (Complex64, Complex64) {
    let half = 0.5 * (a[(0, 0)] - a[(1, 1)]);
    let mean = 0.5 * (a[(0, 0)] + a[(1, 1)]);
    (mean, (half * half + a[(0, 1)] * a[(1, 0)]).sqrt())
}
