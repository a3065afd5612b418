//! Claim: however broken a scene or a mesh is, the answer is a message with its place, or a documented tolerance and an
//! image of finite numbers; never a panic, a hang or a NaN.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use brewster_tests::brewster;
use render::engine::{Job, Limits, render};
use render::film::SpectralMode;
use render::scene::{Overrides, build, read};

#[path = "../crates/render/tests/broken/cases.rs"]
#[expect(dead_code, reason = "what plugins ask for is tested beside the reader")]
mod cases;
use cases::{BROKEN, BROKEN_INSIDE, BROKEN_OBJ, inside};

/// More than any of these may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// What is to come of an input.
#[derive(Clone, Copy)]
enum Outcome {
    /// A message that contains this.
    Refused(&'static str),
    /// An image of finite numbers, and if the text is not empty a notice that contains it.
    Rendered(&'static str),
}
use Outcome::{Refused, Rendered};

/// The parts of a scene, each of which a case replaces.
const PARTS: [(&str, &str); 5] = [
    (
        "INTEGRATOR",
        "<integrator type='path'><integer name='max_depth' value='5'/></integrator>",
    ),
    (
        "CAMERA",
        "<float name='fov' value='40'/><transform name='to_world'><lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/></transform>",
    ),
    (
        "FILM",
        "<film type='hdrfilm'><integer name='width' value='6'/><integer name='height' value='5'/></film>",
    ),
    (
        "SHAPE",
        "<shape type='sphere'><bsdf type='diffuse'/></shape>",
    ),
    ("EMITTER", "<emitter type='constant'/>"),
];

/// A whole scene, five lines of parts, with one of them replaced.
fn scene_with(part: &str, text: &str) -> String {
    let chosen = PARTS.map(|(name, usual)| if name == part { text } else { usual });
    let [integrator, camera, film, shape, emitter] = chosen;
    format!(
        "<scene version='3.0.0'>\n{integrator}\n<sensor type='perspective'>{camera}\n{film}</sensor>\n{shape}\n{emitter}\n</scene>"
    )
}

#[rustfmt::skip]
const SCENES: &[(&str, &str, &str, Outcome)] = &[
    ("unknown integrator", "INTEGRATOR", "<integrator type='pth'/>", Refused("scene.xml:2:1: unknown integrator 'pth', did you mean 'path'?")),
    ("integrator to come", "INTEGRATOR", "<integrator type='volpath'/>", Refused("not supported yet")),
    ("empty stokes", "INTEGRATOR", "<integrator type='stokes'/>", Refused("scene.xml:2:1: integrator 'stokes' is empty, expected another integrator in it")),
    ("two integrators", "INTEGRATOR", "<integrator type='path'/><integrator type='path'/>", Refused("second")),
    ("depth in words", "INTEGRATOR", "<integrator type='path'><string name='max_depth' value='deep'/></integrator>", Refused("expected an integer")),
    ("depth below -1", "INTEGRATOR", "<integrator type='path'><integer name='max_depth' value='-2'/></integrator>", Refused("expected a number from -1")),
    ("depth of 64 bits", "INTEGRATOR", "<integrator type='path'><integer name='max_depth' value='9223372036854775807'/></integrator>", Refused("expected a number from -1")),
    ("depth zero", "INTEGRATOR", "<integrator type='path'><integer name='max_depth' value='0'/></integrator>", Rendered("")),
    ("roulette at once", "INTEGRATOR", "<integrator type='path'><integer name='rr_depth' value='0'/></integrator>", Refused("expected a number from 1")),
    ("misspelt parameter", "INTEGRATOR", "<integrator type='path'><integer name='max_dpeth' value='3'/></integrator>", Refused("unknown parameter 'max_dpeth'")),
    ("no sensor fov", "CAMERA", "", Rendered("")),
    ("fov zero", "CAMERA", "<float name='fov' value='0'/>", Refused("an angle of 0°, expected one between 0 and 180")),
    ("fov 180", "CAMERA", "<float name='fov' value='180'/>", Refused("expected one between 0 and 180")),
    ("fov next to 180", "CAMERA", "<float name='fov' value='179.99999999'/>", Rendered("")),
    ("fov of a nanodegree", "CAMERA", "<float name='fov' value='1e-9'/>", Rendered("")),
    ("fov and focal length", "CAMERA", "<float name='fov' value='40'/><string name='focal_length' value='50mm'/>", Refused("both 'fov' and 'focal_length' are given")),
    ("focal length without unit", "CAMERA", "<string name='focal_length' value='50'/>", Refused("expected a positive length such as '50mm'")),
    ("focal length of infinity", "CAMERA", "<string name='focal_length' value='infmm'/>", Refused("expected a positive length such as '50mm'")),
    ("unknown axis", "CAMERA", "<float name='fov' value='40'/><string name='fov_axis' value='w'/>", Refused("is 'w', expected 'x', 'y'")),
    ("stretched camera", "CAMERA", "<transform name='to_world'><scale x='2'/></transform>", Refused("a camera that is stretched or skewed")),
    ("flat camera", "CAMERA", "<transform name='to_world'><scale z='0'/></transform>", Refused("scene.xml:3")),
    ("camera in the sky", "CAMERA", "<transform name='to_world'><translate z='1e30'/></transform>", Refused("scene.xml:3:1: sensor 'perspective' reaches 1e30 m from the origin")),
    ("camera beyond single precision", "CAMERA", "<transform name='to_world'><translate z='1e300'/></transform>", Refused("choose a larger unit of length")),
    ("camera in the ball", "CAMERA", "<transform name='to_world'><translate x='0.5'/></transform>", Rendered("")),
    ("camera on the ball", "CAMERA", "<transform name='to_world'><translate z='-1'/></transform>", Rendered("")),
    ("camera in the centre", "CAMERA", "<float name='fov' value='90'/>", Rendered("")),
    ("unknown sensor parameter", "CAMERA", "<float name='aperture' value='1'/>", Refused("unknown parameter 'aperture'")),
    ("width zero", "FILM", "<film type='hdrfilm'><integer name='width' value='0'/></film>", Refused("'width' of film 'hdrfilm' is 0, expected a number from 1 to 65536")),
    ("negative height", "FILM", "<film type='hdrfilm'><integer name='height' value='-5'/></film>", Refused("'height' of film 'hdrfilm' is -5")),
    ("film of 1e9", "FILM", "<film type='hdrfilm'><integer name='width' value='1000000000'/><integer name='height' value='1000000000'/></film>", Refused("expected a number from 1 to 65536")),
    ("crop outside", "FILM", "<film type='hdrfilm'><integer name='crop_offset_x' value='768'/></film>", Refused("'crop_offset_x'")),
    ("crop too wide", "FILM", "<film type='hdrfilm'><integer name='crop_offset_x' value='700'/><integer name='crop_width' value='69'/></film>", Refused("'crop_width'")),
    ("crop empty", "FILM", "<film type='hdrfilm'><integer name='crop_height' value='0'/></film>", Refused("'crop_height'")),
    ("unknown film", "FILM", "<film type='hdrfil'/>", Refused("did you mean 'hdrfilm'?")),
    ("unknown filter", "FILM", "<film type='hdrfilm'><rfilter type='bx'/></film>", Refused("did you mean 'box'?")),
    ("filter without width", "FILM", "<film type='hdrfilm'><rfilter type='tent'><float name='radius' value='0'/></rfilter></film>", Refused("expected pixels, up to 100")),
    ("filter of 1e30", "FILM", "<film type='hdrfilm'><rfilter type='gaussian'><float name='stddev' value='1e30'/></rfilter></film>", Refused("expected pixels, up to 100")),
    ("no samples", "FILM", "<sampler type='independent'><integer name='sample_count' value='0'/></sampler>", Refused("expected a number from 1")),
    ("unknown sampler", "FILM", "<sampler type='indepedent'/>", Refused("did you mean 'independent'?")),
    ("unknown shape", "SHAPE", "<shape type='spere'/>", Refused("scene.xml:5:1: unknown shape 'spere', did you mean 'sphere'?")),
    ("shape to come", "SHAPE", "<shape type='ply'><string name='filename' value='a.ply'/></shape>", Refused("not supported yet")),
    ("radius zero", "SHAPE", "<shape type='sphere'><float name='radius' value='0'/></shape>", Refused("'radius' of shape 'sphere' is 0, expected a positive number")),
    ("negative radius", "SHAPE", "<shape type='cylinder'><float name='radius' value='-1'/></shape>", Refused("'radius' of shape 'cylinder' is -1, expected a positive number")),
    ("tiny radius", "SHAPE", "<shape type='sphere'><float name='radius' value='1e-44'/></shape>", Rendered("")),
    ("radius below single precision", "SHAPE", "<shape type='sphere'><float name='radius' value='1e-300'/></shape>", Rendered("")),
    ("huge radius", "SHAPE", "<shape type='sphere'><float name='radius' value='1e30'/></shape>", Refused("choose a larger unit of length")),
    ("largest radius", "SHAPE", "<shape type='sphere'><float name='radius' value='9e11'/></shape>", Rendered("")),
    ("point for a radius", "SHAPE", "<shape type='sphere'><point name='radius' x='1' y='1' z='1'/></shape>", Refused("expected a number")),
    ("cylinder without length", "SHAPE", "<shape type='cylinder'><point name='p0' value='1 1 1'/><point name='p1' value='1 1 1'/></shape>", Refused("'p0' and 'p1' are the same point")),
    ("squeezed sphere", "SHAPE", "<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>", Refused("a transform that stretches or skews shape 'sphere'")),
    ("flat rectangle", "SHAPE", "<shape type='rectangle'><transform name='to_world'><scale x='0'/></transform></shape>", Refused("scene.xml:5:25: transform 'to_world' of shape 'rectangle' maps space to a plane")),
    ("scale 1e30", "SHAPE", "<shape type='cube'><transform name='to_world'><scale value='1e30'/></transform></shape>", Refused("choose a larger unit of length")),
    ("scale 1e-30", "SHAPE", "<shape type='cube'><transform name='to_world'><scale value='1e-30'/></transform></shape>", Rendered("")),
    ("scale 1e-200", "SHAPE", "<shape type='cube'><transform name='to_world'><scale value='1e-200'/></transform></shape>", Rendered("")),
    ("skewed cube", "SHAPE", "<shape type='cube'><transform name='to_world'><matrix value='1 1 0 0 1 1 0 0 1'/></transform></shape>", Rendered("")),
    ("singular matrix", "SHAPE", "<shape type='cube'><transform name='to_world'><matrix value='1 2 3 2 4 6 1 1 1'/></transform></shape>", Refused("scene.xml:5")),
    ("needle", "SHAPE", "<shape type='cube'><transform name='to_world'><scale x='1e-20' y='1e6'/></transform></shape>", Rendered("")),
    ("shape in a shape", "SHAPE", "<shape type='cube'><shape type='cube'/></shape>", Refused("scene.xml:5:20")),
    ("two bsdfs", "SHAPE", "<shape type='cube'><bsdf type='diffuse'/><bsdf type='diffuse'/></shape>", Refused("scene.xml:5:")),
    ("unknown bsdf", "SHAPE", "<shape type='cube'><bsdf type='difuse'/></shape>", Refused("did you mean 'diffuse'?")),
    ("bsdf to come", "SHAPE", "<shape type='cube'><bsdf type='principled'/></shape>", Refused("not supported yet")),
    ("reflectance above one", "SHAPE", "<shape type='cube'><bsdf type='diffuse'><float name='reflectance' value='1.5'/></bsdf></shape>", Refused("scene.xml:5:")),
    ("negative reflectance", "SHAPE", "<shape type='cube'><bsdf type='diffuse'><float name='reflectance' value='-0.1'/></bsdf></shape>", Refused("scene.xml:5:")),
    ("negative index", "SHAPE", "<shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='-1.5'/></bsdf></shape>", Refused("an index of refraction of -1.5, expected a positive number")),
    ("index zero", "SHAPE", "<shape type='cube'><bsdf type='dielectric'><float name='ext_ior' value='0'/></bsdf></shape>", Refused("an index of refraction of 0, expected a positive number")),
    ("huge index", "SHAPE", "<shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='1e38'/></bsdf></shape>", Rendered("")),
    ("index of plastic", "SHAPE", "<shape type='cube'><bsdf type='pplastic'><float name='int_ior' value='-2'/></bsdf></shape>", Refused("an index of refraction of -2")),
    ("unknown glass", "SHAPE", "<shape type='cube'><bsdf type='dielectric'><string name='int_ior' value='watr'/></bsdf></shape>", Refused("did you mean 'water'?")),
    ("unknown metal", "SHAPE", "<shape type='cube'><bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf></shape>", Refused("unknown material 'Unobtainium'")),
    ("metal twice", "SHAPE", "<shape type='cube'><bsdf type='conductor'><string name='material' value='Au'/><float name='k' value='1'/></bsdf></shape>", Refused("both 'material' and 'eta', 'k' are given")),
    ("negative k", "SHAPE", "<shape type='cube'><bsdf type='conductor'><float name='eta' value='1'/><float name='k' value='-3'/></bsdf></shape>", Rendered("")),
    ("huge k", "SHAPE", "<shape type='cube'><bsdf type='conductor'><float name='k' value='1e38'/></bsdf></shape>", Rendered("")),
    ("no roughness", "SHAPE", "<shape type='cube'><bsdf type='roughconductor'><float name='alpha' value='0'/></bsdf></shape>", Refused("a roughness of 0, expected a positive number")),
    ("hair's breadth of roughness", "SHAPE", "<shape type='sphere'><bsdf type='roughconductor'><float name='alpha' value='1e-30'/></bsdf></shape>", Rendered("")),
    ("huge roughness", "SHAPE", "<shape type='sphere'><bsdf type='roughconductor'><float name='alpha' value='1e30'/></bsdf></shape>", Rendered("")),
    ("roughness twice", "SHAPE", "<shape type='cube'><bsdf type='roughconductor'><float name='alpha' value='1'/><float name='alpha_u' value='1'/></bsdf></shape>", Refused("both 'alpha' and 'alpha_u', 'alpha_v' are given")),
    ("unknown distribution", "SHAPE", "<shape type='cube'><bsdf type='roughconductor'><string name='distribution' value='phong'/></bsdf></shape>", Refused("is 'phong', expected 'beckmann' or 'ggx'")),
    ("angle of 1e30", "SHAPE", "<shape type='rectangle'><bsdf type='polarizer'><float name='theta' value='1e30'/></bsdf></shape>", Rendered("")),
    ("retardance of 1e30", "SHAPE", "<shape type='rectangle'><bsdf type='retarder'><float name='delta' value='1e30'/></bsdf></shape>", Rendered("")),
    ("empty twosided", "SHAPE", "<shape type='cube'><bsdf type='twosided'/></shape>", Refused("holds 0 bsdfs, expected one for both sides or one for each")),
    ("three sides", "SHAPE", "<shape type='cube'><bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf></shape>", Refused("holds 3 bsdfs")),
    ("twosided glass", "SHAPE", "<shape type='cube'><bsdf type='twosided'><bsdf type='dielectric'/></bsdf></shape>", Refused("has two sides already")),
    ("no mesh", "SHAPE", "<shape type='obj'/>", Refused("scene.xml:5:1")),
    ("missing mesh", "SHAPE", "<shape type='obj'><string name='filename' value='none.obj'/></shape>", Refused("no file 'none.obj'")),
    ("folder for a mesh", "SHAPE", "<shape type='obj'><string name='filename' value='parts'/></shape>", Refused("is a directory, expected a file")),
    ("scene for a mesh", "SHAPE", "<shape type='obj'><string name='filename' value='scene.xml'/></shape>", Refused("scene.xml:1: unknown statement '<scene'")),
    ("empty mesh", "SHAPE", "<shape type='obj'><string name='filename' value='empty.obj'/></shape>", Rendered("the file has no faces")),
    ("mesh without area", "SHAPE", "<shape type='obj'><string name='filename' value='flat.obj'/></shape>", Rendered("2 triangles have no area")),
    ("emitter on an empty mesh", "SHAPE", "<shape type='obj'><string name='filename' value='empty.obj'/><emitter type='area'/></shape>", Refused("an emitter on a mesh without area")),
    ("emitter on a mesh without area", "SHAPE", "<shape type='obj'><string name='filename' value='flat.obj'/><emitter type='area'/></shape>", Refused("an emitter on a mesh without area")),
    ("emitter with some triangles without area", "SHAPE", "<shape type='obj'><string name='filename' value='partly.obj'/><emitter type='area'/></shape>", Rendered("1 triangles have no area")),
    ("mesh of 1e38", "SHAPE", "<shape type='obj'><string name='filename' value='huge.obj'/></shape>", Refused("choose a larger unit of length")),
    ("mesh of 1e-40", "SHAPE", "<shape type='obj'><string name='filename' value='tiny.obj'/></shape>", Rendered("")),
    ("radiance 1e38", "EMITTER", "<emitter type='constant'><float name='radiance' value='1e38'/></emitter>", Rendered("")),
    ("radiance beyond single precision", "EMITTER", "<emitter type='constant'><float name='radiance' value='1e39'/></emitter>", Refused("scene.xml:6:")),
    ("negative radiance", "EMITTER", "<emitter type='constant'><float name='radiance' value='-1'/></emitter>", Refused("scene.xml:6:")),
    ("no light at all", "EMITTER", "", Rendered("")),
    ("two surroundings", "EMITTER", "<emitter type='constant'/><emitter type='constant'/>", Refused("second emitter that surrounds the scene")),
    ("lone area light", "EMITTER", "<emitter type='area'/>", Refused("scene.xml:6:1: emitter 'area' stands alone, expected it inside a shape")),
    ("constant light in a shape", "EMITTER", "<shape type='cube'><emitter type='constant'/></shape>", Refused("inside a shape, expected 'area'")),
    ("unknown emitter", "EMITTER", "<emitter type='pont'/>", Refused("did you mean 'point'?")),
    ("emitter to come", "EMITTER", "<emitter type='envmap'/>", Refused("not supported yet")),
    ("point light on a surface", "EMITTER", "<emitter type='point'><point name='position' x='0' y='0' z='1'/></emitter>", Rendered("")),
    ("point light in the sky", "EMITTER", "<emitter type='point'><point name='position' x='0' y='0' z='1e30'/></emitter>", Refused("scene.xml:6:")),
    ("spot of no angle", "EMITTER", "<emitter type='spot'><float name='cutoff_angle' value='0'/></emitter>", Refused("scene.xml:6:")),
    ("spot of 400 degrees", "EMITTER", "<emitter type='spot'><float name='cutoff_angle' value='400'/></emitter>", Refused("scene.xml:6:")),
    ("spot wider than itself", "EMITTER", "<emitter type='spot'><float name='cutoff_angle' value='20'/><float name='beam_width' value='30'/></emitter>", Refused("scene.xml:6:")),
    ("directional light without direction", "EMITTER", "<emitter type='directional'><vector name='direction' x='0' y='0' z='0'/></emitter>", Refused("scene.xml:6:")),
    ("spectrum for a scene", "EMITTER", "<spectrum name='radiance' value='1'/>", Refused("scene.xml:6:1")),
];

/// A folder with the meshes that the scenes name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("parts")).unwrap();
    for (name, text) in [
        ("empty.obj", "# nothing\nv 0 0 0\ng a\ng b\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 1\n"),
        (
            "partly.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n",
        ),
        ("huge.obj", "v 1e38 0 0\nv 0 1e38 0\nv 0 0 1e38\nf 1 2 3\n"),
        (
            "tiny.obj",
            "v 1e-40 0 0\nv 0 1e-40 0\nv 0 0 1e-40\nf 1 2 3\n",
        ),
        ("parts/a.obj", "o a\nv 0 0 0\n"),
        ("light.xml", "<emitter type='constant' version='3.0.0'/>"),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Reads, builds and renders a scene file: the notices, or the refusal.
fn render_file(path: &Path) -> Result<Vec<String>, String> {
    let refused = |error: render::scene::SceneError| error.to_string();
    let document = read(path, &[]).map_err(refused)?;
    let built = build(&document, Overrides::default()).map_err(refused)?;
    for mode in [SpectralMode::Single(550.0), SpectralMode::Rgb] {
        let built = build(&document, Overrides::default()).map_err(refused)?;
        let job = Job {
            samples: 4,
            seed: 1,
            ..Job::new(built, mode)
        };
        let rendering = render(&job, Limits::default(), &AtomicBool::new(false), |_| ());
        let (values, variances) = rendering.image();
        assert!(
            values.iter().all(|v| v.is_finite()),
            "a pixel is not finite"
        );
        assert!(
            variances.iter().all(|v| !v.is_nan()),
            "a variance is not a number"
        );
    }
    drop(built);
    Ok(document.notices())
}

/// Renders a scene text within the time that is allowed; a panic becomes a failure with the name of the case.
fn outcome(folder: &Path, name: &str, text: &str) -> Result<Vec<String>, String> {
    let path = folder.join("scene.xml");
    fs::write(&path, text).unwrap();
    let start = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| render_file(&path)))
        .unwrap_or_else(|_| panic!("panic: {name}"));
    assert!(
        start.elapsed() < PATIENCE,
        "{name} took {:?}",
        start.elapsed()
    );
    if let Err(message) = &outcome {
        let file = message
            .strip_prefix(folder.to_str().unwrap())
            .unwrap_or_else(|| panic!("{name}: no file in '{message}'"));
        let place = file.split(": ").next().unwrap_or_default();
        let line = place
            .split(':')
            .nth(1)
            .and_then(|line| line.parse::<u32>().ok());
        assert!(line > Some(0), "{name}: no line in '{message}'");
    }
    outcome
}

/// What went wrong in a list of cases, all of it.
fn check(failures: &[String]) {
    assert!(
        failures.is_empty(),
        "{} cases:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

#[test]
fn a_broken_scene_is_refused_with_its_place_or_rendered_without_nan() {
    let folder = folder();
    let mut failures = Vec::new();
    for (name, part, text, expected) in SCENES {
        match (
            outcome(folder.path(), name, &scene_with(part, text)),
            expected,
        ) {
            (Err(found), Refused(words)) if found.contains(words) => {}
            (Ok(notices), Rendered(words)) if notices.concat().contains(words) => {}
            (Err(found), Refused(words)) => {
                failures.push(format!("{name}: found '{found}', expected '{words}'"));
            }
            (Err(found), Rendered(_)) => failures.push(format!("{name}: refused: '{found}'")),
            (Ok(notices), _) => failures.push(format!("{name}: rendered with {notices:?}")),
        }
    }
    check(&failures);
}

#[test]
fn the_usual_scene_is_rendered() {
    let folder = folder();
    assert_eq!(
        outcome(folder.path(), "usual", &scene_with("", "")),
        Ok(Vec::new())
    );
}

#[test]
fn broken_text_and_broken_meshes_stop_before_anything_is_rendered() {
    let folder = folder();
    let mut failures = Vec::new();
    let mut expect_refusal = |name: &str, text: &str| {
        if outcome(folder.path(), name, text).is_ok() {
            failures.push(format!("{name}: rendered"));
        }
    };
    for (name, text, _) in BROKEN {
        expect_refusal(name, text);
    }
    for (name, text, _) in BROKEN_INSIDE {
        expect_refusal(name, &inside(text));
    }
    let mesh = "<shape type='obj'><string name='filename' value='broken.obj'/></shape>";
    for (name, text, _) in BROKEN_OBJ {
        fs::write(folder.path().join("broken.obj"), text).unwrap();
        expect_refusal(name, &scene_with("SHAPE", mesh));
    }
    check(&failures);
}

#[test]
fn a_scene_cut_off_anywhere_is_refused() {
    let folder = folder();
    let whole = scene_with("", "");
    for end in 0..whole.len() {
        assert!(
            outcome(
                folder.path(),
                &format!("the first {end} bytes"),
                &whole[..end]
            )
            .is_err()
        );
    }
}

#[test]
fn the_program_exits_with_2_and_one_line() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    // every ninth, and a mesh
    for (name, part, text, _) in SCENES
        .iter()
        .filter(|(.., expected)| matches!(expected, Refused(_)))
        .step_by(6)
    {
        fs::write(&path, scene_with(part, text)).unwrap();
        let output = brewster()
            .args(["render", "--quiet", "-o"])
            .arg(folder.path().join("a.exr"))
            .arg(&path)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(
            said.starts_with("brewster: ") && said.trim_end().lines().count() == 1,
            "{name}: {said}"
        );
        assert!(
            output.stdout.is_empty() && !folder.path().join("a.exr").exists(),
            "{name}"
        );
    }
}

#[test]
fn the_program_writes_finite_numbers_for_what_it_tolerates_and_says_what_it_left_out() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    fs::write(
        &path,
        scene_with(
            "EMITTER",
            "<emitter type='constant'><float name='radiance' value='3e38'/></emitter>",
        ),
    )
    .unwrap();
    let image = folder.path().join("a.exr");
    let output = brewster()
        .args(["render", "--rgb", "-o"])
        .arg(&image)
        .arg(&path)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("were not finite and count as black"),
        "{said}"
    );
    let image = render::output::read(&image).unwrap();
    assert!(image.stokes.iter().all(|v| v.is_finite()));
}
