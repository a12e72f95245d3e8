//! The scene `conservatory`, a test that uses almost every feature of scenes once: textures of every kind, vertex colours,
//! surfaces with holes and with partial coverage, an unlit picture, and lights with and without a surface. If the scene is
//! rendered with an environment (light from infinitely far away), this light enters through the roof, the trellis and the
//! open front. Lengths are in metres, and the floor is at height 0.

use crate::procedural::modelling::stage::{Stage, at, repeated, swing};
use crate::procedural::modelling::{Builder, Model, SINK, Shape, dielectric, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::camera::look_at;
use crate::scene::motion::tracks::Interpolation;
use crate::scene::{AlphaMode, Material, PunctualLight, PunctualShape, Scene, Texture};
use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "speed",
        doc: "Speed of the lantern, the trellis, the spot and the sun; 0 stands still",
        default: "0",
        values: Range::Real(0.0, 100.0),
    },
    Parameter {
        name: "lantern",
        doc: "Whether the lantern's paper is whole, or has holes cut into it",
        default: "whole",
        values: Range::Words(&["whole", "pierced"]),
    },
];

/// The corner of the room with the lowest coordinates, in metres. Walls, floor and roof are placed relative to it.
const LOW: Vec3 = Vec3::new(-1.5, 0.0, -1.5);
/// The size of the room along the axes x, y and z, in metres. Walls, floor and roof are made with these
/// lengths.
const SIZE: Vec3 = Vec3::new(3.0, 2.4, 3.0);

pub(super) fn make(values: &Values) -> Scene {
    let speed = f64::from(values.real("speed"));
    let mut stage = Stage::new(Builder::default());
    house(&mut stage.room);
    furnish(&mut stage.room);
    trellis(&mut stage, speed);
    lantern(&mut stage, speed, values.text("lantern") == "pierced");
    lights(&mut stage, speed);
    let (eye, target) = (DVec3::new(0.0, 1.25, 4.6), DVec3::new(0.0, 1.1, 0.0));
    stage.room.camera(eye, target, 36.0, 4.0 / 3.0);
    stage.scene()
}

/// A pseudorandom byte in [0, 255] for the pair (x, y), always the same byte for the same pair. The images of
/// textures get their patterns from such bytes, with the coordinates of texels as x and y.
fn byte(x: u32, y: u32) -> u8 {
    let mixed =
        (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B)).wrapping_mul(0xC2B2_AE35);
    (mixed >> 24) as u8
}

/// A texture that repeats an image `times.x` × `times.y` times within the unit square of texture coordinates.
/// `image` is the index of the image in the scene.
fn repeating(image: u32, times: Vec2) -> Texture {
    Texture {
        transform: Affine2::from_scale(times),
        ..Texture::plain(image)
    }
}

/// Adds the floor, the left wall, the back wall and the glass roof. The front stays open, and [`trellis`] adds the right
/// wall.
fn house(room: &mut Builder) {
    let (x, y, z) = (Vec3::X * SIZE.x, Vec3::Y * SIZE.y, Vec3::Z * SIZE.z);
    let tiles = room.image("tiles", 8, |x, y| {
        let shade = byte(x, y) / 8;
        if (x + y) % 2 == 0 {
            [190 - shade, 110 - shade, 80, 255]
        } else {
            [215 - shade, 205 - shade, 185, 255]
        }
    });
    // Roughness in green, metalness in blue.
    let worn = room.image("wear", 8, |x, y| [0, 110 + byte(x, y + 9) / 2, 0, 255]);
    let bumps = room.image("bumps", 8, |x, y| {
        let lean = |i| 98 + byte(x + i, y + 5) / 4;
        [lean(3), lean(31), 250, 255]
    });
    let floor = Material {
        base_color_texture: Some(Texture {
            nearest: true,
            ..Texture::plain(tiles)
        }),
        metallic_roughness_texture: Some(Texture::plain(worn)),
        normal_texture: Some(Texture::plain(bumps)),
        normal_scale: 0.5,
        ..dielectric("floor", Vec3::ONE, 1.0)
    };
    let floor = room.mesh(floor, Shape::quad(LOW, z, x));
    room.lay(floor, |p| Vec2::new(p.x, p.z) * 0.5);
    room.place("floor", floor, DAffine3::IDENTITY);

    let bricks = room.image("bricks", 16, |x, y| {
        let is_mortar = y % 4 == 0 || (x + y / 4 % 2 * 4) % 8 == 0;
        let shade = byte((x + y / 4 % 2 * 4) / 8, y / 4) / 6;
        match is_mortar {
            true => [200, 195, 185, 255],
            false => [180 - shade, 90 - shade, 70 - shade, 255],
        }
    });
    let bricks = Material {
        base_color_texture: Some(repeating(bricks, Vec2::new(4.0, 4.0))),
        ..Material::lambert("bricks", Vec3::ONE)
    };
    let left = room.mesh(bricks, Shape::quad(LOW, y, z));
    room.lay(left, |p| Vec2::new(p.z, -p.y) / SIZE.y);
    room.place("left wall", left, DAffine3::IDENTITY);

    let back = Shape::quad(LOW, x, y);
    let back = room.mesh(Material::lambert("back wall", Vec3::splat(0.8)), back);
    let mesh = &mut room.0.meshes[back as usize];
    // From green at the floor to white.
    let color = |p: &Vec3| {
        Vec3::new(0.35, 0.55, 0.35)
            .lerp(Vec3::ONE, p.y / SIZE.y)
            .extend(1.0)
    };
    mesh.colors = mesh.positions.iter().map(color).collect();
    room.place("back wall", back, DAffine3::IDENTITY);

    let glass = Material {
        alpha: 0.3,
        alpha_mode: AlphaMode::Blend,
        ..Material::lambert("roof", Vec3::new(0.5, 0.75, 0.7))
    };
    room.add(glass, Shape::quad(LOW + y, x, z));
}

/// Adds the objects in the room that do not move: a curtain, a picture, a plinth, a pot and a metal sphere.
fn furnish(room: &mut Builder) {
    // Denser towards its edges, and nowhere quite closed.
    let lace = room.image("lace", 8, |x, y| {
        let edge = (2 * x).abs_diff(7).max((2 * y).abs_diff(7)) as u8;
        [235, 225, 205, 40 + 25 * edge + byte(x, y) / 8]
    });
    let lace = Material {
        base_color_texture: Some(Texture::plain(lace)),
        alpha: 0.9,
        alpha_mode: AlphaMode::Blend,
        ..Material::lambert("curtain", Vec3::splat(0.9))
    };
    let corner = Vec3::new(-1.1, 0.3, -0.9);
    let curtain = Shape::quad(corner, Vec3::new(0.9, 0.0, 0.3), Vec3::Y * 1.6);
    let curtain = room.mesh(lace, curtain);
    room.lay(curtain, |p| {
        Vec2::new(p.x - corner.x, p.y - corner.y) / Vec2::new(0.9, 1.6)
    });
    room.place("curtain", curtain, DAffine3::IDENTITY);

    let picture = room.image("picture", 8, |x, y| {
        [byte(x, 40), byte(y, 50), byte(x, y + 60), 255]
    });
    let picture = Material {
        base_color_texture: Some(Texture::plain(picture)),
        ..Material::unlit("picture", Vec3::splat(0.6))
    };
    let corner = Vec3::new(0.35, 1.25, -1.49);
    let picture = room.mesh(picture, Shape::quad(corner, Vec3::X * 0.6, Vec3::Y * 0.6));
    room.lay(picture, |p| Vec2::new(p.x - corner.x, corner.y - p.y) / 0.6);
    room.place("picture", picture, DAffine3::IDENTITY);

    let mut stands = Model::default();
    let [low, high] = [Vec3::new(0.25, -SINK, -0.45), Vec3::new(0.75, 0.5, 0.05)];
    stands.add(
        &Material::lambert("plinth", Vec3::splat(0.7)),
        Shape::block(low, high),
    );
    let pot = Shape::cylinder(Vec3::new(-0.75, -SINK, 0.45), 0.2, 0.42, 12);
    stands.add(&Material::lambert("pot", Vec3::new(0.6, 0.3, 0.2)), pot);
    room.add_model("stands", stands);
    let sphere = room.mesh(
        metal("sphere", Vec3::new(1.0, 0.77, 0.34), 0.4),
        Shape::sphere(3),
    );
    let mesh = &mut room.0.meshes[sphere as usize];
    let color = |p: &Vec3| Vec4::new(1.0, 0.8 + 0.2 * p.y, 0.7 + 0.3 * p.x, 1.0);
    mesh.colors = mesh.positions.iter().map(color).collect();
    let position = DVec3::new(0.5, 0.79, -0.2);
    let transform =
        DAffine3::from_scale_rotation_translation(DVec3::splat(0.29), DQuat::IDENTITY, position);
    room.place("sphere", sphere, transform);
}

/// Adds the right wall of the room, which is a trellis of laths, and the leaves in the pot. Both are
/// rectangles with textures, whose alpha cuts out the holes between the laths and the outlines of the leaves.
/// The trellis slides to and fro along z; `speed` multiplies its speed, and with 0 it stands still.
fn trellis(stage: &mut Stage, speed: f64) {
    let room = &mut stage.room;
    let holes = room.image("trellis", 8, |x, y| {
        [150, 110, 70, if x % 4 == 0 || y % 4 == 0 { 255 } else { 0 }]
    });
    let laths = Material {
        base_color_texture: Some(repeating(holes, Vec2::new(4.0, 4.0))),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::lambert("trellis", Vec3::ONE)
    };
    let (y, z) = (Vec3::Y * SIZE.y, Vec3::Z * SIZE.z);
    let wall = room.mesh(laths, Shape::quad(LOW.with_x(0.0), z, y));
    room.lay(wall, |p| Vec2::new(p.z, p.y) / SIZE.y);
    let mut transform = at(f64::from(LOW.x + SIZE.x), 0.0, 0.0);
    let keys = [0.0, 0.25, 0.5, 0.75].map(|phase| {
        let aside = 0.4 * (std::f64::consts::TAU * phase).sin();
        (phase, [DVec3::new(f64::from(LOW.x + SIZE.x), 0.0, aside)])
    });
    transform.translation.track = repeated(speed, 4.0, Interpolation::Linear, &keys);
    let node = stage.moving_node(None, transform);
    stage.hang("trellis", wall, node);

    let room = &mut stage.room;
    // A leaf: within two arcs, of which the texture interpolates the edge.
    let leaf = room.image("leaf", 16, |x, y| {
        let (x, y) = (f32::from(x as u8) - 7.5, f32::from(y as u8) - 7.5);
        let inside = 40.0 - 1.3 * y * y * 0.5 - 3.0 * x.abs() * (1.0 + x.abs() * 0.2);
        [
            60,
            120 + byte(x as u32, y as u32) / 8,
            40,
            (128.0 + 6.0 * inside).clamp(0.0, 255.0) as u8,
        ]
    });
    let leaf = Material {
        base_color_texture: Some(Texture::plain(leaf)),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::lambert("leaf", Vec3::ONE)
    };
    let shape = Shape::quad(Vec3::new(-0.12, 0.0, 0.0), Vec3::X * 0.24, Vec3::Y * 0.6);
    let leaf = room.mesh(leaf, shape);
    room.lay(leaf, |p| Vec2::new(p.x / 0.24 + 0.5, 1.0 - p.y / 0.6));
    for index in 0..7 {
        let turn = 0.9 * f64::from(index);
        let transform = DAffine3::from_translation(DVec3::new(-0.75, 0.4, 0.45))
            * DAffine3::from_rotation_y(turn)
            * DAffine3::from_rotation_x(0.25 + 0.1 * f64::from(index % 3))
            // Every other one is mirrored.
            * DAffine3::from_scale(DVec3::ONE.with_x(f64::from(1 - index % 2 * 2)));
        room.place("leaf", leaf, transform);
    }
}

/// Adds a swinging lantern with an emissive texture of bright and dark panes. `speed` multiplies the speed of
/// the swing; with 0 the lantern stands still. If `pierced` is true, the alpha of a second texture cuts holes
/// into the panes.
fn lantern(stage: &mut Stage, speed: f64, pierced: bool) {
    let panes = stage
        .room
        .image("panes", 8, |x, y| match (x / 2 + y / 2) % 2 {
            0 => [255, 200, 120, 255],
            _ => [30, 10, 0, 255],
        });
    let mut paper = Material {
        emissive_texture: Some(Texture::plain(panes)),
        ..emitter("lantern", Vec3::splat(9.0))
    };
    if pierced {
        let is_open = |i: u32| matches!(i % 4, 1 | 2);
        let holes = stage.room.image("holes", 8, |x, y| {
            [
                255,
                255,
                255,
                if is_open(x) && is_open(y) { 0 } else { 255 },
            ]
        });
        paper.base_color_texture = Some(Texture::plain(holes));
        paper.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    }
    let half = Vec3::new(0.16, 0.2, 0.16);
    let low = Vec3::new(0.0, -0.75, 0.0) - half;
    let lantern = stage.room.mesh(paper, Shape::block(low, low + 2.0 * half));
    stage
        .room
        .lay(lantern, |p| Vec2::new((p.x + p.z) * 2.0, p.y * 2.0));
    let mut hook = at(-0.15, 2.4, 0.0);
    hook.rotation.track = swing(speed, 3.0, DVec3::Z, 0.3);
    let hook = stage.moving_node(None, hook);
    stage.hang("lantern", lantern, hook);
}

/// Adds the lights that have no surface: a candle (point light), a spot and the sun (directional light). The directions of
/// the spot and the sun swing; `speed` multiplies the speed of the swing, and with 0 they stand still.
fn lights(stage: &mut Stage, speed: f64) {
    let toward = |eye: DVec3, target: DVec3| look_at(eye, target, 1.0).camera_to_world;
    let candle = DAffine3::from_translation(DVec3::new(-0.9, 0.75, -1.2));
    let spot = toward(DVec3::new(1.2, 2.2, 1.2), DVec3::new(-0.3, 0.2, -0.6));
    let sun = toward(DVec3::new(3.0, 5.0, 2.0), DVec3::new(0.0, 0.0, 0.0));
    let cone = PunctualShape::Spot {
        inner: 0.15,
        outer: 0.4,
    };
    for (name, shape, intensity, transform, axis) in [
        (
            "candle",
            PunctualShape::Point,
            Vec3::new(0.5, 0.3, 0.1),
            candle,
            DVec3::Y,
        ),
        ("spot", cone, Vec3::new(2.0, 3.0, 4.0), spot, DVec3::X),
        (
            "sun",
            PunctualShape::Directional,
            Vec3::new(1.5, 1.4, 1.2),
            sun,
            DVec3::Y,
        ),
    ] {
        let (_, turn, position) = transform.to_scale_rotation_translation();
        let mut moving = at(position.x, position.y, position.z);
        moving.rotation.rest = turn;
        // Its own turn comes first.
        let node = stage.moving_node(None, moving);
        let mut swinging = at(0.0, 0.0, 0.0);
        swinging.rotation.track = swing(speed, 5.0, axis, 0.2);
        let node = stage.moving_node(Some(node), swinging);
        stage.motion.lights.push(Some(node));
        stage.room.0.punctual_lights.push(PunctualLight {
            name: name.into(),
            // It follows from its node.
            light_to_world: DAffine3::IDENTITY,
            shape,
            intensity,
            range: None,
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::procedural::generate;
    use crate::scene::requirements::Requirements;

    #[test]
    fn it_has_one_of_everything() {
        let scene = generate("conservatory", &[("speed".into(), "1".into())]).unwrap();
        let [_, lacks] = Requirements::of(&scene).features();
        assert_eq!(
            lacks,
            [
                "two-sided lights",
                "environment",
                "clear coats",
                "anisotropic lobes",
                "transmission",
                "specular textures",
                "16-bit textures",
                "blended lights",
                "backs that the camera does not see",
                "large triangles"
            ]
        );
    }
}
