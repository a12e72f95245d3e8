//! The buffers of a scene on the device. Each is declared here once: the declaration generates its GLSL
//! access, its entry in the address table, its binding and its size. `SceneContents::new` fills it.
//!
//! The build script compiles this file too, for the GLSL text; what is marked `cfg(headwater)` is for the
//! crate alone.

use crate::gpu::layout::{GpuStruct, Member, StructLayout};
use crate::layouts::{
    GpuInstance, GpuLight, GpuLightChoice, GpuLightEntry, GpuLightNode, GpuLightTexture,
    GpuMaterial, GpuPreviousTransform, GpuPunctualLight, GpuTexture,
};
use glam::{UVec2, Vec2};

/// How shaders access one of the buffers.
pub struct Access {
    /// The name in GLSL, of the binding and of the entry in [`SceneTable`].
    pub name: &'static str,
    /// How elements are read.
    pub elements: Elements,
}

/// How the elements of a buffer are read.
pub enum Elements {
    /// Each by itself, as this GLSL type.
    Plain(&'static str),
    /// Four words at once: `NAME_words(index)` gives the words 4 · `index` to 4 · `index` + 3. Shader variants with
    /// [`Fetch::Texels`](crate::shader_variants::Fetch) read them as texels.
    Words,
    /// The same, put together to structures of a multiple of four words: `load_NAME(index)`.
    Records(StructLayout),
}

macro_rules! scene_buffers {
    ($(
        $(#[$meta:meta])*
        $name:ident: [$element:ty] as $elements:expr; $count:expr;
    )*) => {
        crate::gpu_struct! {
            /// What shaders know of the scene's buffers.
            pub struct SceneTable {
                /// Number of lights of all kinds: triangles, punctual lights, and 1 for an environment.
                pub light_count: u32,
                /// Number of emissive triangles.
                pub triangle_light_count: u32,
                /// Number of punctual lights.
                pub punctual_light_count: u32,
                /// Width and height of the environment in texels.
                pub environment_size: UVec2,
                /// Cosine and sine of the angle by which it is turned around the upward axis.
                pub environment_turn: Vec2,
                /// Number of instances that are traced.
                pub instance_count: u32,
                /// Whether some light has a texture (0 or 1).
                pub textured_lights: u32,
                $($(#[$meta])* pub $name: UVec2,)*
            }
        }

        /// Every buffer.
        pub const BUFFERS: &[Access] = &[$(Access {
            name: stringify!($name),
            elements: $elements,
        },)*];

        /// What the buffers hold.
        #[cfg(headwater)]
        pub struct SceneContents {
            $($(#[$meta])* pub $name: Vec<$element>,)*
            /// Width and height of the environment in texels.
            pub environment_size: UVec2,
            /// Cosine and sine of the angle by which it is turned around the upward axis.
            pub environment_turn: Vec2,
        }

        /// Bytes of each buffer, known before any tree is built. Only the nodes are missing, whose number
        /// the trees decide; for all but the smallest meshes they take fewer bytes than the positions.
        #[cfg(headwater)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct BufferBytes { $($(#[$meta])* pub $name: u64,)* }

        #[cfg(headwater)]
        impl BufferBytes {
            /// The bytes for these numbers of elements.
            pub fn of(counts: &ElementCounts) -> Self {
                Self { $($name: {
                    let count: fn(&ElementCounts) -> u64 = $count;
                    count(counts) * size_of::<$element>() as u64
                },)* }
            }

            /// Name and bytes of every buffer.
            pub fn named(&self) -> Vec<(&'static str, u64)> {
                vec![$((stringify!($name), self.$name),)*]
            }
        }

        /// The buffers on the device.
        #[cfg(headwater)]
        pub struct SceneBuffers {
            $($(#[$meta])* pub $name: Buffer,)*
            /// The [`SceneTable`].
            table: Buffer,
        }

        #[cfg(headwater)]
        impl SceneBuffers {
            /// Uploads the contents for shaders of a variant.
            ///
            /// # Errors
            /// More memory than the device has.
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
                    textured_lights: counts.textured_lights.into(),
                    $($name: if addressed { $name.address_words()? } else { UVec2::ZERO },)*
                };
                let uniform = Usage { uniform: true, ..Usage::default() };
                let table = Buffer::from_slice(device, "scene", &[table], uniform)?;
                Ok(Self { $($name,)* table })
            }

            /// Name and buffer, without the table.
            pub fn named(&self) -> Vec<(&'static str, &Buffer)> {
                vec![$((stringify!($name), &self.$name),)*]
            }
        }
    };
}

scene_buffers! {
    /// Three packed octahedral words a triangle: the corner normals of smooth meshes, and the corner tangents of meshes with normal
    /// maps.
    corner_directions: [UVec3] as Elements::Plain("uvec3"); |c| c.smooth_triangles + c.tangent_triangles;
    /// Texture coordinates of corners, three a triangle of a mesh with textures: of the first set, then of the second.
    uvs: [[Vec2; 3]] as Elements::Plain("vec2"); |c| c.uv_triangles;
    /// Vertex colours of corners, three a triangle of a mesh with colours: red, green, blue and alpha in 16 bits each.
    colors: [[UVec2; 3]] as Elements::Plain("uvec2"); |c| c.color_triangles;
    /// Three words a triangle of a mesh of several parts: material, rank among the mesh's emissive triangles
    /// or NONE, and what its part adds to the instance's index.
    triangle_parts: [UVec3] as Elements::Plain("uvec3"); |c| c.part_triangles;
    /// Instances in the order of the leaves of the trees over them, for each epoch.
    top_instances: [u32] as Elements::Plain("uint"); |c| c.epochs * c.instances;
    /// Instances, for each epoch.
    instances: [GpuInstance] as Elements::Records(GpuInstance::LAYOUT); |c| c.epochs * c.instances;
    /// Nodes of the trees over the instances, for each epoch, then those of the meshes: five times four words
    /// each.
    nodes: [CwBvhNode] as Elements::Words; |_| 0;
    /// Object-space positions of corners, three a triangle.
    positions: [[Vec3; 3]] as Elements::Words; |c| c.triangles;
    /// Materials.
    materials: [GpuMaterial] as Elements::Records(GpuMaterial::LAYOUT); |c| c.materials;
    /// Textures of materials.
    textures: [GpuTexture] as Elements::Records(GpuTexture::LAYOUT); |c| c.textures;
    /// The bits of the linear value of each sRGB byte, if there are textures, and then the texels of their images: red, green, blue
    /// and alpha, from the lowest byte. In one buffer, since some drivers bind 30 at most.
    texels: [u32] as Elements::Plain("uint"); |c| c.texels + if c.textures > 0 { 256 } else { 0 };
    /// Emissive triangles, for each epoch.
    lights: [GpuLight] as Elements::Records(GpuLight::LAYOUT); |c| c.epochs * c.triangle_lights;
    /// Textures of emissive triangles, one a triangle if some of them has any.
    light_textures: [GpuLightTexture] as Elements::Records(GpuLightTexture::LAYOUT); |c| if c.textured_lights { c.triangle_lights } else { 0 };
    /// Punctual lights, for each epoch.
    punctual_lights: [GpuPunctualLight] as Elements::Records(GpuPunctualLight::LAYOUT); |c| c.epochs * c.punctual_lights;
    /// Texels of the environment, by rows: radiance, and the density over longitude and latitude with which they are drawn.
    environment: [Vec4] as Elements::Words; |c| c.environment_texels;
    /// The alias table that draws them: a texel is kept if 32 random bits are below the first number, else the second is taken.
    environment_columns: [UVec2] as Elements::Plain("uvec2"); |c| c.environment_texels;
    /// The alias table over the lights of all kinds: triangles, punctual lights, the environment. Where some are rare, two more
    /// follow: of those that are not, and of those that are.
    light_choices: [GpuLightChoice] as Elements::Records(GpuLightChoice::LAYOUT); |c| 3 * c.lights();
    /// Where each of the scene's instances was in the previous frame; empty where nothing moves.
    previous_transforms: [GpuPreviousTransform] as Elements::Records(GpuPreviousTransform::LAYOUT); |c| c.previous_transforms;
}

impl Elements {
    /// Whether four words at once are read, in shader variants with texels as texels.
    pub fn are_words(&self) -> bool {
        !matches!(self, Self::Plain(_))
    }
}

/// The buffer of a light BVH: its nodes, then its entries. It is bound by a descriptor only, since each renderer has its own.
pub const LIGHT_BVH: &str = "light_bvh";

/// The text of `light_bvh_buffer.glsl`.
pub fn light_bvh_glsl() -> String {
    [
        String::from("#pragma once\n#include \"prelude.glsl\"\n"),
        words(LIGHT_BVH, &binding(LIGHT_BVH, "uvec4")),
        load("light_node", LIGHT_BVH, &GpuLightNode::LAYOUT),
        load("light_entry", LIGHT_BVH, &GpuLightEntry::LAYOUT),
    ]
    .concat()
}

/// The text of `scene_buffers.glsl`: the table, and access to the elements of every buffer.
pub fn glsl() -> String {
    let mut text = String::from(
        "#pragma once\n#include \"prelude.glsl\"\nlayout(scalar) uniform SceneBlock { SceneTable at; } scene;\n",
    );
    for Access { name, elements } in BUFFERS {
        text += &match elements {
            Elements::Plain(glsl) => array(name, glsl),
            Elements::Words => words(name, &array(name, "uvec4")),
            Elements::Records(layout) => {
                words(name, &array(name, "uvec4")) + &load(name, name, layout)
            }
        };
    }
    text
}

/// `NAME.at[index]`, through a descriptor or by address.
fn array(name: &str, glsl: &str) -> String {
    let block: String = name.split('_').map(capitalised).collect();
    // Drivers may load four words at once if their alignment is known.
    let align = if glsl == "uvec4" { 16 } else { 4 };
    format!(
        "#if GEOMETRY_ADDRESSES\n\
         layout(buffer_reference, scalar, buffer_reference_align = {align}) readonly buffer {block}Block {{ {glsl} at[]; }};\n\
         #define {name} {block}Block(scene.at.{name})\n\
         #else\n{}\
         #endif\n",
        binding(name, glsl)
    )
}

/// `NAME.at[index]` through a descriptor.
fn binding(name: &str, glsl: &str) -> String {
    let block: String = name.split('_').map(capitalised).collect();
    format!("layout(scalar) readonly buffer {block}Block {{ {glsl} at[]; }} {name};\n")
}

/// `NAME_words(index)`. llvmpipe fetches the four words of a texel at once for each lane, but reads a buffer word by
/// word, each word behind a branch. `array` declares the buffer.
fn words(name: &str, array: &str) -> String {
    format!(
        "#if FETCH_TEXELS\n\
         uniform utextureBuffer {name};\n\
         uvec4 {name}_words(uint index) {{ return texelFetch({name}, int(index)); }}\n\
         #else\n{array}\
         uvec4 {name}_words(uint index) {{ return {name}.at[index]; }}\n\
         #endif\n"
    )
}

/// `load_NAME(index)`, from a buffer that is read by four words. What of the structure is not used, compilers do not load.
fn load(name: &str, buffer: &str, layout: &StructLayout) -> String {
    let StructLayout {
        name: record,
        size,
        members,
    } = layout;
    let quads = size / 16;
    assert_eq!(size % 16, 0, "{record} must be a multiple of four words");
    let read: Vec<String> = (0..quads)
        .map(|quad| format!("q[{quad}] = {buffer}_words({quads}u * index + {quad}u);"))
        .collect();
    let values: Vec<String> = members.iter().map(value).collect();
    format!(
        "{record} load_{name}(uint index) {{\n    uvec4 q[{quads}];\n    {}\n    return {record}({});\n}}\n",
        read.join(" "),
        values.join(", ")
    )
}

/// A member's value from the words `q` of its structure.
fn value(member: &Member) -> String {
    let (kind, components) = match member.glsl {
        "float" => ("float", 1),
        "vec2" => ("vec2", 2),
        "vec3" => ("vec3", 3),
        "uint" => ("uint", 1),
        "uvec2" => ("uvec2", 2),
        "uvec3" => ("uvec3", 3),
        other => panic!("a record has a member of type {other}"),
    };
    let first = member.offset / 4;
    let one = |element: usize| {
        let words: Vec<String> = (0..components)
            .map(|component| {
                let word = first + element * components + component;
                let word = format!("q[{}][{}]", word / 4, word % 4);
                if kind.starts_with('u') {
                    word
                } else {
                    format!("uintBitsToFloat({word})")
                }
            })
            .collect();
        format!("{kind}({})", words.join(", "))
    };
    match member.length {
        0 => one(0),
        length => {
            let elements: Vec<String> = (0..length).map(one).collect();
            format!("{kind}[]({})", elements.join(", "))
        }
    }
}

fn capitalised(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_ascii_uppercase() + rest
}

#[cfg(headwater)]
use {
    super::environment::EnvironmentTexels,
    super::epochs::EpochContents,
    super::gather::ElementCounts,
    super::geometry::Geometry,
    super::materials::Materials,
    super::{Fetch, GeometryAccess, Tracer, Variant},
    crate::Result,
    crate::gpu::{Buffer, Device, Resource, Usage},
    glam::{UVec3, Vec3, Vec4},
    obvhs::cwbvh::node::CwBvhNode,
    std::sync::Arc,
};

#[cfg(headwater)]
impl SceneContents {
    /// What a scene's buffers hold at first. The nodes of `epochs` include those of the meshes.
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

#[cfg(headwater)]
impl SceneBuffers {
    /// What shaders of a variant bind.
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

/// Whether [`Fetch`] decides how a buffer is read.
#[cfg(headwater)]
pub fn is_fetched(name: &str) -> bool {
    name == LIGHT_BVH
        || BUFFERS
            .iter()
            .any(|b| b.name == name && b.elements.are_words())
}

/// How a buffer is used by shaders of a variant.
#[cfg(headwater)]
pub fn usage(name: &str, variant: Variant) -> Usage {
    Usage {
        texels: is_fetched(name) && variant.fetch == Fetch::Texels,
        acceleration_input: name == "positions" && variant.tracer == Tracer::RayQuery,
        ..Usage::default()
    }
}
