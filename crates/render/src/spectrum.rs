//! Spectra of scene files: constants, tables, and colours made into smooth spectra.
//!
//! A colour becomes the sigmoid of a quadratic in the wavelength, so that it lies between 0 and 1 everywhere:
//!
//! ```text
//! s(λ) = ½ + x/(2√(1 + x²)),   x = c₀t² + c₁t + c₂,   t = (λ − 360 nm)/470 nm
//! ```
//!
//! The three coefficients are fitted when the scene is read, such that the spectrum has the colour under D65.
//!
//! Source: Jakob & Hanika 2019, A low-dimensional function space for efficient spectral upsampling.

use std::sync::Arc;

use crate::colour::{self, FIRST_NM, LAST_NM};

/// What a spectrum is for; decides how a colour becomes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectrumUse {
    /// A fraction between 0 and 1.
    Reflectance,
    /// Radiance or another quantity of light: a colour is meant under D65.
    Emission,
    /// Any other number that is not negative: indices, scale factors.
    Unbounded,
}

/// A function of the wavelength; cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum(Shape);

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Constant(f32),
    Table {
        /// (nm, value), wavelengths strictly increasing.
        knots: Arc<[(f64, f64)]>,
        held: bool,
    },
    Colour {
        coefficients: [f64; 3],
        scale: f64,
        under_d65: bool,
    },
}

impl Spectrum {
    /// The same value at every wavelength.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self(Shape::Constant(value as f32))
    }

    /// Linear between `(wavelength in nm, value)` knots, and zero outside the first and last, as in Mitsuba 3.
    ///
    /// # Errors
    ///
    /// When there is no knot, a number is not finite, or the wavelengths do not increase.
    pub fn tabulated(knots: Vec<(f64, f64)>) -> Result<Self, String> {
        Self::table(knots, false)
    }

    /// As [`Spectrum::tabulated`], with the end values held outside: for named materials.
    ///
    /// # Errors
    ///
    /// As [`Spectrum::tabulated`].
    pub fn tabulated_held(knots: Vec<(f64, f64)>) -> Result<Self, String> {
        Self::table(knots, true)
    }

    fn table(knots: Vec<(f64, f64)>, held: bool) -> Result<Self, String> {
        if knots.is_empty() {
            return Err("spectrum: expected at least one 'wavelength:value', found none".into());
        }
        if let Some((nm, value)) = knots
            .iter()
            .find(|(nm, value)| !nm.is_finite() || !value.is_finite())
        {
            return Err(format!(
                "spectrum: expected finite numbers, found '{nm}:{value}'"
            ));
        }
        if let Some(pair) = knots.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            return Err(format!(
                "spectrum: expected wavelengths that increase, found {} nm after {} nm",
                pair[1].0, pair[0].0
            ));
        }
        Ok(Self(Shape::Table {
            knots: knots.into(),
            held,
        }))
    }

    /// The reflectance whose linear sRGB colour under D65 is `rgb`, each component clamped to `0.0..=1.0`.
    ///
    /// Greys are constant, exactly. Colours come back with an error below 1e-3 where every component is in
    /// `0.01..=0.95`; the corners of sRGB come within 0.02, as near as such a spectrum can.
    #[must_use]
    pub fn rgb_reflectance(rgb: [f64; 3]) -> Self {
        Self::from_colour(rgb.map(|c| c.clamp(0.0, 1.0)), 1.0, false)
    }

    /// Light of linear sRGB colour `rgb`, negative components taken as 0: D65 filtered by a smooth spectrum.
    ///
    /// `[1.0; 3]` is D65 itself and reads (1, 1, 1).
    #[must_use]
    pub fn rgb_emission(rgb: [f64; 3]) -> Self {
        let (inner, scale) = scaled(rgb);
        Self::from_colour(inner, scale, true)
    }

    /// A quantity without upper bound of colour `rgb`, negative components taken as 0.
    #[must_use]
    pub fn rgb_unbounded(rgb: [f64; 3]) -> Self {
        let (inner, scale) = scaled(rgb);
        Self::from_colour(inner, scale, false)
    }

    /// The spectrum of a colour, for one of the three uses.
    #[must_use]
    pub fn rgb(rgb: [f64; 3], purpose: SpectrumUse) -> Self {
        match purpose {
            SpectrumUse::Reflectance => Self::rgb_reflectance(rgb),
            SpectrumUse::Emission => Self::rgb_emission(rgb),
            SpectrumUse::Unbounded => Self::rgb_unbounded(rgb),
        }
    }

    fn from_colour(rgb: [f64; 3], scale: f64, under_d65: bool) -> Self {
        let [r, g, b] = rgb;
        let grey = r == g && g == b;
        if grey && (!under_d65 || r == 0.0) {
            return Self::constant(scale * r);
        }
        let coefficients = if grey { [0.0, 0.0, logit(r)] } else { fit(rgb) };
        Self(Shape::Colour {
            coefficients,
            scale,
            under_d65,
        })
    }

    /// The value at `wavelength_nm`.
    ///
    /// Computed in f64 and rounded once. A constant costs nothing; a table a binary search.
    #[inline]
    #[must_use]
    pub fn value(&self, wavelength_nm: f32) -> f32 {
        match &self.0 {
            Shape::Constant(value) => *value,
            Shape::Table { knots, held } => {
                interpolate(knots, *held, f64::from(wavelength_nm)) as f32
            }
            Shape::Colour {
                coefficients,
                scale,
                under_d65,
            } => {
                let nm = f64::from(wavelength_nm);
                let light = if *under_d65 { colour::d65(nm) } else { 1.0 };
                (light * scale * sigmoid(polynomial(coefficients, unit(nm)))) as f32
            }
        }
    }

    /// The mean over wavelengths from the first to the second, nm, or the value where these are the same.
    ///
    /// By trapezes between the knots of a table and 64 even steps: exact for tables.
    #[must_use]
    pub fn mean(&self, [from, to]: [f64; 2]) -> f64 {
        const STEPS: u32 = 64;
        let value = |nm: f64| f64::from(self.value(nm as f32));
        if self.is_constant() || from >= to {
            return value(from);
        }
        let knots = self.knots().iter().map(|knot| knot.0);
        let even = (0..=STEPS).map(|k| from + (to - from) * f64::from(k) / f64::from(STEPS));
        let mut places: Vec<f64> = even
            .chain(knots.filter(|nm| (from..=to).contains(nm)))
            .collect();
        places.sort_by(f64::total_cmp);
        let area = |pair: &[f64]| 0.5 * (value(pair[0]) + value(pair[1])) * (pair[1] - pair[0]);
        places.windows(2).map(area).sum::<f64>() / (to - from)
    }

    /// Whether the value is the same at every wavelength by construction.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        matches!(self.0, Shape::Constant(_))
    }

    /// Whether the value is the same at all wavelengths of a range in nm.
    #[must_use]
    pub fn is_constant_over(&self, [from, to]: [f64; 2]) -> bool {
        match &self.0 {
            Shape::Constant(_) => true,
            Shape::Table { knots, held } => {
                // a table that ends inside the range is zero at one end of it
                let end = interpolate(knots, *held, from);
                let inside = knots.iter().filter(|knot| from <= knot.0 && knot.0 <= to);
                interpolate(knots, *held, to) == end && inside.clone().all(|knot| knot.1 == end)
            }
            Shape::Colour { .. } => from == to,
        }
    }

    /// First and last wavelength in nm of a table that is zero outside; `None` for all else.
    #[must_use]
    pub fn domain(&self) -> Option<[f64; 2]> {
        match &self.0 {
            Shape::Table { knots, held: false } => Some([knots[0].0, knots[knots.len() - 1].0]),
            _ => None,
        }
    }

    /// The knots of a table, `(wavelength in nm, value)`; none for all else.
    #[must_use]
    pub fn knots(&self) -> &[(f64, f64)] {
        match &self.0 {
            Shape::Table { knots, .. } => knots,
            _ => &[],
        }
    }

    /// The constant spectrum of this one's value at `wavelength_nm`.
    #[must_use]
    pub fn at(&self, wavelength_nm: f32) -> Self {
        Self(Shape::Constant(self.value(wavelength_nm)))
    }
}

/// A colour halved below its largest component, and the factor back; Mitsuba's choice, which keeps the fit far
/// from the ends of the sigmoid.
fn scaled(rgb: [f64; 3]) -> ([f64; 3], f64) {
    let rgb = rgb.map(|c| c.max(0.0));
    let scale = 2.0 * rgb[0].max(rgb[1]).max(rgb[2]);
    if scale > 0.0 {
        (rgb.map(|c| c / scale), scale)
    } else {
        ([0.0; 3], 1.0)
    }
}

fn interpolate(knots: &[(f64, f64)], held: bool, nm: f64) -> f64 {
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if nm < first.0 || nm > last.0 {
        let end = if nm < first.0 { first } else { last };
        return if held { end.1 } else { 0.0 };
    }
    let above = knots.partition_point(|knot| knot.0 <= nm);
    if above == knots.len() {
        return last.1;
    }
    let ((x0, y0), (x1, y1)) = (knots[above - 1], knots[above]);
    y0 + (y1 - y0) * (nm - x0) / (x1 - x0)
}

/// Wavelength scaled to 0..1 over the visible range.
fn unit(nm: f64) -> f64 {
    (nm - FIRST_NM) / (LAST_NM - FIRST_NM)
}

fn polynomial([c0, c1, c2]: &[f64; 3], t: f64) -> f64 {
    (c0 * t + c1) * t + c2
}

fn sigmoid(x: f64) -> f64 {
    0.5 + 0.5 * x / (1.0 + x * x).sqrt()
}

/// Derivative of [`sigmoid`].
fn slope(x: f64) -> f64 {
    0.5 / (1.0 + x * x).powf(1.5)
}

/// The `x` at which the sigmoid is `value`, for `value` inside 0..1.
fn logit(value: f64) -> f64 {
    let twice = 2.0 * value - 1.0;
    twice / (1.0 - twice * twice).sqrt()
}

/// Coefficients of the sigmoid whose colour under D65 is `rgb`, components in 0..1.
///
/// Damped Gauss-Newton along a straight way from the grey of the same mean, where the answer is known. Where a
/// colour cannot be reached the nearest point on the way is kept.
fn fit(rgb: [f64; 3]) -> [f64; 3] {
    const STEPS: u32 = 16;
    let grey = (rgb.iter().sum::<f64>() / 3.0).clamp(0.01, 0.99);
    let mut coefficients = [0.0, 0.0, logit(grey)];
    for step in 1..=STEPS {
        let on = f64::from(step) / f64::from(STEPS);
        let target = rgb.map(|c| grey + on * (c - grey));
        approach(&mut coefficients, target);
    }
    coefficients
}

/// Levenberg-Marquardt from where `coefficients` stand.
fn approach(coefficients: &mut [f64; 3], target: [f64; 3]) {
    use nalgebra::{Matrix3, Vector3};
    let target = Vector3::from(target);
    let mut damping = 1e-6;
    let (mut residual, mut jacobian) = response(coefficients, target);
    for _ in 0..60 {
        if residual.norm() < 1e-10 {
            return;
        }
        let normal = jacobian.transpose() * jacobian;
        let damped = normal + Matrix3::from_diagonal(&normal.diagonal()) * damping;
        let Some(inverse) = damped.try_inverse() else {
            return;
        };
        let step: Vector3<f64> = inverse * (jacobian.transpose() * residual);
        let trial = [0, 1, 2].map(|i| coefficients[i] - step[i]);
        let (trial_residual, trial_jacobian) = response(&trial, target);
        if trial_residual.norm() < residual.norm() {
            *coefficients = trial;
            (residual, jacobian) = (trial_residual, trial_jacobian);
            damping = (damping * 0.2).max(1e-12);
        } else {
            damping *= 10.0;
            if damping > 1e8 {
                return;
            }
        }
    }
}

/// Colour minus target, and its derivatives by the coefficients.
fn response(
    coefficients: &[f64; 3],
    target: nalgebra::Vector3<f64>,
) -> (nalgebra::Vector3<f64>, nalgebra::Matrix3<f64>) {
    let mut colour = -target;
    let mut jacobian = nalgebra::Matrix3::zeros();
    for (weights, row) in colour::white_weights().iter().zip(0u32..) {
        let t = unit(FIRST_NM + f64::from(row));
        let x = polynomial(coefficients, t);
        let (value, slope) = (sigmoid(x), slope(x));
        for (c, weight) in weights.iter().enumerate() {
            colour[c] += weight * value;
            jacobian[(c, 0)] += weight * slope * t * t;
            jacobian[(c, 1)] += weight * slope * t;
            jacobian[(c, 2)] += weight * slope;
        }
    }
    (colour, jacobian)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{rgb_weights, white_weights};

    fn error_of(rgb: [f64; 3]) -> f64 {
        let spectrum = Spectrum::rgb_reflectance(rgb);
        let found = white_weights()
            .iter()
            .enumerate()
            .fold([0.0; 3], |sum, (row, weights)| {
                let value = f64::from(spectrum.value(360.0 + row as f32));
                [0, 1, 2].map(|c| sum[c] + weights[c] * value)
            });
        (0..3)
            .map(|c| (found[c] - rgb[c]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_table_is_linear_inside_and_zero_outside() {
        let table = Spectrum::tabulated(vec![(400.0, 0.1), (700.0, 0.9)]).expect("sound knots");
        assert_eq!(table.value(400.0), 0.1);
        assert_eq!(table.value(550.0), 0.5);
        assert_eq!(table.value(700.0), 0.9);
        assert_eq!(table.value(399.9), 0.0);
        assert_eq!(table.value(700.1), 0.0);
        assert!(!table.is_constant());
        assert!(table.is_constant_over([300.0, 399.0]) && !table.is_constant_over([300.0, 400.0]));
        assert_eq!(table.at(550.0), Spectrum::constant(0.5));
    }

    #[test]
    fn a_table_of_one_value_is_constant_where_it_is_known() {
        let knots = vec![(400.0, 0.3), (500.0, 0.3), (600.0, 0.3), (700.0, 0.4)];
        let table = Spectrum::tabulated(knots.clone()).expect("sound knots");
        for (range, expected) in [
            ([400.0, 600.0], true),
            ([420.0, 480.0], true),
            ([399.0, 600.0], false),
            ([400.0, 601.0], false),
            ([300.0, 800.0], false),
            ([750.0, 800.0], true),
        ] {
            assert_eq!(table.is_constant_over(range), expected, "{range:?}");
        }
        let held = Spectrum::tabulated_held(knots).expect("sound knots");
        assert!(held.is_constant_over([300.0, 600.0]) && !held.is_constant_over([300.0, 700.0]));
        let red = Spectrum::rgb_reflectance([0.5, 0.1, 0.1]);
        assert!(!red.is_constant_over([400.0, 700.0]));
        assert!(Spectrum::rgb_reflectance([0.5; 3]).is_constant_over([360.0, 830.0]));
        // white light is that of the day
        assert!(!Spectrum::rgb_emission([1.0; 3]).is_constant_over([360.0, 830.0]));
    }

    #[test]
    fn a_held_table_keeps_its_end_values() {
        let table =
            Spectrum::tabulated_held(vec![(400.0, 0.1), (700.0, 0.9)]).expect("sound knots");
        assert_eq!((table.value(300.0), table.value(900.0)), (0.1, 0.9));
        let single = Spectrum::tabulated_held(vec![(500.0, 0.3)]).expect("one knot");
        assert_eq!((single.value(400.0), single.value(500.0)), (0.3, 0.3));
    }

    #[test]
    fn broken_tables_are_refused_with_a_reason() {
        assert_eq!(
            Spectrum::tabulated(vec![(500.0, 0.1), (400.0, 0.2)]),
            Err("spectrum: expected wavelengths that increase, found 400 nm after 500 nm".into())
        );
        assert!(Spectrum::tabulated(vec![(500.0, 0.1), (500.0, 0.2)]).is_err());
        assert!(Spectrum::tabulated(vec![(500.0, f64::NAN)]).is_err());
        assert!(Spectrum::tabulated(vec![]).is_err());
    }

    #[test]
    fn greys_are_constant() {
        for grey in [0.0, 0.18, 0.5, 1.0] {
            assert_eq!(
                Spectrum::rgb_reflectance([grey; 3]),
                Spectrum::constant(grey)
            );
            assert_eq!(
                Spectrum::rgb_unbounded([3.0 * grey; 3]),
                Spectrum::constant(3.0 * grey)
            );
        }
    }

    #[test]
    fn reflectances_keep_their_colour() {
        // a grid over sRGB, in linear values
        let levels = [0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95];
        for r in levels {
            for g in levels {
                for b in levels {
                    let error = error_of([r, g, b]);
                    assert!(error < 1e-3, "{r} {g} {b}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_corners_of_srgb_come_near() {
        for corner in 1..7u8 {
            let rgb = [0, 1, 2].map(|c| f64::from(corner >> c & 1));
            let error = error_of(rgb);
            assert!(error < 0.02, "{rgb:?}: {error}");
        }
    }

    #[test]
    fn reflectances_lie_between_0_and_1() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [2.0, -1.0, 0.3]] {
            let spectrum = Spectrum::rgb_reflectance(rgb);
            assert!((360..=830).all(|nm| (0.0..=1.0).contains(&spectrum.value(nm as f32))));
        }
    }

    #[test]
    fn emission_reads_its_own_colour() {
        for rgb in [[1.0; 3], [5.0, 1.0, 0.2], [0.0; 3], [0.1, 0.2, 0.9]] {
            let light = Spectrum::rgb_emission(rgb);
            let mut read = [0.0f64; 3];
            for nm in 360..=830 {
                let weights = rgb_weights(nm as f32);
                for c in 0..3 {
                    read[c] += f64::from(weights[c] * light.value(nm as f32));
                }
            }
            let largest = rgb.iter().fold(0.0f64, |a, &b| a.max(b));
            for c in 0..3 {
                assert!(
                    (read[c] - rgb[c]).abs() <= 1e-3 * largest,
                    "{rgb:?} {read:?}"
                );
            }
        }
    }
}
