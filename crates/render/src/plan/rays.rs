//! What rays look for: light, flat elements before it, coherence; and what of matter is never met.

use super::{Decision, Request, Stock};
use crate::emitter::Emitter;
use crate::material::Matter;
use crate::sensor::Camera;

/// What is said of it. The scene itself knows by [`crate::scene::Scene::traits`] how it is to be walked.
pub(super) fn decide(stock: &Stock<'_>, request: &Request<'_>) -> Vec<Decision> {
    let mut decisions = vec![coherence(stock), coherence_of_the_image(request)];
    if stock.built.scene.emitters.is_empty() {
        decisions.push(Decision::skipped(
            "paths",
            "the scene has no emitter; the image is black",
        ));
    } else {
        decisions.extend(light(stock));
    }
    decisions.extend(sums(stock));
    decisions.extend(unused(stock));
    decisions
}

/// Coherence where matter answers to it: it decides whether paths are followed one by one or side by side, and is never
/// followed where nothing asks for it.
fn coherence(stock: &Stock<'_>) -> Decision {
    const WHAT: &str = "coherence of the light on matter";
    match stock.who(|_, traits| traits.coherent) {
        Some(matter) => Decision::kept(WHAT, format!("{matter} answers to it")),
        None => Decision::absent(WHAT, "no matter answers to it"),
    }
}

fn coherence_of_the_image(request: &Request<'_>) -> Decision {
    const WHAT: &str = "coherence of the light at the sensor";
    if request.coherence {
        Decision::kept(WHAT, "asked for (--coherence)")
    } else {
        Decision::absent(WHAT, "not asked for (--coherence)")
    }
}

/// How light is looked for where there are emitters.
fn light(stock: &Stock<'_>) -> Vec<Decision> {
    const CONNECTIONS: &str = "connections to emitters";
    const FLAT: &str = "flat elements on the way to emitters";
    const LAST: &str = "last rays of the longest paths";
    const BLACK: &str = "paths beyond black matter";
    let scene = &stock.built.scene;
    let mut decisions = Vec::new();
    if let Some(matter) = stock.who(|_, traits| traits.black) {
        decisions.push(Decision::skipped(
            BLACK,
            format!("{matter} reflects nothing"),
        ));
    }
    let scattering = match &stock.built.camera {
        Camera::IrradianceMeter(_) => Some("the sensor plane takes light".to_owned()),
        Camera::Perspective(_) => stock
            .who(|_, traits| !traits.discrete && !traits.black)
            .filter(|_| stock.vertices() > 0)
            .map(|matter| format!("{matter} scatters light")),
    };
    let Some(scattering) = scattering else {
        let reason = "no matter within reach scatters light, all of it is specular";
        decisions.push(Decision::absent(CONNECTIONS, reason));
        decisions.push(surroundings(stock));
        return decisions;
    };
    decisions.push(Decision::kept(
        CONNECTIONS,
        format!("{scattering} from all directions"),
    ));
    decisions.push(match stock.who(|_, traits| traits.straight) {
        Some(matter) => Decision::kept(FLAT, format!("{matter} lets light straight through")),
        None => Decision::skipped(FLAT, "no matter lets light straight through"),
    });
    if !scene.emitters.iter().any(Emitter::can_be_met) && stock.built.paths.max_depth < u32::MAX {
        decisions.push(Decision::skipped(
            LAST,
            "all emitters are points or single directions, which no ray meets",
        ));
    }
    decisions.push(surroundings(stock));
    decisions
}

fn surroundings(stock: &Stock<'_>) -> Decision {
    const WHAT: &str = "light from outside the scene";
    match stock.which_light(Emitter::surrounds) {
        Some(emitter) => Decision::kept(WHAT, format!("{emitter} surrounds it")),
        None => Decision::absent(
            WHAT,
            "no emitter surrounds it; a ray that leaves ends there",
        ),
    }
}

/// Sums of the theorem that matter has cut short.
fn sums(stock: &Stock<'_>) -> Vec<Decision> {
    let mut decisions: Vec<Decision> = Vec::new();
    for (material, _, name) in stock.matter() {
        if let Some(left_out) = material.left_out() {
            decisions.push(Decision::absent(name, left_out));
        }
    }
    if stock.who(|_, traits| traits.coherent).is_some() {
        decisions.push(Decision::absent(
            "Hermite-Gauss orders above 0 of the incident light",
            "emitters shine in Gaussian patches",
        ));
    }
    decisions
}

/// Matter that the scene file defines and no shape is made of.
fn unused(stock: &Stock<'_>) -> Vec<Decision> {
    let built = stock.built;
    let names = built.material_names.iter();
    names
        .enumerate()
        .filter(|(index, name)| {
            let copied = stock
                .used
                .iter()
                .any(|&u| built.material_names[u as usize] == **name);
            !stock.used.contains(&(*index as u32)) && !copied
        })
        .map(|(_, name)| Decision::absent(name, "no shape is made of it"))
        .collect()
}
