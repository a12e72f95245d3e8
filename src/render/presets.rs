//! Presets: named TOML files, compiled into the program, from which the user selects one. Each contains the settings in
//! which the preset differs from the defaults.

use super::settings::Settings;
use crate::base::nearest::nearest;
use crate::base::toml_text::TomlText;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::sync::LazyLock;

/// A named set of changes to the default settings; the option `--preset NAME` selects it.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The name of the preset, as the user writes it after `--preset`.
    pub name: &'static str,
    /// The content of the preset's TOML file: the settings that it changes. Its leading comment describes the purpose of the
    /// preset.
    pub text: &'static str,
}

/// All presets of this build, in the order in which the command `headwater presets` lists them.
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

/// The name of the preset that commands and [`RendererBuilder`](super::RendererBuilder) use if the user selects none.
pub const DEFAULT: &str = "balanced";

impl Preset {
    /// Finds the preset with the name `name`.
    ///
    /// # Errors
    /// No preset has this name; the message lists the existing names and suggests the nearest one.
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

    /// The purpose of the preset, as one line of text for the command `headwater presets`: the lines of the comment at the
    /// beginning of its TOML file, joined by spaces.
    pub fn purpose(&self) -> String {
        self.text
            .lines()
            .map_while(|line| line.strip_prefix("# "))
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// The complete settings of the preset: the default settings with the preset's changes.
    ///
    /// # Errors
    /// The text of the preset is not valid TOML, or has an unknown key or a value out of range. A test checks that all
    /// presets of this build are valid.
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
