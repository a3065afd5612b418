//! The operation `grating`, and gratings as cases describe them.

use mueller16::{Blaze, CoupledOrders, Grating, Mount, Profile};
use nalgebra::{Vector2, Vector3};

use super::entry::{DIRECTION, Entry};
use super::fields::{number, wavelength};
use super::result::Item;
use super::schema::CaseError;

const PROFILE: &str = "a profile: an object with 'kind', or a list of two";
const KINDS: &str = "'sinusoidal', 'lamellar', 'blazed', 'triangular', 'linear' or 'sampled'";
const PITCH: &str = "a length in metres, or a list of two";
const SENSES: &str = "'rising' or 'falling'";
const SIDES: &str = "'reflection' or 'transmission'";

pub(super) fn grating(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let grating = described(inputs)?;
    let mount = mount(inputs)?;
    let coupled = CoupledOrders::new(&grating, &mount).map_err(|e| inputs.refuse(e))?;
    let orders = coupled.orders();
    let column = |of: &dyn Fn(&mueller16::Order) -> Item| -> Item {
        Item::List(orders.iter().map(of).collect())
    };
    let amplitude = |o: &mueller16::Order| {
        let phi_z = o.geometry.normal_component();
        grating.amplitude(phi_z, o.index).into()
    };
    let mut results = vec![
        (
            "orders",
            column(&|o| o.index.map(f64::from).to_vec().into()),
        ),
        ("to_observer", column(&|o| list(o.geometry.to_observer()))),
        ("phi_z", column(&|o| o.geometry.normal_component().into())),
        ("amplitude", column(&amplitude)),
        ("share", column(&|o| o.share.into())),
        ("efficiency", coupled.efficiencies().into()),
    ];
    if let Ok(lossless) = coupled.lossless()
        && lossless.has_converged()
    {
        results.push(("lossless", lossless.efficiencies.into()));
    }
    Ok(Item::Group(results))
}

fn mount(inputs: &Entry<'_>) -> Result<Mount, CaseError> {
    let to_source = inputs.get("to_source", DIRECTION)?.direction()?;
    let lambda = wavelength(inputs)?;
    let tangents = [Vector3::x(), Vector3::y()];
    let index = |key| inputs.find(key)?.map_or(Ok(1.0), |entry| entry.number());
    let first = index("n_incident")?;
    let reflected = Mount::reflection(to_source, tangents, lambda, first);
    let Some(side) = inputs.find("side")? else {
        return reflected.map_err(|e| inputs.refuse(e));
    };
    match side.word()? {
        "reflection" => reflected,
        "transmission" => {
            Mount::transmission(to_source, tangents, lambda, [first, index("n_outgoing")?])
        }
        other => return Err(side.refuse(format!("found '{other}', expected {SIDES}"))),
    }
    .map_err(|e| inputs.refuse(e))
}

/// A grating from `profile`, `pitch` and `across` of an object: lines, or crossed lines where profile and pitch are two.
pub(super) fn described(spec: &Entry<'_>) -> Result<Grating, CaseError> {
    let across = match spec.find("across")? {
        Some(across) => across.vector()?,
        None => Vector2::x(),
    };
    let (shape, pitch) = (spec.get("profile", PROFILE)?, spec.get("pitch", PITCH)?);
    let made = if shape.is_list() {
        let [first, second] = shape.array()?;
        let profiles = [profile(&first)?, profile(&second)?];
        Grating::crossed(pitch.array_of(Entry::number)?, across, profiles)
    } else {
        Grating::lines(pitch.number()?, across, profile(&shape)?)
    };
    made.map_err(|e| spec.refuse(e))
}

fn profile(spec: &Entry<'_>) -> Result<Profile, CaseError> {
    let kind = spec.get("kind", KINDS)?;
    let depth = || number(spec, "depth");
    let made = match kind.word()? {
        "sinusoidal" => Profile::sinusoidal(depth()?),
        "lamellar" => Profile::lamellar(depth()?, number(spec, "ridge_fraction")?),
        "blazed" => Profile::blazed(depth()?, sense(spec)?),
        "triangular" => Profile::triangular(depth()?, number(spec, "apex")?),
        "linear" => {
            let vertices = spec.get("vertices", "a list of [fraction of the pitch, height]")?;
            let vertices = vertices.list()?;
            let vertices = vertices.iter().map(|v| v.array_of(Entry::number));
            Profile::piecewise_linear(vertices.collect::<Result<_, _>>()?)
        }
        "sampled" => {
            let heights = spec.get("heights", "a list of heights in metres")?.list()?;
            let heights = heights.iter().map(Entry::number);
            Profile::sampled(heights.collect::<Result<_, _>>()?)
        }
        other => return Err(kind.refuse(format!("found '{other}', expected {KINDS}"))),
    };
    made.map_err(|e| spec.refuse(e))
}

fn sense(spec: &Entry<'_>) -> Result<Blaze, CaseError> {
    let sense = spec.get("sense", SENSES)?;
    match sense.word()? {
        "rising" => Ok(Blaze::Rising),
        "falling" => Ok(Blaze::Falling),
        other => Err(sense.refuse(format!("found '{other}', expected {SENSES}"))),
    }
}

pub(super) fn list(direction: Vector3<f64>) -> Item {
    direction.as_slice().to_vec().into()
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
        grating(&Entry::of(&case)).unwrap().to_json().unwrap()
    }

    fn real(value: &Value) -> f64 {
        value.as_str().unwrap().parse().unwrap()
    }

    #[test]
    fn a_disc_in_green_light_has_five_orders() {
        let found = result(
            json!({"profile": {"kind": "sinusoidal", "depth": 1.2e-7}, "pitch": 1.6e-6,
            "to_source": [0, 0, 1], "lambda": 5.5e-7}),
        );
        assert_eq!(found["orders"].as_array().unwrap().len(), 5);
        // asin(0.55/1.6) = 20.1°, toward +x for order 1
        assert_eq!(real(&found["orders"][3][0]), 1.0);
        assert!((real(&found["to_observer"][3][0]).asin().to_degrees() - 20.105).abs() < 1e-3);
        // J_1(φ_z depth/2)², with the φ_z of this order
        let phi_z = real(&found["phi_z"][3]);
        let cosine = (20.105_f64).to_radians().cos();
        assert!((phi_z / (std::f64::consts::TAU / 5.5e-7 * (1.0 + cosine)) - 1.0).abs() < 1e-5);
        let expected = libm::jn(1, 0.5 * phi_z * 1.2e-7).powi(2);
        assert!((real(&found["share"][3]) - expected).abs() < 1e-14);
        // −i J_1: exp(−iφ_z h) for a height toward the light
        assert!(real(&found["amplitude"][3]["im"]) < 0.0);
        let lossless = found["lossless"].as_array().unwrap();
        assert!((lossless.iter().map(real).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_rising_facet_mirrors_to_negative_orders() {
        // half a wave deep at normal incidence: the facet's mirror direction is that of order −1
        for (sense, brightest) in [("rising", -1.0), ("falling", 1.0)] {
            let found = result(
                json!({"profile": {"kind": "blazed", "depth": 2.5e-7, "sense": sense}, "pitch": 8e-6,
                "to_source": [0, 0, 1], "lambda": 5e-7}),
            );
            let shares = found["efficiency"].as_array().unwrap().iter().map(real);
            let orders = found["orders"].as_array().unwrap().iter();
            let (share, order) = shares
                .zip(orders)
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            assert_eq!(real(&order[0]), brightest);
            assert!(share > 0.99);
        }
    }
}
