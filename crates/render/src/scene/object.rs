//! Objects of a scene (`<bsdf>`, `<shape>`, …), their children, and what nobody has asked them for.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::rc::Rc;

use super::document::Notices;
use super::error::{Position, SceneError, suggestion};
use super::search::Search;
use super::tag::Tag;
use super::value::Value;

/// A parameter of an object.
#[derive(Debug)]
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) position: Position,
    pub(super) read: Cell<bool>,
}

/// An object inside an object, or the object that a `<ref>` stands for.
#[derive(Debug)]
pub(super) struct Child {
    pub(super) name: Option<String>,
    /// Of the element or of the `<ref>`.
    pub(super) position: Position,
    pub(super) object: Rc<Object>,
    pub(super) read: Cell<bool>,
}

/// One object of a scene: a kind, a plugin, parameters and other objects.
#[derive(Debug)]
pub struct Object {
    /// The kind.
    pub tag: Tag,
    /// The plugin, from the attribute `type`; `scene` for the root.
    pub plugin: String,
    /// The name by which `<ref>` finds it.
    pub id: Option<String>,
    /// Where its element starts.
    pub position: Position,
    pub(super) parameters: Vec<Parameter>,
    pub(super) children: Vec<Child>,
    pub(super) search: Search,
    pub(super) notices: Rc<Notices>,
    /// Names of parameters and children that were asked for.
    pub(super) asked: RefCell<BTreeSet<String>>,
}

impl Object {
    /// The object in words: `bsdf 'diffuse'`.
    pub fn describe(&self) -> String {
        match self.tag {
            Tag::Scene => "the scene".to_owned(),
            tag => format!("{} '{}'", tag.name(), self.plugin),
        }
    }

    /// An error at the object.
    pub fn error(&self, message: impl Display) -> SceneError {
        self.position.error(message)
    }

    /// An error at a parameter or a named child, or at the object where it has none of that name.
    pub fn error_at(&self, name: &str, message: impl Display) -> SceneError {
        self.place_of(name).error(message)
    }

    /// Where a parameter or a named child is, or the object where it has none of that name.
    pub fn place_of(&self, name: &str) -> &Position {
        let parameter = self.parameters.iter().find(|p| p.name == name);
        let child = || {
            self.children
                .iter()
                .find(|c| c.name.as_deref() == Some(name))
        };
        parameter
            .map(|p| &p.position)
            .or_else(|| child().map(|c| &c.position))
            .unwrap_or(&self.position)
    }

    /// Whether the file gives a parameter or a child of that name. Does not count as reading it.
    pub fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|p| p.name == name)
            || self
                .children
                .iter()
                .any(|c| c.name.as_deref() == Some(name))
    }

    /// The objects of one kind inside this one, in the order of the file, named ones included.
    pub fn children(&self, tag: Tag) -> Vec<Rc<Self>> {
        let of_kind = self.children.iter().filter(|c| c.object.tag == tag);
        of_kind
            .map(|child| {
                child.read.set(true);
                child.object.clone()
            })
            .collect()
    }

    /// The object of one kind inside this one, if there is one.
    ///
    /// # Errors
    ///
    /// A second one, at its place.
    pub fn child(&self, tag: Tag) -> Result<Option<Rc<Self>>, SceneError> {
        let mut of_kind = self.children.iter().filter(|c| c.object.tag == tag);
        let first = of_kind.next();
        if let Some(second) = of_kind.next() {
            return Err(second.position.error(format!(
                "second {} in {}, expected at most one",
                second.object.describe(),
                self.describe()
            )));
        }
        Ok(first.map(|child| {
            child.read.set(true);
            child.object.clone()
        }))
    }

    /// The object with this name inside this one, such as `<texture name="reflectance" …>`.
    ///
    /// # Errors
    ///
    /// A parameter of that name instead, at its place.
    pub fn named_child(&self, name: &str) -> Result<Option<Rc<Self>>, SceneError> {
        self.asked.borrow_mut().insert(name.to_owned());
        if let Some(parameter) = self.parameters.iter().find(|p| p.name == name) {
            return Err(parameter.position.error(format!(
                "parameter '{name}' of {} is {}, expected an object",
                self.describe(),
                parameter.value.describe()
            )));
        }
        let mut children = self.children.iter();
        let child = children.find(|c| c.name.as_deref() == Some(name));
        Ok(child.map(|child| {
            child.read.set(true);
            child.object.clone()
        }))
    }

    /// Accepts parameters that exist in Mitsuba and change nothing here; one notice names those that are given.
    pub fn without_effect(&self, names: &[&str]) {
        let mut given = Vec::new();
        for &name in names {
            self.asked.borrow_mut().insert(name.to_owned());
            for parameter in self.parameters.iter().filter(|p| p.name == name) {
                parameter.read.set(true);
                given.push(name);
            }
        }
        if let Some(first) = given.first() {
            let list = given.join("', '");
            let verb = if given.len() == 1 { "has" } else { "have" };
            let whose = self.describe();
            self.notice_at(first, format!("'{list}' of {whose} {verb} no effect here"));
        }
    }

    /// Tells the user something about a parameter (or the object, where it has none of that name) that is no error.
    pub fn notice_at(&self, name: &str, message: impl Display) {
        self.notices.add(self.error_at(name, message).to_string());
    }

    /// Refuses parameters and children that nobody has asked for.
    ///
    /// # Errors
    ///
    /// The first of them in the file, with the nearest name that was asked for.
    pub fn finish(&self) -> Result<(), SceneError> {
        let asked = self.asked.borrow();
        let known: Vec<&str> = asked.iter().map(String::as_str).collect();
        let whose = self.describe();
        if let Some(unread) = self.parameters.iter().find(|p| !p.read.get()) {
            let name = &unread.name;
            return Err(unread.position.error(format!(
                "unknown parameter '{name}' in {whose}{}",
                suggestion(name, &known)
            )));
        }
        if let Some(unread) = self.children.iter().find(|c| !c.read.get()) {
            let what = unread.object.describe();
            return Err(unread.position.error(match &unread.name {
                Some(name) => format!(
                    "unknown {what} with the name '{name}' in {whose}{}",
                    suggestion(name, &known)
                ),
                None => format!("unexpected {what} in {whose}, expected none there"),
            }));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::xml::tests::scene;

    #[test]
    fn children_are_found_by_kind_and_by_name() {
        let document = scene(
            "<bsdf type='diffuse' id='a'/><shape type='sphere'><ref id='a'/></shape>\
             <bsdf type='mask'><texture name='opacity' type='bitmap'/></bsdf>",
        );
        let [shape] = &document.root.children(Tag::Shape)[..] else {
            panic!("one shape expected")
        };
        let definitions = document.definitions();
        assert_eq!(definitions.len(), 2);
        assert!(Rc::ptr_eq(
            &shape.child(Tag::Bsdf).unwrap().unwrap(),
            &definitions[0]
        ));
        assert!(shape.child(Tag::Emitter).unwrap().is_none());
        let opacity = definitions[1].named_child("opacity").unwrap().unwrap();
        assert_eq!((opacity.tag, &*opacity.plugin), (Tag::Texture, "bitmap"));
        assert!(document.root.finish().is_ok());
    }

    #[test]
    fn a_second_child_is_refused_at_its_place() {
        let document = scene("<bsdf type='a'/>\n  <bsdf type='b'/>");
        assert_eq!(
            document.root.child(Tag::Bsdf).unwrap_err().to_string(),
            "scene.xml:2:3: second bsdf 'b' in the scene, expected at most one"
        );
    }

    #[test]
    fn what_nobody_asked_for_is_refused() {
        let message = |inside: &str| {
            let document = scene(inside);
            let object = &document.definitions()[0];
            let _ = object.float("pitch", 1.0);
            let _ = object.named_child("opacity");
            object.without_effect(&["fast"]);
            object.finish().unwrap_err().to_string()
        };
        assert_eq!(
            message("<bsdf type='grating'>\n      <float name='ptich' value='1'/></bsdf>"),
            "scene.xml:2:7: unknown parameter 'ptich' in bsdf 'grating', did you mean 'pitch'?"
        );
        assert_eq!(
            message("<bsdf type='grating'>\n<float name='zzz' value='1'/></bsdf>"),
            "scene.xml:2:1: unknown parameter 'zzz' in bsdf 'grating', expected 'fast', 'opacity' or 'pitch'"
        );
        assert_eq!(
            message("<bsdf type='grating'>\n<texture name='opcaity' type='t'/></bsdf>"),
            "scene.xml:2:1: unknown texture 't' with the name 'opcaity' in bsdf 'grating', did you mean 'opacity'?"
        );
        assert_eq!(
            message("<bsdf type='grating'>\n<film type='f'/></bsdf>"),
            "scene.xml:2:1: unexpected film 'f' in bsdf 'grating', expected none there"
        );
    }
}
