// From a hit to the surface there.

struct Surface {
    vec3 position;
    // Bound of the position's error by rounding, for each axis.
    vec3 error;
    // Unit normals on the side the ray came from.
    vec3 geometric_normal;
    vec3 shading_normal;
    uint material;
    // Number of the instance in the scene.
    uint instance;
    // NONE unless the triangle is a light.
    uint light;
    // Whether the ray came to the counter-clockwise side.
    bool front;
};

// Whose a triangle is.
struct Owner {
    uint material;
    // Number of the instance in the scene.
    uint instance;
    // NONE unless the triangle is a light.
    uint light;
};

Owner owner_of(GpuInstance instance, uint primitive) {
    Owner owner = Owner(instance.material, instance.id, NONE);
    uint rank = primitive;
    if (instance.first_part != NONE) {
        uvec3 part = triangle_parts.at[instance.first_part + primitive];
        owner.material = part.x;
        rank = part.y;
        owner.instance += part.z;
    }
    if (instance.first_light != NONE && rank != NONE) owner.light = instance.first_light + rank;
    return owner;
}

// A corner's normal in the world. It becomes unit before it is interpolated: only then does a mesh
// look the same through an uneven transform as with its corners moved there beforehand.
vec3 corner_normal(GpuInstance instance, uint packed) {
    return normalize(transform_normal(instance.world_to_object, unpack_octahedral(packed)));
}

// Rounding of a point on a ray, for each axis.
vec3 ray_error(Ray ray, float depth) { return 2.4e-7 * (abs(ray.origin) + abs(depth * ray.direction)); }

// A point of a triangle that was hit lies on the ray too. Each coordinate comes from where it is known
// better: what barycentrics say of a triangle as large as a landscape can be wrong by the size of
// things that stand on it, and would lie inside them.
void refine_by_ray(inout Surface surface, Ray ray) {
    vec3 off = surface.position - ray.origin;
    float along = dot(off, ray.direction);
    float cosine = dot(ray.direction, surface.geometric_normal);
    // To the triangle's plane; the normal's own error weighs only on the way from the ray to the point.
    float depth = along + dot(off - along * ray.direction, surface.geometric_normal) / min(cosine, -1e-6);
    vec3 rounding = ray_error(ray, depth);
    float depth_error = dot(abs(surface.geometric_normal), surface.error + rounding) / max(-cosine, 1e-6);
    vec3 error = rounding + depth_error * abs(ray.direction);
    bvec3 better = lessThan(error, surface.error);
    surface.position = mix(surface.position, ray.origin + depth * ray.direction, better);
    surface.error = mix(surface.error, error, better);
}

// The surface that a ray of unit direction met.
Surface surface_at(Hit hit, Ray ray) {
    GpuInstance instance = instances.at[hit.instance];
    uint triangle = instance.first_triangle + hit.primitive;
    vec3 a, b, c;
    triangle_corners(triangle, a, b, c);
    vec2 weight = hit.barycentrics;
    vec3 edge1 = b - a, edge2 = c - a;
    vec3 p = a + weight.x * edge1 + weight.y * edge2;
    Surface surface;
    surface.position = transform_point(instance.object_to_world, p);
    // Seven roundings, each half of 2^-23 of the largest term.
    vec3 reach = max(abs(a), max(abs(b), abs(c)));
    surface.error = 8.3446503e-7 * (abs(instance.object_to_world[0]) * reach.x
        + abs(instance.object_to_world[1]) * reach.y
        + abs(instance.object_to_world[2]) * reach.z + abs(instance.object_to_world[3]));

    vec3 normal = normalize(transform_normal(instance.world_to_object, unit_cross(edge1, edge2)));
    surface.front = dot(normal, ray.direction) < 0.0;
    surface.geometric_normal = surface.front ? normal : -normal;
    refine_by_ray(surface, ray);
    surface.shading_normal = surface.geometric_normal;
    if (instance.first_normal != NONE) {
        uvec3 corners = normals.at[instance.first_normal + hit.primitive];
        vec3 shading = (1.0 - weight.x - weight.y) * corner_normal(instance, corners.x)
            + weight.x * corner_normal(instance, corners.y) + weight.y * corner_normal(instance, corners.z);
        float size = dot(shading, shading);
        // Opposite corner normals can cancel.
        if (size > TINY) shading *= inversesqrt(size);
        else shading = normal;
        if (dot(shading, surface.geometric_normal) < 0.0) shading = -shading;
        // At a silhouette the interpolated normal may look away from the eye, which would leave
        // black specks there: it is bent until it just faces the eye.
        float facing = -dot(shading, ray.direction);
        if (facing < LEAST_FACING) shading = normalize(shading - (LEAST_FACING - facing) * ray.direction);
        surface.shading_normal = shading;
    }

    Owner owner = owner_of(instance, hit.primitive);
    surface.material = owner.material;
    surface.instance = owner.instance;
    surface.light = owner.light;
    return surface;
}

// How far back along the ray that came a point surely lies before the surface. Before any surface: in a
// crease the point itself may lie behind the other wall, which would then hide everything from it.
float way_back(vec3 error) { return 2.0 * (error.x + error.y + error.z); }

// A ray origin that is off the surface on the side of `direction`, by as much as rounding can have
// moved the position: never a constant, which leaks in the small and floats in the large.
vec3 offset_origin(vec3 position, vec3 error, vec3 geometric_normal, vec3 direction) {
    float distance = 2.0 * dot(abs(geometric_normal), error);
    vec3 moved = position + (dot(direction, geometric_normal) < 0.0 ? -distance : distance) * geometric_normal;
    return moved;
}
