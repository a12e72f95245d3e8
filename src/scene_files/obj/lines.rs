//! Splits OBJ and MTL files into statements. A statement is a keyword, such as `v` or `newmtl`, with the words after it.

use crate::scene::notices::quoted;
use crate::{Error, Result};
use std::io::{BufRead, Read};

/// The maximum length of a statement, in bytes (64 MiB). If backslashes join several lines to one statement, their lengths
/// are added. A longer statement is an error, because it could fill the memory; files for practical use have much shorter
/// ones.
const MAX_BYTES: usize = 64 << 20;

/// A reader that returns the statements of an OBJ or MTL file one after another. All statements use the same memory in turn.
/// A backslash at a line's end joins the line with the next one; `#` begins a comment. A statement whose bytes are not UTF-8
/// is read as Latin-1.
pub struct Lines<R> {
    source: R,
    bytes: Vec<u8>,
    text: String,
    number: usize,
}

/// A statement of an OBJ or MTL file without its comment: a keyword and the text after it. The keyword selects how a reader
/// interprets the text. Lines that a backslash joins are one statement.
pub struct Line<'a> {
    number: usize,
    /// The first word of the statement, such as `v` or `newmtl`. It decides how `rest` is interpreted.
    pub keyword: &'a str,
    /// The text after the keyword, without spaces at its start and end; empty if nothing follows the keyword.
    pub rest: &'a str,
}

impl<R: BufRead> Lines<R> {
    /// Makes a reader that returns the statements of `source`, the content of an OBJ or MTL file, beginning
    /// with the first.
    pub fn new(source: R) -> Self {
        Self {
            source,
            bytes: Vec::new(),
            text: String::new(),
            number: 0,
        }
    }

    /// The next statement; `None` at the end of the file. Empty lines and comments are skipped. Fails if the statement is
    /// longer than [`MAX_BYTES`], or if reading the file fails.
    pub fn next(&mut self) -> Result<Option<Line<'_>>> {
        loop {
            self.bytes.clear();
            let mut number = 0;
            loop {
                let room = (MAX_BYTES + 1 - self.bytes.len()) as u64;
                let mut source = self.source.by_ref().take(room);
                let read = source.read_until(b'\n', &mut self.bytes);
                let count = read.map_err(|cause| {
                    Error::from_io(cause, |cause| {
                        Error::input(format!(
                            "cannot be read after line {}: {cause}",
                            self.number
                        ))
                    })
                })?;
                if self.bytes.len() > MAX_BYTES {
                    return Err(Error::input(format!(
                        "line {}: it has more than {MAX_BYTES} bytes; give an OBJ or MTL file",
                        self.number + 1
                    )));
                }
                if count == 0 && self.bytes.is_empty() {
                    return Ok(None);
                }
                self.number += usize::from(count > 0);
                number = if number == 0 { self.number } else { number };
                let content = self.bytes.trim_ascii_end().len();
                if count == 0 || !self.bytes[..content].ends_with(b"\\") {
                    break;
                }
                self.bytes.truncate(content - 1);
                self.bytes.push(b' ');
            }
            self.text.clear();
            match str::from_utf8(&self.bytes) {
                Ok(text) => self.text.push_str(text),
                // Names that differ must stay different, so that `usemtl` finds the right one.
                Err(_) => self.text.extend(self.bytes.iter().copied().map(char::from)),
            }
            let content = self.text.split('#').next().unwrap_or_default().trim();
            if content.is_empty() {
                continue;
            }
            // Found again in the text itself: the borrow above must not outlive the loop.
            let start = content.as_ptr() as usize - self.text.as_ptr() as usize;
            let end = start + content.len();
            let content = &self.text[start..end];
            let (keyword, rest) = content
                .split_once(char::is_whitespace)
                .unwrap_or((content, ""));
            return Ok(Some(Line {
                number,
                keyword,
                rest: rest.trim_start(),
            }));
        }
    }
}

impl<'a> Line<'a> {
    /// The words of the statement after its keyword, separated by white space, in their order: the arguments
    /// of the statement, such as the numbers of a vertex.
    pub fn words(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.rest.split_whitespace()
    }

    /// The first three words after the keyword as numbers, such as the coordinates of a vertex. Further words are ignored.
    /// Fails if there are fewer than three words, or if one of the three is not a number or is beyond the range of f32. The
    /// numbers are f64, because the reader subtracts the origin of the mesh before it rounds to f32.
    pub fn numbers(&self) -> Result<[f64; 3]> {
        let mut words = self.words();
        let mut numbers = [0.0; 3];
        for number in &mut numbers {
            let word = words
                .next()
                .ok_or_else(|| self.wrong("three numbers are needed"))?;
            *number = self.number(word)?;
        }
        Ok(numbers)
    }

    /// The number that `word`, a word of this statement, states. Fails if `word` is not a number or is beyond the range of
    /// f32; the error names the statement. The number is f64, so that it is rounded to f32 only after computations.
    pub fn number(&self, word: &str) -> Result<f64> {
        word.parse()
            .ok()
            .filter(|number: &f64| number.abs() <= f64::from(f32::MAX))
            .ok_or_else(|| self.wrong(&format!("{} is not a finite number", quoted(word))))
    }

    /// The number of the line on which the statement begins, counted from 1 in the file, as a text for messages: `line 12`.
    pub fn location(&self) -> String {
        format!("line {}", self.number)
    }

    /// An error about this statement. Its text begins with the number of the statement's line and its keyword, and ends with
    /// `fault`: `line 12, "v": fault`.
    pub fn wrong(&self, fault: &str) -> Error {
        Error::input(format!(
            "line {}, {}: {fault}",
            self.number,
            quoted(self.keyword)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_without_comments_and_joined() {
        let text = b"# head\n\n  v 1 2 \\\r\n 3 # x\r\no a  b\nf\n \\\n\xff\n\\";
        let mut lines = Lines::new(&text[..]);
        let mut found = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            let words: Vec<&str> = line.words().collect();
            found.push(format!(
                "{} {} {}",
                line.location(),
                line.keyword,
                words.join(",")
            ));
        }
        assert_eq!(
            found,
            ["line 3 v 1,2,3", "line 5 o a,b", "line 6 f ", "line 7 ÿ "]
        );
    }
}
