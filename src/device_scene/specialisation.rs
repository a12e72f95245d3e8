//! The values of the specialisation constants that depend on the scene. With them, shaders leave out the code
//! for features that the scene lacks, and so run faster.

use super::GpuScene;
use crate::shader_interface::Specialisation;

impl GpuScene {
    /// The values of the specialisation constants for all passes of this scene. Constants that do not depend on the scene
    /// have their defaults. If `full` is true (the setting `variant=full`), shaders also contain the code for features that
    /// the scene lacks, unless that code would trace more rays or change bits of the picture.
    pub fn specialisation(&self, full: bool) -> Specialisation {
        let requires = &self.requirements;
        Specialisation {
            has_specular: full || requires.specular,
            has_smooth_normals: full || requires.smooth_normals,
            has_textures: full || requires.textures,
            has_specular_textures: full || requires.specular_textures,
            has_deep_textures: full || requires.deep_textures,
            has_emissive_textures: full || requires.emissive_textures,
            has_alpha: full || requires.alpha,
            // This code would trace more rays.
            has_blend: requires.blending,
            has_blended_lights: requires.blended_lights,
            has_normal_maps: full || requires.normal_maps,
            has_unlit: full || requires.unlit,
            // This code would trace more rays.
            has_culled: requires.culled,
            // Where no material has a layer, there is no buffer to read.
            has_coat: requires.coat,
            has_anisotropy: requires.anisotropy,
            has_transmission: requires.transmission,
            has_environment: full || requires.environment,
            has_punctual_lights: full || requires.punctual_lights > 0,
            has_vertex_colors: full || requires.vertex_colors,
            // Not in motion, where a point keeps its weights while the plane changes.
            has_large_triangles: requires.large_triangles && !self.moves(),
            has_double_sided_lights: full || requires.double_sided_emitters,
            // This code would read more memory.
            surfaces_named: requires.named_surfaces,
            stack_size: self.stack_size,
            moves: self.moves(),
            previous_root: self.previous_root(),
            ..Specialisation::default()
        }
    }
}
