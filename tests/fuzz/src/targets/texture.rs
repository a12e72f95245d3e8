//! Images of textures: PNG, JPEG, WebP and KTX2, beside a scene that shows them.

use crate::{Folder, images, is_thorough};
use headwater::scene_files::Options;
use std::path::PathBuf;
use std::sync::LazyLock;

static FOLDER: LazyLock<(Folder, PathBuf)> = LazyLock::new(|| {
    let folder = Folder::new(&[]);
    let scene = folder.write("scene.gltf", images::shown("image").as_bytes());
    (folder, scene)
});

pub fn run(bytes: &[u8]) {
    // A few bytes can stand for an image that takes a second: a corpus of these would be read for minutes.
    if images::is_large(bytes) && !is_thorough(bytes) {
        return;
    }
    let (folder, scene) = &*FOLDER;
    folder.write("image", bytes);
    folder.open(scene, Options::default());
}

pub fn has_header(bytes: &[u8]) -> bool {
    images::has_image_header(bytes, &images::TEXTURE_FORMATS) || images::ktx2_size(bytes).is_some()
}
