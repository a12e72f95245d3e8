#version 460
// What a frame left in its reservoirs of direct light, for those who look for faults.
#include "prelude.glsl"
#include "random.glsl"
#include "counters.glsl"
#include "geometry.glsl"
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "lights.glsl"
#include "camera.glsl"
#include "values.glsl"
#include "workgroups.glsl"
#include "sample_data.glsl"
#include "direct_light.glsl"
#include "reservoirs.glsl"
#include "restir.glsl"
#include "similar.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) writeonly buffer DirectAovsBlock { DirectAov at[]; } direct_aovs;

const uint MOST_TECHNIQUES = MOST_NEIGHBOURS + 1u;

#include "neighbours.glsl"

void main() {
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
        Random random = pass_random(pixel, PASS_SPATIAL_DIRECT + step);
        found += find_neighbours(pixel, data, random) - 1u;
    }
    direct_aovs.at[pixel.y * restir.at.width + pixel.x] =
        DirectAov(reservoir.contribution_weight, reservoir.confidence, reservoir.age, reservoir.value.light, found);
}
