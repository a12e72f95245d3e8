//! Collects the notices about statements of OBJ and MTL files that the reader ignores or changes. The number of notices is
//! limited, so that a file which is no OBJ or MTL file does not print thousands of lines.

use super::lines::Line;
use crate::scene::notices::{Tally, listed, quoted};

/// The maximum number of unknown keywords with a notice each, and of unsupported kinds of textures, such as `refl`, in the
/// notice that lists them. Further ones are summarised.
const MAX_KINDS: usize = 16;

/// The notices about an OBJ file and its MTL files.
#[derive(Default)]
pub struct Ignored {
    /// The notices so far.
    pub tally: Tally,
    /// The unknown keywords that have a notice: at most [`MAX_KINDS`].
    unknown: Vec<String>,
    /// The keywords of unsupported textures, each once, for one notice at the end. The list may have one keyword more than
    /// [`MAX_KINDS`], which tells the notice to end with "and others".
    textures: Vec<String>,
}

impl Ignored {
    /// Adds a notice that the keyword of `line` is unknown; there is one notice for each keyword. `location` returns the
    /// place of the statement.
    pub fn unknown_keyword(&mut self, line: &Line, location: impl FnOnce() -> String) {
        let keyword = quoted(line.written);
        if !self.unknown.contains(&keyword) {
            if self.unknown.len() == MAX_KINDS {
                let what = "further unknown keywords are ignored";
                return self
                    .tally
                    .add(what, || format!("{keyword} in {}", location()));
            }
            self.unknown.push(keyword.clone());
        }
        let what = format!("the unknown keyword {keyword} is ignored");
        self.tally.add(&what, location);
    }

    /// Adds the keyword of `line`, which states a texture, to the notice that lists unsupported textures.
    pub fn unsupported_texture(&mut self, line: &Line) {
        if self.textures.len() <= MAX_KINDS {
            let start: String = line.written.chars().take(40).collect();
            let shown = start.escape_debug().to_string();
            if !self.textures.contains(&shown) {
                self.textures.push(shown);
            }
        }
    }

    /// All notices, the list of unsupported textures last.
    pub fn into_tally(mut self) -> Tally {
        if !self.textures.is_empty() {
            let what = "textures that are not supported are ignored";
            self.tally.add(what, || listed(&self.textures, MAX_KINDS));
        }
        self.tally
    }
}
