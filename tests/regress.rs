//! Tests that `regress` passes on the driver that made its golden frames, and names the pass in which a fault is planted.

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use support::{planted, said, takes_largest};

/// The case in which most faults are planted. The tests do not use all cases, because compiling their shaders takes minutes.
const SOME: &str = "cornell-accurate";
const WORLD: &str = "world-reservoirs";

fn regress(folder: &Path, arguments: &[&str], shaders: Option<&Path>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command
        .arg("regress")
        .arg(folder.join("golden"))
        .args(arguments);
    command.arg("--output").arg(folder.join("failures"));
    // Whether it validates is for `--validate` to say.
    command.env_remove("HEADWATER_VALIDATION");
    if let Some(shaders) = shaders {
        command.env("HEADWATER_GLSL", shaders);
    }
    command.output().unwrap()
}

fn assert_status(output: &Output, status: i32, expected: &str) {
    let said = said(output);
    assert_eq!(output.status.code(), Some(status), "{said}");
    assert!(said.contains(expected), "no '{expected}' in: {said}");
}

/// Makes the golden frames of these cases; `cases` are arguments of `regress`, and no arguments mean all cases.
fn bless(folder: &Path, cases: &[&str]) {
    let output = regress(folder, &[&["--bless"], cases].concat(), None);
    assert_status(&output, 0, "golden frames of");
    println!("{}", said(&output));
}

/// On the first driver, all cases must render to the same bits twice. On later drivers, they must agree with the golden
/// frames of the first.
#[test]
fn every_case_passes() {
    if !takes_largest() {
        return;
    }
    let own = tempfile::tempdir().unwrap();
    let (shared, drivers_before) = support::other_drivers();
    let folder = shared.as_deref().unwrap_or(own.path());
    if drivers_before == 0 {
        bless(folder, &[]);
    }
    let output = regress(folder, &[], None);
    println!("{}", said(&output));
    assert_status(&output, 0, " 0 failed");
    let others = said(&output).contains("golden frames of another driver");
    assert_eq!(others, drivers_before > 0);
    assert!(!folder.join("failures").exists());
}

/// A crash of the driver ends the program as SIGKILL does. The report must then still name the case that was running.
fn assert_a_killed_program_is_reported(folder: &Path, junit: &Path) {
    std::fs::remove_file(junit).unwrap();
    let mut running = Command::new(env!("CARGO_BIN_EXE_headwater"))
        .arg("regress")
        .arg(folder.join("golden"))
        .args(["--only", SOME, "--junit"])
        .arg(junit)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while !junit.exists() {
        assert!(running.try_wait().unwrap().is_none(), "it wrote no report");
        std::thread::sleep(Duration::from_millis(1));
    }
    running.kill().unwrap();
    running.wait().unwrap();
    let xml = std::fs::read_to_string(junit).unwrap();
    assert!(
        xml.contains("errors=\"1\"") && xml.contains("the program ended while this case ran"),
        "{xml}"
    );
}

/// Damaged golden frames must be reported as an error of the golden frames, not of the driver.
fn assert_damage_is_named(folder: &Path) {
    let golden = folder.join("golden");
    let own = golden.read_dir().unwrap().next().unwrap().unwrap().path();
    let list = own.join("golden.json");
    let text = std::fs::read_to_string(&list).unwrap();
    let picture = own.join(format!("{SOME}.exr"));
    let bytes = std::fs::read(&picture).unwrap();
    let only = ["--only", SOME];

    let edited = text.replace(
        "--width 48 --height 36 --bounces 3 --frames 3 --preset accurate --aov",
        "--width 49 --aov",
    );
    assert_ne!(edited, text);
    std::fs::write(&list, edited).unwrap();
    assert_status(&regress(folder, &only, None), 2, "other arguments");
    std::fs::write(&list, &text[..text.len() / 2]).unwrap();
    assert_status(
        &regress(folder, &only, None),
        2,
        "golden.json: it is damaged",
    );
    std::fs::remove_file(&list).unwrap();
    let made = Command::new("mkfifo").arg(&list).status().unwrap();
    assert!(made.success());
    assert_status(
        &regress(folder, &only, None),
        2,
        "golden.json: it is a pipe",
    );
    std::fs::remove_file(&list).unwrap();
    std::fs::write(&list, &text).unwrap();
    std::fs::write(&picture, &bytes[..bytes.len() - 100]).unwrap();
    assert_status(
        &regress(folder, &only, None),
        2,
        "the golden picture is damaged",
    );
    std::fs::write(&picture, &bytes).unwrap();
    assert_status(&regress(folder, &only, None), 0, "1 cases");

    // Those of another revision are compared all the same.
    let mut other: serde_json::Value = serde_json::from_str(&text).unwrap();
    other["commit"] = "0123456".into();
    std::fs::write(&list, other.to_string()).unwrap();
    let compared = regress(folder, &only, None);
    assert_status(&compared, 0, "1 cases");
    let said = said(&compared);
    assert!(said.contains("revision 0123456 of Headwater"), "{said}");
    std::fs::write(&list, &text).unwrap();

    // Those of another driver: pictures agree, and nothing is said about passes.
    std::fs::rename(&own, golden.join("another-driver")).unwrap();
    assert_status(
        &regress(folder, &only, None),
        0,
        "golden frames of another driver",
    );

    assert_status(
        &regress(folder, &["--only", "nothing"], None),
        2,
        "no case has 'nothing'",
    );
    assert_status(&regress(&folder.join("empty"), &only, None), 2, "empty");
    let file = folder.join("file");
    std::fs::write(&file, "").unwrap();
    std::fs::rename(&golden, folder.join("kept")).unwrap();
    std::fs::write(&golden, "no folder").unwrap();
    assert_status(&regress(folder, &["--bless"], None), 1, "golden");
    assert_eq!(std::fs::read_to_string(&golden).unwrap(), "no folder");
}

/// Path of the source file that records passes.
const RECORDING: &str = "src/gpu/recording.rs";

/// The text of [`RECORDING`] without the barriers between passes.
fn without_barriers() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(RECORDING);
    let text = std::fs::read_to_string(path).unwrap();
    let begin = "        commands.begin(pass.name(), pass.is_first_run());\n";
    let barrier = format!("        commands.barrier();\n{begin}");
    assert_eq!(text.matches(&barrier).count(), 1);
    text.replace(&barrier, begin)
}

/// Builds the program in a folder with `recording` as the text of [`RECORDING`], and returns the path of its binary.
/// Dependencies are linked from the build of the tests, so that only the crate itself is compiled.
fn program_without_barriers(folder: &Path, recording: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = Path::new(env!("CARGO_BIN_EXE_headwater"));
    let script = r#"
        cd "$1"
        git ls-files -z --cached --others --exclude-standard | xargs -0 cp --parents -t "$2"
        mkdir -p "$2/target/release"
        for part in deps build .fingerprint; do cp -al "$3/$part" "$2/target/release/"; done
        # Without the crate's own files: they are hard links, and the build would overwrite those of the tests.
        rm -rf "$2"/target/release/{build,.fingerprint}/headwater-* "$2"/target/release/deps/{,lib}headwater-*
    "#;
    let status = Command::new("bash")
        .args(["-ec", script, "bash"])
        .args([root, folder, program.parent().unwrap()])
        .status()
        .unwrap();
    assert!(status.success());
    std::fs::write(folder.join(RECORDING), recording).unwrap();
    let built = Command::new("cargo")
        .args([
            "build",
            "--quiet",
            "--release",
            "--bin",
            "headwater",
            "--target-dir",
        ])
        .arg(folder.join("target"))
        .current_dir(folder)
        .status()
        .unwrap();
    assert!(built.success());
    folder.join("target/release/headwater")
}

/// Software drivers finish a pass before they begin the next one, so the picture cannot show a missing barrier.
/// Synchronization validation must find it.
#[test]
fn a_missing_barrier_is_found_by_validation() {
    // The fault fits the code at any time, not only where it is built.
    let recording = without_barriers();
    if !takes_largest() {
        return;
    }
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let program = program_without_barriers(folder.path(), &recording);
    let golden = folder.path().join("golden");
    let only = ["--only", SOME];
    bless(folder.path(), &only);
    assert_status(
        &regress(folder.path(), &[&["--validate"], &only[..]].concat(), None),
        0,
        "1 ok",
    );
    let output = Command::new(program)
        .arg("regress")
        .arg(golden)
        .args(only)
        .arg("--validate")
        .env_remove("HEADWATER_VALIDATION")
        .output()
        .unwrap();
    // The message names the buffer and the pipeline of the pass that reads too early.
    assert_status(&output, 1, "SYNC-HAZARD-READ-AFTER-WRITE");
    assert_status(&output, 1, "[pilots]");
}

mod thorough {
    use super::*;

    /// One test does all steps, since all of them need golden frames, which take long to make.
    #[test]
    fn golden_frames_hold_until_a_fault_is_planted() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        bless(folder, &["--only", SOME]);
        bless(folder, &["--only", WORLD]);
        let junit = folder.join("junit.xml");
        let with_junit = |case| ["--only", case, "--junit", junit.to_str().unwrap()];
        for case in [SOME, WORLD] {
            let output = regress(folder, &with_junit(case), None);
            println!("{}", said(&output));
            assert_status(&output, 0, " 0 failed");
            assert!(!folder.join("failures").exists());
            let xml = std::fs::read_to_string(&junit).unwrap();
            assert!(
                xml.contains("<testsuites") && xml.contains(case) && xml.contains("failures=\"0\""),
                "{xml}"
            );
        }

        // A merge that forgets the Jacobian, a reservoir whose confidence is wrong as it is packed, and a world reservoir, which
        // shaders may write by address, with a wrong weight: each is seen first where its pass writes.
        for (case, scene, change, pass) in [
            (
                SOME,
                "cornell",
                (
                    "restir/samples/path_sample.glsl",
                    "vec3(solid_angle), pdf_solid_angle",
                    "vec3(1.0), pdf_solid_angle",
                ),
                "_indirect wrote different reservoirs",
            ),
            (
                SOME,
                "cornell",
                (
                    "restir/reservoir.glsl",
                    "p.words[HISTORY_WORD] = min(uint(r.confidence)",
                    "p.words[HISTORY_WORD] = 2u + min(uint(r.confidence)",
                ),
                "frame 0: pass initial_direct wrote different reservoirs",
            ),
            (
                WORLD,
                "night-city",
                (
                    "world_reservoirs/world_reservoirs.glsl",
                    "GpuWorldSample(reservoir.contribution_weight,",
                    "GpuWorldSample(1.01 * reservoir.contribution_weight,",
                ),
                "frame 0: pass initial_indirect wrote different world_samples",
            ),
        ] {
            let shaders = tempfile::tempdir().unwrap();
            planted(&shaders.path().join("glsl"), &[change]);
            let output = regress(
                folder,
                &with_junit(case),
                Some(&shaders.path().join("glsl")),
            );
            println!("{}", said(&output));
            assert_status(&output, 1, pass);
            assert!(
                said(&output).contains(&format!("again: headwater render {scene}")),
                "{}",
                said(&output)
            );
            for file in [".exr", "-golden.exr", "-difference.png"] {
                assert!(
                    folder.join(format!("failures/{case}{file}")).is_file(),
                    "{file}"
                );
            }
            let xml = std::fs::read_to_string(&junit).unwrap();
            assert!(xml.contains("<failure") && xml.contains(pass), "{xml}");
        }
        assert_a_killed_program_is_reported(folder, &junit);
        assert_damage_is_named(folder);
    }
}
