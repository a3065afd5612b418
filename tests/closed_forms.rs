//! Claim: where the answer can be written down, the renderer finds it.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, film_scene, mean, pixel, scene};
use glam::DVec3;

/// What single precision may cost in a few matrix products of numbers around one.
const ROUND_OFF: f64 = 3e-6;

/// A Stokes vector or a row of a Mueller matrix.
type Four = [f64; 4];

fn times(m: [Four; 4], s: Four) -> Four {
    m.map(|row| row.iter().zip(s).map(|(a, b)| a * b).sum())
}

/// Stokes vectors in a frame that is turned by `t` radians counter-clockwise, as the observer sees it.
fn turned(t: f64, s: Four) -> Four {
    let (sin, cos) = (2.0 * t).sin_cos();
    times(
        [
            [1., 0., 0., 0.],
            [0., cos, sin, 0.],
            [0., -sin, cos, 0.],
            [0., 0., 0., 1.],
        ],
        s,
    )
}

/// Behind an ideal polarizer that transmits along the angle `t` from the image's right, counter-clockwise.
fn polarizer(t: f64, s: Four) -> Four {
    let half = [[0.5, 0.5, 0., 0.], [0.5, 0.5, 0., 0.], [0.; 4], [0.; 4]];
    turned(-t, times(half, turned(t, s)))
}

/// Behind a retarder with its fast axis at the angle `t`; `delta` is the lead of the fast axis, radians.
fn retarder(t: f64, delta: f64, s: Four) -> Four {
    let (sin, cos) = delta.sin_cos();
    let lead = [
        [1., 0., 0., 0.],
        [0., 1., 0., 0.],
        [0., 0., cos, sin],
        [0., 0., -sin, cos],
    ];
    turned(-t, times(lead, turned(t, s)))
}

/// Behind a circular polarizer that passes S3 > 0 (`sign` 1) or S3 < 0 (`sign` -1).
fn circular(sign: f64, s: Four) -> Four {
    let i = 0.5 * (s[0] + sign * s[3]);
    [i, 0.0, 0.0, sign * i]
}

const LAMP: Four = [1.0, 0.0, 0.0, 0.0];

fn degrees(angle: f64) -> f64 {
    angle.to_radians()
}

/// A rectangle with matter, placed by the given transform elements.
fn plate(bsdf: &str, placement: &str) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'>{placement}</transform>{bsdf}</shape>"
    )
}

fn polarizer_xml(theta: f64) -> String {
    format!("<bsdf type='polarizer'><float name='theta' value='{theta}'/></bsdf>")
}

/// A lamp of radiance 1 behind everything, facing +z.
const LAMP_XML: &str = "<shape type='rectangle'><transform name='to_world'><scale value='200'/><translate z='-3'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";

const SURROUNDINGS: &str = "<emitter type='constant'><float name='radiance' value='1'/></emitter>";

#[test]
fn a_glass_sphere_in_uniform_light_is_invisible() {
    let image = Shot {
        size: Some([48, 48]),
        ..Shot::new(64)
    }
    .of_scene("furnace_sphere");
    // 64 bounces: what is cut off is below 1e-9
    assert_stokes("whole image", mean(&image, 0), LAMP, ROUND_OFF);
    for y in 0..48 {
        for x in 0..48 {
            let (s, _) = pixel(&image, x, y, 0);
            if (x as f64 - 23.5).hypot(y as f64 - 23.5) > 24.0 {
                assert_eq!(s, LAMP, "outside the sphere at {x}, {y}");
            }
        }
    }
}

/// Reflectances of s- and p-polarized light at a glass of index n.
///
/// Source: Born and Wolf, Principles of Optics, 7th ed., section 1.5.2, Eq. (21a): by sines and tangents of the angles.
fn reflectances(n: f64, angle: f64) -> (f64, f64) {
    if angle < 1e-6 {
        let normal = ((n - 1.0) / (n + 1.0)).powi(2);
        return (normal, normal);
    }
    let below = (angle.sin() / n).asin();
    let s = (angle - below).sin() / (angle + below).sin();
    let p = (angle - below).tan() / (angle + below).tan();
    (s * s, p * p)
}

#[test]
fn a_glass_sphere_reflects_tangentially_polarized_light_by_fresnels_formulas() {
    const SIZE: usize = 64;
    let image = Shot {
        size: Some([SIZE as u32; 2]),
        ..Shot::new(256)
    }
    .of_scene("fresnel_sphere");
    // by ring of equal distance from the centre: sums over pixels of mean and variance
    const RINGS: usize = 10;
    let mut found = [[[0.0; 4]; 2]; RINGS];
    let mut expected = [[0.0; 4]; RINGS];
    let mut count = [0.0; RINGS];
    let half = degrees(16.0).tan();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let (s, error) = pixel(&image, x, y, 0);
            let (mut radial, mut inside) = ([0.0; 4], 0);
            const FINE: usize = 16;
            let at = |i: usize, k: usize| {
                ((i as f64 + (k as f64 + 0.5) / FINE as f64) / SIZE as f64 * 2.0 - 1.0) * half
            };
            for k in 0..FINE * FINE {
                let (right, up) = (at(x, k % FINE), -at(y, k / FINE));
                // the camera at distance 4 from the centre of the unit sphere looks along (right, up, -1)
                let sine = 4.0 * right.hypot(up) / (right.hypot(up)).hypot(1.0);
                if sine >= 1.0 {
                    radial[0] += 1.0;
                    continue;
                }
                inside += 1;
                let (r_s, r_p) = reflectances(1.5, sine.asin());
                // s is tangential: across the direction from the centre of the image
                let tangent = up.atan2(right) + PI / 2.0;
                let linear = 0.5 * (r_s - r_p);
                radial[0] += 0.5 * (r_s + r_p);
                radial[1] += linear * (2.0 * tangent).cos();
                radial[2] += linear * (2.0 * tangent).sin();
            }
            radial = radial.map(|v| v / (FINE * FINE) as f64);
            if inside == 0 {
                assert_eq!(s, LAMP, "outside the sphere at {x}, {y}");
                continue;
            }
            if inside < FINE * FINE {
                continue;
            }
            assert_eq!(s[3], 0.0, "no circular light at {x}, {y}");
            let distance =
                (x as f64 + 0.5 - SIZE as f64 / 2.0).hypot(y as f64 + 0.5 - SIZE as f64 / 2.0);
            let ring = (distance / (SIZE as f64 / 2.0) * RINGS as f64) as usize;
            let angle = -2.0
                * (SIZE as f64 / 2.0 - y as f64 - 0.5).atan2(x as f64 + 0.5 - SIZE as f64 / 2.0);
            let turn = |s: Four| turned(-0.5 * angle, s);
            let (turned_s, turned_e) = (turn(s), turn(radial));
            // variances of S1 and S2 mix when the frame turns
            let (c, sn) = (angle.cos().powi(2), angle.sin().powi(2));
            let v = error.map(|e| e * e);
            let variance = [
                v[0],
                2.0 * (c * v[1] + sn * v[2]),
                2.0 * (sn * v[1] + c * v[2]),
                0.0,
            ];
            for k in 0..4 {
                found[ring][0][k] += turned_s[k];
                found[ring][1][k] += variance[k];
                expected[ring][k] += turned_e[k];
            }
            count[ring] += 1.0;
        }
    }
    for ring in (0..RINGS).filter(|&r| count[r] > 0.0) {
        let n = count[ring];
        let means = found[ring][0].map(|v| v / n);
        let errors = found[ring][1].map(|v| v.sqrt() / n);
        assert_stokes(
            &format!("ring {ring}"),
            (means, errors),
            expected[ring].map(|v| v / n),
            ROUND_OFF,
        );
        assert!(
            means[1] < 0.0 || ring == 0,
            "tangential light is negative in the radial frame"
        );
    }
}

/// The twelve cells of `polarizer_stack`, row by row from the top left, in degrees of the scene file: a polarizer's
/// angle counts clockwise, a retarder's counter-clockwise, seen from the front.
fn cells() -> [Four; 12] {
    let p = |theta: f64, s| polarizer(degrees(-theta), s);
    let r = |theta: f64, delta: f64, s| retarder(degrees(theta), degrees(delta), s);
    // turned by 40 degrees about the vertical: the absorbing axis (sin 35, cos 35, 0) in the plane of the plate,
    // seen along z, has its first coordinate shortened
    let tilted = |s| {
        let (sin, cos) = degrees(35.0).sin_cos();
        polarizer((-sin * degrees(40.0).cos()).atan2(cos), s)
    };
    // about U by 150 degrees: seen from the back, where V points down; the retardance falls with the cosine
    let from_behind = |s| retarder(degrees(-10.0), degrees(90.0) * degrees(30.0).cos(), s);
    [
        p(0.0, LAMP),
        p(30.0, LAMP),
        p(45.0, LAMP),
        p(90.0, LAMP),
        p(90.0, p(0.0, LAMP)),
        p(90.0, p(45.0, p(0.0, LAMP))),
        r(0.0, 90.0, p(45.0, LAMP)),
        r(0.0, 90.0, p(-45.0, LAMP)),
        r(22.5, 180.0, p(0.0, LAMP)),
        r(30.0, 90.0, circular(1.0, LAMP)),
        circular(-1.0, r(60.0, 70.0, p(20.0, LAMP))),
        from_behind(tilted(LAMP)),
    ]
}

#[test]
fn every_cell_of_the_polarizer_stack_follows_mueller_calculus() {
    let image = Shot {
        size: Some([256, 192]),
        ..Shot::new(2)
    }
    .of_scene("polarizer_stack");
    for (cell, expected) in cells().into_iter().enumerate() {
        // cells are 1.05 apart on a film 4.33 wide
        let scale = 256.0 / (2.0 * 5000.0 * degrees(0.0248).tan());
        let x = 128.0 + ((cell % 4) as f64 - 1.5) * 1.05 * scale;
        let y = 96.0 + ((cell / 4) as f64 - 1.0) * 1.05 * scale;
        for (dx, dy) in [(0.0, 0.0), (0.3, 0.3), (-0.3, 0.2), (0.1, -0.3)] {
            let (s, error) = pixel(
                &image,
                (x + dx * scale) as usize,
                (y + dy * scale) as usize,
                0,
            );
            // the far camera sees the cells under up to 4e-4 rad, which turns projected axes by as much at most
            assert_stokes(&format!("cell {cell}"), (s, error), expected, 4e-4);
        }
    }
}

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

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    DVec3::from(a).cross(b.into()).into()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from(a).dot(b.into())
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    DVec3::from(a).normalize().into()
}

/// The tilted retarder that `a_tilted_retarder_has_no_seam` looks through: fast axis at `theta` from axis U, projected
/// across each ray; retardance by the cosine.
fn behind_tilted_retarder(right: f64, up: f64, tilt: f64, theta: f64) -> Four {
    let k = unit([-right, -up, 1.0]);
    let e_x = unit(cross(k.map(|v| -v), [0.0, 1.0, 0.0]));
    let e_y = cross(k, e_x);
    let across = |a: [f64; 3]| unit([0, 1, 2].map(|i| a[i] - dot(a, k) * k[i]));
    let angle = |a: [f64; 3]| dot(a, e_y).atan2(dot(a, e_x));
    // the polarizer lies across the axis of the camera and absorbs (sin 30, cos 30, 0)
    let absorbing = across([0.5, degrees(30.0).cos(), 0.0]);
    let light = polarizer(angle(absorbing) - PI / 2.0, LAMP);
    // the retarder is turned about U + V; the half turn of its angles is on the side that faces the camera
    let (s, c) = tilt.sin_cos();
    let h = 0.5f64.sqrt();
    let turn = |v: [f64; 3]| {
        let axis = [h, h, 0.0];
        let (a, x) = (dot(axis, v), cross(axis, v));
        [0, 1, 2].map(|i| v[i] * c + x[i] * s + axis[i] * a * (1.0 - c))
    };
    let (u, n) = (turn([1.0, 0.0, 0.0]), turn([0.0, 0.0, 1.0]));
    retarder(angle(across(u)) + theta, PI / 2.0 * dot(n, k).abs(), light)
}

#[test]
fn a_tilted_retarder_has_no_seam() {
    const SIZE: usize = 40;
    let tilt = 30.0;
    let content = format!(
        "{LAMP_XML}{}{}",
        plate(&polarizer_xml(30.0), "<scale value='60'/>"),
        plate(
            "<bsdf type='retarder'><float name='theta' value='20'/><float name='delta' value='90'/></bsdf>",
            &format!(
                "<scale value='60'/><rotate x='0.7071067811865476' y='0.7071067811865476' angle='{tilt}'/><translate z='7'/>"
            )
        )
    );
    let text = film_scene(
        8,
        "origin='0, 0, 10' target='0, 0, 0' up='0, 1, 0'",
        60.0,
        [SIZE as u32; 2],
        &content,
    );
    let image = Shot::new(256).of_text(&text);
    let half = degrees(30.0).tan();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let at = |i: usize, k: usize| {
                ((i as f64 + (k as f64 + 0.5) / 4.0) / SIZE as f64 * 2.0 - 1.0) * half
            };
            let mut expected = [0.0; 4];
            for k in 0..16 {
                let s = behind_tilted_retarder(
                    at(x, k % 4),
                    -at(y, k / 4),
                    degrees(tilt),
                    degrees(20.0),
                );
                expected = [0, 1, 2, 3].map(|i| expected[i] + s[i] / 16.0);
            }
            // the midpoint rule over a quarter of a pixel is good to 2e-5
            assert_stokes(
                &format!("pixel {x}, {y}"),
                pixel(&image, x, y, 0),
                expected,
                3e-5,
            );
        }
    }
}

/// Light from all around through plates over white paper: the share of the irradiance that reaches the paper.
///
/// 1/π ∫ T cos θ dω over the upper half; T(k) by Mueller calculus for light that travels along k.
fn share_on_paper(passes: impl Fn([f64; 3]) -> f64) -> f64 {
    let (steps, turns) = (500, 720);
    let mut sum = 0.0;
    for j in 0..steps {
        // by projected solid angle: sin² θ is uniform
        let sin = ((f64::from(j) + 0.5) / f64::from(steps)).sqrt();
        let cos = (1.0 - sin * sin).sqrt();
        for turn in 0..turns {
            let phi = (f64::from(turn) + 0.5) / f64::from(turns) * 2.0 * PI;
            sum += passes([sin * phi.cos(), sin * phi.sin(), -cos]);
        }
    }
    sum / f64::from(steps * turns)
}

/// Angles of vectors seen along a downward k: in a frame across it, against image right of who looks up.
struct Downward {
    k: [f64; 3],
    e_x: [f64; 3],
}

impl Downward {
    fn new(k: [f64; 3]) -> Self {
        let e_x = unit(cross(k, [0.3, 0.7, 0.2]));
        Self { k, e_x }
    }

    /// Angle of the direction `a`, projected across k.
    fn angle(&self, a: [f64; 3]) -> f64 {
        dot(a, cross(self.k, self.e_x)).atan2(dot(a, self.e_x))
    }

    fn polarizer(&self, theta: f64, s: Four) -> Four {
        let (sin, cos) = degrees(theta).sin_cos();
        polarizer(self.angle([sin, cos, 0.0]) - PI / 2.0, s)
    }

    /// Its angle counts counter-clockwise from the front, and the light leaves through the back.
    fn retarder(&self, theta: f64, delta: f64, s: Four) -> Four {
        let fast = self.angle([1.0, 0.0, 0.0]) - degrees(theta);
        retarder(fast, degrees(delta) * self.k[2].abs(), s)
    }
}

#[test]
fn white_paper_is_lit_by_what_passes_the_plates_above_it() {
    let at = |bsdf: &str, z: f64| plate(bsdf, &format!("<scale value='1e4'/><translate z='{z}'/>"));
    let retarder_xml = "<bsdf type='retarder'><float name='theta' value='20'/><float name='delta' value='90'/></bsdf>";
    let circular_xml = "<bsdf type='circular'/>";
    let paper = plate(
        "<bsdf type='diffuse'><float name='reflectance' value='1'/></bsdf>",
        "<scale value='1e4'/>",
    );
    let see = |plates: &str| {
        // under the plates, where paper is all that the camera sees
        let camera = "origin='0, 0, 0.05' target='0.05, 0, 0' up='0, 1, 0'";
        let text = scene(6, camera, 0.01, &format!("{SURROUNDINGS}{paper}{plates}"));
        pixel(&Shot::new(200_000).of_text(&text), 0, 0, 0)
    };
    // the plates of 1e4 m end 1e-5 above the horizon; quadrature: doubling its points changes the sixth digit
    let check = |what: &str, plates: &str, share: f64| {
        assert_stokes(what, see(plates), [share, 0.0, 0.0, 0.0], 1e-5);
    };
    let crossed = |theta: f64| {
        share_on_paper(|k| {
            let seen = Downward::new(k);
            seen.polarizer(0.0, seen.polarizer(theta, LAMP))[0]
        })
    };
    for theta in [0.0, 45.0, 70.0] {
        let plates = format!(
            "{}{}",
            at(&polarizer_xml(0.0), 0.1),
            at(&polarizer_xml(theta), 0.2)
        );
        check(
            &format!("polarizers at 0 and {theta}"),
            &plates,
            crossed(theta),
        );
    }
    let elliptic = share_on_paper(|k| {
        let seen = Downward::new(k);
        circular(1.0, seen.retarder(20.0, 90.0, seen.polarizer(60.0, LAMP)))[0]
    });
    assert!(
        (elliptic - 0.25).abs() > 0.02,
        "the sense of rotation matters: {elliptic}"
    );
    let plates = [
        at(circular_xml, 0.1),
        at(retarder_xml, 0.2),
        at(&polarizer_xml(60.0), 0.3),
    ]
    .concat();
    check("polarizer, retarder, circular polarizer", &plates, elliptic);
}

/// Share of light that a rough surface of lossless facets reflects in one bounce, by quadrature over facet normals.
///
/// ∫ G1(i) G1(o) D(m) (o·m)/cos o dm over facets that mirror the view above the surface: GGX, Smith shadowing.
///
/// Source: Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007, Eqs. (20), (33), (34).
fn single_scattering_albedo(alpha: f64, cos_o: f64) -> f64 {
    let sin_o = (1.0 - cos_o * cos_o).sqrt();
    let shadowing =
        |cos: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 / (cos * cos) - 1.0)).sqrt());
    let (steps, turns) = (2000, 720);
    let mut sum = 0.0;
    for j in 0..steps {
        // by slope: tan² = α² u/(1 - u) has the density D cos of facets for uniform u
        let u = (f64::from(j) + 0.5) / f64::from(steps);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let cos_m = 1.0 / (1.0 + tan2).sqrt();
        let sin_m = (1.0 - cos_m * cos_m).sqrt();
        for turn in 0..turns {
            let phi = (f64::from(turn) + 0.5) / f64::from(turns) * PI;
            let o_m = sin_o * sin_m * phi.cos() + cos_o * cos_m;
            let cos_i = 2.0 * o_m * cos_m - cos_o;
            if o_m > 0.0 && cos_i > 0.0 {
                sum += shadowing(cos_i) * shadowing(cos_o) * o_m / (cos_o * cos_m);
            }
        }
    }
    sum / f64::from(steps * turns)
}

#[test]
fn rough_lossless_metal_loses_only_what_meets_a_second_facet() {
    for (alpha, angle) in [(0.1, 0.0), (0.3, 40.0), (0.5, 60.0), (0.5, 80.0)] {
        let (sin, cos) = degrees(angle).sin_cos();
        let bsdf = format!(
            "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><float name='alpha' value='{alpha}'/></bsdf>"
        );
        let text = scene(
            2,
            &format!("origin='{sin}, 0, {cos}' target='0, 0, 0' up='0, 1, 0'"),
            0.01,
            &format!("{SURROUNDINGS}{}", plate(&bsdf, "<scale value='9'/>")),
        );
        let found = pixel(&Shot::new(100_000).of_text(&text), 0, 0, 0);
        let albedo = single_scattering_albedo(alpha, cos);
        assert!(albedo > 0.6 && albedo < 1.0 + 1e-6);
        // the midpoint rule: doubling its points changes the fifth digit
        assert_stokes(
            &format!("alpha {alpha}, {angle} degrees"),
            found,
            [albedo, 0.0, 0.0, 0.0],
            3e-5,
        );
    }
}

#[test]
fn radiance_inside_glass_is_higher_by_the_square_of_its_index() {
    let content = format!(
        "{SURROUNDINGS}<shape type='sphere'><bsdf type='dielectric'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf></shape>"
    );
    // 0.3 from the centre no ray is totally reflected: sin = 0.3 < 1/1.5
    let text = film_scene(
        256,
        "origin='0.3, 0, 0' target='0, 0.5, 1' up='0, 1, 0'",
        90.0,
        [8, 8],
        &content,
    );
    let image = Shot::new(4096).of_text(&text);
    assert_stokes("inside glass", mean(&image, 0), [2.25, 0.0, 0.0, 0.0], 1e-5);
}
