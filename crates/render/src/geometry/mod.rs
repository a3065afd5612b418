//! Rays, watertight triangles, the bounding volume hierarchy, and error bounds that keep rays off their own surface.

pub mod bvh;
pub mod frame;
pub mod ray;
pub mod triangle;
