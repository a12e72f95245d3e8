#pragma once
// Normal maps: shading normals from textures, in the frame of normal and tangent that MikkTSpace defines.
#include "scene/textures.glsl"
#include "scene/triangle_point.glsl"

// A corner's tangent in the world, and in w the side of the bitangent.
vec4 corner_tangent(GpuInstance instance, uint packed) {
    vec3 tangent = transform_vector(instance.object_to_world, unpack_octahedral(packed & ~1u));
    return vec4(normalize(tangent), (packed & 1u) != 0u ? -1.0 : 1.0);
}

// Turns the shading normal of a point by the normal map of its material.
void map_normal(inout TrianglePoint point, GpuMaterial material, GpuInstance instance, uint primitive, vec2 weights) {
    if (!HAS_NORMAL_MAPS || material.normal_texture == NONE || instance.first_tangent == NONE) return;
    uvec3 corners = corner_directions.at[instance.first_tangent + primitive];
    vec4 first = corner_tangent(instance, corners.x);
    vec3 tangent = (1.0 - weights.x - weights.y) * first.xyz + weights.x * corner_tangent(instance, corners.y).xyz
        + weights.y * corner_tangent(instance, corners.z).xyz;
    vec3 normal = point.shading_normal;
    tangent -= dot(tangent, normal) * normal;
    float size = dot(tangent, tangent);
    // Opposite corner tangents can cancel out.
    if (size <= TINY) return;
    tangent *= inversesqrt(size);
    vec3 columns[4] = instance.object_to_world;
    bool mirrored = dot(cross(columns[0], columns[1]), columns[2]) < 0.0;
    vec3 bitangent = cross(normal, tangent) * (mirrored ? -first.w : first.w);
    GpuTexture used = load_textures(material.normal_texture);
    vec3 turned = texture_at(used, uv_at(instance, primitive, weights, used.set), false).rgb * 2.0 - 1.0;
    turned.xy *= material.normal_scale;
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
