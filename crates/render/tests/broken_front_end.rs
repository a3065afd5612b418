//! Claim: no scene file and no mesh, however broken, makes the front end panic or hang; what it refuses it places.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use render::scene::{Document, Object, SceneError, mesh, read, read_text};
use render::spectrum::SpectrumUse;

#[path = "broken/cases.rs"]
mod cases;
use cases::{BROKEN, BROKEN_INSIDE, BROKEN_OBJ, BROKEN_USE, OBJ, VALID, bombs, inside};

/// A folder with the valid scene and its files.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("a file in the temporary folder");
    };
    fs::create_dir(folder.path().join("parts")).expect("a folder in the temporary folder");
    write("scene.xml", VALID);
    write(
        "light.xml",
        "<emitter type='constant' version='3.0.0'><float name='radiance' value='1'/></emitter>",
    );
    write("parts/a.obj", OBJ);
    write("parts/a.spd", "400 0.1\n700 0.9\n");
    folder
}

/// Asks an object for parameters of every type, as plugins do, and returns the first refusal.
fn use_object(object: &Object) -> Result<(), SceneError> {
    let mut outcomes = vec![
        object.float("alpha", 0.1).map(|_| ()),
        object.required_float("fov").map(|_| ()),
        object.integer("sample_count", 1).map(|_| ()),
        object.boolean("face_normals", false).map(|_| ()),
        object
            .choice("distribution", "ggx", &["beckmann", "ggx"])
            .map(|_| ()),
        object.optional_point("p").map(|_| ()),
        object.optional_vector("v").map(|_| ()),
        object.transform("to_world").map(|_| ()),
        object.path("filename").map(|_| ()),
        object.named_child("texture").map(|_| ()),
    ];
    for name in ["s", "t", "reflectance"] {
        let spectrum = object.optional_spectrum(name, SpectrumUse::Reflectance);
        outcomes.push(spectrum.map(|_| ()));
    }
    object.without_effect(&["near_clip"]);
    outcomes.push(object.finish());
    outcomes.into_iter().collect()
}

/// Uses every object of a scene and returns the first refusal.
fn use_document(document: &Document) -> Result<(), SceneError> {
    use render::scene::Tag::*;
    let tags = [
        Bsdf, Shape, Emitter, Sensor, Film, Rfilter, Sampler, Integrator, Texture,
    ];
    let mut waiting = vec![document.root.clone()];
    let mut first = Ok(());
    while let Some(object) = waiting.pop() {
        waiting.extend(tags.iter().flat_map(|&tag| object.children(tag)));
        first = first.and(use_object(&object));
    }
    first
}

/// Every refusal starts with its file, and says nothing in Rust's words.
fn check_words(error: &SceneError) {
    let text = error.to_string();
    let file = error.position.file.display().to_string();
    assert!(text.starts_with(&file), "{text}");
    for word in [
        "Option",
        "Some(",
        "Err(",
        "f64",
        "i64",
        "usize",
        "Utf8Error",
        "os error",
    ] {
        assert!(!text.contains(word), "{text}");
    }
    assert!(!text.ends_with('.'), "{text}");
    assert!(text.len() < 700, "{} bytes: {text}", text.len());
}

/// Checks one case of a table; an `expected` that starts with a digit must start right after the file name.
fn refusal(outcome: Result<(), SceneError>, name: &str, expected: &str) {
    let error = outcome.err().unwrap_or_else(|| panic!("{name}: accepted"));
    check_words(&error);
    assert!(error.position.line > 0, "{name}: no line in '{error}'");
    let text = error.to_string();
    let file = format!("{}:", error.position.file.display());
    let found = if expected.starts_with(|c: char| c.is_ascii_digit()) {
        text[file.len()..].starts_with(expected)
    } else {
        text.contains(expected)
    };
    assert!(found, "{name}:\n  found    {text}\n  expected {expected}");
}

#[test]
fn the_valid_scene_is_read() {
    let folder = folder();
    let document = read(&folder.path().join("scene.xml"), &[]).unwrap();
    assert_eq!(document.notices(), [""; 0]);
    let mesh = mesh::load_obj(&folder.path().join("parts/a.obj"), true).unwrap();
    assert_eq!(mesh.triangles.len(), 3);
}

#[test]
fn broken_scenes_are_refused_in_words_and_with_a_place() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    for (name, text, expected) in BROKEN {
        refusal(read_text(text, &path, &[]).map(|_| ()), name, expected);
    }
    for (name, text, expected) in BROKEN_INSIDE {
        let outcome = read_text(&inside(text), &path, &[]);
        refusal(outcome.map(|_| ()), name, expected);
    }
}

#[test]
fn broken_parameters_are_refused_when_they_are_used() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    for (name, text, expected) in BROKEN_USE {
        let text = inside(&format!("<bsdf type='a'>\n{text}</bsdf>"));
        let document = read_text(&text, &path, &[]).unwrap();
        refusal(use_object(&document.definitions()[0]), name, expected);
    }
}

#[test]
fn scenes_made_to_exhaust_the_reader_are_refused_within_seconds() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    for (name, text, expected) in bombs() {
        let start = Instant::now();
        refusal(read_text(&text, &path, &[]).map(|_| ()), name, expected);
        let taken = start.elapsed();
        assert!(taken < Duration::from_secs(10), "{name} took {taken:?}");
    }
}

#[test]
fn includes_neither_circle_nor_multiply() {
    let folder = folder();
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), inside(text)).unwrap();
    };
    write("a.xml", "<include filename='b.xml'/>");
    write("b.xml", "<include filename='./parts/../a.xml'/>");
    for level in 0..12 {
        let line = format!("<include filename='level{}.xml'/>", level + 1);
        write(&format!("level{level}.xml"), &line.repeat(4));
    }
    write("level12.xml", "");
    for level in 0..30 {
        let line = format!("<include filename='deep{}.xml'/>", level + 1);
        write(&format!("deep{level}.xml"), &line);
    }
    for (name, expected) in [
        (
            "a.xml",
            "b.xml:2:10: file './parts/../a.xml' includes itself, expected no circle of includes",
        ),
        (
            "level0.xml",
            "too many includes, expected at most 1000, at most 15 within each other",
        ),
        (
            "deep0.xml",
            "deep15.xml:2:10: too many includes, expected at most 1000",
        ),
    ] {
        let error = read(&folder.path().join(name), &[]).unwrap_err();
        check_words(&error);
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn broken_meshes_are_refused_with_their_line() {
    let folder = folder();
    let path = folder.path().join("a.obj");
    for (name, text, expected) in BROKEN_OBJ {
        fs::write(&path, text).unwrap();
        let outcome = mesh::load_obj(&path, true);
        refusal(outcome.map(|_| ()), name, expected);
    }
}

#[test]
fn what_is_no_text_file_is_refused() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| fs::write(path(name), bytes).unwrap();
    write(
        "latin.xml",
        b"<scene version='3.0.0'>\n  <!-- caf\xe9 --></scene>",
    );
    write("utf16.xml", b"\xff\xfe<\0s\0");
    write("binary.obj", b"v 0 0 0\n\x80\xff\x00");
    let check = |error: SceneError, expected: &str| {
        check_words(&error);
        assert!(error.to_string().ends_with(expected), "{error}");
    };
    for (name, expected) in [
        ("none.xml", "none.xml: no such file"),
        ("parts", "parts: is a directory, expected a file"),
        (
            "latin.xml",
            "latin.xml:2:11: the text is not UTF-8, save the file in that encoding",
        ),
        (
            "utf16.xml",
            "utf16.xml:1:1: the text is not UTF-8, save the file in that encoding",
        ),
    ] {
        check(read(&path(name), &[]).unwrap_err(), expected);
    }
    for (name, expected) in [
        ("none.obj", "none.obj: no such file"),
        ("parts", "parts: is a directory, expected a file"),
        (
            "binary.obj",
            "binary.obj:2: the line is not text, expected an OBJ file",
        ),
    ] {
        check(mesh::load_obj(&path(name), true).unwrap_err(), expected);
    }
    if cfg!(target_os = "linux") {
        let error = read(Path::new("/dev/zero"), &[]).unwrap_err();
        check(error, "/dev/zero: is a device or a pipe, expected a file");
    }
}

#[test]
fn a_byte_order_mark_is_tolerated() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    assert!(read_text(&format!("\u{feff}{VALID}"), &path, &[]).is_ok());
}

#[test]
fn the_command_line_must_fit_the_scene() {
    let folder = folder();
    let given = |pairs: &[(&str, &str)]| {
        let own = |&(n, v): &(&str, &str)| (n.to_owned(), v.to_owned());
        let pairs: Vec<_> = pairs.iter().map(own).collect();
        read(&folder.path().join("scene.xml"), &pairs)
    };
    assert!(given(&[("spp", "1")]).is_ok());
    for (pairs, expected) in [
        (
            &[("sp", "1")][..],
            "scene.xml: '-D sp' has no effect, the scene has no '$sp', did you mean 'spp'?",
        ),
        (
            &[("spp", "1"), ("spp", "2")],
            "scene.xml: '-D spp' is given twice, expected one value",
        ),
        (
            &[("", "1")],
            "scene.xml: '-D =1' has no usable name, expected -D NAME=VALUE",
        ),
        (
            &[("spp", "many")],
            "scene.xml:13:66: attribute 'value' of integer 'sample_count' is 'many', expected an integer",
        ),
    ] {
        let error = given(pairs).unwrap_err();
        check_words(&error);
        assert!(error.to_string().ends_with(expected), "{error}");
    }
}

#[test]
fn a_scene_cut_off_anywhere_is_refused() {
    let folder = folder();
    let path = folder.path().join("scene.xml");
    for length in 0..VALID.trim_end().len() {
        let text = String::from_utf8_lossy(&VALID.as_bytes()[..length]).into_owned();
        let error = read_text(&text, &path, &[]).expect_err("a part of a scene");
        check_words(&error);
        assert!(error.position.line > 0, "{length}: {error}");
    }
}

#[test]
fn no_byte_put_anywhere_makes_a_panic() {
    let folder = folder();
    let swaps: [&[u8]; 7] = [b"<", b"\"", b"&", b"$", b"-", b"9e9", b"\0"];
    let swap = |text: &str, at: usize, bytes: &[u8]| {
        [&text.as_bytes()[..at], bytes, &text.as_bytes()[at + 1..]].concat()
    };
    let check = |at: usize, outcome: &dyn Fn() -> Result<(), SceneError>| match catch_unwind(
        AssertUnwindSafe(outcome),
    ) {
        Ok(outcome) => outcome.unwrap_or_else(|error| check_words(&error)),
        Err(_) => panic!("a change of byte {at}"),
    };
    let path = folder.path().join("scene.xml");
    for (at, bytes) in (0..VALID.len()).zip(swaps.iter().cycle()) {
        let text = String::from_utf8_lossy(&swap(VALID, at, bytes)).into_owned();
        check(at, &|| use_document(&read_text(&text, &path, &[])?));
    }
    let path = folder.path().join("a.obj");
    for (at, bytes) in (0..OBJ.len()).zip(swaps.iter().cycle()) {
        for text in [swap(OBJ, at, bytes), OBJ.as_bytes()[..at].to_vec()] {
            fs::write(&path, text).unwrap();
            check(at, &|| {
                mesh::load_obj(&path, true).map(|mesh| drop(mesh::vertex_normals(&mesh)))
            });
        }
    }
}
