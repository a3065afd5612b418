//! Scene files: the Mitsuba 3 XML dialect, read strictly, and the meshes that it names.
//!
//! ```text
//! file ─ source ─ dialect ─ element ─ value ┐
//!                   defines ($name) ────────┴─ xml ─ tree (ids, refs) ─ Document ─ Object: typed parameters
//! OBJ file ─ obj (tobj) ─ Mesh
//! ```
//!
//! A scene is read in two steps. [`read`] knows the grammar and no plugin; it returns a [`Document`]. Whoever builds
//! a plugin then asks its [`Object`] for the parameters by name and type, and calls [`Object::finish`], which refuses
//! what nobody has asked for.

pub mod abreast;
mod build;
mod camera;
mod defines;
mod dialect;
mod document;
mod element;
mod error;
mod lists;
pub mod mesh;
mod number;
mod obj;
mod object;
mod params;
pub mod plugins;
mod search;
mod sensors;
mod source;
mod spectral;
mod tag;
mod transform;
mod tree;
mod value;
mod world;
mod xml;

pub(crate) use build::within_reach;
pub use build::{BuiltScene, Overrides, build};
pub use document::Document;
pub use error::{Position, SceneError, nearest};
pub use object::Object;
pub(crate) use params::metres;
pub use tag::Tag;
pub use world::{Body, Encounter, Owner, Scene};
pub use xml::{read, read_text};
