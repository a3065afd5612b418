//! Named optical constants: `material="Au"` of conductors, `int_ior="bk7"` of dielectrics.
//!
//! Names are Mitsuba 3's. The tables under `data/ior` are built into the program; `data/README.md` names their
//! sources. A new material is one CSV file and one row of `CONDUCTORS`.

use crate::spectrum::Spectrum;

/// Name, and CSV with columns `wavelength_nm,n,k`.
const CONDUCTORS: &[(&str, &str)] = &[
    ("a-C", include_str!("../../../data/ior/a-C.csv")),
    ("Ag", include_str!("../../../data/ior/Ag.csv")),
    ("Al", include_str!("../../../data/ior/Al.csv")),
    ("AlAs", include_str!("../../../data/ior/AlAs.csv")),
    ("AlSb", include_str!("../../../data/ior/AlSb.csv")),
    ("Au", include_str!("../../../data/ior/Au.csv")),
    ("Be", include_str!("../../../data/ior/Be.csv")),
    ("Cr", include_str!("../../../data/ior/Cr.csv")),
    ("CsI", include_str!("../../../data/ior/CsI.csv")),
    ("Cu", include_str!("../../../data/ior/Cu.csv")),
    ("Cu2O", include_str!("../../../data/ior/Cu2O.csv")),
    ("CuO", include_str!("../../../data/ior/CuO.csv")),
    ("d-C", include_str!("../../../data/ior/d-C.csv")),
    ("Hg", include_str!("../../../data/ior/Hg.csv")),
    ("HgTe", include_str!("../../../data/ior/HgTe.csv")),
    ("Ir", include_str!("../../../data/ior/Ir.csv")),
    ("K", include_str!("../../../data/ior/K.csv")),
    ("Li", include_str!("../../../data/ior/Li.csv")),
    ("MgO", include_str!("../../../data/ior/MgO.csv")),
    ("Mo", include_str!("../../../data/ior/Mo.csv")),
    ("Na_palik", include_str!("../../../data/ior/Na_palik.csv")),
    ("Nb", include_str!("../../../data/ior/Nb.csv")),
    ("Ni_palik", include_str!("../../../data/ior/Ni_palik.csv")),
    ("Rh", include_str!("../../../data/ior/Rh.csv")),
    ("Se", include_str!("../../../data/ior/Se.csv")),
    ("Se-e", include_str!("../../../data/ior/Se-e.csv")),
    ("SiC", include_str!("../../../data/ior/SiC.csv")),
    ("SnTe", include_str!("../../../data/ior/SnTe.csv")),
    ("Ta", include_str!("../../../data/ior/Ta.csv")),
    ("Te", include_str!("../../../data/ior/Te.csv")),
    ("Te-e", include_str!("../../../data/ior/Te-e.csv")),
    ("ThF4", include_str!("../../../data/ior/ThF4.csv")),
    ("TiC", include_str!("../../../data/ior/TiC.csv")),
    ("TiN", include_str!("../../../data/ior/TiN.csv")),
    ("TiO2", include_str!("../../../data/ior/TiO2.csv")),
    ("TiO2-e", include_str!("../../../data/ior/TiO2-e.csv")),
    ("V_palik", include_str!("../../../data/ior/V_palik.csv")),
    ("VC", include_str!("../../../data/ior/VC.csv")),
    ("VN", include_str!("../../../data/ior/VN.csv")),
    ("W", include_str!("../../../data/ior/W.csv")),
];

/// CSV with columns `name,n`.
const DIELECTRICS: &str = include_str!("../../../data/ior/dielectrics.csv");

/// Index `eta − i k` of a named conductor, as spectra of `eta` and `k`; `None` for an unknown name.
///
/// Linear between the table's wavelengths, end values held outside. `"none"` is the perfect mirror of Mitsuba 3:
/// eta 0, k 1, at every wavelength.
///
/// ```
/// let (eta, k) = render::ior::named_conductor("Au").expect("gold is in the table");
/// assert!((eta.value(633.0) - 0.181).abs() < 1e-3 && (k.value(633.0) - 3.068).abs() < 1e-3);
/// ```
#[must_use]
pub fn named_conductor(name: &str) -> Option<(Spectrum, Spectrum)> {
    if name == "none" {
        return Some((Spectrum::constant(0.0), Spectrum::constant(1.0)));
    }
    let (_, text) = CONDUCTORS.iter().find(|(known, _)| *known == name)?;
    Some(parse(text).expect("the built-in tables are sound (tested)"))
}

/// Index of a named transparent medium; `None` for an unknown name.
///
/// ```
/// assert_eq!(render::ior::named_dielectric("water"), Some(1.333));
/// ```
#[must_use]
pub fn named_dielectric(name: &str) -> Option<f64> {
    dielectrics().find_map(|(known, n)| (known == name).then_some(n))
}

/// The names that [`named_conductor`] knows, for error messages.
pub fn conductor_names() -> impl Iterator<Item = &'static str> {
    CONDUCTORS.iter().map(|(name, _)| *name).chain(["none"])
}

/// The names that [`named_dielectric`] knows, for error messages.
pub fn dielectric_names() -> impl Iterator<Item = &'static str> {
    dielectrics().map(|(name, _)| name)
}

fn dielectrics() -> impl Iterator<Item = (&'static str, f64)> {
    DIELECTRICS.lines().skip(1).filter_map(|line| {
        let (name, n) = line.split_once(',')?;
        Some((name, n.trim().parse().ok()?))
    })
}

fn parse(text: &str) -> Result<(Spectrum, Spectrum), String> {
    let mut eta = Vec::new();
    let mut k = Vec::new();
    for line in text.lines().skip(1) {
        let numbers: Vec<f64> = line
            .split(',')
            .map(|field| field.trim().parse().map_err(|e| format!("'{field}': {e}")))
            .collect::<Result<_, _>>()?;
        let [nm, re, im] = numbers[..] else {
            return Err(format!("expected 3 numbers, found '{line}'"));
        };
        eta.push((nm, re));
        k.push((nm, im));
    }
    Ok((Spectrum::tabulated_held(eta)?, Spectrum::tabulated_held(k)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_material_is_a_possible_index() {
        for name in conductor_names() {
            let (eta, k) = named_conductor(name).expect("a listed name is known");
            for nm in (300..=900).step_by(10) {
                let (eta, k) = (eta.value(nm as f32), k.value(nm as f32));
                assert!(eta >= 0.0 && k >= 0.0 && eta + k > 0.0, "{name} {nm}");
            }
        }
        assert_eq!(dielectric_names().count(), DIELECTRICS.lines().count() - 1);
        assert!(
            dielectric_names()
                .all(|name| named_dielectric(name).is_some_and(|n| (1.0..3.0).contains(&n)))
        );
    }

    #[test]
    fn gold_is_yellow_and_silver_is_not() {
        let reflectance = |name: &str, nm: f32| {
            let (eta, k) = named_conductor(name).expect("a known metal");
            let (eta, k) = (f64::from(eta.value(nm)), f64::from(k.value(nm)));
            ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
        };
        assert!(reflectance("Au", 630.0) > 0.9 && reflectance("Au", 450.0) < 0.5);
        assert!(reflectance("Ag", 630.0) > 0.9 && reflectance("Ag", 450.0) > 0.9);
    }

    #[test]
    fn unknown_names_are_unknown() {
        assert!(named_conductor("gold").is_none());
        assert!(named_dielectric("").is_none());
        assert!(conductor_names().any(|name| name == "none"));
    }
}
