//! Fresnel's rhomb: two total reflections turn linear light into circular light.

use brewster_tests::{Shot, assert_stokes, mean, scene};

const INDEX: f64 = 1.51;
const ANGLE: f64 = 54.6;

/// By how much one total reflection delays p against s.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.4, Eq. (60).
fn delay(index: f64, angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    2.0 * (cos * (sin * sin - 1.0 / (index * index)).sqrt() / (sin * sin)).atan()
}

/// The rhomb of `scenes/rhomb`, a lamp of the given state behind it, paths of at most `depth`.
fn rhomb(depth: i64, stokes: &str, samples: u64) -> ([f64; 4], [f64; 4]) {
    let slope = f64::to_radians(90.0 - ANGLE).tan();
    // the ray through the middle of the entrance leaves through the middle of the exit
    let half = 1.0 / slope + 1.0 / (f64::to_radians(180.0 - 2.0 * ANGLE).tan() - slope);
    let content = format!(
        "<shape type='cube'><transform name='to_world'>
            <matrix value='1 0 {} 0  0 1 0 0  0 0 {half} 0  0 0 0 1'/></transform>
         <bsdf type='dielectric'><float name='int_ior' value='{INDEX}'/><float name='ext_ior' value='1'/></bsdf></shape>
         <shape type='rectangle'><transform name='to_world'><scale value='9'/><translate z='-6'/></transform>
         <emitter type='area'><string name='stokes' value='{stokes}'/></emitter></shape>",
        half * slope
    );
    let exit = half * slope;
    let lookat = format!("origin='{exit}, 0.1, 60' target='{exit}, 0.1, 0' up='0, 1, 0'");
    mean(
        &Shot::new(samples).of_text(&scene(depth, &lookat, 1e-3, &content)),
        0,
    )
}

#[test]
fn diagonal_light_leaves_circular() {
    let total = 2.0 * delay(INDEX, ANGLE.to_radians());
    assert!((total.to_degrees() - 90.0).abs() < 0.1, "a quarter wave");
    let reflected = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    let passed = (1.0 - reflected).powi(2);
    for (stokes, sign) in [("1, 0, 1, 0", 1.0), ("1, 0, -1, 0", -1.0)] {
        // once through: two refractions, two total reflections
        let (s, error) = rhomb(5, stokes, 4096);
        assert!(error[0] < 0.01);
        assert_stokes(
            stokes,
            (s, error),
            [
                passed,
                0.0,
                sign * passed * total.cos(),
                -sign * passed * total.sin(),
            ],
            1e-5,
        );
        assert!((s[3] / s[0] + sign * total.sin()).abs() < 2e-5, "{s:?}");
        // all that goes to and fro between the ends adds up
        let mut expected = [0.0; 4];
        for turn in 0..8 {
            let power = passed * reflected.powi(2 * turn);
            let phase = f64::from(1 + 2 * turn) * total;
            expected[0] += power;
            expected[2] += sign * power * phase.cos();
            expected[3] -= sign * power * phase.sin();
        }
        assert_stokes(stokes, rhomb(64, stokes, 4096), expected, 1e-5);
    }
}

#[test]
fn light_along_the_axes_stays_as_it_is() {
    for (stokes, s1) in [("1, 1, 0, 0", 1.0), ("1, -1, 0, 0", -1.0)] {
        let (s, _) = rhomb(5, stokes, 1024);
        assert!((s[1] / s[0] - s1).abs() < 1e-5, "{s:?}");
        assert!(s[2].abs() < 1e-5 && s[3].abs() < 1e-5, "{s:?}");
    }
}

#[test]
fn the_scene_shows_the_same() {
    let shot = Shot {
        size: Some([64, 64]),
        ..Shot::new(256)
    };
    let image = shot.of_scene("rhomb");
    // the exit fills a square right of the middle
    let (s, error) = brewster_tests::pixel(&image, 44, 32, 0);
    assert!(error[0] < 0.05);
    assert!((s[3] / s[0] + 1.0).abs() < 0.01, "circular: {s:?}");
    let (s, _) = brewster_tests::pixel(&image, 32, 4, 0);
    assert!((s[2] / s[0] - 1.0).abs() < 1e-4, "the lamp itself: {s:?}");
}
