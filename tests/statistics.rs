//! Tests that a shader which wastes registers is found, and that commands which render refuse a device that can only
//! compile.

mod support;

use headwater::profile::statistics;
use headwater::shader_interface::compiler;
use std::collections::BTreeSet;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use support::{planted, said};

/// Exit status of `tools/null-gpu` on a machine without the driver RADV.
const NO_RADV: i32 = 3;

/// Runs Headwater with RADV as its only device, for a GPU that does not exist; `None` without RADV. `glsl` is a folder of
/// changed shaders.
fn on_null_gpu(arguments: &[&str], glsl: Option<&Path>) -> Option<Output> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let environment = Command::new(root.join("tools/null-gpu"))
        .arg("navi31")
        .output()
        .unwrap();
    if environment.status.code() == Some(NO_RADV) {
        // Past the test runner, which shows what a test prints only where it fails.
        let _ = write!(
            std::io::stderr(),
            "note: not tested: {}",
            said(&environment)
        );
        return None;
    }
    assert!(environment.status.success(), "{}", said(&environment));
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

/// Rendering on such a device would crash the driver when commands are recorded, so Headwater must refuse it.
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

/// The stored statistics must cover exactly the passes that exist, for both tracers, on each device.
#[test]
fn every_pass_has_stored_values() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stored = statistics::read(&root.join("tests/measurements/gpu-statistics.json")).unwrap();
    let made: BTreeSet<[&str; 3]> = (stored.iter())
        .map(|one| [&one.device, &one.tracer, &one.pass].map(String::as_str))
        .collect();
    let devices: BTreeSet<&str> = stored.iter().map(|one| one.device.as_str()).collect();
    assert!(devices.len() >= 2, "{devices:?}");
    let sources = compiler::read_folder(&root.join("glsl")).unwrap();
    let passes: Vec<&str> = compiler::passes(&sources).map(|(pass, _)| pass).collect();
    assert!(passes.len() > 20, "{passes:?}");
    for pass in passes {
        for device in &devices {
            for tracer in ["compute-bvh", "ray-query"] {
                let one = [*device, tracer, pass];
                assert!(made.contains(&one), "nothing is stored of {one:?}");
            }
        }
    }
}

/// Runs a copy of `tools/gpu-statistics` in which scripts replace the tools that it calls.
fn gpu_statistics(folder: &Path, null_gpu: &str, run: &str, arguments: &[&str]) -> Output {
    let tools = folder.join("tools");
    std::fs::create_dir_all(&tools).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/gpu-statistics");
    std::fs::copy(source, tools.join("gpu-statistics")).unwrap();
    for (name, script) in [("null-gpu", null_gpu), ("run", run)] {
        let path = tools.join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
    }
    let mut command = Command::new(tools.join("gpu-statistics"));
    command.args(arguments).output().unwrap()
}

/// Without the environment of the null GPU, `statistics` would compile for another device, so the tool must stop.
#[test]
fn nothing_is_compiled_where_there_is_no_gpu_to_compile_for() {
    let folder = tempfile::tempdir().unwrap();
    let compiles = "echo compiled";
    for (null_gpu, arguments, status) in [
        ("exit 1", &[][..], 1),
        ("exit 1", &["--check"], 1),
        ("exit 3", &[], 1),
        ("exit 3", &["--check"], 0),
    ] {
        let output = gpu_statistics(folder.path(), null_gpu, compiles, arguments);
        let text = said(&output);
        let what = format!("{null_gpu}, {arguments:?}: {text}");
        assert_eq!(output.status.code(), Some(status), "{what}");
        assert!(!text.contains("compiled"), "{what}");
        assert_eq!(
            text.contains("not compared: no RADV"),
            status == 0,
            "{what}"
        );
    }
}

#[test]
fn the_file_of_a_check_that_fails_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.json");
    let output = |options: &[&str], run: &str| {
        let arguments = [options, &["-o", file.to_str().unwrap()]].concat();
        gpu_statistics(folder.path(), "exit 0", run, &arguments)
    };
    let writes = r#"while [ "$1" != -o ]; do shift; done; echo [1] >"$2"; exit"#;
    for (options, status, kept) in [
        (&["--check"][..], 1, true),
        (&["--check"], 2, false),
        (&[], 1, false),
        (&[], 0, true),
        (&["--store"], 2, false),
    ] {
        let _ = std::fs::remove_file(&file);
        let output = output(options, &format!("{writes} {status}"));
        let what = format!("{options:?}, {status}: {}", said(&output));
        assert_eq!(output.status.code(), Some(status), "{what}");
        let content = std::fs::read_to_string(&file).unwrap_or_default();
        assert_eq!(content == "[1]\n", kept, "{what}");
    }
}

mod thorough {
    use super::*;

    /// An array with computed indices lies in scratch memory; the check of the command must find this, and in that pass
    /// alone.
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
        planted(&shaders, &[("restir/passes/surfaces.comp", stores, wastes)]);
        let output = on_null_gpu(&against, Some(&shaders)).unwrap();
        let text = said(&output);
        println!("{text}");
        assert_eq!(output.status.code(), Some(1), "{text}");
        let worse = || text.lines().filter(|line| line.starts_with("worse "));
        assert!(worse().any(|line| line.contains("scratch_bytes")), "{text}");
        assert!(worse().all(|line| line.contains(" surfaces (")), "{text}");
    }
}
