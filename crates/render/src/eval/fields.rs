//! Operations of the crate `csdm` on elements at one point and at two, on ensembles and on Gaussian Schell-model light.

use csdm::{
    CloudeSpectrum, CorrelationLengths, Element, GeneralizedMueller, JonesMatrix, PhaseScreen,
    PolarDecomposition, SchellSource, coherency_matrix,
};
use nalgebra::Vector2;
use stokes::{Mueller, Wavelength};

use super::entry::Entry;
use super::result::Item;
use super::schema::CaseError;

/// What messages call a Jones matrix.
const JONES: &str = "a Jones matrix: a list of two rows of two complex numbers";

pub(super) fn jones(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let first = jones_matrix(&inputs.get("T1", JONES)?)?;
    let second = match inputs.find("T2")? {
        Some(second) => jones_matrix(&second)?,
        None => first,
    };
    let sixteen = GeneralizedMueller::of_jones(&first, &second);
    Ok(Item::Group(vec![("M", sixteen.to_matrix().into())]))
}

pub(super) fn phase_screen(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let number = |key| number(inputs, key);
    let lengths = CorrelationLengths {
        xx: number("lxx")?,
        yy: number("lyy")?,
        xy: number("lxy")?,
    };
    // the closed form is asked for, also where no process has these lengths
    let screen = PhaseScreen::without_spectral_check(
        [number("sx")?, number("sy")?],
        number("cxy")?,
        lengths,
    )
    .map_err(|e| inputs.refuse(e))?;
    let apart = Vector2::new(number("d")?, 0.0);
    let sixteen = screen.generalized_mueller(&Vector2::zeros(), &apart);
    Ok(Item::Group(vec![("M", sixteen.to_matrix().into())]))
}

pub(super) fn egsm(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let number = |key| number(inputs, key);
    let source = SchellSource::new(
        wavelength(inputs)?,
        [number("Ax")?, number("Ay")?],
        inputs
            .get("Bxy", "a complex number or its two parts in a list")?
            .complex_or_parts()?,
        number("sigma")?,
        [number("dxx")?, number("dyy")?, number("dxy")?],
    )
    .map_err(|e| inputs.refuse(e))?;
    let z = number("z")?;
    let light = source
        .stokes(&Vector2::new(number("rho")?, 0.0), z)
        .map_err(|e| inputs.refuse(e))?;
    let [dxx, dyy, dxy] = source.coherence_widths(z);
    let widths = [("dxx", dxx), ("dyy", dyy), ("dxy", dxy)];
    let widths = widths.map(|(name, width)| (name, width.into()));
    Ok(Item::Group(vec![
        ("stokes", light.to_array().to_vec().into()),
        ("spectral_density", light.s0().into()),
        ("DoP", light.degree_of_polarization().into()),
        ("coherence_widths", Item::Group(widths.into())),
    ]))
}

pub(super) fn coherency(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let (entry, mueller) = mueller(inputs)?;
    let spectrum = CloudeSpectrum::of(&mueller).map_err(|e| entry.refuse(e))?;
    Ok(Item::Group(vec![
        ("H", coherency_matrix(&mueller).into()),
        ("eigenvalues", ascending(&spectrum)),
    ]))
}

pub(super) fn decompose(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    /// Rounding of elements that were computed elsewhere.
    const TOLERANCE: f64 = 1e-12;
    let (entry, mueller) = mueller(inputs)?;
    let spectrum = CloudeSpectrum::of(&mueller).map_err(|e| entry.refuse(e))?;
    let tolerance = match inputs.find("tolerance")? {
        Some(tolerance) => tolerance.number()?,
        None => TOLERANCE,
    };
    let mut found: Vec<(&'static str, Item)> = vec![
        ("eigenvalues", ascending(&spectrum)),
        (
            "depolarization_index",
            spectrum.depolarization_index().into(),
        ),
        (
            "nearest_realizable",
            spectrum.nearest_realizable().to_matrix().into(),
        ),
    ];
    if let Ok(nearest) = spectrum.nearest_realizable_of_same_transmittance() {
        found.push(("nearest_of_same_transmittance", nearest.to_matrix().into()));
    }
    if let (Ok(entropy), Ok(mixture)) = (
        spectrum.entropy(tolerance),
        spectrum.jones_matrices(tolerance),
    ) {
        let weights: Vec<_> = mixture.iter().map(|element| element.weight).collect();
        let jones: Vec<_> = mixture.iter().map(|e| e.jones.to_matrix()).collect();
        found.push(("entropy", entropy.into()));
        found.push(("weights", weights.into()));
        found.push(("jones", jones.into()));
    }
    if let Ok(polar) = PolarDecomposition::of(&mueller) {
        found.push(("transmittance", polar.transmittance.into()));
        found.push(("diattenuator", polar.diattenuator.to_matrix().into()));
        found.push(("retarder", polar.retarder.to_matrix().into()));
        found.push(("depolarizer", polar.depolarizer.to_matrix().into()));
        found.push(("diattenuation", polar.diattenuation().to_vec().into()));
        found.push(("polarizance", polar.polarizance().to_vec().into()));
        found.push(("retardance", polar.retardance().to_vec().into()));
        found.push(("depolarization_power", polar.depolarization_power().into()));
    }
    Ok(Item::Group(found))
}

/// The eigenvalues in the order of the schema.
fn ascending(spectrum: &CloudeSpectrum) -> Item {
    let mut eigenvalues = spectrum.eigenvalues();
    eigenvalues.reverse();
    eigenvalues.to_vec().into()
}

/// The Mueller matrix under `M`, and its place for messages.
fn mueller<'a>(inputs: &Entry<'a>) -> Result<(Entry<'a>, Mueller), CaseError> {
    let entry = inputs.get(
        "M",
        "a Mueller matrix: a list of four rows of four real numbers",
    )?;
    let rows = entry.array_of(|row| row.array_of(Entry::number))?;
    Ok((entry, Mueller::from_rows(rows)))
}

pub(super) fn jones_matrix(entry: &Entry<'_>) -> Result<JonesMatrix, CaseError> {
    let [[xx, xy], [yx, yy]] = entry.array_of(|row| row.array_of(Entry::complex))?;
    Ok(JonesMatrix::new(xx, xy, yx, yy))
}

pub(super) fn number(inputs: &Entry<'_>, key: &str) -> Result<f64, CaseError> {
    inputs.get(key, "a finite number")?.number()
}

pub(super) fn wavelength(inputs: &Entry<'_>) -> Result<Wavelength, CaseError> {
    let lambda = inputs.get("lambda", "a wavelength in metres")?;
    Wavelength::from_metres(lambda.number()?).map_err(|e| lambda.refuse(e))
}
