//! What a spectrum looks like: weights from bands to luminance and to linear Rec. 709 colour.
//!
//! For pictures only; measurements read the bands.

use crate::image::{Colour, StokesImage};

/// Luminance of linear Rec. 709 red, green and blue.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The weight of each colour of a pixel in its luminance; they add up to 1.
///
/// Bands are weighted by the eye's sensitivity; all equally where none is visible or the wavelengths are unknown.
pub fn luminance_weights(colour: &Colour) -> Vec<f64> {
    match colour {
        Colour::Mono { .. } => vec![1.0],
        Colour::Rgb => LUMINANCE.to_vec(),
        Colour::Bands { wavelengths_nm } => {
            let y: Vec<f64> = wavelengths_nm.iter().map(|&nm| xyz(nm)[1]).collect();
            let sum: f64 = y.iter().sum();
            if sum > 1e-3 {
                y.iter().map(|w| w / sum).collect()
            } else {
                vec![1.0 / y.len() as f64; y.len()]
            }
        }
    }
}

/// The weights of each colour of a pixel in display red, green and blue: `[colour][rgb]`.
///
/// Bands of equal radiance give equal red, green and blue.
pub fn rgb_weights(colour: &Colour) -> Vec<[f64; 3]> {
    match colour {
        Colour::Mono { .. } => vec![[1.0; 3]],
        Colour::Rgb => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        Colour::Bands { wavelengths_nm } => {
            let rgb: Vec<[f64; 3]> = wavelengths_nm.iter().map(|&nm| rec709(xyz(nm))).collect();
            let sum = rgb
                .iter()
                .fold([0.0; 3], |s, c| [s[0] + c[0], s[1] + c[1], s[2] + c[2]]);
            // few bands, or bands on one side of the spectrum, have no white of their own
            if sum.iter().any(|&s| s < 0.05) {
                return luminance_weights(colour).iter().map(|&w| [w; 3]).collect();
            }
            rgb.iter()
                .map(|c| [c[0] / sum[0], c[1] / sum[1], c[2] / sum[2]])
                .collect()
        }
    }
}

/// S0 as linear display colour: three planes of `height × width` numbers.
pub fn intensity_rgb(image: &StokesImage) -> [Vec<f32>; 3] {
    let weights = rgb_weights(&image.colour);
    let mut planes: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; image.width * image.height]);
    for (index, weight) in weights.iter().enumerate() {
        let s0 = image.plane(0, index);
        for (plane, &w) in planes.iter_mut().zip(weight) {
            for (out, &value) in plane.iter_mut().zip(&s0) {
                // a weight of exactly 0 or 1 copies bit by bit
                if w == 1.0 {
                    *out = value;
                } else if w != 0.0 {
                    *out += (w * f64::from(value)) as f32;
                }
            }
        }
    }
    planes
}

/// CIE 1931 colour matching functions; zero for an unknown wavelength.
///
/// Source: Wyman, Sloan, Shirley, JCGT 2(2), 2013, the multi-lobe fit; within about 1 % of the maximum.
fn xyz(nm: f64) -> [f64; 3] {
    if !nm.is_finite() {
        return [0.0; 3];
    }
    let lobe = |height: f64, mean: f64, below: f64, above: f64| {
        let t = (nm - mean) / if nm < mean { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0)
            + lobe(0.362, 442.0, 16.0, 26.7)
            + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

fn rec709([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_is_most_sensitive_at_555_nm() {
        assert!((xyz(555.0)[1] - 1.0).abs() < 0.01);
        assert!(xyz(450.0)[1] < 0.05);
    }

    #[test]
    fn equal_bands_are_white_and_weights_add_up() {
        let wavelengths_nm = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let colour = Colour::Bands { wavelengths_nm };
        let sum: f64 = luminance_weights(&colour).iter().sum();
        assert!((sum - 1.0).abs() < 1e-12);
        for rgb in 0..3 {
            let sum: f64 = rgb_weights(&colour).iter().map(|w| w[rgb]).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn invisible_and_unknown_bands_count_equally() {
        for wavelengths_nm in [vec![1550.0, 1600.0], vec![f64::NAN; 2]] {
            let colour = Colour::Bands { wavelengths_nm };
            assert_eq!(luminance_weights(&colour), [0.5, 0.5]);
            assert_eq!(rgb_weights(&colour), [[0.5; 3]; 2]);
        }
    }
}
