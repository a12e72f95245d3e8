#pragma once
// Adds the light of each pixel's selected sample to its colour. A pass first includes direct.glsl or indirect.glsl.
#include "core/values.glsl"
#include "restir/frame.glsl"
#include "restir/reservoir.glsl"
#include "restir/sample_data.glsl"

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// Shades the pixel of this invocation.
void shade() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    if (has_surface(data)) {
        PackedReservoir packed;
        LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
        Reservoir reservoir = unpack_reservoir(packed, CURRENT);
        if (reservoir.contribution_weight > 0.0) {
            ShadingPoint shading_point = unpack_shading_point(data, primary_ray(pixel));
            vec3 light = contribution(shading_point, reservoir.value) * reservoir.contribution_weight;
            bool traced = (HAS_BLEND && VISIBILITY == VISIBILITY_WEIGHTS) || VISIBILITY == VISIBILITY_FINAL || VISIBILITY == VISIBILITY_INITIAL;
            if (traced && max_component(light) > 0.0) light *= trace_segments(shading_point, reservoir.value, CURRENT);
            if (max_component(light) > 0.0) ADD_LIGHT(pixel, light)
        }
    }
}
