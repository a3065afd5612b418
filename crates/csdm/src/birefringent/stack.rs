//! Stacks of crystal layers between half-spaces: Jones and Mueller matrices from both sides.

use nalgebra::{Matrix2, Matrix4};
use num_complex::Complex64;
use stokes::{Mueller, Wavelength};

use super::crystal::{Crystal, CrystalError};
use super::generator::Generator;
use super::half_space::{Directions, HalfSpace};
use super::scattering::Scattering;
use crate::JonesMatrix;
use crate::fresnel::{self, normal_index_of};
use crate::layered::{
    self, FilmError, Medium, checked_index, checked_thickness, transparent_index,
};

/// A plane-parallel layer of a crystal.
#[derive(Clone, Debug, PartialEq)]
pub struct CrystalLayer {
    /// The medium, its axes in plate axes.
    pub crystal: Crystal,
    /// Thickness in metres.
    pub thickness: f64,
}

/// Crystal layers between an isotropic incident and an isotropic exit half-space.
///
/// A quarter-wave plate of quartz with its axis at 45° between polarizers, laser light at normal incidence:
/// ```
/// use csdm::birefringent::{Crystal, CrystalLayer, CrystalStack, Incidence};
/// use nalgebra::Vector3;
/// let light = stokes::Wavelength::from_metres(589.3e-9)?;
/// let (ordinary, extraordinary) = (1.54424, 1.55335);
/// let crystal = Crystal::uniaxial(ordinary.into(), extraordinary.into(), Vector3::new(1.0, 1.0, 0.0))?;
/// let thickness = 589.3e-9 / (4.0 * (extraordinary - ordinary));
/// let plate = CrystalStack::new(1.55, vec![CrystalLayer { crystal, thickness }], 1.55.into())?;
/// let direct = plate.single_pass(&Incidence::new(1.0, 0.0)?, light);
/// // the slow axis is at 45°: horizontal light becomes left circular but for 1e-5 of reflected light
/// let out = direct.front.transmission_mueller()? * stokes::StokesVector::HORIZONTAL;
/// assert!((out.s3() + 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CrystalStack {
    incident: f64,
    layers: Vec<CrystalLayer>,
    exit: Complex64,
}

/// A direction of incidence: angle to the normal, and azimuth of the s axis in the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incidence {
    cos_i: f64,
    sin_i: f64,
    azimuth: f64,
}

/// Jones matrices of a stack for light from one side, from `(E_s, E_p)` to `(E_s, E_p)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JonesSide {
    /// Of reflection; the plane of reference is the face that is met first.
    pub reflection: JonesMatrix,
    /// Of transmission, electric field behind the last face to electric field before the first, no power weights.
    pub transmission: JonesMatrix,
    /// `[s, p]`: power behind the stack is this times the squared amplitude. Infinite at grazing incidence.
    pub power_weight: [f64; 2],
    exit: Complex64,
}

/// Jones matrices of a stack for light from both sides, with the same tangential wave vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateJones {
    /// For light that comes along +z.
    pub front: JonesSide,
    /// For light that comes along −z; `None` where the exit medium carries no waves: it absorbs, or totally reflects.
    pub back: Option<JonesSide>,
}

/// Mueller matrices of a stack for light from one side, power weights included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuellerSide {
    /// Of reflection.
    pub reflection: Mueller,
    /// Of transmission; zero where the exit medium totally reflects.
    pub transmission: Mueller,
}

/// Mueller matrices of a stack for light from both sides, with the same tangential wave vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateMueller {
    /// For light that comes along +z.
    pub front: MuellerSide,
    /// For light that comes along −z; `None` where the exit medium totally reflects.
    pub back: Option<MuellerSide>,
}

impl Incidence {
    /// Light at an angle of cosine `cos_i`, `0.0..=1.0`, to the normal, its s axis at `azimuth` radians from the x axis
    /// of the plate toward y.
    ///
    /// # Errors
    ///
    /// When the cosine is out of range or the azimuth not finite.
    pub fn new(cos_i: f64, azimuth: f64) -> Result<Self, CrystalError> {
        if (0.0..=1.0).contains(&cos_i) && azimuth.is_finite() {
            let sin_i = ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
            Ok(Self {
                cos_i,
                sin_i,
                azimuth,
            })
        } else {
            Err(CrystalError::Incidence { cos_i, azimuth })
        }
    }

    /// As [`Incidence::new`], for an angle of which the sine is known too.
    ///
    /// Tilted crystals notice the sine, of which the cosine of light near the normal tells 1e-16/sine and at worst 2e-8.
    ///
    /// # Errors
    ///
    /// As [`Incidence::new`]; when the sine is not a number between 0 and 1, or the two are not of one angle (to 1e-5).
    pub fn with_sine(cos_i: f64, sin_i: f64, azimuth: f64) -> Result<Self, CrystalError> {
        let checked = Self::new(cos_i, azimuth)?;
        let squares = cos_i * cos_i + sin_i * sin_i;
        if (0.0..=1.0).contains(&sin_i) && (squares - 1.0).abs() <= 1e-5 {
            Ok(Self { sin_i, ..checked })
        } else {
            Err(CrystalError::Sine { cos_i, sin_i })
        }
    }

    /// Cosine of the angle of incidence.
    #[must_use]
    pub fn cos_i(&self) -> f64 {
        self.cos_i
    }

    /// Angle in radians from the x axis of the plate to the s axis, toward y.
    #[must_use]
    pub fn azimuth(&self) -> f64 {
        self.azimuth
    }

    /// ξ = n₁ sin θ₁.
    pub(super) fn tangential_index(&self, n1: f64) -> f64 {
        n1 * self.sin_i
    }
}

impl CrystalStack {
    /// The stack of `layers`, the first one next to the incident medium of index `incident`, the last one next to the
    /// exit medium of index `exit`.
    ///
    /// # Errors
    ///
    /// When an index is not `η − ik` with `η, k ≥ 0` and a modulus between 1e-8 and 1e8 (k = 0 for the incident
    /// medium), or a thickness not between 0 and 1e6 m.
    pub fn new(
        incident: f64,
        layers: Vec<CrystalLayer>,
        exit: Complex64,
    ) -> Result<Self, FilmError> {
        for (number, layer) in layers.iter().enumerate() {
            checked_thickness(layer.thickness, Medium::Layer(number))?;
        }
        Ok(Self {
            incident: transparent_index(incident.into(), Medium::Incident)?,
            layers,
            exit: checked_index(exit, Medium::Exit)?,
        })
    }

    /// The same stack with every layer thicker by a factor.
    ///
    /// # Errors
    ///
    /// When a thickness is then not between 0 and 1e6 m.
    pub fn thickened(&self, factor: f64) -> Result<Self, FilmError> {
        let layers = self.layers.iter().map(|layer| CrystalLayer {
            crystal: layer.crystal.clone(),
            thickness: layer.thickness * factor,
        });
        Self::new(self.incident, layers.collect(), self.exit)
    }

    /// Jones matrices with all internal reflections in phase.
    ///
    /// Source and accuracy: the page of [`crate::birefringent`]. Power is conserved to 1e-13 in lossless stacks, and to
    /// that times the finesse where evanescent layers make a resonator. In media of equal index without layers the
    /// error grows as `f64::EPSILON/cos_i` toward grazing incidence.
    #[must_use]
    pub fn coherent(&self, incidence: &Incidence, wavelength: Wavelength) -> PlateJones {
        if let Some(all) = self.coherent_by_waves(incidence, wavelength) {
            return self.jones(&all, incidence);
        }
        let layers = self
            .layers
            .iter()
            .fold(Scattering::transparent(), |front, layer| {
                front.then(&self.layer(layer, incidence, wavelength))
            });
        let [before, behind] = self.half_spaces(incidence);
        self.jones(&layers.between(&before, &behind), incidence)
    }

    /// The same face by face, where the waves of all layers have a closed form and the layers are thin: rounding adds
    /// power in proportion to the thickness.
    fn coherent_by_waves(
        &self,
        incidence: &Incidence,
        wavelength: Wavelength,
    ) -> Option<Scattering<Complex64, 2>> {
        const DEEPEST: f64 = 100.0;
        let [mut last, behind] = self.half_spaces(incidence);
        let xi = incidence.tangential_index(self.incident);
        let mut all = Scattering::transparent();
        for layer in &self.layers {
            let directions = Directions::of_uniaxial(&layer.crystal, xi, incidence.azimuth)?;
            let depth = layered::optical_depth(layer.thickness, wavelength);
            if depth > DEEPEST {
                return None;
            }
            all = all
                .then(&Scattering::face(&last, &directions.waves))
                .before_clear(&directions.propagation(depth));
            last = directions.waves;
        }
        Some(all.then(&Scattering::face(&last, &behind)))
    }

    /// Jones matrices of the direct light: transmitted by every face, reflected by none, and the reflection of the face
    /// that is met first.
    ///
    /// Fresnel losses are included; in a medium that matches the plate's index there are none.
    #[must_use]
    pub fn single_pass(&self, incidence: &Incidence, wavelength: Wavelength) -> PlateJones {
        let [before, behind] = self.half_spaces(incidence);
        let xi = incidence.tangential_index(self.incident);
        let (mut direct, mut last) = (Scattering::transparent(), before);
        let mut first_reflection = None;
        for layer in &self.layers {
            let directions = Directions::new(&layer.crystal, xi, incidence.azimuth);
            let face = Scattering::face(&last, &directions.waves);
            first_reflection.get_or_insert(face.reflection);
            let depth = layered::optical_depth(layer.thickness, wavelength);
            direct = direct
                .passing(&face)
                .passing(&directions.propagation(depth));
            last = directions.waves;
        }
        let face = Scattering::face(&last, &behind);
        let mut all = direct.passing(&face);
        all.reflection = first_reflection.unwrap_or(face.reflection);
        all.back_reflection = face.back_reflection;
        self.jones(&all, incidence)
    }

    /// Mueller matrices with the powers of internal reflections added where a layer is thicker than `coherent_below`
    /// metres, and their fields added in thinner ones, which act as coatings of the thick layers.
    ///
    /// `M = T₂ P (1 − R₁ P' R₂ P)⁻¹ T₁`: the average of the coherent matrices over an independent phase common to both
    /// waves of every thick layer. The retardance between the two waves is kept, and with it interference between waves
    /// reflected equally often.
    ///
    /// A layer so thin that an evanescent wave crosses it should be counted as coherent: a power of its own is not
    /// carried by such a wave. Source: the geometric series of bounces, each with the Mueller matrix of its Jones
    /// matrix.
    ///
    /// # Errors
    ///
    /// When the exit medium absorbs: transmitted light has no Mueller matrix there.
    ///
    /// A window of index 1.5 reflects 2R/(1 + R) = 7.69 %, R = 4 %:
    /// ```
    /// use csdm::birefringent::{Crystal, CrystalLayer, CrystalStack, Incidence};
    /// let window = CrystalLayer { crystal: Crystal::isotropic(1.5.into())?, thickness: 1e-3 };
    /// let window = CrystalStack::new(1.0, vec![window], 1.0.into())?;
    /// let green = stokes::Wavelength::from_metres(550e-9)?;
    /// let all = window.incoherent(&Incidence::new(1.0, 0.0)?, green, 0.0)?;
    /// assert!((all.front.reflection.to_matrix()[(0, 0)] - 0.08 / 1.04).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn incoherent(
        &self,
        incidence: &Incidence,
        wavelength: Wavelength,
        coherent_below: f64,
    ) -> Result<PlateMueller, FilmError> {
        if self.exit.im != 0.0 {
            return Err(FilmError::AbsorbingExit { k: -self.exit.im });
        }
        let [mut last, behind] = self.half_spaces(incidence);
        let xi = incidence.tangential_index(self.incident);
        let mut sum: Option<Scattering<f64, 4>> = None;
        let mut coating: Option<Scattering<Complex64, 2>> = None;
        let after = |sum: Option<Scattering<f64, 4>>, face: Scattering<Complex64, 2>| match sum {
            Some(sum) => sum.then(&face.mueller()),
            None => face.mueller(),
        };
        let face = |coating: Option<Scattering<Complex64, 2>>, last: &_, next: &_| match coating {
            Some(coating) => coating.between(last, next),
            None => Scattering::face(last, next),
        };
        for layer in &self.layers {
            if layer.thickness <= coherent_below {
                let layer = self.layer(layer, incidence, wavelength);
                coating = Some(coating.map_or(layer, |coating| coating.then(&layer)));
                continue;
            }
            let directions = Directions::new(&layer.crystal, xi, incidence.azimuth);
            let depth = layered::optical_depth(layer.thickness, wavelength);
            let entered = after(sum, face(coating.take(), &last, &directions.waves));
            sum = Some(entered.before_clear(&directions.propagation(depth).mueller()));
            last = directions.waves;
        }
        let sum = after(sum, face(coating, &last, &behind));
        let (grazing, w) = self.normal_indices(incidence);
        let side = |reflection, transmission: Matrix4<f64>, weight: f64| MuellerSide {
            reflection: Mueller::from(reflection),
            transmission: Mueller::from(if weight.is_finite() {
                transmission * weight
            } else {
                Matrix4::zeros()
            }),
        };
        Ok(PlateMueller {
            front: side(sum.reflection, sum.transmission, w.re / grazing),
            back: (w.re > 0.0)
                .then(|| side(sum.back_reflection, sum.back_transmission, grazing / w.re)),
        })
    }

    /// One layer, all reflections at imagined faces to vacuum at normal incidence included.
    fn layer(
        &self,
        layer: &CrystalLayer,
        incidence: &Incidence,
        wavelength: Wavelength,
    ) -> Scattering<Complex64, 2> {
        let xi = incidence.tangential_index(self.incident);
        let generator = Generator::new(&layer.crystal, xi, incidence.azimuth);
        let depth = layered::optical_depth(layer.thickness, wavelength);
        Scattering::of_layer(&generator, depth, layer.crystal.is_lossless())
    }

    /// `n₁ cos θ₁` and the exit medium's `n cos θ`.
    fn normal_indices(&self, incidence: &Incidence) -> (f64, Complex64) {
        let n1 = self.incident;
        let w = normal_index_of(n1.into(), self.exit, incidence.cos_i);
        (n1 * incidence.cos_i, w)
    }

    fn half_spaces(&self, incidence: &Incidence) -> [HalfSpace; 2] {
        let (grazing, w) = self.normal_indices(incidence);
        [
            HalfSpace::isotropic(self.incident.into(), grazing.into()),
            HalfSpace::isotropic(self.exit, w),
        ]
    }

    fn jones(&self, all: &Scattering<Complex64, 2>, incidence: &Incidence) -> PlateJones {
        let (grazing, w) = self.normal_indices(incidence);
        let jones =
            |m: &Matrix2<Complex64>| JonesMatrix::new(m[(0, 0)], m[(0, 1)], m[(1, 0)], m[(1, 1)]);
        // the limit of grazing light does not depend on the layers
        let (reflection, transmission) = if grazing == 0.0 {
            (-Matrix2::identity(), Matrix2::zeros())
        } else {
            (all.reflection, all.transmission)
        };
        PlateJones {
            front: JonesSide {
                reflection: jones(&reflection),
                transmission: jones(&transmission),
                power_weight: fresnel::power_weight(self.incident, self.exit, incidence.cos_i),
                exit: self.exit,
            },
            back: (self.exit.im == 0.0 && w.re > 0.0).then(|| JonesSide {
                reflection: jones(&all.back_reflection),
                transmission: jones(&all.back_transmission),
                power_weight: [grazing / w.re; 2],
                exit: self.incident.into(),
            }),
        }
    }
}

impl JonesSide {
    /// The Mueller matrix of reflection.
    #[must_use]
    pub fn reflection_mueller(&self) -> Mueller {
        self.reflection.mueller()
    }

    /// The Mueller matrix of transmission, power weight included; zero where the exit medium totally reflects.
    ///
    /// The change of radiance with the solid angle is not in it.
    ///
    /// # Errors
    ///
    /// When the medium behind absorbs: then s and p carry power with different weights.
    pub fn transmission_mueller(&self) -> Result<Mueller, FilmError> {
        layered::transmission_mueller(&self.transmission, self.power_weight[0], self.exit)
    }
}
