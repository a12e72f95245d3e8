//! `.obj` and `.mtl`: one file, which can name itself as its material library, and images beside it.

use crate::{Folder, images, words};
use std::sync::LazyLock;

static FOLDER: LazyLock<Folder> = LazyLock::new(images::folder);

pub fn run(bytes: &[u8]) {
    FOLDER.load("scene.obj", bytes);
}

/// OBJ has no header: whether the first line that is not a comment begins with a word of OBJ or MTL.
pub fn has_header(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !matches!(line, [] | [b'#', ..]));
    first.is_some_and(|line| {
        let word = line
            .split(u8::is_ascii_whitespace)
            .next()
            .unwrap_or_default();
        words::OBJ
            .split_whitespace()
            .any(|known| known.as_bytes() == word)
    })
}
