//! Claim: a bare sensor plane records the irradiance of textbooks, with its polarization and its coherence.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use brewster_tests::{SIGMAS, Shot, assert_stokes, mean, pixel};
use render::image::StokesImage;
use render::scene::{Overrides, build, read_text};

use super::coherence::{
    LEFT_OUT, OWN_MEAN, SAMPLES, SIZE, assert_near, besinc, lamp, measured_in, sinc, wavenumber,
};

/// Rounding of single precision over a few operations, relative.
const ROUNDING: f64 = 2e-6;

/// A scene with a sensor in a shape at `place`; paths of at most `depth`.
fn metered(
    depth: i64,
    shape: &str,
    place: &str,
    parameters: &str,
    [width, height]: [u32; 2],
    content: &str,
) -> String {
    format!(
        "<scene version='3.0.0'>
            <integrator type='path'>
                <integer name='max_depth' value='{depth}'/><integer name='rr_depth' value='1000000'/>
            </integrator>
            <shape type='{shape}'><transform name='to_world'>{place}</transform>
                <sensor type='irradiancemeter'>{parameters}
                    <film type='hdrfilm'>
                        <integer name='width' value='{width}'/><integer name='height' value='{height}'/>
                        <rfilter type='box'/>
                    </film>
                </sensor>
                <bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>
            </shape>
            {content}
        </scene>"
    )
}

/// A plane so small that it is a point of the xy plane, facing up: its half-width squared is 1e-6.
const POINT: &str = "<scale value='0.001'/>";

/// What one pixel at the origin records.
fn at_origin(depth: i64, place: &str, content: &str, spp: u64) -> ([f64; 4], [f64; 4]) {
    let text = metered(depth, "rectangle", place, "", [1, 1], content);
    mean(&Shot::new(spp).of_text(&text), 0)
}

/// Checks S0 alone.
fn assert_irradiance(what: &str, (s, error): ([f64; 4], [f64; 4]), expected: f64) {
    assert_stokes(
        what,
        (s, error),
        [expected, 0.0, 0.0, 0.0],
        ROUNDING * expected,
    );
}

fn point_lamp(position: [f64; 3], parameters: &str) -> String {
    let [x, y, z] = position;
    format!(
        "<emitter type='point'><point name='position' x='{x}' y='{y}' z='{z}'/>
         <float name='intensity' value='3'/>{parameters}</emitter>"
    )
}

#[test]
fn lambertian_lamps_give_their_form_factor() {
    let n = 20_000;
    // disk of radius 1 at 1: π L sin² 45°
    let disk = lamp("disk", [1.0, 1.0], 0.0, 0.0, 2.0);
    assert_irradiance("disk", at_origin(1, POINT, &disk, n), 2.0 * PI * 0.5);
    // 2 a × 2 b at height 1: four corners, each arctan terms of X = a, Y = b
    let (a, b) = (0.8, 1.5);
    let corner = |x: f64, y: f64| {
        let r = x.hypot(1.0);
        x / r * (y / r).atan()
    };
    let factor = 4.0 / TAU * (corner(a, b) + corner(b, a));
    let rectangle = lamp("rectangle", [a, b], 0.0, 0.0, 2.0);
    assert_irradiance(
        "rectangle",
        at_origin(1, POINT, &rectangle, n),
        2.0 * PI * factor,
    );
    // a sphere of radius R at distance d straight above: π L (R/d)²
    let sphere = "<shape type='sphere'><float name='radius' value='0.7'/><point name='center' z='1.2' x='0' y='0'/>
        <emitter type='area'><float name='radiance' value='2'/></emitter></shape>";
    assert_irradiance(
        "sphere",
        at_origin(1, POINT, sphere, n),
        2.0 * PI * (0.7f64 / 1.2).powi(2),
    );
    // the same radiance from everywhere above
    let sky = "<emitter type='constant'><float name='radiance' value='2'/></emitter>";
    assert_irradiance("sky", at_origin(1, POINT, sky, n), 2.0 * PI);
    // nothing shorter than one link
    assert_irradiance("no link", at_origin(0, POINT, sky, 16), 0.0);
}

#[test]
fn lamps_without_area_give_cosine_over_square() {
    let lamp = point_lamp([0.5, -0.2, 1.1], "");
    let r2 = 0.25 + 0.04 + 1.21f64;
    let expected = 3.0 * 1.1 / r2.powf(1.5);
    // the plane's width: second derivatives of 1/r² and cos, below 10 (half-width)²/3
    let found = at_origin(1, POINT, &lamp, 1000);
    assert_stokes("point", found, [expected, 0.0, 0.0, 0.0], 1e-5 * expected);
    // from below nothing
    let below = point_lamp([0.0, 0.0, -1.0], "");
    assert_irradiance("behind", at_origin(1, POINT, &below, 16), 0.0);
    // a beam of even irradiance P/(π w²), inclined by 40°
    let beam = "<emitter type='laser'><string name='waist' value='5mm'/><string name='profile' value='tophat'/>
        <float name='power' value='0.01'/>
        <transform name='to_world'><rotate x='1' angle='180'/><translate z='1'/><rotate x='1' angle='40'/></transform></emitter>";
    let expected = 0.01 / (PI * 25e-6) * 40f64.to_radians().cos();
    assert_irradiance("laser", at_origin(1, POINT, beam, 16), expected);
}

#[test]
fn light_between_mirrors_of_a_furnace_adds_up() {
    // inside a sphere that shines with L and reflects half: 2 L from everywhere; the meter is too small to matter
    let furnace = "<shape type='sphere'><boolean name='flip_normals' value='true'/>
        <bsdf type='diffuse'><float name='reflectance' value='0.5'/></bsdf>
        <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";
    let text = metered(-1, "disk", POINT, "", [1, 1], furnace)
        // roulette is part of it
        .replace("1000000", "3");
    let (s, error) = mean(&Shot::new(40_000).of_text(&text), 0);
    assert_irradiance("furnace", (s, error), TAU);
    assert!(error[0] < 0.01 * TAU, "{error:?}");
}

#[test]
fn one_pixel_is_the_mean_of_many_and_of_the_whole_shape() {
    let (a, b) = (0.6, 0.3);
    let place = format!("<scale x='{a}' y='{b}'/>");
    let lamp = point_lamp([0.0, 0.0, 0.4], "");
    // flux through a rectangle: intensity times its solid angle
    let angle = 4.0 * (a * b / (0.4 * (a * a + b * b + 0.16f64).sqrt())).atan();
    let expected = 3.0 * angle / (4.0 * a * b);
    for size in [[1, 1], [9, 5]] {
        let text = metered(1, "rectangle", &place, "", size, &lamp);
        let found = mean(&Shot::new(20_000).of_text(&text), 0);
        assert_irradiance(&format!("{size:?}"), found, expected);
    }
    // a disk: 2π (1 − cos) over π R²
    let text = metered(1, "disk", "<scale value='0.6'/>", "", [1, 1], &lamp);
    let found = mean(&Shot::new(20_000).of_text(&text), 0);
    let cos = 0.4 / 0.6f64.hypot(0.4);
    assert_irradiance("disk", found, 3.0 * 2.0 * (1.0 - cos) / 0.36);
}

#[test]
fn columns_follow_x_and_rows_follow_y() {
    // near the corner of local +x, +y
    let text = |crop: &str| {
        metered(
            1,
            "rectangle",
            "",
            "",
            [4, 4],
            &point_lamp([0.75, 0.75, 0.1], ""),
        )
        .replace("<rfilter", &format!("{crop}<rfilter"))
    };
    let image = Shot::new(64).of_text(&text(""));
    let brightest = (0..16).max_by(|&p, &q| {
        let s0 = |k: usize| image.stokes_at(k % 4, k / 4, 0)[0];
        s0(p).total_cmp(&s0(q))
    });
    // last column; last row, as seen from behind
    assert_eq!(brightest, Some(15));
    // a window shows the same samples
    let cropped = Shot {
        crop: Some([2, 1, 2, 3]),
        ..Shot::new(64)
    }
    .of_text(&text(""));
    for (x, y) in [(0, 0), (1, 2)] {
        assert_eq!(cropped.stokes_at(x, y, 0), image.stokes_at(x + 2, y + 1, 0));
    }
}

#[test]
fn polarization_is_told_in_the_planes_frame() {
    let state = |text: &str| {
        format!("<string name='stokes' value='{text}'/><vector name='frame' y='1' x='0' z='0'/>")
    };
    for (position, turn) in [
        ([0.0, 0.0, 1.0], 0.0f64),
        ([0.0, 0.0, 1.0], 25.0),
        ([0.7, -0.4, 0.9], 25.0),
        ([-0.2, 1.0, 0.3], 110.0),
    ] {
        let r = position.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        let i = position.map(|x| x / r);
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let across = |v: [f64; 3]| {
            let along = dot(v, i);
            let w: [f64; 3] = std::array::from_fn(|n| v[n] - along * i[n]);
            let length = dot(w, w).sqrt();
            w.map(|x| x / length)
        };
        // the lamp's axis y in the frame of x' and k × x', k = −i
        let (sin, cos) = turn.to_radians().sin_cos();
        let x = across([cos, sin, 0.0]);
        let y = [
            x[1] * i[2] - x[2] * i[1],
            x[2] * i[0] - x[0] * i[2],
            x[0] * i[1] - x[1] * i[0],
        ];
        let field = across([0.0, 1.0, 0.0]);
        let (a, b) = (dot(field, x), dot(field, y));
        let irradiance = 3.0 * i[2] / (r * r);
        let expected = [
            irradiance,
            0.6 * irradiance * (a * a - b * b),
            0.6 * irradiance * 2.0 * a * b,
            0.5 * irradiance,
        ];
        let place = format!("<scale value='0.0001'/><rotate z='1' angle='{turn}'/>");
        let found = at_origin(
            1,
            &place,
            &point_lamp(position, &state("1, 0.6, 0, 0.5")),
            400,
        );
        // directions turn by the width of the plane over the distance
        assert_stokes(
            &format!("{position:?} {turn}"),
            found,
            expected,
            1e-3 / 400f64.sqrt() * irradiance,
        );
    }
    // a wide lamp in the frame of x: the same axis is projected for lamp and plane, ray by ray
    let wide = lamp("rectangle", [1.0, 2.0], 0.0, 0.0, 1.0)
        .replace("<emitter type='area'>", "<emitter type='area'><string name='stokes' value='1, 1, 0, 0'/><vector name='frame' x='1' y='0' z='0'/>");
    let (s, _) = at_origin(1, POINT, &wide, 2000);
    assert!(
        (s[1] / s[0] - 1.0).abs() < 1e-4 && s[2].abs() < 1e-4 * s[0],
        "{s:?}"
    );
}

#[test]
fn lamps_are_seen_through_flat_matter() {
    let polarizer = |angle: f64| {
        format!(
            "<shape type='rectangle'><transform name='to_world'><translate z='0.5'/></transform>
             <bsdf type='polarizer'><float name='theta' value='{angle}'/></bsdf></shape>"
        )
    };
    let lamp = point_lamp([0.0, 0.0, 1.0], "");
    // theta is clockwise from the front, which looks away from the plane; the image is seen from behind: theta in it
    for angle in [0.0f64, 30.0] {
        let content = polarizer(angle) + &lamp;
        let (sin, cos) = (2.0 * angle.to_radians()).sin_cos();
        let found = at_origin(2, POINT, &content, 64);
        let expected = [1.5, 1.5 * cos, 1.5 * sin, 0.0];
        assert_stokes(&format!("{angle}"), found, expected, 1e-4);
        assert_irradiance("too short", at_origin(1, POINT, &content, 16), 0.0);
    }
}

/// Young's experiment: a plane 0.2 m behind a double slit, a lamp of `width` × 0.1 mm a metre before it.
const LAMBDA: f64 = 550e-9;
const SLIT: f64 = 4e-6;
const SPACING: f64 = 60e-6;
const DISTANCE: f64 = 0.2;
/// Half the width of the plane: three fringes.
const HALF: f64 = 3.0 * LAMBDA / SPACING * DISTANCE;
const COLUMNS: usize = 36;

fn young(lamp_width: f64, spp: u64) -> StokesImage {
    let content = format!(
        "<shape type='rectangle' id='screen'><transform name='to_world'><scale value='0.0001'/><translate z='{DISTANCE}'/></transform>
         <bsdf type='slits'><string name='width' value='4um'/><string name='height' value='4um'/>
         <string name='spacing' value='60um'/></bsdf></shape>
         <shape type='rectangle'><transform name='to_world'><scale x='{}' y='0.00005'/><rotate x='1' angle='180'/>
         <translate z='{}'/></transform><emitter type='area'><float name='radiance' value='1'/>
         <string name='stokes' value='1, 0.8, 0, 0.6'/></emitter></shape>",
        0.5 * lamp_width,
        DISTANCE + 1.0
    );
    let place = format!("<scale x='{HALF}' y='0.0001'/>");
    let toward = "<string name='toward' value='screen'/>";
    let text = metered(
        2,
        "rectangle",
        &place,
        toward,
        [COLUMNS as u32, 1],
        &content,
    );
    Shot::new(spp).of_text(&text)
}

/// What is left of a fringe in a pixel: six of them lie on the columns.
const PIXEL: f64 = 6.0 / COLUMNS as f64;

/// sinc² of one slit, for light that turns by `sine`.
fn envelope(sine: f64) -> f64 {
    sinc(PI * sine * SLIT / LAMBDA).powi(2)
}

/// Irradiance at x: `(L/λ²) (ab)² cos²/r² ∫ 2 sinc² (1 + cos kdθ) dΩ` over the lamp, θ from each of its points.
fn fringes(lamp_width: f64, x: f64) -> f64 {
    let r2 = x * x + DISTANCE * DISTANCE;
    let cos2 = DISTANCE * DISTANCE / r2;
    let n = 100;
    let mean: f64 = (0..n)
        .map(|k| {
            let source = lamp_width * ((f64::from(k) + 0.5) / f64::from(n) - 0.5);
            let sine = x / r2.sqrt() + source;
            2.0 * envelope(sine) * (1.0 + (TAU / LAMBDA * SPACING * sine).cos()) / f64::from(n)
        })
        .sum();
    lamp_width * 1e-4 * (SLIT * SLIT / LAMBDA).powi(2) * mean * cos2 / r2
}

#[test]
fn youngs_fringes_are_as_visible_as_van_cittert_and_zernike_say() {
    for ratio in [0.02, 0.5, 1.0, 1.4] {
        let lamp_width = ratio * LAMBDA / SPACING;
        let image = young(lamp_width, 400);
        let width = 2.0 * HALF / COLUMNS as f64;
        // about 1 + V cos: sums of s and s cos over whole fringes
        let (mut even, mut beat, mut noise) = (0.0, 0.0, 0.0);
        for column in 0..COLUMNS {
            let n = 32;
            let x = |place: f64| (column as f64 + place) * width - HALF;
            let expected: f64 = (0..n)
                .map(|k| fringes(lamp_width, x((f64::from(k) + 0.5) / f64::from(n))) / f64::from(n))
                .sum();
            let (s, error) = pixel(&image, column, 0, 0);
            // Gaussian patches, and γ constant over a slit: 1e-3 of what one slit sends
            let one = lamp_width * 1e-4 * 2.0 * (SLIT * SLIT / LAMBDA / DISTANCE).powi(2);
            assert!(
                (s[0] - expected).abs() < SIGMAS * error[0] + 1e-3 * one,
                "{ratio}, column {column}: {:e} ± {:e}, {expected:e}",
                s[0],
                error[0]
            );
            // slits keep the state; the second axes of lamp and plane are both k × x
            for (k, share) in [(1, 0.8), (2, 0.0), (3, 0.6)] {
                assert!(
                    (s[k] - share * s[0]).abs() <= 1e-3 * s[0],
                    "{ratio}, column {column}: {s:?}"
                );
            }
            let (sine, share) = (x(0.5) / DISTANCE, envelope(x(0.5) / DISTANCE).recip());
            let cos = 2.0 * (TAU / LAMBDA * SPACING * sine).cos() / sinc(PI * PIXEL);
            even += s[0] * share;
            beat += s[0] * share * cos;
            noise += (error[0] * share * cos).powi(2);
        }
        let visibility = sinc(PI * ratio);
        // the envelope's own change over the lamp, (α a/λ)²/6, and that of both over a pixel: below 0.01
        assert!(
            (beat / even - visibility).abs() < SIGMAS * noise.sqrt() / even + 0.01,
            "{ratio}: {} {visibility}",
            beat / even
        );
    }
}

#[test]
fn roulette_does_not_see_how_small_the_window_is() {
    // a bright wall behind a window of 1e-6 sr: seven panes of nothing on the way, roulette from the first
    let panes: String = (1..8)
        .map(|k| {
            format!(
                "<shape type='rectangle' id='pane{k}'><transform name='to_world'><scale value='0.001'/><translate z='{}'/>
                 </transform><bsdf type='null'/></shape>",
                1.0 + 0.1 * f64::from(k)
            )
        })
        .collect();
    let wall = "<emitter type='constant'><float name='radiance' value='1'/></emitter>";
    let text = metered(
        -1,
        "rectangle",
        "<scale value='0.00001'/>",
        "<string name='toward' value='pane1'/>",
        [1, 1],
        &(panes + wall),
    )
    .replace("1000000", "1");
    let (s, error) = mean(&Shot::new(4000).of_text(&text), 0);
    let expected = 4e-6 / 1.21;
    assert_irradiance("window", (s, error), expected);
    // survival of 0.95 a pane: variance 0.95⁻⁷ − 1
    assert!(
        error[0] < 2.0 * expected * (0.95f64.powi(-7) - 1.0).sqrt() / 4000f64.sqrt(),
        "{error:?}"
    );
}

#[test]
fn coherence_is_that_of_the_light_at_the_plane() {
    let scene = |content: &str| metered(1, "rectangle", POINT, "", [SIZE as u32; 2], content);
    let k = wavenumber(550e-9);
    let shot = Shot::new(SAMPLES);

    // a disk of angular diameter a: a circle of radius 4/(ka), |2 J1(u)/u|
    let a = 0.02;
    let separation = 2.0 * 2.0 / (k * a);
    let disk = lamp("disk", [0.5 * a; 2], 0.0, 0.0, 1.0);
    let along = [0.6 * separation, -0.8 * separation];
    let [xx, xy, yy, degree] = measured_in(&shot, &scene(&disk), along);
    let spread = OWN_MEAN * a * a / 16.0;
    assert_near("xx", xx, spread, LEFT_OUT);
    assert_near("yy", yy, spread, LEFT_OUT);
    assert_near("xy", xy, 0.0, 0.0);
    assert_near("degree", degree, besinc(2.0), LEFT_OUT);

    // a long lamp at 30° from x toward y: that is below image right, for rows follow y
    let (long, short) = (0.02, 0.008);
    let (sin, cos) = (PI / 6.0).sin_cos();
    let content = lamp("rectangle", [0.5 * long, 0.5 * short], 30.0, 0.0, 1.0);
    let separation = 1.5 * 2.0 / (k * long);
    let [xx, xy, yy, degree] = measured_in(
        &shot,
        &scene(&content),
        [separation * cos, -separation * sin],
    );
    let [large, small] = [long, short].map(|l| OWN_MEAN * l * l / 12.0);
    for (what, found, expected) in [
        ("long xx", xx, large * cos * cos + small * sin * sin),
        ("long xy", xy, -(large - small) * sin * cos),
        ("long yy", yy, large * sin * sin + small * cos * cos),
        ("long degree", degree, sinc(1.5)),
    ] {
        assert_near(what, found, expected, LEFT_OUT);
    }

    // light that comes from matter counts with the direction in which it arrives: a lit wall as wide as the disk
    let wall = "<shape type='disk'><transform name='to_world'><scale value='0.3'/><rotate x='1' angle='180'/><translate z='1'/>
        </transform><bsdf type='diffuse'/></shape>".to_owned() + &point_lamp([0.0, 0.0, -40.0], "");
    // 0.3 m at 1 m: the second moment of sine over irradiance is sin²/4 in each axis
    let text = scene(&wall).replace("'max_depth' value='1'", "'max_depth' value='2'");
    let sin2 = 0.09 / 1.09;
    let [xx, _, yy, _] = measured_in(&Shot::new(8 * SAMPLES), &text, [1e-6, 0.0]);
    // one ray in ten meets the wall; the lamp's obliquity on it is below 1e-4
    let expected = 0.25 * sin2 * (1.0 - 1.0 / (8.0 * SAMPLES as f64 * sin2));
    for (what, found) in [("wall xx", xx), ("wall yy", yy)] {
        assert_near(what, found, expected, 5.0 * LEFT_OUT);
    }
}

fn read(text: &str) -> Result<Vec<String>, String> {
    let document =
        read_text(text, Path::new("test.xml"), &[]).map_err(|error| error.to_string())?;
    build(&document, Overrides::default()).map_err(|error| error.to_string())?;
    Ok(document.notices())
}

#[test]
fn sensors_in_wrong_places_are_refused_in_words() {
    let box_film = "<film type='hdrfilm'><rfilter type='box'/></film>";
    let meter =
        |inside: &str| format!("<sensor type='irradiancemeter'>{box_film}{inside}</sensor>");
    let on = |shape: &str, inside: &str| format!("<shape type='{shape}'>{}</shape>", meter(inside));
    let toward = |id: &str| {
        on(
            "rectangle",
            &format!("\n<string name='toward' value='{id}'/>"),
        )
    };
    for (content, expected) in [
        (
            meter(""),
            "test.xml:2:1: sensor 'irradiancemeter' stands alone, expected it inside a rectangle or a disk",
        ),
        (
            on("sphere", ""),
            "test.xml:2:22: sensor 'irradiancemeter' inside shape 'sphere', expected it inside a rectangle or a disk",
        ),
        (
            on("rectangel", ""),
            "test.xml:2:1: unknown shape 'rectangel', did you mean 'rectangle'?",
        ),
        (
            "<shape type='disk'>\n<sensor type='perspective'/></shape>".to_owned(),
            "test.xml:3:1: sensor 'perspective' inside shape 'disk', expected 'irradiancemeter' there",
        ),
        (
            "<shape type='disk'>\n<sensor type='radiancemeter'/></shape>".to_owned(),
            "test.xml:3:1: sensor 'radiancemeter' is not supported yet",
        ),
        (
            on(
                "disk",
                "\n<transform name='to_world'><scale value='2'/></transform>",
            ),
            "test.xml:3:1: a transform of sensor 'irradiancemeter', expected none: its shape places it",
        ),
        (
            on("disk", "\n<float name='fov' value='40'/>"),
            "test.xml:3:1: unknown parameter 'fov' in sensor 'irradiancemeter'",
        ),
        (
            format!("<shape type='disk'>{}\n{}</shape>", meter(""), meter("")),
            "test.xml:3:1: second sensor 'irradiancemeter' in shape 'disk', expected at most one",
        ),
        (
            toward("nothing"),
            "test.xml:3:1: no shape has the id 'nothing', expected that of a rectangle or a disk",
        ),
        (
            toward("slts") + "<shape type='rectangle' id='slits'/>",
            "test.xml:3:1: no shape has the id 'slts', did you mean 'slits'?",
        ),
        (
            toward("ball") + "<shape type='sphere' id='ball'/>",
            "test.xml:3:1: 'ball' is shape 'sphere', expected a rectangle or a disk",
        ),
        (
            toward("own").replace(
                "<shape type='rectangle'",
                "<shape type='rectangle' id='own'",
            ),
            "test.xml:3:1: 'own' is the sensor's own shape, expected one in front of it",
        ),
    ] {
        let message = read(&format!("<scene version='3.0.0'>\n{content}</scene>"))
            .err()
            .unwrap_or_else(|| panic!("accepted: {content}"));
        assert!(message.starts_with(expected), "{message}");
    }
    // doubtful, not wrong
    for (content, expected) in [
        (
            on("disk", "").replace("box", "tent"),
            "mix with their neighbours",
        ),
        (
            on("disk", "") + "<sensor type='perspective'/>",
            "only the first sensor",
        ),
        (
            on("disk", "") + &on("rectangle", ""),
            "only the first sensor",
        ),
    ] {
        let notices = read(&format!("<scene version='3.0.0'>\n{content}</scene>"))
            .unwrap_or_else(|error| panic!("{error}"));
        assert!(
            notices.iter().any(|notice| notice.contains(expected)),
            "{notices:?}"
        );
    }
}
