//! Rays, watertight triangles and parallelograms, the bounding volume hierarchy, and error bounds that keep rays off their own surface.

pub mod bvh;
pub mod flat;
pub mod frame;
pub mod ray;
