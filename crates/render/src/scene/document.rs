//! A scene as a whole: its root, its definitions, and what the user should know about it.

use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;

use super::object::Object;
use super::tag::Tag;

/// A scene file and the files that it includes.
#[derive(Debug)]
pub struct Document {
    /// The `<scene>`.
    pub root: Rc<Object>,
    pub(super) notices: Rc<Notices>,
}

impl Document {
    /// The objects at the top level that only matter where a `<ref>` names them: materials, textures, media.
    pub fn definitions(&self) -> Vec<Rc<Object>> {
        [
            Tag::Bsdf,
            Tag::Texture,
            Tag::Medium,
            Tag::Phase,
            Tag::Volume,
        ]
        .iter()
        .flat_map(|&tag| self.root.children(tag))
        .collect()
    }

    /// Remarks for the user that are no errors, each once and with its place, in the order in which they arose.
    pub fn notices(&self) -> Vec<String> {
        self.notices.list.borrow().clone()
    }
}

/// Remarks for the user that are no errors, each kept once.
#[derive(Debug, Default)]
pub(super) struct Notices {
    seen: RefCell<HashSet<String>>,
    list: RefCell<Vec<String>>,
}

impl Notices {
    pub(super) fn add(&self, notice: String) {
        if self.seen.borrow_mut().insert(notice.clone()) {
            self.list.borrow_mut().push(notice);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::xml::tests::scene;

    #[test]
    fn a_parameter_without_effect_is_noticed_once() {
        let document = scene("<bsdf type='a'><float name='near_clip' value='1'/></bsdf>");
        let object = &document.definitions()[0];
        object.without_effect(&["near_clip", "far_clip"]);
        object.without_effect(&["near_clip"]);
        assert!(object.finish().is_ok());
        assert_eq!(
            document.notices(),
            ["scene.xml:1:39: 'near_clip' of bsdf 'a' has no effect here"]
        );
    }

    #[test]
    fn definitions_are_what_only_references_use() {
        let document = scene("<shape type='s'/><medium type='m'/><bsdf type='b'/><bsdf type='c'/>");
        let plugins: Vec<_> = document
            .definitions()
            .iter()
            .map(|o| o.plugin.clone())
            .collect();
        assert_eq!(plugins, ["b", "c", "m"]);
    }
}
