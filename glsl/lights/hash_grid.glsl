#pragma once
// The hash grid (src/tracing/hash_grid.rs): points on surfaces, found by cell and by bin of normals, each with a reservoir of
// direct light.
#include "restir/direct.glsl"
#include "restir/frame.glsl"
#include "restir/reservoir.glsl"

layout(scalar) readonly buffer GridCellsBlock { GpuGridCell at[]; } grid_cells;
layout(scalar) readonly buffer GridPointsBlock { GpuGridPoint at[]; } grid_points;

uint grid_bin(vec3 normal) {
    uint bins = restir.at.grid.bins;
    uvec2 bin = min(uvec2((0.5 * octahedral_coordinates(normal) + 0.5) * float(bins)), bins - 1u);
    return bin.y * bins + bin.x;
}

uint grid_hash(uint key) {
    uint bits = (key ^ (key >> 16u)) * 0x7FEB352Du;
    bits = (bits ^ (bits >> 15u)) * 0x846CA68Bu;
    return bits ^ (bits >> 16u);
}

// The slot of the cell and bin at a point, or NONE.
uint grid_slot(vec3 position, vec3 normal) {
    vec3 at = (position - restir.at.grid.low) / restir.at.grid.cell;
    float cells = float(restir.at.grid.cells);
    if (any(lessThan(at, vec3(0.0))) || any(greaterThanEqual(at, vec3(cells)))) return NONE;
    uvec3 cell = uvec3(at);
    uint key = cell.x | (cell.y << 8u) | (cell.z << 16u) | (grid_bin(normal) << 24u);
    uint mask = restir.at.grid.slots - 1u;
    for (uint slot = grid_hash(key) & mask; true; slot = (slot + 1u) & mask) {
        uint found = grid_cells.at[slot].key;
        if (found == key) return slot;
        // At least half of the slots are empty.
        if (found == NONE) return NONE;
    }
    return NONE;
}

// The slot from whose points a pixel's neighbours are taken: that of a point that is moved by up to half a cell, or the borders
// of cells would show.
uint grid_slot_of_pixel(uvec2 pixel, vec3 position, vec3 normal) {
    Random random = pass_random(pixel, STREAM_GRID);
    vec3 u = to_unit(random_bits(random)).xyz;
    return grid_slot(position + (u - 0.5) * restir.at.grid.cell, normal);
}

// The domain of a point of the grid: matte and grey, since a cached target must not depend on a viewer. Its brightness
// matters only beside those of other techniques.
Domain grid_domain(GpuGridPoint point, float reflectance) {
    vec3 normal = unpack_octahedral(point.normal);
    GpuMaterial material;
    material.base_color = vec3(reflectance);
    material.metallic = 0.0;
    material.dielectric_f0 = vec3(0.0);
    material.dielectric_f90 = 0.0;
    material.roughness = 1.0;
    return make_domain(point.position, 0.0, normal, normal, material, -normal);
}
