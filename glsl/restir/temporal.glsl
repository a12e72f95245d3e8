#pragma once
// Temporal reuse: each pixel's reservoir merges with the reservoir that its surface had in the previous frame. Where
// something moves, that reservoir's shading point uses the previous instances and lights, and its sample moves with the
// triangle and the light that it names. A pass first includes direct.glsl or indirect.glsl.
#include "core/values.glsl"
#include "restir/reservoir.glsl"
#include "restir/shift.glsl"
#include "restir/similarity.glsl"
#include "scene/previous_frame.glsl"

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
SAMPLE_DATA_BUFFER(previous_sample_data, PreviousSampleDataBlock);
layout(scalar) readonly buffer HistoryBlock { uint at[]; } history;
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;

// What a pixel's merge is made of: technique 0 is the canonical, 1 the history.
Reservoir canonical, historic;
ShadingPoint point_now, point_before;

Reservoir technique_at(uint technique) {
    if (technique == 0u) return canonical;
    return historic;
}

float confidence_of(uint technique) { return technique == 0u ? canonical.confidence : historic.confidence; }

ShadingPoint shading_point_of(uint technique) {
    if (technique == 0u) return point_now;
    return point_before;
}

// Whether the previous frame saw exactly the same: then both samples, visible in their own shading points, are visible in both.
bool is_static;

float transmittance(uint technique, ShadingPoint shading_point, Sample value) {
    if (is_static) return 1.0;
    uint epoch = epoch_of(technique);
    uint segments = MOVES ? segment_count(value) : 1u;
    float passed = 1.0;
    for (uint i = 0u; passed > 0.0 && i < segments; i += 1u) {
        passed *= trace_transmittance(segment_ray(shading_point, value, i, epoch), epoch);
    }
    return passed;
}

View view_of(uint technique) {
    if (technique == 0u) return View(point_now.position, eye_of(restir.at.view.camera, point_now.position));
    return View(point_before.position, eye_of(restir.at.previous_camera, point_before.position));
}

// A sample moves with the triangle and the light that it names, from the frame of one technique to that of the other.
bool shift(uint from, uint to, ShadingPoint there, inout Sample value, out Shifted shifted) {
    shifted = Shifted(vec3(0.0), 1.0);
    if (from != to) {
        Sample old = value;
        if (MOVES) shifted.jacobian = move_sample(value, epoch_of(from), epoch_of(to));
        if (!(shifted.jacobian > 0.0)) return false;
        if (!is_within_limits(view_of(from), old, view_of(to), value, restir.at.jacobian_limit, restir.at.min_distance)) return false;
    }
    shifted.contribution = contribution(there, value);
    return true;
}

#define MergeSample Sample
#define MergeReservoir Reservoir
#define MERGE_EMPTY empty_reservoir(0.0)
#include "restir/merge.glsl"

// Where the surface of a pixel was in the previous frame.
vec3 previous_position(SampleData data, Ray ray) {
    vec3 position = surface_position(data, ray);
    if (SURFACES_NAMED) return previous_point(data.instance, data.material_or_primitive, named_weights(data), position);
    return previous_point(data.instance, position);
}

vec3 previous_compared_normal(SampleData data) {
    vec3 normal = compared_normal(data);
    if (SURFACES_NAMED) return previous_normal(data.instance, data.material_or_primitive, normal);
    return previous_normal(data.instance, normal);
}

// Merges the pixel of this invocation.
void merge_history() {
    uvec2 pixel = invocation_pixel();
    if (is_outside(pixel)) return;
    uint slot = slot_of(pixel);
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot);
    if (!has_surface(data)) return;
    Ray ray = primary_ray(pixel);
    // Reprojection: where the surface was, and which pixel showed it.
    vec3 position = previous_position(data, ray);
    vec2 at;
    if (!project(restir.at.previous_camera, position - restir.at.previous_camera.position, vec2(picture_size()), at)) return;
    // Before the conversion to integers, which is undefined beyond their range.
    ivec2 before = ivec2(floor(clamp(at, vec2(-1.0), vec2(picture_size()))));
    if (is_outside(before)) return;
    uint previous_slot = slot_of(uvec2(before));
    SampleData previous = LOAD_SAMPLE_DATA(previous_sample_data, previous_slot);
    Ray previous_ray = previous_primary_ray(uvec2(before));
    if (MOVES) {
        vec3 normal = previous_compared_normal(data), eye = eye_of(restir.at.previous_camera, position);
        if (!is_similar(material_index(data), normal, distance(position, eye), eye, previous, previous_ray)) return;
    } else if (!is_similar(data, ray, previous, previous_ray)) {
        return;
    }

    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
    canonical = unpack_reservoir(packed, epoch_of(0u));
    LOAD_RESERVOIR(history, previous_slot, restir.at.slots, packed);
    historic = unpack_reservoir(packed, epoch_of(1u));
    historic.confidence = min(historic.confidence, restir.at.reuse.temporal_confidence_cap);
    historic.age += 1u;
    is_static = !MOVES && before == ivec2(pixel) && previous == data && previous_ray == ray;
    point_now = unpack_shading_point(data, ray);
    point_before = unpack_shading_point(previous, previous_ray, PREVIOUS);
    count(COUNTER_NEIGHBOURS, 1u);
    Random random = pass_random(pixel, FIRST_STREAM + STREAM_TEMPORAL);
    packed = pack_reservoir(merge(MIS, 2u, VISIBILITY == VISIBILITY_WEIGHTS, false, random).reservoir);
    STORE_RESERVOIR(reservoirs, slot, restir.at.slots, packed);
}
