//! Directions of a grating's orders, for any mount.

use nalgebra::{Vector2, Vector3};
use stokes::Wavelength;

use super::{Grating, GratingError};
use crate::geometry::{Geometry, GeometryError};

/// Most orders that are listed.
pub(super) const MOST_LISTED: usize = 100_000;

/// Where light comes from, the surface it meets, and the side on which its orders are asked for.
///
/// ```text
/// n_o o_t = −n_i i_t + qG/k₀          the grating equation; order q propagates where |o_t| < 1
/// ```
///
/// Source: Born & Wolf, Principles of Optics, 7th ed., section 8.6.1; as vectors it holds in conical mounts too.
///
/// ```
/// use mueller16::{Grating, Mount, Profile};
/// use nalgebra::{Vector2, Vector3};
/// use stokes::Wavelength;
/// // a disc's 1.6 µm at normal incidence in green light: orders to ±2, the first at 20.1°
/// let disc = Grating::lines(1.6e-6, Vector2::x(), Profile::lamellar(120e-9, 0.5)?)?;
/// let green = Wavelength::from_metres(550e-9)?;
/// let mount = Mount::reflection(Vector3::z(), [Vector3::x(), Vector3::y()], green, 1.0)?;
/// let orders = disc.orders(&mount)?;
/// assert_eq!(orders.len(), 5);
/// let first = disc.order(&mount, [1, 0])?.geometry.to_observer();
/// assert!((first.x.asin().to_degrees() - 20.105).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// An encounter with any observer on the side where orders are asked for.
    template: Geometry,
    /// Signs of the sides of source and observer along the normal.
    sides: [f64; 2],
}

impl Mount {
    /// Light from `to_source` that a surface with axes `tangents` reflects in a medium of this index.
    ///
    /// # Errors
    ///
    /// As [`Geometry::new`] and [`Geometry::between`]; when the source is at grazing incidence.
    pub fn reflection(
        to_source: Vector3<f64>,
        tangents: [Vector3<f64>; 2],
        wavelength: Wavelength,
        index: f64,
    ) -> Result<Self, GeometryError> {
        Self::new(to_source, tangents, wavelength, [index; 2], 1.0)
    }

    /// Light from `to_source` that passes a surface with axes `tangents` from the first medium into the second.
    ///
    /// # Errors
    ///
    /// As [`Mount::reflection`].
    pub fn transmission(
        to_source: Vector3<f64>,
        tangents: [Vector3<f64>; 2],
        wavelength: Wavelength,
        indices: [f64; 2],
    ) -> Result<Self, GeometryError> {
        Self::new(to_source, tangents, wavelength, indices, -1.0)
    }

    /// The mount of an encounter: its source, and the side of its observer.
    ///
    /// # Errors
    ///
    /// When a direction is at grazing incidence.
    pub fn of(geometry: &Geometry) -> Result<Self, GeometryError> {
        geometry.cosines()?;
        Ok(Self::toward(geometry))
    }

    /// As [`Mount::of`], of an encounter that may graze.
    pub(super) fn toward(geometry: &Geometry) -> Self {
        Self {
            template: *geometry,
            sides: [geometry.cos_incident(), geometry.cos_outgoing()].map(f64::signum),
        }
    }

    fn new(
        to_source: Vector3<f64>,
        tangents: [Vector3<f64>; 2],
        wavelength: Wavelength,
        indices: [f64; 2],
        side: f64,
    ) -> Result<Self, GeometryError> {
        let [t1, t2] = tangents;
        let incident = t1.cross(&t2).dot(&to_source).signum();
        let above = t1.cross(&t2) * (side * incident);
        let template = Geometry::new(to_source, above, tangents, wavelength)?
            .between(indices[0], indices[1])?;
        Self::of(&template)
    }

    /// The encounter in which the surface gives light the tangential wave vector `shift`, rad/m, such as `qG`; `None`
    /// where no propagating direction has it.
    #[must_use]
    pub fn diffracted(&self, shift: &Vector2<f64>) -> Option<Geometry> {
        let found = self.template.observed_at(shift).ok()?;
        (found.cos_outgoing() != 0.0).then_some(found)
    }

    /// The mount of light that comes back along an order, in the medium where that order is.
    ///
    /// # Errors
    ///
    /// When the order is at grazing incidence.
    pub fn reversed(&self, order: &Order) -> Result<Self, GeometryError> {
        Self::of(&order.geometry.reversed())
    }

    /// `o_t = (−n_i i_t + shift/k₀)/n_o`
    pub(super) fn outgoing_tangential(&self, shift: &Vector2<f64>) -> Vector2<f64> {
        let g = &self.template;
        (shift / self.wavenumber() - self.incident_tangential() * g.n_incident()) / g.n_outgoing()
    }

    /// `i_t`
    pub(super) fn incident_tangential(&self) -> Vector2<f64> {
        let [t1, t2] = self.template.tangents();
        let i = self.template.to_source();
        Vector2::new(t1.dot(&i), t2.dot(&i))
    }

    /// `k₀`, rad/m.
    pub(super) fn wavenumber(&self) -> f64 {
        self.template.wavelength().wavenumber().radians_per_metre()
    }

    /// `k₀n_i` and `k₀n_o` with the signs of their sides: times the cosines they add up to `φ_z`.
    pub(super) fn signed_wavenumbers(&self) -> [f64; 2] {
        let k0 = self.wavenumber();
        let g = &self.template;
        [
            k0 * g.n_incident() * self.sides[0],
            k0 * g.n_outgoing() * self.sides[1],
        ]
    }

    pub(super) fn cos_incident(&self) -> f64 {
        self.template.cos_incident().abs()
    }

    pub(super) fn indices(&self) -> [f64; 2] {
        [self.template.n_incident(), self.template.n_outgoing()]
    }
}

/// `√(1 − |t|²)`; `None` unless `|t| < 1`.
pub(super) fn cosine(tangential: &Vector2<f64>) -> Option<f64> {
    let sine = tangential.norm();
    (sine < 1.0).then(|| ((1.0 - sine) * (1.0 + sine)).sqrt())
}

/// A propagating order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Its numbers q₁ and q₂; the second is 0 for lines.
    pub index: [i32; 2],
    /// Its encounter: directions to source and order, `φ_t = qG`, and the `φ_z` of these two directions.
    pub geometry: Geometry,
    /// `p_q = |t_q|²` at that `φ_z`: the share of the incident power, before it is shared among the orders so that no
    /// more leaves than comes, see [`CoupledOrders`](super::CoupledOrders).
    pub share: f64,
}

impl Grating {
    /// The propagating orders of light in this mount.
    ///
    /// # Errors
    ///
    /// When more than 100,000 orders propagate, or the phase depth `|φ_z| depth` exceeds 1e5.
    pub fn orders(&self, mount: &Mount) -> Result<Vec<Order>, GratingError> {
        let centre = mount.outgoing_tangential(&Vector2::zeros());
        let unit = mount.wavenumber() * mount.indices()[1];
        let found = self.propagating(&centre, unit, MOST_LISTED)?;
        found
            .into_iter()
            .filter_map(|index| {
                let geometry = mount.diffracted(&self.shift(index))?;
                Some(self.order_at(index, geometry))
            })
            .collect()
    }

    /// One order.
    ///
    /// # Errors
    ///
    /// When the order is evanescent, with the sine that its angle would have, or as [`Grating::orders`].
    pub fn order(&self, mount: &Mount, index: [i32; 2]) -> Result<Order, GratingError> {
        let shift = self.shift(index);
        let geometry = mount
            .diffracted(&shift)
            .ok_or_else(|| GratingError::Evanescent {
                order: index,
                sine: mount.outgoing_tangential(&shift).norm(),
            })?;
        self.order_at(index, geometry)
    }

    pub(super) fn order_at(
        &self,
        index: [i32; 2],
        geometry: Geometry,
    ) -> Result<Order, GratingError> {
        let phi_z = geometry.normal_component();
        self.check_phase(phi_z)?;
        let share = self.amplitude(phi_z, index).norm_sqr();
        Ok(Order {
            index,
            geometry,
            share,
        })
    }

    /// The orders q with `|centre + (q₁G₁ + q₂G₂)/unit| < 1`, by increasing numbers.
    pub(super) fn propagating(
        &self,
        centre: &Vector2<f64>,
        unit: f64,
        most: usize,
    ) -> Result<Vec<[i32; 2]>, GratingError> {
        let [g1, g2] = self.lattice().map(|g| g / unit);
        let range = |g: Vector2<f64>| {
            let length = g.norm();
            if length == 0.0 {
                return [0.0, 0.0];
            }
            let middle = -centre.dot(&g) / (length * length);
            [
                (middle - 1.0 / length).floor(),
                (middle + 1.0 / length).ceil(),
            ]
        };
        let (first, second) = (range(g1), range(g2));
        let found = [first, second]
            .map(|[low, high]| high - low + 1.0)
            .iter()
            .product::<f64>();
        if found > 2.0 * most as f64 {
            return Err(GratingError::TooMany { found, most });
        }
        let mut orders = vec![];
        for q1 in first[0] as i32..=first[1] as i32 {
            for q2 in second[0] as i32..=second[1] as i32 {
                let at = centre + g1 * f64::from(q1) + g2 * f64::from(q2);
                if at.norm() < 1.0 {
                    orders.push([q1, q2]);
                }
            }
        }
        if orders.len() > most {
            let found = orders.len() as f64;
            return Err(GratingError::TooMany { found, most });
        }
        Ok(orders)
    }
}
