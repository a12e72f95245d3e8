//! The triangles of a scene's meshes, in the arrays that are uploaded for shaders. If a compute shader traces rays through a
//! tree, the triangles of each mesh are in the order of the leaves of that tree, so that each leaf is a range of triangles.
//! With ray queries, they keep the order of the mesh.

use super::compute_bvh::Tree;
use super::merge_static::TracedScene;
use super::units::power_of_two;
use crate::scene::lights::Emitters;
use crate::scene::{AlphaMode, Material, Mesh};
use crate::shader_interface::NONE;
use glam::{DAffine3, DVec3, UVec2, UVec3, Vec2, Vec3, Vec4};
use obvhs::cwbvh::node::CwBvhNode;
use rayon::prelude::*;

/// The indices at which the data of one mesh begin in the arrays of [`Geometry`], with the properties of the mesh that all
/// its instances share. Each instance on the device gets a copy of the indices, with which shaders find the data of a
/// triangle that a ray hits.
#[derive(Clone, Copy, Debug)]
pub struct MeshOffsets {
    /// The index of the mesh's first triangle in [`Geometry::positions`]. Shaders add to it the index of a
    /// triangle in the mesh.
    pub first_triangle: u32,
    /// The number of triangles of the mesh, which are consecutive in [`Geometry::positions`].
    pub triangle_count: u32,
    /// The index in [`Geometry::corner_directions`] of the corner normals of the mesh's first triangle; NONE for a mesh
    /// without normals, which is shaded flat.
    pub first_normal: u32,
    /// The index in [`Geometry::uvs`] of the texture coordinates of the mesh's first triangle: x for the first set of
    /// texture coordinates, y for the second set. It is NONE for a set that the mesh lacks.
    pub first_uvs: UVec2,
    /// The index in [`Geometry::colors`] of the vertex colours of the mesh's first triangle; NONE for a mesh without vertex
    /// colours.
    pub first_color: u32,
    /// The index in [`Geometry::corner_directions`] of the corner tangents of the mesh's first triangle; NONE for a mesh
    /// without tangents.
    pub first_tangent: u32,
    /// The index of the mesh's first triangle in [`Geometry::parts`]. It is NONE for a mesh with one part (run of triangles
    /// with one material) that never emits and was not merged from several meshes. The instance then states the material.
    pub first_part: u32,
    /// The index in [`Geometry::nodes`] of the root of the tree over the mesh's triangles; 0 if the driver builds the trees,
    /// for ray queries.
    pub root_node: u32,
    /// The number of nodes of that tree; 0 if the driver builds the trees.
    pub node_count: u32,
    /// True if every material of the mesh is opaque. Ray queries then accept each hit at once; otherwise the shader tests
    /// the alpha of the hit.
    pub opaque: bool,
    /// The number of the mesh's triangles that emit light at some time. Each instance of the mesh adds that many emissive
    /// triangles to the list of lights.
    pub lights: u32,
    /// The transform from the stored positions in [`Geometry::positions`] to the mesh's object space. A mesh of extreme size
    /// is stored scaled, and a mesh far from its own origin is stored translated, so that f32 is precise enough. For other
    /// meshes the transform is the identity.
    pub to_object: DAffine3,
    /// The smallest and the largest x, y and z of the mesh's stored positions, before `to_object` is applied. From them, the
    /// box of each instance in the world is computed, for the tree over the instances. Zero for a mesh without positions.
    pub bounds: (Vec3, Vec3),
}

/// The triangles of all meshes, as they are uploaded into the scene's buffers. If rays are traced in compute,
/// there is also one tree per mesh over its triangles. In an array with entries per triangle, the entries of
/// one mesh follow those of the mesh before it. An array of an optional attribute, such as vertex colours,
/// has no entries for a mesh that lacks the attribute.
#[derive(Default)]
pub struct Geometry {
    /// The stored positions of the three corners of each triangle. [`MeshOffsets::to_object`] converts stored positions to
    /// the object space of the mesh; for most meshes it is the identity.
    pub positions: Vec<[Vec3; 3]>,
    /// Three unit vectors in object space per triangle, packed by [`pack_octahedral`]: the corner normals of each mesh that
    /// has normals, and the corner tangents of each mesh with normal maps. The tangents of a mesh follow the normals of all
    /// its triangles. The lowest bit of a tangent is 1 if the sign of the bitangent is negative.
    pub corner_directions: Vec<UVec3>,
    /// The texture coordinates of the three corners of each triangle. A mesh with two sets has two entries per triangle:
    /// first those of all its triangles for the first set, then those for the second set.
    pub uvs: Vec<[Vec2; 3]>,
    /// The colours of the three corners of each triangle, for meshes with vertex colours. Each colour is RGBA in [0, 1],
    /// with 16 bits per channel. The first word has red in its lower half and green in its upper half; the second word has
    /// blue and alpha in the same way.
    pub colors: Vec<[UVec2; 3]>,
    /// Three numbers per triangle, with which shaders find the material, the light and the instance of a hit. They exist for
    /// each mesh that has several parts (runs of triangles with one material), emits light, or was merged from several
    /// meshes. The first number is the index of the triangle's material, the second is its rank among the mesh's emissive
    /// triangles, or NONE if it never emits. The third is an offset: added to `GpuInstance::id`, it gives the index of the
    /// original scene's instance to which the triangle belongs.
    pub parts: Vec<UVec3>,
    /// The eight-wide nodes of the trees over all meshes' triangles, through which a compute shader traces rays; empty if
    /// the driver builds the trees, for ray queries. Indices of child nodes count from the start of this array, and indices
    /// of triangles from the start of `positions`.
    pub nodes: Vec<CwBvhNode>,
    /// For each triangle in `positions`, its index in [`Mesh::triangles`], that is, before the triangles were
    /// put into the order of the tree's leaves. With it, an emissive triangle of a mesh is found among the
    /// stored triangles.
    pub order: Vec<u32>,
    /// One entry per mesh of the traced scene, in the same order: the indices at which its data begin in the
    /// other arrays.
    pub meshes: Vec<MeshOffsets>,
    /// The number of levels of the deepest tree over a mesh, from which the size of the traversal's stack is computed; 0 if
    /// the driver builds the trees.
    pub depth: u32,
}

impl Geometry {
    /// Stores the triangles of every mesh of the traced scene. If `trees` is true, a tree for tracing in compute is built
    /// over each mesh, and the mesh's triangles are stored in the order of the leaves. Otherwise they are stored in the
    /// order of [`Mesh::triangles`].
    pub fn new(traced: &TracedScene<'_>, trees: bool) -> Self {
        let mut geometry = Self::default();
        let emitters = Emitters::new(&traced.scene, &traced.emitter_materials);
        for (index, mesh) in traced.scene.meshes.iter().enumerate() {
            let ids = &traced.part_ids[index];
            let rest = traced.deformations[index].map_or(&[][..], |(_, deformation)| {
                deformation.rest.positions.as_slice()
            });
            let placing = Placing::of(&mesh.positions, rest);
            geometry.push(
                mesh,
                ids,
                placing,
                &traced.scene.materials,
                &emitters,
                trees,
            );
        }
        geometry
    }

    /// For each triangle of the mesh with the index `mesh`, in the order of [`Mesh::triangles`]: its index among the stored
    /// triangles of the mesh, where 0 is [`MeshOffsets::first_triangle`]. Lights with holes (alpha mode mask) store this
    /// index, so that shaders can read the alpha at a point of the light.
    pub fn traced_index(&self, mesh: u32) -> Vec<u32> {
        let offsets = self.meshes[mesh as usize];
        let first = offsets.first_triangle as usize;
        let mut index = vec![0; offsets.triangle_count as usize];
        let order = &self.order[first..first + index.len()];
        for (at, triangle) in (0..).zip(order) {
            index[*triangle as usize] = at;
        }
        index
    }

    fn push(
        &mut self,
        mesh: &Mesh,
        part_ids: &[u32],
        placing: Placing,
        materials: &[Material],
        emitters: &Emitters<'_>,
        trees: bool,
    ) {
        let (low, high) = bounds(mesh.positions.iter().copied());
        let Placing { centre, unit } = placing;
        let stored = |position: Vec3| (position - centre) / unit;
        let triangles = &mesh.triangles;
        let corners = |t: usize| triangles[t].map(|i| stored(mesh.positions[i as usize]));
        let mut offsets = MeshOffsets {
            first_triangle: self.positions.len() as u32,
            triangle_count: triangles.len() as u32,
            first_normal: NONE,
            first_uvs: UVec2::splat(NONE),
            first_color: NONE,
            first_tangent: NONE,
            first_part: NONE,
            root_node: 0,
            node_count: 0,
            opaque: (mesh.parts.iter())
                .all(|part| materials[part.material as usize].alpha_mode == AlphaMode::Opaque),
            lights: 0,
            to_object: DAffine3::from_translation(centre.as_dvec3())
                * DAffine3::from_scale(DVec3::splat(unit.into())),
            bounds: (stored(low), stored(high)),
        };
        let order: Vec<u32> = if trees {
            let tree = Tree::over_triangles(triangles.len(), corners);
            offsets.root_node = self.nodes.len() as u32;
            offsets.node_count = tree.nodes.len() as u32;
            self.nodes
                .extend(tree.placed(offsets.root_node, offsets.first_triangle));
            self.depth = self.depth.max(tree.depth);
            tree.order
        } else {
            (0..triangles.len() as u32).collect()
        };
        let ordered = || order.par_iter().map(|&t| t as usize);
        self.positions.par_extend(ordered().map(corners));
        if !mesh.normals.is_empty() {
            offsets.first_normal = self.corner_directions.len() as u32;
            let corners =
                |t: usize| triangles[t].map(|i| pack_octahedral(mesh.normals[i as usize]));
            self.corner_directions
                .par_extend(ordered().map(corners).map(UVec3::from_array));
        }
        for (set, uvs) in mesh
            .uvs
            .iter()
            .enumerate()
            .filter(|(_, uvs)| !uvs.is_empty())
        {
            offsets.first_uvs[set] = self.uvs.len() as u32;
            let corners = |t: usize| triangles[t].map(|i| uvs[i as usize]);
            self.uvs.par_extend(ordered().map(corners));
        }
        if !mesh.colors.is_empty() {
            offsets.first_color = self.colors.len() as u32;
            let corners = |t: usize| triangles[t].map(|i| pack_color(mesh.colors[i as usize]));
            self.colors.par_extend(ordered().map(corners));
        }
        if !mesh.tangents.is_empty() {
            offsets.first_tangent = self.corner_directions.len() as u32;
            let corners = |t: usize| triangles[t].map(|i| pack_tangent(mesh.tangents[i as usize]));
            self.corner_directions
                .par_extend(ordered().map(corners).map(UVec3::from_array));
        }
        if mesh.parts.len() > 1
            || !part_ids.is_empty()
            || mesh.parts.iter().any(|part| emitters.may_emit(part))
        {
            // The rank counts emissive triangles in the mesh's own order, which no tracer changes:
            // so a light keeps its index, and random numbers select the same light with both.
            let mut of_triangle = vec![UVec3::new(0, NONE, 0); triangles.len()];
            for (index, part) in mesh.parts.iter().enumerate() {
                for triangle in part.range() {
                    let entry = &mut of_triangle[triangle as usize];
                    entry.x = part.material;
                    entry.z = part_ids.get(index).copied().unwrap_or(0);
                    if emitters.emits(mesh, part, triangle) {
                        entry.y = offsets.lights;
                        offsets.lights += 1;
                    }
                }
            }
            offsets.first_part = self.parts.len() as u32;
            self.parts.par_extend(ordered().map(|t| of_triangle[t]));
        }
        self.order.extend(order);
        self.meshes.push(offsets);
    }
}

/// The point of a mesh's object space that is stored as zero, and the length that is stored as 1, in units of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placing {
    centre: Vec3,
    unit: f32,
}

impl Placing {
    /// Chooses them for a mesh with the vertices `positions` at time 0. `rest` are the vertices of a mesh that deforms before
    /// its deformation; empty for others.
    fn of(positions: &[Vec3], rest: &[Vec3]) -> Self {
        let (mut low, mut high) = bounds(positions.iter().copied());
        if !is_ordinary((high - low).max_element()) {
            // A mesh that deforms may be nothing at time 0 and grow later.
            (low, high) = bounds(positions.iter().chain(rest).copied());
        }
        let extent = (high - low).max_element();
        let centre = low * 0.5 + high * 0.5;
        // A mesh far from its own origin is translated to it, so that the precision of f32 fits its size. Other meshes
        // keep their positions to the bit.
        let is_far = centre.abs().max_element() > extent;
        Self {
            centre: if is_far { centre } else { Vec3::ZERO },
            unit: unit_of(extent),
        }
    }
}

/// The upper limit of the sizes of meshes that are stored without a scale, in units of the mesh; the lower
/// limit is its reciprocal. The size of a mesh is the longest side of the box around it. Within these limits,
/// a product of two coordinates neither exceeds the range of f32 nor is so small that it loses digits.
const ORDINARY: f32 = (1_u64 << 40) as f32;

/// True if `extent`, the longest side of the box around a mesh, is at least 1 / [`ORDINARY`] and below [`ORDINARY`].
fn is_ordinary(extent: f32) -> bool {
    (ORDINARY.recip()..ORDINARY).contains(&extent)
}

/// The length, in units of the mesh, that is stored as 1. It is 1 if `extent`, the longest side of the box around the mesh,
/// is ordinary. Otherwise it is a power of two near `extent`.
fn unit_of(extent: f32) -> f32 {
    if is_ordinary(extent) {
        return 1.0;
    }
    power_of_two(extent.clamp(f32::MIN_POSITIVE, f32::MAX).into()) as f32
}

/// The smallest and the largest x, y and z of a mesh's positions, for its bounding box; both are zero if there are no
/// positions.
pub(super) fn bounds(positions: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    positions
        .map(|p| (p, p))
        .reduce(|(low, high), (p, _)| (low.min(p), high.max(p)))
        .unwrap_or_default()
}

/// Packs a colour with channels in [0, 1] as 16 bits per channel: red and green in the lower and upper half
/// of the first word, blue and alpha in those of the second word. [`Geometry::colors`] stores vertex colours
/// in this form.
fn pack_color(color: Vec4) -> UVec2 {
    let steps = (color * 65535.0).round();
    let [r, g, b, a] = steps.to_array().map(|step| step as u32);
    UVec2::new(r | g << 16, b | a << 16)
}

/// Packs the direction of a tangent by [`pack_octahedral`], and sets the lowest bit to 1 if `tangent.w`, the sign of the
/// bitangent, is negative. A tangent of length 0 is packed as +X. Shaders never read it, because the surface at such a
/// vertex has no normal map.
pub(super) fn pack_tangent(tangent: Vec4) -> u32 {
    let direction = tangent.truncate().try_normalize().unwrap_or(Vec3::X);
    pack_octahedral(direction) & !1 | u32::from(tangent.w < 0.0)
}

/// Packs a unit vector, such as a normal, into one word, so that it takes a third of the memory. The word has two octahedral
/// coordinates (Cigolle et al., JCGT 2014), each a signed 16-bit integer; the first is in the lower half.
pub fn pack_octahedral(normal: Vec3) -> u32 {
    let n = normal / normal.abs().element_sum();
    let folded = if n.z >= 0.0 {
        Vec2::new(n.x, n.y)
    } else {
        let sign = Vec2::new(1_f32.copysign(n.x), 1_f32.copysign(n.y));
        (Vec2::ONE - Vec2::new(n.y, n.x).abs()) * sign
    };
    let quantised = (folded.clamp(-Vec2::ONE, Vec2::ONE) * 32767.0).round();
    let word = |value: f32| u32::from(value as i16 as u16);
    word(quantised.x) | word(quantised.y) << 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mesh that is nothing at time 0 is stored for the size that it has at rest; others keep their own size.
    #[test]
    fn a_mesh_that_grows_from_nothing_has_room() {
        let rest = [Vec3::NEG_ONE, Vec3::ONE];
        let stored = Placing::of(&[Vec3::ZERO; 2], &rest);
        assert_eq!((stored.centre, stored.unit), (Vec3::ZERO, 1.0));
        let tiny = 2.0_f32.powi(-50);
        assert_eq!(Placing::of(&rest.map(|p| p * tiny), &[]).unit, 2.0 * tiny);
        let far = rest.map(|p| p + Vec3::X * 100.0);
        assert_eq!(Placing::of(&far, &rest).centre, Vec3::X * 100.0);
    }
}
