#version 460
// Initial candidates of direct light: light samples and hits of BSDF rays, weighed against each other by the balance
// heuristic. One of them is selected by resampled importance sampling.
#include "lights/samplers/sources.glsl"
#include "lights/samplers/hash_grid/hash_grid.glsl"
#include "restir/samples/direct.glsl"
#include "lights/samplers/light_bvh/light_lists.glsl"
#include "restir/samples/pilot.glsl"
#include "restir/reservoir.glsl"
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer PilotsBlock { uint at[]; } pilots;
layout(scalar) readonly buffer LightListsBlock { uint at[]; } light_lists;
layout(scalar) readonly buffer GridPointsBlock { GpuGridPoint at[]; } grid_points;
layout(scalar) readonly buffer GridPlacesBlock { GpuGridPlace at[]; } grid_places;
layout(scalar) readonly buffer GridReservoirsBlock { uint at[]; } grid_reservoirs;
layout(scalar) writeonly buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// The distance, in pixels along each axis, up to which pilots are read.
const int PILOT_REACH = 2;
// Additional candidates per unit of pilot brightness.
const float MORE_FOR_BRIGHTNESS = 256.0;
// The share of the additional candidates that narrow lobes get in any case.
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

// What the pixel's merge with the hash grid is made of: technique 0 is what its own light samples selected, the others are
// reservoirs of the grid. What BSDF rays hit belongs to technique 0 too, but comes later.
Domain own_domain;
Reservoir own_reservoir;
uint grid_found[MAX_GRID_MERGED];
uint grid_claims[MAX_GRID_MERGED];
uint grid_count = 0u;

// Finds reservoirs at random places of the pixel's cell, or of a cell close by: otherwise the borders of cells would show.
void find_in_grid(uvec2 pixel, Domain domain) {
    if (HASH_GRID == HASH_GRID_NONE || restir.at.frame >= restir.at.grid.until_frame) return;
    Random random = pass_random(pixel, STREAM_GRID + 1u);
    vec4 u = to_unit(random_bits(random));
    uint key = grid_key(domain.position, domain.geometric_normal, u.w, u.xyz - 0.5);
    uint merged = restir.at.grid.merged, reservoirs = restir.at.grid.reservoirs;
    for (uint i = 0u; i < merged; i += 1u) {
        float part = (float(i) + to_unit(random_bits(random).x)) / float(merged);
        uint place = grid_place(key, min(uint(part * float(reservoirs)), reservoirs - 1u));
        GpuGridPlace found = grid_places.at[place];
        if (found.claim == 0u || found.key != key) continue;
        grid_found[grid_count] = place;
        grid_claims[grid_count] = found.claim;
        grid_count += 1u;
    }
}

float confidence_of(uint technique) { return technique == 0u ? 1.0 : restir.at.grid.confidence; }

Reservoir technique_at(uint technique) {
    if (technique == 0u) return own_reservoir;
    PackedReservoir packed;
    LOAD_RESERVOIR(grid_reservoirs, grid_found[technique - 1u], restir.at.grid.places, packed);
    return unpack_reservoir(packed);
}

Domain domain_of(uint technique) {
    Domain domain = own_domain;
    if (technique != 0u) {
        GRID_DOMAIN(grid_claims[technique - 1u], domain);
    }
    return domain;
}

// The merge asks no ray: its selected sample gets the shadow ray that all light samples share.
float transmittance(uint technique, Domain domain, LightSample value) { return 1.0; }

LightSample shift_to(uint technique, LightSample value, out float jacobian) {
    jacobian = 1.0;
    return value;
}

#define MergeSample Sample
#define MergeReservoir Reservoir
#define MERGE_EMPTY empty_reservoir(0.0)
#include "restir/merge.glsl"

// As published, reservoirs of points count by their confidence alone.
uint grid_mis() { return HASH_GRID == HASH_GRID_POINTS ? MIS_CONSTANT : MIS_DEFENSIVE; }

// Merges the selected light sample with the reservoirs of the hash grid.
void merge_grid(inout Stream stream, inout LightSample selected, inout Random random) {
    if (grid_count == 0u) return;
    own_reservoir = empty_reservoir(1.0);
    own_reservoir.value = selected;
    own_reservoir.contribution_weight = contribution_weight(stream);
    Reservoir merged = merge(grid_mis(), 1u + grid_count, false, false, random).reservoir;
    stream = empty_stream();
    if (!(merged.contribution_weight > 0.0)) return;
    selected = merged.value;
    float target = target_function(own_domain, selected);
    // It needs a shadow ray, as light sample 0 does.
    stream_add(stream, 0u, target * merged.contribution_weight, target, 1.0);
}

// The MIS weight of the pixel's own candidates at a sample with this target, which one of its BSDF rays hit.
float own_weight(LightSample value, float target) {
    if (HASH_GRID == HASH_GRID_NONE || grid_count == 0u) return 1.0;
    float grid_confidence = float(grid_count) * restir.at.grid.confidence, total = 1.0 + grid_confidence;
    float own_share = 1.0 / total, grid_share = grid_confidence / total;
    MisTerms terms = empty_mis_terms();
    add_target(terms, 0u, 0u, target, own_share, own_share, grid_share);
    for (uint i = 1u; i <= grid_count && needs_target(grid_mis(), 0u, i); i += 1u) {
        add_target(terms, 0u, i, target_function(domain_of(i), value), restir.at.grid.confidence / total, own_share, grid_share);
    }
    return mis_weight(grid_mis(), 0u, terms, own_share, own_share, grid_share);
}

// The light that a point of a rare light adds to the pixel if nothing is between them, by the balance heuristic of the candidates that
// find it. `rare_pdf` is the density of candidates among rare lights there.
vec3 rare_light(Domain domain, LightSample value, float rare_pdf, uint bsdf_samples) {
    float bsdf_pdf;
    vec3 light = contribution(domain, value, bsdf_pdf);
    if (max_component(light) <= 0.0) return vec3(0.0);
    return light / (rare_pdf + float(bsdf_samples) * bsdf_pdf);
}

// Adds what a BSDF ray hit; returns whether it is selected now.
bool add_hit(inout Stream stream, Domain domain, LightSample value, float light_pdf, uint index, float choice,
             uint bsdf_samples) {
    if (!found_by_rays(domain, value)) return false;
    if (rare_probability(value.point) > 0.0) {
        // The ray may have passed through surfaces that cover a part, and the hit does not say how much light they take.
        float passed = HAS_BLEND ? trace_transmittance(shadow_ray(domain, value, CURRENT)) : 1.0;
        vec3 light = rare_light(domain, value, rare_pdf_own_measure(value.point, value.position), bsdf_samples) * passed;
        if (max_component(light) > 0.0) ADD_LIGHT(own_pixel(), light)
        return false;
    }
    float target;
    float weight = candidate_weight(domain, value, light_pdf, float(restir.at.reuse.light_samples), bsdf_samples, target);
    if (weight > 0.0) weight *= own_weight(value, target);
    return stream_add(stream, index, weight, target, choice);
}

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    // Empty or not, it has the confidence of one initial reservoir.
    Reservoir reservoir = empty_reservoir(1.0);
    if (has_surface(data) && scene.at.light_count > 0u) {
        Domain domain = unpack_domain(data, primary_ray(pixel));
        Random random = pass_random(pixel, FIRST_STREAM + STREAM_INITIAL);
        prefer_narrow_lobes(domain.bsdf);
        uint light_samples = restir.at.reuse.light_samples, bsdf_samples = restir.at.bsdf_samples;
        if (PILOTS) bsdf_samples += more_bsdf_samples(ivec2(pixel), domain.bsdf);

        Stream stream = empty_stream();
        Receiver receiver;
        uint list = 0u;
        if (LIGHT_LISTS) {
            Random turn = pass_random(pixel, STREAM_TILES);
            list = list_word(tile_near(pixel, random_bits(turn).xy));
            LOAD_RECEIVER(light_lists, list, receiver);
            count_read(LIST_RECEIVER_WORDS);
        } else {
            receiver = receiver_at(domain);
        }
        for (uint i = 0u; i < light_samples; i += 1u) {
            uvec4 bits = random_bits(random);
            float choice = random_choice(random);
            float light_pdf;
            LightSample value;
            if (LIGHT_LISTS && draws_near(receiver, i, bits)) {
                // One entry of each part of the list, which is in the order of the walk.
                float part = (float(i) + to_unit(pcg4d(bits).x)) / float(restir.at.reuse.near_samples);
                uint entry = list + LIST_RECEIVER_WORDS
                    + 2u * min(uint(part * float(restir.at.light_list)), restir.at.light_list - 1u);
                float near = uintBitsToFloat(light_lists.at[entry + 1u]);
                count_read(2u);
                value = sample_of_light(receiver, false, light_lists.at[entry], near, bits, light_pdf);
            } else {
                value = draw_light_sample(receiver, i, bits, light_pdf);
            }
            float target;
            float weight = candidate_weight(domain, value, light_pdf, float(light_samples), bsdf_samples, target);
            if (stream_add(stream, i, weight, target, choice)) reservoir.value = value;
        }
        if (HASH_GRID != HASH_GRID_NONE) {
            own_domain = domain;
            find_in_grid(pixel, domain);
            merge_grid(stream, reservoir.value, random);
        }

        Pilot pilot = Pilot(NONE, NONE, vec2(0.0), 0.0);
        if (PILOTS) pilot = LOAD_PILOT(pilots, slot);
        LightPoint pilot_light = light_found(pilot);
        if (pilot_light.kind != LIGHT_NONE) {
            LightSample value = new_light_sample(pilot_light);
            float light_pdf = light_sample_pdf_own_measure(receiver, value.point, value.position);
            float choice = random_choice(random);
            if (add_hit(stream, domain, value, light_pdf, light_samples, choice, bsdf_samples)) reservoir.value = value;
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
                wanted = sample_bsdf_ray(domain, numbers, chosen, ray);
            } else if (purpose == RAY_DELTA) {
                // A delta lobe reflects the light of one direction, which no reservoir can share.
                wanted = delta_ray(domain, turn - delta_turn, ray, reflectance);
            } else if (purpose == RAY_RARE) {
                Random own = pass_random(pixel, FIRST_STREAM + STREAM_RARE);
                float rare_pdf;
                LightSample drawn = draw_light_sample(receiver, true, 0u, random_bits(own), rare_pdf);
                rare = rare_light(domain, drawn, rare_pdf, bsdf_samples);
                float light = luminance(rare);
                // Roulette: where the candidate would add little to what was found, it seldom has a ray. A hidden light
                // that was selected has been dropped by now, and so does not make the ray less likely.
                chance = clamp(light / max(RARE_PART * stream.weight_sum, TINY), restir.at.reuse.rare_lights, 1.0);
                wanted = light > 0.0 && random_choice(own) <= chance;
                if (wanted) ray = shadow_ray(domain, drawn, CURRENT);
            } else {
                // What a BSDF ray hit is visible.
                wanted = VISIBILITY >= VISIBILITY_INITIAL && stream.chosen < light_samples;
                if (wanted) ray = shadow_ray(domain, reservoir.value, CURRENT);
            }
            if (!wanted) continue;
            // What a delta lobe reflects no other pixel shares, so a coin may decide for it.
            Hit hit = trace(ray, purpose >= RAY_SHADOW, purpose == RAY_DELTA ? ray_coin(random) : NO_COIN);
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
                    emission = environment_radiance(environment_place(ray.direction));
                } else {
                    GpuLight seen = light_at(light.index, CURRENT);
                    emission = light_emission(seen, light.index, light.place, -dot(seen.normal, ray.direction));
                }
                ADD_LIGHT(pixel, emission * reflectance)
                continue;
            }
            LightSample value = new_light_sample(light);
            float light_pdf = light_sample_pdf_own_measure(receiver, value.point, value.position);
            if (add_hit(stream, domain, value, light_pdf, light_samples + turn, choice, bsdf_samples)) reservoir.value = value;
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (turn < turns) count_fault(COUNTER_CUT_SHORT);
        if (stream.chosen != NONE) {
            reservoir.value = as_stored(reservoir.value);
            float target = target_function(domain, reservoir.value);
            if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
        }
        record_origin(reservoir, pixel_index(pixel), domain);
    }
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
