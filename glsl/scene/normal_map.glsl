#pragma once
// Normal maps: shading normals from textures, in the frame of normal and tangent that MikkTSpace defines.
#include "scene/textures.glsl"
#include "scene/triangle_point.glsl"

// A corner's tangent in the world, and in w the side of the bitangent.
vec4 corner_tangent(GpuInstance instance, uint packed) {
    vec3 tangent = transform_vector(instance.object_to_world, unpack_octahedral(packed & ~1u));
    return vec4(normalize(tangent), (packed & 1u) != 0u ? -1.0 : 1.0);
}

// The tangent and the bitangent of a mesh at a point, perpendicular to `normal`; false where the mesh has none.
bool mesh_tangents(GpuInstance instance, uint primitive, vec2 weights, vec3 normal, out vec3 tangent, out vec3 bitangent) {
    if (instance.first_tangent == NONE) return false;
    uvec3 corners = corner_directions.at[instance.first_tangent + primitive];
    vec4 first = corner_tangent(instance, corners.x);
    tangent = (1.0 - weights.x - weights.y) * first.xyz + weights.x * corner_tangent(instance, corners.y).xyz
        + weights.y * corner_tangent(instance, corners.z).xyz;
    tangent -= dot(tangent, normal) * normal;
    float size = dot(tangent, tangent);
    // Opposite corner tangents can cancel out.
    if (size <= TINY) return false;
    tangent *= inversesqrt(size);
    vec3 columns[4] = instance.object_to_world;
    bool mirrored = dot(cross(columns[0], columns[1]), columns[2]) < 0.0;
    bitangent = cross(normal, tangent) * (mirrored ? -first.w : first.w);
    return true;
}

// Turns the shading normal of a point by a normal map.
void turn_normal(inout TrianglePoint point, uint texture, float scale, GpuInstance instance, uint primitive, vec2 weights) {
    vec3 normal = point.shading_normal, tangent, bitangent;
    if (!mesh_tangents(instance, primitive, weights, normal, tangent, bitangent)) return;
    GpuTexture used = load_textures(texture);
    vec3 turned = texture_at(used, uv_at(instance, primitive, weights, used.set), false).rgb * 2.0 - 1.0;
    turned.xy *= scale;
    vec3 mapped = tangent * turned.x + bitangent * turned.y + normal * turned.z;
    float length_squared = dot(mapped, mapped);
    if (length_squared <= TINY) return;
    mapped *= inversesqrt(length_squared);
    // It stays on the side of the surface on which the interpolated normal is, so that `face_viewer` turns both alike.
    vec3 side = dot(normal, point.normal) < 0.0 ? -point.normal : point.normal;
    float facing = dot(mapped, side);
    if (facing < MIN_FACING) mapped = normalize(mapped + (MIN_FACING - facing) * side);
    point.shading_normal = mapped;
    point.interpolated = true;
}

// Turns the shading normal of a point by the normal map of its material.
void map_normal(inout TrianglePoint point, GpuMaterial material, GpuInstance instance, uint primitive, vec2 weights) {
    if (!HAS_NORMAL_MAPS || material.normal_texture == NONE) return;
    turn_normal(point, material.normal_texture, material.normal_scale, instance, primitive, weights);
}
