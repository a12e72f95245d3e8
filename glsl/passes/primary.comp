#version 460
// What the camera sees through each pixel's centre.
#include "prelude.glsl"
#include "geometry.glsl"
#include "last_frame.glsl"
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "camera.glsl"
#include "workgroups.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) uniform PreviousCameraBlock { GpuCamera at; } previous_camera;
layout(scalar) writeonly buffer PrimaryBlock { PrimarySurface at[]; } primary;

// How far what lies at `now` from the camera has come in the image, if the last frame had it at `before`.
vec2 motion_of(vec3 now, vec3 before) {
    vec2 size = vec2(frame.at.width, frame.at.height), here, there;
    // Both are computed, so that what stands still has no motion to the last bit.
    bool seen = camera_sees(frame.at.camera, now, size, here) && camera_sees(previous_camera.at, before, size, there);
    return seen ? there - here : vec2(0.0);
}

void main() {
    uvec2 pixel = tile_pixel(frame.at.width, strip.first_row, frame.at.interleave);
    if (pixel.x >= frame.at.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.width + pixel.x;
    Ray ray = camera_ray(frame.at.camera, vec2(pixel) + 0.5, vec2(frame.at.width, frame.at.height));
    Hit hit = trace_closest(ray);
    PrimarySurface seen = PrimarySurface(vec3(0.0), vec3(0.0), 0.0, NONE, motion_of(ray.direction, ray.direction));
    if (hit.instance != NONE) {
        Surface surface = surface_at(hit, ray);
        float cosine = max(-dot(ray.direction, surface.shading_normal), 0.0);
        Bsdf bsdf = make_bsdf(material_at(surface.material), cosine);
        vec3 specular = specular_fresnel(bsdf, cosine);
        seen = PrimarySurface(bsdf.diffuse * diffuse_share(bsdf, cosine) + specular, surface.shading_normal,
                              hit.t, surface.instance,
                              motion_of(surface.position - frame.at.camera.position,
                                        carried_point(surface.instance, surface.position) - previous_camera.at.position));
    }
    primary.at[index] = seen;
}
