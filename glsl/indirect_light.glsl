// Samples of indirect light: the second vertex of a path, a point of a triangle, and what arrives there
// from one direction. Another pixel takes the path over by looking at the second vertex itself, the
// reconnection shift. Everything is measured by the area there and by the solid angle beyond, neither of
// which depends on who looks: the shift's Jacobian is 1, and stands in each pixel's own cosine over
// distance squared.

// How a path goes on from its second vertex.
const uint PATH_NONE = 0u;
// To a point on a light, which is named so that a moving scene can carry it.
const uint PATH_TO_LIGHT = 1u;
// On over other surfaces.
const uint PATH_ONWARD = 2u;
// As either, but what leaves the second vertex is taken to be the same for all who look: biased.
const uint PATH_OUTGOING = 3u;

struct IndirectSample {
    uint kind;
    // The second vertex: a triangle, and where on it. In a corner it lies as near to who looks as rounding lets
    // it, so the weights of its corners are kept in full.
    uint instance;
    uint primitive;
    vec2 barycentrics;
    // PATH_TO_LIGHT: where the path ends.
    uint light;
    uint light_barycentrics;
    // Unit, from the second vertex on, and the radiance that comes from there; with PATH_OUTGOING that
    // which leaves the vertex instead.
    vec3 direction;
    vec3 radiance;
    // What follows from these, kept so that a format that stores it need not look up the triangle.
    TrianglePoint point;
    float clearance;
    uint material;
};

// Puts the second vertex where its triangle is.
void place_vertex(inout IndirectSample value, uint instance_number) {
    GpuInstance instance = instances.at[instance_number];
    value.point = triangle_point(instance, value.primitive, value.barycentrics);
    value.clearance = clearance_of(value.point.normal, value.point.error);
    value.material = owner_of(instance, value.primitive).material;
}

// Aims from there at the point where the path ends.
void aim_at_light(inout IndirectSample value, uint light_number) {
    LightSample light = sample_at(light_number, value.light_barycentrics);
    float cosine;
    spread_of(value.point.position, light.position, light.normal, value.direction, cosine);
    value.radiance = cosine > 0.0 || light.double_sided ? light.emission : vec3(0.0);
}

// The second vertex as who looks along `direction` sees it.
Domain vertex_domain(IndirectSample value, vec3 direction) {
    vec3 geometric_normal, shading_normal;
    face(value.point, direction, geometric_normal, shading_normal);
    return make_domain(value.point.position, value.clearance, geometric_normal, shading_normal, value.material, direction);
}

// What leaves the second vertex towards who looks along `direction`.
vec3 outgoing_radiance(IndirectSample value, vec3 direction) {
    Domain vertex = vertex_domain(value, direction);
    float pdf_solid_angle;
    if (value.kind != PATH_OUTGOING) return reflected_light(vertex, value.direction, value.radiance, pdf_solid_angle);
    // Lit from the other side, it sends nothing here.
    return dot(value.direction, vertex.geometric_normal) > 0.0 ? value.radiance : vec3(0.0);
}

// The integrand, by the area around the second vertex and the solid angle from there on, without visibility.
vec3 contribution(Domain domain, IndirectSample value) {
    vec3 direction;
    float cosine, pdf_solid_angle;
    float spread = spread_of(domain.position, value.point.position, value.point.normal, direction, cosine);
    vec3 light = reflected_light(domain, direction, vec3(spread), pdf_solid_angle);
    // Most of what is asked lies behind somebody's back.
    if (max_component(light) <= 0.0) return vec3(0.0);
    return light * outgoing_radiance(value, direction);
}

// The ray that decides whether the second vertex is visible.
Ray shadow_ray(Domain domain, IndirectSample value) {
    vec3 direction = value.point.position - domain.position;
    vec3 from = clear_origin(domain, direction);
    float side = dot(direction, value.point.normal) < 0.0 ? value.clearance : -value.clearance;
    vec3 way = value.point.position + side * value.point.normal - from;
    // In a crease the vertex may lie behind the other wall, so the ray ends before it.
    return Ray(from, 1.0 - clamp(value.clearance * inversesqrt(max(dot(way, way), TINY)), 1e-6, 0.5), way);
}
