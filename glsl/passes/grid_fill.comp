#version 460
// Makes the reservoirs of the hash grid that are wanted in this frame and do not exist yet, and those whose turn it is.
#include "lights/hash_grid.glsl"
#include "lights/sources.glsl"

layout(local_size_x = TILE * TILE) in;

layout(scalar) readonly buffer GridWantedBlock { uint at[]; } grid_wanted;
layout(scalar) buffer GridReservoirsBlock { uint at[]; } grid_reservoirs;

void main() {
    uint index = interleaved_group(restir.at.view.interleave) * (TILE * TILE) + gl_LocalInvocationIndex;
    if (index >= restir.at.grid.points) return;
    GpuGridPoint point = grid_points.at[index];
    if (grid_wanted.at[point.slot] != restir.at.frame + 1u) return;
    uint history = grid_reservoirs.at[word_of(index, HISTORY_WORD, restir.at.grid.points)];
    uint refresh = restir.at.grid.refresh;
    bool is_turn = refresh != 0u && (restir.at.frame + index) % refresh == 0u;
    if (unpack_confidence(history) > 0.0 && !is_turn) return;

    GpuGridCell cell = grid_cells.at[point.slot];
    Random random = random_stream(index, restir.at.frame, restir.at.view.seed, STREAM_GRID + 1u);
    Receiver receiver = distant_receiver();
    Stream stream = empty_stream();
    Reservoir reservoir = empty_reservoir(1.0);
    Domain domain = grid_domain(point, 1.0);
    for (uint i = 0u; i < restir.at.grid.candidates; i += 1u) {
        if (restir.at.grid.mixes_points != 0u) {
            uint other = min(uint(to_unit(random_bits(random).x) * float(cell.count)), cell.count - 1u);
            domain = grid_domain(grid_points.at[cell.first + other], 1.0);
        }
        float pdf;
        LightSample value = draw_light_sample(receiver, i, random_bits(random), pdf);
        float target = target_function(domain, value);
        float weight = target / (float(restir.at.grid.candidates) * pdf);
        if (stream_add(stream, i, weight, target, random_choice(random))) reservoir.value = value;
    }
    if (stream.chosen != NONE) reservoir.contribution_weight = accept_weight(contribution_weight(stream));
    PackedReservoir packed = pack_reservoir(reservoir);
    STORE_RESERVOIR(grid_reservoirs, index, restir.at.grid.points, packed);
}
