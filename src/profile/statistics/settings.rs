//! The configurations (named settings) with which `headwater statistics` compiles the passes. Together they use every pass.

use crate::Result;
use crate::render::Settings;
use crate::render::presets::Preset;

/// A configuration: the settings of a preset, with some of them changed, under a name. `headwater statistics` compiles the
/// passes of every scene with each configuration, because the settings decide which passes there are and what their code is.
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    /// Name of the configuration (a set of settings) in tables and files of `headwater statistics`. A configuration that
    /// changes no setting of its preset has the name of the preset.
    pub name: &'static str,
    preset: &'static str,
    changes: &'static [&'static str],
}

/// The configurations with which `headwater statistics` compiles the passes: one for each preset, and three with passes that
/// no preset uses (those of other light samplers and of world reservoirs). Together they use every pass.
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

    /// The settings of the configuration: those of its preset, with its changes applied.
    ///
    /// # Errors
    /// The preset does not exist, or a change is not valid. This never happens with [`CONFIGURATIONS`], as a test checks.
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
