#pragma once
// What triangles belong to.
#include "scene/geometry.glsl"

// What a triangle belongs to.
struct TriangleOwner {
    uint material;
    // Index of the instance in the scene.
    uint instance;
    // NONE unless the triangle is a light.
    uint light;
};

TriangleOwner triangle_owner(GpuInstance instance, uint primitive) {
    TriangleOwner owner = TriangleOwner(instance.material, instance.id, NONE);
    uint rank = primitive;
    if (instance.first_part != NONE) {
        uvec3 part = triangle_parts.at[instance.first_part + primitive];
        owner.material = part.x;
        rank = part.y;
        owner.instance += part.z;
    }
    if (instance.first_light != NONE && rank != NONE) owner.light = instance.first_light + rank;
    return owner;
}
