#pragma once
// The table of world reservoirs: which cells exist, and a list of path vertices for each.
//
// `world_cells` holds the key of the cell at each slot, and after them where the list of each begins.
//
// Cells are found by their keys. A key belongs to one bucket, which keeps the largest of its keys in descending order. Which
// these are does not depend on the order in which they come (`world_insert.comp`). Cells without a slot, and vertices
// without a slot in the list of their cell, are dropped: they cost noise, never the mean, since the choice looks at no
// sample.
#include "core/random.glsl"
#include "restir/frame.glsl"

// In an entry of a list, the index of a vertex, plus 1. The bits above are random, and the highest entry stays.
const uint WORLD_VERTEX_MASK = (1u << WORLD_VERTEX_BITS) - 1u;

// The first slot of a key's bucket.
uint bucket_of(uint key) { return (key & (restir.at.world.buckets - 1u)) * restir.at.world.bucket_slots; }

// Where the table holds the beginning of the list of the cell at a slot; the next list begins where it ends.
uint list_of(uint slot) { return restir.at.world.buckets * restir.at.world.bucket_slots + slot; }

// The entry of a vertex in the list of its cell, and its slot there. Slots keep their order when the length changes, as do
// those that readers choose: if rounding puts a vertex into another cell, most of those who read the list find what they found.
uint list_entry(uint vertex, uint length, out uint slot) {
    uvec4 bits = pcg4d(uvec4(vertex, restir.at.frame, restir.at.view.seed, STREAM_WORLD));
    slot = scale_to(bits.yz, length);
    return (bits.x & ~WORLD_VERTEX_MASK) | (vertex + 1u);
}

// A macro, because GLSL cannot pass buffers to functions: the slot of a key, or NONE.
#define FIND_CELL(KEY, SLOT) \
    SLOT = NONE; \
    for (uint i_ = 0u; i_ < restir.at.world.bucket_slots; i_ += 1u) { \
        uint there_ = world_cells.at[bucket_of(KEY) + i_]; \
        if (there_ == KEY) SLOT = bucket_of(KEY) + i_; \
        if (there_ <= KEY) break; \
    }

// The vertex of this invocation; possibly beyond the last.
uint invocation_vertex() { return invocation_index(restir.at.view.interleave); }
