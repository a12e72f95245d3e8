//! Is a shader that wastes registers found, and is a device that only compiles refused by what renders?

mod support;

use headwater::profile::statistics;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};
use support::{planted, said};

/// Runs Headwater with RADV for a GPU that is not there as its only device; `None` where there is no RADV.
fn on_null_gpu(arguments: &[&str], glsl: Option<&Path>) -> Option<Output> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let environment = Command::new(root.join("tools/null-gpu"))
        .arg("navi31")
        .output()
        .unwrap();
    if !environment.status.success() {
        println!("note: not tested: {}", said(&environment));
        return None;
    }
    let mut command = Command::new("bash");
    let script = r#"eval "$1"; shift; exec "$@""#;
    command.args([
        "-c",
        script,
        "bash",
        &String::from_utf8(environment.stdout).unwrap(),
    ]);
    command.arg(env!("CARGO_BIN_EXE_headwater")).args(arguments);
    if let Some(folder) = glsl {
        command.env("HEADWATER_GLSL", folder);
    }
    Some(command.output().unwrap())
}

/// The driver itself would crash where commands are recorded.
#[test]
fn what_renders_refuses_a_device_whose_memory_cannot_be_mapped() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.exr");
    let picture = picture.to_str().unwrap();
    let inside = folder.path().join("inside");
    let inside = inside.to_str().unwrap();
    for arguments in [
        &["profile", "cornell"][..],
        &["render", "cornell", "-o", picture],
        &["reference", "cornell", "-o", picture, "--spp", "1"],
        &["study", "cornell", "--quick", "-o", inside],
        &["regress", inside, "--bless"],
    ] {
        let Some(output) = on_null_gpu(arguments, None) else {
            return;
        };
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
        let last = text.trim_end().lines().last().unwrap_or_default();
        assert!(last.contains("cannot be mapped"), "{arguments:?}: {text}");
        assert!(!Path::new(picture).exists(), "{arguments:?}");
    }
}

/// The stored values are those of every pass, for both tracers, on each device.
#[test]
fn every_pass_has_stored_values() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stored = statistics::read(&root.join("tests/measurements/gpu-statistics.json")).unwrap();
    let made: BTreeSet<[&str; 3]> = (stored.iter())
        .map(|one| [&one.device, &one.tracer, &one.pass].map(String::as_str))
        .collect();
    let devices: BTreeSet<&str> = stored.iter().map(|one| one.device.as_str()).collect();
    assert!(devices.len() >= 2, "{devices:?}");
    for entry in std::fs::read_dir(root.join("glsl/passes")).unwrap() {
        let path = entry.unwrap().path();
        let pass = path.file_stem().unwrap().to_str().unwrap();
        for device in &devices {
            for tracer in ["compute-bvh", "ray-query"] {
                let one = [*device, tracer, pass];
                assert!(made.contains(&one), "nothing is stored of {one:?}");
            }
        }
    }
}

mod thorough {
    use super::*;

    /// An array with computed indices lies in scratch memory, which the check of the command finds, in that pass alone.
    #[test]
    fn a_shader_that_wastes_registers_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let stored = folder.path().join("stored.json");
        let stored = stored.to_str().unwrap();
        let command = ["statistics", "furnace", "--tracer", "ray-query"];
        let Some(output) = on_null_gpu(&[&command[..], &["-o", stored]].concat(), None) else {
            return;
        };
        assert!(output.status.success(), "{}", said(&output));
        let against = [&command[..], &["--against", stored]].concat();
        let output = on_null_gpu(&against, None).unwrap();
        assert!(output.status.success(), "{}", said(&output));

        let shaders = folder.path().join("glsl");
        let stores = "color.at[pixel_index(pixel)] = emission;";
        let wastes = "float wasted[256];
            for (uint i = 0u; i < 256u; i++) wasted[(7u * i + pixel.y) % 256u] = float(i);
            color.at[pixel_index(pixel)] = emission * wasted[pixel.x % 256u];";
        planted(&shaders, &[("passes/surfaces.comp", stores, wastes)]);
        let output = on_null_gpu(&against, Some(&shaders)).unwrap();
        let text = said(&output);
        println!("{text}");
        assert_eq!(output.status.code(), Some(1), "{text}");
        let worse = || text.lines().filter(|line| line.starts_with("worse "));
        assert!(worse().any(|line| line.contains("scratch_bytes")), "{text}");
        assert!(worse().all(|line| line.contains(" surfaces (")), "{text}");
    }
}
