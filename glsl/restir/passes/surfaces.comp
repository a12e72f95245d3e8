#version 460
// The first pass of a frame: the primary surface of each pixel, and the light that it emits itself.
#include "core/values.glsl"
#include "lights/kinds/environment.glsl"
#include "lights/kinds/triangle.glsl"
#include "restir/frame.glsl"
#include "restir/sample_data.glsl"
#include "scene/camera_trace.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) writeonly buffer SampleDataBlock { SampleData at[]; } sample_data;
layout(scalar) writeonly buffer ColorBlock { vec3 at[]; } color;

void main() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    Ray ray = primary_ray(pixel);
    Hit hit = trace_camera(ray, draw_alpha_random(pass_random(pixel, STREAM_ALPHA)));
    SampleData data = SampleData(0.0, uvec3(0u), 0u, NONE, uvec2(0u));
    vec3 emission = vec3(0.0);
    if (hit.instance != NONE) {
        Surface surface = surface_at(hit, ray);
        data = pack_sample_data(surface, hit, ray, to_unit(pcg4d(uvec4(pixel, 0u, 0u))).xyz);
        emission = unlit_radiance(hit);
        if (surface.light != NONE) {
            GpuLight light = light_at(surface.light, CURRENT);
            float cosine = -dot(light.normal, ray.direction);
            emission += accept_radiance(hit_emission(light, surface.light, hit.barycentrics, cosine));
        }
    } else if (sees_environment()) {
        emission = accept_radiance(environment_radiance(environment_uv(ray.direction)));
    }
    sample_data.at[slot_of(pixel)] = data;
    color.at[pixel_index(pixel)] = emission;
    count_written(SAMPLE_DATA_WORDS + 3u);
}
