//! The buffers of a scene on the device. Each is declared here once: the declaration generates its GLSL access and its entry in
//! the address table, and in `device_scene/buffers.rs` its contents, its binding and its size.

use crate::declare::{GpuStruct, Member, StructLayout};
use crate::{
    GpuInstance, GpuLight, GpuLightChoice, GpuLightEntry, GpuLightNode, GpuLightTexture,
    GpuMaterial, GpuPreviousTransform, GpuPunctualLight, GpuTexture,
};
use glam::{UVec2, Vec2};

/// A buffer of the scene, and the access of shaders to it.
pub struct Access {
    /// The name in GLSL, of the binding and of the entry in [`SceneTable`].
    pub name: &'static str,
    /// The access to elements.
    pub elements: Elements,
}

/// The access of shaders to the elements of a buffer.
pub enum Elements {
    /// Single elements of this GLSL type.
    Plain(&'static str),
    /// Four words at once: `NAME_words(index)` gives the words 4 · `index` to 4 · `index` + 3. Shader variants with
    /// [`Fetch::Texels`](crate::Fetch) read them as texels.
    Words,
    /// Like `Words`, assembled into structures of a multiple of four words: `load_NAME(index)`.
    Records(StructLayout),
}

/// Passes the declarations of all buffers to a macro. Each has a name, the Rust type of an element, the access of shaders to
/// elements ([`Elements`]), and the number of elements as a function of the scene's numbers of elements.
#[macro_export]
macro_rules! scene_buffers {
    ($($declare:tt)+) => {
        $($declare)+! {
            /// Three packed octahedral words per triangle: the corner normals of smooth meshes, and the corner tangents of
            /// meshes with normal maps.
            corner_directions: [UVec3] as Plain("uvec3"); |c| c.smooth_triangles + c.tangent_triangles;
            /// Texture coordinates of corners, three per triangle of a mesh with textures: of the first set, then of the
            /// second.
            uvs: [[Vec2; 3]] as Plain("vec2"); |c| c.uv_triangles;
            /// Vertex colours of corners, three per triangle of a mesh with colours: red, green, blue and alpha in 16 bits
            /// each.
            colors: [[UVec2; 3]] as Plain("uvec2"); |c| c.color_triangles;
            /// Three words per triangle of a mesh of several parts: material, rank among the mesh's emissive triangles or NONE,
            /// and the offset that its part adds to the instance's index.
            triangle_parts: [UVec3] as Plain("uvec3"); |c| c.part_triangles;
            /// Instances in the order of the leaves of the trees over them, for each epoch.
            top_instances: [u32] as Plain("uint"); |c| c.epochs * c.instances;
            /// Instances, for each epoch.
            instances: [GpuInstance] as Records(GpuInstance); |c| c.epochs * c.instances;
            /// Nodes of the trees over the instances, for each epoch, then those of the meshes: twenty words each.
            nodes: [CwBvhNode] as Words; |_| 0;
            /// Object-space positions of corners, three per triangle.
            positions: [[Vec3; 3]] as Words; |c| c.triangles;
            /// Materials.
            materials: [GpuMaterial] as Records(GpuMaterial); |c| c.materials;
            /// Textures of materials.
            textures: [GpuTexture] as Records(GpuTexture); |c| c.textures;
            /// The bits of the linear value of each sRGB byte, if there are textures, and then the texels of their images: red,
            /// green, blue and alpha, from the lowest byte. In one buffer, since some drivers bind 30 at most.
            texels: [u32] as Plain("uint"); |c| c.texels + if c.textures > 0 { 256 } else { 0 };
            /// Emissive triangles, for each epoch.
            lights: [GpuLight] as Records(GpuLight); |c| c.epochs * c.triangle_lights;
            /// Textures of emissive triangles, one per triangle if some of them have a texture.
            light_textures: [GpuLightTexture] as Records(GpuLightTexture); |c| if c.textured_lights { c.triangle_lights } else { 0 };
            /// Punctual lights, for each epoch.
            punctual_lights: [GpuPunctualLight] as Records(GpuPunctualLight); |c| c.epochs * c.punctual_lights;
            /// Texels of the environment, by rows: radiance, and the density over longitude and latitude with which they are
            /// drawn.
            environment: [Vec4] as Words; |c| c.environment_texels;
            /// The alias table that draws texels of the environment: a texel is kept if 32 random bits are below the first
            /// number; otherwise the second one is drawn.
            environment_columns: [UVec2] as Plain("uvec2"); |c| c.environment_texels;
            /// The alias table over the lights of all kinds: triangles, punctual lights, the environment. If some lights are
            /// rare, two more tables follow: of the lights that are not rare, and of the rare lights.
            light_choices: [GpuLightChoice] as Records(GpuLightChoice); |c| 3 * c.lights();
            /// The previous transform of each of the scene's instances; empty if nothing moves.
            previous_transforms: [GpuPreviousTransform] as Records(GpuPreviousTransform); |c| c.previous_transforms;
        }
    };
}

macro_rules! declare_access {
    ($(
        $(#[$meta:meta])*
        $name:ident: [$element:ty] as $elements:ident $(($argument:tt))?; $count:expr;
    )*) => {
        crate::gpu_struct! {
            /// The table of the scene's buffers: counts of elements and addresses.
            pub struct SceneTable {
                /// Number of lights of all kinds: triangles, punctual lights, and 1 for an environment.
                pub light_count: u32,
                /// Number of emissive triangles.
                pub triangle_light_count: u32,
                /// Number of punctual lights.
                pub punctual_light_count: u32,
                /// Width and height of the environment in texels.
                pub environment_size: UVec2,
                /// Cosine and sine of the environment's rotation around the upward axis.
                pub environment_turn: Vec2,
                /// Number of instances that are traced.
                pub instance_count: u32,
                /// 1 if some light has a texture, otherwise 0.
                pub textured_lights: u32,
                $($(#[$meta])* pub $name: UVec2,)*
            }
        }

        /// Every buffer.
        pub const BUFFERS: &[Access] = &[$(Access {
            name: stringify!($name),
            elements: declare_access!(@elements $elements $(($argument))?),
        },)*];
    };
    (@elements Plain($glsl:literal)) => { Elements::Plain($glsl) };
    (@elements Words) => { Elements::Words };
    (@elements Records($record:ident)) => { Elements::Records($record::LAYOUT) };
}
scene_buffers!(declare_access);

impl Elements {
    /// True if four words are read at once: as texels in shader variants with texels.
    pub fn are_words(&self) -> bool {
        !matches!(self, Self::Plain(_))
    }
}

/// The name of the buffer of a light BVH: its nodes, then its entries. It is bound by a descriptor only, since each renderer
/// has a separate one.
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

/// `load_NAME(index)`, from a buffer that is read by four words. Compilers do not load unused parts of the structure.
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
