//! Tests of the NumPy files: bits come back, axes are told apart, damage is named.

use super::*;
use npyz::npz::NpzWriter;

fn counting(width: usize, height: usize, colour: Colour) -> StokesImage {
    let mut image = StokesImage::new(width, height, 4, colour);
    for (i, value) in image.stokes.iter_mut().enumerate() {
        *value = i as f32 + 0.25;
    }
    image
}

#[test]
fn npy_files_come_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    for colour in [
        Colour::Mono {
            wavelength_nm: None,
        },
        Colour::Rgb,
    ] {
        let image = counting(5, 3, colour);
        write(&path, &image).unwrap();
        assert_eq!(read_npy(&path).unwrap(), image);
    }
    let bands = counting(
        5,
        3,
        Colour::Bands {
            wavelengths_nm: vec![400.0, 500.0],
        },
    );
    write(&path, &bands).unwrap();
    let back = read_npy(&path).unwrap();
    assert_eq!(back.stokes, bands.stokes);
    assert_eq!(back.colour.count(), 2);
}

#[test]
fn the_component_is_the_last_axis_of_npy_and_the_colour_of_npz() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let image = counting(2, 1, Colour::Rgb);
    write(&path, &image).unwrap();
    let raw = array(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(raw.shape, [1, 2, 3, 4]);
    // S0.R S1.R S2.R S3.R
    assert_eq!(raw.values[..4], [0.25, 3.25, 6.25, 9.25]);

    let path = folder.path().join("a.npz");
    archive(&path, &[("S", &[1, 2, 4, 3], &image.stokes)]);
    assert_eq!(read_npz(&path, "S").unwrap(), image);
    // an .npy of the same shape is told apart by its last axis
    let path = folder.path().join("b.npy");
    write_array(&path, &[1, 2, 4, 3], &image.stokes).unwrap();
    assert_eq!(read_npy(&path).unwrap(), image);
}

fn archive(path: &Path, arrays: &[(&str, &[u64], &[f32])]) {
    let mut archive = NpzWriter::create(path).unwrap();
    for (name, shape, values) in arrays {
        let mut writer = archive
            .array(name, Default::default())
            .unwrap()
            .default_dtype()
            .shape(shape)
            .begin_nd()
            .unwrap();
        writer.extend(*values).unwrap();
        writer.finish().unwrap();
    }
}

#[test]
fn standard_errors_become_variances() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npz");
    archive(
        &path,
        &[
            ("S", &[1, 1, 4], &[1.0, 0.5, 0.0, 0.0]),
            ("stderr", &[1, 1, 4], &[0.5, 0.25, 0.0, 2.0]),
        ],
    );
    let image = read_npz(&path, "S").unwrap();
    assert_eq!(image.variance, Some(vec![0.25, 0.0625, 0.0, 4.0]));
    let errors = read_npz(&path, "stderr").unwrap();
    assert_eq!(errors.stokes, [0.5, 0.25, 0.0, 2.0]);
}

#[test]
fn first_axis_fastest_is_understood() {
    assert_eq!(
        rows_first(&[2, 3], &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]),
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    );
}

#[test]
fn wrong_shapes_and_damage_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    write_array(&path, &[2, 3], &[0.0; 6]).unwrap();
    let error = read_npy(&path).unwrap_err().to_string();
    assert!(
        error.ends_with("a.npy: its shape is [2, 3], expected (H, W, 4) or (H, W, n, 4)"),
        "{error}"
    );
    write_array(&path, &[0, 3, 4], &[]).unwrap();
    assert!(
        read_npy(&path)
            .unwrap_err()
            .to_string()
            .contains("expected at least one pixel")
    );

    write(&path, &counting(4, 4, Colour::Rgb)).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        let error = read_npy(&path).unwrap_err().to_string();
        assert!(error.contains("no readable npy array"), "{length}: {error}");
    }
    let path = folder.path().join("a.npz");
    fs::write(&path, b"PK but no archive").unwrap();
    assert!(
        read_npz(&path, "S")
            .unwrap_err()
            .to_string()
            .contains("no readable npz archive")
    );
    archive(&path, &[("T", &[1], &[0.0])]);
    assert!(
        read_npz(&path, "S")
            .unwrap_err()
            .to_string()
            .ends_with("no array 'S'; arrays are T")
    );
}

#[test]
fn absurd_headers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    for shape in [
        "(99999999999, 99999999999, 4)",
        "(1000000, 1000000, 4)",
        "(100000, 10000, 4)",
    ] {
        let mut text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        while (text.len() + 10) % 64 != 63 {
            text.push(' ');
        }
        text.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        fs::write(&path, &bytes).unwrap();
        assert!(read_npy(&path).is_err(), "{shape}");
    }
}
