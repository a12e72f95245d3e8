//! Parses TOML texts that users write (settings and plans of studies), and finds the line of a key in them, so that an
//! error message can show it.

use crate::{Error, Result};
use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

/// A TOML text and the name of its origin, so that an error message can name the file and the line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TomlText {
    /// The path of the file that contains the text, or another name of the text; error messages show it.
    pub origin: String,
    /// The TOML source text. It is parsed when its values are needed, and error messages show lines of it.
    pub text: String,
}

/// One step of a path from the root of a TOML document to a table inside it. Error messages need such paths to find the
/// line of a key.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// The step goes to the value of this key in a table.
    Key(&'a str),
    /// The step goes to the element of an array with this index, counted from 0.
    Index(usize),
}

impl TomlText {
    /// Stores a TOML text without parsing it. `origin` is its name in error messages.
    pub fn new(origin: &str, text: &str) -> Self {
        Self {
            origin: origin.to_owned(),
            text: text.to_owned(),
        }
    }

    /// Parses the text into a value of type `T`, which is a structure or a tree of TOML values.
    ///
    /// # Errors
    /// The text is not TOML or does not fit `T`; the message names the line.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(&self.text).map_err(|e| {
            let start = e.span().map_or(0, |span| span.start);
            self.error_at(start, &e.message().replace('\n', " "))
        })
    }

    /// Adds the origin and the line of a key to the message of an input error. The dotted `key`, such as `direct.mode`, is
    /// relative to the table that `path` leads to. If the text does not contain the key, only the origin is added. Other
    /// errors are returned unchanged.
    pub fn error_for(&self, path: &[Step<'_>], key: &str, error: Error) -> Error {
        match (self.offset_of(path, key), error) {
            (Some(offset), Error::Input(message)) => self.error_at(offset, &message),
            (None, Error::Input(message)) => Error::input(format!("{}: {message}", self.origin)),
            (_, error) => error,
        }
    }

    /// Makes an input error. Its message consists of the name of the text's origin, the number and the text of the line that
    /// contains the byte at `offset`, and `message`, in this order.
    fn error_at(&self, offset: usize, message: &str) -> Error {
        let number = 1 + self.text[..offset].matches('\n').count();
        let line = self.text.lines().nth(number - 1).unwrap_or_default().trim();
        let origin = &self.origin;
        Error::input(format!("{origin}, line {number}, '{line}': {message}"))
    }

    /// The offset in bytes, from the start of the text, of the dotted `key` in the table that `path` leads to; an error
    /// message shows the line at this offset. `None` if the text does not contain the key.
    fn offset_of(&self, path: &[Step<'_>], key: &str) -> Option<usize> {
        let document = DeTable::parse(&self.text).ok()?.into_inner();
        let mut value = &DeValue::Table(document);
        for step in path {
            value = match step {
                Step::Key(name) => value.get(name)?.get_ref(),
                Step::Index(index) => value.get(*index)?.get_ref(),
            };
        }
        offset_in(value.as_table()?, key)
    }
}

/// The offset in bytes, from the start of the text, of the dotted `key` in `table` or in a table inside it; `None` if they
/// do not contain the key. Each name in the table is compared with the beginning of `key`, because a name may itself contain
/// dots.
fn offset_in(table: &DeTable<'_>, key: &str) -> Option<usize> {
    table.iter().find_map(|(name, value)| {
        let rest = key.strip_prefix(name.get_ref().as_ref())?;
        let here = name.span().start;
        match (rest.strip_prefix('.'), value.get_ref().as_table()) {
            (Some(rest), Some(inner)) => offset_in(inner, rest),
            _ => rest.is_empty().then_some(here),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn text_that_is_no_toml_names_its_line() {
        for (text, line) in [
            ("a = 1\na = 2", "line 2, 'a = 2':"),
            ("= 1", "line 1, '= 1':"),
        ] {
            let parsed = TomlText::new("x.toml", text).parse::<Value>();
            let error = parsed.unwrap_err().to_string();
            assert!(error.contains(line), "{error}");
        }
    }
}
