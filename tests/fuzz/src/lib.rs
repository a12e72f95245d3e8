//! Fuzz targets share this: a folder in memory, the promises that every loader keeps, and counts.

pub mod gltf;
pub mod images;
pub mod targets;
pub mod words;

use headwater::scene::Scene;
use headwater::scene_files::{Options, load_watched};
use headwater::{Error, Result};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use tempfile::TempDir;

#[path = "../../../src/scene_files/gltf/document/mod.rs"]
#[allow(dead_code)]
mod document;

#[path = "../../loading/files.rs"]
#[allow(dead_code)]
pub mod files;
#[path = "../../support/random.rs"]
#[allow(dead_code)]
pub mod random;

/// Executions between two lines of counts; before, each has a line, so that short runs are counted too.
const REPORT_EVERY: u64 = 1_000;

/// Counts of a target's executions, which `run` reads from the standard error.
#[derive(Default)]
pub struct Counts {
    all: AtomicU64,
    past_the_header: AtomicU64,
}

impl Counts {
    /// No executions yet.
    pub const fn new() -> Self {
        Self {
            all: AtomicU64::new(0),
            past_the_header: AtomicU64::new(0),
        }
    }

    /// Counts one execution.
    pub fn add(&self, is_past_the_header: bool) {
        let all = self.all.fetch_add(1, Ordering::Relaxed) + 1;
        let past = (self.past_the_header).fetch_add(is_past_the_header.into(), Ordering::Relaxed)
            + u64::from(is_past_the_header);
        if all < REPORT_EVERY || all.is_multiple_of(REPORT_EVERY) {
            eprintln!("headwater: {all} executions, {past} past the header");
        }
    }
}

/// A number that depends on all bytes of an input, by which targets choose.
pub fn hash(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish()
}

/// True if the bytes are TOML with at least one key.
pub fn has_key(bytes: &[u8]) -> bool {
    let text = str::from_utf8(bytes).unwrap_or_default();
    text.parse::<toml::Table>()
        .is_ok_and(|table| !table.is_empty())
}

/// True for one input in 16: what takes long is checked for these.
pub fn is_thorough(bytes: &[u8]) -> bool {
    hash(bytes).is_multiple_of(16)
}

/// A folder for the files of a target. `run` puts it into memory.
pub struct Folder(TempDir);

impl Folder {
    /// A new folder with these files.
    #[allow(clippy::new_without_default)]
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, bytes) in files {
            folder.write(name, bytes);
        }
        folder
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).expect("a file in a temporary folder");
        path
    }

    /// Writes a scene file, loads it with options that depend on its bytes, and checks the promises of the loader.
    pub fn load(&self, name: &str, bytes: &[u8]) {
        let bits = hash(bytes) >> 32;
        let options = Options {
            allow_missing: bits & 1 == 1,
            allow_outside: bits & 2 == 2,
            // Another name than that of a variant is an error, so few files get one.
            material_variant: (bits & 28 == 28).then(|| "a".to_owned()),
        };
        self.open(&self.write(name, bytes), options);
    }

    /// [`Folder::load`] for a file that exists.
    pub fn open(&self, path: &Path, options: Options) {
        match load_watched(path, options, &mut |_, _, _| Ok(())) {
            Ok(scene) => check_scene(scene),
            Err(error) => {
                let text = one_line(&error);
                assert!(text.contains("scene."), "{text:?} names the file");
            }
        }
    }
}

/// A loaded scene is valid, a second validation changes nothing, and it can be posed at any time.
fn check_scene(mut scene: Scene) {
    let hash = scene.content_hash();
    scene.validate().expect("a loaded scene is valid");
    assert_eq!(
        scene.content_hash(),
        hash,
        "a second validation changes nothing"
    );
    for notice in &scene.notices {
        assert_eq!(notice.lines().count(), 1, "{notice:?}");
    }
    if let Some(motion) = &scene.motion {
        let end = motion.seconds();
        for time in [0.5 * end, end, -1.0] {
            if let Err(error) = scene.pose_at(time) {
                one_line(&error);
            }
        }
    }
}

/// The text of an error, which is one line about wrong input.
pub fn one_line(error: &Error) -> String {
    let text = error.to_string();
    assert_eq!(error.exit_status(), 2, "{text}");
    assert_eq!(text.lines().count(), 1, "{text:?}");
    text
}

/// The value, or none for an error that is one line about wrong input.
pub fn checked<T>(result: Result<T>) -> Option<T> {
    result.map_err(|error| one_line(&error)).ok()
}
