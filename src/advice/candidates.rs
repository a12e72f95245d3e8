//! Candidates: the settings that the advice compares in a race. The file `candidates.toml` lists them.

use super::chain::Purpose;
use crate::Result;
use crate::base::toml_text::TomlText;
use crate::render::Settings;
use crate::render::presets::Preset;
use crate::render::settings::Integrator;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Settings that the advice can recommend: those of a preset, with some of them changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// Name of the candidate, which the advice, its table and its page show.
    pub name: String,
    /// Name of the preset, such as `fast`, whose settings the candidate begins with.
    pub preset: String,
    /// Changed settings: the new value of each setting, by its dotted key, such as `direct.reuse`. All other
    /// settings have the values of the preset.
    #[serde(default)]
    pub set: Map<String, Value>,
    /// The only purpose for which the candidate is measured; `None` if it is measured for every purpose.
    #[serde(default, rename = "for", skip_serializing_if = "Option::is_none")]
    pub purpose: Option<Purpose>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    candidates: Vec<Candidate>,
}

/// The candidates that a race for `purpose` compares, path tracing first. All of them are unbiased.
///
/// # Errors
/// The list that is compiled into the program is not valid; a test excludes this.
pub fn all(purpose: Purpose) -> Result<Vec<Candidate>> {
    let text = TomlText::new("the list of candidates", include_str!("candidates.toml"));
    let mut candidates = text.parse::<List>()?.candidates;
    candidates.retain(|candidate| candidate.purpose.is_none_or(|only| only == purpose));
    Ok(candidates)
}

impl Candidate {
    /// The complete settings with which the candidate renders: those of its preset, with the changes of `set`
    /// applied.
    ///
    /// # Errors
    /// The preset or a setting does not exist, or a value does not fit its setting.
    pub fn settings(&self) -> Result<Settings> {
        Preset::named(&self.preset)?
            .settings()?
            .with(&Value::Object(self.set.clone()))
    }

    /// True if the integrator of the candidate is path tracing. The other candidates are compared with this
    /// one.
    ///
    /// # Errors
    /// As for [`Self::settings`].
    pub fn is_path_tracing(&self) -> Result<bool> {
        Ok(self.settings()?.integrator == Integrator::PathTracing)
    }

    /// Command-line options that select these settings, such as `--preset fast --set direct.reuse=spatial`.
    /// The advice prints them in a command that the user can run.
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
