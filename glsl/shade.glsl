// What a pixel's reservoir has chosen is added to its colour.
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
#ifdef INDIRECT
#include "indirect_light.glsl"
#endif
#include "reservoirs.glsl"
#include "restir.glsl"

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// Adds to the pixel of this invocation.
void shade() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint index = pixel.y * restir.at.width + pixel.x;
    uint slot = slot_of(pixel);
    vec3 radiance = color.at[index];
    SampleData data = sample_data.at[slot];
    if (has_surface(data)) {
        PackedReservoir packed;
        LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
        Reservoir reservoir = unpack_reservoir(packed);
        if (reservoir.contribution_weight > 0.0) {
            Domain domain = unpack_domain(data, primary_ray(pixel));
            vec3 light = contribution(domain, reservoir.value) * reservoir.contribution_weight;
            bool traced = VISIBILITY == VISIBILITY_FINAL || VISIBILITY == VISIBILITY_INITIAL;
            if (max_component(light) > 0.0 && (!traced || trace_visible(shadow_ray(domain, reservoir.value)))) radiance += light;
        }
    }
    color.at[index] = accept_radiance(radiance);
}
