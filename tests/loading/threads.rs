//! Checks that a scene does not depend on the number of threads that read it, and that the OBJ reader finds the same in lines
//! that threads parse in advance as in lines that it reads one after another.

use crate::files::Folder;
use headwater::scene::Scene;
use headwater::scene_files::{export, load};
use std::fmt::Write;
use std::path::Path;

/// The hash of a scene and its notices or, if it cannot be loaded, the message, with this number of threads.
fn loaded(path: &Path, threads: usize) -> (String, Vec<String>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let scene = pool.build().unwrap().install(|| load(path));
    scene.map_or_else(
        |error| (error.to_string(), Vec::new()),
        |scene| (scene.content_hash(), scene.notices),
    )
}

/// An OBJ text of several blocks: objects of quads and triangles with normals and texture coordinates, comments, lines that
/// are continued, colours, notices, and faces that need a normal.
fn obj() -> String {
    let mut text = "# head\nmtllib no.mtl\n".to_owned();
    for i in 0..20_000 {
        let (x, y) = (f64::from(i % 100) * 0.1, f64::from(i / 100) * 0.3);
        match i % 1000 {
            0 => writeln!(text, "o object {i}\ns {}", i % 3).unwrap(),
            7 => writeln!(text, "# a comment with a \\\nv 1 2 3").unwrap(),
            13 => writeln!(text, "\nl 1 2\nf 1 2").unwrap(),
            17 => writeln!(text, "usemtl m{}", i % 7).unwrap(),
            _ => {}
        }
        writeln!(text, "v {x} {y} {}", (x * y).sin()).unwrap();
        match i % 5 {
            0 => writeln!(text, "v {x} \\\n {y:e} 5").unwrap(),
            1 => writeln!(text, "v {x} {y} 5 1 0.5 0").unwrap(),
            _ => writeln!(text, "v\t{x} {y}  5.25 \r").unwrap(),
        }
        writeln!(text, "vt {x} {y}\nvn 0 {:.3} 1", x - y).unwrap();
        if i > 200 {
            let forms = [
                "f -1/-1/-1 -2/-2/-2 -3/-3/-3",
                "f -1 -2 -9 -7",
                "f 1//1 2//2 -1//-1",
                "f 3/3 4/4 -2/-1 -4/-1",
            ];
            writeln!(text, "{}", forms[i as usize % 4]).unwrap();
        }
    }
    text
}

#[test]
fn scenes_are_the_same_with_any_number_of_threads() {
    let folder = Folder::new();
    let text = obj();
    assert!(text.len() > 1 << 20, "it has several blocks");
    let plain = folder.write("plain.obj", text.as_bytes());
    // Without a line that is parsed in advance.
    let capital: String = text
        .split_inclusive('\n')
        .map(|line| match line.chars().next() {
            Some(first @ ('v' | 'f')) => first.to_uppercase().to_string() + &line[1..],
            _ => line.to_owned(),
        })
        .collect();
    let capital = folder.write("capital.obj", capital.as_bytes());
    let expected = loaded(&capital, 1);
    assert_eq!(expected.0.len(), 64, "{expected:?}");
    assert!(expected.1.len() >= 4, "{expected:?}");
    for threads in [1, 2, 5] {
        assert_eq!(loaded(&plain, threads), expected, "{threads} threads");
    }

    let glb = folder.write("a.glb", b"");
    export::write_glb(&Scene::open("night-city").unwrap(), &glb).unwrap();
    let expected = loaded(&glb, 1);
    assert_eq!(expected.0.len(), 64, "{expected:?}");
    for threads in [2, 5] {
        assert_eq!(loaded(&glb, threads), expected, "{threads} threads");
    }
}

/// Faults are in the last block, and the message names their line.
#[test]
fn faults_name_their_line_with_any_number_of_threads() {
    let folder = Folder::new();
    let text = obj();
    let line = text.lines().count() + 1;
    for (fault, what) in [
        ("f 1 2 999999", "\"f\": vertex 999999 is out of range"),
        ("f 1 2 0", "\"f\": vertex 0 is out of range"),
        ("f 1/2/3/ 2 x", "\"f\": \"x\" is not a vertex index"),
        ("v 1 2", "\"v\": three numbers are needed"),
    ] {
        let path = folder.write("a.obj", format!("{text}{fault}\n").as_bytes());
        for threads in [1, 3] {
            let (message, _) = loaded(&path, threads);
            let expected = format!("line {line}, {what}");
            assert!(message.contains(&expected), "{message}: {expected}");
        }
    }
}
