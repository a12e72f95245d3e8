#version 460
// Initial candidates of direct light: light samples and hits of BSDF rays, weighed against each other by the balance
// heuristic. One of them is selected by resampled importance sampling.
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);

#include "lights/samplers/pixel_samples.glsl"
#include "restir/samples/pilot.glsl"

layout(scalar) readonly buffer PilotsBlock { uint at[]; } pilots;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// The distance, in pixels along each axis, up to which pilots are read.
const int PILOT_REACH = 2;
// Additional candidates per unit of pilot brightness.
const float MORE_FOR_BRIGHTNESS = 256.0;
// The fraction of the additional candidates that narrow lobes get in any case.
const float MORE_FOR_LOBE = 0.25;

// A candidate among rare lights has a ray for certain if it would add this part of what other candidates found, or more.
const float RARE_PART = 0.25;

// The number of BSDF candidates besides the pilot: more for narrow lobes, and where nearby pilots hit bright lights.
uint more_bsdf_samples(ivec2 pixel, Bsdf bsdf) {
    if (restir.at.more_bsdf_samples == 0u) return 0u;
    float squares = 0.0, count = 0.0;
    for (int y = -PILOT_REACH; y <= PILOT_REACH; y += 1) {
        for (int x = -PILOT_REACH; x <= PILOT_REACH; x += 1) {
            ivec2 other = pixel + ivec2(x, y);
            if (other == pixel || is_outside(other)) continue;
            squares += square(LOAD_PILOT_BRIGHTNESS(pilots, slot_of(uvec2(other))));
            count_read(1u);
            count += 1.0;
        }
    }
    float limit = float(restir.at.more_bsdf_samples);
    // The optimal number is proportional to the standard deviation (Neyman). The root mean square is close to it where
    // hits are rare. Under a constant environment, where they are not, the deviation itself brought nothing: in `cornell`
    // .91 of the rays at 1.05 of the error, elsewhere the same of both.
    float for_brightness = MORE_FOR_BRIGHTNESS * sqrt(squares / max(count, 1.0));
    return uint(clamp(for_brightness, MORE_FOR_LOBE * limit * narrowness_of(bsdf), limit));
}

// The light that a point of a rare light adds to the pixel if nothing is between them, by the balance heuristic of the candidates that
// find it. `rare_pdf` is the density of candidates among rare lights there.
vec3 rare_light(ShadingPoint shading_point, LightSample value, float rare_pdf, uint bsdf_samples) {
    float bsdf_pdf;
    vec3 light = contribution(shading_point, value, bsdf_pdf);
    if (max_component(light) <= 0.0) return vec3(0.0);
    return light / (rare_pdf + float(bsdf_samples) * bsdf_pdf);
}

// Adds what a BSDF ray hit; returns whether it is selected now.
bool add_hit(inout Stream stream, ShadingPoint shading_point, LightSample value, float light_pdf, uint index, float choice,
             uint bsdf_samples) {
    if (!found_by_rays(shading_point, value)) return false;
    if (rare_probability(value.point) > 0.0) {
        // The ray may have passed through surfaces that cover a part, and the hit does not say how much light they take.
        float passed = HAS_BLEND ? trace_transmittance(shadow_ray(shading_point, value, CURRENT)) : 1.0;
        vec3 light = rare_light(shading_point, value, rare_pdf_own_measure(value.point, value.position), bsdf_samples) * passed;
        if (max_component(light) > 0.0) ADD_LIGHT(invocation_pixel(), light)
        return false;
    }
    float target;
    float weight = candidate_weight(shading_point, value, light_pdf, float(restir.at.reuse.light_samples), bsdf_samples, target);
    if (weight > 0.0) weight *= pixel_weight(value, target);
    return stream_add(stream, index, weight, target, choice);
}

void main() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    // Empty or not, it has the confidence of one initial reservoir.
    Reservoir reservoir = empty_reservoir(1.0);
    if (has_surface(data) && scene.at.light_count > 0u) {
        ShadingPoint shading_point = unpack_shading_point(data, primary_ray(pixel));
        Random random = pass_random(pixel, FIRST_STREAM + STREAM_INITIAL);
        prefer_narrow_lobes(shading_point.bsdf);
        uint light_samples = restir.at.reuse.light_samples, bsdf_samples = restir.at.bsdf_samples;
        if (PILOTS) bsdf_samples += more_bsdf_samples(ivec2(pixel), shading_point.bsdf);

        Stream stream = empty_stream();
        PixelSampler source = begin_light_samples(pixel, shading_point);
        for (uint i = 0u; i < light_samples; i += 1u) {
            uvec4 bits = random_bits(random);
            float choice = random_choice(random);
            float light_pdf;
            LightSample value = draw_light_sample(source, i, bits, light_pdf);
            float target;
            float weight = candidate_weight(shading_point, value, light_pdf, float(light_samples), bsdf_samples, target);
            if (stream_add(stream, i, weight, target, choice)) reservoir.value = value;
        }
        merge_reused_samples(pixel, shading_point, stream, reservoir.value, random);

        Pilot pilot = Pilot(NONE, NONE, vec2(0.0), 0.0);
        if (PILOTS) pilot = LOAD_PILOT(pilots, slot);
        LightPoint pilot_light = light_found(pilot);
        if (pilot_light.kind != LIGHT_NONE) {
            LightSample value = new_light_sample(pilot_light);
            float light_pdf = light_sample_pdf_own_measure(source.context, value.point, value.position);
            float choice = random_choice(random);
            if (add_hit(stream, shading_point, value, light_pdf, light_samples, choice, bsdf_samples)) reservoir.value = value;
        }

        // The BSDF candidates, of which the pilot is the first, then the rays of delta lobes, then the shadow ray of the
        // selected candidate, then that of the candidate among rare lights.
        uint delta_turn = bsdf_samples, shadow_turn = delta_turn + MAX_DELTA_LOBES;
        uint turns = shadow_turn + (RARE_LIGHTS ? 2u : 1u);
        uint turn = PILOTS ? 1u : 0u;
        for (; turn < turns; turn += 1u) {
            uint purpose = !RARE_LIGHTS || turn == shadow_turn ? RAY_SHADOW : RAY_RARE;
            if (turn < shadow_turn) purpose = turn < delta_turn ? RAY_CANDIDATE : RAY_DELTA;
            Ray ray;
            vec3 rare = vec3(0.0), reflectance = vec3(0.0);
            float chance = 1.0;
            bool wanted;
            float choice = 0.0;
            if (purpose == RAY_CANDIDATE) {
                vec4 numbers = to_unit(random_bits(random));
                choice = random_choice(random);
                BsdfSample chosen;
                wanted = sample_bsdf_ray(shading_point, numbers, chosen, ray);
            } else if (purpose == RAY_DELTA) {
                // A delta lobe reflects the light of one direction, which no reservoir can share.
                wanted = delta_ray(shading_point, turn - delta_turn, ray, reflectance);
            } else if (purpose == RAY_RARE) {
                Random own = pass_random(pixel, FIRST_STREAM + STREAM_RARE);
                float rare_pdf;
                LightSample drawn = draw_light_sample(source.context, true, 0u, random_bits(own), rare_pdf);
                rare = rare_light(shading_point, drawn, rare_pdf, bsdf_samples);
                float light = luminance(rare);
                // Roulette: where the candidate would add little to what was found, it seldom has a ray. A hidden light
                // that was selected has been dropped by now, and so does not make the ray less likely.
                chance = clamp(light / max(RARE_PART * stream.weight_sum, TINY), restir.at.reuse.rare_lights, 1.0);
                wanted = light > 0.0 && random_choice(own) <= chance;
                if (wanted) ray = shadow_ray(shading_point, drawn, CURRENT);
            } else {
                // What a BSDF ray hit is visible.
                wanted = VISIBILITY >= VISIBILITY_INITIAL && stream.chosen < light_samples;
                if (wanted) ray = shadow_ray(shading_point, reservoir.value, CURRENT);
            }
            if (!wanted) continue;
            // What a delta lobe reflects no other pixel shares, so a random number may decide for it.
            Hit hit = trace(ray, purpose >= RAY_SHADOW, purpose == RAY_DELTA ? draw_alpha_random(random) : NO_ALPHA_RANDOM);
            if (purpose == RAY_SHADOW) {
                if (hit.transmittance == 0.0) stream = empty_stream();
                continue;
            }
            if (purpose == RAY_RARE) {
                if (hit.transmittance > 0.0) ADD_LIGHT(pixel, rare * (hit.transmittance / chance))
                continue;
            }
            LightPoint light = light_found(hit, ray.direction);
            if (light.kind == LIGHT_NONE) continue;
            if (purpose == RAY_DELTA) {
                vec3 emission;
                if (is_environment(light.kind)) {
                    emission = environment_radiance(environment_uv(ray.direction));
                } else {
                    GpuLight seen = light_at(light.index, CURRENT);
                    emission = hit_emission(seen, light.index, light.uv, -dot(seen.normal, ray.direction));
                    if (HAS_TRANSMISSION) emission *= passed_light(medium_left(shading_point, ray.direction), hit.t);
                }
                ADD_LIGHT(pixel, emission * reflectance)
                continue;
            }
            LightSample value = new_light_sample(light);
            float light_pdf = light_sample_pdf_own_measure(source.context, value.point, value.position);
            if (add_hit(stream, shading_point, value, light_pdf, light_samples + turn, choice, bsdf_samples)) reservoir.value = value;
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (turn < turns) count_fault(COUNTER_CUT_SHORT);
        if (stream.chosen != NONE) {
            reservoir.value = as_stored(reservoir.value);
            float target = target_function(shading_point, reservoir.value);
            if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
        }
        record_origin(reservoir, pixel_index(pixel), shading_point);
    }
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
