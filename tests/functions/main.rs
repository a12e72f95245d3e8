//! Tests of single shader functions: each is called for many inputs, and the results are compared with the same function
//! written in f64.

mod camera;
mod directions;
mod environment;
mod glass;
mod layer_textures;
mod layers;
mod light_bvh;
mod lights;
mod lobes;
mod numbers;
mod radiance;
mod resampling;
mod rounding;
#[path = "../support/mod.rs"]
mod support;
mod surfaces;
mod textures;

use headwater::device_scene::environment::EnvironmentTexels;
use headwater::device_scene::light_bvh::LightBvhContents;
use headwater::device_scene::lights::Lights;
use headwater::device_scene::shaders::sources;
use headwater::gpu::{Buffer, ComputePass, Offers, Recording, Resource, SampledImage, Usage};
use headwater::render::energy::albedo_table;
use headwater::scene::Image;
use headwater::shader_interface::{
    Fetch, GeometryAccess, GpuMaterial, GpuTexture, RestirConstants, SceneTable, Textures, Tracer,
    Variant, compiler,
};
use std::sync::LazyLock;

headwater::bindings! {
    /// The bindings of the pass that calls a function under test: input words, output words, and the tables that functions
    /// read.
    pub struct Call {
        [offers tables: Tables]
        read inputs,
        write outputs,
    }
}

/// The buffers and images that functions under test may read, under the names that the shaders use.
pub struct Tables {
    specular_albedo: Buffer,
    materials: Buffer,
    lights: Buffer,
    light_choices: Buffer,
    punctual_lights: Buffer,
    environment: Buffer,
    environment_columns: Buffer,
    light_textures: Buffer,
    light_bvh: Buffer,
    textures: Buffer,
    texels: Buffer,
    /// A buffer of zeros for all names that only lights with holes would read.
    nothing: Buffer,
    images: Vec<SampledImage>,
    counters: Buffer,
    scene: Buffer,
    restir: Buffer,
}

impl Offers for Tables {
    fn resources(&self) -> Vec<(&'static str, Resource<'_>)> {
        vec![
            ("specular_albedo", Resource::Read(&self.specular_albedo)),
            ("materials", Resource::Read(&self.materials)),
            ("lights", Resource::Read(&self.lights)),
            ("light_choices", Resource::Read(&self.light_choices)),
            ("punctual_lights", Resource::Read(&self.punctual_lights)),
            ("environment", Resource::Read(&self.environment)),
            (
                "environment_columns",
                Resource::Read(&self.environment_columns),
            ),
            ("light_textures", Resource::Read(&self.light_textures)),
            ("light_bvh", Resource::Read(&self.light_bvh)),
            ("textures", Resource::Read(&self.textures)),
            ("texels", Resource::Read(&self.texels)),
            ("instances", Resource::Read(&self.nothing)),
            ("triangle_parts", Resource::Read(&self.nothing)),
            ("corner_directions", Resource::Read(&self.nothing)),
            ("uvs", Resource::Read(&self.nothing)),
            ("colors", Resource::Read(&self.nothing)),
            ("images", Resource::Images(&self.images)),
            ("counters", Resource::Write(&self.counters)),
            ("scene", Resource::Uniform(&self.scene)),
            ("restir", Resource::Uniform(&self.restir)),
        ]
    }
}

/// A piece of shader code under test, with the data that it reads. It is called once for each input of [`Function::run`].
#[derive(Clone, Default)]
pub struct Function<'a> {
    /// Paths of files in `glsl` that the pass includes.
    pub includes: &'a [&'a str],
    /// GLSL statements that compute `uvec4 x` and `uvec4 y` from the input `uvec4 a` and `uvec4 b`.
    pub body: &'a str,
    /// Contents of the buffer `materials`.
    pub materials: &'a [GpuMaterial],
    /// Lights on the device, and the alias tables that draw from them.
    pub lights: Lights,
    /// Contents of the buffer `light_bvh`.
    pub light_bvh: LightBvhContents,
    /// Texels, size and rotation of the environment.
    pub environment: EnvironmentTexels,
    /// Contents of the buffer `textures`.
    pub textures: &'a [GpuTexture],
    /// Contents of the buffer `texels`.
    pub texels: &'a [u32],
    /// Images that textures are read from; if empty, textures are read from `texels`.
    pub images: &'a [Image],
    /// Contents of the uniform buffer `restir`.
    pub restir: RestirConstants,
    /// GLSL declarations before the function, after the includes.
    pub globals: &'a str,
    /// A change of the shaders that plants a fault: (file, text in it, replacement). `None` plants none.
    pub fault: Option<(&'a str, &'a str, &'a str)>,
    /// More changes of the shaders: (file, text in it, replacement).
    pub changes: &'a [(&'a str, &'a str, &'a str)],
    /// Specialisation constants that differ from their defaults: pairs of id and value.
    pub constants: &'a [(u32, u32)],
}

impl Function<'_> {
    /// Calls the function on the tests' device once for each input: words of `a` and `b` in, words of `x` and `y` out, in
    /// the same order.
    pub fn run(&self, inputs: &[[u32; 8]]) -> Vec<[u32; 8]> {
        let includes: String = self
            .includes
            .iter()
            .map(|name| format!("#include \"{name}\"\n"))
            .collect();
        let source = format!(
            "#version 460\n#include \"core/math.glsl\"\n{includes}
            {globals}
            layout(local_size_x = 64) in;
            layout(scalar) readonly buffer InputsBlock {{ uvec4 at[]; }} inputs;
            layout(scalar) writeonly buffer OutputsBlock {{ uvec4 at[]; }} outputs;
            void main() {{
                uint i_ = gl_GlobalInvocationID.x;
                if (i_ >= {count}u) return;
                uvec4 a = inputs.at[2u * i_], b = inputs.at[2u * i_ + 1u];
                uvec4 x = uvec4(0u), y = uvec4(0u);
                {body}
                outputs.at[2u * i_] = x;
                outputs.at[2u * i_ + 1u] = y;
            }}",
            count = inputs.len(),
            body = self.body,
            globals = self.globals,
        );
        let variant = Variant {
            tracer: Tracer::ComputeBvh,
            geometry: GeometryAccess::StorageBuffers,
            fetch: Fetch::Words,
            textures: match self.images {
                [] => Textures::Buffer,
                _ => Textures::Images,
            },
        };
        let mut sources = sources();
        for (file, text, planted) in self.fault.iter().chain(self.changes) {
            let source = sources.get_mut(*file).expect("no such file");
            assert!(source.contains(*text), "{file} has no '{text}'");
            *source = source.replace(*text, planted);
        }
        let words = compiler::compile("function.comp", &source, &sources, &variant.defines())
            .unwrap_or_else(|e| panic!("{e}"));
        let (device, _) = support::open_device(Some(variant));
        let buffer =
            |name, data: &[u8]| Buffer::from_slice(&device, name, data, Usage::default()).unwrap();
        // Half a second of work, the same for every function.
        static TABLE: LazyLock<Vec<[f32; 2]>> = LazyLock::new(albedo_table);
        let table = SceneTable {
            light_count: self.lights.choices.len() as u32,
            triangle_light_count: self.lights.triangles.len() as u32,
            punctual_light_count: self.lights.punctual.len() as u32,
            environment_size: self.environment.size,
            environment_turn: self.environment.turn,
            ..SceneTable::default()
        };
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let tables = Tables {
            specular_albedo: buffer("specular_albedo", bytemuck::cast_slice(&TABLE)),
            materials: buffer("materials", bytemuck::cast_slice(self.materials)),
            lights: buffer("lights", bytemuck::cast_slice(&self.lights.triangles)),
            light_choices: buffer("light_choices", bytemuck::cast_slice(&self.lights.choices)),
            punctual_lights: buffer(
                "punctual_lights",
                bytemuck::cast_slice(&self.lights.punctual),
            ),
            environment: buffer(
                "environment",
                bytemuck::cast_slice(&self.environment.texels),
            ),
            environment_columns: buffer(
                "environment_columns",
                bytemuck::cast_slice(&self.environment.columns),
            ),
            light_textures: buffer("light_textures", &[0; 32]),
            light_bvh: buffer("light_bvh", bytemuck::cast_slice(&self.light_bvh.words())),
            textures: buffer("textures", bytemuck::cast_slice(self.textures)),
            texels: buffer("texels", bytemuck::cast_slice(self.texels)),
            nothing: buffer("nothing", &[0; 256]),
            images: (self.images.iter())
                .map(|i| SampledImage::new(&device, "image", i.row_length(), &i.texels).unwrap())
                .collect(),
            counters: buffer("counters", &[0; 64]),
            scene: Buffer::from_slice(&device, "scene", &[table], uniform).unwrap(),
            restir: Buffer::from_slice(&device, "restir", &[self.restir], uniform).unwrap(),
        };
        let inputs_buffer = buffer("inputs", bytemuck::cast_slice(inputs));
        let outputs = buffer("outputs", &vec![0; inputs.len() * 32]);
        let images = tables.images.len() as u32;
        let pass = ComputePass::with_images(&device, "function", &words, self.constants, images);
        let pass = pass.unwrap();
        let bindings = Call {
            tables: &tables,
            inputs: &inputs_buffer,
            outputs: &outputs,
        };
        let groups = [inputs.len().div_ceil(64) as u32, 1, 1];
        let mut recording = Recording::new(&device).unwrap();
        recording.pass(&pass, &bindings, &(), groups).unwrap();
        recording.finish().unwrap();
        support::assert_no_messages(&device);
        outputs.read(inputs.len()).unwrap()
    }
}

/// The bits of up to eight floats as an input; the other words are 0.
pub fn floats(values: &[f32]) -> [u32; 8] {
    let mut words = [0; 8];
    for (word, value) in words.iter_mut().zip(values) {
        *word = value.to_bits();
    }
    words
}

/// The vector whose f32 components have the bits of the first three words.
pub fn vector(words: &[u32]) -> glam::DVec3 {
    let at = |i: usize| f64::from(f32::from_bits(words[i]));
    glam::DVec3::new(at(0), at(1), at(2))
}

/// The f32 with the bits of a word, as f64.
pub fn number(word: u32) -> f64 {
    f64::from(f32::from_bits(word))
}
