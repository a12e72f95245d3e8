//! Presets: named TOML files that are compiled into the program. A preset contains only the settings whose values differ
//! from the defaults. The user selects a preset by its name.

use super::settings::{Settings, flatten};
use crate::base::nearest::nearest;
use crate::base::shell_word::quoted;
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
    /// The TOML file of the preset, as text: first a comment that describes the purpose of the preset, then the settings
    /// that the preset changes.
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
        // Plans of studies need these settings once per configuration, so parsed presets are stored.
        static PARSED: LazyLock<HashMap<&str, Settings>> = LazyLock::new(|| {
            let pair = |preset: &Preset| Some((preset.name, preset.parse().ok()?));
            PRESETS.iter().filter_map(pair).collect()
        });
        match PARSED.get(self.name) {
            Some(settings) => Ok(settings.clone()),
            None => self.parse(),
        }
    }

    /// Returns the settings in `settings` whose values differ from the preset: pairs of the dotted key, such as
    /// `direct.spatial.radius`, and the value in `settings`. Empty if no value differs.
    ///
    /// # Errors
    /// As for [`Self::settings`].
    pub fn differences(&self, settings: &Settings) -> Result<Vec<(String, Value)>> {
        let (mut changed, mut others) = (Vec::new(), Vec::new());
        flatten("", &settings.to_value()?, &mut changed);
        flatten("", &self.settings()?.to_value()?, &mut others);
        changed.retain(|setting| !others.contains(setting));
        Ok(changed)
    }

    fn parse(&self) -> Result<Settings> {
        Settings::default().with(&TomlText::new(self.name, self.text).parse::<Value>()?)
    }
}

/// Returns the settings in `settings` whose values differ from the default preset, as TOML text with one line per
/// setting: its dotted key, `=`, and its value. The option `--config` reads a file with this text.
///
/// # Errors
/// As for [`Preset::settings`].
pub fn changes(settings: &Settings) -> Result<String> {
    let changed = Preset::named(DEFAULT)?.differences(settings)?;
    Ok((changed.iter()).fold(String::new(), |text, (key, value)| {
        text + &format!("{key} = {value}\n")
    }))
}

/// Returns command-line options that give `settings`: first `--preset NAME`, with the preset from which the fewest
/// settings differ, and then `--set KEY=VALUE` for each setting that differs. Pages of results show these options.
///
/// # Errors
/// As for [`Preset::settings`].
pub fn options(settings: &Settings) -> Result<String> {
    let mut nearest: Option<(&str, Vec<(String, Value)>)> = None;
    for preset in PRESETS {
        let changed = preset.differences(settings)?;
        if (nearest.as_ref()).is_none_or(|(_, others)| changed.len() < others.len()) {
            nearest = Some((preset.name, changed));
        }
    }
    let (name, changed) = nearest.unwrap_or((DEFAULT, Vec::new()));
    Ok(changed
        .into_iter()
        .fold(format!("--preset {name}"), |text, (key, value)| {
            let value = value.as_str().map_or(value.to_string(), str::to_owned);
            text + &format!(" --set {}", quoted(&format!("{key}={value}")))
        }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_name_the_nearest_preset_and_what_differs() {
        for preset in PRESETS {
            let options = options(&preset.settings().unwrap()).unwrap();
            assert_eq!(options, format!("--preset {}", preset.name));
        }
        let fast = Preset::named("fast").unwrap().settings().unwrap();
        let changes = serde_json::json!({ "direct.visibility": "none" });
        let settings = fast.with(&changes).unwrap();
        let wanted = "--preset fast --set direct.visibility=none";
        assert_eq!(options(&settings).unwrap(), wanted);
        let default = Preset::named(DEFAULT).unwrap().settings().unwrap();
        assert_eq!(super::changes(&default).unwrap(), "");
        let text = super::changes(&default.with(&changes).unwrap()).unwrap();
        assert_eq!(text, "direct.visibility = \"none\"\n");
    }

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
