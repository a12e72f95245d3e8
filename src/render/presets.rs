//! Presets: sparse differences from the default settings, as files.

use super::settings::Settings;
use crate::base::nearest::nearest;
use crate::base::toml_text::TomlText;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::sync::LazyLock;

/// A named set of changes.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The name on the command line.
    pub name: &'static str,
    /// The file's text in TOML; its first comment describes the purpose of the preset.
    pub text: &'static str,
}

/// Every preset.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "path-tracing",
        text: include_str!("presets/path-tracing.toml"),
    },
    Preset {
        name: "fast",
        text: include_str!("presets/fast.toml"),
    },
    Preset {
        name: "balanced",
        text: include_str!("presets/balanced.toml"),
    },
    Preset {
        name: "accurate",
        text: include_str!("presets/accurate.toml"),
    },
    Preset {
        name: "s1",
        text: include_str!("presets/s1.toml"),
    },
];

/// The preset that is used when no preset is named.
pub const DEFAULT: &str = "balanced";

impl Preset {
    /// The preset with this name.
    ///
    /// # Errors
    /// There is no preset with this name; the message lists the existing names.
    pub fn named(name: &str) -> Result<&'static Self> {
        PRESETS.iter().find(|p| p.name == name).ok_or_else(|| {
            let names: Vec<_> = PRESETS.iter().map(|p| p.name).collect();
            let hint = nearest(name, names.iter().copied());
            Error::input(format!(
                "no preset '{name}'{hint}; there are: {}",
                names.join(", ")
            ))
        })
    }

    /// The purpose of the preset: the leading comment of its file.
    pub fn purpose(&self) -> String {
        self.text
            .lines()
            .map_while(|line| line.strip_prefix("# "))
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// The default settings with this preset's changes.
    ///
    /// # Errors
    /// Never with the presets of this build, as a test checks.
    pub fn settings(&self) -> Result<Settings> {
        // A plan asks for them once for each of its configurations.
        static PARSED: LazyLock<HashMap<&str, Settings>> = LazyLock::new(|| {
            let pair = |preset: &Preset| Some((preset.name, preset.parse().ok()?));
            PRESETS.iter().filter_map(pair).collect()
        });
        match PARSED.get(self.name) {
            Some(settings) => Ok(settings.clone()),
            None => self.parse(),
        }
    }

    fn parse(&self) -> Result<Settings> {
        Settings::default().with(&TomlText::new(self.name, self.text).parse::<Value>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_says_what_it_is_for() {
        for preset in PRESETS {
            preset.settings().unwrap();
            assert!(!preset.purpose().is_empty(), "{}", preset.name);
        }
        Preset::named(DEFAULT).unwrap();
    }

    #[test]
    fn an_unknown_preset_names_the_nearest() {
        let error = Preset::named("path-trcing").unwrap_err().to_string();
        assert!(error.contains("path-tracing"), "{error}");
    }
}
