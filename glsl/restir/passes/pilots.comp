#version 460
// Traces the pilot of each pixel. A pilot influences the number of candidates of the pixels around it, but not of its
// own pixel: a choice that depends on the sample that it concerns would bias it.
#include "lights/samplers/sources.glsl"
#include "restir/samples/pilot.glsl"
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) writeonly buffer PilotsBlock { uint at[]; } pilots;

void main() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    Pilot pilot = Pilot(NONE, NONE, vec2(0.0), 0.0);
    if (has_surface(data) && scene.at.light_count > 0u) {
        ShadingPoint shading_point = unpack_shading_point(data, primary_ray(pixel));
        prefer_narrow_lobes(shading_point.bsdf);
        BsdfSample chosen;
        Ray ray;
        if (pilot_ray(shading_point, pixel, chosen, ray)) {
            Hit hit = trace_closest(ray, NO_ALPHA_RANDOM);
            pilot.instance = hit.instance;
            pilot.primitive = hit.primitive;
            pilot.uv = hit.barycentrics;
            LightPoint light = light_found(hit, ray.direction);
            if (is_environment(light.kind)) {
                pilot.primitive = light.index;
                pilot.uv = light.uv;
            }
            if (light.kind != LIGHT_NONE) {
                LightSample value = new_light_sample(light);
                // Of light samples by power: a walk through the light BVH is not worth its time here.
                bool rare = rare_probability(value.point) > 0.0;
                float light_pdf = rare ? rare_pdf_own_measure(value.point, value.position)
                                       : light_sample_pdf_own_measure(distant_context(), value.point, value.position);
                float light_samples = rare ? 1.0 : float(restir.at.reuse.light_samples), target;
                float weight = accept_weight(candidate_weight(shading_point, value, light_pdf, light_samples, 1u, target));
                // The mean is 0 if all lights were off when it was computed; then nothing can be relative to it.
                if (restir.at.mean_light_luminance > 0.0) pilot.brightness = weight / restir.at.mean_light_luminance;
            }
        }
    }
    STORE_PILOT(pilots, slot, pilot);
}
