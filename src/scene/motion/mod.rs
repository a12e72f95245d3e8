//! The motion of a scene: a tree of nodes, whose transforms can change with time by keyframes. Instances, cameras and lights
//! that move are attached to nodes, and the joints of meshes that deform are nodes. From the motion the renderer computes a [`Pose`], the state of all that moves, for the
//! time of each frame.

pub mod deformation;
mod moving_camera;
mod pose;
pub mod tracks;

pub use moving_camera::MovingCamera;
pub use pose::{Pose, check_light_transform, check_transform, check_vertices, is_flat};

use super::validate::BRIGHTEST;
use super::{Mesh, Scene};
use crate::{Error, Result};
use deformation::Deformation;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use tracks::{Animated, Keyed, TrackFault};

/// The changes of a scene with time: moving instances, cameras and lights, animated emission, and meshes that change their
/// shape. [`Motion::pose`] computes their state at any time. The other fields of the scene hold the state at time 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The nodes of the tree of transforms by which instances, cameras and lights move. Each node comes after its parent, so
    /// that one pass over the array computes the transform of every node to the world.
    pub nodes: Vec<Node>,
    /// One entry per instance of the scene: the index of its node in `nodes`, or `None` if the instance does
    /// not move. The node's transform to the world becomes that of the instance.
    pub instances: Vec<Option<u32>>,
    /// One entry per camera of the scene: the index of its node in `nodes`, or `None` if the camera does not
    /// move. The node's transform to the world, without its scale, becomes that of the camera.
    pub cameras: Vec<Option<u32>>,
    /// One entry per punctual light of the scene: the index of its node in `nodes`, or `None` if the light
    /// does not move. The node's transform to the world becomes that of the light.
    pub lights: Vec<Option<u32>>,
    /// The emission of each material whose emission changes with time; each material occurs at most once.
    pub emission: Vec<Emission>,
    /// The meshes whose shape changes; each mesh occurs at most once.
    pub deformations: Vec<Deformation>,
}

/// A node of the tree of transforms. Instances, cameras and lights that are attached to it move with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The index of the parent in [`Motion::nodes`], smaller than the index of this node; `None` for a root.
    pub parent: Option<u32>,
    /// The transform from this node to its parent, or to the world for a root.
    pub transform: Transform,
}

/// The transform from a node to its parent: either constant, or changing with time.
#[derive(Clone, Debug, PartialEq)]
pub enum Transform {
    /// A constant transform to the parent. The node can still move with its parent.
    Fixed(DAffine3),
    /// A transform that changes with time, computed from keyframes in each frame.
    Moving(Box<AnimatedTransform>),
}

/// A transform from a node to its parent that changes with time. It applies the scale first, then the
/// rotation, then the translation.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedTransform {
    /// Translation in the space of the parent node, in its units; for a root in world space, in scene units.
    pub translation: Animated<DVec3>,
    /// Rotation relative to the parent node (to the world for a root), as a unit quaternion.
    pub rotation: Animated<DQuat>,
    /// Scale factors along the node's own x, y and z, without a unit. A negative factor mirrors, and 0 makes
    /// the node flat.
    pub scale: Animated<DVec3>,
}

/// The emission of a material as a function of time: the product of a colour and a strength, which can both
/// have keyframes. The emission in each frame is computed from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Index into [`crate::scene::Scene::materials`]: the material that emits.
    pub material: u32,
    /// Linear RGB colour of the emission, without a unit. The emitted radiance is its product with `strength`.
    pub color: Animated<DVec3>,
    /// The radiance in W/(m²·sr) that the material emits in a channel in which `color` is 1.
    pub strength: Animated<f64>,
}

impl AnimatedTransform {
    /// A transform with the given constant values and without keyframes. Loaders then add tracks to those values that have
    /// keyframes.
    pub fn still(translation: DVec3, rotation: DQuat, scale: DVec3) -> Self {
        Self {
            translation: Animated::still(translation),
            rotation: Animated::still(rotation),
            scale: Animated::still(scale),
        }
    }

    /// The transform from the node to its parent at `time` (in seconds).
    pub fn at(&self, time: f64) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(
            self.scale.at(time),
            self.rotation.at(time),
            self.translation.at(time),
        )
    }

    fn moves(&self) -> bool {
        self.translation.track.is_some()
            || self.rotation.track.is_some()
            || self.scale.track.is_some()
    }
}

impl Emission {
    /// The linear RGB radiance, in W/(m²·sr), that the material emits at `time` (in seconds). Each channel is clamped to the
    /// range from 0 to [`BRIGHTEST`], because a spline can leave the range of the values at its keys.
    pub fn at(&self, time: f64) -> Vec3 {
        let radiance = self.color.at(time) * self.strength.at(time);
        radiance.as_vec3().clamp(Vec3::ZERO, Vec3::splat(BRIGHTEST))
    }

    /// An upper bound of the emission at all keys: linear RGB in W/(m²·sr). Each channel is the largest colour of all keys ×
    /// the largest strength of all keys, at most [`BRIGHTEST`]. Between keys, a spline can exceed it. Lights are compared by
    /// this bound, because an emitter that is dark now may be bright at another time.
    pub fn brightest(&self) -> Vec3 {
        let color = self.color.keys().fold(DVec3::ZERO, DVec3::max);
        let strength = self.strength.keys().fold(0.0, f64::max);
        (color * strength).as_vec3().min(Vec3::splat(BRIGHTEST))
    }

    fn changes(&self) -> bool {
        self.color.track.is_some() || self.strength.track.is_some()
    }
}

impl Motion {
    /// The time of the last key of all tracks, in seconds, for reports; 0 if there are no keys. After this time nothing
    /// changes.
    pub fn seconds(&self) -> f64 {
        let nodes = self.nodes.iter().map(|node| match &node.transform {
            Transform::Fixed(_) => 0.0,
            Transform::Moving(moving) => (moving.translation.seconds())
                .max(moving.rotation.seconds())
                .max(moving.scale.seconds()),
        });
        let emission = self.emission.iter();
        let emission = emission.map(|e| e.color.seconds().max(e.strength.seconds()));
        let targets = self.deformations.iter().flat_map(|d| &d.targets);
        let targets = targets.map(|target| target.weight.seconds());
        nodes.chain(emission).chain(targets).fold(0.0, f64::max)
    }

    /// True if the scene itself changes with time: an instance or a punctual light moves, the emission of a material
    /// changes, or a mesh changes its shape. The device then also stores the scene's state in the previous frame. The motion of cameras does not count.
    pub fn moves_things(&self) -> bool {
        let mut attached = self.instances.iter().chain(&self.lights);
        !self.emission.is_empty() || !self.deformations.is_empty() || attached.any(Option::is_some)
    }

    /// True if the instance with the index `index` in the scene is attached to a node, so that it moves at some time. Such
    /// an instance is never merged with others, and is kept even if it is flat now, because it may not be flat later.
    pub fn moves_instance(&self, index: usize) -> bool {
        self.instances.get(index).is_some_and(Option::is_some)
    }

    /// The same motion in a simpler form, so that frames compute only what changes. A track whose value never changes is
    /// replaced by this value. Instances, cameras and lights that do not move are detached from their nodes, and nodes that
    /// nothing uses are removed. `None` if nothing moves or changes.
    pub(crate) fn simplified(mut self) -> Option<Self> {
        let mut moves = Vec::with_capacity(self.nodes.len());
        for node in &mut self.nodes {
            if let Transform::Moving(moving) = &mut node.transform {
                moving.translation.simplify();
                moving.rotation.simplify();
                moving.scale.simplify();
                if !moving.moves() {
                    node.transform = Transform::Fixed(moving.at(0.0));
                }
            }
            let with_parent = node.parent.is_some_and(|parent| moves[parent as usize]);
            moves.push(with_parent || matches!(node.transform, Transform::Moving(_)));
        }
        for attached in self.attached_mut() {
            attached.take_if(|node| !moves[*node as usize]);
        }
        for emission in &mut self.emission {
            emission.color.simplify();
            emission.strength.simplify();
        }
        self.emission.retain(Emission::changes);
        for target in self.deformations.iter_mut().flat_map(|d| &mut d.targets) {
            target.weight.simplify();
        }
        self.deformations.retain(|d| d.changes(&moves));
        self.drop_unused_nodes();
        let cameras = self.cameras.iter().any(Option::is_some);
        (cameras || self.moves_things()).then_some(self)
    }

    fn drop_unused_nodes(&mut self) {
        let mut used = vec![false; self.nodes.len()];
        let joints = self.deformations.iter().flat_map(Deformation::joint_nodes);
        for node in self.attached().flatten().chain(joints) {
            used[*node as usize] = true;
        }
        for index in (0..self.nodes.len()).rev() {
            if let (true, Some(parent)) = (used[index], self.nodes[index].parent) {
                used[parent as usize] = true;
            }
        }
        let mut kept = 0;
        let moved: Vec<u32> = used
            .iter()
            .map(|&used| {
                kept += u32::from(used);
                kept.saturating_sub(1)
            })
            .collect();
        let mut used = used.into_iter();
        self.nodes.retain(|_| used.next().unwrap_or(false));
        for node in &mut self.nodes {
            node.parent = node.parent.map(|parent| moved[parent as usize]);
        }
        for node in self.attached_mut() {
            *node = node.map(|node| moved[node as usize]);
        }
        let skins = self.deformations.iter_mut().filter_map(|d| d.skin.as_mut());
        for joint in skins.flat_map(|skin| &mut skin.joints) {
            joint.node = moved[joint.node as usize];
        }
    }

    /// The node of each element, as an index into `nodes`; `None` if the element does not move. The instances come first,
    /// then the cameras, then the lights. The indices are used to remove nodes that no element needs, and are checked for
    /// their range.
    fn attached(&self) -> impl Iterator<Item = &Option<u32>> {
        (self.instances.iter())
            .chain(&self.cameras)
            .chain(&self.lights)
    }

    fn attached_mut(&mut self) -> impl Iterator<Item = &mut Option<u32>> {
        (self.instances.iter_mut())
            .chain(&mut self.cameras)
            .chain(&mut self.lights)
    }

    /// Checks indices and keys, so that [`Motion::pose`] can rely on them. `counts` are the numbers of the scene's
    /// instances, cameras, punctual lights and materials, in this order.
    ///
    /// # Errors
    /// The first fault: `instances`, `cameras` or `lights` does not have one entry per element of the scene; a node is not
    /// after its parent; the index of a node or a material is out of range; or a track is faulty (see
    /// [`tracks::Track::check`]).
    pub(super) fn check(&self, counts: [usize; 4]) -> Result<()> {
        let wrong = |what: String, fault: &str| Err(Error::input(format!("{what}: {fault}")));
        if [self.instances.len(), self.cameras.len(), self.lights.len()] != counts[..3] {
            let fault = "it does not have an entry for every instance, camera and light";
            return wrong("motion".into(), fault);
        }
        for (index, node) in self.nodes.iter().enumerate() {
            let what = format!("motion, node {index}");
            if node.parent.is_some_and(|parent| parent as usize >= index) {
                return wrong(what, "its parent does not come before it");
            }
            if let Transform::Moving(moving) = &node.transform {
                check_track(&format!("{what}, translation"), &moving.translation)?;
                check_track(&format!("{what}, rotation"), &moving.rotation)?;
                check_track(&format!("{what}, scale"), &moving.scale)?;
            }
        }
        let mut attached = self.attached().flatten();
        if let Some(node) = attached.find(|n| **n as usize >= self.nodes.len()) {
            return wrong("motion".into(), &format!("node {node} does not exist"));
        }
        for emission in &self.emission {
            let what = format!("motion, material {}", emission.material);
            if emission.material as usize >= counts[3] {
                return wrong(what, "it does not exist");
            }
            check_track(&format!("{what}, emission"), &emission.color)?;
            check_track(&format!("{what}, strength"), &emission.strength)?;
        }
        Ok(())
    }
}

impl Scene {
    /// As [`Motion::moves_instance`]; false without motion.
    pub(crate) fn moves_instance(&self, index: usize) -> bool {
        (self.motion.as_ref()).is_some_and(|motion| motion.moves_instance(index))
    }

    /// One entry for each mesh of the scene: true if the mesh changes its shape with time.
    pub(crate) fn deforming_meshes(&self) -> Vec<bool> {
        let mut deforming = vec![false; self.meshes.len()];
        for deformation in self.motion.iter().flat_map(|motion| &motion.deformations) {
            deforming[deformation.mesh as usize] = true;
        }
        deforming
    }
}

impl Motion {
    /// Checks the deformations, so that [`Deformation::deform`] can rely on them. `meshes` are those of the scene.
    ///
    /// # Errors
    /// The first fault: a mesh does not exist or has two deformations, a joint or a node does not exist, a list does not fit
    /// the vertices, or a track is faulty.
    pub(super) fn check_deformations(&self, meshes: &[Mesh]) -> Result<()> {
        let mut deforming = vec![false; meshes.len()];
        for (index, deformation) in self.deformations.iter().enumerate() {
            let what = format!("motion, deformation {index}");
            let wrong = |fault: &str| Err(Error::input(format!("{what}: {fault}")));
            let Some(mesh) = meshes.get(deformation.mesh as usize) else {
                return wrong(&format!("mesh {} does not exist", deformation.mesh));
            };
            if std::mem::replace(&mut deforming[deformation.mesh as usize], true) {
                return wrong(&format!("mesh {} has another one", deformation.mesh));
            }
            if let Some(fault) = deformation.fault(mesh, self.nodes.len()) {
                return wrong(&fault);
            }
            for (target, morph) in deformation.targets.iter().enumerate() {
                check_track(&format!("{what}, weight {target}"), &morph.weight)?;
            }
        }
        Ok(())
    }
}

fn check_track<T: Keyed>(what: &str, animated: &Animated<T>) -> Result<()> {
    match animated.track.as_ref().map(tracks::Track::check) {
        Some(Err(TrackFault::Times(fault) | TrackFault::Values(fault))) => {
            Err(Error::input(format!("{what}: {fault}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::tracks::{Interpolation, Track};
    use super::*;

    pub(super) fn line(to: DVec3) -> Option<Track<DVec3>> {
        Some(Track {
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            values: vec![DVec3::ZERO, to],
        })
    }

    pub(super) fn moving(to: DVec3) -> Transform {
        let mut moving = AnimatedTransform::still(DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE);
        moving.translation.track = line(to);
        Transform::Moving(Box::new(moving))
    }

    pub(super) fn node(parent: Option<u32>, transform: Transform) -> Node {
        Node { parent, transform }
    }

    #[test]
    fn constant_parts_are_dropped() {
        let motion = Motion {
            nodes: vec![
                node(None, moving(DVec3::ZERO)),
                node(None, moving(DVec3::X)),
                node(Some(0), Transform::Fixed(DAffine3::IDENTITY)),
                node(Some(1), Transform::Fixed(DAffine3::IDENTITY)),
            ],
            instances: vec![Some(2), Some(3)],
            cameras: vec![Some(0)],
            lights: vec![],
            emission: vec![],
            deformations: vec![],
        };
        let simple = motion.clone().simplified().unwrap();
        assert_eq!(simple.nodes.len(), 2);
        assert_eq!(simple.nodes[1].parent, Some(0));
        assert_eq!(simple.instances, [None, Some(1)]);
        assert_eq!(simple.cameras, [None]);
        assert_eq!(simple.pose(0.7).instances, motion.pose(0.7).instances[1..]);
        let still = Motion {
            instances: vec![Some(2), Some(0)],
            ..motion
        };
        assert_eq!(still.simplified(), None);
    }

    #[test]
    fn indices_out_of_range_are_errors() {
        let good = Motion {
            nodes: vec![node(None, moving(DVec3::X))],
            instances: vec![Some(0)],
            ..Motion::default()
        };
        let message = |change: fn(&mut Motion)| {
            let mut motion = good.clone();
            change(&mut motion);
            motion.check([1, 0, 0, 1]).unwrap_err().to_string()
        };
        assert!(message(|m| m.instances.clear()).contains("every instance"));
        assert!(message(|m| m.instances[0] = Some(1)).contains("node 1 does not exist"));
        assert!(message(|m| m.nodes[0].parent = Some(0)).contains("node 0: its parent"));
        assert!(
            message(|m| m.nodes[0].transform = moving(DVec3::NAN)).contains("node 0, translation")
        );
    }
}
