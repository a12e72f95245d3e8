#pragma once
// The hash grid. Space is divided into cells, and each cell by the direction of normals into bins. A cell's bin has some
// slots for reservoirs of direct light, which a hash finds. In each frame some surfaces claim slots, one at random of those
// of their cell, and fill them with a reservoir of many candidates; the pixels around merge it with their own.
//
// No cell is stored: two cells may hash to the same slot, of which one then has fewer reservoirs.
#include "world_reservoirs/cells.glsl"
#include "restir/samples/direct.glsl"
#include "restir/frame.glsl"
#include "restir/matte_point.glsl"
#include "restir/reservoir.glsl"
#include "restir/sample_data.glsl"

// Bits of the index of a claim's source, plus 1; those above are random, and the highest claim stays.
const uint GRID_SOURCE_BITS = 26u;
const uint GRID_SOURCE_MASK = (1u << GRID_SOURCE_BITS) - 1u;

// The key of the cell and the bin at a point; `u` and `shift` as in world_reservoirs/cells.glsl.
uint grid_key(vec3 position, vec3 normal, float u, vec3 shift) {
    float side = restir.at.grid.cell;
    int level = 0;
    if (HASH_GRID == HASH_GRID_PIXELS) {
        side = cell_side(restir.at.view.camera, restir.at.view.width, restir.at.grid.cell, position, u, level);
    }
    return cell_key(position, normal, side, level, restir.at.grid.bins, shift);
}

// Where the reservoir `index` of a cell's bin is.
uint grid_slot(uint key, uint index) { return pcg4d(uvec4(key, index, 0u, 0u)).x & (restir.at.grid.slots - 1u); }

// A claim of a slot.
struct GridClaim {
    uint key;
    uint slot;
    uint value;
};

// The pixel of a block that claims a slot in this frame; possibly outside the picture.
uvec2 claiming_pixel(uint block, uint bits) {
    uint blocks = (restir.at.view.width + GRID_BLOCK - 1u) / GRID_BLOCK;
    uvec2 inside = uvec2(bits, bits >> 8u) % GRID_BLOCK;
    return uvec2(block % blocks, block / blocks) * GRID_BLOCK + inside;
}

Random claim_random(uint source) { return random_stream(source, restir.at.frame, restir.at.view.seed, STREAM_GRID); }

// The claim of a surface.
GridClaim claim_of(uint source, vec3 position, vec3 normal, inout Random random) {
    uvec4 bits = random_bits(random);
    uint key = grid_key(position, normal, to_unit(bits.x), vec3(0.0));
    uint slot = grid_slot(key, bits.y % restir.at.grid.reservoirs);
    return GridClaim(key, slot, (bits.z & ~GRID_SOURCE_MASK) | (source + 1u));
}

// Macros, because GLSL cannot pass buffers to functions. VALID tells whether the source has a surface.
#define CLAIM_OF_SOURCE(SOURCE, RANDOM, CLAIM, VALID) \
    if (HASH_GRID == HASH_GRID_PIXELS) { \
        uvec2 pixel_ = claiming_pixel(SOURCE, random_bits(RANDOM).x); \
        VALID = !is_outside(pixel_); \
        if (VALID) { \
            SampleData data_ = LOAD_SAMPLE_DATA(sample_data, slot_of(pixel_)); \
            VALID = has_surface(data_); \
            vec3 position_ = surface_position(data_, primary_ray(pixel_)); \
            if (VALID) CLAIM = claim_of(SOURCE, position_, geometric_normal(data_), RANDOM); \
        } \
    } else { \
        GpuGridPoint point_ = grid_points.at[SOURCE]; \
        VALID = true; \
        CLAIM = claim_of(SOURCE, point_.position, unpack_octahedral(point_.normal), RANDOM); \
    }

// The shading point of the source of a claim. Points from a list have no viewer: they are matte and white.
#define GRID_SHADING_POINT(CLAIMED, SHADING_POINT) \
    uint source_ = ((CLAIMED) & GRID_SOURCE_MASK) - 1u; \
    if (HASH_GRID == HASH_GRID_PIXELS) { \
        Random random_ = claim_random(source_); \
        uvec2 pixel_ = claiming_pixel(source_, random_bits(random_).x); \
        SHADING_POINT = unpack_shading_point(LOAD_SAMPLE_DATA(sample_data, slot_of(pixel_)), primary_ray(pixel_)); \
    } else { \
        SHADING_POINT = grid_point_shading(grid_points.at[source_]); \
    }
