//! The plans of studies that are part of the program, so that users can repeat the measurements of the
//! documentation by the name of a plan.

/// The plans of studies that are part of the program, in alphabetical order. Each is a pair of its name, which the option
/// `--plan` takes, and its TOML text.
pub const PLANS: &[(&str, &str)] = &[
    ("bias-matrix", include_str!("plans/bias-matrix.toml")),
    ("bias-sample", include_str!("plans/bias-sample.toml")),
    ("confidence-cap", include_str!("plans/confidence-cap.toml")),
    ("contrast", include_str!("plans/contrast.toml")),
    ("contrast-paths", include_str!("plans/contrast-paths.toml")),
    ("direct-layouts", include_str!("plans/direct-layouts.toml")),
    ("direct-light", include_str!("plans/direct-light.toml")),
    ("extremes", include_str!("plans/extremes.toml")),
    ("frame-times", include_str!("plans/frame-times.toml")),
    ("indirect-light", include_str!("plans/indirect-light.toml")),
    (
        "indirect-matrix",
        include_str!("plans/indirect-matrix.toml"),
    ),
    (
        "indirect-motion",
        include_str!("plans/indirect-motion.toml"),
    ),
    (
        "indirect-sample",
        include_str!("plans/indirect-sample.toml"),
    ),
    ("jacobian-limit", include_str!("plans/jacobian-limit.toml")),
    ("light-samples", include_str!("plans/light-samples.toml")),
    ("many-lights", include_str!("plans/many-lights.toml")),
    ("mirrors", include_str!("plans/mirrors.toml")),
    ("motion", include_str!("plans/motion.toml")),
    ("moving-frames", include_str!("plans/moving-frames.toml")),
    (
        "neighbour-confidence",
        include_str!("plans/neighbour-confidence.toml"),
    ),
    (
        "neighbour-radius",
        include_str!("plans/neighbour-radius.toml"),
    ),
    ("path-lights", include_str!("plans/path-lights.toml")),
    ("presets", include_str!("plans/presets.toml")),
    ("rare-lights", include_str!("plans/rare-lights.toml")),
    ("roulette", include_str!("plans/roulette.toml")),
    ("shift", include_str!("plans/shift.toml")),
    ("shift-history", include_str!("plans/shift-history.toml")),
    ("world-matrix", include_str!("plans/world-matrix.toml")),
];
