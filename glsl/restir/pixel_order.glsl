#pragma once
// The index of a pixel in buffers with one entry a pixel: by rows, by columns or by tiles (PIXEL_ORDER).
#include "prelude.glsl"

uint slot_of(uvec2 pixel, uvec2 size) {
    if (PIXEL_ORDER == PIXEL_ORDER_COLUMN) return pixel.x * size.y + pixel.y;
    if (PIXEL_ORDER == PIXEL_ORDER_ROW) return pixel.y * size.x + pixel.x;
    uvec2 tile = pixel / SWIZZLE, within = pixel % SWIZZLE;
    uint across = (size.x + SWIZZLE - 1u) / SWIZZLE;
    return ((tile.y * across + tile.x) * SWIZZLE + within.y) * SWIZZLE + within.x;
}
