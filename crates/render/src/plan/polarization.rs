//! Which Stokes components can be other than zero at the sensor, and why.
//!
//! An upper bound from the light sources, the matter in the scene and the length of paths: whatever polarization arrives
//! was sent out so or was made by matter. Where something polarizes, S0 depends on the rest, and the Stokes vector is
//! followed: S0, S1 and S2 where no light can be circular and [paths go side by side](crate::path::wavefront), else all.

use super::{Components, Decision, Request, Stock};
use crate::material::{Effect, Matter};
use crate::path::wavefront::Wavefront;

/// Why a component may be other than zero, or why it cannot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Component {
    /// Whether it may.
    pub(super) possible: bool,
    /// For the reader of `--explain`.
    pub(super) reason: String,
}

impl Component {
    fn possible(reason: String) -> Self {
        Self {
            possible: true,
            reason,
        }
    }

    fn impossible(reason: impl Into<String>) -> Self {
        Self {
            possible: false,
            reason: reason.into(),
        }
    }
}

/// What can arrive at the sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Needs {
    /// S1 and S2.
    pub(super) linear: Component,
    /// S3.
    pub(super) circular: Component,
}

impl Needs {
    /// What the scene's light sources send out and its matter can make of it.
    pub(super) fn of(stock: &Stock<'_>) -> Self {
        let who = |does: fn(&Effect) -> bool| stock.who(|m, _| does(&m.effect()));
        let vertices = stock.vertices();
        let linear_light = stock.which_light(|e| e.polarizes().0);
        let circular_light = stock.which_light(|e| e.polarizes().1);
        let polarizer = who(|e| e.makes_linear).filter(|_| vertices >= 1);
        let circular = who(|e| e.makes_circular).filter(|_| vertices >= 1);
        // matter retards what a light source has polarized at the first vertex, what other matter has at the second
        let retarder = who(|e| e.retards);
        let of_light = retarder.filter(|_| vertices >= 1);
        let of_matter = retarder.filter(|_| vertices >= 2);
        let linear = if let Some(light) = &linear_light {
            Component::possible(format!("{light} is linearly polarized"))
        } else if let Some(name) = polarizer {
            Component::possible(format!("{name} polarizes linearly"))
        } else if let (Some(light), Some(r)) = (&circular_light, of_light) {
            Component::possible(format!("{r} retards the circular light of {light}"))
        } else if let (Some(c), Some(r)) = (circular, of_matter) {
            Component::possible(format!("{r} retards what {c} has polarized circularly"))
        } else {
            Component::impossible("no matter within reach polarizes linearly")
        };
        let circular = if let Some(light) = &circular_light {
            Component::possible(format!("{light} is circularly polarized"))
        } else if let Some(name) = circular {
            Component::possible(format!("{name} polarizes circularly"))
        } else if let (Some(light), Some(r)) = (&linear_light, of_light) {
            Component::possible(format!("{r} retards the linear light of {light}"))
        } else if let (Some(p), Some(r)) = (polarizer, of_matter) {
            Component::possible(if p == r {
                format!("{r} retards at one bounce what it has polarized at another")
            } else {
                format!("{r} retards what {p} has polarized linearly")
            })
        } else if polarizer.is_none() && linear_light.is_none() {
            Component::impossible("no matter within reach polarizes")
        } else if retarder.is_some() {
            Component::impossible(format!(
                "paths of length {} meet matter once; it takes two to retard",
                stock.built.paths.max_depth
            ))
        } else {
            Component::impossible("no matter retards")
        };
        Self { linear, circular }
    }

    /// Whether Stokes vectors must be followed at all.
    fn polarization(&self) -> bool {
        self.linear.possible || self.circular.possible
    }
}

/// Which components are followed, and what is said of it.
pub(super) fn decide(stock: &Stock<'_>, request: &Request<'_>) -> (Components, Vec<Decision>) {
    const ALL: &str = "S1, S2, S3";
    if !request.polarized {
        let asked = Decision::absent(ALL, "not asked for (--unpolarized)");
        return (Components::Intensity, vec![asked]);
    }
    let needs = Needs::of(stock);
    if !needs.polarization() {
        let reason = format!("zero, {}", needs.circular.reason);
        return (Components::Intensity, vec![Decision::skipped(ALL, reason)]);
    }
    let beside = |component: Component| {
        if component.possible {
            component.reason
        } else {
            format!("zero, {}; carried beside the others", component.reason)
        }
    };
    let linear = Decision::kept("S1, S2", beside(needs.linear));
    if !needs.circular.possible && Wavefront::follows(&stock.built.scene, &stock.built.camera) {
        let reason = format!("zero, {}", needs.circular.reason);
        let circular = Decision::skipped("S3", reason);
        return (Components::Linear, vec![linear, circular]);
    }
    let circular = Decision::kept("S3", beside(needs.circular));
    (Components::All, vec![linear, circular])
}
