//! Tables of Mueller matrices over wavelength and angle, checked.

use csdm::{CloudeSpectrum, NotRealizable};
use nalgebra::{Matrix4, Vector3};
use stokes::Mueller;

use super::effect_of;
use crate::material::Effect;
use crate::material::index::{Known, rows_of};
use crate::scene::{Object, Position, SceneError};

/// Negative eigenvalues up to this, over the largest, are rounding of the numbers in the file; and so is gain.
const ROUNDING: f64 = 1e-3;
/// Below this nothing needs to be said.
const SILENT: f64 = 1e-6;

/// Matrices by wavelength and angle.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// nm, increasing; one that does not matter if there is one only.
    wavelengths: Vec<f64>,
    /// Radians, increasing.
    angles: Vec<f64>,
    /// Angles within wavelengths.
    matrices: Vec<Mueller>,
    known: Option<Known>,
}

impl Table {
    /// One matrix for everything, from the text `matrix`.
    pub(super) fn of_matrix(object: &Object) -> Result<Self, SceneError> {
        let text = object.required_string("matrix")?;
        let numbers: Option<Vec<f64>> = text
            .split(|c: char| c == ',' || c.is_whitespace())
            .filter(|part| !part.is_empty())
            .map(|part| part.parse().ok().filter(|n: &f64| n.is_finite()))
            .collect();
        let found = match &numbers {
            Some(numbers) => format!("{} numbers", numbers.len()),
            None => format!("'{text}'"),
        };
        let rows = numbers.and_then(|n| <[f64; 16]>::try_from(n).ok());
        let Some(numbers) = rows else {
            return Err(object.error_at(
                "matrix",
                format!("'matrix' of bsdf 'mueller' is {found}, expected 16 numbers, row by row"),
            ));
        };
        let matrix = possible(&numbers)
            .map_err(|e| object.error_at("matrix", format!("'matrix' of bsdf 'mueller': {e}")))?;
        if matrix.1 {
            object.notice_at("matrix", ROUNDED);
        }
        Ok(Self {
            wavelengths: vec![0.0],
            angles: vec![0.0],
            matrices: vec![matrix.0],
            known: None,
        })
    }

    /// The table in the file `filename`.
    pub(super) fn of_file(object: &Object) -> Result<Self, SceneError> {
        let path = object.path("filename")?;
        let text = std::fs::read_to_string(&path).map_err(|e| {
            object.error_at(
                "filename",
                format!("{} cannot be read: {e}", path.display()),
            )
        })?;
        let file: std::sync::Arc<std::path::Path> = path.as_path().into();
        let at = |line: u32, message: String| Position::line(file.clone(), line).error(message);
        let columns = columns_of(&text).map_err(|(line, message)| at(line, message))?;
        let mut rows = Vec::new();
        let mut rounded = false;
        for (line, row) in rows_of(&text) {
            let count = row.as_ref().map_or(0, Vec::len);
            let expected = 16 + columns.keys();
            let row = row
                .ok()
                .filter(|row| row.len() == expected)
                .ok_or_else(|| {
                    at(
                        line,
                        format!("{count} numbers in a row, expected {expected}"),
                    )
                })?;
            let numbers: [f64; 16] = std::array::from_fn(|k| row[columns.keys() + k]);
            let matrix =
                possible(&numbers).map_err(|e| at(line, format!("Mueller matrix: {e}")))?;
            rounded |= matrix.1;
            let angle = columns.angle.map_or(0.0, |c| row[c]);
            if !(0.0..=90.0).contains(&angle) {
                return Err(at(
                    line,
                    format!("an angle of {angle} degrees, expected one from 0 to 90"),
                ));
            }
            let wavelength = columns.wavelength.map_or(0.0, |c| row[c]);
            rows.push((wavelength, angle.to_radians(), matrix.0));
        }
        if rounded {
            object.notice_at("filename", ROUNDED);
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut wavelengths: Vec<f64> = rows.iter().map(|row| row.0).collect();
        wavelengths.dedup();
        let mut angles: Vec<f64> = rows.iter().map(|row| row.1).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        let complete = rows.len() == wavelengths.len() * angles.len()
            && rows
                .iter()
                .enumerate()
                .all(|(i, row)| row.1 == angles[i % angles.len()]);
        if rows.is_empty() || !complete {
            return Err(at(
                0,
                format!(
                    "{} matrices for {} wavelengths and {} angles, expected one for each pair",
                    rows.len(),
                    wavelengths.len(),
                    angles.len()
                ),
            ));
        }
        let known = columns.wavelength.map(|_| Known {
            range: [wavelengths[0], wavelengths[wavelengths.len() - 1]],
            place: object.place_of("filename").clone(),
            what: "the table of bsdf 'mueller'".to_owned(),
        });
        Ok(Self {
            wavelengths,
            angles,
            matrices: rows.into_iter().map(|row| row.2).collect(),
            known,
        })
    }

    /// The matrix at a wavelength in nm and the cosine of the angle to the normal.
    pub(super) fn at(&self, wavelength: f32, cos: f32) -> Mueller {
        if self.matrices.len() == 1 {
            return self.matrices[0];
        }
        let (w, u) = place(&self.wavelengths, f64::from(wavelength));
        let (a, v) = place(&self.angles, f64::from(cos).acos());
        let count = self.angles.len();
        let of = |w: usize, a: usize| {
            self.matrices[w.min(self.wavelengths.len() - 1) * count + a.min(count - 1)].to_matrix()
        };
        let along = |w| of(w, a) * (1.0 - v) + of(w, a + 1) * v;
        Mueller::from(along(w) * (1.0 - u) + along(w + 1) * u)
    }

    /// Whether the matrices are the same at all wavelengths.
    pub(super) fn is_grey(&self) -> bool {
        self.wavelengths.len() == 1
    }

    /// What any of the matrices can do.
    pub(super) fn effect(&self) -> Effect {
        let effects = self.matrices.iter().map(effect_of);
        effects.fold(Effect::default(), Effect::and)
    }

    /// Refuses wavelengths outside the table.
    pub(super) fn check(&self, range: [f64; 2]) -> Result<(), SceneError> {
        self.known
            .as_ref()
            .map_or(Ok(()), |known| known.check(range))
    }
}

const ROUNDED: &str = "the matrices are impossible by less than 1e-3, as rounded numbers are: the nearest \
                       possible ones are taken";

/// The knot at or below a value, and the share of the next; the ends hold.
fn place(knots: &[f64], value: f64) -> (usize, f64) {
    let above = knots.partition_point(|&knot| knot <= value);
    if above == 0 {
        return (0, 0.0);
    }
    if above == knots.len() {
        return (above - 1, 0.0);
    }
    let (low, high) = (knots[above - 1], knots[above]);
    (above - 1, (value - low) / (high - low))
}

/// Where the keys are in a row; the matrix follows.
#[derive(Debug)]
struct Columns {
    wavelength: Option<usize>,
    angle: Option<usize>,
}

impl Columns {
    fn keys(&self) -> usize {
        usize::from(self.wavelength.is_some()) + usize::from(self.angle.is_some())
    }
}

/// Reads the header, or says what is wrong in which line.
fn columns_of(text: &str) -> Result<Columns, (u32, String)> {
    let expected = "expected a header 'wavelength_nm angle_deg m00 m01 ... m33', with one or both of the first two";
    let mut lines = text.lines().enumerate().map(|(i, line)| {
        let line = line.split('#').next().unwrap_or_default().trim();
        (i as u32 + 1, line)
    });
    let (number, header) = lines
        .find(|(_, line)| !line.is_empty())
        .ok_or((0, format!("the file is empty, {expected}")))?;
    let names: Vec<&str> = header
        .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
        .filter(|name| !name.is_empty())
        .collect();
    let at = |name: &str| names.iter().position(|n| *n == name);
    let columns = Columns {
        wavelength: at("wavelength_nm"),
        angle: at("angle_deg"),
    };
    let keys = columns.keys();
    let entries = (0..16).map(|k| format!("m{}{}", k / 4, k % 4));
    let sound = keys > 0 && names.len() == keys + 16 && entries.eq(names[keys..].iter().copied());
    if sound {
        Ok(columns)
    } else {
        Err((number, format!("'{header}', {expected}")))
    }
}

/// The matrix if it is possible, and whether it had to be rounded; else why not.
fn possible(numbers: &[f64; 16]) -> Result<(Mueller, bool), String> {
    let given = Mueller::from(Matrix4::from_row_slice(numbers));
    let spectrum = CloudeSpectrum::of(&given).map_err(|e| e.to_string())?;
    let refuse = |error: NotRealizable| match error {
        NotRealizable::NegativeEigenvalue {
            eigenvalue,
            transmittance,
            ..
        } => format!(
            "eigenvalue {eigenvalue:.6} of its coherency matrix is negative at m00 = {transmittance}, expected none \
             below 0: no mixture of Jones matrices makes it"
        ),
        other => other.to_string(),
    };
    spectrum.check_realizable(ROUNDING).map_err(refuse)?;
    let sound = spectrum.check_realizable(SILENT).is_ok();
    let matrix = if sound {
        given
    } else {
        spectrum.nearest_realizable()
    };
    let gain = gain(&matrix);
    if gain > 1.0 + ROUNDING {
        return Err(format!(
            "it sends out {gain:.6} times the power of some light, expected at most 1; divide it by that"
        ));
    }
    if gain > 1.0 + SILENT {
        return Ok((matrix * gain.recip(), true));
    }
    Ok((matrix, !sound))
}

/// Largest ratio of the power that leaves to the power that comes, forward or backward.
fn gain(mueller: &Mueller) -> f64 {
    let m = mueller.to_matrix();
    let row = Vector3::new(m[(0, 1)], m[(0, 2)], m[(0, 3)]).norm();
    let column = Vector3::new(m[(1, 0)], m[(2, 0)], m[(3, 0)]).norm();
    m[(0, 0)] + row.max(column)
}
