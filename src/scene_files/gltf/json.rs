//! Parses the JSON of a glTF file. Some programs write JSON with harmless faults, such as a byte order mark or the integer 4
//! as `4.0`; these are read as they are meant.

use super::damaged;
use super::document::{Asset, Document};
use crate::base::memory;
use crate::scene::notices::{Tally, quoted, quoted_end};
use crate::{Error, Result};
use std::io::Write;

/// The estimated memory of one object or list of the JSON, in bytes (1 KiB). It includes the parts of the scene that are
/// made from the object, such as an instance that is made from a node. [`memory_of`] adds up such estimates, and a file that
/// needs too much memory is refused.
const OBJECT_BYTES: u64 = 1 << 10;

/// The estimated memory of a string, in bytes, without its text. [`memory_of`] adds it for each comma before a string, which
/// is an element of a list or the name of a member. A string at the start of a list or an object follows no comma; its
/// memory is part of [`OBJECT_BYTES`]. For a list that begins with a number, [`memory_of`] adds `STRING_BYTES` in place of
/// [`OBJECT_BYTES`].
const STRING_BYTES: u64 = 128;

/// The estimated memory of a number in a list, in bytes. [`memory_of`] adds it for each comma that no string follows. The
/// first number of a list follows no comma; its memory is part of the [`STRING_BYTES`] that are added for the list.
const NUMBER_BYTES: u64 = 16;

/// Parses the JSON of a glTF file, after a check that there is enough memory for its elements. A byte order mark before the
/// JSON and zero bytes after it are left out. Line breaks inside of texts count as blanks, with a notice in `tally`. Fails
/// if the JSON is damaged, or if its glTF version is not supported.
pub fn parse(json: &[u8], tally: &mut Tally) -> Result<Document> {
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let end = json.iter().rposition(|byte| !matches!(byte, 0 | b' '));
    let json = &json[..end.map_or(0, |last| last + 1)];
    check_memory(json)?;
    let document: Document = match serde_json::from_slice(json) {
        Ok(document) => document,
        // Only files with a fault pay for the copy.
        Err(_) => parse_mended(&mended(json, tally))?,
    };
    check_version(&document.asset)?;
    Ok(document)
}

fn parse_mended(json: &[u8]) -> Result<Document> {
    serde_json::from_slice(json).or_else(|cause| {
        // glTF 1.0 has other types throughout: say that rather than where they differ first.
        #[derive(serde::Deserialize)]
        struct Probe {
            asset: Asset,
        }
        if let Ok(probe) = serde_json::from_slice::<Probe>(json) {
            check_version(&probe.asset)?;
        }
        Err(not_json(json, &cause))
    })
}

/// A copy of `json` with two kinds of faults mended. Integers with a fraction of zeros or an exponent, such as `4.0` and
/// `4e0`, become plain integers, followed by blanks so that the places of other faults stay the same. Control characters
/// inside of texts, such as line breaks, become blanks, with a notice in `tally`.
fn mended(json: &[u8], tally: &mut Tally) -> Vec<u8> {
    let mut mended = Vec::with_capacity(json.len());
    let mut controls = 0;
    let mut rest = json;
    while let Some((first, after)) = rest.split_first() {
        let length = match first {
            b'"' => rest.len() - after_string(after).len(),
            b'-' | b'0'..=b'9' => (rest.iter())
                .position(|byte| !matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'))
                .unwrap_or(rest.len()),
            _ => 1,
        };
        let (token, after) = rest.split_at(length);
        rest = after;
        if *first == b'"' {
            controls += token.iter().filter(|byte| **byte < b' ').count();
            mended.extend(token.iter().map(|byte| *byte.max(&b' ')));
        } else if let Some(whole) = whole_number(token) {
            // Writing to memory does not fail.
            let _ = write!(mended, "{whole:<length$}");
        } else {
            mended.extend(token);
        }
    }
    tally.add_many(
        "control characters in texts of the JSON count as blanks",
        controls,
        || "the JSON".into(),
    );
    mended
}

/// The integer that the JSON number `token` means; `None` if the token has neither a fraction nor an exponent, is not a whole
/// number, or is above 2⁵³, from where not every integer has an f64. `-0.0` is not an integer, because it has a sign.
fn whole_number(token: &[u8]) -> Option<i64> {
    const LARGEST: f64 = (1_u64 << 53) as f64;
    let is_written_otherwise = token.iter().any(|byte| matches!(byte, b'.' | b'e' | b'E'));
    let number: f64 = std::str::from_utf8(token).ok()?.parse().ok()?;
    let is_whole = number.fract() == 0.0 && number.abs() <= LARGEST;
    let is_minus_zero = number == 0.0 && number.is_sign_negative();
    (is_written_otherwise && is_whole && !is_minus_zero).then_some(number as i64)
}

/// Checks that there is enough memory for the data that the JSON describes, as [`memory_of`] estimates it, and otherwise
/// fails. This check comes before the JSON is parsed, because a small file can describe very many elements.
fn check_memory(json: &[u8]) -> Result<()> {
    memory::check(memory_of(json)).map_err(|cause| {
        Error::input(format!(
            "its JSON has too many elements: {cause}; split the file"
        ))
    })
}

/// An upper estimate of the memory that the parsed JSON and the data made from it take, in bytes. It counts the objects,
/// lists, strings and numbers of the JSON.
fn memory_of(json: &[u8]) -> u64 {
    let mut bytes = 0;
    let mut rest = json;
    while let Some((byte, after)) = rest.split_first() {
        rest = after;
        let next = || after.trim_ascii_start().first();
        bytes += match byte {
            b'"' => {
                rest = after_string(after);
                0
            }
            b'[' if matches!(next(), Some(b'-' | b'0'..=b'9')) => STRING_BYTES,
            // The reader takes a list of an object's members for the object.
            b'{' | b'[' => OBJECT_BYTES,
            b',' if next() == Some(&b'"') => STRING_BYTES,
            b',' => NUMBER_BYTES,
            _ => 0,
        };
    }
    bytes
}

/// The rest of `json` after the end of a string, so that brackets and commas in strings are not counted as elements. `json`
/// must begin with the first character of the string, after its opening quote. The result is empty if the string never ends.
fn after_string(json: &[u8]) -> &[u8] {
    let mut rest = json;
    while let Some(at) = rest.iter().position(|byte| matches!(byte, b'"' | b'\\')) {
        let length = if rest[at] == b'"' { 1 } else { 2 };
        rest = rest.get(at + length..).unwrap_or_default();
        if length == 1 {
            return rest;
        }
    }
    &[]
}

/// The error for JSON that cannot be read as a glTF document. Its message contains the fault and the path of the faulty
/// element, such as the name of a list and an index.
fn not_json(json: &[u8], cause: &serde_json::Error) -> Error {
    // Read again to find the element: to follow it in every file would slow loading down.
    let json = &mut serde_json::Deserializer::from_slice(json);
    let fault = serde_path_to_error::deserialize::<_, Document>(json);
    let location = match fault.map_err(|fault| fault.path().to_string()) {
        Err(element) if element != "." => {
            format!(", in {}", quoted_end(&element))
        }
        _ => String::new(),
    };
    damaged(format!("its JSON cannot be read: {cause}{location}"))
}

fn check_version(asset: &Asset) -> Result<()> {
    let wanted = asset.min_version.as_ref().unwrap_or(&asset.version);
    let supported = match &asset.min_version {
        Some(minimum) => minimum == "2.0",
        None => asset.version.starts_with("2."),
    };
    if supported {
        return Ok(());
    }
    Err(Error::input(format!(
        "asset version {} is not supported; export it as glTF 2.0",
        quoted(wanted)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_of_json_are_counted_outside_of_strings() {
        for (json, bytes) in [
            (r#" "[{,\"[{,\\" "#, 0),
            ("{}", OBJECT_BYTES),
            ("[ [],\n[]]", 3 * OBJECT_BYTES + NUMBER_BYTES),
            ("[ -1 , 2,3]", STRING_BYTES + 2 * NUMBER_BYTES),
            (r#"["","" , ""]"#, OBJECT_BYTES + 2 * STRING_BYTES),
            (r#"{"a":1,"b":["#, 2 * OBJECT_BYTES + STRING_BYTES),
            (r#""\"#, 0),
        ] {
            assert_eq!(memory_of(json.as_bytes()), bytes, "{json}");
        }
    }

    #[test]
    fn integers_and_texts_are_mended_in_their_places() {
        let mut tally = Tally::default();
        for (json, expected) in [
            ("[4.0,-2.00,1e2]", "[4  ,-2   ,100]"),
            ("[1.5e1 ,25E-1,4]", "[15    ,25E-1,4]"),
            ("[-0.0,0.0,0.5,1e300]", "[-0.0,0  ,0.5,1e300]"),
            ("[9007199254740994.0]", "[9007199254740994.0]"),
            ("{\"4.0\":\"a\\\"4.0\"}", "{\"4.0\":\"a\\\"4.0\"}"),
        ] {
            let found = String::from_utf8(mended(json.as_bytes(), &mut tally)).unwrap();
            assert_eq!(found, expected, "{json}");
        }
        assert_eq!(tally.into_lines().count(), 0);
        let mut tally = Tally::default();
        assert_eq!(mended(b"[\"a\nb\t\",\n1]", &mut tally), b"[\"a b \",\n1]");
        let line =
            "control characters in texts of the JSON count as blanks: 2 times, first the JSON";
        assert_eq!(tally.into_lines().collect::<Vec<_>>(), [line]);
    }
}
