//! `presets`: prints the presets (named sets of settings), and every setting with its value, its range and its
//! description.

use super::print;
use crate::Result;
use crate::base::json::value_of;
use crate::render::presets::{DEFAULT, PRESETS, Preset};
use crate::render::settings::Settings;
use serde_json::json;

/// The command-line arguments of `headwater presets`, which select one preset or all, and the format of the text.
#[derive(clap::Args)]
pub struct Args {
    /// Show only this preset, and the values of all settings in it; without a name, all presets are shown, and all
    /// settings with their defaults
    name: Option<String>,
    /// Print the presets and settings as one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Prints one preset or all of them, and then every setting, as text or JSON.
///
/// # Errors
/// The preset is unknown, or stdout rejects the text.
pub fn run(args: &Args) -> Result<()> {
    let (shown, settings) = match &args.name {
        Some(name) => {
            let preset = Preset::named(name)?;
            (vec![preset], preset.settings()?)
        }
        None => (PRESETS.iter().collect(), Settings::default()),
    };
    let described = settings.describe()?;
    if args.json {
        let presets: Vec<_> = shown
            .iter()
            .map(
                |p| json!({ "name": p.name, "purpose": p.purpose(), "default": p.name == DEFAULT }),
            )
            .collect();
        let settings = value_of("settings", &described)?;
        print(format_args!(
            "{:#}",
            json!({ "presets": presets, "settings": settings })
        ))?;
        return Ok(());
    }
    for preset in shown {
        let default = if preset.name == DEFAULT {
            " (default)"
        } else {
            ""
        };
        print(format_args!(
            "{}{default}\n    {}",
            preset.name,
            preset.purpose()
        ))?;
    }
    print("")?;
    for setting in described {
        let value = setting
            .value
            .as_str()
            .map_or_else(|| setting.value.to_string(), str::to_owned);
        print(format_args!(
            "{} = {value}    [{}]\n    {}",
            setting.key, setting.values, setting.doc
        ))?;
    }
    Ok(())
}
