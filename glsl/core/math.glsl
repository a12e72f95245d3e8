#pragma once
// Constants, exact sums, transforms, frames of unit vectors, and unit vectors in octahedral coordinates.
#include "prelude.glsl"

const float PI = 3.14159265358979;
// Smallest normal number: divisors are kept above it.
const float TINY = 1.17549435e-38;
// The largest finite number.
const float LARGEST = 3.402823466e38;

float luminance(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }

float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }

float component_sum(vec3 v) { return v.x + v.y + v.z; }

// a / b, or 0 if either is 0.
float ratio(float a, float b) { return a > 0.0 && b > 0.0 ? a / b : 0.0; }

float square(float x) { return x * x; }

vec3 square(vec3 x) { return x * x; }

// The error of a rounded sum: a + b == two_sum(a, b) + low exactly (Knuth).
vec3 two_sum(vec3 a, vec3 b, out vec3 low) {
    precise vec3 sum = a + b;
    precise vec3 part = sum - a;
    precise vec3 rest = (a - (sum - part)) + (b - part);
    low = rest;
    return sum;
}

// Adds a value to the unevaluated sum high + low.
void pair_add(inout vec3 high, inout vec3 low, vec3 value) {
    vec3 rest;
    vec3 sum = two_sum(high, value, rest);
    precise vec3 tail = low + rest;
    high = two_sum(sum, tail, low);
}

vec3 transform_point(vec3 columns[4], vec3 p) {
    return columns[0] * p.x + columns[1] * p.y + columns[2] * p.z + columns[3];
}

vec3 transform_vector(vec3 columns[4], vec3 v) {
    return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z;
}

// Normals transform by the transpose of the inverse.
vec3 transform_normal(vec3 inverse_columns[4], vec3 n) {
    return vec3(dot(inverse_columns[0], n), dot(inverse_columns[1], n), dot(inverse_columns[2], n));
}

// Cosine and sine of an angle given in turns, 0 to 1. The built-in functions may have errors of 2^-11, and
// SwiftShader's have 2e-4: sampled directions would not be unit vectors, nor distributed by their density.
vec2 on_circle(float turns) {
    float quarters = 4.0 * turns;
    float nearest = floor(quarters + 0.5);
    // Exact, and at most half a quarter turn, where short Taylor series suffice.
    float t = quarters - nearest;
    float t2 = t * t;
    float c = 1.0 + t2 * (-1.23370055 + t2 * (0.253669508 + t2 * (-0.0208634807 + t2 * 9.19260275e-4)));
    float s = t * (1.57079633 + t2 * (-0.645964098 + t2 * (0.0796926262 + t2 * (-0.00468175414 + t2 * 1.60441185e-4))));
    uint quadrant = uint(nearest);
    vec2 turned = (quadrant & 1u) != 0u ? vec2(-s, c) : vec2(c, s);
    return (quadrant & 2u) != 0u ? -turned : turned;
}

// The angle, in turns from 0 to 1, of a direction in the plane: the inverse of `on_circle`, and exact to 2e-7 rad.
float turns_of(vec2 direction) {
    vec2 size = abs(direction);
    float t = min(size.x, size.y) / max(max(size.x, size.y), TINY), t2 = t * t;
    float turns = -0.00944856755 + t2 * (0.00384616852 + t2 * -7.4305835e-4);
    turns = t * (0.159154927 + t2 * (-0.0530494615 + t2 * (0.0317820252 + t2 * (-0.0223080879 + t2 * (0.0157660429 + t2 * turns)))));
    if (size.y > size.x) turns = 0.25 - turns;
    if (direction.x < 0.0) turns = 0.5 - turns;
    return direction.y < 0.0 ? 1.0 - turns : turns;
}

// Tangent frame without a branch on any axis but the sign of z (Duff et al. 2017).
void tangent_frame(vec3 n, out vec3 tangent, out vec3 bitangent) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    tangent = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    bitangent = vec3(b, s + n.y * n.y * a, -n.y);
}

// Unit vector from signed octahedral coordinates.
vec3 octahedral_direction(vec2 e) {
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-v.z, 0.0);
    v.x += v.x >= 0.0 ? -fold : fold;
    v.y += v.y >= 0.0 ? -fold : fold;
    return normalize(v);
}

// From two 16-bit coordinates, as Rust packs corner normals too.
vec3 unpack_octahedral(uint word) { return octahedral_direction(unpackSnorm2x16(word)); }

// Signed octahedral coordinates of a unit vector.
vec2 octahedral_coordinates(vec3 n) {
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 e = n.xy;
    if (n.z < 0.0) e = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return clamp(e, -1.0, 1.0);
}

uint pack_octahedral(vec3 n) { return packSnorm2x16(octahedral_coordinates(n)); }

// The unit normal of two edges of any length. Both are scaled first, because the squares of very long or short
// edges, or of a thin triangle's cross product, leave the range of f32.
vec3 unit_cross(vec3 a, vec3 b) {
    vec3 across = cross(a / max_component(abs(a)), b / max_component(abs(b)));
    return normalize(across / max_component(abs(across)));
}
