//! The settings that a race compares.

use super::chain::Purpose;
use crate::Result;
use crate::base::toml_text::TomlText;
use crate::render::Settings;
use crate::render::presets::Preset;
use crate::render::settings::Integrator;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Settings that can be advised: a preset, with changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// The name, which the advice prints.
    pub name: String,
    /// The name of the preset.
    pub preset: String,
    /// The settings that differ from those of the preset: new values by dotted key.
    #[serde(default)]
    pub set: Map<String, Value>,
    /// The purpose for which it races; `None` for all.
    #[serde(default, rename = "for", skip_serializing_if = "Option::is_none")]
    pub purpose: Option<Purpose>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    candidates: Vec<Candidate>,
}

/// The candidates of a race for `purpose`, path tracing first. All are unbiased.
///
/// # Errors
/// The list in the program is wrong, which a test excludes.
pub fn all(purpose: Purpose) -> Result<Vec<Candidate>> {
    let text = TomlText::new("the list of candidates", include_str!("candidates.toml"));
    let mut candidates = text.parse::<List>()?.candidates;
    candidates.retain(|candidate| candidate.purpose.is_none_or(|only| only == purpose));
    Ok(candidates)
}

impl Candidate {
    /// The settings of the preset, with the changes of `set`.
    ///
    /// # Errors
    /// The preset or a setting is unknown.
    pub fn settings(&self) -> Result<Settings> {
        Preset::named(&self.preset)?
            .settings()?
            .with(&Value::Object(self.set.clone()))
    }

    /// True if the candidate is path tracing, with which the others are compared.
    ///
    /// # Errors
    /// As for [`Self::settings`].
    pub fn is_path_tracing(&self) -> Result<bool> {
        Ok(self.settings()?.integrator == Integrator::PathTracing)
    }

    /// The options of the command line that choose these settings.
    pub fn options(&self) -> String {
        let mut options = format!("--preset {}", self.preset);
        for (key, value) in &self.set {
            let value = value.as_str().map_or(value.to_string(), str::to_owned);
            options += &format!(" --set {key}={value}");
        }
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_right_and_begins_with_path_tracing() {
        let all = all(Purpose::Mean).unwrap();
        let settings: Vec<Settings> = all.iter().map(|c| c.settings().unwrap()).collect();
        assert!(all[0].is_path_tracing().unwrap() && all.len() > 4);
        for (index, one) in settings.iter().enumerate() {
            assert!(!settings[..index].contains(one), "{}", all[index].name);
            assert!(one.is_unbiased(), "{}", all[index].name);
        }
        assert_eq!(all[1].options(), "--preset fast");
        let more = all.last().unwrap().options();
        assert!(more.contains(" --set direct.reuse=spatial"), "{more}");
        let steady = super::all(Purpose::Steady).unwrap();
        assert!(steady.len() < all.len());
    }
}
