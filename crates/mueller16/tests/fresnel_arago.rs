//! The laws of Fresnel and Arago (1819) on the interference of polarized light, with two slits.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use csdm::JonesMatrix;
use mueller16::{AngularSpectrum, Opening, Openings};
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, TAU};
use stokes::StokesVector;

fn slit(x: f64, width: f64, height: f64) -> Opening {
    Opening::clear(Vector2::new(x, 0.0), width, height)
}

/// Two slits of these Jones matrices in a plane wave: the Stokes vectors over one fringe.
fn fringes(first: JonesMatrix, second: JonesMatrix, light: StokesVector) -> Vec<StokesVector> {
    let d = 50e-6;
    let with = |x: f64, jones| Opening {
        jones,
        ..slit(x, 1e-6, 1e-5)
    };
    let slits = Openings::new(vec![with(-0.5 * d, first), with(0.5 * d, second)], 1e-9).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    (0..64)
        .map(|i| {
            let phi = Vector2::new(TAU * f64::from(i) / 64.0 / d, 0.0);
            lit.response(&phi) * (1.0 / slit(0.0, 1e-6, 1e-5).fourier(&phi).norm_sqr()) * light
        })
        .collect()
}

/// `(max − min)/2` of each parameter, in units of the intensity of one empty slit.
fn swing(fringes: &[StokesVector]) -> [f64; 4] {
    std::array::from_fn(|l| {
        let values = fringes.iter().map(|s| s.to_array()[l]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        0.5 * (values.fold(f64::NEG_INFINITY, f64::max) - low)
    })
}

#[test]
fn the_four_laws_of_fresnel_and_arago() {
    let horizontal = JonesMatrix::linear_polarizer();
    let vertical = horizontal.rotated(FRAC_PI_2);
    let natural = StokesVector::UNPOLARIZED;
    // 1: light of one polarization interferes as natural light does
    let [s0, ..] = swing(&fringes(horizontal, horizontal, natural));
    assert!((s0 - 1.0).abs() < 1e-13);
    // 2: perpendicular polarizations never make fringes of intensity, whatever the light
    for light in [
        natural,
        StokesVector::DIAGONAL,
        StokesVector::RIGHT_CIRCULAR,
    ] {
        assert!(swing(&fringes(horizontal, vertical, light))[0] < 1e-13);
    }
    // 3: parts of natural light that are brought to one plane afterwards do not, either
    let analyzer = horizontal.rotated(FRAC_PI_2 / 2.0);
    let brought = |light| swing(&fringes(analyzer * horizontal, analyzer * vertical, light));
    assert!(brought(natural)[0] < 1e-13);
    // 4: parts of polarized light do: 2 √(1/4 · 1/4)
    assert!((brought(StokesVector::DIAGONAL)[0] - 0.5).abs() < 1e-13);
    // behind crossed polarizers the fringes are in the polarization: S2 and S3 in quadrature, S0 and S1 at rest
    let crossed = fringes(horizontal, vertical, StokesVector::DIAGONAL);
    let [s0, s1, s2, s3] = swing(&crossed);
    assert!(s0 < 1e-13 && s1 < 1e-13);
    assert!((s2 - 1.0).abs() < 1e-13 && (s3 - 1.0).abs() < 1e-13);
    // the vertical slit is at +d/2: toward +x its way is the shorter, its field ahead, (1, e^(+iδ)): S3 = 2 Im(E_x* E_y)
    let quarter = crossed[16].to_array();
    assert!((quarter[3] - 1.0).abs() < 1e-13 && quarter[2].abs() < 1e-13);
}
