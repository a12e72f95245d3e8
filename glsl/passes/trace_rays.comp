#version 460
// Traces rays from a buffer, for tests and benchmarks of the tracers.
#include "core/workgroups.glsl"
#include "scene/trace.glsl"

layout(local_size_x = RAYS_PER_GROUP) in;

layout(scalar) readonly buffer RaysBlock { RayQuery at[]; } rays;
layout(scalar) writeonly buffer AnswersBlock { RayHit at[]; } answers;
layout(push_constant, scalar) uniform BatchBlock { RayBatch batch; };

void main() {
    uint index = interleaved_group(batch.interleave) * RAYS_PER_GROUP + gl_LocalInvocationIndex;
    if (index >= batch.count) return;
    RayQuery query = rays.at[index];
    Hit hit = trace(Ray(query.origin, query.t_max, query.direction), query.any != 0u, NO_ALPHA_RANDOM);
    bool missed = hit.instance == NONE;
    answers.at[index] = RayHit(missed ? -1.0 : hit.t, hit.instance, hit.primitive,
                                  hit.barycentrics.x, hit.barycentrics.y, hit.transmittance);
}
