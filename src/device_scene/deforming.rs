//! Meshes that change their shape with time, as the device stores them: twice, for the shapes of the current and of the
//! previous frame. In each frame, the older of the two shapes is replaced. Instances name the copy that they show, so that
//! shaders read positions, normals and trees of both frames in the same way.

use super::geometry::{Geometry, MeshOffsets, bounds, pack_octahedral, pack_tangent};
use super::merge_static::TracedScene;
use super::refit::refit;
use crate::Result;
use crate::gpu::Buffer;
use crate::scene::motion::check_vertices;
use crate::scene::motion::deformation::{Deformation, Shape, Vertices};
use crate::shader_interface::{GpuInstance, NONE};
use glam::{DAffine3, DVec3, UVec3, Vec3};
use obvhs::cwbvh::node::CwBvhNode;
use rayon::prelude::*;

/// The number of stored copies of a mesh that deforms: for the current and for the previous frame.
pub const COPIES: usize = 2;

/// A mesh that deforms, with what its shapes have in common.
pub struct DeformingMesh {
    /// The index of the mesh in the traced scene (after static meshes are merged).
    pub mesh: u32,
    /// The index of its deformation in the scene, and so of its shape in a pose.
    pub deformation_index: usize,
    name: String,
    deformation: Deformation,
    triangles: Vec<[u32; 3]>,
    /// For each stored triangle, its index in `triangles`.
    order: Vec<u32>,
    /// The tree over the triangles in their first shape, whose indices count from its own start; empty for ray queries.
    nodes: Vec<CwBvhNode>,
    /// The transform from object space to that of the stored positions.
    to_stored: DAffine3,
    copies: [Copy; COPIES],
}

/// The indices at which one copy of a mesh begins in the arrays of [`Geometry`].
#[derive(Clone, Copy)]
struct Copy {
    first_triangle: u32,
    first_normal: u32,
    first_tangent: u32,
    root_node: u32,
}

/// The buffers of the scene that hold the shapes of meshes.
#[derive(Clone, Copy)]
pub struct ShapeBuffers<'a> {
    /// The corners of triangles.
    pub positions: &'a Buffer,
    /// The normals and tangents of corners.
    pub corner_directions: &'a Buffer,
    /// The nodes of trees.
    pub nodes: &'a Buffer,
}

/// A mesh in one shape, as it is uploaded.
pub struct DeformedMesh {
    /// The values from which the shape was computed.
    pub shape: Shape,
    /// The vertices in object space, from which emissive triangles take their corners.
    pub vertices: Vertices,
    /// The smallest and the largest stored coordinates.
    pub bounds: (Vec3, Vec3),
    positions: Vec<[Vec3; 3]>,
    normals: Vec<UVec3>,
    tangents: Vec<UVec3>,
    nodes: Vec<CwBvhNode>,
}

impl DeformingMesh {
    /// Adds the second copy of every mesh that deforms to `geometry`, and returns these meshes in the order of the traced
    /// scene.
    pub fn reserve(traced: &TracedScene<'_>, geometry: &mut Geometry) -> Vec<Self> {
        let meshes = (0..).zip(&traced.deformations);
        let meshes = meshes.filter_map(|(mesh, deformation)| {
            deformation.map(|deformation| Self::reserve_one(mesh, deformation, traced, geometry))
        });
        meshes.collect()
    }

    fn reserve_one(
        index: u32,
        (deformation_index, deformation): (usize, &Deformation),
        traced: &TracedScene<'_>,
        geometry: &mut Geometry,
    ) -> Self {
        let offsets = geometry.meshes[index as usize];
        let mesh = &traced.scene.meshes[index as usize];
        let MeshOffsets {
            first_triangle,
            first_normal,
            first_tangent,
            root_node,
            ..
        } = offsets;
        let first = Copy {
            first_triangle,
            first_normal,
            first_tangent,
            root_node,
        };
        let count = offsets.triangle_count as usize;
        let range = |first: u32, count: usize| first as usize..first as usize + count;
        let second_triangle = geometry.positions.len() as u32;
        geometry
            .positions
            .extend_from_within(range(first_triangle, count));
        let mut second_directions = |first: u32| {
            if first == NONE {
                return NONE;
            }
            let second = geometry.corner_directions.len() as u32;
            geometry
                .corner_directions
                .extend_from_within(range(first, count));
            second
        };
        let (second_normal, second_tangent) = (
            second_directions(first_normal),
            second_directions(first_tangent),
        );
        let second_root = geometry.nodes.len() as u32;
        let stored_nodes = range(root_node, offsets.node_count as usize);
        let nodes: Vec<CwBvhNode> = geometry.nodes[stored_nodes]
            .iter()
            .map(|node| CwBvhNode {
                child_base_idx: node.child_base_idx.wrapping_sub(root_node),
                primitive_base_idx: node.primitive_base_idx.wrapping_sub(first_triangle),
                ..*node
            })
            .collect();
        let second = Copy {
            first_triangle: second_triangle,
            first_normal: second_normal,
            first_tangent: second_tangent,
            root_node: if nodes.is_empty() { 0 } else { second_root },
        };
        geometry.nodes.extend(second.placed(&nodes, 0));
        Self {
            mesh: index,
            deformation_index,
            name: mesh.name.clone(),
            deformation: deformation.clone(),
            triangles: mesh.triangles.clone(),
            order: geometry.order[range(first_triangle, count)].to_vec(),
            nodes,
            to_stored: offsets.to_object.inverse(),
            copies: [first, second],
        }
    }

    /// The mesh in a shape that it has at `time`, in seconds. Fails if a vertex is further away than can be rendered.
    pub fn deformed(&self, shape: &Shape, time: f64) -> Result<DeformedMesh> {
        let vertices = self.deformation.deform(shape);
        check_vertices(&self.name, &vertices.positions, time)?;
        let stored = |p: Vec3| self.to_stored.transform_point3(p.as_dvec3()).as_vec3();
        let ordered = || self.order.par_iter().map(|&t| self.triangles[t as usize]);
        let positions: Vec<[Vec3; 3]> = ordered()
            .map(|t| t.map(|i| stored(vertices.positions[i as usize])))
            .collect();
        let directions = |is_there: bool, pack: &(dyn Fn(usize) -> u32 + Sync)| match is_there {
            false => Vec::new(),
            true => ordered()
                .map(|t| UVec3::from_array(t.map(|i| pack(i as usize))))
                .collect(),
        };
        let normals = directions(self.copies[0].first_normal != NONE, &|i| {
            pack_octahedral(vertices.normals[i])
        });
        let tangents = directions(self.copies[0].first_tangent != NONE, &|i| {
            pack_tangent(vertices.tangents[i])
        });
        let mut nodes = self.nodes.clone();
        let bounds = match nodes.is_empty() {
            false => refit(&mut nodes, &positions),
            true => bounds(positions.as_flattened().iter().copied()),
        };
        Ok(DeformedMesh {
            shape: shape.clone(),
            vertices,
            bounds,
            positions,
            normals,
            tangents,
            nodes,
        })
    }

    /// The corners, in object space, of the triangle with the index `triangle` in the order of the scene's mesh.
    pub fn corners(&self, deformed: &DeformedMesh, triangle: u32) -> [DVec3; 3] {
        let corners = self.triangles[triangle as usize];
        corners.map(|i| deformed.vertices.positions[i as usize].as_dvec3())
    }

    /// Lets an instance of the mesh show the copy with the index `copy`.
    pub fn show(&self, instance: &mut GpuInstance, copy: usize) {
        let Copy {
            first_triangle,
            first_normal,
            first_tangent,
            root_node,
        } = self.copies[copy];
        instance.first_triangle = first_triangle;
        instance.first_normal = first_normal;
        instance.first_tangent = first_tangent;
        instance.root_node = root_node;
    }

    /// The index in the buffer `positions` of the first triangle of the copy with the index `copy`.
    pub fn first_triangle(&self, copy: usize) -> u32 {
        self.copies[copy].first_triangle
    }

    /// Writes a shape into the copy with the index `copy`. `mesh_nodes` is the index in the buffer `nodes` of the first node of
    /// the meshes' trees. Fails if the device fails.
    pub fn upload(
        &self,
        deformed: &DeformedMesh,
        copy: usize,
        mesh_nodes: u32,
        buffers: ShapeBuffers<'_>,
    ) -> Result<()> {
        let copy = self.copies[copy];
        let first = copy.first_triangle as usize;
        buffers.positions.write_at(first, &deformed.positions)?;
        let directions = buffers.corner_directions;
        if !deformed.normals.is_empty() {
            directions.write_at(copy.first_normal as usize, &deformed.normals)?;
        }
        if !deformed.tangents.is_empty() {
            directions.write_at(copy.first_tangent as usize, &deformed.tangents)?;
        }
        if deformed.nodes.is_empty() {
            return Ok(());
        }
        let nodes: Vec<CwBvhNode> = copy.placed(&deformed.nodes, mesh_nodes).collect();
        let first = (mesh_nodes + copy.root_node) as usize;
        buffers.nodes.write_at(first, &nodes)
    }
}

impl Copy {
    /// The nodes of a tree in this copy. `mesh_nodes` is the index of the first node of the meshes' trees.
    fn placed<'a>(
        &self,
        nodes: &'a [CwBvhNode],
        mesh_nodes: u32,
    ) -> impl Iterator<Item = CwBvhNode> + use<'a> {
        let (first_node, first_triangle) = (self.root_node + mesh_nodes, self.first_triangle);
        nodes.iter().map(move |node| CwBvhNode {
            child_base_idx: node.child_base_idx.wrapping_add(first_node),
            primitive_base_idx: node.primitive_base_idx.wrapping_add(first_triangle),
            ..*node
        })
    }
}
