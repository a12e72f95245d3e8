// What a pixel's reservoir has chosen is added to its colour.
#include "restir.glsl"

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// Adds to the pixel of this invocation.
void shade() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    if (has_surface(data)) {
        PackedReservoir packed;
        LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
        Reservoir reservoir = unpack_reservoir(packed);
        if (reservoir.contribution_weight > 0.0) {
            Domain domain = unpack_domain(data, primary_ray(pixel));
            vec3 light = contribution(domain, reservoir.value) * reservoir.contribution_weight;
            bool traced = VISIBILITY == VISIBILITY_FINAL || VISIBILITY == VISIBILITY_INITIAL;
            if (max_component(light) > 0.0 && (!traced || trace_visible(shadow_ray(domain, reservoir.value))))
                color.at[number_of(pixel)] += accept_radiance(light);
        }
    }
}
