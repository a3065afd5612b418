//! The operation `interaction`: Theorem S4.1 from directions, incident modes, sixteen channels and an envelope.

use mueller16::{Energy, Geometry, Matter, Population};
use nalgebra::{Matrix2, Matrix4, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Envelope, Frame, GeneralizedStokes, HermiteSeries, ModeWidth, Mueller, ShapeMatrix,
    StokesVector, mode_count,
};

use super::entry::{DIRECTION, Entry};
use super::fields::{number, wavelength};
use super::functions::{order, shape_with_root};
use super::light::{ENVELOPE, by_order, envelope};
use super::matter::autocorrelation;
use super::result::Item;
use super::schema::CaseError;

/// Coefficients over the covariant family are asked for up to this order.
const COVARIANT: usize = 4;

/// What messages call the sixteen channels.
const CHANNELS: &str = "four rows of four autocorrelations or nulls";

/// Largest distance of a given axis from the right-angled unit axes next to it.
const RIGHT_ANGLED: f64 = 1e-6;

pub(super) fn interaction(inputs: &Entry<'_>) -> Result<Item, CaseError> {
    let geometry = geometry(inputs)?;
    let incoming = Axes::read(inputs, "e_in", -geometry.to_source())?;
    let outgoing = Axes::read(inputs, "e_out", geometry.to_observer())?;
    let light = incident(inputs, &geometry, &incoming)?;
    let profile = envelope(&inputs.get("I", ENVELOPE)?)?;
    let order = order(inputs, "N_out")?;
    let found = scatter(inputs, order, &geometry, &light, &outgoing, &profile)?;

    let per_parameter = |rows: &[Vec<Complex64>; 4], order| {
        let row = |row: &Vec<Complex64>| by_order(order, |place| row[place]);
        Item::List(rows.iter().map(row).collect())
    };
    let p = geometry.outgoing_projection(&outgoing.frame) * outgoing.to_given();
    let samples = samples(inputs, &geometry, &found.stokes, &profile, &p)?;
    let [s0, s1, s2, s3] = samples[0].map(|c| c.re);
    let first = StokesVector::new(s0, s1, s2, s3);
    // numbers that are no light may have a negative intensity, and a degree with its sign
    let degree = if s0 == 0.0 {
        0.0
    } else {
        first.polarized_intensity() / s0
    };
    let map = incoming.to_given() * geometry.incident_map(&incoming.frame, light.distance());
    Ok(Item::Group(vec![
        ("B", map.into()),
        ("phi_t", geometry.tangential().as_slice().to_vec().into()),
        ("P_out", p.into()),
        ("A", found.amplitudes.into()),
        ("S", found.stokes.to_vec().into()),
        ("W_out", (*found.shape.root()).into()),
        ("Theta_out", found.shape.theta().into()),
        ("c_white", per_parameter(&found.white, order)),
        (
            "c_cov",
            per_parameter(&found.covariant, order.min(COVARIANT)),
        ),
        (
            "C_samples",
            samples
                .iter()
                .map(|sample| sample.to_vec())
                .collect::<Vec<_>>()
                .into(),
        ),
        ("intensity", s0.into()),
        ("DoP", degree.into()),
    ]))
}

fn geometry(inputs: &Entry<'_>) -> Result<Geometry, CaseError> {
    let direction = |key| inputs.get(key, DIRECTION)?.direction();
    Geometry::new(
        direction("to_source")?,
        direction("to_observer")?,
        rows(inputs, "t")?,
        wavelength(inputs)?,
    )
    .map_err(|e| inputs.refuse(e))
}

fn rows(inputs: &Entry<'_>, key: &str) -> Result<[Vector3<f64>; 2], CaseError> {
    inputs
        .get(key, "two axes: a list of two lists of three numbers")?
        .array_of(Entry::direction)
}

/// Transverse axes of either handedness: those of a frame but for the sign of the second one.
struct Axes {
    frame: Frame,
    /// 1, or −1 where the given axes are left-handed about the light's propagation.
    handedness: f64,
}

impl Axes {
    fn read(inputs: &Entry<'_>, key: &str, propagation: Vector3<f64>) -> Result<Self, CaseError> {
        let [x, y] = rows(inputs, key)?;
        let refuse = |problem: &dyn std::fmt::Display| CaseError::Domain {
            key: key.to_owned(),
            problem: problem.to_string(),
        };
        let frame = Frame::with_x_along(propagation, x).map_err(|e| refuse(&e))?;
        let handedness = frame.y().dot(&y).signum();
        let off = (x - frame.x())
            .norm()
            .max((y * handedness - frame.y()).norm());
        if off <= RIGHT_ANGLED {
            Ok(Self { frame, handedness })
        } else {
            Err(refuse(&format_args!(
                "found axes {off:e} away from perpendicular unit axes across the ray, expected at most {RIGHT_ANGLED:e}"
            )))
        }
    }

    /// Leads from coordinates in the frame to those in the given axes, and back.
    fn to_given(&self) -> Matrix2<f64> {
        Matrix2::new(1.0, 0.0, 0.0, self.handedness)
    }
}

/// The incident light; a component without modes is absent.
fn incident(
    inputs: &Entry<'_>,
    geometry: &Geometry,
    axes: &Axes,
) -> Result<GeneralizedStokes, CaseError> {
    let spec = inputs.get(
        "incident",
        "the incident light: an object of 'W' and 'modes'",
    )?;
    let shape = shape_with_root(&spec, "W")?
        .in_coordinates(&axes.to_given())
        .map_err(|e| spec.refuse(e))?;
    let mut series = [const { None }; 4];
    let lists = spec
        .get("modes", "four lists of modes [a, b, c]")?
        .array::<4>()?;
    for (series, list) in series.iter_mut().zip(&lists) {
        *series = hermitian(list)?;
    }
    let distance = inputs.get("s", "a distance in metres")?;
    GeneralizedStokes::new(
        Components::Separate(series),
        shape,
        axes.frame,
        geometry.wavelength(),
        distance.number()?,
    )
    .map_err(|e| distance.refuse(e))
}

/// The series of the modes `[a, b, c]`, real where a + b is even and imaginary where it is odd; `None` where there are none.
fn hermitian(list: &Entry<'_>) -> Result<Option<HermiteSeries>, CaseError> {
    let mut modes = vec![];
    for entry in list.list()? {
        let [a, b, c] = entry.array()?;
        let mode = (a.order()?, b.order()?, c.complex()?);
        HermiteSeries::from_modes(&[mode]).map_err(|e| entry.refuse(e))?;
        modes.push(mode);
    }
    if modes.is_empty() {
        return Ok(None);
    }
    let series = HermiteSeries::from_modes(&modes).map_err(|e| list.refuse(e))?;
    Ok(Some(series))
}

/// The matter of the channels `R[l][j]`: that of the real parts of their amplitudes and that of the imaginary ones, each with
/// its unit.
fn matter(channels: &Entry<'_>, profile: &Envelope) -> Result<Vec<(Complex64, Matter)>, CaseError> {
    let mut parts = [vec![], vec![]];
    for (l, row) in channels.array::<4>()?.iter().enumerate() {
        for (j, spec) in row.array::<4>()?.iter().enumerate() {
            if spec.is_null() {
                continue;
            }
            let (amplitude, r) = autocorrelation(spec)?;
            for (part, value) in parts.iter_mut().zip([amplitude.re, amplitude.im]) {
                let mut one = Matrix4::zeros();
                one[(l, j)] = value;
                part.push((value, Mueller::from(one), r.clone()));
            }
        }
    }
    let [real, mut imaginary] = parts;
    imaginary.retain(|(value, ..)| *value != 0.0);
    let mut matter = vec![];
    for (unit, part) in [(Complex64::ONE, real), (Complex64::I, imaginary)] {
        if part.is_empty() {
            continue;
        }
        let populations = part
            .into_iter()
            .map(|(_, one, r)| Population::of_sixteen(&one, r, profile.clone()));
        let made = Matter::new(populations.collect()).map_err(|e| channels.refuse(e))?;
        matter.push((unit, made));
    }
    if matter.is_empty() {
        return Err(channels.refuse("found no channel, expected at least one that is not null"));
    }
    Ok(matter)
}

/// What the theorem says.
struct Scattered {
    /// `A[l][j]`, sums of both parts.
    amplitudes: Vec<Vec<Complex64>>,
    stokes: [Complex64; 4],
    /// In the given axes.
    shape: ShapeMatrix,
    white: [Vec<Complex64>; 4],
    covariant: [Vec<Complex64>; 4],
}

fn scatter(
    inputs: &Entry<'_>,
    order: usize,
    geometry: &Geometry,
    light: &GeneralizedStokes,
    outgoing: &Axes,
    profile: &Envelope,
) -> Result<Scattered, CaseError> {
    let covariant_order = order.min(COVARIANT);
    let channels = inputs.get("R", CHANNELS)?;
    let distance = inputs.get("r", "a distance in metres")?;
    let metres = distance.number()?;
    let p = geometry.outgoing_projection(&outgoing.frame) * outgoing.to_given();
    let zeros = |order| std::array::from_fn(|_| vec![Complex64::ZERO; mode_count(order)]);
    let mut sum = Scattered {
        amplitudes: vec![vec![Complex64::ZERO; 4]; 4],
        stokes: [Complex64::ZERO; 4],
        shape: profile.shape(&p).map_err(|e| inputs.refuse(e))?,
        white: zeros(order),
        covariant: zeros(covariant_order),
    };
    for (unit, matter) in matter(&channels, profile)? {
        let amplitudes = matter
            .channels()
            .amplitudes(geometry, light)
            .map_err(|e| channels.refuse(e))?;
        let modes = matter
            .modes(ModeWidth::VarianceMatched, order)
            .map_err(|e| inputs.refuse(e))?;
        let frame = outgoing.frame;
        let scattered = matter
            .scatter(&modes, geometry, light, Energy::Printed, frame, metres)
            .map_err(|e| distance.refuse(e))?;
        let stokes = amplitudes.stokes(0).to_array();
        for (l, total) in stokes.into_iter().enumerate() {
            for j in 0..4 {
                sum.amplitudes[l][j] += unit * amplitudes.channel(j, l, 0);
            }
            sum.stokes[l] += unit * total;
            for series in scattered.iter().filter_map(|s| s.components().series(l)) {
                // the coefficients do not see whether the axes are mirrored, the covariant ones do
                let covariant = series.truncated(covariant_order).0.to_covariant(&sum.shape);
                add(&mut sum.white[l], unit, all_coefficients(&series));
                add(&mut sum.covariant[l], unit, covariant);
            }
        }
    }
    Ok(sum)
}

fn all_coefficients(series: &HermiteSeries) -> Vec<Complex64> {
    stokes::modes(series.order())
        .map(|(a, b)| series.coefficient(a, b))
        .collect()
}

fn add(sums: &mut [Complex64], unit: Complex64, more: Vec<Complex64>) {
    for (sum, c) in sums.iter_mut().zip(more) {
        *sum += unit * c;
    }
}

/// `C_l(ξ)` at every ξ, from the envelope's own far field: nothing is truncated.
fn samples(
    inputs: &Entry<'_>,
    geometry: &Geometry,
    stokes: &[Complex64; 4],
    profile: &Envelope,
    p: &Matrix2<f64>,
) -> Result<Vec<[Complex64; 4]>, CaseError> {
    let distance = number(inputs, "r")?;
    let k = geometry.wavelength().wavenumber().radians_per_metre();
    let separations = inputs.get("xi", "a list of separations")?;
    let list = separations.list()?;
    if list.is_empty() {
        return Err(separations.refuse("found no separation, expected at least one"));
    }
    let sample = |entry: &Entry<'_>| {
        let w = entry.vector()? * (k / distance);
        let f = profile.far_field(p, &w) / (distance * distance);
        Ok(stokes.map(|s| s * f))
    };
    list.iter().map(sample).collect()
}
