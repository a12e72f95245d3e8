//! The buffers of a scene on the device. Each is declared here once. The declaration generates its GLSL access and its entry
//! in the address table, and in `device_scene/buffers.rs` its contents, its binding and its size.

use crate::declare::{GpuStruct, Member, StructLayout};
use crate::{
    GpuInstance, GpuLight, GpuLightChoice, GpuLightEntry, GpuLightNode, GpuLightTexture,
    GpuMaterial, GpuPreviousTransform, GpuPunctualLight, GpuTexture,
};
use glam::{UVec2, Vec2};

/// The declaration of one buffer of the scene, from which its GLSL text is generated.
pub struct Access {
    /// The name of the buffer in GLSL, of its binding, and of its entry in [`SceneTable`].
    pub name: &'static str,
    /// The way in which shaders read elements of the buffer.
    pub elements: Elements,
}

/// The way in which shaders read elements of a buffer.
pub enum Elements {
    /// Single elements of this GLSL type, as `NAME.at[index]`.
    Plain(&'static str),
    /// Four words at once: `NAME_words(index)` gives the words 4 · `index` to 4 · `index` + 3. Shader variants with
    /// [`Fetch::Texels`](crate::Fetch) read them as texels.
    Words,
    /// Structures of this layout, whose size is a multiple of four words: `load_NAME(index)` reads them by four words at
    /// once.
    Records(StructLayout),
}

/// Passes the declarations of all buffers to the macro that the argument names. Each declaration has a name, the Rust type
/// of an element, the access of shaders ([`Elements`]), and the number of elements as a function of the scene's
/// `ElementCounts`.
#[macro_export]
macro_rules! scene_buffers {
    ($($declare:tt)+) => {
        $($declare)+! {
            /// Corner normals of smooth meshes, and corner tangents of meshes with normal maps: per triangle, one octahedral
            /// word for each of three corners.
            corner_directions: [UVec3] as Plain("uvec3"); |c| c.smooth_triangles + c.tangent_triangles;
            /// Texture coordinates: per triangle of a mesh with textures, one pair for each of three corners. The triangles
            /// of the mesh's first set come before those of its second set.
            uvs: [[Vec2; 3]] as Plain("vec2"); |c| c.uv_triangles;
            /// Vertex colours: per triangle of a mesh with colours, one entry for each of three corners, with red, green,
            /// blue and alpha of 16 bits each.
            colors: [[UVec2; 3]] as Plain("uvec2"); |c| c.color_triangles;
            /// Three words per triangle of a mesh that has several parts or lights, or is merged: index of the material,
            /// rank among the mesh's emissive triangles or NONE, and the offset that is added to the instance's index.
            triangle_parts: [UVec3] as Plain("uvec3"); |c| c.part_triangles;
            /// Indices into `instances`, in the order of the leaves of the tree over the instances; first for the current
            /// frame and then, if something moves, for the previous frame.
            top_instances: [u32] as Plain("uint"); |c| c.epochs * c.instances;
            /// Traced instances of the current frame and then, if something moves, of the previous frame.
            instances: [GpuInstance] as Records(GpuInstance); |c| c.epochs * c.instances;
            /// Nodes of the trees of the compute tracer, twenty words each: the tree over the instances for the current
            /// frame, then, if something moves, for the previous frame, and then the trees of the meshes.
            nodes: [CwBvhNode] as Words; |_| 0;
            /// Corner positions of the triangles of all meshes: three per triangle, nine floats, before the transform of an
            /// instance.
            positions: [[Vec3; 3]] as Words; |c| c.triangles;
            /// Materials of the scene, in the order of the scene. They refer to textures by index in `textures`.
            materials: [GpuMaterial] as Records(GpuMaterial); |c| c.materials;
            /// Uses of images by materials, one entry per use. Materials and `light_textures` refer to them by index.
            textures: [GpuTexture] as Records(GpuTexture); |c| c.textures;
            /// If there are textures, a table of 256 words, with the bits of the linear float value of each sRGB byte, and
            /// then the texels of all images: red, green, blue and alpha from the lowest byte. Both are in one buffer, since
            /// some drivers bind at most 30.
            texels: [u32] as Plain("uint"); |c| c.texels + if c.textures > 0 { 256 } else { 0 };
            /// Emissive triangles in world space, of the current frame and then, if something moves, of the previous frame.
            lights: [GpuLight] as Records(GpuLight); |c| c.epochs * c.triangle_lights;
            /// Texture coordinates and index in `textures` for the emission of each emissive triangle, at the index that it
            /// has in the current frame's `lights`; empty if no emissive triangle has a texture.
            light_textures: [GpuLightTexture] as Records(GpuLightTexture); |c| if c.textured_lights { c.triangle_lights } else { 0 };
            /// Punctual lights of the current frame and then, if something moves, of the previous frame.
            punctual_lights: [GpuPunctualLight] as Records(GpuPunctualLight); |c| c.epochs * c.punctual_lights;
            /// Texels of the environment, row by row from the zenith: RGB radiance, and the density over longitude and
            /// latitude with which the texel is drawn.
            environment: [Vec4] as Words; |c| c.environment_texels;
            /// The alias table that draws texels of the environment, one entry per texel: the texel is selected if 32 random
            /// bits are below the first number; otherwise the second number is the index of the selected texel.
            environment_columns: [UVec2] as Plain("uvec2"); |c| c.environment_texels;
            /// The alias table that draws lights of all kinds (triangles, punctual lights, environment). If some lights are
            /// rare (far dimmer than the others), two tables of the same length follow: one that draws the lights that are
            /// not rare, and one that draws the rare lights.
            light_choices: [GpuLightChoice] as Records(GpuLightChoice); |c| 3 * c.lights();
            /// For each instance of the scene, by its index before meshes are merged, the transform of its points from the
            /// current to the previous frame; empty if nothing moves.
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
            /// The uniform table of a scene: counts of elements, the environment's size and rotation, and the device address
            /// of each buffer as lower and upper word. The addresses are zeros in variants without buffer addresses.
            pub struct SceneTable {
                /// Number of lights of all kinds: emissive triangles, punctual lights, and 1 for an environment.
                pub light_count: u32,
                /// Number of emissive triangles in one frame.
                pub triangle_light_count: u32,
                /// Number of punctual lights in one frame.
                pub punctual_light_count: u32,
                /// Width and height of the environment in texels; zeros without one.
                pub environment_size: UVec2,
                /// Cosine and sine of the angle by which the environment is rotated around the upward axis.
                pub environment_turn: Vec2,
                /// Number of traced instances in one frame, after meshes are merged.
                pub instance_count: u32,
                /// 1 if some emissive triangle has a texture, otherwise 0; shaders read `light_textures` only if it is 1.
                pub textured_lights: u32,
                $($(#[$meta])* pub $name: UVec2,)*
            }
        }

        /// The declarations of all buffers of a scene, in the order of the fields of [`SceneTable`].
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
    /// True if elements are read four words at a time, which variants with [`Fetch::Texels`](crate::Fetch) read as texels.
    pub fn are_words(&self) -> bool {
        !matches!(self, Self::Plain(_))
    }
}

/// The name of the buffer of a light BVH: its nodes, then its entries. It is bound by a descriptor only and has no address
/// in [`SceneTable`], since each renderer has a separate one.
pub const LIGHT_BVH: &str = "light_bvh";

/// The text of the generated file `light_bvh_buffer.glsl`: access to the nodes and entries of the light BVH.
pub fn light_bvh_glsl() -> String {
    [
        String::from("#pragma once\n#include \"prelude.glsl\"\n"),
        words(LIGHT_BVH, &binding(LIGHT_BVH, "uvec4")),
        load("light_node", LIGHT_BVH, &GpuLightNode::LAYOUT),
        load("light_entry", LIGHT_BVH, &GpuLightEntry::LAYOUT),
    ]
    .concat()
}

/// The text of the generated file `scene_buffers.glsl`: the scene table, and access to the elements of every buffer.
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

/// The GLSL declaration of a buffer that is read as `NAME.at[index]`, by address or through a descriptor, as the macro
/// `GEOMETRY_ADDRESSES` selects.
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

/// The GLSL declaration of a buffer that is read as `NAME.at[index]` through a descriptor.
fn binding(name: &str, glsl: &str) -> String {
    let block: String = name.split('_').map(capitalised).collect();
    format!("layout(scalar) readonly buffer {block}Block {{ {glsl} at[]; }} {name};\n")
}

/// The GLSL function `NAME_words(index)`, which reads four words: as a texel with `FETCH_TEXELS`, otherwise from the buffer
/// that the text `array` declares. llvmpipe fetches the four words of a texel at once for each lane, but reads a buffer word
/// by word, each word behind a branch.
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

/// The GLSL function `load_NAME(index)`, which assembles a structure from words that are read by four. Compilers do not load
/// parts of the structure that are not used.
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

/// The GLSL expression of a member's value, made from the array `q` of the words of its structure.
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
