//! Settings: a file of `--config`, over the default preset.

use crate::checked;
use headwater::render::presets::{DEFAULT, Preset};
use headwater::render::settings::Settings;
use headwater::toml_text::TomlText;
use std::sync::LazyLock;

static PRESET: LazyLock<Settings> = LazyLock::new(|| {
    let preset = Preset::named(DEFAULT).and_then(Preset::settings);
    preset.expect("the default preset")
});

/// Loads the file, and checks what its loader promises; whether it is TOML.
pub fn run(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else {
        return false;
    };
    let source = TomlText::new("a.toml", text);
    let Some(changes) = checked(source.parse()) else {
        return false;
    };
    if let Some(settings) = checked(PRESET.with_toml(&source, &[], &changes)) {
        let tree = settings.to_value().expect("settings are JSON");
        let again = Settings::default().with(&tree);
        assert_eq!(again.expect("settings that were read are valid"), settings);
    }
    true
}
