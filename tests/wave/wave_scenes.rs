//! Scenes of films and crystals: the numbers that their pages state, pixel by pixel.

use std::f64::consts::TAU;

use brewster_tests::{Shot, assert_stokes, pixel, repository};
use num_complex::Complex64;
use render::film::SpectralMode;
use render::ior::named_conductor;
use render::scene::read_text;

type Vector = [f64; 3];

const AIR: f64 = 1.000_277;
const PLAIN_LAMP: (&str, &str) = (
    "<rgb name=\"radiance\" value=\"1, 1, 1\"/>",
    "<float name=\"radiance\" value=\"1\"/>",
);

/// One pixel of a scene, parts of its text replaced.
fn seen(
    name: &str,
    changes: &[(&str, &str)],
    nm: f64,
    spp: u64,
    [x, y]: [u32; 2],
) -> ([f64; 4], [f64; 4]) {
    let path = repository().join("scenes").join(name).join("scene.xml");
    let mut text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    for (from, to) in changes {
        assert!(text.contains(from), "{name} has no {from}");
        text = text.replace(from, to);
    }
    let shot = Shot {
        mode: SpectralMode::Single(nm),
        crop: Some([x, y, 1, 1]),
        ..Shot::new(spp)
    };
    let document = read_text(&text, &path, &[]).unwrap_or_else(|error| panic!("{error}"));
    pixel(&shot.of_document(&document), 0, 0, 0)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn sum(a: Vector, factor: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + factor * b[i])
}

fn unit(a: Vector) -> Vector {
    a.map(|c| c / dot(a, a).sqrt())
}

/// A camera: where it is, what it looks at (y is up), its horizontal angle and its film.
struct Camera {
    origin: Vector,
    target: Vector,
    fov: f64,
    size: [u32; 2],
}

impl Camera {
    fn axes(&self) -> [Vector; 3] {
        let forward = unit(sum(self.target, -1.0, self.origin));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        [right, cross(right, forward), forward]
    }

    /// Direction of sight through a point of the film, in pixels.
    fn sight(&self, [x, y]: [f64; 2]) -> Vector {
        let [right, up, forward] = self.axes();
        let [w, h] = self.size.map(f64::from);
        let step = 2.0 * (0.5 * self.fov.to_radians()).tan() / w;
        unit(sum(
            sum(forward, (x - 0.5 * w) * step, right),
            (0.5 * h - y) * step,
            up,
        ))
    }

    /// The pixel that shows a point.
    fn pixel_of(&self, point: Vector) -> [u32; 2] {
        let to = sum(point, -1.0, self.origin);
        let [right, up, forward] = self.axes().map(|axis| dot(axis, to));
        let [w, h] = self.size.map(f64::from);
        let step = 2.0 * (0.5 * self.fov.to_radians()).tan() / w * forward;
        [0.5 * w + right / step, 0.5 * h - up / step].map(|c| c as u32)
    }

    /// Mean over a pixel, by the midpoint rule.
    fn mean<const N: usize>(&self, pixel: [u32; 2], of: impl Fn(Vector) -> [f64; N]) -> [f64; N] {
        const STEPS: u32 = 16;
        let mut mean = [0.0; N];
        for i in 0..STEPS * STEPS {
            let within = [i % STEPS, i / STEPS].map(|c| (f64::from(c) + 0.5) / f64::from(STEPS));
            let at = [0, 1].map(|c| f64::from(pixel[c]) + within[c]);
            let values = of(self.sight(at));
            mean = std::array::from_fn(|k| mean[k] + values[k] / f64::from(STEPS * STEPS));
        }
        mean
    }
}

/// |r_s|² and |r_p|² of a film, by Airy's sum.
///
/// Source: Born & Wolf, 7th ed., section 1.6.4, Eq. (57), in `exp(+iωt)`.
fn film(before: f64, film: f64, behind: Complex64, phase: f64, cos_i: f64) -> [f64; 2] {
    let media = [before.into(), film.into(), behind];
    let sine = before * (1.0 - cos_i * cos_i).sqrt();
    let cosines = media.map(|n: Complex64| (1.0 - (sine / n).powi(2)).sqrt());
    let face = |a: usize, b: usize| {
        let [na, nb, ca, cb] = [media[a], media[b], cosines[a], cosines[b]];
        [
            (na * ca - nb * cb) / (na * ca + nb * cb),
            (nb * ca - na * cb) / (nb * ca + na * cb),
        ]
    };
    let [front, back] = [face(0, 1), face(1, 2)];
    let turn = (-2.0 * Complex64::I * phase * film * cosines[1]).exp();
    [0, 1].map(|p| ((front[p] + back[p] * turn) / (1.0 + front[p] * back[p] * turn)).norm_sqr())
}

#[test]
fn the_soap_film_shows_airys_bands() {
    let camera = Camera {
        origin: [0.0, 0.0, 14.0],
        target: [0.0; 3],
        fov: 9.6,
        size: [320, 320],
    };
    let (sin, cos) = 53.06f64.to_radians().sin_cos();
    let normal = [sin, 0.0, cos];
    let reflectances = |nm: f64, k: Vector| {
        let cos_i = -dot(k, normal);
        let distance = dot(camera.origin, normal) / cos_i;
        let y = sum(camera.origin, distance, k)[1];
        let phase = TAU * 450e-9 * (1.0 - y) / (nm * 1e-9);
        film(AIR, 1.333, AIR.into(), phase, cos_i)
    };
    for nm in [480.0, 550.0, 633.0] {
        for at in [
            [160, 30],
            [160, 75],
            [160, 200],
            [160, 280],
            [90, 120],
            [230, 170],
        ] {
            let [mean] = camera.mean(at, |k| [0.5 * reflectances(nm, k).iter().sum::<f64>()]);
            let (found, error) = seen("soap_film", &[PLAIN_LAMP], nm, 4096, at);
            assert!(error[0] < 0.05 * mean.max(0.02));
            let off = (found[0] - mean).abs();
            assert!(
                off < 5.0 * error[0] + 1e-5,
                "{nm} nm, {at:?}: {found:?} ± {error:?}, expected {mean}"
            );
        }
    }
    // Brewster's angle in the middle: all of it up and down
    let (found, _) = seen("soap_film", &[PLAIN_LAMP], 550.0, 1024, [160, 160]);
    assert!((found[1] / found[0] + 1.0).abs() < 1e-3, "{found:?}");
    // 258 nm: half a wave of way to and fro, and the film is dark once more
    let [dark] = camera.mean([160, 160], |_| {
        [film(AIR, 1.333, AIR.into(), TAU * 257.9 / 550.0, cos)[0]]
    });
    assert!(dark < 1e-6);
}

#[test]
fn every_plate_of_the_oxide_scene_reflects_as_its_film() {
    let camera = Camera {
        origin: [0.0, -12.1244, 7.0],
        target: [0.0, -0.3, 0.0],
        fov: 18.0,
        size: [320, 140],
    };
    let (eta, k) = named_conductor("Nb").unwrap();
    let metal = Complex64::new(f64::from(eta.value(550.0)), -f64::from(k.value(550.0)));
    for plate in 0..12 {
        let centre = [-1.5 + f64::from(plate % 4), 1.0 - f64::from(plate / 4), 0.0];
        let thickness = (30.0 + 10.0 * f64::from(plate)) * 1e-9;
        let at = camera.pixel_of(centre);
        let [mean, difference] = camera.mean(at, |k| {
            let [s, p] = film(AIR, 2.3, metal, TAU * thickness / 550e-9, -k[2]);
            [0.5 * (s + p), 0.5 * (s - p)]
        });
        let (found, error) = seen("oxide", &[PLAIN_LAMP], 550.0, 1024, at);
        let linear = found[1].hypot(found[2]);
        let what = format!("plate {plate}: {found:?} ± {error:?}, expected {mean}, {difference}");
        // the index of the metal in single precision
        assert!((found[0] - mean).abs() < 5.0 * error[0] + 1e-5, "{what}");
        assert!(
            (linear - difference.abs()).abs() < 5.0 * error[1].max(error[2]) + 1e-4,
            "{what}"
        );
        assert!(found[1] * difference > 0.0 && found[3] == 0.0, "{what}");
    }
}

/// Power that crossed polarizers and a uniaxial plate between them, cut across its axis, let through along k.
///
/// Faces by the admittances of the ordinary wave (s) and the extraordinary wave (p).
fn conoscope([n_o, n_e]: [f64; 2], phase: f64, k: Vector) -> f64 {
    let sine2 = (AIR * AIR) * (1.0 - k[2] * k[2]);
    let w = AIR * k[2].abs();
    let (q_o, q_e) = (
        (n_o * n_o - sine2).sqrt(),
        n_o * (1.0 - sine2 / (n_e * n_e)).sqrt(),
    );
    let r_s = (w - q_o) / (w + q_o);
    let r_p = (n_o * n_o * w - AIR * AIR * q_e) / (n_o * n_o * w + AIR * AIR * q_e);
    let pass = |r: f64, q: f64| (1.0 - r * r) * (-Complex64::I * phase * q).exp();
    let s = unit(cross(k, [0.0, 0.0, 1.0]));
    let p = cross(k, s);
    // a polarizer passes what is across its absorbing axis
    let (first, second) = (
        unit(cross([0.0, 1.0, 0.0], k)),
        unit(cross([1.0, 0.0, 0.0], k)),
    );
    let through = |axis: Vector, q: Complex64| q * dot(first, axis) * dot(second, axis);
    0.5 * (through(s, pass(r_s, q_o)) + through(p, pass(r_p, q_e))).norm_sqr()
}

#[test]
fn calcite_between_crossed_polarizers_has_its_rings_and_its_cross() {
    let camera = Camera {
        origin: [0.0, 0.0, 1.0],
        target: [0.0; 3],
        fov: 50.0,
        size: [240, 240],
    };
    // Ghosh, Opt. Commun. 163, 95 (1999), at 589.3 nm
    let indices = [1.658_343_404, 1.486_130_061];
    let phase = TAU * 0.15e-3 / 589.3e-9;
    // at 45 degrees to the polarizers, from the middle outward, and elsewhere
    for at in [
        [130, 109],
        [150, 89],
        [165, 74],
        [180, 59],
        [80, 75],
        [150, 119],
        [60, 201],
    ] {
        let [expected] = camera.mean(at, |k| [conoscope(indices, phase, k)]);
        let (found, error) = seen("crossed_polarizers_crystal", &[PLAIN_LAMP], 589.3, 1024, at);
        // vertical, as the second polarizer lets it be, but for the tilt of the ray
        assert!(
            (found[0] - expected).abs() < 5.0 * error[0] + 2e-5,
            "{at:?}: {found:?} ± {error:?}, expected {expected}"
        );
        assert!(error[0] < 0.02);
    }
    // dark rings at 13.3 and 18.8 degrees, bright ones in between
    let along = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let half = 0.5f64.sqrt();
        conoscope(indices, phase, [sin * half, sin * half, -cos])
    };
    // tilted polarizers leak
    assert!(along(13.25) < 2e-3 && along(18.81) < 2e-3);
    assert!(along(16.3) > 0.4 && along(9.4) > 0.4);
}

#[test]
fn cells_of_the_display_pass_what_their_page_says() {
    // from so far away that all cells are seen along their normals
    let far = [
        ("origin=\"0, 0, 6\"", "origin=\"0, 0, 600\""),
        (
            "<float name=\"fov\" value=\"24\"/>",
            "<float name=\"fov\" value=\"0.2\"/>",
        ),
        PLAIN_LAMP,
    ];
    let camera = Camera {
        origin: [0.0, 0.0, 600.0],
        target: [0.0; 3],
        fov: 0.2,
        size: [240, 240],
    };
    let levels = [0.0, 0.0732, 0.25, 0.4268, 0.5];
    // cells of every level, left and right
    for (cell, level) in [
        ([-0.1, 0.3], 0),
        ([-0.7, 0.1], 1),
        ([-0.5, -0.1], 2),
        ([-0.1, -0.1], 3),
        ([-0.1, 0.1], 4),
        ([0.5, 0.1], 0),
        ([0.5, -0.1], 2),
        ([0.3, -0.1], 3),
        ([0.1, 0.1], 4),
    ] {
        let at = camera.pixel_of([cell[0], cell[1], 0.0]);
        let (found, error) = seen("lcd", &far, 550.0, 1024, at);
        let lit = levels[level];
        // behind glasses at 60°, clockwise: three quarters, at that angle
        let expected = if cell[0] > 0.0 {
            let (sin, cos) = (-120f64).to_radians().sin_cos();
            [0.75 * lit, 0.75 * lit * cos, 0.75 * lit * sin, 0.0]
        } else {
            [lit, -lit, 0.0, 0.0]
        };
        // the faces reflect 5e-4 of it
        assert_stokes(&format!("cell {cell:?}"), (found, error), expected, 4e-4);
        if cell[0] > 0.0 {
            let glasses = (
                "name=\"glasses\" value=\"60\"",
                "name=\"glasses\" value=\"0\"",
            );
            let crossed = [far[0], far[1], far[2], glasses];
            let (found, _) = seen("lcd", &crossed, 550.0, 1024, at);
            assert!(found[0] < 1e-6, "{found:?}");
        }
    }
}
