//! Conversion of values to JSON in which 32-bit floats have the fewest digits that identify them: 0.05, not
//! 0.05000000074505806. So reports and pictures show settings as the user wrote them.

use crate::{Error, Result};
use serde::Serialize;
use serde_json::Value;

/// Converts a value to JSON in which 32-bit floats have the fewest digits that identify them. `serde_json::to_value`
/// would convert them to 64 bits first, and 0.05 would become 0.05000000074505806. `what` names the value in the error
/// message.
///
/// # Errors
/// The value has no JSON form, such as a map whose keys are not text.
pub fn value_of(what: &str, value: &impl Serialize) -> Result<Value> {
    serde_json::to_string(value)
        .and_then(|text| serde_json::from_str(&text))
        .map_err(|e| Error::failed(format!("{what} as JSON: {e}")))
}
