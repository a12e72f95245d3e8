#pragma once
// Candidate sources of light samples: how lights are selected for candidates, and the density of a candidate over all
// sources that can draw it.
#include "restir/algebra.glsl"
#include "restir/frame.glsl"
#include "restir/light_sample.glsl"

// Draws a light, uniformly or by power, and a uniform point on it.
LightSample draw_light_sample(uvec4 bits) {
    uint count = scene.at.light_count;
    uint unused;
    uint index = restir.at.reuse.uniform_candidates != 0u ? scale_to(bits.xy, count, unused) : pick_light(count, bits.xy);
    return light_sample_at(index, uniform_barycentrics(bits.zw), CURRENT);
}

// The density with which `draw_light_sample` draws a point of this light.
float light_sample_pdf_area(uint index) {
    GpuLight light = light_at(index, CURRENT);
    return restir.at.reuse.uniform_candidates != 0u ? 1.0 / (float(scene.at.light_count) * light.area) : light_pdf_area(light);
}

// The weight of a candidate: its target over the sum of the densities of all light and BSDF samples.
float candidate_weight(Domain domain, LightSample value, uint bsdf_samples, out float target) {
    float bsdf_pdf_area;
    target = luminance(contribution(domain, value, bsdf_pdf_area));
    return target / (float(restir.at.reuse.light_samples) * light_sample_pdf_area(value.light) + float(bsdf_samples) * bsdf_pdf_area);
}
