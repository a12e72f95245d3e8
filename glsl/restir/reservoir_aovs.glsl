#pragma once
// Debug AOVs: each pixel's final reservoir, the number of neighbours that it merged, and the pixel that drew its sample. A
// pass first includes direct.glsl or indirect.glsl.
#include "restir/frame.glsl"
#include "restir/reservoir.glsl"
#include "restir/sample_data.glsl"

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) writeonly buffer ReservoirAovsBlock { ReservoirAov at[]; } reservoir_aovs;

// Writes the AOVs of the pixel of this invocation.
void write_aovs() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
    Reservoir reservoir = unpack_reservoir(packed, CURRENT);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    uint found = KEEPS_DEBUG_WORDS ? packed.words[neighbours_word()] : 0u;
    vec2 source = vec2(-1.0);
    float jacobian = 0.0;
    if (KEEPS_DEBUG_WORDS && reservoir.contribution_weight > 0.0) {
        source = vec2(reservoir.origin % restir.at.view.width, reservoir.origin / restir.at.view.width);
        // From where rays begin: a point in a crease may lie in the plane of the sample's surface.
        float here = sample_solid_angle(ray_start(unpack_shading_point(data, primary_ray(pixel))), reservoir.value);
        jacobian = here / max(reservoir.origin_solid_angle, TINY);
    }
    reservoir_aovs.at[pixel_index(pixel)] =
        ReservoirAov(reservoir.contribution_weight, reservoir.confidence, reservoir.age, light_of(reservoir.value), found,
                     source, jacobian);
}
