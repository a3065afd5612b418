//! Reflection: Brewster angle, metals, total reflection, frames of camera and surface.

use brewster_tests::{Shot, assert_stokes, pixel, scene};

use crate::elements::{
    Four, LAMP, LAMP_XML, ROUND_OFF, SURROUNDINGS, degrees, plate, polarizer, polarizer_xml,
    reflectances, times, turned,
};

#[test]
fn light_reflected_at_brewsters_angle_is_purely_s_polarized() {
    let (r_s, _) = reflectances(1.5, degrees(56.309932474));
    assert!((0.5 * r_s - 0.0739645).abs() < 1e-7);
    let absorber = plate(
        "<bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>",
        "<scale value='9'/><translate z='-0.1'/>",
    );
    let glass = plate(
        "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf>",
        "<scale value='9'/>",
    );
    let (sin, cos) = degrees(56.309932474).sin_cos();
    for (roll, first, second) in [
        (0.0, 1.0, 0.0),
        (45.0, 0.0, 1.0),
        (-45.0, 0.0, -1.0),
        (90.0, -1.0, 0.0),
    ] {
        // the camera rolls: its up vector turns from the plane of incidence towards image right, which is world y
        let (s, c) = degrees(roll).sin_cos();
        let up = [-c * cos, s, c * sin];
        let text = scene(
            2,
            &format!(
                "origin='{}, 0, {}' target='0, 0, 0' up='{}, {}, {}'",
                sin, cos, up[0], up[1], up[2]
            ),
            0.01,
            &format!("{SURROUNDINGS}{glass}{absorber}"),
        );
        let image = Shot::new(100_000).of_text(&text);
        let (found, error) = pixel(&image, 0, 0, 0);
        let i = 0.0739645;
        assert_stokes(
            &format!("roll {roll}"),
            (found, error),
            [i, i * first, i * second, 0.0],
            2e-6,
        );
        // each sample by itself is fully polarized; the pixel spans 0.01 degrees of roll and angle
        assert!(
            (found[1].hypot(found[2]) / found[0] - 1.0).abs() < 1e-5,
            "degree of polarization {found:?}"
        );
    }
}

/// A surface z = 0, a polarizer and a lamp on one side, the camera on the other, both at `angle` degrees from the normal
/// on the side `side` of the surface (1 above, -1 below). The light travels towards +x.
fn mirror_scene(surface: &str, angle: f64, side: f64, theta: Option<f64>) -> String {
    let (sin, cos) = degrees(angle).sin_cos();
    let source = |distance: f64| format!("{}, 0, {}", -distance * sin, side * distance * cos);
    let placed = |distance: f64, size: f64, up: &str| {
        format!(
            "<scale value='{size}'/><lookat origin='{}' target='0, 0, 0' up='{up}'/>",
            source(distance)
        )
    };
    let filter = theta.map(|theta| {
        // local x of the plate is the s axis, world y; lookat puts it there by an up vector in the plane of incidence
        plate(&polarizer_xml(theta), &placed(6.0, 4.0, "0, 0, 1"))
    });
    let lamp = format!(
        "<shape type='rectangle'><transform name='to_world'>{}</transform><emitter type='area'><float name='radiance' value='1'/></emitter></shape>",
        placed(12.0, 8.0, "0, 0, 1")
    );
    let camera = format!(
        "origin='{}, 0, {}' target='0, 0, 0' up='0, 0, {side}'",
        10.0 * sin,
        side * 10.0 * cos
    );
    scene(
        8,
        &camera,
        0.001,
        &format!(
            "{}{lamp}{}",
            plate(surface, "<scale value='3'/>"),
            filter.unwrap_or_default()
        ),
    )
}

/// Stokes vectors behind a mirror in the frame whose first axis is perpendicular to the plane of incidence.
///
/// `cos` and `sin` are the elements (2,2) and (3,2) of the Mueller matrix: C cos δ and C sin δ.
fn mirrored([mean, difference, cos, sin]: Four, s: Four) -> Four {
    times(
        [
            [mean, difference, 0., 0.],
            [difference, mean, 0., 0.],
            [0., 0., cos, -sin],
            [0., 0., sin, cos],
        ],
        s,
    )
}

/// Elements of a metal mirror of index eta - i k by Fresnel's formulas in their real form: mean, difference, C cos δ and
/// C sin δ.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 14.2 (Eqs. (14)-(23)), phases from the ratio
/// r_p/r_s = (sin θ tan θ - w)/(sin θ tan θ + w), w² = n² - sin² θ (ellipsometry), here with e^{+iωt}.
fn metal(eta: f64, k: f64, angle: f64) -> Four {
    let (sin, cos) = angle.sin_cos();
    // w = sqrt(n² - sin² θ) = a - i b
    let (re, im) = (eta * eta - k * k - sin * sin, -2.0 * eta * k);
    let modulus = re.hypot(im);
    let (a, b) = (((modulus + re) / 2.0).sqrt(), ((modulus - re) / 2.0).sqrt());
    let r_s = ((cos - a).powi(2) + b * b) / ((cos + a).powi(2) + b * b);
    // r_p/r_s in the convention where both are equal at grazing incidence and opposite at normal incidence
    let t = sin * sin / cos;
    let (nr, ni, dr, di) = (a - t, -b, a + t, -b);
    let norm = dr * dr + di * di;
    let (re, im) = (-(nr * dr + ni * di) / norm, -(ni * dr - nr * di) / norm);
    let r_p = r_s * (re * re + im * im);
    [0.5 * (r_s + r_p), 0.5 * (r_s - r_p), r_s * re, r_s * im]
}

#[test]
fn a_metal_mirror_changes_diagonal_light_into_elliptic_light() {
    let m = metal(0.2, 3.2, degrees(60.0));
    assert!(
        (m[2] + 0.61204).abs() < 5e-6 && (m[3].abs() - 0.69362).abs() < 5e-6,
        "{m:?}"
    );
    let silver = "<bsdf type='conductor'><spectrum name='eta' value='0.2'/><spectrum name='k' value='3.2'/></bsdf>";
    let shot = Shot::new(16);
    let see = |theta| {
        pixel(
            &shot.of_text(&mirror_scene(silver, 60.0, 1.0, theta)),
            0,
            0,
            0,
        )
    };
    assert_stokes(
        "unpolarized light",
        see(None),
        [0.92592, 0.0404, 0.0, 0.0],
        1e-5,
    );
    // the polarizer faces the mirror: its axis (cos 45, -sin 45) is S2 < 0 for who looks at the lamp
    assert_stokes(
        "light at -45 degrees",
        see(Some(45.0)),
        [0.46296, 0.0202, 0.30602, -0.34681],
        1e-5,
    );
    assert_stokes(
        "light at +45 degrees",
        see(Some(-45.0)),
        [0.46296, 0.0202, -0.30602, 0.34681],
        1e-5,
    );
    // and by the formulas, along the axes and in between; the back of two-sided metal does the same
    let both = format!("<bsdf type='twosided'>{silver}</bsdf>");
    for theta in [0.0, 20.0, 45.0, 80.0, 90.0, 130.0] {
        let expected = mirrored(m, polarizer(degrees(-theta), LAMP));
        assert_stokes(
            &format!("light at {theta} degrees"),
            see(Some(theta)),
            expected,
            1e-5,
        );
        let back = pixel(
            &shot.of_text(&mirror_scene(&both, 60.0, -1.0, Some(theta))),
            0,
            0,
            0,
        );
        assert_stokes(
            &format!("light at {theta} degrees on the back"),
            back,
            expected,
            1e-5,
        );
    }
}

#[test]
fn total_internal_reflection_retards() {
    let glass = "<bsdf type='dielectric'><float name='int_ior' value='1.51'/><float name='ext_ior' value='1'/></bsdf>";
    let (cos, sin) = (0.70696, 0.70726);
    let shot = Shot::new(4);
    for theta in [-45.0, 0.0, 30.0, 45.0] {
        let lit = polarizer(degrees(-theta), LAMP);
        // all light is reflected: no noise
        let found = pixel(
            &shot.of_text(&mirror_scene(glass, 54.6, -1.0, Some(theta))),
            0,
            0,
            0,
        );
        assert_stokes(
            &format!("light at {theta} degrees"),
            found,
            mirrored([1.0, 0.0, cos, sin], lit),
            1e-5,
        );
    }
}

#[test]
fn the_stokes_frame_turns_with_the_camera() {
    let content = format!(
        "{LAMP_XML}{}",
        plate(&polarizer_xml(0.0), "<scale value='5'/>")
    );
    let (sin, cos) = degrees(30.0).sin_cos();
    let text = scene(
        8,
        &format!("origin='0, 0, 10' target='0, 0, 0' up='{}, {cos}, 0'", -sin),
        0.01,
        &content,
    );
    let found = pixel(&Shot::new(4).of_text(&text), 0, 0, 0);
    assert_stokes(
        "roll 30",
        found,
        [0.5, 0.25, -(3f64.sqrt()) / 4.0, 0.0],
        ROUND_OFF,
    );
}

#[test]
fn the_back_of_a_two_sided_metal_looks_like_its_front_however_it_is_turned() {
    let (sin, cos) = degrees(60.0).sin_cos();
    let m = metal(0.2, 3.2, degrees(60.0));
    // a camera that is rolled against the plane of incidence, y = 0: the s axis in its frame
    let (d, up) = ([-sin, 0.0, -cos], [0.3, 0.5, 1.0]);
    let across = [
        d[1] * up[2] - d[2] * up[1],
        d[2] * up[0] - d[0] * up[2],
        d[0] * up[1] - d[1] * up[0],
    ];
    let length = across.iter().map(|v| v * v).sum::<f64>().sqrt();
    let e_x = across.map(|v| v / length);
    let k = d.map(|v| -v);
    let e_y = [
        k[1] * e_x[2] - k[2] * e_x[1],
        k[2] * e_x[0] - k[0] * e_x[2],
        k[0] * e_x[1] - k[1] * e_x[0],
    ];
    let expected = turned(-e_y[1].atan2(e_x[1]), [m[0], m[1], 0.0, 0.0]);
    for rough in [false, true] {
        let bsdf = if rough {
            "<bsdf type='roughconductor'><float name='alpha' value='0.001'/>"
        } else {
            "<bsdf type='conductor'>"
        };
        let bsdf = format!(
            "<bsdf type='twosided'>{bsdf}<spectrum name='eta' value='0.2'/><spectrum name='k' value='3.2'/></bsdf></bsdf>"
        );
        for azimuth in [0.0, 25.0, 45.0, 70.0] {
            for back in [0.0, 180.0] {
                let placement = format!(
                    "<scale value='3'/><rotate x='1' angle='{back}'/><rotate z='1' angle='{azimuth}'/>"
                );
                let text = scene(
                    2,
                    &format!(
                        "origin='{}, 0, {}' target='0, 0, 0' up='0.3, 0.5, 1'",
                        10.0 * sin,
                        10.0 * cos
                    ),
                    0.01,
                    &format!("{SURROUNDINGS}{}", plate(&bsdf, &placement)),
                );
                let found = pixel(
                    &Shot::new(if rough { 256 } else { 4 }).of_text(&text),
                    0,
                    0,
                    0,
                );
                // facets 0.001 steep spread the angle of incidence
                let tolerance = if rough { 2e-4 } else { 1e-5 };
                assert_stokes(
                    &format!("rough {rough}, azimuth {azimuth}, turned by {back}"),
                    found,
                    expected,
                    tolerance,
                );
            }
        }
    }
}
