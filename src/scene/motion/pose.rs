//! The pose of a scene: the state, at one time, of everything that moves. The renderer draws each frame in the pose at the
//! frame's time.

use super::deformation::Shape;
use super::{Motion, Transform};
use crate::scene::validate::{LARGEST_COORDINATE, check_reach, is_singular};
use crate::scene::{Bounds, Camera, Mesh, Scene, camera};
use crate::{Error, Result};
use glam::{DAffine3, DVec3, Vec3};

/// The state of everything that moves, at one time, from which the renderer computes transforms and lights for one frame.
/// Each field lists only the elements that move, as pairs: the index of the element in the scene's list of its kind, and its
/// transform or emission at that time. All other elements are as the scene states them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The moving instances: the index in [`Scene::instances`], in ascending order, and the transform from object to world
    /// space.
    pub instances: Vec<(u32, DAffine3)>,
    /// The moving cameras: the index in [`Scene::cameras`], in ascending order, and the transform of the camera's node to
    /// world space. This transform may include scale, which is removed to obtain the camera's own transform.
    pub cameras: Vec<(u32, DAffine3)>,
    /// The moving punctual lights: the index in [`Scene::punctual_lights`], in ascending order, and the light's transform to
    /// world space. The transform may include scale, which has no effect on a light.
    pub lights: Vec<(u32, DAffine3)>,
    /// The materials whose emission changes: the index in [`Scene::materials`], and the emitted linear RGB radiance in
    /// W/(m²·sr).
    pub emission: Vec<(u32, Vec3)>,
    /// The shapes of the meshes that deform, in the order of [`Motion::deformations`].
    pub shapes: Vec<Shape>,
}

impl Motion {
    /// Computes the pose at `time` (in seconds): the transforms of all instances, cameras and lights that
    /// move, the emissions that change, and the shapes of the meshes that deform. The renderer draws a frame in the pose at the frame's time.
    pub fn pose(&self, time: f64) -> Pose {
        let mut to_world: Vec<DAffine3> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let local = match &node.transform {
                Transform::Fixed(transform) => *transform,
                Transform::Moving(moving) => moving.at(time),
            };
            to_world.push(match node.parent {
                Some(parent) => to_world[parent as usize] * local,
                None => local,
            });
        }
        let placed = |nodes: &[Option<u32>]| -> Vec<(u32, DAffine3)> {
            let attached = (0..).zip(nodes);
            attached
                .filter_map(|(index, node)| Some((index, to_world[(*node)? as usize])))
                .collect()
        };
        Pose {
            instances: placed(&self.instances),
            cameras: placed(&self.cameras),
            lights: placed(&self.lights),
            emission: self
                .emission
                .iter()
                .map(|emission| (emission.material, emission.at(time)))
                .collect(),
            shapes: (self.deformations.iter())
                .map(|deformation| deformation.shape(time, &to_world))
                .collect(),
        }
    }
}

impl Scene {
    /// A copy of the scene without motion, in its state at `time` (in seconds): meshes that deform have their shape at that
    /// time. It is rendered like a scene in which nothing moves.
    ///
    /// # Errors
    /// At that time the transform of an instance, a punctual light or a camera is not finite; an instance, a light or a vertex
    /// of a mesh that deforms has a coordinate above [`LARGEST_COORDINATE`]; or a camera has a scale of 0 or its axes in one plane, so that it has no
    /// direction.
    pub fn pose_at(&self, time: f64) -> Result<Self> {
        let mut still = self.clone();
        still.take_pose(time)?;
        still.motion = None;
        Ok(still)
    }

    /// The camera with the index `index` in [`Scene::cameras`], in its state at `time` (in seconds).
    ///
    /// # Errors
    /// The scene has no camera with this index, or the camera's transform at that time is not finite, has a scale of 0, or
    /// has its axes in one plane.
    pub fn camera_at(&self, index: usize, time: f64) -> Result<Camera> {
        let mut camera = self.cameras.get(index).cloned().ok_or_else(|| {
            Error::input(format!(
                "camera {index} is out of range, there are {}",
                self.cameras.len()
            ))
        })?;
        if let Some(motion) = &self.motion {
            let pose = motion.pose(time);
            if let Some((_, transform)) = pose.cameras.iter().find(|(i, _)| *i as usize == index) {
                camera.camera_to_world = rigid_camera(index, transform, time)?;
            }
        }
        Ok(camera)
    }

    /// Sets the scene to its state at `time` (in seconds): the transforms of instances, cameras and lights, the emission of
    /// materials, and the shapes of meshes that deform. A scene without motion stays unchanged. Fails if a transform is not
    /// finite, if an instance, a light or a vertex of a mesh that deforms is too far from the origin, or if a camera has no direction. After an error, some elements may already be changed.
    pub(crate) fn take_pose(&mut self, time: f64) -> Result<()> {
        let Some(motion) = &self.motion else {
            return Ok(());
        };
        let pose = motion.pose(time);
        for (deformation, shape) in motion.deformations.iter().zip(&pose.shapes) {
            let vertices = deformation.deform(shape);
            let mesh = &mut self.meshes[deformation.mesh as usize];
            check_vertices(&mesh.name, &vertices.positions, time)?;
            mesh.positions = vertices.positions;
            mesh.normals = vertices.normals;
            mesh.tangents = vertices.tangents;
        }
        // Once for each mesh, in however many places it stands.
        let boxes: Vec<_> = self.meshes.iter().map(Mesh::bounds).collect();
        for (index, transform) in pose.instances {
            let instance = &mut self.instances[index as usize];
            let bounds = boxes[instance.mesh as usize].as_ref();
            check_transform(index, &transform, bounds, time, LARGEST_COORDINATE)?;
            instance.object_to_world = transform;
        }
        for (index, transform) in pose.cameras {
            let transform = rigid_camera(index as usize, &transform, time)?;
            self.cameras[index as usize].camera_to_world = transform;
        }
        for (index, transform) in pose.lights {
            check_light_transform(index, &transform, time, LARGEST_COORDINATE)?;
            self.punctual_lights[index as usize].light_to_world = transform;
        }
        for (index, emission) in pose.emission {
            self.materials[index as usize].emission = emission;
        }
        Ok(())
    }
}

fn rigid_camera(index: usize, transform: &DAffine3, time: f64) -> Result<DAffine3> {
    match camera::rigid(transform.matrix3) {
        Some(axes) if transform.is_finite() => {
            Ok(DAffine3::from_mat3_translation(axes, transform.translation))
        }
        _ => Err(Error::input(format!(
            "camera {index}: at {time} s it has no direction, since its scale is 0 or its axes are in one plane"
        ))),
    }
}

/// Checks that a deformed mesh can be rendered. `name` is the name of the mesh and `time`, in seconds, the time of its shape,
/// for messages.
///
/// # Errors
/// A coordinate is not finite or beyond [`LARGEST_COORDINATE`].
pub fn check_vertices(name: &str, positions: &[Vec3], time: f64) -> Result<()> {
    let limit = LARGEST_COORDINATE as f32;
    let wrong = |p: &&Vec3| !p.abs().cmple(Vec3::splat(limit)).all();
    match positions.iter().find(wrong) {
        None => Ok(()),
        Some(position) => Err(Error::input(format!(
            "mesh \"{name}\" at {time} s: its joints or morph targets move a vertex to {position}, and {LARGEST_COORDINATE:e} is as far as can be rendered"
        ))),
    }
}

/// True if the transform flattens an instance onto a plane, a line or a point. Such an instance has no normals, so the
/// renderer leaves it out as long as it is flat.
pub fn is_flat(object_to_world: &DAffine3) -> bool {
    is_singular(object_to_world.matrix3)
}

/// Checks that the instance `index` can be rendered with `transform`. `bounds` is the bounding box of its mesh before the
/// transform, or `None` for an empty mesh. `farthest` is the largest absolute coordinate that is allowed after the
/// transform. `time`, in seconds, is the time of the transform, for messages.
///
/// # Errors
/// The transform is not finite, or a corner of the transformed box has a coordinate beyond `farthest`. The message names the
/// instance and the time.
pub fn check_transform(
    index: u32,
    transform: &DAffine3,
    bounds: Option<&Bounds>,
    time: f64,
    farthest: f64,
) -> Result<()> {
    let what = format!("instance {index} at {time} s");
    check_reach(&what, transform, bounds, farthest)
}

/// Checks that the punctual light `index` can be rendered at the position to which `transform` moves it. `farthest` is the
/// largest absolute coordinate that this position may have. `time`, in seconds, is the time of the transform, for messages.
///
/// # Errors
/// The transform is not finite, or a coordinate of the position exceeds `farthest`. The message names the light and the
/// time.
pub fn check_light_transform(
    index: u32,
    transform: &DAffine3,
    time: f64,
    farthest: f64,
) -> Result<()> {
    let what = format!("punctual light {index} at {time} s");
    let point = Bounds {
        min: DVec3::ZERO,
        max: DVec3::ZERO,
    };
    check_reach(&what, transform, Some(&point), farthest)
}

#[cfg(test)]
mod tests {
    use super::super::Emission;
    use super::super::tests::{line, moving, node};
    use super::super::tracks::Animated;
    use super::*;

    #[test]
    fn a_pose_goes_down_the_tree() {
        let turn = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let motion = Motion {
            nodes: vec![
                node(None, moving(DVec3::X)),
                node(Some(0), Transform::Fixed(turn)),
                node(Some(1), moving(DVec3::X * 4.0)),
            ],
            instances: vec![Some(2), None, Some(1)],
            cameras: vec![Some(0)],
            lights: vec![],
            emission: vec![Emission {
                material: 3,
                color: Animated {
                    rest: DVec3::ONE,
                    track: line(DVec3::new(2.0, -1.0, 0.0)),
                },
                strength: Animated::still(3.0),
            }],
            deformations: vec![],
        };
        assert_eq!(
            motion.check([3, 1, 0, 4]).map_err(|e| e.to_string()),
            Ok(())
        );
        let pose = motion.pose(0.5);
        let indices: Vec<u32> = pose.instances.iter().map(|(index, _)| *index).collect();
        assert_eq!(indices, [0, 2]);
        let at = pose.instances[0].1.translation;
        assert!((at - DVec3::new(0.5, 2.0, 0.0)).length() < 1e-12, "{at}");
        assert!(pose.instances[1].1.matrix3.x_axis.y > 1.0 - 1e-12);
        assert_eq!(pose.cameras[0].1.translation, DVec3::X * 0.5);
        assert_eq!(pose.emission, [(3, Vec3::new(3.0, 0.0, 0.0))]);
    }

    #[test]
    fn lights_that_move_out_of_reach_are_refused() {
        let at = |x: f64| DAffine3::from_translation(DVec3::X * x);
        assert!(check_light_transform(7, &at(99.0), 2.0, 100.0).is_ok());
        for transform in [at(101.0), at(f64::NAN), at(f64::INFINITY)] {
            let text = check_light_transform(7, &transform, 2.0, 100.0).unwrap_err();
            assert!(text.to_string().starts_with("punctual light 7 at 2 s"));
        }
    }
}
