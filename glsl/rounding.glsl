// What rounding does to points of surfaces, and how rays keep clear of it.

// Rounding of a point at this distance on a ray, for each axis.
vec3 ray_error(vec3 origin, vec3 direction, float depth) { return 2.4e-7 * (abs(origin) + abs(depth * direction)); }

// How far along a ray of unit direction the plane of a surface lies that faces it, and the error of the
// point there. Position and error are those of a point of the surface that the ray passes near.
float depth_along(vec3 origin, vec3 direction, vec3 position, vec3 position_error, vec3 normal, out vec3 error) {
    vec3 off = position - origin;
    float along = dot(off, direction);
    float cosine = min(dot(direction, normal), -1e-6);
    // The normal's own error weighs only on the way from the ray to the position.
    float depth = along + dot(off - along * direction, normal) / cosine;
    vec3 rounding = ray_error(origin, direction, depth);
    float depth_error = dot(abs(normal), position_error + rounding) / -cosine;
    error = rounding + depth_error * abs(direction);
    return depth;
}

// What barycentrics say of a triangle as large as a landscape can be wrong by the size of things that
// stand on it, and would lie inside them. Then the point is where the ray meets the plane: all of it,
// since a point that takes one coordinate from here and one from there lies off the plane.
void refine_by_ray(inout vec3 position, inout vec3 position_error, vec3 normal, vec3 origin, vec3 direction) {
    vec3 error;
    float depth = depth_along(origin, direction, position, position_error, normal, error);
    if (component_sum(error) < component_sum(position_error)) {
        position = origin + depth * direction;
        position_error = error;
    }
}

// How far along the normal a ray's origin must move to be clear of the surface.
float clearance_of(vec3 normal, vec3 error) { return 2.0 * dot(abs(normal), error); }

// How far back along a ray of this length a point lies before the surface, and before any other that the
// ray does not graze: in a crease the point itself may lie behind the other wall, which would then hide
// everything from it. Never so far back that it passes what the ray came from.
float way_back(vec3 error, float ray_length) { return min(component_sum(error), 0.5 * ray_length); }

// A ray origin that is off the surface on the side of `direction`, by as much as rounding can have
// moved the position: never a constant, which leaks in the small and floats in the large.
vec3 offset_origin(vec3 position, vec3 error, vec3 normal, vec3 direction) {
    float distance = clearance_of(normal, error);
    return position + (dot(direction, normal) < 0.0 ? -distance : distance) * normal;
}
