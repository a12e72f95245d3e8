//! Tests of the progress of loading, and of its interruption.

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, textured};
use headwater::Error;
use headwater::scene_files::progress::Step;
use headwater::scene_files::{Options, load_watched};
use std::path::Path;

/// All reports of progress while a file is loaded: step, amount done, and total.
fn told(path: &Path) -> Vec<(Step, u64, u64)> {
    let mut told = Vec::new();
    let watch = &mut |step, done, total| {
        told.push((step, done, total));
        Ok(())
    };
    load_watched(path, Options::default(), watch).unwrap();
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
    let mut with_image = textured(serde_json::json!({}));
    let png = encoded(image::ImageFormat::Png);
    with_image.json["images"][0]["bufferView"] = with_image.add_view(&png).into();
    let paths = [
        folder.write("a.gltf", file.with_uri("a.bin")),
        folder.write("a.glb", file.glb()),
        folder.write("a.obj", obj),
        folder.write("textured.glb", with_image.glb()),
    ];
    for path in paths {
        // At each time that it is asked.
        for end in 0..told(&path).len() {
            let mut asked = 0;
            let error = load_watched(&path, Options::default(), &mut |_, _, _| {
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

#[test]
fn images_are_decoded_between_questions_whether_to_go_on() {
    let folder = Folder::new();
    folder.write("wall.png", encoded(image::ImageFormat::Png));
    let file = textured(serde_json::json!({ "uri": "wall.png" }));
    let told = told(&folder.write("a.glb", file.glb()));
    // Once more when all has been read, before the image is decoded, and once after it.
    let last = told
        .iter()
        .rposition(|told| told.0 == Step::Reading)
        .unwrap();
    let repeated = told[..last].iter().rev().take_while(|t| **t == told[last]);
    assert!(repeated.count() >= 2, "{told:?}");
}
