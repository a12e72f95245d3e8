//! Golden frames on disk: a folder for each driver, with a JSON list and one picture per case.

use super::cases::Case;
use crate::base::files::write_atomically;
use crate::base::input_files;
use crate::base::short_hash::short;
use crate::gpu::{DeviceInfo, Output};
use crate::image::Image;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Version of the form of `golden.json`. A list of another version is refused.
const VERSION: u32 = 1;
/// The file name of the list of golden frames in the folder of a driver.
const LIST: &str = "golden.json";

/// A hash of one buffer after one pass of one frame. The first step that differs from the golden steps shows where a fault
/// begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// The index of the frame, counted from 0.
    pub frame: u32,
    /// The name of the pass.
    pub pass: String,
    /// The name of the buffer, which the pass may write.
    pub buffer: String,
    /// The BLAKE3 hash of all bytes of the buffer after the pass: its first 16 hexadecimal digits.
    pub hash: String,
}

impl Step {
    /// Makes a step from a recorded output of a pass in the frame with index `frame`.
    pub fn of(frame: u32, output: Output) -> Self {
        Self {
            frame,
            pass: output.pass,
            buffer: output.buffer,
            hash: output.hash,
        }
    }
}

/// The stored result of one case on the trusted driver; the picture itself is in a separate file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Golden {
    /// The arguments of `render` with which the case was rendered. If the case has other arguments now, the golden frame is
    /// refused.
    pub arguments: String,
    /// The BLAKE3 hash of the EXR file of the picture, its first 16 hexadecimal digits. It shows whether the file is
    /// damaged.
    pub picture: String,
    /// The hashes of the outputs of all passes, in the order in which the passes ran.
    pub steps: Vec<Step>,
}

/// The set of golden frames of one device and driver.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Goldens {
    version: u32,
    /// Name of the device that rendered the golden frames.
    pub device: String,
    /// Name and version of the driver that rendered the golden frames.
    pub driver: String,
    /// The revision of Headwater that wrote the set: a git commit of 12 hexadecimal digits, then `+` if files had been
    /// changed. It is empty for a build outside a checkout. Golden frames that `--only` left in place may come from an older
    /// revision.
    pub commit: String,
    /// The golden frames by the names of their cases.
    pub cases: BTreeMap<String, Golden>,
    #[serde(skip)]
    folder: PathBuf,
}

/// The name of the folder for a device and its driver: their names and the driver's version, joined by hyphens. A driver
/// that may compute other bits has another folder, because drivers put the version of their compiler and the width of
/// vectors into these names.
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

/// A new set of golden frames, which replaces an older one of the same driver when it is complete. Until then it is in
/// memory, so that nothing must be cleaned up if the work ends early.
pub struct Blessing {
    goldens: Goldens,
    /// The pictures of the cases that were rendered for this set, by the names of the cases.
    pictures: BTreeMap<String, Image>,
    /// The folder of all golden frames, which has one folder per driver.
    folder: PathBuf,
    /// The paths of this driver's set.
    locations: Locations,
}

/// The beginning of the names of temporary folders, in which new sets of golden frames are written.
const WORK: &str = ".golden-";

impl Blessing {
    /// An empty set for the driver of `device`. `folder` has one folder per driver; nothing is written to it yet.
    pub fn new(folder: &Path, device: &DeviceInfo) -> Self {
        let locations = Locations::new(folder, device);
        let goldens = Goldens {
            version: VERSION,
            device: device.name.clone(),
            driver: device.driver.clone(),
            commit: env!("HEADWATER_COMMIT").to_owned(),
            cases: BTreeMap::new(),
            folder: locations.target.clone(),
        };
        Self {
            goldens,
            pictures: BTreeMap::new(),
            folder: folder.to_owned(),
            locations,
        }
    }

    /// Adds a rendered case with its picture and the hashes of its passes. It replaces an older golden frame of the same
    /// case.
    pub fn add(&mut self, case: &Case, image: Image, steps: Vec<Step>) {
        let golden = Golden {
            arguments: case.arguments.clone(),
            // Known once the picture is written.
            picture: String::new(),
            steps,
        };
        self.goldens.cases.insert(case.name.clone(), golden);
        self.pictures.insert(case.name.clone(), image);
    }

    /// Adds the cases of the driver's set on disk, if there is one, so that `--only` keeps the cases that it does not
    /// render. Cases that are added later replace them. [`Self::finish`] copies the pictures of those that remain.
    ///
    /// # Errors
    /// The list of the set on disk cannot be read, is damaged, or has another version.
    pub fn add_older(&mut self) -> Result<()> {
        if let Some(older) = self.locations.set() {
            for (name, golden) in Goldens::read(older)?.cases {
                self.goldens.cases.insert(name, golden);
            }
        }
        Ok(())
    }

    /// Writes the set, which replaces the driver's older set, and returns the path of its folder.
    ///
    /// # Errors
    /// A file cannot be written, or a picture of the older set cannot be copied; then the older set stays.
    pub fn finish(self) -> Result<PathBuf> {
        let Self {
            mut goldens,
            pictures,
            folder,
            locations,
        } = self;
        std::fs::create_dir_all(&folder).map_err(|e| Error::writing(&folder, e))?;
        // While this lasts, no other program writes a set here, and what one has left is of no use to anyone.
        let lock = File::open(&folder).and_then(|folder| folder.lock().map(|()| folder));
        if lock.is_ok() {
            remove_unfinished(&folder);
        }
        let work = tempfile::Builder::new()
            .prefix(WORK)
            .tempdir_in(&folder)
            .map_err(|e| Error::writing(&folder, e))?;
        for (name, golden) in &mut goldens.cases {
            let file = picture(work.path(), name);
            match pictures.get(name) {
                Some(image) => {
                    image.write(&file, 0.0)?;
                    golden.picture = hash(&file)?;
                }
                None => {
                    let from = picture(locations.set().unwrap_or(&locations.target), name);
                    std::fs::copy(&from, &file).map_err(|e| Error::reading(&from, e))?;
                }
            }
        }
        let list = serde_json::to_string_pretty(&goldens)
            .map_err(|e| Error::failed(format!("golden frames as JSON: {e}")))?;
        write_atomically(&work.path().join(LIST), |file| writeln!(file, "{list}"))?;
        let Locations { target, older } = locations;
        let failed = |e| Error::writing(&target, e);
        // Readable by others, which temporary folders are not.
        let permissions = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(work.path(), permissions).map_err(failed)?;
        // A folder is replaced in two steps, of which the first can be taken back.
        let had = target.exists();
        if had {
            let _ = std::fs::remove_dir_all(&older);
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

/// The paths where the set of golden frames of a driver can be.
struct Locations {
    target: PathBuf,
    /// The path of the older set while a new set takes its place.
    older: PathBuf,
}

impl Locations {
    fn new(folder: &Path, device: &DeviceInfo) -> Self {
        let name = folder_name(device);
        Self {
            target: folder.join(&name),
            older: folder.join(format!(".older-{name}")),
        }
    }

    /// The folder of the complete set; `None` if there is none. It is the path `older` if a program was killed before the
    /// new set took its place.
    fn set(&self) -> Option<&Path> {
        let mut locations = [&self.target, &self.older].into_iter();
        locations
            .find(|location| location.is_dir())
            .map(PathBuf::as_path)
    }
}

/// Removes the temporary folders that killed programs have left in `folder`.
fn remove_unfinished(folder: &Path) {
    let entries = folder.read_dir().into_iter().flatten().flatten();
    for entry in entries.filter(|e| e.file_name().to_string_lossy().starts_with(WORK)) {
        let _ = std::fs::remove_dir_all(entry.path());
    }
}

/// The path of the picture of the case `name` in the folder of a set.
fn picture(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.exr"))
}

impl Goldens {
    /// The revision of Headwater that made the golden frames, if it differs from that of this program. Then a difference may
    /// come from a change of Headwater, and not from the driver. `None` if both are equal or the revision is unknown.
    pub fn other_revision(&self) -> Option<&str> {
        let made_by = Some(self.commit.as_str()).filter(|commit| !commit.is_empty())?;
        (made_by != env!("HEADWATER_COMMIT")).then_some(made_by)
    }

    /// Reads the golden frames of a device and its driver. If `folder` has none, reads those of another driver, the first by
    /// name. The returned flag is true if they belong to this driver.
    ///
    /// # Errors
    /// There are no golden frames, or the list of those that were found cannot be read or is damaged.
    pub fn find(folder: &Path, device: &DeviceInfo) -> Result<(Self, bool)> {
        if let Some(own) = Locations::new(folder, device).set() {
            return Ok((Self::read(own)?, true));
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
            .filter(|path| path.join(LIST).exists())
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
        // Names are those of files in the folder.
        let is_outside = |name: &&String| Path::new(name).file_name() != Some(name.as_ref());
        if let Some(name) = goldens.cases.keys().find(is_outside) {
            return Err(damaged(format!("'{name}' cannot be the name of a case")));
        }
        Ok(Self {
            folder: folder.to_owned(),
            ..goldens
        })
    }

    /// The golden frame of a case and its picture; `None` if the set does not have the case, for example because the driver
    /// lacked a feature.
    ///
    /// # Errors
    /// The picture is missing or damaged, or the golden frame was rendered with other arguments.
    pub fn case(&self, case: &Case) -> Result<Option<(&Golden, Image)>> {
        let Some(golden) = self.cases.get(&case.name) else {
            return Ok(None);
        };
        let path = picture(&self.folder, &case.name);
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
