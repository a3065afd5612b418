//! Spectra of scene files: constants, tables, and colours made into smooth spectra (`spectrum/sigmoid.rs`).

mod sigmoid;

use std::sync::Arc;

use crate::colour;

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
        let coefficients = if grey {
            sigmoid::constant(r)
        } else {
            sigmoid::fit(rgb)
        };
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
                (light * scale * sigmoid::value(coefficients, nm)) as f32
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::rgb_weights;

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
