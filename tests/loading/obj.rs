//! Valid OBJ files.

use crate::files::Folder;
use glam::Vec3;
use headwater::scene::{Material, Scene};

/// Four corners of a unit square in z = 0.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(text: &str) -> Scene {
    Folder::new().load("scene.obj", format!("{SQUARE}{text}"))
}

#[test]
fn polygons_and_negative_indices() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1// 2/ 3/1 4/1/"] {
        let scene = load(face);
        assert_eq!(scene.triangle_count(), 2, "{face}");
        assert_eq!(scene.meshes[0].positions.len(), 4);
        assert!(scene.meshes[0].normals.is_empty());
        assert_eq!(scene.materials, [Material::lambert("", Vec3::splat(0.8))]);
        assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
        assert!(scene.notices[0].contains("grey"));
    }
}

#[test]
fn objects_become_meshes_and_materials_parts() {
    let folder = Folder::new();
    folder.write(
        "a b.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl lamp light\nKd 0.5\nKe 3 2 1\n",
    );
    let scene = folder.load(
        "scene.obj",
        format!(
            "mtllib a b.mtl\n{SQUARE}o first\nusemtl red\nf 1 2 3\nusemtl lamp light\nf 1 3 4\n\
             usemtl red\nf 2 3 4\ng second\nf 1 2 4\no none\n"
        ),
    );
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["first", "second"]);
    let parts: Vec<(u32, u32, u32)> = scene.meshes[0]
        .parts
        .iter()
        .map(|part| (part.first_triangle, part.triangle_count, part.material))
        .collect();
    assert_eq!(parts, [(0, 2, 0), (2, 1, 1)]);
    assert_eq!(scene.meshes[1].parts[0].material, 0);
    let mut lamp = Material::lambert("lamp light", Vec3::splat(0.5));
    lamp.emission = Vec3::new(3.0, 2.0, 1.0);
    assert_eq!(scene.materials, [Material::lambert("red", Vec3::X), lamp]);
    assert_eq!(scene.emissive_triangle_count(), 1);
}

#[test]
fn physical_materials_have_a_specular_lobe() {
    let folder = Folder::new();
    folder.write(
        "m.mtl",
        "newmtl a\nPr 0.25\nnewmtl b\nPm 1\nPr 0.5\nmap_Kd x.png\nd 0.5\n",
    );
    let text = format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n");
    let scene = folder.load("scene.obj", text);
    let found: Vec<(f32, f32, f32)> = scene
        .materials
        .iter()
        .map(|m| (m.specular, m.metallic, m.roughness))
        .collect();
    assert_eq!(found, [(1.0, 0.0, 0.25), (1.0, 1.0, 0.5)]);
    assert_eq!(
        scene.notices,
        [
            "transparency is not supported, surfaces are opaque: material \"b\"",
            "textures are not supported yet, the plain factors are used: map_Kd",
        ]
    );
}

#[test]
fn normals_where_they_are_and_flat_where_not() {
    let scene = load("v 0 0 1\nvn 0 0 2\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1 3 4\nf 1//2 4//2 5//2\n");
    let mesh = &scene.meshes[0];
    let of = |t: usize| mesh.triangles[t].map(|i| mesh.normals[i as usize]);
    assert_eq!(of(0), [Vec3::Z; 3]);
    assert_eq!(of(1), [Vec3::Z; 3]);
    assert_eq!(of(2), [Vec3::X; 3]);
}

#[test]
fn normals_of_some_corners_stay_with_them() {
    // Faces without normals come first, so that normals counted by corners would be misplaced.
    let scene = load("vn 0 .6 .8\nf 1 2 3\nf 1//1 3//1 4//1\nf 1//1 2 4//1\n");
    let mesh = &scene.meshes[0];
    let of = |t: usize| mesh.triangles[t].map(|i| mesh.normals[i as usize]);
    let tilted = Vec3::new(0.0, 0.6, 0.8);
    assert_eq!(of(0), [Vec3::Z; 3]);
    assert_eq!(of(1), [tilted; 3]);
    assert_eq!(of(2), [tilted, Vec3::Z, tilted]);
    let places = mesh.triangles[2].map(|i| mesh.positions[i as usize]);
    assert_eq!(places, [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn colours_of_some_vertices_change_no_position() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 0 0 1\nv 0 1 0\nf 2 3 4\nf 1 2 4\n";
    let coloured = Folder::new().load("scene.obj", text);
    assert_eq!(
        coloured.notices[0],
        "vertex colours are ignored: 2 times, first line 1"
    );
    let plain = load("f 2 3 4\nf 1 2 4\n");
    assert_eq!(coloured.content_hash(), plain.content_hash());
}

#[test]
fn latin_1_is_read_where_a_line_is_no_utf_8() {
    let folder = Folder::new();
    // Two names that differ only in such a letter, in files of different encodings.
    folder.write(
        "türen.mtl",
        b"# caf\xe9\nnewmtl gr\xfcn\nKd 0 1 0\nnewmtl gr\xf6n\nKd 0 0 1\n",
    );
    let text = [
        SQUARE.as_bytes(),
        b"# \xe9\xa0\nmtllib t\xfcren.mtl\no T\xfcr \xb5\nusemtl gr\xfcn\nf 1 2 3\n",
        "usemtl grön\nf 1 3 4\n".as_bytes(),
    ];
    let scene = folder.load("scene.obj", text.concat());
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_eq!(scene.meshes[0].name, "Tür µ");
    let expected = [("grün", Vec3::Y), ("grön", Vec3::Z)];
    assert_eq!(
        scene.materials,
        expected.map(|(name, colour)| Material::lambert(name, colour))
    );
    let parts = scene.meshes[0].parts.iter();
    assert_eq!(parts.map(|p| p.material).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn a_backslash_continues_a_line() {
    for end in ["\\\n", "\\\r\n", "\\ \n\t"] {
        let folder = Folder::new();
        let library = "newmtl red\nKd 1 >0 >.5\nKe >3 2 1\n";
        folder.write("m.mtl", library.replace('>', end));
        let text =
            "mtllib >m.mtl\nv 0 >0 0\nv 1 0 >>0\nv 1 1 0\nv 0 1 0\nusemtl >red\nf 1 2 >3 4\n";
        let scene = folder.load("scene.obj", text.replace('>', end));
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        let mesh = &scene.meshes[0];
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert_eq!(mesh.positions, square);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let mut red = Material::lambert("red", Vec3::new(1.0, 0.0, 0.5));
        red.emission = Vec3::new(3.0, 2.0, 1.0);
        assert_eq!(scene.materials, [red]);
    }
}

#[test]
fn missing_materials_are_grey_with_a_warning() {
    let scene = load("mtllib lost.mtl\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n");
    assert_eq!(
        scene.notices,
        [
            "MTL files that cannot be read are left out: line 5: \"lost.mtl\"",
            "materials that no MTL file has are grey (0.8): 2 times, first line 6: \"red\"",
            "faces without a material are given one: grey Lambert (0.8)",
        ]
    );
    assert_eq!(scene.meshes[0].parts.len(), 1);
}

#[test]
fn degenerate_faces_points_and_lines_are_left_out() {
    let scene = load("f 1 1 2\nf 1 2 3\nl 1 2\np 1\nl 2 3\n");
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(
        scene.notices[..1],
        ["points and lines are skipped: 3 times, first line 7"]
    );
    assert_eq!(
        scene.notices[2],
        "triangles without area are removed: mesh 0"
    );
}

#[test]
fn an_empty_file_is_an_empty_scene() {
    for text in ["", "# nothing\n", SQUARE] {
        let scene = Folder::new().load("scene.obj", text);
        assert!(scene.meshes.is_empty());
        assert_eq!(scene.notices.len(), 1);
    }
}
