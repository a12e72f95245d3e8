// What the passes of resampling share: the scene and its light, the frame, its pixels, their primary surfaces.
#include "prelude.glsl"
#include "random.glsl"
#include "counters.glsl"
#include "geometry.glsl"
#ifdef LAST_FRAME
#include "last_frame.glsl"
#endif
#include "trace.glsl"
#include "surface.glsl"
#include "materials.glsl"
#include "lights.glsl"
#include "camera.glsl"
#include "values.glsl"
#include "workgroups.glsl"
#include "sample_data.glsl"
#include "direct_light.glsl"
#ifdef INDIRECT
#include "indirect_light.glsl"
#endif
#include "reservoirs.glsl"
#include "resampling.glsl"

layout(scalar) uniform RestirBlock { RestirConstants at; } restir;

layout(constant_id = 11) const uint MIS = MIS_DEFENSIVE;
layout(constant_id = 12) const uint VISIBILITY = VISIBILITY_WEIGHTS;
// Neighbours of a spatial merge.
layout(constant_id = 13) const uint NEIGHBOURS = 3u;

#ifdef INDIRECT
const uint FIRST_PASS = PASS_INDIRECT;
#else
const uint FIRST_PASS = 0u;
#endif

// A pixel's number in the picture, by rows.
uint number_of(uvec2 pixel) { return pixel.y * restir.at.width + pixel.x; }

// What a pass draws must not depend on how much an earlier one drew, so each counts on its own.
Random pass_random(uvec2 pixel, uint pass) {
    return random_stream(number_of(pixel), restir.at.frame, restir.at.seed, pass);
}

// The same for passes that each kind of light has of its own.
Random kind_random(uvec2 pixel, uint pass) { return pass_random(pixel, FIRST_PASS + pass); }

uvec2 picture_size() { return uvec2(restir.at.width, restir.at.height); }

bool is_outside(uvec2 pixel) { return pixel.x >= restir.at.width || pixel.y >= restir.at.height; }

// Coordinates below 0 wrap to the largest.
bool is_outside(ivec2 pixel) { return is_outside(uvec2(pixel)); }

// The pixel of this invocation, or one outside.
uvec2 own_pixel() { return tile_pixel(restir.at.width, 0u, restir.at.interleave); }

uint slot_of(uvec2 pixel) { return slot_of(pixel, picture_size()); }

Ray primary_ray(uvec2 pixel) {
    return camera_ray(restir.at.camera, vec2(pixel) + vec2(restir.at.jitter_x, restir.at.jitter_y), vec2(picture_size()));
}

Ray previous_primary_ray(uvec2 pixel) {
    return camera_ray(restir.at.previous_camera, vec2(pixel) + vec2(restir.at.previous_jitter_x, restir.at.previous_jitter_y),
                      vec2(picture_size()));
}
