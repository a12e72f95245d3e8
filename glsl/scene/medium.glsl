#pragma once
// Media without state. A volume lies behind the surfaces of its material. A segment of a path lies in the volume of the surface
// that it leaves on its back; otherwise in that of the surface that it meets from its back; otherwise in air. Light that is
// emitted where a segment ends knows the first of these rules only. ../bsdf/GLASS.md has reasons and limits.
#include "bsdf/dielectric.glsl"
#include "core/math.glsl"

// Absorption per unit of length, where there is no volume. In a volume no channel is negative.
const vec3 NO_MEDIUM = vec3(-1.0);

bool is_medium(vec3 absorption) { return HAS_TRANSMISSION && absorption.x >= 0.0; }

// The fraction of light that passes a length of a medium.
vec3 passed_light(vec3 absorption, float length) { return is_medium(absorption) ? exp(-absorption * max(length, TINY)) : vec3(1.0); }

// The medium behind surfaces with these layers.
vec3 medium_behind(Layers layers) { return HAS_TRANSMISSION && has_interface(layers) ? layers.absorption : NO_MEDIUM; }

// The medium of a ray that leaves a surface: `normal` is on the viewer's side, and the viewer on the back if `inside`.
vec3 medium_left(vec3 behind, bool inside, vec3 normal, vec3 direction) {
    return (dot(normal, direction) > 0.0) == inside ? behind : NO_MEDIUM;
}

// The medium of a segment, by the medium of its start and by the surface at its end.
vec3 medium_between(vec3 left, vec3 behind_end, bool inside_end) { return is_medium(left) || !inside_end ? left : behind_end; }
