//! Collects notices for the user about assumptions and omissions. Notices with the same text become one line, which states
//! how often the notice occurred, so that a faulty file does not print thousands of lines. This module also prepares names
//! and other texts from files for messages.

/// Notices for the user, such as about repairs of a mesh, counted by their text, so that each text is printed only once. For
/// each text it stores the element that was named at the first occurrence, and the number of occurrences.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    kinds: Vec<Kind>,
}

#[derive(Debug)]
struct Kind {
    what: String,
    first: String,
    count: usize,
}

impl Tally {
    /// Counts one occurrence of the notice with the text `what`. `location` returns the name of the element that the notice
    /// is about, such as a mesh; it is called only at the first occurrence.
    pub fn add(&mut self, what: &str, location: impl FnOnce() -> String) {
        self.add_many(what, 1, location);
    }

    /// Counts `count` occurrences, possibly 0, of the notice with the text `what` at one element, such as a mesh. `location`
    /// returns the name of the element; it is called only at the first occurrence of this text.
    pub fn add_many(&mut self, what: &str, count: usize, location: impl FnOnce() -> String) {
        if count == 0 {
            return;
        }
        match self.kinds.iter_mut().find(|kind| kind.what == what) {
            Some(kind) => kind.count += count,
            None => self.kinds.push(Kind {
                what: what.into(),
                first: location(),
                count,
            }),
        }
    }

    /// Adds all notices of `other`, as if they had been added here one after another.
    pub fn append(&mut self, other: Self) {
        for Kind { what, first, count } in other.kinds {
            self.add_many(&what, count, || first);
        }
    }

    /// One line per text of a notice, in the order of their first occurrence. The line contains the text, the name of the
    /// element at the first occurrence and, if there were several occurrences, their number.
    pub fn into_lines(self) -> impl Iterator<Item = String> {
        self.kinds.into_iter().map(|kind| match kind.count {
            1 => format!("{}: {}", kind.what, kind.first),
            n => format!("{}: {n} times, first {}", kind.what, kind.first),
        })
    }
}

/// The name of an element in messages: its kind, its index in the scene or file, and `name` in quotes, such as
/// `mesh 3 "Lamp"`, or `mesh 3` if `name` is empty. A `name` of more than 60 characters is cut, and control characters are
/// escaped.
pub(crate) fn label(kind: &str, index: usize, name: &str) -> String {
    if name.is_empty() {
        return format!("{kind} {index}");
    }
    format!("{kind} {index} {}", quoted(name))
}

/// A list of names for a message: the first `most` of `names`, separated by commas, followed by `and others` if there are
/// more.
pub(crate) fn listed(names: &[String], most: usize) -> String {
    match names.get(..most) {
        Some(first) if first.len() < names.len() => first.join(", ") + " and others",
        _ => names.join(", "),
    }
}

/// The maximum number of characters that a message quotes from a text in a file. A longer text is cut, and `...` marks the
/// cut; these three characters are included in the maximum. Escaping control characters can make the quotation longer.
const LONGEST: usize = 60;

/// Prepares a text from a file for a message, so that the message stays one short line: puts the text in quotes, escapes
/// control characters, and replaces everything after the first 57 characters by `...` if the text has more than 60
/// characters.
pub(crate) fn quoted(text: &str) -> String {
    if text.chars().nth(LONGEST).is_some() {
        let start: String = text.chars().take(LONGEST - 3).collect();
        format!("{:?}", start + "...")
    } else {
        format!("{text:?}")
    }
}

/// Prepares a text whose end says more than its start, such as a path, for a message: puts it in quotes, escapes control
/// characters, and keeps only the last 57 characters, after `...`, if it has more than 60. [`quoted`] cuts a text at its end
/// instead.
pub(crate) fn quoted_end(text: &str) -> String {
    match text.chars().count().checked_sub(LONGEST) {
        None | Some(0) => quoted(text),
        Some(more) => {
            let end: String = text.chars().skip(more + 3).collect();
            format!("{:?}", "...".to_owned() + &end)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn like_cases_make_one_line() {
        let mut tally = Tally::default();
        tally.add("skipped", || "a".into());
        tally.add("ignored", || "x".into());
        tally.add_many("skipped", 2, || "b".into());
        let lines: Vec<String> = tally.into_lines().collect();
        assert_eq!(lines, ["skipped: 3 times, first a", "ignored: x"]);
    }

    #[test]
    fn the_end_of_a_long_path_is_kept() {
        let path = |length: usize| "a".repeat(length - 2) + ".b";
        assert_eq!(quoted_end(&path(60)), format!("{:?}", path(60)));
        assert_eq!(quoted_end(&path(61)), format!("\"...{}\"", path(57)));
    }

    #[test]
    fn names_stay_on_the_line() {
        assert_eq!(label("mesh", 1, ""), "mesh 1");
        assert_eq!(label("mesh", 1, "a\nb"), "mesh 1 \"a\\nb\"");
        assert!(label("mesh", 1, &"ä".repeat(5000)).chars().count() < 80);
    }
}
