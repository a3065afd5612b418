//! Claims about the choice itself: chances are those with which sources are drawn, and follow the light that arrives.

use glam::{Vec3A, dvec3};

use super::Glance;
use super::bundle::Seen;
use super::testing::{built, numbers};
use crate::geometry::frame::Frame;
use crate::sampler::{SampleStream, uniform_sphere};

/// Sources of every kind, of strengths over six decades, in a box of two metres; one in a hundred outside the scene.
fn of_all_kinds(count: u64) -> String {
    let mut content = String::from("<emitter type='constant'/>");
    for source in 1..count {
        let [x, y, z, strength, turn, tilt] = numbers(source);
        let place = format!(
            "<rotate x='1' angle='{}'/><rotate y='1' angle='{}'/><translate x='{}' y='{}' z='{}'/>",
            180.0 * tilt,
            360.0 * turn,
            2.0 * x - 1.0,
            2.0 * y - 1.0,
            2.0 * z - 1.0
        );
        let strength = 10f64.powf(6.0 * strength - 3.0);
        let placed = format!("<transform name='to_world'>{place}</transform>");
        let small = format!("<transform name='to_world'><scale value='0.02'/>{place}</transform>");
        let area =
            format!("<emitter type='area'><float name='radiance' value='{strength}'/></emitter>");
        let shape = |kind: &str| format!("<shape type='{kind}'>{small}{area}</shape>");
        content += &match source % 100 {
            0 => format!(
                "<emitter type='directional'>{placed}<float name='irradiance' value='{strength}'/></emitter>"
            ),
            1 => format!(
                "<emitter type='laser'>{placed}<float name='power' value='{strength}'/>
                 <string name='waist' value='20cm'/></emitter>"
            ),
            k if k < 20 => format!(
                "<emitter type='point'>{placed}<float name='intensity' value='{strength}'/></emitter>"
            ),
            k if k < 40 => format!(
                "<emitter type='spot'>{placed}<float name='intensity' value='{strength}'/>
                 <float name='cutoff_angle' value='{}'/></emitter>",
                1.0 + 4.0 * k as f64
            ),
            k => shape(["rectangle", "disk", "sphere", "cube", "cylinder"][(k % 5) as usize]),
        };
    }
    content
}

/// Places in and around the box, and far from it.
fn places() -> impl Iterator<Item = Vec3A> {
    (0..40).map(|k| {
        let stream = SampleStream::new(12, 0, k);
        let distance = [0.3, 1.0, 3.0, 1e4][k as usize % 4];
        uniform_sphere(stream.pair(0)) * distance
    })
}

#[test]
fn chances_sum_to_one_and_are_those_of_the_draws() {
    // a source is drawn for an interval of numbers in the blind part and one in the other, so that even numbers miss its
    // chance by at most one number at either end of both; and roundings of the number on the way down
    const DRAWS: u32 = 1 << 16;
    let bound = 4.0 / f64::from(DRAWS) + 4e-6;
    for count in [2, 3, 8, 1000] {
        let built = built(&of_all_kinds(count));
        for from in places().step_by(if count < 1000 { 1 } else { 7 }) {
            let chances: Vec<f32> = (0..count as u32)
                .map(|source| built.scene.chance_of_emitter(source, from))
                .collect();
            let sum: f64 = chances.iter().copied().map(f64::from).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{count} {from}: {sum}");
            let mut drawn = vec![0u32; chances.len()];
            for k in 0..DRAWS {
                let u = (k as f32 + 0.5) / DRAWS as f32;
                let (source, chance) = built
                    .scene
                    .lights
                    .choose(&built.scene.emitters, from, u)
                    .unwrap();
                assert_eq!(chance, chances[source as usize], "{count} {from} {source}");
                drawn[source as usize] += 1;
            }
            for (source, (drawn, chance)) in drawn.iter().zip(&chances).enumerate() {
                let off = f64::from(*drawn) / f64::from(DRAWS) - f64::from(*chance);
                assert!(off.abs() < bound, "{count} {from} {source}: {off}");
            }
        }
    }
}

#[test]
fn what_is_thought_dark_sends_nothing() {
    let built = built(&of_all_kinds(1000));
    let frame = Frame::around(Vec3A::Z);
    let mut dark = 0;
    for emitter in &built.scene.emitters {
        let Glance::Near(bundle) = emitter.glance(&built.scene, [550.0; 2]) else {
            continue;
        };
        let seen = Seen::one(&bundle, 1.0);
        for from in places().filter(|&from| seen.irradiance(from) <= 0.0) {
            dark += 1;
            for k in 0..8 {
                let u = SampleStream::new(13, 0, k).pair(0);
                let connection = emitter.connect(&built.scene, from, &frame, u);
                assert!(connection.is_none(), "{from} {emitter:?}");
            }
        }
    }
    // of flat lamps half of the places are behind them
    assert!(dark > 1000, "{dark}");
}

#[test]
fn the_choice_among_lamps_of_equal_strength_follows_their_distance() {
    // the second moment of a sum Σ E drawn with chances p is Σ E²/p, at least (Σ E)²: even chances against those of the tree
    let lamps: String = (0..1000)
        .map(|lamp| {
            let [x, y, z, ..] = numbers(lamp);
            format!(
                "<emitter type='point'><point name='position' x='{x}' y='{y}' z='{z}'/></emitter>"
            )
        })
        .collect();
    let built = built(&lamps);
    let (mut even, mut chosen) = (0.0, 0.0);
    for k in 0..200 {
        let at = |source| {
            let [x, y, z, ..] = numbers(source);
            dvec3(x, y, z).as_vec3a()
        };
        let from = at(5000 + k);
        let irradiance: Vec<f64> = (0..1000)
            .map(|lamp| f64::from(at(lamp).distance_squared(from).recip()))
            .collect();
        let least = irradiance.iter().sum::<f64>().powi(2);
        even += 1000.0 * irradiance.iter().map(|e| e * e).sum::<f64>() / least;
        chosen += (0..)
            .zip(&irradiance)
            .map(|(lamp, e)| e * e / f64::from(built.scene.chance_of_emitter(lamp, from)))
            .sum::<f64>()
            / least;
    }
    println!(
        "second moments over the least, mean of 200 places: even {}, chosen {}",
        even / 200.0,
        chosen / 200.0
    );
    // in the midst of its lamps a box says little of the nearest: half of what even chances lose is a modest demand
    assert!(chosen < 0.5 * even, "{chosen} {even}");
}

#[test]
fn a_single_lamp_is_certain() {
    let built = built("<emitter type='point'/>");
    for from in places() {
        for u in [0.0, 0.1, 0.999_999] {
            let (_, chance) = built.scene.choose_emitter(from, u).unwrap();
            assert_eq!(chance, 1.0);
        }
        assert_eq!(built.scene.chance_of_emitter(0, from), 1.0);
    }
}
