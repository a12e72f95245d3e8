#pragma once
// Candidate sources of light samples: how lights are selected for candidates, and the density of a candidate over all
// sources that can draw it.
#include "restir/algebra.glsl"
#include "restir/frame.glsl"
#include "restir/light_sample.glsl"

// A point that receives light, as candidate sources see it: their densities may depend on where it is.
struct Receiver {
    vec3 position;
};

Receiver receiver_at(Domain domain) { return Receiver(domain.position); }

// Draws a light, uniformly or by power, and a point of it.
LightSample draw_light_sample(Receiver receiver, uvec4 bits) {
    uint count = scene.at.light_count;
    uint unused;
    uint light = restir.at.reuse.uniform_candidates != 0u ? scale_to(bits.xy, count, unused) : pick_light(count, bits.xy);
    return new_light_sample(draw_point(light, bits));
}

// The density with which `draw_light_sample` draws a point, in its own measure. `direction` is the one towards it.
float light_sample_pdf_own_measure(Receiver receiver, LightPoint point, vec3 direction) {
    float probability = restir.at.reuse.uniform_candidates != 0u ? 1.0 / float(scene.at.light_count)
                                                                 : light_probability(point);
    return pdf_own_measure(point, direction, probability);
}

// The weight of a candidate: its target over the sum of the densities of all light and BSDF samples.
float candidate_weight(Domain domain, Receiver receiver, LightSample value, uint bsdf_samples, out float target) {
    float bsdf_pdf;
    target = luminance(contribution(domain, value, bsdf_pdf));
    float light_pdf = light_sample_pdf_own_measure(receiver, value.point, value.position);
    return target / (float(restir.at.reuse.light_samples) * light_pdf + float(bsdf_samples) * bsdf_pdf);
}
