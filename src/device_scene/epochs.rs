//! A scene that moves. The device holds it twice: in its state in the current frame (epoch 0) and in its state in the
//! previous frame (epoch 1), so that passes that reuse samples of the previous frame can trace rays and evaluate lights
//! as they were then. A buffer that depends on time holds the elements of the current frame, then those of the previous
//! frame.

use super::deforming::ShapeBuffers;
use super::lights::Lights;
use super::pose::{ScenePose, ScenePoser};
use crate::scene::Motion;
use crate::shader_interface::{
    GpuInstance, GpuLight, GpuLightChoice, GpuPreviousTransform, GpuPunctualLight,
};
use crate::{Error, Result};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::{Mutex, MutexGuard};

/// The contents of the buffers that depend on time; they are uploaded whenever the time changes. Unless the comment of an
/// array states otherwise, the array first holds the elements as they are in the current frame. If something moves, the
/// elements as they were in the previous frame follow.
pub struct EpochContents {
    /// The nodes of the bounding volume hierarchies (trees) over the instances, in which compute shaders find the instances
    /// that a ray may hit: one tree for the current frame and, if something moves, one for the previous frame. Later the
    /// nodes of the meshes' trees, which do not depend on time, are appended.
    pub nodes: Vec<CwBvhNode>,
    /// The instance of each leaf of the trees over the instances: an index in `instances`. The entries have the order of the
    /// leaves. A shader that traverses such a tree reads here which instance the ray enters at a leaf.
    pub top_instances: Vec<u32>,
    /// All instances after static meshes are merged, as shaders read them, with their transforms in the current frame. If
    /// something moves, the same instances follow with their transforms in the previous frame.
    pub instances: Vec<GpuInstance>,
    /// All emissive triangles in the device's world space, on which light samples draw points. They are stored as they are
    /// in the current frame and, if something moves, once more as they were in the previous frame.
    pub lights: Vec<GpuLight>,
    /// All punctual lights, in the device's world space and units, as they are in the current frame and, if something moves,
    /// once more as they were in the previous frame.
    pub punctual_lights: Vec<GpuPunctualLight>,
    /// Alias tables by which light samples draw a light at random. Unlike the other arrays, they exist only for the current
    /// frame. The first table draws from all lights. If some lights are rare (far dimmer than the others, and sampled
    /// separately), two tables follow: one for the lights that are not rare, and one for the rare lights.
    pub light_choices: Vec<GpuLightChoice>,
}

impl EpochContents {
    /// Assembles the contents of the buffers from poses (states of the scene at one time): one pose if nothing moves,
    /// otherwise those of the current and of the previous frame. `nodes` gets `room` nodes for each pose's tree over the
    /// instances. The caller must append the nodes of the meshes' trees to `nodes`; the instances already contain the final
    /// indices of these trees' roots.
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
    /// The number of nodes that are reserved in the buffer `nodes` for one tree over the instances, because the tree changes
    /// with time and the buffer cannot grow. The trees of the current and of the previous frame each get as many. So this
    /// number is also the index of the root of the previous frame's tree.
    pub room: usize,
    /// The number of instances in the original scene, before static meshes are merged. Each of them has an entry in
    /// [`PoseChange::previous_transforms`].
    instance_count: usize,
    /// The pose (state of the scene at one time) of the current frame, then that of the previous frame. The buffers on the
    /// device were filled from these two poses, so [`Self::set_times`] computes only poses of other times.
    poses: Mutex<[ScenePose; 2]>,
}

/// The result of a change of time: the poses (states of the scene at one time), and which parts of the device's data must
/// be updated.
pub struct PoseChange<'a> {
    /// The poses of the current frame and of the previous frame, in this order, under a lock. As long as the
    /// caller keeps this guard, other threads cannot change the poses. The caller keeps it until it has
    /// written the poses to the buffers on the device.
    pub poses: MutexGuard<'a, [ScenePose; 2]>,
    /// True if the pose that was current before this change is now the previous one; false if the time has jumped. If it is
    /// true and rays are traced by ray queries, the acceleration structure over the instances of that pose is reused.
    pub advanced: bool,
    /// True for each pose that this change of time has computed: first the current pose, then the previous
    /// one. With ray queries, the acceleration structure over the instances of such a pose must be rebuilt.
    pub new: [bool; 2],
    /// One transform for each instance of the original scene (before static meshes are merged). It takes a point of the
    /// instance from its position in the current frame to its position in the previous frame; both are in the device's
    /// world space (relative to the scene's origin, in the device's unit of length). Shaders compute motion vectors with
    /// it, and find the pixel that showed a point in the previous frame.
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
            room,
            instance_count,
            poses: Mutex::new([pose.clone(), poser.in_other_copy(&pose)]),
            poser,
        }
    }

    /// Sets the times of the current frame (`now`) and of the previous frame (`before`), in seconds, and computes the poses
    /// at these times that are not known yet. Returns the new poses and what the caller must update on the device; `None` if
    /// the times are the same as before.
    ///
    /// # Errors
    /// At one of the times, the transform of an instance or punctual light is not finite, or puts it further away than can
    /// be rendered; or posing the scene failed in another thread.
    pub fn set_times(&self, now: f64, before: f64) -> Result<Option<PoseChange<'_>>> {
        let mut poses = self.lock()?;
        if poses[0].time == now && poses[1].time == before {
            return Ok(None);
        }
        let advanced = poses[0].time == before;
        let kept = |epoch: usize| if advanced { 1 - epoch } else { epoch };
        let missing = |epoch: usize, time: f64| {
            (poses[kept(epoch)].time != time)
                .then(|| {
                    let replaced = Some(&poses[kept(epoch)]);
                    self.poser.pose_at(time, self.motion.pose(time), replaced)
                })
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

    /// Writes the new shapes of a pose to the device, into the copies of the meshes that the pose is meant for.
    ///
    /// # Errors
    /// The device fails.
    pub fn upload_shapes(&self, pose: &ScenePose, buffers: ShapeBuffers<'_>) -> Result<()> {
        let mesh_nodes = (2 * self.room) as u32;
        self.poser.upload_shapes(pose, mesh_nodes, buffers)
    }

    /// For each mesh whose shape in `pose` is new, its index in the traced scene and the index in the buffer `positions` of the
    /// first triangle of the copy that the pose is meant for.
    pub fn new_copies(&self, pose: &ScenePose) -> impl Iterator<Item = (u32, u32)> {
        self.poser.new_copies(pose)
    }

    /// The lights as they are in the current frame, and the time of this frame in seconds. The light BVH updates its boxes
    /// and powers with them. `known` is the time, in seconds, of the lights that the caller already has. If the current
    /// frame has the same time, the result is `None`.
    ///
    /// # Errors
    /// Posing the scene failed in another thread.
    pub fn moved_lights(&self, known: f64) -> Result<Option<(Lights, f64)>> {
        let now = &self.lock()?[0];
        Ok((now.time != known).then(|| (now.lights.clone(), now.time)))
    }

    /// One transform for each instance of the original scene (before static meshes are merged). It takes a point of the
    /// instance from its position in the current frame to its position in the previous frame; both are in the device's
    /// world space (relative to the scene's origin, in the device's unit of length). The buffer `previous_transforms` is
    /// first filled with these transforms.
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

#[cfg(test)]
mod tests;
