//! The two waves that a crystal refracts, their indices and rays.

use nalgebra::{Matrix2, Rotation3, Vector2, Vector3, Vector4};
use num_complex::Complex64;

use super::crystal::Crystal;
use super::generator::Generator;
use super::half_space::{Directions, eigenvalues};
use super::stack::Incidence;
use crate::layered::{FilmError, Medium, transparent_index};

/// A plane wave inside a crystal that runs, or decays, away from the face where the light enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefractedWave {
    /// Component of the wave vector along the normal over k₀, `n cos θ`; `Im ≤ 0`.
    pub normal_index: Complex64,
    /// Index of the wave for its own direction: length of the real wave vector over k₀.
    pub index: f64,
    /// Unit vector of the wave normal in plate axes.
    pub wave_normal: Vector3<f64>,
    /// Unit vector of the energy flow in plate axes, the ray.
    pub ray: Vector3<f64>,
}

impl Crystal {
    /// The two waves behind the face of this crystal, the one of larger `Re n cos θ` first.
    ///
    /// Where the two coincide their rays are those of one pair of polarizations out of many.
    ///
    /// Source: Born & Wolf, Principles of Optics, 7th ed., section 15.2; computed from Maxwell's equations in the layer.
    ///
    /// # Errors
    ///
    /// When `incident_index` is not between 1e-8 and 1e8.
    ///
    /// Calcite cleaved at 45° to its axis splits light at normal incidence by 6.2°:
    /// ```
    /// use csdm::birefringent::{Crystal, Incidence};
    /// use nalgebra::Vector3;
    /// let calcite = Crystal::uniaxial(1.6584.into(), 1.4864.into(), Vector3::new(0.0, 1.0, 1.0))?;
    /// let [ordinary, extraordinary] = calcite.refracted(1.0, &Incidence::new(1.0, 0.0)?)?;
    /// assert!(ordinary.ray.z == 1.0 && (ordinary.index - 1.6584).abs() < 1e-14);
    /// let walk_off = extraordinary.ray.z.acos().to_degrees();
    /// assert!((walk_off - 6.224).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn refracted(
        &self,
        incident_index: f64,
        incidence: &Incidence,
    ) -> Result<[RefractedWave; 2], FilmError> {
        let n1 = transparent_index(incident_index.into(), Medium::Incident)?;
        let xi = incidence.tangential_index(n1);
        let directions = Directions::new(self, xi, incidence.azimuth());
        let generator = Generator::new(self, xi, incidence.azimuth());
        let to_plate =
            Rotation3::from_axis_angle(&Vector3::z_axis(), incidence.azimuth()).into_inner();
        let (mean, half) = eigenvalues(&directions.forward);
        let half = if half.re < 0.0 { -half } else { half };
        Ok([half, -half].map(|offset| {
            let q = mean + offset;
            let a = eigenvector(&directions.forward, mean, offset);
            let b = directions.waves.b_forward * a;
            let [e, h] = generator.fields(&Vector4::new(a.x, a.y, b.x, b.y));
            let flux = e.cross(&h.map(|c| c.conj())).map(|c| c.re);
            let wave_vector = Vector3::new(0.0, xi, q.re);
            let index = wave_vector.norm();
            let wave_normal = to_plate * wave_vector.try_normalize(0.0).unwrap_or(Vector3::z());
            RefractedWave {
                normal_index: q,
                index,
                wave_normal,
                ray: (to_plate * flux).try_normalize(0.0).unwrap_or(wave_normal),
            }
        }))
    }
}

/// Eigenvector of A for the eigenvalue `mean + offset`; s or p where any vector is one.
fn eigenvector(a: &Matrix2<Complex64>, mean: Complex64, offset: Complex64) -> Vector2<Complex64> {
    let rest = a - Matrix2::identity() * (mean + offset);
    // the rows of A − λ are across the eigenvector
    let by_row = [0, 1].map(|row| Vector2::new(rest[(row, 1)], -rest[(row, 0)]));
    let larger = if by_row[0].norm() > by_row[1].norm() {
        by_row[0]
    } else {
        by_row[1]
    };
    // below rounding the direction is arbitrary: the axes of the frame
    if larger.norm() < 1e-14 * a.norm() {
        return if offset.re >= 0.0 && (offset.re > 0.0 || offset.im > 0.0) {
            Vector2::x().map(|c: f64| c.into())
        } else {
            Vector2::y().map(|c: f64| c.into())
        };
    }
    larger.unscale(larger.norm())
}
