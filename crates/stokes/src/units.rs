//! Wavelength and wavenumber: two types, because they are the pair that gets mixed up.

use std::f64::consts::TAU;

use thiserror::Error;

/// A length or wavenumber that is not a finite positive number.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{quantity}: found {value} {unit}, expected a finite positive number")]
pub struct NotPositive {
    quantity: &'static str,
    value: f64,
    unit: &'static str,
}

fn positive(value: f64, quantity: &'static str, unit: &'static str) -> Result<f64, NotPositive> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(NotPositive {
            quantity,
            value,
            unit,
        })
    }
}

/// Vacuum wavelength `λ₀`, in metres.
///
/// ```
/// let sodium = stokes::Wavelength::from_metres(589.3e-9)?;
/// assert!((sodium.wavenumber().radians_per_metre() - 1.0662e7).abs() < 1e3);
/// # Ok::<(), stokes::NotPositive>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Wavelength(f64);

impl Wavelength {
    /// The wavelength of `metres` metres.
    ///
    /// # Errors
    ///
    /// When `metres` is not finite and positive.
    pub fn from_metres(metres: f64) -> Result<Self, NotPositive> {
        positive(metres, "wavelength", "m").map(Self)
    }

    /// The wavelength in metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        self.0
    }

    /// The wavenumber `k₀ = 2π/λ₀`.
    #[must_use]
    pub fn wavenumber(self) -> Wavenumber {
        Wavenumber(TAU / self.0)
    }
}

/// Vacuum wavenumber `k₀ = 2π/λ₀`, in radians per metre.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Wavenumber(f64);

impl Wavenumber {
    /// The wavenumber of `value` radians per metre.
    ///
    /// # Errors
    ///
    /// When `value` is not finite and positive.
    pub fn from_radians_per_metre(value: f64) -> Result<Self, NotPositive> {
        positive(value, "wavenumber", "rad/m").map(Self)
    }

    /// The wavenumber in radians per metre.
    #[must_use]
    pub fn radians_per_metre(self) -> f64 {
        self.0
    }

    /// The wavelength `λ₀ = 2π/k₀`.
    #[must_use]
    pub fn wavelength(self) -> Wavelength {
        Wavelength(TAU / self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wavelength_is_finite_and_positive() {
        for bad in [0.0, -5e-7, f64::NAN, f64::INFINITY] {
            assert!(Wavelength::from_metres(bad).is_err());
            assert!(Wavenumber::from_radians_per_metre(bad).is_err());
        }
        let text = Wavelength::from_metres(-1.0).unwrap_err().to_string();
        assert_eq!(
            text,
            "wavelength: found -1 m, expected a finite positive number"
        );
    }

    #[test]
    fn wavenumber_and_wavelength_are_each_others_inverse() {
        let green = Wavelength::from_metres(550e-9).unwrap();
        let back = green.wavenumber().wavelength().metres();
        assert!((back / 550e-9 - 1.0).abs() < 4.0 * f64::EPSILON);
    }
}
