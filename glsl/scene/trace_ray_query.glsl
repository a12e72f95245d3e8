#pragma once
// Body of the trace seam by ray query on the driver's acceleration structures. Included by trace.glsl.

uniform accelerationStructureEXT top_level;

uint ray_flags(bool any_hit) {
    return (HAS_ALPHA ? gl_RayFlagsNoneEXT : gl_RayFlagsOpaqueEXT) | (any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
}

// Traces a query to its end. A macro, because GLSL cannot pass queries to functions.
#define FINISH_QUERY(QUERY, COIN, PASSED) \
    while (rayQueryProceedEXT(QUERY)) { \
        if (!HAS_ALPHA) continue; \
        uint index_ = rayQueryGetIntersectionInstanceCustomIndexEXT(QUERY, false); \
        uint primitive_ = rayQueryGetIntersectionPrimitiveIndexEXT(QUERY, false); \
        vec2 two_ = rayQueryGetIntersectionBarycentricsEXT(QUERY, false); \
        vec3 weights_ = vec3(1.0 - two_.x - two_.y, two_); \
        bool front_ = rayQueryGetIntersectionFrontFaceEXT(QUERY, false); \
        if (ends_ray(COIN, index_, load_instances(index_), primitive_, front_, weights_, PASSED)) { \
            rayQueryConfirmIntersectionEXT(QUERY); \
        } \
    }

Hit trace_body(Ray ray, bool any_hit, uint alpha_random) {
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top_level, ray_flags(any_hit), 0xFFu, ray.origin, 0.0, ray.direction, ray.t_max);
    Hit hit = no_hit(ray.t_max);
    FINISH_QUERY(query, alpha_random, hit.transmittance)
    if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT) {
        hit.t = rayQueryGetIntersectionTEXT(query, true);
        hit.instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
        hit.primitive = rayQueryGetIntersectionPrimitiveIndexEXT(query, true);
        hit.barycentrics = rayQueryGetIntersectionBarycentricsEXT(query, true);
    }
    return hit;
}
