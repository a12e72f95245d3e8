#pragma once
// A frame of resampling: its constants, its pixels, and their primary rays.
#include "core/random.glsl"
#include "core/values.glsl"
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
uvec2 invocation_pixel() { return tile_pixel(restir.at.view.width, 0u, restir.at.view.interleave); }

// Adds light to a pixel of the picture, `color`. A macro, because GLSL cannot pass buffers to functions.
#define ADD_LIGHT(PIXEL, LIGHT) \
    { \
        color.at[pixel_index(PIXEL)] += accept_radiance(LIGHT); \
        count_read(3u); \
        count_written(3u); \
    }

uint slot_of(uvec2 pixel) { return slot_of(pixel, picture_size()); }

// Where the primary ray of a pixel passes through it: the jitter of the frame, rotated by multiples of the golden and
// the silver ratio, which spread evenly along rows and columns. If all pixels of a frame moved alike, so would the edges
// of lights that lie along rows of pixels, and the mean of the picture with them.
vec2 position_in_pixel(uvec2 pixel, vec2 jitter) {
    if (restir.at.jitters == 0u) return vec2(0.5);
    const uvec2 ratios = uvec2(0x9E3779B9u, 0x6A09E668u);
    uvec2 rotation = pixel.x * ratios + pixel.y * ratios.yx;
    return fract(jitter + vec2(to_unit(rotation.x), to_unit(rotation.y)));
}

// Where on the lens the primary ray of a pixel begins: the lens point of the frame, moved by a random offset of the pixel.
vec2 position_on_lens(uvec2 pixel, vec2 lens_point) {
    if (CAMERA_MODEL != CAMERA_MODEL_THIN_LENS) return vec2(0.0);
    return on_disc(fract(lens_point + to_unit(pcg4d(uvec4(pixel, STREAM_LENS, 0u))).xy));
}

Ray primary_ray(uvec2 pixel) {
    vec2 at = vec2(pixel) + position_in_pixel(pixel, restir.at.jitter);
    return camera_ray(restir.at.view.camera, at, vec2(picture_size()), position_on_lens(pixel, restir.at.lens_point));
}

Ray previous_primary_ray(uvec2 pixel) {
    vec2 at = vec2(pixel) + position_in_pixel(pixel, restir.at.previous_jitter);
    return camera_ray(restir.at.previous_camera, at, vec2(picture_size()), position_on_lens(pixel, restir.at.previous_lens_point));
}
