#pragma once
// Primary surfaces: packed by the first pass, unpacked into shading points by later passes and by the next frame.
#include "core/counters.glsl"
#include "scene/shading_point.glsl"

// Bits of each octahedral coordinate of a normal. With 16 bits a mirror's reflections would shift, by 9 pixels where the
// field of view is one degree.
const uint NORMAL_BITS = 22u;
const float NORMAL_STEPS = float((1u << (NORMAL_BITS - 1u)) - 1u);
// What of the second coordinate does not fit into the word of the first.
const uint NORMAL_REST = 2u * NORMAL_BITS - 32u;

// Both normals, and the exponent of the clearance, rounded up.
uvec3 pack_normals(vec3 geometric_normal, vec3 shading_normal, float clearance) {
    vec4 e = vec4(octahedral_coordinates(geometric_normal), octahedral_coordinates(shading_normal));
    uvec4 steps = uvec4(round((e + 1.0) * NORMAL_STEPS));
    uvec2 words = steps.xz | (steps.yw << NORMAL_BITS), rest = steps.yw >> (32u - NORMAL_BITS);
    uint exponent = min((floatBitsToUint(clearance) >> 23u) + 1u, 254u);
    return uvec3(words, rest.x | (rest.y << NORMAL_REST) | (exponent << 24u));
}

vec3 unpack_normal(uint word, uint rest) {
    const uint mask = (1u << NORMAL_BITS) - 1u;
    uvec2 steps = uvec2(word & mask, (word >> NORMAL_BITS) | ((rest & ((1u << NORMAL_REST) - 1u)) << (32u - NORMAL_BITS)));
    // From integers around 0, because floats are finest there.
    return octahedral_direction(vec2(ivec2(steps) - int(NORMAL_STEPS)) / NORMAL_STEPS);
}

vec3 geometric_normal(SampleData data) { return unpack_normal(data.packed_normals.x, data.packed_normals.z); }

vec3 shading_normal(SampleData data) { return unpack_normal(data.packed_normals.y, data.packed_normals.z >> NORMAL_REST); }

// In the word of the material: the viewer is on the back of the surface.
const uint VIEWED_FROM_BACK = 0x80000000u;

// What textures and vertex colours change of a material: the square roots of the base colour in 12 bits each, which divide
// dark colours more finely; metalness in 12 bits; roughness in 15; and whether the base colour differs from the material's.
const float COLOR_STEPS = 4095.0;
const float ROUGHNESS_STEPS = 32767.0;

// The square roots of a colour in `steps` steps. Colours are rounded up or down by `numbers` in [0, 1), so that their mean over
// the pixels is exact. Rounding to nearest would make a dark wall of one colour darker or brighter by up to a hundredth, everywhere.
uvec3 color_steps(vec3 color, float steps, vec3 numbers) {
    vec3 below = floor(sqrt(color) * steps);
    vec3 low = square(below / steps), high = square((below + 1.0) / steps);
    uvec3 rounded = uvec3(below) + uvec3(lessThan(numbers * (high - low), color - low));
    // Interpolated vertex colours may be 1 + 1e-7: a step beyond 1 would be carried into the next channel.
    return min(rounded, uint(steps));
}

// A material with specular textures stores more in the same two words: the base colour in 9 bits per channel, metalness in 6,
// roughness in 10, and what the textures leave of the specular reflection (6) and of its colour (5 per channel). All but the
// roughness are rounded by random numbers, one for all channels of the colour: grey stays grey.
const float COARSE_COLOR_STEPS = 511.0;
const float COARSE_STEPS = 63.0;
const float COARSE_ROUGHNESS_STEPS = 1023.0;
const float TINT_STEPS = 31.0;

uvec2 pack_specular_material(GpuMaterial material, uint index, vec3 numbers) {
    GpuMaterial plain = material_at(index);
    vec4 more = to_unit(pcg4d(uvec4(floatBitsToUint(numbers), 1u)));
    uvec3 color = color_steps(material.base_color, COARSE_COLOR_STEPS, numbers);
    vec3 left = material.dielectric_f0 / max(min(plain.dielectric_f0, vec3(1.0)) * material.dielectric_f90, vec3(TINY));
    uvec3 tint = color_steps(min(left, vec3(1.0)), TINT_STEPS, vec3(more.x));
    float strength = min(material.dielectric_f90 / max(plain.dielectric_f90, TINY), 1.0);
    uint specular = uint(strength * COARSE_STEPS + more.y), metallic = uint(material.metallic * COARSE_STEPS + more.z);
    uint roughness = uint(round(material.roughness * COARSE_ROUGHNESS_STEPS));
    return uvec2(color.x | (color.y << 9u) | (color.z << 18u) | (tint.x << 27u),
                 tint.y | (tint.z << 5u) | (specular << 10u) | (metallic << 16u) | (roughness << 22u));
}

void unpack_specular_material(uvec2 p, inout GpuMaterial material) {
    vec3 root = vec3(p.x & 0x1FFu, (p.x >> 9u) & 0x1FFu, (p.x >> 18u) & 0x1FFu) / COARSE_COLOR_STEPS;
    vec3 tint = vec3(p.x >> 27u, p.y & 0x1Fu, (p.y >> 5u) & 0x1Fu) / TINT_STEPS;
    if (HAS_VERTEX_COLORS || material.base_color_texture != NONE) material.base_color = root * root;
    if (material.metallic_roughness_texture != NONE) {
        material.metallic = float((p.y >> 16u) & 0x3Fu) / COARSE_STEPS;
        material.roughness = float(p.y >> 22u) / COARSE_ROUGHNESS_STEPS;
    }
    material.dielectric_f90 *= float((p.y >> 10u) & 0x3Fu) / COARSE_STEPS;
    material.dielectric_f0 = min(material.dielectric_f0, vec3(1.0)) * tint * tint * material.dielectric_f90;
}

uvec2 pack_material(GpuMaterial material, uint index, vec3 numbers) {
    if (!VARIES) return uvec2(0u);
    if (has_specular_textures(material)) return pack_specular_material(material, index, numbers);
    uvec3 color = color_steps(material.base_color, COLOR_STEPS, numbers);
    uint metallic = uint(round(material.metallic * COLOR_STEPS));
    uint roughness = uint(round(material.roughness * ROUGHNESS_STEPS));
    return uvec2(color.x | (color.y << 12u) | (color.z << 24u),
                 (color.z >> 8u) | (metallic << 4u) | (roughness << 16u) | ((material.flags & MATERIAL_VARIES) != 0u ? 1u << 31u : 0u));
}

// Where surfaces are named, sample data hold the device's instance, the triangle and the barycentric weights of the point.
// Materials, textures and owners of triangles are the same in both epochs.
vec2 named_weights(SampleData data) { return uintBitsToFloat(data.variation_or_weights); }

TriangleOwner named_owner(SampleData data) { return triangle_owner(load_instances(data.instance), data.material_or_primitive); }

uint material_index(SampleData data) {
    if (SURFACES_NAMED) return named_owner(data).material;
    return HAS_TRANSMISSION ? data.material_or_primitive & ~VIEWED_FROM_BACK : data.material_or_primitive;
}

// The material of a primary surface.
GpuMaterial unpack_material(SampleData data) {
    if (SURFACES_NAMED) {
        if (!VARIES) return material_at(material_index(data));
        return material_at(material_index(data), load_instances(data.instance), data.material_or_primitive, named_weights(data));
    }
    GpuMaterial material = material_at(material_index(data));
    if (!VARIES) return material;
    uvec2 p = data.variation_or_weights;
    if (has_specular_textures(material)) {
        unpack_specular_material(p, material);
        return material;
    }
    uvec3 color = uvec3(p.x & 0xFFFu, (p.x >> 12u) & 0xFFFu, (p.x >> 24u) | ((p.y & 0xFu) << 8u));
    vec3 root = vec3(color) / COLOR_STEPS;
    if (p.y >> 31u != 0u) material.base_color = root * root;
    if (material.metallic_roughness_texture != NONE) {
        material.metallic = float((p.y >> 4u) & 0xFFFu) / COLOR_STEPS;
        material.roughness = float((p.y >> 16u) & 0x7FFFu) / ROUGHNESS_STEPS;
    }
    return material;
}

// The layers of a primary surface in an epoch, for a viewer along `direction`.
Layers unpack_layers(SampleData data, vec3 direction, uint epoch) {
    if (!SURFACES_NAMED) return layers_at(material_index(data), (data.material_or_primitive & VIEWED_FROM_BACK) != 0u);
    if (!HAS_LAYERS) return NO_LAYERS;
    GpuInstance instance = instance_at(data.instance, MOVES ? epoch : CURRENT);
    uint primitive = data.material_or_primitive;
    TrianglePoint point = triangle_point(instance, primitive, named_weights(data));
    Layers layers = layers_at(material_index(data), instance, primitive, named_weights(data), point);
    layers.inside = HAS_TRANSMISSION && dot(point.normal, direction) > 0.0;
    if (HAS_COAT_NORMALS) layers.coat_normal = facing_viewer(layers.coat_normal, geometric_normal(data), true, direction);
    return layers;
}

// The surface at a ray's hit. `numbers` in [0, 1) round its colour; a pixel's are the same in every frame, so that a surface at rest
// stays the same.
SampleData pack_sample_data(Surface surface, Hit hit, Ray ray, vec3 numbers) {
    // The depth along the ray: camera, pixel and depth then give the position.
    vec3 normal = surface.geometric_normal;
    float clearance = surface.clearance;
    float depth = depth_along(ray.origin, ray.direction, surface.position, normal, clearance);
    uvec3 normals = pack_normals(normal, surface.shading_normal, clearance);
    if (SURFACES_NAMED) return SampleData(depth, normals, hit.primitive, hit.instance, floatBitsToUint(clamp(hit.barycentrics, 0.0, 1.0)));
    uint material = surface.material_index;
    if (HAS_TRANSMISSION && surface.layers.inside) material |= VIEWED_FROM_BACK;
    return SampleData(depth, normals, material, surface.instance, pack_material(surface.material, surface.material_index, numbers));
}

// Macros, because GLSL cannot pass buffers to functions. Passes that only read sample data read it as texels, two an
// entry: llvmpipe reads buffers word by word, each behind a branch.
#if FETCH_TEXELS
#define SAMPLE_DATA_BUFFER(NAME, BLOCK) uniform utextureBuffer NAME
#define LOAD_SAMPLE_DATA(NAME, SLOT) \
    sample_data_of(texelFetch(NAME, int(2u * (SLOT))), texelFetch(NAME, int(2u * (SLOT) + 1u)))
#else
#define SAMPLE_DATA_BUFFER(NAME, BLOCK) layout(scalar) readonly buffer BLOCK { SampleData at[]; } NAME
#define LOAD_SAMPLE_DATA(NAME, SLOT) counted(NAME.at[SLOT])
#endif

SampleData counted(SampleData data) {
    count_read(SAMPLE_DATA_WORDS);
    return data;
}

SampleData sample_data_of(uvec4 p, uvec4 q) { return counted(SampleData(uintBitsToFloat(p.x), p.yzw, q.x, q.y, q.zw)); }

bool has_surface(SampleData data) { return data.instance != NONE; }

vec3 surface_position(SampleData data, Ray ray) { return ray.origin + data.depth * ray.direction; }

// The shading point of a primary surface, which was stored in the frame `epoch`.
ShadingPoint unpack_shading_point(SampleData data, Ray ray, uint epoch) {
    float clearance = uintBitsToFloat((data.packed_normals.z >> 24u) << 23u);
    vec3 normal = geometric_normal(data);
    vec3 error = depth_along_error(ray.origin, ray.direction, data.depth, normal, clearance);
    Layers layers = unpack_layers(data, ray.direction, epoch);
    ShadingPoint shading_point = make_shading_point(surface_position(data, ray), clearance, back_off_distance(error, data.depth), normal,
                       shading_normal(data), unpack_material(data), layers, ray.direction);
    if (HAS_TRANSMISSION && layers.inside) shading_point.passed_to_viewer = passed_light(shading_point.behind, data.depth);
    return shading_point;
}

ShadingPoint unpack_shading_point(SampleData data, Ray ray) { return unpack_shading_point(data, ray, CURRENT); }
