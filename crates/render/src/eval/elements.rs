//! The operation `jones_element`: elements that have a name, as Jones and as Mueller matrices.

use csdm::JonesMatrix;
use nalgebra::Vector2;
use num_complex::Complex64;

use super::entry::Entry;
use super::fields::{jones_matrix, number};
use super::result::Item;
use super::schema::CaseError;

const NAMES: &str = "'identity', 'rotator', 'linear_polarizer', 'partial_polarizer', 'elliptical_polarizer', \
    'right_circular_polarizer', 'left_circular_polarizer', 'linear_retarder', 'quarter_wave_plate', 'half_wave_plate', \
    'circular_retarder', 'elliptical_retarder', 'homogeneous', 'from_eigenpolarizations' or 'matrix'";

pub(super) fn jones_element(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let mut element = named(inputs)?;
    if let Some(angle) = inputs.find("rotated")? {
        element = element.rotated(angle.number()?);
    }
    Ok(Item::Group(vec![
        ("T", element.to_matrix().into()),
        ("M", element.mueller().to_matrix().into()),
        ("singular_values", element.singular_values().to_vec().into()),
        ("diattenuation", element.diattenuation().into()),
        ("retardance", element.retardance().into()),
    ]))
}

fn named(inputs: &Entry<'_>) -> Result<JonesMatrix, CaseError> {
    let real = |key| number(inputs, key);
    let complex = |key| inputs.get(key, "a complex number")?.complex();
    let name = inputs.get("element", NAMES)?;
    Ok(match name.word()? {
        "identity" => JonesMatrix::identity(),
        "rotator" => JonesMatrix::rotator(real("angle")?),
        "linear_polarizer" => JonesMatrix::linear_polarizer(),
        "partial_polarizer" => {
            JonesMatrix::partial_polarizer(real("x")?, real("y")?).map_err(|e| inputs.refuse(e))?
        }
        "elliptical_polarizer" => {
            JonesMatrix::elliptical_polarizer(real("azimuth")?, real("ellipticity")?)
        }
        "right_circular_polarizer" => JonesMatrix::right_circular_polarizer(),
        "left_circular_polarizer" => JonesMatrix::left_circular_polarizer(),
        "linear_retarder" => JonesMatrix::linear_retarder(real("retardance")?),
        "quarter_wave_plate" => JonesMatrix::quarter_wave_plate(),
        "half_wave_plate" => JonesMatrix::half_wave_plate(),
        "circular_retarder" => JonesMatrix::circular_retarder(real("retardance")?),
        "elliptical_retarder" => JonesMatrix::elliptical_retarder(
            real("azimuth")?,
            real("ellipticity")?,
            real("retardance")?,
        ),
        "homogeneous" => JonesMatrix::homogeneous(
            real("azimuth")?,
            real("ellipticity")?,
            complex("first")?,
            complex("second")?,
        ),
        "from_eigenpolarizations" => JonesMatrix::from_eigenpolarizations(
            field(inputs, "first_field")?,
            complex("first")?,
            field(inputs, "second_field")?,
            complex("second")?,
        )
        .map_err(|e| inputs.refuse(e))?,
        "matrix" => jones_matrix(&inputs.get("T", "a Jones matrix")?)?,
        other => return Err(name.refuse(format!("found '{other}', expected {NAMES}"))),
    })
}

fn field(inputs: &Entry<'_>, key: &str) -> Result<Vector2<Complex64>, CaseError> {
    let entry = inputs.get(key, "a field: a list of two complex numbers")?;
    entry.array_of(Entry::complex).map(Vector2::from)
}
