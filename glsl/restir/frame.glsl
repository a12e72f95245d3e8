#pragma once
// A frame of resampling: its constants, its pixels, and their primary rays.
#include "core/random.glsl"
#include "core/workgroups.glsl"
#include "restir/pixel_order.glsl"
#include "scene/camera.glsl"

layout(scalar) uniform RestirBlock { RestirConstants at; } restir;

// A pixel's index in the picture, by rows.
uint pixel_index(uvec2 pixel) { return pixel.y * restir.at.view.width + pixel.x; }

// Random numbers of one pass. Each pass has a stream of its own, so that they do not depend on how many numbers an
// earlier pass drew.
Random pass_random(uvec2 pixel, uint stream) {
    return random_stream(pixel_index(pixel), restir.at.frame, restir.at.view.seed, stream);
}

uvec2 picture_size() { return uvec2(restir.at.view.width, restir.at.view.height); }

bool is_outside(uvec2 pixel) { return pixel.x >= restir.at.view.width || pixel.y >= restir.at.view.height; }

// Negative coordinates wrap to large ones.
bool is_outside(ivec2 pixel) { return is_outside(uvec2(pixel)); }

// The pixel of this invocation; possibly outside the picture.
uvec2 own_pixel() { return tile_pixel(restir.at.view.width, 0u, restir.at.view.interleave); }

uint slot_of(uvec2 pixel) { return slot_of(pixel, picture_size()); }

Ray primary_ray(uvec2 pixel) {
    return camera_ray(restir.at.view.camera, vec2(pixel) + restir.at.jitter, vec2(picture_size()));
}

Ray previous_primary_ray(uvec2 pixel) {
    return camera_ray(restir.at.previous_camera, vec2(pixel) + restir.at.previous_jitter,
                      vec2(picture_size()));
}
