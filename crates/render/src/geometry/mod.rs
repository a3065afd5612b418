//! Rays, watertight triangles and parallelograms, the bounding volume hierarchy, and error bounds that keep rays off their own surface.

pub mod bounds;
pub mod bvh;
mod choices;
mod collapse;
pub mod flat;
pub mod frame;
pub(crate) mod lanes;
mod node;
pub mod ray;
#[cfg(test)]
mod tests;
mod walk;
