#pragma once
// The trace seam: `trace` finds the closest hit, or any hit, along a ray. Its two bodies are a ray query on the
// driver's acceleration structures and a BVH traversed in compute.
#include "core/counters.glsl"
#include "core/math.glsl"
#include "scene/alpha.glsl"

struct Ray {
    vec3 origin;
    // Hits count at 0 < t < t_max, in units of the direction's length.
    float t_max;
    vec3 direction;
};

struct Hit {
    float t;
    // NONE: nothing was hit.
    uint instance;
    // Triangle of the instance's mesh.
    uint primitive;
    // Weights of the second and third corner.
    vec2 barycentrics;
    // Of a visibility ray: the fraction of light that passes between its ends.
    float transmittance;
};

// The result of a ray that meets nothing.
Hit no_hit(float t_max) { return Hit(t_max, NONE, 0u, vec2(0.0), 1.0); }

// The purpose of the next ray of a pass that traces all its rays in one loop. Drivers compile the trace as often as it
// stands in the code, so it stands there once.
const uint RAY_NONE = 0u;
// The next segment of a path: the closest hit.
const uint RAY_PATH = 1u;
// The same, but the hit is already known.
const uint RAY_PILOT = 2u;
// A BSDF candidate of direct light: the closest hit.
const uint RAY_CANDIDATE = 3u;
// The reflection of a perfect mirror: the closest hit.
const uint RAY_DELTA = 4u;
// Visibility: any hit.
const uint RAY_SHADOW = 5u;
// The same, of a candidate among rare lights.
const uint RAY_RARE = 6u;

#if TRACE_RAY_QUERY
#include "scene/trace_ray_query.glsl"
#else
#include "scene/trace_compute_bvh.glsl"
#endif

void count_ray() {
    count(COUNTER_RAYS, 1u);
    count_lanes(COUNTER_TRACE_LANES);
}

// The closest hit, or any hit. `alpha_random` decides on surfaces that cover a part (alpha.glsl).
Hit trace(Ray ray, bool any_hit, uint alpha_random) {
    count_ray();
    Hit hit = trace_body(ray, any_hit, alpha_random);
    if (hit.instance != NONE) {
        hit.transmittance = 0.0;
        count(COUNTER_HITS, 1u);
    }
    return hit;
}

Hit trace_closest(Ray ray, uint alpha_random) { return trace(ray, false, alpha_random); }

// The fraction of light that passes between the ray's ends.
float trace_transmittance(Ray ray) { return trace(ray, true, NO_ALPHA_RANDOM).transmittance; }
