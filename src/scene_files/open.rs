//! Opens a scene by its name, which is either the name of a procedural scene, with parameters after a colon, or the path of
//! a file.

use super::{Options, Watch, load_watched};
use crate::scene::Scene;
use crate::{Error, Result, procedural};
use std::path::Path;

impl Scene {
    /// Opens the scene `name`: generates the procedural scene with this name, such as `cornell` or `cornell:KEY=VALUE,…`, or
    /// loads the file at this path. A scene without any light gets a neutral environment ([`Self::surround`]).
    ///
    /// # Errors
    /// There is neither a procedural scene nor a readable file with this name, a parameter of the procedural scene is
    /// unknown or out of range, or the file is not a valid scene.
    pub fn open(name: &str) -> Result<Self> {
        let mut scene = Self::open_watched(name, Options::default(), &mut |_, _, _| Ok(()))?;
        scene.surround(None)?;
        Ok(scene)
    }

    /// Opens the scene `name` as [`Self::open`] does, but leaves a scene without light dark. `options` are the user's
    /// permissions for missing image files and for files outside of the scene's folder, and the material variant; `watch` is
    /// called with the progress of the loading. Both have no effect on a procedural scene.
    ///
    /// # Errors
    /// The errors of [`Self::open`], except those about files that `options` permit; a material variant that the scene does not
    /// have; and an error that `watch` returns, which ends the loading.
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

/// Splits the name of a procedural scene, such as `cornell:KEY=VALUE`, into the part before the colon and the text of the
/// parameters, which may be empty. `None` if `name` is the path of a file. A single word without extension or folder always
/// counts as a procedural scene, even if there is none with this name; a file with such a name can be given as `./NAME`.
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

/// The parameters of a procedural scene as pairs of key and value, in the order of `text`, which has the form
/// `KEY=VALUE,KEY=VALUE`. Keys and values are not checked here. Fails if a part between commas has no `=`; `name` is the
/// scene's name in the error.
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

/// Checks, before long work, that the scene `name` can probably be opened with [`Scene::open`]. It checks that the file
/// exists, or that the procedural scene exists and its parameters are valid. The scene is neither read nor generated.
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
