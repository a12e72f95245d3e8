//! A scene that moves, as two frames see it: this one and the last, side by side in the buffers.

use super::stage::{Stage, Standing};
use crate::layouts::{GpuCarry, GpuInstance, GpuLight};
use crate::scene::Motion;
use crate::{Error, Result};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::{Mutex, MutexGuard};

/// What the buffers hold for some times, each after the one before.
pub struct Contents {
    /// Nodes of the trees over the instances.
    pub nodes: Vec<CwBvhNode>,
    /// Instances in the order of those trees' leaves.
    pub top_instances: Vec<u32>,
    /// Instances.
    pub instances: Vec<GpuInstance>,
    /// Lights.
    pub lights: Vec<GpuLight>,
}

impl Contents {
    /// Lays out times; every tree over the instances takes `room` nodes, and behind all of them are
    /// those of the meshes.
    pub fn of(times: &[&Standing], room: usize) -> Self {
        let mut contents = Self {
            nodes: Vec::new(),
            top_instances: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
        };
        let mesh_nodes = (times.len() * room) as u32;
        for (number, standing) in times.iter().enumerate() {
            let (first_node, first) = (number * room, number * standing.instances.len());
            // What trees leave free is never read.
            contents.nodes.resize(first_node, CwBvhNode::default());
            contents.top_instances.resize(first, 0);
            let placed = standing.top.placed(first_node as u32, first as u32);
            contents.nodes.extend(placed);
            let leaves = standing.top.order.iter();
            let instance_at = |leaf: &u32| standing.visible[*leaf as usize] + first as u32;
            contents.top_instances.extend(leaves.map(instance_at));
            let instances = standing.instances.iter().map(|instance| GpuInstance {
                root_node: instance.root_node + mesh_nodes,
                ..*instance
            });
            contents.instances.extend(instances);
            contents.lights.extend(&standing.lights);
        }
        contents
            .nodes
            .resize(mesh_nodes as usize, CwBvhNode::default());
        if let [_, _, ..] = times {
            let instances = contents.instances.len();
            contents.top_instances.resize(instances, 0);
        }
        contents
    }
}

/// A scene that moves, and where it stands.
pub struct Moving {
    motion: Motion,
    stage: Stage,
    /// Nodes for each of the two trees over the instances.
    pub room: usize,
    /// Number of instances in the scene, before any were gathered.
    instance_count: usize,
    held: Mutex<[Standing; 2]>,
}

/// What a change of time replaced.
pub struct Change<'a> {
    /// Now and before.
    pub held: MutexGuard<'a, [Standing; 2]>,
    /// Whether what was now is before.
    pub turned: bool,
    /// Whether each of now and before, after that, is new.
    pub new: [bool; 2],
    /// How the points of each of the scene's instances go from now to before.
    pub carries: Vec<GpuCarry>,
}

impl Moving {
    /// A scene of `instance_count` instances that stands at one time in both frames.
    pub fn new(
        motion: Motion,
        stage: Stage,
        room: usize,
        instance_count: usize,
        now: Standing,
    ) -> Self {
        Self {
            motion,
            stage,
            room,
            instance_count,
            held: Mutex::new([now.clone(), now]),
        }
    }

    /// Lets now and before be these times in seconds; nothing is returned if they are already.
    ///
    /// # Errors
    /// At one of them an instance is further away than can be rendered.
    pub fn stand(&self, now: f64, before: f64) -> Result<Option<Change<'_>>> {
        let mut held = self.lock()?;
        if held[0].time == now && held[1].time == before {
            return Ok(None);
        }
        let turned = held[0].time == before;
        let kept = |which: usize| if turned { 1 - which } else { which };
        let missing = |which: usize, time: f64| {
            (held[kept(which)].time != time)
                .then(|| self.stage.standing(time, self.motion.pose(time)))
                .transpose()
        };
        // All that may fail comes first: after an error what is held is still what the device has.
        let made = [missing(0, now)?, missing(1, before)?];
        if turned {
            held.reverse();
        }
        let new = made.each_ref().map(Option::is_some);
        for (place, standing) in held.iter_mut().zip(made) {
            if let Some(standing) = standing {
                *place = standing;
            }
        }
        Ok(Some(Change {
            carries: self.carries_between(&held),
            held,
            turned,
            new,
        }))
    }

    /// How the points of each of the scene's instances go from now to before.
    pub fn carries(&self) -> Result<Vec<GpuCarry>> {
        Ok(self.carries_between(&*self.lock()?))
    }

    fn carries_between(&self, [now, before]: &[Standing; 2]) -> Vec<GpuCarry> {
        self.stage.carries(self.instance_count, now, before)
    }

    fn lock(&self) -> Result<MutexGuard<'_, [Standing; 2]>> {
        (self.held.lock()).map_err(|_| Error::failed("posing the scene failed in another thread"))
    }
}
