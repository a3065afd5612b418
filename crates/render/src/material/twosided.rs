//! `twosided`: gives one-sided matter a back, the same as the front or another.
//!
//! One or two nested bsdfs: one for both sides, or the front and the back.
//!
//! ```xml
//! <bsdf type="twosided"><bsdf type="roughconductor"/></bsdf>
//! ```
//!
//! Seen from the back the local frame is turned about axis U by 180°: a proper rotation, so that the sense of
//! polarization is kept. (Mitsuba 3.9 mirrors it, which turns the linear polarization of the back by twice the
//! azimuth of the view.)

use glam::Vec3A;

use super::{Departure, Effect, Material, Matter, Part, Traits, Vertex};
use crate::coherence::Coherence;
use crate::light::Light;
use crate::scene::SceneError;

/// Matter with a front and a back.
#[derive(Clone, Debug)]
pub struct TwoSided {
    front: Box<Material>,
    back: Box<Material>,
}

/// Half a turn about axis U.
#[inline]
fn turned(v: Vec3A) -> Vec3A {
    Vec3A::new(v.x, -v.y, -v.z)
}

impl TwoSided {
    /// From the matter of its sides.
    pub fn new(front: Material, back: Material) -> Self {
        Self {
            front: Box::new(front),
            back: Box::new(back),
        }
    }

    /// Front and back.
    pub fn sides(&self) -> [&Material; 2] {
        [&self.front, &self.back]
    }
}

impl TwoSided {
    /// The matter that a viewer sees, and the vertex as that matter describes it.
    #[inline]
    fn seen<'a>(&'a self, at: &Vertex) -> (&'a Material, Vertex, bool) {
        if at.o.z > 0.0 {
            return (&self.front, *at, false);
        }
        let vertex = Vertex {
            o: turned(at.o),
            frame: at.frame.flipped(),
            ..*at
        };
        (&self.back, vertex, true)
    }
}

impl Matter for TwoSided {
    #[inline]
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let (material, vertex, back) = self.seen(at);
        let departure = material.sample(&vertex, wavelengths, u)?;
        Some(if back {
            Departure {
                direction: turned(departure.direction),
                ..departure
            }
        } else {
            departure
        })
    }

    #[inline]
    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let (material, vertex, back) = self.seen(at);
        if !back {
            return material.respond::<L>(&vertex, i, part, wavelengths, coherence);
        }
        let (response, density) =
            material.respond::<L>(&vertex, turned(i), part, wavelengths, coherence);
        (L::map_axes(response, turned), density)
    }

    fn is_grey(&self, range: [f64; 2]) -> bool {
        self.sides().into_iter().all(|side| side.is_grey(range))
    }

    fn effect(&self) -> Effect {
        let [front, back] = self.sides().map(Matter::effect);
        front.and(back)
    }

    fn lobe_width(&self, at: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        let (material, vertex, _) = self.seen(at);
        material.lobe_width(&vertex, wavelengths)
    }

    fn bend(&self, at: &Vertex, part: Part, wavelengths: &[f32]) -> Option<Vec3A> {
        let (material, vertex, back) = self.seen(at);
        let direction = material.bend(&vertex, part, wavelengths)?;
        Some(if back { turned(direction) } else { direction })
    }

    fn traits(&self) -> Traits {
        let [front, back] = self.sides().map(Matter::traits);
        front.or(back)
    }

    fn left_out(&self) -> Option<String> {
        let [front, back] = self.sides().map(Matter::left_out);
        match (front, back) {
            (Some(front), Some(back)) if front == back => Some(front),
            (None, None) => None,
            (front, back) => {
                let named = |side, what: Option<String>| what.map(|what| format!("{side}: {what}"));
                let both = [named("front", front), named("back", back)];
                Some(both.into_iter().flatten().collect::<Vec<_>>().join("; "))
            }
        }
    }

    fn check_wavelengths(&self, range: [f64; 2]) -> Result<(), SceneError> {
        let [front, back] = self.sides();
        front.check_wavelengths(range)?;
        back.check_wavelengths(range)
    }

    fn doubts(&self, range: [f64; 2]) -> Vec<String> {
        self.sides()
            .into_iter()
            .flat_map(|side| side.doubts(range))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::material::Matter;
    use crate::material::testing::material_of;

    #[test]
    fn matter_is_specular_or_black_only_on_both_sides() {
        const MIRROR: &str = "<bsdf type='conductor'/>";
        const BLACK: &str = "<bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>";
        for (front, back, discrete, black) in [
            (MIRROR, MIRROR, true, false),
            (MIRROR, BLACK, false, false),
            (BLACK, MIRROR, false, false),
            (BLACK, BLACK, false, true),
        ] {
            let matter = material_of(&format!("<bsdf type='twosided'>{front}{back}</bsdf>"));
            let traits = matter.unwrap().traits();
            assert_eq!((traits.discrete, traits.black), (discrete, black));
        }
    }

    #[test]
    fn what_either_side_leaves_out_is_said() {
        const ROUGH: &str = "<bsdf type='roughsurface'><string name='material' value='Al'/>\
            <string name='height' value='1um'/><string name='length' value='10um'/></bsdf>";
        const PLAIN: &str = "<bsdf type='diffuse'/>";
        let left_out = |sides: String| {
            let matter = material_of(&format!("<bsdf type='twosided'>{sides}</bsdf>")).unwrap();
            matter.left_out()
        };
        let alone = material_of(ROUGH).unwrap().left_out().unwrap();
        assert_eq!(left_out(ROUGH.to_owned()), Some(alone.clone()));
        assert_eq!(
            left_out(format!("{ROUGH}{PLAIN}")),
            Some(format!("front: {alone}"))
        );
        assert_eq!(
            left_out(format!("{PLAIN}{ROUGH}")),
            Some(format!("back: {alone}"))
        );
        assert_eq!(left_out(PLAIN.to_owned()), None);
    }
}
