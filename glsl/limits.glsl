// What the reconnection shift may do: beyond its limits it does not exist, for any sample either way.

// Who looks at a second vertex: a surface's point, and the eye that sees it.
struct View {
    vec3 position;
    vec3 eye;
};

// Whether two views are alike enough for one to take over the other's path, whichever made it: `here` and `there`
// are the path as each knows it. The Jacobian of the shift by solid angle is the ratio of the two spreads.
bool is_within_limits(View a, IndirectSample here, View b, IndirectSample there) {
    vec3 direction;
    float cosine;
    float spread_a = spread_of(a.position, here.point.position, here.point.normal, direction, cosine);
    float spread_b = spread_of(b.position, there.point.position, there.point.normal, direction, cosine);
    float limit = restir.at.jacobian_limit, least = restir.at.min_distance;
    if (limit >= 1.0 && max(spread_a, spread_b) > limit * min(spread_a, spread_b)) return false;
    return distance(a.position, here.point.position) >= least * distance(a.position, a.eye)
        && distance(b.position, there.point.position) >= least * distance(b.position, b.eye);
}
