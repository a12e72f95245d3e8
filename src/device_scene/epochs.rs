//! A scene that moves. The device holds it twice: in its state in the current frame (epoch 0) and in its state in the
//! previous frame (epoch 1), so that passes that reuse samples of the previous frame can trace rays and evaluate lights
//! as they were then. A buffer that depends on time holds the elements of the current frame, then those of the previous
//! frame.

use super::lights::Lights;
use super::pose::{ScenePose, ScenePoser};
use crate::scene::Motion;
use crate::shader_interface::{
    GpuInstance, GpuLight, GpuLightChoice, GpuPreviousTransform, GpuPunctualLight,
};
use crate::{Error, Result};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::{Mutex, MutexGuard};

/// The contents of the buffers that depend on time; they are uploaded whenever the time changes. Unless its comment
/// states otherwise, each array holds the elements of the current frame and, if something moves, then those of the
/// previous frame.
pub struct EpochContents {
    /// The nodes of the trees over the instances: one tree for the current frame and, if something moves, one for the
    /// previous frame. Later the nodes of the meshes' trees, which do not depend on time, are appended.
    pub nodes: Vec<CwBvhNode>,
    /// For each leaf of the trees over the instances, in the order of the leaves: the index in `instances` of the leaf's
    /// instance. Shaders that traverse a tree find by it which instance a ray meets.
    pub top_instances: Vec<u32>,
    /// All instances that rays can meet, as shaders read them: with their transforms in the current frame and, if something
    /// moves, once more with those in the previous frame.
    pub instances: Vec<GpuInstance>,
    /// All emissive triangles in the device's world space, which shaders draw as lights: as they are in the current frame
    /// and, if something moves, once more as they were in the previous frame.
    pub lights: Vec<GpuLight>,
    /// All punctual lights, in the device's world space and units, as they are in the current frame and, if something moves,
    /// once more as they were in the previous frame.
    pub punctual_lights: Vec<GpuPunctualLight>,
    /// Alias tables that draw lights; they are of the current frame only. The first draws from all lights. If some lights
    /// are rare (far dimmer than the others, and sampled separately), two more follow: one draws the lights that are not
    /// rare, and one draws the rare lights.
    pub light_choices: Vec<GpuLightChoice>,
}

impl EpochContents {
    /// Assembles the contents of the buffers from one pose (state of the scene at one time) if nothing moves, or from the
    /// poses of the current and the previous frame. `room` is the number of nodes that are reserved in `nodes` for each
    /// pose's tree over the instances. The caller appends the nodes of the meshes' trees behind all reserved nodes; the
    /// instances already refer to them there.
    pub fn new(poses: &[&ScenePose], room: usize) -> Self {
        let mut contents = Self {
            nodes: Vec::new(),
            top_instances: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            punctual_lights: Vec::new(),
            light_choices: Vec::new(),
        };
        let mesh_nodes = (poses.len() * room) as u32;
        for (epoch, pose) in poses.iter().enumerate() {
            let (first_node, first) = (epoch * room, epoch * pose.instances.len());
            // The nodes that a tree does not need are never read.
            contents.nodes.resize(first_node, CwBvhNode::default());
            contents.top_instances.resize(first, 0);
            let placed = pose.top.placed(first_node as u32, first as u32);
            contents.nodes.extend(placed);
            let leaves = pose.top.order.iter();
            let instance_at = |leaf: &u32| pose.visible[*leaf as usize] + first as u32;
            contents.top_instances.extend(leaves.map(instance_at));
            let instances = pose.instances.iter().map(|instance| GpuInstance {
                root_node: instance.root_node + mesh_nodes,
                ..*instance
            });
            contents.instances.extend(instances);
            contents.lights.extend(&pose.lights.triangles);
            contents.punctual_lights.extend(&pose.lights.punctual);
            if epoch == 0 {
                contents.light_choices.extend(&pose.lights.choices);
                contents.light_choices.extend(&pose.lights.common_choices);
                contents.light_choices.extend(&pose.lights.rare_choices);
            }
        }
        contents
            .nodes
            .resize(mesh_nodes as usize, CwBvhNode::default());
        if let [_, _, ..] = poses {
            let instances = contents.instances.len();
            contents.top_instances.resize(instances, 0);
        }
        contents
    }
}

/// A scene that moves, with its poses (states at one time) in the current and in the previous frame. It computes the
/// poses of new times, from which the buffers on the device are updated.
pub struct MovingScene {
    motion: Motion,
    poser: ScenePoser,
    /// The number of nodes that are reserved for the tree over the instances, separately for the current and for the
    /// previous frame, because the tree changes with time and its buffer cannot grow. It is also the index of the root
    /// of the previous frame's tree in the buffer `nodes`.
    pub room: usize,
    /// The number of instances in the original scene, before static meshes are merged. For each of them, shaders need
    /// the transform to its previous position.
    instance_count: usize,
    /// The pose of the current frame, then the pose of the previous frame. They are the poses that the device's buffers
    /// contain.
    poses: Mutex<[ScenePose; 2]>,
}

/// The result of a change of time: the poses (states of the scene at one time), and which parts of the device's data must
/// be updated.
pub struct PoseChange<'a> {
    /// The locked poses: that of the current frame, then that of the previous frame. While this guard exists, other threads
    /// cannot change the poses. The caller keeps the guard until it has written them to the buffers on the device.
    pub poses: MutexGuard<'a, [ScenePose; 2]>,
    /// True if the pose that was current is now the previous one, so that its acceleration structure can be reused;
    /// false after a jump in time.
    pub advanced: bool,
    /// One flag for the current and one for the previous pose, in this order: true if this change computed the pose
    /// anew, so that its acceleration structure must be rebuilt.
    pub new: [bool; 2],
    /// For each instance of the scene (counted before static meshes are merged), the transform that takes a point of the
    /// instance, in the device's world space, from its current position to its position in the previous frame. Motion
    /// vectors and the reuse of earlier samples need it.
    pub previous_transforms: Vec<GpuPreviousTransform>,
}

impl MovingScene {
    /// Makes a moving scene with `instance_count` instances, counted before static meshes are merged. At first `pose` is
    /// both its current and its previous pose. `room` is the number of nodes reserved for each pose's tree over the
    /// instances.
    pub fn new(
        motion: Motion,
        poser: ScenePoser,
        room: usize,
        instance_count: usize,
        pose: ScenePose,
    ) -> Self {
        Self {
            motion,
            poser,
            room,
            instance_count,
            poses: Mutex::new([pose.clone(), pose]),
        }
    }

    /// Sets the times of the current frame (`now`) and of the previous frame (`before`), in seconds, and computes the
    /// poses that are missing. Returns what the caller must update on the device; `None` if both times are already set.
    ///
    /// # Errors
    /// At one of the times, the transform of an instance or punctual light is not finite or reaches further than can be
    /// rendered; or posing the scene failed in another thread.
    pub fn set_times(&self, now: f64, before: f64) -> Result<Option<PoseChange<'_>>> {
        let mut poses = self.lock()?;
        if poses[0].time == now && poses[1].time == before {
            return Ok(None);
        }
        let advanced = poses[0].time == before;
        let kept = |epoch: usize| if advanced { 1 - epoch } else { epoch };
        let missing = |epoch: usize, time: f64| {
            (poses[kept(epoch)].time != time)
                .then(|| self.poser.pose_at(time, self.motion.pose(time)))
                .transpose()
        };
        // Everything that can fail comes first, so that after an error the poses are still those on the device.
        let made = [missing(0, now)?, missing(1, before)?];
        if advanced {
            poses.reverse();
        }
        let new = made.each_ref().map(Option::is_some);
        for (kept, made) in poses.iter_mut().zip(made) {
            if let Some(made) = made {
                *kept = made;
            }
        }
        Ok(Some(PoseChange {
            previous_transforms: self.transforms_between(&poses),
            poses,
            advanced,
            new,
        }))
    }

    /// The lights of the current pose, and the time of that pose in seconds; the light BVH is fitted to them. `known`
    /// is the time of the lights that the caller has: if it is the time of the pose, returns `None`.
    ///
    /// # Errors
    /// Posing the scene failed in another thread.
    pub fn moved_lights(&self, known: f64) -> Result<Option<(Lights, f64)>> {
        let now = &self.lock()?[0];
        Ok((now.time != known).then(|| (now.lights.clone(), now.time)))
    }

    /// For each instance of the scene (counted before static meshes are merged), the transform that takes a point of the
    /// instance, in the device's world space, from its current position to its position in the previous frame. These
    /// transforms are the first content of the buffer `previous_transforms`, with which shaders find where a point was.
    ///
    /// # Errors
    /// Posing the scene failed in another thread.
    pub fn previous_transforms(&self) -> Result<Vec<GpuPreviousTransform>> {
        Ok(self.transforms_between(&*self.lock()?))
    }

    fn transforms_between(&self, [now, before]: &[ScenePose; 2]) -> Vec<GpuPreviousTransform> {
        self.poser
            .previous_transforms(self.instance_count, now, before)
    }

    fn lock(&self) -> Result<MutexGuard<'_, [ScenePose; 2]>> {
        (self.poses.lock()).map_err(|_| Error::failed("posing the scene failed in another thread"))
    }
}
