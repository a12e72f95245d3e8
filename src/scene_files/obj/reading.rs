//! Reads all statements of an OBJ file, block by block. Blocks are parsed in parallel; what they state is added to the scene
//! in the order of the file, by one thread.

use super::blocks::{self, Block, Blocks, Run};
use super::faces::{CORNER_BYTES, Index};
use super::lines::{Line, Lines};
use super::{Reader, check_memory};
use crate::scene_files::progress::{Progress, Watched};
use crate::{Error, Result};
use std::fs::File;
use std::io::{Read, Seek};

/// The statements found so far, from which it is decided whether the file is an OBJ file.
#[derive(Default)]
struct Found {
    /// True if some statement belongs to OBJ.
    known: bool,
    /// The error for the first statement that does not.
    unknown: Option<Error>,
}

/// Appends the first `count` elements of `from` to `to`, and removes them from `from`.
fn append<T: Copy>(to: &mut Vec<T>, from: &mut &[T], count: usize) {
    let (first, rest) = from.split_at(count);
    to.extend_from_slice(first);
    *from = rest;
}

impl Reader<'_> {
    /// Reads all statements of the OBJ file. Fails if a statement is wrong, or if none belongs to OBJ although there are
    /// others.
    pub(super) fn read(
        &mut self,
        mut file: &File,
        length: u64,
        progress: &mut Progress<'_>,
    ) -> Result<()> {
        let unreadable = |cause| Error::input(format!("cannot be read: {cause}"));
        file.rewind().map_err(unreadable)?;
        let file = file.try_clone().map_err(unreadable)?;
        let mut blocks = Blocks::new(Watched::new(file, progress).take(length));
        let mut found = Found::default();
        let mut number = 0;
        let mut parsed = Vec::new();
        loop {
            // The next blocks are parsed while those before them become meshes. So an error of theirs waits too.
            let (next, failed) = match blocks.read() {
                Ok(next) => (next, None),
                Err(error) => (Vec::new(), Some(error)),
            };
            let (is_first, line_end) = (number == 0 && parsed.is_empty(), blocks.line_end);
            let ready: Vec<Block> = std::mem::take(&mut parsed);
            let (is_last, parsed) = (next.is_empty(), &mut parsed);
            rayon::in_place_scope(|scope| {
                scope.spawn(move |_| *parsed = blocks::parse(next, is_first, line_end));
                (ready.into_iter())
                    .try_for_each(|block| self.block(&block, line_end, &mut number, &mut found))
            })?;
            if let Some(error) = failed {
                return Err(error);
            }
            if is_last {
                break;
            }
        }
        match found.unknown {
            Some(error) if !found.known => Err(error),
            _ => Ok(()),
        }
    }

    /// Processes the statements of a block in the order of the file. `line_end` is the byte that ends a line; `number`, the
    /// number of lines read so far, is increased. Fails as [`Self::statement`] does.
    fn block(
        &mut self,
        block: &Block,
        line_end: u8,
        number: &mut usize,
        found: &mut Found,
    ) -> Result<()> {
        let statements = &block.statements;
        let mut positions = statements.positions.as_slice();
        let mut normals = statements.normals.as_slice();
        let mut coordinates = statements.coordinates.as_slice();
        let (mut faces, mut corners) = (statements.faces.iter(), statements.corners.as_slice());
        for run in &block.runs {
            match run {
                Run::Positions(count) => append(&mut self.positions, &mut positions, *count),
                Run::Normals(count) => append(&mut self.attributes.normals, &mut normals, *count),
                Run::Coordinates(count) => {
                    append(&mut self.attributes.coordinates, &mut coordinates, *count);
                }
                Run::Faces(count) => {
                    for (face, count) in faces.by_ref().take(*count).enumerate() {
                        let (indices, rest) = corners.split_at(*count);
                        corners = rest;
                        let line = Line::face(*number + face + 1);
                        check_memory(&line, indices.len() as u64 * CORNER_BYTES)?;
                        self.face(&line, indices.iter().map(|c| c.map(Index::stated)))?;
                    }
                }
                Run::Text(range) => {
                    let text = &block.text[range.clone()];
                    let mut lines = Lines::continuing(text, *number, line_end);
                    while let Some(line) = lines.next()? {
                        if self.statement(&line)? {
                            found.known = true;
                            continue;
                        }
                        if found.unknown.is_none() {
                            let what = "is not a statement of OBJ; give an OBJ file";
                            found.unknown = Some(line.wrong(what));
                        }
                        self.ignored.unknown_keyword(&line, || line.location());
                    }
                    *number = lines.number();
                }
            }
            if let Run::Positions(count)
            | Run::Normals(count)
            | Run::Coordinates(count)
            | Run::Faces(count) = run
            {
                found.known = true;
                *number += count;
            }
        }
        Ok(())
    }
}
