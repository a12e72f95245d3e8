//! The pose of a scene: the state of its instances and lights at one time, as shaders read it.

use super::compute_bvh::Tree;
use super::deforming::{DeformedMesh, DeformingMesh, ShapeBuffers};
use super::geometry::{Geometry, MeshOffsets};
use super::lights::{LightSources, Lights};
use super::merge_static::TracedScene;
use super::units::Units;
use crate::Result;
use crate::scene::Bounds;
use crate::scene::lights::EmitterTriangle;
use crate::scene::motion::{Pose, check_light_transform, check_transform, is_flat};
use crate::scene::validate::LARGEST_COORDINATE;
use crate::shader_interface::{GpuInstance, GpuPreviousTransform, NONE};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Computes the pose of a scene at any time: its instances, its lights and the tree over the instances. It holds all data
/// that do not depend on time. So [`ScenePoser::pose_at`] needs only the current transforms and emission of what changes.
pub struct ScenePoser {
    units: Units,
    instances: Vec<TracedInstance>,
    /// For each instance of the original scene whose mesh is not merged with others, its index in `instances`. The key is
    /// the index in the original scene. A pose gives the transforms of moving instances by original indices, which are
    /// looked up here. Instances with merged meshes never move, and are not in the map.
    traced_index: HashMap<u32, usize>,
    sources: LightSources,
    /// The meshes that deform, in the order of the traced scene.
    deforming: Vec<DeformingMesh>,
    /// For each traced instance, the index in `deforming` of its mesh; `None` if the mesh keeps its shape.
    deforms: Vec<Option<usize>>,
    trees: bool,
    /// The maximum number of levels of the tree over the instances. Compiled shaders traverse the tree with a stack of fixed
    /// size, and a deeper tree would exceed it. The value is `u32::MAX` (no limit) until [`ScenePoser::limit_depth`] sets
    /// it.
    max_depth: u32,
}

/// The data of an instance of the traced scene (after static meshes are merged) that do not depend on time.
/// Each pose computes the instance's entry in the device's array of instances from them. `object_to_world` is
/// the transform from object to world space without motion, in scene units. `mesh` has the indices at which
/// the data of the instance's mesh begin.
struct TracedInstance {
    object_to_world: DAffine3,
    mesh: MeshOffsets,
    /// The instance's entry in the device's array of instances. Its fields `object_to_world` and `world_to_object` are zero
    /// here; each pose sets them.
    constant: GpuInstance,
}

/// The state of a scene's instances and lights at one time. The device's buffers are filled from the pose of the current
/// frame and, if something moves, that of the previous frame.
#[derive(Clone)]
pub struct ScenePose {
    /// The time of the pose in seconds. A new pose is computed only for a time whose pose the device does not
    /// have yet.
    pub time: f64,
    /// All traced instances (after static meshes are merged) with their transforms, in the form in which
    /// shaders read them, except for the field `root_node`. Here this field is the index of the mesh's root
    /// in [`Geometry::nodes`]. On the device, the buffer of nodes has the trees over the instances first,
    /// then the content of [`Geometry::nodes`]. The index at which this content begins is added to
    /// `root_node` when the instances are uploaded.
    pub instances: Vec<GpuInstance>,
    /// The indices in `instances` of all instances that rays can hit; only these are in the tree or the acceleration
    /// structure. An instance is left out if its transform flattens it to a plane, a line or a point.
    pub visible: Vec<u32>,
    /// The tree over the boxes of the instances in `visible`, for tracing in compute; it is empty if the driver builds its
    /// own tree for ray queries.
    pub top: Tree,
    /// The lights at this time, in the device's units. They are uploaded for shaders, and a light BVH takes
    /// its boxes and powers from them.
    pub lights: Lights,
    /// One pair for each instance that may move: its index in the original scene, before meshes are merged, and its
    /// transform from object to world space at this time. From the pairs of two poses, [`ScenePoser::previous_transforms`]
    /// computes where points were in the previous frame.
    pub moved: Vec<(u32, DAffine3)>,
    /// The meshes that deform in their shapes at this time.
    pub deformed: Vec<Arc<DeformedMesh>>,
    /// The index, 0 or 1, of the stored copies of these meshes that have these shapes.
    pub copy: usize,
    /// For each mesh that deforms, true if its stored copy had another shape before this pose, so that it must be written.
    pub is_new: Vec<bool>,
}

impl ScenePoser {
    /// Prepares a scene for posing. If `trees` is true, each pose gets a tree over the instances, which tracing in compute
    /// needs; otherwise its tree is empty. `deforming` are the meshes that deform, in the order of the traced scene.
    pub fn new(
        traced: &TracedScene<'_>,
        geometry: &Geometry,
        deforming: Vec<DeformingMesh>,
        units: Units,
        trees: bool,
    ) -> Self {
        let scene = &traced.scene;
        let mut instances = Vec::with_capacity(scene.instances.len());
        let mut traced_index = HashMap::new();
        let mut light_count = 0;
        for (index, instance) in scene.instances.iter().enumerate() {
            let offsets = geometry.meshes[instance.mesh as usize];
            let parts = &scene.meshes[instance.mesh as usize].parts;
            let id = traced.instance_ids[index];
            // A merged mesh holds several of the scene's instances, none of which moves.
            if traced.part_ids[instance.mesh as usize].is_empty() {
                traced_index.insert(id, index);
            }
            instances.push(TracedInstance {
                object_to_world: instance.object_to_world,
                mesh: offsets,
                constant: GpuInstance {
                    object_to_world: [Vec3::ZERO; 4],
                    world_to_object: [Vec3::ZERO; 4],
                    first_triangle: offsets.first_triangle,
                    first_normal: offsets.first_normal,
                    first_part: offsets.first_part,
                    root_node: offsets.root_node,
                    material: parts.first().map_or(0, |p| p.material),
                    first_light: if offsets.lights > 0 {
                        light_count
                    } else {
                        NONE
                    },
                    id,
                    first_uvs: offsets.first_uvs,
                    first_color: offsets.first_color,
                    first_tangent: offsets.first_tangent,
                    padding: 0,
                },
            });
            light_count += offsets.lights;
        }
        let deforms = scene.instances.iter().map(|instance| {
            let mut meshes = deforming.iter();
            meshes.position(|deforming| deforming.mesh == instance.mesh)
        });
        Self {
            deforms: deforms.collect(),
            deforming,
            units,
            max_depth: u32::MAX,
            instances,
            traced_index,
            sources: LightSources::of(scene, &traced.emitter_materials, |mesh| {
                geometry.traced_index(mesh)
            }),
            trees,
        }
    }

    /// The emissive triangles in object space, in the order of the lights' indices. Callers find the groups of triangles
    /// with common corners in this list, and look up the texture coordinates of the triangles.
    pub fn emitter_triangles(&self) -> &[EmitterTriangle] {
        &self.sources.emitter_triangles
    }

    /// Limits the number of levels of the tree over the instances in all later poses, because the stack of compiled shaders
    /// has a fixed size. `levels` must be at least that of a balanced tree over all instances.
    pub fn limit_depth(&mut self, levels: u32) {
        self.max_depth = levels;
    }

    /// Computes the pose of the scene at `time`, in seconds. `pose` has the transforms at this time of everything that may
    /// move, the emission of each material whose emission changes, and the shapes of all meshes that deform. The stored copies
    /// of `replaced` get these shapes, those with the index 0 without it; a shape that it has already is not computed again.
    ///
    /// # Errors
    /// The transform of an instance or punctual light is not finite, or moves it further from the origin of the device's
    /// coordinates than can be rendered; or a vertex of a mesh that deforms is too far away.
    pub fn pose_at(
        &self,
        time: f64,
        pose: Pose,
        replaced: Option<&ScenePose>,
    ) -> Result<ScenePose> {
        let copy = replaced.map_or(0, |replaced| replaced.copy);
        let (mut deformed, mut is_new) = (Vec::new(), Vec::new());
        for (index, mesh) in self.deforming.iter().enumerate() {
            let shape = &pose.shapes[mesh.deformation_index];
            let stored = replaced.map(|replaced| &replaced.deformed[index]);
            let same = stored.filter(|stored| stored.shape == *shape);
            is_new.push(same.is_none());
            deformed.push(match same {
                Some(same) => same.clone(),
                None => Arc::new(mesh.deformed(shape, time)?),
            });
        }
        let mut to_world: Vec<DAffine3> =
            self.instances.iter().map(|i| i.object_to_world).collect();
        let from_origin = DAffine3::from_translation(-self.units.origin);
        let farthest = self.units.farthest().min(LARGEST_COORDINATE);
        for (moving, transform) in &pose.instances {
            let Some(&index) = self.traced_index.get(moving) else {
                continue;
            };
            to_world[index] = *transform;
        }
        let bounds_of = |index: usize| match self.deforms[index] {
            Some(mesh) => deformed[mesh].bounds,
            None => self.instances[index].mesh.bounds,
        };
        let moving = pose.instances.iter().map(|(moving, _)| moving);
        let moving = moving.filter_map(|moving| self.traced_index.get(moving).copied());
        let deforming = (0..to_world.len()).filter(|index| self.deforms[*index].is_some());
        for index in moving.chain(deforming) {
            let (min, max) = bounds_of(index);
            let bounds = Bounds {
                min: min.as_dvec3(),
                max: max.as_dvec3(),
            };
            let centred = from_origin * to_world[index] * self.instances[index].mesh.to_object;
            let id = self.instances[index].constant.id;
            check_transform(id, &centred, Some(&bounds), time, farthest)?;
        }
        for (moving, transform) in &pose.lights {
            check_light_transform(*moving, &(from_origin * *transform), time, farthest)?;
        }
        let transform_of = |instance: u32| to_world[instance as usize];
        let corners_of = |emitter: &EmitterTriangle| match self.deforms[emitter.instance as usize] {
            Some(mesh) => self.deforming[mesh].corners(&deformed[mesh], emitter.triangle),
            None => emitter.corners,
        };
        let lights = self.sources.placed(
            transform_of,
            corners_of,
            &pose.emission,
            &pose.lights,
            &self.units,
        );

        let mut instances = Vec::with_capacity(to_world.len());
        let (mut visible, mut boxes) = (Vec::new(), Vec::new());
        for (index, (traced, transform)) in self.instances.iter().zip(&to_world).enumerate() {
            let object_to_world = self.on_device(transform, index);
            let mut instance = traced.constant;
            if let Some(mesh) = self.deforms[index] {
                self.deforming[mesh].show(&mut instance, copy);
            }
            if !is_flat(&object_to_world) {
                instance.object_to_world = columns(object_to_world);
                instance.world_to_object = columns(object_to_world.inverse());
                visible.push(index as u32);
                boxes.push(world_box(&object_to_world, bounds_of(index)));
            }
            instances.push(instance);
        }
        if !self.trees {
            boxes.clear();
        }
        Ok(ScenePose {
            time,
            instances,
            visible,
            top: Tree::over_boxes_within(&boxes, self.max_depth),
            lights,
            moved: pose.instances,
            deformed,
            copy,
            is_new,
        })
    }

    /// The same pose, in the other stored copies of the meshes that deform.
    pub fn in_other_copy(&self, pose: &ScenePose) -> ScenePose {
        let mut other = pose.clone();
        other.copy = 1 - pose.copy;
        for (instance, mesh) in other.instances.iter_mut().zip(&self.deforms) {
            if let Some(mesh) = mesh {
                self.deforming[*mesh].show(instance, other.copy);
            }
        }
        other
    }

    /// Writes the new shapes of a pose into the copies of the meshes that the pose is meant for. `mesh_nodes` is the index in the
    /// buffer `nodes` of the first node of the meshes' trees.
    ///
    /// # Errors
    /// The device fails.
    pub fn upload_shapes(
        &self,
        pose: &ScenePose,
        mesh_nodes: u32,
        buffers: ShapeBuffers<'_>,
    ) -> Result<()> {
        for (index, mesh) in self.newly_shaped(pose) {
            let deformed = &pose.deformed[index];
            mesh.upload(deformed, pose.copy, mesh_nodes, buffers)?;
        }
        Ok(())
    }

    /// For each mesh whose shape in `pose` is new, its index in the traced scene and the index in the buffer `positions` of the
    /// first triangle of the copy that the pose is meant for.
    pub fn new_copies(&self, pose: &ScenePose) -> impl Iterator<Item = (u32, u32)> {
        let meshes = self.newly_shaped(pose);
        meshes.map(|(_, mesh)| (mesh.mesh, mesh.first_triangle(pose.copy)))
    }

    fn newly_shaped(&self, pose: &ScenePose) -> impl Iterator<Item = (usize, &DeformingMesh)> {
        let meshes = self.deforming.iter().enumerate();
        meshes.filter(|(index, _)| pose.is_new[*index])
    }

    /// The transform of the traced instance `index` from the stored positions of its mesh to the device's
    /// world space. `object_to_world` is its transform from object space to the world in scene units. The
    /// instance's entry for shaders and its box are computed from the result.
    fn on_device(&self, object_to_world: &DAffine3, index: usize) -> DAffine3 {
        self.units.to_device() * *object_to_world * self.instances[index].mesh.to_object
    }

    /// For each of the `count` instances of the original scene (before merging), the transform of its points from their
    /// positions in the pose `now` to those in the pose `before`, in the device's world space. With it, shaders find the
    /// pixel that showed a point in the previous frame. It is the identity for an instance that does not move, and zero for
    /// an instance that is flat in `now`.
    pub fn previous_transforms(
        &self,
        count: usize,
        now: &ScenePose,
        before: &ScenePose,
    ) -> Vec<GpuPreviousTransform> {
        let mut transforms = vec![previous_transform(DAffine3::IDENTITY); count];
        for ((index, now), (_, before)) in now.moved.iter().zip(&before.moved) {
            let back = if is_flat(now) {
                DAffine3::ZERO
            } else {
                self.units.to_device() * *before * now.inverse() * self.units.to_world()
            };
            transforms[*index as usize] = previous_transform(back);
        }
        transforms
    }
}

fn previous_transform(current_to_previous: DAffine3) -> GpuPreviousTransform {
    GpuPreviousTransform {
        current_to_previous: columns(current_to_previous),
    }
}

fn columns(transform: DAffine3) -> [Vec3; 4] {
    [
        transform.matrix3.x_axis,
        transform.matrix3.y_axis,
        transform.matrix3.z_axis,
        transform.translation,
    ]
    .map(|column| column.as_vec3())
}

/// The box (min, max) of an instance in the device's world space, for the tree over the instances.
/// `object_to_world` transforms the mesh's stored positions to this space. The box is enlarged on each side
/// by a millionth of its largest coordinate, so that rounding errors of rays in object space cause no misses.
fn world_box(object_to_world: &DAffine3, bounds: (Vec3, Vec3)) -> (Vec3, Vec3) {
    let (low, high) = (bounds.0.as_dvec3(), bounds.1.as_dvec3());
    let mut world = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        let p = object_to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
        world = (world.0.min(p), world.1.max(p));
    }
    let reach = world.0.abs().max(world.1.abs()).max_element();
    let pad = DVec3::splat(reach * 1e-6);
    ((world.0 - pad).as_vec3(), (world.1 + pad).as_vec3())
}
