#pragma once
// Cells of space: points close to each other, with similar normals, have the same key.
#include "core/math.glsl"
#include "core/random.glsl"
#include "scene/camera.glsl"

// The side of a cell that spans `pixels` of the picture at a point, and its level. It is a power of two, so that cells stay
// where they are while the camera moves; `u` in [0, 1) blurs the border between two sizes.
float cell_side(GpuCamera camera, uint width, float pixels, vec3 position, float u, out int level) {
    float pixel = 2.0 * length(camera.right) / float(width);
    // A pixel of an orthographic camera has this size at every distance.
    float scale = CAMERA_MODEL == CAMERA_MODEL_ORTHOGRAPHIC ? 1.0 : distance(position, camera.position);
    float wanted = pixels * pixel * scale;
    level = int(floor(log2(max(wanted, TINY)) + u));
    return exp2(float(level));
}

// The bin of a normal, of which there are `bins` along each side of the octahedral map. Most walls and floors stand along the axes,
// so no axis lies on a border between bins, where rounding would part what belongs together.
uint normal_bin(vec3 normal, uint bins) {
    uvec2 bin = uvec2((0.5 * octahedral_coordinates(normal) + 0.5) * float(bins - 1u) + 0.3);
    // The corners of the map are one direction.
    bool at_corner = bins > 2u && all(equal(bin % (bins - 1u), uvec2(0u)));
    return at_corner ? 0u : bin.y * bins + bin.x;
}

// The key of a cell with sides of `side`, and of a bin of normals, of which there are `bins` along each side of the octahedral
// map. `shift` is in cells; only its part along the surface counts.
uint cell_key(vec3 position, vec3 normal, float side, int level, uint bins, vec3 shift) {
    // Far from the origin of coordinates integers would overflow.
    ivec3 cell = ivec3(clamp(floor(position / side + (shift - dot(shift, normal) * normal)), -1e9, 1e9));
    return pcg4d(uvec4(cell, (uint(level) << 8u) | normal_bin(normal, bins))).x;
}
