#version 460
// Initial candidates for direct light: points on lights and hits of BSDF rays, weighed against each
// other by the balance heuristic, one of them chosen by resampled importance sampling.
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
#include "resampling.glsl"
#include "restir.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// The candidate's weight in the stream: target over the density that all techniques together have.
float candidate_weight(Sample value, float target, float bsdf_pdf_area, uint light_samples, uint bsdf_samples) {
    float light_pdf_area = light_sample_pdf_area(restir.at.lights, restir.at.uniform_candidates != 0u, value.light);
    return target / (float(light_samples) * light_pdf_area + float(bsdf_samples) * bsdf_pdf_area);
}

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    // Empty or not, it counts as one attempt.
    Reservoir reservoir = empty_reservoir(1.0);
    if (has_surface(data) && restir.at.lights > 0u) {
        Ray ray = primary_ray(pixel);
        Domain domain = unpack_domain(data, ray);
        Random random = pass_random(pixel, PASS_INITIAL_DIRECT);
        uint light_samples = restir.at.light_samples, bsdf_samples = restir.at.bsdf_samples;

        Stream stream = empty_stream();
        for (uint i = 0u; i < light_samples; i += 1u) {
            uvec4 bits = random_bits(random);
            float choice = to_unit(random_bits(random).x);
            Sample value = sample_lights(restir.at.lights, restir.at.uniform_candidates != 0u, bits);
            float pdf_area;
            float target = luminance(direct_contribution(domain, value, pdf_area));
            float weight = candidate_weight(value, target, pdf_area, light_samples, bsdf_samples);
            if (stream_add(stream, i, weight, target, choice)) reservoir.value = value;
        }

        // One trace a turn: BSDF rays, the mirror's ray, and the survivor's visibility.
        uint mirror_turn = bsdf_samples, visibility_turn = bsdf_samples + 1u;
        bool mirror = domain.bsdf.alpha == 0.0 && domain.bsdf.specular_probability > 0.0;
        for (uint turn = 0u; turn <= visibility_turn; turn += 1u) {
            Ray next;
            bool wanted;
            float choice = 0.0;
            if (turn < bsdf_samples) {
                vec4 numbers = to_unit(random_bits(random));
                choice = to_unit(random_bits(random).x);
                BsdfSample chosen = sample_bsdf(domain.bsdf, domain.outgoing, numbers);
                vec3 direction = to_world(domain, chosen.direction);
                wanted = chosen.valid && !chosen.mirror && dot(direction, domain.geometric_normal) > 0.0;
                next = Ray(clear_origin(domain, direction), 3.402823466e38, direction);
            } else if (turn == mirror_turn) {
                // What a mirror shows is one direction's light, which no reservoir can share.
                vec3 direction = to_world(domain, vec3(-domain.outgoing.xy, domain.outgoing.z));
                wanted = mirror && dot(direction, domain.geometric_normal) > 0.0;
                next = Ray(clear_origin(domain, direction), 3.402823466e38, direction);
            } else {
                // What a BSDF ray found was seen.
                wanted = restir.at.visibility >= VISIBILITY_INITIAL && stream.chosen < light_samples;
                next = shadow_ray(domain, reservoir.value);
            }
            if (!wanted) continue;
            Hit hit = trace(next, turn == visibility_turn);
            if (turn == visibility_turn) {
                if (hit.instance != NONE) stream = empty_stream();
                continue;
            }
            if (hit.instance == NONE) continue;
            uint light = owner_of(instances.at[hit.instance], hit.primitive).light;
            if (light == NONE) continue;
            if (turn == mirror_turn) {
                vec3 emission = light_emission(light_at(light), -dot(light_at(light).normal, next.direction));
                uint index = pixel.y * restir.at.width + pixel.x;
                color.at[index] += emission * specular_fresnel(domain.bsdf, domain.outgoing.z);
                continue;
            }
            Sample value = sample_at(light, packUnorm2x16(hit.barycentrics));
            float pdf_area;
            float target = luminance(direct_contribution(domain, value, pdf_area));
            float weight = candidate_weight(value, target, pdf_area, light_samples, bsdf_samples);
            if (stream_add(stream, light_samples + turn, weight, target, choice)) reservoir.value = value;
        }
        reservoir.contribution_weight = accept_weight(contribution_weight(stream));
    }
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
