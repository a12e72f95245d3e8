//! Tests of smoothing groups and vertex colours of OBJ files.

use crate::files::Folder;
use glam::{Vec3, Vec4};
use headwater::scene::{Material, Mesh, Scene};

/// The corners of a cube from −1 to 1: bit 0 of the index decides x, bit 1 y, bit 2 z.
fn cube_corners() -> String {
    let side = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1 } else { -1 };
    let corner = |i| format!("v {} {} {}\n", side(i, 0), side(i, 1), side(i, 2));
    (0..8).map(corner).collect()
}

/// The faces of the cube, seen from outside.
const FACES: [[usize; 4]; 6] = [
    [1, 3, 4, 2],
    [5, 6, 8, 7],
    [1, 2, 6, 5],
    [3, 7, 8, 4],
    [1, 5, 7, 3],
    [2, 4, 8, 6],
];

fn faces(range: std::ops::Range<usize>) -> String {
    let face = |[a, b, c, d]: &[usize; 4]| format!("f {a} {b} {c} {d}\n");
    FACES[range].iter().map(face).collect()
}

fn load(text: &str) -> Scene {
    Folder::new().load("scene.obj", text)
}

/// The position and the normal of each corner of each triangle.
fn corners(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
    let corner = |i: &u32| (mesh.positions[*i as usize], mesh.normals[*i as usize]);
    mesh.triangles.as_flattened().iter().map(corner).collect()
}

fn flat_normal(mesh: &Mesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.positions[i as usize]);
    (b - a).cross(c - a).normalize()
}

/// At a corner of a cube three faces meet with the same angle, so the normal is the diagonal, however the faces are cut.
#[test]
fn faces_of_a_smoothing_group_share_normals() {
    let triangles: String = (FACES.iter().enumerate())
        .map(|(i, [a, b, c, d])| match i % 2 {
            0 => format!("f {a} {b} {c}\nf {a} {c} {d}\n"),
            _ => format!("f {b} {c} {d}\nf {b} {d} {a}\n"),
        })
        .collect();
    for faces in [faces(0..6), triangles] {
        for group in ["1", "on", "4294967295"] {
            let scene = load(&format!("{}s {group}\n{faces}", cube_corners()));
            assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
            let mesh = &scene.meshes[0];
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12));
            for (position, normal) in corners(mesh) {
                assert!(normal.distance(position.normalize()) < 1e-6, "{normal}");
            }
        }
    }
}

#[test]
fn groups_are_apart_and_off_is_flat() {
    // Two faces of group 1 meet in an edge; the third face belongs to group 2, and the others are flat.
    let text = format!(
        "{}s 1\nf 5 6 8 7\nf 2 4 8 6\ns 2\nf 3 7 8 4\ns off\n{}s 0\n{}",
        cube_corners(),
        faces(0..1),
        faces(4..5)
    );
    let scene = load(&text);
    assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
    let mesh = &scene.meshes[0];
    for (corner, (position, normal)) in corners(mesh).into_iter().enumerate() {
        let flat = flat_normal(mesh, corner / 3);
        let expected = match corner / 3 {
            // The edge of the two faces: x = z = 1.
            0..4 if position.x == 1.0 && position.z == 1.0 => Vec3::new(1.0, 0.0, 1.0).normalize(),
            _ => flat,
        };
        assert!(
            normal.distance(expected) < 1e-6,
            "{corner}: {normal} {expected}"
        );
    }
}

/// A group continues in later objects, since `g` and `o` only name parts.
#[test]
fn groups_continue_over_objects() {
    let text = format!("{}s 1\no a\nf 5 6 8 7\no b\nf 2 4 8 6\n", cube_corners());
    let scene = load(&text);
    let edge = Vec3::new(1.0, 0.0, 1.0).normalize();
    for mesh in &scene.meshes {
        let shared = corners(mesh)
            .into_iter()
            .filter(|(p, _)| p.x == 1.0 && p.z == 1.0);
        let normals: Vec<Vec3> = shared.map(|(_, normal)| normal).collect();
        assert!(normals.len() >= 2);
        for normal in normals {
            assert!(normal.distance(edge) < 1e-6, "{normal}");
        }
    }
}

/// The angle of a corner weights its face: 90° of the floor against 45° of each wall.
#[test]
fn a_face_counts_by_its_angle() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 9\ns 1\nf 1 2 3 4\nf 1 4 5\n";
    let scene = load(text);
    let mesh = &scene.meshes[0];
    let at_origin = corners(mesh)
        .into_iter()
        .find(|(p, _)| *p == Vec3::ZERO)
        .unwrap()
        .1;
    let angle = 9.0_f32.atan();
    let expected = Vec3::new(angle, 0.0, std::f32::consts::FRAC_PI_2).normalize();
    assert!(
        at_origin.distance(expected) < 1e-6,
        "{at_origin} {expected}"
    );
}

#[test]
fn normals_of_the_file_and_files_without_groups_stay() {
    let flat = load(&format!("{}{}", cube_corners(), faces(0..6)));
    assert!(flat.meshes[0].normals.is_empty());
    for off in ["off", "0", ""] {
        let scene = load(&format!("{}s {off}\n{}", cube_corners(), faces(0..6)));
        assert_eq!(scene.content_hash(), flat.content_hash());
        assert_eq!(scene.notices, flat.notices);
    }
    let stated = "vn 0 0.6 0.8\ns 1\nf 1//1 2//1 3//1\n";
    let scene = load(&format!("{}{stated}", cube_corners()));
    assert_eq!(scene.meshes[0].normals, [Vec3::new(0.0, 0.6, 0.8); 3]);
    let scene = load(&format!("{}s wheel\n{}", cube_corners(), faces(0..6)));
    assert!(scene.meshes[0].normals.is_empty());
    assert_eq!(
        scene.notices[0],
        "smoothing groups that are no numbers are flat: line 9"
    );
}

/// The linear value of an sRGB value, by the definition.
fn linear(value: f64) -> f32 {
    match value <= 0.04045 {
        true => (value / 12.92) as f32,
        false => ((value + 0.055) / 1.055).powf(2.4) as f32,
    }
}

fn assert_near(found: Vec4, expected: Vec4) {
    assert!(
        (found - expected).abs().max_element() < 1e-6,
        "{found} {expected}"
    );
}

#[test]
fn vertex_colours_are_read_as_srgb() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0\nv 1 1 0 0.02 0 1 0.25\nv 0 1 0 0.5\nf 2 3 4\nf 1 2 4\n";
    let scene = load(text);
    let mesh = &scene.meshes[0];
    let color_at = |position: Vec3| {
        let vertex = mesh.positions.iter().position(|p| *p == position).unwrap();
        mesh.colors[vertex]
    };
    assert_near(color_at(Vec3::ZERO), Vec4::new(1.0, 0.0, linear(0.5), 1.0));
    assert_near(
        color_at(Vec3::new(1.0, 1.0, 0.0)),
        Vec4::new(linear(0.02), 0.0, 1.0, 0.25),
    );
    assert_eq!([color_at(Vec3::X), color_at(Vec3::Y)], [Vec4::ONE; 2]);
    // Grey would darken them.
    assert_eq!(scene.materials, [Material::lambert("", Vec3::ONE)]);
    assert_eq!(
        scene.notices,
        ["faces without a material but with vertex colours are given one: white Lambert"]
    );
}

#[test]
fn vertex_colours_multiply_the_material() {
    let folder = Folder::new();
    folder.write("m.mtl", "newmtl a\nKd 0.5 0.5 0.5\n");
    let text = "mtllib m.mtl\nusemtl a\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0\n\
                f 1 2 3\no plain\nv 0 0 1\nv 1 0 1\nv 1 1 1\nusemtl\nf 5 6 7\no colours\nf 1 2 3\n";
    let scene = folder.load("scene.obj", text);
    assert_eq!(scene.meshes[0].colors, [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    assert!(scene.meshes[1].colors.is_empty());
    let of = |mesh: usize| &scene.materials[scene.meshes[mesh].parts[0].material as usize];
    assert_eq!(of(0), &Material::lambert("a", Vec3::splat(0.5)));
    assert_eq!(of(1), &Material::lambert("", Vec3::splat(0.8)));
    assert_eq!(of(2), &Material::lambert("", Vec3::ONE));
    let notices: Vec<&String> = (scene.notices.iter())
        .filter(|notice| notice.contains("are given one"))
        .collect();
    assert_eq!(notices.len(), 2, "{:?}", scene.notices);
}

#[test]
fn vertex_colours_may_be_bytes() {
    let scene =
        load("v 0 0 0 255 0 128\nv 1 0 0 1 0 0\nv 1 1 0 0 0 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
    let colors = &scene.meshes[0].colors;
    assert_near(colors[0], Vec4::new(1.0, 0.0, linear(128.0 / 255.0), 1.0));
    assert_near(colors[1], Vec4::new(linear(1.0 / 255.0), 0.0, 0.0, 1.0));
    assert_eq!(colors[3], Vec4::ONE);
    assert_eq!(
        scene.notices[0],
        "vertex colours are divided by 255: all are whole numbers, and some are above 1"
    );
    // Colours whose linear value is beyond f32 are out of range too.
    let scene = load("v 0 0 0 1e38 0.5 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n");
    assert_near(
        scene.meshes[0].colors[0],
        Vec4::new(1.0, linear(0.5), 0.0, 1.0),
    );
    // Fractions above 1 are colours out of range.
    let scene = load("v 0 0 0 1.5 0 0.5\nv 1 0 0 1 0 0\nv 1 1 0 0 0 0\nf 1 2 3\n");
    assert_near(
        scene.meshes[0].colors[0],
        Vec4::new(1.0, 0.0, linear(0.5), 1.0),
    );
    let clamped = "vertex colours outside [0, 1] are clamped: mesh 0";
    assert!(
        scene.notices.contains(&clamped.to_owned()),
        "{:?}",
        scene.notices
    );
}

#[test]
fn other_words_behind_a_position_are_ignored() {
    for words in ["red green blue", "1 0 nan", "1 1 x"] {
        let scene = load(&format!("v 0 0 0 {words}\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"));
        assert!(scene.meshes[0].colors.is_empty(), "{words}");
        assert_eq!(
            scene.notices[0],
            "words behind the position of a vertex are ignored: line 1"
        );
    }
}
