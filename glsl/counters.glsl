// What a pass counts, each pass in its own part of one buffer: refused values always, what costs
// time only where it was asked for.
#define COUNTS 1

layout(constant_id = 6) const bool COUNTING = false;
// Where the pass's part begins.
layout(constant_id = 7) const uint FIRST_COUNTER = 0u;

layout(scalar) buffer CountersBlock { uint at[]; } counters;

// Something that should not be: counted in any case.
void count_fault(uint counter) { atomicAdd(counters.at[FIRST_COUNTER + counter], 1u); }

void count(uint counter, uint amount) {
    if (COUNTING) atomicAdd(counters.at[FIRST_COUNTER + counter], amount);
}

// How many lanes come here together, and how many could.
void count_lanes(uint counter) {
    if (!COUNTING) return;
    atomicAdd(counters.at[FIRST_COUNTER + counter], 1u);
    if (subgroupElect()) atomicAdd(counters.at[FIRST_COUNTER + counter + 1u], gl_SubgroupSize);
}
