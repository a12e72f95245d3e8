//! `.glb`.

use crate::{Folder, gltf, images};
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(images::folder);

pub fn run(bytes: &[u8]) {
    FOLDER.load("scene.glb", bytes);
}

pub use gltf::has_header;
