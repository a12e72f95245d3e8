//! Prints notes on stderr, one line each, about arguments that have no effect in combination with the other arguments,
//! so that the user does not expect one.

use super::arguments::{SceneArgs, ViewArgs};
use super::choices::TonemapArg;
use super::notice;
use crate::image::Format;
use crate::render::Settings;
use crate::render::settings::{
    Candidates, DirectMode, Far, Heuristic, IndirectMode, Integrator, Visibility,
};
use crate::scene_files::{NO_ENVIRONMENT, file_of};
use crate::shader_interface::{HashGrid, WorldReservoirs};
use std::path::PathBuf;

/// Keys of the settings that affect path tracing, or groups of keys: `environment` stands for all keys that begin with
/// `environment.`. All other settings have no effect on the command `reference`, and a note says so.
const OF_PATH_TRACING: [&str; 6] = [
    "heuristic",
    "energy",
    "roulette",
    "environment",
    "direct.mode",
    "variant",
];

/// The keys in the group `indirect` that have an effect with `indirect.mode=path`, which traces indirect light without
/// resampling. The other keys of the group have no effect in this mode, and a note tells the user so.
const OF_INDIRECT_PATHS: [&str; 4] = [
    "indirect.mode",
    "indirect.secondary",
    "indirect.candidates",
    "indirect.light_samples",
];

/// Prints notes on options of the scene and its view that have no effect, such as `--camera` together with
/// `--look-at`.
pub fn note_for_view(view: &ViewArgs) {
    if let (Some(camera), Some(_)) = (&view.camera, &view.look_at) {
        notice(&format!(
            "--look-at sets the camera, so --camera {camera} has no effect"
        ));
    }
    if view.aperture == 0.0 && view.focus.is_some() {
        notice("without --aperture, the camera is a pinhole, so --focus has no effect");
    }
    if file_of(&view.scene).is_none() {
        for (option, is_given) in [
            ("--allow-missing", view.load.allow_missing),
            ("--allow-outside", view.load.allow_outside),
            ("--material-variant", view.load.material_variant.is_some()),
        ] {
            if is_given {
                notice(&format!(
                    "a generated scene has no files, so {option} has no effect"
                ));
            }
        }
    }
}

/// Prints notes on arguments without effect, for every command that renders a scene. `changed` lists the dotted keys that
/// --config and --set name, and `outputs` lists the paths of the pictures. `presents` is true if frames are presented for
/// a capture tool; then --exposure has an effect even without a PNG file.
pub fn note_for_scene(args: &SceneArgs, changed: &[String], outputs: &[PathBuf], presents: bool) {
    if matches!(
        args.view.environment.as_deref(),
        None | Some(NO_ENVIRONMENT)
    ) {
        note_ignored("there is no --environment", changed, |key| {
            group(key) == "environment"
        });
    }
    note_for_view(&args.view);
    let writes = |format| {
        outputs
            .iter()
            .any(|path| Format::of(path).ok() == Some(format))
    };
    if !args.aov.is_empty() && !writes(Format::Exr) {
        notice("no --output is an .exr file, so --aov has no effect");
    }
    if args.exposure != 0.0 && !writes(Format::Png) && !presents {
        notice("no --output is a .png file, so --exposure has no effect");
    }
    if args.tonemap != TonemapArg::default() && !writes(Format::Png) {
        notice("no --output is a .png file, so --tonemap has no effect");
    }
}

/// Prints notes on settings that have no effect on the commands `render` and `profile`. `changed` lists the dotted keys
/// that --config and --set name; `bounces` is the maximum number of scattering events of a path.
pub fn note_for_render(changed: &[String], settings: &Settings, bounces: u32) {
    if settings.integrator == Integrator::PathTracing {
        note_ignored(
            "integrator=path-tracing does not resample",
            changed,
            |key| key != "integrator" && !is_of_path_tracing(key),
        );
        return;
    }
    // What `auto` becomes depends on the scene, which is not read yet.
    let scene_decides = settings.has_candidates(Candidates::Auto, bounces);
    if !settings.has_candidates(Candidates::LightBvh, bounces) && !scene_decides {
        note_ignored("no candidates=light-bvh", changed, |key| {
            group(key) == "light_bvh"
        });
    }
    if settings.hash_grid() == HashGrid::None {
        note_ignored("no direct.candidates=hash-grid", changed, |key| {
            group(key) == "hash_grid"
        });
    }
    note_parts_of_candidates(changed, settings, bounces);
    if settings.world_reservoirs() == WorldReservoirs::None {
        note_ignored("no indirect.secondary=world-reservoirs", changed, |key| {
            group(key) == "world_reservoirs"
        });
    }
    if settings.direct.mode == DirectMode::Off && bounces > 0 {
        note_ignored("direct.mode=off has no direct light", changed, |key| {
            group(key) == "direct" && key != "direct.mode"
        });
    }
    if settings.heuristic == Heuristic::Power {
        notice(
            "heuristic=power is for integrator=path-tracing; candidates share light by the balance heuristic",
        );
    }
    let is_indirect = |key: &str| {
        group(key) == "indirect"
            || group(key) == "world_reservoirs"
                && settings.world_reservoirs() != WorldReservoirs::None
    };
    match (bounces, settings.indirect.mode) {
        (0, _) => note_ignored("--bounces 0 shows emitted light only", changed, |key| {
            is_indirect(key) || group(key) == "direct"
        }),
        (1, _) => note_ignored("--bounces 1 has no indirect light", changed, is_indirect),
        (_, IndirectMode::Off) => {
            note_ignored("indirect.mode=off has no indirect light", changed, |key| {
                is_indirect(key) && key != "indirect.mode"
            });
        }
        (_, IndirectMode::Path) => {
            note_ignored("indirect.mode=path does not resample", changed, |key| {
                group(key) == "indirect" && !OF_INDIRECT_PATHS.contains(&key)
            });
        }
        (_, IndirectMode::Restir) => {}
    }
    if bounces > 0
        && settings.direct.resampling.visibility == Visibility::Final
        && settings.direct.bsdf_samples > 0
    {
        notice("direct.visibility=final takes light candidates only, so no BSDF samples are drawn");
    }
}

/// Prints notes on settings of the groups `light_bvh` and `hash_grid` that another setting makes ineffective. Both groups
/// describe how lights are drawn for candidates (the light samples from which resampling selects). If
/// `indirect.candidates=hash-grid` is set, a further note says that lights are drawn by their power instead, because the
/// hash grid does not support indirect light. `changed` lists the dotted keys that --config and --set name; `bounces` is
/// the maximum number of scattering events of a path.
fn note_parts_of_candidates(changed: &[String], settings: &Settings, bounces: u32) {
    if settings.has_candidates(Candidates::LightBvh, bounces) {
        if settings.light_bvh.far == Far::Joined {
            note_ignored(
                "light_bvh.far=joined has no boxes of influence",
                changed,
                |key| key == "light_bvh.boxes",
            );
        }
        if settings.light_bvh.tile == 1 {
            note_ignored(
                "with light_bvh.tile=1 no pixels share a list",
                changed,
                |key| key == "light_bvh.list",
            );
        }
    }
    match settings.hash_grid() {
        HashGrid::None => {}
        HashGrid::Pixels => note_ignored(
            "hash_grid.mode=unbiased measures cells in pixels",
            changed,
            |key| key == "hash_grid.cells",
        ),
        HashGrid::Points => note_ignored(
            "hash_grid.mode=published divides the scene and counts candidates",
            changed,
            |key| ["hash_grid.cell", "hash_grid.confidence"].contains(&key),
        ),
    }
    if settings.indirect.resampling.candidates == Candidates::HashGrid
        && changed.iter().any(|key| key == "indirect.candidates")
    {
        notice(
            "the hash grid holds direct light alone, so indirect.candidates=hash-grid draws by power",
        );
    }
}

/// Prints notes on a preset and on settings that have no effect on the command `reference`, because it path traces.
/// `changed` lists the dotted keys that --config and --set name.
pub fn note_for_reference(args: &SceneArgs, changed: &[String]) {
    if let Some(preset) = args.preset.as_deref().filter(|p| *p != "path-tracing") {
        notice(&format!(
            "a reference is path traced: of --preset {preset} it takes {} only",
            OF_PATH_TRACING.join(", ")
        ));
    }
    note_ignored("a reference is path traced", changed, |key| {
        !is_of_path_tracing(key)
    });
}

fn is_of_path_tracing(key: &str) -> bool {
    OF_PATH_TRACING.contains(&key) || OF_PATH_TRACING.contains(&group(key))
}

/// Prints one line that names all `changed` keys for which `is_ignored` is true; if there is no such key, prints nothing.
/// The line begins with `why`, the reason, such as "there is no --environment".
fn note_ignored(why: &str, changed: &[String], is_ignored: impl Fn(&str) -> bool) {
    let ignored: Vec<&str> = (changed.iter().map(String::as_str))
        .filter(|key| is_ignored(key))
        .collect();
    match ignored.as_slice() {
        [] => {}
        [key] => notice(&format!("{why}, so {key} has no effect")),
        keys => notice(&format!("{why}, so {} have no effect", keys.join(", "))),
    }
}

/// The part of a dotted key before its first dot, such as `direct` of `direct.mode`; the whole key if it has no dot.
fn group(key: &str) -> &str {
    key.split('.').next().unwrap_or(key)
}
