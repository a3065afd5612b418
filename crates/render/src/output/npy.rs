//! Stokes images as NumPy arrays.
//!
//! ```text
//! .npy   (H, W, 4)      one number per component          what we write and read
//!        (H, W, n, 4)   n colours, the component last     (polanalyser's axis order)
//!        (H, W, 4, 3)   read too: only n = 4 could be mistaken, and then the component is last
//! .npz   S (H, W, 4) or (H, W, 4, n): the colour last     read only
//!        stderr         standard errors of S, same shape
//!        coherence      (H, W, 4): semi-axes, angle and degree, as in the EXR channels of that name
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
/// The last axis has length 1 where only S0 was rendered. Variances, coherence, numbers of samples and metadata are left out.
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

/// Writes the coherence of an image, if it has any, as an array (H, W, 4).
///
/// # Errors
/// The file cannot be written.
pub fn write_coherence(path: &Path, image: &StokesImage) -> Result<(), ImageError> {
    if let Some(problem) = image.inconsistency() {
        return Err(ImageError::content(path, problem));
    }
    let Some(coherence) = &image.coherence else {
        return Ok(());
    };
    let shape = [image.height as u64, image.width as u64, 4];
    write_array(path, &shape, coherence.as_flattened())
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
        let coherence = numbers("coherence")?;
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
        if let Some(array) = coherence {
            if array.shape != [image.height, image.width, 4] {
                return Err(format!(
                    "array 'coherence' has shape {:?}, expected {:?}",
                    array.shape,
                    [image.height, image.width, 4]
                ));
            }
            image.coherence = Some(array.values.as_chunks::<4>().0.to_vec());
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
        coherence: None,
        samples: None,
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
#[path = "npy_tests.rs"]
mod tests;
