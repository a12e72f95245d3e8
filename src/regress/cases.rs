//! The cases of the regression tests: the pictures that are rendered and compared. Arguments of the command
//! `render` define each case.

use crate::Result;
use crate::base::toml_text::TomlText;
use serde::Deserialize;

/// One test case: the frame, or the short sequence of frames, that the command `render` makes from given arguments.
/// `headwater regress` renders it, and compares the result with the golden frame (the stored result of a trusted driver).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// The name of the case, by which its golden frame is found and `--only` selects cases. The names of its picture files
    /// consist of this name and an ending such as `.exr`.
    pub name: String,
    /// The arguments of the command `render` that make the picture, separated by spaces, as `cases.toml` and golden frames
    /// contain them. `--output` is missing, because each caller adds its own; so is `--jitter off`, which
    /// [`Self::command`] adds.
    pub arguments: String,
}

impl Case {
    /// The arguments with which the command `render` makes the picture, separated by spaces. The camera's rays pass through
    /// the centres of pixels unless the case says otherwise, so that the bits of golden frames do not depend on the default of
    /// `--jitter`.
    pub fn command(&self) -> String {
        let mut words = self.arguments.split(' ');
        if words.any(|word| word == "--jitter") {
            self.arguments.clone()
        } else {
            format!("{} --jitter off", self.arguments)
        }
    }
}

/// All cases of the file `cases.toml`, in the order in which they are listed and run. `headwater regress` renders them all,
/// or those that `--only` selects.
///
/// # Errors
/// The text of `cases.toml`, which is compiled into the program, is not valid; a test excludes this.
pub fn cases() -> Result<Vec<Case>> {
    #[derive(Deserialize)]
    struct List {
        cases: Vec<Case>,
    }
    let text = TomlText::new("cases.toml", include_str!("cases.toml"));
    Ok(text.parse::<List>()?.cases)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;
    use crate::render::presets;
    use std::collections::BTreeSet;

    /// The choices of a user of the renderer that the regression tests must cover, as parts of command lines, such as
    /// `--preset fast`. A test checks that each of them occurs in the arguments of at least one case. Without a case, a
    /// fault of a driver with this choice would stay unnoticed.
    fn choices() -> Vec<String> {
        let presets = presets::PRESETS
            .iter()
            .map(|preset| format!("--preset {}", preset.name));
        let tracers = ["ray-query", "compute-bvh"].map(|name| format!("--tracer {name}"));
        let geometry = ["storage-buffers", "buffer-addresses"].map(|n| format!("--geometry {n}"));
        let textures = ["images", "buffer"].map(|name| format!("--textures {name}"));
        // Every value of these, and some of others.
        let described = Settings::default().describe().unwrap();
        let all = [
            "direct.mis",
            "indirect.mis",
            "direct.visibility",
            "reservoirs.format",
            "reservoirs.arrays",
        ];
        let all = all.map(|key| {
            let setting = described.iter().find(|setting| setting.key == key).unwrap();
            (key, setting.values.split(" | ").map(String::from).collect())
        });
        let some = [
            ("reservoirs.order", "row column swizzle:4"),
            ("direct.candidates", "uniform power light-bvh hash-grid"),
            ("indirect.candidates", "power light-bvh"),
            ("indirect.mode", "off path"),
            ("indirect.secondary", "power world-reservoirs"),
            ("environment.intensity", "1000000 1e-30"),
            ("variant", "full"),
            ("energy", "compensated"),
        ];
        let some = some.map(|(key, values)| (key, values.split(' ').map(String::from).collect()));
        let keys: Vec<(&str, Vec<String>)> = all.into_iter().chain(some).collect();
        let settings = keys.into_iter().flat_map(|(key, values)| {
            values
                .into_iter()
                .map(move |value| format!("--set {key}={value}"))
        });
        let flags = [
            "--fps 24",
            "--jitter",
            "--accumulate",
            "--aov direct,indirect",
        ];
        presets
            .chain(tracers)
            .chain(geometry)
            .chain(textures)
            .chain(settings)
            .chain(flags.map(String::from))
            .collect()
    }

    #[test]
    fn every_choice_is_made_in_some_case() {
        let cases = cases().unwrap();
        assert!(cases.len() >= 40, "{}", cases.len());
        let names: BTreeSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
        assert_eq!(names.len(), cases.len(), "two cases have one name");
        for choice in choices() {
            // Whole words: direct.mis=balance is not indirect.mis=balance.
            let has =
                |case: &Case| format!(" {} ", case.arguments).contains(&format!(" {choice} "));
            assert!(cases.iter().any(has), "{choice}");
        }
    }
}
