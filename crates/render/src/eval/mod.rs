//! Formulas of the theorem crates by name, for numbers that come from elsewhere: the table behind `brewster eval`.

mod elements;
pub mod entry;
mod fields;
mod functions;
mod grating;
mod interaction;
mod layers;
mod light;
mod matter;
pub mod population;
mod relief;
pub mod result;
pub mod schema;
mod slits;
mod surface;

use entry::Entry;
use result::Item;
use schema::{Case, CaseError};

/// How the one-dimensional functions are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// In f64, as everything else.
    #[default]
    Double,
    /// In f32, where there is such a road.
    Single,
}

/// An operation.
#[derive(Debug)]
pub struct Op {
    /// Its name in the cases.
    pub name: &'static str,
    /// The inputs it takes; those in brackets may be left out.
    pub inputs: &'static str,
    /// The results it returns.
    pub results: &'static str,
    run: Run,
}

#[derive(Debug)]
enum Run {
    /// Computed in f64.
    Double(fn(&Entry<'_>) -> Result<Item, CaseError>),
    /// Computed in either precision.
    Either(fn(&Entry<'_>, Precision) -> Result<Item, CaseError>),
}

impl Op {
    const fn new(
        name: &'static str,
        inputs: &'static str,
        results: &'static str,
        run: fn(&Entry<'_>) -> Result<Item, CaseError>,
    ) -> Self {
        Self {
            name,
            inputs,
            results,
            run: Run::Double(run),
        }
    }

    const fn either(
        name: &'static str,
        inputs: &'static str,
        results: &'static str,
        run: fn(&Entry<'_>, Precision) -> Result<Item, CaseError>,
    ) -> Self {
        Self {
            name,
            inputs,
            results,
            run: Run::Either(run),
        }
    }
}

/// All operations.
pub const OPS: &[Op] = &[
    Op::either("hermite1d", "n, t", "value", functions::hermite1d),
    Op::either("phi", "a, b, W, x", "value", functions::phi),
    Op::new("psi", "n, m, Theta, x [, dual]", "value", functions::psi),
    Op::new("psi_zero", "n, m, Theta", "value", functions::psi_zero),
    Op::new(
        "ft_psi",
        "n, m, Theta, zeta [, dual]",
        "value",
        functions::ft_psi,
    ),
    Op::new("sym_power", "A, N", "matrix", functions::sym_power),
    Op::new(
        "cov_to_white",
        "W, coeffs",
        "coeffs_white, Theta",
        functions::cov_to_white,
    ),
    Op::new("overlap", "a, b, n, m, W1, W2", "value", functions::overlap),
    Op::new(
        "projection",
        "I, P, N [, W]",
        "W, Theta, white, cov, f0",
        light::projection,
    ),
    Op::new("shape", "I, P", "Theta, minus_hessian", light::shape),
    Op::new(
        "wvd",
        "lambda, r, Theta, Q, modes, zeta",
        "W, intensity",
        light::wvd,
    ),
    Op::new("csd", "lambda, r, Theta, Q, modes, xi", "C", light::csd),
    Op::new(
        "observables",
        "stokes",
        "I, DoP, DoLP, DoCP, AoLP, chi, semi_major, semi_minor, eig",
        light::observables,
    ),
    Op::new("jones", "T1 [, T2]", "M", fields::jones),
    Op::new(
        "phase_screen",
        "sx, sy, cxy, lxx, lyy, lxy, d",
        "M",
        fields::phase_screen,
    ),
    Op::new(
        "fresnel",
        "n1, n2, cos_i",
        "r_s, r_p, t_s, t_p, M_reflect",
        layers::fresnel,
    ),
    Op::new(
        "egsm",
        "lambda, sigma, dxx, dyy, dxy, Ax, Ay, Bxy, z, rho",
        "stokes, spectral_density, DoP, coherence_widths",
        fields::egsm,
    ),
    Op::new("coherency", "M", "H, eigenvalues", fields::coherency),
    Op::new(
        "scatter",
        "R, family, n, m, shape, B, phi",
        "value",
        matter::scatter,
    ),
    Op::new("lobe", "R, phi", "value, coherent_weight", matter::lobe),
    Op::new(
        "interaction",
        "lambda, s, r, to_source, to_observer, t, e_in, e_out, incident, R, I, N_out, xi",
        "B, phi_t, P_out, A, S, W_out, Theta_out, c_white, c_cov, C_samples, intensity, DoP",
        interaction::interaction,
    ),
    Op::new(
        "multilayer",
        "n_incident, layers, n_exit, cos_i, lambda",
        "r_s, r_p, t_s, t_p, R, T, M_reflect, M_transmit",
        layers::multilayer,
    ),
    Op::new(
        "plate",
        "n_incident, layers, n_exit, cos_i, lambda [, azimuth, side, method, coherent_below]",
        "r, t, R, T, M_reflect, M_transmit",
        layers::plate,
    ),
    Op::new(
        "decompose",
        "M [, tolerance]",
        "eigenvalues, depolarization_index, entropy, weights, jones, transmittance, diattenuator, retarder, \
         depolarizer, diattenuation, polarizance, retardance, depolarization_power, nearest_realizable, \
         nearest_of_same_transmittance",
        fields::decompose,
    ),
    Op::new(
        "jones_element",
        "element, … [, rotated]",
        "T, M, singular_values, diattenuation, retardance",
        elements::jones_element,
    ),
    Op::new(
        "surface",
        "boundary, relief, to_source, to_observer, lambda [, n_incident, n_outgoing, light, tolerance, obliquity, shadowing, x_in, x_out]",
        "M, phi_t, phi_z, coherent_weight, method, terms, error, beams",
        surface::surface,
    ),
    Op::new(
        "grating",
        "profile, pitch, to_source, lambda [, across, side, n_incident, n_outgoing]",
        "orders, to_observer, phi_z, amplitude, share, efficiency, lossless",
        grating::grating,
    ),
    Op::new(
        "slits",
        "openings, screen_area, to_source, to_observers, lambda [, n_incident, n_outgoing, light, tolerance, pair, stokes]",
        "M, open_fraction, error, gamma, visibility",
        slits::slits,
    ),
];

/// The operation of that name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Op> {
    OPS.iter().find(|op| op.name == name)
}

impl Op {
    /// The result for the inputs of a case, in the schema's form.
    ///
    /// # Errors
    ///
    /// When an input is missing, of the wrong kind or out of its domain, or a result is not finite.
    pub fn evaluate(
        &self,
        case: &Case,
        precision: Precision,
    ) -> Result<serde_json::Value, CaseError> {
        let inputs = Entry::of(case);
        match self.run {
            Run::Double(run) => run(&inputs),
            Run::Either(run) => run(&inputs, precision),
        }?
        .to_json()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documentation_has_the_table() {
        let text = include_str!("../../../../docs/eval.md");
        let rows: Vec<_> = text
            .lines()
            .filter(|line| line.starts_with("| `"))
            .collect();
        assert_eq!(rows.len(), OPS.len());
        for (op, row) in OPS.iter().zip(rows) {
            assert!(
                row.starts_with(&format!("| `{}` | `{}` |", op.name, op.inputs)),
                "{row}"
            );
            for result in op.results.split(", ") {
                assert!(
                    row.split(|c: char| !c.is_alphanumeric() && c != '_')
                        .any(|word| word == result),
                    "{row}: {result}"
                );
            }
        }
    }
}
