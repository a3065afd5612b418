//! Locally stationary matter as a list of populations: a response, an autocorrelation and an envelope each.

use csdm::{CloudeSpectrum, Element, JonesMatrix, NotRealizable};
use nalgebra::{Matrix2, Vector2};
use stokes::{Envelope, EnvelopeError, EnvelopeModes, ModeWidth, Mueller, plane};
use thiserror::Error;

use crate::autocorrelation::{Autocorrelation, GaussianFamily};
use crate::channels::Channels;

/// Rounding that a Mueller matrix may carry and still be taken for realizable, of its largest eigenvalue.
const REALIZABLE: f64 = 1e-9;

/// Why populations are no matter.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MatterError {
    /// A population is one that no ensemble of Jones matrices makes.
    #[error("matter: {0}")]
    NotRealizable(#[from] NotRealizable),
    /// The lobe of a population is negative somewhere.
    #[error(
        "matter: a population with sixteen given numbers has an autocorrelation of negative weight {weight}; expected weights \
         of at least 0, or channels given one by one"
    )]
    NegativeWeight {
        /// The weight.
        weight: f64,
    },
    /// A number of a population is none.
    #[error("matter: {what} of population {population} is {value}, expected a finite number")]
    NotFinite {
        /// Place in the list, from 0.
        population: usize,
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
    },
    /// There is none.
    #[error("matter: no population, expected at least one")]
    Nothing,
    /// An envelope has no modes.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
}

/// One kind of scatterer: what it does to polarization, how it is correlated from place to place, and where it is.
///
/// ```text
/// Σ^(j→l)(x₁, x₂) = I((x₁ + x₂)/2) R^(j→l)(x₁ − x₂),      R^(j→l) = M_lj R
/// ```
///
/// `M` is real: it is the Mueller matrix of one point. The phase of a relief or of a patterned element stands in R, as
/// the places of its orders ([`crate::Autocorrelation::shifted`]); a height h along the normal is `e^(−iφ_z h)` there, a
/// Jones matrix in `exp(+iωt)` enters as its conjugate.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    mueller: Mueller,
    autocorrelation: Autocorrelation,
    envelope: Envelope,
}

impl Population {
    /// Scatterers of one Jones matrix.
    #[must_use]
    pub fn of_jones(
        jones: &JonesMatrix,
        autocorrelation: Autocorrelation,
        envelope: Envelope,
    ) -> Self {
        Self::of_sixteen(&jones.mueller(), autocorrelation, envelope)
    }

    /// Scatterers of one Mueller matrix: an ensemble at one point.
    ///
    /// # Errors
    ///
    /// When no ensemble of Jones matrices has this matrix (an eigenvalue of its coherency matrix below −1e-9 of the
    /// largest), or a weight of the autocorrelation is negative.
    pub fn of_mueller(
        mueller: &Mueller,
        autocorrelation: Autocorrelation,
        envelope: Envelope,
    ) -> Result<Self, MatterError> {
        CloudeSpectrum::of(mueller)?.check_realizable(REALIZABLE)?;
        let mut terms = autocorrelation
            .families()
            .iter()
            .flat_map(GaussianFamily::terms);
        if let Some(term) = terms.find(|term| term.weight.is_nan() || term.weight < 0.0) {
            return Err(MatterError::NegativeWeight {
                weight: term.weight,
            });
        }
        Ok(Self::of_sixteen(mueller, autocorrelation, envelope))
    }

    /// Scatterers that are what `element` is at one point: plates, films, and mixtures of them.
    ///
    /// The element must be uniform, the same at every place and for every pair of points. Random phases are
    /// [`Channels::of_phase_screen`] and [`Channels::of_rough_retarder`], patterns [`crate::PolarizationPattern`].
    ///
    /// ```
    /// use csdm::{JonesMatrix, Mixture};
    /// use mueller16::{Autocorrelation, ChannelSet, Matter, Population};
    /// use stokes::Envelope;
    /// // polarizers along x and y, half of each: S1 passes as S0 does, S2 and S3 do not
    /// let x = JonesMatrix::linear_polarizer();
    /// let mixture = Mixture::new(vec![(0.5, x), (0.5, x.rotated(std::f64::consts::FRAC_PI_2))])?;
    /// let part = Population::of_element(&mixture, Autocorrelation::constant(1.0), Envelope::disk(1e-3)?)?;
    /// let mueller = Matter::new(vec![part])?.channels().mueller();
    /// assert!((mueller.element(1, 1) - 0.5).abs() < 1e-15 && mueller.element(2, 2).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Population::of_mueller`].
    pub fn of_element(
        element: &(impl Element + ?Sized),
        autocorrelation: Autocorrelation,
        envelope: Envelope,
    ) -> Result<Self, MatterError> {
        let mueller = element.mueller_at(&Vector2::zeros());
        Self::of_mueller(&mueller, autocorrelation, envelope)
    }

    /// Scatterers of sixteen given numbers, which need not be realizable by themselves: one channel of many, or numbers
    /// from elsewhere. [`Matter::check_realizable`] asks about the whole.
    #[must_use]
    pub fn of_sixteen(
        mueller: &Mueller,
        autocorrelation: Autocorrelation,
        envelope: Envelope,
    ) -> Self {
        Self {
            mueller: *mueller,
            autocorrelation,
            envelope,
        }
    }

    /// The first number that is none, and what it is.
    fn not_finite(&self) -> Option<(&'static str, f64)> {
        let matrix = self.mueller.to_matrix();
        let elements = matrix.iter().map(|m| ("an element of the matrix", *m));
        let families = self.autocorrelation.families().iter();
        let terms = families.flat_map(GaussianFamily::terms).flat_map(|term| {
            [
                ("a weight of the autocorrelation", term.weight),
                ("a shift of the autocorrelation", term.shift.x),
                ("a shift of the autocorrelation", term.shift.y),
            ]
        });
        elements.chain(terms).find(|(_, value)| !value.is_finite())
    }
}

/// Locally stationary matter: its channels, and the envelopes in which they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Matter {
    channels: Channels,
    envelopes: Vec<Envelope>,
}

impl Matter {
    /// The matter that consists of these populations. Equal envelopes are held once, and so are channels of one
    /// autocorrelation.
    ///
    /// # Errors
    ///
    /// When there is no population, or a number of one is not finite.
    pub fn new(populations: Vec<Population>) -> Result<Self, MatterError> {
        let mut channels = Channels::default();
        let mut envelopes: Vec<Envelope> = vec![];
        for (place, population) in populations.into_iter().enumerate() {
            if let Some((what, value)) = population.not_finite() {
                return Err(MatterError::NotFinite {
                    population: place,
                    what,
                    value,
                });
            }
            let Population {
                mueller,
                autocorrelation,
                envelope,
            } = population;
            let place = match envelopes.iter().position(|known| *known == envelope) {
                Some(place) => place,
                None => {
                    envelopes.push(envelope);
                    envelopes.len() - 1
                }
            };
            channels = channels.with(&mueller, autocorrelation, place);
        }
        if envelopes.is_empty() {
            return Err(MatterError::Nothing);
        }
        Ok(Self {
            channels,
            envelopes,
        })
    }

    /// The channels; their envelopes are numbered as [`Matter::envelopes`] are.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// The different envelopes.
    #[must_use]
    pub fn envelopes(&self) -> &[Envelope] {
        &self.envelopes
    }

    /// The far-field modes of every envelope up to `order`, the same in every direction.
    ///
    /// # Errors
    ///
    /// As [`Envelope::modes`].
    pub fn modes(&self, width: ModeWidth, order: usize) -> Result<Vec<EnvelopeModes>, MatterError> {
        let modes: Result<_, _> = self
            .envelopes
            .iter()
            .map(|e| e.modes(width, order))
            .collect();
        Ok(modes?)
    }

    /// Centroid of the total scattered intensity, m: the phase centre of light of one shape. `None` where no intensity is
    /// scattered.
    #[must_use]
    pub fn centroid(&self) -> Option<Vector2<f64>> {
        let weights = self.intensities();
        let total: f64 = weights.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let weighted = self.envelopes.iter().zip(&weights);
        let sum: Vector2<f64> = weighted.map(|(e, w)| e.centroid() * *w).sum();
        Some(sum / total)
    }

    /// Covariance of the place of the total scattered intensity, 2×2, m²: the envelopes of `0 → 0` weighted by their
    /// areas and `R^(0→0)(0)`; about the common centroid. `None` where no intensity is scattered.
    #[must_use]
    pub fn covariance(&self) -> Option<Matrix2<f64>> {
        let centre = self.centroid()?;
        let weights = self.intensities();
        let total: f64 = weights.iter().sum();
        let sum: Matrix2<f64> = self
            .envelopes
            .iter()
            .zip(&weights)
            .map(|(e, w)| {
                let d = e.centroid() - centre;
                (e.covariance() + d * d.transpose()) * *w
            })
            .sum();
        Some(sum / total)
    }

    /// `R^(0→0)(0)` times the area, for each envelope.
    fn intensities(&self) -> Vec<f64> {
        let of_envelope = |(place, envelope): (usize, &Envelope)| {
            let r = self.channels.autocorrelation(0, 0, place);
            r.map_or(0.0, |r| r.at_zero() * envelope.area())
        };
        self.envelopes.iter().enumerate().map(of_envelope).collect()
    }

    /// Tangential wave vectors, rad/m, where lobes of different width or place differ: the centre of every Gaussian, and
    /// 1, 2 and 4 standard deviations from it along both axes of its shape. For [`Matter::check_realizable`].
    ///
    /// Thirteen for each Gaussian of different shape or centre.
    #[must_use]
    pub fn lobe_places(&self) -> Vec<Vector2<f64>> {
        let mut gaussians: Vec<(Vector2<f64>, Matrix2<f64>)> = vec![];
        let families = self.channels.groups().iter();
        for family in families.flat_map(|group| group.autocorrelation.families()) {
            // the lobe is e^(−|D(φ − shift)|²/2m)
            let axes = plane::inverse(family.root());
            for term in family.terms() {
                let gaussian = (term.shift, axes * term.rate.sqrt());
                if !gaussians.contains(&gaussian) {
                    gaussians.push(gaussian);
                }
            }
        }
        let around = |(centre, axes): (Vector2<f64>, Matrix2<f64>)| {
            let steps = [-4.0, -2.0, -1.0, 1.0, 2.0, 4.0];
            let off = steps
                .into_iter()
                .flat_map(move |step| [0, 1].map(|axis| centre + axes.column(axis) * step));
            std::iter::once(centre).chain(off)
        };
        gaussians.into_iter().flat_map(around).collect()
    }

    /// Asks whether the matter could be made of Jones matrices, at these tangential wave vectors: whether the Mueller
    /// matrix `F{R^(j→l)}(φ)` of every one has no negative eigenvalue of its coherency matrix (Bochner).
    ///
    /// Delta orders are asked about one by one. [`Matter::lobe_places`] are places where lobes that differ show it.
    ///
    /// # Errors
    ///
    /// With the most negative eigenvalue of the first that fails.
    pub fn check_realizable(&self, at: &[Vector2<f64>], tolerance: f64) -> Result<(), MatterError> {
        for place in 0..self.envelopes.len() {
            for mueller in self.channels.spectral_muellers(place, at) {
                CloudeSpectrum::of(&mueller)?.check_realizable(tolerance)?;
            }
        }
        Ok(())
    }
}
