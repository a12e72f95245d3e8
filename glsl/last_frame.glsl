// The last frame, for passes that look back. They define LAST_FRAME, and include this before the trace.

// Whether anything but the camera moves. Then the last frame's lights and instances stand behind this
// frame's in the same buffers.
layout(constant_id = 8) const bool MOVES = false;

// Where each instance of the scene was, by its number.
layout(scalar) readonly buffer CarriesBlock { GpuCarry at[]; } carries;

// Where a point of an instance was.
vec3 carried_point(uint instance, vec3 point) {
    return MOVES ? transform_point(carries.at[instance].now_to_before, point) : point;
}

// How a unit normal of an instance looked, or 0 if the instance was flat then.
vec3 carried_normal(uint instance, vec3 normal) {
    if (!MOVES) return normal;
    vec3 columns[4] = carries.at[instance].now_to_before;
    // By the matrix of cofactors: a transform that had no volume has no inverse.
    vec3 x = cross(columns[1], columns[2]), y = cross(columns[2], columns[0]), z = cross(columns[0], columns[1]);
    vec3 carried = x * normal.x + y * normal.y + z * normal.z;
    if (dot(columns[0], x) < 0.0) carried = -carried;
    float size = max_component(abs(carried));
    return size > 0.0 ? normalize(carried / size) : vec3(0.0);
}
