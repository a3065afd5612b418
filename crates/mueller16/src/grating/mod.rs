//! Gratings: periodic reliefs, their orders and what each order carries.
//!
//! ```text
//! R(x) = e^(−xᵀS⁻¹x/2) Σ_q p_q e^(iqG·x),     p_q = |t_q|²,     Σ_q p_q = 1
//! ```
//!
//! for a grating whose place is not known (the mean over it). R is complex unless `p_q = p_(−q)`; its transform is real
//! and nowhere negative: one line, or one lobe of area `p_q`, at each `φ_t = qG`.

mod bessel;
mod choice;
mod coupling;
mod mount;
mod pattern;
mod profile;
mod samples;
mod sharing;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::Wavelength;
use thiserror::Error;

use crate::accuracy::{Approximation, Method, Tolerance};
use crate::autocorrelation::{Autocorrelation, AutocorrelationError, GaussianTerm};
use crate::geometry::{Geometry, GeometryError};
use crate::relief::{Relief, SharpOrder};
use profile::check;
use samples::Samples;

pub use coupling::{CoupledOrders, LosslessOrders};
pub use mount::{Mount, Order};
pub use pattern::PolarizationPattern;
pub use profile::{Blaze, Profile};
pub use sharing::Sharing;

/// Largest phase depth `|φ_z| depth`, rad, for which orders are computed.
const DEEPEST: f64 = 1e5;

/// Why numbers are no grating, or it has no such order.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GratingError {
    /// A number is out of its domain.
    #[error("grating: the {what} is {value}, expected a number from {} to {}", .range[0], .range[1])]
    Value {
        /// Which number.
        what: &'static str,
        /// What was found.
        value: f64,
        /// What it may be.
        range: [f64; 2],
    },
    /// A list is too short.
    #[error("grating: {found} {what}, expected at least {least}")]
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many there must be.
        least: usize,
    },
    /// Samples do not fill a cell.
    #[error(
        "grating: {found} samples in rows of {columns}, expected whole rows and at most {most} samples"
    )]
    Samples {
        /// How many were given.
        found: usize,
        /// How many make a row.
        columns: usize,
        /// How many there may be.
        most: usize,
    },
    /// An order that does not leave the surface was asked for.
    #[error(
        "grating: order ({}, {}) is evanescent: the sine of its angle would be {sine}, expected less than 1", .order[0], .order[1]
    )]
    Evanescent {
        /// The order.
        order: [i32; 2],
        /// Length of the tangential part of its direction.
        sine: f64,
    },
    /// More orders propagate than can be listed.
    #[error(
        "grating: about {found} orders propagate, expected at most {most}: the pitch is too long beside the wavelength; \
         describe the surface by its slopes"
    )]
    TooMany {
        /// Their number, estimated.
        found: f64,
        /// The most that are listed.
        most: usize,
    },
    /// The orders on both sides cannot be paired without loss.
    #[error(
        "grating: {incident} directions of incidence are coupled to {outgoing} orders, expected equally many: no lossless \
         sharing is reciprocal"
    )]
    Unpaired {
        /// Number of directions on the side of the source.
        incident: usize,
        /// Number of directions on the side of the observer.
        outgoing: usize,
    },
    /// The directions.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The roughness on the grating.
    #[error(transparent)]
    Autocorrelation(#[from] AutocorrelationError),
}

/// A periodic relief: lines, lines crossed with others, or cells of any shape.
///
/// Orders are counted by two numbers; the second is 0 for lines. Order q of a surface with this relief is at
/// `φ_t = q₁G₁ + q₂G₂`, `G = 2π/pitch` along its direction.
///
/// ```
/// use mueller16::{Grating, Profile, Relief, Tolerance};
/// use nalgebra::Vector2;
/// // 1.6 µm pitch, a sine 120 nm deep, seen with φ_z = 4π/550 nm: J_1(ψ/2)² in each first order
/// let grating = Grating::lines(1.6e-6, Vector2::x(), Profile::sinusoidal(120e-9)?)?;
/// let phi_z = 4.0 * std::f64::consts::PI / 550e-9;
/// let (r, chosen) = grating.autocorrelation(phi_z, Tolerance::relative(1e-9)?)?;
/// assert!((r.at_zero() - 1.0).abs() < 1e-9);
/// let first = grating.amplitude(phi_z, [1, 0]).norm_sqr();
/// assert!((first - libm::jn(1, 0.5 * phi_z * 120e-9).powi(2)).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Grating {
    cell: Cell,
    pitches: [f64; 2],
    directions: [Vector2<f64>; 2],
    /// Root of S, and the largest `|φ_t|` of interest.
    aperture: Option<Matrix2<f64>>,
    reach: f64,
    sharing: Sharing,
}

#[derive(Clone, Debug, PartialEq)]
enum Cell {
    Lines(Profile),
    Crossed([Profile; 2]),
    Sampled(Samples),
}

impl Grating {
    /// Lines of `profile` with the period `pitch`, metres; `across` points across the grooves, a unit vector in the axes
    /// of the surface's tangents.
    ///
    /// # Errors
    ///
    /// When the pitch is not a number between 1e-12 and 1e3 m or `across` is not of unit length (to 1e-6).
    pub fn lines(pitch: f64, across: Vector2<f64>, profile: Profile) -> Result<Self, GratingError> {
        Self::of_cell(Cell::Lines(profile), [pitch; 2], across)
    }

    /// The sum of two line gratings, `h₁(x₁) + h₂(x₂)`: x₁ along `first`, x₂ a quarter turn counter-clockwise from it.
    ///
    /// # Errors
    ///
    /// As [`Grating::lines`].
    pub fn crossed(
        pitches: [f64; 2],
        first: Vector2<f64>,
        profiles: [Profile; 2],
    ) -> Result<Self, GratingError> {
        Self::of_cell(Cell::Crossed(profiles), pitches, first)
    }

    /// Rectangular cells of heights (metres) sampled at equal steps: row after row of `columns` heights, along `first`
    /// within a row, a quarter turn counter-clockwise from it from row to row.
    ///
    /// The phase between the samples is that of as many orders as there are samples, see [`Profile::sampled`].
    ///
    /// # Errors
    ///
    /// As [`Grating::lines`]; when the heights are no whole rows, none, more than 2²², or not between −1 and 1 m.
    pub fn sampled_cells(
        pitches: [f64; 2],
        first: Vector2<f64>,
        heights: Vec<f64>,
        columns: usize,
    ) -> Result<Self, GratingError> {
        let samples = Samples::new(heights, columns)?;
        Self::of_cell(Cell::Sampled(samples), pitches, first)
    }

    fn of_cell(cell: Cell, pitches: [f64; 2], first: Vector2<f64>) -> Result<Self, GratingError> {
        for pitch in pitches {
            check_pitch(pitch)?;
        }
        let first = unit(first)?;
        Ok(Self {
            cell,
            pitches,
            directions: [first, Vector2::new(-first.y, first.x)],
            aperture: None,
            reach: f64::INFINITY,
            sharing: Sharing::default(),
        })
    }

    /// The grating seen through an aperture of Gaussian autocorrelation `e^(−xᵀS⁻¹x/2)`; `covariance` S, 2×2, m².
    ///
    /// An aperture whose amplitude is `e^(−|x|²/w²)` has `S = w² 1`. Orders become lobes of covariance `S⁻¹`.
    ///
    /// # Errors
    ///
    /// When the covariance is not finite, not symmetric or not positive definite.
    pub fn through_aperture(
        mut self,
        covariance: &Matrix2<f64>,
    ) -> Result<Self, AutocorrelationError> {
        let shape = stokes::ShapeMatrix::from_covariance(covariance)?;
        self.aperture = Some(*shape.root());
        Ok(self)
    }

    /// Leaves out of the autocorrelation all orders beyond this tangential wave vector, rad/m.
    ///
    /// No two directions are further apart than `k₀ (n_i + n_o)`, and light of a narrow source meets no order much beyond.
    /// Profiles with steps, whose shares fall as `1/q²`, need far fewer terms so. The bound of the autocorrelation does not
    /// count what is left out here.
    ///
    /// # Errors
    ///
    /// When the wave vector is not positive.
    pub fn within_reach(mut self, tangential: f64) -> Result<Self, GratingError> {
        check("reach", tangential, [f64::MIN_POSITIVE, f64::MAX])?;
        self.reach = tangential;
        Ok(self)
    }

    /// The wave vector `q₁G₁ + q₂G₂` of an order, rad/m, in the axes of the tangents.
    #[must_use]
    pub fn shift(&self, order: [i32; 2]) -> Vector2<f64> {
        let [first, second] = self.lattice();
        // what does not exist for lines adds nothing
        first * f64::from(order[0]) + second * f64::from(order[1])
    }

    /// `G₁` and `G₂`, rad/m; the second is 0 for lines.
    #[must_use]
    pub fn lattice(&self) -> [Vector2<f64>; 2] {
        let [first, second] =
            [0, 1].map(|i| self.directions[i] * (std::f64::consts::TAU / self.pitches[i]));
        match self.cell {
            Cell::Lines(_) => [first, Vector2::zeros()],
            Cell::Crossed(_) | Cell::Sampled(_) => [first, second],
        }
    }

    /// The amplitude `t_q` of an order for the vertical wave vector `phi_z`, rad/m; 0 for an order that lines lack.
    ///
    /// Accuracy and cost as [`Profile::amplitude`]; a sampled cell takes a sum over all samples.
    #[must_use]
    pub fn amplitude(&self, phi_z: f64, order: [i32; 2]) -> Complex64 {
        match &self.cell {
            Cell::Lines(profile) if order[1] == 0 => profile.amplitude(phi_z, order[0]),
            Cell::Lines(_) => Complex64::ZERO,
            Cell::Crossed([first, second]) => {
                first.amplitude(phi_z, order[0]) * second.amplitude(phi_z, order[1])
            }
            Cell::Sampled(samples) => samples.amplitude(phi_z, order),
        }
    }

    /// From the lowest to the highest point, metres.
    #[must_use]
    pub fn depth(&self) -> f64 {
        match &self.cell {
            Cell::Lines(profile) => profile.depth(),
            Cell::Crossed([first, second]) => first.depth() + second.depth(),
            Cell::Sampled(samples) => samples.depth(),
        }
    }

    /// The shorter of its periods, metres.
    #[must_use]
    pub fn pitch(&self) -> f64 {
        match self.cell {
            Cell::Lines(_) => self.pitches[0],
            Cell::Crossed(_) | Cell::Sampled(_) => self.pitches[0].min(self.pitches[1]),
        }
    }

    /// How far scalar orders can be trusted at this vacuum wavelength in a medium of this index.
    #[must_use]
    pub fn validity(&self, wavelength: Wavelength, index: f64) -> Validity {
        Validity {
            pitch_in_wavelengths: self.pitch() * index / wavelength.metres(),
            depth_in_pitches: self.depth() / self.pitch(),
        }
    }

    fn check_phase(&self, phi_z: f64) -> Result<(), GratingError> {
        check(
            "phase depth (rad)",
            phi_z.abs() * self.depth(),
            [0.0, DEEPEST],
        )
    }
}

/// What decides whether a grating's orders may be taken from its phase alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// The (shorter) pitch over the wavelength in the medium.
    pub pitch_in_wavelengths: f64,
    /// The depth over the (shorter) pitch.
    pub depth_in_pitches: f64,
}

impl Validity {
    /// Whether the pitch exceeds 5 wavelengths and the depth is below a quarter of the pitch. Elsewhere the orders are
    /// still defined, reciprocal and passive, but light meets more than a phase.
    #[must_use]
    pub fn is_trusted(&self) -> bool {
        self.pitch_in_wavelengths > 5.0 && self.depth_in_pitches < 0.25
    }

    /// Whether the pitch is below half a wavelength, so that order 0 alone propagates in this medium, from any direction.
    ///
    /// Such a surface acts as a birefringent layer, which a phase does not describe.
    #[must_use]
    pub fn has_order_zero_only(&self) -> bool {
        self.pitch_in_wavelengths < 0.5
    }
}

impl Relief for Grating {
    /// The orders with the most light, as few as leave out less than the tolerance.
    ///
    /// The bound is `Σ p_q` of what is left out (all orders together are 1) over the largest `p_q`: the lobe is a sum of
    /// copies of one non-negative peak, for light of order 0. Where steps in height ask for more orders than are
    /// computed (10,000 to each side; 128 for each direction of crossed lines) the bound exceeds the tolerance and says
    /// by how much; orders out of [`Grating::within_reach`] are not counted in it.
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let depth = self.depth();
        if !(0.0..=DEEPEST).contains(&(phi_z.abs() * depth)) {
            return Err(AutocorrelationError::Depth { phi_z, depth });
        }
        let chosen = choice::choose(self, phi_z, tolerance.get());
        let rate = if self.aperture.is_some() { 1.0 } else { 0.0 };
        let terms = chosen.orders.iter().map(|(order, weight)| GaussianTerm {
            weight: *weight,
            rate,
            shift: self.shift(*order),
        });
        let root = self.aperture.unwrap_or_else(Matrix2::identity);
        let approximation = Approximation {
            method: Method::Orders,
            terms: chosen.orders.len(),
            error: chosen.error,
        };
        Ok((Autocorrelation::of_family(&root, terms)?, approximation))
    }

    /// Those that [`Grating::orders`] lists, with the light [`Sharing`] gives them; none that is sharp behind an aperture.
    fn orders(
        &self,
        geometry: &Geometry,
        tolerance: Tolerance,
    ) -> Result<Option<Vec<SharpOrder>>, GratingError> {
        match self.aperture {
            None => self.sharp_orders(geometry, tolerance).map(Some),
            Some(_) => Ok(Some(vec![])),
        }
    }

    fn energy_cap(&self, geometry: &Geometry) -> Result<f64, GratingError> {
        self.cap(geometry)
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        let along = |profile: &Profile, i: usize| {
            let g = self.directions[i];
            Some(g * g.transpose() * profile.mean_square_slope(self.pitches[i])?)
        };
        match &self.cell {
            Cell::Lines(profile) => along(profile, 0),
            Cell::Crossed([first, second]) => Some(along(first, 0)? + along(second, 1)?),
            Cell::Sampled(_) => None,
        }
    }
}

fn check_pitch(pitch: f64) -> Result<(), GratingError> {
    check("pitch", pitch, [1e-12, 1e3])
}

/// A direction in the surface, brought to unit length.
fn unit(direction: Vector2<f64>) -> Result<Vector2<f64>, GratingError> {
    let length = direction.norm();
    check("length of the direction", length, [1.0 - 1e-6, 1.0 + 1e-6])?;
    Ok(direction / length)
}
