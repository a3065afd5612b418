//! A lit screen: what its openings and the light have in common for all observers, and the pattern of its far field.

use csdm::{GeneralizedMueller, TransferTensor};
use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2, Vector3};
use num_complex::Complex64;
use smallvec::SmallVec;
use stokes::{Components, GeneralizedStokes, HermiteSeries, Mueller, StokesVector};

use super::error::OpeningError;
use super::screen::{Openings, sinc};
use super::spectrum::AngularSpectrum;
use crate::accuracy::Tolerance;
use crate::geometry::Geometry;
use crate::incident;

/// `cos + i sin` of the three phases that a wave vector has at one opening: at its middle, and at the middles of two of
/// its edges from there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turns {
    middle: Complex64,
    x: Complex64,
    y: Complex64,
}

impl Turns {
    fn of(openings: &Openings, q: &Vector2<f64>) -> impl Iterator<Item = Self> {
        openings.openings().iter().map(|opening| Self {
            middle: Complex64::cis(q.dot(&opening.centre)),
            x: Complex64::cis(0.5 * q.x * opening.width),
            y: Complex64::cis(0.5 * q.y * opening.height),
        })
    }
}

/// What stands in the openings.
#[derive(Clone, Debug, PartialEq)]
enum Filling {
    /// In each opening the same Jones matrix times a number.
    Common(Matrix4<f64>, Vec<Complex64>),
    /// A Jones matrix in each.
    Own,
}

/// A screen under light of given coherence: the far-field pattern without trigonometry of its own.
///
/// Cost of one direction: the sines of its phases at each opening, then for each plane wave and opening six products.
/// No allocation for up to eight openings.
#[derive(Clone, Debug)]
pub struct LitOpenings<'a> {
    openings: &'a Openings,
    light: &'a AngularSpectrum,
    /// For each wave those of all openings.
    turns: Vec<Turns>,
    filling: Filling,
}

impl Openings {
    /// This screen in that light.
    ///
    /// # Errors
    ///
    /// When the sines of openings and waves together do not fit: more than 2²⁶ of them.
    pub fn lit_by<'a>(
        &'a self,
        light: &'a AngularSpectrum,
    ) -> Result<LitOpenings<'a>, OpeningError> {
        let count = self.openings().len() * light.waves().len();
        if count > 1 << 26 {
            return Err(OpeningError::Value {
                what: "the number of openings times plane waves",
                value: count as f64,
                expected: "at most 67108864",
            });
        }
        let turns = light
            .waves()
            .iter()
            .flat_map(|wave| Turns::of(self, &wave.wave_vector))
            .collect();
        Ok(LitOpenings {
            openings: self,
            light,
            turns,
            filling: self.filling(),
        })
    }

    fn filling(&self) -> Filling {
        let matrices = self.openings().iter().map(|o| o.jones.to_matrix());
        let largest = |m: &Matrix2<Complex64>| m.camax();
        let Some(common) = matrices
            .clone()
            .max_by(|a, b| largest(a).total_cmp(&largest(b)))
        else {
            return Filling::Own;
        };
        let place = common.icamax_full();
        if common[place] == Complex64::ZERO {
            return Filling::Common(
                Matrix4::zeros(),
                vec![Complex64::ZERO; self.openings().len()],
            );
        }
        let factors: Vec<_> = matrices.clone().map(|m| m[place] / common[place]).collect();
        let same = |(m, f): (Matrix2<Complex64>, &Complex64)| {
            (m - common * *f).camax() <= 4.0 * f64::EPSILON * largest(&common)
        };
        if matrices.zip(&factors).all(same) {
            let mueller = csdm::JonesMatrix::from(common).mueller().to_matrix();
            Filling::Common(mueller, factors)
        } else {
            Filling::Own
        }
    }

    /// Stokes parameters times r², toward the geometry's observer, of the light that passes the screen when it is lit by
    /// `light`: the radiant intensity without its cosines, for components that share their modes or not.
    ///
    /// `tolerance` is relative to the coherence of each component; no opening's coherence is taken as constant.
    ///
    /// Source: Lemma 4.3 at ξ = 0.
    ///
    /// # Errors
    ///
    /// When the light comes from elsewhere than the geometry says or has another wavelength, or is too incoherent for the
    /// tolerance.
    pub fn scatter(
        &self,
        geometry: &Geometry,
        light: &GeneralizedStokes,
        tolerance: Tolerance,
    ) -> Result<StokesVector, OpeningError> {
        let (root, _, factor) = incident::root_of(light, geometry)?;
        let scale = (geometry.n_outgoing() / geometry.wavelength().metres()).powi(2) * factor;
        let phi = geometry.tangential();
        let mueller = |series: &HermiteSeries| {
            let size = series.norm();
            let reach = tolerance.get() * size;
            let spectrum = AngularSpectrum::of_series(&root, series, self.extent(), reach)?;
            Ok::<_, OpeningError>(self.lit_by(&spectrum)?.response(&phi))
        };
        let sum = match light.components() {
            Components::Shared { modes, stokes } => {
                mueller(modes)?.to_matrix() * stokes.to_vector()
            }
            Components::Separate(series) => {
                let mut sum = nalgebra::Vector4::zeros();
                for (j, series) in series.iter().enumerate() {
                    if let Some(series) = series {
                        sum += mueller(series)?.to_matrix().column(j);
                    }
                }
                sum
            }
        };
        Ok((sum * scale).into())
    }
}

impl LitOpenings<'_> {
    /// `Σ_i p_i M(T̃(φ + q_i))`, m⁴, at the tangential wave vector `phi` in rad/m.
    ///
    /// Off by at most the error of the light times the square of the open area (times that of the Jones matrices). For
    /// weights that are not negative it is realizable.
    #[must_use]
    pub fn response(&self, phi: &Vector2<f64>) -> Mueller {
        let at: SmallVec<[Turns; 8]> = Turns::of(self.openings, phi).collect();
        match &self.filling {
            Filling::Common(mueller, factors) => {
                let mut power = 0.0;
                for (wave, turns) in self.waves() {
                    let fields = self.fields(phi, &wave.wave_vector, &at, turns);
                    let field: Complex64 = fields.zip(factors).map(|(f, t)| f * t).sum();
                    power += wave.weight * field.norm_sqr();
                }
                (mueller * power).into()
            }
            Filling::Own => {
                let mut tensor = Matrix4::zeros();
                for (wave, turns) in self.waves() {
                    let jones = self.vector(phi, &wave.wave_vector, &at, turns);
                    tensor += jones * jones.adjoint() * Complex64::from(wave.weight);
                }
                let sixteen = TransferTensor::from(tensor).generalized_mueller();
                sixteen.to_matrix().map(|element| element.re).into()
            }
        }
    }

    /// The mutual response `A{Σ^(j→l) γ}(φ + u/2, φ − u/2)`, m⁴, row l and column j: what two observers see together.
    /// `u = P w` is the far-field argument in the surface, rad/m; at 0 it is [`LitOpenings::response`].
    ///
    /// Source: Eq. (S2.3).
    #[must_use]
    pub fn mutual_response(&self, phi: &Vector2<f64>, u: &Vector2<f64>) -> Matrix4<Complex64> {
        let (first, second) = (phi + u * 0.5, phi - u * 0.5);
        self.light
            .waves()
            .iter()
            .map(|wave| {
                let jones = |at: Vector2<f64>| self.openings.jones(&(at + wave.wave_vector));
                let sixteen = GeneralizedMueller::of_jones(&jones(first), &jones(second));
                sixteen.scattering() * Complex64::from(wave.weight)
            })
            .sum()
    }

    /// The transfer `f_t` between the geometry's two directions, 1/sr: a bidirectional scattering function without
    /// obliquity. Reciprocal up to frames; its integral over `cos_o dω` is the open fraction.
    ///
    /// # Errors
    ///
    /// When a direction is at grazing incidence.
    pub fn transfer(&self, geometry: &Geometry) -> Result<Mueller, OpeningError> {
        geometry.cosines()?;
        let scale = (geometry.n_outgoing() / geometry.wavelength().metres()).powi(2);
        let scale = scale / self.openings.screen_area();
        Ok(self.response(&geometry.tangential()) * scale)
    }

    /// Radiant intensity `f_t cos_i cos_o A_s` per irradiance across the incident ray, m²/sr, toward each of the
    /// observers; the rest as `geometry` says.
    ///
    /// # Errors
    ///
    /// As [`LitOpenings::transfer`]; when a direction is not a unit vector.
    pub fn pattern(
        &self,
        geometry: &Geometry,
        to_observers: &[Vector3<f64>],
    ) -> Result<Vec<Mueller>, OpeningError> {
        let (n_i, n_o) = (geometry.n_incident(), geometry.n_outgoing());
        let pattern = to_observers.iter().map(|to_observer| {
            let geometry = Geometry::new(
                geometry.to_source(),
                *to_observer,
                geometry.tangents(),
                geometry.wavelength(),
            )?
            .between(n_i, n_o)?;
            let [cos_i, cos_o] = geometry.cosines()?;
            let area = self.openings.screen_area();
            Ok(self.transfer(&geometry)? * ((cos_i * cos_o).abs() * area))
        });
        pattern.collect()
    }

    fn waves(&self) -> impl Iterator<Item = (&super::PlaneWave, &[Turns])> {
        let count = self.openings.openings().len();
        self.light
            .waves()
            .iter()
            .zip(self.turns.chunks_exact(count))
    }

    /// `F_n(φ + q)*` of every opening.
    fn fields<'b>(
        &'b self,
        phi: &Vector2<f64>,
        q: &Vector2<f64>,
        at: &'b [Turns],
        turns: &'b [Turns],
    ) -> impl Iterator<Item = Complex64> + 'b {
        let kappa = phi + q;
        let openings = self.openings.openings().iter();
        openings.zip(at.iter().zip(turns)).map(move |(o, (a, b))| {
            let x = sinc(0.5 * kappa.x * o.width, sine(a.x, b.x));
            let y = sinc(0.5 * kappa.y * o.height, sine(a.y, b.y));
            a.middle * b.middle * (o.area() * x * y)
        })
    }

    /// `vec T̃(φ + q)`
    fn vector(
        &self,
        phi: &Vector2<f64>,
        q: &Vector2<f64>,
        at: &[Turns],
        turns: &[Turns],
    ) -> SMatrix<Complex64, 4, 1> {
        let fields = self.fields(phi, q, at, turns);
        let openings = self.openings.openings().iter();
        let mut sum = SMatrix::zeros();
        for (field, opening) in fields.zip(openings) {
            let t = opening.jones.to_matrix();
            sum += SMatrix::<_, 4, 1>::new(t.m11, t.m12, t.m21, t.m22) * field;
        }
        sum
    }
}

/// The sine of the sum of two angles.
fn sine(a: Complex64, b: Complex64) -> f64 {
    a.im * b.re + a.re * b.im
}
