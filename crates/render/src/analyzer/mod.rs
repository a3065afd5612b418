//! Analyzers without geometry: what polarizing matter across every ray, right before the film, lets through.
//!
//! ```text
//! S' = M S                    behind a Mueller matrix M; S0' is what a detector reads
//! I  = a · S,                 a: first row of M
//! a  = ½ (1, cos 2θ, sin 2θ, 0)      linear, transmitting along θ
//! a  = ½ (1, 0, 0, ±1)               circular, right or left handed
//! ```
//!
//! M acts in the frame of each pixel: x is image right, y image up, seen from the sensor, and θ is counter-clockwise from x.
//! So an analyzer turns with the frame over a wide image, where a sheet of polarizer before the camera would not quite.
//!
//! The variance of I needs the covariances of the components. A film that sums products of components
//! ([`crate::film::FilmGeometry::products`]) knows it as if each sample had gone through the analyzer; of a finished image
//! only the variances are known, and `(Σ |a_k| σ_k)²` is never less.
//!
//! Source: Goldstein, Polarized Light, 3rd ed., chapter 6 (Mueller matrices of polarizers, Malus).

use mueller16::element;
use stokes::Mueller;

mod behind;
mod camera;
mod matrix_file;
mod request;
mod write;

pub use behind::Incident;
pub use camera::{MOSAIC, frame_row};
pub use request::{Request, Requests, parse};
pub use write::{AnalyzerReport, AnalyzerRow, Destination, write_all};

/// A named Mueller matrix before the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Analyzer {
    /// What file names call it: `linear30`, `rcp`, the name of a matrix's file.
    pub name: String,
    /// What it is, in words.
    pub description: String,
    /// Acts on the Stokes vectors of pixels, in their frames.
    pub matrix: Mueller,
}

impl Analyzer {
    /// An ideal linear polarizer that transmits along `degrees`, counter-clockwise from image right, seen from the sensor.
    ///
    /// Angles that differ by 180° are the same polarizer and have the same name.
    pub fn linear(degrees: f64) -> Self {
        let turned = degrees.rem_euclid(180.0);
        // millionths of a degree are enough for a name; just below 180 is 0 again
        let name = (turned * 1e6).round() / 1e6 % 180.0;
        Self {
            name: format!("linear{name}"),
            description: format!(
                "linear polarizer that transmits along {name} degrees, counter-clockwise from image right, seen from the sensor"
            ),
            matrix: element::linear_polarizer()
                .to_mueller()
                .rotated(turned.to_radians()),
        }
    }

    /// An ideal circular polarizer, which passes S3 > 0, or S3 < 0 where `left_handed`.
    pub fn circular(left_handed: bool) -> Self {
        let (name, hand, sign) = if left_handed {
            ("lcp", "left", '<')
        } else {
            ("rcp", "right", '>')
        };
        Self {
            name: name.to_owned(),
            description: format!("{hand} circular polarizer: passes S3 {sign} 0"),
            matrix: element::circular_polarizer(left_handed),
        }
    }

    /// The rows of the matrix.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        std::array::from_fn(|row| std::array::from_fn(|column| self.matrix.element(row, column)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stokes::StokesVector;

    #[test]
    fn analyzers_pass_the_state_that_they_are_named_after() {
        let root = std::f64::consts::FRAC_1_SQRT_2;
        for (analyzer, state) in [
            (Analyzer::linear(0.0), [1.0, 1.0, 0.0, 0.0]),
            (Analyzer::linear(45.0), [1.0, 0.0, 1.0, 0.0]),
            (Analyzer::linear(-22.5), [1.0, root, -root, 0.0]),
            (Analyzer::linear(90.0), [1.0, -1.0, 0.0, 0.0]),
            (Analyzer::circular(false), [1.0, 0.0, 0.0, 1.0]),
            (Analyzer::circular(true), [1.0, 0.0, 0.0, -1.0]),
        ] {
            let light = |s: [f64; 4]| StokesVector::from(nalgebra::Vector4::from(s));
            let passed = analyzer.matrix * light(state);
            let error = (passed - light(state)).to_vector().norm();
            assert!(error < 1e-15, "{}: {error}", analyzer.name);
            let [s0, s1, s2, s3] = state;
            let opposite = analyzer.matrix * light([s0, -s1, -s2, -s3]);
            assert!(opposite.to_vector().norm() < 1e-15, "{}", analyzer.name);
        }
    }

    #[test]
    fn one_polarizer_has_one_name() {
        for (degrees, name) in [
            (30.0, "linear30"),
            (-150.0, "linear30"),
            (22.5, "linear22.5"),
            (180.0, "linear0"),
            (-1e-9, "linear0"),
            (-30.0, "linear150"),
        ] {
            assert_eq!(Analyzer::linear(degrees).name, name);
        }
    }
}
