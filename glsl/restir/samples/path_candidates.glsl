#pragma once
// Candidates of indirect light: a path with next-event estimation at every vertex but the first. Each light that the
// path finds is one candidate.
#include "core/roulette.glsl"
#include "lights/samplers/sources.glsl"
#include "restir/samples/path_sample.glsl"
#include "restir/samples/pilot.glsl"
#include "world_reservoirs/world_reservoirs.glsl"

// A path under construction.
struct Path {
    // Product of f · cosine / density.
    vec3 throughput;
    // The same for the vertices after the second, without roulette: the radiance of a sample is made of it. MIS weights
    // and roulette are part of the contribution weight instead. Densities of directions could be too, since they do not
    // depend on the viewer, but chains of narrow lobes would leave the range of f32.
    vec3 suffix_throughput;
    uint scatterings;
    // The vertex that the current ray left, and the density of the ray, for the MIS weight of a light that it hits.
    LightSampleContext context;
    float pdf_solid_angle;
    // The distance within which the ray finds no lights that are no larger: `near_distance`.
    float near;
    // True if the current ray follows a delta lobe.
    bool delta;
    // 0 for the path that begins with the pilot; else 1 + the index of the delta lobe, at the surface that the camera sees, with
    // which it begins.
    uint first_lobe;
    // Whether its samples can be shared: not with a delta lobe at one of the first two vertices, to which no reconnection
    // exists.
    bool is_reusable;
    // The second vertex, once it is known, and the direction in which the path continues from there.
    PathSample second;
    // The medium of the current ray, as its start knows it.
    vec3 medium;
};

// A light that a path found.
struct Candidate {
    // Its contribution to the pixel if it were the only candidate.
    vec3 light;
    bool is_reusable;
    PathSample value;
};

// The path that begins with a delta lobe. Lights that the first ray hits belong to direct light, so that nothing asks
// for the context that it left.
Path delta_path(uint first_lobe, vec3 reflectance, vec3 medium) {
    return Path(reflectance, vec3(1.0), 1u, distant_context(), 0.0, 0.0, true, first_lobe, false, empty_path_sample(), medium);
}

// The path that begins with the pixel's pilot ray.
Path first_path(BsdfSample first, vec3 medium) {
    return Path(first.weight, vec3(1.0), 1u, distant_context(), first.pdf_solid_angle, 0.0, false, 0u, true, empty_path_sample(), medium);
}

// Whether the current ray started at the first vertex, or at the second.
bool left_first(Path path) { return path.scatterings == 1u; }
bool left_second(Path path) { return path.scatterings == 2u; }

// Weakens the path by a length of a medium. The first segment belongs to no sample: each viewer has his own.
void pass_medium(inout Path path, vec3 medium, float length) {
    vec3 passed = passed_light(medium, length);
    path.throughput *= passed;
    if (!left_first(path)) path.suffix_throughput *= passed;
}

// The number of light samples of a vertex, in the mean. Those among rare lights take the place of the others.
float vertex_samples() {
    return float(restir.at.reuse.light_samples) * (RARE_LIGHTS ? 1.0 - restir.at.reuse.rare_lights : 1.0);
}

// The sum of the densities of a vertex' light samples at a point, in its own measure.
float vertex_pdf_own_measure(LightSampleContext context, LightPoint point, vec3 direction) {
    if (rare_probability(point) > 0.0) return restir.at.reuse.rare_lights * rare_pdf_own_measure(point, direction);
    return vertex_samples() * light_sample_pdf_own_measure(context, point, direction);
}

// The MIS weight of a vertex' light samples against the BSDF ray that leaves it, for a point that the ray would find with a
// density of `bsdf_pdf` in the point's measure; `found_light` has that of the ray. It counts the vertex' own samples alone:
// counting those of merged reservoirs as well gave more outliers.
float light_sampling_fraction(LightSampleContext context, LightSample value, float bsdf_pdf) {
    return fraction_of(vertex_pdf_own_measure(context, value.point, value.position), bsdf_pdf);
}

// The candidate of a path that ends at a light: `directly` from its second vertex, or from a later vertex. `radiance` is
// what arrives, or the light that the last vertex reflects.
Candidate make_candidate(Path path, vec3 light, bool directly, LightPoint end, vec3 radiance) {
    Candidate found = Candidate(light, path.is_reusable, path.second);
    found.value.kind = directly ? PATH_TO_LIGHT : PATH_ONWARD;
    found.value.end = end;
    found.value.radiance = path.suffix_throughput * radiance;
    return found;
}

// The light that a BSDF ray found, weighed against next-event estimation at the previous vertex, whose samples find the same
// point with densities whose sum is `pdf_solid_angle`.
Candidate found_light(Path path, LightPoint end, vec3 radiance, float pdf_solid_angle) {
    float weight = 1.0;
    if (!path.delta) {
        weight = 1.0 / (1.0 + pdf_solid_angle / path.pdf_solid_angle);
    }
    return make_candidate(path, path.throughput * radiance * weight, left_second(path), end, radiance);
}

// The light that a ray hit.
Candidate light_hit(Path path, uint index, Hit hit, vec3 direction) {
    LightPoint end = LightPoint(LIGHT_TRIANGLE, index, hit.barycentrics);
    GpuLight light = light_at(index, CURRENT);
    float cosine = -dot(light.normal, direction);
    vec3 emission = hit_emission(light, index, stored_uv(end.uv), cosine);
    if (max(hit.t, sqrt(light.area)) < path.near || (is_blended(light) && !path.delta)) emission = vec3(0.0);
    float pdf_area = vertex_pdf_own_measure(path.context, end, direction);
    return found_light(path, end, emission, area_to_solid_angle(pdf_area, square(hit.t), cosine));
}

// The light of the environment in the direction of a ray that hit nothing.
Candidate environment_hit(Path path, vec3 direction) {
    LightSample value = new_light_sample(environment_point(direction));
    float pdf_solid_angle = vertex_pdf_own_measure(path.context, value.point, value.position);
    return found_light(path, value.point, value.emission, pdf_solid_angle);
}

// Whether the vertex at the end of the current ray has a world reservoir.
bool has_world_reservoirs(Path path) {
    return WORLD_RESERVOIRS != WORLD_RESERVOIRS_NONE && path.scatterings <= restir.at.world.depth;
}

// Next-event estimation at a vertex: selects one of several light samples by their reflected light (RIS) and, with world
// reservoirs, merges it with some of the previous frame. `slot` is that of the path's pixel. Returns whether its shadow ray
// must be traced.
bool sample_light_at(Path path, ShadingPoint vertex, LightSampleContext context, uint slot, inout Random random, out Candidate found, out Ray ray) {
    bool rare = RARE_LIGHTS && random_choice(random) <= restir.at.reuse.rare_lights;
    // In this order: a constant comes first, so that without world reservoirs no code of theirs is left, nor a binding.
    bool in_world = has_world_reservoirs(path) && !rare;
    // BSDF rays share the light with the samples; but not in a weight that other vertices take over.
    uint bsdf_samples = in_world ? 0u : 1u;
    float light_samples = rare ? restir.at.reuse.rare_lights : in_world ? float(restir.at.reuse.light_samples) : vertex_samples();
    // At each vertex the paths of a pixel have random streams of their own.
    Random world_random =
        pass_random(invocation_pixel(), STREAM_WORLD + (MAX_DELTA_LOBES + 1u) * path.scatterings + path.first_lobe);
    uint normal = pack_octahedral(vertex.geometric_normal);
    // The shading point that resamples, and that of the reservoir which is kept.
    ShadingPoint resampling = vertex, stored = vertex;
    bool keeps_merged = false;
    if (in_world) {
        stored = matte_point(vertex.position, unpack_octahedral(normal));
        keeps_merged = keeps_merged_reservoir(vertex, normal);
        // What the vertex can select and what the stored point can must be the same, to the last bit of the normal.
        if (keeps_merged) resampling = with_normals_of(vertex, stored);
    }
    // Its own selection, and the one that it keeps for others.
    Stream points = empty_stream(), kept = empty_stream();
    LightReservoir own = empty_light_reservoir(1.0), for_others = empty_light_reservoir(1.0);
    for (uint i = 0u; i < (rare ? 1u : restir.at.reuse.light_samples); i += 1u) {
        uvec4 bits = random_bits(random);
        float choice = random_choice(random);
        float light_pdf, target;
        LightSample value = draw_light_sample(context, rare, i, bits, light_pdf);
        float weight = candidate_weight(resampling, value, light_pdf, light_samples, bsdf_samples, target);
        if (stream_add(points, i, weight, target, choice)) own.value = value;
        if (in_world && !keeps_merged) {
            weight = candidate_weight(stored, value, light_pdf, light_samples, 0u, target);
            if (stream_add(kept, i, weight, target, random_choice(world_random))) for_others.value = value;
        }
    }
    own.contribution_weight = contribution_weight(points);
    if (in_world) {
        own.contribution_weight = accept_weight(own.contribution_weight);
        for_others.contribution_weight = accept_weight(contribution_weight(kept));
        own = merge_world(resampling, own, world_random);
        if (keeps_merged) for_others = own;
        // The paths of delta lobes have no slots.
        if (path.first_lobe == 0u) {
            keep_world_reservoir((path.scatterings - 1u) * restir.at.slots + slot, vertex.position, normal, for_others,
                                 to_unit(random_bits(world_random).x));
        }
    }
    if (!(own.contribution_weight > 0.0)) return false;
    LightSample point = own.value;
    vec3 direction;
    float solid_angle, pdf_solid_angle;
    vec3 radiance = arriving_radiance(point, vertex.position, vertex.back_off, direction, solid_angle);
    vec3 reflected = reflected_light(vertex, direction, radiance, pdf_solid_angle);
    if (HAS_TRANSMISSION) reflected *= passed_to(vertex, point, direction);
    vec3 light = path.throughput * reflected * (solid_angle * own.contribution_weight);
    if (in_world && found_by_rays(vertex, point)) light *= light_sampling_fraction(context, point, pdf_solid_angle * solid_angle);
    // A merged reservoir counts as if the vertex always had one.
    if (RARE_LIGHTS && in_world) light /= 1.0 - restir.at.reuse.rare_lights;
    found = make_candidate(path, light, left_first(path), point.point, reflected);
    ray = shadow_ray(vertex, point, CURRENT);
    return max_component(found.light) > 0.0;
}

// Samples the path's next ray at a vertex; returns whether the path continues.
bool scatter(inout Path path, ShadingPoint vertex, LightSampleContext context, vec4 numbers, out Ray next) {
    BsdfSample onward;
    bool alive = sample_bsdf_ray(vertex, numbers, onward, next);
    path.throughput *= onward.weight;
    if (left_first(path)) {
        path.second.direction = next.direction;
        path.is_reusable = path.is_reusable && !onward.delta;
    } else {
        path.suffix_throughput *= onward.weight;
    }
    path.scatterings += 1u;
    path.context = context;
    path.pdf_solid_angle = onward.pdf_solid_angle;
    path.near = onward.delta ? 0.0 : near_distance(vertex);
    path.delta = onward.delta;
    if (HAS_TRANSMISSION) path.medium = medium_left(vertex, next.direction);
    return survives_roulette(path.throughput, path.scatterings, restir.at.view.roulette_start, restir.at.view.roulette_floor, numbers.w)
        && alive;
}
