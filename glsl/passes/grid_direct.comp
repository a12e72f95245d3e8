#version 460
// Merges each pixel's initial reservoir of direct light with some of the hash grid. Targets of the grid's points do not include
// visibility, so that a merge traces one ray: from the pixel to one sample of the grid.
#include "lights/hash_grid.glsl"
#include "core/values.glsl"
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) readonly buffer GridReservoirsBlock { uint at[]; } grid_reservoirs;
layout(scalar) buffer ReservoirsBlock { uint at[]; } reservoirs;

// Technique 0 is the pixel; the others are points of the grid, by their indices.
Reservoir canonical;
Domain domain_here;
uint points[MAX_GRID_MERGED + 1u];
// The pixel's reflectance, by which the grid's targets compare with its own.
float reflectance;

Reservoir technique_at(uint technique) {
    if (technique == 0u) return canonical;
    PackedReservoir packed;
    LOAD_RESERVOIR(grid_reservoirs, points[technique], restir.at.grid.points, packed);
    Reservoir reservoir = unpack_reservoir(packed);
    reservoir.confidence = restir.at.grid.confidence;
    return reservoir;
}

float confidence_of(uint technique) { return technique == 0u ? canonical.confidence : restir.at.grid.confidence; }

Domain domain_of(uint technique) {
    if (technique == 0u) return domain_here;
    return grid_domain(grid_points.at[points[technique]], reflectance);
}

float transmittance(uint technique, Domain domain, Sample value) {
    return technique == 0u ? trace_segments(domain, value, CURRENT) : 1.0;
}

Sample shift_to(uint technique, Sample value, out float jacobian) {
    jacobian = 1.0;
    return value;
}

#include "restir/merge.glsl"

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot_of(pixel));
    if (!has_surface(data)) return;
    Ray ray = primary_ray(pixel);
    uint grid_slot = grid_slot_of_pixel(pixel, surface_position(data, ray), geometric_normal(data));
    if (grid_slot == NONE) return;
    GpuGridCell cell = grid_cells.at[grid_slot];
    uint count = min(cell.count, restir.at.grid.merged);
    Random random = pass_random(pixel, STREAM_GRID + 2u);
    for (uint i = 0u; i < count; i += 1u) {
        // One of each part of the cell's points.
        float part = (float(i) + to_unit(random_bits(random).x)) / float(count);
        points[i + 1u] = cell.first + min(uint(part * float(cell.count)), cell.count - 1u);
    }
    PackedReservoir packed;
    LOAD_RESERVOIR(reservoirs, slot_of(pixel), restir.at.slots, packed);
    canonical = unpack_reservoir(packed);
    domain_here = unpack_domain(data, ray);
    reflectance = luminance(domain_here.bsdf.diffuse) + luminance(specular_fresnel(domain_here.bsdf, domain_here.outgoing.z));
    uint mis = restir.at.grid.mixes_points != 0u ? MIS_CONSTANT : MIS;
    Merged merged = merge(mis, count + 1u, VISIBILITY >= VISIBILITY_INITIAL, false, random);
    // Neighbours merge the same reservoirs of the grid. If these counted beside the history, errors would stay.
    merged.reservoir.confidence = canonical.confidence;
    packed = pack_reservoir(merged.reservoir);
    STORE_RESERVOIR(reservoirs, slot_of(pixel), restir.at.slots, packed);
}
