//! Populations of scatterers from a file: the matter of Theorem S4.1 in the words of `interaction` and its neighbours.

use csdm::CloudeSpectrum;
use mueller16::Autocorrelation;
use serde_json::Value;
use stokes::{Envelope, Mueller};

use super::entry::Entry;
use super::fields::jones_matrix;
use super::light::envelope;
use super::matter::{AUTOCORRELATION, autocorrelation};
use super::schema::CaseError;
use crate::scene::nearest;

/// Rounding that a Mueller matrix may carry and still be taken for realizable, of its largest eigenvalue.
const REALIZABLE: f64 = 1e-9;

/// Radius, metres, of the disk in which matter without envelope is: beyond any scene.
const EVERYWHERE: f64 = 1e15;

const POPULATIONS: &str = "a list of populations";
const SIDES: &str = "'reflection' or 'transmission'";

/// Keys of a file and of a population.
const KEYS: &[&str] = &["populations", "T", "M", "sixteen", "R", "I", "side"];

/// Keys of autocorrelations, reliefs and envelopes.
#[rustfmt::skip]
const INNER_KEYS: &[&str] = &[
    "kind", "amp", "S", "weights", "S_list", "G", "orders", "g", "l", "exponent", "inner", "tolerance", "relief", "phi_z",
    "sigma", "hx", "hy", "radius", "re", "im",
];

/// Channels of one autocorrelation over one envelope, on one side of the surface.
#[derive(Clone, Debug)]
pub struct Part {
    /// Light goes on behind the surface instead of turning back.
    pub transmits: bool,
    /// Response at one point.
    pub mueller: Mueller,
    /// Autocorrelation from place to place.
    pub autocorrelation: Autocorrelation,
    /// Where it is.
    pub envelope: Envelope,
}

/// Reads `{"populations": […]}`.
///
/// # Errors
///
/// A key that is missing, unknown or of another kind; a population that no ensemble of Jones matrices makes.
pub fn populations(file: &Value) -> Result<Vec<Part>, CaseError> {
    known_keys(file, "", KEYS)?;
    let list = Entry::whole(file).get("populations", POPULATIONS)?;
    let mut parts = vec![];
    for population in list.list()? {
        parts.extend(read(&population)?);
    }
    if parts.is_empty() {
        return Err(list.refuse("found no population, expected at least one"));
    }
    Ok(parts)
}

/// Refuses keys that no reader asks for.
///
/// The keys of a grating are left to its own refusal.
fn known_keys(value: &Value, place: &str, known: &[&str]) -> Result<(), CaseError> {
    if value.get("kind").is_some_and(|kind| kind == "grating") && place.ends_with(".relief") {
        return Ok(());
    }
    match value {
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                known_keys(value, &format!("{place}[{index}]"), known)?;
            }
        }
        Value::Object(object) => {
            for (key, value) in object {
                let inner = if place.is_empty() {
                    key.clone()
                } else {
                    format!("{place}.{key}")
                };
                if !known.contains(&key.as_str()) {
                    let problem = match nearest(key, known.iter().copied()) {
                        Some(near) => format!("found an unknown key, did you mean '{near}'?"),
                        None => format!(
                            "found an unknown key, expected one of: {}",
                            known.join(", ")
                        ),
                    };
                    return Err(CaseError::Domain {
                        key: inner,
                        problem,
                    });
                }
                let known = if known == KEYS && matches!(key.as_str(), "R" | "I" | "T") {
                    INNER_KEYS
                } else {
                    known
                };
                known_keys(value, &inner, known)?;
            }
        }
        _ => {}
    }
    Ok(())
}

fn read(spec: &Entry<'_>) -> Result<Vec<Part>, CaseError> {
    let transmits = match spec.find("side")? {
        None => false,
        Some(side) => match side.word()? {
            "reflection" => false,
            "transmission" => true,
            other => return Err(side.refuse(format!("found '{other}', expected {SIDES}"))),
        },
    };
    let envelope = match spec.find("I")? {
        Some(profile) => envelope(&profile)?,
        None => Envelope::disk(EVERYWHERE).map_err(|e| spec.refuse(e))?,
    };
    let part = |mueller, autocorrelation| Part {
        transmits,
        mueller,
        autocorrelation,
        envelope: envelope.clone(),
    };
    let matrix = matrix(spec)?;
    let r = spec.get("R", AUTOCORRELATION)?;
    let Some(mueller) = matrix else {
        let channels = channels(&r)?;
        return Ok(channels.into_iter().map(|(m, r)| part(m, r)).collect());
    };
    Ok(vec![part(mueller, real_autocorrelation(&r)?)])
}

/// The one matrix of `T`, `M` or `sixteen`; `None` if there is none of them.
fn matrix(spec: &Entry<'_>) -> Result<Option<Mueller>, CaseError> {
    let mut found = None;
    for key in ["T", "M", "sixteen"] {
        let Some(entry) = spec.find(key)? else {
            continue;
        };
        if let Some((first, _)) = found {
            return Err(entry.refuse(format!("found beside '{first}', expected one of the two")));
        }
        let mueller = if key == "T" {
            jones_matrix(&entry)?.mueller()
        } else {
            Mueller::from_rows(entry.array_of(|row| row.array_of(Entry::number))?)
        };
        if key == "M" {
            let spectrum = CloudeSpectrum::of(&mueller).map_err(|e| entry.refuse(e))?;
            spectrum
                .check_realizable(REALIZABLE)
                .map_err(|e| entry.refuse(e))?;
        }
        found = Some((key, mueller));
    }
    Ok(found.map(|(_, mueller)| mueller))
}

/// Four rows l of four channels j → l, null where there is none.
fn channels(rows: &Entry<'_>) -> Result<Vec<(Mueller, Autocorrelation)>, CaseError> {
    if !rows.is_list() {
        return Err(rows.refuse(
            "found one autocorrelation without a matrix, expected 'T', 'M' or 'sixteen' beside it, \
             or four rows of four autocorrelations or nulls",
        ));
    }
    let mut channels = vec![];
    for (l, row) in rows.array::<4>()?.iter().enumerate() {
        for (j, spec) in row.array::<4>()?.iter().enumerate() {
            if !spec.is_null() {
                let mut one = [[0.0; 4]; 4];
                one[l][j] = 1.0;
                channels.push((Mueller::from_rows(one), real_autocorrelation(spec)?));
            }
        }
    }
    Ok(channels)
}

/// Refuses reliefs of infinitely many sharp orders.
fn without_grating(spec: &Entry<'_>) -> Result<(), CaseError> {
    if let Some(relief) = spec.find("relief")?
        && let Some(kind) = relief.find("kind")?
        && kind.word()? == "grating"
    {
        return Err(kind.refuse(
            "found a grating, which has sharp orders without end, expected other heights; \
             a few orders are an autocorrelation of the kind 'orders'",
        ));
    }
    Ok(())
}

/// An autocorrelation whose amplitude is real, as that of all matter.
fn real_autocorrelation(spec: &Entry<'_>) -> Result<Autocorrelation, CaseError> {
    without_grating(spec)?;
    let (amplitude, r) = autocorrelation(spec)?;
    if amplitude.im != 0.0 {
        return Err(spec.refuse(format!(
            "found the amplitude {amplitude}, expected a real number: an order's phase is its place, 'orders'"
        )));
    }
    Ok(r.scaled(amplitude.re))
}
