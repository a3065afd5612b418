//! Operations of the crate `csdm` on interfaces, thin films and crystal plates.

use csdm::birefringent::{Crystal, CrystalLayer, CrystalStack, Incidence, JonesSide, MuellerSide};
use csdm::film::{Layer, Stack};
use csdm::{JonesMatrix, fresnel};
use nalgebra::{Matrix2, Matrix3, Matrix4, Vector3};
use num_complex::Complex64;
use stokes::{DiattenuatingRetarder, Mueller};

use super::entry::Entry;
use super::fields::{number, wavelength};
use super::result::Item;
use super::schema::CaseError;

const COSINE: &str = "a cosine between 0 and 1";
const LAYERS: &str = "a list of layers";
const THICKNESS: &str = "a thickness in metres";
const SIDES: &str = "'front' or 'back'";
const METHODS: &str = "'coherent', 'single_pass' or 'incoherent'";

pub(super) fn fresnel(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let [n1, n2] = ["n1", "n2"].map(|key| passive_index(inputs, key));
    let found = fresnel::amplitudes(n1?, n2?, cosine(inputs)?);
    let (r, t) = (found.reflected, found.transmitted);
    let mirror = DiattenuatingRetarder::from_amplitudes(r.s, r.p).to_mueller();
    Ok(Item::Group(vec![
        ("r_s", r.s.into()),
        ("r_p", r.p.into()),
        ("t_s", t.s.into()),
        ("t_p", t.p.into()),
        ("M_reflect", mirror.to_matrix().into()),
    ]))
}

/// The index `η − ik` under `key`.
fn passive_index(inputs: &Entry<'_>, key: &str) -> Result<Complex64, CaseError> {
    let entry = inputs.get(key, INDEX)?;
    let n = entry.complex()?;
    if n.re < 0.0 || n.im > 0.0 || n == Complex64::ZERO {
        return Err(entry.refuse(format!("found {} and {} i, expected {INDEX}", n.re, n.im)));
    }
    Ok(n)
}

const INDEX: &str = "an index eta - ik with eta, k >= 0, not both 0";

fn cosine(inputs: &Entry<'_>) -> Result<f64, CaseError> {
    let entry = inputs.get("cos_i", COSINE)?;
    let cos_i = entry.number()?;
    if !(0.0..=1.0).contains(&cos_i) {
        return Err(entry.refuse(format!("found {cos_i}, expected {COSINE}")));
    }
    Ok(cos_i)
}

pub(super) fn multilayer(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let layers = inputs.get("layers", LAYERS)?.list()?;
    let layers = layers.iter().map(film).collect::<Result<_, _>>()?;
    let stack = Stack::new(
        number(inputs, "n_incident")?,
        layers,
        inputs.get("n_exit", "a refractive index")?.complex()?,
    )
    .map_err(|e| inputs.refuse(e))?;
    let found = stack.amplitudes(cosine(inputs)?, wavelength(inputs)?);
    let mut results: Vec<(&'static str, Item)> = vec![
        ("r_s", found.reflected.s.into()),
        ("r_p", found.reflected.p.into()),
        ("t_s", found.transmitted.s.into()),
        ("t_p", found.transmitted.p.into()),
        ("R", found.reflectance().to_vec().into()),
        ("T", found.transmittance().to_vec().into()),
        ("M_reflect", found.reflection_mueller().to_matrix().into()),
    ];
    if let Ok(transmission) = found.transmission_mueller() {
        results.push(("M_transmit", transmission.to_matrix().into()));
    }
    Ok(Item::Group(results))
}

/// A layer: an object of `n` and `thickness`, or these two in a list.
pub(super) fn film(layer: &Entry<'_>) -> Result<Layer, CaseError> {
    let [index, thickness] = match layer.list() {
        Ok(_) => layer.array()?,
        Err(_) => [
            layer.get("n", "a refractive index")?,
            layer.get("thickness", THICKNESS)?,
        ],
    };
    Ok(Layer {
        index: index.complex()?,
        thickness: thickness.number()?,
    })
}

pub(super) fn plate(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let layers = inputs.get("layers", LAYERS)?.list()?;
    let layers = layers.iter().map(crystal_layer).collect::<Result<_, _>>()?;
    let stack = CrystalStack::new(
        number(inputs, "n_incident")?,
        layers,
        inputs.get("n_exit", "a refractive index")?.complex()?,
    )
    .map_err(|e| inputs.refuse(e))?;
    let incidence = Incidence::new(cosine(inputs)?, optional(inputs, "azimuth")?)
        .map_err(|e| inputs.refuse(e))?;
    let lambda = wavelength(inputs)?;
    let jones = match word(inputs, "method", "coherent")? {
        "coherent" => stack.coherent(&incidence, lambda),
        "single_pass" => stack.single_pass(&incidence, lambda),
        "incoherent" => {
            let below = optional(inputs, "coherent_below")?;
            let found = stack
                .incoherent(&incidence, lambda, below)
                .map_err(|e| inputs.refuse(e))?;
            return side(inputs, found.front, found.back).map(|side| powers(&side));
        }
        other => return Err(inputs.refuse(format!("method '{other}', expected {METHODS}"))),
    };
    side(inputs, jones.front, jones.back).map(|side| amplitudes(&side))
}

/// The side that is asked for.
fn side<T>(inputs: &Entry<'_>, front: T, back: Option<T>) -> Result<T, CaseError> {
    match word(inputs, "side", "front")? {
        "front" => Ok(front),
        "back" => back.ok_or_else(|| {
            inputs
                .refuse("no light comes from the back: the exit medium absorbs or totally reflects")
        }),
        other => Err(inputs.refuse(format!("side '{other}', expected {SIDES}"))),
    }
}

fn amplitudes(side: &JonesSide) -> Item {
    let [r, t] = [side.reflection, side.transmission].map(JonesMatrix::to_matrix);
    // no power crosses at grazing incidence, where the weight is infinite
    let weight = side
        .power_weight
        .map(|w| if w.is_finite() { w } else { 0.0 });
    let mut results: Vec<(&'static str, Item)> = vec![
        ("r", r.into()),
        ("t", t.into()),
        ("R", shares(&r, [1.0; 2])),
        ("T", shares(&t, weight)),
        ("M_reflect", side.reflection_mueller().to_matrix().into()),
    ];
    if let Ok(transmission) = side.transmission_mueller() {
        results.push(("M_transmit", transmission.to_matrix().into()));
    }
    Item::Group(results)
}

/// Power that s-light and p-light leave behind, in both polarizations together.
fn shares(jones: &Matrix2<Complex64>, weight: [f64; 2]) -> Item {
    let share = |column: usize| -> f64 {
        let row = |(row, w): (usize, f64)| w * jones[(row, column)].norm_sqr();
        weight.into_iter().enumerate().map(row).sum()
    };
    vec![share(0), share(1)].into()
}

fn powers(side: &MuellerSide) -> Item {
    let [r, t] = [side.reflection, side.transmission].map(Mueller::to_matrix);
    let share = |m: &Matrix4<f64>| vec![m.m11 + m.m12, m.m11 - m.m12];
    Item::Group(vec![
        ("R", share(&r).into()),
        ("T", share(&t).into()),
        ("M_reflect", r.into()),
        ("M_transmit", t.into()),
    ])
}

fn crystal_layer(layer: &Entry<'_>) -> Result<CrystalLayer, CaseError> {
    let mut crystal = crystal(layer)?;
    if let Some(gyration) = layer.find("gyration")? {
        crystal = crystal
            .with_gyration(&symmetric(&gyration)?)
            .map_err(|e| gyration.refuse(e))?;
    }
    Ok(CrystalLayer {
        crystal: crystal.turned(optional(layer, "turned")?),
        thickness: layer.get("thickness", THICKNESS)?.number()?,
    })
}

/// A medium from its one, two or three principal indices.
fn crystal(layer: &Entry<'_>) -> Result<Crystal, CaseError> {
    let entry = layer.get("n", "a refractive index or a list of up to three")?;
    let indices = match entry.list() {
        Ok(list) => list.iter().map(Entry::complex).collect::<Result<_, _>>()?,
        Err(_) => vec![entry.complex()?],
    };
    let made = match indices[..] {
        [index] => Crystal::isotropic(index),
        [ordinary, extraordinary] => {
            let axis = direction(&layer.get("axis", "the direction of the optic axis")?)?;
            Crystal::uniaxial(ordinary, extraordinary, axis)
        }
        [first, second, third] => {
            let [x, y] = layer
                .get("axes", "the directions of the first and the second axis")?
                .array()?;
            Crystal::biaxial([first, second, third], direction(&x)?, direction(&y)?)
        }
        _ => {
            let found = indices.len();
            return Err(entry.refuse(format!("found {found} indices, expected 1, 2 or 3")));
        }
    };
    made.map_err(|e| layer.refuse(e))
}

fn direction(entry: &Entry<'_>) -> Result<Vector3<f64>, CaseError> {
    entry.array_of(Entry::number).map(Vector3::from)
}

/// A gyration: one number for the same in all directions, or a matrix.
fn symmetric(entry: &Entry<'_>) -> Result<Matrix3<f64>, CaseError> {
    if entry.list().is_err() {
        return entry.number().map(Matrix3::from_diagonal_element);
    }
    let rows: [[f64; 3]; 3] = entry.array_of(|row| row.array_of(Entry::number))?;
    Ok(Matrix3::from_fn(|row, column| rows[row][column]))
}

fn optional(inputs: &Entry<'_>, key: &str) -> Result<f64, CaseError> {
    inputs.find(key)?.map_or(Ok(0.0), |entry| entry.number())
}

fn word<'a>(inputs: &Entry<'a>, key: &str, otherwise: &'a str) -> Result<&'a str, CaseError> {
    inputs
        .find(key)?
        .map_or(Ok(otherwise), |entry| entry.word())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::schema::Case;
    use serde_json::{Value, json};

    fn said(run: fn(&Entry<'_>) -> Result<Item, CaseError>, inputs: Value) -> String {
        let case = Case {
            id: String::new(),
            op: String::new(),
            inputs,
        };
        run(&Entry::of(&case)).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_with_a_stack_is_said_with_its_place() {
        let stack = |layer: Value, side: &str| json!({"n_incident": 1.5, "layers": [layer], "n_exit": 1, "cos_i": 0.5, "lambda": 5e-7, "side": side});
        let glass = json!({"n": 1.5, "thickness": 1e-6});
        // sin θ = 0.87 at 1.5 against 1: beyond the critical angle
        assert_eq!(
            said(plate, stack(glass.clone(), "back")),
            "key 'inputs': no light comes from the back: the exit medium absorbs or totally reflects"
        );
        assert_eq!(
            said(plate, stack(glass, "top")),
            "key 'inputs': side 'top', expected 'front' or 'back'"
        );
        let uniaxial = json!({"n": [1.5, 1.6], "thickness": 1e-6});
        assert_eq!(
            said(plate, stack(uniaxial, "front")),
            "key 'layers[0].axis' is missing, expected the direction of the optic axis"
        );
        let gain = json!([{"re": 1.5, "im": 1e-3}, 1e-6]);
        let text = said(multilayer, stack(gain, "front"));
        assert!(
            text.starts_with("key 'inputs': layer 0: refractive index"),
            "{text}"
        );
        let grazing = json!({"n1": 1, "n2": 1.5, "cos_i": 1.5});
        assert_eq!(
            said(fresnel, grazing),
            "key 'cos_i': found 1.5, expected a cosine between 0 and 1"
        );
    }
}
