//! JSON with shortest numbers.

use crate::{Error, Result};
use serde::Serialize;
use serde_json::Value;

/// A value as JSON whose 32-bit numbers are as short as possible. `serde_json::to_value` would make 64-bit numbers of them
/// first, and 0.05 would become 0.05000000074505806.
///
/// # Errors
/// The value, called `what` in messages, has no JSON form.
pub fn value_of(what: &str, value: &impl Serialize) -> Result<Value> {
    serde_json::to_string(value)
        .and_then(|text| serde_json::from_str(&text))
        .map_err(|e| Error::failed(format!("{what} as JSON: {e}")))
}
