//! Opens a scene by its name, which is either that of a procedural scene, with parameters, or the path of a file.

use super::{Options, Watch, load_watched};
use crate::scene::Scene;
use crate::{Error, Result, procedural};
use std::path::Path;

impl Scene {
    /// Generates the procedural scene with this name, such as `cornell` or `cornell:KEY=VALUE,…`, or loads the file at this
    /// path.
    ///
    /// # Errors
    /// There is neither a procedural scene nor a readable file with this name, a parameter is unknown or out of range, or
    /// the file is not a valid scene.
    pub fn open(name: &str) -> Result<Self> {
        Self::open_watched(name, Options::default(), &mut |_, _, _| Ok(()))
    }

    /// The same as [`Self::open`], but with the user's permissions `options` for missing image files and for files outside
    /// of the scene's folder, and with reports of the progress to `watch`. Both have no effect on a procedural scene.
    ///
    /// # Errors
    /// The errors of [`Self::open`], and an error that `watch` returns, which ends the loading.
    pub fn open_watched(name: &str, options: Options, watch: &mut Watch<'_>) -> Result<Self> {
        if let Some((name, parameters)) = as_procedural(name) {
            return procedural::generate(name, &parse_parameters(name, parameters)?);
        }
        load_watched(Path::new(name), options, watch)
    }
}

/// The path of the file from which a scene is read, given the scene's name. `None` for the name of a procedural scene.
/// Commands use it to refuse an output that would replace the scene's file.
pub fn file_of(name: &str) -> Option<&Path> {
    as_procedural(name).is_none().then(|| Path::new(name))
}

/// The name of a procedural scene and the text of its parameters after the colon, which may be empty. `None` if `name` is
/// the path of a file. A bare word without extension and folder always counts as the name of a procedural scene; a file with
/// such a name can be given as `./NAME`.
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

/// The parameters of a procedural scene as pairs of key and value, from a text such as `KEY=VALUE,KEY=VALUE`. `name` is the
/// scene's name for messages. Fails if a part has no `=`.
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

/// Checks, before long work, that the scene `name` can probably be opened with [`Scene::open`]: the file exists, or the
/// procedural scene and its parameters do. The scene is neither read nor generated.
///
/// # Errors
/// There is no procedural scene with this name, a parameter is unknown or out of range, or there is no plain file at this
/// path.
pub fn check_name(name: &str) -> Result<()> {
    if let Some((name, parameters)) = as_procedural(name) {
        return procedural::check(name, &parse_parameters(name, parameters)?);
    }
    crate::base::input_files::check(Path::new(name))
}
