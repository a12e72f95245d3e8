//! Scenes by name: a procedural one, or a file.

use super::{Options, Watch, load_watched};
use crate::scene::Scene;
use crate::{Error, Result, procedural};
use std::path::Path;

impl Scene {
    /// Generates the procedural scene with this name, or loads the file at this path.
    ///
    /// # Errors
    /// The name is neither a procedural scene nor a readable file.
    pub fn open(name: &str) -> Result<Self> {
        Self::open_watched(name, Options::default(), &mut |_, _, _| Ok(()))
    }

    /// [`Self::open`] with progress reports to `watch` while a file is loaded.
    ///
    /// # Errors
    /// The errors of [`Self::open`], and those of `watch`.
    pub fn open_watched(name: &str, options: Options, watch: &mut Watch<'_>) -> Result<Self> {
        if let Some((name, parameters)) = as_procedural(name) {
            return procedural::generate(name, &parse_parameters(name, parameters)?);
        }
        load_watched(Path::new(name), options, watch)
    }
}

/// The path of a scene's file; `None` for a procedural scene.
pub fn file_of(name: &str) -> Option<&Path> {
    as_procedural(name).is_none().then(|| Path::new(name))
}

/// The name of a procedural scene and the text after its colon. A bare word is taken as a name; a file with that name can be
/// given as ./NAME.
fn as_procedural(name: &str) -> Option<(&str, &str)> {
    let (bare, parameters) = name.split_once(':').unwrap_or((name, ""));
    if procedural::list().iter().any(|scene| scene.name == bare) {
        return Some((bare, parameters));
    }
    let path = Path::new(name);
    let bare_word =
        path.extension().is_none() && path.components().count() == 1 && !name.starts_with('.');
    bare_word.then_some((name, ""))
}

/// `KEY=VALUE`, separated by commas.
fn parse_parameters(name: &str, text: &str) -> Result<Vec<(String, String)>> {
    let parts = text.split(',').filter(|part| !part.is_empty());
    let parse = |part: &str| {
        let (key, value) = part.split_once('=').ok_or_else(|| {
            Error::input(format!(
                "scene {name}: '{part}' is not KEY=VALUE; write {name}:KEY=VALUE,KEY=VALUE"
            ))
        })?;
        Ok((key.to_owned(), value.to_owned()))
    };
    parts.map(parse).collect()
}

/// Checks that [`Scene::open`] can succeed, as far as possible without opening the scene.
///
/// # Errors
/// No such procedural scene or parameter, or no such file.
pub fn check_name(name: &str) -> Result<()> {
    if let Some((name, parameters)) = as_procedural(name) {
        return procedural::check(name, &parse_parameters(name, parameters)?);
    }
    crate::base::input_files::check(Path::new(name))
}
