//! The pictures of a study for its pages: the last frames of the run with the first seed of each configuration on each scene.
//! No result depends on them, so a picture that is missing or damaged is only left out.

use crate::Result;
use crate::image::Image;
use std::path::PathBuf;

/// Linear RGB radiance: one value per pixel, row by row from the top.
type Picture = Vec<[f32; 3]>;

/// The seed of the runs whose last frames are stored as pictures.
pub const PICTURED_SEED: u32 = 0;

const COLORS: [&str; 3] = ["R", "G", "B"];

/// The prefix of the EXR channels that contain the frame before the last one.
const BEFORE: &str = "before.";

/// The last two frames of a run, which a page shows, and from which it computes flicker.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LastFrames {
    /// The last frame; empty before the first frame.
    pub last: Picture,
    /// The frame before the last one; `None` if the run has only one frame.
    pub before: Option<Picture>,
}

impl LastFrames {
    /// Adds the next frame of the run: it becomes the last frame, and the last frame becomes the one before
    /// it.
    pub fn push(&mut self, frame: Picture) {
        let before = std::mem::replace(&mut self.last, frame);
        self.before = Some(before).filter(|before| !before.is_empty());
    }
}

/// The pictures of a study in the subfolder `pictures`: one EXR file for each configuration on each scene,
/// named by the key of its runs.
pub struct Pictures {
    folder: PathBuf,
}

impl Pictures {
    /// Prepares the pictures in `folder`. This only stores the path, and opens nothing.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.exr"))
    }

    /// Writes the last frames of the run with the key `key` to its EXR file. They have `size` (width, height)
    /// pixels.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, key: &str, size: (u32, u32), frames: &LastFrames) -> Result<()> {
        let mut image = Image::new(size.0, size.1);
        image.set_vectors("", COLORS, &frames.last);
        if let Some(before) = &frames.before {
            image.set_vectors(BEFORE, COLORS, before);
        }
        image.write(&self.path(key), 0.0)
    }

    /// Reads the last frames of the run with the key `key`. `None` if there is no such file, if it is
    /// damaged, or if its pictures do not have `size` (width, height) pixels.
    pub fn read(&self, key: &str, size: (u32, u32)) -> Option<LastFrames> {
        let image = Image::read(&self.path(key)).ok()?;
        let picture = |prefix: &str| -> Option<Picture> {
            let [r, g, b] = COLORS.map(|c| image.floats(&format!("{prefix}{c}")));
            let pixels = r?.iter().zip(g?).zip(b?);
            Some(pixels.map(|((r, g), b)| [*r, *g, *b]).collect())
        };
        let frames = LastFrames {
            last: picture("")?,
            before: picture(BEFORE),
        };
        ((image.width, image.height) == size).then_some(frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_and_damaged_ones_are_missing() {
        let folder = tempfile::tempdir().unwrap();
        let pictures = Pictures::new(folder.path().to_owned());
        let mut frames = LastFrames::default();
        frames.push(vec![[0.5, 1.0, 2.0]; 6]);
        assert!(frames.before.is_none());
        pictures.write("one", (3, 2), &frames).unwrap();
        assert_eq!(pictures.read("one", (3, 2)), Some(frames.clone()));
        frames.push(vec![[0.25; 3]; 6]);
        pictures.write("two", (3, 2), &frames).unwrap();
        let read = pictures.read("two", (3, 2)).unwrap();
        assert_eq!(read.last, vec![[0.25; 3]; 6]);
        assert_eq!(read.before, Some(vec![[0.5, 1.0, 2.0]; 6]));
        assert_eq!(pictures.read("two", (2, 3)), None);
        assert_eq!(pictures.read("none", (3, 2)), None);
        let path = folder.path().join("two.exr");
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert_eq!(pictures.read("two", (3, 2)), None);
    }
}
