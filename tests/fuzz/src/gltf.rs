//! Mutations of glTF files that keep their form: values of the JSON are changed, exchanged, copied and removed, and
//! bytes of buffers are changed.

use crate::document::Document;
use crate::files::glb;
use crate::random::Random;
use crate::words;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use libfuzzer_sys::fuzzer_mutate;
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::LazyLock;

static KEYS: LazyLock<Vec<&str>> = LazyLock::new(|| words::GLTF_KEYS.split_whitespace().collect());
static TEXTS: LazyLock<Vec<&str>> =
    LazyLock::new(|| words::GLTF_TEXTS.split_whitespace().collect());

/// Numbers at which loaders decide: sizes, codes of component types, filters and wrap modes, limits of types.
const NUMBERS: &[f64] = &[
    0.0,
    1.0,
    2.0,
    3.0,
    4.0,
    5.0,
    6.0,
    7.0,
    8.0,
    12.0,
    16.0,
    252.0,
    253.0,
    255.0,
    256.0,
    65535.0,
    65536.0,
    5120.0,
    5121.0,
    5122.0,
    5123.0,
    5125.0,
    5126.0,
    9728.0,
    10497.0,
    33071.0,
    33648.0,
    -1.0,
    0.5,
    -0.5,
    1e-30,
    1e-45,
    1e13,
    1e30,
    3.4e38,
    1e39,
    1e300,
    1048576.0,
    2147483648.0,
    4294967295.0,
    4294967296.0,
    18446744073709549568.0,
];

/// Mutates the file in the first `size` bytes of `data`, which end at `max_size`; the new size.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, random: &mut Random) -> usize {
    let changed = (random.index(16) > 0).then(|| edited(&data[..size], max_size, random));
    match changed.flatten() {
        Some(file) if file.len() <= max_size => {
            data[..file.len()].copy_from_slice(&file);
            file.len()
        }
        _ => fuzzer_mutate(data, size, max_size),
    }
}

/// The file with changes; none if its JSON cannot be read.
fn edited(file: &[u8], max_size: usize, random: &mut Random) -> Option<Vec<u8>> {
    let chunks = split(file);
    let (json, binary) = chunks.unwrap_or((file, &[]));
    if chunks.is_some() && !binary.is_empty() && random.index(4) == 0 {
        return Some(glb(json, &with_other_bytes(binary, max_size)));
    }
    let mut document: Value = serde_json::from_slice(json).ok()?;
    for _ in 0..=random.index(3) {
        let mut next = document.clone();
        edit(&mut next, random);
        // Nothing of a file is read if one value has the wrong type.
        if Document::deserialize(&next).is_ok() || random.index(16) == 0 {
            document = next;
        }
    }
    let json = document.to_string();
    Some(match chunks {
        Some(_) => glb(json.as_bytes(), binary),
        None => json.into_bytes(),
    })
}

/// The chunks of a GLB file that has both.
fn split(file: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = u32::from_le_bytes(*file.strip_prefix(b"glTF")?.get(8..)?.first_chunk()?);
    let (json, rest) = file[20.min(file.len())..].split_at_checked(length as usize)?;
    Some((json, rest.get(8..)?))
}

fn with_other_bytes(bytes: &[u8], max_size: usize) -> Vec<u8> {
    let mut room = bytes.to_vec();
    room.resize(max_size.max(bytes.len()), 0);
    let size = fuzzer_mutate(&mut room, bytes.len(), max_size.max(bytes.len()));
    room.truncate(size);
    room
}

/// One change somewhere in a document. Most keep the type of a value.
fn edit(document: &mut Value, random: &mut Random) {
    let values = count(document);
    let other = nth(document, &mut random.index(values)).cloned();
    let other = other.unwrap_or_default();
    let key = KEYS[random.index(KEYS.len())];
    let Some(value) = nth(document, &mut random.index(values)) else {
        return;
    };
    match (value, random.index(16)) {
        (value, 0) => {
            let plain = [json!(null), json!(true), json!(""), json!([]), json!({})];
            *value = plain[random.index(plain.len())].clone();
        }
        (Value::Object(fields), 1..=4) => {
            fields.insert(key.into(), other);
        }
        (Value::Object(fields), 5..=8) if !fields.is_empty() => {
            let name = fields.keys().nth(random.index(fields.len())).cloned();
            fields.remove(&name.unwrap_or_default());
        }
        (Value::Object(fields), 9..=12) => {
            fields.insert(key.into(), number(true, random));
        }
        (Value::Array(items), 1..=12) if items.iter().any(|item| !item.is_number()) => {
            let index = random.index(items.len());
            match random.index(3) {
                0 => drop(items.remove(index)),
                1 => items.push(items[index].clone()),
                _ => items[index] = other,
            }
        }
        (Value::String(text), 1..=12) => *text = other_text(text, random),
        (Value::Number(old), 1..=6) => {
            let step = [-1, 1, 2, 4][random.index(4)];
            if let Some(moved) = old.as_i64().and_then(|old| old.checked_add(step)) {
                *old = moved.into();
            }
        }
        (value, 7..=13) if value.is_number() => *value = number(value.is_u64(), random),
        (value, _) => {
            if std::mem::discriminant(value) == std::mem::discriminant(&other) {
                *value = other;
            }
        }
    }
}

/// One of [`NUMBERS`]: an index or a count, if it is to be whole.
fn number(whole: bool, random: &mut Random) -> Value {
    let number = NUMBERS[random.index(NUMBERS.len())];
    match number.fract() == 0.0 && (0.0..1e19).contains(&number) {
        true => json!(number as u64),
        false if whole && random.index(8) > 0 => json!(random.index(8)),
        false => json!(number),
    }
}

/// Another text, or the same data with other bytes.
fn other_text(text: &str, random: &mut Random) -> String {
    if let Some((kind, data)) = text.split_once(";base64,")
        && random.index(8) > 0
        && let Ok(bytes) = STANDARD.decode(data)
    {
        let bytes = with_other_bytes(&bytes, bytes.len() + 16);
        return format!("{kind};base64,{}", STANDARD.encode(bytes));
    }
    TEXTS[random.index(TEXTS.len())].to_owned()
}

/// Number of values in a document, itself included.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Object(fields) => fields.values().map(count).sum(),
        Value::Array(items) => items.iter().map(count).sum(),
        _ => 0,
    }
}

/// The value at `index`, which counts down, in the order of the document.
fn nth<'a>(value: &'a mut Value, index: &mut usize) -> Option<&'a mut Value> {
    if *index == 0 {
        return Some(value);
    }
    *index -= 1;
    match value {
        Value::Object(fields) => fields.values_mut().find_map(|value| nth(value, index)),
        Value::Array(items) => items.iter_mut().find_map(|value| nth(value, index)),
        _ => None,
    }
}

/// True if the file is JSON that fits the types of glTF 2.0, or a GLB file with such a chunk.
pub fn has_header(file: &[u8]) -> bool {
    let json = split(file).map_or(file, |(json, _)| json);
    serde_json::from_slice::<Document>(json)
        .is_ok_and(|document| document.asset.version.starts_with("2."))
}
