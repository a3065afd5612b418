//! Lu and Chipman's polar decomposition of a Mueller matrix: a diattenuator, then a retarder, then a depolarizer.

use nalgebra::{Matrix3, Matrix4, Vector3};
use stokes::Mueller;
use thiserror::Error;

use super::not_finite;
use super::rotation3::{least_rotation, rotation_vector};
use super::svd3::Svd3;

/// Roundings up to which a number counts as zero.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Why a Mueller matrix has no polar decomposition.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum NoPolarDecomposition {
    /// An element is infinite or not a number.
    #[error("polar decomposition: element ({row}, {column}) is {value}, expected a finite number")]
    NotFinite {
        /// Row of the element, from 0.
        row: usize,
        /// Column of the element, from 0.
        column: usize,
        /// What was found.
        value: f64,
    },
    /// Nothing is transmitted, or less.
    #[error("polar decomposition: M00 is {transmittance}, expected a positive transmittance")]
    NoTransmittance {
        /// `M00`.
        transmittance: f64,
    },
    /// Some light would leave with negative intensity.
    #[error(
        "polar decomposition: the diattenuation is {diattenuation}, expected at most 1: light of the opposite \
         polarization would leave with negative intensity"
    )]
    Diattenuation {
        /// `|D|`.
        diattenuation: f64,
    },
}

/// A Mueller matrix as the product `transmittance · depolarizer · retarder · diattenuator`, the right factor met first.
///
/// ```text
/// M = M00 M_Δ M_R M_D,    D = (M01, M02, M03)/M00,   P = (M10, M20, M30)/M00,   a = √(1 − |D|²)
/// M_D = [1  Dᵀ; D  m_D],  m_D = a 1 + (1 − a) D̂ D̂ᵀ
/// M_Δ = [1  0ᵀ; P_Δ m_Δ], P_Δ = (P − m D)/a²         M_Δ M_R = M M_D⁻¹/M00
/// m_Δ m_R = m' = U Σ Vᵀ:  m_Δ = ±U Σ Uᵀ, m_R = ±U Vᵀ, the sign that of det m'
/// ```
///
/// Where that leaves a choice:
///
/// - **det m' < 0**: all three depolarization factors are negative, as in the paper.
/// - **det m' = 0**, one vanishing factor: they are not negative, and `m_R` is the rotation that the other two fix. Two
///   vanishing factors: the least rotation that takes the one input axis to its output axis. Three: the identity.
/// - **|D| = 1**, a polarizer: `M = M00 (1, P)(1, D)ᵀ`. `m_R` is the least rotation that takes `D` to the direction of
///   `P`, `P_Δ = 0` and `m_Δ = |P| 1`.
///
/// Factors count as vanishing below 64 roundings over `a²`, and `|D|` counts as 1 where `1 − |D|² < 64` roundings: an
/// `a` below 1e-7 is not in the first row to be found, and the product then misses terms of that size.
///
/// Source: Lu & Chipman 1996, Interpretation of Mueller matrices based on polar decomposition, J. Opt. Soc. Am. A 13,
/// 1106.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarDecomposition {
    /// `M00`, the transmittance for unpolarized light.
    pub transmittance: f64,
    /// `M_D`, with element (0, 0) equal to 1.
    pub diattenuator: Mueller,
    /// `M_R`, a rotation of the Poincaré sphere.
    pub retarder: Mueller,
    /// `M_Δ`, with element (0, 0) equal to 1 and no diattenuation.
    pub depolarizer: Mueller,
}

impl PolarDecomposition {
    /// Decomposes a Mueller matrix.
    ///
    /// The product of the factors is the matrix to a few `f64::EPSILON` over `a = √(1 − |D|²)`; the depolarizer by itself has
    /// an error of a few over `a²`.
    ///
    /// # Errors
    ///
    /// When an element is not finite, `M00` is not positive, or the diattenuation exceeds 1 by more than 64 roundings.
    pub fn of(mueller: &Mueller) -> Result<Self, NoPolarDecomposition> {
        let whole = mueller.to_matrix();
        if let Some((row, column, value)) = not_finite(&whole) {
            return Err(NoPolarDecomposition::NotFinite { row, column, value });
        }
        let transmittance = whole[(0, 0)];
        if transmittance <= 0.0 {
            return Err(NoPolarDecomposition::NoTransmittance { transmittance });
        }
        let whole = whole / transmittance;
        let d = whole.fixed_view::<1, 3>(0, 1).transpose();
        let p = whole.fixed_view::<3, 1>(1, 0).into_owned();
        let m = whole.fixed_view::<3, 3>(1, 1).into_owned();
        let diattenuation = d.norm();
        if diattenuation > 1.0 + ROUNDING {
            return Err(NoPolarDecomposition::Diattenuation { diattenuation });
        }
        let passed = (1.0 - diattenuation) * (1.0 + diattenuation);
        let (m_delta, p_delta, m_r) = if passed < ROUNDING {
            behind_a_polarizer(&(d / diattenuation), &p)
        } else {
            behind_a_diattenuator(&d, passed, &p, &m)
        };
        Ok(Self {
            transmittance,
            diattenuator: assembled(&d, &d, &diattenuator_block(&d, passed.max(0.0))),
            retarder: assembled(&Vector3::zeros(), &Vector3::zeros(), &m_r),
            depolarizer: assembled(&Vector3::zeros(), &p_delta, &m_delta),
        })
    }

    /// The product of the factors: the matrix that was decomposed.
    #[must_use]
    pub fn product(&self) -> Mueller {
        self.depolarizer * self.retarder * self.diattenuator * self.transmittance
    }

    /// Diattenuation vector `D = (M01, M02, M03)/M00`, of length at most 1: the Stokes direction of the best transmitted
    /// light.
    #[must_use]
    pub fn diattenuation(&self) -> [f64; 3] {
        [1, 2, 3].map(|i| self.diattenuator.element(0, i))
    }

    /// Polarizance vector of the depolarizer, `P_Δ`: what it makes of unpolarized light.
    #[must_use]
    pub fn polarizance(&self) -> [f64; 3] {
        [1, 2, 3].map(|i| self.depolarizer.element(i, 0))
    }

    /// Retardance vector: the Stokes direction of the fast eigenpolarization times the retardance δ, radians, of length in
    /// `0.0..=π`.
    ///
    /// Error of a few `f64::EPSILON`, its direction included unless δ is tiny; at δ = π the two eigenpolarizations are
    /// fast alike and one is chosen.
    ///
    /// ```
    /// let plate = csdm::JonesMatrix::linear_retarder(1.2).mueller();
    /// let [x, y, z] = csdm::PolarDecomposition::of(&plate)?.retardance();
    /// assert!((x - 1.2).abs() < 1e-15 && y == 0.0 && z == 0.0);
    /// # Ok::<(), csdm::NoPolarDecomposition>(())
    /// ```
    #[must_use]
    pub fn retardance(&self) -> [f64; 3] {
        let whole = self.retarder.to_matrix();
        let m = whole.fixed_view::<3, 3>(1, 1).into_owned();
        // the sphere turns by −δ about the fast eigenpolarization
        (-rotation_vector(&m)).into()
    }

    /// Depolarization power `1 − |tr m_Δ|/3`: 0 for matter that does not depolarize, 1 for an ideal depolarizer.
    #[must_use]
    pub fn depolarization_power(&self) -> f64 {
        let m = self.depolarizer.to_matrix();
        1.0 - (m[(1, 1)] + m[(2, 2)] + m[(3, 3)]).abs() / 3.0
    }
}

/// `m_Δ`, `P_Δ` and `m_R` of a matrix with `|D| < 1`, `passed = 1 − |D|²`.
fn behind_a_diattenuator(
    d: &Vector3<f64>,
    passed: f64,
    p: &Vector3<f64>,
    m: &Matrix3<f64>,
) -> (Matrix3<f64>, Vector3<f64>, Matrix3<f64>) {
    let p_delta = (p - m * d) / passed;
    let rest = m - p_delta * d.transpose();
    // m_D⁻¹ = (1/a) 1 − (1/a − 1) D̂ D̂ᵀ, with 1/a − 1 = |D|²/(a (1 + a))
    let a = passed.sqrt();
    let inverse = Matrix3::identity() / a - d * d.transpose() / (a * (1.0 + a));
    let svd = Svd3::of(&(rest * inverse));
    let limit = ROUNDING / passed * svd.values[0].max(1.0);
    let rank = svd.values.iter().filter(|value| **value > limit).count();
    let (u, v) = (svd.u, svd.v);
    let m_r = match rank {
        0 => Matrix3::identity(),
        1 => least_rotation(&v.column(0).into_owned(), &u.column(0).into_owned()),
        2 => {
            let third = |of: &Matrix3<f64>| of.column(0).cross(&of.column(1));
            let close = |of: &Matrix3<f64>| {
                Matrix3::from_columns(&[
                    of.column(0).into_owned(),
                    of.column(1).into_owned(),
                    third(of),
                ])
            };
            close(&u) * close(&v).transpose()
        }
        _ => {
            let m_r = u * v.transpose();
            m_r * m_r.determinant().signum()
        }
    };
    let sign = if rank == 3 {
        (u * v.transpose()).determinant().signum()
    } else {
        1.0
    };
    let m_delta = u * Matrix3::from_diagonal(&svd.values) * u.transpose() * sign;
    (m_delta, p_delta, m_r)
}

/// `m_Δ`, `P_Δ` and `m_R` of a polarizer along the unit vector `d` that sends out light of polarization `p`.
fn behind_a_polarizer(
    d: &Vector3<f64>,
    p: &Vector3<f64>,
) -> (Matrix3<f64>, Vector3<f64>, Matrix3<f64>) {
    let degree = p.norm();
    let m_r = if degree > ROUNDING {
        least_rotation(d, &(p / degree))
    } else {
        Matrix3::identity()
    };
    (Matrix3::identity() * degree, Vector3::zeros(), m_r)
}

/// `a 1 + (1 − a) D̂ D̂ᵀ = a 1 + D Dᵀ/(1 + a)`, with `a² = passed`.
fn diattenuator_block(d: &Vector3<f64>, passed: f64) -> Matrix3<f64> {
    let a = passed.sqrt();
    Matrix3::identity() * a + d * d.transpose() / (1.0 + a)
}

/// `[1 rowᵀ; column block]`.
fn assembled(row: &Vector3<f64>, column: &Vector3<f64>, block: &Matrix3<f64>) -> Mueller {
    let mut matrix = Matrix4::identity();
    matrix
        .fixed_view_mut::<1, 3>(0, 1)
        .copy_from(&row.transpose());
    matrix.fixed_view_mut::<3, 1>(1, 0).copy_from(column);
    matrix.fixed_view_mut::<3, 3>(1, 1).copy_from(block);
    Mueller::from(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jones::JonesMatrix;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn close(a: Mueller, b: Mueller, tolerance: f64) -> bool {
        (a.to_matrix() - b.to_matrix()).amax() < tolerance
    }

    fn depolarizer(p: Vector3<f64>, block: Matrix3<f64>) -> Mueller {
        assembled(&Vector3::zeros(), &p, &block)
    }

    fn diagonal(factors: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(factors))
    }

    #[test]
    fn the_retardance_vector_points_to_the_fast_eigenpolarization() {
        let find = |jones: JonesMatrix| {
            let found = PolarDecomposition::of(&jones.mueller()).unwrap();
            Vector3::from(found.retardance())
        };
        let near = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-14;
        let quarter = JonesMatrix::quarter_wave_plate();
        assert!(near(find(quarter), Vector3::x() * FRAC_PI_2));
        assert!(near(
            find(quarter.rotated(FRAC_PI_4)),
            Vector3::y() * FRAC_PI_2
        ));
        assert!(near(
            find(JonesMatrix::circular_retarder(0.4)),
            Vector3::z() * 0.4
        ));
        assert!(near(find(JonesMatrix::identity()), Vector3::zeros()));
        let half = find(JonesMatrix::half_wave_plate());
        assert!((half.x.abs() - PI).abs() < 1e-14 && half.yz().norm() < 1e-14);
    }

    #[test]
    fn a_polarizer_with_a_rotator_behind_it_is_found() {
        let element = JonesMatrix::rotator(0.3) * JonesMatrix::elliptical_polarizer(0.2, 0.1);
        let found = PolarDecomposition::of(&element.mueller()).unwrap();
        assert!(close(found.product(), element.mueller(), 1e-14));
        assert!(found.depolarization_power().abs() < 1e-14);
        // from D to P, at the latitude 2χ: not about the poles, but the shortest way
        let d = Vector3::from(found.diattenuation());
        assert!((d.norm() - 1.0).abs() < 1e-14);
        let angle = Vector3::from(found.retardance()).norm();
        let chord = 2.0 * 0.2f64.cos() * 0.3f64.sin();
        assert!((2.0 * (0.5 * angle).sin() - chord).abs() < 1e-14);
    }

    #[test]
    fn a_polarizer_before_a_depolarizer_is_found() {
        let polarizer = JonesMatrix::linear_polarizer().mueller();
        for degree in [0.4, 0.0] {
            let mueller = depolarizer(Vector3::zeros(), diagonal([degree; 3])) * polarizer;
            let found = PolarDecomposition::of(&mueller).unwrap();
            assert!(close(found.product(), mueller, 1e-15));
            assert!((found.depolarization_power() - (1.0 - degree)).abs() < 1e-15);
        }
    }

    #[test]
    fn crossed_polarizing_states_are_half_a_turn_apart() {
        // passes x, sends out y
        let flip = JonesMatrix::rotator(FRAC_PI_2) * JonesMatrix::linear_polarizer();
        let found = PolarDecomposition::of(&flip.mueller()).unwrap();
        assert!(close(found.product(), flip.mueller(), 1e-15));
        let turn = found
            .retarder
            .to_matrix()
            .fixed_view::<3, 3>(1, 1)
            .into_owned();
        assert!((turn.determinant() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_best_reversal_of_the_sphere_is_a_depolarizer_of_negative_factors() {
        // diag(1, −⅓, −⅓, −⅓): realizable, det m' < 0
        let mueller = depolarizer(Vector3::zeros(), diagonal([-1.0 / 3.0; 3]));
        let found = PolarDecomposition::of(&mueller).unwrap();
        assert!(close(found.product(), mueller, 1e-15));
        assert!(close(found.retarder, Mueller::identity(), 1e-15));
        assert!((found.depolarization_power() - 2.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn vanishing_factors_leave_a_rotation() {
        let plate = JonesMatrix::elliptical_retarder(0.4, 0.2, 0.8).mueller();
        for factors in [[0.5, 0.3, 0.0], [0.5, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 0.7]] {
            let mueller = depolarizer(Vector3::new(0.1, 0.0, 0.2), diagonal(factors)) * plate;
            let found = PolarDecomposition::of(&mueller).unwrap();
            assert!(close(found.product(), mueller, 1e-15));
            let turn = found.retarder.to_matrix();
            assert!((turn.transpose() * turn - Matrix4::identity()).amax() < 1e-14);
            assert!((turn.determinant() - 1.0).abs() < 1e-14);
            if factors[1] > 0.0 {
                assert!(close(found.retarder, plate, 1e-14));
            }
        }
    }

    #[test]
    fn the_product_is_the_matrix_up_to_the_perfect_polarizer() {
        for exponent in 0..40 {
            let ratio = 0.5f64.powi(exponent);
            let element = JonesMatrix::elliptical_retarder(0.4, 0.2, 0.8)
                * JonesMatrix::homogeneous(0.7, -0.3, 1.0.into(), ratio.into());
            let found = PolarDecomposition::of(&element.mueller()).unwrap();
            // a ≈ 2 ratio; from |D| = 1 to rounding on it is lost
            let lost = if ratio < 1e-7 {
                1.2e-7 + 2.0 * ratio
            } else {
                0.0
            };
            let error = (found.product().to_matrix() - element.mueller().to_matrix()).amax();
            assert!(
                error < 32.0 * f64::EPSILON / ratio + lost,
                "{ratio} {error}"
            );
        }
    }

    #[test]
    fn what_transmits_nothing_or_less_is_refused_with_its_number() {
        assert_eq!(
            PolarDecomposition::of(&Mueller::depolarizer(0.0)),
            Err(NoPolarDecomposition::NoTransmittance { transmittance: 0.0 })
        );
        let mut rows = [[0.0; 4]; 4];
        rows[0] = [1.0, 0.8, 0.8, 0.0];
        let error = PolarDecomposition::of(&Mueller::from_rows(rows)).unwrap_err();
        let NoPolarDecomposition::Diattenuation { diattenuation } = error else {
            panic!("{error}");
        };
        assert!((diattenuation - 1.28f64.sqrt()).abs() < 1e-15);
    }
}
