//! Theorem S4.1 to the letter: light of all channels and all envelopes in one shape, with what that took from it.
//!
//! ```text
//! W = Cov^(1/2) P        Cov of the total scattered intensity, about its centroid
//! c^(l)_ab = Σ_q ⟨f_q | φ_ab(·; W)⟩ S^(q)_l,        S^(q)_l = Σ_j A^(j→l) over the channels of envelope q
//! ```

use nalgebra::{Matrix2, Vector2};
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, Loss, MAX_ORDER, ModeWidth, ShapeMatrix,
    StokesVector, mode_count, plane,
};

use crate::geometry::Geometry;
use crate::population::Matter;
use crate::theorem::{Energy, InteractionError};

/// How many orders beyond the last are added up for the loss.
const TAIL: usize = 32;

/// The far field of one envelope in the common shape, beyond the order asked for, and the norm of what even that
/// leaves out.
struct Projected {
    series: HermiteSeries,
    area: f64,
    rest: f64,
}

impl Matter {
    /// The shape of the total scattered intensity, seen with the projection P of
    /// [`Geometry::outgoing_projection`]: `W = Cov^(1/2) P`, the symmetric root.
    ///
    /// Source: Theorem S4.1 (ii), with the minus sign and restricted to the transverse plane before it is inverted.
    ///
    /// # Errors
    ///
    /// When no intensity is scattered or the plane is seen edge-on.
    pub fn shape(&self, projection: &Matrix2<f64>) -> Result<ShapeMatrix, InteractionError> {
        let covariance = self.covariance().ok_or(InteractionError::Dark)?;
        let root = plane::symmetric_root(&covariance);
        Ok(ShapeMatrix::from_root(&root)?.in_coordinates(projection)?)
    }

    /// The light that this matter scatters toward the observer, all envelopes in the one shape of
    /// [`Matter::shape`] by modes up to `order`, and what that took from it.
    ///
    /// The phase centre is [`Matter::centroid`]. The loss counts the next 32 orders and bounds what is beyond them by the sum
    /// over the envelopes. [`Matter::scatter`] loses nothing but the truncation of each envelope in its own shape.
    ///
    /// Source: Theorem S4.1 (i).
    ///
    /// # Errors
    ///
    /// As [`Matter::scatter`] and [`Matter::shape`]; when `order` exceeds [`MAX_ORDER`].
    pub fn scatter_in_one_shape(
        &self,
        geometry: &Geometry,
        light: &GeneralizedStokes,
        energy: Energy,
        outgoing: Frame,
        distance: f64,
        order: usize,
    ) -> Result<(GeneralizedStokes, Loss), InteractionError> {
        let projection = geometry.outgoing_projection(&outgoing);
        let shape = self.shape(&projection)?;
        let origin = self.centroid().ok_or(InteractionError::Dark)?;
        let factor = energy.factor(geometry)?;
        let amplitudes = self.channels().amplitudes(geometry, light)?;
        let stokes: Vec<StokesVector> = (0..self.envelopes().len())
            .map(|place| amplitudes.stokes(place) * factor)
            .collect();
        let projected = self.projected(&origin, &projection, &shape, order)?;
        let (components, norm) = combined(&projected, &stokes, order)?;
        let wavelength = geometry.wavelength();
        let scattered = GeneralizedStokes::new(components, shape, outgoing, wavelength, distance)?;
        let whole = projected
            .iter()
            .zip(&stokes)
            .fold(StokesVector::DARK, |sum, (p, s)| sum + *s * p.area)
            * (1.0 / (distance * distance));
        let loss = Loss {
            norm,
            stokes: whole - scattered.stokes().stokes,
        };
        Ok((scattered, loss))
    }

    fn projected(
        &self,
        origin: &Vector2<f64>,
        projection: &Matrix2<f64>,
        shape: &ShapeMatrix,
        order: usize,
    ) -> Result<Vec<Projected>, InteractionError> {
        // beyond the largest order the projection says what is wrong
        let far = if order < MAX_ORDER {
            (order + TAIL).min(MAX_ORDER)
        } else {
            order
        };
        self.envelopes()
            .iter()
            .map(|envelope| {
                let series = envelope.project_about(origin, projection, shape, far)?;
                let own = envelope.modes(ModeWidth::VarianceMatched, 0)?;
                let matched = own.in_direction(projection)?.1.norm();
                let squared = matched * matched / (1.0 - own.relative_error().powi(2));
                let lost = squared - series.norm().powi(2);
                Ok(Projected {
                    series,
                    area: envelope.area(),
                    // below that the difference has no digits; a sum of Gaussians has converged there
                    rest: if lost > 1e-8 * squared {
                        lost.sqrt()
                    } else {
                        0.0
                    },
                })
            })
            .collect()
    }
}

/// The four series up to the order, and the norm of what they lack over that of the whole.
fn combined(
    projected: &[Projected],
    stokes: &[StokesVector],
    order: usize,
) -> Result<(Components, f64), InteractionError> {
    let count = mode_count(order);
    if let ([only], [stokes]) = (projected, stokes) {
        let kept = &only.series.real_coefficients()[..count];
        let modes =
            HermiteSeries::from_real_coefficients(kept).map_err(stokes::EnvelopeError::from)?;
        let (_, tail) = only.series.truncated(order);
        let lost = tail.hypot(only.rest);
        let norm = relative(lost, modes.norm());
        return Ok((
            Components::Shared {
                modes,
                stokes: *stokes,
            },
            norm,
        ));
    }
    let (mut lost, mut whole) = (0.0, 0.0);
    let mut series = [const { None }; 4];
    for (l, component) in series.iter_mut().enumerate() {
        let amplitudes: Vec<f64> = stokes.iter().map(|s| s.to_array()[l]).collect();
        if amplitudes.iter().all(|a| *a == 0.0) {
            continue;
        }
        let length = projected
            .first()
            .map_or(0, |p| p.series.real_coefficients().len());
        let mut sum = vec![0.0; length];
        for (p, amplitude) in projected.iter().zip(&amplitudes) {
            for (into, s) in sum.iter_mut().zip(p.series.real_coefficients()) {
                *into += amplitude * s;
            }
        }
        let rest: f64 = projected
            .iter()
            .zip(&amplitudes)
            .map(|(p, amplitude)| p.rest * amplitude.abs())
            .sum();
        let square = |s: &[f64]| s.iter().map(|s| s * s).sum::<f64>();
        let (kept, tail) = sum.split_at(count.min(length));
        lost += square(tail) + rest * rest;
        whole += square(kept);
        let kept =
            HermiteSeries::from_real_coefficients(kept).map_err(stokes::EnvelopeError::from)?;
        *component = Some(kept);
    }
    Ok((
        Components::Separate(series),
        relative(lost.sqrt(), whole.sqrt()),
    ))
}

/// The lost part over the whole, of which `kept` and `lost` are perpendicular parts.
fn relative(lost: f64, kept: f64) -> f64 {
    if lost > 0.0 {
        lost / lost.hypot(kept)
    } else {
        0.0
    }
}
