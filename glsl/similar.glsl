// Which surfaces are alike enough for reuse to pay. It looks at sample data alone, never at a
// reservoir: a choice that depends on a sample would bias the merge.

// What surfaces are compared by: `a` as it is seen from `eye`, `b` wherever it was seen from.
bool similar(uint material, vec3 normal, float depth, vec3 eye, SampleData b, Ray ray_b) {
    if (!has_surface(b) || (restir.at.same_material != 0u && material != b.material)) return false;
    if (dot(normal, unpack_octahedral(b.shading_normal, 16u)) < restir.at.least_normal_cosine) return false;
    return abs(distance(surface_position(b, ray_b), eye) - depth) <= restir.at.depth_tolerance * depth;
}

// Both as the camera of `a` sees them.
bool similar(SampleData a, Ray ray_a, SampleData b, Ray ray_b) {
    return similar(a.material, unpack_octahedral(a.shading_normal, 16u), a.depth, ray_a.origin, b, ray_b);
}
