//! The elements of a scene as shaders read them: instances, materials, textures, lights, and nodes of the light BVH.
//! Positions are relative to the scene's origin; lengths and radiance are in the units of the device.

use glam::{UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// A mesh that is placed in the world by an affine transform.
    pub struct GpuInstance {
        /// Columns of the 3×4 transform from the stored positions of the mesh to the world: three axes, then the
        /// translation.
        pub object_to_world: [Vec3; 4],
        /// Columns of the 3×4 transform from the world to the stored positions of the mesh: three axes, then the
        /// translation.
        pub world_to_object: [Vec3; 4],
        /// Index in the buffer `positions`, in triangles, of the mesh's first triangle.
        pub first_triangle: u32,
        /// Index in the buffer `corner_directions`, in triangles, of the mesh's first corner normals; NONE for flat shading.
        pub first_normal: u32,
        /// Index in the buffer `triangle_parts`, in triangles, of the mesh's first triangle; NONE if the mesh has one
        /// material and no lights.
        pub first_part: u32,
        /// Index in the buffer `nodes` of the root of the mesh's tree, which the compute tracer traverses.
        pub root_node: u32,
        /// Index of the material of all triangles, for a mesh without entries in `triangle_parts`.
        pub material: u32,
        /// Index in the buffer `lights` of the instance's first emissive triangle; NONE if it emits no light.
        pub first_light: u32,
        /// Index of the instance in the scene before meshes are merged, as the AOV `instance` shows it.
        pub id: u32,
        /// Index in the buffer `uvs`, in triangles, of the mesh's first triangle, for the first and the second set of
        /// texture coordinates; NONE for a missing set.
        pub first_uvs: UVec2,
        /// Index in the buffer `colors`, in triangles, of the mesh's first triangle; NONE for a mesh without vertex colours.
        pub first_color: u32,
        /// Index in the buffer `corner_directions`, in triangles, of the mesh's first corner tangents; NONE without normal
        /// maps.
        pub first_tangent: u32,
        /// Unused; it makes the size a multiple of four words, as `load_instances` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The values of a surface's BSDF, its textures and its alpha, at an index in the buffer `materials`.
    pub struct GpuMaterial {
        /// Linear RGB base colour in [0, 1]: the albedo of the diffuse lobe, and the reflectance of a metal. With
        /// MATERIAL_UNLIT, it is the radiance that the camera sees.
        pub base_color: Vec3,
        /// Metalness in [0, 1]: 0 is a dielectric, 1 is a metal, and values between them mix the two.
        pub metallic: f32,
        /// Reflectance of the dielectric at normal incidence, RGB in [0, 1].
        pub dielectric_f0: Vec3,
        /// Reflectance of the dielectric at grazing incidence, in [0, 1].
        pub dielectric_f90: f32,
        /// Perceptual roughness in [0, 1]; its square is the width α of the GGX lobe.
        pub roughness: f32,
        /// Index in the buffer `textures` of the texture that multiplies base colour and alpha; NONE without such a texture.
        pub base_color_texture: u32,
        /// Index in the buffer `textures` of the texture that multiplies roughness (green) and metalness (blue); NONE
        /// without one.
        pub metallic_roughness_texture: u32,
        /// Bit mask of MATERIAL_UNLIT and MATERIAL_VARIES.
        pub flags: u32,
        /// Index in the buffer `textures` of the normal map, which bends the shading normal; NONE without one.
        pub normal_texture: u32,
        /// Factor of the red and green components of the normal map; 0 leaves the shading normal as it is.
        pub normal_scale: f32,
        /// The alpha mode: ALPHA_OPAQUE, ALPHA_MASK or ALPHA_BLEND.
        pub alpha_mode: u32,
        /// With ALPHA_BLEND, the coverage in [0, 1], which texture and vertex colour multiply. With ALPHA_MASK, the
        /// threshold: the surface exists where the product of texture and vertex alpha is at least this value.
        pub alpha: f32,
    }
}

crate::gpu_struct! {
    /// One use of an image by a material: where its texels are, and how texture coordinates select them.
    pub struct GpuTexture {
        /// First column of the 2×2 matrix that transforms texture coordinates; in the result, [0, 1] spans the image.
        pub column_u: Vec2,
        /// Second column of the 2×2 matrix that transforms texture coordinates.
        pub column_v: Vec2,
        /// Translation that is added to the transformed texture coordinates; 1 is the width or the height of the image.
        pub offset: Vec2,
        /// Index of the image's first texel in the buffer `texels`. In variants of a shader that sample images instead of
        /// reading this buffer, it is the index of the image.
        pub index: u32,
        /// Width of the image in texels.
        pub width: u32,
        /// Height of the image in texels.
        pub height: u32,
        /// Index of the mesh's set of texture coordinates that the texture uses: 0 or 1.
        pub set: u32,
        /// Wrap modes beyond the edges of the image: WRAP_… along u, plus 4 times WRAP_… along v.
        pub wrap: u32,
        /// 1: a lookup returns the nearest texel; 0: it interpolates between the four nearest texels.
        pub nearest: u32,
    }
}

crate::gpu_struct! {
    /// An emissive triangle in world space, as light samples and hits on emitters read it.
    pub struct GpuLight {
        /// Position of the first corner, relative to the scene's origin, in device units.
        pub corner: Vec3,
        /// Vector from the first corner to the second one.
        pub edge1: Vec3,
        /// Vector from the first corner to the third one.
        pub edge2: Vec3,
        /// Unit normal on the emitting side; for a triangle that emits to both sides, on either of them.
        pub normal: Vec3,
        /// Emitted radiance, RGB, in the device's unit; a texture of the light multiplies it.
        pub emission: Vec3,
        /// Area of the triangle, in the square of the device's unit of length. Its inverse is the density of a uniform
        /// point.
        pub area: f32,
        /// 1 if the triangle emits on both sides, 0 if only on the side of `normal`.
        pub double_sided: u32,
        /// Index in the buffer `instances` of the instance that the triangle belongs to.
        pub instance: u32,
        /// Index of the triangle in the mesh of its instance, for a look-up of alpha; NONE if the triangle has no holes.
        pub primitive: u32,
        /// Unused; it makes the size a multiple of four words, as `load_lights` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A light without an area: a point, spot or directional light (`KHR_lights_punctual`).
    pub struct GpuPunctualLight {
        /// Position of a point or spot light, relative to the scene's origin, in device units; without meaning for a
        /// directional light.
        pub position: Vec3,
        /// Kind of the light: LIGHT_POINT, LIGHT_SPOT or LIGHT_DIRECTIONAL.
        pub kind: u32,
        /// Unit direction in which light travels: along the axis of a spot light's cone, or everywhere for a directional
        /// light.
        pub direction: Vec3,
        /// Distance at which the light fades to 0, in the device's unit of length; 0: it has no limit.
        pub range: f32,
        /// Intensity, RGB: radiance × squared length in device units. For a directional light, the irradiance of a surface
        /// that faces it.
        pub intensity: Vec3,
        /// Constant of a spot's falloff. The emitted fraction of the intensity is (`angle_offset` − `angle_scale` · d²)²,
        /// with the base clamped to [0, 1]; d is the distance between the unit vectors along the axis and towards the
        /// shading point.
        pub angle_offset: f32,
        /// Factor of d² in a spot's falloff; the formula is at `angle_offset`. A larger factor narrows the border of the
        /// cone.
        pub angle_scale: f32,
        /// Unused; it makes the size a multiple of four words, as `load_punctual_lights` in the shaders requires.
        pub padding: UVec3,
    }
}

crate::gpu_struct! {
    /// One column of an alias table, which draws a light among all lights in constant time: a uniform random number selects
    /// a column, and 32 more random bits select one of the column's two lights.
    pub struct GpuLightChoice {
        /// The total probability, in [0, 1], with which the table selects the light that has the index of this column.
        pub probability: f32,
        /// Threshold of the 32 random bits: below it, the light with the index of this column is selected, otherwise
        /// `alias`.
        pub keep_below: u32,
        /// The index, among lights of all kinds, of the column's second light.
        pub alias: u32,
        /// Unused; it makes the size a multiple of four words, as `load_light_choices` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The texture of an emissive triangle, at the index of that triangle in the buffer `lights`.
    pub struct GpuLightTexture {
        /// Texture coordinates of the triangle's first corner.
        pub uv: Vec2,
        /// Difference of the texture coordinates from the first corner to the second one.
        pub edge1: Vec2,
        /// Difference of the texture coordinates from the first corner to the third one.
        pub edge2: Vec2,
        /// Index in the buffer `textures` of the texture that multiplies the emission; NONE for a triangle without one.
        pub texture: u32,
        /// Unused; it makes the size a multiple of four words, as `load_light_textures` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The motion of an instance since the previous frame, by which temporal reuse and motion vectors find the same surface
    /// point.
    pub struct GpuPreviousTransform {
        /// Columns of the 3×4 transform from current to previous world positions of the instance's points: three axes, then
        /// the translation.
        pub current_to_previous: [Vec3; 4],
    }
}

crate::gpu_struct! {
    /// A node of the light BVH. Nodes are in depth-first order, so a walk needs no stack: it visits the next node if the
    /// node's box holds the point, and otherwise skips the node's descendants.
    pub struct GpuLightNode {
        /// Smallest coordinates of the box that a walk tests: the bounds of the lights, enlarged by their range of
        /// influence.
        pub low: Vec3,
        /// Index of the node after the last descendant, at which a walk continues that skips this node; for a leaf, the next
        /// node.
        pub next: u32,
        /// Largest coordinates of the box that a walk tests; see `low`.
        pub high: Vec3,
        /// Index of the node's first light among the lights of the BVH, which are in the order of the leaves.
        pub first: u32,
        /// Centre of the box around the node's lights, which is not enlarged.
        pub center: Vec3,
        /// Total power of the node's lights, as area × luminance in device units; if lights are drawn uniformly, their
        /// number.
        pub weight: f32,
        /// Mean of the lights' unit normals, weighted by power: its length is below 1 if they face different directions.
        pub normal: Vec3,
        /// Half the diagonal of the box around the node's lights, in the device's unit of length.
        pub size: f32,
        /// Number of the node's lights; they follow each other from `first` on.
        pub count: u32,
        /// Length of the mean normal `normal`, in [0, 1]; 0 if the lights emit in all directions.
        pub facing: f32,
        /// Unused; it makes the size a multiple of four words, as `load_light_node` in the shaders requires.
        pub padding: UVec2,
    }
}

crate::gpu_struct! {
    /// One element of two arrays of the light BVH that share an index. The first array (`light`, `before`) has the lights of
    /// the BVH in the order of its leaves. The second array (`leaf`, `index`) has the position of each light of the scene in
    /// the BVH.
    pub struct GpuLightEntry {
        /// First array, by index in the BVH: the index of this light among lights of all kinds.
        pub light: u32,
        /// First array, by index in the BVH: the first of the consecutive integers that select this light; the next light's
        /// integers follow. The more integers a light has, the more likely it is drawn from its node.
        pub before: u32,
        /// Second array, by index among lights of all kinds: the index of the leaf node that holds the light; NONE if none
        /// does.
        pub leaf: u32,
        /// Second array, by index among lights of all kinds: the index of the light in the BVH, that is, in the first array.
        pub index: u32,
    }
}

crate::gpu_struct! {
    /// A slot of the hash grid, which keeps reservoirs of direct light in cells of space. A slot holds the reservoir of at
    /// most one surface per frame.
    pub struct GpuGridSlot {
        /// Index of the surface that has claimed the slot, plus 1, in the low bits, and random bits above them; 0: the slot
        /// is free. The largest claim wins, so the order of threads does not matter.
        pub claim: u32,
        /// Hash of the cell of space and of the bin of normals that the slot's reservoir belongs to; readers compare it with
        /// their own.
        pub key: u32,
    }
}

crate::gpu_struct! {
    /// A surface point with a reservoir of direct light, which surfaces near it reuse: in the hash grid or as a world
    /// reservoir.
    pub struct GpuGridPoint {
        /// Position of the point, relative to the scene's origin, in device units.
        pub position: Vec3,
        /// Unit geometric normal on the visible side, in octahedral coordinates of 16 bits each.
        pub normal: u32,
    }
}
