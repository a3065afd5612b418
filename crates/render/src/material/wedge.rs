//! Films and plates whose thickness changes along the scene.
//!
//! The thickness of all layers is that of the scene file times `1 + w·(x − x₀)`, with a vector w in 1/m (`wedge`) and
//! a point x₀ (`wedge_origin`), both in world space; never less than nothing. Slopes are so small that faces count as
//! parallel.

use glam::Vec3A;

use crate::scene::{Object, SceneError};

/// A linear change of thickness.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    slope: Vec3A,
    origin: Vec3A,
}

impl Wedge {
    /// Reads `wedge` and `wedge_origin`; `None` where the thickness is the same everywhere.
    ///
    /// # Errors
    ///
    /// A `wedge_origin` without `wedge`.
    pub fn read(object: &Object) -> Result<Option<Self>, SceneError> {
        let slope = object.optional_vector("wedge")?;
        let origin = object.optional_point("wedge_origin")?;
        let narrow = |v: [f64; 3]| Vec3A::from_array(v.map(|c| c as f32));
        match (slope, origin) {
            (Some(slope), origin) => Ok(Some(Self {
                slope: narrow(slope),
                origin: narrow(origin.unwrap_or_default()),
            })),
            (None, None) => Ok(None),
            (None, Some(_)) => Err(object.error_at(
                "wedge_origin",
                "'wedge_origin' without 'wedge', expected a vector 'wedge' too",
            )),
        }
    }

    /// The factor on the thickness at a point.
    #[inline]
    pub fn factor(&self, position: Vec3A) -> f64 {
        f64::from(self.slope.dot(position - self.origin) + 1.0).max(0.0)
    }
}
