#pragma once
// Candidate sources of light samples: how lights are selected for candidates, and the density of a candidate over all
// sources that can draw it.
#include "lights/samplers/light_bvh/light_bvh.glsl"
#include "restir/algebra.glsl"
#include "restir/frame.glsl"
#include "restir/samples/light_sample.glsl"

// True if some of the light samples of a context come from the light BVH.
bool has_near_lights(LightSampleContext context) { return LIGHT_BVH && context.expected > 0.0; }

// Whether number `index` of the context's light samples is drawn among near lights; for a single sample a random number decides, from
// another hash of its bits than the one that draws a light and a uv on it.
bool draws_near(LightSampleContext context, uint index, uvec4 bits) {
    return has_near_lights(context) && index < restir.at.reuse.near_samples
        && (restir.at.reuse.light_samples > 1u || to_unit(pcg4d(bits.wzyx).x) < restir.at.reuse.near_fraction);
}

// The mean probability with which the context's light samples select a light, given those of the sources.
float mean_probability(LightSampleContext context, float of_all, float of_near) {
    return has_near_lights(context) ? mix(of_all, of_near, restir.at.reuse.near_fraction) : of_all;
}

// The probability of selecting the light of a point among all; 0 for rare lights, which reservoirs do not hold.
float probability_among_all(LightPoint point) {
    if (restir.at.reuse.uniform_candidates == 0u) return light_probability(point);
    return rare_probability(point) > 0.0 ? 0.0 : 1.0 / float(scene.at.light_count);
}

// The mean density with which the context's light samples are drawn at a point, in its own measure. `direction` is the one
// towards it.
float light_sample_pdf_own_measure(LightSampleContext context, LightPoint point, vec3 direction) {
    float near = has_near_lights(context) ? near_light_probability(context, light_index(point)) : 0.0;
    return pdf_own_measure(point, direction, mean_probability(context, probability_among_all(point), near));
}

// The sample at a point of a light that was selected, among near lights with a probability of `near`, and its mean density. If `rare`,
// the light was selected among rare lights.
LightSample sample_of_light(LightSampleContext context, bool rare, uint light, float near, uvec4 bits, out float pdf) {
    LightSample value = new_light_sample(draw_point(light, bits));
    float probability = rare ? rare_probability(value.point) : probability_among_all(value.point);
    // Where light samples are not drawn by power they find rare lights, whose light has its own candidates.
    if (RARE_LIGHTS && probability == 0.0) value.emission = vec3(0.0);
    if (!rare) probability = mean_probability(context, probability, near);
    pdf = pdf_own_measure(value.point, value.position, probability);
    return value;
}

// Draws a light and a point of it, for number `index` of the context's light samples, in ascending order. Also returns the
// density as above. If `rare`, the light is a rare one. Both kinds share their code, because neighbouring vertices may differ.
LightSample draw_light_sample(inout LightSampleContext context, bool rare, uint index, uvec4 bits, out float pdf) {
    uint light;
    float near = 0.0;
    if (!rare && draws_near(context, index, bits)) {
        // The words that are left are too few for a cluster, a light and a uv on it.
        light = draw_near_light(context, index, restir.at.reuse.near_samples, pcg4d(bits).xy, near);
    } else {
        uint count = scene.at.light_count;
        uint unused;
        light = !rare && restir.at.reuse.uniform_candidates != 0u
            ? scale_to(bits.xy, count, unused)
            : pick_light(rare ? choices_of_rare() : choices_of_samples(), count, bits.xy);
        if (!rare && has_near_lights(context)) near = near_light_probability(context, light);
    }
    return sample_of_light(context, rare, light, near, bits, pdf);
}

LightSample draw_light_sample(inout LightSampleContext context, uint index, uvec4 bits, out float pdf) {
    return draw_light_sample(context, false, index, bits, pdf);
}

// The weight of a candidate: its target over the sum of the densities of all light and BSDF samples. `light_pdf` is the mean
// density of the light samples.
float candidate_weight(ShadingPoint shading_point, LightSample value, float light_pdf, float light_samples, uint bsdf_samples,
                       out float target) {
    float bsdf_pdf;
    target = luminance(contribution(shading_point, value, bsdf_pdf));
    // A light that is off has no target, and no density either.
    return target > 0.0 ? target / (light_samples * light_pdf + float(bsdf_samples) * bsdf_pdf) : 0.0;
}

// ---- Rare lights
//
// Resampling compares candidates before their shadow rays. Beside a much brighter emitter a dim one is selected almost never, also
// where the bright emitter is hidden: then nearly all pixels lack the dim emitter's light, and no firefly warns. So emitters of
// very little power are left out of reservoirs. They have a candidate of their own, drawn with the same probability for each of
// them, and a shadow ray that is theirs alone; BSDF rays find them too. Rust decides which are rare: src/device_scene/rare_lights.rs.

// The density of a candidate among rare lights at a point, in its own measure; 0 if its light is not rare. `direction` is the
// one towards it.
float rare_pdf_own_measure(LightPoint point, vec3 direction) {
    float probability = rare_probability(point);
    return probability > 0.0 ? pdf_own_measure(point, direction, probability) : 0.0;
}
