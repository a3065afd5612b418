//! Rectangular openings in an opaque screen, and what one plane wave makes of them.

use csdm::{GeneralizedMueller, JonesMatrix};
use nalgebra::Vector2;
use num_complex::Complex64;
use stokes::{StokesVector, Wavelength};

use super::error::OpeningError;
use crate::accuracy::Tolerance;
use crate::geometry::Geometry;

/// Overlap of two openings that is taken for rounding, of the smaller width.
const TOUCHING: f64 = 1e-9;

/// One rectangular opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Its middle, m, along the screen's two tangents.
    pub centre: Vector2<f64>,
    /// Full width along the first tangent, m.
    pub width: f64,
    /// Full width along the second tangent, m.
    pub height: f64,
    /// What stands in it, fields in `exp(+iωt)`: a polarizer, a plate; a delay δ is a factor `e^(−iδ)`.
    pub jones: JonesMatrix,
}

impl Opening {
    /// An empty opening.
    #[must_use]
    pub fn clear(centre: Vector2<f64>, width: f64, height: f64) -> Self {
        Self {
            centre,
            width,
            height,
            jones: JonesMatrix::identity(),
        }
    }

    /// m²
    #[must_use]
    pub fn area(&self) -> f64 {
        self.width * self.height
    }

    /// The transform `F(κ) = ∫ e^(−iκ·x) d²x` over the opening, m²; `kappa` in rad/m.
    #[must_use]
    pub fn fourier(&self, kappa: &Vector2<f64>) -> Complex64 {
        let (x, y) = (0.5 * kappa.x * self.width, 0.5 * kappa.y * self.height);
        let size = self.area() * sinc(x, x.sin()) * sinc(y, y.sin());
        Complex64::from_polar(size, -kappa.dot(&self.centre))
    }
}

/// `sin(t)/t` for a known sine, without loss where both are small: error of a few ε.
pub(super) fn sinc(t: f64, sin: f64) -> f64 {
    if t.abs() > 0.5 {
        return sin / t;
    }
    let s = t * t;
    let mut sum = 1.0;
    for n in (1..8).rev() {
        let n = f64::from(n);
        sum = 1.0 - sum * s / (2.0 * n * (2.0 * n + 1.0));
    }
    sum
}

/// An opaque screen with rectangular openings.
///
/// Young's two slits, a grating of a few lines, a stop; coordinates are metres along the two tangents of the surface.
///
/// ```text
/// f_t = (n_o²/(λ₀² A_s)) ∫ p(q) M(Σ_n T_n F_n(φ_t + q)*) d²q         F_n(κ) = ∫_n e^(−iκ·x) d²x, p the light's wave vectors
/// ```
///
/// With `A_s` the area of the screen the albedo is the open fraction; radiant intensity is `f_t cos_i cos_o A_s E`, radiance
/// over the screen `f_t cos_i E`, with E the irradiance across the incident ray.
///
/// # More than one such element
///
/// A screen is no locally stationary matter: the coherence of the light behind it depends on where it is, not on
/// separations alone. For one screen and its receiver that does not matter, and any incoherent source is served by the
/// average over its points. A chain of two (slits behind slits) needs the light between them as a function of two points:
/// neither radiances can be added up there, nor is it enough to take the modes of Lemma 4.3 about one direction, which
/// change over the second screen as fast as its fringes do. What is needed is the field of each plane wave of the source:
/// the sum over all ways through opening n of the first screen and m of the second of `T_m T_n` times both transforms and
/// the phase of the way ([`Openings::seen_between`] has those of one screen), squared at the end, then added up over the
/// waves.
///
/// Source: Lemma 4.3 and Eq. (S2.9).
///
/// # Example
///
/// ```
/// use mueller16::{AngularSpectrum, Geometry, Opening, Openings};
/// use nalgebra::{Vector2, Vector3};
/// use stokes::Wavelength;
/// // two slits of 10 µm, 50 µm apart, in a screen of 1 mm²: Young's first bright fringe is at sin θ = λ/d
/// let slit = |x| Opening::clear(Vector2::new(x, 0.0), 10e-6, 1e-3);
/// let slits = Openings::new(vec![slit(-25e-6), slit(25e-6)], 1e-6)?;
/// assert!((slits.open_fraction() - 0.02).abs() < 1e-15);
/// let sodium = Wavelength::from_metres(589e-9)?;
/// let star = AngularSpectrum::plane_wave();
/// let lit = slits.lit_by(&star)?;
/// let at = |sin: f64| {
///     let to_observer = Vector3::new(sin, 0.0, (1.0 - sin * sin).sqrt());
///     let geometry = Geometry::on_plane(-Vector3::z(), to_observer, sodium)?;
///     Ok::<f64, Box<dyn std::error::Error>>(lit.transfer(&geometry)?.element(0, 0))
/// };
/// // [sin(π/5)/(π/5)]² under the envelope of one slit, and nothing half way
/// assert!((at(589e-9 / 50e-6)? / at(0.0)? - 0.875).abs() < 1e-3);
/// assert!(at(0.5 * 589e-9 / 50e-6)? / at(0.0)? < 1e-20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Openings {
    openings: Vec<Opening>,
    screen: f64,
}

impl Openings {
    /// These openings in a screen of `screen_area` m² that is opaque elsewhere.
    ///
    /// Openings may touch. They are checked pair by pair.
    ///
    /// # Errors
    ///
    /// When there is none, a width is not between 1e-30 and 1e30 m, a centre or an element of a Jones matrix not finite,
    /// two overlap, or the screen is smaller than what is open.
    pub fn new(openings: Vec<Opening>, screen_area: f64) -> Result<Self, OpeningError> {
        if openings.is_empty() {
            return Err(OpeningError::Nothing);
        }
        for (index, opening) in openings.iter().enumerate() {
            check(index, opening)?;
        }
        for (second, b) in openings.iter().enumerate() {
            for (first, a) in openings[..second].iter().enumerate() {
                let common = |d: f64, a: f64, b: f64| (0.5 * (a + b) - d.abs()).min(a).min(b);
                let width = common(a.centre.x - b.centre.x, a.width, b.width);
                let height = common(a.centre.y - b.centre.y, a.height, b.height);
                let rounding = |a: f64, b: f64| TOUCHING * a.min(b);
                if width > rounding(a.width, b.width) && height > rounding(a.height, b.height) {
                    return Err(OpeningError::Overlap {
                        first,
                        second,
                        width,
                        height,
                    });
                }
            }
        }
        let open: f64 = openings.iter().map(Opening::area).sum();
        if !(screen_area.is_finite() && screen_area >= open * (1.0 - TOUCHING)) {
            return Err(OpeningError::Screen {
                screen: screen_area,
                open,
            });
        }
        Ok(Self {
            openings,
            screen: screen_area,
        })
    }

    /// The openings.
    #[must_use]
    pub fn openings(&self) -> &[Opening] {
        &self.openings
    }

    /// Area of the screen with its openings, m².
    #[must_use]
    pub fn screen_area(&self) -> f64 {
        self.screen
    }

    /// Area of all openings, m².
    #[must_use]
    pub fn open_area(&self) -> f64 {
        self.openings.iter().map(Opening::area).sum()
    }

    /// The fraction of the screen that is open: the albedo of empty openings, in `0.0..=1.0`.
    ///
    /// A little of it is evanescent: `λ/(π² a)` of each opening in each direction in which its width is a.
    #[must_use]
    pub fn open_fraction(&self) -> f64 {
        self.open_area() / self.screen
    }

    /// Largest separation of two points of the openings along each tangent, m.
    #[must_use]
    pub fn extent(&self) -> [f64; 2] {
        let range = |at: &dyn Fn(&Opening) -> (f64, f64)| {
            let edges = self.openings.iter().map(at);
            let low = edges.clone().map(|(c, w)| c - 0.5 * w);
            let high = edges.map(|(c, w)| c + 0.5 * w);
            high.fold(f64::NEG_INFINITY, f64::max) - low.fold(f64::INFINITY, f64::min)
        };
        [
            range(&|o| (o.centre.x, o.width)),
            range(&|o| (o.centre.y, o.height)),
        ]
    }

    /// The Jones matrix of the whole screen for a plane wave that gives it the tangential wave vector `kappa`, rad/m:
    /// `Σ T_n F_n(κ)*`, m².
    ///
    /// Jones matrices stand in `exp(+iωt)`, spatial phases are the conjugate of those of `exp(+ikr)`: the transform
    /// enters conjugated.
    #[must_use]
    pub fn jones(&self, kappa: &Vector2<f64>) -> JonesMatrix {
        let sum: nalgebra::Matrix2<Complex64> = self
            .openings
            .iter()
            .map(|o| o.jones.to_matrix() * o.fourier(kappa).conj())
            .sum();
        sum.into()
    }

    /// Visibility of the fringes of openings `first` and `second` in light of this polarization, whose degree of
    /// coherence between their middles is `gamma`, near the tangential wave vector `phi`; in `0.0..=1.0`.
    ///
    /// `2|K|/(P₁ + P₂)`: `|γ|` for two equal empty openings, `2√(P₁P₂)/(P₁ + P₂)|γ|` for unequal ones, 0 behind crossed
    /// polarizers. The coherence over each opening is taken as full. 0 in the dark.
    ///
    /// # Errors
    ///
    /// When there is no opening of that number.
    pub fn visibility(
        &self,
        [first, second]: [usize; 2],
        phi: &Vector2<f64>,
        light: StokesVector,
        gamma: Complex64,
    ) -> Result<f64, OpeningError> {
        let opening = |index: usize| {
            self.openings.get(index).ok_or(OpeningError::Value {
                what: "the number of an opening",
                value: index as f64,
                expected: "a number below that of the openings",
            })
        };
        let (a, b) = (opening(first)?, opening(second)?);
        let intensity = |a: &Opening, b: &Opening| {
            let field = a.fourier(phi) * b.fourier(phi).conj();
            let row = GeneralizedMueller::of_jones(&a.jones, &b.jones).scattering();
            let stokes = light.to_array();
            let sum: Complex64 = (0..4).map(|j| row[(0, j)] * stokes[j]).sum();
            field * sum
        };
        let total = intensity(a, a).re + intensity(b, b).re;
        let mutual = (intensity(a, b) * gamma).norm();
        Ok(if total > 0.0 {
            2.0 * mutual / total
        } else {
            0.0
        })
    }

    /// Asks whether one plane phase over the whole screen, as [`Openings::lit_by`] has it, is right for a source and a
    /// receiver at these distances (m, infinite for a star) in the media of the geometry: whether spherical waves leave it
    /// by no more than `tolerance` radians. See [`Openings::seen_between`] where not.
    ///
    /// # Errors
    ///
    /// With the phase that is left out, `k e² (n_i/s + n_o/r)/2` at the outermost corner; when a distance is not positive.
    ///
    /// Three slits over 3.7 mm are in no far field at 1 m:
    /// ```
    /// use mueller16::{Geometry, Opening, Openings, Tolerance};
    /// use nalgebra::{Vector2, Vector3};
    /// let slit = |x| Opening::clear(Vector2::new(x, 0.0), 10e-6, 10e-6);
    /// let slits = Openings::new(vec![slit(-1.85e-3), slit(0.0), slit(1.85e-3)], 1e-4)?;
    /// let green = stokes::Wavelength::from_metres(550e-9)?;
    /// let straight = Geometry::on_plane(-Vector3::z(), Vector3::z(), green)?;
    /// let one = Tolerance::relative(0.5)?;
    /// assert!(slits.check_global_phase(&straight, [f64::INFINITY, 1.0], one).is_err());
    /// // 19.7 rad at 1 m, a hundredth of it at 100 m
    /// assert!(slits.check_global_phase(&straight, [f64::INFINITY, 100.0], one).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check_global_phase(
        &self,
        geometry: &Geometry,
        [source_distance, observer]: [f64; 2],
        tolerance: Tolerance,
    ) -> Result<(), OpeningError> {
        for value in [source_distance, observer] {
            if value.is_nan() || value <= 0.0 {
                return Err(OpeningError::Value {
                    what: "a distance",
                    value,
                    expected: "a positive length",
                });
            }
        }
        let corner = |o: &Opening| {
            let x = o.centre.x.abs() + 0.5 * o.width;
            x.hypot(o.centre.y.abs() + 0.5 * o.height)
        };
        let extent = self.openings.iter().map(corner).fold(0.0, f64::max);
        let distances = [source_distance, observer];
        let indices = [geometry.n_incident(), geometry.n_outgoing()];
        let phase = curvature(distances, indices, geometry.wavelength()) * extent * extent;
        let limit = tolerance.get();
        if phase <= limit {
            return Ok(());
        }
        Err(OpeningError::GlobalPhase {
            extent,
            source_distance,
            observer,
            phase,
            limit,
        })
    }
}

/// `k (n_i/s + n_o/r)/2`: the phase per square of the distance from the axis.
pub(super) fn curvature([s, r]: [f64; 2], [n_i, n_o]: [f64; 2], wavelength: Wavelength) -> f64 {
    0.5 * wavelength.wavenumber().radians_per_metre() * (n_i / s + n_o / r)
}

/// Visibility `2√(P₁P₂)/(P₁ + P₂)|γ|` of the fringes of two beams of these powers; 0 in the dark.
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., section 10.3.
#[must_use]
pub fn fringe_visibility(powers: [f64; 2], gamma: Complex64) -> f64 {
    let [p1, p2] = powers;
    let sum = p1 + p2;
    if sum > 0.0 {
        2.0 * p1.sqrt() * p2.sqrt() / sum * gamma.norm()
    } else {
        0.0
    }
}

fn check(index: usize, opening: &Opening) -> Result<(), OpeningError> {
    let wrong = |what, value, expected| OpeningError::Number {
        index,
        what,
        value,
        expected,
    };
    for (what, value) in [("width", opening.width), ("height", opening.height)] {
        if !(1e-30..=1e30).contains(&value) {
            return Err(wrong(what, value, "a length between 1e-30 and 1e30 m"));
        }
    }
    let jones = opening.jones.to_matrix();
    let elements = jones.iter().flat_map(|z| [z.re, z.im]);
    let numbers = opening.centre.iter().map(|x| ("centre", *x));
    for (what, value) in numbers.chain(elements.map(|z| ("Jones matrix", z))) {
        if value.is_nan() || value.abs() > 1e30 {
            return Err(wrong(what, value, "a number of at most 1e30"));
        }
    }
    Ok(())
}
