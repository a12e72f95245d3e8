//! Specialisation constants: values that the scene and the settings decide, by which code that is not needed is removed from
//! a shader before the driver compiles it.

use crate::{Format, HashGrid, Mis, PILOT_WORDS, PixelOrder, Visibility, WorldReservoirs};

crate::gpu_specialisation! {
    /// The values of the specialisation constants of a pass. In GLSL, the constant of a field has the field's name in
    /// capitals, and the index of the field as `constant_id`.
    pub struct Specialisation {
        /// Number of entries of the stack with which the compute tracer traverses trees: as many as the deepest path through
        /// the tree over the instances and the tree of a mesh needs.
        pub stack_size: u32 = 32,
        /// True if some surface has a specular lobe; false leaves only Lambert surfaces.
        pub has_specular: bool = true,
        /// True if some mesh has interpolated shading normals; false leaves only flat triangles.
        pub has_smooth_normals: bool = true,
        /// True if some material has a texture of base colour, metalness or roughness.
        pub has_textures: bool = true,
        /// True if some emissive triangle has a texture that multiplies its emission.
        pub has_emissive_textures: bool = true,
        /// True if some surface has holes (alpha mode mask) or covers only a part (alpha mode blend), so that rays may pass
        /// it.
        pub has_alpha: bool = true,
        /// True if some surface has alpha mode blend: visibility rays then return a fraction of light, and more of them are
        /// traced.
        pub has_blend: bool = false,
        /// True if some material has a normal map.
        pub has_normal_maps: bool = true,
        /// True if some material is unlit: the camera sees its base colour as radiance, and all other rays see black.
        pub has_unlit: bool = true,
        /// True if the scene has an environment, a light that surrounds it at infinite distance.
        pub has_environment: bool = true,
        /// True if the scene has punctual lights: point, spot or directional lights.
        pub has_punctual_lights: bool = true,
        /// True if some mesh has vertex colours.
        pub has_vertex_colors: bool = true,
        /// True if path samples store a point of a triangle as coordinates in the triangle's plane, which are more precise
        /// on very large triangles than barycentric weights. It changes the bits of the picture.
        pub has_large_triangles: bool = false,
        /// True if some emissive triangle emits to both sides.
        pub has_double_sided_lights: bool = true,
        /// True if something besides the camera moves. Then the lights and instances of the previous frame follow those of
        /// the current frame in the same buffers.
        pub moves: bool = false,
        /// Index in the buffer `nodes` of the root of the previous frame's tree over the instances; 0 if nothing moves.
        pub previous_root: u32 = 0,
        /// True if the BSDF adds the energy that its model of single scattering loses, mainly on rough metals.
        pub energy_compensated: bool = false,
        /// The format of reservoirs in memory: the compact one reads more from the scene, the full one needs more memory.
        pub reservoir_format: Format = Format::Compact,
        /// True if word n of all reservoirs is contiguous in memory (structure of arrays); false if all words of one
        /// reservoir are. It changes the speed only.
        pub reservoir_soa: bool = false,
        /// The order of pixels in buffers with one entry per pixel. It changes the locality of memory access, never the
        /// picture.
        pub pixel_order: PixelOrder = PixelOrder::Row,
        /// Side in pixels of the square tiles of `PixelOrder::Swizzle`; unused with other orders.
        pub swizzle: u32 = 4,
        /// True if reservoirs also store the pixel that drew their sample and their number of neighbours, for debug AOVs.
        pub keeps_debug_words: bool = false,
        /// True if the pass counts rays, lanes, neighbours and memory traffic for profiles, which costs time. Faults are
        /// counted always.
        pub counting: bool = false,
        /// Index, in the buffer of counters, of the first counter of the pass.
        pub first_counter: u32 = 0,
        /// True if a separate pass has traced the first BSDF candidate of direct light of each pixel, its pilot.
        pub pilots: bool = false,
        /// Distance in words from the pilot of one pixel (its stored first BSDF ray) to that of the next pixel. Where pilots
        /// are stored in reservoirs of indirect light, it is the size of such a reservoir.
        pub pilot_stride: u32 = PILOT_WORDS,
        /// The MIS weights with which a merge weighs the reservoirs that could have drawn a sample.
        pub mis: Mis = Mis::Defensive,
        /// The step of resampling at which shadow rays test samples. It decides on bias, noise and the number of rays.
        pub visibility: Visibility = Visibility::Weights,
        /// Maximum number of neighbours of a spatial merge; it is the length of arrays in the shader.
        pub neighbours: u32 = 3,
        /// True if rare lights have separate candidates and are not resampled with the other lights. Rare lights are those
        /// that are far dimmer than the others.
        pub rare_lights: bool = false,
        /// True if light samples are drawn from the light BVH, a tree that finds the lights that matter at a point.
        pub light_bvh: bool = false,
        /// True if light samples of direct light come from light lists, which one pixel of each tile draws from the light
        /// BVH.
        pub light_lists: bool = false,
        /// The surfaces that fill the hash grid, which keeps reservoirs of direct light in cells of space; `None` if the
        /// pass merges no reservoirs of a hash grid.
        pub hash_grid: HashGrid = HashGrid::None,
        /// The way in which vertices of indirect paths reuse light samples of vertices of the previous frame; `None` if they
        /// do not.
        pub world_reservoirs: WorldReservoirs = WorldReservoirs::None,
        /// True if the pass stores candidates of indirect light in reservoirs for reuse; false if it adds their light to the
        /// picture at once, as a path tracer does.
        pub uses_reservoirs: bool = true,
        /// True if the radiance that leaves a path's second vertex is assumed to be equal for all viewers, which is cheaper
        /// but biased.
        pub biased_shift: bool = false,
    }
}

impl Specialisation {
    /// The constants as pairs of `constant_id` and value, as Vulkan expects them.
    pub fn words(&self) -> Vec<(u32, u32)> {
        let constants = self.constants().into_iter();
        constants.map(|c| (c.id, c.word)).collect()
    }
}
