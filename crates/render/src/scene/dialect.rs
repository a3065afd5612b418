//! Which XML is a scene at all: well-formed, of a version that is read here, with elements that exist.

use super::element::Element;
use super::error::{Position, SceneError, quoted, suggestion};
use super::source::Source;
use super::tag::Tag;
use super::value::VALUE_TAGS;

/// Elements that neither make an object nor give a value.
const OTHER_TAGS: [&str; 5] = ["default", "include", "path", "alias", "ref"];

/// Accepts the dialect of Mitsuba 2 and 3.
pub(super) fn check_version(root: &Element<'_>) -> Result<(), SceneError> {
    let version = root.require("version")?;
    let parts: Vec<Option<u32>> = version.value.split('.').map(|p| p.parse().ok()).collect();
    match parts[..] {
        [Some(2 | 3), ref rest @ ..] if rest.len() <= 2 && rest.iter().all(Option::is_some) => {
            Ok(())
        }
        [Some(0 | 1), ..] => Err(version.position.error(format!(
            "version {} is the older dialect with names like 'toWorld', expected version 2 or 3, \
             'mitsuba -u' of Mitsuba 3 updates the file",
            quoted(&version.value)
        ))),
        _ => Err(version.expected("a version such as '3.0.0'")),
    }
}

/// Parses the XML; errors name their place.
pub(super) fn parse(source: &Source) -> Result<roxmltree::Document<'_>, SceneError> {
    roxmltree::Document::parse(&source.text).map_err(|failure| syntax_error(source, &failure))
}

/// The place and the words of an error in the XML itself.
fn syntax_error(source: &Source, failure: &roxmltree::Error) -> SceneError {
    use roxmltree::Error;
    let text = &source.text;
    let end = source.position(text.trim_end().len());
    match failure {
        Error::NoRootNode if text.trim().is_empty() => source
            .position(0)
            .error("the file is empty, expected a scene"),
        Error::NoRootNode => end.error("no element in the file, expected a scene"),
        Error::UnclosedRootNode => {
            end.error("the file ends inside an element, expected its end tag")
        }
        Error::UnexpectedEndOfStream => {
            end.error("the file ends in the middle of the XML, expected more")
        }
        Error::DtdDetected => source
            .position(text.find("<!DOCTYPE").unwrap_or(0))
            .error("a document type declaration, expected none, entities are not supported"),
        other => {
            let at = other.pos();
            let place = Position {
                file: source.file.clone(),
                line: at.row,
                column: at.col,
            };
            let words = other.to_string().replace(&format!(" at {at}"), "");
            place.error(format!("the XML is malformed: {words}"))
        }
    }
}

/// An error for an element that may not stand where it stands.
pub(super) fn unknown(element: &Element<'_>) -> SceneError {
    let tag = element.tag;
    if [
        "translate",
        "rotate",
        "scale",
        "lookat",
        "look_at",
        "matrix",
    ]
    .contains(&tag)
    {
        return element.error(format!(
            "element '{tag}' outside a transform, put it into <transform name=\"to_world\">"
        ));
    }
    let known: Vec<&str> = Tag::ALL
        .iter()
        .map(|&(_, name)| name)
        .chain(VALUE_TAGS)
        .chain(OTHER_TAGS)
        .collect();
    element.error(format!(
        "unknown element {}{}",
        quoted(tag),
        suggestion(tag, &known)
    ))
}

#[cfg(test)]
mod tests {
    use crate::scene::xml::tests::message;

    #[test]
    fn only_the_dialects_of_versions_2_and_3_are_read() {
        for version in ["3.0.0", "3.9.1", "2.0.0", "2.1", "3"] {
            assert_eq!(message(&format!("<scene version='{version}'/>"), &[]), "");
        }
        assert_eq!(
            message("<scene version='0.6.0'/>", &[]),
            "s.xml:1:8: version '0.6.0' is the older dialect with names like 'toWorld', expected version 2 or 3, \
             'mitsuba -u' of Mitsuba 3 updates the file"
        );
        assert_eq!(
            message("<scene version='4.0.0'/>", &[]),
            "s.xml:1:8: attribute 'version' of scene is '4.0.0', expected a version such as '3.0.0'"
        );
        assert_eq!(
            message("<scene/>", &[]),
            "s.xml:1:1: element 'scene' has no attribute 'version', expected version=\"…\""
        );
    }

    #[test]
    fn syntax_errors_point_at_the_fault_and_not_at_the_first_line() {
        for (text, expected) in [
            ("", "s.xml:1:1: the file is empty, expected a scene"),
            (
                "<scene version='3.0.0'>\n  <bsdf>",
                "s.xml:2:9: the file ends inside an element, expected its end tag",
            ),
            (
                "<scene version='3.0.0'>\n <bsdf></scen",
                "s.xml:2:14: the file ends in the middle of the XML, expected more",
            ),
            (
                "<scene version='3.0.0'>\n<bsdf></shape>",
                "s.xml:2:7: the XML is malformed: expected 'bsdf' tag, not 'shape'",
            ),
            (
                "\n<!DOCTYPE a>",
                "s.xml:2:1: a document type declaration, expected none, entities are not supported",
            ),
        ] {
            assert_eq!(message(text, &[]), expected);
        }
    }
}
