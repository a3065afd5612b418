//! Wavelength to colour: CIE 1931 colour matching, illuminant D65, linear sRGB, and the sampling of wavelengths.
//!
//! The tables are `data/cie/cie1931_2deg_d65.csv`, 360-830 nm at 1 nm, built into the program and read on first use.

use std::sync::LazyLock;

use crate::lanes::{Real, ln};

/// First wavelength of the visible range used here, nm.
pub const FIRST_NM: f64 = 360.0;
/// Last wavelength of the visible range used here, nm.
pub const LAST_NM: f64 = 830.0;

/// Intervals of 1 nm between [`FIRST_NM`] and [`LAST_NM`].
const INTERVALS: usize = 470;

/// What a constant spectrum is divided by, nm: with it radiance 1 reads Y = 1.0010, as in Mitsuba 3.
const LUMINANCE_NORM: f64 = 106.7502593994140625;

/// CIE XYZ to linear sRGB (Rec. 709 primaries, D65 white).
const XYZ_TO_SRGB: [[f64; 3]; 3] = [
    [3.240479, -1.537150, -0.498535],
    [-0.969256, 1.875991, 0.041556],
    [0.055648, -0.204043, 1.057311],
];

/// Rate and centre (nm) of the density by which wavelengths are sampled: sech²(0.0072 (λ − 538)).
const SAMPLING_RATE: f64 = 0.0072;
const SAMPLING_CENTRE: f64 = 538.0;
/// The hyperbolic tangents of 0.0072 (360 − 538) and 0.0072 (830 − 538).
const SAMPLING_ENDS: [f64; 2] = [-0.856_910_625_469_828, 0.970_591_346_940_269_8];

/// The tables at `FIRST_NM + i` nm.
struct Tables {
    /// Linear sRGB response, 1/nm.
    rgb: Vec<[f64; 3]>,
    /// CIE luminance response, 1/nm.
    luminance: Vec<f64>,
    /// D65, scaled so that its luminance reads 1.
    d65: Vec<f64>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let text = include_str!("../../../data/cie/cie1931_2deg_d65.csv");
    parse(text).expect("the built-in CIE table is sound (tested)")
});

fn parse(text: &str) -> Result<Tables, String> {
    let mut tables = Tables {
        rgb: Vec::new(),
        luminance: Vec::new(),
        d65: Vec::new(),
    };
    for (row, line) in text.lines().skip(2).enumerate() {
        let numbers: Vec<f64> = line
            .split(',')
            .map(|field| field.parse().map_err(|e| format!("'{field}': {e}")))
            .collect::<Result<_, _>>()?;
        let [wavelength, x, y, z, d65] = numbers[..] else {
            return Err(format!("row {row}: expected 5 numbers, found '{line}'"));
        };
        if wavelength != FIRST_NM + row as f64 {
            return Err(format!("row {row}: wavelength {wavelength} is out of step"));
        }
        tables
            .rgb
            .push(XYZ_TO_SRGB.map(|[rx, ry, rz]| (rx * x + ry * y + rz * z) / LUMINANCE_NORM));
        tables.luminance.push(y / LUMINANCE_NORM);
        tables.d65.push(d65);
    }
    if tables.d65.len() != INTERVALS + 1 {
        return Err(format!("expected 471 rows, found {}", tables.d65.len()));
    }
    let luminance: f64 = integrate(|i| tables.d65[i] * tables.luminance[i]);
    for value in &mut tables.d65 {
        *value /= luminance;
    }
    Ok(tables)
}

/// Trapezoidal rule over the visible range, of a function of the row.
fn integrate(f: impl Fn(usize) -> f64) -> f64 {
    let inner: f64 = (1..INTERVALS).map(&f).sum();
    0.5 * (f(0) + f(INTERVALS)) + inner
}

/// Row below `wavelength_nm` and how far on to the next it lies; `None` outside the visible range.
fn place(wavelength_nm: f64) -> Option<(usize, f64)> {
    if !(FIRST_NM..=LAST_NM).contains(&wavelength_nm) {
        return None;
    }
    let position = wavelength_nm - FIRST_NM;
    let row = (position as usize).min(INTERVALS - 1);
    Some((row, position - row as f64))
}

/// Response of linear sRGB to light of one wavelength, per nm: integrate `spectrum × rgb_weights` over the visible
/// range for the colour.
///
/// Components are negative where a spectral colour lies outside sRGB; 0 outside 360-830 nm. Linear between the
/// table's nanometres. f32 is the renderer's precision and costs 6e-8 of the peak.
///
/// A spectrum of constant value 1 reads RGB (1.206, 0.949, 0.910), Y = 1.0010:
/// ```
/// let sum = (360..=830).fold([0.0; 3], |sum: [f32; 3], nm| {
///     let w = render::colour::rgb_weights(nm as f32);
///     [sum[0] + w[0], sum[1] + w[1], sum[2] + w[2]]
/// });
/// assert!((sum[0] - 1.2061).abs() < 1e-4 && (sum[1] - 0.9492).abs() < 1e-4 && (sum[2] - 0.9102).abs() < 1e-4);
/// ```
#[must_use]
pub fn rgb_weights(wavelength_nm: f32) -> [f32; 3] {
    let Some((row, on)) = place(f64::from(wavelength_nm)) else {
        return [0.0; 3];
    };
    let (a, b) = (TABLES.rgb[row], TABLES.rgb[row + 1]);
    [0, 1, 2].map(|c| (a[c] + on * (b[c] - a[c])) as f32)
}

/// Colour of a spectrum of constant value 1: the integral of [`rgb_weights`] over the visible range.
pub(crate) fn grey_weights() -> [f32; 3] {
    static WEIGHTS: LazyLock<[f32; 3]> =
        LazyLock::new(|| [0, 1, 2].map(|c| integrate(|i| TABLES.rgb[i][c]) as f32));
    *WEIGHTS
}

/// Illuminant D65 at `wavelength_nm`, scaled so that its luminance, and each of its linear sRGB components to 2e-4,
/// reads 1; 0 outside 360-830 nm.
#[must_use]
pub fn d65(wavelength_nm: f64) -> f64 {
    let Some((row, on)) = place(wavelength_nm) else {
        return 0.0;
    };
    let (a, b) = (TABLES.d65[row], TABLES.d65[row + 1]);
    a + on * (b - a)
}

/// Quadrature weights, one row a nanometre, of the linear sRGB colour of a surface under D65: D65 times response, each
/// component summing to 1.
pub(crate) fn white_weights() -> &'static [[f64; 3]] {
    static WEIGHTS: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
        let weight = |i: usize, c: usize| TABLES.d65[i] * TABLES.rgb[i][c];
        let white = [0, 1, 2].map(|c| integrate(|i| weight(i, c)));
        let end = |i: usize| if i == 0 || i == INTERVALS { 0.5 } else { 1.0 };
        (0..=INTERVALS)
            .map(|i| [0, 1, 2].map(|c| end(i) * weight(i, c) / white[c]))
            .collect()
    });
    &WEIGHTS
}

/// A wavelength in 360-830 nm from a uniform number `u` in `0.0..1.0`, and its density per nm.
///
/// The density is proportional to sech²(0.0072 (λ − 538)), which follows the eye's sensitivity.
///
/// Source: Radziszewski, Boryczko & Alda 2009, An improved technique for full spectral rendering.
///
/// ```
/// let (wavelength_nm, density) = render::colour::sample_wavelength(0.5);
/// assert!((wavelength_nm - 545.9).abs() < 0.1 && (density - 0.00393).abs() < 1e-5);
/// ```
#[must_use]
pub fn sample_wavelength(u: f32) -> (f32, f32) {
    sample_wavelengths(u)
}

/// The same in lanes, with the same bits on every processor.
#[inline(always)]
pub(crate) fn sample_wavelengths<R: Real>(u: R) -> (R, R) {
    let number = |x: f64| R::splat(x as f32);
    let [low, high] = SAMPLING_ENDS;
    let t = number(low) + u * number(high - low);
    let (up, down) = (R::one() + t, R::one() - t);
    // artanh t is half of this logarithm
    let wavelength = number(SAMPLING_CENTRE) + ln(up / down) * number(0.5 / SAMPLING_RATE);
    let density = up * down * number(SAMPLING_RATE / (high - low));
    let first = wavelength.max(number(FIRST_NM));
    (first.min(number(LAST_NM)), density)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_spectrum_has_luminance_one_point_zero_zero_one() {
        let y = integrate(|i| TABLES.luminance[i]);
        assert!((y - 1.0010).abs() < 5e-5, "{y}");
    }

    #[test]
    fn the_colour_matching_functions_have_equal_areas() {
        // the CIE made them so: X = Y = Z for equal energy, hence sRGB sums are the row sums of the matrix
        let y = integrate(|i| TABLES.luminance[i]);
        for (c, row) in XYZ_TO_SRGB.iter().enumerate() {
            let found = integrate(|i| TABLES.rgb[i][c]);
            assert!((found / y - row.iter().sum::<f64>()).abs() < 2e-3);
        }
    }

    #[test]
    fn daylight_is_white() {
        for c in 0..3 {
            let found = integrate(|i| TABLES.rgb[i][c] * TABLES.d65[i]);
            assert!((found - 1.0).abs() < 2e-4, "{c} {found}");
        }
        assert!((d65(560.0) / d65(700.0) - 100.0 / 71.6091).abs() < 1e-6);
    }

    #[test]
    fn green_light_lies_outside_srgb() {
        let [r, g, b] = rgb_weights(520.0);
        assert!(r < 0.0 && g > 0.0 && b < 0.0);
        assert_eq!(rgb_weights(359.9), [0.0; 3]);
        assert_eq!(rgb_weights(831.0), [0.0; 3]);
        assert!(rgb_weights(830.0)[0] > 0.0);
    }

    #[test]
    fn responses_are_linear_between_nanometres() {
        let (a, m, b) = (rgb_weights(450.0), rgb_weights(450.5), rgb_weights(451.0));
        for c in 0..3 {
            assert!((m[c] - 0.5 * (a[c] + b[c])).abs() < 1e-9);
        }
    }

    #[test]
    fn sampled_wavelengths_have_the_density_that_is_claimed() {
        // the slope of the wavelength against u is one over the density
        let steps = 2000;
        for i in 1..steps {
            let u = |i: i32| i as f32 / steps as f32;
            let slope = f64::from(sample_wavelength(u(i + 1)).0 - sample_wavelength(u(i - 1)).0)
                / f64::from(u(i + 1) - u(i - 1));
            let density = f64::from(sample_wavelength(u(i)).1);
            // f32 wavelengths: 3e-5 nm over about 0.2 nm
            assert!(
                (slope * density - 1.0).abs() < 2e-3,
                "{i} {slope} {density}"
            );
        }
        // 1 − t is 0.03 at the long end, and loses two digits of f32: 2e-4 nm
        assert!((sample_wavelength(0.0).0 - 360.0).abs() < 1e-4);
        assert!((sample_wavelength(1.0).0 - 830.0).abs() < 5e-4);
        let ends = [FIRST_NM, LAST_NM].map(|nm| (SAMPLING_RATE * (nm - SAMPLING_CENTRE)).tanh());
        assert!((0..2).all(|i| (ends[i] - SAMPLING_ENDS[i]).abs() < 1e-15));
    }

    #[test]
    fn wavelength_samples_estimate_luminance() {
        let n = 10_000;
        let mean = (0..n)
            .map(|i| {
                let (nm, density) = sample_wavelength((i as f32 + 0.5) / n as f32);
                f64::from(rgb_weights(nm)[1]) / f64::from(density)
            })
            .sum::<f64>()
            / f64::from(n);
        assert!((mean - integrate(|i| TABLES.rgb[i][1])).abs() < 1e-5);
    }

    #[test]
    fn a_damaged_table_is_refused() {
        assert!(parse("#\nhead\n360,1,2,3,4\n361,x,2,3,4\n").is_err());
        assert!(parse("#\nhead\n360,1,2,3,4\n362,1,2,3,4\n").is_err());
        assert!(parse("#\nhead\n360,1,2,3,4\n").is_err());
    }
}
