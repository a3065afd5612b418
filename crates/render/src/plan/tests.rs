//! Plans of small scenes, part by part.

use super::polarization::Needs;
use super::{Components, Plan, Request, Stock, Wavelengths};
use crate::film::SpectralMode;
use crate::scene::{BuiltScene, Overrides, build, read_text};

const ONE: SpectralMode = SpectralMode::Single(550.0);
const RGB: SpectralMode = SpectralMode::Rgb;
const VISIBLE: SpectralMode = SpectralMode::Bands {
    from: 400.0,
    to: 700.0,
    count: 6,
};

fn built(content: &str, depth: u32) -> BuiltScene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='{depth}'/></integrator>\
         <sensor type='perspective'/>{content}</scene>"
    );
    let document = read_text(&text, "test.xml".as_ref(), &[]).unwrap();
    build(&document, Overrides::default()).unwrap()
}

/// A sphere of each matter.
fn spheres<const N: usize>(matter: [&str; N]) -> String {
    let sphere = |bsdf| format!("<shape type='sphere'>{bsdf}</shape>\n");
    matter.map(sphere).concat()
}

fn plan(content: &str, depth: u32, mode: &SpectralMode) -> (Plan, String) {
    let request = Request {
        mode,
        polarized: true,
        coherence: false,
        skip: true,
    };
    told(&built(content, depth), &request)
}

/// A plan, and all that it says.
fn told(built: &BuiltScene, request: &Request<'_>) -> (Plan, String) {
    let plan = Plan::of(built, request);
    let lines = plan.decisions().iter();
    let text = lines.map(|d| format!("{} {d}\n", d.verdict())).collect();
    (plan, text)
}

/// Whether linear, and circular, polarization can arrive.
fn needs(content: &str, depth: u32) -> (bool, bool) {
    let built = built(content, depth);
    let needs = Needs::of(&Stock::of(&built));
    (needs.linear.possible, needs.circular.possible)
}

#[test]
fn depolarizers_alone_need_no_stokes_vectors() {
    let matter = spheres(["<bsdf type='diffuse'/>", "<bsdf type='null'/>"]);
    assert_eq!(needs(&matter, 8), (false, false));
    let (plan, text) = plan(&matter, 8, &ONE);
    assert_eq!(plan.stokes, Components::Intensity);
    assert!(
        text.contains("skipped S1, S2, S3: zero, no matter within reach polarizes"),
        "{text}"
    );
}

#[test]
fn one_reflection_makes_no_circular_light_but_two_do() {
    let metal = spheres(["<bsdf type='conductor'/>"]);
    assert_eq!(needs(&metal, 1), (false, false));
    assert_eq!(needs(&metal, 2), (true, false));
    assert_eq!(needs(&metal, 3), (true, true));
}

#[test]
fn plastic_and_polarizers_never_retard() {
    let linear = spheres(["<bsdf type='pplastic'/>", "<bsdf type='polarizer'/>"]);
    assert_eq!(needs(&linear, 50), (true, false));
    assert_eq!(
        needs(&spheres(["<bsdf type='retarder'/>"]), 50),
        (false, false)
    );
    let both = spheres(["<bsdf type='retarder'/>", "<bsdf type='circular'/>"]);
    assert_eq!(needs(&both, 50), (true, true));
    assert_eq!(
        needs(&spheres(["<bsdf type='circular'/>"]), 50),
        (false, true)
    );
    let sides = spheres(["<bsdf type='twosided'><bsdf type='pplastic'/></bsdf>"]);
    assert_eq!(needs(&sides, 50), (true, false));
}

#[test]
fn polarized_emitters_need_stokes_vectors_at_once() {
    let lamp = |stokes: &str| {
        format!("<emitter type='point'><string name='stokes' value='{stokes}'/></emitter>")
    };
    assert_eq!(needs(&lamp("1, 0, 0, 0"), 8), (false, false));
    assert_eq!(needs(&lamp("1, 0, 0.5, 0"), 1), (true, false));
    assert_eq!(needs(&lamp("1, 0, 0, -0.5"), 1), (false, true));
    let plate = spheres(["<bsdf type='retarder'/>"]);
    // one plate is enough for light that is polarized already
    assert_eq!(needs(&(lamp("1, 0.5, 0, 0") + &plate), 2), (true, true));
    assert_eq!(needs(&(lamp("1, 0, 0, 1") + &plate), 2), (true, true));
    assert_eq!(needs(&(lamp("1, 0, 0, 1") + &plate), 1), (false, true));
}

#[test]
fn matter_that_no_shape_is_made_of_needs_nothing() {
    let unused = "<bsdf type='conductor' id='gold'/><bsdf type='roughsurface' id='mat'>\
                  <string name='height' value='0.1um'/><string name='length' value='5um'/></bsdf>\
                  <bsdf type='polarizer' id='film'/>";
    let used = spheres(["<bsdf type='diffuse'/>"]);
    let (plan, text) = plan(&(unused.to_owned() + &used), 8, &ONE);
    assert_eq!(plan.stokes, Components::Intensity, "{text}");
    for line in [
        "skipped conductor 'gold' (test.xml:1:",
        "skipped coherence of the light on matter: no matter answers to it",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let built = built(&(unused.to_owned() + &used), 8);
    assert!(!built.scene.traits().coherent && !built.scene.traits().straight);
}

#[test]
fn reasons_name_matter_and_its_place() {
    let matter = spheres([
        "<bsdf type='diffuse'/>",
        "<bsdf type='polarizer' id='sheet'/>",
    ]);
    let light = "<emitter type='point'/>";
    let (plan, text) = plan(&(light.to_owned() + &matter), 8, &ONE);
    assert_eq!(plan.stokes, Components::Linear);
    let sheet = "polarizer 'sheet' (test.xml:2:22)";
    for line in [
        format!("kept S1, S2: {sheet} polarizes linearly"),
        "skipped S3: zero, no matter retards".to_owned(),
        format!("kept flat elements on the way to emitters: {sheet} lets light straight through"),
        "kept connections to emitters: diffuse (test.xml:1:".to_owned(),
        "skipped last rays of the longest paths: all emitters are points".to_owned(),
        "skipped light from outside the scene: no emitter surrounds it".to_owned(),
        "skipped all wavelengths but one: 550 nm is asked for".to_owned(),
        "skipped coherence of the light at the sensor: not asked for".to_owned(),
    ] {
        assert!(text.contains(&line), "{line}: {text}");
    }
}

#[test]
fn one_path_serves_all_colours_where_light_and_matter_are_grey() {
    let sky = "<emitter type='constant'/>";
    let grey = spheres([
        "<bsdf type='diffuse'/>",
        "<bsdf type='conductor'><float name='eta' value='0.2'/><float name='k' value='3'/></bsdf>",
        "<bsdf type='dielectric'/>",
        "<bsdf type='retarder'/>",
        "<bsdf type='rotator'/>",
        "<bsdf type='diffuse'><spectrum name='reflectance' value='300:0.4, 500:0.4, 900:0.4'/></bsdf>",
    ]);
    for mode in [&RGB, &VISIBLE] {
        let (plan, text) = plan(&(sky.to_owned() + &grey), 8, mode);
        assert_eq!(plan.wavelengths, Wavelengths::One, "{text}");
        assert!(text.contains("skipped all wavelengths but one: light and matter are the same"));
    }
}

#[test]
fn what_depends_on_the_wavelength_is_found() {
    let sky = "<emitter type='constant'/>";
    for (light, matter, culprit) in [
        (
            "<emitter type='constant'><rgb name='radiance' value='1, 1, 1'/></emitter>",
            "<bsdf type='diffuse'/>",
            "emitter constant (test.xml:1:",
        ),
        (
            sky,
            "<bsdf type='diffuse'><rgb name='reflectance' value='0.5, 0.4, 0.3'/></bsdf>",
            "diffuse (test.xml:1:",
        ),
        (
            sky,
            "<bsdf type='conductor'><string name='material' value='Au'/></bsdf>",
            "conductor (test.xml:1:",
        ),
        (
            sky,
            "<bsdf type='rotator'><float name='angle' value='20'/><string name='reference' value='589nm'/></bsdf>",
            "rotator (test.xml:1:",
        ),
        (
            sky,
            "<bsdf type='diffuse'><spectrum name='reflectance' value='500:0.4, 900:0.4'/></bsdf>",
            "diffuse (test.xml:1:",
        ),
        (
            sky,
            "<bsdf type='birefringent'><string name='no' value='1.54'/><string name='ne' value='1.55'/>\
             <string name='thickness' value='10um'/></bsdf>",
            "birefringent (test.xml:1:",
        ),
    ] {
        let (plan, text) = plan(&(light.to_owned() + &spheres([matter])), 8, &VISIBLE);
        assert_eq!(plan.wavelengths, Wavelengths::Together, "{text}");
        let line = format!("kept wavelengths: {culprit}");
        assert!(text.contains(&line), "{line}: {text}");
    }
}

#[test]
fn a_grating_gives_each_wavelength_a_path_of_its_own() {
    let grating = spheres([
        "<bsdf type='grating'><string name='pitch' value='1.6um'/><string name='depth' value='100nm'/></bsdf>",
    ]);
    let (plan, text) = plan(
        &("<emitter type='constant'/>".to_owned() + &grating),
        8,
        &RGB,
    );
    assert_eq!(plan.wavelengths, Wavelengths::Apart, "{text}");
    assert!(
        text.contains("kept a path for each wavelength: grating (test.xml:1:"),
        "{text}"
    );
}

#[test]
fn coherence_that_is_asked_for_keeps_all_wavelengths() {
    let built = built("<emitter type='constant'/>", 8);
    let request = Request {
        mode: &RGB,
        polarized: true,
        coherence: true,
        skip: true,
    };
    let (plan, text) = told(&built, &request);
    assert_eq!(plan.wavelengths, Wavelengths::Together, "{text}");
    assert!(text.contains("kept coherence of the light at the sensor: asked for"));
}

#[test]
fn without_emitters_nothing_is_traced() {
    let (plan, text) = plan(&spheres(["<bsdf type='diffuse'/>"]), 8, &ONE);
    assert!(plan.dark && text.contains("skipped paths: the scene has no emitter"));
}

#[test]
fn paths_end_at_black_matter() {
    let lamp = "<shape type='disk'><emitter type='area'/></shape>";
    let (_, text) = plan(
        &(lamp.to_owned() + &spheres(["<bsdf type='null'/>"])),
        8,
        &ONE,
    );
    for line in [
        "skipped paths beyond black matter: black (default) reflects nothing",
        "skipped connections to emitters: no matter within reach scatters light",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let mut built = built(lamp, 8);
    assert!(built.scene.traits_of(0).black);
    built.scene.follow_everything();
    assert!(!built.scene.traits_of(0).black);
    // one side that reflects is enough
    let half = "<bsdf type='twosided'><bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>\
                <bsdf type='diffuse'/></bsdf>";
    let scene = super::tests::built(&spheres([half]), 8).scene;
    assert!(!scene.traits_of(0).black);
}

#[test]
fn wave_matter_tells_what_it_leaves_out() {
    let rough = spheres([
        "<bsdf type='roughsurface'><string name='height' value='0.1um'/>\
                          <string name='length' value='5um'/></bsdf>",
    ]);
    let (_, text) = plan(&("<emitter type='constant'/>".to_owned() + &rough), 8, &ONE);
    for line in [
        "kept coherence of the light on matter: roughsurface (test.xml:1:",
        "): all but at most ",
        "skipped Hermite-Gauss orders above 0 of the incident light",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

#[test]
fn nothing_is_skipped_on_request() {
    let built = built(&spheres(["<bsdf type='diffuse'/>"]), 8);
    let request = Request {
        mode: &RGB,
        polarized: true,
        coherence: false,
        skip: false,
    };
    let (plan, text) = told(&built, &request);
    assert!(plan.stokes == Components::All && !plan.dark);
    assert_eq!(plan.wavelengths, Wavelengths::Together);
    assert!(
        text.contains(
            "kept S1, S2, S3: zero, no matter within reach polarizes; followed all the same"
        ),
        "{text}"
    );
    // but not what nobody asks for
    assert!(text.contains("skipped coherence of the light at the sensor"));
    let scalar = Request {
        polarized: false,
        ..request
    };
    assert_eq!(told(&built, &scalar).0.stokes, Components::Intensity);
}
