#version 460
// The first BSDF ray of each pixel: a candidate of direct light where it meets a light, and the beginning of a
// path of indirect light. What it finds also tells the pixels around how many more they should draw. It
// must not tell its own: a choice that depends on the sample that it concerns would bias it.
#include "restir.glsl"
#include "candidates.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) writeonly buffer PilotsBlock { uint at[]; } pilots;

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    Pilot pilot = Pilot(NONE, 0u, vec2(0.0), 0.0);
    if (has_surface(data) && restir.at.lights > 0u) {
        Domain domain = unpack_domain(data, primary_ray(pixel));
        prefer_narrow_lobe(domain.bsdf);
        BsdfSample chosen;
        Ray ray;
        if (pilot_ray(domain, pixel, chosen, ray)) {
            Hit hit = trace_closest(ray);
            pilot.instance = hit.instance;
            pilot.primitive = hit.primitive;
            pilot.barycentrics = hit.barycentrics;
            uint light = light_of(hit);
            if (light != NONE) {
                LightSample value = sample_at(light, packUnorm2x16(hit.barycentrics));
                float target;
                float weight = candidate_weight(domain, value, 1u, target);
                // Lamps that all were off when their brightness was measured ask for no more.
                if (restir.at.lamp_luminance > 0.0) pilot.brightness = weight / restir.at.lamp_luminance;
            }
        }
    }
    pilots.at[pilot_word(slot, 0u)] = pilot.instance;
    pilots.at[pilot_word(slot, 1u)] = pilot.primitive;
    pilots.at[pilot_word(slot, 2u)] = floatBitsToUint(pilot.barycentrics.x);
    pilots.at[pilot_word(slot, 3u)] = floatBitsToUint(pilot.barycentrics.y);
    pilots.at[pilot_word(slot, 4u)] = floatBitsToUint(pilot.brightness);
}
