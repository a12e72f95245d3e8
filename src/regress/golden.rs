//! Golden frames (the stored results with which the regression tests compare) on disk: a folder for each driver, with a JSON
//! list and one picture per case.

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

/// Version of the format of the file `golden.json`. A file with another version is refused, because its values could mean
/// something else.
const VERSION: u32 = 2;
/// The name of the file that lists the golden frames in the folder of a driver. A folder without this file is not a set of
/// golden frames.
const LIST: &str = "golden.json";

/// A hash of the contents of one buffer after one pass of one frame. On the driver of the golden frames, the test compares
/// the steps of a case with the golden ones; the first step that differs shows in which pass an error begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// The index of the frame in which the pass ran. The first frame of a case has the index 0.
    pub frame: u32,
    /// The name of the pass that ran just before the hash was made.
    pub pass: String,
    /// The name of the hashed buffer, which is one that the pass may write. The message about a difference shows it.
    pub buffer: String,
    /// The first 16 hexadecimal digits of the BLAKE3 hash of all bytes of the buffer `buffer` after the pass. If it differs
    /// from the hash of the golden frame, the pass or an earlier one has computed something else.
    pub hash: String,
}

impl Step {
    /// Makes a step (the hash of one buffer after one pass of one frame) from `output`, which contains the hash and the
    /// names of the pass and of the buffer. `frame` is the index of the frame in which the pass ran.
    pub fn of(frame: u32, output: Output) -> Self {
        Self {
            frame,
            pass: output.pass,
            buffer: output.buffer,
            hash: output.hash,
        }
    }
}

/// The result of rendering a case on the driver under test: its picture, the levels of its pictures with several seeds, and
/// the hashes of its buffers. They are compared with those of the golden frame, which is the stored result of a trusted
/// driver.
pub struct Rendered {
    /// The picture of the case, from a run in which each frame is submitted as a whole, as in normal use. The hashes in
    /// `steps` come from a second run, in which the passes run one by one.
    pub image: Image,
    /// The levels ([`level`](super::verdict::level)) of the case with one seed or with
    /// [`SEEDS`](super::verdict::SEEDS) seeds, from runs like the one of `image`, in the unit of radiance.
    /// The first level belongs to `image`; each further seed is larger by one.
    pub levels: Vec<f64>,
    /// The hashes of the buffers that passes may write: one per pass and buffer, in the order in which the passes ran. They
    /// show which pass first differs from the golden frame.
    pub steps: Vec<Step>,
}

/// The golden frame of one case: the stored result of a trusted driver, with which the results of later runs and of other
/// drivers are compared. The picture itself is in a separate file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Golden {
    /// The arguments of the command `render` with which the golden frame was rendered. If the case has other arguments now,
    /// the golden frame is out of date and is refused.
    pub arguments: String,
    /// The first 16 hexadecimal digits of the BLAKE3 hash of the picture's EXR file. They show whether the file is damaged.
    pub picture: String,
    /// The levels of the case (mean values of its pictures) with several seeds, one per seed, like
    /// [`Rendered::levels`]. The levels of other drivers with the same seeds are compared with them.
    pub levels: Vec<f64>,
    /// The hashes of the buffers that passes may write: one per pass and buffer, in the order in which the passes ran. They
    /// are compared only if every bit must be equal, that is, on the same driver or with `--exact`.
    pub steps: Vec<Step>,
}

/// The set of golden frames that one driver rendered on one device, with which `headwater regress` compares the results of a
/// driver. On disk, it is one folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Goldens {
    version: u32,
    /// Name of the device that rendered the golden frames. It is only shown to the user, and not used to find the set: for
    /// this, the program uses the name of the folder.
    pub device: String,
    /// Name and version of the driver that rendered the golden frames. It is only shown to the user.
    pub driver: String,
    /// The revision of Headwater that wrote the set: the first 12 hexadecimal digits of a git commit, then `+` if files had
    /// been changed. Empty for a build outside a checkout. If `--only` limited a run to some cases, the golden frames of
    /// other cases may come from an older revision.
    pub commit: String,
    /// The golden frames of the set. The keys are the names of their cases. A case that the driver could not
    /// render is missing.
    pub cases: BTreeMap<String, Golden>,
    #[serde(skip)]
    folder: PathBuf,
}

/// The name of the folder for the golden frames of a device and its driver. It consists of the name of the device and the
/// name and version of the driver, with hyphens instead of spaces and other special characters. Drivers put the version of
/// their compiler and the width of vectors into these names, so two drivers that may compute different bits have different
/// folders.
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

/// A new set of golden frames, which the command `regress --bless` builds from the results of this driver, for later
/// comparisons. When it is complete, it replaces the older set of the same driver. Until then it is only in memory, so that
/// no file must be removed if the work ends early.
pub struct Blessing {
    goldens: Goldens,
    /// The pictures of the cases that were rendered for this set, which are written to files at the end. The keys are the
    /// names of the cases. Cases that were taken over from an older set have no entry; their picture files are copied.
    pictures: BTreeMap<String, Image>,
    /// The path of the folder of all golden frames, which contains one folder per driver.
    folder: PathBuf,
    /// The two paths on disk at which the set of this driver can be: the normal one, and the one to which an older set is
    /// moved while the new one takes its place.
    locations: Locations,
}

/// The beginning of the names of temporary folders, in which new sets of golden frames are written. If the program is
/// killed, its folder stays. A later run that writes golden frames recognises such folders by this beginning and removes
/// them.
const WORK: &str = ".golden-";

impl Blessing {
    /// Makes an empty set for the driver of `device`. `folder` is the folder that has one folder per driver; nothing is
    /// written to it before [`Self::finish`].
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

    /// Adds the result of a case that was just rendered. It replaces a golden frame of the same case that is in the set
    /// already.
    pub fn add(&mut self, case: &Case, rendered: Rendered) {
        let golden = Golden {
            arguments: case.arguments.clone(),
            // Known once the picture is written.
            picture: String::new(),
            levels: rendered.levels,
            steps: rendered.steps,
        };
        self.goldens.cases.insert(case.name.clone(), golden);
        self.pictures.insert(case.name.clone(), rendered.image);
    }

    /// Adds the golden frames of the driver's set on disk, if there is one, so that a run with `--only` does not lose the
    /// golden frames of the cases that it does not render. A result that is added later replaces the golden frame of the
    /// same case. If a golden frame is not replaced, [`Self::finish`] copies its picture from the set on disk.
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

    /// Writes the set to disk, where it replaces the older set of the driver, and returns the path of its folder.
    ///
    /// # Errors
    /// A file cannot be written, or a picture of the older set cannot be copied. The older set then stays in place.
    pub fn finish(self) -> Result<PathBuf> {
        let Self {
            mut goldens,
            pictures,
            folder,
            locations,
        } = self;
        std::fs::create_dir_all(&folder).map_err(|e| Error::writing(&folder, e))?;
        // While this program holds the lock, no other one writes sets here: unfinished ones can be removed.
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
        // A folder is replaced in two steps; if the second one fails, the first one is undone.
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

/// The two paths at which the set of golden frames of a driver can be. `target` is the normal one. The second
/// path, `older`, is needed so that a complete set exists at any time, even if the program is killed while it
/// replaces a set.
struct Locations {
    target: PathBuf,
    /// The path to which the older set of golden frames is moved while a new set takes its place at `target`. If the program
    /// is killed in between, the older set is found here.
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

    /// The folder that contains the complete set of the driver; `None` if there is none. Normally, this folder is `target`.
    /// It is `older` if a program was killed after it had moved the older set away and before the new set was in place.
    fn set(&self) -> Option<&Path> {
        let mut locations = [&self.target, &self.older].into_iter();
        locations
            .find(|location| location.is_dir())
            .map(PathBuf::as_path)
    }
}

/// Removes the temporary folders in `folder`, which were left by programs that were killed before their sets were complete.
/// A folder that cannot be removed stays.
fn remove_unfinished(folder: &Path) {
    let entries = folder.read_dir().into_iter().flatten().flatten();
    for entry in entries.filter(|e| e.file_name().to_string_lossy().starts_with(WORK)) {
        let _ = std::fs::remove_dir_all(entry.path());
    }
}

/// The path of the EXR file with the golden picture of the case `name`. `folder` is the folder of a driver's
/// set.
fn picture(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.exr"))
}

impl Goldens {
    /// The revision of Headwater that made the golden frames, if it differs from the revision of this
    /// program. The program then prints a note that a difference between pictures may come from a change of
    /// Headwater instead of the driver. `None` if both revisions are equal, or if the revision of the golden
    /// frames is unknown.
    pub fn other_revision(&self) -> Option<&str> {
        let made_by = Some(self.commit.as_str()).filter(|commit| !commit.is_empty())?;
        (made_by != env!("HEADWATER_COMMIT")).then_some(made_by)
    }

    /// Reads the golden frames that belong to a device and its driver. If `folder` has none, it reads those of another
    /// driver: the folder whose name is first in alphabetical order. The returned flag is true if the golden frames belong
    /// to this device and driver, so that every bit must be equal.
    ///
    /// # Errors
    /// There are no golden frames, or the list of those that were found cannot be read, is damaged or has another version.
    pub fn find(folder: &Path, device: &DeviceInfo) -> Result<(Self, bool)> {
        if let Some(own) = Locations::new(folder, device).set() {
            return Ok((Self::read(own)?, true));
        }
        let entries = std::fs::read_dir(folder).map_err(|e| Error::reading(folder, e))?;
        let mut others: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            // A folder whose name begins with a dot is not a complete set, or an older set.
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
        #[derive(Deserialize)]
        struct Versioned {
            version: u32,
        }
        let broken = |e: serde_json::Error| damaged(format!("it is damaged ({e})"));
        // Another version has other fields.
        let Versioned { version } = serde_json::from_str(&text).map_err(broken)?;
        if version != VERSION {
            return Err(damaged(format!("its version is {version}, not {VERSION}")));
        }
        let goldens: Self = serde_json::from_str(&text).map_err(broken)?;
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

    /// The golden frame of a case and its picture, with which the result of a driver is compared. `None` if the set does not
    /// contain the case, for example because the driver lacked a feature that the case needs.
    ///
    /// # Errors
    /// The picture is missing or damaged, or the golden frame was rendered with other arguments than the case has now.
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
