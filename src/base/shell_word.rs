//! Quotes words for commands that the user can copy into a shell.

/// `word` in a form that a shell reads as this one word: unchanged if it has only harmless characters,
/// otherwise in single quotes. It is used in commands that the program prints.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:,=+%@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_with_special_characters_is_quoted() {
        assert_eq!(quoted("cornell:finish=metal"), "cornell:finish=metal");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's $x"), "'it'\\''s $x'");
        assert_eq!(quoted(""), "''");
    }
}
