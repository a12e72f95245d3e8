//! A scene on the device: what every shader that traces rays or reads surfaces is bound to.

use super::compute_bvh::{balanced_depth, most_nodes};
use super::epochs::{Contents, Moving};
use super::gather::gather;
use super::geometry::Geometry;
use super::ray_query::RayQueryScene;
use super::sizes::{SceneSizes, check_buffer};
pub use super::stage::gpu_lights;
use super::stage::{Stage, lamp_luminance};
use super::{Fetch, GeometryAccess, Tracer, Variant};
use crate::gpu::{Buffer, Device, Resource, Usage};
use crate::layouts::{GpuMaterial, SceneAddresses};
use crate::scene::motion::Pose;
use crate::scene::{Material, Scene};
use crate::{Error, Result};
use glam::{DVec3, UVec2, Vec3};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::Arc;

/// Specialisation constant: entries of the compute traversal's stack.
const STACK_SIZE: u32 = 0;
/// Specialisation constant: whether the last frame's instances and lights stand behind this one's.
const MOVES: u32 = 8;
/// Specialisation constant: the root of the last frame's tree over the instances.
const PREVIOUS_ROOT: u32 = 9;

/// A scene's buffers and, where rays are queries, its acceleration structures.
pub struct GpuScene {
    /// Which shaders fit it.
    pub variant: Variant,
    /// What was subtracted from every world position, so that f32 is finest around the camera.
    pub origin: DVec3,
    /// Number of lights.
    pub light_count: u32,
    /// Number of instances that are traced.
    pub instance_count: u32,
    /// Mean luminance of the lights as the scene was uploaded, weighted by their power; 0 without any.
    pub lamp_luminance: f32,
    /// Entries that the compute traversal's stack needs, rounded up so that scenes share shaders.
    stack_size: u32,
    positions: Buffer,
    normals: Buffer,
    triangle_parts: Buffer,
    nodes: Buffer,
    top_instances: Buffer,
    instances: Buffer,
    materials: Buffer,
    lights: Buffer,
    carries: Buffer,
    addresses: Option<Buffer>,
    ray_query: Option<RayQueryScene>,
    moving: Option<Moving>,
}

impl GpuScene {
    /// Uploads `scene` with `origin` (usually the camera's position) moved to zero.
    ///
    /// # Errors
    /// More triangles than 32-bit indices hold, or more memory than the device has or reads.
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        origin: DVec3,
        variant: Variant,
    ) -> Result<Self> {
        SceneSizes::of(scene).check(&device.info, variant)?;
        let trees = variant.tracer == Tracer::ComputeBvh;
        // The trees over the instances stand first, then those of the meshes.
        let gathered = gather(scene, origin);
        let geometry = Geometry::new(&gathered, trees);
        let motion = scene.motion.as_ref().filter(|motion| motion.moves_things());
        let mut stage = Stage::new(&gathered, &geometry, origin, trees);
        let pose = motion.map_or_else(Pose::default, |motion| motion.pose(0.0));
        let now = stage.standing(0.0, pose)?;
        // One group a level, and two where an instance is entered.
        let levels = |top: u32| (top + geometry.depth + 2).next_multiple_of(8);
        let mut stack_size = levels(now.top.depth);
        let lamp_luminance = lamp_luminance(&now.lights);
        let (light_count, visible) = (now.lights.len() as u32, now.visible.clone());
        let instance_count = now.instances.len() as u32;
        let (mut moving, mut carries) = (None, Vec::new());
        let contents = match motion {
            None => Contents::of(&[&now], now.top.nodes.len()),
            Some(motion) => {
                // The tree over the instances changes with time and may grow.
                let count = now.instances.len();
                stack_size = levels(now.top.depth.max(balanced_depth(count)));
                stage.limit_depth(stack_size - geometry.depth - 2);
                let room = if trees { most_nodes(count) } else { 1 };
                let contents = Contents::of(&[&now, &now], room);
                let whole = Moving::new(motion.clone(), stage, room, scene.instances.len(), now);
                carries = whole.carries()?;
                moving = Some(whole);
                contents
            }
        };
        let mesh_nodes = contents.nodes.len() as u32;
        let mut nodes = contents.nodes;
        nodes.extend(geometry.nodes.iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx + mesh_nodes,
            ..*node
        }));
        let node_bytes = size_of_val(nodes.as_slice()) as u64;
        check_buffer(&device.info, variant, "nodes", node_bytes)?;
        let materials: Vec<GpuMaterial> = scene.materials.iter().map(gpu_material).collect();
        let plain = Usage::default();
        let fetched = Usage {
            texels: variant.fetch == Fetch::Texels,
            ..plain
        };
        let input = Usage {
            acceleration_input: variant.tracer == Tracer::RayQuery,
            ..fetched
        };
        let positions = Buffer::from_slice(device, "positions", &geometry.positions, input)?;
        let ray_query = match variant.tracer {
            Tracer::RayQuery => {
                let mesh_of = gathered.scene.instances.iter().map(|i| i.mesh).collect();
                let tops = if motion.is_some() { 2 } else { 1 };
                let placed = (&contents.instances[..], &visible[..]);
                let scene =
                    RayQueryScene::new(device, &geometry, &positions, placed, mesh_of, tops);
                Some(scene?)
            }
            Tracer::ComputeBvh => None,
        };
        let mut uploaded = Self {
            variant,
            origin,
            light_count,
            instance_count,
            lamp_luminance,
            stack_size,
            positions,
            normals: Buffer::from_slice(device, "normals", &geometry.normals, plain)?,
            triangle_parts: Buffer::from_slice(device, "triangle_parts", &geometry.parts, plain)?,
            nodes: Buffer::from_slice(device, "nodes", &nodes, fetched)?,
            top_instances: Buffer::from_slice(
                device,
                "top_instances",
                &contents.top_instances,
                plain,
            )?,
            instances: Buffer::from_slice(device, "instances", &contents.instances, plain)?,
            materials: Buffer::from_slice(device, "materials", &materials, plain)?,
            lights: Buffer::from_slice(device, "lights", &contents.lights, plain)?,
            carries: Buffer::from_slice(device, "carries", &carries, plain)?,
            addresses: None,
            ray_query,
            moving,
        };
        if variant.geometry == GeometryAccess::BufferAddresses {
            let addresses = uploaded.scene_addresses()?;
            let usage = Usage {
                uniform: true,
                ..plain
            };
            let buffer = Buffer::from_slice(device, "scene_addresses", &[addresses], usage)?;
            uploaded.addresses = Some(buffer);
        }
        Ok(uploaded)
    }

    /// Lets the scene stand as it is at `now`, and for what looks back at the last frame as it was
    /// at `before`, both in seconds. Does nothing where nothing but cameras moves.
    ///
    /// # Errors
    /// At one of the times something is further away than can be rendered, or the device fails.
    pub fn stand(&self, now: f64, before: f64) -> Result<()> {
        let Some(moving) = &self.moving else {
            return Ok(());
        };
        let Some(change) = moving.stand(now, before)? else {
            return Ok(());
        };
        let [now, before] = &*change.held;
        let contents = Contents::of(&[now, before], moving.room);
        self.instances.write(&contents.instances)?;
        self.lights.write(&contents.lights)?;
        self.carries.write(&change.carries)?;
        match &self.ray_query {
            None => {
                self.nodes.write(&contents.nodes)?;
                self.top_instances.write(&contents.top_instances)
            }
            Some(scene) => {
                if change.turned {
                    scene.turn();
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

    /// The specialisation constants that tell shaders.
    pub fn constants(&self) -> [(u32, u32); 3] {
        let room = self.moving.as_ref().map_or(0, |moving| moving.room);
        [
            (STACK_SIZE, self.stack_size),
            (MOVES, self.moving.is_some().into()),
            (PREVIOUS_ROOT, room as u32),
        ]
    }

    /// What shaders may name.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let fetched = match self.variant.fetch {
            Fetch::Texels => Resource::Texels,
            Fetch::Words => Resource::Read,
        };
        let mut offered = vec![
            ("carries", Resource::Read(&self.carries)),
            ("nodes", fetched(&self.nodes)),
            ("positions", fetched(&self.positions)),
        ];
        match &self.addresses {
            Some(addresses) => offered.push(("scene_addresses", Resource::Uniform(addresses))),
            None => offered.extend([
                ("normals", Resource::Read(&self.normals)),
                ("triangle_parts", Resource::Read(&self.triangle_parts)),
                ("top_instances", Resource::Read(&self.top_instances)),
                ("instances", Resource::Read(&self.instances)),
                ("materials", Resource::Read(&self.materials)),
                ("lights", Resource::Read(&self.lights)),
            ]),
        }
        if let Some(scene) = &self.ray_query {
            let structure = Resource::AccelerationStructure;
            offered.push(("top_level", structure(scene.top())));
            offered.push(("previous_top_level", structure(scene.previous_top())));
        }
        offered
    }

    /// Bytes on the device, by buffer.
    pub fn memory(&self) -> Vec<(&str, u64)> {
        let mut memory: Vec<(&str, u64)> = [
            &self.positions,
            &self.normals,
            &self.triangle_parts,
            &self.nodes,
            &self.top_instances,
            &self.instances,
            &self.materials,
            &self.lights,
            &self.carries,
        ]
        .map(|buffer| (buffer.name(), buffer.size()))
        .to_vec();
        if let Some(scene) = &self.ray_query {
            memory.push(("acceleration structures", scene.size()));
        }
        memory
    }

    fn scene_addresses(&self) -> Result<SceneAddresses> {
        let address = |buffer: &Buffer| {
            let address = buffer.address()?;
            Ok::<_, Error>(UVec2::new(address as u32, (address >> 32) as u32))
        };
        Ok(SceneAddresses {
            normals: address(&self.normals)?,
            triangle_parts: address(&self.triangle_parts)?,
            top_instances: address(&self.top_instances)?,
            instances: address(&self.instances)?,
            nodes: address(&self.nodes)?,
            positions: address(&self.positions)?,
            materials: address(&self.materials)?,
            lights: address(&self.lights)?,
        })
    }
}

/// A material as shaders read it.
pub fn gpu_material(material: &Material) -> GpuMaterial {
    // KHR_materials_ior: an index of 0 stands for a reflectance of 1 at every angle.
    let normal_reflectance = if material.ior == 0.0 {
        1.0
    } else {
        ((material.ior - 1.0) / (material.ior + 1.0)).powi(2)
    };
    let f0 = (normal_reflectance * material.specular_color).min(Vec3::ONE) * material.specular;
    GpuMaterial {
        base_color: material.base_color,
        metallic: material.metallic,
        dielectric_f0: f0,
        dielectric_f90: material.specular,
        roughness: material.roughness,
    }
}
