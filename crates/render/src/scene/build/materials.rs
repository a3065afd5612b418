//! Matter of a scene: one line for each bsdf plugin.

use std::rc::Rc;

use crate::material::birefringent::Birefringent;
use crate::material::circular::Circular;
use crate::material::conductor::Conductor;
use crate::material::dielectric::Dielectric;
use crate::material::diffuse::Diffuse;
use crate::material::grating::Grating;
use crate::material::layered::Layered;
use crate::material::mueller::MuellerElement;
use crate::material::null::Null;
use crate::material::plastic::Plastic;
use crate::material::polarizer::Polarizer;
use crate::material::retarder::Retarder;
use crate::material::rotator::Rotator;
use crate::material::roughconductor::RoughConductor;
use crate::material::roughdielectric::RoughDielectric;
use crate::material::roughsurface::RoughSurface;
use crate::material::scatterer16::Scatterer16;
use crate::material::slits::Slits;
use crate::material::thindielectric::ThinDielectric;
use crate::material::twosided::TwoSided;
use crate::material::{Material, pplastic, roughplastic};
use crate::scene::error::SceneError;
use crate::scene::object::Object;
use crate::scene::plugins;
use crate::scene::tag::Tag;

/// The matter that a bsdf describes; all its parameters are read.
pub(super) fn read_material(object: &Rc<Object>) -> Result<Material, SceneError> {
    let material = match object.plugin.as_str() {
        "diffuse" => Material::Diffuse(Diffuse::read(object)?),
        "conductor" => Material::Conductor(Conductor::read(object)?),
        "roughconductor" => Material::RoughConductor(RoughConductor::read(object)?),
        "roughsurface" => Material::RoughSurface(Box::new(RoughSurface::read(object)?)),
        "dielectric" => Material::Dielectric(Dielectric::read(object)?),
        "pplastic" => Material::RoughlyCoated(pplastic::read(object)?),
        "polarizer" => Material::Polarizer(Polarizer::read(object)?),
        "retarder" => Material::Retarder(Retarder::read(object)?),
        "circular" => Material::Circular(Circular::read(object)?),
        "layered" => Material::Layered(Box::new(Layered::read(object)?)),
        "birefringent" => Material::Birefringent(Box::new(Birefringent::read(object)?)),
        "rotator" => Material::Rotator(Rotator::read(object)?),
        "mueller" => Material::Mueller(MuellerElement::read(object)?),
        "grating" => Material::Grating(Box::new(Grating::read(object)?)),
        "slits" => Material::Slits(Box::new(Slits::read(object)?)),
        "null" => Material::Null(Null),
        "roughdielectric" => Material::RoughDielectric(RoughDielectric::read(object)?),
        "thindielectric" => Material::ThinDielectric(ThinDielectric::read(object)?),
        "plastic" => Material::Plastic(Plastic::read(object)?),
        "roughplastic" => Material::RoughlyCoated(roughplastic::read(object)?),
        "scatterer16" => Material::Scatterer16(Box::new(Scatterer16::read(object)?)),
        "twosided" => {
            let sides = object.children(Tag::Bsdf);
            let [front, back] = match &sides[..] {
                [both] => [both, both],
                [front, back] => [front, back],
                _ => {
                    return Err(object.error(format!(
                        "bsdf 'twosided' holds {} bsdfs, expected one for both sides or one for each",
                        sides.len()
                    )));
                }
            };
            let [front, back] = [front, back].map(|side| {
                let material = read_material(side)?;
                if material.is_two_sided() {
                    return Err(side.error(format!(
                        "{} has two sides already, expected matter with one",
                        side.describe()
                    )));
                }
                Ok(material)
            });
            Material::TwoSided(TwoSided::new(front?, back?))
        }
        _ => return Err(plugins::refuse(object)),
    };
    object.finish()?;
    Ok(material)
}
