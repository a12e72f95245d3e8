#pragma once
// Textures and vertex colours. There is one level of detail: what a lookup returns depends on the point alone, not on
// who looks, so that every technique sees the same material.
#include "scene/geometry.glsl"

// A coordinate within one period of the image, with clamping one near the image, so that indices fit an integer. Huge
// coordinates can become infinities and NaN: they give 0 or, with clamping, the edge.
float within_period(float x, uint wrap) {
    float period = wrap == WRAP_MIRROR ? 2.0 : 1.0;
    x = wrap == WRAP_CLAMP ? clamp(x, -1.0, 2.0) : x - period * floor(x / period);
    return x >= -1.0 && x <= 2.0 ? x : 0.0;
}

// The index of the texel that is seen at index `i`.
int wrapped(int i, int size, uint wrap) {
    int period = wrap == WRAP_MIRROR ? 2 * size : size;
    if (wrap != WRAP_CLAMP) i += i < 0 ? period : i >= period ? -period : 0;
    if (wrap == WRAP_MIRROR) i = min(i, period - 1 - i);
    // Without clamping too: of an image of one texel, the neighbour of the neighbour may be asked for.
    return clamp(i, 0, size - 1);
}

#if TEXTURE_IMAGES
uniform texture2D images[];
#endif

// The bytes of a texel. An image gives a byte as the nearest float to a 255th of it, from which it is recovered exactly:
// so both bodies give the same bits whatever follows.
uint texel_bytes(GpuTexture used, uint x, uint y) {
#if TEXTURE_IMAGES
    return packUnorm4x8(texelFetch(images[nonuniformEXT(used.index)], ivec2(x, y), 0));
#else
    return texels.at[used.index + y * used.width + x];
#endif
}

// From a table before the texels, because drivers differ in powers.
float linear_of_srgb(uint byte) { return uintBitsToFloat(texels.at[byte]); }

// The same for a 16-bit value, from the table that follows.
float linear_of_deep_srgb(uint value) { return uintBitsToFloat(texels.at[256u + value]); }

// A texel of an image with 16 bits per channel, which has two words: for the high and the low bytes.
vec4 deep_texel_at(GpuTexture used, uint x, uint y, bool is_color) {
    used.width *= 2u;
    uvec4 high = uvec4(texel_bytes(used, 2u * x, y)), low = uvec4(texel_bytes(used, 2u * x + 1u, y));
    uvec4 shift = uvec4(0u, 8u, 16u, 24u);
    uvec4 value = (high >> shift & 0xFFu) << 8u | (low >> shift & 0xFFu);
    if (!is_color) return vec4(value) / 65535.0;
    return vec4(linear_of_deep_srgb(value.r), linear_of_deep_srgb(value.g), linear_of_deep_srgb(value.b),
                float(value.a) / 65535.0);
}

// A texel. Colours are sRGB, and decoded before they are mixed.
vec4 texel_at(GpuTexture used, ivec2 i, uvec2 wrap, bool is_color) {
    int x = wrapped(i.x, int(used.width), wrap.x), y = wrapped(i.y, int(used.height), wrap.y);
    if (HAS_DEEP_TEXTURES) {
        if ((used.flags & TEXTURE_DEEP) != 0u) return deep_texel_at(used, uint(x), uint(y), is_color);
    }
    uint texel = texel_bytes(used, uint(x), uint(y));
    if (!is_color) return unpackUnorm4x8(texel);
    return vec4(linear_of_srgb(texel & 0xFFu), linear_of_srgb((texel >> 8u) & 0xFFu), linear_of_srgb((texel >> 16u) & 0xFFu),
                float(texel >> 24u) / 255.0);
}

bool interpolates(GpuTexture used) {
    if (HAS_DEEP_TEXTURES) return (used.flags & TEXTURE_NEAREST) == 0u;
    // There is no other flag.
    return used.flags == 0u;
}

// A texture at texture coordinates.
vec4 texture_at(GpuTexture used, vec2 uv, bool is_color) {
    uvec2 wrap = uvec2(used.wrap & 3u, used.wrap >> 2u);
    vec2 at = used.column_u * uv.x + used.column_v * uv.y + used.offset;
    at = vec2(within_period(at.x, wrap.x), within_period(at.y, wrap.y)) * vec2(used.width, used.height);
    // Centres of texels are at halves.
    if (interpolates(used)) at -= 0.5;
    vec2 corner = floor(at), part = interpolates(used) ? at - corner : vec2(0.0);
    vec4 rows[2];
    for (int y = 0; y < 2; y += 1) {
        ivec2 i = ivec2(corner) + ivec2(0, y);
        rows[y] = mix(texel_at(used, i, wrap, is_color), texel_at(used, i + ivec2(1, 0), wrap, is_color), part.x);
    }
    return mix(rows[0], rows[1], part.y);
}

// The texture coordinates at a point of a triangle, which is given by the weights of the second and third corner.
vec2 uv_at(GpuInstance instance, uint primitive, vec2 weights, uint set) {
    uint first = 3u * ((set == 0u ? instance.first_uvs.x : instance.first_uvs.y) + primitive);
    vec2 a = uvs.at[first];
    return a + weights.x * (uvs.at[first + 1u] - a) + weights.y * (uvs.at[first + 2u] - a);
}

// One of the three colours of a triangle with vertex colours.
vec3 corner_color(uint index) {
    uvec2 packed = colors.at[index];
    return vec3(unpackUnorm2x16(packed.x), unpackUnorm2x16(packed.y).x);
}

float corner_alpha(uint index) { return unpackUnorm2x16(colors.at[index].y).y; }

// Whether materials differ from point to point.
const bool VARIES = HAS_TEXTURES || HAS_SPECULAR_TEXTURES || HAS_VERTEX_COLORS || HAS_NORMAL_MAPS || HAS_LAYERS;

// A material with its textures and vertex colours at a point of a triangle.
GpuMaterial with_textures(GpuMaterial material, GpuInstance instance, uint primitive, vec2 weights) {
    if (HAS_VERTEX_COLORS && instance.first_color != NONE) {
        uint first = 3u * (instance.first_color + primitive);
        vec3 a = corner_color(first), b = corner_color(first + 1u), c = corner_color(first + 2u);
        // A hit of a ray query may lie outside of its triangle by a rounding error.
        material.base_color *= max(a + weights.x * (b - a) + weights.y * (c - a), vec3(0.0));
        material.flags |= MATERIAL_VARIES;
    }
    if (!HAS_TEXTURES) return material;
    if (material.base_color_texture != NONE) {
        GpuTexture used = load_textures(material.base_color_texture);
        material.base_color *= texture_at(used, uv_at(instance, primitive, weights, used.set), true).rgb;
        material.flags |= MATERIAL_VARIES;
    }
    if (material.metallic_roughness_texture != NONE) {
        GpuTexture used = load_textures(material.metallic_roughness_texture);
        vec4 found = texture_at(used, uv_at(instance, primitive, weights, used.set), false);
        material.roughness *= found.g;
        material.metallic *= found.b;
    }
    return material;
}

bool has_specular_textures(GpuMaterial material) {
    return HAS_SPECULAR_TEXTURES && (material.flags & (MATERIAL_SPECULAR_TEXTURE | MATERIAL_SPECULAR_COLOR_TEXTURE)) != 0u;
}

// A material with its textures of the dielectric's specular reflection (KHR_materials_specular).
GpuMaterial with_specular_textures(GpuMaterial material, GpuInstance instance, uint primitive, vec2 weights) {
    uint index = material.flags >> MATERIAL_SPECULAR_SHIFT;
    if ((material.flags & MATERIAL_SPECULAR_TEXTURE) != 0u) {
        GpuTexture used = load_textures(index);
        material.dielectric_f90 *= texture_at(used, uv_at(instance, primitive, weights, used.set), false).a;
        index += 1u;
    }
    if ((material.flags & MATERIAL_SPECULAR_COLOR_TEXTURE) != 0u) {
        GpuTexture used = load_textures(index);
        material.dielectric_f0 *= texture_at(used, uv_at(instance, primitive, weights, used.set), true).rgb;
    }
    material.dielectric_f0 = min(material.dielectric_f0, vec3(1.0)) * material.dielectric_f90;
    return material;
}

// The material at a point of a triangle, as it reflects light.
GpuMaterial material_at(uint index, GpuInstance instance, uint primitive, vec2 weights) {
    GpuMaterial material = with_textures(material_at(index), instance, primitive, weights);
    if (has_specular_textures(material)) material = with_specular_textures(material, instance, primitive, weights);
    return material;
}
