//! The kinds of objects in a scene.

/// The kind of an object: the name of its element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Tag {
    /// The root.
    Scene,
    /// How a surface scatters.
    Bsdf,
    /// A surface.
    Shape,
    /// A source of light.
    Emitter,
    /// A camera.
    Sensor,
    /// What collects the image.
    Film,
    /// A reconstruction filter.
    Rfilter,
    /// A source of samples.
    Sampler,
    /// The algorithm.
    Integrator,
    /// A texture; also `<spectrum type="…">`.
    Texture,
    /// What fills a shape.
    Medium,
    /// How a medium scatters.
    Phase,
    /// A quantity in space.
    Volume,
}

impl Tag {
    /// Every kind with the name of its element.
    pub(super) const ALL: [(Self, &'static str); 13] = [
        (Self::Scene, "scene"),
        (Self::Bsdf, "bsdf"),
        (Self::Shape, "shape"),
        (Self::Emitter, "emitter"),
        (Self::Sensor, "sensor"),
        (Self::Film, "film"),
        (Self::Rfilter, "rfilter"),
        (Self::Sampler, "sampler"),
        (Self::Integrator, "integrator"),
        (Self::Texture, "texture"),
        (Self::Medium, "medium"),
        (Self::Phase, "phase"),
        (Self::Volume, "volume"),
    ];

    /// The name of the element.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The kind whose element has this name.
    pub(super) fn of(name: &str) -> Option<Self> {
        let found = Self::ALL.iter().find(|(_, known)| *known == name);
        found.map(|&(tag, _)| tag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_knows_its_element() {
        for (tag, name) in Tag::ALL {
            assert_eq!(tag.name(), name);
            assert_eq!(Tag::of(name), Some(tag));
        }
    }
}
