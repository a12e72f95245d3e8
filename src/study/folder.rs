//! The folder of a study's results, finished runs and references, which only one study at a time can use, so that two
//! studies do not render the same runs. If a study ends without a result, the files and folders that it created are removed.

use crate::{Error, Result};
use std::fs::{File, TryLockError};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// The folder of a study's results, finished runs and references. While this value exists, the folder is locked against
/// other studies. When it is dropped, an empty file of runs, its subfolders that are empty, and empty folders that
/// [`Self::open`] created are removed.
pub struct Folder {
    path: PathBuf,
    /// The paths of the folders that [`Self::open`] created, the innermost first. Those that are still empty when this value
    /// is dropped are removed.
    made: Vec<PathBuf>,
    /// The open file of finished runs, `runs.jsonl`. The lock on this file keeps other studies out of the folder; it ends
    /// when the file is closed.
    _lock: File,
}

impl Folder {
    /// Creates the folder at `path` if it does not exist, with the folders above it and its subfolders, and
    /// locks it against other studies.
    ///
    /// # Errors
    /// The folder cannot be created or written, or another study uses it.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |e| Error::writing(path, e);
        let is_new = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = path.ancestors().take_while(is_new).map(Path::to_owned);
        let made: Vec<PathBuf> = made.collect();
        let locked = std::fs::create_dir_all(path)
            .map_err(failed)
            .and_then(|()| lock(path));
        let Some(lock) = locked.inspect_err(|_| take_away_empty(path, &made))? else {
            return Err(Error::failed(format!(
                "another study is running in {}; wait until it ends, or name another folder with --output",
                path.display()
            )));
        };
        let folder = Self {
            _lock: lock,
            path: path.to_owned(),
            made,
        };
        for subfolder in subfolders(path) {
            std::fs::create_dir_all(subfolder).map_err(failed)?;
        }
        Ok(folder)
    }

    /// The path of the folder as the user gave it, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of the subfolder `references`. It contains the references (path-traced pictures that runs are compared with)
    /// as one EXR file for each block of samples.
    pub fn references(&self) -> PathBuf {
        references(&self.path)
    }

    /// The path of the subfolder `pictures`, with the last frames of one run of each configuration, which only pages show.
    pub fn pictures(&self) -> PathBuf {
        pictures(&self.path)
    }

    /// True if the folder contains a finished run or a reference. Then the folder is not removed, and the same command can
    /// continue the study; a message after a signal states this.
    pub fn holds_results(&self) -> bool {
        let has_runs = self.runs().metadata().is_ok_and(|runs| runs.len() > 0);
        let mut references = self.references().read_dir().into_iter().flatten();
        has_runs || references.next().is_some()
    }

    /// The path of the file that describes the study, `study.json` ([`Manifest`](super::manifest::Manifest)).
    pub fn manifest(&self) -> PathBuf {
        manifest(&self.path)
    }

    /// The path of the file of finished runs, `runs.jsonl`, which has one line for each run. A study that was stopped
    /// continues with these runs.
    pub fn runs(&self) -> PathBuf {
        runs(&self.path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        take_away_empty(&self.path, &self.made);
    }
}

/// Removes the file of runs and the subfolders of `folder` if they are empty. Then removes the folders in `made`
/// that are empty, in the order of that list. Errors are ignored, because the folders do no harm.
fn take_away_empty(folder: &Path, made: &[PathBuf]) {
    let runs = runs(folder);
    if runs.metadata().is_ok_and(|about| about.len() == 0) {
        let _ = std::fs::remove_file(runs);
    }
    // Folders that hold something stay.
    for subfolder in subfolders(folder) {
        let _ = std::fs::remove_dir(subfolder);
    }
    for folder in made {
        let _ = std::fs::remove_dir(folder);
    }
}

/// The path of `study.json` in `folder`: the file that describes the study
/// ([`Manifest`](super::manifest::Manifest)).
pub fn manifest(folder: &Path) -> PathBuf {
    folder.join("study.json")
}

/// The path of `runs.jsonl` in `folder`: the file of finished runs, with one line for each run.
pub fn runs(folder: &Path) -> PathBuf {
    folder.join("runs.jsonl")
}

/// The path of the subfolder `references` of `folder`, which has one EXR file for each block of samples of a
/// reference.
pub fn references(folder: &Path) -> PathBuf {
    folder.join("references")
}

/// The path of the subfolder `pictures` of `folder`, which has the last frames of one run of each
/// configuration.
pub fn pictures(folder: &Path) -> PathBuf {
    folder.join("pictures")
}

/// The path of the subfolder `pages` of `folder`, which has one HTML page for each scene.
pub fn pages(folder: &Path) -> PathBuf {
    folder.join("pages")
}

/// The paths of the subfolders that a study creates in `folder`. They are removed at the end if they are
/// empty.
fn subfolders(folder: &Path) -> [PathBuf; 3] {
    [references(folder), pictures(folder), pages(folder)]
}

/// Creates or opens the file of finished runs in `folder`, and locks it. Returns `None` if another study has the lock, and
/// an error if the file cannot be opened for writing.
fn lock(folder: &Path) -> Result<Option<File>> {
    let path = runs(folder);
    loop {
        // A pipe of that name would never open.
        let file = File::options()
            .create(true)
            .append(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(&path)
            .map_err(|e| Error::writing(&path, e))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(e)) => return Err(Error::writing(&path, e)),
        }
        // A study that was refused in between may have taken the file away.
        if file.metadata().is_ok_and(|about| about.nlink() > 0) {
            return Ok(Some(file));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_studies_do_not_share_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let first = Folder::open(&path).unwrap();
        let error = Folder::open(&path).err().unwrap();
        assert_eq!(error.exit_status(), 1);
        assert!(error.to_string().contains("another study"), "{error}");
        assert!(path.join("references").exists());
        std::fs::write(first.runs(), "a run").unwrap();
        assert!(first.holds_results());
        drop(first);
        assert_eq!(std::fs::read(runs(&path)).unwrap(), b"a run");
        Folder::open(&path).unwrap();
    }

    #[test]
    fn a_folder_that_cannot_be_made_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let too_long = "x".repeat(300);
        let error = Folder::open(&folder.path().join("a").join(too_long)).err();
        assert_eq!(error.unwrap().exit_status(), 1);
        assert!(!folder.path().join("a").exists());
    }

    #[test]
    fn what_is_empty_goes_and_what_was_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("a/b/c");
        let empty = Folder::open(&deep).unwrap();
        assert!(!empty.holds_results());
        drop(empty);
        assert!(folder.path().exists() && !folder.path().join("a").exists());
        std::fs::create_dir_all(&deep).unwrap();
        drop(Folder::open(&deep).unwrap());
        assert!(deep.exists() && deep.read_dir().unwrap().next().is_none());
        let kept = Folder::open(&deep).unwrap();
        std::fs::write(kept.references().join("x.exr"), "x").unwrap();
        assert!(kept.holds_results());
        drop(kept);
        assert!(deep.join("references/x.exr").exists());
    }
}
