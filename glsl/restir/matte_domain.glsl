#pragma once
// The domain of a reservoir that is kept for surfaces elsewhere: a matte white point, which has no viewer.
#include "scene/domain.glsl"

Domain matte_domain(vec3 position, vec3 normal) {
    GpuMaterial material;
    material.base_color = vec3(1.0);
    material.metallic = 0.0;
    material.dielectric_f0 = vec3(0.0);
    material.dielectric_f90 = 0.0;
    material.roughness = 1.0;
    return make_domain(position, 0.0, 0.0, normal, normal, material, -normal);
}

Domain point_domain(GpuGridPoint point) { return matte_domain(point.position, unpack_octahedral(point.normal)); }
