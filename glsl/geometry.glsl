// The one accessor to geometry, with two bodies: storage buffers and buffer addresses.

#if GEOMETRY_ADDRESSES

layout(scalar) uniform SceneAddressesBlock { SceneAddresses at; } scene_addresses;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionsBlock { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer NormalsBlock { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TrianglePartsBlock { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer NodesBlock { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TopInstancesBlock { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstancesBlock { GpuInstance at[]; };
#define positions PositionsBlock(scene_addresses.at.positions)
#define normals NormalsBlock(scene_addresses.at.normals)
#define triangle_parts TrianglePartsBlock(scene_addresses.at.triangle_parts)
#define nodes NodesBlock(scene_addresses.at.nodes)
#define top_instances TopInstancesBlock(scene_addresses.at.top_instances)
#define instances InstancesBlock(scene_addresses.at.instances)

#else

layout(scalar) readonly buffer PositionsBlock { vec3 at[]; } positions;
layout(scalar) readonly buffer NormalsBlock { uvec3 at[]; } normals;
layout(scalar) readonly buffer TrianglePartsBlock { uvec2 at[]; } triangle_parts;
layout(scalar) readonly buffer NodesBlock { uvec4 at[]; } nodes;
layout(scalar) readonly buffer TopInstancesBlock { uint at[]; } top_instances;
layout(scalar) readonly buffer InstancesBlock { GpuInstance at[]; } instances;

#endif

layout(scalar) readonly buffer MaterialsBlock { GpuMaterial at[]; } materials;
layout(scalar) readonly buffer LightsBlock { GpuLight at[]; } lights;

// A triangle's corners in object space.
void triangle_corners(uint triangle, out vec3 a, out vec3 b, out vec3 c) {
    a = positions.at[3u * triangle];
    b = positions.at[3u * triangle + 1u];
    c = positions.at[3u * triangle + 2u];
}
