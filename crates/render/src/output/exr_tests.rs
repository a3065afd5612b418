//! Tests of the EXR files: what is written comes back bit by bit, and damage is named.

use super::*;

/// An image of many magnitudes and both signs, with variances.
fn specimen(colour: Colour) -> StokesImage {
    let mut image = StokesImage::new(37, 21, 4, colour);
    for (i, value) in image.stokes.iter_mut().enumerate() {
        let t = i as f32;
        *value = (t * 0.37).sin() * 10f32.powf((t * 0.01).cos() * 30.0);
    }
    image.variance = Some(image.stokes.iter().map(|s| s * s * 1e-3).collect());
    image
        .metadata
        .insert("scene".to_owned(), "Brücke & Söhne/鏡.xml".to_owned());
    image
        .metadata
        .insert("version".to_owned(), "0.1.0".to_owned());
    image
        .metadata
        .insert("comments".to_owned(), "two\nlines".to_owned());
    image
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn there_and_back(image: &StokesImage, options: &WriteOptions) -> StokesImage {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, image, options).unwrap();
    read(&path).unwrap()
}

#[test]
fn coherence_comes_back_bit_by_bit() {
    let mut image = specimen(Colour::Rgb);
    let coherence: Vec<[f32; 4]> = (0..37 * 21)
        .map(|i| [1e-5 * i as f32, 1e-6, 0.004 * i as f32, 0.5])
        .collect();
    image.coherence = Some(coherence.clone());
    let back = there_and_back(&image, &WriteOptions::default());
    assert_eq!(back, image);
    image.coherence = Some(vec![[f32::NAN, f32::INFINITY, 0.0, -0.0]; 37 * 21]);
    let back = there_and_back(&image, &WriteOptions::default());
    assert_eq!(
        bits(back.coherence.unwrap().as_flattened()),
        bits(image.coherence.as_ref().unwrap().as_flattened())
    );
    // Mitsuba has no such channels
    let mitsuba = WriteOptions {
        mitsuba_channels: true,
    };
    assert_eq!(there_and_back(&image, &mitsuba).coherence, None);
    image.coherence = Some(coherence[1..].to_vec());
    let folder = tempfile::tempdir().unwrap();
    let error = write(
        &folder.path().join("a.exr"),
        &image,
        &WriteOptions::default(),
    )
    .unwrap_err()
    .to_string();
    assert!(
        error.ends_with("coherence of 776 pixels, expected 777"),
        "{error}"
    );
}

#[test]
fn every_layout_comes_back_bit_by_bit() {
    let bands = Colour::Bands {
        wavelengths_nm: vec![400.0, 550.125, 1064.5],
    };
    let mono = Colour::Mono {
        wavelength_nm: Some(632.8),
    };
    for colour in [
        mono,
        Colour::Mono {
            wavelength_nm: None,
        },
        Colour::Rgb,
        bands,
    ] {
        let image = specimen(colour);
        let back = there_and_back(&image, &WriteOptions::default());
        assert_eq!(bits(&back.stokes), bits(&image.stokes));
        assert_eq!(
            bits(back.variance.as_ref().unwrap()),
            bits(image.variance.as_ref().unwrap())
        );
        assert_eq!(back, image);
    }
}

#[test]
fn an_unpolarized_image_keeps_one_component() {
    let mut image = StokesImage::new(3, 2, 1, Colour::Rgb);
    image.stokes[7] = 0.25;
    assert_eq!(there_and_back(&image, &WriteOptions::default()), image);
}

#[test]
fn mitsuba_layout_has_its_names_and_no_variances() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let options = WriteOptions {
        mitsuba_channels: true,
    };
    let mono = specimen(Colour::Mono {
        wavelength_nm: None,
    });
    write(&path, &mono, &options).unwrap();
    let names = |path: &Path| -> Vec<String> {
        let meta = MetaData::read_from_file(path, false).unwrap();
        meta.headers[0]
            .channels
            .list
            .iter()
            .map(|c| c.name.to_string())
            .collect()
    };
    let stokes = ["S0", "S1", "S2", "S3"]
        .iter()
        .flat_map(|s| ["B", "G", "R"].map(|c| format!("{s}.{c}")));
    let expected: Vec<String> = stokes.clone().chain(["Y".to_owned()]).collect();
    assert_eq!(names(&path), expected);
    let back = read(&path).unwrap();
    assert_eq!((&back.colour, &back.variance), (&Colour::Rgb, &None));
    assert_eq!(back.plane(2, 1), mono.plane(2, 0));

    write(&path, &specimen(Colour::Rgb), &options).unwrap();
    let expected: Vec<String> = ["B", "G", "R"]
        .map(str::to_owned)
        .into_iter()
        .chain(stokes)
        .collect();
    assert_eq!(names(&path), expected);

    let bands = specimen(Colour::Bands {
        wavelengths_nm: vec![500.0],
    });
    assert!(
        write(&path, &bands, &options)
            .unwrap_err()
            .to_string()
            .contains("found bands")
    );
}

/// Writes channels as some other program would.
fn foreign(path: &Path, names: &[&str], half: bool, attribute: Option<(&str, &str)>) {
    let list = names.iter().enumerate().map(|(i, name)| {
        let value = i as f32 + 0.5;
        let samples = if half {
            FlatSamples::F16(vec![f16::from_f32(value); 6])
        } else {
            FlatSamples::F32(vec![value; 6])
        };
        AnyChannel::new(text(name), samples)
    });
    let mut attributes = LayerAttributes::default();
    if let Some((key, value)) = attribute {
        attributes
            .other
            .insert(text(key), AttributeValue::Text(text(value)));
    }
    let layer = Layer::new(
        (3, 2),
        attributes,
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list.collect()),
    );
    Image::from_layer(layer).write().to_file(path).unwrap();
}

#[test]
fn half_files_with_other_channels_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let names = [
        "S0.R", "S0.G", "S0.B", "S1.R", "S1.G", "S1.B", "S2.R", "S2.G", "S2.B", "S3.R", "S3.G",
        "S3.B", "R", "G", "B", "A", "albedo.R",
    ];
    foreign(&path, &names, true, None);
    let image = read(&path).unwrap();
    assert_eq!(image.colour, Colour::Rgb);
    assert_eq!(image.stokes_at(2, 1, 1), [1.5, 4.5, 7.5, 10.5]);

    foreign(&path, &["S0.Y", "S1.Y", "S2.Y", "S3.Y", "Y"], false, None);
    let image = read(&path).unwrap();
    assert_eq!(
        image.colour,
        Colour::Mono {
            wavelength_nm: None
        }
    );
    assert_eq!(image.stokes_at(0, 0, 0), [0.5, 1.5, 2.5, 3.5]);
}

#[test]
fn left_handed_files_change_the_sign_of_s3() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let names = ["S0.500nm", "S1.500nm", "S2.500nm", "S3.500nm"];
    foreign(&path, &names, false, Some((HANDEDNESS, "left")));
    assert_eq!(
        read(&path).unwrap().stokes_at(1, 1, 0),
        [0.5, 1.5, 2.5, -3.5]
    );
    foreign(&path, &names, false, Some((HANDEDNESS, "right")));
    assert_eq!(
        read(&path).unwrap().stokes_at(1, 1, 0),
        [0.5, 1.5, 2.5, 3.5]
    );
}

#[test]
fn missing_channels_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    foreign(&path, &["R", "G", "B"], false, None);
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.ends_with("no channel for S0; channels are B G R; expected S0, S0.R or the like"),
        "{error}"
    );
    foreign(&path, &["S0", "S1", "S3"], false, None);
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("no channel 'S2'"), "{error}");
}

#[test]
fn damaged_files_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, &specimen(Colour::Rgb), &WriteOptions::default()).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in (0..whole.len())
        .step_by(whole.len() / 97)
        .chain([1, 4, 8, whole.len() - 1])
    {
        fs::write(&path, &whole[..length]).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(
            error.contains("a.exr: no readable EXR image"),
            "{length} bytes: {error}"
        );
    }
    fs::write(&path, b"this is a text file, not an image at all").unwrap();
    assert!(read(&path).is_err());
}

#[test]
fn flipped_bytes_are_survived() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(
        &path,
        &specimen(Colour::Mono {
            wavelength_nm: None,
        }),
        &WriteOptions::default(),
    )
    .unwrap();
    let whole = fs::read(&path).unwrap();
    for at in (0..1200).chain((1200..whole.len()).step_by(41)) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        fs::write(&path, &bytes).unwrap();
        let _ = read(&path);
    }
}
