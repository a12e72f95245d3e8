// Candidates of indirect light: a path with next-event estimation at every vertex but the first. Each light that
// it finds is one.
#include "roulette.glsl"

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
    // The second vertex, once it is known, and the direction in which the path goes on from there.
    IndirectSample second;
};

// A light that a path found.
struct Candidate {
    // What it adds to the pixel if no other is a candidate.
    vec3 light;
    bool can_share;
    // The path as others may take it over.
    IndirectSample value;
};

// The path of what a mirror shows.
Path mirror_path(vec3 reflectance) { return Path(reflectance, vec3(1.0), 1u, 0.0, true, false, empty_sample()); }

// The path that begins with a pixel's first BSDF ray.
Path first_path(BsdfSample first) {
    return Path(first.weight, vec3(1.0), 1u, first.pdf_solid_angle, false, true, empty_sample());
}

// Whether the ray under way left the first vertex, or the second.
bool left_first(Path path) { return path.scatterings == 1u; }
bool left_second(Path path) { return path.scatterings == 2u; }

// What a path found as it ends: at a light straight from its second vertex, or further on with this radiance from
// there.
Candidate found_by(Path path, vec3 light, bool at_once, uint number, uint barycentrics, vec3 radiance) {
    Candidate found = Candidate(light, path.can_share, path.second);
    found.value.kind = at_once ? PATH_TO_LIGHT : PATH_ONWARD;
    found.value.light = number;
    found.value.light_barycentrics = barycentrics;
    found.value.radiance = path.beyond * radiance;
    return found;
}

// The light that a path's ray has hit, which the vertex before could also have looked for.
Candidate light_hit(Path path, uint number, Hit hit, vec3 direction) {
    GpuLight light = light_at(number);
    float cosine = -dot(light.normal, direction);
    vec3 emission = light_emission(light, cosine);
    float weight = 1.0;
    if (!path.mirror) {
        float pdf_area = light_sample_pdf_area(restir.at.lights, restir.at.uniform_candidates != 0u, number);
        float pdf_light = area_to_solid_angle(pdf_area, square(hit.t), cosine);
        weight = 1.0 / (1.0 + float(restir.at.light_samples) * (pdf_light / path.pdf_solid_angle));
    }
    return found_by(path, path.throughput * emission * weight, left_second(path), number,
                    packUnorm2x16(hit.barycentrics), emission);
}

// Looks for a light from a vertex: one of several points, by what it would reflect of each. Returns whether the
// ray is to be traced that decides on it.
bool look_for_light(Path path, Domain vertex, inout Random random, out Candidate found, out Ray ray) {
    Stream points = empty_stream();
    LightSample point;
    for (uint i = 0u; i < restir.at.light_samples; i += 1u) {
        uvec4 bits = random_bits(random);
        float choice = to_unit(random_bits(random).x);
        LightSample value = sample_lights(restir.at.lights, restir.at.uniform_candidates != 0u, bits);
        float target;
        float weight = candidate_weight(vertex, value, 1u, target);
        if (stream_add(points, i, weight, target, choice)) point = value;
    }
    if (points.chosen == NONE) return false;
    vec3 direction;
    float cosine, pdf_solid_angle;
    float spread = spread_of(vertex.position, point.position, point.normal, direction, cosine);
    vec3 reflected = reflected_light(vertex, direction, point.emission, pdf_solid_angle);
    found = found_by(path, path.throughput * reflected * (spread * contribution_weight(points)), left_first(path),
                     point.light, point.barycentrics, reflected);
    ray = shadow_ray(vertex, point);
    return max_component(found.light) > 0.0;
}

// Sends the path on from a vertex; returns whether it goes on.
bool scatter(inout Path path, Domain vertex, vec4 numbers, out Ray next) {
    BsdfSample onward;
    bool alive = sample_bsdf_ray(vertex, numbers, onward, next);
    path.throughput *= onward.weight;
    if (left_first(path)) {
        path.second.direction = next.direction;
        path.can_share = path.can_share && !onward.mirror;
    } else {
        path.beyond *= onward.weight;
    }
    path.scatterings += 1u;
    path.pdf_solid_angle = onward.pdf_solid_angle;
    path.mirror = onward.mirror;
    return survives_roulette(path.throughput, path.scatterings, restir.at.roulette_start, restir.at.roulette_floor, numbers.w)
        && alive;
}
