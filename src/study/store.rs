//! Stores the finished runs of a study in a file, to which each run is appended when it is finished, so that a study that
//! was stopped does not render it again.

use super::run::Run;
use crate::base::input_files;
use crate::{Error, Result};
use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The finished runs of a study, in memory and in a file with one JSON object for each run, each on its own line. A study
/// renders only runs that it does not have. A line that is not complete, because the program was killed while it wrote, is
/// removed, and its run is rendered again.
pub struct Store {
    path: PathBuf,
    /// The runs: a map from the key ([`Run::key`]) to a map from the seed to the run.
    runs: HashMap<String, BTreeMap<u32, Run>>,
}

impl Store {
    /// Reads all finished runs from the file `path`, and removes the rest of a line that is not complete. If the file does
    /// not exist, the store is empty. The caller has locked the folder ([`Folder`](super::folder::Folder)).
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = read(path)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n');
        let whole = whole.map_or(0, |last| last + 1);
        if whole < bytes.len() {
            cut(path, whole as u64).map_err(|e| Error::writing(path, e))?;
        }
        Ok(Self::parse(path, &bytes[..whole]))
    }

    /// Reads the finished runs from the file `path`, and changes nothing, so that the study to which the file belongs may be
    /// running.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn look_into(path: &Path) -> Result<Self> {
        Ok(Self::parse(path, &read(path)?))
    }

    fn parse(path: &Path, bytes: &[u8]) -> Self {
        let mut store = Self {
            path: path.to_owned(),
            runs: HashMap::new(),
        };
        let lines = bytes.split(|byte| *byte == b'\n');
        for run in lines.filter_map(|line| serde_json::from_slice(line).ok()) {
            store.remember(run);
        }
        store
    }

    /// All finished runs, sorted by key and then by seed.
    pub fn all(&self) -> impl Iterator<Item = &Run> {
        let mut keys: Vec<&String> = self.runs.keys().collect();
        keys.sort_unstable();
        keys.into_iter().flat_map(|key| self.runs[key].values())
    }

    /// Stores a run in memory, but not in the file; it replaces the run in memory that has the same key and seed. Therefore,
    /// if the file has two lines with the same key and seed, the later line counts. The program writes such a later line
    /// only if the run of the earlier one was damaged.
    fn remember(&mut self, run: Run) {
        let seeds = self.runs.entry(run.key.clone()).or_default();
        seeds.insert(run.seed, run);
    }

    /// The run with the key `key` ([`Run::key`]) and the seed `seed`; `None` if the store does not have it, so that it must
    /// be rendered.
    pub fn find(&self, key: &str, seed: u32) -> Option<&Run> {
        self.runs.get(key)?.get(&seed)
    }

    /// The finished runs with the key `key` ([`Run::key`]) whose seeds are in the range `seeds`, in the order of their
    /// seeds. Seeds without a finished run are left out.
    pub fn of(&self, key: &str, seeds: std::ops::Range<u32>) -> Vec<&Run> {
        let own = self.runs.get(key).into_iter();
        own.flat_map(|runs| runs.range(seeds.clone()).map(|(_, run)| run))
            .collect()
    }

    /// Stores a finished run in memory, and appends it as one line to the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, run: Run) -> Result<()> {
        let mut line =
            serde_json::to_vec(&run).map_err(|e| Error::failed(format!("a run as JSON: {e}")))?;
        line.push(b'\n');
        let mut file = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&self.path)
            .map_err(|e| Error::writing(&self.path, e))?;
        let length = file.metadata().map(|about| about.len());
        if let Err(error) = file.write_all(&line) {
            // The part that a full disk has taken is no run.
            let _ = length.map(|length| cut(&self.path, length));
            return Err(Error::writing(&self.path, error));
        }
        self.remember(run);
        Ok(())
    }
}

/// Reads all bytes of a file; returns an empty list if the file does not exist.
fn read(path: &Path) -> Result<Vec<u8>> {
    match path.exists() {
        true => input_files::read(path),
        false => Ok(Vec::new()),
    }
}

/// Cuts the file at `path` to its first `length` bytes, to remove a line that is not complete.
fn cut(path: &Path, length: u64) -> std::io::Result<()> {
    std::fs::File::options()
        .write(true)
        .open(path)?
        .set_len(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(key: &str, seed: u32) -> Run {
        Run {
            key: key.into(),
            seed,
            mean: [1.0, 2.0, 3.0],
            milliseconds: vec![vec![("pass".into(), 1.5)]],
            ..Run::default()
        }
    }

    #[test]
    fn runs_outlive_a_crash_in_the_midst_of_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut store = Store::open(&path).unwrap();
        store.add(run("a", 1)).unwrap();
        store.add(run("a", 0)).unwrap();
        store.add(run("é", 0)).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let within = whole.iter().position(|byte| *byte == 0xA9).unwrap();
        std::fs::write(&path, &whole[..within]).unwrap();

        let mut store = Store::open(&path).unwrap();
        assert!(store.find("é", 0).is_none());
        store.add(run("é", 0)).unwrap();
        let store = Store::open(&path).unwrap();
        let seeds: Vec<u32> = store.of("a", 0..9).iter().map(|r| r.seed).collect();
        assert_eq!(seeds, [0, 1]);
        assert_eq!(store.of("a", 1..9).len(), 1);
        assert!(store.of("c", 0..9).is_empty());
        assert_eq!(store.find("é", 0).unwrap().mean, [1.0, 2.0, 3.0]);
        // Every line is one object, as tools expect of such a file.
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), 3);
        for line in text.lines() {
            let value: serde_json::Value = serde_json::from_str(line).unwrap();
            assert!(value.is_object(), "{line}");
        }
        let all: Vec<(&str, u32)> = store
            .all()
            .map(|run| (run.key.as_str(), run.seed))
            .collect();
        assert_eq!(all, [("a", 0), ("a", 1), ("é", 0)]);
    }
}
