//! Files that store fronts (the measured time and error of each candidate), so that a scene is measured only
//! once for each device, driver, view and version of the program.

use super::front::Front;
use crate::base::files::write_atomically;
use crate::base::short_hash::short;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The content of a file that stores a front. The conditions of the measurement are stored too, because two
/// different conditions could have the same hash, which is the name of the file.
#[derive(Serialize, Deserialize)]
struct Stored {
    conditions: Value,
    front: Front,
}

/// The file that stores the front of one measurement. The conditions of the measurement decide the name of
/// the file, and are compared when the file is read.
pub struct Place {
    conditions: Value,
    file: Option<PathBuf>,
}

impl Place {
    /// Determines the file for the front that is measured under `conditions`. These must contain everything
    /// that the numbers depend on, such as scene, view, device and settings. The file is in the user's cache
    /// folder (`XDG_CACHE_HOME`, or `.cache` in `HOME`). If neither variable is set, nothing is stored.
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

    /// Path of the file that stores the front, even if it does not exist yet; `None` if there is no cache
    /// folder.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Reads the stored front. `None` if no front was stored under these conditions, if there is no cache
    /// folder, or if the file is damaged; the candidates must then be measured.
    pub fn load(&self) -> Option<Front> {
        let text = std::fs::read(self.file.as_ref()?).ok()?;
        let stored: Stored = serde_json::from_slice(&text).ok()?;
        (stored.conditions == self.conditions).then_some(stored.front)
    }

    /// Writes `front` and the conditions of its measurement to the file, so that a later command need not
    /// measure again. Does nothing if there is no cache folder.
    ///
    /// # Errors
    /// The folder cannot be made, or the file cannot be written.
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
