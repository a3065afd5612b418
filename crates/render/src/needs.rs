//! What a scene needs: which Stokes components can be other than zero at the sensor, and why.
//!
//! An upper bound from the light sources, the matter in the scene and the length of paths: whatever polarization arrives
//! was sent out so or was made by matter. What cannot arise is not computed. Where something polarizes, S0 depends on
//! the rest, and all of the Stokes vector is followed.

use crate::material::{Effect, Matter};
use crate::path::PathOptions;
use crate::scene::Scene;

/// Why a component may be other than zero, or why it cannot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Whether it may.
    pub possible: bool,
    /// For the reader of `inspect`.
    pub reason: String,
}

/// What can arrive at the sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Needs {
    /// S1 and S2.
    pub linear: Component,
    /// S3.
    pub circular: Component,
}

impl Needs {
    /// What the scene's light sources send out and its matter can make of it.
    ///
    /// `names` names the materials in messages, in their order.
    pub fn of(scene: &Scene, paths: &PathOptions, names: &[String]) -> Self {
        let effects: Vec<Effect> = scene.materials.iter().map(Matter::effect).collect();
        let who = |does: fn(&Effect) -> bool| {
            effects
                .iter()
                .position(does)
                .map(|i| names.get(i).map_or("matter", String::as_str))
        };
        // a path of length d has d − 1 vertices
        let vertices = paths.max_depth.saturating_sub(1);
        let shines = |is: fn((bool, bool)) -> bool| {
            let mut emitters = scene.emitters.iter();
            let found = emitters.find(|e| is(e.polarizes()));
            found.map(|e| format!("emitter '{}'", e.plugin()))
        };
        let [linear_light, circular_light] = [shines(|p| p.0), shines(|p| p.1)];
        let polarizer = who(|e| e.makes_linear).filter(|_| vertices >= 1);
        let circular = who(|e| e.makes_circular).filter(|_| vertices >= 1);
        // matter retards what a light source has polarized at the first vertex, what other matter has at the second
        let retarder = who(|e| e.retards);
        let of_light = retarder.filter(|_| vertices >= 1);
        let of_matter = retarder.filter(|_| vertices >= 2);
        let possible = |reason: String| Component {
            possible: true,
            reason,
        };
        let impossible = |reason: &str| Component {
            possible: false,
            reason: reason.to_owned(),
        };
        let linear = if let Some(light) = &linear_light {
            possible(format!("{light} is linearly polarized"))
        } else if let Some(name) = polarizer {
            possible(format!("{name} polarizes linearly"))
        } else if let (Some(light), Some(r)) = (&circular_light, of_light) {
            possible(format!("{r} retards the circular light of {light}"))
        } else if let (Some(c), Some(r)) = (circular, of_matter) {
            possible(format!("{r} retards what {c} has polarized circularly"))
        } else {
            impossible("no matter within reach polarizes linearly")
        };
        let circular = if let Some(light) = &circular_light {
            possible(format!("{light} is circularly polarized"))
        } else if let Some(name) = circular {
            possible(format!("{name} polarizes circularly"))
        } else if let (Some(light), Some(r)) = (&linear_light, of_light) {
            possible(format!("{r} retards the linear light of {light}"))
        } else if let (Some(p), Some(r)) = (polarizer, of_matter) {
            possible(if p == r {
                format!("{r} retards at one bounce what it has polarized at another")
            } else {
                format!("{r} retards what {p} has polarized linearly")
            })
        } else if polarizer.is_none() && linear_light.is_none() {
            impossible("no matter within reach polarizes")
        } else if retarder.is_some() {
            impossible(&format!(
                "paths of length {} meet matter once; it takes two to retard",
                paths.max_depth
            ))
        } else {
            impossible("no matter retards")
        };
        Self { linear, circular }
    }

    /// Whether Stokes vectors must be followed at all.
    pub fn polarization(&self) -> bool {
        self.linear.possible || self.circular.possible
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Overrides, build, read_text};

    fn needs(content: &str, depth: u32) -> (bool, bool) {
        let text = format!(
            "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='{depth}'/></integrator>\
             <sensor type='perspective'/>{content}</scene>"
        );
        let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
        let built = build(&document, Overrides::default()).unwrap();
        let needs = Needs::of(&built.scene, &built.paths, &built.material_names);
        (needs.linear.possible, needs.circular.possible)
    }

    #[test]
    fn depolarizers_alone_need_no_stokes_vectors() {
        let matter = "<bsdf type='diffuse'/><bsdf type='null'/>";
        assert_eq!(needs(matter, 8), (false, false));
    }

    #[test]
    fn one_reflection_makes_no_circular_light_but_two_do() {
        let metal = "<bsdf type='conductor'/>";
        assert_eq!(needs(metal, 1), (false, false));
        assert_eq!(needs(metal, 2), (true, false));
        assert_eq!(needs(metal, 3), (true, true));
    }

    #[test]
    fn plastic_and_polarizers_never_retard() {
        assert_eq!(
            needs("<bsdf type='pplastic'/><bsdf type='polarizer'/>", 50),
            (true, false)
        );
        assert_eq!(needs("<bsdf type='retarder'/>", 50), (false, false));
        assert_eq!(
            needs("<bsdf type='retarder'/><bsdf type='circular'/>", 50),
            (true, true)
        );
        assert_eq!(needs("<bsdf type='circular'/>", 50), (false, true));
        assert_eq!(
            needs("<bsdf type='twosided'><bsdf type='pplastic'/></bsdf>", 50),
            (true, false)
        );
    }

    #[test]
    fn polarized_emitters_need_stokes_vectors_at_once() {
        let lamp = |stokes: &str| {
            format!("<emitter type='point'><string name='stokes' value='{stokes}'/></emitter>")
        };
        assert_eq!(needs(&lamp("1, 0, 0, 0"), 8), (false, false));
        assert_eq!(needs(&lamp("1, 0, 0.5, 0"), 1), (true, false));
        assert_eq!(needs(&lamp("1, 0, 0, -0.5"), 1), (false, true));
        let plate = "<bsdf type='retarder'/>";
        // one plate is enough for light that is polarized already
        assert_eq!(needs(&(lamp("1, 0.5, 0, 0") + plate), 2), (true, true));
        assert_eq!(needs(&(lamp("1, 0, 0, 1") + plate), 2), (true, true));
        assert_eq!(needs(&(lamp("1, 0, 0, 1") + plate), 1), (false, true));
    }
}
