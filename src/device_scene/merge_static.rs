//! Merges static meshes, those with a single instance that does not move, into at most four large meshes.
//!
//! Where a room's walls, floor and furniture are separate meshes, their boxes overlap, and a ray has to enter each of them.
//! One tree over all their triangles has no such overlap. A mesh with several instances stays separate, so that it is stored
//! once.

use super::materials::table_length;
use crate::scene::motion::deformation::Deformation;
use crate::scene::{Instance, Mesh, Part, Scene};
use glam::{DAffine3, DVec3, Vec2, Vec4};
use std::borrow::Cow;

/// The scene in which rays are traced, after static meshes are merged, with the data that map its instances back to the
/// original scene.
pub struct TracedScene<'a> {
    /// The scene that is traced. Its last meshes and instances are the merged ones; each merged mesh has one instance.
    pub scene: Cow<'a, Scene>,
    /// For each instance of the traced scene, its index in the original scene; 0 for the instance of a merged
    /// mesh, whose parts come from several original instances. Shaders use it to state the instance of a hit,
    /// and to find the instance's motion.
    pub instance_ids: Vec<u32>,
    /// For each traced mesh, one number per part (run of triangles with one material); empty for a mesh that is not merged.
    /// The number plus the entry of the mesh's instance in `instance_ids` is the index of the original instance to which the
    /// part belongs.
    pub part_ids: Vec<Vec<u32>>,
    /// One entry per material of the scene: true if it emits light at some time. The entries are computed from the original
    /// scene, because a merged `scene` lacks the motion, and thus the changes of emission with time.
    pub emitter_materials: Vec<bool>,
    /// For each traced mesh, the index of its deformation in [`crate::scene::Motion::deformations`] and the deformation;
    /// `None` for a mesh that keeps its shape.
    pub deformations: Vec<Option<(usize, &'a Deformation)>>,
}

impl<'a> TracedScene<'a> {
    fn unchanged(scene: &'a Scene) -> Self {
        Self {
            scene: Cow::Borrowed(scene),
            instance_ids: (0..scene.instances.len() as u32).collect(),
            part_ids: vec![Vec::new(); scene.meshes.len()],
            emitter_materials: scene.emitter_materials(),
            deformations: deformations(scene),
        }
    }
}

/// For each mesh of the scene, its deformation with its index among the scene's deformations; `None` if the mesh keeps its
/// shape.
fn deformations(scene: &Scene) -> Vec<Option<(usize, &Deformation)>> {
    let mut of_mesh = vec![None; scene.meshes.len()];
    let deformations = scene.motion.iter().flat_map(|motion| &motion.deformations);
    for (index, deformation) in deformations.enumerate() {
        of_mesh[deformation.mesh as usize] = Some((index, deformation));
    }
    of_mesh
}

/// One entry per instance: true if its mesh is merged with others, because the mesh has no other instance and neither the
/// instance moves nor the mesh deforms. If only one instance meets these conditions, none is merged, because there is no other mesh to merge it
/// with.
fn merged_instances(scene: &Scene) -> Vec<bool> {
    let mut uses = vec![0_u32; scene.meshes.len()];
    for instance in &scene.instances {
        uses[instance.mesh as usize] += 1;
    }
    let deforming = scene.deforming_meshes();
    let merged: Vec<bool> = (scene.instances.iter().enumerate())
        .map(|(index, instance)| {
            let mesh = instance.mesh as usize;
            uses[mesh] == 1 && !scene.moves_instance(index) && !deforming[mesh]
        })
        .collect();
    if merged.iter().filter(|merged| **merged).count() < 2 {
        return vec![false; merged.len()];
    }
    merged
}

/// The number of elements that a scene has on the device, for each kind of element. The sizes of the buffers are computed
/// from these counts before the buffers are filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ElementCounts {
    /// The number of triangles in the buffer `positions`. The triangles of a mesh with several instances are stored, and
    /// counted, once.
    pub triangles: u64,
    /// The number of stored triangles of meshes with vertex normals. Each takes one entry, with the normals of its three
    /// corners, in the buffer `corner_directions`. Triangles of other meshes take none, and are shaded flat.
    pub smooth_triangles: u64,
    /// The number of entries in the buffer `uvs`: the stored triangles of meshes with texture coordinates, where a triangle
    /// with two sets counts twice. A merged mesh has each set that one of its original meshes has.
    pub uv_triangles: u64,
    /// The number of entries in the buffer `colors`: the stored triangles of meshes with vertex colours. All triangles of a
    /// merged mesh count if one of its original meshes has colours.
    pub color_triangles: u64,
    /// The number of stored triangles of meshes with vertex tangents. Each takes one entry in the buffer
    /// `corner_directions`. All triangles of a merged mesh count if one of its original meshes has tangents.
    pub tangent_triangles: u64,
    /// The number of entries in the buffer `triangle_parts`: the stored triangles of meshes that have several parts (runs of
    /// triangles with one material), have a material that emits, or were merged from several meshes.
    pub part_triangles: u64,
    /// The number of instances that are traced: those that are not merged, and one per merged mesh. Each has one entry in
    /// the buffer `instances` for each epoch (the current and, if something moves, the previous frame).
    pub instances: u64,
    /// The number of materials in the scene; each has one entry in the buffer `materials`.
    pub materials: u64,
    /// True if some material of the scene has a layer that is seen. The layers of all materials are then stored.
    pub layers: bool,
    /// The number of uses of an image by a material; each use has one entry in the buffer `textures`.
    pub textures: u64,
    /// The number of entries of the texels of all images together, from which the size of the buffer `texels` follows if
    /// shaders read textures from it. A texel with 16 bits per channel has two entries.
    pub texels: u64,
    /// The number of words of the table of sRGB, which comes first in the buffer `texels`.
    pub srgb_table: u64,
    /// The number of emissive triangles in the world, which is the number of entries in the buffer `lights` for each epoch
    /// (the current and, if something moves, the previous frame). A triangle of a mesh counts once for each instance of the
    /// mesh.
    pub triangle_lights: u64,
    /// True if a material that emits at some time has an emissive texture. The texture coordinates of all emissive triangles
    /// are then stored.
    pub textured_lights: bool,
    /// The number of punctual lights in the scene, which is the number of entries in the buffer `punctual_lights` for each
    /// epoch (the current and, if something moves, the previous frame).
    pub punctual_lights: u64,
    /// The number of texels in the image of the environment, and so of entries in the buffers `environment` and
    /// `environment_columns`; 0 for a scene without an environment.
    pub environment_texels: u64,
    /// The number of epochs, that is, of the frames whose instances and lights are stored at the same time. It is 2, for the
    /// current and the previous frame, if something moves; otherwise 1.
    pub epochs: u64,
    /// The number of entries in the buffer `previous_transforms`, which transform the points of an instance from their
    /// positions in the current frame to those in the previous frame. If something moves, it is the number of instances
    /// before merging; otherwise 0.
    pub previous_transforms: u64,
}

impl ElementCounts {
    /// The number of lights of all kinds: emissive triangles, punctual lights, and 1 for an environment, if there is one.
    /// Each alias table that selects among the lights has as many columns.
    pub fn lights(&self) -> u64 {
        self.triangle_lights + self.punctual_lights + u64::from(self.environment_texels > 0)
    }

    /// Counts the elements that `scene` will have on the device after its static meshes are merged. The meshes are not
    /// merged for this, so that a scene that is too large is refused early.
    pub fn of(scene: &Scene) -> Self {
        let merged = merged_instances(scene);
        let motion = scene.motion.as_ref().filter(|motion| motion.moves_things());
        let mut counts = Self {
            materials: scene.materials.len() as u64,
            layers: scene.has_layers(),
            textures: (scene.materials.iter())
                .map(|m| m.textures().count() as u64)
                .sum(),
            texels: (scene.images.iter())
                .map(|image| image.texels.len() as u64)
                .sum(),
            srgb_table: table_length(scene) as u64,
            triangle_lights: scene.emissive_triangle_count(),
            textured_lights: scene.has_textured_lights(),
            punctual_lights: scene.punctual_lights.len() as u64,
            environment_texels: (scene.environment.iter())
                .map(|environment| environment.texels.len() as u64)
                .sum(),
            epochs: if motion.is_some() { 2 } else { 1 },
            previous_transforms: motion.map_or(0, |_| scene.instances.len() as u64),
            ..Self::default()
        };
        let mut is_merged = vec![false; scene.meshes.len()];
        // For each merged mesh: the number of its triangles, the sets of texture coordinates that it has, and
        // whether it has colours and tangents.
        let mut groups = [(0, [false; 2], false, false); GROUPS];
        for (instance, merged) in scene.instances.iter().zip(&merged) {
            let mesh = &scene.meshes[instance.mesh as usize];
            is_merged[instance.mesh as usize] = *merged;
            if *merged {
                let (triangles, sets, colors, tangents) = &mut groups[group(mesh)];
                *triangles += mesh.triangles.len() as u64;
                *colors |= !mesh.colors.is_empty();
                *tangents |= !mesh.tangents.is_empty();
                for (set, uvs) in sets.iter_mut().zip(&mesh.uvs) {
                    *set |= !uvs.is_empty();
                }
            } else {
                counts.instances += 1;
            }
        }
        for (triangles, sets, colors, tangents) in
            groups.iter().filter(|(triangles, ..)| *triangles > 0)
        {
            counts.instances += 1;
            counts.color_triangles += if *colors { *triangles } else { 0 };
            counts.tangent_triangles += if *tangents { *triangles } else { 0 };
            counts.uv_triangles += triangles * sets.iter().filter(|set| **set).count() as u64;
        }
        let merges = merged.contains(&true);
        let mut used = vec![false; scene.meshes.len()];
        for instance in &scene.instances {
            used[instance.mesh as usize] = true;
        }
        let emitter_materials = scene.emitter_materials();
        let deforming = scene.deforming_meshes();
        for (index, mesh) in scene.meshes.iter().enumerate() {
            // Merging drops meshes without instances.
            if merges && !used[index] {
                continue;
            }
            let count = mesh.triangles.len() as u64;
            // A mesh that deforms is stored in two shapes.
            let shapes = if deforming[index] { 2 } else { 1 };
            counts.triangles += shapes * count;
            if !mesh.normals.is_empty() {
                counts.smooth_triangles += shapes * count;
            }
            let emits = mesh
                .parts
                .iter()
                .any(|part| emitter_materials[part.material as usize]);
            if is_merged[index] || mesh.parts.len() > 1 || emits {
                counts.part_triangles += count;
            }
            if !is_merged[index] {
                let sets = mesh.uvs.iter().filter(|uvs| !uvs.is_empty());
                counts.uv_triangles += count * sets.count() as u64;
                counts.color_triangles += if mesh.colors.is_empty() { 0 } else { count };
                counts.tangent_triangles += match mesh.tangents.is_empty() {
                    true => 0,
                    false => shapes * count,
                };
            }
        }
        counts
    }
}

/// The maximum number of merged meshes: one for each combination of vertex attributes that [`group`] distinguishes.
const GROUPS: usize = 4;

/// The index, from 0 to 3, of the merged mesh into which a mesh is merged. Bit 0 is set for meshes with normals, and bit 1
/// for meshes with texture coordinates or colours. So meshes without these attributes do not have to store them.
fn group(mesh: &Mesh) -> usize {
    let varies = !mesh.colors.is_empty() || mesh.uvs.iter().any(|uvs| !uvs.is_empty());
    usize::from(!mesh.normals.is_empty()) + 2 * usize::from(varies)
}

/// Merges the static meshes of a scene (those with a single instance that does not move) into at most four. Positions of
/// merged meshes are relative to `origin`, a point of the world in scene units, because f32 is most precise near zero.
pub fn merge_static(scene: &Scene, origin: DVec3) -> TracedScene<'_> {
    let is_merged = merged_instances(scene);
    if !is_merged.contains(&true) {
        return TracedScene::unchanged(scene);
    }
    let mut left = Scene {
        materials: scene.materials.clone(),
        images: scene.images.clone(),
        punctual_lights: scene.punctual_lights.clone(),
        environment: scene.environment.clone(),
        ..Scene::default()
    };
    let (mut instance_ids, mut part_ids) = (Vec::new(), Vec::new());
    let (of_mesh, mut left_deformations) = (deformations(scene), Vec::new());
    let mut mesh_index_of = vec![None; scene.meshes.len()];
    let mut merged: [(Mesh, Vec<u32>); GROUPS] = Default::default();
    for (index, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        if is_merged[index] {
            let (whole, ids) = &mut merged[group(mesh)];
            let transform = DAffine3::from_translation(-origin) * instance.object_to_world;
            append(whole, mesh, transform);
            ids.extend(mesh.parts.iter().map(|_| index as u32));
        } else {
            let mesh_index = *mesh_index_of[instance.mesh as usize].get_or_insert_with(|| {
                left.meshes.push(mesh.clone());
                part_ids.push(Vec::new());
                left_deformations.push(of_mesh[instance.mesh as usize]);
                left.meshes.len() as u32 - 1
            });
            left.instances.push(Instance {
                mesh: mesh_index,
                ..instance.clone()
            });
            instance_ids.push(index as u32);
        }
    }
    for (mesh, ids) in merged {
        if !mesh.triangles.is_empty() {
            left.instances.push(Instance {
                name: String::new(),
                mesh: left.meshes.len() as u32,
                object_to_world: DAffine3::from_translation(origin),
            });
            instance_ids.push(0);
            left.meshes.push(mesh);
            part_ids.push(ids);
            left_deformations.push(None);
        }
    }
    TracedScene {
        scene: Cow::Owned(left),
        instance_ids,
        part_ids,
        emitter_materials: scene.emitter_materials(),
        deformations: left_deformations,
    }
}

/// Appends `mesh` to the merged mesh `whole`. `transform` is applied to the positions, normals and tangents of `mesh`. If
/// only one of the two meshes has colours, tangents or a set of texture coordinates, the vertices of the other get white as
/// colour, and zeros otherwise. Shaders never read these zeros.
fn append(whole: &mut Mesh, mesh: &Mesh, transform: DAffine3) {
    let turn = transform.matrix3.inverse().transpose();
    // A triangle's front is the side from which object space shows it counter-clockwise; a
    // mirroring transform would turn it over.
    let order = if transform.matrix3.determinant() < 0.0 {
        [0, 2, 1]
    } else {
        [0, 1, 2]
    };
    let first_triangle = whole.triangles.len() as u32;
    let first = whole.positions.len() as u32;
    let positions = mesh.positions.iter().map(|p| p.as_dvec3());
    whole
        .positions
        .extend(positions.map(|p| transform.transform_point3(p).as_vec3()));
    let normals = mesh.normals.iter().map(|n| n.as_dvec3());
    whole
        .normals
        .extend(normals.map(|n| (turn * n).normalize_or_zero().as_vec3()));
    if !mesh.colors.is_empty() || !whole.colors.is_empty() {
        whole.colors.resize(first as usize, Vec4::ONE);
        whole.colors.extend(&mesh.colors);
        whole.colors.resize(whole.positions.len(), Vec4::ONE);
    }
    if !mesh.tangents.is_empty() || !whole.tangents.is_empty() {
        // Those of vertices without a normal map are never read.
        whole.tangents.resize(first as usize, Vec4::ZERO);
        // The bitangent is moved too, not mirrored as the cross product would be.
        let side = transform.matrix3.determinant().signum() as f32;
        whole.tangents.extend(mesh.tangents.iter().map(|tangent| {
            let direction = transform.matrix3 * tangent.truncate().as_dvec3();
            let direction = direction.normalize_or_zero().as_vec3();
            direction.extend(side * tangent.w)
        }));
        whole.tangents.resize(whole.positions.len(), Vec4::ZERO);
    }
    for (whole_uvs, uvs) in whole.uvs.iter_mut().zip(&mesh.uvs) {
        // Those of meshes without this set are never read.
        if !uvs.is_empty() || !whole_uvs.is_empty() {
            whole_uvs.resize(first as usize, Vec2::ZERO);
            whole_uvs.extend(uvs);
            whole_uvs.resize(whole.positions.len(), Vec2::ZERO);
        }
    }
    let triangles = mesh.triangles.iter();
    whole
        .triangles
        .extend(triangles.map(|t| order.map(|corner| first + t[corner])));
    whole.parts.extend(mesh.parts.iter().map(|part| Part {
        first_triangle: first_triangle + part.first_triangle,
        ..*part
    }));
}
