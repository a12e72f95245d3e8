//! The buffers of a scene on the device, from which shaders read its geometry, materials and lights: their contents,
//! sizes in bytes and bindings. `shader_interface/scene_buffers.rs` declares each buffer; `SceneContents::new` collects
//! the contents.

use super::environment::EnvironmentTexels;
use super::epochs::EpochContents;
use super::geometry::Geometry;
use super::materials::Materials;
use super::merge_static::ElementCounts;
use crate::Result;
use crate::gpu::{Buffer, Device, Resource, Usage};
use crate::shader_interface::{
    BUFFERS, Fetch, GeometryAccess, GpuInstance, GpuLight, GpuLightChoice, GpuLightTexture,
    GpuMaterial, GpuPreviousTransform, GpuPunctualLight, GpuTexture, LIGHT_BVH, SceneTable, Tracer,
    Variant,
};
use glam::{UVec2, UVec3, Vec2, Vec3, Vec4};
use obvhs::cwbvh::node::CwBvhNode;
use std::sync::Arc;

macro_rules! declare_contents {
    ($(
        $(#[$meta:meta])*
        $name:ident: [$element:ty] as $elements:ident $(($argument:tt))?; $count:expr;
    )*) => {
        /// The elements of every buffer of a scene, in host memory. The buffers are first filled with them.
        /// When the time of a moving scene changes, the buffers that depend on time are written again. An
        /// empty `Vec` means that the scene has no elements of this kind.
        pub struct SceneContents {
            $($(#[$meta])* pub $name: Vec<$element>,)*
            /// Width and height of the environment in texels, with which shaders find the texel for a direction; zero for a
            /// scene without an environment.
            pub environment_size: UVec2,
            /// Cosine and sine of the environment's rotation around the upward axis (+Y). Shaders turn a direction in world
            /// space by the opposite angle before they read the environment. Zero for a scene without an environment.
            pub environment_turn: Vec2,
        }

        /// Upper bounds, in bytes, of the sizes of the scene's buffers. They are computed before the bounding
        /// volume hierarchies (trees) are built. With them, the program chooses how shaders access the scene,
        /// and refuses a scene that is too large for the device. `nodes` is 0, because its size is known only
        /// after the trees are built. The choice depends only on the largest buffer, and the nodes take less
        /// memory than the positions, except for meshes of very few triangles.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct BufferBytes { $($(#[$meta])* pub $name: u64,)* }

        impl BufferBytes {
            /// Computes the upper bounds of the buffers' sizes in bytes for a scene with `counts` elements (numbers of
            /// triangles, lights and so on).
            pub fn of(counts: &ElementCounts) -> Self {
                Self { $($name: {
                    let count: fn(&ElementCounts) -> u64 = $count;
                    count(counts) * size_of::<$element>() as u64
                },)* }
            }

            /// The name of every buffer and the upper bound of its size in bytes, in the order of
            /// [`BUFFERS`]. The sizes are compared with the limits of the device.
            pub fn named(&self) -> Vec<(&'static str, u64)> {
                vec![$((stringify!($name), self.$name),)*]
            }
        }

        /// All buffers of a scene on the device, from which every pass reads the scene, and the uniform buffer that gives
        /// shaders the numbers of elements and, in some variants, the addresses of the buffers.
        pub struct SceneBuffers {
            $($(#[$meta])* pub $name: Buffer,)*
            /// The uniform buffer with one [`SceneTable`]: the numbers of elements, the size and rotation of the environment
            /// and, with [`GeometryAccess::BufferAddresses`], the address of each buffer.
            table: Buffer,
        }

        impl SceneBuffers {
            /// Creates the buffers and uploads `contents` into them. `counts` are the numbers of elements;
            /// the uniform buffer with the [`SceneTable`] gives some of them to shaders. `variant` is the
            /// variant of the shaders that will read the buffers; it decides with which Vulkan usages they
            /// are created.
            ///
            /// # Errors
            /// A buffer exceeds a limit of the device or its free memory, or `variant` uses buffer addresses on a device
            /// that was opened without them.
            pub fn new(
                device: &Arc<Device>,
                contents: &SceneContents,
                counts: &ElementCounts,
                variant: Variant,
            ) -> Result<Self> {
                $(let $name = Buffer::from_slice(
                    device,
                    stringify!($name),
                    &contents.$name,
                    usage(stringify!($name), variant),
                )?;)*
                let addressed = variant.geometry == GeometryAccess::BufferAddresses;
                let table = SceneTable {
                    light_count: counts.lights() as u32,
                    triangle_light_count: counts.triangle_lights as u32,
                    punctual_light_count: counts.punctual_lights as u32,
                    environment_size: contents.environment_size,
                    environment_turn: contents.environment_turn,
                    instance_count: counts.instances as u32,
                    material_count: counts.materials as u32,
                    textured_lights: counts.textured_lights.into(),
                    $($name: if addressed { $name.address_words()? } else { UVec2::ZERO },)*
                };
                let uniform = Usage { uniform: true, ..Usage::default() };
                let table = Buffer::from_slice(device, "scene", &[table], uniform)?;
                Ok(Self { $($name,)* table })
            }

            /// The name and the buffer of every array of the scene, in the order of [`BUFFERS`], for bindings
            /// and reports of memory. The uniform buffer with the [`SceneTable`] is not included.
            pub fn named(&self) -> Vec<(&'static str, &Buffer)> {
                vec![$((stringify!($name), &self.$name),)*]
            }
        }
    };
}
crate::shader_interface::scene_buffers!(declare_contents);

impl SceneContents {
    /// Collects the initial contents of all buffers of a scene. `epochs.nodes` must already hold the nodes of all trees:
    /// first those of the trees over the instances, then those of the meshes' trees, which the caller must have appended.
    pub(super) fn new(
        materials: Materials,
        light_textures: Vec<GpuLightTexture>,
        geometry: Geometry,
        epochs: EpochContents,
        previous_transforms: Vec<GpuPreviousTransform>,
        environment: EnvironmentTexels,
    ) -> Self {
        Self {
            corner_directions: geometry.corner_directions,
            uvs: geometry.uvs,
            colors: geometry.colors,
            triangle_parts: geometry.parts,
            top_instances: epochs.top_instances,
            instances: epochs.instances,
            nodes: epochs.nodes,
            positions: geometry.positions,
            materials: materials.materials,
            textures: materials.textures,
            texels: materials.texels,
            lights: epochs.lights,
            light_textures,
            punctual_lights: epochs.punctual_lights,
            environment: environment.texels,
            environment_columns: environment.columns,
            light_choices: epochs.light_choices,
            previous_transforms,
            environment_size: environment.size,
            environment_turn: environment.turn,
        }
    }
}

impl SceneBuffers {
    /// The name and the resource of each binding through which shaders of `variant` (tracer and access to memory) read the
    /// scene: the uniform buffer with the [`SceneTable`], buffers that are read as texels, and storage buffers. Buffers that
    /// shaders read by address have no binding; the table contains their addresses.
    pub fn resources(&self, variant: Variant) -> Vec<(&'static str, Resource<'_>)> {
        let mut resources = vec![("scene", Resource::Uniform(&self.table))];
        for ((name, buffer), access) in self.named().into_iter().zip(BUFFERS) {
            if access.elements.are_words() && variant.fetch == Fetch::Texels {
                resources.push((name, Resource::Texels(buffer)));
            } else if variant.geometry == GeometryAccess::StorageBuffers {
                resources.push((name, Resource::Read(buffer)));
            }
        }
        resources
    }
}

/// True if shaders read the buffer with this name in groups of four 32-bit words; false for other buffers and unknown names.
/// In shader variants with [`Fetch::Texels`], such a buffer is bound as a texel buffer, so that its size must be within the
/// device's limit for texel buffers. In other variants, it is read like the other buffers.
pub fn is_fetched(name: &str) -> bool {
    name == LIGHT_BVH
        || BUFFERS
            .iter()
            .any(|b| b.name == name && b.elements.are_words())
}

/// The Vulkan usages with which the buffer `name` is created, so that shaders of `variant` (tracer and access to memory)
/// can read it. Every buffer is a storage buffer. If the variant reads this buffer as texels, it is also a texel buffer.
/// With ray queries, `positions` is also an input from which the driver builds acceleration structures.
pub fn usage(name: &str, variant: Variant) -> Usage {
    Usage {
        texels: is_fetched(name) && variant.fetch == Fetch::Texels,
        acceleration_input: name == "positions" && variant.tracer == Tracer::RayQuery,
        ..Usage::default()
    }
}
