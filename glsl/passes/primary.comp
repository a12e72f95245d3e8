#version 460
// What the camera sees through each pixel's centre.
#include "prelude.glsl"
#include "geometry.glsl"
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "camera.glsl"
#include "workgroups.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) writeonly buffer PrimaryBlock { PrimarySurface at[]; } primary;

void main() {
    uvec2 pixel = tile_pixel(frame.at.width, strip.first_row, frame.at.interleave);
    if (pixel.x >= frame.at.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.width + pixel.x;
    Ray ray = camera_ray(frame.at.camera, vec2(pixel) + 0.5, vec2(frame.at.width, frame.at.height));
    Hit hit = trace_closest(ray);
    PrimarySurface seen = PrimarySurface(vec3(0.0), vec3(0.0), 0.0, NONE);
    if (hit.instance != NONE) {
        Surface surface = surface_at(hit, ray.direction);
        float cosine = max(-dot(ray.direction, surface.shading_normal), 0.0);
        Bsdf bsdf = make_bsdf(material_at(surface.material), cosine);
        vec3 specular = specular_fresnel(bsdf, cosine);
        seen = PrimarySurface(bsdf.diffuse * diffuse_share(bsdf, cosine) + specular, surface.shading_normal,
                              hit.t, surface.instance);
    }
    primary.at[index] = seen;
}
