#version 460
// Marks the cells of the hash grid from which pixels will take reservoirs in this frame.
#include "lights/hash_grid.glsl"
#include "restir/sample_data.glsl"

layout(local_size_x = TILE * TILE) in;

SAMPLE_DATA_BUFFER(sample_data, SampleDataBlock);
layout(scalar) writeonly buffer GridWantedBlock { uint at[]; } grid_wanted;

void main() {
    uvec2 pixel = own_pixel();
    if (is_outside(pixel)) return;
    SampleData data = LOAD_SAMPLE_DATA(sample_data, slot_of(pixel));
    if (!has_surface(data)) return;
    uint slot = grid_slot_of_pixel(pixel, surface_position(data, primary_ray(pixel)), geometric_normal(data));
    // All write the same.
    if (slot != NONE) grid_wanted.at[slot] = restir.at.frame + 1u;
}
