#pragma once
// Access to the scene. `scene_buffers.glsl` is generated from the one declaration of scene buffers in Rust; it
// reads each buffer through a descriptor, by address, or as texels, depending on the shader variant.
#include "scene_buffers.glsl"

// Where something moves, the lights and instances of the previous frame follow those of the current frame in the
// same buffers.
const uint CURRENT = 0u;
const uint PREVIOUS = 1u;

// Macros, because a function would return, and so load, the whole structure.
#define light_at(INDEX, EPOCH) lights.at[(INDEX) + (EPOCH) * scene.at.light_count]
#define instance_at(INDEX, EPOCH) instances.at[(INDEX) + (EPOCH) * scene.at.instance_count]
#define material_at(INDEX) materials.at[INDEX]

#if FETCH_TEXELS

// llvmpipe fetches the four words of a texel at once for each lane, but reads a buffer word by word, each word behind
// a branch.
uvec4 node_words(uint index) { return texelFetch(nodes, int(index)); }

// A triangle's corners in object space.
void triangle_corners(uint triangle, out vec3 a, out vec3 b, out vec3 c) {
    uint first = 9u * triangle;
    int texel = int(first >> 2u);
    uvec4 p = texelFetch(positions, texel);
    uvec4 q = texelFetch(positions, texel + 1);
    uvec4 r = texelFetch(positions, texel + 2);
    // The nine words begin at any of the first texel's four.
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

#else

uvec4 node_words(uint index) { return nodes.at[index]; }

void triangle_corners(uint triangle, out vec3 a, out vec3 b, out vec3 c) {
    a = positions.at[3u * triangle];
    b = positions.at[3u * triangle + 1u];
    c = positions.at[3u * triangle + 2u];
}

#endif
