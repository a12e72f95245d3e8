#pragma once
// What a shift computes on its way. `merge.glsl` has the contract of shifts.
#include "scene/geometry.glsl"

struct Shifted {
    // Light that the sample contributes at the new shading point, without visibility; its luminance is the target function.
    vec3 contribution;
    // Ratio of the sample's measure in the new space to that in the old one.
    float jacobian;
};

// The epoch in which a technique of a merge over time sees samples: the canonical is of this frame. Without motion there is only one.
uint epoch_of(uint technique) { return MOVES && technique != 0u ? PREVIOUS : CURRENT; }
