#version 460
// Initial candidates of indirect light: one of the lights that a path finds is selected for the pixel's reservoir by
// resampled importance sampling. Light that only this pixel can use is added to its colour at once.
#include "restir/samples/indirect.glsl"
#include "restir/samples/path_candidates.glsl"
#include "restir/reservoir.glsl"
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
// Holds each pixel's pilot until its reservoir is written.
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// The selection so far.
Stream stream;
PathSample chosen;
// Light that only this pixel can use.
vec3 not_reusable;

void add_candidate(Candidate found, float choice) {
    if (!found.is_reusable || !USES_RESERVOIRS) not_reusable += found.light;
    else if (stream_add(stream, 0u, luminance(found.light), 1.0, choice)) chosen = found.value;
}

void main() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    // Empty or not, it has the confidence of one initial reservoir.
    Reservoir reservoir = empty_reservoir(1.0);
    PackedReservoir packed = pack_reservoir(reservoir);
    if (has_surface(data) && scene.at.light_count > 0u) {
        ShadingPoint eye = unpack_shading_point(data, primary_ray(pixel));
        prefer_narrow_lobes(eye.bsdf);
        Pilot pilot = LOAD_PILOT(reservoirs, slot);
        Random random = pass_random(pixel, FIRST_STREAM + STREAM_INITIAL);
        stream = empty_stream();
        chosen = empty_path_sample();
        not_reusable = vec3(0.0);

        // First the paths that delta lobes reflect, then the path that begins with the pilot.
        uint paths_begun = 0u;
        Path path;
        uint purpose = RAY_NONE;
        Ray ray;
        // While a shadow ray is traced: the path's next ray and its purpose, and the candidate to be decided on.
        Ray next;
        uint next_purpose = RAY_NONE;
        Candidate shadowed;
        float choice = 0.0;
        while (true) {
            if (purpose == RAY_NONE) {
                paths_begun += 1u;
                if (paths_begun > MAX_DELTA_LOBES + 1u) break;
                if (paths_begun <= MAX_DELTA_LOBES) {
                    vec3 reflectance;
                    if (delta_ray(eye, paths_begun - 1u, ray, reflectance)) purpose = RAY_PATH;
                    path = delta_path(paths_begun, reflectance, medium_left(eye, ray.direction));
                } else {
                    BsdfSample first;
                    // A pilot passes surfaces that cover a part; a random number decides whether a path ends there.
                    if (HAS_BLEND) {
                        if (pilot_ray(eye, pixel, first, ray)) purpose = RAY_PATH;
                    } else if (pilot.instance != NONE && pilot_ray(eye, pixel, first, ray)) {
                        purpose = RAY_PILOT;
                    }
                    path = first_path(first, medium_left(eye, ray.direction));
                }
                continue;
            }
            Hit hit = pilot_hit(pilot);
            if (purpose != RAY_PILOT) {
                hit = trace(ray, purpose == RAY_SHADOW, purpose == RAY_SHADOW ? NO_ALPHA_RANDOM : draw_alpha_random(random));
            }
            if (purpose == RAY_SHADOW) {
                shadowed.light *= hit.transmittance;
                if (hit.transmittance > 0.0) add_candidate(shadowed, choice);
                ray = next;
                purpose = next_purpose;
                continue;
            }
            if (hit.instance == NONE) {
                if (sees_environment() && !left_first(path)) {
                    add_candidate(environment_hit(path, ray.direction), random_choice(random));
                }
                purpose = RAY_NONE;
                continue;
            }
            Surface surface = surface_at(hit, ray);
            if (purpose == RAY_PILOT) hit.t = distance(surface.position, ray.origin);
            if (HAS_TRANSMISSION) pass_medium(path, path.medium, hit.t);
            if (left_first(path)) {
                path.second.instance = hit.instance;
                path.second.primitive = hit.primitive;
                path.second.uv = uv_of(hit, surface.position);
            } else if (surface.light != NONE) {
                // Emission at the second vertex belongs to direct light.
                add_candidate(light_hit(path, surface.light, hit, ray.direction), random_choice(random));
            }
            // Emitted light knows no medium that only the surface knows.
            if (HAS_TRANSMISSION && !is_medium(path.medium) && surface.layers.inside) {
                pass_medium(path, medium_behind(surface.layers), hit.t);
            }
            if (path.scatterings >= restir.at.view.bounces) {
                purpose = RAY_NONE;
                continue;
            }
            ShadingPoint vertex = make_shading_point(surface.position, surface.clearance,
                                        surface.back_off, surface.geometric_normal, surface.shading_normal, surface.material,
                                        surface.layers, ray.direction);
            // Later vertices add little, and their walks through the light BVH would take more time than they save.
            LightSampleContext context = distant_context();
            if (left_first(path)) context = light_sample_context(vertex);
            bool shadow = sample_light_at(path, vertex, context, slot, random, shadowed, ray);
            vec4 numbers = to_unit(random_bits(random));
            choice = random_choice(random);
            next_purpose = scatter(path, vertex, context, numbers, next) ? RAY_PATH : RAY_NONE;
            if (shadow) {
                purpose = RAY_SHADOW;
            } else {
                ray = next;
                purpose = next_purpose;
            }
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (paths_begun <= 2u) count_fault(COUNTER_CUT_SHORT);
        ADD_LIGHT(pixel, not_reusable)

        if (stream.chosen != NONE) {
            place_vertex(chosen, CURRENT);
            chosen = as_stored(chosen);
            if (BIASED_SHIFT) {
                chosen.radiance = outgoing_radiance(chosen, normalize(chosen.point.position - eye.position));
                chosen.kind = PATH_OUTGOING;
                chosen = as_stored(chosen);
            }
            float target = target_function(eye, chosen);
            // The random numbers that let the path pass were part of its density. Whoever adds its light multiplies it by the
            // transmittance again, his own for the first segment.
            if (HAS_BLEND && target > 0.0) target *= trace_segments(eye, chosen, CURRENT);
            if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
            if (chosen.kind != PATH_TO_LIGHT) round_color(chosen, to_unit(random_bits(random)).xyz);
            reservoir.value = chosen;
            record_origin(reservoir, pixel_index(pixel), eye);
            packed = pack_reservoir(reservoir);
        }
    }
    if (USES_RESERVOIRS) STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
