//! Compares the OBJ reader with the crate `tobj`, which shares no code with it, on random files: both must find the same
//! triangles with the same normals, texture coordinates and colours.
//!
//! The files avoid what version 4.0.5 of `tobj` reads wrongly, so it is no oracle for it: it panics on a colour of one or two
//! numbers in an MTL file (`Kd 0.5`); it gives normals to all faces of an object if some faces have them; it cuts concave
//! polygons as fans, also outside of their outline; it turns `l 1 2 3` into a triangle; it drops all materials of a library
//! with a line that it cannot read; it refuses Latin-1, lines continued by `\`, and comments behind numbers; it ignores `fo`
//! and smoothing groups. The tests in `obj*.rs` check these by values.

use crate::files::Folder;
use crate::support::random::Random;
use headwater::scene::Scene;
use std::fmt::Write;
use std::path::Path;

/// A triangle: for each corner position, normal and texture coordinates, then the linear colour of its material.
type Triangle = ([[f32; 8]; 3], [f32; 3]);

/// Polygons with integer corners in a plane, convex and counter-clockwise.
const POLYGONS: [&[[i32; 2]]; 4] = [
    &[[0, 0], [2, 0], [1, 3]],
    &[[0, 0], [2, 0], [3, 2], [1, 2]],
    &[[0, 0], [2, 0], [3, 2], [1, 3], [-1, 2]],
    &[[0, 0], [1, -1], [3, 0], [3, 2], [1, 3], [-1, 2]],
];

const COLORS: [[f32; 3]; 3] = [[0.25, 0.5, 1.0], [1.0, 0.125, 0.0], [0.75, 0.75, 0.5]];

/// An OBJ text of random polygons in several objects and materials. All numbers are exact in f32, so that both readers must
/// find the same bits.
fn obj(random: &mut Random, has_normals: bool) -> String {
    let mut text = "mtllib m.mtl\n".to_owned();
    let mut count = [0; 3];
    for object in 0..4 {
        writeln!(text, "o object {object}").unwrap();
        for _ in 0..12 {
            writeln!(text, "usemtl m{}", random.index(COLORS.len())).unwrap();
            let polygon = POLYGONS[random.index(POLYGONS.len())];
            let offset = [0; 3].map(|_| random.index(64) as f32 / 8.0);
            let axis = random.index(3);
            for [a, b] in polygon {
                let mut position = offset;
                position[axis] += *a as f32;
                position[(axis + 1) % 3] += *b as f32;
                let [x, y, z] = position;
                writeln!(text, "v {x} {y} {z}").unwrap();
                let [u, v] = [0; 2].map(|_| random.index(33) as f32 / 16.0);
                writeln!(text, "vt {u} {v}").unwrap();
            }
            let normal = [[0, 0, 1], [0, -1, 0], [1, 0, 0]][random.index(3)];
            writeln!(text, "vn {} {} {}", normal[0], normal[1], normal[2]).unwrap();
            count[0] += polygon.len();
            count[1] += polygon.len();
            count[2] += 1;
            text += "f";
            for i in 0..polygon.len() {
                let from_end = polygon.len() - i;
                let [v, vt, vn] = match random.index(2) {
                    0 => [count[0] - from_end + 1, count[1] - from_end + 1, count[2]]
                        .map(|index| index as i64),
                    _ => [-(from_end as i64), -(from_end as i64), -1],
                };
                match has_normals {
                    true => write!(text, " {v}/{vt}/{vn}").unwrap(),
                    false => write!(text, " {v}/{vt}").unwrap(),
                }
            }
            text += "\n";
        }
    }
    text
}

/// The triangles of a scene, sorted, since the order of the materials is free.
fn of_scene(scene: &Scene) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for mesh in &scene.meshes {
        for part in &mesh.parts {
            let color = scene.materials[part.material as usize].base_color;
            for triangle in part.range() {
                let corners = mesh.triangles[triangle as usize].map(|i| {
                    let [x, y, z] = mesh.positions[i as usize].to_array();
                    let normal = mesh.normals.get(i as usize).copied().unwrap_or_default();
                    let [u, v] = mesh.uvs[0][i as usize].to_array();
                    let [a, b, c] = normal.to_array();
                    [x, y, z, a, b, c, u, v]
                });
                triangles.push((corners, color.to_array()));
            }
        }
    }
    sorted(triangles)
}

fn of_tobj(path: &Path) -> Vec<Triangle> {
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..tobj::LoadOptions::default()
    };
    let (models, materials) = tobj::load_obj(path, &options).unwrap();
    let materials = materials.unwrap();
    let mut triangles = Vec::new();
    for tobj::Model { mesh, .. } in models {
        let color = materials[mesh.material_id.unwrap()].diffuse.unwrap();
        for triangle in mesh.indices.chunks(3) {
            let corner = |i: u32| {
                let i = i as usize;
                let vector = |values: &[f32]| match values.is_empty() {
                    true => [0.0; 3],
                    false => [0, 1, 2].map(|axis| values[3 * i + axis]),
                };
                let [x, y, z] = vector(&mesh.positions);
                let [a, b, c] = vector(&mesh.normals);
                let [u, v] = [mesh.texcoords[2 * i], 1.0 - mesh.texcoords[2 * i + 1]];
                [x, y, z, a, b, c, u, v]
            };
            let corners = [0, 1, 2].map(|i| corner(triangle[i]));
            triangles.push((corners, color));
        }
    }
    sorted(triangles)
}

fn sorted(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
    triangles.sort_by(|a, b| a.partial_cmp(b).unwrap());
    triangles
}

#[test]
fn tobj_finds_the_same_triangles() {
    let folder = Folder::new();
    image::RgbImage::new(1, 1)
        .save(folder.path("t.png"))
        .unwrap();
    let material =
        |(i, [r, g, b]): (usize, &[f32; 3])| format!("newmtl m{i}\nKd {r} {g} {b}\nmap_Kd t.png\n");
    let mtl: String = COLORS.iter().enumerate().map(material).collect();
    folder.write("m.mtl", mtl);
    let mut random = Random(1);
    for round in 0..40 {
        let has_normals = round % 2 == 0;
        let text = obj(&mut random, has_normals);
        let path = folder.write("scene.obj", &text);
        let scene = headwater::scene_files::load(&path).unwrap();
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        let found = of_scene(&scene);
        assert!(found.len() > 48 && found == of_tobj(&path), "{text}");
        // The comparison sees one changed number of one line.
        let changed = text.replacen("\nvt ", "\nvt 9", 1);
        let path = folder.write("changed.obj", changed);
        assert_ne!(found, of_tobj(&path));
    }
}
