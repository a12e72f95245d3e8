// Which surfaces are alike enough for reuse to pay. It looks at sample data alone, never at a
// reservoir: a choice that depends on a sample would bias the merge.
bool similar(SampleData a, Ray ray_a, SampleData b, Ray ray_b) {
    if (!has_surface(b) || (restir.at.same_material != 0u && a.material != b.material)) return false;
    vec3 normal = unpack_octahedral(a.shading_normal, 16u);
    if (dot(normal, unpack_octahedral(b.shading_normal, 16u)) < restir.at.least_normal_cosine) return false;
    // Both as the camera of `a` sees them: the camera may have moved.
    float depth = distance(surface_position(b, ray_b), ray_a.origin);
    return abs(depth - a.depth) <= restir.at.depth_tolerance * a.depth;
}
