#version 460
// Initial candidates of indirect light: of all that a path finds, one is chosen for the pixel's reservoir by
// resampled importance sampling; what none but this pixel can use is added to its colour at once.
#define INDIRECT
#include "restir.glsl"
#include "candidates.glsl"
#include "indirect_candidates.glsl"

layout(local_size_x = TILE * TILE) in;

// Whether candidates go to reservoirs at all; else this is path tracing.
layout(constant_id = 14) const bool SHARES = true;
layout(constant_id = 15) const bool BIASED_SHIFT = false;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
// Until a pixel's reservoir is written, its pilot lies there.
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// What is chosen so far.
Stream stream;
IndirectSample chosen;
// What only this pixel can use.
vec3 unshared;

void offer(Candidate found, float choice) {
    if (!found.can_share || !SHARES) unshared += found.light;
    else if (stream_add(stream, 0u, luminance(found.light), 1.0, choice)) chosen = found.value;
}

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = sample_data.at[slot];
    // Empty or not, it counts as one attempt.
    Reservoir reservoir = empty_reservoir(1.0);
    PackedReservoir packed = pack_reservoir(reservoir);
    if (has_surface(data) && restir.at.lights > 0u) {
        Domain eye = unpack_domain(data, primary_ray(pixel));
        bool mirror = is_mirror(eye.bsdf);
        vec3 mirrored = specular_fresnel(eye.bsdf, eye.outgoing.z);
        prefer_narrow_lobe(eye.bsdf);
        Pilot pilot = LOAD_PILOT(reservoirs, slot);
        Random random = kind_random(pixel, PASS_INITIAL);
        stream = empty_stream();
        chosen = empty_sample();
        unshared = vec3(0.0);

        // One trace a turn: what a mirror shows and on, then the path that begins with the pilot's ray.
        Path path;
        Ray ray, next;
        // What a shadow ray on its way decides on.
        Candidate looked_for;
        float choice = 0.0;
        bool alive = false, next_alive = false, shadow = false, met = false;
        uint begun = 0u;
        while (true) {
            if (!alive) {
                begun += 1u;
                if (begun > 2u) break;
                if (begun == 1u) {
                    alive = mirror && mirror_ray(eye, ray);
                    path = mirror_path(mirrored);
                } else {
                    BsdfSample first;
                    alive = pilot.instance != NONE && pilot_ray(eye, pixel, first, ray);
                    path = first_path(first);
                    met = true;
                }
                continue;
            }
            Hit hit = pilot_hit(pilot);
            if (!met) hit = trace(ray, shadow);
            if (shadow) {
                if (hit.instance == NONE) offer(looked_for, choice);
                shadow = false;
                ray = next;
                alive = next_alive;
                continue;
            }
            if (hit.instance == NONE) {
                alive = false;
                continue;
            }
            Surface surface = surface_at(hit, ray);
            if (met) hit.t = distance(surface.position, ray.origin);
            met = false;
            if (left_first(path)) {
                path.second.instance = hit.instance;
                path.second.primitive = hit.primitive;
                path.second.barycentrics = hit.barycentrics;
            } else if (surface.light != NONE) {
                // Of what the first vertex sees of a light direct light takes care.
                offer(light_hit(path, surface.light, hit, ray.direction), to_unit(random_bits(random).x));
            }
            if (path.scatterings >= restir.at.bounces) {
                alive = false;
                continue;
            }
            surface.position -= way_back(surface.error, hit.t) * ray.direction;
            Domain vertex = make_domain(surface.position, clearance_of(surface.geometric_normal, surface.error),
                                        surface.geometric_normal, surface.shading_normal, surface.material, ray.direction);
            shadow = look_for_light(path, vertex, random, looked_for, ray);
            vec4 numbers = to_unit(random_bits(random));
            choice = to_unit(random_bits(random).x);
            next_alive = scatter(path, vertex, numbers, next);
            if (!shadow) {
                ray = next;
                alive = next_alive;
            }
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (begun <= 2u) count_fault(COUNTER_CUT_SHORT);
        color.at[number_of(pixel)] += accept_radiance(unshared);

        if (stream.chosen != NONE) {
            place_vertex(chosen, chosen.instance);
            chosen = stored(chosen);
            if (BIASED_SHIFT) {
                chosen.radiance = outgoing_radiance(chosen, normalize(chosen.point.position - eye.position));
                chosen.kind = PATH_OUTGOING;
                chosen = stored(chosen);
            }
            float target = target_function(eye, chosen);
            if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
            if (chosen.kind != PATH_TO_LIGHT) round_color(chosen, random);
            reservoir.value = chosen;
            mark_origin(reservoir, number_of(pixel), eye);
            packed = pack_reservoir(reservoir);
        }
    }
    if (SHARES) STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
