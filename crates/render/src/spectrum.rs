//! Spectra: a number for each wavelength (stand-in with the names of the real module).

/// What the three numbers of an `rgb` mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpectrumUse {
    /// A fraction of the incident light, in `0.0..=1.0`.
    Reflectance,
    /// Emitted light under the white of the display.
    Emission,
    /// Any positive quantity.
    Unbounded,
}

/// A quantity that depends on the wavelength.
#[derive(Debug, Clone, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
    /// Linear between (nm, value) pairs, zero outside.
    Tabulated(Vec<(f64, f64)>),
    /// Made of a colour.
    Rgb(SpectrumUse, [f64; 3]),
}

impl Spectrum {
    /// The same value at every wavelength.
    pub fn constant(value: f64) -> Self {
        Self::Constant(value)
    }
    /// Linear between (nm, value) pairs, zero outside.
    pub fn tabulated(pairs: Vec<(f64, f64)>) -> Result<Self, String> {
        Ok(Self::Tabulated(pairs))
    }
    /// A reflectance with this colour.
    pub fn rgb_reflectance(rgb: [f64; 3]) -> Self {
        Self::Rgb(SpectrumUse::Reflectance, rgb)
    }
    /// An emission with this colour.
    pub fn rgb_emission(rgb: [f64; 3]) -> Self {
        Self::Rgb(SpectrumUse::Emission, rgb)
    }
    /// A quantity without upper bound with this colour.
    pub fn rgb_unbounded(rgb: [f64; 3]) -> Self {
        Self::Rgb(SpectrumUse::Unbounded, rgb)
    }
}
