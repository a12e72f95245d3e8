//! Golden frames: a folder for each driver, with a list and a picture for each case.

use super::cases::Case;
use crate::files::write_atomically;
use crate::gpu::{DeviceInfo, Output};
use crate::image::Image;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
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

/// Where the older set of a device is while a new one takes its place.
fn older(folder: &Path, device: &DeviceInfo) -> PathBuf {
    folder.join(format!(".older-{}", folder_name(device)))
}

impl Goldens {
    /// An empty set for a device, to be filled in a folder beside its own.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(folder: &Path, device: &DeviceInfo) -> Result<(Self, tempfile::TempDir)> {
        let failed = |e| Error::writing(folder, e);
        std::fs::create_dir_all(folder).map_err(failed)?;
        // What a killed start has left between the two steps of `finish`.
        let (own, older) = (folder.join(folder_name(device)), older(folder, device));
        if older.is_dir() && !own.exists() {
            std::fs::rename(&older, &own).map_err(failed)?;
        }
        let work = tempfile::Builder::new()
            .prefix(".golden-")
            .tempdir_in(folder)
            .map_err(failed)?;
        let goldens = Self {
            version: VERSION,
            device: device.name.clone(),
            driver: device.driver.clone(),
            commit: env!("HEADWATER_COMMIT").to_owned(),
            cases: BTreeMap::new(),
            folder: work.path().to_owned(),
        };
        Ok((goldens, work))
    }

    /// Adds a case.
    ///
    /// # Errors
    /// The picture cannot be written.
    pub fn add(&mut self, case: &Case, image: &Image, steps: Vec<Step>) -> Result<()> {
        let path = self.picture(&case.name);
        image.write(&path, 0.0)?;
        let golden = Golden {
            arguments: case.arguments.clone(),
            picture: hash(&path)?,
            steps,
        };
        self.cases.insert(case.name.clone(), golden);
        Ok(())
    }

    /// Adds the cases of the driver's older set, if there is one, that are not in this one.
    ///
    /// # Errors
    /// The older set is damaged, or the disk fails.
    pub fn add_older(&mut self, folder: &Path, device: &DeviceInfo) -> Result<()> {
        let folder = folder.join(folder_name(device));
        if !folder.is_dir() {
            return Ok(());
        }
        let older = Self::read(&folder)?;
        for (name, golden) in &older.cases {
            if !self.cases.contains_key(name) {
                let (from, to) = (older.picture(name), self.picture(name));
                std::fs::copy(&from, &to).map_err(|e| Error::reading(&from, e))?;
                self.cases.insert(name.clone(), golden.clone());
            }
        }
        Ok(())
    }

    /// Puts a complete set in the place of the driver's older one. `work` is the folder of [`Self::begin`].
    ///
    /// # Errors
    /// The disk does not take it; then the older one stays.
    pub fn finish(
        self,
        folder: &Path,
        device: &DeviceInfo,
        work: tempfile::TempDir,
    ) -> Result<PathBuf> {
        let list = serde_json::to_string_pretty(&self)
            .map_err(|e| Error::failed(format!("golden frames as JSON: {e}")))?;
        write_atomically(&work.path().join(LIST), |file| writeln!(file, "{list}"))?;
        let target = folder.join(folder_name(device));
        let failed = |e| Error::writing(&target, e);
        // Readable by others, which temporary folders are not.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let permissions = std::fs::Permissions::from_mode(0o755);
            std::fs::set_permissions(work.path(), permissions).map_err(failed)?;
        }
        // A folder is replaced in two steps, of which the first can be taken back.
        let older = older(folder, device);
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
        let text = std::fs::read_to_string(&path).map_err(|e| Error::reading(&path, e))?;
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
    let bytes = std::fs::read(path).map_err(|e| Error::reading(path, e))?;
    Ok(blake3::hash(&bytes).to_hex()[..16].to_owned())
}
