//! The elements of a scene: instances, materials, textures and lights.

use glam::{UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// A mesh placed in the world, relative to the scene's origin.
    pub struct GpuInstance {
        /// Columns of the 3×4 object-to-world transform.
        pub object_to_world: [Vec3; 4],
        /// Columns of the 3×4 world-to-object transform.
        pub world_to_object: [Vec3; 4],
        /// First triangle of its mesh in the position array.
        pub first_triangle: u32,
        /// First triangle of its mesh with normals in the array of corner directions, or NONE for flat shading.
        pub first_normal: u32,
        /// First triangle of its mesh in the part array, or NONE if the mesh has one material.
        pub first_part: u32,
        /// Root of its mesh in the node array.
        pub root_node: u32,
        /// Material of a mesh of one part.
        pub material: u32,
        /// The light of its first emissive triangle, or NONE.
        pub first_light: u32,
        /// Index of this instance in the scene, as the AOV shows it.
        pub id: u32,
        /// First triangle of its mesh in the array of texture coordinates, for each of two sets; or NONE.
        pub first_uvs: UVec2,
        /// First triangle of its mesh in the array of vertex colours, or NONE.
        pub first_color: u32,
        /// First triangle of its mesh with tangents in the array of corner directions, or NONE.
        pub first_tangent: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A surface's material.
    pub struct GpuMaterial {
        /// Linear base colour; with MATERIAL_UNLIT radiance.
        pub base_color: Vec3,
        /// Metalness in [0, 1]: 0 is a dielectric, 1 a metal.
        pub metallic: f32,
        /// Reflectance of the dielectric at normal incidence.
        pub dielectric_f0: Vec3,
        /// Reflectance of the dielectric at grazing incidence.
        pub dielectric_f90: f32,
        /// Perceptual roughness.
        pub roughness: f32,
        /// Texture that multiplies the base colour, or NONE.
        pub base_color_texture: u32,
        /// Texture that multiplies roughness and metalness, or NONE.
        pub metallic_roughness_texture: u32,
        /// The flags MATERIAL_….
        pub flags: u32,
        /// Texture that turns the shading normal, or NONE.
        pub normal_texture: u32,
        /// Factor of the normal texture's red and green components.
        pub normal_scale: f32,
        /// The alpha mode, ALPHA_….
        pub alpha_mode: u32,
        /// The coverage, which texture and vertex colours multiply; with ALPHA_MASK the smallest product of these that is
        /// covered.
        pub alpha: f32,
    }
}

crate::gpu_struct! {
    /// An image as a material uses it.
    pub struct GpuTexture {
        /// First column of the 2×2 part of the transform from texture coordinates to those of the image.
        pub column_u: Vec2,
        /// Second column.
        pub column_v: Vec2,
        /// The translation.
        pub offset: Vec2,
        /// Index of the image's first texel in the array of texels or, where images are sampled, of the image itself.
        pub index: u32,
        /// Width in texels.
        pub width: u32,
        /// Height in texels.
        pub height: u32,
        /// The set of texture coordinates, 0 or 1.
        pub set: u32,
        /// The wrap modes: WRAP_… along u, plus 4 times WRAP_… along v.
        pub wrap: u32,
        /// 1 if a lookup takes the nearest texel, 0 if it interpolates between four.
        pub nearest: u32,
    }
}

crate::gpu_struct! {
    /// An emissive triangle in world space.
    pub struct GpuLight {
        /// First corner.
        pub corner: Vec3,
        /// The vector from the first corner to the second.
        pub edge1: Vec3,
        /// The vector from the first corner to the third.
        pub edge2: Vec3,
        /// Unit normal of the emitting side.
        pub normal: Vec3,
        /// Emitted radiance.
        pub emission: Vec3,
        /// Area, in the unit of length on the device.
        pub area: f32,
        /// 1 if it emits on both sides, otherwise 0.
        pub double_sided: u32,
        /// The traced instance that it belongs to.
        pub instance: u32,
        /// The index of the light's triangle in the mesh of that instance, if it may have holes; otherwise NONE.
        pub primitive: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A punctual light.
    pub struct GpuPunctualLight {
        /// Position; without meaning for a directional light.
        pub position: Vec3,
        /// LIGHT_POINT, LIGHT_SPOT or LIGHT_DIRECTIONAL.
        pub kind: u32,
        /// The unit direction in which a spot is aimed or directional light travels.
        pub direction: Vec3,
        /// The distance up to which it reaches; 0: no limit.
        pub range: f32,
        /// The intensity; for a directional light, the irradiance of a surface that faces it.
        pub intensity: Vec3,
        /// The offset of a spot's falloff: the square root of the emitted fraction of the intensity is this offset minus the
        /// product of `angle_scale` and a squared distance, clamped to [0, 1].
        pub angle_offset: f32,
        /// The factor of the squared distance between the unit vectors along the spot's axis and to the shading point.
        pub angle_scale: f32,
        /// Fills the last four words.
        pub padding: UVec3,
    }
}

crate::gpu_struct! {
    /// One column of the alias table that selects lights of all kinds by power.
    pub struct GpuLightChoice {
        /// The probability of the light with the column's index.
        pub probability: f32,
        /// The threshold below which 32 random bits select that light.
        pub keep_below: u32,
        /// The index of the light that is selected otherwise.
        pub alias: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A texture on a light.
    pub struct GpuLightTexture {
        /// Texture coordinates of the first corner.
        pub uv: Vec2,
        /// The difference of texture coordinates from the first corner to the second.
        pub edge1: Vec2,
        /// The difference of texture coordinates from the first corner to the third.
        pub edge2: Vec2,
        /// The texture that multiplies its emission, or NONE.
        pub texture: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The transform from the present positions of an instance's points to the previous frame's.
    pub struct GpuPreviousTransform {
        /// Columns of the 3×4 transform from current to previous world positions.
        pub current_to_previous: [Vec3; 4],
    }
}

crate::gpu_struct! {
    /// A node of the light BVH. Nodes are in depth-first order: a walk visits the next node if a node's box holds the point,
    /// and otherwise skips its descendants.
    pub struct GpuLightNode {
        /// The smallest coordinates of the box.
        pub low: Vec3,
        /// The index of the node after the last descendant; for a leaf, this is the next node.
        pub next: u32,
        /// The largest coordinates of the box.
        pub high: Vec3,
        /// The index of its first light among the BVH's lights.
        pub first: u32,
        /// The centre of the box around its lights.
        pub center: Vec3,
        /// The power of its lights or, if they are drawn uniformly, their number.
        pub weight: f32,
        /// The mean of their normals, weighted by power: shorter than 1 if they face different directions.
        pub normal: Vec3,
        /// Half the diagonal of the box around its lights.
        pub size: f32,
        /// Number of its lights.
        pub count: u32,
        /// The length of the mean normal, at most 1.
        pub facing: f32,
        /// Fills the last four words.
        pub padding: UVec2,
    }
}

crate::gpu_struct! {
    /// An element of two arrays of the light BVH, which are stored side by side. The first array has its lights, in the order
    /// of its leaves; a light of a node is drawn with the probability of its fraction of the node's integers. The second array
    /// has the location of each light, by its index among the lights of all kinds.
    pub struct GpuLightEntry {
        /// For the light at this position in the BVH: its index among the lights of all kinds.
        pub light: u32,
        /// For the light at this position in the BVH: the first of the integers that select it; those of the next light follow.
        pub before: u32,
        /// For the light with this index: the leaf of its cluster; NONE if it belongs to none.
        pub leaf: u32,
        /// For the light with this index: its index among the lights of the BVH.
        pub index: u32,
    }
}

crate::gpu_struct! {
    /// A slot of the hash grid.
    pub struct GpuGridSlot {
        /// The index of the surface that has claimed it, plus 1, with random bits above; 0: no surface.
        pub claim: u32,
        /// The key of its cell and bin.
        pub key: u32,
    }
}

crate::gpu_struct! {
    /// A point of a surface at which a reservoir is made, for surfaces close to it.
    pub struct GpuGridPoint {
        /// The position.
        pub position: Vec3,
        /// Unit geometric normal on the visible side, octahedral.
        pub normal: u32,
    }
}
