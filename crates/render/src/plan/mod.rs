//! What a scene needs, worked out when it is loaded; paths follow that and no more.
//!
//! A plan comes from the light sources, the matter that shapes are made of, the length of paths and what the user asks
//! for. Skipping is exact: what is left out could only have added zeros, or the same number again, and no random number
//! is used in another way for it. `--no-skip` follows all of it; the image is the same within rounding.
//!
//! The compiler makes an integrator for each kind of scene: S0, three or four Stokes components, one wavelength or four. `polarization.rs` decides on Stokes components, `spectral.rs` on wavelengths, `rays.rs` on what rays look for.

mod polarization;
mod rays;
mod spectral;
#[cfg(test)]
mod tests;

use std::fmt;

use crate::emitter::Emitter;
use crate::film::SpectralMode;
use crate::material::{Material, Traits};
use crate::scene::{BuiltScene, Scene};

pub use spectral::Wavelengths;

/// What the user asks for, as far as it decides what is followed.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Which wavelengths the image shows.
    pub mode: &'a SpectralMode,
    /// Whether the image has four components, or S0 alone by scalar transport.
    pub polarized: bool,
    /// Whether the coherence of the light at the sensor is asked for.
    pub coherence: bool,
    /// Whether to skip what the scene does not need.
    pub skip: bool,
}

/// Stokes components that are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// S0, by scalar transport.
    Intensity,
    /// S0, S1, S2: no light is circular.
    Linear,
    /// All four.
    All,
}

/// What is followed, and why.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Which Stokes components are followed; the others are zero.
    pub stokes: Components,
    /// How paths carry wavelengths.
    pub wavelengths: Wavelengths,
    /// Whether light and matter are the same at all wavelengths of the image: its colours are known beforehand.
    pub grey: bool,
    /// Whether there is no light at all: nothing is traced.
    pub dark: bool,
    decisions: Vec<Decision>,
}

impl Plan {
    /// What a scene needs for a request.
    pub fn of(built: &BuiltScene, request: &Request<'_>) -> Self {
        let stock = Stock::of(built);
        let mut plan = Self::in_full(&built.scene, request.mode, request.polarized);
        let (stokes, mut decisions) = polarization::decide(&stock, request);
        let (wavelengths, spectral) = spectral::decide(&stock, request);
        decisions.extend(spectral);
        decisions.extend(rays::decide(&stock, request));
        plan.grey = wavelengths == Wavelengths::One && request.mode.colours() > 1;
        if request.skip {
            plan.stokes = stokes;
            plan.wavelengths = wavelengths;
            plan.dark = built.scene.emitters.is_empty();
        } else {
            decisions.iter_mut().for_each(Decision::follow);
        }
        plan.decisions = decisions;
        plan
    }

    /// Everything that an image can show of a scene, whether the scene needs it or not.
    pub fn in_full(scene: &Scene, mode: &SpectralMode, polarized: bool) -> Self {
        Self {
            stokes: if polarized {
                Components::All
            } else {
                Components::Intensity
            },
            wavelengths: Wavelengths::in_full(scene, mode),
            grey: false,
            dark: false,
            decisions: Vec::new(),
        }
    }

    /// What was skipped and what was kept, one line each.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }
}

/// What became of a part of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Kept,
    /// Left out, as it cannot change the image.
    Skipped,
    /// Nobody asks for it, or there is nothing of it.
    Absent,
}

/// A part of the work, and why it is done or not.
#[derive(Clone, Debug)]
pub struct Decision {
    what: String,
    verdict: Verdict,
    reason: String,
}

impl Decision {
    fn new(verdict: Verdict, what: &str, reason: String) -> Self {
        Self {
            what: what.to_owned(),
            verdict,
            reason,
        }
    }

    fn kept(what: &str, reason: impl Into<String>) -> Self {
        Self::new(Verdict::Kept, what, reason.into())
    }

    fn skipped(what: &str, reason: impl Into<String>) -> Self {
        Self::new(Verdict::Skipped, what, reason.into())
    }

    fn absent(what: &str, reason: impl Into<String>) -> Self {
        Self::new(Verdict::Absent, what, reason.into())
    }

    /// Follows all the same what could have been skipped.
    fn follow(&mut self) {
        if self.verdict == Verdict::Skipped {
            self.verdict = Verdict::Kept;
            self.reason += "; followed all the same (--no-skip)";
        }
    }

    /// `kept` or `skipped`.
    pub fn verdict(&self) -> &'static str {
        match self.verdict {
            Verdict::Kept => "kept",
            Verdict::Skipped | Verdict::Absent => "skipped",
        }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.reason)
    }
}

/// A scene, and the matter in it that shapes are made of.
struct Stock<'a> {
    built: &'a BuiltScene,
    /// Indices of materials that paths can meet.
    used: Vec<u32>,
}

impl<'a> Stock<'a> {
    fn of(built: &'a BuiltScene) -> Self {
        Self {
            built,
            used: built.scene.used_materials(),
        }
    }

    /// All matter in use, with its name.
    fn matter(&self) -> impl Iterator<Item = (&'a Material, Traits, &'a str)> {
        let built = self.built;
        self.used.iter().map(move |&index| {
            let place = index as usize;
            let name = built.material_names.get(place).map_or("matter", |n| n);
            (
                &built.scene.materials[place],
                built.scene.traits_of(index),
                name,
            )
        })
    }

    /// The first matter of a kind.
    fn who(&self, is: impl Fn(&Material, Traits) -> bool) -> Option<&'a str> {
        let mut matter = self.matter();
        matter
            .find(|(material, traits, _)| is(material, *traits))
            .map(|found| found.2)
    }

    /// The first emitter of a kind.
    fn which_light(&self, is: impl Fn(&Emitter) -> bool) -> Option<String> {
        let emitters = self.built.scene.emitters.iter();
        emitters
            .zip(&self.built.emitter_names)
            .find(|(emitter, _)| is(emitter))
            .map(|(_, name)| format!("emitter {name}"))
    }

    /// Vertices of the longest path on matter: one of length d has d − 1.
    fn vertices(&self) -> u32 {
        self.built.paths.max_depth.saturating_sub(1)
    }
}
