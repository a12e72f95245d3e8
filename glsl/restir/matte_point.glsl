#pragma once
// The shading point of a reservoir that is kept for surfaces elsewhere: a matte white point, which has no viewer.
#include "scene/shading_point.glsl"

ShadingPoint matte_point(vec3 position, vec3 normal) {
    GpuMaterial material;
    material.base_color = vec3(1.0);
    material.metallic = 0.0;
    material.dielectric_f0 = vec3(0.0);
    material.dielectric_f90 = 0.0;
    material.roughness = 1.0;
    return make_shading_point(position, 0.0, 0.0, normal, normal, material, NO_LAYERS, -normal);
}

ShadingPoint grid_point_shading(GpuGridPoint point) { return matte_point(point.position, unpack_octahedral(point.normal)); }
