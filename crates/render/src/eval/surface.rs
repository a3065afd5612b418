//! The operation `surface`: what a smooth or rough boundary does to polarized light.

use mueller16::{Boundary, Film, RayFrames, Specular, Surface};
use mueller16::{
    ConductorInterface, DielectricInterface, Geometry, IncidentCoherence, Relief, Tolerance,
};
use nalgebra::Matrix2;
use stokes::Frame;

use super::entry::{DIRECTION, Entry};
use super::fields::{number, wavelength};
use super::grating::list;
use super::layers::film;
use super::relief::{AnyRelief, RELIEF, name, relief, tolerance};
use super::result::Item;
use super::schema::CaseError;

const KINDS: &str = "'dielectric', 'conductor', 'film', 'mirror' or 'window'";
const BOUNDARY: &str = "a boundary: an object with 'kind'";
const LIGHTS: &str = "'plane_wave' or 'gaussian'";
const ANGLES: &str = "an angle in radians or a matrix of angles";
const INDEX: &str = "a refractive index";

pub(super) fn surface(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let boundary = boundary(&inputs.get("boundary", BOUNDARY)?)?;
    let geometry = geometry(inputs, &boundary)?;
    let wavenumber = geometry.wavelength().wavenumber().radians_per_metre();
    let reach = wavenumber * (geometry.n_incident() + geometry.n_outgoing());
    let relief = relief(&inputs.get("relief", RELIEF)?, reach)?;
    let tolerance = tolerance(inputs)?;
    let phi_z = geometry.normal_component();
    let (r, chosen) = relief
        .autocorrelation(phi_z, tolerance)
        .map_err(|e| inputs.refuse(e))?;
    let surface = with_factors(inputs, boundary, relief)?;
    let frames = frames(inputs, &geometry)?;
    let light = light(inputs, &geometry)?;
    let diffuse = surface
        .scattering_function(&geometry, &frames, &light, tolerance)
        .map_err(|e| inputs.refuse(e))?;
    Ok(Item::Group(vec![
        ("M", diffuse.to_matrix().into()),
        ("phi_t", geometry.tangential().as_slice().to_vec().into()),
        ("phi_z", phi_z.into()),
        ("coherent_weight", r.delta_weight().into()),
        ("method", Item::Word(name(chosen.method))),
        ("terms", (chosen.terms as f64).into()),
        ("error", chosen.error.into()),
        ("beams", beams(inputs, &surface, &geometry, tolerance)?),
    ]))
}

fn beams(
    inputs: &Entry<'_>,
    surface: &Surface<AnyRelief>,
    geometry: &Geometry,
    tolerance: Tolerance,
) -> Result<Item, CaseError> {
    let incident = frames(inputs, geometry)?.incident;
    let found = surface
        .specular(geometry, incident, tolerance)
        .map_err(|e| inputs.refuse(e))?;
    let beam = |beam: &Specular| {
        Item::Group(vec![
            ("to_observer", list(beam.geometry.to_observer())),
            ("weight", beam.weight.into()),
            ("M", beam.mueller.to_matrix().into()),
        ])
    };
    Ok(Item::List(found.iter().map(beam).collect()))
}

/// The encounter in the axes of the surface; media that are not given are those of the boundary, or 1.
fn geometry(inputs: &Entry<'_>, boundary: &Boundary) -> Result<Geometry, CaseError> {
    let direction = |key| inputs.get(key, DIRECTION)?.direction();
    let (to_source, to_observer) = (direction("to_source")?, direction("to_observer")?);
    let [front, back] = boundary.indices();
    let index = |key, z: f64| match inputs.find(key)? {
        Some(index) => index.number(),
        None => Ok(if z < 0.0 { back } else { front }.unwrap_or(1.0)),
    };
    let indices = [
        index("n_incident", to_source.z)?,
        index("n_outgoing", to_observer.z)?,
    ];
    Geometry::on_plane(to_source, to_observer, wavelength(inputs)?)
        .and_then(|found| found.between(indices[0], indices[1]))
        .map_err(|e| inputs.refuse(e))
}

fn boundary(spec: &Entry<'_>) -> Result<Boundary, CaseError> {
    let kind = spec.get("kind", KINDS)?;
    let back = || spec.get("n_back", INDEX);
    Ok(match kind.word()? {
        "dielectric" => {
            let made = DielectricInterface::new(number(spec, "n_front")?, back()?.number()?);
            Boundary::Dielectric(made.map_err(|e| spec.refuse(e))?)
        }
        "conductor" => {
            let n = back()?.complex()?;
            let made = ConductorInterface::new(number(spec, "n_front")?, n.re, -n.im);
            Boundary::Conductor(made.map_err(|e| spec.refuse(e))?)
        }
        "film" => {
            let layers = spec.get("layers", "a list of layers")?.list()?;
            let layers = layers.iter().map(film).collect::<Result<_, _>>()?;
            let made = Film::new(number(spec, "n_front")?, layers, back()?.complex()?);
            Boundary::Film(made.map_err(|e| spec.refuse(e))?)
        }
        "mirror" => Boundary::Mirror,
        "window" => Boundary::Window,
        other => return Err(kind.refuse(format!("found '{other}', expected {KINDS}"))),
    })
}

/// With obliquity unless that is 0, with shadowing if that is 1.
fn with_factors(
    inputs: &Entry<'_>,
    boundary: Boundary,
    relief: AnyRelief,
) -> Result<Surface<AnyRelief>, CaseError> {
    let flag = |key, otherwise| inputs.find(key)?.map_or(Ok(otherwise), |flag| flag.flag());
    let surface = if flag("obliquity", true)? {
        Surface::of_heights(boundary, relief)
    } else {
        Surface::of_phases(boundary, relief)
    };
    if flag("shadowing", false)? {
        return surface.with_shadowing().map_err(|e| inputs.refuse(e));
    }
    Ok(surface)
}

/// The s-p frames about the normal, or those whose first axes are along `x_in` and `x_out`.
fn frames(inputs: &Entry<'_>, geometry: &Geometry) -> Result<RayFrames, CaseError> {
    let mut frames = RayFrames::of_surface(geometry).map_err(|e| inputs.refuse(e))?;
    for (key, frame) in [
        ("x_in", &mut frames.incident),
        ("x_out", &mut frames.outgoing),
    ] {
        if let Some(axis) = inputs.find(key)? {
            let made = Frame::with_x_along(frame.z(), axis.direction()?);
            *frame = made.map_err(|e| axis.refuse(e))?;
        }
    }
    Ok(frames)
}

fn light(inputs: &Entry<'_>, geometry: &Geometry) -> Result<IncidentCoherence, CaseError> {
    let Some(light) = inputs.find("light")? else {
        return Ok(IncidentCoherence::plane_wave());
    };
    let kind = light.get("kind", LIGHTS)?;
    match kind.word()? {
        "plane_wave" => Ok(IncidentCoherence::plane_wave()),
        "gaussian" => gaussian(&light, geometry),
        other => Err(kind.refuse(format!("found '{other}', expected {LIGHTS}"))),
    }
}

/// Light from directions `angles·u`, u of two independent standard normal numbers.
pub(super) fn gaussian(
    light: &Entry<'_>,
    geometry: &Geometry,
) -> Result<IncidentCoherence, CaseError> {
    let root = angles(light)?.transpose();
    IncidentCoherence::gaussian(geometry, &root).map_err(|e| light.refuse(e))
}

/// `angles`: a matrix, or a number for the same in all directions.
pub(super) fn angles(light: &Entry<'_>) -> Result<Matrix2<f64>, CaseError> {
    let angles = light.get("angles", ANGLES)?;
    if angles.is_list() {
        return angles.matrix();
    }
    angles.number().map(Matrix2::from_diagonal_element)
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
        surface(&Entry::of(&case)).unwrap().to_json().unwrap()
    }

    fn real(value: &Value) -> f64 {
        value.as_str().unwrap().parse().unwrap()
    }

    fn glass(relief: Value) -> Value {
        let (sin, cos) = 1.5_f64.atan().sin_cos();
        json!({"boundary": {"kind": "dielectric", "n_front": 1, "n_back": 1.5}, "relief": relief,
            "to_source": [sin, 0, cos], "to_observer": [-sin, 0, cos], "lambda": 5.5e-7})
    }

    #[test]
    fn smooth_glass_reflects_s_light_alone_at_brewsters_angle() {
        let found = result(glass(json!({"kind": "none"})));
        let beams = found["beams"].as_array().unwrap();
        assert_eq!(beams.len(), 1);
        let element = |row: usize, column: usize| real(&beams[0]["M"][row][column]);
        assert!((element(0, 0) - 0.073_964_5).abs() < 1e-7);
        assert!((element(0, 1) - element(0, 0)).abs() < 1e-15);
        assert_eq!(real(&beams[0]["weight"]), 1.0);
        assert_eq!(real(&found["M"][0][0]), 0.0);
    }

    #[test]
    fn roughness_dims_the_mirror_and_widens_it() {
        let relief = |sigma: f64| glass(json!({"kind": "gaussian", "sigma": sigma, "l": 3e-6}));
        // g = (φ_z σ)² with φ_z = 2k cos 56.31°
        let g = (4.0 * std::f64::consts::PI / 5.5e-7 * 1.5_f64.atan().cos() * 4e-8).powi(2);
        let found = result(relief(4e-8));
        assert!((real(&found["coherent_weight"]) - (-g).exp()).abs() < 1e-14);
        assert!((real(&found["beams"][0]["weight"]) - (-g).exp()).abs() < 1e-14);
        // ∫(R − e^(−g)) = π l² e^(−g) Σ g^m/(m! m) in the mirror direction, over λ²
        let sum: f64 = (1..40)
            .map(|m| g.powi(m) / (libm::tgamma(f64::from(m) + 1.0) * f64::from(m)))
            .sum();
        let lobe = std::f64::consts::PI * (3e-6_f64 / 5.5e-7).powi(2) * (-g).exp() * sum;
        assert!((real(&found["M"][0][0]) / (0.073_964_497 * lobe) - 1.0).abs() < 1e-8);
        assert_eq!(found["method"], "gauss_charlier");
    }

    #[test]
    fn frames_may_be_given() {
        let mut inputs = glass(json!({"kind": "none"}));
        // p for s in both rays
        inputs["x_in"] = json!([0, 0, 1]);
        let found = result(inputs);
        let element = |column: usize| real(&found["beams"][0]["M"][0][column]);
        assert!((element(1) + element(0)).abs() < 1e-15);
    }
}
