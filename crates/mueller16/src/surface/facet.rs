//! The facet of a surface that leads one direction into the other, and the s and p axes about it.

use nalgebra::Vector3;
use stokes::{Frame, FrameError, FrameRotation, Mueller};

use super::error::SurfaceError;
use crate::geometry::Geometry;

/// Sine below which the plane of incidence is taken anywhere: what it decides is of the order of the sine.
///
/// Above it, s is known to rounding over the sine, and what depends on s is of the order of the sine.
const NO_PLANE: f64 = 1e-14;
/// Largest angle between a ray and its frame.
const SAME_RAY: f64 = 1e-6;

/// The frames in which a Mueller matrix is written: `z` along the propagation of the incident, respectively the outgoing
/// light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayFrames {
    /// Of the incident light; `z` points away from the source.
    pub incident: Frame,
    /// Of the outgoing light; `z` points to the observer.
    pub outgoing: Frame,
}

impl RayFrames {
    /// The frames whose first axes are s about the surface's normal, `normal × propagation`; the first tangent where a ray
    /// is along the normal.
    ///
    /// # Errors
    ///
    /// Never for directions and tangents of unit length.
    pub fn of_surface(geometry: &Geometry) -> Result<Self, FrameError> {
        let [t1, _] = geometry.tangents();
        let of = |k: Vector3<f64>| {
            Frame::with_x_across(k, geometry.normal()).or_else(|_| Frame::with_x_along(k, t1))
        };
        Ok(Self {
            incident: of(-geometry.to_source())?,
            outgoing: of(geometry.to_observer())?,
        })
    }

    /// The frames of light that goes the other way, each `(x, −y, −z)` and the two exchanged.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            incident: self.outgoing.reversed(),
            outgoing: self.incident.reversed(),
        }
    }

    pub(super) fn check(&self, geometry: &Geometry) -> Result<(), SurfaceError> {
        let pairs = [
            ("incident", self.incident.z() + geometry.to_source()),
            ("outgoing", self.outgoing.z() - geometry.to_observer()),
        ];
        for (ray, off) in pairs {
            let angle = off.norm();
            if angle.is_nan() || angle > SAME_RAY {
                return Err(SurfaceError::Frame { ray, angle });
            }
        }
        Ok(())
    }
}

/// One facet met by light: the only one that leads the source's direction into the observer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    /// On the side of the surface's normal, unit length.
    normal: Vector3<f64>,
    /// Whether the source is behind the surface.
    pub(super) from_behind: bool,
    /// Whether the observer is on the other side.
    pub(super) transmitted: bool,
    /// Cosine of the angle of incidence on the facet, in `0.0..=1.0`.
    pub(super) cos_i: f64,
    /// Its sine, to its own digits near the normal.
    pub(super) sin_i: f64,
    /// `normal × propagation`, unit length, common to both rays.
    s: Vector3<f64>,
}

impl Facet {
    /// The facet `h = φ/|φ|`; `None` where there is none, or it is met from its back on one of the sides.
    pub(super) fn between(geometry: &Geometry, frames: &RayFrames) -> Option<Self> {
        Self::along(geometry, geometry.half_vector()?, frames)
    }

    /// The facet of normal `normal`, which must be on the side of the surface's.
    pub(super) fn along(
        geometry: &Geometry,
        normal: Vector3<f64>,
        frames: &RayFrames,
    ) -> Option<Self> {
        let (i, o) = (geometry.to_source(), geometry.to_observer());
        let (on_i, on_o) = (normal.dot(&i), normal.dot(&o));
        let front = on_i * geometry.cos_incident() > 0.0 && on_o * geometry.cos_outgoing() > 0.0;
        if !front {
            return None;
        }
        let across = i.cross(&normal);
        let sine = across.norm();
        let s = if sine > NO_PLANE {
            across / sine
        } else {
            frames.incident.x()
        };
        let transmitted = !geometry.is_reflection();
        let cos_i = if transmitted {
            on_i.abs()
        } else {
            // i·h = |i + o|/2 keeps its digits where both directions graze
            0.5 * (i + o).norm()
        };
        Some(Self {
            normal,
            from_behind: geometry.cos_incident() < 0.0,
            transmitted,
            cos_i: cos_i.min(1.0),
            sin_i: sine.min(1.0),
            s,
        })
    }

    /// A matrix between the s–p frames of the facet, written between other frames.
    pub(super) fn in_frames(&self, mueller: &Mueller, frames: &RayFrames) -> Mueller {
        from_axes(mueller, [self.s, self.s], frames)
    }

    /// Angle from the x axis of a plate that lies on the facet to s, radians.
    ///
    /// The plate's z axis points into the surface; its x axis is the surface's first tangent, turned with the normal into
    /// the facet.
    pub(super) fn azimuth(&self, geometry: &Geometry) -> f64 {
        let (n, h, [t1, _]) = (geometry.normal(), self.normal, geometry.tangents());
        let x = t1 - (n + h) * (t1.dot(&h) / (1.0 + n.dot(&h)));
        let y = x.cross(&h);
        self.s.dot(&y).atan2(self.s.dot(&x))
    }
}

/// A matrix between frames whose first axes are `axes`, projected across each ray, written between other frames.
pub(super) fn from_axes(mueller: &Mueller, axes: [Vector3<f64>; 2], frames: &RayFrames) -> Mueller {
    let [incident, outgoing] = axes;
    let to = |frame: &Frame, axis: Vector3<f64>| {
        FrameRotation::from_axis(frame.x().dot(&axis), frame.y().dot(&axis)).inverse()
    };
    mueller.in_frames(
        to(&frames.incident, incident),
        to(&frames.outgoing, outgoing),
    )
}
