//! Claims: paths side by side are the paths of the walk, lane by lane, and those of eight lanes have the bits of one.

use std::path::Path;

use glam::Vec4;

use super::abreast::{self, Beginnings};
use super::{CameraSample, Counters, Start, trace};
use crate::lanes::{Mask, Real, Task, V3, run};
use crate::light::Polarized;
use crate::light::abreast::Abreast;
use crate::sampler::PixelStream;
use crate::scene::{BuiltScene, Overrides, build, read_text};
use crate::sensor::Camera;
use crate::shape::abreast::Rays;

fn built(content: &str) -> BuiltScene {
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

const SAMPLES: u64 = 4000;

/// The light of samples of one pixel, in the order of their numbers.
struct Samples<'a>(&'a BuiltScene);

impl Task for Samples<'_> {
    type Output = Vec<Vec4>;

    #[inline(always)]
    fn run<R: Real>(self) -> Vec<Vec4> {
        let (scene, mut counters) = (&self.0.scene, Counters::default());
        let mut stack = scene.stack();
        let mut found = vec![];
        for first in (0..SAMPLES).step_by(R::LANES) {
            let mut rays = vec![];
            let stream = PixelStream::new(1, 7).in_blocks::<R>(first, (first % 16) as u32, 15);
            let [u, v] = stream.pairs(<R::B as crate::lanes::Bits>::splat(0));
            for lane in 0..R::LANES {
                rays.push(start(self.0, [u.lane(lane), v.lane(lane)]));
            }
            let begin = Beginnings {
                rays: Rays {
                    origin: V3::from_fn(|lane| rays[lane].0.origin),
                    direction: V3::from_fn(|lane| rays[lane].0.direction),
                    t_max: R::splat(f32::INFINITY),
                },
                axes: V3::from_fn(|lane| rays[lane].1),
                wavelengths: <Polarized<1> as Abreast>::values(R::splat(550.0)),
                stream,
                lanes: R::M::from_bits((1 << R::LANES) - 1),
            };
            let seen = abreast::trace::<R, Polarized<1>>(
                scene,
                &self.0.paths,
                &begin,
                &mut stack,
                &mut counters,
            );
            for lane in 0..R::LANES {
                found.push(<Polarized<1> as Abreast>::lane(&seen, lane)[0]);
            }
        }
        found
    }
}

/// A ray through a place of the film, from the lower left to the upper right.
fn start(built: &BuiltScene, [u, v]: [f32; 2]) -> (crate::geometry::ray::Ray, glam::Vec3A) {
    let Camera::Perspective(camera) = &built.camera else {
        panic!("a pinhole")
    };
    let [width, height] = built.film.size.map(|n| n as f32);
    camera.ray(u * width, v * height)
}

/// The same by the walk.
fn walked(built: &BuiltScene) -> Vec<Vec4> {
    let (scene, mut counters) = (&built.scene, Counters::default());
    let mut stack = scene.stack();
    (0..SAMPLES)
        .map(|sample| {
            let stream = PixelStream::new(1, 7).in_blocks::<f32>(sample, (sample % 16) as u32, 15);
            let (ray, axis) = start(built, stream.pair(0));
            let camera = CameraSample {
                start: Start::Ray { ray, axis },
                wavelengths: &[550.0],
                stream,
            };
            let options = &built.paths;
            let (stack, counters) = (&mut stack, &mut counters);
            let [seen] =
                trace::<Polarized<1>, _>(scene, options, camera, stack, counters, &mut ());
            seen
        })
        .collect()
}

/// Compares both, and says how many samples differ by more than rounding makes of curved mirrors and glass.
fn compare(content: &str, least_light: f32) {
    let built = built(content);
    let walked = walked(&built);
    let one = Samples(&built).run::<f32>();
    let most = run(Samples(&built));
    assert_eq!(one, most, "lanes");
    let mean = walked.iter().map(|s| s.x).sum::<f32>() / SAMPLES as f32;
    assert!(mean > least_light, "dark: {mean}");
    // a decision that falls the other way by rounding changes a sample altogether
    let off = walked.iter().zip(&one).filter(|(a, b)| {
        let size = a.x.max(b.x).max(0.1 * mean);
        (**a - **b).abs().max_element() > 1e-3 * size
    });
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

#[test]
fn smooth_matter_is_the_same_side_by_side() {
    for bsdf in [
        "<bsdf type='dielectric'/>",
        "<bsdf type='conductor'><string name='material' value='Au'/></bsdf>",
        "<bsdf type='plastic'/>",
    ] {
        compare(&ball(bsdf), 0.1);
    }
}

#[test]
fn rough_matter_is_the_same_side_by_side() {
    for bsdf in [
        "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><float name='alpha_u' value='0.1'/>
            <float name='alpha_v' value='0.4'/></bsdf>",
        "<bsdf type='roughconductor'><boolean name='sample_visible' value='false'/><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='roughdielectric'><float name='alpha' value='0.3'/></bsdf>",
        "<bsdf type='twosided'><bsdf type='roughplastic'/></bsdf>",
    ] {
        compare(&ball(bsdf), 0.1);
    }
}

#[test]
fn light_through_plates_is_the_same_side_by_side() {
    let plate = |bsdf: &str, z: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><translate z='{z}'/></transform>{bsdf}</shape>"
        )
    };
    let polarizer = "<bsdf type='polarizer'><float name='theta' value='20'/></bsdf>";
    let retarder = "<bsdf type='retarder'><float name='theta' value='70'/><float name='delta' value='100'/></bsdf>";
    let circular = "<bsdf type='circular'/>";
    let all = plate(polarizer, 1.0) + &plate(retarder, 0.5) + &plate(circular, 0.0);
    compare(&format!("{all}{LAMP}{SKY}"), 0.1);
    compare(&format!("{all}{LAMP}{}", plate("<bsdf type='null'/>", 1.5)), 0.05);
}

#[test]
fn lights_are_the_same_side_by_side() {
    let bsdf = "<bsdf type='twosided'><bsdf type='roughconductor'><float name='alpha' value='0.4'/></bsdf></bsdf>";
    for light in [
        "<emitter type='point'><point name='position' x='1' y='2' z='1'/></emitter>",
        "<emitter type='directional'><vector name='direction' x='-1' y='-2' z='-1'/></emitter>",
        "<emitter type='rayleighsky'/>",
        "<shape type='sphere'><point name='center' x='1.5' y='1' z='0'/><float name='radius' value='0.4'/>
            <emitter type='area'><string name='stokes' value='1, 0.3, 0.2, 0.5'/></emitter></shape>",
        "<shape type='disk'><transform name='to_world'><rotate x='1' angle='90'/><translate y='2'/></transform>
            <emitter type='area'/></shape>",
    ] {
        compare(&format!("{}{light}", ball(bsdf)), 0.1);
        let alone = format!("<shape type='cube'><transform name='to_world'><scale value='0.5'/></transform>{bsdf}</shape>{light}");
        compare(&alone, 0.01);
    }
}
