//! The scene `motion`: a playroom in the evening, which tests every kind of motion and of interpolation between keyframes.
//! The camera, toys and lamps move, and the light that a sign and a fire emit changes. Lengths are in metres, and the floor
//! is at height 0.

use crate::base::random::Random;
use crate::procedural::modelling::stage::{Stage, at, repeated, swing};
use crate::procedural::modelling::{Builder, Model, Shape, dielectric, emitter, lathe, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::camera::look_at;
use crate::scene::motion::tracks::{Animated, Interpolation};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::TAU;

const SPEED: Range = Range::Real(0.0, 100.0);

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "camera",
        doc: "Speed of the camera's swing around the room; 0 stands still",
        default: "1",
        values: SPEED,
    },
    Parameter {
        name: "object",
        doc: "Speed of the carousel and the ball; 0 stands still",
        default: "1",
        values: SPEED,
    },
    Parameter {
        name: "light",
        doc: "Speed of the swinging lamp and the growing lantern; 0 stands still",
        default: "1",
        values: SPEED,
    },
    Parameter {
        name: "toggle",
        doc: "Speed at which the sign goes on and off and the fire flickers; 0 is steady",
        default: "1",
        values: SPEED,
    },
    Parameter {
        name: "seed",
        doc: "Seed of the books",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

pub(super) fn make(values: &Values) -> Scene {
    let speed = |name: &str| f64::from(values.real(name));
    let mut room = Builder::default();
    furnish(&mut room, &mut Random::new(values.whole("seed")));
    let mut stage = Stage::new(room);
    stage.sign(speed("toggle"));
    stage.fire(speed("toggle"));
    stage.carousel(speed("object"));
    stage.ball(speed("object"));
    stage.pendulum(speed("light"));
    stage.lantern(speed("light"));
    stage.camera(speed("camera"));
    stage.scene()
}

/// Adds everything in the playroom that does not move: the room and its furniture. `random` decides the sizes and colours of
/// the books on the shelf.
fn furnish(room: &mut Builder, random: &mut Random) {
    let wall = |name: &str, color: [f32; 3]| Material::lambert(name, Vec3::from(color));
    let (low, high) = (Vec3::new(-2.0, 0.0, -1.8), Vec3::new(2.0, 2.6, 3.8));
    let size = high - low;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let mut model = Model::default();
    let boards = dielectric("boards", Vec3::new(0.42, 0.26, 0.15), 0.35);
    model.add(&boards, Shape::quad(low, z, x));
    let plaster = wall("ceiling", [0.75, 0.74, 0.7]);
    model.add(&plaster, Shape::quad(low + y, x, z));
    let paper = wall("wallpaper", [0.5, 0.56, 0.6]);
    model.add(&paper, Shape::quad(low, x, y));
    model.add(&paper, Shape::quad(low + z, y, x));
    model.add(&wall("left wall", [0.6, 0.42, 0.3]), Shape::quad(low, y, z));
    let green = wall("right wall", [0.35, 0.52, 0.36]);
    model.add(&green, Shape::quad(low + x, z, y));

    let wood = dielectric("table", Vec3::new(0.5, 0.33, 0.2), 0.3);
    let foot = |y: f32| Vec3::new(0.0, y, 0.0);
    model.add(&wood, Shape::cylinder(foot(0.7), 0.75, 0.05, 20));
    model.add(&wood, Shape::cylinder(foot(0.03), 0.08, 0.67, 8));
    model.add(&wood, Shape::cylinder(foot(0.0), 0.4, 0.03, 12));

    // A shelf of books along the right wall.
    let white = wall("shelf", [0.7, 0.7, 0.68]);
    for height in [0.55, 1.15] {
        let middle = Vec3::new(1.86, height, 0.1);
        model.add(&white, Shape::chunk(middle, Vec3::new(0.26, 0.03, 1.8)));
        let mut at = -0.75;
        while at < 0.9 {
            let thick = random.between(0.05, 0.15);
            let tall = random.between(0.2, 0.32);
            let color = Vec3::new(random.unit(), random.unit(), random.unit()) * 0.5 + 0.15;
            let book = Vec3::new(1.87, height + 0.015 + tall / 2.0, at + thick / 2.0);
            let cover = wall("book", color.to_array());
            model.add(&cover, Shape::chunk(book, Vec3::new(0.2, tall, thick)));
            at += thick + random.between(0.005, 0.2);
        }
    }
    let iron = metal("stove", Vec3::splat(0.25), 0.4);
    model.add(
        &iron,
        Shape::chunk(Vec3::new(-1.5, 0.45, -1.3), Vec3::new(0.7, 0.9, 0.6)),
    );
    model.add(
        &iron,
        Shape::cylinder(Vec3::new(-1.5, 0.9, -1.4), 0.09, 1.7, 10),
    );
    room.add_model("room", model);
}

impl Stage {
    fn carousel(&mut self, speed: f64) {
        let mut hub = at(0.0, 0.75, 0.0);
        let turn = |phase: f64| DQuat::from_rotation_y(TAU * phase);
        let keys = [0.0, 0.25, 0.5, 0.75].map(|phase| (phase, [turn(phase)]));
        hub.rotation.track = repeated(speed, 6.0, Interpolation::Linear, &keys);
        let hub = self.moving_node(None, hub);

        let mut horse = Shape::chunk(Vec3::Y * 0.22, Vec3::new(0.1, 0.1, 0.22));
        horse.add(Shape::chunk(
            Vec3::new(0.0, 0.3, 0.1),
            Vec3::new(0.07, 0.14, 0.08),
        ));
        horse.add(Shape::chunk(Vec3::Y * 0.11, Vec3::new(0.03, 0.18, 0.03)));
        let horse = self
            .room
            .mesh(metal("brass", Vec3::new(0.9, 0.65, 0.3), 0.3), horse);
        for index in 0..5 {
            let transform = DAffine3::from_rotation_y(TAU * f64::from(index) / 5.0)
                * DAffine3::from_translation(DVec3::new(0.36, 0.0, 0.0));
            let node = self.node(Some(hub), transform);
            self.hang("horse", horse, node);
        }

        let red = dielectric("carousel", Vec3::new(0.6, 0.08, 0.1), 0.25);
        let mut body = Shape::cylinder(Vec3::ZERO, 0.5, 0.05, 16);
        body.add(Shape::cylinder(Vec3::Y * 0.05, 0.03, 0.6, 6));
        body.add(
            lathe(
                &[&[(0.0, 0.6), (0.52, 0.6)], &[(0.52, 0.6), (0.0, 0.85)]],
                8,
            )
            .flat(),
        );
        let body = self.room.mesh(red, body);
        self.hang("carousel", body, hub);
    }

    /// Adds a ball that bounces on the floor, which squashes it at each impact. `speed` multiplies the speed of the motion;
    /// with 0 the ball lies still.
    fn ball(&mut self, speed: f64) {
        const RADIUS: f64 = 0.18;
        const HEIGHT: f64 = 0.7;
        const PERIOD: f64 = 1.5;
        let mut ball = at(1.05, RADIUS, 0.95);
        ball.scale = Animated::still(DVec3::splat(RADIUS));
        let position = |height: f64| DVec3::new(1.05, RADIUS + height, 0.95);
        // A parabola, which a cubic spline with its tangents reproduces exactly.
        let slope = DVec3::Y * (4.0 * HEIGHT / PERIOD * speed);
        let keys = [
            (0.0, [-slope, position(0.0), slope]),
            (0.5, [DVec3::ZERO, position(HEIGHT), DVec3::ZERO]),
        ];
        ball.translation.track = repeated(speed, PERIOD, Interpolation::CubicSpline, &keys);
        let squashed = DVec3::new(1.12, 0.8, 1.12) * RADIUS;
        let round = DVec3::splat(RADIUS);
        let keys = [(0.0, [squashed]), (0.15, [round]), (0.85, [round])];
        ball.scale.track = repeated(speed, PERIOD, Interpolation::Linear, &keys);
        let node = self.moving_node(None, ball);
        let blue = dielectric("ball", Vec3::new(0.1, 0.2, 0.6), 0.15);
        let mesh = self.room.mesh(blue, Shape::sphere(1));
        self.hang("ball", mesh, node);
    }

    /// Adds a lamp that hangs on a cord from the ceiling and swings. `speed` multiplies the speed of the motion; with 0 the
    /// lamp hangs still.
    fn pendulum(&mut self, speed: f64) {
        let mut hook = at(-0.55, 2.6, 0.7);
        hook.rotation.track = swing(speed, 3.0, DVec3::new(0.3, 0.0, 1.0).normalize(), 0.35);
        let hook = self.moving_node(None, hook);
        let mut shade = Shape::cylinder(Vec3::Y * -0.75, 0.01, 0.75, 4);
        shade.add(lathe(&[&[(0.24, -0.95), (0.05, -0.75)]], 10).flat());
        let shade = self
            .room
            .mesh(Material::lambert("shade", Vec3::new(0.5, 0.1, 0.08)), shade);
        self.hang("lamp shade", shade, hook);
        let bulb = disc(Vec3::Y * -0.93, 0.17, 8);
        let bulb = self
            .room
            .mesh(emitter("bulb", Vec3::new(50.0, 38.0, 24.0)), bulb);
        self.hang("bulb", bulb, hook);
    }

    /// Adds a glowing paper lantern that grows and shrinks. `speed` multiplies the speed of the motion; with 0 the lantern
    /// stays small.
    fn lantern(&mut self, speed: f64) {
        let mut lantern = at(1.2, 1.95, -1.1);
        lantern.scale = Animated::still(DVec3::splat(0.17));
        let keys = [
            (0.0, [DVec3::splat(0.17)]),
            (0.5, [DVec3::new(0.23, 0.3, 0.23)]),
        ];
        lantern.scale.track = repeated(speed, 2.0, Interpolation::Linear, &keys);
        let node = self.moving_node(None, lantern);
        let paper = emitter("lantern", Vec3::new(4.0, 1.8, 0.7));
        let mesh = self.room.mesh(paper, Shape::sphere(1));
        self.hang("lantern", mesh, node);
    }

    /// Adds a glowing sign on the back wall, three arrowheads in a row, whose light switches on and off. `speed` multiplies
    /// the frequency of the switching; with 0 the light stays on.
    fn sign(&mut self, speed: f64) {
        let color = Vec3::new(0.3, 0.75, 1.0);
        let mut arrow = Shape::default();
        let (right, up) = (Vec3::X, Vec3::Y * 0.07);
        for tip in [0.0, 0.28, 0.56] {
            let tip = Vec3::new(-0.7 + tip, 1.85, -1.55);
            let wing = Vec3::new(-0.18, 0.18, 0.0);
            arrow.add(Shape::quad(tip + wing, -wing, up + right * 0.07));
            let wing = Vec3::new(-0.18, -0.18, 0.0);
            arrow.add(Shape::quad(tip + wing, right * 0.07 - up, -wing));
        }
        let keys = [(0.0, [24.0]), (0.5, [0.0])];
        let strength = repeated(speed, 0.5, Interpolation::Step, &keys);
        self.emit(color, 24.0, None, strength);
        let mesh = self.room.mesh(emitter("sign", color * 24.0), arrow);
        self.room.place("sign", mesh, DAffine3::IDENTITY);
    }

    /// Adds the window of the stove. It glows, and its radiance changes over time, as if a fire flickered behind it. `speed`
    /// multiplies the speed of the change; with 0 the radiance is constant.
    fn fire(&mut self, speed: f64) {
        let color = Vec3::new(1.0, 0.4, 0.12);
        let bright = color.as_dvec3();
        let keys = [
            (0.0, [bright]),
            (0.3, [bright * 0.3]),
            (0.45, [bright * 0.8]),
            (0.8, [bright * 0.2]),
        ];
        let flicker = repeated(speed, 1.2, Interpolation::Linear, &keys);
        let corner = Vec3::new(-1.72, 0.35, -0.99);
        let window = Shape::quad(corner, Vec3::X * 0.44, Vec3::Y * 0.36);
        self.emit(color, 12.0, flicker, None);
        let mesh = self.room.mesh(emitter("fire", color * 12.0), window);
        self.room.place("fire", mesh, DAffine3::IDENTITY);
    }

    fn camera(&mut self, speed: f64) {
        let (eye, target) = (DVec3::new(0.35, 1.6, 3.5), DVec3::new(0.0, 1.05, 0.0));
        self.room.camera(eye, target, 48.0, 4.0 / 3.0);
        let mut pivot = at(0.0, 0.0, 0.0);
        pivot.rotation.track = swing(speed, 8.0, DVec3::Y, 0.3);
        let pivot = self.moving_node(None, pivot);
        let transform = look_at(eye, target, 1.0).camera_to_world;
        let node = self.node(Some(pivot), transform);
        self.motion.cameras.push(Some(node));
    }
}

/// A flat disc that faces down, for the light of the swinging lamp. It has `sides` triangles around its
/// centre `middle`, and the radius `radius`, in metres.
fn disc(middle: Vec3, radius: f32, sides: u32) -> Shape {
    let rim = |i: u32| {
        let turn = std::f32::consts::TAU * (i % sides) as f32 / sides as f32;
        middle + radius * Vec3::new(turn.cos(), 0.0, turn.sin())
    };
    let corners: Vec<Vec3> = (0..sides)
        .flat_map(|i| [middle, rim(i), rim(i + 1)])
        .collect();
    Shape::triangles(&corners)
}

#[cfg(test)]
mod tests {
    use crate::procedural::generate;

    #[test]
    fn each_speed_moves_its_own() {
        let moves = |still: &[&str]| {
            let settings = still
                .iter()
                .map(|name| ((*name).to_owned(), "0".to_owned()));
            let scene = generate("motion", &settings.collect::<Vec<_>>()).unwrap();
            assert!(scene.triangle_count() < 1000, "{}", scene.triangle_count());
            scene.motion.map_or((0, 0, 0), |motion| {
                let count = |list: &[Option<u32>]| list.iter().flatten().count();
                (
                    count(&motion.instances),
                    count(&motion.cameras),
                    motion.emission.len(),
                )
            })
        };
        assert_eq!(moves(&[]), (10, 1, 2));
        assert_eq!(moves(&["camera"]), (10, 0, 2));
        assert_eq!(moves(&["object", "toggle"]), (3, 1, 0));
        assert_eq!(moves(&["light", "camera"]), (7, 0, 2));
        assert_eq!(moves(&["camera", "object", "light", "toggle"]), (0, 0, 0));
    }
}
