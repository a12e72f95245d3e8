#pragma once
// Counters, each pass with its own range of one buffer. Rejected values and other faults are always counted; the
// rest costs time and is counted only with COUNTING.
#include "prelude.glsl"

layout(scalar) buffer CountersBlock { uint at[]; } counters;

// Counts a fault, with or without COUNTING.
void count_fault(uint counter) { atomicAdd(counters.at[FIRST_COUNTER + counter], 1u); }

void count(uint counter, uint amount) {
    if (COUNTING) atomicAdd(counters.at[FIRST_COUNTER + counter], amount);
}

// Counts words of memory: of sample data, reservoirs, pilots, light lists, points and samples of world reservoirs, colour and
// sums; not those of the scene, of keys and of tables.
void count_read(uint words) { count(COUNTER_READ, words); }
void count_written(uint words) { count(COUNTER_WRITTEN, words); }

// Counts the active lanes, and next to them all lanes of their subgroups.
void count_lanes(uint counter) {
    if (!COUNTING) return;
    atomicAdd(counters.at[FIRST_COUNTER + counter], 1u);
    if (subgroupElect()) atomicAdd(counters.at[FIRST_COUNTER + counter + 1u], gl_SubgroupSize);
}
