//! Reads an OBJ file in blocks of whole statements, and parses several blocks in parallel. Statements that are written in
//! the usual way ([`super::plain`]) become numbers here; all others stay text, which [`super::lines`] splits later. So the
//! result does not depend on the number of threads.

use super::lines::{MAX_BYTES, too_long, unreadable};
use super::plain::{self, Statements};
use crate::{Error, Result};
use rayon::prelude::*;
use std::io::Read;
use std::ops::Range;

/// The size of a block in bytes, before it is cut at the end of a statement (256 KiB): thousands of lines, so that parsing it
/// takes much longer than starting a task, but so few that the blocks of many threads take little memory.
const BLOCK: u64 = 1 << 18;

/// The number of bytes at the start of the file in which the byte is looked for that ends lines.
const START: usize = 1 << 16;

/// A part of an OBJ file that begins and ends between two statements.
pub struct Block {
    /// The bytes of the block, from which statements that are not plain are read.
    pub text: Vec<u8>,
    /// The lines of the block in their order, without gaps.
    pub runs: Vec<Run>,
    /// The numbers of the plain statements.
    pub statements: Statements,
}

/// Consecutive lines of a block with the same kind of statement.
#[derive(Debug, PartialEq)]
pub enum Run {
    /// This number of plain lines `v`.
    Positions(usize),
    /// This number of plain lines `vn`.
    Normals(usize),
    /// This number of plain lines `vt`.
    Coordinates(usize),
    /// This number of plain lines `f`.
    Faces(usize),
    /// Other lines: their range in [`Block::text`].
    Text(Range<usize>),
}

/// Reads the blocks of an OBJ file one after another.
pub struct Blocks<R> {
    source: R,
    /// The bytes that were read behind the end of the last block.
    rest: Vec<u8>,
    /// The byte that ends a line: a line feed, or in files of old programs a carriage return.
    pub line_end: u8,
    is_started: bool,
    /// The number of lines in the blocks that were read.
    lines: usize,
    /// The error that ended the last call of [`Self::read`] after some blocks.
    failed: Option<Error>,
}

impl<R: Read> Blocks<R> {
    /// Makes a reader of the blocks of `source`, the content of an OBJ file.
    pub fn new(source: R) -> Self {
        Self {
            source,
            rest: Vec::new(),
            line_end: b'\n',
            is_started: false,
            lines: 0,
            failed: None,
        }
    }

    /// Reads the next blocks without parsing them: two for each thread, or fewer at the end of the file. Empty after the
    /// last block. Fails, after the blocks before the fault were returned, if the file cannot be read or a statement is
    /// longer than [`MAX_BYTES`].
    pub fn read(&mut self) -> Result<Vec<Vec<u8>>> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let mut blocks = Vec::new();
        while blocks.len() < 2 * rayon::current_num_threads() {
            match self.next() {
                Ok(Some(block)) => blocks.push(block),
                Ok(None) => break,
                Err(error) if blocks.is_empty() => return Err(error),
                Err(error) => {
                    self.failed = Some(error);
                    break;
                }
            }
        }
        Ok(blocks)
    }

    fn next(&mut self) -> Result<Option<Vec<u8>>> {
        let mut text = std::mem::take(&mut self.rest);
        loop {
            let searched = text.len();
            let read = self.source.by_ref().take(BLOCK).read_to_end(&mut text);
            if read.map_err(|cause| unreadable(cause, self.lines))? == 0 {
                return Ok((!text.is_empty()).then_some(text));
            }
            if !std::mem::replace(&mut self.is_started, true) {
                let start = &text[..text.len().min(START)];
                if start.contains(&b'\r') && !start.contains(&b'\n') {
                    self.line_end = b'\r';
                }
            }
            if let Some(end) = last_end(&text, searched, self.line_end) {
                self.rest = text.split_off(end);
                let ends = text.iter().filter(|byte| **byte == self.line_end);
                self.lines += ends.count();
                return Ok(Some(text));
            }
            if text.len() > MAX_BYTES {
                return Err(too_long(self.lines + 1));
            }
        }
    }
}

/// The index behind the last statement in `text` that surely ends there: with a line end at or behind the index `from`,
/// before which no backslash continues the statement. `None` if there is none.
fn last_end(text: &[u8], from: usize, line_end: u8) -> Option<usize> {
    let mut behind = text.len();
    loop {
        let lines = text.get(from..behind)?;
        let end = from + lines.iter().rposition(|byte| *byte == line_end)?;
        let content = text[..end].trim_ascii_end();
        if !content.ends_with(b"\\") {
            return Some(end + 1);
        }
        behind = content.len();
    }
}

/// Parses the plain statements of blocks, several blocks at a time in parallel. `is_first` is true if the first of them
/// begins the file, and `line_end` is the byte that ends a line.
pub fn parse(blocks: Vec<Vec<u8>>, is_first: bool, line_end: u8) -> Vec<Block> {
    let blocks = blocks.into_par_iter().enumerate();
    blocks
        .map(|(index, text)| Block::parse(text, is_first && index == 0, line_end))
        .collect()
}

impl Block {
    fn parse(text: Vec<u8>, is_first: bool, line_end: u8) -> Self {
        let mut runs = Vec::new();
        let mut statements = Statements::default();
        match str::from_utf8(&text) {
            Ok(lines) if line_end == b'\n' => {
                let mut begin = 0;
                // The first line may have a byte order mark, and the line behind a backslash belongs to the same statement.
                let mut is_text = is_first;
                for line in lines.split_inclusive('\n') {
                    let end = begin + line.len();
                    let kind = if is_text { None } else { statements.read(line) };
                    let content = line.trim_ascii_end();
                    is_text = match content {
                        "" => is_text,
                        _ => kind.is_none() && content.ends_with('\\'),
                    };
                    add(&mut runs, kind, begin..end);
                    begin = end;
                }
            }
            _ => runs.push(Run::Text(0..text.len())),
        }
        Self {
            text,
            runs,
            statements,
        }
    }
}

/// Adds a line to the last run, or as a new run if its kind is another one. `kind` is `None` for a line that is not plain;
/// `range` is its range in the block.
fn add(runs: &mut Vec<Run>, kind: Option<plain::Kind>, range: Range<usize>) {
    use plain::Kind;
    match (runs.last_mut(), kind) {
        (Some(Run::Positions(count)), Some(Kind::Position))
        | (Some(Run::Normals(count)), Some(Kind::Normal))
        | (Some(Run::Coordinates(count)), Some(Kind::Coordinates))
        | (Some(Run::Faces(count)), Some(Kind::Face)) => *count += 1,
        (Some(Run::Text(text)), None) => text.end = range.end,
        (_, kind) => runs.push(match kind {
            Some(Kind::Position) => Run::Positions(1),
            Some(Kind::Normal) => Run::Normals(1),
            Some(Kind::Coordinates) => Run::Coordinates(1),
            Some(Kind::Face) => Run::Faces(1),
            None => Run::Text(range),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_that_go_on_are_not_cut() {
        let text = b"# head\nv 1 2 3\nv 4 5 \\\nv 6\n# \\\nv 7 8 9\nvn 0 0 1\nf 1 2 3\nf -1//2 2/1 3\n\nf 1 2";
        let block = Block::parse(text.to_vec(), true, b'\n');
        let expected = [
            Run::Text(0..7),
            Run::Positions(1),
            Run::Text(15..39),
            Run::Normals(1),
            Run::Faces(2),
            Run::Text(70..71),
            Run::Faces(1),
        ];
        assert_eq!(block.runs, expected);
        assert_eq!(block.statements.faces, [3, 3, 2]);
        assert_eq!(block.statements.corners[3], [-1, 0, 2]);
    }

    #[test]
    fn blocks_are_all_of_the_file_and_end_behind_statements() {
        // Lines with a backslash, and blank lines behind one, end no block.
        let text = "v 1 2 3 \\\n \nv 5 6 7\n".repeat(200_000);
        let mut blocks = Blocks::new(text.as_bytes());
        let mut whole = Vec::new();
        let mut count = 0;
        while let Some(block) = blocks.next().unwrap() {
            assert!(block.len() < 2 * BLOCK as usize);
            assert!(block.ends_with(b"7\n"));
            whole.extend(block);
            count += 1;
        }
        assert!(count > 3);
        assert_eq!(whole, text.as_bytes());
    }
}
