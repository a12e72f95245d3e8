//! Scenes on the CPU: their parts, motion, checks and limits. Independent of files and of Vulkan.
//!
//! Units are those of the file (glTF: metres); right-handed, +Y up; linear RGB radiance.

pub mod bounds;
pub mod camera;
mod content_hash;
mod darkness;
pub mod environment;
pub mod lights;
pub mod limits;
pub mod motion;
pub(crate) mod notices;
pub mod punctual;
mod repair;
pub mod requirements;
mod tangents;
pub mod texture;
pub mod validate;

pub use bounds::Bounds;
pub use environment::Environment;
pub use motion::{Motion, MovingCamera};
pub use punctual::{PunctualLight, PunctualShape};
pub use texture::{Image, Texture};

use glam::{DAffine3, Vec2, Vec3, Vec4};

/// A complete scene: meshes placed by instances, seen by cameras.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The scene's name: a procedural name or the file's stem.
    pub name: String,
    /// Geometry in object space, shared by instances.
    pub meshes: Vec<Mesh>,
    /// Surface descriptions that [`Part::material`] points into.
    pub materials: Vec<Material>,
    /// Images that [`Texture::image`] points into.
    pub images: Vec<Image>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Lights without a surface.
    pub punctual_lights: Vec<PunctualLight>,
    /// Light from infinitely far away, if there is any.
    pub environment: Option<Environment>,
    /// Cameras in file order.
    pub cameras: Vec<Camera>,
    /// The scene's motion, if it moves; the rest of the scene is then its state at time 0.
    pub motion: Option<Motion>,
    /// Notices to the user about assumptions and omissions of the loader, one line each.
    pub notices: Vec<String>,
}

/// Indexed triangles in object space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the source file, possibly empty.
    pub name: String,
    /// Finite positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position; empty for flat shading with geometric normals.
    pub normals: Vec<Vec3>,
    /// Linear colours and alpha in [0, 1], which multiply the material's base colour, one per position; or empty.
    pub colors: Vec<Vec4>,
    /// Unit tangents along u, with the sign of the bitangent normal × tangent in w, one per position; or empty. A vertex whose
    /// material has no normal map may have 0.
    pub tangents: Vec<Vec4>,
    /// Two sets of texture coordinates, one per position; a set that no texture uses is empty.
    pub uvs: [Vec<Vec2>; 2],
    /// Corner indices into `positions`, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of triangles with one material each; together they cover `triangles` in order.
    pub parts: Vec<Part>,
}

/// A run of triangles of a [`Mesh`] with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index of the run's first triangle.
    pub first_triangle: u32,
    /// Number of triangles in the run.
    pub triangle_count: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

impl Part {
    /// The indices of its triangles.
    pub fn range(&self) -> std::ops::Range<u32> {
        self.first_triangle..self.first_triangle + self.triangle_count
    }
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name of the node, possibly empty.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Object to world; may mirror and scale non-uniformly. In f64 until the scene is rebased.
    pub object_to_world: DAffine3,
}

/// The meaning of a material's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha has no effect: the surface is opaque.
    Opaque,
    /// The surface is opaque where alpha is at least the cutoff, and absent elsewhere.
    Mask {
        /// The cutoff, above 0.
        cutoff: f32,
    },
    /// Alpha is the fraction of the light that the surface covers; the rest of the light passes.
    Blend,
}

/// A metallic-roughness surface (glTF 2.0 with emissive strength, specular and ior).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the source file, possibly empty.
    pub name: String,
    /// Linear base colour, each channel in [0, 1].
    pub base_color: Vec3,
    /// Texture that multiplies the base colour; sRGB.
    pub base_color_texture: Option<Texture>,
    /// Coverage of the surface, in [0, 1]: multiplied by the alpha of base colour texture and vertex colours.
    pub alpha: f32,
    /// The meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Metalness in [0, 1]: 0 is a dielectric, 1 a metal.
    pub metallic: f32,
    /// Perceptual roughness in [0, 1]; GGX α is its square.
    pub roughness: f32,
    /// Texture that multiplies roughness (green) and metalness (blue).
    pub metallic_roughness_texture: Option<Texture>,
    /// Texture that turns the shading normal: a vector of tangent, bitangent and normal.
    pub normal_texture: Option<Texture>,
    /// Factor of the first two components of that vector.
    pub normal_scale: f32,
    /// The factor of `KHR_materials_specular`, in [0, 1]; 0 on a dielectric is pure Lambert.
    pub specular: f32,
    /// `KHR_materials_specular`'s colour factor, ≥ 0.
    pub specular_color: Vec3,
    /// Index of refraction of a dielectric, ≥ 1 (or 0, glTF's "F0 = 1" convention).
    pub ior: f32,
    /// True if the camera sees the base colour unchanged, as radiance, while all other rays see black (`KHR_materials_unlit`).
    pub unlit: bool,
    /// Emitted radiance: emissive factor × emissive strength, ≥ 0.
    pub emission: Vec3,
    /// Texture that multiplies the emission; sRGB.
    pub emissive_texture: Option<Texture>,
    /// True if both sides emit. (Every surface reflects on both sides.)
    pub double_sided: bool,
}

impl Default for Material {
    /// glTF's defaults: a white, fully rough metal. Loaders overwrite them.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::ONE,
            base_color_texture: None,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            specular: 1.0,
            specular_color: Vec3::ONE,
            ior: 1.5,
            unlit: false,
            emission: Vec3::ZERO,
            emissive_texture: None,
            double_sided: false,
        }
    }
}

impl Material {
    /// A purely Lambertian surface without a specular lobe.
    pub fn lambert(name: &str, albedo: Vec3) -> Self {
        Self {
            name: name.into(),
            base_color: albedo,
            metallic: 0.0,
            specular: 0.0,
            ..Self::default()
        }
    }

    /// An opaque surface that the camera sees, but that neither emits nor reflects light.
    pub fn unlit(name: &str, color: Vec3) -> Self {
        Self {
            unlit: true,
            ..Self::lambert(name, color)
        }
    }

    /// The textures, each with its name for messages.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, &Texture)> {
        let textures = [
            ("base colour texture", &self.base_color_texture),
            (
                "metallic-roughness texture",
                &self.metallic_roughness_texture,
            ),
            ("normal texture", &self.normal_texture),
            ("emissive texture", &self.emissive_texture),
        ];
        textures
            .into_iter()
            .filter_map(|(name, texture)| Some((name, texture.as_ref()?)))
    }

    /// True if the surface emits light.
    pub fn is_emissive(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}

/// A perspective camera that looks along its −Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the node or camera, possibly empty.
    pub name: String,
    /// Camera to world: a rigid transform.
    pub camera_to_world: DAffine3,
    /// Full vertical field of view in radians, in (0, π).
    pub vertical_fov: f64,
    /// Width over height, if the file has it.
    pub aspect_ratio: Option<f64>,
}
