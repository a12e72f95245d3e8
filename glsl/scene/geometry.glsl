#pragma once
// Access to the scene. `scene_buffers.glsl` is generated from the one declaration of scene buffers in Rust; it
// reads each buffer through a descriptor, by address, or as texels, depending on the shader variant.
#include "bsdf/layers.glsl"
#include "scene_buffers.glsl"

// Where something moves, the lights and instances of the previous frame follow those of the current frame in the
// same buffers.
const uint CURRENT = 0u;
const uint PREVIOUS = 1u;

GpuLight light_at(uint index, uint epoch) { return load_lights(index + epoch * scene.at.triangle_light_count); }

GpuPunctualLight punctual_light_at(uint index, uint epoch) {
    return load_punctual_lights(index + epoch * scene.at.punctual_light_count);
}

GpuInstance instance_at(uint index, uint epoch) { return load_instances(index + epoch * scene.at.instance_count); }

// A material without its textures, as it reflects light.
GpuMaterial material_at(uint index) {
    GpuMaterial material = load_materials(index);
    if (HAS_UNLIT && (material.flags & MATERIAL_UNLIT) != 0u) material.base_color = vec3(0.0);
    return material;
}

// The layers of a material without their textures.
Layers layers_at(uint index) {
    if (!HAS_LAYERS) return NO_LAYERS;
    GpuMaterialLayers found = load_material_layers(scene.at.material_count + index);
    return Layers(found.coat, found.coat_roughness, vec3(0.0, 0.0, 1.0), found.anisotropy, vec3(0.0), found.transmission,
                  found.ior, found.absorption.x >= 0.0, max(found.absorption, vec3(0.0)), false);
}

// The same for a viewer who is on the back of the surface or not.
Layers layers_at(uint index, bool inside) {
    Layers layers = layers_at(index);
    layers.inside = HAS_TRANSMISSION && inside;
    return layers;
}

// A triangle's corners in object space.
void triangle_corners(uint triangle, out vec3 a, out vec3 b, out vec3 c) {
    uint first = 9u * triangle;
    uvec4 p = positions_words(first >> 2u), q = positions_words((first >> 2u) + 1u), r = positions_words((first >> 2u) + 2u);
    // The nine words begin at any of the first four.
    bool by_one = (first & 1u) != 0u, by_two = (first & 2u) != 0u;
    p = by_one ? uvec4(p.yzw, q.x) : p;
    q = by_one ? uvec4(q.yzw, r.x) : q;
    r.xyz = by_one ? r.yzw : r.xyz;
    p = by_two ? uvec4(p.zw, q.xy) : p;
    q = by_two ? uvec4(q.zw, r.xy) : q;
    r.x = by_two ? r.z : r.x;
    a = uintBitsToFloat(p.xyz);
    b = uintBitsToFloat(uvec3(p.w, q.xy));
    c = uintBitsToFloat(uvec3(q.zw, r.x));
}
