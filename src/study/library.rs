//! The references of a study: finds the files of their blocks of samples, and combines the blocks of each
//! reference.

use super::identity::Identity;
use super::plan::Resolved;
use super::reference::{MEASURING_BLOCKS, Reference, References, SampleBlocks};
use super::subject::path_tracing;
use crate::Result;
use std::collections::HashMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// The path of the file of one block of a reference, and the range of the indices of its samples.
pub type BlockFile = (PathBuf, Range<u32>);

/// The references in the folder of a study. A reference that was read stays in memory; when files of further
/// blocks appear, only these are read and added.
pub struct Library {
    folder: PathBuf,
    /// The references that were read, by key; for each, the indices of the blocks that it contains, in
    /// ascending order.
    read: HashMap<String, (Vec<u32>, Arc<Reference>)>,
}

impl Library {
    /// Makes a library of the references in `folder`. It reads no file yet.
    pub fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            read: HashMap::new(),
        }
    }

    /// Lists the files of those blocks of the reference with the key `key` that have the indices `wanted`:
    /// the path of each, and the indices of its samples. The files need not exist.
    pub fn files(
        &self,
        key: &str,
        blocks: SampleBlocks,
        wanted: impl IntoIterator<Item = u32>,
    ) -> Vec<BlockFile> {
        (wanted.into_iter())
            .map(|block| {
                let path = self.folder.join(format!("{key}-{block:04}.exr"));
                (path, blocks.samples_of(block))
            })
            .collect()
    }

    /// The references with which the frames of a configuration are compared. The reference of the last frame
    /// uses all of its first `most` blocks that have files; the others use only the [`MEASURING_BLOCKS`].
    /// `None` if one of these first blocks has no file.
    ///
    /// # Errors
    /// A file cannot be read, or is not a block of this reference.
    pub fn references(
        &mut self,
        identity: &Identity,
        configuration: &Resolved,
        blocks: SampleBlocks,
        most: u32,
    ) -> Result<Option<References>> {
        let settings = path_tracing(&configuration.settings);
        let times = identity.times(configuration);
        let mut references = Vec::new();
        for (index, time) in times.iter().enumerate() {
            let key = identity.reference_key(&settings, *time, blocks)?;
            let is_last = index + 1 == times.len();
            let most = if is_last { most } else { MEASURING_BLOCKS };
            let Some(reference) = self.reference(&key, identity.size, blocks, most)? else {
                return Ok(None);
            };
            references.push(reference);
        }
        Ok(Some(References::new(references)))
    }

    fn reference(
        &mut self,
        key: &str,
        size: (u32, u32),
        blocks: SampleBlocks,
        most: u32,
    ) -> Result<Option<Arc<Reference>>> {
        let files: Vec<(u32, BlockFile)> = (0..)
            .zip(self.files(key, blocks, 0..most))
            .filter(|(_, (path, _))| path.exists())
            .collect();
        let found: Vec<u32> = files.iter().map(|(block, _)| *block).collect();
        if !found.starts_with(&[0, 1]) {
            return Ok(None);
        }
        // Blocks are added in ascending order, so that the sums have the same bits for everyone: if one appears between
        // others, all are read again.
        let is_grown = |(read, _): &(Vec<u32>, Arc<Reference>)| found.starts_with(read);
        if !self.read.get(key).is_some_and(is_grown) {
            let measuring = files[..MEASURING_BLOCKS as usize].iter();
            let measuring: Vec<BlockFile> = measuring.map(|(_, file)| file.clone()).collect();
            let reference = Reference::read(size, &measuring)?;
            let entry = ((0..MEASURING_BLOCKS).collect(), Arc::new(reference));
            self.read.insert(key.to_owned(), entry);
        }
        let Some(entry) = self.read.get_mut(key) else {
            return Ok(None);
        };
        for (block, (path, samples)) in &files[entry.0.len()..] {
            Arc::make_mut(&mut entry.1).add(path, samples.len() as u32)?;
            entry.0.push(*block);
        }
        Ok(Some(entry.1.clone()))
    }
}
