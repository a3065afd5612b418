//! Objects while the file is being read: `<ref>` may name what comes later, so links are made at the end.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

use super::document::{Document, Notices};
use super::error::{Position, SceneError, nearest, quoted};
use super::object::{Child, Object, Parameter};
use super::search::Search;
use super::tag::Tag;
use super::value::Value;

/// Deepest nesting of objects, references included; what walks a scene may recurse.
pub(super) const MAX_DEPTH: usize = 64;

/// Most objects that one object below the root may contain when every `<ref>` is written out.
const MAX_EXPANDED: usize = 1_000_000;

/// An object whose references are still names.
pub(super) struct Draft {
    pub(super) tag: Tag,
    pub(super) plugin: String,
    pub(super) id: Option<String>,
    pub(super) position: Position,
    pub(super) search: Search,
    parameters: Vec<Parameter>,
    children: Vec<(Option<String>, Position, Target)>,
    names: HashMap<String, Position>,
}

enum Target {
    Draft(usize),
    Reference(String),
}

impl Draft {
    pub(super) fn new(tag: Tag, plugin: &str, position: Position, search: Search) -> Self {
        Self {
            tag,
            plugin: plugin.to_owned(),
            id: None,
            position,
            search,
            parameters: Vec::new(),
            children: Vec::new(),
            names: HashMap::new(),
        }
    }

    fn claim(&mut self, name: &str, position: &Position) -> Result<(), SceneError> {
        match self.names.insert(name.to_owned(), position.clone()) {
            None => Ok(()),
            Some(first) => Err(position.error(format!(
                "second parameter {}, the first is at {first}, expected one",
                quoted(name)
            ))),
        }
    }
}

/// All the objects of a scene, by number; the root is number 0.
#[derive(Default)]
pub(super) struct Tree {
    drafts: Vec<Draft>,
    ids: HashMap<String, usize>,
}

impl Tree {
    /// Takes an object, to be found by its id.
    pub(super) fn add(&mut self, draft: Draft) -> Result<usize, SceneError> {
        let index = self.drafts.len();
        if let Some(id) = &draft.id {
            self.claim(id, index, &draft.position)?;
        }
        self.drafts.push(draft);
        Ok(index)
    }

    fn claim(&mut self, id: &str, index: usize, position: &Position) -> Result<(), SceneError> {
        if let Some(&first) = self.ids.get(id) {
            let first = &self.drafts[first].position;
            return Err(position.error(format!(
                "id {} is taken by the object at {first}, expected another one",
                quoted(id)
            )));
        }
        self.ids.insert(id.to_owned(), index);
        Ok(())
    }

    /// Gives a second name to an object that stands before this place.
    pub(super) fn alias(
        &mut self,
        id: &str,
        alias: &str,
        position: &Position,
    ) -> Result<(), SceneError> {
        let index = self.index(id, position)?;
        self.claim(alias, index, position)
    }

    fn index(&self, id: &str, position: &Position) -> Result<usize, SceneError> {
        self.ids.get(id).copied().ok_or_else(|| {
            let remedy = match nearest(id, self.ids.keys().map(String::as_str)) {
                Some(near) => format!("did you mean '{near}'?"),
                None => format!("expected an object with id={}", quoted(id)),
            };
            position.error(format!("no object has the id {}, {remedy}", quoted(id)))
        })
    }

    pub(super) fn parameter(
        &mut self,
        owner: usize,
        name: &str,
        value: Value,
        position: &Position,
    ) -> Result<(), SceneError> {
        let owner = &mut self.drafts[owner];
        owner.claim(name, position)?;
        owner.parameters.push(Parameter {
            name: name.to_owned(),
            value,
            position: position.clone(),
            read: Cell::new(false),
        });
        Ok(())
    }

    /// Puts object number `child` inside object number `owner`.
    pub(super) fn child(
        &mut self,
        owner: usize,
        name: Option<&str>,
        child: usize,
    ) -> Result<(), SceneError> {
        let position = self.drafts[child].position.clone();
        self.hold(owner, name, position, Target::Draft(child))
    }

    /// Puts the object with that id inside object number `owner`.
    pub(super) fn reference(
        &mut self,
        owner: usize,
        name: Option<&str>,
        id: &str,
        position: Position,
    ) -> Result<(), SceneError> {
        self.hold(owner, name, position, Target::Reference(id.to_owned()))
    }

    fn hold(
        &mut self,
        owner: usize,
        name: Option<&str>,
        position: Position,
        target: Target,
    ) -> Result<(), SceneError> {
        let owner = &mut self.drafts[owner];
        if let Some(name) = name {
            owner.claim(name, &position)?;
        }
        owner
            .children
            .push((name.map(str::to_owned), position, target));
        Ok(())
    }

    /// Replaces names by the objects that they mean.
    pub(super) fn link(mut self) -> Result<Document, SceneError> {
        let notices = Rc::new(Notices::default());
        let mut linked = vec![State::Waiting; self.drafts.len()];
        let root = self.object(0, 0, &mut linked, &notices)?.object;
        Ok(Document { root, notices })
    }

    /// Recurses along children and references, at most [`MAX_DEPTH`] deep.
    fn object(
        &mut self,
        index: usize,
        depth: usize,
        states: &mut [State],
        notices: &Rc<Notices>,
    ) -> Result<Linked, SceneError> {
        if let State::Done(linked) = &states[index] {
            return Ok(linked.clone());
        }
        states[index] = State::Open;
        let mut children = Vec::new();
        let (mut height, mut expanded) = (0, 1usize);
        for (name, position, target) in std::mem::take(&mut self.drafts[index].children) {
            let target = match target {
                Target::Draft(child) => child,
                Target::Reference(id) => self.index(&id, &position)?,
            };
            if matches!(states[target], State::Open) {
                return Err(position.error(
                    "the reference names an object around it, expected one that does not contain it",
                ));
            }
            let too_deep = || {
                position.error(format!(
                    "objects are nested deeper than {MAX_DEPTH} levels, expected fewer"
                ))
            };
            if depth >= MAX_DEPTH {
                return Err(too_deep());
            }
            let child = self.object(target, depth + 1, states, notices)?;
            height = height.max(child.height + 1);
            expanded = expanded.saturating_add(child.expanded);
            if height > MAX_DEPTH {
                return Err(too_deep());
            }
            if index != 0 && expanded > MAX_EXPANDED {
                return Err(position.error(format!(
                    "references repeat an object more than {MAX_EXPANDED} times, expected fewer"
                )));
            }
            children.push(Child {
                name,
                position,
                object: child.object,
                read: Cell::new(false),
            });
        }
        let draft = &mut self.drafts[index];
        let linked = Linked {
            object: Rc::new(Object {
                tag: draft.tag,
                plugin: std::mem::take(&mut draft.plugin),
                id: draft.id.take(),
                position: draft.position.clone(),
                parameters: std::mem::take(&mut draft.parameters),
                children,
                search: draft.search.clone(),
                notices: notices.clone(),
                asked: RefCell::default(),
            }),
            height,
            expanded,
        };
        states[index] = State::Done(linked.clone());
        Ok(linked)
    }
}

#[derive(Clone)]
struct Linked {
    object: Rc<Object>,
    /// Levels of objects below.
    height: usize,
    /// Objects in it when every reference is written out, itself included.
    expanded: usize,
}

#[derive(Clone)]
enum State {
    Waiting,
    /// Its children are being linked.
    Open,
    Done(Linked),
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene::tag::Tag;
    use crate::scene::xml::{read_text, tests::scene};

    fn message(inside: &str) -> String {
        let text = format!("<scene version='3.0.0'>\n{inside}</scene>");
        let outcome = read_text(&text, Path::new("s.xml"), &[]);
        outcome.err().map_or_else(String::new, |e| e.to_string())
    }

    #[test]
    fn a_reference_may_stand_before_its_object_and_an_alias_after_it() {
        let document = scene(
            "<shape type='cube'><ref id='b'/></shape><bsdf type='diffuse' id='a'/><alias id='a' as='b'/>",
        );
        let shapes = document.root.children(Tag::Shape);
        let bsdf = shapes[0].child(Tag::Bsdf).unwrap().unwrap();
        assert_eq!(bsdf.id.as_deref(), Some("a"));
    }

    #[test]
    fn names_that_mean_nothing_or_two_things_are_refused() {
        for (inside, expected) in [
            (
                "<ref id='whit'/><bsdf type='a' id='white'/>",
                "2:1: no object has the id 'whit', did you mean 'white'?",
            ),
            (
                "<ref id='x'/>",
                "2:1: no object has the id 'x', expected an object with id='x'",
            ),
            (
                "<alias id='a' as='b'/><bsdf type='a' id='a'/>",
                "2:1: no object has the id 'a', expected an object with id='a'",
            ),
            (
                "<bsdf type='a' id='a'/>\n<bsdf type='b' id='a'/>",
                "3:1: id 'a' is taken by the object at s.xml:2:1, expected another one",
            ),
            (
                "<bsdf type='a' id='a'/><bsdf type='b' id='b'/>\n<alias id='a' as='b'/>",
                "3:1: id 'b' is taken by the object at s.xml:2:24, expected another one",
            ),
            (
                "<bsdf type='a'>\n<float name='x' value='1'/>\n<texture type='t' name='x'/></bsdf>",
                "4:1: second parameter 'x', the first is at s.xml:3:1, expected one",
            ),
        ] {
            assert_eq!(message(inside), format!("s.xml:{expected}"));
        }
    }

    #[test]
    fn an_object_cannot_contain_itself() {
        for inside in [
            "<bsdf type='a' id='a'>\n<ref id='a'/></bsdf>",
            "<bsdf type='a' id='a'><ref id='b'/></bsdf><bsdf type='b' id='b'>\n<ref id='a'/></bsdf>",
        ] {
            assert_eq!(
                message(inside),
                "s.xml:3:1: the reference names an object around it, expected one that does not contain it"
            );
        }
    }

    #[test]
    fn references_make_neither_deep_nor_endless_scenes() {
        let link = |i: usize| format!("<bsdf type='t' id='b{}'><ref id='b{i}'/></bsdf>", i + 1);
        let first = "<bsdf type='t' id='b0'/>".to_owned();
        let forwards: String = (0..5000).map(link).collect();
        let backwards: String = (0..5000).rev().map(link).collect();
        for chain in [first.clone() + &forwards, backwards + &first] {
            assert!(message(&chain).ends_with("deeper than 64 levels, expected fewer"));
        }
        let twice = |i: usize| {
            format!(
                "<bsdf type='t' id='b{}'><ref id='b{i}'/><ref id='b{i}'/></bsdf>",
                i + 1
            )
        };
        let doubling = first + &(0..40).map(twice).collect::<String>();
        assert!(message(&doubling).contains("more than 1000000 times"));
    }
}
