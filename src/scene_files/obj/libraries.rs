//! Reads the MTL files that an OBJ file names, and adds their materials to the scene.

use super::lines::Line;
use super::mtl;
use super::{Reader, check_memory};
use crate::base::memory;
use crate::scene::notices::quoted;
use crate::scene_files::scene_folder::SceneFile;
use crate::{Error, Result};
use std::collections::HashMap;
use std::io::{BufReader, Read};
use std::path::Path;

/// The maximum size of an MTL file, in bytes (64 MiB). A larger file is an error and is not read, because its materials
/// would take too much memory.
const MAX_MTL_BYTES: u64 = 64 << 20;

/// The memory that the materials of an MTL file are assumed to take, in bytes per byte of the file. Before the file is read,
/// the reader checks that this much is free; if it is not, loading ends with an error. A material takes about 430 bytes of
/// memory, and its first line at least 7 bytes of the file: about 61 bytes per byte. This number is about twice as large,
/// because a growing list may reserve twice the memory of its elements.
const MTL_RATIO: u64 = 128;

/// The memory, in bytes, that the reader takes to remember the name of an MTL file, not counting the bytes of the name
/// itself. The reader checks for each name after `mtllib` that this much and the name's own bytes are free. If they are not,
/// loading ends with an error.
pub(super) const NAME_BYTES: u64 = 128;

impl Reader<'_> {
    /// Reads the MTL files that an `mtllib` statement names, and adds their materials to the scene. A file
    /// that does not exist is left out, with a notice to the user.
    ///
    /// # Errors
    /// An MTL file cannot be opened, is damaged or too large, or is outside of the scene's folder without the
    /// user's permission; or there is not enough memory.
    pub(super) fn material_library(&mut self, line: &Line) -> Result<()> {
        if !self.library_names.contains(line.rest) {
            self.library_lines
                .push((line.number(), line.rest.to_owned()));
        }
        // A name may contain spaces, and there may be several names.
        if self.library(line, line.rest)? {
            return Ok(());
        }
        let is_one = line.words().nth(1).is_none();
        for name in line.words() {
            if is_one || !self.library(line, name)? {
                self.ignored
                    .tally
                    .add("MTL files that cannot be read are left out", || {
                        let hint = self.folder.hint(Path::new(name));
                        format!("{}: {}{hint}", line.location(), quoted(name))
                    });
            }
        }
        Ok(())
    }

    /// Reads the materials of the MTL file with the path `name`, unless this path was looked up before. Returns false only at
    /// the first look-up of a file that does not exist, so that it is reported once. `line` is the `mtllib` statement, for
    /// messages.
    fn library(&mut self, line: &Line, name: &str) -> Result<bool> {
        check_memory(line, 2 * (name.len() as u64 + NAME_BYTES))?;
        if !self.library_names.insert(name.to_owned()) {
            return Ok(true);
        }
        match self.open_library(line, name)? {
            Some(file) => self.read_library(name, file).map(|()| true),
            None => Ok(false),
        }
    }

    fn open_library(&mut self, line: &Line, name: &str) -> Result<Option<SceneFile>> {
        let mut open = |name: &str| {
            let what = format!("mtllib in {}", line.location());
            self.folder
                .open_dispensable(&what, &[name.into()], &mut self.ignored.tally)
        };
        let found = open(name)?;
        // One after the other: what is inside with backslashes may be outside with slashes.
        match name.replace('\\', "/") {
            other if found.is_none() && other != name => open(&other),
            _ => Ok(found),
        }
    }

    /// Reads an MTL file and adds its materials to the scene. Does nothing if the same file was already read
    /// under another path. `name` is the file's path in the OBJ file, for messages. Fails if the file has
    /// more than [`MAX_MTL_BYTES`] bytes or a wrong statement, or if there is not enough memory.
    fn read_library(&mut self, name: &str, file: SceneFile) -> Result<()> {
        if !self.libraries.insert(file.id) {
            return Ok(());
        }
        if file.length > MAX_MTL_BYTES {
            return Err(Error::input(format!(
                "{} has {} bytes, an MTL file at most {MAX_MTL_BYTES}; remove materials that nothing uses",
                quoted(name),
                file.length
            )));
        }
        memory::check(file.length * MTL_RATIO).map_err(|cause| {
            Error::input(format!(
                "{}: {cause}; remove materials that nothing uses",
                quoted(name)
            ))
        })?;
        let folder = file.name.parent().unwrap_or(Path::new(""));
        let source = BufReader::new(file.file.take(file.length));
        let first = self.scene.materials.len();
        mtl::read(
            source,
            name,
            folder,
            &mut self.scene.materials,
            &mut self.maps,
            &mut self.ignored,
        )
        .map_err(|fault| Error::input(format!("{}, {fault}", quoted(name))))?;
        for (index, material) in self.scene.materials.iter().enumerate().skip(first) {
            self.materials.add(&material.name, index as u32);
        }
        Ok(())
    }
}

/// The materials of all MTL files by name. A name that no MTL file has is looked up without regard to letter case.
#[derive(Default)]
pub(super) struct MaterialNames {
    /// The index of each material in the scene.
    exact: HashMap<String, u32>,
    /// The index for each name in lower case; `None` if several names differ only in letter case.
    lower_case: HashMap<String, Option<u32>>,
}

/// The result of looking up the name of a material.
pub(super) enum Named {
    /// The index of the material with this name.
    Exact(u32),
    /// The index of the only material whose name differs from this one in letter case only.
    OtherCase(u32),
    Unknown,
}

impl MaterialNames {
    fn add(&mut self, name: &str, index: u32) {
        let is_new = self.exact.insert(name.to_owned(), index).is_none();
        let of_lower_case = self.lower_case.entry(name.to_lowercase());
        let of_lower_case = of_lower_case.or_insert(Some(index));
        *of_lower_case = match is_new && *of_lower_case != Some(index) {
            true => None,
            false => of_lower_case.map(|_| index),
        };
    }

    /// Looks up the material that a `usemtl` statement names.
    pub(super) fn find(&self, name: &str) -> Named {
        if let Some(index) = self.exact.get(name) {
            return Named::Exact(*index);
        }
        match self.lower_case.get(&name.to_lowercase()) {
            Some(Some(index)) => Named::OtherCase(*index),
            _ => Named::Unknown,
        }
    }
}
