//! Tests of the maps: known states have known numbers, and what is written can be read.

use super::*;
use crate::image::Colour;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

fn image(pixels: &[[f32; 4]], width: usize) -> StokesImage {
    let mut image = StokesImage::new(
        width,
        pixels.len() / width,
        4,
        Colour::Mono {
            wavelength_nm: None,
        },
    );
    image.stokes = pixels.as_flattened().to_vec();
    image
}

/// Unpolarized, horizontal, diagonal, vertical, right circular, half left circular.
fn states() -> StokesImage {
    image(
        &[
            [1.0, 0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0, 0.0],
            [1.0, 0.0, 1.0, 0.0],
            [1.0, -1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 1.0],
            [2.0, 0.0, 0.0, -1.0],
        ],
        3,
    )
}

#[test]
fn known_states_have_known_numbers() {
    let map = |name: &str| TABLE.iter().find(|map| map.name == name).unwrap();
    let value = |name: &str, pixel: usize| {
        let s = states().stokes_at(pixel % 3, pixel / 3, 0);
        (map(name).planes[0])(&StokesVector::new(s[0], s[1], s[2], s[3]))
    };
    let expected = [
        ("s0", [1.0, 1.0, 1.0, 1.0, 1.0, 2.0]),
        ("s1", [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]),
        ("s2", [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ("s3", [0.0, 0.0, 0.0, 0.0, 1.0, -0.5]),
        ("dop", [0.0, 1.0, 1.0, 1.0, 1.0, 0.5]),
        ("dolp", [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]),
        ("docp", [0.0, 0.0, 0.0, 0.0, 1.0, -0.5]),
        ("aolp", [0.0, 0.0, FRAC_PI_4, FRAC_PI_2, 0.0, 0.0]),
        ("ellipticity", [0.0, 0.0, 0.0, 0.0, FRAC_PI_4, -FRAC_PI_4]),
    ];
    for (name, numbers) in expected {
        for (pixel, number) in numbers.into_iter().enumerate() {
            assert!(
                (value(name, pixel) - number).abs() < 1e-15,
                "{name} {pixel}"
            );
        }
    }
}

#[test]
fn every_map_is_written_and_named_in_the_side_car() {
    let folder = tempfile::tempdir().unwrap();
    let options = MapOptions {
        data: true,
        ..MapOptions::default()
    };
    let target = folder.path().join("new/folder");
    let report = write_all(&states(), &options, &target, "a <&> b").unwrap();
    // a picture per map, numbers for all but the ellipses, one SVG, the side-car
    assert_eq!(report.files.len(), 12 + 11 + 1 + 1);
    for path in &report.files {
        assert!(
            std::fs::metadata(path).unwrap().len() > 100,
            "{}",
            path.display()
        );
    }
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(target.join("a <&> b_maps.json")).unwrap()).unwrap();
    assert_eq!(json["maps"].as_array().unwrap().len(), 12);
    assert_eq!(json["statistics"]["dop_above_one_share"], 0.0);
    assert_eq!(json["maps"][5]["limits"], serde_json::json!([0.0, 1.0]));
    let svg = std::fs::read_to_string(target.join("a <&> b_ellipses.svg")).unwrap();
    assert!(roxmltree::Document::parse(&svg).is_ok());
}

#[test]
fn angles_of_unpolarized_light_are_masked_in_the_numbers() {
    let states = states();
    let options = MapOptions::default();
    let scene = paint::Scene::new(&states, &options, "a").unwrap();
    let aolp = TABLE.iter().find(|map| map.name == "aolp").unwrap();
    let (shape, values) = scene.data(aolp);
    assert_eq!(shape, [2, 3]);
    assert!(values[0].is_nan() && values[4].is_nan() && values[5].is_nan());
    assert!((f64::from(values[2]) - FRAC_PI_4).abs() < 1e-7);
}

#[test]
fn strange_images_are_drawn_without_panic() {
    let folder = tempfile::tempdir().unwrap();
    let options = MapOptions::default();
    let black = StokesImage::new(1, 1, 4, Colour::Rgb);
    let nan = image(&[[f32::NAN; 4], [f32::INFINITY; 4]], 1);
    let wide = StokesImage::new(
        900,
        1,
        4,
        Colour::Mono {
            wavelength_nm: None,
        },
    );
    let negative = image(&[[-1.0, 2.0, 0.0, 0.0]], 1);
    for (i, image) in [black, nan, wide, negative].iter().enumerate() {
        write_all(image, &options, folder.path(), &format!("strange{i}")).unwrap();
    }
}

#[test]
fn wrong_requests_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let ask = |image: &StokesImage, options: MapOptions| {
        write_all(image, &options, folder.path(), "a")
            .unwrap_err()
            .to_string()
    };
    let named = |name: &str| MapOptions {
        maps: vec![name.to_owned()],
        ..MapOptions::default()
    };
    assert!(ask(&states(), named("dopl")).contains("unknown map 'dopl', expected some of s0,s1"));
    assert!(ask(&states(), named("elipses")).ends_with("did you mean 'ellipses'?"));
    let unpolarized = StokesImage::new(2, 2, 1, Colour::Rgb);
    assert!(ask(&unpolarized, named("dop")).contains("the image has S0 only"));
    let threshold = MapOptions {
        threshold: -1.0,
        ..MapOptions::default()
    };
    assert!(ask(&states(), threshold).contains("the threshold is -1"));
    assert!(check_names(&["s0".to_owned(), "xyz".to_owned()]).is_err());
    assert!(check_names(&["ellipses".to_owned()]).is_ok());
    // an image with S0 alone has its intensity, unasked
    let report = write_all(&unpolarized, &MapOptions::default(), folder.path(), "u").unwrap();
    assert_eq!(report.maps.len(), 1);
}
