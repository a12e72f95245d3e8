#pragma once
// Layers: what a material has beyond the metallic-roughness model, at one point of a surface.
#include "prelude.glsl"

// True if some surface has one; else nothing of them is read.
const bool HAS_LAYERS = HAS_COAT || HAS_ANISOTROPY || HAS_TRANSMISSION;

struct Layers {
    // The fraction of the surface that is coated; 0 = no coat.
    float coat;
    float coat_roughness;
    // Unit normal of the coat; the BSDF is made from it in the shading frame. Unused without HAS_COAT_NORMALS: then the coat has
    // the shading normal.
    vec3 coat_normal;
    // Strength of the anisotropy; 0 = none.
    float anisotropy;
    // Along the surface in the direction in which the specular lobe is wider; 0 = none.
    vec3 grain;
    // The fraction of unreflected light that passes through the surface.
    float transmission;
    // Index of refraction of the dielectric; 0 = it reflects all light.
    float ior;
    // True if the surface is the boundary of a volume; else it is a thin sheet.
    bool has_volume;
    // Absorption coefficient of the volume, per unit of length.
    vec3 absorption;
    // True if the viewer is on the back of the surface, where its volume is. No property of a material: whoever knows the viewer
    // sets it.
    bool inside;
};

// A surface without layers.
const Layers NO_LAYERS = Layers(0.0, 0.0, vec3(0.0, 0.0, 1.0), 0.0, vec3(0.0), 0.0, 1.5, false, vec3(0.0), false);
