//! Golden frames: a folder for each driver, with a list and a picture for each case.

use super::cases::Case;
use crate::files::write_atomically;
use crate::gpu::{DeviceInfo, Output};
use crate::image::Image;
use crate::short_hash::short;
use crate::{Error, Result, input_files};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Version of the lists.
const VERSION: u32 = 1;
/// The list in a driver's folder.
const LIST: &str = "golden.json";

/// What a pass of a frame wrote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// The frame.
    pub frame: u32,
    /// The pass.
    pub pass: String,
    /// The buffer that it wrote.
    pub buffer: String,
    /// A hash of all bytes of the buffer after it.
    pub hash: String,
}

impl Step {
    /// What a pass of frame `frame` wrote.
    pub fn of(frame: u32, output: Output) -> Self {
        Self {
            frame,
            pass: output.pass,
            buffer: output.buffer,
            hash: output.hash,
        }
    }
}

/// A case as it was once rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Golden {
    /// Arguments of the case.
    pub arguments: String,
    /// Hash of the file of the picture.
    pub picture: String,
    /// What its passes wrote, in order.
    pub steps: Vec<Step>,
}

/// The golden frames of a driver.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Goldens {
    version: u32,
    /// Name of the device.
    pub device: String,
    /// Name and version of the driver.
    pub driver: String,
    /// The revision of Headwater that made them.
    pub commit: String,
    /// By name of the case.
    pub cases: BTreeMap<String, Golden>,
    #[serde(skip)]
    folder: PathBuf,
}

/// The name of a driver's folder: what must be the same for the same bits. Names and versions of drivers have the version of
/// the compiler and the width of vectors in them.
fn folder_name(device: &DeviceInfo) -> String {
    let text = format!("{} {}", device.name, device.driver);
    let letters = text.chars().map(|c| {
        if c.is_ascii_alphanumeric() || c == '.' {
            c
        } else {
            '-'
        }
    });
    let words: String = letters.collect();
    let words = words.split('-').filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

/// A new set of golden frames, which takes the place of an older one of the same driver when it is complete.
pub struct Blessing {
    /// So far, in the folder `work`.
    goldens: Goldens,
    work: tempfile::TempDir,
    /// Where the set will be.
    target: PathBuf,
    /// Where the older set is while this one takes its place.
    older: PathBuf,
}

impl Blessing {
    /// An empty set for a device, in a folder beside that of its older set.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(folder: &Path, device: &DeviceInfo) -> Result<Self> {
        let failed = |e| Error::writing(folder, e);
        std::fs::create_dir_all(folder).map_err(failed)?;
        let name = folder_name(device);
        let (target, older) = (folder.join(&name), folder.join(format!(".older-{name}")));
        // What a killed start has left between the two steps of `finish`.
        if older.is_dir() && !target.exists() {
            std::fs::rename(&older, &target).map_err(failed)?;
        }
        let work = tempfile::Builder::new()
            .prefix(".golden-")
            .tempdir_in(folder)
            .map_err(failed)?;
        let goldens = Goldens {
            version: VERSION,
            device: device.name.clone(),
            driver: device.driver.clone(),
            commit: env!("HEADWATER_COMMIT").to_owned(),
            cases: BTreeMap::new(),
            folder: work.path().to_owned(),
        };
        Ok(Self {
            goldens,
            work,
            target,
            older,
        })
    }

    /// Adds a case.
    ///
    /// # Errors
    /// The picture cannot be written.
    pub fn add(&mut self, case: &Case, image: &Image, steps: Vec<Step>) -> Result<()> {
        let path = self.goldens.picture(&case.name);
        image.write(&path, 0.0)?;
        let golden = Golden {
            arguments: case.arguments.clone(),
            picture: hash(&path)?,
            steps,
        };
        self.goldens.cases.insert(case.name.clone(), golden);
        Ok(())
    }

    /// Adds the cases of the older set, if there is one, that are not in this one.
    ///
    /// # Errors
    /// The older set is damaged, or the disk fails.
    pub fn add_older(&mut self) -> Result<()> {
        if !self.target.is_dir() {
            return Ok(());
        }
        let older = Goldens::read(&self.target)?;
        for (name, golden) in &older.cases {
            if !self.goldens.cases.contains_key(name) {
                let (from, to) = (older.picture(name), self.goldens.picture(name));
                std::fs::copy(&from, &to).map_err(|e| Error::reading(&from, e))?;
                self.goldens.cases.insert(name.clone(), golden.clone());
            }
        }
        Ok(())
    }

    /// Puts the set in the place of the older one; returns where it is.
    ///
    /// # Errors
    /// The disk does not take it; then the older one stays.
    pub fn finish(self) -> Result<PathBuf> {
        let Self {
            goldens,
            work,
            target,
            older,
        } = self;
        let list = serde_json::to_string_pretty(&goldens)
            .map_err(|e| Error::failed(format!("golden frames as JSON: {e}")))?;
        write_atomically(&work.path().join(LIST), |file| writeln!(file, "{list}"))?;
        let failed = |e| Error::writing(&target, e);
        // Readable by others, which temporary folders are not.
        let permissions = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(work.path(), permissions).map_err(failed)?;
        // A folder is replaced in two steps, of which the first can be taken back.
        let _ = std::fs::remove_dir_all(&older);
        let had = target.exists();
        if had {
            std::fs::rename(&target, &older).map_err(failed)?;
        }
        if let Err(error) = std::fs::rename(work.path(), &target) {
            if had {
                let _ = std::fs::rename(&older, &target);
            }
            return Err(failed(error));
        }
        let _ = std::fs::remove_dir_all(&older);
        Ok(target)
    }
}

impl Goldens {
    /// The golden frames of a device, or else those of another; whether they are its own.
    ///
    /// # Errors
    /// There are none, or what is there cannot be read.
    pub fn find(folder: &Path, device: &DeviceInfo) -> Result<(Self, bool)> {
        let own = folder.join(folder_name(device));
        if own.is_dir() {
            return Ok((Self::read(&own)?, true));
        }
        let entries = std::fs::read_dir(folder).map_err(|e| Error::reading(folder, e))?;
        let mut others: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            // What begins with a dot is not, or no longer, a whole set.
            .filter(|path| {
                !path
                    .file_name()
                    .is_some_and(|n| n.to_string_lossy().starts_with('.'))
            })
            .filter(|path| path.join(LIST).is_file())
            .collect();
        others.sort();
        match others.first() {
            Some(other) => Ok((Self::read(other)?, false)),
            None => Err(Error::input(format!(
                "{} holds no golden frames; --bless makes those of this driver",
                folder.display()
            ))),
        }
    }

    fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(LIST);
        let text = input_files::read_text(&path, input_files::MAX_JSON_BYTES)?;
        let damaged = |why: String| {
            Error::input(format!(
                "{}: {why}; restore the folder, or make it again with --bless on its driver",
                path.display()
            ))
        };
        let goldens: Self =
            serde_json::from_str(&text).map_err(|e| damaged(format!("it is damaged ({e})")))?;
        if goldens.version != VERSION {
            return Err(damaged(format!(
                "its version is {}, not {VERSION}",
                goldens.version
            )));
        }
        Ok(Self {
            folder: folder.to_owned(),
            ..goldens
        })
    }

    /// The file of a case's picture.
    fn picture(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.exr"))
    }

    /// A case and its picture; `None` if it was not rendered then, as where the driver lacked something.
    ///
    /// # Errors
    /// The picture is missing or damaged, or the case was another one.
    pub fn case(&self, case: &Case) -> Result<Option<(&Golden, Image)>> {
        let Some(golden) = self.cases.get(&case.name) else {
            return Ok(None);
        };
        let path = self.picture(&case.name);
        let damaged = |why: &str| {
            Error::input(format!(
                "{}: {why}; restore the file, or make all again with --bless",
                path.display()
            ))
        };
        if golden.arguments != case.arguments {
            return Err(damaged(&format!(
                "it was rendered with other arguments ({})",
                golden.arguments
            )));
        }
        if hash(&path)? != golden.picture {
            return Err(damaged("the golden picture is damaged"));
        }
        Ok(Some((golden, Image::read(&path)?)))
    }
}

fn hash(path: &Path) -> Result<String> {
    let bytes = input_files::read(path)?;
    Ok(short(&blake3::hash(&bytes)))
}
