//! Claim: what is skipped changes no image: `--no-skip` gives the same within rounding.
//!
//! Both images take the same random numbers for the same decisions, so that they differ by rounding alone. Where Stokes
//! vectors are skipped no matter diattenuates: each link of a path multiplies two or three numbers and adds zeros, in
//! another order, which rounds at most four times. Where wavelengths are skipped the same is done on one lane instead of
//! four. Everything else is the same arithmetic. Hence n links err by at most 4n units of rounding of what they carry, and
//! a pixel by as much of its S0; links beyond the 64th carry too little to be seen.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use brewster_tests::{make_big_mesh, repository};
use render::engine::{Job, Limits, render};
use render::film::SpectralMode;
use render::plan::{Plan, Request, Wavelengths};
use render::scene::{Document, Overrides, build, read, read_text};

/// Half the distance of 1 to the next number of single precision.
const ROUNDING: f64 = 5.960_464_477_539_063e-8;

/// Weights of wavelengths in linear sRGB have both signs: their sums may be this much smaller than what they add up.
const CANCELS: f64 = 8.0;

/// What was skipped in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Skipped {
    stokes: bool,
    wavelengths: bool,
    rays: bool,
    paths: bool,
}

/// Means of an image, and the rays that it took.
fn image(job: &Job) -> (Vec<f32>, u64) {
    let rendering = render(job, Limits::default(), &AtomicBool::new(false), |_| ());
    assert_eq!(rendering.rejected, 0);
    (rendering.image().0, rendering.counters.rays)
}

/// Renders a scene in every mode, with and without skipping, and compares.
fn compare(name: &str, document: &Document, size: Option<[u32; 2]>, polarized: bool) -> Skipped {
    let overrides = Overrides { size, crop: None };
    let built = build(document, overrides).unwrap_or_else(|error| panic!("{error}"));
    let links = f64::from(built.paths.max_depth.min(64));
    let modes = [
        SpectralMode::Single(550.0),
        SpectralMode::Bands {
            from: 450.0,
            to: 650.0,
            count: 6,
        },
        SpectralMode::Rgb,
    ];
    let plans = modes.clone().map(|mode| {
        [true, false].map(|skip| {
            let request = Request {
                mode: &mode,
                polarized,
                coherence: false,
                skip,
            };
            Plan::of(&built, &request)
        })
    });
    let mut job = Job {
        polarized,
        samples: 4,
        block: 4,
        seed: 3,
        ..Job::new(built, modes[0].clone())
    };
    let mut skipping = Vec::new();
    let mut skipped = Skipped::default();
    for (mode, [plan, full]) in modes.iter().zip(&plans) {
        job.mode = mode.clone();
        job.plan = plan.clone();
        skipping.push(image(&job));
        skipped.stokes |= plan.stokes != full.stokes;
        skipped.wavelengths |= plan.wavelengths != full.wavelengths;
        skipped.paths |= plan.dark;
        assert_ne!(full.wavelengths == Wavelengths::One, mode.colours() > 1);
    }
    job.scene.follow_everything();
    for ((mode, [_, full]), (found, rays)) in modes.iter().zip(plans).zip(&skipping) {
        job.mode = mode.clone();
        job.plan = full;
        let (expected, all_rays) = image(&job);
        skipped.rays |= mode.colours() == 1 && *rays < all_rays;
        let colours = mode.colours();
        let stride = colours * if polarized { 4 } else { 1 };
        let both = expected.chunks(stride).zip(found.chunks(stride));
        for (pixel, (expected, found)) in both.enumerate() {
            let s0 = |colour: usize| f64::from(expected[colour]).abs();
            let scale: f64 = match mode {
                SpectralMode::Rgb => CANCELS * (0..colours).map(s0).sum::<f64>(),
                _ => (0..colours).map(s0).fold(0.0, f64::max),
            };
            let tolerance = (4.0 * links + 1.0) * ROUNDING * scale;
            for (e, f) in expected.iter().zip(found) {
                let difference = (f64::from(*e) - f64::from(*f)).abs();
                assert!(
                    difference <= tolerance,
                    "{name}, {mode:?}, pixel {pixel}: {found:?} with skipping, {expected:?} without"
                );
            }
        }
    }
    skipped
}

fn compare_text(content: &str, polarized: bool) -> Skipped {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='5'/></integrator>
            <sensor type='perspective'>
                <transform name='to_world'><lookat origin='0, 1, 6' target='0, 0, 0' up='0, 1, 0'/></transform>
                <film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='16'/></film>
            </sensor>{content}</scene>"
    );
    let document = read_text(&text, Path::new("test.xml"), &[]).unwrap();
    compare("test.xml", &document, None, polarized)
}

/// Compares a range of the bundled scenes, in the order of their names.
fn compare_scenes(range: std::ops::RangeInclusive<char>) -> Vec<(String, Skipped)> {
    let folder = repository().join("scenes");
    let mut all = Vec::new();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path().join("scene.xml");
        let name = path
            .parent()
            .unwrap()
            .file_name()
            .unwrap()
            .to_string_lossy()
            .into_owned();
        if !path.is_file() || !name.starts_with(|c| range.contains(&c)) {
            continue;
        }
        if name == "big_mesh" && !make_big_mesh() {
            continue;
        }
        let document = read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let skipped = compare(&name, &document, Some([12, 9]), true);
        println!("{name}: {skipped:?}");
        all.push((name, skipped));
    }
    all
}

#[test]
fn bundled_scenes_from_a_to_e_are_the_same_without_skipping() {
    let all = compare_scenes('a'..='e');
    assert!(all.len() >= 6);
    let of = |name: &str| all.iter().find(|found| found.0 == name).unwrap().1;
    assert!(of("double_slit").stokes && of("cornell").wavelengths);
    assert!(!of("cornell").stokes && !of("cornell_spectral").wavelengths);
}

#[test]
fn bundled_scenes_from_f_to_q_are_the_same_without_skipping() {
    assert!(compare_scenes('f'..='q').len() >= 5);
}

#[test]
fn bundled_scenes_from_r_to_z_are_the_same_without_skipping() {
    let all = compare_scenes('r'..='z');
    assert!(all.len() >= 7);
    // its lamps and its backdrop are black
    let showroom = all.iter().find(|found| found.0 == "showroom").unwrap().1;
    assert!(showroom.rays && showroom.wavelengths);
}

/// Matter that turns and scrambles light but polarizes none of it.
const UNPOLARIZING: &str = "
    <shape type='rectangle'><transform name='to_world'><scale value='4'/><translate z='-2'/></transform>
        <bsdf type='diffuse'><float name='reflectance' value='0.8'/></bsdf></shape>
    <shape type='rectangle'><transform name='to_world'><scale value='4'/><rotate x='1' angle='-90'/><translate y='-1'/>
        </transform><bsdf type='diffuse'><float name='reflectance' value='0.6'/></bsdf></shape>
    <shape type='rectangle'><transform name='to_world'><translate x='0.6' z='1'/></transform>
        <bsdf type='retarder'><float name='theta' value='20'/></bsdf></shape>
    <shape type='rectangle'><transform name='to_world'><translate x='-0.6' z='0.5'/></transform>
        <bsdf type='rotator'><float name='angle' value='30'/></bsdf></shape>
    <shape type='sphere'><float name='radius' value='0.5'/><bsdf type='null'/></shape>";

#[test]
fn unpolarizing_matter_is_the_same_with_stokes_vectors() {
    let skipped = compare_text(&format!("{UNPOLARIZING}<emitter type='constant'/>"), true);
    let expected = Skipped {
        stokes: true,
        wavelengths: true,
        ..Skipped::default()
    };
    assert_eq!(skipped, expected);
}

#[test]
fn a_point_light_is_the_same_with_rays_that_cannot_meet_it() {
    let lamp = "<emitter type='point'><point name='position' x='0' y='3' z='2'/></emitter>";
    let skipped = compare_text(&format!("{UNPOLARIZING}{lamp}"), true);
    assert!(skipped.rays && skipped.stokes);
    // polarized light needs Stokes vectors
    let polarized = lamp.replace(
        "/></emitter>",
        "/><string name='stokes' value='1, 0.5, 0, 0'/></emitter>",
    );
    let skipped = compare_text(&format!("{UNPOLARIZING}{polarized}"), true);
    assert!(skipped.rays && !skipped.stokes);
}

#[test]
fn without_emitters_the_image_is_black_either_way() {
    assert!(compare_text(UNPOLARIZING, true).paths);
}

#[test]
fn scalar_transport_on_request_stays_scalar() {
    let metal = "<shape type='sphere'><bsdf type='conductor'/></shape>";
    let skipped = compare_text(
        &format!("{UNPOLARIZING}{metal}<emitter type='constant'/>"),
        false,
    );
    assert!(!skipped.stokes);
}

#[test]
fn colours_of_a_grey_scene_are_those_of_a_constant_spectrum_times_one_wavelength() {
    let metal = "<shape type='sphere'><bsdf type='conductor'><float name='eta' value='0.2'/><float name='k' value='3'/></bsdf>
        </shape><emitter type='constant'/>";
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'>
            <transform name='to_world'><lookat origin='0, 1, 6' target='0, 0, 0' up='0, 1, 0'/></transform>
            <film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film></sensor>
        {UNPOLARIZING}{metal}</scene>"
    );
    let document = read_text(&text, Path::new("test.xml"), &[]).unwrap();
    let of = |mode: SpectralMode| {
        let built = build(&document, Overrides::default()).unwrap();
        let request = Request {
            mode: &mode,
            polarized: true,
            coherence: false,
            skip: true,
        };
        let plan = Plan::of(&built, &request);
        assert!(plan.wavelengths == Wavelengths::One);
        let job = Job {
            plan,
            samples: 4,
            block: 4,
            ..Job::new(built, mode.clone())
        };
        image(&job).0
    };
    let (one, colours) = (of(SpectralMode::Single(550.0)), of(SpectralMode::Rgb));
    // trapezoids over the table's nanometres
    let mut white = [0.0f64; 3];
    for nm in 360..=830 {
        let part = if nm == 360 || nm == 830 { 0.5 } else { 1.0 };
        let response = render::colour::rgb_weights(nm as f32);
        (0..3).for_each(|c| white[c] += part * f64::from(response[c]));
    }
    for (pixel, (s, rgb)) in one.chunks(4).zip(colours.chunks(12)).enumerate() {
        for (k, value) in s.iter().enumerate() {
            for c in 0..3 {
                let (found, expected) = (f64::from(rgb[3 * k + c]), f64::from(*value) * white[c]);
                // a few roundings to single precision, and of 471 terms of the sum
                let tolerance = (8.0 + 22.0) * ROUNDING * f64::from(s[0]) * 1.3;
                assert!(
                    (found - expected).abs() <= tolerance,
                    "pixel {pixel}, S{k}: {found} {expected}"
                );
            }
        }
    }
}
