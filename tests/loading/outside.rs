//! Tests of files that a scene names: a file outside of the scene's folder, or one that is no regular file, is not opened.

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, textured};
use headwater::Result;
use headwater::scene::Scene;
use headwater::scene_files::{Options, load_watched};
use image::ImageFormat;
use serde_json::json;
use std::ffi::CString;
use std::fs::Permissions;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// A text in a file outside of the scene's folder, which no message may contain.
const SECRET: &str = "hunter2";

/// A folder with the subfolders `scene` and `other`, each with a buffer, an image, an MTL file and a secret, and links from
/// `scene` to `other`.
fn folders() -> Folder {
    let folder = Folder::new();
    for subfolder in ["scene", "other"] {
        std::fs::create_dir(folder.path(subfolder)).unwrap();
        folder.write(&format!("{subfolder}/buffer.bin"), Gltf::triangle().binary);
        folder.write(&format!("{subfolder}/wall.png"), encoded(ImageFormat::Png));
        folder.write(&format!("{subfolder}/m.mtl"), "newmtl red\nKd 1 0 0\n");
        folder.write(
            &format!("{subfolder}/secret"),
            format!("{SECRET} root:x:0:0\nnewmtl {SECRET}\nKd {SECRET}\n"),
        );
    }
    symlink("../other", folder.path("scene/away")).unwrap();
    symlink("away", folder.path("scene/twice-away")).unwrap();
    symlink(folder.path("other"), folder.path("scene/absolute")).unwrap();
    symlink(".", folder.path("scene/here")).unwrap();
    for name in ["buffer.bin", "wall.png", "m.mtl", "secret"] {
        let link = folder.path(&format!("scene/link-{name}"));
        symlink(format!("../other/{name}"), link).unwrap();
    }
    folder
}

/// Paths, relative to `scene` or absolute, that lead to the file `name` in `other`.
fn ways_out(folder: &Folder, name: &str) -> Vec<String> {
    let absolute = folder.path("other").join(name);
    let mut ways = vec![absolute.to_str().unwrap().to_owned()];
    let relative = [
        "../other/",
        "./../other/",
        "../scene/../other/",
        "away/",
        "here/away/",
        "twice-away/",
        "absolute/",
        "link-",
    ];
    ways.extend(relative.map(|way| format!("{way}{name}")));
    ways
}

fn load_with(folder: &Folder, name: &str, content: &str, options: Options) -> Result<Scene> {
    let path = folder.write(name, content);
    load_watched(&path, options, &mut |_, _, _| Ok(()))
}

fn load(folder: &Folder, name: &str, content: &str) -> Result<Scene> {
    load_with(folder, name, content, Options::default())
}

fn permissive(folder: &Folder, name: &str, content: &str) -> Result<Scene> {
    let options = Options {
        allow_outside: true,
        ..Options::default()
    };
    load_with(folder, name, content, options)
}

/// Asserts that a scene is refused because it names a file outside of its folder, in one line that says what can be done.
fn assert_outside(loaded: Result<Scene>, element: &str, way: &str) {
    let error = loaded.expect_err(way);
    let text = error.to_string();
    assert_eq!(
        (error.exit_status(), text.lines().count()),
        (2, 1),
        "{text}"
    );
    for part in [element, "outside of the scene's folder", "--allow-outside"] {
        assert!(text.contains(part), "{way}: {text:?} contains {part:?}");
    }
    assert!(!text.contains(SECRET), "{text}");
}

fn with_buffer(uri: &str) -> String {
    Gltf::triangle().with_uri(uri)
}

fn with_image(uri: &str) -> String {
    let mut file = textured(json!({ "name": "bark", "uri": uri }));
    file.json["buffers"][0]["uri"] = data_uri(&file.binary).into();
    file.json.to_string()
}

fn data_uri(bytes: &[u8]) -> String {
    use base64::prelude::{BASE64_STANDARD, Engine};
    format!("data:;base64,{}", BASE64_STANDARD.encode(bytes))
}

fn with_library(line: &str) -> String {
    format!("mtllib {line}\n{SQUARE}usemtl red\nf 1 2 3 4\n")
}

/// Writes an MTL file with the texture of `line`, and returns an OBJ text that uses it.
fn with_map(folder: &Folder, line: &str) -> String {
    folder.write("scene/mapped.mtl", format!("newmtl red\n{line}\n"));
    with_library("mapped.mtl")
}

#[test]
fn buffers_outside_of_the_folder_are_not_opened() {
    let folder = folders();
    for name in ["buffer.bin", "secret"] {
        for way in ways_out(&folder, name) {
            assert_outside(
                load(&folder, "scene/a.gltf", &with_buffer(&way)),
                "buffer 0",
                &way,
            );
        }
    }
    for way in ways_out(&folder, "buffer.bin") {
        let scene = permissive(&folder, "scene/a.gltf", &with_buffer(&way)).expect(&way);
        assert_eq!(scene.triangle_count(), 1);
    }
    // What is missing may not even show that it is.
    for way in [
        "../other/none.bin",
        "/none.bin",
        "file:///none.bin",
        "here/../../other/buffer.bin",
        "new/../../other/buffer.bin",
    ] {
        assert_outside(
            load(&folder, "scene/a.gltf", &with_buffer(way)),
            "buffer 0",
            way,
        );
    }
}

#[test]
fn escapes_and_uris_are_no_way_out() {
    let folder = folders();
    let absolute = folder.path("other/buffer.bin");
    let absolute = absolute.to_str().unwrap();
    let escaped: String = absolute
        .bytes()
        .map(|byte| format!("%{byte:02x}"))
        .collect();
    for uri in [
        "%2e%2e/other/buffer.bin",
        "..%2Fother%2fbuffer.bin",
        "%2E%2E%2Fother/buffer.bin",
        "./%2e%2e/other/buffer.bin",
        "link%2dbuffer.bin",
        &escaped,
        &format!("file://{absolute}"),
        &format!("file://localhost{absolute}"),
        &format!("file://{}", absolute.replace('o', "%6f")),
    ] {
        assert_outside(
            load(&folder, "scene/a.gltf", &with_buffer(uri)),
            "buffer 0",
            uri,
        );
        permissive(&folder, "scene/a.gltf", &with_buffer(uri)).expect(uri);
        let image = uri.replace("buffer.bin", "wall.png");
        if image != uri {
            assert_outside(
                load(&folder, "scene/a.gltf", &with_image(&image)),
                "image 0",
                uri,
            );
            permissive(&folder, "scene/a.gltf", &with_image(&image)).expect(uri);
        }
    }
    // Not decoded twice, and none of another machine or of another scheme; backslashes are parts of names.
    for uri in [
        "%252e%252e/other/buffer.bin",
        "file://elsewhere/other/buffer.bin",
        "http://elsewhere/buffer.bin",
        "..\\other\\buffer.bin",
        "C:\\other\\buffer.bin",
        "file:buffer.bin",
        "buffer.bin%00",
        "~/buffer.bin",
    ] {
        for loaded in [
            load(&folder, "scene/a.gltf", &with_buffer(uri)),
            permissive(&folder, "scene/a.gltf", &with_buffer(uri)),
        ] {
            let text = loaded.expect_err(uri).to_string();
            assert!(
                text.contains("buffer 0") && text.lines().count() == 1,
                "{text}"
            );
        }
    }
    // The same within the folder is fine.
    for uri in [
        "%62uffer.bin",
        "here/here/buffer.bin",
        "new/../buffer.bin",
        "./buffer.bin",
    ] {
        load(&folder, "scene/a.gltf", &with_buffer(uri)).expect(uri);
    }
}

#[test]
fn images_outside_of_the_folder_are_not_opened() {
    let folder = folders();
    for way in ways_out(&folder, "wall.png") {
        assert_outside(
            load(&folder, "scene/a.gltf", &with_image(&way)),
            "image 0 \"bark\"",
            &way,
        );
        let scene = permissive(&folder, "scene/a.gltf", &with_image(&way)).expect(&way);
        assert_eq!(scene.images.len(), 1);
        for map in ["map_Kd", "norm", "map_Pr"] {
            let text = with_map(&folder, &format!("{map} {way}"));
            assert_outside(load(&folder, "scene/a.obj", &text), "line 2", &way);
            let scene = permissive(&folder, "scene/a.obj", &text).expect(&way);
            assert_eq!(scene.images.len(), 1);
        }
        let text = with_map(&folder, &format!("map_Kd {}", way.replace('/', "\\")));
        assert_outside(load(&folder, "scene/a.obj", &text), "line 2", &way);
    }
}

#[test]
fn images_outside_may_be_left_out_like_missing_ones() {
    let folder = folders();
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    for way in ways_out(&folder, "wall.png") {
        let scene =
            load_with(&folder, "scene/a.gltf", &with_image(&way), options.clone()).expect(&way);
        assert!(scene.images.is_empty());
        assert!(
            scene.notices[0].contains("image files are missing"),
            "{:?}",
            scene.notices
        );
    }
    // A scene cannot do without its buffers.
    let loaded = load_with(
        &folder,
        "scene/a.gltf",
        &with_buffer("../other/buffer.bin"),
        options,
    );
    assert_outside(loaded, "buffer 0", "../other/buffer.bin");
}

#[test]
fn mtl_files_outside_of_the_folder_are_not_opened() {
    let folder = folders();
    for name in ["m.mtl", "secret"] {
        for way in ways_out(&folder, name) {
            for line in [
                way.clone(),
                way.replace('/', "\\"),
                format!("none.mtl {way}"),
                format!("{way} none.mtl"),
            ] {
                assert_outside(
                    load(&folder, "scene/a.obj", &with_library(&line)),
                    "line 1",
                    &line,
                );
            }
        }
    }
    for way in ways_out(&folder, "m.mtl") {
        let scene = permissive(&folder, "scene/a.obj", &with_library(&way)).expect(&way);
        assert_eq!(scene.materials[0].name, "red", "{way}");
    }
    for inside in ["m.mtl", "here\\m.mtl", "new/../m.mtl", "none.mtl m.mtl"] {
        let scene = load(&folder, "scene/a.obj", &with_library(inside)).expect(inside);
        assert_eq!(scene.materials[0].name, "red", "{inside}");
    }
    // Drive letters and homes are names like others.
    for missing in ["C:\\other\\m.mtl", "~/m.mtl", "file:///m.mtl"] {
        let scene = load(&folder, "scene/a.obj", &with_library(missing)).expect(missing);
        assert!(
            scene
                .notices
                .iter()
                .any(|notice| notice.contains("MTL files"))
        );
    }
}

#[test]
fn a_scene_named_without_a_folder_lies_in_the_current_one() {
    let folder = folders();
    folder.write("scene/a.gltf", with_buffer("buffer.bin"));
    folder.write("scene/b.gltf", with_buffer("../other/buffer.bin"));
    let inspect = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_headwater"))
            .args(["scene", "inspect"])
            .args(arguments)
            .current_dir(folder.path("scene"))
            .output()
            .unwrap()
    };
    for (arguments, status) in [
        (&["a.gltf"][..], 0),
        (&["./a.gltf"], 0),
        (&["here/a.gltf"], 0),
        (&["b.gltf"], 2),
        (&["b.gltf", "--allow-outside"], 0),
    ] {
        let output = inspect(arguments);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{arguments:?} {output:?}"
        );
    }
}

#[test]
fn the_folder_of_a_link_to_a_scene_counts() {
    let folder = folders();
    folder.write("other/b.gltf", with_buffer("buffer.bin"));
    folder.write("other/only.gltf", with_buffer("only.bin"));
    folder.write("other/only.bin", Gltf::triangle().binary);
    for name in ["b.gltf", "only.gltf"] {
        let link = folder.path("scene").join(name);
        symlink(format!("../other/{name}"), link).unwrap();
    }
    std::fs::remove_file(folder.path("other/buffer.bin")).unwrap();
    headwater::scene_files::load(&folder.path("scene/b.gltf")).unwrap();
    let only = headwater::scene_files::load(&folder.path("scene/only.gltf"));
    let text = only.unwrap_err().to_string();
    assert!(text.contains("there is no file \"only.bin\""), "{text}");
}

#[test]
fn textures_of_mtl_files_in_folders_may_lie_above_them() {
    let folder = folders();
    std::fs::create_dir(folder.path("scene/sub")).unwrap();
    let with_map = |map: &str| {
        folder.write("scene/sub/m.mtl", format!("newmtl red\nmap_Kd {map}\n"));
        load(&folder, "scene/a.obj", &with_library("sub/m.mtl"))
    };
    assert_eq!(with_map("../wall.png").unwrap().images.len(), 1);
    assert_outside(with_map("../../other/wall.png"), "line 2", "above");
    // Of two files of that name, one lies outside.
    symlink("../../other/wall.png", folder.path("scene/sub/wall.png")).unwrap();
    assert_eq!(with_map("wall.png").unwrap().images.len(), 1);
    std::fs::remove_file(folder.path("scene/wall.png")).unwrap();
    assert_outside(with_map("wall.png"), "line 2", "by the link");
}

#[test]
fn folders_need_not_be_readable() {
    let folder = folders();
    let path = folder.write("scene/a.gltf", with_buffer("here/sub/buffer.bin"));
    std::fs::create_dir(folder.path("scene/sub")).unwrap();
    std::fs::copy(
        folder.path("scene/buffer.bin"),
        folder.path("scene/sub/buffer.bin"),
    )
    .unwrap();
    let set_mode = |mode| {
        for name in ["", "scene", "scene/sub"] {
            let mode = Permissions::from_mode(mode);
            std::fs::set_permissions(folder.path(name), mode).unwrap();
        }
    };
    set_mode(0o311);
    const NOBODY: u32 = 65534;
    // SAFETY: it changes as whom this thread, which ends with the test, opens files; root reads any folder.
    let before = unsafe { libc::setfsuid(NOBODY) };
    let loaded = headwater::scene_files::load(&path);
    // SAFETY: as above.
    unsafe { libc::setfsuid(before as u32) };
    set_mode(0o700);
    assert_eq!(loaded.unwrap().triangle_count(), 1);
}

fn make_pipe(path: &Path) {
    let name = CString::new(path.as_os_str().as_bytes()).unwrap();
    // SAFETY: the name ends with a zero byte.
    assert_eq!(unsafe { libc::mkfifo(name.as_ptr(), 0o600) }, 0);
}

#[test]
fn only_plain_files_are_opened() {
    let folder = folders();
    make_pipe(&folder.path("scene/pipe"));
    make_pipe(&folder.path("other/pipe"));
    symlink("pipe", folder.path("scene/link-to-pipe")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(folder.path("scene/socket")).unwrap();
    let refused = |loaded: Result<Scene>, kind: &str| {
        let text = loaded.unwrap_err().to_string();
        assert!(text.contains(kind) && text.lines().count() == 1, "{text}");
    };
    let devices = [("/dev/null", "a device"), ("/dev/zero", "a device")];
    let inside = [
        ("pipe", "a pipe"),
        ("link-to-pipe", "a pipe"),
        ("socket", "a socket"),
        ("here", "a folder"),
        (".", "a folder"),
    ];
    for (name, kind) in inside
        .into_iter()
        .chain(devices)
        .chain([("../other/pipe", "a pipe")])
    {
        for text in [with_buffer(name), with_image(name)] {
            refused(permissive(&folder, "scene/a.gltf", &text), kind);
        }
        for text in [
            with_library(name),
            with_map(&folder, &format!("map_Kd {name}")),
        ] {
            refused(permissive(&folder, "scene/a.obj", &text), kind);
        }
    }
    for (name, kind) in inside {
        for text in [with_buffer(name), with_image(name)] {
            refused(load(&folder, "scene/a.gltf", &text), kind);
        }
        for text in [
            with_library(name),
            with_map(&folder, &format!("map_Kd {name}")),
        ] {
            refused(load(&folder, "scene/a.obj", &text), kind);
        }
    }
}

#[test]
fn scenes_and_environments_are_plain_files() {
    let folder = Folder::new();
    for name in ["a.gltf", "a.glb", "a.obj", "a.exr", "a.hdr"] {
        let path = folder.path(name);
        make_pipe(&path);
        let error = match name {
            "a.exr" | "a.hdr" => {
                let name = path.to_str().unwrap();
                headwater::scene::Environment::check_name(name).unwrap_err();
                headwater::scene::Environment::open(name, &mut Vec::new()).unwrap_err()
            }
            _ => {
                headwater::scene_files::check_name(path.to_str().unwrap()).unwrap_err();
                headwater::scene_files::load(&path).unwrap_err()
            }
        };
        let text = error.to_string();
        assert!(text.contains("a pipe") && text.contains(name), "{text}");
        assert_eq!((error.exit_status(), text.lines().count()), (2, 1));
    }
}
