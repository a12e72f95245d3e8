//! Tests of compressed meshes and images in glTF files: what is decoded equals the mesh or the image before compression,
//! within the steps of the encoder. The mesh is a grid of 5 × 4 vertices (x, y) at the height x · y / 8.

mod draco;
mod ktx2;
mod meshopt;

use crate::files::{Folder, Gltf};
use crate::textures::{encoded, textured};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::{Vec2, Vec3, Vec4};
use headwater::scene::{Mesh, Scene};
use image::ImageFormat;
use serde_json::json;

/// The vertex (x, y) of the grid; the vertices are in this order, y first.
fn vertices() -> impl Iterator<Item = (f32, f32)> {
    (0..20_u8).map(|index| (f32::from(index / 4), f32::from(index % 4)))
}

fn position((x, y): (f32, f32)) -> Vec3 {
    Vec3::new(x, y, x * y / 8.0)
}

fn normal((x, y): (f32, f32)) -> Vec3 {
    Vec3::new(-y / 8.0, -x / 8.0, 1.0).normalize()
}

fn uv((x, y): (f32, f32)) -> Vec2 {
    Vec2::new(x, y) / 4.0
}

/// Red, green and blue as bytes.
fn color((x, y): (f32, f32)) -> [u8; 3] {
    [x as u8 * 50, y as u8 * 80, 7]
}

/// The vertices of the triangles, two per cell.
fn indices() -> Vec<u32> {
    let cells = (0..4).flat_map(|x| (0..3).map(move |y| 4 * x + y));
    let corners = cells.flat_map(|v| [v, v + 4, v + 1, v + 1, v + 4, v + 5]);
    corners.collect()
}

/// A file whose material has a texture, so that texture coordinates are read. Its primitive is replaced by the tests.
fn base() -> Gltf {
    let image = BASE64.encode(encoded(ImageFormat::Png));
    textured(json!({ "uri": format!("data:image/png;base64,{image}") }))
}

fn load(file: &Gltf) -> Scene {
    let scene = Folder::new().load("scene.glb", file.glb());
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    scene
}

fn refuse(file: &Gltf) -> String {
    Folder::new().refuse("scene.glb", file.glb())
}

/// The vertex of the grid that each vertex of the mesh is, and checks its position within `step`.
fn identify(mesh: &Mesh, step: f32) -> Vec<usize> {
    let all: Vec<_> = vertices().collect();
    let identify = |found: &Vec3| {
        let index = (4.0 * found.x.round() + found.y.round()) as usize;
        let error = (*found - position(all[index])).abs().max_element();
        assert!(error <= step, "{found} for {:?}", all[index]);
        index
    };
    mesh.positions.iter().map(identify).collect()
}

/// Triangles as vertices of the grid, in an order that does not depend on the order in the file. The first corner is the
/// least, so that the side that faces the viewer counts.
fn sorted(mut triangles: Vec<[usize; 3]>) -> Vec<[usize; 3]> {
    for triangle in &mut triangles {
        let least = (0..3).min_by_key(|corner| triangle[*corner]).unwrap();
        triangle.rotate_left(least);
    }
    triangles.sort();
    triangles
}

/// Checks that the mesh has the triangles of the grid, `copies` times. Its positions may differ by `step`.
fn check_triangles(mesh: &Mesh, step: f32, copies: usize) {
    let identities = identify(mesh, step);
    let found = (mesh.triangles.iter()).map(|t| t.map(|corner| identities[corner as usize]));
    let indices = indices();
    let triangles = indices.as_chunks::<3>().0.iter().cycle().take(24 * copies);
    let expected = triangles.map(|t| t.map(|corner| corner as usize));
    assert_eq!(sorted(found.collect()), sorted(expected.collect()));
}

/// Checks normals, texture coordinates and colours of all vertices, within the steps of the encoder.
fn check_attributes(mesh: &Mesh, step: f32, normal_step: f32, uv_step: f32) {
    let all: Vec<_> = vertices().collect();
    for (vertex, identity) in identify(mesh, step).into_iter().enumerate() {
        let of = all[identity];
        let error = mesh.normals[vertex].normalize().distance(normal(of));
        assert!(error <= normal_step, "normal of {of:?}: {error}");
        let error = mesh.uvs[0][vertex].distance(uv(of));
        assert!(error <= uv_step, "texture coordinates of {of:?}: {error}");
        let [r, g, b] = color(of).map(|byte| f32::from(byte) / 255.0);
        assert_eq!(mesh.colors[vertex], Vec4::new(r, g, b, 1.0), "{of:?}");
    }
}
