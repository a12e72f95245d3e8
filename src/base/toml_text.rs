//! TOML as users write it: read into structures, and searched for the line that a message is about.

use crate::{Error, Result};
use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

/// A TOML text and where it comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TomlText {
    /// The file of the text, or its other name in messages.
    pub origin: String,
    /// The text.
    pub text: String,
}

/// A step into a TOML document.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// The value of a key.
    Key(&'a str),
    /// An element of a list.
    Index(usize),
}

impl TomlText {
    /// A text with its name in messages.
    pub fn new(origin: &str, text: &str) -> Self {
        Self {
            origin: origin.to_owned(),
            text: text.to_owned(),
        }
    }

    /// The contents of the text: a tree of values, or a structure.
    ///
    /// # Errors
    /// The text is not TOML or not of that structure; the message names the line.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(&self.text).map_err(|e| {
            let start = e.span().map_or(0, |span| span.start);
            self.error_at(start, &e.message().replace('\n', " "))
        })
    }

    /// The given error, preceded by the line that holds the dotted `key` at `path`.
    pub fn error_for(&self, path: &[Step<'_>], key: &str, error: Error) -> Error {
        match (self.offset_of(path, key), error) {
            (Some(offset), Error::Input(message)) => self.error_at(offset, &message),
            (None, Error::Input(message)) => Error::input(format!("{}: {message}", self.origin)),
            (_, error) => error,
        }
    }

    /// A message about the byte at `offset`.
    fn error_at(&self, offset: usize, message: &str) -> Error {
        let number = 1 + self.text[..offset].matches('\n').count();
        let line = self.text.lines().nth(number - 1).unwrap_or_default().trim();
        let origin = &self.origin;
        Error::input(format!("{origin}, line {number}, '{line}': {message}"))
    }

    /// The byte offset of the dotted `key` in the table at `path`.
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

/// The byte offset of the dotted `key` in a table, whose keys may be dotted too.
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
