#version 460
// Initial candidates of indirect light: a path with next-event estimation at every vertex but the first. Each
// light that it finds is a candidate for the pixel's reservoir, one of them chosen by resampled importance
// sampling; what none but this pixel can use is added to its colour at once.
#define INDIRECT
#include "restir.glsl"
#include "candidates.glsl"

layout(local_size_x = TILE * TILE) in;

// Whether candidates go to reservoirs at all; else this is path tracing.
layout(constant_id = 14) const bool SHARES = true;
layout(constant_id = 15) const bool BIASED_SHIFT = false;

layout(scalar) readonly buffer SampleDataBlock { SampleData at[]; } sample_data;
// Until a pixel's reservoir is written, its pilot lies there.
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;
layout(scalar) buffer ColorBlock { vec3 at[]; } color;

// How a path under way came to where it is.
struct Path {
    // Product of f · cosine / density.
    vec3 throughput;
    // The same beyond the second vertex and without roulette: what a sample's radiance is made of. Weights between
    // techniques and roulette stand in its contribution weight. Densities of directions there could too, since
    // they are the same whoever looks, but chains of narrow lobes would leave the range of f32.
    vec3 beyond;
    uint scatterings;
    // How the ray under way was sampled: for weighing the light that it may hit.
    float pdf_solid_angle;
    bool mirror;
    // Whether its samples can be shared: no mirror at the first two vertices, which nobody could reconnect to.
    bool can_share;
};

// What is chosen so far.
Stream stream;
IndirectSample chosen;
// What only this pixel can use.
vec3 unshared;

// Offers what a path found; `found` says where it ends.
void offer_path(bool can_share, vec3 light, IndirectSample found, float choice) {
    if (!can_share || !SHARES) unshared += light;
    else if (stream_add(stream, 0u, luminance(light), 1.0, choice)) chosen = found;
}

// A path as it ends: at a light straight from its second vertex, or further on with this radiance from there.
IndirectSample ended(IndirectSample here, bool at_once, uint light, uint barycentrics, vec3 radiance) {
    here.kind = at_once ? PATH_TO_LIGHT : PATH_ONWARD;
    here.light = light;
    here.light_barycentrics = barycentrics;
    here.radiance = radiance;
    return here;
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
        Ray ray = primary_ray(pixel);
        Domain eye = unpack_domain(data, ray);
        bool mirror = is_mirror(eye.bsdf);
        vec3 mirrored = specular_fresnel(eye.bsdf, eye.outgoing.z);
        prefer_narrow_lobe(eye.bsdf);
        Pilot pilot = LOAD_PILOT(reservoirs, slot);
        bool evenly = restir.at.uniform_candidates != 0u;
        Random random = kind_random(pixel, PASS_INITIAL);
        stream = empty_stream();
        chosen = empty_sample();
        unshared = vec3(0.0);
        // The path's second vertex; and, while a shadow ray is on its way, what it decides on.
        IndirectSample here = empty_sample(), there = empty_sample();
        vec3 light_arrives = vec3(0.0);
        bool light_shared = false;
        float choice = 0.0;

        // One trace a turn: what a mirror shows and on, then the path that begins with the pilot's ray.
        Path path;
        Ray next;
        bool alive = false, next_alive = false, shadow = false, met = false;
        uint begun = 0u;
        while (true) {
            if (!alive) {
                begun += 1u;
                if (begun > 2u) break;
                if (begun == 1u) {
                    alive = mirror && mirror_ray(eye, ray);
                    path = Path(mirrored, vec3(1.0), 1u, 0.0, true, false);
                } else {
                    BsdfSample first;
                    alive = pilot.instance != NONE && pilot_ray(eye, pixel, first, ray);
                    path = Path(first.weight, vec3(1.0), 1u, first.pdf_solid_angle, false, true);
                    met = true;
                }
                continue;
            }
            Hit hit = pilot_hit(pilot);
            if (!met) hit = trace(ray, shadow);
            if (shadow) {
                if (hit.instance == NONE) offer_path(light_shared, light_arrives, there, choice);
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
            bool at_second = path.scatterings == 1u, at_third = path.scatterings == 2u;
            if (at_second) {
                here.instance = hit.instance;
                here.primitive = hit.primitive;
                here.barycentrics = hit.barycentrics;
            }
            // What the first vertex sees of a light is direct light.
            if (surface.light != NONE && !at_second) {
                GpuLight light = light_at(surface.light);
                float cosine = -dot(light.normal, ray.direction);
                vec3 emission = light_emission(light, cosine);
                float weight = 1.0;
                if (!path.mirror) {
                    float pdf_area = light_sample_pdf_area(restir.at.lights, evenly, surface.light);
                    float pdf_light = area_to_solid_angle(pdf_area, square(hit.t), cosine);
                    weight = 1.0 / (1.0 + float(restir.at.light_samples) * (pdf_light / path.pdf_solid_angle));
                }
                IndirectSample found = ended(here, at_third, surface.light, packUnorm2x16(hit.barycentrics), path.beyond * emission);
                offer_path(path.can_share, path.throughput * emission * weight, found, to_unit(random_bits(random).x));
            }
            if (path.scatterings >= restir.at.bounces) {
                alive = false;
                continue;
            }
            surface.position -= way_back(surface.error, hit.t) * ray.direction;
            Domain vertex = make_domain(surface.position, clearance_of(surface.geometric_normal, surface.error),
                                        surface.geometric_normal, surface.shading_normal, surface.material, ray.direction);

            Stream points = empty_stream();
            LightSample point;
            for (uint i = 0u; i < restir.at.light_samples; i += 1u) {
                uvec4 bits = random_bits(random);
                float u = to_unit(random_bits(random).x);
                LightSample value = sample_lights(restir.at.lights, evenly, bits);
                float target;
                float weight = candidate_weight(vertex, value, 1u, target);
                if (stream_add(points, i, weight, target, u)) point = value;
            }
            vec4 numbers = to_unit(random_bits(random));
            choice = to_unit(random_bits(random).x);
            Ray to_light;
            if (points.chosen != NONE) {
                vec3 direction;
                float cosine, pdf_solid_angle;
                float spread = spread_of(vertex.position, point.position, point.normal, direction, cosine);
                vec3 reflected = reflected_light(vertex, direction, point.emission, pdf_solid_angle);
                light_arrives = path.throughput * reflected * (spread * contribution_weight(points));
                shadow = max_component(light_arrives) > 0.0;
                there = ended(here, at_second, point.light, point.barycentrics, path.beyond * reflected);
                light_shared = path.can_share;
                to_light = shadow_ray(vertex, point);
            }

            BsdfSample onward;
            next_alive = sample_bsdf_ray(vertex, numbers, onward, next);
            path.throughput *= onward.weight;
            if (at_second) here.direction = next.direction;
            else path.beyond *= onward.weight;
            path.scatterings += 1u;
            path.pdf_solid_angle = onward.pdf_solid_angle;
            path.mirror = onward.mirror;
            if (at_second && onward.mirror) path.can_share = false;
            if (path.scatterings >= restir.at.roulette_start) {
                float survival = clamp(max_component(path.throughput), restir.at.roulette_floor, 1.0);
                next_alive = next_alive && numbers.w < survival;
                path.throughput /= survival;
            }
            if (shadow) {
                ray = to_light;
            } else {
                ray = next;
                alive = next_alive;
            }
        }
        // A driver may end a loop that seems endless to it; the pixel would then lack light.
        if (begun <= 2u) count_fault(COUNTER_CUT_SHORT);
        uint index = pixel.y * restir.at.width + pixel.x;
        color.at[index] += accept_radiance(unshared);

        if (stream.chosen != NONE) {
            place_vertex(chosen, chosen.instance);
            reservoir.value = stored(chosen, random);
            if (BIASED_SHIFT) {
                vec3 direction = normalize(reservoir.value.point.position - eye.position);
                reservoir.value.radiance = outgoing_radiance(reservoir.value, direction);
                reservoir.value.kind = PATH_OUTGOING;
                reservoir.value = stored(reservoir.value, random);
            }
            float target = target_function(eye, reservoir.value);
            if (target > 0.0) reservoir.contribution_weight = accept_weight(stream.weight_sum / target);
            mark_origin(reservoir, pixel, eye);
            packed = pack_reservoir(reservoir);
        }
    }
    if (SHARES) STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
