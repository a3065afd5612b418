//! Claim: `roughsurface` is a mirror, facets, or what the theorem says in between, in images.

use std::f64::consts::PI;

use brewster_tests::{SIGMAS, Shot, assert_stokes, mean, repository, scene};
use glam::DVec3;

const SILVER: &str = "<string name='material' value='Ag'/>";

fn rough(height: &str, length: &str, rest: &str) -> String {
    format!(
        "<bsdf type='roughsurface'><string name='height' value='{height}'/>
         <string name='length' value='{length}'/>{rest}</bsdf>"
    )
}

/// A unit vector at an angle from the normal, in degrees; positive angles lean toward +x.
fn leaning(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

/// A plate z = 0 seen at `seen` degrees under a square lamp at 10 m along `lamp`, half as wide as `half` metres.
fn plate(bsdf: &str, seen: f64, lamp: DVec3, half: f64) -> String {
    let o = leaning(seen) * 10.0;
    let at = lamp * 10.0;
    scene(
        2,
        &format!("origin='{}, 0, {}' target='0, 0, 0' up='0, 1, 0'", o.x, o.z),
        0.001,
        &format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform>{bsdf}</shape>
             <shape type='rectangle'><transform name='to_world'><scale value='{half}'/>
                <lookat origin='{}, {}, {}' target='0, 0, 0' up='0, 1, 0'/></transform>
             <emitter type='area'><float name='radiance' value='1'/></emitter></shape>",
            at.x, at.y, at.z
        ),
    )
}

#[test]
fn a_very_rough_metal_is_beckmanns() {
    // ten wavelengths of height: g is 1.6e4 cos², and the lobe errs by 1/g
    let wave = rough("5.5um", "110um", SILVER);
    let facets =
        format!("<bsdf type='roughconductor'>{SILVER}<float name='alpha' value='0.1'/></bsdf>");
    for (seen, lamp) in [(0.0, 5.0), (45.0, -45.0), (45.0, -35.0), (70.0, -62.0)] {
        let image = |bsdf: &str| {
            let text = plate(bsdf, seen, leaning(lamp), 0.5);
            mean(&Shot::new(20_000).of_text(&text), 0)
        };
        let ((found, error), (expected, other)) = (image(&wave), image(&facets));
        let both = std::array::from_fn(|k| f64::hypot(error[k], other[k]));
        let what = format!("seen at {seen}°, lit from {lamp}°");
        assert_stokes(&what, (found, both), expected, 2e-3 * expected[0]);
    }
}

#[test]
fn a_smooth_metal_is_a_mirror() {
    // heights of λ/5500: g = 5e-6
    let mirror = format!("<bsdf type='conductor'>{SILVER}</bsdf>");
    let image = |bsdf: &str| {
        let text = plate(bsdf, 60.0, leaning(-60.0), 0.5);
        mean(&Shot::new(400).of_text(&text), 0)
    };
    let (expected, _) = image(&mirror);
    assert!(expected[0] > 0.9, "{expected:?}");
    assert_stokes(
        "λ/5500",
        image(&rough("0.1nm", "2um", SILVER)),
        expected,
        1e-5,
    );
}

#[test]
fn the_sharp_image_fades_with_the_phase_variance() {
    let mirror = format!("<bsdf type='conductor'>{SILVER}</bsdf>");
    for (nm, angle) in [(20.0, 0.0), (40.0, 30.0), (60.0, 60.0)] {
        // a lamp of 1 mrad: of the lobe, 0.1 rad wide, it takes 1e-5
        let image = |bsdf: &str| {
            let text = plate(bsdf, angle, leaning(-angle), 0.005);
            mean(&Shot::new(20_000).of_text(&text), 0)
        };
        let g = (4.0 * PI * nm / 550.0 * f64::cos(f64::to_radians(angle))).powi(2);
        let expected = image(&mirror).0.map(|s| s * (-g).exp());
        let found = image(&rough(&format!("{nm}nm"), "1um", SILVER));
        assert_stokes(&format!("{nm} nm at {angle}°"), found, expected, 5e-5);
    }
}

#[test]
fn images_do_not_depend_on_the_patches() {
    let cases = [
        ("100nm", "4um", ""),
        ("30nm", "4um", ""),
        (
            "300nm",
            "3um",
            "<string name='correlation' value='exponential'/>",
        ),
        ("100nm", "4um", "<string name='correlation' value='k'/>"),
    ];
    for (height, length, rest) in cases {
        // widths of the lobes are 0.03 to 0.15 rad; 0.01 is a small lamp, 0.2 a large one
        for half in [0.1, 2.0] {
            let image = |patch: f64| {
                let bsdf = rough(height, length, &format!("{SILVER}{rest}"));
                let text = plate(&bsdf, 40.0, leaning(-44.0), half).replace(
                    "<integrator type='path'>",
                    &format!("<integrator type='path'><float name='patch' value='{patch}'/>"),
                );
                mean(&Shot::new(8_000).of_text(&text), 0)
            };
            let (plane_waves, noise) = image(0.0);
            for patch in [0.1, 0.5] {
                let (found, error) = image(patch);
                let both = std::array::from_fn(|k| f64::hypot(error[k], noise[k]));
                let what = format!("{height}, {length} {rest}, lamp {half}, patch {patch}");
                // a Gaussian for a square of half a lobe width, and what is frozen at its centre: 2e-3
                assert_stokes(&what, (found, both), plane_waves, 2e-3 * plane_waves[0]);
            }
        }
    }
}

/// Fresnel's transmittance of unpolarized light by power, from index `n1` at `cos` into `n2`.
fn transmittance(n1: f64, n2: f64, cos: f64) -> f64 {
    let cos_t = (1.0 - (n1 / n2).powi(2) * (1.0 - cos * cos)).sqrt();
    let s = (n1 * cos - n2 * cos_t) / (n1 * cos + n2 * cos_t);
    let p = (n2 * cos - n1 * cos_t) / (n2 * cos + n1 * cos_t);
    1.0 - 0.5 * (s * s + p * p)
}

/// Smith's G1 for Beckmann, by the rational fit of the paper.
fn seen(alpha: f64, cos: f64) -> f64 {
    let a = cos / (alpha * (1.0 - cos * cos).sqrt());
    if a >= 1.6 {
        return 1.0;
    }
    (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
}

/// Facets of alpha 0.2 refract the lamp's light: Walter et al. 2007, Eq. 21, integrated over the lamp.
#[test]
fn very_rough_glass_refracts_as_facets_do() {
    let alpha = 0.2;
    // from glass into air, seen from above: g is about 4e3
    let bsdf = rough(
        "11um",
        "110um",
        "<float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>",
    );
    for (degrees, lamp) in [(20.0, -15.0), (50.0, -28.0)] {
        let o = leaning(degrees);
        let centre = leaning(lamp);
        let centre = DVec3::new(centre.x, 0.0, -centre.z);
        let half = 1.0;
        let (u, v) = (DVec3::Y, centre.cross(DVec3::Y));
        let count = 80;
        let mut sum = 0.0;
        for a in 0..count {
            for b in 0..count {
                let place = |k: i32| half * (2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0);
                let at = centre * 10.0 + u * place(a) + v * place(b);
                let i = at.normalize();
                let solid =
                    (2.0 * half / f64::from(count)).powi(2) * i.dot(centre) / at.length_squared();
                let (n_i, n_o) = (1.5, 1.0);
                let h = -(i * n_i + o * n_o).normalize();
                // toward the denser side
                let h = if h.z < 0.0 { -h } else { h };
                let (i_h, o_h) = (i.dot(h).abs(), o.dot(h).abs());
                let tan2 = (1.0 - h.z * h.z) / (h.z * h.z);
                let d = (-tan2 / (alpha * alpha)).exp() / (PI * alpha * alpha * h.z.powi(4));
                let root = n_i * i.dot(h) + n_o * o.dot(h);
                let g = seen(alpha, i.z.abs()) * seen(alpha, o.z);
                let f = i_h * o_h / (i.z.abs() * o.z)
                    * n_o
                    * n_o
                    * transmittance(n_i, n_o, i_h)
                    * g
                    * d
                    / (root * root);
                sum += f * i.z.abs() * solid;
            }
        }
        // plane waves: patches hold the vertical wave vector at their centre, which here costs 0.5 % at 50°
        let text = plate(&bsdf, degrees, centre, half);
        for (patch, most) in [(0.0, 1e-3), (0.5, 8e-3)] {
            let text = text.replace(
                "<integrator type='path'>",
                &format!("<integrator type='path'><float name='patch' value='{patch}'/>"),
            );
            let ([found, ..], [error, ..]) = mean(&Shot::new(60_000).of_text(&text), 0);
            // the lobe's 5e-4 and 1/g
            assert!(
                (found - sum).abs() < SIGMAS * error + most * sum,
                "seen at {degrees}°, patch {patch}: {found} ± {error}, expected {sum}"
            );
        }
    }
}

/// The last two spheres of the series: heights of two wavelengths, and facets.
#[test]
fn the_series_ends_in_facets() {
    let path = repository().join("scenes/roughness_series/scene.xml");
    let text = std::fs::read_to_string(path).unwrap();
    let facets = "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Ag\"/><float name=\"alpha\" value=\"0.2\"/></bsdf>";
    assert!(text.contains(facets));
    let wave = rough("1100nm", "11um", SILVER);
    let image = |text: &str| {
        let shot = Shot {
            crop: Some([768, 0, 128, 160]),
            ..Shot::new(16)
        };
        mean(&shot.of_text(text), 0)
    };
    let (expected, other) = image(&text);
    let (found, error) = image(&text.replace(facets, &wave));
    let both = std::array::from_fn(|k| f64::hypot(error[k], other[k]));
    // 1/g is 0.2 % where light comes straight, more at the sphere's rim
    assert_stokes("sphere", (found, both), expected, 1e-2 * expected[0]);
}
