#version 460
// MIS path tracing: samples are added to each pixel's sums.
//
// This is the reference that resampling is measured against. So it does not use the domains, candidates and shadow rays
// of resampling, but repeats them in its own way: an error in one of them cannot be in both.
//
// One loop traces one ray a turn and begins the pixel's next sample when a path ends, so that no lane idles while its
// neighbours' paths are longer.
#include "core/roulette.glsl"
#include "core/values.glsl"
#include "core/workgroups.glsl"
#include "lights/triangle.glsl"
#include "scene/camera.glsl"
#include "scene/material.glsl"
#include "scene/surface.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) buffer SumsBlock { PixelSums at[]; } sums;

float heuristic_weight(float pdf, float other) {
    // Of the ratio, because squares of densities overflow.
    if (pdf <= 0.0) return 0.0;
    float ratio = other / pdf;
    if (frame.at.heuristic == HEURISTIC_POWER) ratio *= ratio;
    return 1.0 / (1.0 + ratio);
}

// A path under construction.
struct Path {
    vec3 throughput;
    uint scatterings;
    // The density of the current ray, for the MIS weight of a light that it hits.
    float pdf_solid_angle;
    bool mirror;
};

void main() {
    uvec2 pixel = tile_pixel(frame.at.view.width, strip.first_row, frame.at.view.interleave);
    if (pixel.x >= frame.at.view.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.view.width + pixel.x;
    PixelSums total = sums.at[index];

    uint sample_index = frame.at.first_sample;
    uint end = sample_index + frame.at.samples;
    Random random;
    vec3 radiance = vec3(0.0);
    Path path;
    uint purpose = RAY_NONE;
    Ray ray;
    // While a shadow ray is traced: the path's next ray and its purpose, and the light to be decided on.
    Ray next;
    uint next_purpose = RAY_NONE;
    vec3 shadowed = vec3(0.0);
    bool started = false;
    while (true) {
        if (purpose == RAY_NONE) {
            if (started) {
                radiance = accept_radiance(radiance);
                pair_add(total.sum, total.sum_low, radiance);
                pair_add(total.square, total.square_low, radiance * radiance);
                sample_index += 1u;
            }
            if (sample_index >= end) break;
            started = true;
            random = random_start(pixel.y * frame.at.view.width + pixel.x, sample_index, frame.at.view.seed);
            vec2 offset = frame.at.jitter != 0u ? to_unit(random_bits(random)).xy : vec2(0.5);
            ray = camera_ray(frame.at.view.camera, vec2(pixel) + offset, vec2(frame.at.view.width, frame.at.view.height));
            radiance = vec3(0.0);
            path = Path(vec3(1.0), 0u, 0.0, true);
            purpose = RAY_PATH;
        }
        Hit hit = trace(ray, purpose == RAY_SHADOW);
        if (purpose == RAY_SHADOW) {
            if (hit.transmittance > 0.0) radiance += hit.transmittance * shadowed;
            ray = next;
            purpose = next_purpose;
            continue;
        }
        if (hit.instance == NONE) {
            purpose = RAY_NONE;
            continue;
        }
        Surface surface = surface_at(hit, ray);
        if (surface.light != NONE) {
            GpuLight light = light_at(surface.light, CURRENT);
            float cosine = -dot(light.normal, ray.direction);
            vec3 emission = light_emission(light, surface.light, hit.barycentrics, cosine);
            float weight = 1.0;
            if (!path.mirror) {
                float distance_squared = square(hit.t);
                float pdf_light = area_to_solid_angle(light_pdf_area(light), distance_squared, cosine);
                weight = heuristic_weight(path.pdf_solid_angle, pdf_light);
            }
            radiance += path.throughput * emission * weight;
        }
        if (path.scatterings >= frame.at.view.bounces) {
            purpose = RAY_NONE;
            continue;
        }
        surface.position -= back_off_distance(surface.error, hit.t) * ray.direction;
        vec3 tangent, bitangent;
        tangent_frame(surface.shading_normal, tangent, bitangent);
        vec3 outgoing = -vec3(dot(ray.direction, tangent), dot(ray.direction, bitangent),
                              dot(ray.direction, surface.shading_normal));
        Bsdf bsdf = make_bsdf(surface.material, max(outgoing.z, 0.0));

        // Drawn whether they are needed or not, so that what a scene lacks does not shift the others.
        uvec4 light_bits = random_bits(random);
        vec4 bsdf_numbers = to_unit(random_bits(random));

        Ray shadow_ray;
        bool shadow = false;
        if (scene.at.light_count > 0u) {
            LightPoint point = sample_light(scene.at.light_count, light_bits);
            vec3 toward = point.position - surface.position;
            float distance_squared = dot(toward, toward);
            vec3 direction = toward * inversesqrt(max(distance_squared, TINY));
            float cosine = -dot(point.normal, direction);
            vec3 emission = light_emission(light_at(point.light, CURRENT), point.light, point.barycentrics, cosine);
            vec3 incoming = vec3(dot(direction, tangent), dot(direction, bitangent),
                                 dot(direction, surface.shading_normal));
            if (max_component(emission) > 0.0 && dot(direction, surface.geometric_normal) > 0.0) {
                float pdf_bsdf;
                vec3 f = evaluate_bsdf(bsdf, outgoing, incoming, pdf_bsdf);
                float pdf_light = area_to_solid_angle(point.pdf_area, distance_squared, cosine);
                float weight = heuristic_weight(pdf_light, pdf_bsdf) / pdf_light;
                shadowed = path.throughput * f * emission * (max(incoming.z, 0.0) * weight);
                shadow = max_component(shadowed) > 0.0;
                if (shadow) {
                    vec3 from = offset_origin(surface.position, surface.error, surface.geometric_normal, direction);
                    vec3 to = offset_origin(point.position, point.error, point.normal, -direction);
                    // Ends short of the light by the rounding error along the whole ray.
                    shadow_ray = Ray(from, 1.0 - 1e-6, to - from);
                }
            }
        }

        BsdfSample chosen = sample_bsdf(bsdf, outgoing, bsdf_numbers);
        vec3 direction = tangent * chosen.direction.x + bitangent * chosen.direction.y
            + surface.shading_normal * chosen.direction.z;
        bool alive = chosen.valid && dot(direction, surface.geometric_normal) > 0.0;
        path.throughput *= chosen.weight;
        path.scatterings += 1u;
        path.pdf_solid_angle = chosen.pdf_solid_angle;
        path.mirror = chosen.mirror;
        alive = alive && max_component(path.throughput) > 0.0;
        bool survives = survives_roulette(path.throughput, path.scatterings, frame.at.view.roulette_start,
                                          frame.at.view.roulette_floor, bsdf_numbers.w);
        next = Ray(offset_origin(surface.position, surface.error, surface.geometric_normal, direction), LARGEST, direction);
        next_purpose = alive && survives ? RAY_PATH : RAY_NONE;
        purpose = shadow ? RAY_SHADOW : next_purpose;
        ray = next;
        if (shadow) ray = shadow_ray;
    }
    // A driver may end a loop that seems endless to it; the sums would then lack light.
    if (sample_index != end) count_fault(COUNTER_CUT_SHORT);
    sums.at[index] = total;
}
