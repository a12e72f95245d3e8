#pragma once
// The boundary of two dielectrics: Fresnel's law and Snell's law. `index` is the index of refraction beyond the boundary, relative to
// that of the side from which it is viewed.
#include "bsdf/layers.glsl"

// True for the boundary of a volume that light enters.
bool has_interface(Layers layers) { return HAS_TRANSMISSION && layers.has_volume && layers.transmission > 0.0 && layers.ior >= 1.0; }

// The relative index of the boundary of a volume; 0 of other surfaces.
float interface_index(Layers layers) {
    if (!has_interface(layers)) return 0.0;
    return layers.inside ? 1.0 / layers.ior : layers.ior;
}

// The reflectance of a smooth interface for unpolarised light; 1 where the reflection is total.
float dielectric_reflectance(float cosine, float index) {
    float sine_squared = (1.0 - cosine * cosine) / (index * index);
    if (sine_squared >= 1.0) return 1.0;
    float beyond = sqrt(1.0 - sine_squared);
    float across = (cosine - index * beyond) / (cosine + index * beyond);
    float along = (index * cosine - beyond) / (index * cosine + beyond);
    return 0.5 * (across * across + along * along);
}

// The direction behind an interface with the normal h, on whose front `outgoing` is; 0 where the reflection is total.
vec3 refracted(vec3 outgoing, vec3 h, float index) {
    float cosine = dot(outgoing, h), sine_squared = (1.0 - cosine * cosine) / (index * index);
    if (sine_squared >= 1.0) return vec3(0.0);
    return (cosine * h - outgoing) / index - sqrt(1.0 - sine_squared) * h;
}
