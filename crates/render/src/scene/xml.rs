//! The grammar of scene files: which element may stand where, and what it does.

use std::fs;
use std::path::{Path, PathBuf};

use super::defines::Defines;
use super::dialect::{check_version, parse, unknown};
use super::document::Document;
use super::element::{Attribute, Element};
use super::error::{Position, SceneError, quoted};
use super::search::Search;
use super::source::Source;
use super::tag::Tag;
use super::tree::{Draft, MAX_DEPTH, Tree};
use super::value::{VALUE_TAGS, Value};

/// Files within files, and files altogether, that a scene may include.
const MAX_INCLUDE_DEPTH: usize = 15;
const MAX_INCLUDES: usize = 1000;

/// Reads a scene file in the Mitsuba 3 XML dialect, with the files that it includes.
///
/// `defines` are the values of the command line for `$name`; they win over the `<default>`s of the file. More generous
/// than Mitsuba: `look_at` beside `lookat`, `r`, `g`, `b` and `#rrggbb` (sRGB code values) in an `<rgb>`, parameters in
/// an included `<scene>`. A byte order mark is skipped. Bounds: 64 levels of objects, with what `<ref>` adds; 1000
/// includes, 15 within each other; no document type declaration.
///
/// # Errors
///
/// Anything that is not in the grammar, a `$name` without a value, a value that no `$name` uses, an unreadable file:
/// with file, line and column.
pub fn read(path: &Path, defines: &[(String, String)]) -> Result<Document, SceneError> {
    read_source(&Source::read(path)?, defines)
}

/// Reads a scene from a text that is said to stand in `path`: the place of errors, and where other files are found.
///
/// # Errors
///
/// As for [`read`].
pub fn read_text(
    text: &str,
    path: &Path,
    defines: &[(String, String)],
) -> Result<Document, SceneError> {
    read_source(&Source::new(path, text), defines)
}

fn read_source(source: &Source, defines: &[(String, String)]) -> Result<Document, SceneError> {
    let whole = Position::whole(&source.file);
    let mut reader = Reader {
        defines: Defines::new(defines).map_err(|message| whole.error(message))?,
        tree: Tree::default(),
        open: Vec::new(),
        includes: 0,
    };
    reader.file(source, None)?;
    if let Some(message) = reader.defines.unused() {
        return Err(whole.error(message));
    }
    reader.tree.link()
}

struct Reader {
    defines: Defines,
    tree: Tree,
    /// Files being read, outermost first, by their canonical names.
    open: Vec<PathBuf>,
    includes: usize,
}

/// Where an object goes.
#[derive(Clone, Copy)]
struct Slot<'s> {
    owner: usize,
    depth: usize,
    name: Option<&'s str>,
}

/// What an included file must know about the `<include>`.
struct Include<'s> {
    slot: Slot<'s>,
    search: &'s Search,
    place: &'s Position,
}

impl Reader {
    fn file(&mut self, source: &Source, include: Option<&Include<'_>>) -> Result<(), SceneError> {
        let path = &*source.file;
        self.open
            .push(fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()));
        let document = parse(source)?;
        let root = Element::new(document.root_element(), source, &mut self.defines)?;
        check_version(&root)?;
        let mut search = Search::beside(path, include.map(|include| include.search));
        match include {
            None => self.scene(&root, source, &mut search)?,
            Some(Include { slot, place, .. }) if root.tag == "scene" => {
                root.allow(&["version", "id"])?;
                if slot.name.is_some() {
                    return Err(place.error(
                        "the included file is a scene and cannot have a name, remove 'name'",
                    ));
                }
                self.contents(&root, slot.owner, slot.depth, source, &mut search)?;
            }
            Some(Include { slot, .. }) => {
                let tag = object_tag(&root).ok_or_else(|| unknown(&root))?;
                self.object(&root, tag, *slot, source, &mut search)?;
            }
        }
        self.open.pop();
        Ok(())
    }

    fn scene(
        &mut self,
        root: &Element<'_>,
        source: &Source,
        search: &mut Search,
    ) -> Result<(), SceneError> {
        if root.tag != "scene" {
            return Err(root.error(format!(
                "the outermost element is {}, expected 'scene'",
                quoted(root.tag)
            )));
        }
        root.allow(&["version", "id"])?;
        let position = root.position.clone();
        let mut draft = Draft::new(Tag::Scene, "scene", position, search.clone());
        draft.id = optional(root, "id")?.map(|id| id.value.clone());
        let owner = self.tree.add(draft)?;
        self.contents(root, owner, 0, source, search)
    }

    /// Everything inside an object.
    fn contents(
        &mut self,
        element: &Element<'_>,
        owner: usize,
        depth: usize,
        source: &Source,
        search: &mut Search,
    ) -> Result<(), SceneError> {
        for node in element.children()? {
            let element = Element::new(node, source, &mut self.defines)?;
            if let Some(tag) = object_tag(&element) {
                let slot = Slot {
                    owner,
                    depth: depth + 1,
                    name: optional(&element, "name")?.map(|name| name.value.as_str()),
                };
                self.object(&element, tag, slot, source, search)?;
            } else if VALUE_TAGS.contains(&element.tag) {
                let value = Value::read(&element, source, &mut self.defines, search)?;
                let name = &element.require("name")?.value;
                self.tree.parameter(owner, name, value, &element.position)?;
            } else {
                element.no_children()?;
                self.other(&element, owner, depth, search)?;
            }
        }
        Ok(())
    }

    fn object(
        &mut self,
        element: &Element<'_>,
        tag: Tag,
        slot: Slot<'_>,
        source: &Source,
        search: &mut Search,
    ) -> Result<(), SceneError> {
        if tag == Tag::Scene {
            return Err(element.error("a scene inside an object, expected it outermost only"));
        }
        if slot.depth > MAX_DEPTH {
            return Err(element.error(format!(
                "objects are nested deeper than {MAX_DEPTH} levels, expected fewer"
            )));
        }
        let root = element.get("version").is_some();
        let version: &[&str] = if root { &["version"] } else { &[] };
        element.allow(&[&["type", "id", "name"], version].concat())?;
        let plugin = &element.require("type")?.value;
        let mut draft = Draft::new(tag, plugin, element.position.clone(), search.clone());
        draft.id = optional(element, "id")?.map(|id| id.value.clone());
        let index = self.tree.add(draft)?;
        self.tree.child(slot.owner, slot.name, index)?;
        self.contents(element, index, slot.depth, source, search)
    }

    fn other(
        &mut self,
        element: &Element<'_>,
        owner: usize,
        depth: usize,
        search: &mut Search,
    ) -> Result<(), SceneError> {
        match element.tag {
            "default" => {
                element.allow(&["name", "value"])?;
                let name = element.require("name")?;
                let value = element.present("value")?;
                if name.value.contains(['$', '\\']) {
                    return Err(name.expected("a name without '$'"));
                }
                self.defines.set_default(&name.value, &value.value);
                Ok(())
            }
            "ref" => {
                element.allow(&["id", "name"])?;
                let id = &element.require("id")?.value;
                let name = optional(element, "name")?.map(|name| name.value.as_str());
                self.tree
                    .reference(owner, name, id, element.position.clone())
            }
            "alias" => {
                element.allow(&["id", "as"])?;
                let (id, alias) = (element.require("id")?, element.require("as")?);
                self.tree.alias(&id.value, &alias.value, &element.position)
            }
            "path" => {
                element.allow(&["value"])?;
                if owner != 0 {
                    return Err(
                        element.error("a path inside an object, expected it in the scene only")
                    );
                }
                let folder = element.require("value")?;
                search
                    .add(&folder.value)
                    .map_err(|message| folder.position.error(message))
            }
            "include" => self.include(element, owner, depth, search),
            _ => Err(unknown(element)),
        }
    }

    fn include(
        &mut self,
        element: &Element<'_>,
        owner: usize,
        depth: usize,
        search: &Search,
    ) -> Result<(), SceneError> {
        element.allow(&["filename", "name"])?;
        let filename = element.require("filename")?;
        let place = &filename.position;
        let path = search
            .find(&filename.value)
            .map_err(|message| place.error(message))?;
        if fs::canonicalize(&path).is_ok_and(|canonical| self.open.contains(&canonical)) {
            return Err(place.error(format!(
                "file {} includes itself, expected no circle of includes",
                quoted(&filename.value)
            )));
        }
        self.includes += 1;
        if self.open.len() > MAX_INCLUDE_DEPTH || self.includes > MAX_INCLUDES {
            return Err(place.error(format!(
                "too many includes, expected at most {MAX_INCLUDES}, at most {MAX_INCLUDE_DEPTH} within each other"
            )));
        }
        let slot = Slot {
            owner,
            depth: depth + 1,
            name: optional(element, "name")?.map(|name| name.value.as_str()),
        };
        let include = Include {
            slot,
            search,
            place,
        };
        self.file(&Source::read(&path)?, Some(&include))
    }
}

fn object_tag(element: &Element<'_>) -> Option<Tag> {
    match element.tag {
        "spectrum" => element.get("type").map(|_| Tag::Texture),
        other => Tag::of(other),
    }
}

/// An attribute that may be absent but not empty.
fn optional<'e>(element: &'e Element<'_>, name: &str) -> Result<Option<&'e Attribute>, SceneError> {
    match element.get(name) {
        Some(_) => element.require(name).map(Some),
        None => Ok(None),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A scene with this inside, said to stand in `scene.xml`.
    pub(in crate::scene) fn scene(inside: &str) -> Document {
        let text = format!("<scene version='3.0.0'>{inside}</scene>");
        read_text(&text, Path::new("scene.xml"), &[]).unwrap()
    }

    /// The error that a text gives, empty where it gives none.
    pub(in crate::scene) fn message(text: &str, defines: &[(&str, &str)]) -> String {
        let defines: Vec<_> = defines
            .iter()
            .map(|&(name, value)| (name.to_owned(), value.to_owned()))
            .collect();
        let outcome = read_text(text, Path::new("s.xml"), &defines);
        outcome.err().map_or_else(String::new, |e| e.to_string())
    }

    #[test]
    fn defaults_give_way_to_the_command_line() {
        let text = "<scene version='3.0.0'><default name='n' value='4'/>\
                    <sampler type='independent'><integer name='sample_count' value='$n'/></sampler></scene>";
        for (defines, expected) in [(vec![], 4), (vec![("n".to_owned(), "9".to_owned())], 9)] {
            let document = read_text(text, Path::new("s.xml"), &defines).unwrap();
            let sampler = document.root.child(Tag::Sampler).unwrap().unwrap();
            assert_eq!(sampler.integer("sample_count", 1), Ok(expected));
        }
        assert_eq!(
            message(text, &[("nn", "1")]),
            "s.xml: '-D nn' has no effect, the scene has no '$nn', did you mean 'n'?"
        );
    }

    #[test]
    fn included_scenes_are_spliced_in_and_included_objects_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        fs::create_dir(folder.path().join("parts")).unwrap();
        write(
            "scene.xml",
            "<scene version='3.0.0'><include filename='parts/lights.xml'/>\
             <bsdf type='mask'><include name='opacity' filename='parts/checks.xml'/></bsdf></scene>",
        );
        write(
            "parts/lights.xml",
            "<scene version='2.1.0'><emitter type='constant'/><include filename='more.xml'/></scene>",
        );
        write("parts/more.xml", "<emitter version='3.0' type='point'/>");
        write(
            "parts/checks.xml",
            "<texture version='3.0.0' type='checkerboard'/>",
        );
        let document = read(&folder.path().join("scene.xml"), &[]).unwrap();
        let plugins = |tag| -> Vec<String> {
            let objects = document.root.children(tag);
            objects.iter().map(|o| o.plugin.clone()).collect()
        };
        assert_eq!(plugins(Tag::Emitter), ["constant", "point"]);
        let mask = &document.definitions()[0];
        let opacity = mask.named_child("opacity").unwrap().unwrap();
        assert_eq!(opacity.plugin, "checkerboard");
        assert!(
            opacity
                .position
                .to_string()
                .ends_with("parts/checks.xml:1:1")
        );
    }

    #[test]
    fn files_are_found_beside_the_file_that_names_them_and_in_its_paths() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir(root.join("data")).unwrap();
        fs::write(root.join("data/a.spd"), "400 1\n700 2\n").unwrap();
        let text = "<scene version='3.0.0'><path value='data'/><bsdf type='t'>\
                    <spectrum name='s' filename='a.spd'/><string name='f' value='a.spd'/></bsdf></scene>";
        let document = read_text(text, &root.join("s.xml"), &[]).unwrap();
        let found = document.definitions()[0].path("f").unwrap();
        assert_eq!(found, root.join("data").join("a.spd"));
    }

    #[test]
    fn a_spectrum_with_a_type_is_a_texture() {
        let document = scene(
            "<emitter type='point'><spectrum name='intensity' type='blackbody'><float name='temperature' value='1'/>\
             </spectrum></emitter>",
        );
        let emitter = document.root.child(Tag::Emitter).unwrap().unwrap();
        let intensity = emitter.named_child("intensity").unwrap().unwrap();
        assert_eq!(
            (intensity.tag, &*intensity.plugin),
            (Tag::Texture, "blackbody")
        );
    }
}
