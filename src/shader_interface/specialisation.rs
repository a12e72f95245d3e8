//! Specialisation constants.

use crate::{Format, HashGrid, Mis, PILOT_WORDS, PixelOrder, Visibility, WorldReservoirs};

crate::gpu_specialisation! {
    /// What the shaders of a pass are specialised by.
    pub struct Specialisation {
        /// Entries of the stack of the traversal in compute: the depth of the scene's trees.
        pub stack_size: u32 = 32,
        /// Whether some surface has a specular lobe; otherwise all are Lambert.
        pub has_specular: bool = true,
        /// Whether some mesh has shading normals.
        pub has_smooth_normals: bool = true,
        /// Whether some material has textures of base colour, metalness or roughness.
        pub has_textures: bool = true,
        /// Whether some light has a texture.
        pub has_emissive_textures: bool = true,
        /// Whether some surface has holes or covers only a part.
        pub has_alpha: bool = true,
        /// Whether some surface covers only a part.
        pub has_blend: bool = false,
        /// Whether some material has a normal map.
        pub has_normal_maps: bool = true,
        /// Whether some material is unlit.
        pub has_unlit: bool = true,
        /// Whether there is an environment.
        pub has_environment: bool = true,
        /// Whether there are punctual lights.
        pub has_punctual_lights: bool = true,
        /// Whether some mesh has vertex colours.
        pub has_vertex_colors: bool = true,
        /// Whether points of triangles are stored as coordinates in the triangle's plane instead of barycentric weights.
        pub has_large_triangles: bool = false,
        /// Whether some light emits to both sides.
        pub has_double_sided_lights: bool = true,
        /// Whether something besides the camera moves. Then lights and instances of the previous frame follow
        /// those of the current frame in their buffers.
        pub moves: bool = false,
        /// Root of the previous frame's tree over the instances.
        pub previous_root: u32 = 0,
        /// Whether the energy that single scattering loses is compensated.
        pub energy_compensated: bool = false,
        /// What reservoirs store.
        pub reservoir_format: Format = Format::Compact,
        /// Whether equal words of all reservoirs are side by side, instead of the words of one reservoir.
        pub reservoir_soa: bool = false,
        /// The order of pixels in buffers.
        pub pixel_order: PixelOrder = PixelOrder::Row,
        /// Side of a tile, in pixels, with `PixelOrder::Swizzle`.
        pub swizzle: u32 = 4,
        /// Whether reservoirs store the origin of their samples and the number of neighbours, for debug AOVs.
        pub keeps_debug_words: bool = false,
        /// Whether a pass counts rays, lanes and neighbours.
        pub counting: bool = false,
        /// Index of the pass's first counter.
        pub first_counter: u32 = 0,
        /// Whether the first BSDF candidate of direct light is the pilot.
        pub pilots: bool = false,
        /// Words from one pixel's pilot to the next.
        pub pilot_stride: u32 = PILOT_WORDS,
        /// How a merge weighs its techniques.
        pub mis: Mis = Mis::Defensive,
        /// Where visibility enters.
        pub visibility: Visibility = Visibility::Weights,
        /// Maximum number of neighbours of a spatial merge.
        pub neighbours: u32 = 3,
        /// True if rare lights are left to candidates of their own.
        pub rare_lights: bool = false,
        /// Whether light samples are drawn from the light BVH.
        pub light_bvh: bool = false,
        /// Whether those of direct light come from light lists.
        pub light_lists: bool = false,
        /// What fills the hash grid, if some of direct light come from there.
        pub hash_grid: HashGrid = HashGrid::None,
        /// How vertices of paths reuse light samples of other vertices.
        pub world_reservoirs: WorldReservoirs = WorldReservoirs::None,
        /// Whether candidates of indirect light go to reservoirs; otherwise the pass is a path tracer.
        pub shares: bool = true,
        /// Whether the radiance that leaves a path's second vertex is taken to be the same for all viewers.
        pub biased_shift: bool = false,
    }
}

impl Specialisation {
    /// Pairs of id and value, for Vulkan.
    pub fn words(&self) -> Vec<(u32, u32)> {
        let constants = self.constants().into_iter();
        constants.map(|c| (c.id, c.word)).collect()
    }
}
