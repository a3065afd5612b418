//! One XML element with its attributes, their `$names` filled in, and the places to blame.

use roxmltree::Node;

use super::defines::Defines;
use super::error::{Position, SceneError, quoted, suggestion};
use super::source::Source;

/// An attribute after substitution.
pub(super) struct Attribute {
    name: String,
    pub(super) value: String,
    pub(super) position: Position,
    owner: String,
}

impl Attribute {
    /// An error that says what was expected of the value: `attribute 'value' of float 'alpha' is 'x', expected …`.
    pub(super) fn expected(&self, what: &str) -> SceneError {
        let Self { name, owner, .. } = self;
        let value = quoted(&self.value);
        self.position.error(format!(
            "attribute '{name}' of {owner} is {value}, expected {what}"
        ))
    }

    /// Reads the value with a function that says what it expects.
    pub(super) fn parse<T>(
        &self,
        read: impl Fn(&str) -> Result<T, &'static str>,
    ) -> Result<T, SceneError> {
        read(&self.value).map_err(|what| self.expected(what))
    }
}

/// An XML element.
pub(super) struct Element<'a> {
    pub(super) tag: &'a str,
    pub(super) position: Position,
    attributes: Vec<Attribute>,
    node: Node<'a, 'a>,
    source: &'a Source,
}

impl<'a> Element<'a> {
    /// Takes the attributes of a node and fills in their `$names`.
    pub(super) fn new(
        node: Node<'a, 'a>,
        source: &'a Source,
        defines: &mut Defines,
    ) -> Result<Self, SceneError> {
        let mut element = Self {
            tag: node.tag_name().name(),
            position: source.position(node.range().start),
            attributes: Vec::new(),
            node,
            source,
        };
        if node.tag_name().namespace().is_some() {
            return Err(element.error(format!(
                "element '{}' is in an XML namespace, expected none",
                element.tag
            )));
        }
        let owner = match node.attribute("name").or(node.attribute("id")) {
            Some(name) => format!("{} {}", element.tag, quoted(name)),
            None => element.tag.to_owned(),
        };
        for attribute in node.attributes() {
            let position = source.position(attribute.range().start);
            if attribute.namespace().is_some() {
                let name = attribute.name();
                return Err(position.error(format!(
                    "attribute '{name}' is in an XML namespace, expected none"
                )));
            }
            let value = defines
                .substitute(attribute.value())
                .map_err(|message| position.error(message))?;
            element.attributes.push(Attribute {
                name: attribute.name().to_owned(),
                value,
                position,
                owner: owner.clone(),
            });
        }
        Ok(element)
    }

    /// An error at the element itself.
    pub(super) fn error(&self, message: impl std::fmt::Display) -> SceneError {
        self.position.error(message)
    }

    /// Refuses attributes that are not listed.
    pub(super) fn allow(&self, known: &[&str]) -> Result<(), SceneError> {
        match self.attributes.iter().find(|a| !known.contains(&&*a.name)) {
            None => Ok(()),
            Some(attribute) => Err(attribute.position.error(format!(
                "unknown attribute {} of {}{}",
                quoted(&attribute.name),
                attribute.owner,
                suggestion(&attribute.name, known)
            ))),
        }
    }

    pub(super) fn get(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// An attribute that must be there; it may be empty.
    pub(super) fn present(&self, name: &str) -> Result<&Attribute, SceneError> {
        self.get(name).ok_or_else(|| {
            let tag = self.tag;
            self.error(format!(
                "element '{tag}' has no attribute '{name}', expected {name}=\"…\""
            ))
        })
    }

    /// An attribute that must be there and not be empty.
    pub(super) fn require(&self, name: &str) -> Result<&Attribute, SceneError> {
        let attribute = self.present(name)?;
        if attribute.value.is_empty() {
            return Err(attribute.expected("a text"));
        }
        Ok(attribute)
    }

    /// The elements inside; text between them is refused.
    pub(super) fn children(&self) -> Result<Vec<Node<'a, 'a>>, SceneError> {
        for child in self.node.children().filter(Node::is_text) {
            let text = child.text().unwrap_or_default();
            if let Some(first) = text.find(|c: char| !c.is_whitespace()) {
                let place = self.source.position(child.range().start + first);
                return Err(place.error(format!(
                    "text {} inside element '{}', expected elements only, values stand in attributes",
                    quoted(text.trim()),
                    self.tag
                )));
            }
        }
        Ok(self.node.children().filter(Node::is_element).collect())
    }

    /// Refuses anything inside the element.
    pub(super) fn no_children(&self) -> Result<(), SceneError> {
        match self.children()?.first() {
            None => Ok(()),
            Some(child) => {
                let inner = quoted(child.tag_name().name());
                let place = self.source.position(child.range().start);
                let tag = self.tag;
                Err(place.error(format!(
                    "element {inner} inside element '{tag}', expected nothing inside"
                )))
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use super::*;

    /// Hands the root element of an XML text to `check`.
    pub(in crate::scene) fn with_element<T>(
        text: &str,
        check: impl FnOnce(&Element<'_>) -> Result<T, SceneError>,
    ) -> Result<T, String> {
        let source = Source::new(Path::new("s.xml"), text);
        let document = roxmltree::Document::parse(&source.text).unwrap();
        let mut defines = Defines::new(&[("x".to_owned(), "7".to_owned())]).unwrap();
        Element::new(document.root_element(), &source, &mut defines)
            .and_then(|element| check(&element))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn attributes_are_substituted_and_point_at_themselves() {
        let value = with_element("<float\n  value='1$x'/>", |e| {
            e.require("value")?.parse(crate::scene::number::float)
        });
        assert_eq!(value, Ok(17.0));
        let error = with_element("<float name='alpha'\n  value='a$x'/>", |e| {
            e.require("value")?.parse(crate::scene::number::float)
        });
        assert_eq!(
            error.unwrap_err(),
            "s.xml:2:3: attribute 'value' of float 'alpha' is 'a7', expected a number"
        );
    }

    #[test]
    fn unknown_and_missing_attributes_are_refused() {
        let error = with_element("<float name='a' vlaue='1'/>", |e| {
            e.allow(&["name", "value"])
        });
        assert_eq!(
            error.unwrap_err(),
            "s.xml:1:17: unknown attribute 'vlaue' of float 'a', did you mean 'value'?"
        );
        let error = with_element(" <float name='a'/>", |e| e.require("value").map(|_| ()));
        assert_eq!(
            error.unwrap_err(),
            "s.xml:1:2: element 'float' has no attribute 'value', expected value=\"…\""
        );
        let error = with_element("<float name=''/>", |e| e.require("name").map(|_| ()));
        assert_eq!(
            error.unwrap_err(),
            "s.xml:1:8: attribute 'name' of float '' is '', expected a text"
        );
    }

    #[test]
    fn text_and_namespaces_are_refused() {
        let error = with_element("<bsdf>\n  0.5\n</bsdf>", |e| {
            e.no_children()?;
            Ok(())
        });
        assert_eq!(
            error.unwrap_err(),
            "s.xml:2:3: text '0.5' inside element 'bsdf', expected elements only, values stand in attributes"
        );
        let error = with_element("<float><float/></float>", |e| {
            e.no_children()?;
            Ok(())
        });
        assert_eq!(
            error.unwrap_err(),
            "s.xml:1:8: element 'float' inside element 'float', expected nothing inside"
        );
        let error = with_element("<scene xmlns='http://a'/>", |e| {
            e.no_children()?;
            Ok(())
        });
        assert_eq!(
            error.unwrap_err(),
            "s.xml:1:1: element 'scene' is in an XML namespace, expected none"
        );
    }
}
