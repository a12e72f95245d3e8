// What a frame left in its reservoirs, for those who look for faults.
#include "restir.glsl"
#include "similar.glsl"

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) writeonly buffer ReservoirAovsBlock { ReservoirAov at[]; } reservoir_aovs;

const uint MOST_TECHNIQUES = NEIGHBOURS + 1u;

#include "neighbours.glsl"

// Looks at the pixel of this invocation.
void look() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
    Reservoir reservoir = unpack_reservoir(packed);
    SampleData data = sample_data.at[slot];
    uint found = 0u;
    for (uint step = 0u; has_surface(data) && step < restir.at.spatial_passes; step += 1u) {
        // The same random numbers find the same neighbours again.
        Random random = kind_random(pixel, PASS_SPATIAL + step);
        found += find_neighbours(pixel, data, random) - 1u;
    }
    vec2 source = vec2(-1.0);
    float jacobian = 0.0;
    if (KEEPS_ORIGINS && reservoir.contribution_weight > 0.0) {
        source = vec2(reservoir.origin % restir.at.width, reservoir.origin / restir.at.width);
        float here = sample_spread(surface_position(data, primary_ray(pixel)), reservoir.value);
        jacobian = here / max(reservoir.origin_spread, TINY);
    }
    reservoir_aovs.at[number_of(pixel)] =
        ReservoirAov(reservoir.contribution_weight, reservoir.confidence, reservoir.age, reservoir.value.light, found,
                     source, jacobian);
}
