//! Claim: light behind an analyzer is what the same plate in front of the camera lets through, and the frames of a
//! polarization camera hold S0, S1 and S2.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use brewster_tests::{SIGMAS, Shot, brewster, film_scene, image_of, mean, scene};
use render::analyzer::{Analyzer, Incident};
use render::engine::{Limits, Rendering, render};
use render::image::StokesImage;
use render::output;
use render::scene::read_text;

/// What single precision may cost in a few matrix products of numbers around one.
const ROUND_OFF: f64 = 3e-6;

/// Renders with products of components, as `--analyzer` does.
fn rendered(text: &str, spp: u64) -> (StokesImage, Rendering) {
    let document =
        read_text(text, Path::new("test.xml"), &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut job = Shot::new(spp).job(&document);
    job.film.products = true;
    let rendering = render(&job, Limits::default(), &AtomicBool::new(false), |_| ());
    (image_of(&job, &rendering), rendering)
}

fn behind(image: &StokesImage, analyzer: &Analyzer) -> StokesImage {
    Incident::new(image, None).unwrap().behind(analyzer)
}

/// A polarizer that transmits along `angle` degrees, counter-clockwise as a camera at +z sees it.
fn polarizer(angle: f64, z: f64) -> String {
    // the plugin's angle is clockwise
    plate(
        &format!(
            "<bsdf type='polarizer'><float name='theta' value='{}'/></bsdf>",
            -angle
        ),
        z,
    )
}

fn plate(bsdf: &str, z: f64) -> String {
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale value='50'/><translate z='{z}'/></transform>{bsdf}</shape>"
    )
}

const LAMP: &str = "<shape type='rectangle'><transform name='to_world'><scale value='200'/><translate z='-3'/></transform>
    <emitter type='area'><float name='radiance' value='1'/></emitter></shape>";
const AHEAD: &str = "origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'";

#[test]
fn malus_law_holds_for_the_option_as_for_a_plate() {
    let lit = format!("{LAMP}{}", polarizer(20.0, 0.0));
    let (image, _) = rendered(&scene(8, AHEAD, 0.01, &lit), 2);
    for angle in [-70.0f64, 0.0, 20.0, 47.0, 90.0, 110.0] {
        let found = mean(&behind(&image, &Analyzer::linear(angle)), 0).0;
        let plates = format!("{lit}{}", polarizer(angle, 1.0));
        let plate = mean(&rendered(&scene(8, AHEAD, 0.01, &plates), 2).0, 0).0;
        let turned = 2.0 * angle.to_radians();
        let passed = 0.5 * (angle - 20.0).to_radians().cos().powi(2);
        let expected = [1.0, turned.cos(), turned.sin(), 0.0].map(|x| x * passed);
        for k in 0..4 {
            assert!(
                (found[k] - expected[k]).abs() < ROUND_OFF,
                "{angle}: S{k} {found:?} {expected:?}"
            );
            assert!(
                (found[k] - plate[k]).abs() < ROUND_OFF,
                "{angle}: S{k} {found:?} {plate:?}"
            );
        }
    }
}

#[test]
fn circular_analyzers_tell_the_hands_apart() {
    for (left, rcp, lcp) in [("false", 0.5, 0.0), ("true", 0.0, 0.5)] {
        let bsdf =
            format!("<bsdf type='circular'><boolean name='left_handed' value='{left}'/></bsdf>");
        let (image, _) = rendered(
            &scene(8, AHEAD, 0.01, &format!("{LAMP}{}", plate(&bsdf, 0.0))),
            2,
        );
        for (analyzer, expected) in [
            (Analyzer::circular(false), rcp),
            (Analyzer::circular(true), lcp),
        ] {
            let found = mean(&behind(&image, &analyzer), 0).0;
            assert!(
                (found[0] - expected).abs() < ROUND_OFF,
                "{}: {found:?}",
                analyzer.name
            );
        }
    }
}

#[test]
fn a_horizontal_analyzer_turns_with_the_frames_of_a_wide_camera_as_a_plate_does() {
    let lit = format!("{LAMP}{}", polarizer(30.0, 0.0));
    let wide = |content: &str| film_scene(8, AHEAD, 80.0, [7, 5], content);
    let (image, _) = rendered(&wide(&lit), 1);
    let (plate, _) = rendered(&wide(&format!("{lit}{}", polarizer(0.0, 4.0))), 1);
    let found = behind(&image, &Analyzer::linear(0.0));
    for (found, expected) in found.stokes.iter().zip(&plate.stokes) {
        // the same rays: one sample each, of the same pixel
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
    // and it is no trivial claim: towards the corners the frames do turn
    let corner = image.stokes_at(0, 0, 0);
    let middle = image.stokes_at(3, 2, 0);
    assert!(
        (corner[1] - middle[1]).abs() > 0.005,
        "{corner:?} {middle:?}"
    );
}

/// A metal ball under a lamp: noisy, and polarized in every way.
fn ball(extra: &str) -> String {
    let content = format!(
        "<emitter type='constant'><float name='radiance' value='0.2'/></emitter>
         <shape type='rectangle'><transform name='to_world'><lookat origin='4, 3, 2' target='0, 0, 0' up='0, 1, 0'/></transform>
            <emitter type='area'><float name='radiance' value='5'/></emitter></shape>
         <shape type='sphere'><bsdf type='roughconductor'><float name='alpha' value='0.3'/>
            <spectrum name='eta' value='0.2'/><spectrum name='k' value='3'/></bsdf></shape>
         <shape type='sphere'><point name='center' x='1.2' y='-0.4' z='0.8'/><float name='radius' value='0.5'/><bsdf type='diffuse'/></shape>{extra}"
    );
    film_scene(
        5,
        "origin='0, 0, 500' target='0, 0, 0' up='0, 1, 0'",
        0.2,
        [12, 12],
        &content,
    )
}

#[test]
fn noise_behind_an_analyzer_is_that_behind_a_plate() {
    let (image, rendering) = rendered(&ball(""), 256);
    let light = Incident::new(&image, Some(&rendering)).unwrap();
    let finished = Incident::new(&image, None).unwrap();
    for angle in [0.0, 65.0] {
        let analyzer = Analyzer::linear(angle);
        let found = light.behind(&analyzer);
        let (plate, _) = rendered(&ball(&polarizer(angle, 400.0)), 256);
        let ((a, error_a), (b, error_b)) = (mean(&found, 0), mean(&plate, 0));
        for k in 0..4 {
            let limit = SIGMAS * error_a[k].hypot(error_b[k]) + ROUND_OFF;
            assert!(
                (a[k] - b[k]).abs() < limit,
                "{angle}: S{k} {a:?} {b:?} ± {limit}"
            );
        }
        // both are estimates from 144 pixels of 256 samples: 10 % is ten of their standard errors
        let noise = |image: &StokesImage| -> f64 {
            image
                .variance_plane(0, 0)
                .unwrap()
                .iter()
                .map(|v| f64::from(*v))
                .sum()
        };
        let (ours, theirs) = (noise(&found), noise(&plate));
        assert!(
            (ours / theirs - 1.0).abs() < 0.1,
            "{angle}: {ours} {theirs}"
        );
        // without covariances only a bound is known, and it is one
        let bound = finished.behind(&analyzer);
        assert_eq!(bound.stokes, found.stokes);
        for (bound, exact) in bound.variance.unwrap().iter().zip(found.variance.unwrap()) {
            assert!(*bound >= exact * (1.0 - 1e-5), "{bound} {exact}");
        }
    }
}

/// A folder with the ball's scene in it, in which the program runs.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("ball.xml"), ball("")).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program, checks its exit status, and returns what it says on standard error.
    fn run(&self, arguments: &str, status: i32) -> String {
        let output = brewster()
            .current_dir(self.0.path())
            .args(arguments.split_whitespace())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            output.status.code(),
            Some(status),
            "brewster {arguments}: {said}"
        );
        said
    }

    fn image(&self, name: &str) -> StokesImage {
        output::read(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    fn files(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// A quarter-wave plate, fast along image right.
const PLATE: &str = r#"{"mueller": [[1,0,0,0],[0,1,0,0],[0,0,0,1],[0,0,-1,0]]}"#;
const LIST: &str = "linear:30deg,rcp,plate.json,camera,mosaic";

#[test]
fn analyzers_at_render_time_and_afterwards_give_the_same_images() {
    let place = Place::new();
    fs::write(place.path("plate.json"), PLATE).unwrap();
    for (options, ending) in [
        ("", "exr"),
        ("--rgb", "exr"),
        ("--bands 450:650:2", "exr"),
        ("--rgb", "npy"),
    ] {
        place.run(
            &format!("render ball.xml --quiet --spp 8 {options} -o a.{ending} --analyzer {LIST}"),
            0,
        );
        place.run(&format!("maps a.{ending} -o later --analyzer {LIST}"), 0);
        for name in [
            "linear30",
            "rcp",
            "plate",
            "camera000",
            "camera045",
            "camera090",
            "camera135",
            "mosaic",
        ] {
            let [now, later] =
                ["", "later/"].map(|f| place.image(&format!("{f}a.{name}.{ending}")));
            assert_eq!(now.stokes, later.stokes, "{options} {name}");
            assert_eq!(
                now.components,
                if name.starts_with(['c', 'm']) { 1 } else { 4 }
            );
            assert_eq!(now.variance.is_some(), ending == "exr");
            if ending == "exr" {
                assert_eq!(now.colour, later.colour);
                let pairs = now
                    .variance
                    .unwrap()
                    .into_iter()
                    .zip(later.variance.unwrap());
                let (mut exact, mut bound) = (0.0, 0.0);
                for (a, b) in pairs {
                    assert!(a <= b * (1.0 + 1e-5), "{options} {name}: {a} {b}");
                    (exact, bound) = (exact + a, bound + b);
                }
                // the ball makes linear light alone: only there the components' noises are related
                assert!(
                    exact < bound || !name.starts_with("linear"),
                    "{options} {name}: {exact} {bound}"
                );
                assert!(later.metadata["analyzerVariance"].starts_with("upper bound"));
                assert!(now.metadata["analyzerVariance"].starts_with("of the samples"));
            }
        }
        let before = place.image(&format!("a.{ending}"));
        let plate = place.image(&format!("a.plate.{ending}"));
        let [s0, s1, s2, s3] = before.stokes_at(4, 7, 0);
        assert_eq!(plate.stokes_at(4, 7, 0), [s0, s1, s3, -s2]);
    }
}

#[test]
fn the_frames_of_a_polarization_camera_hold_the_linear_stokes_parameters() {
    let place = Place::new();
    place.run(
        "render ball.xml --quiet --spp 8 --size 13x11 -o a.exr --analyzer mosaic,camera",
        0,
    );
    let image = place.image("a.exr");
    let frames =
        ["000", "045", "090", "135"].map(|angle| place.image(&format!("a.camera{angle}.exr")));
    let mosaic = place.image("a.mosaic.exr");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(place.path("a_analyzers.json")).unwrap()).unwrap();
    let white = report["white"].as_f64().unwrap();
    let levels = |name: &str| -> Vec<u16> {
        let decoder = png::Decoder::new(std::io::BufReader::new(
            fs::File::open(place.path(name)).unwrap(),
        ));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(
            (info.color_type, info.bit_depth),
            (png::ColorType::Grayscale, png::BitDepth::Sixteen)
        );
        bytes
            .chunks_exact(2)
            .map(|b| u16::from_be_bytes([b[0], b[1]]))
            .collect()
    };
    let raw = levels("a.mosaic.png");
    assert!(
        levels("a.camera090.png")
            .iter()
            .zip(frames[2].plane(0, 0))
            .all(|(&level, value)| {
                (f64::from(level) - 65535.0 * f64::from(value) / white).abs() < 0.51
            })
    );
    for y in 0..11 {
        for x in 0..13 {
            let [s0, s1, s2, _] = image.stokes_at(x, y, 0);
            let i = frames.each_ref().map(|frame| frame.stokes_at(x, y, 0)[0]);
            // sums of three numbers in single precision
            let round_off = 4e-7 * s0;
            for (found, expected) in [
                (i[0] + i[2], s0),
                (i[1] + i[3], s0),
                (i[0] - i[2], s1),
                (i[1] - i[3], s2),
            ] {
                assert!(
                    (found - expected).abs() <= round_off,
                    "({x}, {y}): {found} {expected}"
                );
            }
            // seen from the front: 90 45 over 135 0
            let angle = [[2, 1], [3, 0]][y % 2][x % 2];
            let found = mosaic.stokes_at(x, y, 0)[0];
            assert_eq!(found, i[angle], "({x}, {y})");
            let level = f64::from(raw[y * 13 + x]);
            assert!(
                (level - 65535.0 * found / white).abs() < 0.51,
                "({x}, {y}): {level}"
            );
        }
    }
}

#[test]
fn images_of_mitsuba_are_analyzed_too() {
    let place = Place::new();
    place.run(
        "render ball.xml --quiet --spp 4 --mitsuba-channels -o a.exr --analyzer lcp",
        0,
    );
    let said = place.run("maps a.exr -o later --analyzer lcp --maps dop", 0);
    assert_eq!(said, "");
    let (now, later) = (place.image("a.lcp.exr"), place.image("later/a.lcp.exr"));
    assert_eq!(now.stokes, later.stokes);
    assert!(later.variance.is_none());
    assert_eq!(
        place.files("later"),
        [
            "a.lcp.exr",
            "a.lcp_maps.json",
            "a.lcp_s0.png",
            "a_analyzers.json",
            "a_dop.png",
            "a_maps.json"
        ]
    );
}

#[test]
fn what_is_no_analyzer_is_refused_before_any_work() {
    let place = Place::new();
    fs::write(
        place.path("flip.json"),
        "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,-1]]",
    )
    .unwrap();
    fs::write(
        place.path("hot.json"),
        "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,2]]",
    )
    .unwrap();
    place.run(
        "render ball.xml --quiet --spp 1 --unpolarized -o grey.exr",
        0,
    );
    let before = place.files(".");
    for (arguments, expected) in [
        (
            "render ball.xml --analyzer rpc",
            "--analyzer: unknown analyzer 'rpc', expected linear:ANGLE such as linear:30deg",
        ),
        (
            "render ball.xml --analyzer linear:up",
            "such as linear:30deg",
        ),
        (
            "render ball.xml --analyzer rcp,rcp",
            "'rcp' for the second time",
        ),
        (
            "render ball.xml --analyzer none.json",
            "none.json: cannot be read",
        ),
        (
            "render ball.xml --analyzer flip.json",
            "flip.json: not realizable: its coherency matrix has the eigenvalue -5.000e-1",
        ),
        (
            "render ball.xml --analyzer rcp --unpolarized",
            "cannot be used with",
        ),
        ("maps grey.exr --analyzer rcp", "needs S1 to S3"),
        (
            "maps grey.exr --analyzer rcp --maps dip",
            "unknown map 'dip'",
        ),
    ] {
        let said = place.run(arguments, 2);
        assert!(said.contains(expected), "brewster {arguments}: {said}");
    }
    assert_eq!(place.files("."), before, "nothing is written");
    let said = place.run("render ball.xml --spp 1 --analyzer hot.json", 0);
    assert!(
        said.contains("notice: hot.json: amplifies some light"),
        "{said}"
    );
}
