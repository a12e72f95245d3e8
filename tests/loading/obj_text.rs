//! Tests of OBJ and MTL files as programs write them: encodings, letter case, unknown keywords, and materials that are named
//! before their library.

use crate::files::Folder;
use glam::Vec3;
use headwater::scene::{Material, Scene};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The scene of a red and a blue triangle, as a file without any oddity makes it.
fn expected() -> (Folder, Scene) {
    let folder = Folder::new();
    folder.write("m.mtl", MTL);
    let scene = folder.load("scene.obj", OBJ);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    (folder, scene)
}

const MTL: &str = "newmtl red\nKd 1 0 0\nnewmtl Blue\nKd 0 0 1\nKe 0 0 .5\n";
const OBJ: &str =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl Blue\nf 1 3 4\n";

#[test]
fn byte_order_marks_tabs_and_line_ends_change_nothing() {
    let (folder, expected) = expected();
    let marked = |text: &str| format!("\u{feff}{text}");
    for (obj, mtl) in [
        (marked(OBJ), MTL.to_owned()),
        (OBJ.to_owned(), marked(MTL)),
        (marked(OBJ), marked(MTL)),
        (
            marked(OBJ).replace('\n', "\r\n"),
            marked(MTL).replace('\n', "\r\n"),
        ),
        (OBJ.replace(' ', "\t"), MTL.replace(' ', " \t ")),
        (OBJ.replace('\n', "\r"), marked(MTL).replace('\n', "\r")),
        (format!("# a\r b\n{OBJ}"), format!("# a\r b\n{MTL}")),
    ] {
        folder.write("m.mtl", mtl);
        let scene = folder.load("scene.obj", obj);
        assert_eq!(scene.materials, expected.materials);
        assert_eq!(scene.content_hash(), expected.content_hash());
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
}

#[test]
fn utf_16_is_refused() {
    let (folder, _) = expected();
    let little =
        |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let big = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_be_bytes).collect() };
    for mark in ["\u{feff}", ""] {
        for encode in [little as fn(&str) -> Vec<u8>, big] {
            let line = folder.refuse("scene.obj", encode(&format!("{mark}{OBJ}")));
            assert!(line.contains("UTF-16") && line.contains("save"), "{line}");
            folder.write("u.mtl", encode(&format!("{mark}{MTL}")));
            let line = folder.refuse("scene.obj", OBJ.replace("m.mtl", "u.mtl"));
            assert!(
                line.contains("\"u.mtl\"") && line.contains("UTF-16"),
                "{line}"
            );
        }
    }
}

#[test]
fn names_may_contain_the_sign_of_comments() {
    let (folder, expected) = expected();
    let [red, blue] = ["Material #1", "Material #2"];
    folder.write("m#1.mtl", MTL.replace("red", red).replace("Blue", blue));
    let obj = OBJ
        .replace("m.mtl", "m#1.mtl")
        .replace("red", red)
        .replace("Blue", blue);
    for obj in [obj.clone(), obj.replace('\n', " # comment\n")] {
        let scene = folder.load("scene.obj", obj);
        assert_eq!(scene.content_hash(), expected.content_hash());
        let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, [red, blue]);
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
}

#[test]
fn a_comment_ends_with_its_line() {
    let (folder, expected) = expected();
    let comment = "# from C:\\scenes\\\n";
    folder.write("m.mtl", format!("{comment}{MTL}"));
    let scene = folder.load("scene.obj", format!("{comment}{OBJ} {comment}"));
    assert_eq!(scene.content_hash(), expected.content_hash());
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
}

#[test]
fn keywords_may_be_written_in_another_letter_case() {
    let (folder, expected) = expected();
    let keywords = |text: &str, change: fn(&str) -> String| -> String {
        let line = |line: &str| {
            let (keyword, rest) = line.split_once(' ').unwrap();
            format!("{} {rest}\n", change(keyword))
        };
        text.lines().map(line).collect()
    };
    for change in [str::to_uppercase, str::to_lowercase] {
        folder.write("m.mtl", keywords(MTL, change));
        let scene = folder.load("scene.obj", keywords(OBJ, change));
        assert_eq!(scene.materials, expected.materials);
        assert_eq!(scene.content_hash(), expected.content_hash());
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
}

#[test]
fn unknown_keywords_have_a_notice_each() {
    let (folder, expected) = expected();
    folder.write(
        "m.mtl",
        format!("# \nfoo 1\n{MTL}Qd 1 1 1\nfoo\nqd 2\nQd 3\n"),
    );
    let scene = folder.load("scene.obj", format!("{OBJ}vq 1 2 3\nfoo\n"));
    assert_eq!(scene.content_hash(), expected.content_hash());
    assert_eq!(
        scene.notices,
        [
            "statements before the first newmtl are ignored: line 2 of \"m.mtl\"",
            "the unknown keyword \"Qd\" is ignored: 2 times, first line 8 of \"m.mtl\"",
            "the unknown keyword \"foo\" is ignored: 2 times, first line 9 of \"m.mtl\"",
            "the unknown keyword \"qd\" is ignored: line 10 of \"m.mtl\"",
            "the unknown keyword \"vq\" is ignored: line 10",
        ]
    );
    // Their number is limited, since a file can have any number of them.
    let many: String = (0..10_000).map(|i| format!("word{i} 1\n")).collect();
    let scene = folder.load("scene.obj", format!("{SQUARE}f 1 2 3\n{many}"));
    assert_eq!(scene.notices.len(), 18, "{:?}", scene.notices);
    let rest = "further unknown keywords are ignored: 9984 times, first \"word16\" in line 22";
    assert_eq!(scene.notices[16], rest);
}

#[test]
fn materials_may_be_used_before_their_library_is_named() {
    let (folder, expected) = expected();
    let late = "MTL files are read first, because they are named after the use of a material";
    let without = OBJ.replace("mtllib m.mtl\n", "");
    for (text, notices) in [
        (
            format!("{without}mtllib m.mtl\n"),
            vec![format!("{late}: line 5: \"red\"")],
        ),
        (
            without.replace("usemtl Blue", "mtllib lost.mtl\nusemtl Blue\nmtllib m.mtl"),
            vec![
                format!("{late}: line 5: \"red\""),
                "MTL files that cannot be read are left out: line 7: \"lost.mtl\"".into(),
            ],
        ),
    ] {
        let scene = folder.load("scene.obj", text);
        assert_eq!(scene.materials, expected.materials);
        assert_eq!(scene.content_hash(), expected.content_hash());
        assert_eq!(scene.notices, notices);
    }
    // A material that no library has stays grey, and the file is not read again.
    let scene = folder.load(
        "scene.obj",
        format!("{OBJ}usemtl lost\nf 1 2 3\nmtllib m.mtl\n"),
    );
    assert_eq!(
        scene.notices,
        [
            "materials that are in no MTL file are grey (0.8): line 10: \"lost\"",
            "faces without a material are given one: grey Lambert (0.8)",
        ]
    );
}

#[test]
fn names_of_materials_match_without_regard_to_letter_case() {
    let (folder, expected) = expected();
    let other = OBJ
        .replace("usemtl red", "usemtl RED")
        .replace("usemtl Blue", "usemtl blue");
    let scene = folder.load("scene.obj", other);
    assert_eq!(scene.content_hash(), expected.content_hash());
    let notice = "names of materials are matched without regard to letter case: 2 times, \
                  first line 6: \"RED\" is \"red\"";
    assert_eq!(scene.notices, [notice]);
    // An exact match comes first, and of several others none is taken.
    folder.write(
        "m.mtl",
        "newmtl a\nKd 1 0 0\nnewmtl A\nKd 0 1 0\nnewmtl bB\nKd 0 0 1\nnewmtl BB\n",
    );
    let material = |name: &str| {
        let text = format!("mtllib m.mtl\n{SQUARE}usemtl {name}\nf 1 2 3\n");
        let scene = folder.load("scene.obj", text);
        scene.materials[scene.meshes[0].parts[0].material as usize].clone()
    };
    assert_eq!(material("a"), Material::lambert("a", Vec3::X));
    assert_eq!(material("A"), Material::lambert("A", Vec3::Y));
    assert_eq!(material("bb"), Material::lambert("", Vec3::splat(0.8)));
}
