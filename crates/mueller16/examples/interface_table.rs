//! Prints Mueller matrices of interfaces as CSV, for comparison with an independent program.
//!
//! `cargo run -p mueller16 --example interface_table > table.csv`. Columns: index before (`n1`), index behind
//! (`n2 − i k2`), angle of incidence, `R` or `T`, then the 16 elements by rows. Frames: s first, on both rays.

use mueller16::{ConductorInterface, DielectricInterface, IndexError};
use stokes::Mueller;

/// Angles of incidence in degrees: normal, ordinary, Brewster's at 1.5, near grazing.
const ANGLES: [f64; 10] = [0.0, 10.0, 25.0, 40.0, 45.0, 54.6, 56.3099, 70.0, 85.0, 89.9];

/// Pairs of transparent media: up, down, total reflection, nearly equal.
const DIELECTRICS: [[f64; 2]; 7] = [
    [1.0, 1.5],
    [1.5, 1.0],
    [1.0, 1.33],
    [1.51, 1.0],
    [1.5, 1.33],
    [1.0, 2.419],
    [1.0, 1.000277],
];

/// `n1, η, k`: gold, silver, aluminium, copper in water, weak absorbers, a strong one.
const CONDUCTORS: [[f64; 3]; 8] = [
    [1.0, 0.183, 3.43],
    [1.0, 0.136125, 4.010625],
    [1.0, 1.5, 7.3],
    [1.33, 0.2, 3.2],
    [1.0, 1.5, 1e-6],
    [1.5, 1.0, 1e-6],
    [1.5, 1.5, 0.5],
    [1.0, 100.0, 100.0],
];

fn main() -> Result<(), IndexError> {
    print!("n1,n2,k2,angle_deg,kind");
    for row in 0..4 {
        for column in 0..4 {
            print!(",m{row}{column}");
        }
    }
    println!();
    for [n1, n2] in DIELECTRICS {
        let interface = DielectricInterface::new(n1, n2)?;
        for angle in ANGLES {
            let cos_i = angle.to_radians().cos();
            print_row(
                [n1, n2, 0.0, angle],
                "R",
                interface.reflection(cos_i).to_mueller(),
            );
            if let Some(through) = interface.transmission(cos_i) {
                print_row([n1, n2, 0.0, angle], "T", through.element.to_mueller());
            }
        }
    }
    for [n1, eta, k] in CONDUCTORS {
        let interface = ConductorInterface::new(n1, eta, k)?;
        for angle in ANGLES {
            let reflected = interface.reflection(angle.to_radians().cos());
            print_row([n1, eta, k, angle], "R", reflected.to_mueller());
        }
    }
    Ok(())
}

fn print_row([n1, n2, k2, angle]: [f64; 4], kind: &str, m: Mueller) {
    print!("{n1},{n2},{k2},{angle},{kind}");
    for row in 0..4 {
        for column in 0..4 {
            print!(",{:e}", m.element(row, column));
        }
    }
    println!();
}
