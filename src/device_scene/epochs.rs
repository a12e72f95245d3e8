//! A scene that moves, in two epochs: the buffers hold the current frame and then the previous frame.

use super::lights::Lights;
use super::pose::{ScenePose, ScenePoser};
use crate::scene::Motion;
use crate::shader_interface::{
    GpuInstance, GpuLight, GpuLightChoice, GpuPreviousTransform, GpuPunctualLight,
};
use crate::{Error, Result};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::{Mutex, MutexGuard};

/// The contents of the buffers that differ by epoch: the current epoch and, where something moves, the previous epoch.
pub struct EpochContents {
    /// Nodes of the trees over the instances.
    pub nodes: Vec<CwBvhNode>,
    /// Instances in the order of those trees' leaves.
    pub top_instances: Vec<u32>,
    /// Instances.
    pub instances: Vec<GpuInstance>,
    /// Emissive triangles.
    pub lights: Vec<GpuLight>,
    /// Punctual lights.
    pub punctual_lights: Vec<GpuPunctualLight>,
    /// The alias table that selects lights of the current epoch.
    pub light_choices: Vec<GpuLightChoice>,
}

impl EpochContents {
    /// The contents for one or two poses. Every tree over the instances has space for `room` nodes; the nodes of the meshes
    /// follow the trees.
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

/// A scene that moves, and its poses in both epochs.
pub struct MovingScene {
    motion: Motion,
    poser: ScenePoser,
    /// The number of nodes reserved for each of the two trees over the instances.
    pub room: usize,
    /// Number of instances in the scene, before any were merged.
    instance_count: usize,
    /// The poses of the current and of the previous frame.
    poses: Mutex<[ScenePose; 2]>,
}

/// The result of a change of time.
pub struct PoseChange<'a> {
    /// The current and the previous pose.
    pub poses: MutexGuard<'a, [ScenePose; 2]>,
    /// True if the current pose has become the previous one.
    pub advanced: bool,
    /// True for each pose (current, previous) that is new after the change.
    pub new: [bool; 2],
    /// For each of the scene's instances, the transform of its points from the current to the previous frame.
    pub previous_transforms: Vec<GpuPreviousTransform>,
}

impl MovingScene {
    /// A scene of `instance_count` instances with the same pose in both epochs.
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

    /// Sets the times of the current and the previous frame, in seconds; `None` if they are set already.
    ///
    /// # Errors
    /// At one of them an instance is further away than can be rendered.
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

    /// The lights of the current pose and the time of that pose in seconds; `None` if that time is `known`.
    ///
    /// # Errors
    /// Posing the scene failed in another thread.
    pub fn moved_lights(&self, known: f64) -> Result<Option<(Lights, f64)>> {
        let now = &self.lock()?[0];
        Ok((now.time != known).then(|| (now.lights.clone(), now.time)))
    }

    /// For each of the scene's instances, the transform of its points from the current to the previous frame.
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
