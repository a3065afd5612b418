//! The operation `slits`: rectangular openings in a screen under partially coherent light.

use csdm::JonesMatrix;
use mueller16::{AngularSpectrum, Geometry, LitOpenings, Opening, Openings};
use nalgebra::Vector3;
use stokes::{StokesVector, Wavelength};

use super::entry::{DIRECTION, Entry, VECTOR};
use super::fields::{jones_matrix, number, wavelength};
use super::relief::tolerance;
use super::result::Item;
use super::schema::CaseError;
use super::surface::{angles, gaussian};

const LIGHTS: &str = "'plane_wave', 'gaussian', 'rectangle' or 'disk'";
const OBSERVERS: &str = "a list of directions";

pub(super) fn slits(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let list = inputs.get("openings", "a list of openings")?.list()?;
    let openings = list.iter().map(opening).collect::<Result<_, _>>()?;
    let screen = Openings::new(openings, number(inputs, "screen_area")?);
    let screen = screen.map_err(|e| inputs.refuse(e))?;
    let geometries = geometries(inputs)?;
    let Some(geometry) = geometries.first() else {
        return Err(inputs.refuse("found no direction under 'to_observers', expected at least one"));
    };
    let light = light(inputs, geometry, &screen)?;
    let lit = screen.lit_by(&light).map_err(|e| inputs.refuse(e))?;
    let transfers = geometries
        .iter()
        .map(|geometry| transfer(inputs, &lit, geometry));
    let mut results = vec![
        ("M", Item::List(transfers.collect::<Result<_, _>>()?)),
        ("open_fraction", screen.open_fraction().into()),
        ("error", light.error().into()),
    ];
    if let Some(pair) = inputs.find("pair")? {
        results.extend(fringes(inputs, &pair, &screen, &light, &geometries)?);
    }
    Ok(Item::Group(results))
}

fn opening(spec: &Entry<'_>) -> Result<Opening, CaseError> {
    let jones = match spec.find("T")? {
        Some(jones) => jones_matrix(&jones)?,
        None => JonesMatrix::identity(),
    };
    Ok(Opening {
        centre: spec.get("centre", VECTOR)?.vector()?,
        width: number(spec, "width")?,
        height: number(spec, "height")?,
        jones,
    })
}

/// One encounter for each observer.
fn geometries(inputs: &Entry<'_>) -> Result<Vec<Geometry>, CaseError> {
    let to_source = inputs.get("to_source", DIRECTION)?.direction()?;
    let lambda = wavelength(inputs)?;
    let index = |key| inputs.find(key)?.map_or(Ok(1.0), |entry| entry.number());
    let indices = [index("n_incident")?, index("n_outgoing")?];
    let observers = inputs.get("to_observers", OBSERVERS)?.list()?;
    let geometry = |entry: &Entry<'_>| encounter(to_source, entry, lambda, indices);
    observers.iter().map(geometry).collect()
}

fn encounter(
    to_source: Vector3<f64>,
    to_observer: &Entry<'_>,
    lambda: Wavelength,
    [incident, outgoing]: [f64; 2],
) -> Result<Geometry, CaseError> {
    Geometry::on_plane(to_source, to_observer.direction()?, lambda)
        .and_then(|found| found.between(incident, outgoing))
        .map_err(|e| to_observer.refuse(e))
}

fn light(
    inputs: &Entry<'_>,
    geometry: &Geometry,
    screen: &Openings,
) -> Result<AngularSpectrum, CaseError> {
    let Some(light) = inputs.find("light")? else {
        return Ok(AngularSpectrum::plane_wave());
    };
    let (extent, tolerance) = (screen.extent(), tolerance(inputs)?);
    let wavenumber = geometry.wavelength().wavenumber().radians_per_metre();
    let spread = || Ok::<_, CaseError>(angles(&light)? * (wavenumber * geometry.n_incident()));
    let kind = light.get("kind", LIGHTS)?;
    match kind.word()? {
        "plane_wave" => Ok(AngularSpectrum::plane_wave()),
        "gaussian" => {
            let coherence = gaussian(&light, geometry)?;
            AngularSpectrum::of_coherence(&coherence, extent, tolerance)
        }
        "rectangle" => AngularSpectrum::rectangle(&spread()?, extent, tolerance),
        "disk" => AngularSpectrum::disk(&spread()?, extent, tolerance),
        other => return Err(kind.refuse(format!("found '{other}', expected {LIGHTS}"))),
    }
    .map_err(|e| light.refuse(e))
}

fn transfer(
    inputs: &Entry<'_>,
    lit: &LitOpenings<'_>,
    geometry: &Geometry,
) -> Result<Item, CaseError> {
    let mueller = lit.transfer(geometry).map_err(|e| inputs.refuse(e))?;
    Ok(mueller.to_matrix().into())
}

/// The degree of coherence between the middles of two openings, and the visibility toward each observer.
fn fringes(
    inputs: &Entry<'_>,
    pair: &Entry<'_>,
    screen: &Openings,
    light: &AngularSpectrum,
    geometries: &[Geometry],
) -> Result<Vec<(&'static str, Item)>, CaseError> {
    let [first, second] = pair.array()?;
    let pair_of = [first.order()?, second.order()?];
    let stokes = match inputs.find("stokes")? {
        Some(stokes) => StokesVector::from(stokes.array_of(Entry::number)?),
        None => StokesVector::from([1.0, 0.0, 0.0, 0.0]),
    };
    let centre = |index: usize| {
        let opening = screen.openings().get(index);
        let found = opening.map(|opening| opening.centre);
        found.ok_or_else(|| {
            let count = screen.openings().len();
            pair.refuse(format!(
                "found opening {index} of {count}, expected one from 0"
            ))
        })
    };
    let gamma = light.degree_of_coherence(&(centre(pair_of[0])? - centre(pair_of[1])?));
    let visibility = geometries.iter().map(|geometry| {
        let phi = geometry.tangential();
        let found = screen.visibility(pair_of, &phi, stokes, gamma);
        found.map_err(|e| pair.refuse(e))
    });
    let visibility = visibility.collect::<Result<Vec<_>, _>>()?;
    Ok(vec![
        ("gamma", gamma.into()),
        ("visibility", visibility.into()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::schema::Case;
    use serde_json::{Value, json};

    fn result(inputs: Value) -> Value {
        let case = Case {
            id: String::new(),
            op: String::new(),
            inputs,
        };
        slits(&Entry::of(&case)).unwrap().to_json().unwrap()
    }

    fn real(value: &Value) -> f64 {
        value.as_str().unwrap().parse().unwrap()
    }

    fn young(light: &Value, sines: [f64; 2]) -> Value {
        let toward = sines.map(|sin| json!([sin, 0, (1.0 - sin * sin).sqrt()]));
        let slit = |x: f64| json!({"centre": [x, 0], "width": 1e-5, "height": 1e-3});
        result(
            json!({"openings": [slit(-2.5e-5), slit(2.5e-5)], "screen_area": 1e-6, "lambda": 5.89e-7,
            "to_source": [0, 0, -1], "to_observers": toward, "light": light, "pair": [0, 1]}),
        )
    }

    #[test]
    fn a_star_makes_youngs_fringes() {
        let found = young(&json!({"kind": "plane_wave"}), [0.0, 0.5 * 5.89e-7 / 5e-5]);
        assert!((real(&found["open_fraction"]) - 0.02).abs() < 1e-15);
        // (n²/λ²) open²/screen straight on, nothing half way to λ/d
        let straight = real(&found["M"][0][0][0]);
        assert!((straight * 5.89e-7_f64.powi(2) * 1e-6 / 2e-8_f64.powi(2) - 1.0).abs() < 1e-12);
        assert!(real(&found["M"][1][0][0]) < 1e-20 * straight);
        assert!((real(&found["visibility"][0]) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn fringes_fade_as_the_lamp_grows() {
        // 2 J_1(u)/u with u = k α d = 2
        let angle = 2.0 * 5.89e-7 / (std::f64::consts::TAU * 5e-5);
        let found = young(&json!({"kind": "disk", "angles": angle}), [0.0, 0.001]);
        let expected = libm::j1(2.0);
        assert!((real(&found["gamma"]["re"]) - expected).abs() < 1e-13);
        assert!((real(&found["visibility"][1]) - expected).abs() < 1e-13);
    }
}
