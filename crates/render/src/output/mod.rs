//! Image files: Stokes images as EXR, `.npy` and `.npz`, written whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::image::StokesImage;

pub mod channels;
pub mod display;
pub mod exr;
pub mod npy;

/// Why an image file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file system refused to read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file system refused to write.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file, or the image for it, is not what is needed.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What was found, what was expected, the remedy.
        problem: String,
    },
    /// The request does not fit the image.
    #[error("{0}")]
    Request(String),
}

impl ImageError {
    pub(crate) fn content(path: &Path, problem: impl Into<String>) -> Self {
        Self::Content {
            path: path.to_owned(),
            problem: problem.into(),
        }
    }

    fn read(path: &Path, source: io::Error) -> Self {
        Self::Read {
            path: path.to_owned(),
            source,
        }
    }
}

/// How a Stokes image is laid out in its file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// EXR channels exactly as Mitsuba's: three colours per component, no variances.
    pub mitsuba_channels: bool,
}

/// Reads a Stokes image: our EXR, Mitsuba's, spectral polarised EXR, `.npy`, or `.npz` with `S` and perhaps `stderr`.
///
/// # Errors
/// The file cannot be read, is damaged, or holds no Stokes image.
pub fn read(path: &Path) -> Result<StokesImage, ImageError> {
    match extension(path).as_str() {
        "exr" => exr::read(path),
        "npy" => npy::read_npy(path),
        "npz" => npy::read_npz(path, "S"),
        _ => Err(unknown_extension(path, "'.exr', '.npy' or '.npz'")),
    }
}

/// Writes a Stokes image as EXR or, without variances and metadata, as `.npy`; the extension decides.
///
/// The coherence of an image goes into the EXR, or beside `NAME.npy` as `NAME_coherence.npy`.
///
/// # Errors
/// The folder or the file cannot be written, the extension is another, or the image's sizes do not fit together.
pub fn write(path: &Path, image: &StokesImage, options: &WriteOptions) -> Result<(), ImageError> {
    if let Some(problem) = image.inconsistency() {
        return Err(ImageError::content(path, problem));
    }
    match extension(path).as_str() {
        "exr" => exr::write(path, image, options),
        "npy" => {
            npy::write(path, image)?;
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            npy::write_coherence(&path.with_file_name(format!("{stem}_coherence.npy")), image)
        }
        _ => Err(unknown_extension(path, "'.exr' or '.npy'")),
    }
}

/// Writes a file whole or not at all: into a temporary file beside it, which then takes its name.
///
/// An older file of that name stays as it was until the new one is complete.
///
/// # Errors
/// The folder cannot be written, or `path` is something other than an ordinary file (a folder, a device).
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    try_write(path, bytes).map_err(|source| ImageError::Write {
        path: path.to_owned(),
        source,
    })
}

fn try_write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if path.exists() && !path.is_file() {
        return Err(io::Error::other(
            "it is not an ordinary file; name a file to write",
        ));
    }
    // A link keeps pointing where it did: the file behind it is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(io::Error::other(format!(
            "there is no folder '{}'; create it first",
            folder.display()
        )));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".brewster-").suffix(".part");
    ordinary_permissions(&mut builder);
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_data()?;
    file.persist(&target).map_err(|failure| failure.error)?;
    Ok(())
}

/// Temporary files are private by default; ours become ordinary files, so the user's umask decides.
#[cfg(unix)]
fn ordinary_permissions(builder: &mut tempfile::Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn ordinary_permissions(_builder: &mut tempfile::Builder<'_, '_>) {}

fn extension(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase()
}

/// Whether a file is an array: `.npy` or `.npz`.
pub fn is_array(path: &Path) -> bool {
    ["npy", "npz"].contains(&extension(path).as_str())
}

fn unknown_extension(path: &Path, expected: &str) -> ImageError {
    let found = extension(path);
    let found = if found.is_empty() {
        "no extension".to_owned()
    } else {
        format!("extension '.{found}'")
    };
    ImageError::content(path, format!("{found}, expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Colour;

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let mut image = StokesImage::new(
            2,
            2,
            4,
            Colour::Mono {
                wavelength_nm: None,
            },
        );
        image.stokes.pop();
        let path = folder.path().join("a.exr");
        let error = write(&path, &image, &WriteOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.ends_with("a.exr: 15 numbers, expected 16"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

        // the target is a folder: the temporary file must not survive
        fs::create_dir(folder.path().join("b.exr")).unwrap();
        image.stokes.push(0.0);
        let error = write(
            &folder.path().join("b.exr"),
            &image,
            &WriteOptions::default(),
        )
        .unwrap_err()
        .to_string();
        assert!(error.contains("not an ordinary file"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_and_a_strange_extension_are_named() {
        let image = StokesImage::new(1, 1, 4, Colour::Rgb);
        let error = write(
            Path::new("/nowhere/a.exr"),
            &image,
            &WriteOptions::default(),
        )
        .unwrap_err()
        .to_string();
        assert!(error.contains("there is no folder '/nowhere'"), "{error}");
        let error = write(Path::new("a.tiff"), &image, &WriteOptions::default())
            .unwrap_err()
            .to_string();
        assert_eq!(
            error,
            "a.tiff: extension '.tiff', expected '.exr' or '.npy'"
        );
        let error = read(Path::new("noend")).unwrap_err().to_string();
        assert_eq!(
            error,
            "noend: no extension, expected '.exr', '.npy' or '.npz'"
        );
        assert!(
            read(Path::new("absent.exr"))
                .unwrap_err()
                .to_string()
                .starts_with("absent.exr: cannot be read")
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_ordinary_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomically(&ours, b"x").unwrap();
        fs::write(&plain, b"x").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
