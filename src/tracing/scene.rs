//! A scene on the device: what every shader that traces rays or reads surfaces is bound to.

use super::compute_bvh::Tree;
use super::gather::gather;
use super::geometry::{Geometry, MeshPlace};
use super::ray_query::RayQueryScene;
use super::sizes::{SceneSizes, check_buffer};
use super::{Fetch, GeometryAccess, Tracer, Variant};
use crate::gpu::{Buffer, Device, Resource, Usage};
use crate::layouts::{GpuInstance, GpuLight, GpuMaterial, NONE, SceneAddresses};
use crate::scene::lights::{self, AliasTable, UNIFORM_SHARE};
use crate::scene::{Material, Scene};
use crate::{Error, Result};
use glam::{DAffine3, DVec3, UVec2, Vec3};
use std::sync::Arc;

/// A scene's buffers and, where rays are queries, its acceleration structures.
pub struct GpuScene {
    /// Which shaders fit it.
    pub variant: Variant,
    /// What was subtracted from every world position, so that f32 is finest around the camera.
    pub origin: DVec3,
    /// Number of lights.
    pub light_count: u32,
    /// Entries that the compute traversal's stack needs, rounded up so that scenes share shaders.
    pub stack_size: u32,
    positions: Buffer,
    normals: Buffer,
    triangle_parts: Buffer,
    nodes: Buffer,
    top_instances: Buffer,
    instances: Buffer,
    materials: Buffer,
    lights: Buffer,
    addresses: Option<Buffer>,
    ray_query: Option<RayQueryScene>,
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
        // The tree over the instances stands first; its size is known once it is built.
        let gathered = gather(scene, origin);
        let mut geometry = Geometry::new(&gathered, trees);
        let scene = &gathered.scene;
        let (instances, mut light_count) = (Vec::with_capacity(scene.instances.len()), 0);
        let mut instances = instances;
        let mut boxes = Vec::with_capacity(scene.instances.len());
        for (number, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh as usize];
            let place = &geometry.meshes[instance.mesh as usize];
            let object_to_world = DAffine3::from_translation(-origin)
                * instance.object_to_world
                * DAffine3::from_translation(place.centre);
            instances.push(GpuInstance {
                object_to_world: columns(object_to_world),
                world_to_object: columns(object_to_world.inverse()),
                first_triangle: place.first_triangle,
                first_normal: place.first_normal,
                first_part: place.first_part,
                root_node: place.root_node,
                material: mesh.parts.first().map_or(0, |p| p.material),
                first_light: if place.lights > 0 { light_count } else { NONE },
                id: gathered.instance_ids[number],
            });
            light_count += place.lights;
            boxes.push(world_box(&object_to_world, place));
        }
        let top = Tree::over_boxes(if trees { &boxes } else { &[] });
        let top_nodes = top.nodes.len() as u32;
        for instance in &mut instances {
            instance.root_node += top_nodes;
        }
        for node in &mut geometry.nodes {
            node.child_base_idx += top_nodes;
        }
        let mut nodes: Vec<_> = top.placed(0, 0).collect();
        nodes.append(&mut geometry.nodes);
        let node_bytes = size_of_val(nodes.as_slice()) as u64;
        check_buffer(&device.info, variant, "nodes", node_bytes)?;
        // One group a level, and two where an instance is entered.
        let stack_size = (top.depth + geometry.depth + 2).next_multiple_of(8);

        let lights = gpu_lights(scene, origin);
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
                let mesh_of: Vec<u32> = scene.instances.iter().map(|i| i.mesh).collect();
                Some(RayQueryScene::new(
                    device, &geometry, &positions, &instances, &mesh_of,
                )?)
            }
            Tracer::ComputeBvh => None,
        };
        let mut uploaded = Self {
            variant,
            origin,
            light_count: lights.len() as u32,
            stack_size,
            positions,
            normals: Buffer::from_slice(device, "normals", &geometry.normals, plain)?,
            triangle_parts: Buffer::from_slice(device, "triangle_parts", &geometry.parts, plain)?,
            nodes: Buffer::from_slice(device, "nodes", &nodes, fetched)?,
            top_instances: Buffer::from_slice(device, "top_instances", &top.order, plain)?,
            instances: Buffer::from_slice(device, "instances", &instances, plain)?,
            materials: Buffer::from_slice(device, "materials", &materials, plain)?,
            lights: Buffer::from_slice(device, "lights", &lights, plain)?,
            addresses: None,
            ray_query,
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

    /// What shaders may name.
    pub fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        let fetched = match self.variant.fetch {
            Fetch::Texels => Resource::Texels,
            Fetch::Words => Resource::Read,
        };
        let mut offered = vec![
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
            offered.push(("top_level", Resource::AccelerationStructure(&scene.top)));
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

fn columns(transform: DAffine3) -> [Vec3; 4] {
    [
        transform.matrix3.x_axis,
        transform.matrix3.y_axis,
        transform.matrix3.z_axis,
        transform.translation,
    ]
    .map(|column| column.as_vec3())
}

/// The box of a placed mesh, grown by what rounding a ray into object space can move it.
fn world_box(object_to_world: &DAffine3, place: &MeshPlace) -> (Vec3, Vec3) {
    let (low, high) = (place.bounds.0.as_dvec3(), place.bounds.1.as_dvec3());
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

/// The lights of a scene with `origin` moved to zero, as shaders pick them.
pub fn gpu_lights(scene: &Scene, origin: DVec3) -> Vec<GpuLight> {
    let triangles = lights::light_triangles(scene);
    let weights: Vec<f64> = triangles
        .iter()
        .map(|light| lights::power(light, &scene.materials[light.material as usize]))
        .collect();
    let table = AliasTable::new(&weights, UNIFORM_SHARE);
    triangles
        .iter()
        .enumerate()
        .map(|(number, light)| {
            let material = &scene.materials[light.material as usize];
            let [a, b, c] = light.corners;
            GpuLight {
                corner: (a - origin).as_vec3(),
                edge1: (b - a).as_vec3(),
                edge2: (c - a).as_vec3(),
                normal: light.normal.as_vec3(),
                emission: material.emission,
                area: light.area as f32,
                probability: table.probabilities[number] as f32,
                double_sided: material.double_sided.into(),
                keep_below: table.columns[number].keep_below,
                alias: table.columns[number].alias,
            }
        })
        .collect()
}
