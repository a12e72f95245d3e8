//! Stores the finished runs of a study in a file, to which each run is appended when it is finished, so that a study that
//! was stopped does not render it again.

use super::run::Run;
use crate::base::input_files;
use crate::{Error, Result};
use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The finished runs of a study, in memory and in a file with one line of JSON for each run. A study renders only runs that
/// it does not have. A line that is not complete, because the program was killed while it wrote, is ignored, and its run is
/// rendered again.
pub struct Store {
    path: PathBuf,
    /// The runs: a map from the key ([`Run::key`]) to a map from the seed to the run.
    runs: HashMap<String, BTreeMap<u32, Run>>,
}

impl Store {
    /// Reads all finished runs from the file `path`. If the file does not exist, the store is empty.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = match path.exists() {
            true => input_files::read(path)?,
            false => Vec::new(),
        };
        let mut store = Self {
            path: path.to_owned(),
            runs: HashMap::new(),
        };
        // A line may be cut short within a character.
        let lines = bytes.split(|byte| *byte == b'\n');
        for run in lines.filter_map(|line| serde_json::from_slice(line).ok()) {
            store.remember(run);
        }
        Ok(store)
    }

    /// Stores a run in memory, but not in the file; it replaces the run in memory that has the same key and seed. Therefore,
    /// if the file has two lines with the same key and seed, the later line counts. The program writes such a later line
    /// only if the run of the earlier one was damaged.
    fn remember(&mut self, run: Run) {
        let seeds = self.runs.entry(run.key.clone()).or_default();
        seeds.insert(run.seed, run);
    }

    /// Removes from memory those runs with the key `key` ([`Run::key`]) that do not have `frames` frames and `blocks` blocks
    /// of pixels. Their lines in the file were edited or damaged, and the runs are then rendered again.
    pub fn keep_whole(&mut self, key: &str, frames: usize, blocks: usize) {
        if let Some(runs) = self.runs.get_mut(key) {
            runs.retain(|_, run| run.has_lengths(frames, blocks));
        }
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
        let line = serde_json::to_string(&run)
            .map_err(|e| Error::failed(format!("a run as JSON: {e}")))?;
        let mut file = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&self.path)
            .map_err(|e| Error::writing(&self.path, e))?;
        // A line that a crash cut short must not swallow this one.
        file.write_all(format!("\n{line}\n").as_bytes())
            .map_err(|e| Error::writing(&self.path, e))?;
        self.remember(run);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(key: &str, seed: u32) -> Run {
        Run {
            key: key.into(),
            seed,
            mean: [1.0, 2.0, 3.0],
            milliseconds: vec![("pass".into(), 1.5)],
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
    }

    #[test]
    fn a_run_of_other_lengths_is_left_out_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let whole = Run {
            rmse: vec![0.0; 2],
            rmse_clamped: vec![0.0; 2],
            relmse: vec![0.0; 2],
            correlation: vec![0.0; 2],
            median: vec![1.0; 2],
            blocks: vec![0.0; 3],
            ..run("a", 0)
        };
        let lists: [fn(&mut Run) -> &mut Vec<f64>; 6] = [
            |run| &mut run.rmse,
            |run| &mut run.rmse_clamped,
            |run| &mut run.relmse,
            |run| &mut run.correlation,
            |run| &mut run.median,
            |run| &mut run.blocks,
        ];
        let mut store = Store::open(&path).unwrap();
        for (seed, list) in (0..).zip(&lists) {
            let mut longer = Run {
                seed,
                ..whole.clone()
            };
            list(&mut longer).push(0.0);
            store.add(longer).unwrap();
            let mut shorter = Run {
                seed: 10 + seed,
                ..whole.clone()
            };
            list(&mut shorter).pop();
            store.add(shorter).unwrap();
        }
        assert_eq!(store.of("a", 0..20).len(), 2 * lists.len());
        store.keep_whole("a", 2, 3);
        assert!(store.of("a", 0..20).is_empty());
        store.add(whole).unwrap();
        let mut store = Store::open(&path).unwrap();
        store.keep_whole("a", 2, 3);
        assert_eq!(store.of("a", 0..20).len(), 1);
    }
}
