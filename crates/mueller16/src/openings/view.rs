//! Openings seen from nearby: each with its own path and its own directions.

use csdm::JonesMatrix;
use nalgebra::{Matrix2, Matrix4, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{Mueller, Wavelength};

use super::error::OpeningError;
use super::screen::{Openings, curvature, sinc};
use super::spectrum::AngularSpectrum;
use crate::accuracy::Tolerance;
use crate::geometry::{GeometryError, LEAST_COSINE, check_index};

/// A screen between a source and a receiver that may be too near for one phase over all openings.
///
/// ```text
/// F_n = (s r/(s_n r_n)) a b sinc sinc(κ_n) e^(ik (n_i (s_n − s) + n_o (r_n − r) + δ_n))
/// κ_n = k (n_o r̂_n + n_i ŝ_n), tangential       δ_n = (n_i/s_n + n_o/r_n)(a² + b²)/24
/// ```
///
/// with `s_n`, `r_n` the distances of source and receiver from opening n, s and r from the centre. Far away it is the
/// plane-wave form. Every opening has to be in its own far field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlitView<'a> {
    openings: &'a Openings,
    source: Vector3<f64>,
    observer: Vector3<f64>,
    wavelength: Wavelength,
    indices: [f64; 2],
    /// Of the phase at an opening's corner.
    limit: f64,
}

impl Openings {
    /// This screen between the points `source` and `observer`: metres along the two tangents and the normal, from the
    /// origin of the openings' coordinates. Both media have index 1; see [`SlitView::between`].
    ///
    /// `tolerance` is the largest phase in radians, at the corner of an opening, by which spherical waves may leave the
    /// plane ones that are used there: `k (a² + b²)(1/s + 1/r)/8`. Its mean over the opening, a third of that, is kept.
    /// What is lost is at most half of it, relative to the pattern's peak; under the central lobe much less (8 to 15 µm at
    /// 1 m, a phase of 8e-4: 1e-6).
    ///
    /// # Errors
    ///
    /// When an opening is in its near field, with the phase; when a point is in the screen's plane or not finite.
    pub fn seen_between(
        &self,
        source: Vector3<f64>,
        observer: Vector3<f64>,
        wavelength: Wavelength,
        tolerance: Tolerance,
    ) -> Result<SlitView<'_>, OpeningError> {
        for (to, point) in [("source", source), ("observer", observer)] {
            let distance = point.norm();
            if !(1e-30..=1e30).contains(&distance) {
                return Err(OpeningError::Value {
                    what: "a distance",
                    value: distance,
                    expected: "a length between 1e-30 and 1e30 m",
                });
            }
            let cosine = point.z / distance;
            if cosine.abs() < LEAST_COSINE {
                return Err(GeometryError::Grazing { to, cosine }.into());
            }
        }
        let view = SlitView {
            openings: self,
            source,
            observer,
            wavelength,
            indices: [1.0; 2],
            limit: tolerance.get(),
        };
        view.check_far_fields(&source)?;
        Ok(view)
    }
}

impl SlitView<'_> {
    /// The same view between media of index `incident`, where the source is, and `outgoing`, where the observer is.
    ///
    /// # Errors
    ///
    /// When an index is not a number between 1e-3 and 1e3, or an opening is in its near field there.
    pub fn between(mut self, incident: f64, outgoing: f64) -> Result<Self, OpeningError> {
        check_index("incident", incident)?;
        check_index("outgoing", outgoing)?;
        self.indices = [incident, outgoing];
        self.check_far_fields(&self.source)?;
        Ok(self)
    }

    /// The Jones matrix of the screen between the two points, m².
    #[must_use]
    pub fn jones(&self) -> JonesMatrix {
        self.jones_from(&self.source)
    }

    /// The transfer of light from the source's point alone, 1/sr, as [`super::LitOpenings::transfer`].
    #[must_use]
    pub fn transfer(&self) -> Mueller {
        self.jones().mueller() * self.scale()
    }

    /// The transfer of light from around the source's point, 1/sr: the points where the waves of `light` come from, at
    /// the distance of the source.
    ///
    /// # Errors
    ///
    /// When a wave of the light comes from no direction: its wave vector is not below the wavenumber, or it comes along the
    /// screen; when an opening is in the near field of the point where a wave comes from.
    pub fn transfer_of(&self, light: &AngularSpectrum) -> Result<Mueller, OpeningError> {
        let mut sum = Matrix4::zeros();
        for wave in light.waves() {
            let source = self.source_of(&wave.wave_vector)?;
            self.check_far_fields(&source)?;
            sum += self.jones_from(&source).mueller().to_matrix() * wave.weight;
        }
        Ok(Mueller::from(sum) * self.scale())
    }

    /// The point of the source that gives the screen's centre the wave vector `q` beside its own.
    fn source_of(&self, q: &Vector2<f64>) -> Result<Vector3<f64>, OpeningError> {
        let s = self.source.norm();
        let k = self.indices[0] * self.wavelength.wavenumber().radians_per_metre();
        let along = self.source.xy() / s + q / k;
        let cosine = 1.0 - along.norm_squared();
        if cosine.is_nan() || cosine < LEAST_COSINE * LEAST_COSINE {
            return Err(OpeningError::Value {
                what: "the sine of a wave's angle with the screen's normal",
                value: along.norm(),
                expected: "a number below 1",
            });
        }
        let height = cosine.sqrt().copysign(self.source.z);
        Ok(along.push(height) * s)
    }

    /// An error for an opening at whose corner spherical waves leave plane ones by more than the limit.
    fn check_far_fields(&self, source: &Vector3<f64>) -> Result<(), OpeningError> {
        for (index, o) in self.openings.openings().iter().enumerate() {
            let middle = o.centre.push(0.0);
            let distances = [(source - middle).norm(), (self.observer - middle).norm()];
            let square = 0.25 * (o.width * o.width + o.height * o.height);
            let phase = curvature(distances, self.indices, self.wavelength) * square;
            let limit = self.limit;
            if phase.is_nan() || phase > limit {
                return Err(OpeningError::NearField {
                    index,
                    width: o.width,
                    height: o.height,
                    source_distance: distances[0],
                    observer: distances[1],
                    phase,
                    limit,
                });
            }
        }
        Ok(())
    }

    fn jones_from(&self, source: &Vector3<f64>) -> JonesMatrix {
        let k = self.wavelength.wavenumber().radians_per_metre();
        let [n_i, n_o] = self.indices;
        let sum: Matrix2<Complex64> = self
            .openings
            .openings()
            .iter()
            .map(|o| {
                let (s, ds, near_s) = leg(source, &o.centre);
                let (r, dr, near_r) = leg(&self.observer, &o.centre);
                let kappa = (r * n_o + s * n_i) * k;
                let (x, y) = (0.5 * kappa.x * o.width, 0.5 * kappa.y * o.height);
                let size = o.area() * sinc(x, x.sin()) * sinc(y, y.sin()) * near_s * near_r;
                // what the spherical waves are behind the plane ones on average over the opening
                let bend = n_i * near_s / source.norm() + n_o * near_r / self.observer.norm();
                let behind = bend * (o.width * o.width + o.height * o.height) / 24.0;
                // the transform enters conjugated, as that of plane waves does
                let path = n_i * ds + n_o * dr + behind;
                o.jones.to_matrix() * Complex64::from_polar(size, -k * path)
            })
            .sum();
        sum.into()
    }

    fn scale(&self) -> f64 {
        (self.indices[1] / self.wavelength.metres()).powi(2) / self.openings.screen_area()
    }
}

/// From the place `centre` of the screen to a point: the direction's tangential part, how much longer the way is than from
/// the origin, and how much stronger a spherical wave.
///
/// The difference of the two ways is formed from the square of the small one.
fn leg(point: &Vector3<f64>, centre: &Vector2<f64>) -> (Vector2<f64>, f64, f64) {
    let way = point - centre.push(0.0);
    let (whole, length) = (point.norm(), way.norm());
    let longer = (centre.norm_squared() - 2.0 * point.xy().dot(centre)) / (length + whole);
    (way.xy() / length, longer, whole / length)
}
