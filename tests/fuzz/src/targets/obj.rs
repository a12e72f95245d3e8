//! `.obj` and `.mtl`: one file, which can name itself as its material library, and images beside it.

use crate::{Folder, images};
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(images::folder);

/// Loads the file, and checks what its loader promises; whether it has a statement of OBJ, which has no header.
pub fn run(bytes: &[u8]) -> bool {
    let loaded = FOLDER.load("scene.obj", bytes);
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let has_statement = lines.any(|line| !matches!(line.trim_ascii(), [] | [b'#', ..]));
    has_statement && !matches!(&loaded, Err(text) if text.contains("is not a statement of OBJ"))
}
