//! Maxwell's equations in a homogeneous layer for one tangential wave vector: a constant 4×4 matrix.
//!
//! Frame of incidence: x along s, z the normal, tangential wave vector `k₀ ξ` along y. With `h = c μ₀ H` the tangential
//! fields `u = (E_x, E_y)`, `v = (h_y, −h_x)` carry the power `½ Re u·v*` along z. They are written as the waves
//!
//! ```text
//! a = (u + v)/√2,   b = (u − v)/√2,        |a|² − |b|² = 2 Re u·v*        d/dz (a, b) = −i k₀ M (a, b)
//! ```
//!
//! which are plane waves of vacuum at normal incidence, to and fro. Whatever is passive reflects and transmits them with a
//! contraction, whatever is lossless with a unitary matrix.
//!
//! Source: Berreman, J. Opt. Soc. Am. 62, 502 (1972), for the elimination of the normal fields.

use nalgebra::{Matrix2, Matrix2x4, Matrix3, Matrix4, Matrix6, RowVector4, Vector3, Vector4};
use num_complex::Complex64;

use super::crystal::Crystal;
use super::scattering::joined;

const I: Complex64 = Complex64::I;

/// The equations of one medium at one tangential wave vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Generator {
    /// M of the module page: `[[aa, ab], [ba, bb]]`.
    pub(super) aa: Matrix2<Complex64>,
    pub(super) ab: Matrix2<Complex64>,
    pub(super) ba: Matrix2<Complex64>,
    pub(super) bb: Matrix2<Complex64>,
    /// `(E_z, h_z)` from `(E_x, E_y, h_x, h_y)`.
    normal: Matrix2x4<Complex64>,
}

impl Generator {
    /// The equations in `crystal` for the tangential index ξ, the s axis turned by `azimuth` from the plate's x axis.
    pub(super) fn new(crystal: &Crystal, xi: f64, azimuth: f64) -> Self {
        Self::with_loss(crystal, xi, azimuth, 0.0)
    }

    /// The same with the permittivity and permeability made lossy by `loss` times their size.
    pub(super) fn with_loss(crystal: &Crystal, xi: f64, azimuth: f64, loss: f64) -> Self {
        let seen = crystal.turned(-azimuth);
        let size = seen.permittivity().norm();
        let epsilon = seen.permittivity() - Matrix3::identity() * (I * loss * size);
        let coupling = seen.coupling().map(|k| I * k);
        let mu = Matrix3::identity() * (Complex64::ONE - I * loss);
        // (d, b) from (E, h)
        let mut matter = Matrix6::zeros();
        matter.fixed_view_mut::<3, 3>(0, 0).copy_from(&epsilon);
        matter.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling);
        matter.fixed_view_mut::<3, 3>(3, 0).copy_from(&-coupling);
        matter.fixed_view_mut::<3, 3>(3, 3).copy_from(&mu);
        Self::from_matter(&matter, xi)
    }

    /// From κ×E = b, κ×h = −d with κ = (0, ξ, q): four equations for q, and d_z = ξ h_x, b_z = −ξ E_x.
    fn from_matter(matter: &Matrix6<Complex64>, xi: f64) -> Self {
        const TANGENTIAL: [usize; 4] = [0, 1, 3, 4];
        let mut source = Matrix2x4::zeros();
        for (column, field) in TANGENTIAL.into_iter().enumerate() {
            source[(0, column)] = -matter[(2, field)];
            source[(1, column)] = -matter[(5, field)];
        }
        source[(0, 2)] += xi;
        source[(1, 0)] -= xi;
        let normal = solve_normal(matter) * source;
        // row of d or b as a function of the tangential fields
        let row = |index: usize| {
            RowVector4::from_fn(|_, column| {
                matter[(index, TANGENTIAL[column])]
                    + matter[(index, 2)] * normal[(0, column)]
                    + matter[(index, 5)] * normal[(1, column)]
            })
        };
        let xi = Complex64::from(xi);
        // q (E_x, E_y, h_x, h_y) = (b_y, ξ E_z − b_x, −d_y, d_x + ξ h_z)
        let (ex, ey) = (row(4), normal.row(0) * xi - row(3));
        let (hx, hy) = (-row(1), row(0) + normal.row(1) * xi);
        let berreman = Matrix4::from_rows(&[ex, ey, hx, hy]);
        let change = waves_from_fields();
        // the change is orthogonal
        let m = change * berreman * change.transpose();
        let block = |r, c| m.fixed_view::<2, 2>(r, c).into_owned();
        Self {
            aa: block(0, 0),
            ab: block(0, 2),
            ba: block(2, 0),
            bb: block(2, 2),
            normal,
        }
    }

    /// M as one matrix.
    pub(super) fn matrix(&self) -> Matrix4<Complex64> {
        joined(&self.aa, &self.ab, &self.ba, &self.bb)
    }

    /// E and h, three components each, of the waves `(a, b)`.
    pub(super) fn fields(&self, waves: &Vector4<Complex64>) -> [Vector3<Complex64>; 2] {
        let tangential = waves_from_fields().transpose() * waves;
        let normal = self.normal * tangential;
        [
            Vector3::new(tangential[0], tangential[1], normal[0]),
            Vector3::new(tangential[2], tangential[3], normal[1]),
        ]
    }
}

/// The inverse of the 2×2 matrix that gives (d_z, b_z) from (E_z, h_z).
fn solve_normal(matter: &Matrix6<Complex64>) -> Matrix2<Complex64> {
    let (xx, xy) = (matter[(2, 2)], matter[(2, 5)]);
    let (yx, yy) = (matter[(5, 2)], matter[(5, 5)]);
    let mut determinant = xx * yy - xy * yx;
    // ε_zz = 0 exactly, possible where principal values have both signs, is the limit of a small loss
    let least = f64::EPSILON * matter.norm();
    if determinant.norm() < least {
        determinant = -I * least;
    }
    Matrix2::new(yy, -xy, -yx, xx) / determinant
}

/// `(a, b)` from `(E_x, E_y, h_x, h_y)`.
fn waves_from_fields() -> Matrix4<Complex64> {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    Matrix4::new(
        h, 0.0, 0.0, h, //
        0.0, h, -h, 0.0, //
        h, 0.0, 0.0, -h, //
        0.0, h, h, 0.0,
    )
    .map(Complex64::from)
}
