//! How far loading tells it has come, that it can be ended on the way, and how much memory it takes.

use crate::files::{Folder, Gltf};
use headwater::Error;
use headwater::scene::load::load_watched;
use headwater::scene::progress::Step;
use headwater::scene::{Scene, export, procedural};
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// What loading tells of a file.
fn told(path: &Path) -> Vec<(Step, u64, u64)> {
    let mut told = Vec::new();
    let watch = &mut |step, done, total| {
        told.push((step, done, total));
        Ok(())
    };
    load_watched(path, watch).unwrap();
    told
}

#[test]
fn all_bytes_of_all_files_are_told_then_all_meshes() {
    let folder = Folder::new();
    let file = Gltf::triangle();
    let (json, glb) = (file.with_uri("a%20b.bin"), file.glb());
    folder.write("a b.bin", &file.binary);
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, content, bytes, meshes) in [
        (
            "a.gltf",
            json.as_bytes(),
            json.len() + file.binary.len(),
            Some(1),
        ),
        ("a.glb", &glb, glb.len(), Some(1)),
        ("a.obj", obj.as_bytes(), obj.len(), None),
    ] {
        let told = told(&folder.write(name, content));
        type Told<'a> = Vec<&'a (Step, u64, u64)>;
        let (read, decoded): (Told<'_>, Told<'_>) =
            told.iter().partition(|(step, ..)| *step == Step::Reading);
        let bytes = bytes as u64;
        assert!(
            read.windows(2).all(|w| w[0].1 <= w[1].1),
            "{name}: {told:?}"
        );
        assert_eq!(
            read.last(),
            Some(&&(Step::Reading, bytes, bytes)),
            "{name}: {told:?}"
        );
        assert_eq!(
            decoded.last().map(|d| (d.1, d.2)),
            meshes.map(|m| (m, m)),
            "{name}"
        );
    }
}

#[test]
fn an_error_of_the_watcher_ends_loading_as_it_is() {
    let folder = Folder::new();
    let file = Gltf::triangle();
    folder.write("a.bin", &file.binary);
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let paths = [
        folder.write("a.gltf", file.with_uri("a.bin")),
        folder.write("a.glb", file.glb()),
        folder.write("a.obj", obj),
    ];
    for path in paths {
        // At each time that it is asked.
        for end in 0..told(&path).len() {
            let mut asked = 0;
            let error = load_watched(&path, &mut |_, _, _| {
                asked += 1;
                let kept = "nothing".into();
                if asked > end {
                    Err(Error::Interrupted { signal: 2, kept })
                } else {
                    Ok(())
                }
            });
            let error = error.unwrap_err();
            assert!(
                matches!(error, Error::Interrupted { signal: 2, .. }),
                "{error}"
            );
            assert_eq!(asked, end + 1);
        }
    }
}

/// Bytes that a process had in memory at most while it looked into a scene.
fn peak_memory(path: &Path) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_headwater"))
        .args(["scene", "inspect"])
        .arg(path)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    let mut status = 0;
    // SAFETY: waits for the child just started, and fills what it is given.
    let usage = unsafe {
        libc::wait4(child.id() as i32, &raw mut status, 0, usage.as_mut_ptr());
        usage.assume_init()
    };
    // It was waited for already; this only tells the standard library.
    let _ = child.try_wait();
    assert_eq!(status, 0);
    usage.ru_maxrss as u64 * 1024
}

fn obj(scene: &Scene) -> String {
    let mut text = String::new();
    let mesh = &scene.meshes[0];
    for p in &mesh.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

#[test]
fn loading_takes_at_most_four_times_a_files_memory() {
    let triangles = match std::env::var_os("HEADWATER_TEST_ALL") {
        Some(_) => "5000000",
        None => "500000",
    };
    let settings = [("triangles".to_owned(), triangles.to_owned())];
    let scene = procedural::generate("terrain", &settings).unwrap();
    let folder = Folder::new();
    let glb = folder.path("a.glb");
    export::write_glb(&scene, &glb).unwrap();
    for path in [glb, folder.write("a.obj", obj(&scene))] {
        let size = std::fs::metadata(&path).unwrap().len();
        let peak = peak_memory(&path);
        println!("{}: {size} bytes, {peak} in memory", path.display());
        // Less than the file cannot be: the measurement would be wrong.
        assert!(
            (size / 2..=4 * size).contains(&peak),
            "{size} bytes, {peak} in memory"
        );
    }
}
