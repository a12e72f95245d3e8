// The one accessor to the scene. Geometry, materials and lights are read through storage buffers or by
// address, nodes and corners like these or as texels.

#if GEOMETRY_ADDRESSES

layout(scalar) uniform SceneAddressesBlock { SceneAddresses at; } scene_addresses;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer NormalsBlock { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TrianglePartsBlock { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TopInstancesBlock { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstancesBlock { GpuInstance at[]; };
#define normals NormalsBlock(scene_addresses.at.normals)
#define triangle_parts TrianglePartsBlock(scene_addresses.at.triangle_parts)
#define top_instances TopInstancesBlock(scene_addresses.at.top_instances)
#define instances InstancesBlock(scene_addresses.at.instances)
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialsBlock { GpuMaterial at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightsBlock { GpuLight at[]; };
#define material_at(index) MaterialsBlock(scene_addresses.at.materials).at[index]
#define light_at(index) LightsBlock(scene_addresses.at.lights).at[index]
#if !FETCH_TEXELS
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer NodesBlock { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionsBlock { vec3 at[]; };
#define nodes NodesBlock(scene_addresses.at.nodes)
#define positions PositionsBlock(scene_addresses.at.positions)
#endif

#else

layout(scalar) readonly buffer NormalsBlock { uvec3 at[]; } normals;
layout(scalar) readonly buffer TrianglePartsBlock { uvec3 at[]; } triangle_parts;
layout(scalar) readonly buffer TopInstancesBlock { uint at[]; } top_instances;
layout(scalar) readonly buffer InstancesBlock { GpuInstance at[]; } instances;
layout(scalar) readonly buffer MaterialsBlock { GpuMaterial at[]; } materials;
layout(scalar) readonly buffer LightsBlock { GpuLight at[]; } lights;
#define material_at(index) materials.at[index]
#define light_at(index) lights.at[index]
#if !FETCH_TEXELS
layout(scalar) readonly buffer NodesBlock { uvec4 at[]; } nodes;
layout(scalar) readonly buffer PositionsBlock { vec3 at[]; } positions;
#endif

#endif

#if FETCH_TEXELS

// llvmpipe fetches a texel's four words at once for each lane, but a buffer's words one by one, each
// behind its own branch.
// Eight-wide nodes, five texels each.
uniform utextureBuffer nodes;
// Triangles, nine words each: the object-space positions of three corners.
uniform utextureBuffer positions;

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
