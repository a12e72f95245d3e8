#version 460
// Initial candidates for direct light: points on lights and hits of BSDF rays, weighed against each
// other by the balance heuristic, one of them chosen by resampled importance sampling.
#include "restir.glsl"
#include "candidates.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) readonly buffer PilotsBlock { uint at[]; } pilots;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// BSDF candidates beside the pilot: more for narrow lobes, and where pixels around found bright light.
uint more_bsdf_samples(ivec2 pixel, Bsdf bsdf) {
    if (restir.at.more_bsdf_samples == 0u) return 0u;
    float squares = 0.0, count = 0.0;
    for (int y = -PILOT_REACH; y <= PILOT_REACH; y += 1) {
        for (int x = -PILOT_REACH; x <= PILOT_REACH; x += 1) {
            ivec2 other = pixel + ivec2(x, y);
            if (other == pixel || is_outside(other)) continue;
            squares += square(uintBitsToFloat(pilots.at[pilot_word(slot_of(uvec2(other)), 4u)]));
            count += 1.0;
        }
    }
    float most = float(restir.at.more_bsdf_samples);
    // The best share for each is in proportion to the deviation (Neyman); a hit is rare enough for the
    // root mean square to stand for it.
    float for_brightness = MORE_FOR_BRIGHTNESS * sqrt(squares / max(count, 1.0));
    return uint(clamp(for_brightness, MORE_FOR_LOBE * most * narrowness(bsdf), most));
}

// Offers a candidate of either technique; returns whether it is chosen now.
bool offer_candidate(inout Stream stream, Domain domain, LightSample value, uint number, float choice, uint bsdf_samples) {
    float target;
    float weight = candidate_weight(domain, value, bsdf_samples, target);
    return stream_add(stream, number, weight, target, choice);
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
        Random random = kind_random(pixel, PASS_INITIAL);
        bool mirror = is_mirror(domain.bsdf);
        prefer_narrow_lobe(domain.bsdf);
        uint light_samples = restir.at.light_samples, bsdf_samples = restir.at.bsdf_samples;
        if (PILOTS) bsdf_samples += more_bsdf_samples(ivec2(pixel), domain.bsdf);

        Stream stream = empty_stream();
        for (uint i = 0u; i < light_samples; i += 1u) {
            uvec4 bits = random_bits(random);
            float choice = to_unit(random_bits(random).x);
            LightSample value = sample_lights(restir.at.lights, restir.at.uniform_candidates != 0u, bits);
            if (offer_candidate(stream, domain, value, i, choice, bsdf_samples)) reservoir.value = value;
        }

        Hit pilot = Hit(0.0, NONE, 0u, vec2(0.0));
        if (PILOTS) pilot = pilot_hit(LOAD_PILOT(pilots, slot));
        uint pilot_light = light_of(pilot);
        if (pilot_light != NONE) {
            LightSample value = sample_at(pilot_light, packUnorm2x16(pilot.barycentrics));
            float choice = to_unit(random_bits(random).x);
            if (offer_candidate(stream, domain, value, light_samples, choice, bsdf_samples)) reservoir.value = value;
        }

        // One trace a turn: BSDF rays, the mirror's ray, and the survivor's visibility.
        uint mirror_turn = bsdf_samples, visibility_turn = bsdf_samples + 1u;
        uint turn = PILOTS ? 1u : 0u;
        for (; turn <= visibility_turn; turn += 1u) {
            Ray next;
            bool wanted;
            float choice = 0.0;
            if (turn < bsdf_samples) {
                vec4 numbers = to_unit(random_bits(random));
                choice = to_unit(random_bits(random).x);
                BsdfSample chosen;
                wanted = sample_bsdf_ray(domain, numbers, chosen, next);
            } else if (turn == mirror_turn) {
                // What a mirror shows is one direction's light, which no reservoir can share.
                wanted = mirror && mirror_ray(domain, next);
            } else {
                // What a BSDF ray found was seen.
                wanted = VISIBILITY >= VISIBILITY_INITIAL && stream.chosen < light_samples;
                if (wanted) next = shadow_ray(domain, reservoir.value);
            }
            if (!wanted) continue;
            Hit hit = trace(next, turn == visibility_turn);
            if (turn == visibility_turn) {
                if (hit.instance != NONE) stream = empty_stream();
                continue;
            }
            uint light = light_of(hit);
            if (light == NONE) continue;
            if (turn == mirror_turn) {
                vec3 emission = light_emission(light_at(light), -dot(light_at(light).normal, next.direction));
                color.at[number_of(pixel)] += accept_radiance(emission * specular_fresnel(domain.bsdf, domain.outgoing.z));
                continue;
            }
            LightSample value = sample_at(light, packUnorm2x16(hit.barycentrics));
            if (offer_candidate(stream, domain, value, light_samples + turn, choice, bsdf_samples)) reservoir.value = value;
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (turn <= visibility_turn) count_fault(COUNTER_CUT_SHORT);
        reservoir.contribution_weight = accept_weight(contribution_weight(stream));
        mark_origin(reservoir, number_of(pixel), domain);
    }
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
