//! Reads a scene from a file, whatever its format.

use super::notices::quoted;
use super::{Scene, gltf, obj};
use crate::{Error, Result};
use std::io::Read;
use std::path::Path;

/// Reads and validates a scene: glTF 2.0 (`.gltf`, `.glb`) or Wavefront OBJ (`.obj`).
///
/// Whatever the file holds, this ends in a scene that keeps to the rules of
/// [`Scene::validate`], with a notice for each thing assumed or ignored, or in an error of one
/// line that names the file, the element and what to do.
///
/// # Errors
/// A file that cannot be read, or whose content is no scene.
pub fn load(path: &Path) -> Result<Scene> {
    load_watched(path, &mut |_, _| ())
}

/// [`load`]; `watch` is told how many of the file's bytes have been read, and of how many.
///
/// # Errors
/// Those of [`load`].
pub fn load_watched(path: &Path, watch: &mut dyn FnMut(u64, u64)) -> Result<Scene> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    let folder = path.parent().unwrap_or(Path::new(""));
    let scene = match extension.as_deref() {
        Some("gltf" | "glb") => {
            let mut file = open_file(path, watch)?;
            let mut bytes = Vec::with_capacity(file.total as usize);
            file.read_to_end(&mut bytes)
                .map_err(|cause| unreadable(path, cause))?;
            if extension.as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
                Err(Error::input(
                    "is no binary glTF, its first bytes are not \"glTF\"; export it again",
                ))
            } else {
                gltf::read(&bytes, folder)
            }
        }
        Some("obj") => {
            let file = open_file(path, watch)?;
            obj::read(std::io::BufReader::with_capacity(1 << 16, file), folder)
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

/// A file that tells how far it has been read.
struct Watched<'a> {
    file: std::fs::File,
    done: u64,
    total: u64,
    watch: &'a mut dyn FnMut(u64, u64),
}

fn open_file<'a>(path: &Path, watch: &'a mut dyn FnMut(u64, u64)) -> Result<Watched<'a>> {
    let file = std::fs::File::open(path).map_err(|cause| unreadable(path, cause))?;
    // A pipe has no length; then the total stays below what is done.
    let total = file.metadata().map_or(0, |about| about.len());
    Ok(Watched {
        file,
        done: 0,
        total,
        watch,
    })
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.done += count as u64;
        (self.watch)(self.done, self.total);
        Ok(count)
    }
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
