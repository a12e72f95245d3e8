#version 460
// The surface through each pixel's centre, and through the centre of a lens, for the AOVs. What covers only a part of it is left
// out.
#include "bsdf/bsdf.glsl"
#include "core/workgroups.glsl"
#include "scene/camera.glsl"
#include "scene/camera_trace.glsl"
#include "scene/previous_frame.glsl"
#include "scene/surface.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) uniform PreviousCameraBlock { GpuCamera at; } previous_camera;
layout(scalar) writeonly buffer PrimaryBlock { PrimarySurface at[]; } primary;

// The motion vector of a point, given relative to the camera in this frame and in the previous one: pixels from here to
// there, 0 if it was behind the camera.
vec2 motion_of(vec3 now, vec3 before) {
    vec2 size = vec2(frame.at.view.width, frame.at.view.height), here, there;
    // Both are projected by the same code, so that without motion the difference is exactly 0.
    bool seen = project(frame.at.view.camera, now, size, here) && project(previous_camera.at, before, size, there);
    return seen ? there - here : vec2(0.0);
}

void main() {
    uvec2 pixel = tile_pixel(frame.at.view.width, strip.first_row, frame.at.view.interleave);
    if (pixel.x >= frame.at.view.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.view.width + pixel.x;
    Ray ray = camera_ray(frame.at.view.camera, vec2(pixel) + 0.5, vec2(frame.at.view.width, frame.at.view.height), vec2(0.0));
    Hit hit = trace_camera(ray, NO_ALPHA_RANDOM);
    // An orthographic camera sees one direction of the sky in all pixels.
    vec2 of_sky = CAMERA_MODEL == CAMERA_MODEL_ORTHOGRAPHIC ? vec2(0.0) : motion_of(ray.direction, ray.direction);
    PrimarySurface seen = PrimarySurface(vec3(0.0), vec3(0.0), 0.0, NONE, of_sky);
    if (hit.instance != NONE) {
        Surface surface = surface_at(hit, ray);
        float cosine = max(-dot(ray.direction, surface.shading_normal), 0.0);
        vec3 tangent, bitangent;
        shading_frame(surface.shading_normal, surface.layers, tangent, bitangent);
        vec3 outgoing = -vec3(dot(ray.direction, tangent), dot(ray.direction, bitangent),
                              dot(ray.direction, surface.shading_normal));
        Bsdf bsdf = make_bsdf(surface.material, in_frame(surface.layers, tangent, bitangent, surface.shading_normal), outgoing);
        vec3 before = SURFACES_NAMED
            ? previous_point(hit.instance, hit.primitive, clamp(hit.barycentrics, 0.0, 1.0), surface.position)
            : previous_point(surface.instance, surface.position);
        seen = PrimarySurface(albedo_of(bsdf, cosine), surface.shading_normal,
                              hit.t, surface.instance,
                              motion_of(surface.position - frame.at.view.camera.position, before - previous_camera.at.position));
    }
    primary.at[index] = seen;
}
