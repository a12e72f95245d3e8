//! Collection of notices about assumptions and omissions, which counts equal notices in one line, and names for messages.

/// Notices for the user, counted by their text. For each text it stores where the notice occurred first, and how often it
/// occurred.
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
    /// Counts one occurrence of the notice with the text `what`. `location` names the element that the notice is about, such
    /// as a mesh; it is called at the first occurrence only.
    pub fn add(&mut self, what: &str, location: impl FnOnce() -> String) {
        self.add_many(what, 1, location);
    }

    /// Counts `count` occurrences of the notice with the text `what` at one element, such as a mesh. `location` names the
    /// element; it is called only if the notice is new.
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

    /// One line per text of a notice, in the order of their first occurrence. The line also names the element of the first
    /// occurrence and, if there were several occurrences, their number.
    pub fn into_lines(self) -> impl Iterator<Item = String> {
        self.kinds.into_iter().map(|kind| match kind.count {
            1 => format!("{}: {}", kind.what, kind.first),
            n => format!("{}: {n} times, first {}", kind.what, kind.first),
        })
    }
}

/// The name of an element in messages, such as `mesh 3 "Lamp"`, or `mesh 3` if `name` is empty. A long name is cut, and
/// control characters are escaped.
pub(crate) fn label(kind: &str, index: usize, name: &str) -> String {
    if name.is_empty() {
        return format!("{kind} {index}");
    }
    format!("{kind} {index} {}", quoted(name))
}

/// The maximum number of characters that a message takes from a text in a file.
const LONGEST: usize = 60;

/// A text from a file for messages: in quotes, with control characters escaped, and cut at its end after 60 characters.
pub(crate) fn quoted(text: &str) -> String {
    if text.chars().nth(LONGEST).is_some() {
        let start: String = text.chars().take(LONGEST - 3).collect();
        format!("{:?}", start + "...")
    } else {
        format!("{text:?}")
    }
}

/// A text as by [`quoted`], but cut at its start, for texts whose end is more informative, such as paths.
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
