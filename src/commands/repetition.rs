//! Writes the command line that renders a picture again: the options of the view, the settings, and further
//! options, quoted for a shell.

use super::arguments::ViewArgs;
use super::choices::JitterArg;
use crate::base::shell_word::quoted;
use clap::ValueEnum;
use clap::builder::PossibleValue;

/// The command line of `headwater render` with all options of the view `view` except the seed, and with the
/// options `settings`. `fps` is the number of frames per second if the scene moves; `None` leaves the option
/// out.
pub fn of_view(view: &ViewArgs, settings: &str, fps: Option<f64>) -> String {
    let mut command = format!(
        "headwater render {} {settings} --bounces {}",
        quoted(&view.scene),
        view.bounces
    );
    let mut add = |option: &str, value: Option<String>| {
        if let Some(value) = value {
            command += &format!(" --{option} {value}");
        }
    };
    add("environment", view.environment.as_deref().map(quoted));
    add("camera", view.camera.as_deref().map(quoted));
    add("look-at", view.look_at.as_deref().map(quoted));
    add(
        "aperture",
        (view.aperture != 0.0).then(|| view.aperture.to_string()),
    );
    add("focus", view.focus.map(|focus| focus.to_string()));
    add(
        "material-variant",
        view.load.material_variant.as_deref().map(quoted),
    );
    add("width", view.width.map(|width| width.to_string()));
    add("height", view.height.map(|height| height.to_string()));
    add(
        "start-time",
        (view.start_time != 0.0).then(|| view.start_time.to_string()),
    );
    add("device", view.device.as_deref().map(quoted));
    add("fps", fps.map(|fps| fps.to_string()));
    let name = |choice: Option<PossibleValue>| choice.map(|choice| choice.get_name().to_owned());
    let variant = &view.variant;
    add(
        "tracer",
        name(variant.tracer.to_possible_value()).filter(|name| name != "auto"),
    );
    add(
        "geometry",
        name(variant.geometry.to_possible_value()).filter(|name| name != "auto"),
    );
    add(
        "textures",
        name(variant.textures.to_possible_value()).filter(|name| name != "auto"),
    );
    add(
        "jitter",
        (view.jitter == JitterArg::Off).then(|| "off".to_owned()),
    );
    for (option, is_given) in [
        ("allow-missing", view.load.allow_missing),
        ("allow-outside", view.load.allow_outside),
    ] {
        if is_given {
            command += &format!(" --{option}");
        }
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        view: ViewArgs,
    }

    #[test]
    fn options_of_loading_are_repeated() {
        let words = [
            "_",
            "a.glb",
            "--allow-missing",
            "--material-variant",
            "by night",
            "--width=9",
            "--jitter=off",
            "--aperture=0.05",
            "--focus=2.5",
        ];
        let Line { view } = Line::parse_from(words);
        assert_eq!(
            of_view(&view, "--preset fast", None),
            "headwater render a.glb --preset fast --bounces 5 --aperture 0.05 --focus 2.5 --material-variant 'by night' --width 9 --jitter off --allow-missing"
        );
    }
}
