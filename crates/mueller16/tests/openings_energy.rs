//! The power that passes openings: their area, less what is evanescent.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use gauss_quad::GaussLegendre;
use mueller16::{AngularSpectrum, Geometry, LitOpenings, Opening, Openings};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};
use stokes::Wavelength;

const GREEN: f64 = 550e-9;

fn slit(x: f64, width: f64, height: f64) -> Opening {
    Opening::clear(Vector2::new(x, 0.0), width, height)
}

fn power(lit: &LitOpenings<'_>, phi: &Vector2<f64>) -> f64 {
    lit.response(phi).element(0, 0)
}

/// `∫_{-c}^{c} sin²t/t² dt/π` by parts and the alternating tail of the sine integral's series.
fn inside(c: f64) -> f64 {
    let rule = GaussLegendre::new(40.try_into().unwrap());
    let pieces = c.ceil() as usize;
    let width = c / pieces as f64;
    let mut sum = 0.0;
    for i in 0..pieces {
        for (u, p) in &rule {
            let t = (i as f64 + 0.5 + 0.5 * u) * width;
            sum += 0.5 * width * p * (t.sin() / t).powi(2);
        }
    }
    2.0 * sum / PI
}

#[test]
fn albedo_is_the_open_fraction_less_what_is_evanescent() {
    // 1D: slits of 8, 12 and 15 µm at 550 nm keep .9952
    let slits = [(-20e-6, 8e-6), (0.0, 12e-6), (22e-6, 15e-6)].map(|(x, a)| slit(x, a, 1e-3));
    let slits = Openings::new(slits.to_vec(), 1e-6).unwrap();
    let plane = AngularSpectrum::plane_wave();
    let lit = slits.lit_by(&plane).unwrap();
    let rule = GaussLegendre::new(20.try_into().unwrap());
    let (k, pieces) = (TAU / GREEN, 400);
    let width = 2.0 * k / f64::from(pieces);
    let mut sum = 0.0;
    for i in 0..pieces {
        for (u, p) in &rule {
            let phi = Vector2::new(-k + (f64::from(i) + 0.5 + 0.5 * u) * width, 0.0);
            sum += 0.5 * width * p * power(&lit, &phi) / 1e-6;
        }
    }
    let kept = sum / TAU / 35e-6;
    println!("1D: {kept}");
    assert!((kept - 0.9952).abs() < 5e-5);
    // 2D, over the hemisphere: between the square in the circle of propagating waves and the square around it
    let (a, b) = (3e-6, 2e-6);
    let hole = Openings::new(vec![slit(1e-6, a, b)], 4e-11).unwrap();
    let lit = hole.lit_by(&plane).unwrap();
    let green = Wavelength::from_metres(GREEN).unwrap();
    let rows = 48;
    let rule = GaussLegendre::new(24.try_into().unwrap());
    let mut albedo = 0.0;
    for row in 0..rows {
        for (u, p) in &rule {
            // y = sin t, dy = cos t dt; x across the chord the same way
            let t = PI * ((f64::from(row) + 0.5 + 0.5 * u) / f64::from(rows) - 0.5);
            let (y, chord) = t.sin_cos();
            for column in 0..rows {
                for (v, q) in &rule {
                    let s = PI * ((f64::from(column) + 0.5 + 0.5 * v) / f64::from(rows) - 0.5);
                    let (x, z) = (chord * s.sin(), chord * s.cos());
                    let to_observer = Vector3::new(x, y, z);
                    let geometry = Geometry::on_plane(-Vector3::z(), to_observer, green).unwrap();
                    let f = lit.transfer(&geometry).unwrap().element(0, 0);
                    // cos_o dω = dx dy = chord² cos s dt ds... with dy = chord dt, dx = chord cos s ds
                    let cell = (PI / f64::from(rows) * 0.5).powi(2) * p * q;
                    albedo += cell * f * chord * chord * s.cos();
                }
            }
        }
    }
    let half = |size: f64, fraction: f64| inside(0.5 * k * fraction * size);
    let outer = half(a, 1.0) * half(b, 1.0);
    let inner = half(a, 0.5f64.sqrt()) * half(b, 0.5f64.sqrt());
    let fraction = albedo / hole.open_fraction();
    println!("2D: {inner} < {fraction} < {outer}");
    assert!(inner < fraction && fraction < outer);
}
