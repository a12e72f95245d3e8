//! Tests of files that a scene names in another letter case than they have.

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, textured};
use headwater::scene_files::{Options, load_watched};
use image::ImageFormat;
use serde_json::json;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn folder() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("Images")).unwrap();
    folder.write("Images/Wall.PNG", encoded(ImageFormat::Png));
    folder.write("M.Mtl", "newmtl a\nKd 1 0 0\nmap_Kd images\\wall.png\n");
    folder.write("Buffer.bin", Gltf::triangle().binary);
    folder
}

fn obj() -> String {
    format!("mtllib m.mtl\n{SQUARE}vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n")
}

#[test]
fn the_only_file_in_another_letter_case_is_taken() {
    let folder = folder();
    let scene = folder.load("scene.obj", obj());
    assert_eq!(scene.images.len(), 1);
    assert_eq!(
        scene.notices,
        [
            "files are taken whose names differ in letter case: 2 times, first \"M.Mtl\" for \"m.mtl\""
        ]
    );
    let scene = folder.load("scene.gltf", Gltf::triangle().with_uri("BUFFER.BIN"));
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(
        scene.notices,
        ["files are taken whose names differ in letter case: \"Buffer.bin\" for \"BUFFER.BIN\""]
    );
    let scene = folder.load(
        "scene.glb",
        textured(json!({ "uri": "images/WALL.png" })).glb(),
    );
    assert_eq!(scene.images.len(), 1);
    assert_eq!(
        scene.notices,
        [
            "files are taken whose names differ in letter case: \"Images/Wall.PNG\" for \"images/WALL.png\""
        ]
    );
}

#[test]
fn an_exact_name_comes_first_and_of_several_none_is_taken() {
    let folder = folder();
    folder.write("Images/WALL.png", encoded(ImageFormat::Jpeg));
    let line = folder.refuse("scene.obj", obj());
    let hint = "no file \"images/wall.png\" beside the scene (there are \"Images/WALL.png\" and \"Images/Wall.PNG\")";
    assert!(line.contains(hint), "{line}");
    folder.write("M.MTL", "newmtl a\nKd 0 1 0\n");
    let scene = folder.load("scene.obj", obj());
    let lost = "MTL files that cannot be read are left out: line 1: \"m.mtl\" (there are \"M.MTL\" and \"M.Mtl\")";
    assert_eq!(scene.notices[0], lost);
    folder.write("BUFFER.bin", Gltf::triangle().binary);
    let line = folder.refuse("scene.gltf", Gltf::triangle().with_uri("buffer.bin"));
    assert!(
        line.contains("(there are \"BUFFER.bin\" and \"Buffer.bin\")"),
        "{line}"
    );
    folder.write("images.png", encoded(ImageFormat::Png));
    folder.write("m.mtl", "newmtl a\nmap_Kd images.png\n");
    let scene = folder.load("scene.obj", obj());
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
}

/// A folder outside of the scene's folder is not searched without the user's permission.
#[test]
fn folders_outside_are_not_searched() {
    let folder = folder();
    std::fs::create_dir(folder.path("scene")).unwrap();
    std::os::unix::fs::symlink("../Images", folder.path("scene/link")).unwrap();
    let text = |name: &str| {
        folder.write("scene/m.mtl", format!("newmtl a\nmap_Kd {name}\n"));
        obj()
    };
    for name in ["../Images/WALL.PNG", "link/WALL.PNG"] {
        let line = folder.refuse("scene/scene.obj", text(name));
        assert!(!line.contains("Wall"), "{line}");
        let path = folder.write("scene/scene.obj", text(name));
        let options = Options {
            allow_outside: true,
            ..Options::default()
        };
        let scene = load_watched(&path, options, &mut |_, _, _| Ok(())).unwrap();
        assert_eq!(scene.images.len(), 1, "{name}");
    }
}
