//! The store of measured fronts, so that a scene is measured once for each device, driver, view and version of the program.

use super::front::Front;
use crate::base::files::write_atomically;
use crate::base::short_hash::short;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of the store: what was measured, and under which conditions.
#[derive(Serialize, Deserialize)]
struct Stored {
    conditions: Value,
    front: Front,
}

/// The place of one front in the store.
pub struct Place {
    conditions: Value,
    file: Option<PathBuf>,
}

impl Place {
    /// The place for a front that was measured under `conditions`: everything that its numbers depend on. Without a folder for
    /// caches (`XDG_CACHE_HOME` or `HOME`), nothing is stored.
    pub fn of(conditions: Value) -> Self {
        let folder = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
        let folder = folder.filter(|folder| folder.is_absolute());
        let folder =
            folder.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache")));
        let name = short(&blake3::hash(conditions.to_string().as_bytes()));
        Self {
            file: folder.map(|folder| folder.join(format!("headwater/fronts/{name}.json"))),
            conditions,
        }
    }

    /// The path of the file; `None` if there is no folder for caches.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The stored front; `None` if there is none for these conditions. A damaged file counts as none.
    pub fn load(&self) -> Option<Front> {
        let text = std::fs::read(self.file.as_ref()?).ok()?;
        let stored: Stored = serde_json::from_slice(&text).ok()?;
        (stored.conditions == self.conditions).then_some(stored.front)
    }

    /// Stores a front, if there is a folder for caches.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn store(&self, front: &Front) -> Result<()> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|e| Error::writing(folder, e))?;
        }
        let stored = Stored {
            conditions: self.conditions.clone(),
            front: front.clone(),
        };
        let text = crate::base::json::value_of("the measurements", &stored)?;
        write_atomically(file, |file| writeln!(file, "{text:#}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_front_is_found_by_its_conditions_only() {
        let folder = tempfile::tempdir().unwrap();
        let place = |conditions: Value| Place {
            file: Some(folder.path().join("fronts/front.json")),
            conditions,
        };
        let front: Front = serde_json::from_value(json!({
            "purpose": "steady", "size": [1, 1], "wanted_size": [2, 2], "reference_samples": 8,
            "verdict": "better", "finalists": [], "race": [], "seconds": 1.5, "compilation_seconds": 2.0,
        }))
        .unwrap();
        let own = place(json!({ "scene": "a" }));
        assert!(own.load().is_none());
        own.store(&front).unwrap();
        let file = own.file().unwrap().to_owned();
        assert_eq!(own.load().unwrap().wanted_size, (2, 2));
        // Other conditions with the same hash, and a damaged file, count as nothing.
        assert!(place(json!({ "scene": "b" })).load().is_none());
        std::fs::write(file, "{").unwrap();
        assert!(own.load().is_none());
    }
}
