//! Specialisation constants.

use crate::{Format, HashGrid, Mis, PILOT_WORDS, PixelOrder, Visibility, WorldReservoirs};

crate::gpu_specialisation! {
    /// The specialisation constants of a pass.
    pub struct Specialisation {
        /// The number of entries of the stack of the traversal in compute: the depth of the scene's trees.
        pub stack_size: u32 = 32,
        /// True if some surface has a specular lobe; otherwise all surfaces are Lambert.
        pub has_specular: bool = true,
        /// True if some mesh has shading normals.
        pub has_smooth_normals: bool = true,
        /// True if some material has textures of base colour, metalness or roughness.
        pub has_textures: bool = true,
        /// True if some light has a texture.
        pub has_emissive_textures: bool = true,
        /// True if some surface has holes or covers only a part.
        pub has_alpha: bool = true,
        /// True if some surface covers only a part.
        pub has_blend: bool = false,
        /// True if some material has a normal map.
        pub has_normal_maps: bool = true,
        /// True if some material is unlit.
        pub has_unlit: bool = true,
        /// True if there is an environment.
        pub has_environment: bool = true,
        /// True if there are punctual lights.
        pub has_punctual_lights: bool = true,
        /// True if some mesh has vertex colours.
        pub has_vertex_colors: bool = true,
        /// True if points of triangles are stored as coordinates in the triangle's plane instead of barycentric weights.
        pub has_large_triangles: bool = false,
        /// True if some light emits to both sides.
        pub has_double_sided_lights: bool = true,
        /// True if something besides the camera moves. Then lights and instances of the previous frame follow
        /// those of the current frame in their buffers.
        pub moves: bool = false,
        /// Root of the previous frame's tree over the instances.
        pub previous_root: u32 = 0,
        /// True if the energy that single scattering loses is compensated.
        pub energy_compensated: bool = false,
        /// The contents of reservoirs.
        pub reservoir_format: Format = Format::Compact,
        /// True if equal words of all reservoirs are side by side, instead of the words of one reservoir.
        pub reservoir_soa: bool = false,
        /// The order of pixels in buffers.
        pub pixel_order: PixelOrder = PixelOrder::Row,
        /// Side of a tile, in pixels, with `PixelOrder::Swizzle`.
        pub swizzle: u32 = 4,
        /// True if reservoirs store the origin of their samples and the number of neighbours, for debug AOVs.
        pub keeps_debug_words: bool = false,
        /// True if a pass counts rays, lanes and neighbours.
        pub counting: bool = false,
        /// Index of the pass's first counter.
        pub first_counter: u32 = 0,
        /// True if the first BSDF candidate of direct light is the pilot.
        pub pilots: bool = false,
        /// The distance from one pixel's pilot to the next, in words.
        pub pilot_stride: u32 = PILOT_WORDS,
        /// The MIS weights of a merge.
        pub mis: Mis = Mis::Defensive,
        /// The step at which visibility is tested.
        pub visibility: Visibility = Visibility::Weights,
        /// The maximum number of neighbours of a spatial merge.
        pub neighbours: u32 = 3,
        /// True if rare lights have separate candidates.
        pub rare_lights: bool = false,
        /// True if light samples are drawn from the light BVH.
        pub light_bvh: bool = false,
        /// True if light samples of direct light come from light lists.
        pub light_lists: bool = false,
        /// The surfaces that fill the hash grid, if candidates of direct light come from there.
        pub hash_grid: HashGrid = HashGrid::None,
        /// The way in which vertices of paths reuse light samples of other vertices.
        pub world_reservoirs: WorldReservoirs = WorldReservoirs::None,
        /// True if candidates of indirect light are stored in reservoirs; otherwise the pass is a path tracer.
        pub shares: bool = true,
        /// True if the radiance that leaves a path's second vertex is assumed to be equal for all viewers.
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
