//! Claims: paths side by side are the paths of the walk, and have the same bits with any number of lanes.

use std::marker::PhantomData;
use std::path::Path;

use glam::{Vec3A, Vec4};

use super::{Beginnings, Wavefront};
use crate::film::SpectralMode;
use crate::lanes::{Bits, COLUMNS, MOST, Real, Task, V3, run_with_each};
use crate::light::abreast::{Abreast, Stokes};
use crate::light::{Intensity, Light};
use crate::path::{CameraSample, Counters, Start, trace};
use crate::plan::{Components, Plan, Request};
use crate::sampler::{PixelStream, Stream};
use crate::scene::{BuiltScene, Overrides, build, read_text};
use crate::sensor::Camera;

pub(super) fn built(content: &str) -> BuiltScene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='6'/></integrator>
            <sensor type='perspective'><transform name='to_world'>
                <lookat origin='0, 1, 5' target='0, 0, 0' up='0, 1, 0'/></transform></sensor>
            <shape type='rectangle'><transform name='to_world'><scale value='3'/><rotate x='1' angle='-90'/>
                <translate y='-1'/></transform><bsdf type='diffuse'><float name='reflectance' value='0.7'/></bsdf></shape>
            {content}</scene>"
    );
    let document = read_text(&text, Path::new("test.xml"), &[]).expect("a scene");
    build(&document, Overrides::default()).expect("a scene")
}

pub(super) const SAMPLES: u64 = 4096;
const BLOCK: u64 = 16;

/// Wavelengths, nm, of which a path carries the first ones.
const WAVELENGTHS: [f32; 4] = [550.0, 450.0, 620.0, 500.0];

/// The light of samples of one pixel, in the order of their numbers, each wavelength of its own.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a, L>(pub(super) &'a BuiltScene, pub(super) PhantomData<L>);

impl<L: Abreast> Task for Samples<'_, L> {
    type Output = Vec<Vec4>;

    #[inline(always)]
    fn run<R: Real>(self) -> Vec<Vec4> {
        let (scene, mut counters) = (&self.0.scene, Counters::default());
        let mut stack = scene.stack();
        let mut front = Wavefront::new(scene);
        let mut found = vec![];
        let pixel = PixelStream::new(1, 7).words().map(R::B::splat);
        let zero = R::B::splat(0);
        let mut wavelengths = L::values(R::zero());
        for (to, nm) in wavelengths.as_mut().iter_mut().zip(&WAVELENGTHS) {
            *to = R::splat(*nm);
        }
        for start in (0..SAMPLES as u32).step_by(COLUMNS) {
            for first in (start..start + COLUMNS as u32).step_by(R::LANES) {
                let number = R::B::from_fn(|lane| first + lane as u32);
                let place = number & R::B::splat(BLOCK as u32 - 1);
                let stream: Stream<R> =
                    Stream::in_block(pixel, [number, zero], [number - place, zero], place);
                let [u, v] = stream.pairs(zero);
                let (u, v) = (u.lanes(), v.lanes());
                let mut rays = [[Vec3A::Z; MOST]; 3];
                for lane in 0..R::LANES {
                    let (ray, axis) = start_of(self.0, [u[lane], v[lane]]);
                    rays[0][lane] = ray.origin;
                    rays[1][lane] = ray.direction;
                    rays[2][lane] = axis;
                }
                let [origin, direction, axis] = rays.map(|all| V3::from_lanes(&all));
                let begin = Beginnings {
                    origin,
                    direction,
                    axis,
                };
                front.begin::<R, L>(&begin, &wavelengths, &stream, R::LANES);
            }
            let mut seen = [L::Single::dark(); COLUMNS];
            let options = &self.0.paths;
            front.trace::<R, L>(scene, options, &mut stack, &mut counters, &mut seen);
            for stokes in &seen {
                found.extend_from_slice(stokes.as_ref());
            }
        }
        found
    }
}

/// A ray through a place of the film, from the lower left to the upper right.
fn start_of(built: &BuiltScene, [u, v]: [f32; 2]) -> (crate::geometry::ray::Ray, Vec3A) {
    let Camera::Perspective(camera) = &built.camera else {
        panic!("a pinhole")
    };
    let [width, height] = built.film.size.map(|n| n as f32);
    camera.ray(u * width, v * height)
}

/// The same by the walk.
fn walked<L: Abreast>(built: &BuiltScene) -> Vec<Vec4> {
    let (scene, mut counters) = (&built.scene, Counters::default());
    let mut stack = scene.stack();
    (0..SAMPLES)
        .flat_map(|sample| {
            let stream = PixelStream::new(1, 7).in_block(sample, (sample % BLOCK) as u32);
            let (ray, axis) = start_of(built, stream.pair(0));
            let camera = CameraSample {
                start: &Start::Ray { ray, axis },
                wavelengths: &WAVELENGTHS[..L::LANES],
                stream,
            };
            let options = &built.paths;
            let (stack, counters) = (&mut stack, &mut counters);
            let seen = trace::<L::Single, _>(scene, options, camera, stack, counters, &mut ());
            seen.as_ref().to_vec()
        })
        .collect()
}

/// Compares both, and says how many samples differ by more than rounding makes of curved mirrors and glass.
fn compare(content: &str) {
    compare_as::<Stokes<1, 4>>(content);
}

/// The same of light with any number of wavelengths, polarized or not.
fn compare_as<L: Abreast>(content: &str) {
    let built = built(content);
    let walked = walked::<L>(&built);
    let all = run_with_each(Samples::<L>(&built, PhantomData));
    let one = &all[0];
    for lanes in &all[1..] {
        assert!(one == lanes, "{content}: lanes differ");
    }
    let mean = walked.iter().map(|s| s.x).sum::<f32>() / walked.len() as f32;
    assert!(mean > 1e-3, "dark: {mean}");
    // a decision that falls the other way by rounding changes a sample altogether
    let is_off = |(a, b): (&Vec4, &Vec4)| {
        let size = a.x.max(b.x).max(0.1 * mean);
        (*a - *b).abs().max_element() > 1e-3 * size
    };
    let samples = walked.chunks(L::LANES).zip(one.chunks(L::LANES));
    let off = samples.filter(|(a, b)| a.iter().zip(*b).any(is_off));
    let shares = off.count() as f64 / SAMPLES as f64;
    println!("{shares} differ");
    assert!(shares < 2e-3, "{content}: {shares}");
}

const LAMP: &str = "<shape type='rectangle'><transform name='to_world'><scale value='0.7'/><rotate x='1' angle='90'/>
    <translate y='2'/></transform><emitter type='area'><float name='radiance' value='5'/></emitter></shape>";
const SKY: &str = "<emitter type='constant'><float name='radiance' value='0.3'/></emitter>";

fn ball(bsdf: &str) -> String {
    format!("<shape type='sphere'><float name='radius' value='0.9'/>{bsdf}</shape>{LAMP}{SKY}")
}

/// Scenes with smooth matter; in some its light is polarized again after the matte floor, and by lamps.
pub(super) fn of_smooth_matter() -> Vec<String> {
    let gold = "<bsdf type='conductor'><string name='material' value='Au'/></bsdf>";
    let mirror = format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='2'/><translate z='-1.5'/></transform>{gold}</shape>"
    );
    ["<bsdf type='dielectric'/>", gold, "<bsdf type='plastic'/>"]
        .iter()
        .flat_map(|bsdf| {
            [
                ball(bsdf),
                ball(bsdf) + POLARIZED,
                ball(bsdf) + POLARIZED + &mirror,
            ]
        })
        .collect()
}

#[test]
fn smooth_matter_is_the_same_side_by_side() {
    for content in of_smooth_matter() {
        compare(&content);
    }
}

/// Scenes with rough matter.
pub(super) fn of_rough_matter() -> Vec<String> {
    [
        "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><float name='alpha_u' value='0.1'/>
            <float name='alpha_v' value='0.4'/></bsdf>",
        "<bsdf type='roughconductor'><boolean name='sample_visible' value='false'/><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='roughdielectric'><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='twosided'><bsdf type='roughplastic'/></bsdf>",
    ]
    .iter()
    .map(|bsdf| ball(bsdf))
    .collect()
}

#[test]
fn rough_matter_is_the_same_side_by_side() {
    for content in of_rough_matter() {
        compare(&content);
    }
}

/// A lamp of all kinds of polarization, to the right.
const POLARIZED: &str = "<shape type='sphere'><point name='center' x='1.5' y='1' z='0.5'/>
    <float name='radius' value='0.4'/><emitter type='area'><float name='radiance' value='5'/>
    <string name='stokes' value='1, 0.5, 0.5, 0.5'/></emitter></shape>";

const COLOURS: &str = "<rgb name='diffuse_reflectance' value='0.7, 0.4, 0.1'/>
    <rgb name='specular_reflectance' value='0.5, 0.9, 0.7'/>";

/// Scenes with everything that plastics can be made of.
pub(super) fn of_plastic() -> Vec<String> {
    let bsdf = |kind: &str, more: &str| format!("<bsdf type='{kind}'>{COLOURS}{more}</bsdf>");
    let ggx = "<string name='distribution' value='ggx'/>";
    let along = "<float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.4'/>";
    let all_facets =
        "<float name='alpha' value='0.2'/><boolean name='sample_visible' value='false'/>";
    let nonlinear = "<float name='alpha' value='0.3'/><boolean name='nonlinear' value='true'/>";
    let thin = "<float name='int_ior' value='1.1'/><float name='ext_ior' value='1.5'/>";
    let mut all: Vec<String> = [
        ("pplastic", String::new()),
        ("pplastic", along.to_owned()),
        ("pplastic", format!("{ggx}{along}")),
        ("pplastic", all_facets.to_owned()),
        ("pplastic", thin.to_owned()),
        ("roughplastic", nonlinear.to_owned()),
        ("roughplastic", format!("{ggx}{all_facets}")),
        (
            "plastic",
            "<boolean name='nonlinear' value='true'/>".to_owned(),
        ),
        ("plastic", thin.to_owned()),
    ]
    .iter()
    .map(|(kind, more)| ball(&bsdf(kind, more)) + POLARIZED)
    .collect();
    // from behind one side is dark, and two sides are not
    let turned = |matter: &str| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><rotate y='1' angle='200'/></transform>{matter}</shape>{LAMP}{SKY}{POLARIZED}"
        )
    };
    all.push(turned(&bsdf("pplastic", "")));
    let sides = bsdf("plastic", "") + &bsdf("roughplastic", nonlinear);
    all.push(turned(&format!("<bsdf type='twosided'>{sides}</bsdf>")));
    let side = bsdf("pplastic", along);
    all.push(turned(&format!("<bsdf type='twosided'>{side}</bsdf>")));
    all
}

#[test]
fn plastics_are_the_same_side_by_side() {
    for content in of_plastic() {
        compare(&content);
    }
}

#[test]
fn colours_of_plastics_are_the_same_side_by_side() {
    for content in of_plastic() {
        compare_as::<Stokes<4, 4>>(&content);
        compare_as::<Intensity<1>>(&content);
        compare_as::<Intensity<4>>(&content);
    }
}

/// Scenes with plates that light goes straight through.
pub(super) fn of_plates() -> Vec<String> {
    let plate = |bsdf: &str, z: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><translate z='{z}'/></transform>{bsdf}</shape>"
        )
    };
    let polarizer = "<bsdf type='polarizer'><float name='theta' value='20'/></bsdf>";
    let retarder = "<bsdf type='retarder'><float name='theta' value='70'/><float name='delta' value='100'/></bsdf>";
    let circular = "<bsdf type='circular'/>";
    let all = plate(polarizer, 1.0) + &plate(retarder, 0.5) + &plate(circular, 0.0);
    vec![
        format!("{all}{LAMP}{SKY}"),
        format!("{all}{LAMP}{}", plate("<bsdf type='null'/>", 1.5)),
        format!("{all}{LAMP}{POLARIZED}"),
    ]
}

#[test]
fn light_through_plates_is_the_same_side_by_side() {
    for content in of_plates() {
        compare(&content);
    }
}

#[test]
fn lights_are_the_same_side_by_side() {
    let bsdf = "<bsdf type='twosided'><bsdf type='roughconductor'><float name='alpha' value='0.4'/></bsdf></bsdf>";
    for light in [
        "<emitter type='point'><point name='position' x='1' y='2' z='1'/></emitter>",
        "<emitter type='directional'><vector name='direction' x='-1' y='-2' z='-1'/></emitter>",
        "<emitter type='rayleighsky'><vector name='sun_direction' x='1' y='2' z='0.5'/></emitter>",
        "<shape type='sphere'><point name='center' x='1.5' y='1' z='0'/><float name='radius' value='0.4'/>
            <emitter type='area'><string name='stokes' value='1, 0.3, 0.2, 0.5'/></emitter></shape>",
        "<shape type='disk'><transform name='to_world'><scale value='0.5'/><rotate x='1' angle='90'/><translate x='1.5' y='1.8'/></transform>
            <emitter type='area'/></shape>",
    ] {
        let ball = format!("<shape type='sphere'><float name='radius' value='0.9'/>{bsdf}</shape>{LAMP}");
        compare(&format!("{ball}{light}"));
        let alone = format!("<shape type='cube'><transform name='to_world'><scale value='0.5'/></transform>{bsdf}</shape>{light}");
        compare(&alone);
    }
}

/// Scenes in which light is linearly polarized, and never circularly.
fn of_linear_light() -> Vec<String> {
    let lamp = POLARIZED.replace("1, 0.5, 0.5, 0.5", "1, 0.5, 0.5, 0");
    let plates = |theta: f64, z: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><translate z='{z}'/></transform>
            <bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf></shape>"
        )
    };
    let plastic = |kind: &str| {
        format!(
            "<bsdf type='twosided'><bsdf type='{kind}'><float name='alpha' value='0.3'/></bsdf></bsdf>"
        )
    };
    vec![
        ball(&plastic("pplastic")) + &lamp,
        ball(&plastic("roughplastic")) + &lamp + &plates(20.0, 1.2),
        ball("<bsdf type='plastic'/>") + &plates(20.0, 1.2) + &plates(75.0, 1.5),
        format!(
            "{LAMP}{SKY}{lamp}{}{}",
            plates(10.0, 0.5),
            plates(50.0, 0.8)
        ),
    ]
}

#[test]
fn linear_light_is_the_same_in_three_components() {
    for content in of_linear_light() {
        let scene = built(&content);
        let request = Request {
            mode: &SpectralMode::Single(550.0),
            polarized: true,
            coherence: false,
            skip: true,
        };
        assert_eq!(Plan::of(&scene, &request).stokes, Components::Linear);
        compare_as::<Stokes<1, 3>>(&content);
        compare_as::<Stokes<4, 3>>(&content);
        // what is left out is zero
        let three = Samples(&scene, PhantomData::<Stokes<1, 3>>).run::<f32>();
        let four = Samples(&scene, PhantomData::<Stokes<1, 4>>).run::<f32>();
        assert!(three == four, "{content}");
        assert!(four.iter().any(|s| s.y.abs() > 0.01));
    }
}
