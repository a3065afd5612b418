//! Stokes images as NumPy arrays.
//!
//! ```text
//! .npy   (H, W, 4)      one number per component          what we write and read
//!        (H, W, n, 4)   n colours, the component last     (polanalyser's axis order)
//!        (H, W, 4, 3)   read too: only n = 4 could be mistaken, and then the component is last
//! .npz   S (H, W, 4) or (H, W, 4, n): the colour last     read only
//!        stderr         standard errors of S, same shape
//!        meta           JSON object as a string
//! ```
//!
//! Numbers are 32-bit in memory; 64-bit arrays lose digits beyond the seventh.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use npyz::npz::NpzArchive;
use npyz::{NpyFile, Order, WriterBuilder};

use super::{ImageError, write_atomically};
use crate::image::{Colour, StokesImage};

/// Arrays longer than this are taken for damage.
const MOST_NUMBERS: u64 = 1 << 32;

/// Writes the numbers of an image as `.npy`: (H, W, 4), or (H, W, n, 4) for colours and bands.
///
/// The last axis has length 1 where only S0 was rendered. Variances and metadata are left out.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, image: &StokesImage) -> Result<(), ImageError> {
    if let Some(problem) = image.inconsistency() {
        return Err(ImageError::content(path, problem));
    }
    let colours = image.colour.count();
    let mut shape = vec![image.height as u64, image.width as u64];
    if !matches!(image.colour, Colour::Mono { .. }) {
        shape.push(colours as u64);
    }
    shape.push(image.components as u64);
    write_array(
        path,
        &shape,
        &transposed(&image.stokes, image.components, colours),
    )
}

/// Writes an array of any shape as `.npy`, 32-bit floats, rows first.
///
/// # Errors
/// The file cannot be written, or `values` does not fill `shape`.
pub fn write_array(path: &Path, shape: &[u64], values: &[f32]) -> Result<(), ImageError> {
    let mut bytes = Vec::new();
    let encode = |bytes: &mut Vec<u8>| -> std::io::Result<()> {
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .shape(shape)
            .writer(bytes)
            .begin_nd()?;
        writer.extend(values)?;
        writer.finish()
    };
    encode(&mut bytes).map_err(|e| ImageError::content(path, e.to_string()))?;
    write_atomically(path, &bytes)
}

/// Reads a Stokes image from `.npy`.
///
/// # Errors
/// The file cannot be read, is damaged, or its shape is no Stokes image's.
pub fn read_npy(path: &Path) -> Result<StokesImage, ImageError> {
    let bytes = fs::read(path).map_err(|e| ImageError::read(path, e))?;
    guarded(path, || image_of(array(&bytes[..])?, false))
}

/// Reads a Stokes image from the array `key` of an `.npz`, or from `S` where there is no such array.
///
/// `stderr` becomes the variance, `meta` the metadata.
///
/// # Errors
/// The file cannot be read, is damaged, or lacks the array.
pub fn read_npz(path: &Path, key: &str) -> Result<StokesImage, ImageError> {
    let bytes = fs::read(path).map_err(|e| ImageError::read(path, e))?;
    guarded(path, || {
        let mut archive =
            NpzArchive::new(Cursor::new(&bytes)).map_err(|e| damaged("npz archive", &e))?;
        let mut numbers = |name: &str| -> Result<Option<Array>, String> {
            let file = archive
                .by_name(name)
                .map_err(|e| damaged(&format!("array '{name}'"), &e))?;
            file.map(|file| numbers_of(file).map_err(|e| format!("array '{name}': {e}")))
                .transpose()
        };
        let stderr = numbers("stderr")?;
        let stokes = match numbers(key)? {
            Some(array) => Some(array),
            None => numbers("S")?,
        };
        let Some(stokes) = stokes else {
            let names: Vec<&str> = archive.array_names().collect();
            return Err(format!("no array '{key}'; arrays are {}", names.join(" ")));
        };
        let mut image = image_of(stokes, true).map_err(|e| format!("array '{key}': {e}"))?;
        if let Some(stderr) = stderr {
            let stderr = image_of(stderr, true).map_err(|e| format!("array 'stderr': {e}"))?;
            if stderr.stokes.len() != image.stokes.len() || stderr.width != image.width {
                return Err(
                    "array 'stderr' has another shape than 'S', expected the same".to_owned(),
                );
            }
            image.variance = Some(stderr.stokes.iter().map(|e| e * e).collect());
        }
        let meta = archive
            .by_name("meta")
            .map_err(|e| damaged("array 'meta'", &e))?;
        image.metadata = meta.map(metadata_of).unwrap_or_default();
        Ok(image)
    })
}

/// Numbers with their shape, rows first.
struct Array {
    shape: Vec<usize>,
    values: Vec<f32>,
}

/// The decoders may meet an assertion of theirs in a crafted file; that is an error like any other.
fn guarded(
    path: &Path,
    decode: impl FnOnce() -> Result<StokesImage, String>,
) -> Result<StokesImage, ImageError> {
    let decoded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode));
    decoded
        .unwrap_or_else(|_| Err("damaged beyond recognition".to_owned()))
        .map_err(|problem| ImageError::content(path, problem))
}

fn damaged(what: &str, error: &dyn std::fmt::Display) -> String {
    format!("no readable {what} ({error}); it may be cut short or of another format")
}

fn array(bytes: &[u8]) -> Result<Array, String> {
    numbers_of(NpyFile::new(bytes).map_err(|e| damaged("npy array", &e))?)
}

fn numbers_of<R: Read>(file: NpyFile<R>) -> Result<Array, String> {
    let fortran = file.order() == Order::Fortran;
    let shape: Vec<u64> = file.shape().to_vec();
    let count = shape
        .iter()
        .try_fold(1_u64, |product, &n| product.checked_mul(n));
    if count.is_none_or(|n| n > MOST_NUMBERS) {
        return Err(format!(
            "its header claims shape {shape:?}, expected at most {MOST_NUMBERS} numbers"
        ));
    }
    let dtype = file.dtype().descr();
    let broken = |e: std::io::Error| damaged("npy array", &e);
    let values: Vec<f32> = match file.try_data::<f32>() {
        Ok(data) => data.collect::<Result<_, _>>().map_err(broken)?,
        Err(file) => match file.try_data::<f64>() {
            Ok(data) => data
                .map(|v| v.map(|v| v as f32))
                .collect::<Result<_, _>>()
                .map_err(broken)?,
            Err(_) => {
                return Err(format!(
                    "its numbers are of type {dtype}, expected float32 or float64"
                ));
            }
        },
    };
    let shape: Vec<usize> = shape.iter().map(|&n| n as usize).collect();
    let values = if fortran {
        rows_first(&shape, &values)
    } else {
        values
    };
    Ok(Array { shape, values })
}

/// Reorders an array that is stored with its first axis fastest.
fn rows_first(shape: &[usize], values: &[f32]) -> Vec<f32> {
    let mut index = vec![0; shape.len()];
    let mut out = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        let at = index
            .iter()
            .zip(shape)
            .rev()
            .fold(0, |at, (&i, &n)| at * n + i);
        out.push(values[at]);
        for (i, &n) in index.iter_mut().zip(shape).rev() {
            *i += 1;
            if *i < n {
                break;
            }
            *i = 0;
        }
    }
    out
}

/// A Stokes image from an array; `colour_last` says what (H, W, 4, 4) means.
fn image_of(array: Array, colour_last: bool) -> Result<StokesImage, String> {
    let Array { shape, values } = array;
    let (height, width, components, colours, component_first) = match shape[..] {
        [h, w, k @ (1 | 4)] => (h, w, k, 1, true),
        [h, w, k @ (1 | 4), n] if colour_last => (h, w, k, n, true),
        [h, w, n, k @ (1 | 4)] if !colour_last => (h, w, k, n, false),
        [h, w, 4, 3] => (h, w, 4, 3, true),
        _ => {
            let expected = if colour_last {
                "(H, W, 4) or (H, W, 4, n)"
            } else {
                "(H, W, 4) or (H, W, n, 4)"
            };
            return Err(format!("its shape is {shape:?}, expected {expected}"));
        }
    };
    let colour = match colours {
        1 => Colour::Mono {
            wavelength_nm: None,
        },
        3 => Colour::Rgb,
        n => Colour::Bands {
            wavelengths_nm: vec![f64::NAN; n],
        },
    };
    let image = StokesImage {
        width,
        height,
        components,
        colour,
        stokes: if component_first {
            values
        } else {
            transposed(&values, colours, components)
        },
        variance: None,
        metadata: BTreeMap::new(),
    };
    image.inconsistency().map_or(Ok(image), Err)
}

/// Swaps the last two axes, of lengths `rows` and `columns`.
fn transposed(values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
    let block = |pixel: &[f32]| -> Vec<f32> {
        (0..rows * columns)
            .map(|i| pixel[(i % rows) * columns + i / rows])
            .collect()
    };
    values
        .chunks_exact((rows * columns).max(1))
        .flat_map(block)
        .collect()
}

/// The entries of a JSON object in a zero-dimensional string array; empty where there is none.
fn metadata_of<R: Read>(file: NpyFile<R>) -> BTreeMap<String, String> {
    let Ok(mut strings) = file.data::<String>() else {
        return BTreeMap::new();
    };
    let Some(Ok(text)) = strings.next() else {
        return BTreeMap::new();
    };
    let Ok(serde_json::Value::Object(entries)) = serde_json::from_str(&text) else {
        return BTreeMap::from([("meta".to_owned(), text)]);
    };
    let plain = |value: serde_json::Value| match value {
        serde_json::Value::String(text) => text,
        other => other.to_string(),
    };
    entries
        .into_iter()
        .map(|(key, value)| (key, plain(value)))
        .collect()
}

#[cfg(test)]
mod tests {
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
            let mut text =
                format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
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
}
