//! Scenes on the CPU: meshes, materials, lights, cameras and their motion, with checks of a scene and of its limits. Files
//! are read into these types, generators fill them, and the renderer makes the device's copy from them. This module knows
//! neither file formats nor Vulkan.
//!
//! Lengths are in the units of the file (glTF: metres). Coordinates are right-handed with +Y up. Radiance is linear RGB.

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

use camera::Projection;
use glam::{DAffine3, Vec2, Vec3, Vec4};

/// A complete scene: meshes that instances place in the world, lights, and cameras. It comes from a file or a generator,
/// [`Scene::validate`] checks it, and the renderer makes the device's copy from it.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The name of a generated scene, or the file's name without its extension. Reports and exported files state it.
    pub name: String,
    /// Meshes in object space. Several instances can share one mesh.
    pub meshes: Vec<Mesh>,
    /// The materials, which describe how surfaces reflect, emit and block light. [`Part::material`] is an
    /// index into this array.
    pub materials: Vec<Material>,
    /// The names of the material variants among which the scene's file offers a choice, in the order of the file. One of them
    /// can be chosen when the scene is loaded; it decides the materials of [`Mesh::parts`]. Empty if there is no choice.
    pub material_variants: Vec<String>,
    /// Images of textures. [`Texture::image`] is an index into this array.
    pub images: Vec<Image>,
    /// Meshes with their transforms into the world. A mesh without an instance is not visible.
    pub instances: Vec<Instance>,
    /// Point, spot and directional lights. They have no surface that a ray could hit, so only light samples
    /// find them.
    pub punctual_lights: Vec<PunctualLight>,
    /// Light from infinitely far away; `None` if a ray that leaves the scene sees black.
    pub environment: Option<Environment>,
    /// Cameras in the order of the file. If it is empty, because the file has no camera, commands use a camera that sees the
    /// whole scene.
    pub cameras: Vec<Camera>,
    /// The motion of instances, cameras and lights, and the changes of emission; `None` if nothing changes with time. The
    /// other fields hold the state at time 0.
    pub motion: Option<Motion>,
    /// Notices to the user about assumptions, omissions and repairs during loading, one line each. Commands print them.
    pub notices: Vec<String>,
}

/// Indexed triangles in object space, divided into parts with one material each. An [`Instance`] places them in the world.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the source file, for messages; possibly empty.
    pub name: String,
    /// Position of each vertex in object space, finite. The indices in `triangles` are indices into this array.
    pub positions: Vec<Vec3>,
    /// Unit shading normals in object space, one per position. Empty if the mesh is shaded with the geometric normals of its
    /// triangles.
    pub normals: Vec<Vec3>,
    /// Vertex colours, one per position: linear RGB and alpha in [0, 1], which multiply the material's base colour and
    /// alpha. Empty if the mesh has no vertex colours.
    pub colors: Vec<Vec4>,
    /// Unit tangents along u in object space, one per position. The component w is the sign of the bitangent, which is w ·
    /// (normal × tangent). Empty if no material of the mesh has a normal map. A vertex whose material has no normal map may
    /// have the tangent 0.
    pub tangents: Vec<Vec4>,
    /// Two sets of texture coordinates, each with one entry per position; [`Texture::set`] says which set a texture uses. A
    /// set that no texture uses can be empty.
    pub uvs: [Vec<Vec2>; 2],
    /// The three corners of each triangle, as indices into `positions`, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of triangles with one material each. Together they cover `triangles` in order, without gaps.
    pub parts: Vec<Part>,
    /// While a mesh that deforms is repaired: for each vertex, its index before the repair. Empty otherwise.
    pub sources: Vec<u32>,
}

/// A run of consecutive triangles of a [`Mesh`] that have the same material. Several parts give one mesh several materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index into [`Mesh::triangles`] of the first triangle of the part. Its other triangles follow in that
    /// array.
    pub first_triangle: u32,
    /// Number of triangles of the part, which are consecutive in [`Mesh::triangles`].
    pub triangle_count: u32,
    /// Index into [`Scene::materials`]: the material of all triangles of the part.
    pub material: u32,
}

impl Part {
    /// The indices of the part's triangles in [`Mesh::triangles`], for loops over these triangles.
    pub fn range(&self) -> std::ops::Range<u32> {
        self.first_triangle..self.first_triangle + self.triangle_count
    }
}

/// A copy of a mesh in the world, placed there by a transform. Several instances can share one mesh.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name of the node of the scene file from which the instance was read, for messages; empty if the node has none.
    pub name: String,
    /// Index into [`Scene::meshes`]: the mesh that the instance places.
    pub mesh: u32,
    /// Transform from object to world space, which may mirror and scale non-uniformly. It is in f64 because f32 is coarse
    /// far from 0. On upload, the renderer moves the origin near the camera and converts the transform to f32.
    pub object_to_world: DAffine3,
}

/// The effect of a material's alpha (glTF's `alphaMode`): it decides how much light a point of the surface blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha has no effect: the surface blocks all light everywhere.
    Opaque,
    /// The surface has holes: it blocks all light where alpha is at least the cutoff, and is absent elsewhere.
    Mask {
        /// The smallest alpha with which the surface is present, above 0. Higher values make larger holes.
        cutoff: f32,
    },
    /// The surface is partly transparent: alpha is the fraction of light that it blocks, and the rest passes. What the
    /// surface reflects and emits is multiplied by alpha too.
    Blend,
}

/// The material of a surface, by the metallic-roughness model (glTF 2.0 with emissive strength, specular and ior). It
/// decides how the surface reflects, emits and blocks light.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the source file, for messages; possibly empty.
    pub name: String,
    /// Linear RGB base colour, each channel in [0, 1]: the diffuse albedo of a dielectric, the specular colour of a metal.
    pub base_color: Vec3,
    /// Texture whose sRGB colour, converted to linear, multiplies `base_color`, and whose alpha multiplies `alpha`. `None`
    /// leaves both unchanged.
    pub base_color_texture: Option<Texture>,
    /// Coverage of the surface in [0, 1], with which `alpha_mode` decides how much light the surface blocks. The alpha of
    /// the base colour texture and of the vertex colours multiplies it.
    pub alpha: f32,
    /// The effect of the alpha at a point: none, holes, or partial transparency.
    pub alpha_mode: AlphaMode,
    /// Metalness in [0, 1]: 0 is a dielectric, 1 a metal. The blue channel of `metallic_roughness_texture` multiplies it.
    pub metallic: f32,
    /// Perceptual roughness in [0, 1], which the green channel of `metallic_roughness_texture` multiplies. The square of the
    /// product is the width α of the GGX lobe.
    pub roughness: f32,
    /// Linear texture that multiplies `roughness` by its green channel and `metallic` by its blue one. `None` leaves both
    /// unchanged.
    pub metallic_roughness_texture: Option<Texture>,
    /// Normal map: its red, green and blue, mapped from [0, 1] to [−1, 1], are the shading normal along tangent, bitangent
    /// and normal. `None` leaves the shading normal unchanged.
    pub normal_texture: Option<Texture>,
    /// Factor on the tangent and bitangent components of the normal map, finite. With 0 the map has no effect.
    pub normal_scale: f32,
    /// Strength of a dielectric's specular reflection (`KHR_materials_specular`), in [0, 1]. A dielectric with 0 is pure
    /// Lambert.
    pub specular: f32,
    /// Linear RGB factor ≥ 0 on a dielectric's specular reflection at normal incidence
    /// (`KHR_materials_specular`); it tints the reflection.
    pub specular_color: Vec3,
    /// Linear texture whose alpha multiplies `specular`; `None` leaves it unchanged.
    pub specular_texture: Option<Texture>,
    /// Texture whose sRGB colour, converted to linear, multiplies `specular_color`; `None` leaves it unchanged.
    pub specular_color_texture: Option<Texture>,
    /// Index of refraction of a dielectric: at least 1, or 0 for a dielectric that reflects all light at normal incidence (a
    /// convention of glTF). Above 1, a higher index reflects more.
    pub ior: f32,
    /// True if the camera sees the base colour as radiance, independent of all lights, and all other rays see
    /// a black surface (`KHR_materials_unlit`).
    pub unlit: bool,
    /// Emitted linear RGB radiance ≥ 0 in W/(m²·sr): glTF's emissive factor × emissive strength. `emissive_texture`
    /// multiplies it.
    pub emission: Vec3,
    /// Texture whose sRGB colour, converted to linear, multiplies `emission`; `None` leaves the emission unchanged.
    pub emissive_texture: Option<Texture>,
    /// True if both sides of the surface emit; false if only the front does. Every surface reflects on both sides.
    pub double_sided: bool,
    /// True if the camera looks through the back of the surface, as glTF asks for materials that are not double-sided. All
    /// other rays meet both sides: a wall blocks light from both, and a bounce behind it would find light that cannot be
    /// there.
    pub culled: bool,
}

impl Default for Material {
    /// The values that glTF defines for properties that a file omits: a white metal of roughness 1 without emission. Loaders
    /// overwrite the properties that the file states.
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
            specular_texture: None,
            specular_color_texture: None,
            ior: 1.5,
            unlit: false,
            emission: Vec3::ZERO,
            emissive_texture: None,
            double_sided: false,
            culled: false,
        }
    }
}

impl Material {
    /// A material that reflects light only diffusely (Lambert), without a specular lobe. `albedo` is linear RGB in [0, 1].
    pub fn lambert(name: &str, albedo: Vec3) -> Self {
        Self {
            name: name.into(),
            base_color: albedo,
            metallic: 0.0,
            specular: 0.0,
            ..Self::default()
        }
    }

    /// An opaque material that neither emits nor reflects light. The camera sees its surfaces with the linear
    /// RGB radiance `color`, in W/(m²·sr).
    pub fn unlit(name: &str, color: Vec3) -> Self {
        Self {
            unlit: true,
            ..Self::lambert(name, color)
        }
    }

    /// The textures that the material has, each with the name of its slot, such as `normal texture`, for
    /// messages.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, &Texture)> {
        let textures = [
            ("base colour texture", &self.base_color_texture),
            (
                "metallic-roughness texture",
                &self.metallic_roughness_texture,
            ),
            ("normal texture", &self.normal_texture),
            ("specular texture", &self.specular_texture),
            ("specular colour texture", &self.specular_color_texture),
            ("emissive texture", &self.emissive_texture),
        ];
        textures
            .into_iter()
            .filter_map(|(name, texture)| Some((name, texture.as_ref()?)))
    }

    /// True if light may pass through a part of each point of the surface where `mesh` has this material: the alpha mode is
    /// [`AlphaMode::Blend`], and alpha is not 1 everywhere. Texels are not examined, nor are vertex colours.
    pub fn blends(&self, mesh: &Mesh) -> bool {
        let varies = self.base_color_texture.is_some() || !mesh.colors.is_empty();
        self.alpha_mode == AlphaMode::Blend && (varies || self.alpha < 1.0)
    }

    /// True if a texture changes the specular reflection of the dielectric from point to point.
    pub fn has_specular_textures(&self) -> bool {
        self.specular_texture.is_some() || self.specular_color_texture.is_some()
    }

    /// True if `emission` is above 0 in some channel, so that the surface's triangles can be lights. The emissive texture is
    /// not examined, so the surface can still be black. If the emission is animated, only the value in `emission` counts.
    pub fn is_emissive(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}

/// A camera, from which a picture is rendered. In its own space it looks along −Z, and +Y is the top of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the file's node or camera, by which a user can choose the camera; possibly empty.
    pub name: String,
    /// Transform from camera to world space, in scene units: a rotation and a translation without scale.
    pub camera_to_world: DAffine3,
    /// The projection of the scene to the picture, with the picture's vertical extent.
    pub projection: Projection,
    /// Width of the picture divided by its height, above 0; `None` if the file does not give it. Commands then use 16:9.
    pub aspect_ratio: Option<f64>,
}
