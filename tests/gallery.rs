//! Claim: every plugin is documented, and every scene that the documentation shows can be rendered.

use std::path::{Path, PathBuf};

use brewster_tests::{Shot, repository};
use render::film::SpectralMode;
use render::scene::{Tag, plugins, read};

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    found.sort();
    found
}

#[test]
fn every_plugin_stands_in_the_table_of_plugins() {
    let text = std::fs::read_to_string(repository().join("docs/scenes.md")).expect("the document");
    for tag in [
        Tag::Bsdf,
        Tag::Shape,
        Tag::Emitter,
        Tag::Sensor,
        Tag::Integrator,
    ] {
        for name in plugins::supported(tag) {
            assert!(
                text.contains(&format!("`{name}`")),
                "docs/scenes.md does not name {name}"
            );
        }
    }
}

#[test]
fn scenes_of_the_gallery_render_and_have_their_pictures() {
    let gallery = repository().join("docs/gallery");
    let scenes = files(&gallery, "xml");
    assert!(!scenes.is_empty(), "no scene in docs/gallery");
    for path in scenes {
        assert!(
            path.with_extension("png").is_file(),
            "{} has no picture beside it",
            path.display()
        );
        let text = std::fs::read_to_string(&path).expect("a text");
        assert!(
            text.contains("brewster render docs/gallery/"),
            "{} does not say how its picture is made",
            path.display()
        );
        let document = read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let shot = Shot {
            mode: SpectralMode::Rgb,
            size: Some([12, 12]),
            ..Shot::new(2)
        };
        let image = shot.of_document(&document);
        let light: f32 = image.stokes.iter().sum();
        assert!(
            light.is_finite() && image.stokes.iter().any(|&s| s > 0.0),
            "{}: no light",
            path.display()
        );
    }
}
