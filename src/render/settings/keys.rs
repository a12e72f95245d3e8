//! Access to settings by their dotted keys, such as `direct.spatial.radius`: settings are changed, checked and described
//! by means of the JSON schema of [`Settings`]. The schema is made from the fields and their doc comments.

use super::Settings;
use crate::base::nearest::nearest;
use crate::base::toml_text::{Step, TomlText};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::LazyLock;

/// One setting as the command `headwater presets` shows it, so that the user learns what it does and which values it takes.
#[derive(Clone, Debug, Serialize)]
pub struct Description {
    /// The dotted key of the setting, such as `direct.spatial.radius`.
    pub key: String,
    /// The doc comment of the setting as one line of text: its meaning, unit, cost and effect on bias.
    pub doc: String,
    /// The values that the setting can have, as text: a type, with its range if it has one, such as `integer 1 to 64`, or
    /// all possible names, such as `gltf | compensated`.
    pub values: String,
    /// The current value of the setting, in the settings for which [`Settings::describe`] was called.
    pub value: Value,
}

impl Settings {
    /// A copy of these settings in which `changes` are made. `changes` is a JSON tree that contains only the settings to
    /// change. Its keys can be nested or dotted.
    ///
    /// # Errors
    /// A key is unknown, or a value has the wrong type or is out of range. The message names the nearest valid key, or the
    /// values that the setting takes.
    pub fn with(&self, changes: &Value) -> Result<Self> {
        let mut flat = Vec::new();
        flatten("", changes, &mut flat);
        let mut settings = self.clone();
        let mut tree = self.to_value()?;
        for (key, value) in flat {
            let (Some(slot), Some(field)) = (slot_of(&mut tree, &key), field_schema(&key)) else {
                let known = self.describe()?;
                return Err(Error::input(format!(
                    "unknown setting '{key}'{}; see 'headwater presets' for all",
                    nearest(&key, known.iter().map(|d| d.key.as_str()))
                )));
            };
            *slot = value.clone();
            // Changes are checked one by one, so that the message of an error names the wrong key.
            let changed = Self::deserialize(&tree).ok();
            let changed = changed.filter(|_| in_range(field, &value));
            settings = changed.ok_or_else(|| {
                Error::input(format!(
                    "setting {key}={} is not valid; it takes {}",
                    plain(&value),
                    values_of(field)
                ))
            })?;
        }
        Ok(settings)
    }

    /// A copy of these settings with `changes`, a JSON tree that was parsed from the TOML text `source`. `path` lists the
    /// keys and indices that lead from the root of the text to the table of the changes; it is empty if this table is the
    /// root. From `source` and `path`, the message of an error can name the line of the wrong setting.
    ///
    /// # Errors
    /// The errors of [`Self::with`]; the message also names the TOML text and the line.
    pub fn with_toml(&self, source: &TomlText, path: &[Step<'_>], changes: &Value) -> Result<Self> {
        let mut flat = Vec::new();
        flatten("", changes, &mut flat);
        flat.into_iter()
            .try_fold(self.clone(), |settings, (key, value)| {
                let change = Value::Object([(key.clone(), value)].into_iter().collect());
                settings
                    .with(&change)
                    .map_err(|error| source.error_for(path, &key, error))
            })
    }

    /// Converts the text `KEY=VALUE`, which the user gives after `--set`, to a JSON tree with this one change, for
    /// [`Settings::with`]. The key is dotted. A value that is not valid JSON becomes a string.
    ///
    /// # Errors
    /// There is no `=`, or a part of the key is empty.
    pub fn parse_change(text: &str) -> Result<Value> {
        let malformed = || Error::input(format!("'{text}' is not KEY=VALUE"));
        let (key, value) = text.split_once('=').ok_or_else(malformed)?;
        if key.split('.').any(str::is_empty) {
            return Err(malformed());
        }
        let value = serde_json::from_str(value).unwrap_or_else(|_| Value::String(value.to_owned()));
        Ok(Value::Object(
            [(key.to_owned(), value)].into_iter().collect(),
        ))
    }

    /// Describes every setting, for the command `headwater presets`: its key, its doc comment, its possible values, and its
    /// value in these settings. The result has one entry per setting, in the order of the fields.
    ///
    /// # Errors
    /// The settings cannot be written as JSON, which does not happen with the settings of this build.
    pub fn describe(&self) -> Result<Vec<Description>> {
        let mut flat = Vec::new();
        flatten("", &self.to_value()?, &mut flat);
        Ok(flat
            .into_iter()
            .map(|(key, value)| {
                let field = field_schema(&key).unwrap_or(&Value::Null);
                Description {
                    doc: doc_of(field),
                    values: values_of(field),
                    key,
                    value,
                }
            })
            .collect())
    }

    /// Converts the settings to a tree of JSON values, with one object per structure of settings. Pictures, reports and
    /// results of studies store this tree.
    ///
    /// # Errors
    /// The settings cannot be written as JSON, which does not happen with finite values.
    pub fn to_value(&self) -> Result<Value> {
        crate::base::json::value_of("settings", self)
    }
}

/// The JSON schema of all settings, which contains their doc comments, ranges and choices. Descriptions and checks of values
/// are made from it. It is made once, at its first use, since that takes milliseconds.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(Settings).to_value());

/// A reference to the value with the dotted key `key` in a tree of settings, through which the caller replaces the value.
/// `None` if the key is unknown, or if it names a group of settings, which has no value of its own.
fn slot_of<'a>(tree: &'a mut Value, key: &str) -> Option<&'a mut Value> {
    let slot = key
        .split('.')
        .try_fold(tree, |node, part| node.get_mut(part));
    slot.filter(|value| !value.is_object())
}

/// The schema of the setting with the dotted key `key`; `None` if the key is unknown. It contains the doc and the range of
/// the setting. If it also refers to the schema of a type, this reference is not replaced by that schema.
fn field_schema(key: &str) -> Option<&'static Value> {
    key.split('.').try_fold(&*SCHEMA, |node, part| {
        resolve(node).get("properties")?.get(part)
    })
}

fn resolve(node: &'static Value) -> &'static Value {
    let reference = node.get("$ref").and_then(Value::as_str);
    reference
        .and_then(|r| SCHEMA.pointer(r.trim_start_matches('#')))
        .unwrap_or(node)
}

fn doc_of(field: &Value) -> String {
    let text = field.get("description").and_then(Value::as_str);
    text.unwrap_or_default().replace('\n', " ")
}

fn values_of(field: &'static Value) -> String {
    let resolved = resolve(field);
    if let Some(choices) = resolved.get("oneOf").and_then(Value::as_array) {
        let names = choices.iter().filter_map(|c| c.get("const")?.as_str());
        return names.collect::<Vec<_>>().join(" | ");
    }
    let bound = |name: &str| resolved.get(name).and_then(Value::as_f64);
    let kind = resolved.get("type").and_then(Value::as_str).unwrap_or("");
    match (bound("minimum"), bound("maximum")) {
        (Some(low), Some(high)) => format!("{kind} {low} to {high}"),
        _ => kind.to_owned(),
    }
}

/// True if the number `value` is between the minimum and the maximum of its setting, both included, so that the setting may
/// be changed to it. `field` is the JSON schema of the setting; if it has no minimum or no maximum, there is no such limit.
/// Always true if `value` is not a number.
fn in_range(field: &Value, value: &Value) -> bool {
    let bound = |name: &str| field.get(name).and_then(Value::as_f64);
    value.as_f64().is_none_or(|number| {
        bound("minimum").is_none_or(|low| number >= low)
            && bound("maximum").is_none_or(|high| number <= high)
    })
}

/// Appends one entry to `out` for each value in the JSON tree `value` that is not an object: the dotted key of the value,
/// and the value itself. So nested and dotted settings get the same keys. `prefix` is the dotted key of the tree in a larger
/// tree; it is empty for a whole tree.
pub(crate) fn flatten(prefix: &str, value: &Value, out: &mut Vec<(String, Value)>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let key = if prefix.is_empty() {
                    key.clone()
                } else {
                    format!("{prefix}.{key}")
                };
                flatten(&key, value, out);
            }
        }
        value => out.push((prefix.to_owned(), value.clone())),
    }
}

fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::super::Energy;
    use super::*;

    fn set(change: &str) -> Result<Settings> {
        Settings::default().with(&Settings::parse_change(change)?)
    }

    #[test]
    fn a_change_reaches_its_field() {
        assert_eq!(
            set("energy=compensated").unwrap().energy,
            Energy::Compensated
        );
        assert_eq!(set("roulette.start=7").unwrap().roulette.start, 7);
    }

    #[test]
    fn numbers_are_as_short_as_they_were_written() {
        let settings = set("roulette.floor=0.05").unwrap();
        let text = settings.to_value().unwrap().to_string();
        assert!(text.contains("\"floor\":0.05}"), "{text}");
        assert_eq!(
            Settings::default()
                .with(&settings.to_value().unwrap())
                .unwrap(),
            settings
        );
    }

    #[test]
    fn a_table_that_is_empty_changes_nothing() {
        let same = Settings::default().with(&serde_json::json!({ "direct": {} }));
        assert_eq!(same.unwrap(), Settings::default());
    }

    #[test]
    fn wrong_settings_name_key_range_and_nearest_key() {
        let message = |change: &str| set(change).unwrap_err().to_string();
        assert!(message("roulette.floor=2").contains("0.001 to 1"));
        assert!(message("energy=magic").contains("gltf | compensated"));
        assert!(message("roulete.start=1").contains("roulette.start"));
        assert!(message("roulette.start=-1").contains("roulette.start"));
        assert!(message("roulette.start=1.5").contains("roulette.start"));
        assert!(message("roulette=3").contains("roulette"));
        assert!(set("noequals").is_err());
    }

    #[test]
    fn a_wrong_setting_names_its_line_however_it_is_written() {
        for (text, line) in [
            (
                "energy = \"gltf\"\ndirect.mess = 1",
                "line 2, 'direct.mess = 1': unknown",
            ),
            (
                "\n\"direct.mess\" = 1",
                "line 2, '\"direct.mess\" = 1': unknown",
            ),
            ("[direct]\n\nmess = 1", "line 3, 'mess = 1': unknown"),
            (
                "[direct.temporal]\nconfidence_cap = 1\n[roulette]\nfloor = 7",
                "line 4, 'floor = 7': setting roulette.floor=7",
            ),
        ] {
            let source = TomlText::new("x.toml", text);
            let changes: Value = source.parse().unwrap();
            let changed = Settings::default().with_toml(&source, &[], &changes);
            let error = changed.unwrap_err().to_string();
            assert!(error.starts_with(&format!("x.toml, {line}")), "{error}");
        }
    }

    #[test]
    fn every_setting_has_a_doc_and_values() {
        for setting in Settings::default().describe().unwrap() {
            // A sentence that says more than the key.
            assert!(
                setting.doc.ends_with('.'),
                "{}: {}",
                setting.key,
                setting.doc
            );
            assert!(
                setting.doc.split(' ').count() >= 4,
                "{}: {}",
                setting.key,
                setting.doc
            );
            assert!(!setting.values.is_empty(), "{}", setting.key);
        }
    }
}
