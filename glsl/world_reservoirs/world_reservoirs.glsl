#pragma once
// World reservoirs: the light samples of path vertices, reused over space and time by the vertices of the next frame (Boissé,
// "World-Space Spatiotemporal Reservoir Reuse for Ray-Traced Global Illumination", 2021).
//
// Each vertex keeps a reservoir for all who come close: a light sample selected by what a matte white point at its position
// would reflect, or what it merged itself. In the next frame a vertex finds some of them in its cell and merges them with its
// own light sample. Each has its own shading point, so that the weights are exact. Their targets leave out visibility, and the merge
// asks for no ray: one shadow ray is traced for the sample that it selects. Contribution weights are made of the densities of
// light sources alone; what BSDF rays find is set against them where the sample is shaded.
#include "lights/samplers/sources.glsl"
#include "restir/matte_point.glsl"
#include "restir/shift.glsl"
#include "world_reservoirs/cells.glsl"
#include "world_reservoirs/world_table.glsl"

// The table that the previous frame made.
layout(scalar) readonly buffer WorldCellsBlock { uint at[]; } world_cells;
layout(scalar) readonly buffer WorldListBlock { uint at[]; } world_list;
// Keys of this frame's vertices.
layout(scalar) writeonly buffer WorldKeysBlock { uint at[]; } world_keys;
// Points and samples of both frames, by address where that is possible: large pictures have more vertices than a binding
// holds.
#if GEOMETRY_ADDRESSES
#define WORLD_BUFFER(access, Block, Type, name) \
    layout(buffer_reference, scalar, buffer_reference_align = 16) access buffer Block { Type at[]; };
#define previous_world_points PreviousWorldPointsBlock(restir.at.world.previous.points)
#define previous_world_samples PreviousWorldSamplesBlock(restir.at.world.previous.samples)
#define world_points WorldPointsBlock(restir.at.world.current.points)
#define world_samples WorldSamplesBlock(restir.at.world.current.samples)
#else
#define WORLD_BUFFER(access, Block, Type, name) layout(scalar) access buffer Block { Type at[]; } name;
#endif
WORLD_BUFFER(readonly, PreviousWorldPointsBlock, GpuGridPoint, previous_world_points)
WORLD_BUFFER(readonly, PreviousWorldSamplesBlock, GpuWorldSample, previous_world_samples)
WORLD_BUFFER(writeonly, WorldPointsBlock, GpuGridPoint, world_points)
WORLD_BUFFER(writeonly, WorldSamplesBlock, GpuWorldSample, world_samples)

// Entries of a list that are tried for each reservoir, since lists have gaps.
const uint WORLD_TRIES = 4u;

struct LightReservoir {
    LightSample value;
    // Unbiased contribution weight; 0: the reservoir is empty.
    float contribution_weight;
    float confidence;
};

LightReservoir empty_light_reservoir(float confidence) { return LightReservoir(empty_light_sample(), 0.0, confidence); }

// What a vertex' merge is made of: technique 0 is its own light sample, the others are reservoirs of the previous frame.
ShadingPoint world_point;
LightReservoir world_canonical;
uint world_found[MAX_WORLD_MERGED];
uint world_found_count;

// The key of the cell at a point, as a frame's camera divides space; 0 is none.
uint world_key(GpuCamera camera, vec3 position, vec3 normal, float u, vec3 shift) {
    int level;
    float side = cell_side(camera, restir.at.view.width, restir.at.world.cell, position, u, level);
    return max(cell_key(position, normal, side, level, restir.at.world.bins, shift), 1u);
}

// Whether a vertex keeps what it merges. In the weights of others it then stands for a matte white point, so it must be able to
// select whatever such a point reflects: light of any colour. A metal's lobe may be 0 in f32 where a matte point's is not, and an
// interpolated normal has another horizon.
bool keeps_merged_reservoir(ShadingPoint vertex, uint packed_normal) {
    vec3 diffuse = matte_albedo_of(vertex.bsdf, vertex.outgoing.z);
    return restir.at.world.keeps_merged != 0u && min(diffuse.x, min(diffuse.y, diffuse.z)) > 0.01
        && pack_octahedral(vertex.shading_normal) == packed_normal;
}

// A shading point with the normals of another. Its tangents may point elsewhere, so the direction of view is turned along.
ShadingPoint with_normals_of(ShadingPoint shading_point, ShadingPoint other) {
    vec3 outgoing = to_world(shading_point, shading_point.outgoing);
    shading_point.geometric_normal = other.geometric_normal;
    shading_point.shading_normal = other.shading_normal;
    shading_point.tangent = other.tangent;
    shading_point.bitangent = other.bitangent;
    shading_point.outgoing = to_shading(shading_point, outgoing);
    return shading_point;
}

// Finds reservoirs in the cell of a vertex, or in one close by: otherwise the borders of cells would show.
void find_world_reservoirs(ShadingPoint vertex, inout Random random) {
    world_found_count = 0u;
    vec4 u = to_unit(random_bits(random));
    // The normal as reservoirs keep it, which decides their bin.
    vec3 normal = unpack_octahedral(pack_octahedral(vertex.geometric_normal));
    uint key = world_key(restir.at.previous_camera, vertex.position, normal, u.w,
                         restir.at.world.jitter * (u.xyz - 0.5));
    uint slot;
    FIND_CELL(key, slot);
    if (slot == NONE) return;
    uint first = world_cells.at[list_of(slot)], length = world_cells.at[list_of(slot) + 1u] - first;
    // One of each part of the list.
    uint parts = min(restir.at.world.merged, length);
    for (uint i = 0u; i < parts; i += 1u) {
        // At most 16 parts of 2²⁷ entries: no product overflows.
        uint begin = i * length / parts, size = (i + 1u) * length / parts - begin;
        uint start = scale_to(random_bits(random).xy, size);
        for (uint turn = 0u; turn < min(WORLD_TRIES, size); turn += 1u) {
            uint entry = world_list.at[first + begin + (start + turn) % size];
            if (entry == 0u) continue;
            world_found[world_found_count] = (entry & WORLD_VERTEX_MASK) - 1u;
            world_found_count += 1u;
            break;
        }
    }
}

float confidence_of(uint technique) {
    if (technique == 0u) return world_canonical.confidence;
    count_read(1u);
    float confidence = unpack_confidence(previous_world_samples.at[world_found[technique - 1u]].history);
    return min(confidence, restir.at.world.confidence_cap);
}

LightReservoir technique_at(uint technique) {
    if (technique == 0u) return world_canonical;
    GpuWorldSample stored = previous_world_samples.at[world_found[technique - 1u]];
    count_read(4u);
    LightReservoir reservoir = empty_light_reservoir(confidence_of(technique));
    if (!(stored.weight > 0.0)) return reservoir;
    PackedReservoir packed = empty_packed();
    packed.words[HISTORY_WORD] = stored.history;
    packed.words[2] = stored.light;
    packed.words[3] = stored.uv;
    reservoir.value.point = unpack_point(packed, 2u);
    reservoir.contribution_weight = stored.weight;
    reservoir.value = light_sample_at(reservoir.value.point, epoch_of(technique));
    return reservoir;
}

ShadingPoint shading_point_of(uint technique) {
    if (technique == 0u) return world_point;
    count_read(4u);
    return grid_point_shading(previous_world_points.at[world_found[technique - 1u]]);
}

float transmittance(uint technique, ShadingPoint shading_point, LightSample value) { return 1.0; }

// The sample as this frame's lights show it, or as the previous frame's lights did.
bool shift(uint from, uint to, ShadingPoint there, inout LightSample value, out Shifted shifted) {
    shifted = Shifted(vec3(0.0), 1.0);
    if (MOVES && from != to) {
        shifted.jacobian = move_sample(value, epoch_of(from), epoch_of(to));
        if (!(shifted.jacobian > 0.0)) return false;
    }
    shifted.contribution = contribution(there, value);
    return true;
}

#define MergeSample LightSample
#define MergeReservoir LightReservoir
#define MERGE_EMPTY empty_light_reservoir(0.0)
#include "restir/merge.glsl"

// Merges a vertex' own reservoir with some of the previous frame.
LightReservoir merge_world(ShadingPoint vertex, LightReservoir own, inout Random random) {
    find_world_reservoirs(vertex, random);
    if (world_found_count == 0u) return own;
    count(COUNTER_NEIGHBOURS, world_found_count);
    world_point = vertex;
    world_canonical = own;
    // As published, reservoirs count by their confidence alone.
    uint mis = WORLD_RESERVOIRS == WORLD_RESERVOIRS_PUBLISHED ? MIS_CONSTANT : MIS_DEFENSIVE;
    return merge(mis, 1u + world_found_count, false, false, random).reservoir;
}

// Keeps a vertex' reservoir for the next frame.
void keep_world_reservoir(uint vertex, vec3 position, uint normal, LightReservoir reservoir, float u) {
    PackedReservoir packed = empty_packed();
    packed.words[HISTORY_WORD] = uint(reservoir.confidence);
    if (reservoir.contribution_weight > 0.0) pack_point(reservoir.value.point, 2u, packed);
    world_points.at[vertex] = GpuGridPoint(position, normal);
    world_samples.at[vertex] = GpuWorldSample(reservoir.contribution_weight, packed.words[HISTORY_WORD], packed.words[2],
                                              packed.words[3]);
    world_keys.at[vertex] = world_key(restir.at.view.camera, position, unpack_octahedral(normal), u, vec3(0.0));
    // The point with its normal, and the sample.
    count_written(4u + 4u);
}
