//! Matter that answers to coherence, under cones of parallel light and under Schell-model sources.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::atomic::AtomicBool;

use brewster_tests::{SIGMAS, Shot, image_of, mean, scene};
use glam::DVec3;
use render::engine::{Limits, render};
use render::scene::read_text;

use crate::grating::{LAMBDA, incident, lamellar, total, view};

/// Stokes vector of a one-pixel image and its standard errors, with patches of the given size.
fn seen(text: &str, spp: u64, patch: f32) -> ([f64; 4], [f64; 4]) {
    let shot = Shot::new(spp);
    let document =
        read_text(text, Path::new("test.xml"), &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut job = shot.job(&document);
    job.paths.patch = patch;
    let rendering = render(&job, Limits::default(), &AtomicBool::new(false), |_| ());
    mean(&image_of(&job, &rendering), 0)
}

const PITCH: f64 = 4e-6;
const DEPTH: f64 = 110e-9;
const SIZE: f64 = 60e-6;

fn finite(more: &str) -> String {
    format!(
        "<string name='pitch' value='4um'/><string name='depth' value='110nm'/>
         <string name='profile' value='lamellar'/><float name='duty' value='0.35'/>
         <string name='size' value='60um'/>{more}"
    )
}

/// A mirror that changes nothing but the plane of the light.
const PERFECT: &str = "<float name='eta' value='0'/><float name='k' value='10000'/>";

/// How much of a Gaussian of standard deviation s, `offset` from its middle, lies within a disk of radius r.
fn within(r: f64, offset: f64, s: f64) -> f64 {
    let (rings, sectors) = (400, 400);
    let mut sum = 0.0;
    for place in 0..rings * sectors {
        let radius = r * ((place / sectors) as f64 + 0.5) / rings as f64;
        let turn = TAU * ((place % sectors) as f64 + 0.5) / sectors as f64;
        let square = radius * radius + offset * offset + 2.0 * radius * offset * turn.cos();
        sum += radius * (-0.5 * square / (s * s)).exp();
    }
    sum * (r / rings as f64) * (TAU / sectors as f64) / (TAU * s * s)
}

#[test]
fn an_order_under_a_cone_of_parallel_light_is_as_wide_as_the_cone() {
    let diameter = 1.0f64;
    let radius = (0.5 * diameter.to_radians()).sin();
    let lamp = format!(
        "<emitter type='directional'><vector name='direction' x='0' y='0' z='-1'/>
         <float name='angular_diameter' value='{diameter}'/></emitter>"
    );
    let radiance = 1.0 / (PI * radius * radius);
    let width = LAMBDA / (TAU * SIZE);
    let share = |q: i32, psi: f64| lamellar(q, psi, 0.35);
    let q = 2;
    for (place, along) in [
        (0.0, DVec3::X),
        (0.6, DVec3::X),
        (-0.9, DVec3::X),
        (1.0, DVec3::Y),
        (1.2, DVec3::X),
    ] {
        // the direction whose order q is `place` radii from the middle of the cone
        let i = along * (place * radius);
        let i = (i + DVec3::Z * (1.0 - i.length_squared()).sqrt()).normalize();
        let o = incident(i, q, PITCH, [1.0, 1.0], 1.0).unwrap();
        let cap = total(o, PITCH, DEPTH, share)
            .max(total(i, PITCH, DEPTH, share))
            .max(1.0);
        let efficiency = share(q, TAU / LAMBDA * DEPTH * (o.z + i.z)) / cap;
        let expected = radiance * efficiency * within(radius, place * radius, width);
        let text = view(&finite(PERFECT), o, &lamp);
        for patch in [0.5, 0.25] {
            let (found, error) = seen(&text, 60_000, patch);
            // the Gaussian of a cell errs by 1e-3 of the peak, shares within a lobe by 2e-3
            let allowed = SIGMAS * error[0] + 3e-3 * radiance * efficiency;
            assert!(
                (found[0] - expected).abs() < allowed && allowed < 0.2 * radiance * efficiency,
                "{place}, patch {patch}: {found:?} ± {error:?}, {expected}"
            );
        }
    }
}

#[test]
fn a_cone_in_patches_is_the_cone_in_plane_waves() {
    let lamp = "<emitter type='directional'><vector name='direction' x='-0.2' y='0.1' z='-1'/>
         <float name='angular_diameter' value='0.6'/>
         <string name='stokes' value='1, 0.3, 0.5, -0.4'/></emitter>";
    let i = DVec3::new(0.2, -0.1, 1.0).normalize();
    // at the rim of order 1
    let o = incident(i + DVec3::X * 0.006, 1, PITCH, [1.0, 1.0], 1.0).unwrap();
    let text = view(&finite("<string name='material' value='Al'/>"), o, lamp);
    let (plane, noise) = seen(&text, 400_000, 0.0);
    let (found, error) = seen(&text, 50_000, 0.5);
    assert!(noise[0] < 0.01 * plane[0], "{plane:?} ± {noise:?}");
    for k in 0..4 {
        // cells err by 2e-3 of the peak, here at half of it
        let allowed = SIGMAS * (noise[k] + error[k]) + 4e-3 * plane[0];
        assert!(
            (found[k] - plane[k]).abs() < allowed,
            "S{k}: {found:?} ± {error:?}, {plane:?} ± {noise:?}"
        );
        assert!(plane[k].abs() > 2.0 * allowed, "S{k}: {plane:?}");
    }
}

#[test]
fn schell_model_sources_in_patches_are_those_in_plane_waves() {
    // seen by the plate 0.1 rad from their normals, where such sources are polarized
    let tilt = 0.1f64;
    let lamp = format!(
        "<shape type='disk'><transform name='to_world'><scale value='0.02'/>
         <lookat origin='0.2, 0, 1' target='{}, 0, 0' up='0, 1, 0'/></transform>
         <emitter type='egsm'><string name='sigma' value='5mm'/><string name='delta_xx' value='1um'/>
         <string name='delta_yy' value='2um'/><string name='delta_xy' value='1.8um'/><string name='B_xy' value='0.3, 0.2'/>
         </emitter></shape>",
        tilt.tan()
    );
    let (height, length) = ("80nm", "40um");
    let matter = format!(
        "<bsdf type='roughsurface'><string name='material' value='Al'/><string name='height' value='{height}'/>
         <string name='length' value='{length}'/></bsdf>"
    );
    // off the mirror direction by about the lobe's width
    let o = DVec3::new(-0.2, 0.0, 1.0).normalize() + DVec3::new(0.004, 0.002, 0.0);
    let o = o.normalize() * 2.0;
    let text = scene(
        2,
        &format!(
            "origin='{}, {}, {}' target='0, 0, 0' up='0, 1, 0'",
            o.x, o.y, o.z
        ),
        0.01,
        &format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='0.01'/></transform>{matter}</shape>{lamp}"
        ),
    );
    let (plane, noise) = seen(&text, 200_000, 0.0);
    let (found, error) = seen(&text, 50_000, 0.5);
    assert!(noise[0] < 0.01 * plane[0], "{plane:?} ± {noise:?}");
    for k in 0..4 {
        let allowed = SIGMAS * (noise[k] + error[k]) + 4e-3 * plane[0];
        assert!(
            (found[k] - plane[k]).abs() < allowed,
            "S{k}: {found:?} ± {error:?}, {plane:?} ± {noise:?}"
        );
    }
    let polarized = plane[1].hypot(plane[2]).hypot(plane[3]) / plane[0];
    assert!(polarized > 0.1, "{plane:?}");
}
