//! The declarations of the buffers from which shaders read a scene, such as its triangles, materials and lights. Each buffer
//! is declared once, so that Rust and GLSL agree on its elements. Macros generate three things from each declaration: the
//! GLSL code that reads the buffer, the field of [`SceneTable`] with the buffer's address, and, in
//! `device_scene/buffers.rs`, fields for the buffer's contents and size.

use crate::declare::{GpuStruct, Member, StructLayout};
use crate::{
    GpuInstance, GpuLight, GpuLightChoice, GpuLightEntry, GpuLightNode, GpuLightTexture,
    GpuMaterial, GpuMaterialLayers, GpuPreviousTransform, GpuPunctualLight, GpuTexture,
};
use glam::{UVec2, Vec2};

/// The declaration of one buffer of the scene for shaders: its name, and the way in which they read it. The GLSL code that
/// reads the buffer is generated from it. The program also decides by it whether the buffer is bound as texels in variants
/// with [`Fetch::Texels`](crate::Fetch).
pub struct Access {
    /// The name of the buffer in GLSL. The buffer's binding (descriptor) and the field of its address in [`SceneTable`] have
    /// the same name.
    pub name: &'static str,
    /// The way in which shaders read the buffer's elements, with the GLSL type or the layout of an element.
    pub elements: Elements,
}

/// The way in which shaders read the elements of a buffer: one by one, as groups of four 32-bit words, or as structures.
/// [`Fetch`](crate::Fetch) decides whether buffers of the last two kinds are read as texels, which is faster on some
/// drivers.
pub enum Elements {
    /// Shaders read one element of this GLSL type at a time, by the expression `NAME.at[index]`, where `NAME` is the name of
    /// the buffer.
    Plain(&'static str),
    /// Shaders read four 32-bit words at a time: the function `NAME_words(index)` returns the words 4 · `index` to 4 ·
    /// `index` + 3 of the buffer `NAME`. In shader variants with [`Fetch::Texels`](crate::Fetch), these four words are one
    /// texel.
    Words,
    /// The elements are structures of this layout, whose size must be a multiple of four words. The function
    /// `load_NAME(index)` returns one structure of the buffer `NAME`; it reads the words of the structure four at a time, as
    /// with [`Self::Words`].
    Records(StructLayout),
}

/// Passes the declarations of all buffers of a scene to another macro, whose name is the argument. That macro generates
/// items from them. A declaration has a doc comment, the name of the buffer, the Rust type of an element, the access of
/// shaders ([`Elements`]), and a function that computes the number of elements from the scene's `ElementCounts` (numbers of
/// triangles, lights and so on), so that sizes are known before the buffers are filled.
#[macro_export]
macro_rules! scene_buffers {
    ($($declare:tt)+) => {
        $($declare)+! {
            /// Normals and tangents at the corners of triangles, which shaders interpolate for smooth shading and for normal
            /// maps. They are unit vectors in the object space of the mesh, each packed into one word (octahedral
            /// coordinates). Each entry has three vectors, one for each corner of a triangle. Meshes with smooth shading
            /// have one entry per triangle for their normals; meshes with normal maps have one more per triangle for their
            /// tangents.
            corner_directions: [UVec3] as Plain("uvec3"); |c| c.smooth_triangles + c.tangent_triangles;
            /// Texture coordinates (u, v), at which shaders read the textures of a mesh; only for meshes that have them.
            /// There are three pairs per triangle, one for each corner. If a mesh has two sets of texture coordinates, all
            /// its triangles in the first set come before all its triangles in the second set.
            uvs: [[Vec2; 3]] as Plain("vec2"); |c| c.uv_triangles;
            /// Vertex colours, which multiply the base colour of the material, for meshes that have them: three entries per
            /// triangle, one for each corner. An entry has red, green, blue and alpha, 16 bits each, which represent the
            /// range [0, 1].
            colors: [[UVec2; 3]] as Plain("uvec2"); |c| c.color_triangles;
            /// The material, the light and the instance of each triangle that a ray can hit. There is one
            /// entry per triangle, but only for meshes that have several parts (runs of triangles with one
            /// material), emit light, or are merged from several meshes. An entry has the index of the
            /// triangle's material, the triangle's rank among the emissive triangles of the mesh (NONE if it
            /// emits no light), and an offset. `GpuInstance::id` plus the offset is the index of the
            /// triangle's instance before meshes were merged, which selects an entry of
            /// `previous_transforms`.
            triangle_parts: [UVec3] as Plain("uvec3"); |c| c.part_triangles;
            /// For each leaf of the tree over the instances, which the compute tracer traverses, the index in the buffer
            /// `instances` of the instance that a ray enters at this leaf. The leaves of the current frame's tree come
            /// first. If something moves, the leaves of the previous frame's tree follow.
            top_instances: [u32] as Plain("uint"); |c| c.epochs * c.instances;
            /// The instances of meshes that rays hit, after static meshes are merged. An instance has the transform of its
            /// mesh, and the indices at which the data of the mesh begin in other buffers. All instances with their
            /// transforms in the current frame come first. If something moves, all instances with their transforms in the
            /// previous frame follow, so that shaders can also trace rays in the scene as it was in that frame.
            instances: [GpuInstance] as Records(GpuInstance); |c| c.epochs * c.instances;
            /// Nodes of the trees (eight-wide bounding volume hierarchies) that the compute tracer traverses, twenty words
            /// each. The tree over the instances in the current frame comes first, then, if something moves, the tree over
            /// the instances in the previous frame, and then the trees over the triangles of the meshes.
            nodes: [CwBvhNode] as Words; |_| 0;
            /// Positions of the three corners of each triangle of all meshes, from which shaders compute the points that
            /// rays hit: nine floats per triangle. They are in the stored space of the mesh, which is its object space,
            /// translated and scaled for precision; `GpuInstance::object_to_world` transforms them to the world.
            positions: [[Vec3; 3]] as Words; |c| c.triangles;
            /// All materials of the scene, in the order of the scene; shaders take the BSDF of a surface from them. A
            /// material names its textures by their indices in the buffer `textures`. If some material has a layer, the layers of
            /// all materials follow (`GpuMaterialLayers`), which are read by `load_material_layers`.
            materials: [GpuMaterial] as Records(GpuMaterial); |c| if c.layers { 2 * c.materials } else { c.materials };
            /// One entry for each use of an image by a material: where the texels of the image are, and how texture
            /// coordinates select them. Materials and the buffer `light_textures` name an entry by its index.
            textures: [GpuTexture] as Records(GpuTexture); |c| c.textures;
            /// If there are textures, a table of 256 words comes first: the bits of the linear float value of each sRGB
            /// byte. If some image has 16 bits per channel, the values of the 65,536 16-bit sRGB values follow. Then come
            /// the texels of all images, one word each, with red, green, blue and alpha from the lowest byte; a texel of 16
            /// bits has two words, for the high and the low bytes. Texels are left out if shaders read Vulkan images
            /// instead. Table and texels share one buffer, because some drivers bind at most 30 buffers.
            texels: [u32] as Plain("uint"); |c| c.texels + c.srgb_table;
            /// Emissive triangles, on which light samples draw points; in world space, relative to the scene's origin, which
            /// is usually the camera's position. Lengths and radiances are in the device's units, which are the scene's
            /// units times powers of two. All triangles as they are in the current frame come first. If something moves, all
            /// triangles as they were in the previous frame follow.
            lights: [GpuLight] as Records(GpuLight); |c| c.epochs * c.triangle_lights;
            /// For each emissive triangle, the texture that multiplies its emission: an index in the buffer `textures` (NONE
            /// without such a texture) and texture coordinates. The order is that of the current frame's triangles in the
            /// buffer `lights`. This buffer is empty if no emissive triangle has a texture.
            light_textures: [GpuLightTexture] as Records(GpuLightTexture); |c| if c.textured_lights { c.triangle_lights } else { 0 };
            /// Punctual lights (point, spot and directional lights), which light samples draw; in world space and in the
            /// device's units, as in the buffer `lights`. All of them as they are in the current frame come first. If
            /// something moves, all of them as they were in the previous frame follow.
            punctual_lights: [GpuPunctualLight] as Records(GpuPunctualLight); |c| c.epochs * c.punctual_lights;
            /// Texels of the environment, the light that surrounds the scene, row by row from the zenith; empty without an
            /// environment. A texel has its RGB radiance in the device's unit of radiance (the scene's unit times a power of
            /// two), and the density with which light samples draw a point of the texel, per square radian of longitude ×
            /// latitude.
            environment: [Vec4] as Words; |c| c.environment_texels;
            /// The alias table by which light samples draw a texel of the environment, with one entry per texel. A random
            /// number selects an entry. If 32 more random bits are below the entry's first number, the texel with the index
            /// of the entry is drawn; otherwise the second number is the index of the drawn texel.
            environment_columns: [UVec2] as Plain("uvec2"); |c| c.environment_texels;
            /// The alias table by which light samples draw a light, with one entry for each emissive triangle, then for each
            /// punctual light, then for the environment. If some lights are rare (far dimmer than the others), two tables of
            /// the same length follow. The first draws only lights that are not rare. The second draws only rare lights,
            /// which have separate candidates, because brighter lights would win against them in resampling.
            light_choices: [GpuLightChoice] as Records(GpuLightChoice); |c| 3 * c.lights();
            /// For each instance of the scene, in the order of the scene before meshes are merged, the transform of its
            /// points in the world from their positions in the current frame to those in the previous frame. By it, shaders
            /// find the pixel of the previous frame that showed a surface. Empty if nothing moves.
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
            /// The uniform buffer of a scene: numbers of elements, size and rotation of the environment, and the device
            /// address of each buffer (lower word, then upper word), by which shaders read the buffer. In variants that bind
            /// buffers by descriptors instead, the addresses are zeros.
            pub struct SceneTable {
                /// Number of lights of all kinds in one frame: emissive triangles, punctual lights, and 1 for an
                /// environment. It is the number of entries of each alias table in `light_choices`.
                pub light_count: u32,
                /// Number of emissive triangles in one frame; if something moves, the buffer `lights` has twice as many. In
                /// `light_choices`, emissive triangles have the indices below this number.
                pub triangle_light_count: u32,
                /// Number of punctual lights in one frame; if something moves, the buffer `punctual_lights` has twice as
                /// many. In `light_choices`, they come after the emissive triangles.
                pub punctual_light_count: u32,
                /// Width and height of the environment in texels; zeros without an environment.
                pub environment_size: UVec2,
                /// Cosine and sine of the angle by which the environment is rotated around the upward axis (+Y),
                /// counter-clockwise if seen from above. Shaders convert between directions in the world and texels of the
                /// environment with them.
                pub environment_turn: Vec2,
                /// Number of instances in one frame, after static meshes are merged; if something moves, the buffer
                /// `instances` has twice as many. Shaders add it to the index of an instance to read its transform in the
                /// previous frame.
                pub instance_count: u32,
                /// Number of materials in the buffer `materials`. The layers of the material with the index i, if there are any,
                /// are the element with this number + i.
                pub material_count: u32,
                /// 1 if some emissive triangle has a texture, otherwise 0; shaders read `light_textures` only if it is 1.
                pub textured_lights: u32,
                $($(#[$meta])* pub $name: UVec2,)*
            }
        }

        /// The declarations of all buffers of a scene, in the order of the fields of [`SceneTable`]. GLSL code is generated
        /// from them, and the program binds buffers by them.
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
    /// True if shaders read the elements four words at a time, as with [`Self::Words`] and [`Self::Records`]. Variants with
    /// [`Fetch::Texels`](crate::Fetch) then read the buffer as texels.
    pub fn are_words(&self) -> bool {
        !matches!(self, Self::Plain(_))
    }
}

/// The name of the buffer of the light BVH (a tree from which light samples are drawn). The buffer holds all nodes of the
/// tree, then one entry per light. It is bound by a descriptor only and has no address in [`SceneTable`]: the table belongs
/// to the scene, but each renderer builds its own light BVH.
pub const LIGHT_BVH: &str = "light_bvh";

/// The text of the generated file `light_bvh_buffer.glsl`: the declaration of the light BVH's buffer, and the functions
/// `load_light_node` and `load_light_entry`, which read one node or entry by its index.
pub fn light_bvh_glsl() -> String {
    [
        String::from("#pragma once\n#include \"prelude.glsl\"\n"),
        words(LIGHT_BVH, &binding(LIGHT_BVH, "uvec4")),
        load("light_node", LIGHT_BVH, &GpuLightNode::LAYOUT),
        load("light_entry", LIGHT_BVH, &GpuLightEntry::LAYOUT),
    ]
    .concat()
}

/// The text of the generated file `scene_buffers.glsl`: the declaration of the [`SceneTable`], and for every buffer of the
/// scene the declaration and the functions by which shaders read it.
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
    text + &load("material_layers", "materials", &GpuMaterialLayers::LAYOUT)
}

/// The GLSL declaration of the buffer `name` with elements of the GLSL type `glsl`, which shaders read as `NAME.at[index]`.
/// They read it by its address if the preprocessor macro `GEOMETRY_ADDRESSES` is 1, and through a descriptor if the macro is
/// 0.
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

/// The GLSL declaration of the buffer `name` with elements of the GLSL type `glsl`, which shaders read as `NAME.at[index]`
/// through a descriptor, in variants without buffer addresses and for buffers that have no address in [`SceneTable`].
fn binding(name: &str, glsl: &str) -> String {
    let block: String = name.split('_').map(capitalised).collect();
    format!("layout(scalar) readonly buffer {block}Block {{ {glsl} at[]; }} {name};\n")
}

/// The GLSL text of the function `NAME_words(index)`, which reads four words of the buffer `name`. If the preprocessor macro
/// `FETCH_TEXELS` is 1, it reads them as one texel; otherwise it reads them from the buffer that the GLSL text `array`
/// declares. Texels are faster on the driver llvmpipe: it fetches the four words of a texel at once for each lane, but reads
/// the words of a buffer one by one, with a branch for each word.
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

/// The GLSL text of the function `load_NAME(index)`, where `NAME` is `name`. It reads one structure from the buffer
/// `buffer`, four words at a time, and assembles the members that `layout` lists. Compilers leave out the reads of members
/// that the caller does not use.
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

/// The GLSL expression of the value of `member`, a member of a structure that `load_NAME` returns. The expression takes the
/// value from the array `q`, which has the words of the structure in groups of four.
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
