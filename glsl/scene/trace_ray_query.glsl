#pragma once
// Body of the trace seam by ray query on the driver's acceleration structures. Included by trace.glsl.

uniform accelerationStructureEXT top_level;

Hit trace_body(Ray ray, bool any_hit) {
    uint flags = gl_RayFlagsOpaqueEXT | (any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top_level, flags, 0xFFu, ray.origin, 0.0, ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
    }
    Hit hit = no_hit(ray.t_max);
    if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT) {
        hit.t = rayQueryGetIntersectionTEXT(query, true);
        hit.instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
        hit.primitive = rayQueryGetIntersectionPrimitiveIndexEXT(query, true);
        hit.barycentrics = rayQueryGetIntersectionBarycentricsEXT(query, true);
    }
    return hit;
}
