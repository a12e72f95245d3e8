use crate::{Folder, gltf, images};
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(images::folder);

/// Loads the file, and checks what its loader promises; whether it has a readable header.
pub fn run(bytes: &[u8]) -> bool {
    gltf::is_past_the_header(&FOLDER.load("scene.gltf", bytes))
}
