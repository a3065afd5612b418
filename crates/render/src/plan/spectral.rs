//! How paths carry wavelengths, and why.

use super::{Decision, Request, Stock};
use crate::film::SpectralMode;
use crate::material::Matter;
use crate::scene::Scene;

/// How paths carry the wavelengths of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wavelengths {
    /// One path at one wavelength serves all colours.
    One,
    /// A path for each wavelength.
    Apart,
    /// Several wavelengths on one path.
    Together,
}

impl Wavelengths {
    /// Where all wavelengths of an image are followed.
    pub(super) fn in_full(scene: &Scene, mode: &SpectralMode) -> Self {
        match mode {
            SpectralMode::Single(_) => Self::One,
            _ if scene.traits().disperses => Self::Apart,
            _ => Self::Together,
        }
    }
}

/// How wavelengths are carried, and what is said of it.
pub(super) fn decide(stock: &Stock<'_>, request: &Request<'_>) -> (Wavelengths, Vec<Decision>) {
    const ALL: &str = "wavelengths";
    const OTHERS: &str = "all wavelengths but one";
    const SHARED: &str = "a path for each wavelength";
    if let SpectralMode::Single(nm) = request.mode {
        let only = Decision::absent(OTHERS, format!("{nm} nm is asked for"));
        return (Wavelengths::One, vec![only]);
    }
    let [from, to] = request.mode.range();
    let full = Wavelengths::in_full(&stock.built.scene, request.mode);
    let light = stock.which_light(|emitter| !emitter.is_grey([from, to]));
    let matter = stock.who(|material, _| !material.is_grey([from, to]));
    let needed = match (&light, matter) {
        (Some(light), _) => format!("{light} depends on them"),
        (None, Some(matter)) => format!("{matter} depends on them"),
        (None, None) if request.coherence => "the coherence asked for depends on them".to_owned(),
        (None, None) => {
            let grey = format!("light and matter are the same from {from} to {to} nm");
            return (Wavelengths::One, vec![Decision::skipped(OTHERS, grey)]);
        }
    };
    let shared = match stock.who(|_, traits| traits.disperses) {
        Some(matter) => Decision::kept(SHARED, format!("{matter} sends them different ways")),
        None => Decision::absent(
            SHARED,
            "no matter sends them different ways; four share one",
        ),
    };
    (full, vec![Decision::kept(ALL, needed), shared])
}
