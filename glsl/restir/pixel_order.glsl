#pragma once
// The order of pixels in buffers.
#include "prelude.glsl"

// The place of a pixel's data in buffers of one entry a pixel.
uint slot_of(uvec2 pixel, uvec2 size) {
    if (PIXEL_ORDER == PIXEL_ORDER_COLUMN) return pixel.x * size.y + pixel.y;
    if (PIXEL_ORDER == PIXEL_ORDER_ROW) return pixel.y * size.x + pixel.x;
    uvec2 tile = pixel / SWIZZLE, within = pixel % SWIZZLE;
    uint across = (size.x + SWIZZLE - 1u) / SWIZZLE;
    return ((tile.y * across + tile.x) * SWIZZLE + within.y) * SWIZZLE + within.x;
}
