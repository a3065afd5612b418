//! Which wavelengths an image shows, as the command line says it.

use super::values::{Band, parse_wavelength};
use crate::film::SpectralMode;

/// The wavelengths of an image.
#[derive(clap::Args, Debug)]
pub(super) struct Wavelengths {
    /// One wavelength [default: 550nm]
    #[arg(long, value_name = "550nm", value_parser = parse_wavelength, conflicts_with_all = ["bands", "rgb"])]
    wavelength: Option<f64>,
    /// Equal bands of wavelengths; each shows the mean over its band
    #[arg(long, value_name = "FROM:TO:N", conflicts_with = "rgb")]
    bands: Option<Band>,
    /// Linear sRGB of every Stokes component, from 360 to 830 nm
    #[arg(long)]
    rgb: bool,
}

impl Wavelengths {
    /// What was asked for.
    pub(super) fn mode(&self) -> SpectralMode {
        match self.bands {
            _ if self.rgb => SpectralMode::Rgb,
            Some(Band { from, to, count }) => SpectralMode::Bands { from, to, count },
            None => SpectralMode::Single(self.wavelength.unwrap_or(550.0)),
        }
    }
}
