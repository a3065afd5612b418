//! The factors of Theorem S4.1 by themselves: the lobe that an autocorrelation has for a series of incident modes, and
//! the map from the surface to the light by which the two meet.

use nalgebra::{Matrix2, Vector2};
use stokes::{Frame, HermiteSeries, ShapeMatrix, plane};

use crate::autocorrelation::Autocorrelation;
use crate::geometry::Geometry;
use crate::incident::incident_map;
use crate::kernel::Request;
use crate::theorem::{InteractionError, integrate};

impl Geometry {
    /// `B = (n_i k₀/s) E T`, which takes a separation in the surface, in the axes of the tangents, to the far-field
    /// argument of light that comes from `distance` metres with the transverse axes of `incident`; 2×2, 1/m².
    ///
    /// Infinite for a distance of 0.
    ///
    /// Source: the argument `(k/s) Q' r'` of Theorem S4.1 (i), restricted to the surface.
    ///
    /// ```
    /// use mueller16::Geometry;
    /// use nalgebra::Vector3;
    /// use stokes::{Frame, Wavelength};
    /// let green = Wavelength::from_metres(550e-9)?;
    /// let (sin, cos) = 60f64.to_radians().sin_cos();
    /// let mirror = Geometry::on_plane(Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos), green)?;
    /// let frame = Frame::with_x_across(-mirror.to_source(), Vector3::z())?;
    /// let b = mirror.incident_map(&frame, 2.0);
    /// // p is foreshortened by cos 60°, s is not: k/s = 5.712e6 per m²
    /// assert!((b.m21.abs() - 0.5 * b.m12.abs()).abs() < 1e-9);
    /// assert!((b.m12.abs() - 5.711_986e6).abs() < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn incident_map(&self, incident: &Frame, distance: f64) -> Matrix2<f64> {
        incident_map([incident.x(), incident.y()], self, distance)
    }
}

impl Autocorrelation {
    /// `F{R Σ c_ab φ_ab(B·; W)}(φ)`: the lobe that this autocorrelation has for incident light of these modes. Real; the
    /// unit of the series times that of `|det W|^(1/2)` times m².
    ///
    /// `shape` is that of the light, `map` is `B` ([`Geometry::incident_map`]), `phi` the tangential wave vector in rad/m.
    /// With [`HermiteSeries`] of one real coefficient 1 it is `i^(a+b) F{R φ_ab(B·; W)}(φ)`.
    ///
    /// Source: the integral of Theorem S4.1 (i).
    ///
    /// Error: `order·ε` of the lobe's largest value times the norm of the series, and what rounding of the inputs moves.
    ///
    /// # Errors
    ///
    /// When a term that does not decay meets a singular map: the lobe is a delta.
    ///
    /// ```
    /// use mueller16::Autocorrelation;
    /// use nalgebra::{Matrix2, Vector2};
    /// use stokes::{HermiteSeries, ShapeMatrix};
    /// // R = e^(−x²/2), light e^(−x²/2)/√π: the product's variance is 1/2, its transform π e^(−φ²/4)/√π
    /// let rough = Autocorrelation::gaussian(&Matrix2::identity())?;
    /// let light = HermiteSeries::fundamental(1.0);
    /// let unit = ShapeMatrix::isotropic(1.0)?;
    /// let lobe = rough.lobe_for(&unit, &Matrix2::identity(), &light, &Vector2::new(2.0, 0.0))?;
    /// assert!((lobe - 0.652_049_332_173_292_2).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn lobe_for(
        &self,
        shape: &ShapeMatrix,
        map: &Matrix2<f64>,
        series: &HermiteSeries,
        phi: &Vector2<f64>,
    ) -> Result<f64, InteractionError> {
        let root = plane::product(shape.root(), map);
        // better than that of the product, whose entries are rounded
        let determinant = plane::determinant(shape.root()) * plane::determinant(map);
        let request = Request::new([Some(series)], None);
        let [sum] = integrate::<f64, 1>(self, (&root, determinant), phi, &request)?;
        Ok(sum * shape.root_determinant().sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GaussianTerm;
    use num_complex::Complex64;

    /// `∫ R(x) f(Bx) e^(−iφ·x) d²x` by the trapezoidal rule, R and f from their own values.
    fn quadrature(
        r: &Autocorrelation,
        shape: &ShapeMatrix,
        map: &Matrix2<f64>,
        series: &HermiteSeries,
        phi: &Vector2<f64>,
    ) -> Complex64 {
        let (half, step) = (200_i32, 0.06);
        let mut sum = Complex64::ZERO;
        for i in -half..=half {
            for j in -half..=half {
                let x = Vector2::new(f64::from(i), f64::from(j)) * step;
                sum += r.value(&x) * series.value(shape, &(map * x)) * Complex64::cis(-phi.dot(&x));
            }
        }
        sum * step * step
    }

    #[test]
    fn lobes_of_blazed_matter_under_any_series_are_fourier_integrals() {
        let root = Matrix2::new(1.3, -0.3, 0.2, 0.9);
        let terms = [(0.7, 1.0, [0.4, -1.1]), (0.4, 2.5, [-0.8, 0.3])];
        let r = Autocorrelation::of_family(
            &root,
            terms.map(|(weight, rate, [x, y])| GaussianTerm {
                weight,
                rate,
                shift: Vector2::new(x, y),
            }),
        )
        .unwrap();
        let shape = ShapeMatrix::from_root(&Matrix2::new(0.6, 0.2, -0.3, 1.1)).unwrap();
        // a mirrored map: det B < 0
        let map = Matrix2::new(0.5, 0.9, 0.8, -0.4);
        let series = [1.0, 0.3, -0.2, 0.4, -0.1, 0.25, 0.2, -0.3, 0.1, 0.15];
        let series = HermiteSeries::from_real_coefficients(&series).unwrap();
        for phi in [[0.0, 0.0], [0.7, -0.4], [-1.5, 1.2]] {
            let phi = Vector2::from(phi);
            let found = r.lobe_for(&shape, &map, &series, &phi).unwrap();
            let expected = quadrature(&r, &shape, &map, &series, &phi);
            // the rule's own error is below e^(−2π²/(h² λ)) with a largest curvature λ of 5, and e^(−40) beyond the grid; 160,801 roundings of numbers
            // whose moduli add up to less than 20
            assert!((expected - found).norm() < 1e-13, "{found} {expected}");
        }
    }

    #[test]
    fn a_mirror_has_no_lobe_for_light_without_width() {
        let mirror = Autocorrelation::constant(1.0);
        let unit = ShapeMatrix::isotropic(1.0).unwrap();
        let light = HermiteSeries::fundamental(1.0);
        let edge_on = Matrix2::new(1.0, 0.0, 0.0, 0.0);
        let found = mirror.lobe_for(&unit, &edge_on, &light, &Vector2::zeros());
        assert_eq!(found, Err(InteractionError::Delta { determinant: 0.0 }));
    }
}
