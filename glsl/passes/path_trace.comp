#version 460
// MIS path tracing: samples are added to each pixel's sums.
//
// One loop traces one ray a turn, a path's next ray or the shadow ray to a light, and begins the
// pixel's next sample when a path ends. So the trace stands in the code once, which compilers of
// software drivers need, and no lane idles while its neighbours' paths are longer.
#include "prelude.glsl"
#include "random.glsl"
#include "counters.glsl"
#include "geometry.glsl"
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "lights.glsl"
#include "camera.glsl"
#include "roulette.glsl"
#include "values.glsl"
#include "workgroups.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) buffer SumsBlock { PixelSums at[]; } sums;

float heuristic_weight(float pdf, float other) {
    // By the ratio: squares of densities overflow.
    if (pdf <= 0.0) return 0.0;
    float ratio = other / pdf;
    if (frame.at.heuristic == HEURISTIC_POWER) ratio *= ratio;
    return 1.0 / (1.0 + ratio);
}

// A path under way.
struct Path {
    vec3 throughput;
    uint scatterings;
    // How the ray under way was sampled: for weighing the light that it may hit.
    float pdf_solid_angle;
    bool mirror;
};

void main() {
    uvec2 pixel = tile_pixel(frame.at.width, strip.first_row, frame.at.interleave);
    if (pixel.x >= frame.at.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.width + pixel.x;
    PixelSums total = sums.at[index];

    uint sample_number = frame.at.first_sample;
    uint end = sample_number + frame.at.samples;
    Random random;
    vec3 radiance = vec3(0.0);
    Path path;
    Ray ray, next;
    bool alive = false, next_alive = false, shadow = false;
    vec3 light_arrives = vec3(0.0);
    bool started = false;
    while (true) {
        if (!alive) {
            if (started) {
                radiance = accept_radiance(radiance);
                pair_add(total.sum, total.sum_low, radiance);
                pair_add(total.square, total.square_low, radiance * radiance);
                sample_number += 1u;
            }
            if (sample_number >= end) break;
            started = true;
            random = random_start(pixel.y * frame.at.width + pixel.x, sample_number, frame.at.seed);
            vec2 offset = frame.at.jitter != 0u ? to_unit(random_bits(random)).xy : vec2(0.5);
            ray = camera_ray(frame.at.camera, vec2(pixel) + offset, vec2(frame.at.width, frame.at.height));
            radiance = vec3(0.0);
            path = Path(vec3(1.0), 0u, 0.0, true);
            shadow = false;
            alive = true;
        }
        Hit hit = trace(ray, shadow);
        if (shadow) {
            if (hit.instance == NONE) radiance += light_arrives;
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
        GpuMaterial material = material_at(surface.material);
        if (surface.light != NONE) {
            GpuLight light = light_at(surface.light);
            float cosine = -dot(light.normal, ray.direction);
            vec3 emission = light_emission(light, cosine);
            float weight = 1.0;
            if (!path.mirror) {
                float distance_squared = square(hit.t);
                float pdf_light = area_to_solid_angle(light_pdf_area(light), distance_squared, cosine);
                weight = heuristic_weight(path.pdf_solid_angle, pdf_light);
            }
            radiance += path.throughput * emission * weight;
        }
        if (path.scatterings >= frame.at.bounces) {
            alive = false;
            continue;
        }
        surface.position -= way_back(surface.error, hit.t) * ray.direction;
        vec3 tangent, bitangent;
        tangent_frame(surface.shading_normal, tangent, bitangent);
        vec3 outgoing = -vec3(dot(ray.direction, tangent), dot(ray.direction, bitangent),
                              dot(ray.direction, surface.shading_normal));
        Bsdf bsdf = make_bsdf(material, max(outgoing.z, 0.0));

        // Draws come whether they are needed or not: what a scene lacks must not shift the rest.
        uvec4 light_bits = random_bits(random);
        vec4 bsdf_numbers = to_unit(random_bits(random));

        if (frame.at.lights > 0u) {
            LightPoint point = sample_light(frame.at.lights, light_bits);
            vec3 toward = point.position - surface.position;
            float distance_squared = dot(toward, toward);
            vec3 direction = toward * inversesqrt(max(distance_squared, TINY));
            float cosine = -dot(point.normal, direction);
            vec3 emission = light_emission(light_at(point.light), cosine);
            vec3 incoming = vec3(dot(direction, tangent), dot(direction, bitangent),
                                 dot(direction, surface.shading_normal));
            if (max_component(emission) > 0.0 && dot(direction, surface.geometric_normal) > 0.0) {
                float pdf_bsdf;
                vec3 f = evaluate_bsdf(bsdf, outgoing, incoming, pdf_bsdf);
                float pdf_light = area_to_solid_angle(point.pdf_area, distance_squared, cosine);
                float weight = heuristic_weight(pdf_light, pdf_bsdf) / pdf_light;
                light_arrives = path.throughput * f * emission * (max(incoming.z, 0.0) * weight);
                shadow = max_component(light_arrives) > 0.0;
                if (shadow) {
                    vec3 from = offset_origin(surface.position, surface.error, surface.geometric_normal, direction);
                    vec3 to = offset_origin(point.position, point.error, point.normal, -direction);
                    // Ends short of the light by what rounding costs along the whole way.
                    next.origin = from;
                    next.direction = to - from;
                    next.t_max = 1.0 - 1e-6;
                }
            }
        }
        Ray shadow_ray = next;

        BsdfSample chosen = sample_bsdf(bsdf, outgoing, bsdf_numbers);
        vec3 direction = tangent * chosen.direction.x + bitangent * chosen.direction.y
            + surface.shading_normal * chosen.direction.z;
        next_alive = chosen.valid && dot(direction, surface.geometric_normal) > 0.0;
        path.throughput *= chosen.weight;
        path.scatterings += 1u;
        path.pdf_solid_angle = chosen.pdf_solid_angle;
        path.mirror = chosen.mirror;
        next_alive = next_alive && max_component(path.throughput) > 0.0;
        bool survives = survives_roulette(path.throughput, path.scatterings, frame.at.roulette_start,
                                          frame.at.roulette_floor, bsdf_numbers.w);
        next_alive = next_alive && survives;
        next.origin = offset_origin(surface.position, surface.error, surface.geometric_normal, direction);
        next.direction = direction;
        next.t_max = LARGEST;
        if (shadow) {
            ray = shadow_ray;
        } else {
            ray = next;
            alive = next_alive;
        }
    }
    // A driver may end a loop that seems endless to it; the sums would then lack light.
    if (sample_number != end) count_fault(COUNTER_CUT_SHORT);
    sums.at[index] = total;
}
