//! A grating from its parameters, and what the user should know of them.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use mueller16::{Blaze, Profile};

use super::lines::{Across, Lines};
use super::lobes::Lobes;
use super::shares::Shares;
use super::{Boundary, Doubt, Grating};
use crate::material::conductor::Metal;
use crate::material::dielectric::{Faces, glass_parameter};
use crate::scene::{Object, SceneError};

/// Shortest wavelength for which shares are tabulated, metres; below they are computed each time.
const SHORTEST: f64 = 300e-9;

/// Range of pitches, metres: from far below any wavelength to as many orders as can be looked through.
const PITCHES: std::ops::RangeInclusive<f64> = 1e-9..=1e-3;

/// A coherent size beyond which lobes are narrower than single precision tells directions apart, metres.
const LARGEST_SIZE: f64 = 0.02;

impl Grating {
    /// Reads its parameters.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let boundary = read_boundary(object)?;
        // φ_z ≤ 2 k n, and orders reach as far
        let highest = 2.0 * TAU / SHORTEST * boundary.largest_index();
        let shares = |pitch: f64, profile: Profile| {
            let last = (highest * pitch / TAU).ceil() as i32;
            Shares::new(profile, highest, last)
        };
        let pitch = positive(object, "pitch", None)?;
        let profile = read_profile(object, "", None)?;
        let mut depth = profile.depth();
        let mut shortest = pitch;
        let second = if object.has("pitch_v") {
            let pitch_v = positive(object, "pitch_v", None)?;
            let other = read_profile(object, "_v", Some(&profile))?;
            depth += other.depth();
            shortest = shortest.min(pitch_v);
            Some((pitch_v, shares(pitch_v, other)))
        } else {
            None
        };
        notice_depth(object, shortest, depth);
        Ok(Self {
            doubts: doubts(object, shortest * boundary.largest_index()),
            lines: Lines {
                across: read_direction(object)?,
                pitch,
                shares: shares(pitch, profile),
                second,
            },
            lobes: read_lobes(object)?,
            capped: object.choice("sharing", "capped", &["capped", "phase"])? == "capped",
            boundary,
        })
    }
}

/// A positive length that the file must give, or the default.
fn positive(object: &Object, name: &str, default: Option<f64>) -> Result<f64, SceneError> {
    let value = object.micro_length(name, default)?.ok_or_else(|| {
        object.error(format!(
            "{} has no parameter '{name}', expected a length such as '1.6um'",
            object.describe()
        ))
    })?;
    if PITCHES.contains(&value) {
        Ok(value)
    } else {
        Err(object.error_at(
            name,
            format!(
                "'{name}' of {} is {value:e} m, expected a length from 1 nm to 1 mm",
                object.describe()
            ),
        ))
    }
}

fn read_profile(
    object: &Object,
    suffix: &str,
    first: Option<&Profile>,
) -> Result<Profile, SceneError> {
    let name = |stem: &str| format!("{stem}{suffix}");
    let shapes = ["sinusoidal", "lamellar", "blazed", "triangular"];
    let of_first = |stem: &str| first.is_some() && !object.has(&name(stem)) && object.has(stem);
    // what the second lines do not say is as of the first
    let pick = |stem: &str| {
        if of_first(stem) {
            stem.to_owned()
        } else {
            name(stem)
        }
    };
    let kind = object.choice(&pick("profile"), "sinusoidal", &shapes)?;
    let depth_name = pick("depth");
    let depth = object.micro_length(&depth_name, None)?.ok_or_else(|| {
        object.error(format!(
            "{} has no parameter 'depth', expected a length such as '120nm'",
            object.describe()
        ))
    })?;
    let profile = match kind.as_str() {
        "lamellar" => Profile::lamellar(depth, object.float(&pick("duty"), 0.5)?),
        "blazed" => Profile::blazed(depth, Blaze::Rising),
        "triangular" => Profile::triangular(depth, object.float(&pick("apex"), 0.5)?),
        _ => Profile::sinusoidal(depth),
    };
    let profile = profile.map_err(|e| {
        let at = match &e {
            mueller16::GratingError::Value { what, .. } if *what == "ridge fraction" => {
                pick("duty")
            }
            mueller16::GratingError::Value { what, .. } if *what == "apex" => pick("apex"),
            _ => depth_name,
        };
        object.error_at(&at, e)
    })?;
    Ok(profile)
}

fn read_direction(object: &Object) -> Result<Across, SceneError> {
    let Some(vector) = object.optional_vector("direction")? else {
        let angle = object.float("angle", 0.0)?;
        return Ok(Across::Local(DVec2::from_angle(angle.to_radians())));
    };
    if object.has("angle") {
        return Err(object.error_at(
            "angle",
            "both 'angle' and 'direction' are given, expected one of them",
        ));
    }
    let vector = DVec3::from(vector);
    match vector.try_normalize() {
        Some(direction) => Ok(Across::World(direction)),
        None => Err(object.error_at(
            "direction",
            "'direction' is along nothing, expected a vector across the grooves",
        )),
    }
}

fn read_lobes(object: &Object) -> Result<Lobes, SceneError> {
    let height = object.micro_length("height", Some(0.0))?.unwrap_or(0.0);
    if !(0.0..=1e-3).contains(&height) {
        return Err(object.error_at(
            "height",
            format!("an rms height of {height:e} m, expected a length from 0 to 1 mm"),
        ));
    }
    let length = if height > 0.0 || object.has("length") {
        positive(object, "length", None)?
    } else {
        1.0
    };
    let size = match object.micro_length("size", None)? {
        None => f64::INFINITY,
        Some(size) if size > 0.0 => {
            if size > LARGEST_SIZE {
                object.notice_at(
                    "size",
                    format!(
                        "a coherent size of {size} m makes lobes narrower than directions can be told apart; \
                         leave 'size' out for sharp orders"
                    ),
                );
            }
            size
        }
        Some(size) => {
            return Err(object.error_at(
                "size",
                format!("a coherent size of {size} m, expected a positive length"),
            ));
        }
    };
    Ok(Lobes {
        height,
        length,
        size,
    })
}

fn read_boundary(object: &Object) -> Result<Boundary, SceneError> {
    Ok(match glass_parameter(object)? {
        None => Boundary::Metal(Metal::read(object)?),
        Some(_) => Boundary::Glass(Faces::read(object, "bk7")?),
    })
}

/// Wavelengths, in the denser medium, for which a pitch is too short; `optical` is the pitch times the index there.
fn doubts(object: &Object, optical: f64) -> [Doubt; 2] {
    let nm = |length: f64| (length * 1e9).round();
    let doubt = |beyond: f64, message: String| Doubt {
        beyond: beyond * 1e9,
        text: object.error_at("pitch", message).to_string(),
    };
    let (alone, trusted) = (2.0 * optical, optical / 5.0);
    [
        doubt(
            alone,
            format!(
                "only order 0 propagates above {} nm; there the surface acts as a birefringent layer, which scalar \
                 grating theory does not describe",
                nm(alone)
            ),
        ),
        doubt(
            trusted,
            format!(
                "scalar grating theory is good for pitches above five wavelengths: here below {} nm; beyond, directions \
                 are right and efficiencies approximate",
                nm(trusted)
            ),
        ),
    ]
}

/// Says that scalar theory is not to be trusted for deep grooves.
fn notice_depth(object: &Object, pitch: f64, depth: f64) {
    if depth > 0.25 * pitch {
        object.notice_at(
            "depth",
            format!(
                "a depth of {:.2} pitches; scalar grating theory is good below a quarter: directions are right and \
                 efficiencies approximate",
                depth / pitch
            ),
        );
    }
}
