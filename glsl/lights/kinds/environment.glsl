#pragma once
// The environment: light from infinitely far away. Its image covers the sphere by longitude, of which the middle column
// looks along -Z, and by latitude, from the zenith down; it is interpolated between the centres of texels.
#include "core/math.glsl"
#include "core/random.glsl"
#include "scene/geometry.glsl"

// Whether a ray that meets no surface sees an environment.
bool sees_environment() { return HAS_ENVIRONMENT && scene.at.environment_size.x > 0u; }

// A texel of the environment: its radiance, and the density over longitude and latitude with which it is drawn.
vec4 environment_texel(uint texel) { return uintBitsToFloat(environment_words(texel)); }

// The uv in the image, in texels, that is seen in a direction.
vec2 environment_uv(vec3 direction) {
    vec2 turn = scene.at.environment_turn;
    float x = turn.x * direction.x - turn.y * direction.z, z = turn.y * direction.x + turn.x * direction.z;
    vec2 at = vec2(turns_of(vec2(z, -x)), 2.0 * turns_of(vec2(direction.y, length(direction.xz))));
    return at * vec2(scene.at.environment_size);
}

// The unit direction in which a uv in the image is seen. `sine` is that of the angle to the zenith.
vec3 environment_direction(vec2 uv, out float sine) {
    vec2 at = uv / vec2(scene.at.environment_size);
    vec2 around = on_circle(at.x), down = on_circle(0.5 * at.y);
    sine = max(down.y, TINY);
    float x = -sine * around.y, z = sine * around.x;
    vec2 turn = scene.at.environment_turn;
    return vec3(turn.x * x + turn.y * z, down.x, turn.x * z - turn.y * x);
}

// The radiance at a uv in the image.
vec3 environment_radiance(vec2 uv) {
    ivec2 size = ivec2(scene.at.environment_size);
    vec2 at = uv - 0.5, corner = floor(at), part = at - corner;
    ivec2 first = ivec2(corner);
    vec3 rows[2];
    for (int y = 0; y < 2; y += 1) {
        // Longitudes continue beyond the edge, latitudes end at the poles.
        uint row = uint(clamp(first.y + y, 0, size.y - 1) * size.x);
        vec3 left = environment_texel(row + uint(first.x < 0 ? size.x - 1 : first.x)).rgb;
        rows[y] = mix(left, environment_texel(row + uint(first.x + 1 < size.x ? first.x + 1 : 0)).rgb, part.x);
    }
    return mix(rows[0], rows[1], part.y);
}

// The texel at a uv in the image.
uint environment_texel_at(vec2 uv) {
    uvec2 size = scene.at.environment_size;
    uvec2 at = min(uvec2(uv), size - 1u);
    return at.y * size.x + at.x;
}

// The uv in the image of the upper left corner of a texel.
vec2 texel_corner(uint texel) {
    uint width = scene.at.environment_size.x;
    return vec2(texel % width, texel / width);
}

// Selects a texel by its fraction of the light, from an alias table.
uint draw_environment_texel(uvec2 bits) {
    uvec2 size = scene.at.environment_size;
    uint fraction;
    uint slot = scale_to(bits, size.x * size.y, fraction);
    uvec2 column = environment_columns.at[slot];
    return fraction < column.x ? slot : column.y;
}

// The density with which a point of a texel is drawn, where the angle to the zenith has this sine.
float environment_pdf_solid_angle(uint texel, float sine) { return environment_texel(texel).w / sine; }
