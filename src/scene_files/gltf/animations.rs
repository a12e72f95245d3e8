//! Reads animations: keys for the transforms of nodes and, by `KHR_animation_pointer`, for the emission of materials.
//!
//! All animations of a file play together, from time 0. If two of them change one property, the first one in the file takes
//! effect, and a notice reports it.

use super::accessors::{Accessors, get};
use super::damaged;
use super::deformations::target_count;
use super::document::{Animation, Channel};
use super::materials::emission;
use super::nodes::Placed;
use crate::scene::motion::deformation::Deformation;
use crate::scene::motion::tracks::{Animated, Interpolation, Keyed, Track, TrackFault};
use crate::scene::motion::{AnimatedTransform, Emission, Motion, Node, Transform};
use crate::scene::notices::{Tally, quoted};
use crate::scene::validate::BRIGHTEST;
use crate::{Error, Result};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::BTreeMap;

/// The keyframes of all animated properties of the file, from which [`Animations::motion`] makes the motion of the scene.
/// `nodes` maps the index of a node in the file to its changing transform, and `materials` maps the index of a material in
/// the file to its changing emission.
#[derive(Default)]
pub struct Animations {
    nodes: BTreeMap<usize, AnimatedTransform>,
    materials: BTreeMap<usize, Emission>,
    /// For the index of a node in the file, the keyframes of the weight of each morph target of its mesh.
    weights: BTreeMap<usize, Vec<Track<f64>>>,
}

/// The property that a channel of a glTF animation changes, with the index in the file of the node or the material that has
/// the property.
enum Target {
    Translation(usize),
    Rotation(usize),
    Scale(usize),
    EmissiveFactor(usize),
    EmissiveStrength(usize),
    Weights(usize),
}

/// Reads the keyframes of all animation channels that change the translation, rotation or scale of a node, or the emission
/// of a material. Other channels are ignored, with a notice in `tally`. `placed` are the nodes of the scene. Fails if an
/// index or a keyframe of a channel is wrong, or if the node of a channel has a matrix.
pub fn read(
    accessors: &Accessors<'_>,
    placed: &[Placed<'_>],
    tally: &mut Tally,
) -> Result<Animations> {
    let mut read = Animations::default();
    if accessors.document.animations.is_empty() {
        return Ok(read);
    }
    let in_scene: BTreeMap<usize, &Placed<'_>> = placed.iter().map(|p| (p.index, p)).collect();
    for (animation_index, animation) in accessors.document.animations.iter().enumerate() {
        for (index, channel) in animation.channels.iter().enumerate() {
            let what = format!("animations[{animation_index}].channels[{index}]");
            let Some(target) = target(accessors, &what, channel, tally)? else {
                continue;
            };
            let sampler = channel
                .sampler
                .ok_or_else(|| damaged(format!("{what}: it has no sampler")))?;
            let keys = get(&animation.samplers, sampler);
            let missing = keys.and_then(|keys| {
                let missing = accessors.missing_buffer(keys.input);
                missing.or_else(|| accessors.missing_buffer(keys.output))
            });
            if let Some(fault) = missing {
                let text = "animations whose buffers are missing are left out";
                tally.add(text, || format!("{what} ({fault})"));
                continue;
            }
            let source = Source {
                accessors,
                animation,
                animation_index,
                sampler,
                channel: &what,
            };
            read.add(&source, target, &in_scene, tally)?;
        }
    }
    Ok(read)
}

/// The number of morph targets of the mesh of the node with the index `node` in the file.
fn weight_count(accessors: &Accessors<'_>, node: usize) -> usize {
    let document = accessors.document;
    let mesh = document.nodes[node].mesh;
    mesh.and_then(|mesh| get(&document.meshes, mesh))
        .map_or(0, target_count)
}

/// The property that a channel changes; `None`, with a notice in `tally`, if this property cannot be animated. `what` names
/// the channel in messages. Fails if the index of a node or a material is out of range.
fn target(
    accessors: &Accessors<'_>,
    what: &str,
    channel: &Channel,
    tally: &mut Tally,
) -> Result<Option<Target>> {
    let ignored = "animations of properties that cannot be animated are ignored";
    let location = || what.to_owned();
    let document = accessors.document;
    let in_range = |kind: &str, index: u64| {
        let count = match kind {
            "node" => document.nodes.len(),
            _ => document.materials.len(),
        };
        match usize::try_from(index) {
            Ok(index) if index < count => Ok(index),
            _ => Err(super::out_of_range(what, kind, index, count)),
        }
    };
    let (node, path) = (channel.target.node, channel.target.path.as_str());
    if let Some(pointer) = &channel.target.extensions.pointer {
        let parts: Vec<&str> = pointer.pointer.split('/').collect();
        let found = match &parts[..] {
            [_, list, index, path @ ..] => index.parse().ok().map(|index| (*list, index, path)),
            _ => None,
        };
        let Some((list, index, path)) = found else {
            tally.add(ignored, || format!("{what} ({})", quoted(&pointer.pointer)));
            return Ok(None);
        };
        let strength = [
            "extensions",
            "KHR_materials_emissive_strength",
            "emissiveStrength",
        ];
        return Ok(match (list, path) {
            ("materials", ["emissiveFactor"]) => {
                Some(Target::EmissiveFactor(in_range("material", index)?))
            }
            ("materials", path) if path == strength => {
                Some(Target::EmissiveStrength(in_range("material", index)?))
            }
            ("nodes", ["translation"]) => Some(Target::Translation(in_range("node", index)?)),
            ("nodes", ["rotation"]) => Some(Target::Rotation(in_range("node", index)?)),
            ("nodes", ["scale"]) => Some(Target::Scale(in_range("node", index)?)),
            ("nodes", ["weights"]) if weight_count(accessors, in_range("node", index)?) > 0 => {
                Some(Target::Weights(in_range("node", index)?))
            }
            _ => {
                tally.add(ignored, || format!("{what} ({})", quoted(&pointer.pointer)));
                None
            }
        });
    }
    let Some(node) = node else {
        tally.add(ignored, location);
        return Ok(None);
    };
    let node = in_range("node", node)?;
    Ok(match path {
        "translation" => Some(Target::Translation(node)),
        "rotation" => Some(Target::Rotation(node)),
        "scale" => Some(Target::Scale(node)),
        "weights" if weight_count(accessors, node) > 0 => Some(Target::Weights(node)),
        _ => {
            tally.add(ignored, location);
            None
        }
    })
}

/// The source of the keyframes of one channel: the sampler with the index `sampler` in `animation`. Messages
/// name the animation by `animation_index`, its index in the file, and the channel by the text `channel`.
struct Source<'a> {
    accessors: &'a Accessors<'a>,
    animation: &'a Animation,
    animation_index: usize,
    sampler: u64,
    channel: &'a str,
}

impl Source<'_> {
    /// Reads and checks the keyframes of the sampler; their times are in seconds. `kind` is the glTF type of
    /// a value and its number of components, such as `VEC3` and 3. `make` makes one value of the track from
    /// this many numbers. Keys before time 0 and several keys at one time are kept, with notices in `tally`. Fails if an
    /// index, a type, a time or a value is wrong.
    fn track<T: Keyed>(
        &self,
        kind: (&str, usize),
        make: impl Fn(&[f64]) -> T,
        tally: &mut Tally,
    ) -> Result<Track<T>> {
        let track = self.unchecked(kind, make)?;
        self.check(&track, tally)?;
        Ok(track)
    }

    /// The same without the check of times and values.
    fn unchecked<T>(&self, kind: (&str, usize), make: impl Fn(&[f64]) -> T) -> Result<Track<T>> {
        let samplers = &self.animation.samplers;
        let Some(sampler) = get(samplers, self.sampler) else {
            let (what, count) = (self.channel, samplers.len());
            return Err(super::out_of_range(what, "sampler", self.sampler, count));
        };
        let what = self.what();
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                return Err(damaged(format!(
                    "{what}.interpolation: {} is not LINEAR, STEP or CUBICSPLINE",
                    quoted(other)
                )));
            }
        };
        let missing = |half: &str| damaged(format!("{what}.{half}: it is missing"));
        let input = sampler.input.ok_or_else(|| missing("input"))?;
        let output = sampler.output.ok_or_else(|| missing("output"))?;
        let times = format!("{what}.input");
        let values = format!("{what}.output");
        Ok(Track {
            interpolation,
            times: self.accessors.numbers(input, &times, ("SCALAR", 1), true)?,
            values: (self.accessors.numbers(output, &values, kind, false)?)
                .chunks_exact(kind.1)
                .map(make)
                .collect(),
        })
    }

    fn what(&self) -> String {
        format!(
            "animations[{}].samplers[{}]",
            self.animation_index, self.sampler
        )
    }

    /// Reads the keyframes of the weights of `count` morph targets: for each key, the sampler has one value for each target
    /// or, for a spline, the incoming slopes of all targets, their values, and the outgoing slopes. Fails as [`Self::track`]
    /// does.
    fn weights(&self, count: usize, tally: &mut Tally) -> Result<Vec<Track<f64>>> {
        let all: Track<f64> = self.unchecked(("SCALAR", 1), |v| v[0])?;
        let stride = match all.interpolation {
            Interpolation::CubicSpline => 3,
            Interpolation::Step | Interpolation::Linear => 1,
        };
        let (wanted, found) = (all.times.len() * stride * count, all.values.len());
        if wanted != found {
            return Err(damaged(format!(
                "{}.output: there are {found} weights for {} keys of {count} morph targets, not {wanted}",
                self.what(),
                all.times.len()
            )));
        }
        let of_target = |target: usize| {
            let values = all.values.iter().skip(target).step_by(count);
            Track {
                interpolation: all.interpolation,
                times: all.times.clone(),
                values: values.copied().collect(),
            }
        };
        let tracks: Vec<Track<f64>> = (0..count).map(of_target).collect();
        match tracks.first() {
            Some(first) => self.check(first, tally)?,
            None => return Ok(tracks),
        }
        for track in &tracks[1..] {
            self.check(track, &mut Tally::default())?;
        }
        Ok(tracks)
    }

    fn check<T: Keyed>(&self, track: &Track<T>, tally: &mut Tally) -> Result<()> {
        let (times, values) = (
            format!("{}.input", self.what()),
            format!("{}.output", self.what()),
        );
        let correct = "correct the keys in the modelling tool";
        track.check().map_err(|fault| match fault {
            TrackFault::Times(fault) => Error::input(format!("{times}: {fault}; {correct}")),
            TrackFault::Values(fault) => Error::input(format!("{values}: {fault}; {correct}")),
        })?;
        if track.times[0] < 0.0 {
            let text = "keys before time 0 are shown only at a negative --start-time";
            tally.add(text, || times.clone());
        }
        if track.times.windows(2).any(|pair| pair[0] == pair[1]) {
            let text = "several keys are at one time, where the value jumps to the last of them";
            tally.add(text, || times.clone());
        }
        Ok(())
    }

    /// Fails if a value of the track, which is a colour or a strength, is below 0 or above [`BRIGHTEST`] at some key.
    /// Products of larger values could overflow f32. `most` returns the smallest and the largest channel of a colour; for a
    /// strength, it returns the strength twice.
    fn check_emission<T: Keyed>(
        &self,
        track: &Track<T>,
        most: impl Fn(T) -> [f64; 2],
    ) -> Result<()> {
        let good = |value: T| {
            most(value)
                .iter()
                .all(|v| (0.0..=f64::from(BRIGHTEST)).contains(v))
        };
        match track.keys().position(|value| !good(value)) {
            None => Ok(()),
            Some(key) => Err(Error::input(format!(
                "animations[{}].samplers[{}].output: the emission of key {key} must be within 0 and 1e12",
                self.animation_index, self.sampler
            ))),
        }
    }
}

impl Animations {
    fn add(
        &mut self,
        source: &Source<'_>,
        target: Target,
        in_scene: &BTreeMap<usize, &Placed<'_>>,
        tally: &mut Tally,
    ) -> Result<()> {
        let taken = |tally: &mut Tally, taken: bool| {
            if taken {
                let text = "several animations change one property, the first one is used";
                tally.add(text, || source.channel.to_owned());
            }
            taken
        };
        // A node's keys are checked even if the scene does not show it.
        match target {
            Target::Translation(node) | Target::Scale(node) => {
                let track = source.track(("VEC3", 3), DVec3::from_slice, tally)?;
                let Some(moving) = self.moving(source, node, in_scene)? else {
                    return Ok(());
                };
                let animated = match target {
                    Target::Scale(_) => &mut moving.scale,
                    _ => &mut moving.translation,
                };
                if !taken(tally, animated.track.is_some()) {
                    animated.track = Some(track);
                }
            }
            Target::Rotation(node) => {
                let mut track = source.track(("VEC4", 4), DQuat::from_slice, tally)?;
                // Keys from integers are unit only nearly; slopes have no length to keep.
                let stride = track.values.len() / track.times.len();
                let keys = track.values.iter_mut().skip(stride / 2).step_by(stride);
                keys.for_each(|key| *key = key.normalize());
                let Some(moving) = self.moving(source, node, in_scene)? else {
                    return Ok(());
                };
                if !taken(tally, moving.rotation.track.is_some()) {
                    moving.rotation.track = Some(track);
                }
            }
            Target::EmissiveFactor(material) | Target::EmissiveStrength(material)
                if source.accessors.document.materials[material].is_unlit() => {}
            Target::Weights(node) => {
                let count = weight_count(source.accessors, node);
                let tracks = source.weights(count, tally)?;
                if !taken(tally, self.weights.contains_key(&node)) {
                    self.weights.insert(node, tracks);
                }
            }
            Target::EmissiveFactor(material) => {
                let track = source.track(("VEC3", 3), DVec3::from_slice, tally)?;
                source.check_emission(&track, |v| [v.min_element(), v.max_element()])?;
                let emission = self.emission(source, material);
                if !taken(tally, emission.color.track.is_some()) {
                    emission.color.track = Some(track);
                }
            }
            Target::EmissiveStrength(material) => {
                let track = source.track(("SCALAR", 1), |v| v[0], tally)?;
                source.check_emission(&track, |v| [v, v])?;
                let emission = self.emission(source, material);
                if !taken(tally, emission.strength.track.is_some()) {
                    emission.strength.track = Some(track);
                }
            }
        }
        Ok(())
    }

    /// The animated transform of the node with the index `node` in the file, to which the caller adds keyframes. If the node
    /// has no animated transform yet, one without keyframes is inserted, with the node's values in the file. `None` if the
    /// scene does not contain the node. Fails if the node states a matrix instead of scale, rotation and translation, since
    /// glTF forbids animations of such a node.
    fn moving(
        &mut self,
        source: &Source<'_>,
        node: usize,
        in_scene: &BTreeMap<usize, &Placed<'_>>,
    ) -> Result<Option<&mut AnimatedTransform>> {
        let Some(placed) = in_scene.get(&node) else {
            return Ok(None);
        };
        if placed.node.matrix.is_some() {
            return Err(damaged(format!(
                "{}: {} has a matrix, which cannot be animated",
                source.channel,
                placed.label()
            )));
        }
        let rest = || {
            let (scale, rotation, translation) = placed.rest();
            AnimatedTransform::still(translation, rotation, scale)
        };
        Ok(Some(self.nodes.entry(node).or_insert_with(rest)))
    }

    fn emission(&mut self, source: &Source<'_>, material: usize) -> &mut Emission {
        self.materials.entry(material).or_insert_with(|| {
            let (color, strength) = emission(&source.accessors.document.materials[material]);
            Emission {
                material: material as u32,
                color: Animated::still(color),
                strength: Animated::still(strength),
            }
        })
    }

    /// True if there are keyframes for the emission of the material at the index `material` in the file. Such a material
    /// counts as emitting even if its emission in the file is 0, so that its emissive texture is read.
    pub fn change_emission_of(&self, material: usize) -> bool {
        self.materials.contains_key(&material)
    }

    /// Drops the keyframes for the emission of the material at the index `material` in the file, so that it emits nothing.
    pub fn drop_emission_of(&mut self, material: usize) {
        self.materials.remove(&material);
    }

    /// Takes the keyframes of the morph weights of the node with the index `node` in the file; `None` if it has none.
    pub fn weights_of(&mut self, node: usize) -> Option<Vec<Track<f64>>> {
        self.weights.remove(&node)
    }

    /// True if there are keyframes for the morph weights of the node with the index `node` in the file.
    pub fn change_weights_of(&self, node: usize) -> bool {
        self.weights.contains_key(&node)
    }

    /// The motion of the scene; `None` if nothing has keyframes. Its nodes are `placed`, the nodes of the scene, followed by
    /// `copies`: each copy of a mesh has the index of its node in `placed` and its transform to this node. `instances`,
    /// `cameras` and `lights` have one entry for each instance, camera and light of the scene: the index of its node.
    /// `deformations` name joints by their indices in `placed`.
    pub fn motion(
        mut self,
        placed: &[Placed<'_>],
        copies: &[(u32, DAffine3)],
        instances: Vec<Option<u32>>,
        cameras: Vec<Option<u32>>,
        lights: Vec<Option<u32>>,
        deformations: Vec<Deformation>,
    ) -> Option<Motion> {
        if self.nodes.is_empty() && self.materials.is_empty() && deformations.is_empty() {
            return None;
        }
        let nodes = placed.iter().map(|placed_node| Node {
            parent: placed_node.parent,
            transform: match self.nodes.remove(&placed_node.index) {
                Some(moving) => Transform::Moving(Box::new(moving)),
                None => Transform::Fixed(placed_node.in_parent),
            },
        });
        let copies = copies.iter().map(|(node, in_node)| Node {
            parent: Some(*node),
            transform: Transform::Fixed(*in_node),
        });
        Some(Motion {
            nodes: nodes.chain(copies).collect(),
            instances,
            cameras,
            lights,
            emission: self.materials.into_values().collect(),
            deformations,
        })
    }
}
