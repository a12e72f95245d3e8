// The trace seam: `trace` finds the closest hit, or any, along a ray. Its bodies are a ray query
// on the driver's structures and an eight-wide BVH traversed in compute.

struct Ray {
    vec3 origin;
    // Hits are looked for at 0 < t < t_max, in lengths of the direction.
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
};

// Who defines LAST_FRAME can also look back.

#if TRACE_RAY_QUERY
#include "trace_ray_query.glsl"
#else
#include "trace_compute_bvh.glsl"
#endif

void count_ray() {
#ifdef COUNTS
    count(COUNTER_RAYS, 1u);
    count_lanes(COUNTER_TRACE_LANES);
#endif
}

// The seam itself: the closest hit, or any.
Hit trace(Ray ray, bool any_hit) {
    count_ray();
    return trace_body(ray, any_hit);
}

Hit trace_closest(Ray ray) { return trace(ray, false); }

// Whether nothing lies between the ray's ends.
bool trace_visible(Ray ray) { return trace(ray, true).instance == NONE; }

#ifdef LAST_FRAME
// Whether nothing lies, or in the last frame lay, between the ray's ends.
bool trace_visible(Ray ray, bool before) {
    count_ray();
    return trace_visible_body(ray, before);
}
#endif
