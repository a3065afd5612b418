//! Which plugins there are: ours, and Mitsuba's that we do not have yet.

use super::error::{SceneError, nearest};
use super::object::Object;
use super::tag::Tag;

/// A kind of object with the plugins that we have, and those of Mitsuba 3 that we do not.
struct Kind {
    tag: Tag,
    supported: &'static [&'static str],
    missing: &'static [&'static str],
}

const KINDS: [Kind; 8] = [
    Kind {
        tag: Tag::Bsdf,
        supported: &[
            "birefringent",
            "circular",
            "conductor",
            "dielectric",
            "diffuse",
            "grating",
            "layered",
            "mueller",
            "null",
            "plastic",
            "polarizer",
            "pplastic",
            "retarder",
            "rotator",
            "roughconductor",
            "roughdielectric",
            "roughplastic",
            "roughsurface",
            "scatterer16",
            "slits",
            "thindielectric",
            "twosided",
        ],
        missing: &[
            "blendbsdf",
            "bumpmap",
            "hair",
            "mask",
            "measured",
            "measured_polarized",
            "normalmap",
            "principled",
            "principledthin",
        ],
    },
    Kind {
        tag: Tag::Shape,
        supported: &["cube", "cylinder", "disk", "obj", "rectangle", "sphere"],
        missing: &[
            "blender",
            "bsplinecurve",
            "ellipsoids",
            "ellipsoidsmesh",
            "instance",
            "linearcurve",
            "merge",
            "ply",
            "sdfgrid",
            "serialized",
            "shapegroup",
        ],
    },
    Kind {
        tag: Tag::Emitter,
        supported: &[
            "area",
            "constant",
            "directional",
            "egsm",
            "laser",
            "point",
            "rayleighsky",
            "spot",
        ],
        missing: &[
            "directionalarea",
            "envmap",
            "projector",
            "sunsky",
            "timed_sunsky",
            "volumelight",
        ],
    },
    Kind {
        tag: Tag::Sensor,
        supported: &["irradiancemeter", "perspective"],
        missing: &[
            "batch",
            "distant",
            "orthographic",
            "radiancemeter",
            "thinlens",
        ],
    },
    Kind {
        tag: Tag::Film,
        supported: &["hdrfilm"],
        missing: &["specfilm"],
    },
    Kind {
        tag: Tag::Rfilter,
        supported: &["box", "gaussian", "tent"],
        missing: &["catmullrom", "lanczos", "mitchell"],
    },
    Kind {
        tag: Tag::Sampler,
        supported: &[
            "independent",
            "ldsampler",
            "multijitter",
            "orthogonal",
            "stratified",
        ],
        missing: &[],
    },
    Kind {
        tag: Tag::Integrator,
        supported: &["path", "stokes"],
        missing: &[
            "aov",
            "depth",
            "direct",
            "moment",
            "prb",
            "prb_basic",
            "prb_projective",
            "prbvolpath",
            "ptracer",
            "volpath",
            "volpathmis",
        ],
    },
];

/// The names that may stand in the attribute `type` of this kind of object.
pub fn supported(tag: Tag) -> &'static [&'static str] {
    KINDS
        .iter()
        .find(|kind| kind.tag == tag)
        .map_or(&[], |kind| kind.supported)
}

/// The error for an object whose plugin we do not have, or that cannot stand where it does.
pub fn refuse(object: &Object) -> SceneError {
    let what = object.describe();
    let Some(kind) = KINDS.iter().find(|kind| kind.tag == object.tag) else {
        return object.error(format!(
            "{what} is not supported yet, nor is any other {}",
            object.tag.name()
        ));
    };
    let list = kind.supported.join(", ");
    if kind.missing.contains(&object.plugin.as_str()) {
        return object.error(format!(
            "{what} is not supported yet; supported are: {list}"
        ));
    }
    match nearest(
        &object.plugin,
        kind.supported.iter().chain(kind.missing).copied(),
    ) {
        Some(near) => object.error(format!(
            "unknown {what}, did you mean '{near}'? Supported are: {list}"
        )),
        None => object.error(format!("unknown {what}, expected one of: {list}")),
    }
}
