//! What a scene needs: which Stokes components can be other than zero at the sensor, and why.
//!
//! An upper bound from the matter in the scene and the length of paths alone: all light sources are unpolarized, so
//! whatever polarization arrives was made by matter. What cannot arise is not computed.

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
    /// What the scene's matter can make of unpolarized light.
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
        let polarizer = who(|e| e.makes_linear).filter(|_| vertices >= 1);
        let circular = who(|e| e.makes_circular).filter(|_| vertices >= 1);
        let retarder = who(|e| e.retards).filter(|_| vertices >= 2);
        let possible = |reason: String| Component {
            possible: true,
            reason,
        };
        let linear = match (polarizer, circular, retarder) {
            (Some(name), ..) => possible(format!("{name} polarizes linearly")),
            (None, Some(c), Some(r)) => {
                possible(format!("{r} retards what {c} has polarized circularly"))
            }
            _ => Component {
                possible: false,
                reason: "no matter within reach polarizes linearly".to_owned(),
            },
        };
        let circular = match (circular, polarizer, retarder) {
            (Some(name), ..) => possible(format!("{name} polarizes circularly")),
            (None, Some(p), Some(r)) if p == r => possible(format!(
                "{r} retards at one bounce what it has polarized at another"
            )),
            (None, Some(p), Some(r)) => {
                possible(format!("{r} retards what {p} has polarized linearly"))
            }
            (None, Some(_), None) if who(|e| e.retards).is_some() => Component {
                possible: false,
                reason: format!(
                    "paths of length {} meet matter once; it takes two to retard",
                    paths.max_depth
                ),
            },
            (None, Some(_), None) => Component {
                possible: false,
                reason: "no matter retards".to_owned(),
            },
            _ => Component {
                possible: false,
                reason: "no matter within reach polarizes".to_owned(),
            },
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

    fn needs(matter: &str, depth: u32) -> (bool, bool) {
        let text = format!(
            "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='{depth}'/></integrator>\
             <sensor type='perspective'/>{matter}</scene>"
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
}
