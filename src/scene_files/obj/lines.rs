//! Splits OBJ and MTL files into statements. A statement is a keyword, such as `v` or `newmtl`, with the words after it.

use crate::scene::notices::quoted;
use crate::{Error, Result};
use std::io::{self, BufRead, Read};

/// The maximum length of a statement, in bytes (64 MiB). If backslashes join several lines to one statement, their lengths
/// are added. A longer statement is an error, because it could fill the memory; files for practical use have much shorter
/// ones.
pub(super) const MAX_BYTES: usize = 64 << 20;

/// The keywords, in lower case, of statements that end with a name, beside those that begin with `map_`.
const NAMING: [&str; 11] = [
    "o", "g", "usemtl", "newmtl", "mtllib", "usemap", "norm", "bump", "disp", "decal", "refl",
];

/// A reader that returns the statements of an OBJ or MTL file one after another. All statements use the same memory in turn.
/// A backslash at a line's end joins the line with the next one, except in a comment. `#` begins a comment
/// ([`without_comment`]). A statement whose bytes are not UTF-8
/// is read as Latin-1. A UTF-8 byte order mark at the start of the file is skipped.
pub struct Lines<R> {
    source: R,
    bytes: Vec<u8>,
    text: String,
    /// The keyword of the current statement in lower case. It is used only if the file writes the keyword otherwise.
    lower_case: String,
    /// The number of lines before the next statement.
    number: usize,
    /// The byte that ends a line: a line feed, or in files of old programs a carriage return.
    line_end: u8,
}

/// A statement of an OBJ or MTL file without its comment: a keyword and the text after it. The keyword selects how a reader
/// interprets the text. Lines that a backslash joins are one statement.
pub struct Line<'a> {
    number: usize,
    /// The first word of the statement in lower case, such as `v` or `map_kd`. It decides how `rest` is interpreted. Letter
    /// case has no meaning, because some programs write `NEWMTL` or `map_kd`.
    pub keyword: &'a str,
    /// The first word of the statement as the file writes it, such as `map_Kd`, for messages.
    pub written: &'a str,
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
            lower_case: String::new(),
            number: 0,
            line_end: b'\n',
        }
    }

    /// Makes a reader for `source`, a part of a file that begins behind the line with the number `number`. `line_end` is the
    /// byte that ends a line in this file.
    pub fn continuing(source: R, number: usize, line_end: u8) -> Self {
        Self {
            number,
            line_end,
            ..Self::new(source)
        }
    }

    /// The number of lines read so far, counted from the start of the file.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The next statement; `None` at the end of the file. Empty lines and comments are skipped. Fails if the statement is
    /// longer than [`MAX_BYTES`], if the file is UTF-16, or if reading the file fails.
    pub fn next(&mut self) -> Result<Option<Line<'_>>> {
        if self.number == 0 {
            let start = self.source.fill_buf();
            let start = start.map_err(|cause| unreadable(cause, self.number))?;
            if start.contains(&b'\r') && !start.contains(&b'\n') {
                self.line_end = b'\r';
            }
        }
        loop {
            self.bytes.clear();
            let mut number = 0;
            loop {
                let room = (MAX_BYTES + 1 - self.bytes.len()) as u64;
                let mut source = self.source.by_ref().take(room);
                let read = source.read_until(self.line_end, &mut self.bytes);
                let count = read.map_err(|cause| unreadable(cause, self.number))?;
                if self.bytes.len() > MAX_BYTES {
                    return Err(too_long(self.number + 1));
                }
                if count == 0 && self.bytes.is_empty() {
                    return Ok(None);
                }
                if self.number == 0 {
                    skip_byte_order_mark(&mut self.bytes)?;
                }
                self.number += usize::from(count > 0);
                number = if number == 0 { self.number } else { number };
                let content = self.bytes.trim_ascii_end().len();
                let is_comment = self.bytes.trim_ascii_start().starts_with(b"#");
                if count == 0 || is_comment || !self.bytes[..content].ends_with(b"\\") {
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
            let content = without_comment(&self.text).trim();
            if content.is_empty() {
                continue;
            }
            // Found again in the text itself: the borrow above must not outlive the loop.
            let start = content.as_ptr() as usize - self.text.as_ptr() as usize;
            let end = start + content.len();
            let content = &self.text[start..end];
            let (written, rest) = content
                .split_once(char::is_whitespace)
                .unwrap_or((content, ""));
            let keyword = match written.bytes().any(|byte| byte.is_ascii_uppercase()) {
                true => {
                    self.lower_case.clear();
                    self.lower_case.push_str(written);
                    self.lower_case.make_ascii_lowercase();
                    &self.lower_case
                }
                false => written,
            };
            return Ok(Some(Line {
                number,
                keyword,
                written,
                rest: rest.trim_start(),
            }));
        }
    }
}

/// The part of a statement before its comment. In a statement that ends with a name, such as `usemtl Material #25`, `#` begins
/// a comment only at the end or between blanks, because names may contain it.
fn without_comment(text: &str) -> &str {
    let Some(first) = text.find('#') else {
        return text;
    };
    let keyword = text.split_whitespace().next().unwrap_or_default();
    let keyword = keyword.to_ascii_lowercase();
    if !NAMING.contains(&&*keyword) && !keyword.starts_with("map_") {
        return &text[..first];
    }
    let is_blank = |letter: Option<char>| letter.is_none_or(char::is_whitespace);
    let begins_comment = |(at, _): &(usize, &str)| {
        let (before, after) = (&text[..*at], &text[at + 1..]);
        is_blank(before.chars().next_back()) && is_blank(after.chars().next())
    };
    let comment = text.match_indices('#').find(begins_comment);
    &text[..comment.map_or(text.len(), |(at, _)| at)]
}

/// The error that a file cannot be read behind the line with this number, because of `cause`.
pub(super) fn unreadable(cause: io::Error, number: usize) -> Error {
    Error::from_io(cause, |cause| {
        Error::input(format!("cannot be read after line {number}: {cause}"))
    })
}

/// The error that the statement which begins on the line with this number is longer than [`MAX_BYTES`].
pub(super) fn too_long(number: usize) -> Error {
    Error::input(format!(
        "line {number}: it has more than {MAX_BYTES} bytes; give an OBJ or MTL file"
    ))
}

/// Removes a UTF-8 byte order mark at the start of `bytes`, the first line of a file. Fails if the line shows that the file
/// is UTF-16: by a byte order mark of UTF-16, or by a zero byte beside the first letter.
fn skip_byte_order_mark(bytes: &mut Vec<u8>) -> Result<()> {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    match bytes[..] {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [1..=255, 0, ..] | [0, 1..=255, 0, ..] => Err(
            Error::input("line 1: the text is UTF-16; save the file as UTF-8"),
        ),
        _ => Ok(()),
    }
}

impl<'a> Line<'a> {
    /// The face statement `f` on the line with this number, whose corners were parsed before.
    pub fn face(number: usize) -> Self {
        Self {
            number,
            keyword: "f",
            written: "f",
            rest: "",
        }
    }

    /// An `mtllib` statement that was read before; `number` and `rest` are those of the statement.
    pub fn material_library(number: usize, rest: &'a str) -> Self {
        Self {
            number,
            keyword: "mtllib",
            written: "mtllib",
            rest,
        }
    }

    /// The number of the line on which the statement begins, counted from 1 in the file.
    pub fn number(&self) -> usize {
        self.number
    }

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
            *number = self.parse(word)?;
        }
        Ok(numbers)
    }

    /// The number that `word`, a word of this statement, states. Fails if `word` is not a number or is beyond the range of
    /// f32; the error names the statement. The number is f64, so that it is rounded to f32 only after computations.
    pub fn parse(&self, word: &str) -> Result<f64> {
        word.parse()
            .ok()
            .filter(|number: &f64| number.abs() <= f64::from(f32::MAX))
            .ok_or_else(|| self.wrong(&format!("{} is not a finite number", quoted(word))))
    }

    /// The number of the line on which the statement begins, counted from 1 in the file, as a text for messages: `line 12`.
    pub fn location(&self) -> String {
        format!("line {}", self.number)
    }

    /// The line of this statement of the MTL file `library`, as a text for messages: `line 12 of "a.mtl"`.
    pub fn location_in(&self, library: &str) -> String {
        format!("{} of {}", self.location(), quoted(library))
    }

    /// An error about this statement. Its text begins with the number of the statement's line and its keyword, and ends with
    /// `fault`: `line 12, "v": fault`.
    pub fn wrong(&self, fault: &str) -> Error {
        Error::input(format!(
            "line {}, {}: {fault}",
            self.number,
            quoted(self.written)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_not_parts_of_names() {
        for (line, statement) in [
            ("v 1 2 3#x", "v 1 2 3"),
            ("f 1 2 3 # x", "f 1 2 3 "),
            ("#usemtl a", ""),
            ("# usemtl a", ""),
            ("usemtl Material #25", "usemtl Material #25"),
            ("USEMTL a#b # c", "USEMTL a#b "),
            ("newmtl a #", "newmtl a "),
            ("map_Kd -s 1 1 a #1.png", "map_Kd -s 1 1 a #1.png"),
            ("Kd 1 0 0 #25", "Kd 1 0 0 "),
        ] {
            assert_eq!(without_comment(line), statement);
        }
    }

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
