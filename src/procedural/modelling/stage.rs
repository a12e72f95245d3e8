//! A builder for scenes in which objects move, and functions that make their animation tracks.

use super::Builder;
use crate::scene::motion::tracks::{Animated, Interpolation, Keyed, Track};
use crate::scene::motion::{AnimatedTransform, Emission, Node, Transform};
use crate::scene::{Motion, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::TAU;

/// The minimum duration of a repeating animation track, in seconds. The track repeats its period a whole number of times,
/// until it has lasted at least this long. After its end, its value stays constant.
const LENGTH: f64 = 16.0;

/// A scene that is still being built, together with the motion of its objects. [`Stage::scene`] joins the two when all
/// objects have been added.
pub struct Stage {
    /// The builder of the scene's meshes, materials and instances. Objects that do not move are added to it
    /// directly.
    pub room: Builder,
    /// The motion of the scene's instances, cameras, lights and emission so far. [`Stage::scene`] puts it into the scene.
    pub motion: Motion,
}

impl Stage {
    pub fn new(room: Builder) -> Self {
        Self {
            room,
            motion: Motion::default(),
        }
    }

    /// Finishes the construction, and returns the scene with the motion of its objects. Objects without a
    /// node of the motion stay where they are.
    pub fn scene(mut self) -> Scene {
        let mut scene = self.room.0;
        self.motion.instances.resize(scene.instances.len(), None);
        self.motion.cameras.resize(scene.cameras.len(), None);
        self.motion.lights.resize(scene.punctual_lights.len(), None);
        scene.motion = Some(self.motion);
        scene
    }

    /// Adds a node of the scene's tree of transforms, without an animation of its own. `transform` converts positions from
    /// the coordinates of the node to those of the node `parent`, or to world space if `parent` is `None`. Returns the
    /// node's index.
    pub fn node(&mut self, parent: Option<u32>, transform: DAffine3) -> u32 {
        self.push(parent, Transform::Fixed(transform))
    }

    pub fn moving_node(&mut self, parent: Option<u32>, moving: AnimatedTransform) -> u32 {
        self.push(parent, Transform::Moving(Box::new(moving)))
    }

    fn push(&mut self, parent: Option<u32>, transform: Transform) -> u32 {
        self.motion.nodes.push(Node { parent, transform });
        self.motion.nodes.len() as u32 - 1
    }

    /// Adds an instance of the mesh with the index `mesh`, which moves with the node with the index `node`. The transform of
    /// the instance is that of the node.
    pub fn hang(&mut self, name: &str, mesh: u32, node: u32) {
        self.motion
            .instances
            .resize(self.room.0.instances.len(), None);
        self.motion.instances.push(Some(node));
        // Its transform follows from its node.
        self.room.place(name, mesh, DAffine3::IDENTITY);
    }

    /// Animates the emission of a material. The caller must add this material to [`Self::room`] right after this call,
    /// before any other material. The emitted radiance is `color` (linear RGB) × `strength`, in W/(m²·sr). A track (values
    /// over time) in `colors` or `strengths` replaces the constant colour or strength; with `None`, it stays constant.
    pub fn emit(
        &mut self,
        color: Vec3,
        strength: f64,
        colors: Option<Track<DVec3>>,
        strengths: Option<Track<f64>>,
    ) {
        self.motion.emission.push(Emission {
            material: self.room.0.materials.len() as u32,
            color: Animated {
                rest: color.as_dvec3(),
                track: colors,
            },
            strength: Animated {
                rest: strength,
                track: strengths,
            },
        });
    }
}

/// A transform that only translates, by `x`, `y` and `z` metres along the axes. It has no animation tracks, so that it is
/// constant until the caller sets some.
pub fn at(x: f64, y: f64, z: f64) -> AnimatedTransform {
    AnimatedTransform::still(DVec3::new(x, y, z), DQuat::IDENTITY, DVec3::ONE)
}

/// A track of a pendulum's rotation around the unit vector `axis`. The angle is a sine of time with the amplitude `most` in
/// radians and a period of `period` / `speed` seconds. `None` if `speed` is 0, since nothing moves then.
pub fn swing(speed: f64, period: f64, axis: DVec3, most: f64) -> Option<Track<DQuat>> {
    let keys = [0.0, 0.25, 0.5, 0.75].map(|phase| {
        let (sine, cosine) = (TAU * phase).sin_cos();
        let half = most * sine / 2.0;
        let slope = most * cosine * TAU / period * speed / 2.0;
        let value = DQuat::from_axis_angle(axis, 2.0 * half);
        let side = axis * half.cos() * slope;
        let slope = DQuat::from_xyzw(side.x, side.y, side.z, -half.sin() * slope);
        (phase, [slope, value, slope])
    });
    repeated(speed, period, Interpolation::CubicSpline, &keys)
}

/// A track that repeats `keys` for at least 16 s, and ends with the value with which it starts. Each key has a time, as a
/// fraction of the period, and one value; for cubic splines, the value stands between its two tangents. The period is
/// `period` / `speed` seconds. The result is `None` if `speed` is 0.
pub fn repeated<T: Keyed, const N: usize>(
    speed: f64,
    period: f64,
    interpolation: Interpolation,
    keys: &[(f64, [T; N])],
) -> Option<Track<T>> {
    if speed <= 0.0 {
        return None;
    }
    let cycles = (LENGTH * speed / period).ceil().max(1.0) as u32;
    let mut track = Track {
        interpolation,
        times: Vec::new(),
        values: Vec::new(),
    };
    for cycle in 0..cycles {
        for (phase, values) in keys {
            track
                .times
                .push((f64::from(cycle) + phase) * period / speed);
            track.values.extend(values);
        }
    }
    track.times.push(f64::from(cycles) * period / speed);
    track.values.extend(keys[0].1);
    Some(track)
}
