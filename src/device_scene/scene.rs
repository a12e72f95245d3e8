//! A scene on the device: the buffers and acceleration structures that shaders bind to trace rays and read surfaces.

use super::buffers::{SceneBuffers, SceneContents};
use super::compute_bvh::{balanced_depth, max_nodes};
use super::deforming::{DeformingMesh, ShapeBuffers};
use super::environment::EnvironmentTexels;
use super::epochs::{EpochContents, MovingScene};
use super::geometry::Geometry;
use super::images;
use super::light_bvh::connected::connected;
use super::lights::Lights;
pub use super::lights::gpu_lights;
use super::materials::Materials;
use super::merge_static::{ElementCounts, merge_static};
use super::pose::ScenePoser;
use super::ray_query::RayQueryScene;
use super::shaders;
use super::sizes::{SceneSizes, check_buffer};
use super::surface_points::{SurfacePoint, surface_points};
use super::units::Units;
use crate::Result;
use crate::base::timed::timed;
use crate::gpu::{ComputePass, Device, Offers, Resource, SampledImage};
use crate::scene::Scene;
use crate::scene::motion::Pose;
use crate::scene::requirements::Requirements;
use crate::shader_interface::{Textures, Tracer, Variant};
use glam::DVec3;
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::Arc;

/// A scene on the device: its buffers, its texture images and, for ray queries, its acceleration structures. Passes bind
/// these to trace rays, to shade surfaces and to draw lights.
pub struct GpuScene {
    /// The variant in which shaders are compiled for the scene: how they trace rays, and how they read buffers and textures.
    pub variant: Variant,
    /// The origin of the device's coordinates, and the units of length and radiance in which the device stores positions and
    /// lights.
    pub units: Units,
    /// The features of shading that the scene needs, such as textures or alpha. Shaders leave out the code of other
    /// features.
    pub requirements: Requirements,
    /// The number of elements of each kind that the scene has on the device, such as triangles, materials and lights. In
    /// indices of lights of all kinds, the emissive triangles come first, so a light with an index below
    /// [`ElementCounts::triangle_lights`] is one of them.
    pub counts: ElementCounts,
    /// The size of the stack with which a compute shader traverses the tree over the instances and the trees over their
    /// meshes, in entries of two words; an entry is a group of nodes or triangles that are still to be visited. It is a
    /// multiple of 8, so that scenes with trees of similar depth share compiled shaders.
    pub stack_size: u32,
    buffers: SceneBuffers,
    /// The texture images in the order of the scene, which shaders sample; empty if shaders read texels from
    /// a buffer.
    images: Vec<SampledImage>,
    ray_query: Option<RayQueryScene>,
    moving: Option<MovingScene>,
    /// The lights at time 0, in the device's units, for which the light BVH is built.
    first_lights: Lights,
    /// For each emissive triangle, the index of the first emissive triangle of its group. A group is the triangles of an
    /// instance that are connected by common corners. The light BVH makes clusters from the groups, and `candidates=auto`
    /// counts them.
    pub light_groups: Vec<u32>,
    /// For each traced instance (after static meshes are merged), the number of triangles of its mesh.
    /// [`GpuScene::surface_points`] reads it to visit the triangles of all instances.
    triangle_counts: Vec<u32>,
}

impl Offers for GpuScene {
    /// The resources of the scene that shaders of its variant may bind, each with the name of its binding. A pass binds
    /// those that its shader uses.
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = self.buffers.resources(self.variant);
        if self.variant.textures == Textures::Images {
            resources.push(("images", Resource::Images(&self.images)));
        }
        if let Some(scene) = &self.ray_query {
            let structure = Resource::AccelerationStructure;
            resources.push(("top_level", structure(scene.top())));
            resources.push(("previous_top_level", structure(scene.previous_top())));
        }
        resources
    }
}

impl GpuScene {
    /// Merges static meshes of `scene`, computes its pose at time 0, and uploads it for shaders of `variant`. The point
    /// `origin` of the world, usually the camera's position, becomes the origin of the device's coordinates, where f32 is
    /// most precise.
    ///
    /// # Errors
    /// The scene has more triangles or lights than shaders can index, or exceeds the memory of the host or the device, or
    /// another limit of the device. At time 0, something is further from `origin` than can be rendered. Or the device was
    /// opened without a feature that `variant` uses.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        origin: DVec3,
        variant: Variant,
    ) -> Result<Self> {
        SceneSizes::of(scene).check(&device.info, variant)?;
        let trees = variant.tracer == Tracer::ComputeBvh;
        let units = Units::of(scene, origin);
        let traced = timed("merging static meshes", || merge_static(scene, origin));
        let mut geometry = timed("building trees", || Geometry::new(&traced, trees));
        let deforming = DeformingMesh::reserve(&traced, &mut geometry);
        let motion = scene.motion.as_ref().filter(|motion| motion.moves_things());
        let mut poser = ScenePoser::new(&traced, &geometry, deforming, units, trees);
        let start = motion.map_or_else(Pose::default, |motion| motion.pose(0.0));
        let pose = poser.pose_at(0.0, start, None)?;
        // One group per level, and two more where a ray enters an instance.
        let levels = |top: u32| (top + geometry.depth + 2).next_multiple_of(8);
        let mut stack_size = levels(pose.top.depth);
        let first_lights = pose.lights.clone();
        let visible = pose.visible.clone();
        let counts = ElementCounts {
            triangle_lights: pose.lights.triangles.len() as u64,
            instances: pose.instances.len() as u64,
            ..ElementCounts::of(scene)
        };
        let materials = Materials::of(&traced.scene, &units, variant.textures);
        let light_textures = match counts.textured_lights {
            true => materials.of_lights(poser.emitter_triangles()),
            false => Vec::new(),
        };
        let light_groups = connected(poser.emitter_triangles());
        let triangle_counts = traced.scene.instances.iter();
        let triangle_counts = triangle_counts
            .map(|instance| geometry.meshes[instance.mesh as usize].triangle_count)
            .collect();
        let (mut moving, mut previous_transforms) = (None, Vec::new());
        let mut epochs = match motion {
            None => EpochContents::new(&[&pose], pose.top.nodes.len()),
            Some(motion) => {
                // The tree over the instances changes with time and may grow.
                let count = pose.instances.len();
                stack_size = levels(pose.top.depth.max(balanced_depth(count)));
                poser.limit_depth(stack_size - geometry.depth - 2);
                let room = if trees { max_nodes(count) } else { 1 };
                let epochs = EpochContents::new(&[&pose, &pose], room);
                let scene =
                    MovingScene::new(motion.clone(), poser, room, scene.instances.len(), pose);
                previous_transforms = scene.previous_transforms()?;
                moving = Some(scene);
                epochs
            }
        };
        // The trees over the instances come first, then those of the meshes.
        let mesh_nodes = epochs.nodes.len() as u32;
        epochs
            .nodes
            .extend(geometry.nodes.iter().map(|node| CwBvhNode {
                child_base_idx: node.child_base_idx + mesh_nodes,
                ..*node
            }));
        let node_bytes = size_of_val(epochs.nodes.as_slice()) as u64;
        check_buffer(&device.info, variant, "nodes", node_bytes)?;
        let meshes = geometry.meshes.clone();
        let contents = SceneContents::new(
            materials,
            light_textures,
            geometry,
            epochs,
            previous_transforms,
            (scene.environment.as_ref()).map_or_else(EnvironmentTexels::default, |environment| {
                EnvironmentTexels::of(environment, &units)
            }),
        );
        let buffers = timed("uploading the scene", || {
            SceneBuffers::new(device, &contents, &counts, variant)
        })?;
        let images = match variant.textures {
            Textures::Buffer => Vec::new(),
            Textures::Images => images::upload(device, scene)?,
        };
        let ray_query = match variant.tracer {
            Tracer::RayQuery => {
                let mesh_of = traced.scene.instances.iter().map(|i| i.mesh).collect();
                let tops = if motion.is_some() { 2 } else { 1 };
                let placed = (&contents.instances[..], &visible[..]);
                let positions = &buffers.positions;
                let scene = RayQueryScene::new(device, &meshes, positions, placed, mesh_of, tops);
                Some(scene?)
            }
            Tracer::ComputeBvh => None,
        };
        Ok(Self {
            variant,
            units,
            requirements: Requirements::of(scene),
            counts,
            stack_size,
            buffers,
            images,
            ray_query,
            moving,
            first_lights,
            light_groups,
            triangle_counts,
        })
    }

    /// Updates the instances, lights and shapes of meshes on the device to their state at the time `now` and, for passes that
    /// use the previous frame, to their state at the time `before`, both in seconds. A shape that a stored copy has already is
    /// not written again. Does nothing if nothing but cameras changes with time, or if the device has both states already.
    ///
    /// # Errors
    /// At one of the times, something is further from the origin of the device's coordinates than can be rendered, or has a
    /// transform that is not finite. Or the device cannot be updated.
    pub fn set_pose(&self, now: f64, before: f64) -> Result<()> {
        let Some(moving) = &self.moving else {
            return Ok(());
        };
        let Some(change) = moving.set_times(now, before)? else {
            return Ok(());
        };
        let [now, before] = &*change.poses;
        let epochs = EpochContents::new(&[now, before], moving.room);
        for (pose, _) in change.poses.iter().zip(change.new).filter(|(_, new)| *new) {
            let buffers = ShapeBuffers {
                positions: &self.buffers.positions,
                corner_directions: &self.buffers.corner_directions,
                nodes: &self.buffers.nodes,
            };
            moving.upload_shapes(pose, buffers)?;
            if let Some(scene) = &self.ray_query {
                scene.rebuild_meshes(&self.buffers.positions, moving.new_copies(pose))?;
            }
        }
        self.buffers.instances.write(&epochs.instances)?;
        self.buffers.lights.write(&epochs.lights)?;
        self.buffers
            .punctual_lights
            .write(&epochs.punctual_lights)?;
        self.buffers.light_choices.write(&epochs.light_choices)?;
        let transforms = &self.buffers.previous_transforms;
        transforms.write(&change.previous_transforms)?;
        match &self.ray_query {
            None => {
                self.buffers.nodes.write(&epochs.nodes)?;
                self.buffers.top_instances.write(&epochs.top_instances)
            }
            Some(scene) => {
                if change.advanced {
                    scene.advance();
                }
                if change.new[1] {
                    scene.rebuild(scene.previous_top(), &before.instances, &before.visible)?;
                }
                if change.new[0] {
                    scene.rebuild(scene.top(), &now.instances, &now.visible)?;
                }
                Ok(())
            }
        }
    }

    /// The lights as they are in the current pose, and the time of this pose in seconds. Callers use them to update data
    /// that depend on lights. `known` is the time of the lights that the caller has already. The result is `None` if the
    /// pose has the same time as these, or if no instance and no light changes with time.
    ///
    /// # Errors
    /// Posing the scene failed in another thread.
    pub fn moved_lights(&self, known: f64) -> Result<Option<(Lights, f64)>> {
        match &self.moving {
            Some(moving) => moving.moved_lights(known),
            None => Ok(None),
        }
    }

    /// The lights as they are at time 0, in the device's units. The light BVH is built for them; later, only its boxes and
    /// powers change.
    pub fn first_lights(&self) -> &Lights {
        &self.first_lights
    }

    /// Draws `count` points on the surfaces in the current pose, uniformly by area, in the device's units. The light BVH
    /// chooses its scale from such points. The hash grid (reservoirs of direct light in cells of space) is filled at them
    /// with the setting `hash_grid.mode=published`. The result is empty if the surfaces have no area.
    ///
    /// # Errors
    /// The buffers cannot be read from the device.
    pub fn surface_points(&self, count: usize) -> Result<Vec<SurfacePoint>> {
        let instances = self.buffers.instances.read(self.triangle_counts.len())?;
        let positions = self
            .buffers
            .positions
            .read(self.counts.triangles as usize)?;
        Ok(surface_points(
            &instances,
            &self.triangle_counts,
            &positions,
            count,
        ))
    }

    /// True if instances or lights move, or if emission changes with time; motion of cameras does not count.
    /// The device then stores the state of the previous frame too.
    pub fn moves(&self) -> bool {
        self.moving.is_some()
    }

    /// The index, in the buffer `nodes`, of the root of the tree over the instances of the previous frame. A compute shader
    /// that traces rays through the scene of that frame starts there. It is 0, the root of the current frame's tree, if
    /// nothing moves.
    pub fn previous_root(&self) -> u32 {
        self.moving.as_ref().map_or(0, |moving| moving.room as u32)
    }

    /// Makes the pass `name`, whose shader is the file `NAME.comp`, in the scene's variant. `constants` has pairs for
    /// specialisation constants: the `constant_id` and the 32-bit value.
    ///
    /// # Errors
    /// The shader does not exist or does not compile, or its interface cannot be bound by name.
    pub fn pass(
        &self,
        device: &Arc<Device>,
        name: &str,
        constants: &[(u32, u32)],
    ) -> Result<ComputePass> {
        let spirv = shaders::spirv(name, self.variant)?;
        ComputePass::with_images(device, name, &spirv, constants, self.images.len() as u32)
    }

    /// Pairs of name and size in bytes, for reports of memory: one for each buffer, one for all images together, and one for
    /// all acceleration structures together. The last two are missing if the scene has no images or no acceleration
    /// structures on the device.
    pub fn memory(&self) -> Vec<(&str, u64)> {
        let buffers = self.buffers.named().into_iter();
        let mut memory: Vec<(&str, u64)> = buffers.map(|(name, b)| (name, b.size())).collect();
        if !self.images.is_empty() {
            memory.push(("images", self.images.iter().map(SampledImage::size).sum()));
        }
        if let Some(scene) = &self.ray_query {
            memory.push(("acceleration structures", scene.size()));
        }
        memory
    }
}
