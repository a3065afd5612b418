//! `pplastic`: a diffuse base under a rough dielectric surface; both parts polarize.
//!
//! | parameter              | type            | meaning                                                    | default         |
//! |------------------------|-----------------|------------------------------------------------------------|-----------------|
//! | `diffuse_reflectance`  | spectrum        | reflected fraction of the base                             | 0.5             |
//! | `specular_reflectance` | spectrum        | factor on the surface reflection (not physical)            | 1               |
//! | `int_ior`              | float or string | index of the plastic                                       | `polypropylene` |
//! | `ext_ior`              | float or string | index outside                                              | `air`           |
//! | `distribution`         | string          | `beckmann` or `ggx`                                        | `beckmann`      |
//! | `alpha`                | float           | roughness, or `alpha_u`, `alpha_v` along and across axis U | 0.1             |
//! | `sample_visible`       | boolean         | draw only facets that the viewer sees                      | true            |
//!
//! ```xml
//! <bsdf type="pplastic"><rgb name="diffuse_reflectance" value="0.1, 0.3, 0.5"/><float name="alpha" value="0.05"/></bsdf>
//! ```
//!
//! Light enters through the surface, is depolarized by the base and leaves through the surface: polarized across the
//! plane of reflection near the highlight, along it near the rim. No internal reflections between base and surface.
//! One-sided.
//!
//! Source: Baek et al., Simultaneous Acquisition of Polarimetric SVBRDF and Normals, TOG 37(6), 2018.

use mueller16::DielectricInterface;

use super::coated::{Base, Coat, Passages, RoughlyCoated};
use super::dielectric::read_index;
use super::microfacet::Microfacets;
use crate::scene::{Object, SceneError};

/// Reads its parameters.
pub fn read(object: &Object) -> Result<RoughlyCoated, SceneError> {
    let inside = read_index(object, "int_ior", "polypropylene")?;
    let outside = read_index(object, "ext_ior", "air")?;
    let surface = DielectricInterface::new(outside, inside).map_err(|e| object.error(e))?;
    let base = Base::read(object)?;
    Ok(RoughlyCoated {
        coat: Coat::read(object, surface, Passages::Smooth, base)?,
        facets: Microfacets::read(object)?,
    })
}
