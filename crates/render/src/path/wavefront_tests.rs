//! Claims: paths side by side are the paths of the walk, lane by lane, and those of eight lanes have the bits of one.

use std::path::Path;

use glam::{Vec3A, Vec4};

use super::abreast::{self, QUEUE, Queue};
use super::{CameraSample, Counters, Start, trace};
use crate::lanes::{Bits, MOST, Real, Task, V3, run};
use crate::light::Polarized;
use crate::sampler::PixelStream;
use crate::scene::{BuiltScene, Overrides, build, read_text};
use crate::sensor::Camera;

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

const SAMPLES: u64 = 4096;

/// The light of samples of one pixel, in the order of their numbers.
struct Samples<'a>(&'a BuiltScene);

impl Task for Samples<'_> {
    type Output = Vec<Vec4>;

    #[inline(always)]
    fn run<R: Real>(self) -> Vec<Vec4> {
        let (scene, mut counters) = (&self.0.scene, Counters::default());
        let mut stack = scene.stack();
        let mut found = vec![];
        for first in (0..SAMPLES).step_by(QUEUE) {
            let mut queue = Queue::default();
            while queue.count < QUEUE {
                let first = first + queue.count as u64;
                let stream = PixelStream::new(1, 7).in_blocks::<R>(first, (first % 16) as u32, 15);
                let [u, v] = stream.pairs(<R::B as Bits>::splat(0));
                let (u, v) = (u.lanes(), v.lanes());
                let mut rays = [[Vec3A::Z; MOST]; 3];
                for lane in 0..R::LANES {
                    let (ray, axis) = start(self.0, [u[lane], v[lane]]);
                    rays[0][lane] = ray.origin;
                    rays[1][lane] = ray.direction;
                    rays[2][lane] = axis;
                }
                let [origin, direction, axis] = &rays;
                let begin = (
                    V3::from_lanes(origin),
                    V3::from_lanes(direction),
                    V3::from_lanes(axis),
                );
                queue.append(begin, &[R::splat(550.0)], &stream, R::LANES);
            }
            let mut seen = [[Vec4::ZERO]; QUEUE];
            let (options, stack) = (&self.0.paths, &mut stack);
            abreast::trace::<R, Polarized<1>>(
                scene,
                options,
                &queue,
                stack,
                &mut counters,
                &mut seen,
            );
            found.extend(seen.map(|[stokes]| stokes));
        }
        found
    }
}

/// A ray through a place of the film, from the lower left to the upper right.
fn start(built: &BuiltScene, [u, v]: [f32; 2]) -> (crate::geometry::ray::Ray, Vec3A) {
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
                start: &Start::Ray { ray, axis },
                wavelengths: &[550.0],
                stream,
            };
            let options = &built.paths;
            let (stack, counters) = (&mut stack, &mut counters);
            let [seen] = trace::<Polarized<1>, _>(scene, options, camera, stack, counters, &mut ());
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
    compare(
        &format!("{all}{LAMP}{}", plate("<bsdf type='null'/>", 1.5)),
        0.05,
    );
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
