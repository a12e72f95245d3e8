//! Reads what deforms meshes: skins with the joints and weights of vertices, and morph targets.

use super::accessors::{Accessors, Kind, get};
use super::damaged;
use super::document::{Document, Mesh as FileMesh, Node, Primitive};
use super::nodes::Placed;
use crate::Result;
use crate::scene::Mesh;
use crate::scene::motion::deformation::{
    Deformation, Influence, Joint, MorphTarget, Skin, Vertices,
};
use crate::scene::motion::tracks::{Animated, Track};
use crate::scene::notices::{Tally, label};
use glam::{DAffine3, DMat4, DVec3, Vec3};
use std::collections::HashMap;

/// The difference of the sum of a vertex' weights from 1 above which a notice reports that they are scaled. It is above the
/// rounding of weights that are stored in bytes.
const WEIGHT_TOLERANCE: f32 = 2e-2;

/// The skin and the morph targets of one mesh, as its vertices are read. The order is that of the vertices.
pub struct Deforming {
    /// The joints of the skin, with nodes as indices in the list of placed nodes; empty without a skin.
    joints: Vec<Joint>,
    first_influence: Vec<u32>,
    influences: Vec<Influence>,
    /// Offsets of positions, normals and tangents for each morph target. A list is empty if no primitive has such offsets.
    offsets: Vec<[Vec<Vec3>; 3]>,
}

/// The number of morph targets of a mesh of the file: that of its first primitive.
pub fn target_count(mesh: &FileMesh) -> usize {
    mesh.primitives.first().map_or(0, |p| p.targets.len())
}

/// The weights of the morph targets of the mesh of `node`, as the file states them without animations. Fails if their number
/// is not that of the targets.
pub fn rest_weights(document: &Document, node: &Node, what: &str) -> Result<Vec<f64>> {
    let mesh = node.mesh.and_then(|mesh| get(&document.meshes, mesh));
    let count = mesh.map_or(0, target_count);
    let stated = match (node.weights.as_slice(), mesh) {
        ([], Some(mesh)) => &mesh.weights,
        (weights, _) => weights,
    };
    match stated.len() {
        0 => Ok(vec![0.0; count]),
        found if found == count && stated.iter().all(|w| w.is_finite()) => Ok(stated.to_vec()),
        found => Err(damaged(format!(
            "{what}: has {found} weights for {count} morph targets"
        ))),
    }
}

impl Deforming {
    /// Prepares to read the mesh of `node` with its skin, if it has one, and its morph targets. Fails if the skin is wrong.
    pub fn new(
        accessors: &Accessors<'_>,
        node: &Placed<'_>,
        mesh: &FileMesh,
        placed: &[Placed<'_>],
        tally: &mut Tally,
    ) -> Result<Self> {
        let joints = match node.node.skin {
            Some(skin) => joints(accessors, node, skin, placed, tally)?,
            None => Vec::new(),
        };
        Ok(Self {
            joints,
            first_influence: vec![0],
            influences: Vec::new(),
            offsets: vec![Default::default(); target_count(mesh)],
        })
    }

    /// Reads the values of the vertices `used` of a primitive, which follow the vertices that were read before. `what` names
    /// the primitive in messages. Fails if an index, a type or a count is wrong.
    pub fn append(
        &mut self,
        accessors: &Accessors<'_>,
        what: &str,
        primitive: &Primitive,
        used: &[u64],
        tally: &mut Tally,
    ) -> Result<()> {
        let vertices = self.first_influence.len() - 1 + used.len();
        if primitive.targets.len() != self.offsets.len() {
            return Err(damaged(format!(
                "{what}: has {} morph targets, but the first primitive of its mesh has {}",
                primitive.targets.len(),
                self.offsets.len()
            )));
        }
        self.append_influences(accessors, what, primitive, used, tally)?;
        let positions = count_of(accessors, primitive, "POSITION");
        for (index, (target, lists)) in primitive.targets.iter().zip(&mut self.offsets).enumerate()
        {
            for (name, list) in ["POSITION", "NORMAL", "TANGENT"].into_iter().zip(lists) {
                let Some(&accessor) = target.get(name) else {
                    if !list.is_empty() {
                        list.resize(vertices, Vec3::ZERO);
                    }
                    continue;
                };
                let used_as = format!("{name} of target {index} of {what}");
                let found =
                    accessors.vertex_attribute(accessor, &used_as, &[Kind::Vec3], positions)?;
                (accessors.unfolding).take(&used_as, vertices as u128 * 12)?;
                list.resize(vertices - used.len(), Vec3::ZERO);
                for &vertex in used {
                    let offset = found.vector(vertex);
                    if !offset.is_finite() {
                        return Err(damaged(format!(
                            "{used_as}: offset {vertex} is {offset}; it must be finite"
                        )));
                    }
                    list.push(offset);
                }
            }
        }
        Ok(())
    }

    fn append_influences(
        &mut self,
        accessors: &Accessors<'_>,
        what: &str,
        primitive: &Primitive,
        used: &[u64],
        tally: &mut Tally,
    ) -> Result<()> {
        let mut sets = Vec::new();
        let positions = count_of(accessors, primitive, "POSITION");
        while !self.joints.is_empty() {
            let names = [
                format!("JOINTS_{}", sets.len()),
                format!("WEIGHTS_{}", sets.len()),
            ];
            let [Some(joints), Some(weights)] =
                names.each_ref().map(|name| primitive.attributes.get(name))
            else {
                break;
            };
            let read = |accessor: u64, name: &str| {
                let used_as = format!("{name} of {what}");
                accessors.vertex_attribute(accessor, &used_as, &[Kind::Vec4], positions)
            };
            sets.push((read(*joints, &names[0])?, read(*weights, &names[1])?));
        }
        let bytes = used.len() as u128 * (4 + sets.len() as u128 * 32);
        (accessors.unfolding).take(what, bytes)?;
        let (mut scaled, mut lost) = (0, 0);
        for &vertex in used {
            let first = self.influences.len();
            for (joints, weights) in &sets {
                let (joints, weights) = (joints.quadruple(vertex), weights.quadruple(vertex));
                for (joint, weight) in joints.to_array().into_iter().zip(weights.to_array()) {
                    if !(weight > 0.0 && weight.is_finite()) {
                        continue;
                    }
                    if !(joint >= 0.0 && (joint as usize) < self.joints.len()) {
                        return Err(damaged(format!(
                            "{what}: vertex {vertex} has the joint {joint}, but its skin has {}",
                            self.joints.len()
                        )));
                    }
                    self.influences.push(Influence {
                        joint: joint as u32,
                        weight,
                    });
                }
            }
            let own = &mut self.influences[first..];
            let sum: f32 = own.iter().map(|influence| influence.weight).sum();
            if own.is_empty() && !self.joints.is_empty() {
                lost += 1;
                self.influences.push(Influence {
                    joint: 0,
                    weight: 1.0,
                });
            } else {
                scaled += usize::from(!own.is_empty() && (sum - 1.0).abs() > WEIGHT_TOLERANCE);
                own.iter_mut().for_each(|influence| influence.weight /= sum);
            }
            self.first_influence.push(self.influences.len() as u32);
        }
        let text = "weights of joints that do not sum to 1 are scaled";
        tally.add_many(text, scaled, || what.into());
        let text = "vertices of skins without weights follow the first joint";
        tally.add_many(text, lost, || what.into());
        Ok(())
    }

    /// The deformation of `mesh`, which has the index `index` in the scene. `sources` has, for each vertex of the mesh, its
    /// index among the vertices that were read. `rest_weights` are the weights of the targets, and `tracks` their keyframes,
    /// if there are any. The skin, if there is one, is relative to the world; see [`Self::world_to_object`].
    pub fn finish(
        self,
        index: u32,
        mesh: &Mesh,
        sources: &[u32],
        rest_weights: &[f64],
        tracks: Option<Vec<Track<f64>>>,
        world_to_object: DAffine3,
    ) -> Deformation {
        let mut tracks = tracks.unwrap_or_default().into_iter();
        let gathered = |list: Vec<Vec3>| match list.is_empty() {
            true => list,
            false => sources
                .iter()
                .map(|&source| list[source as usize])
                .collect(),
        };
        let targets = (self.offsets.into_iter().zip(rest_weights)).map(
            |([positions, normals, tangents], &rest)| MorphTarget {
                weight: Animated {
                    rest,
                    track: tracks.next(),
                },
                positions: gathered(positions),
                normals: match mesh.normals.is_empty() {
                    true => Vec::new(),
                    false => gathered(normals),
                },
                tangents: match mesh.tangents.is_empty() {
                    true => Vec::new(),
                    false => gathered(tangents),
                },
            },
        );
        let targets = targets.collect();
        let skin = (!self.joints.is_empty()).then(|| {
            let (mut first_influence, mut influences) = (vec![0], Vec::new());
            for &source in sources {
                let [first, end] =
                    [0, 1].map(|i| self.first_influence[source as usize + i] as usize);
                influences.extend_from_slice(&self.influences[first..end]);
                first_influence.push(influences.len() as u32);
            }
            Skin {
                joints: self.joints,
                first_influence,
                influences,
                world_to_object,
            }
        });
        Deformation {
            mesh: index,
            rest: Vertices {
                positions: mesh.positions.clone(),
                normals: mesh.normals.clone(),
                tangents: mesh.tangents.clone(),
            },
            targets,
            skin,
        }
    }

    /// The transform from the world to the object space of a mesh with this skin: its origin is at the first joint, where f32
    /// is precise. It mirrors if most joints do, so that the front of a triangle stays the front. The identity without a skin.
    pub fn world_to_object(&self, placed: &[Placed<'_>]) -> DAffine3 {
        let Some(first) = self.joints.first() else {
            return DAffine3::IDENTITY;
        };
        let side = |joint: &Joint| {
            let to_world = placed[joint.node as usize].to_world * joint.inverse_bind;
            to_world.matrix3.determinant().signum()
        };
        let sides: f64 = self.joints.iter().map(side).sum();
        let mirror = DVec3::new(if sides < 0.0 { -1.0 } else { 1.0 }, 1.0, 1.0);
        let origin = placed[first.node as usize].to_world.translation;
        DAffine3::from_scale(mirror) * DAffine3::from_translation(-origin)
    }
}

fn count_of(accessors: &Accessors<'_>, primitive: &Primitive, name: &str) -> u64 {
    let index = primitive.attributes.get(name);
    let accessor = index.and_then(|index| get(&accessors.document.accessors, *index));
    accessor.map_or(0, |accessor| accessor.count)
}

/// The joints of the skin with the index `index`, which `node` uses.
fn joints(
    accessors: &Accessors<'_>,
    node: &Placed<'_>,
    index: u64,
    placed: &[Placed<'_>],
    tally: &mut Tally,
) -> Result<Vec<Joint>> {
    let skins = &accessors.document.skins;
    let Some(skin) = get(skins, index) else {
        return Err(super::out_of_range(
            &node.label(),
            "skin",
            index,
            skins.len(),
        ));
    };
    let what = label("skin", index as usize, &skin.name);
    let count = skin.joints.len();
    if count == 0 {
        return Err(damaged(format!("{what}: it has no joints")));
    }
    let mut matrices = Vec::new();
    if let Some(accessor) = skin.inverse_bind_matrices {
        let used_as = format!("inverseBindMatrices of {what}");
        let found = get(&accessors.document.accessors, accessor);
        if found.is_some_and(|found| found.buffer_view.is_none() || found.count < count as u64) {
            return Err(damaged(format!(
                "accessor {accessor} ({used_as}): it does not have a matrix for each of the {count} joints"
            )));
        }
        matrices = accessors.numbers(accessor, &used_as, ("MAT4", 16), true)?;
    }
    (accessors.unfolding).take(&what, placed.len() as u128 * 24 + count as u128 * 120)?;
    let nodes: HashMap<u64, u32> = (0..)
        .zip(placed)
        .map(|(at, placed)| (placed.index as u64, at))
        .collect();
    let mut joints = Vec::with_capacity(count);
    for (number, &joint) in skin.joints.iter().enumerate() {
        let Some(&node) = nodes.get(&joint) else {
            return Err(damaged(format!(
                "{what}: its joint {number}, node {joint}, is not in the scene"
            )));
        };
        let matrix: [f64; 16] = (matrices.get(16 * number..16 * number + 16))
            .and_then(|matrix| matrix.try_into().ok())
            .unwrap_or(DMat4::IDENTITY.to_cols_array());
        let inverse_bind = DAffine3::from_mat4(DMat4::from_cols_array(&matrix));
        if !inverse_bind.is_finite() {
            return Err(damaged(format!(
                "{what}: the inverse bind matrix of joint {number} is not finite"
            )));
        }
        if crate::scene::motion::is_flat(&inverse_bind) {
            let text = "inverse bind matrices without an inverse flatten what their joints move";
            tally.add(text, || format!("{what} joint {number}"));
        }
        joints.push(Joint { node, inverse_bind });
    }
    Ok(joints)
}
