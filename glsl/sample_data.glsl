// Primary surfaces as later passes know them: packed in a buffer, unpacked into domains.

// A shading point as target functions see it. A pixel without a surface has no domain.
struct Domain {
    vec3 position;
    // How far along the normal a ray's origin must move to be clear of rounding.
    float clearance;
    // Unit, on the camera's side.
    vec3 geometric_normal;
    vec3 shading_normal;
    vec3 tangent;
    vec3 bitangent;
    // Towards the camera, in the shading frame.
    vec3 outgoing;
    Bsdf bsdf;
};

vec3 to_shading(Domain domain, vec3 direction) {
    return vec3(dot(direction, domain.tangent), dot(direction, domain.bitangent), dot(direction, domain.shading_normal));
}

vec3 to_world(Domain domain, vec3 direction) {
    return domain.tangent * direction.x + domain.bitangent * direction.y + domain.shading_normal * direction.z;
}

// Two signed octahedral coordinates of `bits` bits each.
uint pack_octahedral(vec3 n, uint bits) {
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 e = n.xy;
    if (n.z < 0.0) e = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    float most = float((1u << (bits - 1u)) - 1u);
    ivec2 i = ivec2(round(clamp(e, -1.0, 1.0) * most));
    uint mask = (1u << bits) - 1u;
    return (uint(i.x) & mask) | ((uint(i.y) & mask) << bits);
}

vec3 unpack_octahedral(uint word, uint bits) {
    float most = float((1u << (bits - 1u)) - 1u);
    ivec2 i = ivec2(bitfieldExtract(int(word), 0, int(bits)), bitfieldExtract(int(word), int(bits), int(bits)));
    return octahedral_direction(vec2(i) / most);
}

// Normals and clearance share a word: 12 + 12 bits and the clearance's exponent, rounded up.
uint pack_geometry(vec3 geometric_normal, float clearance) {
    uint exponent = min((floatBitsToUint(clearance) >> 23u) + 1u, 254u);
    return pack_octahedral(geometric_normal, 12u) | (exponent << 24u);
}

SampleData pack_sample_data(Surface surface, Ray ray) {
    // Along the ray, so that camera, pixel and depth give back a position that rays can start from.
    vec3 error;
    vec3 normal = surface.geometric_normal;
    float depth = depth_along(ray.origin, ray.direction, surface.position, surface.error, normal, error);
    depth -= way_back(error, depth);
    return SampleData(depth, pack_geometry(normal, clearance_of(normal, error)),
                      pack_octahedral(surface.shading_normal, 16u), surface.material, surface.instance);
}

bool has_surface(SampleData data) { return data.instance != NONE; }

vec3 surface_position(SampleData data, Ray ray) { return ray.origin + data.depth * ray.direction; }

// A surface as who looks along `direction` sees it, with the normals on that side.
Domain make_domain(vec3 position, float clearance, vec3 geometric_normal, vec3 shading_normal, uint material, vec3 direction) {
    Domain domain;
    domain.position = position;
    domain.clearance = clearance;
    domain.geometric_normal = geometric_normal;
    domain.shading_normal = shading_normal;
    tangent_frame(shading_normal, domain.tangent, domain.bitangent);
    domain.outgoing = to_shading(domain, -direction);
    domain.bsdf = make_bsdf(material_at(material), max(domain.outgoing.z, 0.0));
    return domain;
}

Domain unpack_domain(SampleData data, Ray ray) {
    float clearance = uintBitsToFloat((data.geometry >> 24u) << 23u);
    return make_domain(surface_position(data, ray), clearance, unpack_octahedral(data.geometry, 12u),
                       unpack_octahedral(data.shading_normal, 16u), data.material, ray.direction);
}

// A ray origin clear of the surface on the side of `direction`.
vec3 clear_origin(Domain domain, vec3 direction) {
    float side = dot(direction, domain.geometric_normal) < 0.0 ? -1.0 : 1.0;
    return domain.position + (side * domain.clearance) * domain.geometric_normal;
}
