//! Reads a scene from a file, whatever its format.

use super::notices::quoted;
use super::{Scene, gltf, obj};
use crate::{Error, Result};
use std::path::Path;

/// Reads and validates a scene: glTF 2.0 (`.gltf`, `.glb`) or Wavefront OBJ (`.obj`).
///
/// Whatever the file holds, this ends in a scene that keeps to the rules of
/// [`Scene::validate`], with a notice for each thing assumed or ignored, or in an error of one
/// line that names the file, the element and what to do.
pub fn load(path: &Path) -> Result<Scene> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    let folder = path.parent().unwrap_or(Path::new(""));
    let scene = match extension.as_deref() {
        Some("gltf" | "glb") => {
            let bytes = std::fs::read(path).map_err(|cause| unreadable(path, cause))?;
            if extension.as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
                Err(Error::input(
                    "is no binary glTF, its first bytes are not \"glTF\"; export it again",
                ))
            } else {
                gltf::read(&bytes, folder)
            }
        }
        Some("obj") => {
            let file = std::fs::File::open(path).map_err(|cause| unreadable(path, cause))?;
            obj::read(std::io::BufReader::new(file), folder)
        }
        _ => Err(Error::input(
            "is no scene that can be read; give a .gltf, .glb or .obj file",
        )),
    };
    scene
        .and_then(|mut scene| {
            scene.validate()?;
            Ok(finished(scene, path))
        })
        .map_err(|error| match error {
            Error::Input(fault) => Error::Input(format!("{}: {fault}", one_line(path))),
            other => other,
        })
}

fn finished(mut scene: Scene, path: &Path) -> Scene {
    scene.name = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default();
    if scene.triangle_count() == 0 {
        scene
            .notices
            .push("the scene has no triangles, nothing of it can be seen".into());
    }
    scene
}

fn unreadable(path: &Path, cause: std::io::Error) -> Error {
    Error::reading(Path::new(&one_line(path)), cause)
}

/// A path as messages show it: as it is, but for characters that would break the line.
fn one_line(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.chars().any(char::is_control) {
        quoted(&text)
    } else {
        text.into_owned()
    }
}
