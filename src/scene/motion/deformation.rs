//! Meshes that change their shape with time: by morph targets, which add weighted offsets to the vertices, and by a skin,
//! whose joints move the vertices. Both are evaluated as glTF 2.0 defines them, first the targets, then the skin.

use super::tracks::Animated;
use crate::scene::Mesh;
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// The changing shape of one mesh. The mesh itself has the shape at time 0, this type has the rest shape and what deforms it.
/// Validation checks both, but repairs neither: its vertices must keep their order. So the maker of a deformation gives unit
/// normals and tangents and triangles with an area, as the loader of glTF files does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformation {
    /// Index into [`crate::scene::Scene::meshes`]: the mesh that changes its shape. Its triangles stay the same.
    pub mesh: u32,
    /// The vertices of the mesh before morph targets and skin, one for each vertex of the mesh.
    pub rest: Vertices,
    /// The morph targets; empty if the mesh has none.
    pub targets: Vec<MorphTarget>,
    /// The joints that move the vertices; `None` if only morph targets change the mesh.
    pub skin: Option<Skin>,
}

/// Vertices in one shape. Normals and tangents are empty where the mesh has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vertices {
    /// Positions in object space, in its units.
    pub positions: Vec<Vec3>,
    /// Unit normals in object space.
    pub normals: Vec<Vec3>,
    /// Unit tangents in object space; w is the sign of the bitangent.
    pub tangents: Vec<Vec4>,
}

/// A morph target: offsets of the vertices, which are added after they are multiplied by a weight.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphTarget {
    /// The weight, usually in [0, 1], without a unit; any finite number is allowed.
    pub weight: Animated<f64>,
    /// Offsets of the positions, one for each vertex; empty if the target changes no positions.
    pub positions: Vec<Vec3>,
    /// Offsets of the normals, one for each vertex; empty if the target changes no normals.
    pub normals: Vec<Vec3>,
    /// Offsets of the tangents, one for each vertex; empty if the target changes no tangents.
    pub tangents: Vec<Vec3>,
}

/// The joints of a skin, and the weights with which each vertex follows them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Joints, by whose index influences name them.
    pub joints: Vec<Joint>,
    /// For each vertex, the index in `influences` of its first influence, and at the end the number of all influences.
    pub first_influence: Vec<u32>,
    /// The influences of all vertices. The weights of a vertex sum to 1.
    pub influences: Vec<Influence>,
    /// The transform from the world, where the joints are, to the object space of the mesh's instance.
    pub world_to_object: DAffine3,
}

/// A joint of a skin: a node that moves vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Index into [`super::Motion::nodes`].
    pub node: u32,
    /// The transform from the rest shape to the space of the node. In the pose in which the skin was bound to the mesh, the
    /// product of the node's transform and this one is the same for all joints.
    pub inverse_bind: DAffine3,
}

/// The share with which a vertex follows one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Index into [`Skin::joints`].
    pub joint: u32,
    /// Weight in (0, 1].
    pub weight: f32,
}

/// The values on which the shape of a deforming mesh depends, at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// For each joint of the skin, the transform from the rest shape to the object space of the mesh's instance.
    pub joints: Vec<DAffine3>,
    /// For each morph target, its weight.
    pub weights: Vec<f64>,
}

impl Deformation {
    /// The shape at `time`, in seconds. `to_world` has the transform of each node of the motion to the world at this time.
    pub(super) fn shape(&self, time: f64, to_world: &[DAffine3]) -> Shape {
        let joints = self.skin.iter().flat_map(|skin| {
            let joints = skin.joints.iter();
            joints.map(|j| skin.world_to_object * to_world[j.node as usize] * j.inverse_bind)
        });
        Shape {
            joints: joints.collect(),
            weights: self.targets.iter().map(|t| t.weight.at(time)).collect(),
        }
    }

    /// The vertices of the mesh in `shape`. A normal or a tangent that joints flatten to nothing keeps its rest direction.
    pub fn deform(&self, shape: &Shape) -> Vertices {
        let count = self.rest.positions.len();
        let moved = (0..count)
            .into_par_iter()
            .map(|vertex| self.vertex(vertex, shape));
        let mut vertices = Vertices::default();
        let mut normals = Vec::with_capacity(self.rest.normals.len());
        let mut tangents = Vec::with_capacity(self.rest.tangents.len());
        for (position, normal, tangent) in moved.collect::<Vec<_>>() {
            vertices.positions.push(position);
            normals.extend(normal);
            tangents.extend(tangent);
        }
        (vertices.normals, vertices.tangents) = (normals, tangents);
        vertices
    }

    fn vertex(&self, vertex: usize, shape: &Shape) -> (Vec3, Option<Vec3>, Option<Vec4>) {
        let rest = &self.rest;
        let mut position = rest.positions[vertex].as_dvec3();
        let mut normal = rest.normals.get(vertex).map(|normal| normal.as_dvec3());
        let tangent = rest.tangents.get(vertex);
        let mut mirrors = false;
        let mut along = tangent.map(|tangent| tangent.truncate().as_dvec3());
        for (target, weight) in self.targets.iter().zip(&shape.weights) {
            let offset = |offsets: &[Vec3]| {
                let offset = offsets.get(vertex).copied().unwrap_or_default();
                *weight * offset.as_dvec3()
            };
            position += offset(&target.positions);
            normal = normal.map(|normal| normal + offset(&target.normals));
            along = along.map(|along| along + offset(&target.tangents));
        }
        if let Some(skin) = &self.skin {
            let matrix = skin.matrix(vertex, shape);
            position = matrix.transform_point3(position);
            let of_normals = normal_matrix(matrix.matrix3);
            normal = normal.map(|normal| of_normals * normal);
            along = along.map(|along| matrix.matrix3 * along);
            // The bitangent is moved too, not mirrored as the cross product would be.
            mirrors = matrix.matrix3.determinant() < 0.0;
        }
        let unit = |v: DVec3, rest: Vec3| v.try_normalize().map_or(rest, |v| v.as_vec3());
        (
            position.as_vec3(),
            normal.map(|normal| unit(normal, rest.normals[vertex])),
            tangent.zip(along).map(|(tangent, along)| {
                let w = if mirrors { -tangent.w } else { tangent.w };
                unit(along, tangent.truncate()).extend(w)
            }),
        )
    }

    /// True if the shape changes with time. `moves` has one entry per node of the motion: true if the node moves.
    pub(super) fn changes(&self, moves: &[bool]) -> bool {
        let joints = self.skin.iter().flat_map(|skin| &skin.joints);
        self.targets.iter().any(|t| t.weight.track.is_some())
            || joints.into_iter().any(|joint| moves[joint.node as usize])
    }

    /// The nodes of the motion that are joints, as indices.
    pub(super) fn joint_nodes(&self) -> impl Iterator<Item = &u32> {
        let joints = self.skin.iter().flat_map(|skin| &skin.joints);
        joints.map(|joint| &joint.node)
    }

    /// The fault that makes the deformation unusable for `mesh`, as the end of a message; `None` if there is none. `nodes` is
    /// the number of nodes of the motion.
    pub(super) fn fault(&self, mesh: &Mesh, nodes: usize) -> Option<String> {
        let vertices = mesh.positions.len();
        let fits = |count: usize| count == 0 || count == vertices;
        let rest = &self.rest;
        let same = rest.positions.len() == vertices
            && rest.normals.len() == mesh.normals.len()
            && rest.tangents.len() == mesh.tangents.len();
        let targets = (self.targets.iter())
            .all(|t| fits(t.positions.len()) && fits(t.normals.len()) && fits(t.tangents.len()));
        if !same || !targets {
            return Some(format!("its values do not fit the {vertices} vertices"));
        }
        let skin = self.skin.as_ref()?;
        if let Some(joint) = skin.joints.iter().find(|j| j.node as usize >= nodes) {
            return Some(format!("node {} of a joint does not exist", joint.node));
        }
        let ends = skin.first_influence.last().map(|end| *end as usize);
        let ordered = skin.first_influence.is_sorted();
        if skin.first_influence.len() != vertices + 1
            || ends != Some(skin.influences.len())
            || !ordered
        {
            return Some(format!("its influences do not fit the {vertices} vertices"));
        }
        let joints = skin.joints.len();
        let wrong = skin.influences.iter().find(|i| i.joint as usize >= joints);
        wrong.map(|influence| {
            let joint = influence.joint;
            format!("joint {joint} is out of range, there are {joints}")
        })
    }
}

impl Skin {
    /// The mean of the joints' transforms by which the vertex moves, weighted by its influences.
    fn matrix(&self, vertex: usize, shape: &Shape) -> DAffine3 {
        let range =
            self.first_influence[vertex] as usize..self.first_influence[vertex + 1] as usize;
        let mut sum = DAffine3 {
            matrix3: DMat3::ZERO,
            translation: DVec3::ZERO,
        };
        for influence in &self.influences[range] {
            let joint = &shape.joints[influence.joint as usize];
            let weight = f64::from(influence.weight);
            sum.matrix3 += joint.matrix3 * weight;
            sum.translation += joint.translation * weight;
        }
        sum
    }
}

/// The matrix of normals under `matrix`, up to a positive factor: the inverse transpose. It is made of cofactors, so that it
/// exists where joints flatten the mesh.
fn normal_matrix(matrix: DMat3) -> DMat3 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    match x.dot(cofactors.x_axis) < 0.0 {
        true => -cofactors,
        false => cofactors,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            ..Mesh::default()
        }
    }

    /// All vertices follow one joint, node 0.
    fn skinned() -> Deformation {
        let mesh = mesh();
        let influence = Influence {
            joint: 0,
            weight: 1.0,
        };
        Deformation {
            mesh: 0,
            rest: Vertices {
                positions: mesh.positions,
                normals: mesh.normals,
                tangents: Vec::new(),
            },
            targets: Vec::new(),
            skin: Some(Skin {
                joints: vec![Joint {
                    node: 0,
                    inverse_bind: DAffine3::IDENTITY,
                }],
                first_influence: vec![0, 1, 2, 3],
                influences: vec![influence; 3],
                world_to_object: DAffine3::IDENTITY,
            }),
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        type Change = fn(&mut Deformation);
        let changes: [(Change, Option<&str>); 6] = [
            (|_| (), None),
            (|d| d.rest.positions.clear(), Some("3 vertices")),
            (|d| d.rest.normals.clear(), Some("3 vertices")),
            (
                |d| d.skin.as_mut().unwrap().joints[0].node = 1,
                Some("node 1 of a joint does not exist"),
            ),
            (
                |d| d.skin.as_mut().unwrap().influences[1].joint = 1,
                Some("joint 1 is out of range, there are 1"),
            ),
            (
                |d| d.skin.as_mut().unwrap().first_influence = vec![0, 3, 2, 3],
                Some("influences do not fit"),
            ),
        ];
        for (change, expected) in changes {
            let mut deformation = skinned();
            change(&mut deformation);
            let fault = deformation.fault(&mesh(), 1);
            match expected {
                None => assert_eq!(fault, None),
                Some(expected) => assert!(fault.unwrap().contains(expected)),
            }
        }
    }

    /// A joint that mirrors moves the bitangent, which the normal, the tangent and its sign give.
    #[test]
    fn bitangents_follow_mirrors() {
        let mut deformation = skinned();
        deformation.rest.tangents = vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 3];
        let bitangent = |vertices: &Vertices| {
            let tangent = vertices.tangents[0];
            tangent.w * vertices.normals[0].cross(tangent.truncate())
        };
        let rest = bitangent(&deformation.rest).as_dvec3();
        for scale in [
            DVec3::ONE,
            DVec3::new(-1.0, 1.0, 1.0),
            DVec3::new(1.0, -1.0, 1.0),
            DVec3::new(1.0, 1.0, -1.0),
            DVec3::NEG_ONE,
        ] {
            let matrix = DAffine3::from_rotation_x(0.7) * DAffine3::from_scale(scale);
            let shape = deformation.shape(0.0, &[matrix]);
            let moved = bitangent(&deformation.deform(&shape)).as_dvec3();
            let off = moved - matrix.matrix3 * rest;
            assert!(off.length() < 1e-6, "{scale}: {off}");
        }
    }

    /// Normals stay at right angles to a surface that joints scale, mirror or flatten.
    #[test]
    fn normals_stay_normal() {
        let mut deformation = skinned();
        let slope = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        deformation.rest.normals = vec![slope.as_vec3(); 3];
        let along = [DVec3::new(2.0, -1.0, 0.0), DVec3::new(0.0, 1.0, -1.0)];
        for scale in [
            DVec3::new(3.0, 1.0, 0.5),
            DVec3::new(-2.0, 1.0, 1.0),
            DVec3::new(1.0, 1.0, 0.0),
        ] {
            let matrix = DAffine3::from_rotation_x(0.7) * DAffine3::from_scale(scale);
            let shape = deformation.shape(0.0, &[matrix]);
            let normal = deformation.deform(&shape).normals[0].as_dvec3();
            assert!((normal.length() - 1.0).abs() < 1e-6);
            for along in along {
                let off = normal.dot(matrix.matrix3 * along);
                assert!(off.abs() < 1e-6, "{scale}: {off}");
            }
            // On the same side as the surface's own outside.
            assert!(normal.dot(matrix.matrix3 * slope) >= -1e-6, "{scale}");
        }
    }
}
