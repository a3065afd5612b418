//! Claim: the program does what its options say, and its exit status tells how it went.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use brewster_tests::brewster;
use render::output;

/// A metal ball in front of a polarizer, in a light that fades from red to blue; near_clip makes a notice.
const SCENE: &str = "<scene version='3.0.0'>
    <default name='spp' value='4'/>
    <integrator type='path'><integer name='max_depth' value='4'/></integrator>
    <sensor type='perspective'>
        <float name='fov' value='40'/><float name='near_clip' value='0.1'/>
        <transform name='to_world'><lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/></transform>
        <sampler type='independent'><integer name='sample_count' value='$spp'/></sampler>
        <film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='12'/></film>
    </sensor>
    <emitter type='constant'><spectrum name='radiance' value='360:0.5, 830:1'/></emitter>
    <shape type='sphere'><bsdf type='roughconductor'><spectrum name='eta' value='0.2'/><spectrum name='k' value='3'/></bsdf></shape>
    <shape type='rectangle'><transform name='to_world'><translate x='0.5' z='2'/></transform><bsdf type='polarizer'/></shape>
</scene>";

/// A folder with the scene in it, in which the program runs.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.xml"), SCENE).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = brewster();
        command
            .current_dir(self.0.path())
            .args(arguments.split_whitespace());
        command
    }

    /// Runs the program and checks its exit status.
    fn run(&self, arguments: &str, status: i32) -> Output {
        let output = self.command(arguments).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(status),
            "brewster {arguments}: {error}"
        );
        assert!(!error.contains("panicked"), "brewster {arguments}: {error}");
        output
    }

    /// Runs the program, which must refuse, and returns what it says.
    fn refused(&self, arguments: &str, status: i32) -> String {
        String::from_utf8(self.run(arguments, status).stderr).unwrap()
    }

    /// Runs the program with `--json` and returns the line.
    fn json(&self, arguments: &str) -> serde_json::Value {
        let output = self.run(&format!("{arguments} --quiet --json"), 0);
        assert!(
            output.stderr.is_empty(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.lines().count(), 1, "{text}");
        serde_json::from_str(&text).unwrap()
    }

    fn files(&self) -> Vec<String> {
        let names = fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }
}

/// Names of the channels of an EXR file, from its header: pairs of name and 16 bytes after `channels`, `chlist`, size.
fn channels(path: &Path) -> Vec<String> {
    let bytes = fs::read(path).unwrap();
    let key = b"channels\0chlist\0";
    let start = bytes.windows(key.len()).position(|w| w == key).unwrap() + key.len() + 4;
    let mut rest = &bytes[start..];
    let mut names = Vec::new();
    while rest[0] != 0 {
        let end = rest.iter().position(|&b| b == 0).unwrap();
        names.push(String::from_utf8(rest[..end].to_vec()).unwrap());
        rest = &rest[end + 17..];
    }
    names
}

fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
    words.sort();
    words
}

#[test]
fn help_goes_to_standard_output() {
    let place = Place::new();
    for (arguments, word) in [
        ("--help", "render"),
        ("render --help", "--target-error"),
        ("maps --help", "--threshold"),
        ("compare --help", "--max-rmse"),
        ("inspect --help", "scene"),
        ("eval --help", "--f32"),
        ("--version", "brewster"),
    ] {
        let output = place.run(arguments, 0);
        assert!(
            String::from_utf8(output.stdout).unwrap().contains(word),
            "{arguments}"
        );
        assert!(output.stderr.is_empty(), "{arguments}");
    }
}

#[test]
fn wrong_options_exit_with_2_and_say_what_was_expected() {
    let place = Place::new();
    for (arguments, expected) in [
        ("", "Usage"),
        ("rendre scene.xml", "rendre"),
        ("render", "SCENE"),
        ("render scene.xml --frob", "--frob"),
        ("render scene.xml --spp 0", "--spp"),
        ("render scene.xml --spp many", "--spp"),
        ("render scene.xml --seed -1", "-1"),
        ("render scene.xml --size 0x4", "such as 640x480"),
        ("render scene.xml --crop 1,2,3", "such as 100,50,64,64"),
        (
            "render scene.xml --crop 10,10,10,10",
            "expected a window within 16x12",
        ),
        (
            "render scene.xml --crop 4294967295,0,2,2",
            "expected a window within 16x12",
        ),
        (
            "render scene.xml --size 65536x65536",
            "GiB, expected at most",
        ),
        ("render scene.xml --wavelength green", "such as 550nm"),
        (
            "render scene.xml --wavelength 500nm --rgb",
            "cannot be used with",
        ),
        (
            "render scene.xml --rgb --bands 400:700:3",
            "cannot be used with",
        ),
        ("render scene.xml --bands 700:400:3", "FROM < TO"),
        ("render scene.xml --time never", "such as 60s"),
        ("render scene.xml --target-error -1", "-1"),
        ("render scene.xml --target-error S4=0.1", "S0=0.01,S3=0.002"),
        (
            "render scene.xml --target-error S1=0.1,S1=0.2",
            "S0=0.01,S3=0.002",
        ),
        (
            "render scene.xml --target-error S0=0.1,S1=0.1 --unpolarized",
            "S1 is not rendered with --unpolarized",
        ),
        ("render scene.xml --threads 0", "--threads"),
        ("render scene.xml --sampler sobel", "independent"),
        ("render scene.xml -D spp", "NAME=VALUE"),
        (
            "render scene.xml -o image.png",
            "expected a name in .exr or .npy",
        ),
        ("render scene.xml --maps s0,dip", "dip"),
        ("render none.xml", "none.xml: no such file"),
        ("maps none.exr", "none.exr"),
        ("maps scene.xml", "scene.xml"),
        ("compare none.exr none.exr", "none.exr"),
        ("inspect none.xml", "none.xml: no such file"),
        ("eval none.json", "none.json: cannot be read"),
        ("eval", "CASES"),
    ] {
        let said = place.refused(arguments, 2);
        assert!(said.contains(expected), "brewster {arguments}: {said}");
    }
    assert_eq!(place.files(), ["scene.xml"], "nothing is written");
}

#[test]
fn channels_follow_the_options() {
    let place = Place::new();
    let mono = "S0 S1 S2 S3 S0.var S1.var S2.var S3.var R G B";
    let coloured = |prefix: &str| {
        (0..4)
            .map(|k| {
                ["R", "G", "B"]
                    .map(|c| format!(" S{k}{prefix}.{c}"))
                    .concat()
            })
            .collect::<String>()
    };
    for (options, expected) in [
        ("", mono.to_owned()),
        ("--wavelength 633nm", mono.to_owned()),
        ("--unpolarized", "S0 S0.var R G B".to_owned()),
        (
            "--rgb",
            format!("{}{} R G B", coloured(""), coloured(".var")),
        ),
        ("--mitsuba-channels", format!("{} Y", coloured(""))),
        (
            "--mitsuba-channels --rgb",
            format!("{} R G B", coloured("")),
        ),
    ] {
        place.run(&format!("render scene.xml -o a.exr --quiet {options}"), 0);
        let mut found = channels(&place.path("a.exr"));
        found.sort();
        assert_eq!(found, words(&expected), "{options}");
        let image = output::read(&place.path("a.exr")).unwrap();
        assert_eq!((image.width, image.height), (16, 12));
        assert!(image.stokes.iter().all(|v| v.is_finite()));
    }
    place.run("render scene.xml -o a.exr --quiet --bands 400:700:3", 0);
    let found = channels(&place.path("a.exr"));
    for name in ["S0.450,000000nm", "S3.650,000000nm"] {
        assert!(found.iter().any(|c| c == name), "{found:?}");
    }
}

#[test]
fn one_sample_has_no_variance() {
    let place = Place::new();
    place.run("render scene.xml --spp 1", 0);
    let mut found = channels(&place.path("scene.exr"));
    found.sort();
    assert_eq!(found, words("S0 S1 S2 S3 R G B"));
}

#[test]
fn arrays_have_the_shape_that_the_readme_states() {
    let place = Place::new();
    for (options, shape) in [
        ("", vec![12, 16, 4]),
        ("--rgb", vec![12, 16, 3, 4]),
        ("--bands 400:700:5", vec![12, 16, 5, 4]),
    ] {
        place.run(&format!("render scene.xml -o a.npy --quiet {options}"), 0);
        let bytes = fs::read(place.path("a.npy")).unwrap();
        let array = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(array.shape(), shape, "{options}");
        let numbers: Vec<f32> = array.into_vec().unwrap();
        assert!(numbers.iter().all(|v| v.is_finite()) && numbers[0] > 0.0);
    }
}

#[test]
fn the_size_and_the_window_of_the_film_can_be_chosen() {
    let place = Place::new();
    place.run("render scene.xml --quiet --size 20x10 -o whole.exr", 0);
    place.run(
        "render scene.xml --quiet --size 20x10 --crop 5,2,8,6 -o crop.exr",
        0,
    );
    let [whole, crop] =
        ["whole.exr", "crop.exr"].map(|name| output::read(&place.path(name)).unwrap());
    assert_eq!(
        (whole.width, whole.height, crop.width, crop.height),
        (20, 10, 8, 6)
    );
    assert_eq!(whole.stokes_at(9, 4, 0), crop.stokes_at(4, 2, 0));
}

#[test]
fn a_rendering_stops_in_time() {
    let place = Place::new();
    let start = Instant::now();
    let line = place.json("render scene.xml --spp 1000000000000 --time 1s");
    assert!(line["samples"].as_u64().unwrap() < 1_000_000_000_000);
    let sampling = line["sampling_wall_s"].as_f64().unwrap();
    // passes last at most half a second, or a single sample on a busy machine
    assert!(
        (0.9..6.0).contains(&sampling) && start.elapsed() < Duration::from_secs(60),
        "{line}"
    );
    assert_eq!(line["interrupted"], false);
}

#[test]
fn a_rendering_stops_at_the_error_that_is_asked_for() {
    let place = Place::new();
    let errors = |line: &serde_json::Value| -> Vec<f64> {
        let list = line["errors"].as_array().unwrap();
        list.iter().map(|e| e.as_f64().unwrap()).collect()
    };
    let run = |options: &str| place.json(&format!("render scene.xml {options}"));
    // the scene's own 4 samples are no limit
    let all = run("--target-error 0.003");
    let samples = all["samples"].as_u64().unwrap();
    assert!(errors(&all).iter().all(|e| *e <= 0.003), "{all}");
    assert!(samples > 4 && samples < 1_000_000, "{all}");
    // S2 is weak here: it alone is known sooner, the others are not
    let some = run("--target-error S2=0.003");
    let found = errors(&some);
    assert!(found[2] <= 0.003 && found[0] > 0.003, "{some}");
    assert!(some["samples"].as_u64() < all["samples"].as_u64(), "{some}");
    // a limit stays a limit, but for rounding of each pixel to blocks
    let limited = run("--target-error 1e-9 --spp 100");
    assert!(
        (98..=102).contains(&limited["samples"].as_u64().unwrap()),
        "{limited}"
    );
    assert_eq!(
        run("--target-error S0=0.1 --unpolarized")["errors"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
}

#[test]
fn the_error_that_is_asked_for_makes_the_same_image_on_any_number_of_threads() {
    let place = Place::new();
    for threads in ["1", "2", "5"] {
        place.run(
            &format!(
                "render scene.xml --quiet --target-error 0.003 --threads {threads} -o {threads}.npy"
            ),
            0,
        );
    }
    let [a, b, c] = ["1.npy", "2.npy", "5.npy"].map(|name| fs::read(place.path(name)).unwrap());
    assert!(a == b && a == c);
}

#[test]
fn samples_go_where_the_noise_is() {
    let place = Place::new();
    place.run(
        "render scene.xml --quiet --size 32x24 --spp 256 --adaptive -o a.exr",
        0,
    );
    let image = output::read(&place.path("a.exr")).unwrap();
    let samples = image.samples.as_ref().unwrap();
    let mean = samples.iter().sum::<u64>() as f64 / samples.len() as f64;
    // numbers are rounded to an eighth at most, each by chance
    assert!((mean / 256.0 - 1.0).abs() < 0.02, "{mean}");
    assert_eq!(image.metadata["samples"], format!("{mean:.0}"));
    assert!(image.blocks().unwrap() >= 4);
    let (few, many) = (samples.iter().min().unwrap(), samples.iter().max().unwrap());
    assert!(*few >= 64 && *many > 2 * few, "{few} {many}");
    // the error is what spreading is for
    let error = |options: &str| {
        let line = place.json(&format!(
            "render scene.xml --size 32x24 --spp 256 {options}"
        ));
        line["error"].as_f64().unwrap()
    };
    assert!(error("--adaptive") < error(""));
    // without it there is nothing to tell
    place.run("render scene.xml --quiet -o b.exr", 0);
    assert!(
        output::read(&place.path("b.exr"))
            .unwrap()
            .samples
            .is_none()
    );
}

#[test]
fn the_line_of_numbers_is_complete() {
    let place = Place::new();
    let line = place.json("render scene.xml --threads 2 --seed 9");
    assert_eq!(
        (&line["samples"], &line["threads"], &line["rejected"]),
        (&4.into(), &2.into(), &0.into())
    );
    assert_eq!(line["paths"], 16 * 12 * 4);
    for name in [
        "rays",
        "paths_per_s",
        "rays_per_s",
        "sampling_wall_s",
        "sampling_cpu_s",
        "wall_s",
        "total_cpu_s",
        "error",
    ] {
        assert!(line[name].as_f64().unwrap() > 0.0, "{name}: {line}");
    }
}

#[test]
fn names_in_the_scene_are_filled_from_the_command_line() {
    let place = Place::new();
    assert_eq!(place.json("render scene.xml -D spp=7")["samples"], 7);
    assert_eq!(
        place.json("render scene.xml -D spp=7 --spp 3")["samples"],
        3
    );
    assert!(
        place
            .refused("render scene.xml -D sp=7", 2)
            .contains("'-D sp' has no effect")
    );
    assert!(
        place
            .refused("render scene.xml -D spp=x", 2)
            .contains("expected an integer")
    );
}

#[test]
fn the_same_seed_gives_the_same_file_for_any_number_of_threads() {
    let place = Place::new();
    for (name, options) in [
        ("a", "--threads 1"),
        ("b", "--threads 3"),
        ("c", "--seed 5"),
    ] {
        place.run(
            &format!("render scene.xml -o {name}.npy --quiet {options}"),
            0,
        );
    }
    let [a, b, c] = ["a.npy", "b.npy", "c.npy"].map(|name| fs::read(place.path(name)).unwrap());
    assert!(a == b && a != c);
}

#[test]
fn what_cannot_be_written_exits_with_1_and_leaves_nothing() {
    let place = Place::new();
    fs::create_dir(place.path("folder.exr")).unwrap();
    for output in ["folder.exr", "scene.xml/a.exr"] {
        let said = place.refused(&format!("render scene.xml --quiet -o {output}"), 1);
        assert!(said.contains(output.split('/').next().unwrap()), "{said}");
    }
    assert_eq!(place.files(), ["folder.exr", "scene.xml"]);
    assert_eq!(fs::read_dir(place.path("folder.exr")).unwrap().count(), 0);
}

#[test]
#[cfg(unix)]
fn an_interrupted_rendering_writes_what_there_is() {
    let place = Place::new();
    let mut child = place
        .command("render scene.xml --spp 1000000000000 --time 60s --json -o a.exr")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // the notice is given just before work begins
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut notice = String::new();
    stderr.read_line(&mut notice).unwrap();
    assert!(notice.contains("near_clip"), "{notice}");
    std::thread::sleep(Duration::from_secs(1));
    assert!(
        Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap()
            .success()
    );
    let finished = child.wait_with_output().unwrap();
    assert_eq!(finished.status.code(), Some(0));
    let line: serde_json::Value = serde_json::from_slice(&finished.stdout).unwrap();
    assert_eq!(line["interrupted"], true);
    let image = output::read(&place.path("a.exr")).unwrap();
    assert_eq!(image.metadata["samples"], line["samples"].to_string());
    assert!(image.stokes.iter().all(|v| v.is_finite()) && image.value(0, 0, 0, 0) > 0.0);
}

#[test]
fn pictures_come_with_the_image_or_later() {
    let place = Place::new();
    place.run(
        "render scene.xml --quiet --maps dop,ellipses -o out/a.exr",
        0,
    );
    let with: Vec<_> = fs::read_dir(place.path("out"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert!(
        with.iter()
            .any(|p| p.extension().is_some_and(|e| e == "svg")),
        "{with:?}"
    );
    let said = place.run("maps out/a.exr -o pictures", 0);
    let files = String::from_utf8(said.stdout).unwrap();
    assert!(files.lines().count() >= 12, "{files}");
    for file in files.lines() {
        assert!(
            fs::metadata(place.path(file)).unwrap().len() > 100,
            "{file}"
        );
    }
}

#[test]
fn an_image_equals_itself_and_not_another() {
    let place = Place::new();
    place.run("render scene.xml --quiet -o a.exr", 0);
    place.run("render scene.xml --quiet -o b.exr --seed 2", 0);
    place.run(
        "compare a.exr a.exr --max-rmse 0 --max-bias 0 --max-abs 0",
        0,
    );
    place.run("compare a.exr b.exr", 0);
    place.run("compare a.exr b.exr --max-rmse 1e-9", 1);
    // two renders of one scene differ by noise only
    place.run("compare a.exr b.exr --max-bias-t 5 --block 4", 0);
}

#[test]
fn inspect_tells_what_can_be_polarized() {
    let place = Place::new();
    let text = String::from_utf8(place.run("inspect scene.xml", 0).stdout).unwrap();
    for word in ["polarizer", "roughconductor", "S3"] {
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn explain_says_what_is_skipped_and_because_of_whom() {
    let place = Place::new();
    let output = place.run("render scene.xml --quiet --explain -o a.exr", 0);
    let text = String::from_utf8(output.stderr).unwrap();
    for line in [
        "kept     S1, S2: roughconductor (scene.xml:11:",
        "kept     flat elements on the way to emitters: polarizer (scene.xml:12:",
        "skipped  coherence of the light on matter: no matter answers to it",
        "skipped  all wavelengths but one: 550 nm is asked for",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    place.run("render scene.xml --quiet --no-skip -o b.exr", 0);
    place.run(
        "compare a.exr b.exr --max-rmse 1e-6 --max-bias 1e-6 --max-abs 1e-6",
        0,
    );
    // and beforehand
    let text = String::from_utf8(place.run("inspect scene.xml --rgb", 0).stdout).unwrap();
    for line in [
        "polarizes linearly, lets light straight through",
        "kept        wavelengths: emitter constant (scene.xml:10:",
        "skipped     a path for each wavelength: no matter sends them different ways",
    ] {
        assert!(text.contains(line), "{line}: {text}");
        // without the polarizer nothing lets light straight through
        let opaque = SCENE.replace("'polarizer'", "'diffuse'");
        fs::write(place.path("opaque.xml"), opaque).unwrap();
        let output = place.run("render opaque.xml --quiet --explain --no-skip -o c.exr", 0);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(
            text.contains("straight through; followed all the same (--no-skip)"),
            "{text}"
        );
    }
}
