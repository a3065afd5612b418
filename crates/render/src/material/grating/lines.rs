//! The lines of a grating on a surface: where they run, and what their orders carry.

use glam::{DVec2, DVec3};

use super::shares::Shares;
use crate::geometry::frame::Frame;

/// Which way is across the grooves.
#[derive(Clone, Copy, Debug)]
pub(super) enum Across {
    /// In the axes U, V, unit.
    Local(DVec2),
    /// In the world; projected on the surface.
    World(DVec3),
}

/// One set of lines, or two crossed ones.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    pub(super) across: Across,
    pub(super) pitch: f64,
    pub(super) shares: Shares,
    /// A quarter turn from the first.
    pub(super) second: Option<(f64, Shares)>,
}

impl Lines {
    /// Unit vector across the (first) grooves, in the axes of `frame`; axis U where the given direction has no part in
    /// the surface.
    pub(super) fn direction(&self, frame: &Frame) -> DVec2 {
        match self.across {
            Across::Local(v) => v,
            Across::World(v) => {
                let local = frame.to_local(v.as_vec3a()).as_dvec3().truncate();
                let length = local.length();
                if length > 1e-6 {
                    local / length
                } else {
                    DVec2::X
                }
            }
        }
    }

    /// `|t_q|²`
    #[inline]
    pub(super) fn share(&self, q: [i32; 2], phi_z: f64) -> f64 {
        let first = self.shares.get(phi_z, q[0]);
        match &self.second {
            None => first,
            Some((_, shares)) => first * shares.get(phi_z, q[1]),
        }
    }
}
