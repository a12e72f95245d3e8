//! Settings: a file of `--config`, over the default preset.

use crate::{checked, is_thorough};
use headwater::base::toml_text::TomlText;
use headwater::render::presets::{DEFAULT, Preset};
use headwater::render::settings::Settings;
use serde_json::Value;
use std::sync::LazyLock;

static PRESET: LazyLock<Settings> = LazyLock::new(|| {
    let preset = Preset::named(DEFAULT).and_then(Preset::settings);
    preset.expect("the default preset")
});

pub fn run(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let source = TomlText::new("a.toml", text);
    let Some(changes) = checked(source.parse::<Value>()) else {
        return;
    };
    if let Some(settings) = checked(PRESET.with_toml(&source, &[], &changes)) {
        let tree = settings.to_value().expect("settings are JSON");
        // Reads the tree once for each of its keys.
        if is_thorough(bytes) {
            let again = Settings::default().with(&tree);
            assert_eq!(
                again.as_ref().expect("settings that were read are valid"),
                &settings
            );
        }
        let again: Settings = serde_json::from_value(tree).expect("settings that were read");
        assert_eq!(again, settings);
    }
}

pub use crate::has_key as has_header;
