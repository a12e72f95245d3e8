//! Reads a scene from a file of any supported format: glTF or OBJ.

use super::progress::{Progress, Watch, Watched};
use super::scene_folder::SceneFolder;
use super::{Options, gltf, obj};
use crate::base::timed::timed;
use crate::base::{input_files, memory};
use crate::scene::Scene;
use crate::scene::notices::quoted;
use crate::{Error, Result};
use std::fs::File;
use std::path::Path;

/// The maximum size of a glTF file (`.gltf` or `.glb`), in bytes, not counting buffers and images in files of their own; a
/// larger file is an error. It is the largest length that a GLB file can state, because the length in its header has 32
/// bits.
const MAX_BYTES: u64 = u32::MAX as u64;

/// The memory that the scene of an OBJ file is assumed to take, in bytes, is this number times the size of the file. If less
/// memory is free, the file is refused before it is read.
const OBJ_RATIO: u64 = 4;

/// Reads and validates a scene from the file `path`: glTF 2.0 (`.gltf`, `.glb`) or Wavefront OBJ (`.obj`). If the scene
/// names files outside of its folder or image files that are missing, this is an error.
///
/// For any content of the file this returns either a scene that passes [`Scene::validate`], or an error of one line that
/// names the file, the element and a remedy. The notices of the scene list what the reader assumed and what it left out.
///
/// # Errors
/// The file has another extension or cannot be read, its content is not a valid scene, or there is not enough memory for it.
pub fn load(path: &Path) -> Result<Scene> {
    load_watched(path, Options::default(), &mut |_, _, _| Ok(()))
}

/// Reads and validates a scene from the file `path`, as [`load`] does. `options` are the user's permissions for missing
/// image files and for files outside of the scene's folder, and the material variant; `watch` is called with the progress of the loading.
///
/// # Errors
/// The errors of [`load`], except those about files that `options` permit; a material variant that the scene does not have;
/// and an error that `watch` returns, which ends the
/// loading.
pub fn load_watched(path: &Path, options: Options, watch: &mut Watch<'_>) -> Result<Scene> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    let folder = SceneFolder::new(path.parent().unwrap_or(Path::new("")), &options);
    let mut progress = Progress::new(watch);
    let scene = timed("reading the scene", || match extension.as_deref() {
        Some("gltf" | "glb") => read_whole(path, &mut progress).and_then(|bytes| {
            if extension.as_deref() == Some("glb") && !bytes.starts_with(b"glTF") {
                return Err(Error::input(
                    "is not a GLB file (no glTF header); export it again",
                ));
            }
            gltf::read(&bytes, &folder, &mut progress)
        }),
        Some("obj") => open_file(path, &mut progress).and_then(|(file, length)| {
            memory::check(length.saturating_mul(OBJ_RATIO))
                .map_err(|cause| Error::input(format!("{cause}; give a smaller scene")))?;
            obj::read(&file, length, &folder, &mut progress)?.load_textures(&folder, &mut progress)
        }),
        _ => Err(Error::input(
            "is not a scene file; give a .gltf, .glb or .obj file",
        )),
    });
    scene
        .and_then(|mut scene| {
            check_variant(&scene.material_variants, &options)?;
            timed("checking the scene", || scene.validate())?;
            Ok(finished(scene, path))
        })
        .map_err(|error| match error {
            Error::Input(fault) => Error::input(format!("{}: {fault}", path.to_string_lossy())),
            other => other,
        })
}

/// Opens the scene's file, and adds its size to the number of bytes that `progress` expects to be read. Returns the open
/// file and its size in bytes.
fn open_file(path: &Path, progress: &mut Progress<'_>) -> Result<(File, u64)> {
    let file = input_files::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    progress.add_to_read(length);
    Ok((file, length))
}

/// Reads the whole content of a glTF file, and reports to `progress` how much was read. Fails if the file has more than
/// [`MAX_BYTES`] bytes, cannot be read, or is larger than the free memory.
fn read_whole(path: &Path, progress: &mut Progress<'_>) -> Result<Vec<u8>> {
    let (file, length) = open_file(path, progress)?;
    if length > MAX_BYTES {
        return Err(Error::input(format!(
            "has {length} bytes, a glTF file at most {MAX_BYTES}; give a smaller scene, or one with its buffers in files of their own"
        )));
    }
    input_files::read_length(Watched::new(file, progress), length)
        .map_err(|cause| Error::from_io(cause, unreadable))
}

/// Fails if the user has chosen a material variant that is not among `names`, the variants of the scene. The error lists them.
fn check_variant(names: &[String], options: &Options) -> Result<()> {
    const MAX_NAMES: usize = 16;
    let Some(wanted) = &options.material_variant else {
        return Ok(());
    };
    if names.contains(wanted) {
        return Ok(());
    }
    let listed: Vec<String> = names
        .iter()
        .take(MAX_NAMES)
        .map(|name| quoted(name))
        .collect();
    let more = if names.len() > MAX_NAMES { ", …" } else { "" };
    let remedy = match names {
        [] => "leave out --material-variant, the scene has no variants".to_owned(),
        _ => format!("choose one of {}{more}", listed.join(", ")),
    };
    Err(Error::input(format!(
        "there is no material variant {}; {remedy}",
        quoted(wanted)
    )))
}

fn finished(mut scene: Scene, path: &Path) -> Scene {
    scene.name = path
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default();
    if scene.triangle_count() == 0 {
        scene
            .notices
            .push("the scene has no triangles, so nothing can be seen".into());
    }
    scene
}

/// The error that the scene's file cannot be read because of `cause`. Its text does not contain the path, because
/// [`load_watched`] puts the path in front of it.
fn unreadable(cause: std::io::Error) -> Error {
    Error::input(format!("cannot be read: {cause}"))
}
