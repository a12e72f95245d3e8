//! The elements of a scene as shaders read them from buffers: instances, materials, textures, lights, and nodes of the light
//! BVH. Positions in world space are relative to the scene's origin. Lengths and radiance are in the units of the device,
//! which are powers of two of the scene's units.

use glam::{UVec2, UVec3, Vec2, Vec3};

crate::gpu_struct! {
    /// A mesh that an affine transform places in the world. The same mesh can have several instances. When a ray hits an
    /// instance, shaders find with these data the triangle's vertices, material and light.
    pub struct GpuInstance {
        /// Columns of the 3×4 matrix that transforms the stored positions of the mesh to world space: three axes, then the
        /// translation. Stored positions are those in the buffer `positions`; a mesh of extreme size is stored scaled, and a
        /// mesh far from its own origin is stored translated, so that f32 is precise enough.
        pub object_to_world: [Vec3; 4],
        /// Columns of the 3×4 matrix that transforms positions in world space to the space of the mesh's
        /// stored positions (those in the buffer `positions`): three axes, then the translation. The compute
        /// tracer transforms rays with it, and shaders transform normals to world space with its transpose.
        pub world_to_object: [Vec3; 4],
        /// Index of the mesh's first triangle in the buffer `positions`, counted in triangles; the mesh's other triangles
        /// follow.
        pub first_triangle: u32,
        /// Index of the normals of the mesh's first triangle in the buffer `corner_directions`, counted in triangles. NONE
        /// for a mesh without corner normals, which is shaded flat.
        pub first_normal: u32,
        /// Index of the mesh's first triangle in the buffer `triangle_parts`, counted in triangles. Shaders
        /// find the material, light and instance of each triangle there. NONE if the mesh has only one
        /// material, none of its triangles emits light, and it was not merged from several meshes; `material`
        /// is then sufficient.
        pub first_part: u32,
        /// Index, in the buffer `nodes`, of the root of the tree over the mesh's triangles. The compute tracer traverses
        /// this tree; 0 if the driver builds the trees (ray query).
        pub root_node: u32,
        /// Index in the buffer `materials` of the material of all triangles. It is used only if `first_part` is NONE;
        /// otherwise `triangle_parts` has the material of each triangle.
        pub material: u32,
        /// Index in the buffer `lights` of the instance's first emissive triangle; its other emissive triangles follow. NONE
        /// if the instance emits no light.
        pub first_light: u32,
        /// Index of the instance in the scene, as the AOV `instance` shows it. If meshes of several instances were merged
        /// into this one, the index can differ from triangle to triangle: it is this number plus the triangle's offset in
        /// `triangle_parts`.
        pub id: u32,
        /// Indices of the mesh's first triangle in the buffer `uvs`, counted in triangles: x for the first set of texture
        /// coordinates, y for the second one. NONE for a set that the mesh does not have.
        pub first_uvs: UVec2,
        /// Index of the mesh's first triangle in the buffer `colors`, counted in triangles; NONE for a mesh without vertex
        /// colours.
        pub first_color: u32,
        /// Index of the tangents of the mesh's first triangle in the buffer `corner_directions`, counted in triangles. NONE
        /// if no material of the mesh has a normal map, for which tangents are needed.
        pub first_tangent: u32,
        /// Unused; it makes the size a multiple of four words, as `load_instances` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A material in the buffer `materials`: the values of its BSDF, its textures and its alpha. Shaders compute with it how
    /// the surface at a hit reflects light, and whether a ray passes through.
    pub struct GpuMaterial {
        /// Linear RGB base colour in [0, 1]: the albedo of the diffuse lobe, and the reflectance of a metal. If `flags` has
        /// MATERIAL_UNLIT, it is instead the radiance that the camera sees, in the device's unit.
        pub base_color: Vec3,
        /// Metalness in [0, 1]: 0 is a dielectric, 1 is a metal, and values between 0 and 1 mix the two.
        pub metallic: f32,
        /// Reflectance of the material's specular lobe at normal incidence where it is a dielectric (`metallic` = 0), RGB,
        /// each channel in [0, 1]. Shaders compute the Fresnel term of the lobe from it. With specular textures, it is the
        /// reflectance before `dielectric_f90` multiplies it, and it can be above 1: the colour of the texture comes first,
        /// then the limit of 1, then `dielectric_f90`.
        pub dielectric_f0: Vec3,
        /// Reflectance of the dielectric's specular lobe at grazing incidence, in [0, 1], for the Fresnel term. 0: the
        /// dielectric has no specular lobe.
        pub dielectric_f90: f32,
        /// Perceptual roughness in [0, 1]; its square is the width α of the GGX lobe.
        pub roughness: f32,
        /// Index in the buffer `textures` of the texture that multiplies base colour and alpha; NONE for a material without
        /// such a texture.
        pub base_color_texture: u32,
        /// Index in the buffer `textures` of the texture that multiplies roughness (green channel) and metalness (blue
        /// channel); NONE for a material without such a texture.
        pub metallic_roughness_texture: u32,
        /// Bits MATERIAL_UNLIT, MATERIAL_CULLED, MATERIAL_SPECULAR_TEXTURE, MATERIAL_SPECULAR_COLOR_TEXTURE and
        /// MATERIAL_VARIES. The buffer does not contain the last one; shaders set it in their copy of the material if a
        /// texture or vertex colours change its base colour. The bits from MATERIAL_SPECULAR_SHIFT on are the index in the
        /// buffer `textures` of the first specular texture, if there is one.
        pub flags: u32,
        /// Index in the buffer `textures` of the normal map, which bends the shading normal; NONE for a material without a
        /// normal map.
        pub normal_texture: u32,
        /// Factor by which the red and green components of the normal map are multiplied. A larger factor bends the shading
        /// normal more; 0 does not bend it.
        pub normal_scale: f32,
        /// The way in which alpha makes the surface transparent: ALPHA_OPAQUE, ALPHA_MASK or ALPHA_BLEND.
        pub alpha_mode: u32,
        /// With ALPHA_BLEND, the fraction in [0, 1] that the surface covers; the alpha of texture and vertex colour
        /// multiplies it. With ALPHA_MASK, the threshold: the surface exists where the alpha of the texture times that of
        /// the vertex colour is at least this value. Without meaning for ALPHA_OPAQUE.
        pub alpha: f32,
    }
}

crate::gpu_struct! {
    /// The layers of a material: clear coat, anisotropy, transmission, volume and dispersion, as in the glTF extensions of
    /// these names. In scenes where some material has a layer, those of all materials follow the materials in the buffer
    /// `materials`, because some drivers bind at most 30 buffers. An element has the size of a [`GpuMaterial`].
    pub struct GpuMaterialLayers {
        /// Fraction of the surface that is coated, in [0, 1]; 0: there is no coat. Shaders scale the reflection of the coat
        /// by it.
        pub coat: f32,
        /// Perceptual roughness of the coat in [0, 1]; its square is the width α of the coat's GGX lobe.
        pub coat_roughness: f32,
        /// Strength of the anisotropy in [0, 1]; 0: the specular lobe has the same width in all directions. Along its
        /// direction, the width of the lobe is mixed with 1 by the square of the strength.
        pub anisotropy: f32,
        /// Angle from the tangent, or from the direction of the anisotropy texture, to the direction in which the specular lobe
        /// is wider, towards the bitangent. In turns, in [0, 1].
        pub anisotropy_turns: f32,
        /// Absorption coefficient of the volume per RGB channel, in 1 over the device's unit of length: light that travels the
        /// distance d is multiplied by exp(−absorption · d). It is finite. All channels are −1 if the surface is a thin sheet
        /// without a volume.
        pub absorption: Vec3,
        /// Index of refraction of the dielectric, at least 1, or 0 if it reflects all light. Transmitted light is refracted
        /// by it.
        pub ior: f32,
        /// Fraction in [0, 1] of the light that the dielectric does not reflect and that passes through the surface; 0: the
        /// diffuse lobe gets all of it.
        pub transmission: f32,
        /// Strength of the dispersion of the volume, at least 0: 20 divided by the Abbe number. 0: all colours have the same
        /// index of refraction.
        pub dispersion: f32,
        /// Index in the buffer `textures` of the texture whose red channel multiplies `coat`; NONE without such a texture.
        pub coat_texture: u32,
        /// Index in the buffer `textures` of the texture whose green channel multiplies `coat_roughness`; NONE without one.
        pub coat_roughness_texture: u32,
        /// Index in the buffer `textures` of the coat's normal map; NONE: the coat has the normal of the mesh.
        pub coat_normal_texture: u32,
        /// Factor by which the red and green components of the coat's normal map are multiplied; 0 does not bend the normal.
        pub coat_normal_scale: f32,
        /// Index in the buffer `textures` of the texture whose red and green channels are the direction of the anisotropy in
        /// the tangent frame, and whose blue channel multiplies `anisotropy`; NONE without such a texture.
        pub anisotropy_texture: u32,
        /// Index in the buffer `textures` of the texture whose red channel multiplies `transmission`; NONE without one.
        pub transmission_texture: u32,
    }
}

crate::gpu_struct! {
    /// A texture: one use of an image by a material. It states where the texels of the image are stored, and
    /// how texture coordinates are converted to positions in the image. Shaders need it to read the image at
    /// a point of a surface.
    pub struct GpuTexture {
        /// First column of the 2×2 matrix that transforms texture coordinates of the mesh to coordinates of the image, in
        /// which the image covers [0, 1] along both axes.
        pub column_u: Vec2,
        /// Second column of the 2×2 matrix that transforms texture coordinates of the mesh to coordinates of the image.
        pub column_v: Vec2,
        /// Translation that is added to the product of the 2×2 matrix and the mesh's texture coordinates. The sum is
        /// coordinates of the image, in which the image covers [0, 1] along both axes.
        pub offset: Vec2,
        /// Index of the image's first texel in the buffer `texels`. If shaders sample an array of Vulkan images instead of
        /// reading this buffer (`Textures::Images`), it is the index of the image in that array.
        pub index: u32,
        /// Width of the image in texels. Shaders multiply coordinates of the image by it to find texels.
        pub width: u32,
        /// Height of the image in texels. Shaders multiply coordinates of the image by it to find texels.
        pub height: u32,
        /// The set of texture coordinates of the mesh that the texture uses: 0 for the first one, 1 for the second one.
        pub set: u32,
        /// Wrap mode (WRAP_…) along u, plus 4 times the wrap mode along v. Wrap modes select the texel that
        /// shaders read if a coordinate of the image is outside of [0, 1].
        pub wrap: u32,
        /// Bits TEXTURE_…: the filter of the texture, and the number of bits per channel of its image.
        pub flags: u32,
    }
}

crate::gpu_struct! {
    /// An emissive triangle in world space. Shaders read it when they draw a point on it, and when a ray hits it.
    pub struct GpuLight {
        /// Position of the emissive triangle's first corner in world space, relative to the scene's origin,
        /// in the device's unit of length. Points on the triangle are `corner` + u · `edge1` + v · `edge2`,
        /// where u and v are barycentric weights.
        pub corner: Vec3,
        /// Vector in world space from the emissive triangle's first corner to its second one, in the device's unit of
        /// length. Shaders compute points on the triangle with it.
        pub edge1: Vec3,
        /// Vector in world space from the emissive triangle's first corner to its third one, in the device's unit of length.
        /// Shaders compute points on the triangle with it.
        pub edge2: Vec3,
        /// Unit normal of the emissive triangle in world space, on the side that emits. If the triangle emits
        /// to both sides, it is the normal of one of the sides. Shaders compute the cosine at the light with
        /// it.
        pub normal: Vec3,
        /// Emitted radiance, RGB, in the device's unit of radiance. If the light has a texture (`GpuLightTexture`), the
        /// texture multiplies it.
        pub emission: Vec3,
        /// Area of the triangle, in the square of the device's unit of length. The density per area of a point that is drawn
        /// uniformly on the triangle is one over this area.
        pub area: f32,
        /// 1: the triangle emits to both sides; 0: it emits only to the side of `normal`.
        pub double_sided: u32,
        /// Index in the buffer `instances` of the instance to which the triangle belongs. Shaders need it to
        /// look up alpha if the material has an alpha mode.
        pub instance: u32,
        /// Index of the triangle among the triangles of its instance's mesh, if its material has the alpha mode ALPHA_MASK
        /// or ALPHA_BLEND; otherwise NONE. Shaders need it to look up alpha, because the triangle emits only where, and by
        /// as much as, it covers.
        pub primitive: u32,
        /// 1: light passes through a part of the triangle (ALPHA_BLEND with an alpha below 1); otherwise 0.
        pub blended: u32,
    }
}

crate::gpu_struct! {
    /// A light without an area: a point, spot or directional light, as in the glTF extension `KHR_lights_punctual`. Shaders
    /// compute from it how much light arrives at a point.
    pub struct GpuPunctualLight {
        /// Position of a point or spot light, relative to the scene's origin, in the device's unit of length. Without
        /// meaning for a directional light.
        pub position: Vec3,
        /// Kind of the light: LIGHT_POINT, LIGHT_SPOT or LIGHT_DIRECTIONAL. It decides which of the other
        /// fields have a meaning.
        pub kind: u32,
        /// Unit direction in world space in which light travels. For a spot light it is the direction of the axis; for a
        /// directional light, light travels in this direction at every point. Without meaning for a point light.
        pub direction: Vec3,
        /// Distance, in the device's unit of length, at which the light of a point or spot light has faded to 0. If it is 0,
        /// the light has no such limit.
        pub range: f32,
        /// Strength of the light, RGB. For a point or spot light it is the radiant intensity, in the device's unit of
        /// radiance times the square of its unit of length; divided by the square of the distance it gives the irradiance.
        /// For a directional light it is the irradiance of a surface that faces the light, in the device's unit of radiance.
        pub intensity: Vec3,
        /// Constant in the formula for the border of a spot light: towards a shading point the light emits the fraction
        /// (`angle_offset` − `angle_scale` · d²)² of its intensity. The value in parentheses is clamped to [0, 1]. d is the
        /// distance between the ends of two unit vectors: the direction of the light's axis, and the direction from the
        /// light to the shading point.
        pub angle_offset: f32,
        /// Factor of d² in the formula for the border of a spot light; d and the formula are explained at `angle_offset`. A
        /// larger factor makes the transition from light to dark narrower.
        pub angle_scale: f32,
        /// Unused; it makes the size a multiple of four words, as `load_punctual_lights` in the shaders requires.
        pub padding: UVec3,
    }
}

crate::gpu_struct! {
    /// One column of an alias table, with which shaders draw a light in constant time. Random bits select a column
    /// uniformly; 32 more random bits then select one of the two lights of the column. The first light has the index of the
    /// column. If the scene has rare lights (lights far dimmer than the others), there are three tables: of all lights, of
    /// the lights that are not rare, and of the rare lights.
    pub struct GpuLightChoice {
        /// The total probability, in [0, 1], that a draw from the alias table selects the light whose index is the index of
        /// this column. It includes draws of other columns, in which the light is the second one. MIS and contribution
        /// weights use it as the density of a light sample.
        pub probability: f32,
        /// Threshold for the choice between the two lights of this column. If 32 random bits, as an unsigned number, are
        /// below it, the light with the index of this column is selected, otherwise the light `alias`.
        pub keep_below: u32,
        /// Index, among lights of all kinds, of the second light of this column of the alias table. A draw selects it if its
        /// random bits are not below `keep_below`.
        pub alias: u32,
        /// Unused; it makes the size a multiple of four words, as `load_light_choices` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The texture of the emission of one emissive triangle, from which shaders compute the radiance at a point of the
    /// triangle. It has the same index in its buffer as the triangle in the buffer `lights`.
    pub struct GpuLightTexture {
        /// Texture coordinates (u, v) of the first corner of the emissive triangle. Shaders interpolate the
        /// texture coordinates of a point on the triangle from this field, `edge1` and `edge2`.
        pub uv: Vec2,
        /// Texture coordinates of the emissive triangle's second corner minus those of its first corner.
        pub edge1: Vec2,
        /// Texture coordinates of the emissive triangle's third corner minus those of its first corner.
        pub edge2: Vec2,
        /// Index in the buffer `textures` of the texture that multiplies the emission; NONE for a triangle whose emission
        /// has no texture.
        pub texture: u32,
        /// Unused; it makes the size a multiple of four words, as `load_light_textures` in the shaders requires.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// The motion of one instance, as a transform from the current to the previous frame. With it, temporal reuse and motion
    /// vectors find where a point of a surface was in the previous frame.
    pub struct GpuPreviousTransform {
        /// Columns of the 3×4 matrix that transforms world positions of the instance's points in the current frame to those
        /// of the previous frame: three axes, then the translation.
        pub current_to_previous: [Vec3; 4],
    }
}

crate::gpu_struct! {
    /// A node of the light BVH: a tree over the lights of a scene, from which shaders draw lights with a probability that
    /// depends on the point that receives the light. Nodes are stored in depth-first order, so a walk through the tree needs
    /// no stack: if the box of a node contains the point, the walk continues at the next node, otherwise after the node's
    /// last descendant.
    pub struct GpuLightNode {
        /// Smallest coordinates, in world space and in the device's unit of length, of a box that is larger than the box
        /// around the node's lights. A walk through the light BVH tests whether the point that receives light is inside the
        /// larger box. If `RestirConstants::light_bvh_joins` is 1, the node's lights are drawn as one group at points
        /// outside of it. If it is 0, they are not drawn there, because they contribute little.
        pub low: Vec3,
        /// Index of the node after this node's last descendant. A walk through the light BVH continues there if it skips the
        /// descendants of this node. For a leaf it is the index of the next node.
        pub next: u32,
        /// Largest coordinates, in world space and in the device's unit of length, of the enlarged box whose
        /// smallest coordinates are `low`.
        pub high: Vec3,
        /// Index of the node's first light in the list of the lights of the BVH, which is in the order of the leaves
        /// (`light` and `before` of `GpuLightEntry`). Shaders draw one of the node's lights from this list.
        pub first: u32,
        /// Centre of the box around the node's lights, in world space, in the device's unit of length. Shaders use it as the
        /// position of all these lights to estimate what the node contributes at a point. The box is not the enlarged one of
        /// `low` and `high`.
        pub center: Vec3,
        /// Power of all lights in the node: the sum of area × luminance, in the device's unit of radiance times the square
        /// of its unit of length. The expected contribution of the node at a point, and thus the probability to draw the
        /// node, is proportional to it. If `RestirConstants::light_bvh_uniform` is 1, the field is instead the number of the
        /// node's lights.
        pub weight: f32,
        /// Mean of the unit normals of the node's lights, weighted by their power, from which shaders estimate how much
        /// light leaves towards a point. Its length is below 1 if the lights face different directions.
        pub normal: Vec3,
        /// Half the diagonal of the box around the node's lights, in the device's unit of length. Lights may be beside the
        /// centre of this box, so shaders use larger cosines and wider lobes for a larger box when they estimate what the
        /// node contributes. The box is not the enlarged one of `low` and `high`.
        pub size: f32,
        /// Number of the lights in this node of the light BVH, including those of its descendants. Their indices in the list
        /// of the lights of the BVH are consecutive and begin with `first`.
        pub count: u32,
        /// Length, in [0, 1], of `normal`, the mean of the normals of the node's lights. Shaders use it to estimate how much
        /// light leaves the node towards a point. 1: all lights face the same direction; 0: the lights together emit about
        /// equally in all directions.
        pub facing: f32,
        /// Unused; it makes the size a multiple of four words, as `load_light_node` in the shaders requires.
        pub padding: UVec2,
    }
}

crate::gpu_struct! {
    /// One entry of the light BVH. It holds one element each of two independent arrays. The first array
    /// (`light`, `before`) lists the lights of the BVH in the order of its leaves; shaders draw a light from
    /// it. The second array (`leaf`, `index`) has one element per light of the scene; shaders compute with it
    /// the probability that a given light is drawn.
    pub struct GpuLightEntry {
        /// Index, among the scene's lights of all kinds, of a light in the light BVH; a draw that selects this element
        /// returns it. The field belongs to the first array, which has one element per light in the BVH, in the order of the
        /// leaves.
        pub light: u32,
        /// The smallest random integer that selects the light `light`, when shaders draw one of a node's lights by a random
        /// integer. The integers of the light end before the `before` of the next element, so a light with more integers is
        /// drawn more often. The field belongs to the first array, which has one more element after the last light.
        pub before: u32,
        /// Index of the leaf node of the light BVH that contains the light. Shaders compute from it the probability that a
        /// draw from the light BVH selects this light. NONE for a light outside of the BVH, such as the environment; its
        /// probability is 0. The field belongs to the second array, which has one element per light of the scene, in the
        /// order of the lights.
        pub leaf: u32,
        /// Index in the first array of the light to which `leaf` belongs. With the `before` of this element
        /// and of the next one, shaders compute how often the light is drawn among the lights of its leaf.
        /// This field belongs to the second array, like `leaf`. Without meaning for a light outside of the
        /// BVH.
        pub index: u32,
    }
}

crate::gpu_struct! {
    /// A slot of the hash grid, which stores reservoirs of direct light in cells of space, so that pixels in a cell can
    /// reuse them. Each slot can store one reservoir. Several surfaces may claim a slot, which means that they ask to fill
    /// it; one of them fills it.
    pub struct GpuGridSlot {
        /// Number by which a surface claims the slot; 0: no surface claims it. The low bits are the index of the surface
        /// plus 1, the bits above them are random. If several surfaces claim the slot, the largest number wins, so that the
        /// result does not depend on the order of threads. Pixels that merge the slot's reservoir find its surface by this
        /// number.
        pub claim: u32,
        /// Hash of the cell of space and the bin of normals to which the slot's reservoir belongs. Several cells may use the
        /// same slot, so pixels merge the reservoir only if the hash of their own cell and bin is equal.
        pub key: u32,
    }
}

crate::gpu_struct! {
    /// The surface point for which a reservoir of direct light was made. Surfaces near the point reuse this reservoir, which
    /// is a reservoir of the hash grid or a world reservoir (a reservoir of a path vertex). To compute unbiased MIS weights,
    /// a merge evaluates at this point how probable a sample was.
    pub struct GpuGridPoint {
        /// Position in world space of the surface point that stores the reservoir, relative to the scene's origin, in the
        /// device's unit of length.
        pub position: Vec3,
        /// Unit geometric normal in world space of the surface at the point, on its visible side. It is stored as two
        /// octahedral coordinates of 16 bits each.
        pub normal: u32,
    }
}
