#pragma once
// What a shift computes on its way. `merge.glsl` has the contract of shifts.

struct Shifted {
    // Light that the sample contributes at the new shading point, without visibility; its luminance is the target function.
    vec3 contribution;
    // Ratio of the sample's measure in the new space to that in the old one.
    float jacobian;
};
