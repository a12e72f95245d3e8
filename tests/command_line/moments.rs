//! Tests that send SIGINT, SIGTERM and SIGKILL at many moments of a command. No output file is partly written, no temporary
//! file is left (except by SIGKILL), and the next run with the same arguments succeeds.
//!
//! `HEADWATER_SIGNAL_MOMENTS` is the number of moments per command; the three signals take turns.

use crate::{headwater, messages, text};
use headwater::image::Image;
use headwater::scene_files::load;
use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const SIGNALS: [i32; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGKILL];

/// The name of the command that does not handle signals, so that each signal kills it.
const UNWATCHED: &str = "scene generate";

/// A command under test; `$` in its arguments is replaced by its output folder.
struct Subject {
    name: &'static str,
    arguments: Vec<&'static str>,
    /// Arguments that write different outputs with the same names, which exist in the folder before the interrupted run.
    older: Vec<&'static str>,
    /// Names of output files that must have the same bytes after an interruption and a new run as without one.
    results: Vec<&'static str>,
}

impl Subject {
    /// A command that writes two pictures and a report; `arguments` begins with its name.
    fn of_pictures(arguments: &[&'static str]) -> Self {
        let outputs = ["-o", "$/a.exr", "-o", "$/a.png", "--report", "$/a.json"];
        let arguments = [arguments, &outputs].concat();
        Self {
            name: arguments[0],
            older: [&arguments[..], &["--seed", "5"]].concat(),
            arguments,
            results: vec!["a.exr", "a.png"],
        }
    }
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let arguments: Vec<String> = (arguments.iter())
        .map(|argument| argument.replace('$', text(folder)))
        .collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut command = headwater(&arguments);
    command.env("HEADWATER_SAVE_SECONDS", "0");
    command
}

fn succeed(folder: &Path, arguments: &[&str]) {
    let output = command(folder, arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {output:?}");
}

/// All files and folders below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let inner = |path: PathBuf| match path.is_dir() {
        true => [files(&path), vec![path]].concat(),
        false => vec![path],
    };
    paths.flat_map(inner).collect()
}

/// The paths of all files below a folder, relative to the folder.
fn names(folder: &Path) -> BTreeSet<PathBuf> {
    let names = files(folder).into_iter();
    names
        .map(|path| path.strip_prefix(folder).unwrap().to_owned())
        .collect()
}

/// Panics unless a file is complete: it must be readable in the format that its ending names.
fn assert_whole(path: &Path) {
    let extension = path.extension().and_then(|e| e.to_str());
    let content = || std::fs::read_to_string(path).unwrap();
    match extension {
        Some("exr" | "png") => drop(Image::read(path).unwrap()),
        Some("json") => drop(serde_json::from_str::<serde_json::Value>(&content()).unwrap()),
        Some("xml") => assert!(content().trim_end().ends_with("</testsuites>"), "{path:?}"),
        Some("glb") => drop(load(path).unwrap()),
        Some("csv") => assert!(content().ends_with('\n'), "{path:?}"),
        _ => {}
    }
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    [".headwater-", ".golden-", ".older-"]
        .iter()
        .any(|prefix| name.starts_with(prefix))
}

/// True if the folder has a reference that the interrupted run has begun (not the older one). It needs `--resume` to get all
/// samples.
fn is_begun(folder: &Path) -> bool {
    let picture = folder.join("a.exr");
    picture.exists() && Image::read(&picture).unwrap().metadata["headwater.seed"] == "0"
}

/// The numbers of interrupted runs by the way in which they ended, and of temporary files that SIGKILL left.
#[derive(Debug, Default)]
struct Counts {
    moments: usize,
    /// Number of runs that ended with status 130 or 143 and one line.
    by_status: usize,
    /// Number of runs that the signal killed: SIGKILL, or a signal that came before the command handled signals.
    killed: usize,
    /// Number of runs that were complete before the signal came.
    done: usize,
    left_by_kill: usize,
}

/// Runs a command in a folder, sends it a signal after the time `moment`, checks how it ends, and counts it.
fn interrupt(
    folder: &Path,
    arguments: &[&str],
    moment: Duration,
    signal: i32,
    counts: &mut Counts,
) {
    let mut command = command(folder, arguments);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(moment);
    // SAFETY: a signal to a child that has not been waited for.
    unsafe { libc::kill(child.id() as i32, signal) };
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(30) {
            let _ = child.kill();
            panic!("{arguments:?} goes on 30 s after signal {signal} at {moment:?}");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    let said = messages(stderr);
    let what = format!("{arguments:?}, signal {signal} at {moment:?}: {status}: {said}");
    counts.moments += 1;
    if status.code() == Some(128 + signal) {
        counts.by_status += 1;
        let is_end = |line: &&str| line.contains(&format!("stopped by signal {signal}; "));
        assert_eq!(said.lines().filter(is_end).count(), 1, "{what}");
        let is_note = |line: &str| line.starts_with("headwater: note: ");
        assert!(said.lines().all(|l| is_end(&l) || is_note(l)), "{what}");
    } else if status.signal() == Some(signal) {
        counts.killed += 1;
        assert!(signal == libc::SIGKILL || said.is_empty(), "{what}");
    } else {
        counts.done += 1;
        assert!(status.success(), "{what}");
    }
    for path in files(folder) {
        if is_temporary(&path) {
            assert_eq!(signal, libc::SIGKILL, "{path:?}: {what}");
            counts.left_by_kill += 1;
        } else {
            assert_whole(&path);
        }
    }
}

/// Interrupts a command at `moments` moments spread over its whole duration, and checks the folder after each.
fn check(subject: &Subject, moments: u32) {
    let folder = tempfile::tempdir().unwrap();
    let [whole, older] = ["whole", "older"].map(|name| folder.path().join(name));
    for path in [&whole, &older] {
        std::fs::create_dir(path).unwrap();
    }
    succeed(&older, &subject.older);
    // The second run finds compiled shaders, as all later ones do.
    succeed(&whole, &subject.arguments);
    // The shorter of two, since signals that come after the end say nothing.
    let duration = [(); 2].map(|()| {
        let began = Instant::now();
        succeed(&whole, &subject.arguments);
        began.elapsed()
    });
    let mut duration = duration[0].min(duration[1]);
    let mut counts = Counts::default();
    for i in 0..3 * moments {
        // More moments than that are needed only if a busy machine made the first ones come too late.
        if i >= moments && counts.say_something(subject) {
            break;
        }
        // Multiples of the golden ratio leave no gap.
        let part = (f64::from(i) * 0.618_033_988_749_895).fract();
        let moment = duration.mul_f64(part);
        let signal = SIGNALS[i as usize % SIGNALS.len()];
        let work = folder.path().join(format!("work-{i}"));
        std::fs::create_dir(&work).unwrap();
        let has_older = i % 2 == 0;
        if has_older {
            copy(&older, &work);
        }
        let done = counts.done;
        interrupt(&work, &subject.arguments, moment, signal, &mut counts);
        if counts.done > done {
            duration = duration.min(moment);
        }
        let resume = if subject.name == "reference" && is_begun(&work) {
            &["--resume"][..]
        } else {
            &[]
        };
        let began = Instant::now();
        succeed(&work, &[&subject.arguments[..], resume].concat());
        // The machine may have been busy before.
        if resume.is_empty() {
            duration = duration.min(began.elapsed());
        }
        for name in &subject.results {
            let [now, expected] = [&work, &whole].map(|f| std::fs::read(f.join(name)).unwrap());
            assert!(now == expected, "{}: {name} at {moment:?}", subject.name);
        }
        for path in files(&work) {
            assert_whole(&path);
        }
        let mut expected = names(&whole);
        if has_older {
            expected.extend(names(&older));
        }
        assert_eq!(names(&work), expected, "{} at {moment:?}", subject.name);
        std::fs::remove_dir_all(&work).unwrap();
    }
    println!("{} of {duration:?}: {counts:?}", subject.name);
    assert!(counts.say_something(subject), "{counts:?}");
}

impl Counts {
    /// False if the signals came too early or too late to say anything about a command.
    fn say_something(&self, subject: &Subject) -> bool {
        let is_watched = subject.name != UNWATCHED;
        (self.by_status > 0 || !is_watched) && self.killed > 0 && 2 * self.done < self.moments
    }
}

fn copy(from: &Path, to: &Path) {
    for path in files(from).into_iter().rev() {
        let target = to.join(path.strip_prefix(from).unwrap());
        if path.is_dir() {
            std::fs::create_dir_all(target).unwrap();
        } else {
            std::fs::create_dir_all(target.parent().unwrap()).unwrap();
            std::fs::copy(path, target).unwrap();
        }
    }
}

mod thorough {
    use super::*;

    /// The number of moments per command.
    fn moments() -> u32 {
        crate::support::number_in("HEADWATER_SIGNAL_MOMENTS").map_or(12, |number| number as u32)
    }

    #[test]
    fn render_can_be_stopped_at_any_moment() {
        let arguments = [
            "render",
            "cornell",
            "--width",
            "48",
            "--frames",
            "8",
            "--preset",
            "fast",
            "--bounces",
            "1",
        ];
        check(&Subject::of_pictures(&arguments), moments());
    }

    #[test]
    fn reference_can_be_stopped_at_any_moment() {
        let arguments = ["reference", "cornell", "--width", "48", "--spp", "200"];
        check(&Subject::of_pictures(&arguments), moments());
    }

    #[test]
    fn study_can_be_stopped_at_any_moment() {
        let plan = tempfile::tempdir().unwrap();
        let path = plan.path().join("plan.toml");
        let content = "scenes = [\"cornell\"]\nwidth = 16\nframes = 2\nseeds = 6\nbounces = 1\nreference_spp = 16\n\
             [[configurations]]\nname = \"a\"\npreset = \"accurate\"\nexpect = \"any\"\n";
        std::fs::write(&path, content).unwrap();
        let path: &'static str = text(&path).to_owned().leak();
        let arguments = vec!["study", "--plan", path, "-o", "$/out"];
        let subject = Subject {
            name: "study",
            older: [&arguments[..], &["--bounces", "0"]].concat(),
            arguments,
            // Results have times in them; runs are compared by the tests of studies.
            results: vec![],
        };
        check(&subject, moments());
    }

    #[test]
    fn regress_can_be_stopped_at_any_moment() {
        let case = ["--only", "cornell-path-tracing"];
        let blessed = [&["regress", "$/golden", "--bless"][..], &case].concat();
        let subject = Subject {
            name: "regress --bless",
            older: blessed.clone(),
            arguments: blessed,
            results: vec![],
        };
        check(&subject, moments());
        // Golden frames stand beside the work, so that each comparison finds them.
        let golden = tempfile::tempdir().unwrap();
        succeed(golden.path(), &subject.arguments);
        let golden: &'static str = text(&golden.path().join("golden")).to_owned().leak();
        let arguments = vec![
            "regress",
            golden,
            "--only",
            case[1],
            "-o",
            "$/failures",
            "--junit",
            "$/a.xml",
        ];
        let subject = Subject {
            name: "regress",
            older: arguments.clone(),
            arguments,
            results: vec![],
        };
        check(&subject, moments());
    }

    /// These commands spend most of their time reading or writing large files.
    #[test]
    fn large_files_can_be_interrupted_while_they_are_read_or_written() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("large.glb");
        let generate = [
            "scene",
            "generate",
            "terrain",
            "--set",
            "triangles=400000",
            "-o",
        ];
        let scene: &'static str = text(&scene).to_owned().leak();
        succeed(folder.path(), &[&generate[..], &[scene]].concat());
        let arguments = vec![
            "render",
            scene,
            "--width",
            "1600",
            "--preset",
            "path-tracing",
            "--bounces",
            "0",
            "--aov",
            "albedo,normal,depth",
            "-o",
            "$/a.exr",
            "-o",
            "$/a.png",
        ];
        let subject = Subject {
            name: "large files",
            older: arguments.clone(),
            arguments,
            results: vec!["a.exr", "a.png"],
        };
        check(&subject, moments());
        let arguments = vec![
            "scene",
            "generate",
            "terrain",
            "--set",
            "triangles=400000",
            "-o",
            "$/a.glb",
        ];
        let subject = Subject {
            name: UNWATCHED,
            older: vec!["scene", "generate", "cornell", "-o", "$/a.glb"],
            arguments,
            results: vec!["a.glb"],
        };
        check(&subject, moments());
    }
}
