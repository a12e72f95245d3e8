//! Rooms that several of these tests render.

use crate::support;
use glam::{DVec3, Vec3};
use headwater::scene::{Camera, Material, Scene};

/// A matte material with an albedo that emits radiance of one colour.
pub fn emitter(radiance: Vec3, albedo: f32) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert("lamp", Vec3::splat(albedo))
    }
}

/// The triangles of a box that stands on the floor; `centre` is its x and z, and `turn` the angle about the vertical axis.
pub fn standing_box(centre: [f32; 2], size: Vec3, turn: f32) -> Vec<[Vec3; 3]> {
    let (sin, cos) = turn.sin_cos();
    let (x, z) = (
        Vec3::new(cos, 0.0, -sin) * size.x,
        Vec3::new(sin, 0.0, cos) * size.z,
    );
    let y = Vec3::Y * size.y;
    let corner = Vec3::new(centre[0], 0.0, centre[1]) - 0.5 * (x + z);
    [
        support::quad(corner + z, x, y),
        support::quad(corner, y, x),
        support::quad(corner + x, y, z),
        support::quad(corner, z, y),
        support::quad(corner + y, z, x),
    ]
    .concat()
}

pub const ROOM_SIZE: [u32; 2] = [24, 24];

/// A room in the style of the Cornell box, open in front, with a matte, a metal and a dielectric box, and its camera.
pub fn room() -> (Scene, Camera) {
    let matte = |name, color| Material::lambert(name, color);
    let glossy = |name: &str, color, metallic, roughness| Material {
        name: name.into(),
        base_color: color,
        metallic,
        roughness,
        ..Material::default()
    };
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let low = Vec3::new(-1.0, 0.0, -1.0);
    let scene = support::scene_of(&[
        (
            matte("white", Vec3::splat(0.75)),
            [
                support::quad(low, z, x),
                support::quad(low + y, x, z),
                support::quad(low, x, y),
            ]
            .concat(),
        ),
        (
            matte("red", Vec3::new(0.6, 0.06, 0.05)),
            support::quad(low, y, z),
        ),
        (
            matte("green", Vec3::new(0.12, 0.45, 0.1)),
            support::quad(low + x, z, y),
        ),
        (
            matte("grey box", Vec3::splat(0.4)),
            standing_box([0.5, -0.55], Vec3::new(0.5, 0.5, 0.5), 0.4),
        ),
        (
            glossy("metal box", Vec3::new(0.9, 0.7, 0.4), 1.0, 0.3),
            standing_box([-0.4, -0.3], Vec3::new(0.6, 1.2, 0.5), 0.3),
        ),
        (
            glossy("dielectric box", Vec3::new(0.2, 0.3, 0.7), 0.0, 0.2),
            standing_box([0.35, 0.4], Vec3::new(0.55, 0.5, 0.5), -0.3),
        ),
        (
            emitter(Vec3::new(9.0, 8.0, 6.0), 0.5),
            support::quad(Vec3::new(-0.4, 1.95, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8),
        ),
    ]);
    // Off the middle, from where the room's edges would run through the pixels' centres.
    let (eye, target) = (DVec3::new(0.07, 1.03, 3.6), DVec3::new(0.01, 0.98, 0.0));
    (scene, support::look_at(eye, target, DVec3::Y, 0.72))
}
