#version 460
// Initial candidates of direct light: light samples and hits of BSDF rays, weighed against each other by the balance
// heuristic. One of them is selected by resampled importance sampling.
#include "lights/sources.glsl"
#include "lights/hash_grid.glsl"
#include "restir/direct.glsl"
#include "restir/light_lists.glsl"
#include "restir/pilot.glsl"
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

// The number of BSDF candidates besides the pilot: more for narrow lobes, and where nearby pilots hit bright lights.
uint more_bsdf_samples(ivec2 pixel, Bsdf bsdf) {
    if (restir.at.more_bsdf_samples == 0u) return 0u;
    float squares = 0.0, count = 0.0;
    for (int y = -PILOT_REACH; y <= PILOT_REACH; y += 1) {
        for (int x = -PILOT_REACH; x <= PILOT_REACH; x += 1) {
            ivec2 other = pixel + ivec2(x, y);
            if (other == pixel || is_outside(other)) continue;
            squares += square(LOAD_PILOT_BRIGHTNESS(pilots, slot_of(uvec2(other))));
            count += 1.0;
        }
    }
    float limit = float(restir.at.more_bsdf_samples);
    // The optimal number is proportional to the standard deviation (Neyman). The root mean square is close to it where
    // hits are rare. Under a constant environment, where they are not, the deviation itself brought nothing: in `cornell`
    // .91 of the rays at 1.05 of the error, elsewhere the same of both.
    float for_brightness = MORE_FOR_BRIGHTNESS * sqrt(squares / max(count, 1.0));
    return uint(clamp(for_brightness, MORE_FOR_LOBE * limit * narrowness(bsdf), limit));
}

// The reservoirs of the hash grid that are merged with the pixel's candidates: as techniques of a merge, of which the pixel's
// candidates together are number 0.
struct GridTechniques {
    uint places[MAX_GRID_MERGED];
    uint claims[MAX_GRID_MERGED];
    uint count;
    // Of the pixel's candidates, of each reservoir, and of all of these together.
    float own_share;
    float share;
    float grid_share;
};

// Reservoirs of random places of the pixel's cell, or of a cell close by: otherwise the borders of cells would show.
GridTechniques grid_techniques(uvec2 pixel, Domain domain) {
    GridTechniques grid;
    grid.count = 0u;
    grid.own_share = 1.0;
    if (HASH_GRID == HASH_GRID_NONE || restir.at.frame >= restir.at.grid.until_frame) return grid;
    Random random = pass_random(pixel, STREAM_GRID + 1u);
    vec4 u = to_unit(random_bits(random));
    uint key = grid_key(domain.position, domain.geometric_normal, u.w, u.xyz - 0.5);
    uint merged = restir.at.grid.merged, reservoirs = restir.at.grid.reservoirs;
    for (uint i = 0u; i < merged; i += 1u) {
        float part = (float(i) + to_unit(random_bits(random).x)) / float(merged);
        uint place = grid_place(key, min(uint(part * float(reservoirs)), reservoirs - 1u));
        GpuGridPlace found = grid_places.at[place];
        if (found.claim == 0u || found.key != key) continue;
        grid.places[grid.count] = place;
        grid.claims[grid.count] = found.claim;
        grid.count += 1u;
    }
    float total = 1.0 + float(grid.count) * restir.at.grid.confidence;
    grid.own_share = 1.0 / total;
    grid.share = restir.at.grid.confidence / total;
    grid.grid_share = float(grid.count) * grid.share;
    return grid;
}

// As published, reservoirs of points count by their confidence alone.
uint grid_mis() { return HASH_GRID == HASH_GRID_POINTS ? MIS_CONSTANT : MIS_DEFENSIVE; }

// The MIS weight of the pixel's own candidates at a sample with this target.
float own_weight(GridTechniques grid, LightSample value, float target) {
    if (HASH_GRID == HASH_GRID_NONE || grid.count == 0u) return 1.0;
    MisTerms terms = empty_mis_terms();
    add_target(terms, 0u, 0u, target, grid.own_share, grid.own_share, grid.grid_share);
    for (uint i = 0u; i < grid.count && needs_target(grid_mis(), 0u, i + 1u); i += 1u) {
        Domain there;
        GRID_DOMAIN(grid.claims[i], there);
        add_target(terms, 0u, i + 1u, target_function(there, value), grid.share, grid.own_share, grid.grid_share);
    }
    return mis_weight(grid_mis(), 0u, terms, grid.own_share, grid.own_share, grid.grid_share);
}

// Merges the selected light sample with the reservoirs of the hash grid.
void merge_grid(GridTechniques grid, Domain domain, inout Stream stream, inout LightSample selected, inout Random random) {
    if (grid.count == 0u) return;
    bool has_own = stream.chosen != NONE;
    MisTerms own_terms = empty_mis_terms();
    add_target(own_terms, 0u, 0u, stream.target, grid.own_share, grid.own_share, grid.grid_share);
    Stream merged = empty_stream();
    LightSample drawn = selected;
    for (uint i = 0u; i < grid.count; i += 1u) {
        Domain there;
        GRID_DOMAIN(grid.claims[i], there);
        if (has_own && needs_target(grid_mis(), 0u, i + 1u)) {
            float target = target_function(there, selected);
            add_target(own_terms, 0u, i + 1u, target, grid.share, grid.own_share, grid.grid_share);
        }
        PackedReservoir packed;
        LOAD_RESERVOIR(grid_reservoirs, grid.places[i], restir.at.grid.places, packed);
        Reservoir reservoir = unpack_reservoir(packed);
        if (!(reservoir.contribution_weight > 0.0)) continue;
        MisTerms terms = empty_mis_terms();
        terms.canonical = target_function(domain, reservoir.value);
        terms.own = target_function(there, reservoir.value);
        float weight = mis_weight(grid_mis(), i + 1u, terms, grid.share, grid.own_share, grid.grid_share)
            * terms.canonical * reservoir.contribution_weight;
        // It needs a shadow ray, as every light sample.
        if (stream_add(merged, 0u, weight, terms.canonical, random_choice(random))) drawn = reservoir.value;
    }
    if (has_own) {
        float weight = mis_weight(grid_mis(), 0u, own_terms, grid.own_share, grid.own_share, grid.grid_share) * stream.weight_sum;
        if (stream_add(merged, stream.chosen, weight, stream.target, random_choice(random))) drawn = selected;
    }
    stream = merged;
    selected = drawn;
}

// Adds what a BSDF ray hit; returns whether it is selected now.
bool add_hit(inout Stream stream, GridTechniques grid, Domain domain, LightSample value, float light_pdf, uint index,
             float choice, uint bsdf_samples) {
    float target;
    float weight = candidate_weight(domain, value, light_pdf, bsdf_samples, target);
    if (weight > 0.0) weight *= own_weight(grid, value, target);
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
        bool mirror = is_mirror(domain.bsdf);
        prefer_narrow_lobe(domain.bsdf);
        uint light_samples = restir.at.reuse.light_samples, bsdf_samples = restir.at.bsdf_samples;
        if (PILOTS) bsdf_samples += more_bsdf_samples(ivec2(pixel), domain.bsdf);

        Stream stream = empty_stream();
        Receiver receiver;
        uint list = 0u;
        if (LIGHT_LISTS) {
            Random turn = pass_random(pixel, STREAM_TILES);
            list = list_word(tile_near(pixel, random_bits(turn).xy));
            LOAD_RECEIVER(light_lists, list, receiver);
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
                value = near_light_sample(receiver, light_lists.at[entry], near, bits, light_pdf);
            } else {
                value = draw_light_sample(receiver, i, bits, light_pdf);
            }
            float target;
            float weight = candidate_weight(domain, value, light_pdf, bsdf_samples, target);
            if (stream_add(stream, i, weight, target, choice)) reservoir.value = value;
        }
        GridTechniques grid = grid_techniques(pixel, domain);
        if (HASH_GRID != HASH_GRID_NONE) merge_grid(grid, domain, stream, reservoir.value, random);

        Pilot pilot = Pilot(NONE, NONE, vec2(0.0), 0.0);
        if (PILOTS) pilot = LOAD_PILOT(pilots, slot);
        LightPoint pilot_light = light_found(pilot);
        if (pilot_light.kind != LIGHT_NONE) {
            LightSample value = new_light_sample(pilot_light);
            float light_pdf = light_sample_pdf_own_measure(receiver, value.point, value.position);
            float choice = random_choice(random);
            if (add_hit(stream, grid, domain, value, light_pdf, light_samples, choice, bsdf_samples)) reservoir.value = value;
        }

        // The BSDF candidates, of which the pilot is the first, then the mirror's ray, then the shadow ray of the
        // selected candidate.
        uint turns = bsdf_samples + 2u;
        uint turn = PILOTS ? 1u : 0u;
        for (; turn < turns; turn += 1u) {
            uint purpose = turn < bsdf_samples ? RAY_CANDIDATE : turn == bsdf_samples ? RAY_MIRROR : RAY_SHADOW;
            Ray ray;
            bool wanted;
            float choice = 0.0;
            if (purpose == RAY_CANDIDATE) {
                vec4 numbers = to_unit(random_bits(random));
                choice = random_choice(random);
                BsdfSample chosen;
                wanted = sample_bsdf_ray(domain, numbers, chosen, ray);
            } else if (purpose == RAY_MIRROR) {
                // A mirror reflects the light of one direction, which no reservoir can share.
                wanted = mirror && mirror_ray(domain, ray);
            } else {
                // What a BSDF ray hit is visible.
                wanted = VISIBILITY >= VISIBILITY_INITIAL && stream.chosen < light_samples;
                if (wanted) ray = shadow_ray(domain, reservoir.value, CURRENT);
            }
            if (!wanted) continue;
            // What a mirror reflects no other pixel shares, so a coin may decide for it.
            Hit hit = trace(ray, purpose == RAY_SHADOW, purpose == RAY_MIRROR ? ray_coin(random) : NO_COIN);
            if (purpose == RAY_SHADOW) {
                if (hit.transmittance == 0.0) stream = empty_stream();
                continue;
            }
            LightPoint light = light_found(hit, ray.direction);
            if (light.kind == LIGHT_NONE) continue;
            if (purpose == RAY_MIRROR) {
                vec3 emission;
                if (is_environment(light.kind)) {
                    emission = environment_radiance(environment_place(ray.direction));
                } else {
                    GpuLight seen = light_at(light.index, CURRENT);
                    emission = light_emission(seen, light.index, light.place, -dot(seen.normal, ray.direction));
                }
                color.at[pixel_index(pixel)] += accept_radiance(emission * specular_fresnel(domain.bsdf, domain.outgoing.z));
                continue;
            }
            LightSample value = new_light_sample(light);
            float light_pdf = light_sample_pdf_own_measure(receiver, value.point, value.position);
            if (add_hit(stream, grid, domain, value, light_pdf, light_samples + turn, choice, bsdf_samples)) reservoir.value = value;
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
