//! The settings for which the command `headwater statistics` compiles the passes; together they use every pass.

use crate::Result;
use crate::render::Settings;
use crate::render::presets::Preset;

/// Settings with a name: a preset with changes, for which the passes are compiled.
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    /// Name of the configuration in tables and files.
    pub name: &'static str,
    preset: &'static str,
    changes: &'static [&'static str],
}

/// The configurations for which `headwater statistics` compiles the passes: all presets, and settings that no preset
/// requests (other light samplers, and world reservoirs).
pub const CONFIGURATIONS: &[Configuration] = &[
    Configuration::preset("path-tracing"),
    Configuration::preset("fast"),
    Configuration::preset("balanced"),
    Configuration::preset("accurate"),
    Configuration::preset("s1"),
    Configuration {
        name: "light-bvh",
        preset: "accurate",
        changes: &[
            "direct.candidates=light-bvh",
            "indirect.candidates=light-bvh",
        ],
    },
    Configuration {
        name: "hash-grid",
        preset: "accurate",
        changes: &["direct.candidates=hash-grid"],
    },
    Configuration {
        name: "world-reservoirs",
        preset: "accurate",
        changes: &[
            "indirect.secondary=world-reservoirs",
            "world_reservoirs.min_lights=0",
        ],
    },
];

impl Configuration {
    const fn preset(name: &'static str) -> Self {
        Self {
            name,
            preset: name,
            changes: &[],
        }
    }

    /// The settings of the preset, with the changes of the configuration.
    ///
    /// # Errors
    /// Never with [`CONFIGURATIONS`], as a test checks.
    pub fn settings(&self) -> Result<Settings> {
        let mut settings = Preset::named(self.preset)?.settings()?;
        for change in self.changes {
            settings = settings.with(&Settings::parse_change(change)?)?;
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::presets::PRESETS;

    #[test]
    fn every_configuration_is_valid_and_every_preset_among_them() {
        for configuration in CONFIGURATIONS {
            configuration.settings().unwrap();
        }
        for preset in PRESETS {
            let mut all = CONFIGURATIONS.iter();
            assert!(all.any(|one| one.name == preset.name), "{}", preset.name);
        }
    }
}
