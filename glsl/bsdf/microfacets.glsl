#pragma once
// Microfacets of GGX, with height-correlated Smith masking and Schlick's Fresnel term: parts of specular lobes.
#include "core/math.glsl"

vec3 schlick(vec3 f0, vec3 f90, float cosine) {
    float m = clamp(1.0 - cosine, 0.0, 1.0);
    float m2 = m * m;
    return f0 + (f90 - f0) * (m2 * m2 * m);
}

// GGX distribution of a half vector. Computed from x and y, because 1 − z² cancels for narrow lobes.
float ggx_distribution(vec3 h, float alpha) {
    float a2 = alpha * alpha;
    float d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return a2 / (PI * d * d);
}

// Smith's λ, as (−1 + sqrt(1 + α² tan²)) / 2.
float smith_lambda(float cosine, float alpha) {
    float c2 = cosine * cosine;
    return 0.5 * (sqrt(1.0 + alpha * alpha * max(1.0 - c2, 0.0) / max(c2, TINY)) - 1.0);
}

// Both for a lobe with the widths `alpha` along x and y.
float ggx_distribution(vec3 h, vec2 alpha) {
    float product = alpha.x * alpha.y, ratio = alpha.x / alpha.y;
    float d = h.x * h.x / ratio + h.y * h.y * ratio + product * h.z * h.z;
    return product / (PI * d * d);
}

float smith_lambda(vec3 direction, vec2 alpha) {
    vec2 stretched = alpha * direction.xy;
    return 0.5 * (sqrt(1.0 + dot(stretched, stretched) / max(direction.z * direction.z, TINY)) - 1.0);
}

// Samples a microfacet normal visible from `outgoing` (Dupuy and Benyoub, "Sampling Visible
// GGX Normals with Spherical Caps", 2023). `alpha` is the width along x and y.
vec3 sample_visible_normal(vec3 outgoing, vec2 alpha, vec2 u) {
    vec3 w = normalize(vec3(alpha * outgoing.xy, outgoing.z));
    float z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    float s = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(s * on_circle(u.x), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 0.0)));
}
