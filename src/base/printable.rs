//! Escaping and shortening of text for a terminal. Names and messages can come from files, and control characters in them
//! could move the cursor, change colours, forge further lines or reverse the order of letters.

use std::fmt::Write;

/// Returns `text` as one line: control characters, line breaks and changes of the direction of text become JSON escapes,
/// such as `\n` and `\u001b`.
pub fn printable(text: &str) -> String {
    escaped(text, |_| false)
}

/// Escapes `text` like [`printable`], except that line breaks stay. JSON text keeps its meaning, because strings in JSON
/// contain no raw line break, and the escapes are those of JSON.
pub fn printable_lines(text: &str) -> String {
    escaped(text, |c| c == '\n')
}

/// Shortens `text` to at most `most` characters. If it is longer, an ellipsis replaces its middle, because a message
/// begins with the location of an error and ends with the advice.
pub fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let tail = most * 2 / 5;
    let head = most.saturating_sub(tail + 1);
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!("{start}…{end}")
}

fn escaped(text: &str, keeps: impl Fn(char) -> bool) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            _ if keeps(c) || !disturbs(c) => out.push(c),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            // All of them have four hexadecimal digits, and writing to a string cannot fail.
            _ => drop(write!(out, "\\u{:04x}", u32::from(c))),
        }
    }
    out
}

/// True if `c` can disturb a terminal or an XML file: C0 and C1 controls, DEL, Unicode's line breaks, changes of the
/// direction of text, and the two noncharacters that XML forbids.
fn disturbs(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_disturbs_a_terminal_is_escaped_and_the_rest_stays() {
        for (text, shown) in [
            ("é 木 ™ 🙂 עברית ‎", "é 木 ™ 🙂 עברית ‎"),
            ("a\u{1b}[31mb\nc", "a\\u001b[31mb\\nc"),
            ("\0\t\r\u{7f}\u{9b}", "\\u0000\\t\\r\\u007f\\u009b"),
            ("\u{2028}\u{2029}", "\\u2028\\u2029"),
            ("\u{202e}evil\u{2066}", "\\u202eevil\\u2066"),
        ] {
            assert_eq!(printable(text), shown);
        }
        assert_eq!(printable_lines("a\n\u{1b}b"), "a\n\\u001bb");
    }

    #[test]
    fn json_stays_the_same_json() {
        let value = serde_json::json!({ "a\u{7f}": "x\n\t\u{1b}\u{9b}\u{202e}\u{ffff}é" });
        for text in [value.to_string(), format!("{value:#}")] {
            let shown = printable_lines(&text);
            let back: serde_json::Value = serde_json::from_str(&shown).unwrap();
            assert_eq!(back, value);
            assert!(!shown.contains(['\u{7f}', '\u{9b}', '\u{202e}']));
        }
    }

    #[test]
    fn a_long_text_loses_its_middle() {
        assert_eq!(shortened("abcdefghij", 10), "abcdefghij");
        assert_eq!(shortened("äbcdefghijk", 10), "äbcde…hijk");
        assert_eq!(shortened(&"木".repeat(9000), 500).chars().count(), 500);
    }
}
