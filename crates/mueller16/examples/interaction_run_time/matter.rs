//! Matter and light for the races.

use std::error::Error;

use mueller16::{Autocorrelation, Channels, GaussianTerm, Geometry, IncidentCoherence, Tolerance};
use nalgebra::{Matrix2, Matrix4, Vector2, Vector3};
use stokes::{
    Components, Envelope, Frame, GeneralizedStokes, HermiteSeries, Mueller, ShapeMatrix,
    Wavelength, mode_count,
};

type Anything<T> = Result<T, Box<dyn Error>>;

/// Correlation length, m.
const LENGTH: f64 = 1e-5;
/// Root of light over the surface, 1/m.
pub(crate) const LIGHT: Matrix2<f64> = Matrix2::new(7e4, -5e4, 2e4, 9e4);

/// An encounter at 30°, `off` from the mirror direction in direction cosines.
pub(crate) fn geometry(off: f64) -> Anything<Geometry> {
    let up = |x: f64, y: f64| Vector3::new(x, y, (1.0 - x * x - y * y).sqrt());
    let green = Wavelength::from_metres(550e-9)?;
    Ok(Geometry::on_plane(
        up(0.5, 0.0),
        up(off - 0.5, 0.3 * off),
        green,
    )?)
}

/// Root of an anisotropic correlation, larger by a tenth for every step.
pub(crate) fn root(step: usize) -> Matrix2<f64> {
    Matrix2::new(1.1, 0.4, -0.3, 0.8) * (LENGTH * (1.0 + 0.1 * step as f64))
}

/// A series with every mode, and one of even orders alone.
pub(crate) fn series(order: usize, odd: bool) -> Anything<HermiteSeries> {
    let mut s: Vec<f64> = (0..mode_count(order))
        .map(|i| if i == 0 { 1.0 } else { 0.1 * (i as f64).sin() })
        .collect();
    for (s, (a, b)) in s.iter_mut().zip(stokes::modes(order)) {
        if !odd && (a + b) % 2 == 1 {
            *s = 0.0;
        }
    }
    Ok(HermiteSeries::from_real_coefficients(&s)?)
}

pub(crate) fn light(order: usize) -> Anything<IncidentCoherence> {
    Ok(IncidentCoherence::new(LIGHT, &series(order, true)?)?)
}

/// Light whose four parameters have series of their own, as many as asked for.
pub(crate) fn separate(
    geometry: &Geometry,
    order: usize,
    count: usize,
) -> Anything<GeneralizedStokes> {
    let series = series(order, true)?;
    let components =
        std::array::from_fn(|j| (j < count).then(|| series.scaled(1.0 / (1.0 + j as f64))));
    let frame = Frame::with_x_across(-geometry.to_source(), Vector3::y())?;
    Ok(GeneralizedStokes::new(
        Components::Separate(components),
        ShapeMatrix::from_root(&Matrix2::new(8e-3, 2e-3, 0.0, 9e-3))?,
        frame,
        geometry.wavelength(),
        1.0,
    )?)
}

/// The first `count` of the channels `0 → 0, 1 → 1, 2 → 2, 3 → 3, 1 → 0, …`.
fn places(count: usize) -> Vec<(usize, usize)> {
    let blocks = [(0, 1), (1, 0), (2, 3), (3, 2)];
    let mut places: Vec<_> = (0..4).map(|i| (i, i)).chain(blocks).collect();
    for l in 0..4 {
        for j in 0..4 {
            if !places.contains(&(l, j)) {
                places.push((l, j));
            }
        }
    }
    places.truncate(count);
    places
}

fn mueller(places: &[(usize, usize)]) -> Mueller {
    let mut m = Matrix4::zeros();
    for &(l, j) in places {
        m[(l, j)] = 1.0 / (1.0 + l as f64 + 2.0 * j as f64);
    }
    m.into()
}

/// Channels of one autocorrelation.
pub(crate) fn shared(count: usize, autocorrelation: Autocorrelation) -> Channels {
    Channels::new(&mueller(&places(count)), autocorrelation)
}

/// Channels of which each has an autocorrelation of its own.
pub(crate) fn different(count: usize) -> Anything<Channels> {
    let mut channels = Channels::default();
    for (step, place) in places(count).into_iter().enumerate() {
        let gaussian = Autocorrelation::of_family(&root(step), [GaussianTerm::centred(1.0, 1.0)])?;
        channels = channels.with(&mueller(&[place]), gaussian, 0);
    }
    Ok(channels)
}

/// `count` Gaussians of one shape about the mirror direction.
pub(crate) fn family(root: &Matrix2<f64>, count: usize) -> Anything<Autocorrelation> {
    let terms = (1..=count).map(|m| GaussianTerm::centred(1.0 / count as f64, m as f64));
    Ok(Autocorrelation::of_family(root, terms)?)
}

/// The Gaussians `e^(−g) g^m/m!` of a rough surface with `m ≥ 1` that exceed `least` of the largest.
pub(crate) fn rough(g: f64, least: f64) -> Anything<Autocorrelation> {
    let mode = g.max(1.0) as usize;
    let reach = (12.0 * g.sqrt() + 30.0) as usize;
    // from the largest down and up, each in units of it
    let mut weights: Vec<(usize, f64)> = vec![];
    let mut weight = 1.0;
    for m in (mode.saturating_sub(reach).max(1)..=mode).rev() {
        weights.push((m, weight));
        weight *= m as f64 / g;
    }
    weight = 1.0;
    for m in mode + 1..=mode + reach {
        weight *= g / m as f64;
        weights.push((m, weight));
    }
    // together they are 1 − e^(−g)
    let unit = -(-g).exp_m1() / weights.iter().map(|(_, weight)| weight).sum::<f64>();
    let terms = weights
        .into_iter()
        .filter(|(_, weight)| *weight >= least)
        .map(|(m, weight)| GaussianTerm::centred(weight * unit, m as f64));
    Ok(Autocorrelation::of_family(
        &(Matrix2::identity() * width(g)),
        terms,
    )?)
}

/// The same without its mirror, by the Gaussians that the crate chooses for a tolerance.
pub(crate) fn heights(g: f64, tolerance: Tolerance) -> Anything<Autocorrelation> {
    let root = Matrix2::identity() * width(g);
    let (r, _) = Autocorrelation::of_gaussian_phase(g, &root, tolerance)?;
    Ok(r.without_deltas())
}

/// The limit of great roughness: one Gaussian.
pub(crate) fn very_rough(g: f64) -> Anything<Autocorrelation> {
    let root = Matrix2::identity() * width(g);
    Ok(Autocorrelation::of_family(
        &root,
        [GaussianTerm::centred(1.0, g)],
    )?)
}

/// Root of the height correlation: as long as lobes of every roughness are equally wide.
fn width(g: f64) -> f64 {
    LENGTH * g.max(1.0).sqrt()
}

/// Lamellar grating of 50 % duty and 20 µm, whose orders are as wide as 100 µm of it make them.
pub(crate) fn grating(orders: i32) -> Anything<Autocorrelation> {
    let terms = (-orders..=orders).map(|q| GaussianTerm {
        weight: match q {
            0 => 0.3,
            q if q % 2 == 0 => 0.0,
            q => 0.7 * 4.0 / (std::f64::consts::PI * f64::from(q)).powi(2),
        },
        rate: 1.0,
        shift: Vector2::new(f64::from(q) * std::f64::consts::TAU / 20e-6, 0.0),
    });
    let seen = terms.filter(|term| term.weight != 0.0);
    Ok(Autocorrelation::of_family(
        &(Matrix2::identity() * 1e-4),
        seen,
    )?)
}

/// A Gaussian source as the series of order `order` over a shape of twice its variance; itself for `None`.
pub(crate) fn gaussian_source(order: Option<usize>) -> Anything<IncidentCoherence> {
    let source = Envelope::gaussian(&Matrix2::identity())?;
    let root = Matrix2::identity() * order.map_or(1.0, |_| 2f64.sqrt());
    let shape = ShapeMatrix::from_root(&root)?;
    let modes = source.project(&Matrix2::identity(), &shape, order.unwrap_or(0))?;
    Ok(IncidentCoherence::new(root * 6e4, &modes)?)
}
