//! Paths that begin on a bare sensor plane: at a vertex that is given, not met.

use glam::Vec3A;

use super::witness::Witness;
use super::{CHOICES, DIRECTION, Origin, Walk, connect};
use crate::coherence::Coherence;
use crate::geometry::ray::{Ray, offset_origin};
use crate::light::{Light, Sight};
use crate::material::{Material, Matter, Part, Vertex};
use crate::shape::Surface;

/// Where a camera path begins.
#[derive(Clone, Copy, Debug)]
pub enum Start<'a> {
    /// On a ray.
    Ray {
        /// The ray.
        ray: Ray,
        /// First axis of its Stokes frame.
        axis: Vec3A,
    },
    /// At a point of a sensor plane.
    Plane(PlanePoint<'a>),
}

/// A point of a sensor plane.
#[derive(Clone, Copy, Debug)]
pub struct PlanePoint<'a> {
    /// Where; the normal of its frame is on the side of the light, the first axis that of its Stokes vectors.
    pub surface: Surface,
    /// What the plane records.
    pub detector: &'a Material,
    /// Unit of the throughput, sr: roulette looks at what is left of all light that could come.
    pub scale: f32,
}

/// First random dimension of the plane: beyond those of every vertex.
const DIMENSIONS: u32 = 1 << 31;

impl<L: Light, W: Witness> Walk<'_, L, W> {
    /// What the path has collected where its throughput counts in `scale`.
    pub(super) fn seen_in(&self, scale: f32) -> L::Stokes {
        let mut seen = L::dark();
        L::accumulate(&mut seen, self.seen, scale);
        seen
    }

    /// Takes the light that emitters send straight to the plane, and draws the direction in which the path goes on.
    #[inline(never)]
    pub(super) fn leave_plane(
        &mut self,
        point: &PlanePoint<'_>,
    ) -> Option<(Ray, L::Throughput, Origin)> {
        let surface = &point.surface;
        let frame = surface.frame;
        let vertex = Vertex {
            o: Vec3A::NEG_Z,
            position: surface.position,
            frame,
            viewer_distance: 0.0,
            sight: Sight::BLIND,
        };
        let mut throughput = L::identity(frame.s);
        L::scale(&mut throughput, point.scale.recip());
        self.witness.meets(frame.n, 1.0);

        // a link from the plane to a light source is the first
        let links = self.options.max_depth.checked_sub(1)?;
        let [choice, drawn] = self.stream.pair(DIMENSIONS + CHOICES);
        let place = connect::Place {
            material: point.detector,
            surface,
            vertex: &vertex,
            lit_frame: &frame,
            lobe: None,
            room: links,
        };
        self.connect(&throughput, &place, choice, DIMENSIONS);

        let [u, v] = self.stream.pair(DIMENSIONS + DIRECTION);
        let departure = point
            .detector
            .sample(&vertex, self.wavelengths, [drawn, u, v])?;
        let (response, _) = point.detector.respond::<L>(
            &vertex,
            departure.direction,
            Part::Continuous,
            self.wavelengths,
            &Coherence::PLANE_WAVE,
        );
        let response = L::map_axes(response, |v| frame.to_world(v));
        let throughput = L::extend(&throughput, response, departure.density.recip(), -frame.n);
        let direction = frame.to_world(departure.direction);
        self.witness.departs(-frame.n, direction, false);
        self.way.begin(direction);
        let origin = Origin {
            position: surface.position,
            lit_frame: frame,
            density: departure.density,
        };
        let ray = Ray {
            origin: offset_origin(surface.position, surface.error, surface.normal, direction),
            direction,
            t_max: f32::INFINITY,
        };
        Some((ray, throughput, origin))
    }
}
