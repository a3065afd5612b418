//! Claim: scenes outside the references mean here what they mean in Mitsuba 3.9.1.
//!
//! Small scenes with what users write: every shape, anisotropic, mirrored, stretched and turned inside out; meshes
//! with and without normals; lights of every kind; a cropped film, a rolled camera, the default filter; colours. The
//! mean Stokes vectors of the four quarters of each image are compared with Mitsuba's, with both standard errors.
//!
//! The numbers: `mi.load_file(path, optimize=False)`, 64 renders `mi.render(scene, spp=1024, seed=100..164)` of the
//! variant `llvm_ad_mono_polarized`, `llvm_ad_spectral_polarized` for colours; mean over the quarter and its standard
//! error from the scatter of the renders. (Unless `optimize=False`, 3.9.1 refuses meshes that differ in `flip_normals`.)

use std::path::Path;
use std::sync::atomic::AtomicBool;

use render::engine::{Job, Limits, render};
use render::film::SpectralMode;
use render::plan::Plan;
use render::scene::{self, Overrides};

/// Mean and standard error of S0..S3.
type Mean = ([f64; 4], [f64; 4]);

/// Mean and standard error of each quarter (top left, top right, bottom left, bottom right) and each colour in it.
fn quarters(name: &str, mode: SpectralMode, polarized: bool) -> Vec<Mean> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/against_mitsuba")
        .join(name);
    let document = scene::read(&path, &[]).expect("a scene that can be read");
    let built = scene::build(&document, Overrides::default()).expect("a scene");
    let [width, height] = built.film.crop_size.map(|n| n as usize);
    let colours = mode.colours();
    let job = Job {
        polarized,
        plan: Plan::in_full(&built.scene, &mode, polarized),
        samples: 512,
        seed: 1,
        ..Job::new(built, mode)
    };
    let rendering = render(&job, Limits::default(), &AtomicBool::new(false), |_| {});
    assert_eq!(rendering.rejected, 0, "{name}: samples that are not finite");
    let (means, variances) = rendering.image();
    let components = if polarized { 4 } else { 1 };
    let count = (width * height / 4) as f64;
    let mut quarters = Vec::new();
    for (top, left) in [
        (0, 0),
        (0, width / 2),
        (height / 2, 0),
        (height / 2, width / 2),
    ] {
        for colour in 0..colours {
            let of_component = |component: usize| {
                let pixels = (top..top + height / 2)
                    .flat_map(|y| (left..left + width / 2).map(move |x| y * width + x));
                let (mean, variance) = pixels.fold((0.0, 0.0), |(mean, variance), pixel| {
                    let at = (pixel * components + component) * colours + colour;
                    (
                        mean + f64::from(means[at]),
                        variance + f64::from(variances[at]),
                    )
                });
                (mean / count, variance.sqrt() / count)
            };
            let all = [0, 1, 2, 3].map(|component| {
                if component < components {
                    of_component(component)
                } else {
                    (0.0, 0.0)
                }
            });
            quarters.push((all.map(|(mean, _)| mean), all.map(|(_, error)| error)));
        }
    }
    quarters
}

/// Every difference within 4.5 standard errors, and `relative` of S0 for what differs on purpose.
fn agrees(name: &str, mode: SpectralMode, relative: f64, mitsuba: &[Mean]) {
    compare(name, &quarters(name, mode, true), relative, mitsuba);
}

fn compare(name: &str, ours: &[Mean], relative: f64, mitsuba: &[Mean]) {
    assert_eq!(ours.len(), mitsuba.len());
    for (index, ((mean, error), (expected, noise))) in ours.iter().zip(mitsuba).enumerate() {
        for k in 0..4 {
            // 1e-6: single precision on both sides
            let allowed = 4.5 * error[k].hypot(noise[k]) + relative * expected[0] + 1e-6;
            assert!(
                (mean[k] - expected[k]).abs() <= allowed,
                "{name}, mean {index}, S{k}: {} here, {} in Mitsuba, {allowed:.1e} allowed",
                mean[k],
                expected[k],
            );
        }
    }
}

const ONE: SpectralMode = SpectralMode::Single(550.0);

#[test]
fn every_shape_has_mitsubas_front_and_axis_u() {
    agrees(
        "shapes.xml",
        ONE,
        0.0,
        &[
            (
                [0.158226, 0.002511, -0.000517, -0.000044],
                [1.2e-05, 1.8e-06, 1.9e-06, 1.6e-07],
            ),
            (
                [0.181296, 0.001085, 0.001728, 0.000003],
                [3.8e-05, 1.5e-06, 2.7e-06, 2.2e-07],
            ),
            (
                [0.222413, 0.000726, 0.005621, 0.000195],
                [7.7e-05, 3.8e-06, 7.1e-06, 1.1e-06],
            ),
            (
                [0.184755, 0.000042, 0.002283, 0.000004],
                [7.5e-05, 4.1e-06, 5.0e-06, 8.0e-07],
            ),
        ],
    );
}

#[test]
fn meshes_are_placed_as_mitsuba_places_them() {
    agrees(
        "meshes.xml",
        ONE,
        0.0,
        &[
            (
                [0.185638, -0.000628, 0.001674, -0.000001],
                [4.3e-05, 2.0e-06, 3.3e-06, 6.5e-08],
            ),
            (
                [0.274015, -0.007581, 0.007790, -0.000038],
                [1.0e-04, 4.1e-06, 5.9e-06, 6.6e-07],
            ),
            (
                [0.159127, -0.000237, 0.000608, -0.000002],
                [3.2e-05, 1.1e-06, 2.3e-06, 2.9e-07],
            ),
            (
                [0.172499, -0.001673, 0.001014, 0.000002],
                [4.6e-05, 2.5e-06, 2.3e-06, 3.7e-07],
            ),
        ],
    );
}

#[test]
fn small_lights_and_a_cropped_film_agree() {
    agrees(
        "lights.xml",
        ONE,
        0.0,
        &[
            (
                [0.043048, -0.000629, -0.003923, -0.000036],
                [1.6e-05, 1.0e-06, 1.5e-06, 1.1e-07],
            ),
            (
                [0.074851, -0.001888, -0.004555, -0.000000],
                [1.7e-05, 2.6e-06, 1.4e-06, 1.5e-09],
            ),
            (
                [0.089827, 0.000054, -0.004310, -0.000052],
                [2.2e-05, 1.6e-06, 1.9e-06, 2.5e-07],
            ),
            (
                [0.079839, -0.000931, -0.002329, -0.000000],
                [1.2e-05, 1.4e-06, 1.5e-06, 6.7e-09],
            ),
        ],
    );
}

/// One thousandth for the colour-matching functions: Mitsuba's are in steps of 5 nm.
#[test]
fn colours_of_light_and_matter_agree() {
    agrees(
        "colours.xml",
        SpectralMode::Rgb,
        1e-3,
        &[
            (
                [0.125669, -0.001050, -0.000365, -0.000004],
                [4.0e-05, 4.3e-06, 1.1e-06, 2.1e-07],
            ),
            (
                [0.102972, 0.001721, 0.001198, 0.000001],
                [3.7e-05, 3.5e-06, 3.0e-06, 1.2e-07],
            ),
            (
                [0.082133, 0.004209, 0.002031, 0.000004],
                [4.8e-05, 3.3e-06, 4.1e-06, 1.1e-07],
            ),
            (
                [0.112593, -0.001683, 0.000323, 0.000000],
                [1.8e-05, 3.5e-06, 8.5e-07, 0.0e+00],
            ),
            (
                [0.089447, 0.001120, -0.000200, 0.000000],
                [1.3e-05, 2.9e-06, 7.7e-07, 0.0e+00],
            ),
            (
                [0.067767, 0.003758, -0.000681, 0.000000],
                [1.4e-05, 2.7e-06, 7.5e-07, 0.0e+00],
            ),
            (
                [0.137088, -0.001458, -0.000511, -0.000076],
                [4.0e-05, 3.9e-06, 1.5e-06, 9.9e-07],
            ),
            (
                [0.093254, 0.000299, 0.000100, -0.000171],
                [2.5e-05, 3.4e-06, 1.4e-06, 1.4e-06],
            ),
            (
                [0.049892, 0.002702, 0.000893, -0.000307],
                [2.7e-05, 4.5e-06, 2.0e-06, 2.3e-06],
            ),
            (
                [0.121556, -0.001996, 0.000590, -0.000000],
                [2.7e-05, 2.6e-06, 9.0e-07, 1.6e-10],
            ),
            (
                [0.121767, 0.000446, -0.000110, 0.000000],
                [3.1e-05, 1.8e-06, 6.5e-07, 7.8e-11],
            ),
            (
                [0.049425, 0.002328, -0.000660, 0.000000],
                [2.2e-05, 1.7e-06, 6.2e-07, 7.2e-11],
            ),
        ],
    );
}

/// Mitsuba forgets polarization in plastic and in rough glass (`llvm_ad_mono`): scalar transport does the same.
///
/// A thousandth for the sum over facets by which Mitsuba makes its tables.
#[test]
fn plastic_and_rough_glass_are_as_bright() {
    let s0 = |mean: f64, error: f64| ([mean, 0.0, 0.0, 0.0], [error, 0.0, 0.0, 0.0]);
    compare(
        "glossy.xml",
        &quarters("glossy.xml", ONE, false),
        1e-3,
        &[
            s0(0.173945, 3.9e-5),
            s0(0.112916, 9.0e-5),
            s0(0.111731, 1.4e-5),
            s0(0.139842, 2.3e-5),
        ],
    );
}

/// The middle pixel of an image of a rectangle in surroundings of radiance 1.
fn rectangle_in_a_furnace(inside: &str) -> f32 {
    let text = format!(
        "<scene version='3.0.0'><emitter type='constant'/><shape type='rectangle'>{inside}</shape>\
         <integrator type='path'><integer name='max_depth' value='2'/></integrator>\
         <sensor type='perspective'><transform name='to_world'><lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/>\
         </transform><film type='hdrfilm'><integer name='width' value='3'/><integer name='height' value='3'/></film></sensor></scene>"
    );
    let document = scene::read_text(&text, Path::new("scene.xml"), &[]).expect("a scene");
    let built = scene::build(&document, Overrides::default()).expect("a scene");
    let job = Job {
        polarized: false,
        plan: Plan::in_full(&built.scene, &ONE, false),
        samples: 256,
        seed: 1,
        ..Job::new(built, ONE)
    };
    let rendering = render(&job, Limits::default(), &AtomicBool::new(false), |_| {});
    rendering.image().0[4]
}

#[test]
fn a_shape_without_bsdf_is_grey_and_black_if_it_shines() {
    // cosine sampling of a Lambertian surface in even light has no variance
    assert!((rectangle_in_a_furnace("") - 0.5).abs() < 1e-5);
    let lamp = "<emitter type='area'><float name='radiance' value='0.25'/></emitter>";
    assert_eq!(rectangle_in_a_furnace(lamp), 0.25);
}
