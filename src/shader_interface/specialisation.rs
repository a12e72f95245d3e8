//! Specialisation constants: constants of a shader whose values depend on the scene and the settings. The program sets the
//! values when it loads the shader, and removes the code that they make unnecessary before the driver compiles the shader.

use crate::{
    CameraModel, Format, HashGrid, Mis, PILOT_WORDS, PixelOrder, Visibility, WorldReservoirs,
};

crate::gpu_specialisation! {
    /// The values of the specialisation constants of a pass (a compute shader). They decide which code of the pass is
    /// removed because the scene and the settings do not need it. In GLSL, each field is a constant whose name is the
    /// field's name in capitals, and whose `constant_id` is the index of the field, counted from 0.
    pub struct Specialisation {
        /// Number of entries of the stack on which the compute tracer stores the groups of nodes that it visits later. It
        /// suffices for the deepest path through the tree over the instances and then the tree of a mesh. Shaders with ray
        /// queries do not use it.
        pub stack_size: u32 = 32,
        /// True if some surface has a specular lobe; if false, shaders treat all surfaces as Lambert surfaces.
        pub has_specular: bool = true,
        /// True if some mesh has normals at its vertices, which shaders interpolate; if false, they use the normals of the
        /// flat triangles.
        pub has_smooth_normals: bool = true,
        /// True if some material has a texture of base colour, metalness or roughness, or of a layer such as a clear coat; if
        /// false, shaders do not read such textures.
        pub has_textures: bool = true,
        /// True if some material has a texture of its specular reflection (`KHR_materials_specular`); if false, shaders do
        /// not read such textures.
        pub has_specular_textures: bool = true,
        /// True if some image has 16 bits per channel; if false, shaders read one word per texel and do not test for two.
        pub has_deep_textures: bool = true,
        /// True if some emissive triangle has a texture that multiplies its emission; if false, the emission is constant
        /// over each triangle.
        pub has_emissive_textures: bool = true,
        /// True if some surface has holes (alpha mode mask) or covers only a fraction of each point (alpha mode blend). Rays
        /// can pass through such a surface, so shaders then test the alpha of each hit.
        pub has_alpha: bool = true,
        /// True if some surface has alpha mode blend and lets a fraction of light pass. Visibility rays then return this fraction instead of only 0 or 1. With `Visibility::Weights`, shaders trace one
        /// more ray when they add the light of a selected sample to the picture, and multiply the light by this fraction.
        pub has_blend: bool = false,
        /// True if such a surface emits light. Light samples then find the light of its triangles, and BSDF rays do not.
        pub has_blended_lights: bool = false,
        /// True if some material or its clear coat has a normal map; if false, shaders do not read normal maps and tangents.
        pub has_normal_maps: bool = true,
        /// True if some material is unlit: the camera sees its base colour as radiance, and all other rays see black. If
        /// false, shaders do not test for unlit materials.
        pub has_unlit: bool = true,
        /// True if the camera looks through the back of some surface. Its rays then go on behind such a hit. If false, shaders
        /// do not test for this.
        pub has_culled: bool = false,
        /// True if some surface has a clear coat, a second specular lobe on top of the others.
        pub has_coat: bool = false,
        /// True if some surface has a specular lobe that is wider in one direction; if false, shaders treat all specular
        /// lobes as equally wide in all directions.
        pub has_anisotropy: bool = false,
        /// True if light passes through some surface by refraction or as through a thin sheet (`KHR_materials_transmission`);
        /// if false, shaders treat all surfaces as opaque, apart from alpha.
        pub has_transmission: bool = false,
        /// True if the scene has an environment, a light that surrounds it at infinite distance; if false, rays that leave
        /// the scene find no light.
        pub has_environment: bool = true,
        /// True if the scene has punctual lights (point, spot or directional lights); if false, the code for them is left
        /// out.
        pub has_punctual_lights: bool = true,
        /// True if some mesh has vertex colours, which multiply the base colour of its material; if false, shaders do not
        /// read them.
        pub has_vertex_colors: bool = true,
        /// True if nothing moves and some triangle is so large, compared with the typical size of instances, that
        /// barycentric weights in 32-bit floats are too coarse to locate a point on it. Samples of indirect light then store
        /// a point of any triangle as coordinates in the triangle's plane, which are more precise. This changes the bits of
        /// the picture.
        pub has_large_triangles: bool = false,
        /// True if some emissive triangle emits to both sides; if false, shaders assume that all emit to their front only.
        pub has_double_sided_lights: bool = true,
        /// True if something besides the camera moves. Then the buffers of lights and instances hold all elements of the
        /// current frame and after them all elements of the previous frame, so that shaders can also compute light and
        /// visibility as they were in the previous frame.
        pub moves: bool = false,
        /// True if the stored primary surface of a pixel names its triangle and a point on it. Shaders then read material,
        /// textures and the corners of the triangle again from the scene. If false, it stores the index of the material and
        /// what textures change of it, which is faster to read.
        pub surfaces_named: bool = false,
        /// Index, in the buffer `nodes`, of the root of the tree over the instances as they were in the previous frame. The
        /// compute tracer uses it to test visibility in that frame. 0 if nothing moves.
        pub previous_root: u32 = 0,
        /// True if the BSDF corrects two errors of energy of its specular lobe: rough metals lose light that is scattered
        /// more than once, and bright dielectrics gain light at grazing angles.
        pub energy_compensated: bool = false,
        /// The contents of a reservoir in memory. The compact format needs less memory; shaders then read position, normal
        /// and other data of a sample from the scene. The full format stores these data in the reservoir.
        pub reservoir_format: Format = Format::Compact,
        /// True if the words with the same index in all reservoirs are adjacent in memory (structure of arrays); false if
        /// the words of one reservoir are adjacent (array of structures). It changes the speed only.
        pub reservoir_soa: bool = false,
        /// The order of pixels in buffers with one entry per pixel, such as reservoirs: by rows, by columns or by square
        /// tiles. It changes the locality of memory access, never the picture.
        pub pixel_order: PixelOrder = PixelOrder::Row,
        /// Side in pixels of the square tiles of `PixelOrder::Swizzle`; other orders do not use it.
        pub swizzle: u32 = 4,
        /// True if reservoirs store three more words for debug AOVs, additional channels of a picture that show the reuse of
        /// samples. The words are the index of the pixel that drew the sample, the solid angle per unit of the sample's
        /// measure (such as area) seen from that pixel's surface, and the number of neighbours that the spatial passes of
        /// the frame found.
        pub keeps_debug_words: bool = false,
        /// True if the pass counts rays, lanes in use, merged neighbours and memory traffic for profiles, which costs time.
        /// Faults, such as rejected values, are counted even if this is false.
        pub counting: bool = false,
        /// Index of the pass's first counter in the buffer of counters. All passes share this buffer. Each pass writes to a
        /// separate range of it, so that reports can state the counts of each pass.
        pub first_counter: u32 = 0,
        /// True if a separate pass has traced the pilot of each pixel, which is the pixel's first BSDF ray, and has stored
        /// its hit. The pass of direct light then reads this hit as its first BSDF candidate.
        pub pilots: bool = false,
        /// Distance in 32-bit words from the pilot of one pixel (the stored hit of its first BSDF ray) to the pilot of the
        /// next pixel in the buffer. Where reservoirs of indirect light hold the pilots, it is the size of such a reservoir.
        /// Shaders do not use it if `reservoir_soa` is true.
        pub pilot_stride: u32 = PILOT_WORDS,
        /// The kind of MIS weights with which a pixel merges its reservoir with those of its neighbours and of the previous
        /// frame. They divide the contribution of a sample among the reservoirs that could have drawn it. The kind affects
        /// the cost, the noise and the bias of the merge.
        pub mis: Mis = Mis::Defensive,
        /// The step of resampling at which shadow rays test whether a sample is visible from the shading point. It affects
        /// the bias, the noise and the number of rays.
        pub visibility: Visibility = Visibility::Weights,
        /// Maximum number of neighbours that a pixel has in one spatial merge, which merges their reservoirs with the
        /// pixel's own. The size of arrays in the shader follows from it: one element for each neighbour and one for the
        /// pixel itself.
        pub neighbours: u32 = 3,
        /// True if rare lights, which are far dimmer than the others, are sampled separately. For direct light, each pixel
        /// draws one additional candidate from the rare lights only. It is not resampled, because brighter lights would win
        /// against it even where they are hidden. For indirect light, a fraction of the path vertices, selected at random,
        /// sample rare lights only. All other light samples leave rare lights out.
        pub rare_lights: bool = false,
        /// True if some of the light samples at a shading point are drawn from the light BVH, a tree over
        /// lights. A light is drawn from the tree more often if it is expected to contribute more light at
        /// that point. The other samples are drawn from an alias table for the whole scene.
        pub light_bvh: bool = false,
        /// True if pixels take those samples of direct light that would be drawn from the light BVH (a tree over lights)
        /// from light lists instead. One pixel of each tile, a square of pixels, draws the tile's list from the tree. Each
        /// pixel then takes samples from the list of its own tile or of a tile beside it, selected at random.
        pub light_lists: bool = false,
        /// The source of the surface points that fill the hash grid: pixels of the frame or a list of points. The hash grid
        /// stores reservoirs of direct light in cells of space, and pixels in a cell merge these with their own light
        /// samples. `None` if the pass uses no hash grid.
        pub hash_grid: HashGrid = HashGrid::None,
        /// The way in which vertices of indirect paths reuse light samples that vertices of the previous frame drew in the
        /// same cell of space. `None` if they do not reuse them.
        pub world_reservoirs: WorldReservoirs = WorldReservoirs::None,
        /// True if the pass that traces paths of indirect light keeps one path per pixel in a reservoir, so that pixels can
        /// reuse it; false if it adds the light of its paths to the picture at once, as a path tracer does.
        pub uses_reservoirs: bool = true,
        /// True if pixels that reuse a path take over the radiance that leaves its second vertex (the first one after the
        /// surface that the pixel shows), as if it were equal in all directions. This is cheaper than evaluating the BSDF at
        /// this vertex again, but it gives a bias if the surface there is glossy.
        pub biased_shift: bool = false,
        /// The model of the camera, which decides where primary rays begin and where they go.
        pub camera_model: CameraModel = CameraModel::Pinhole,
        /// True if the picture has an alpha channel. The camera then does not see the environment, and passes count the
        /// samples of each pixel whose primary ray meets a surface.
        pub tracks_coverage: bool = false,
    }
}

impl Specialisation {
    /// All constants as pairs of `constant_id` and value, in the order of the fields. The program sets them in the SPIR-V of
    /// a pass. The value is one 32-bit word: the number itself for a `u32`, 0 or 1 for a `bool`, and the index of the Rust
    /// variant for an enumeration.
    pub fn words(&self) -> Vec<(u32, u32)> {
        let constants = self.constants().into_iter();
        constants.map(|c| (c.id, c.word)).collect()
    }
}
