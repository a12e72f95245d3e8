// Samples of direct light: a point on an emissive triangle, in area measure.

struct LightSample {
    // The light, and where on it: two 16-bit barycentric weights.
    uint light;
    uint barycentrics;
    // What follows from these, kept so that a format that stores it need not look up the light.
    vec3 position;
    vec3 normal;
    vec3 emission;
    bool double_sided;
};

LightSample sample_at(uint number, uint barycentrics) {
    GpuLight light = light_at(number);
    vec3 position = light_position(light, unpackUnorm2x16(barycentrics));
    return LightSample(number, barycentrics, position, light.normal, light.emission, light.double_sided != 0u);
}

// A point of a light that was picked by its probability, or evenly.
LightSample sample_lights(uint count, bool evenly, uvec4 bits) {
    uint number = evenly ? scale_to(bits.x, count) : pick_light(count, bits.xy);
    return sample_at(number, packUnorm2x16(uniform_barycentrics(bits.zw)));
}

// Density with which `sample_lights` makes a point of a light.
float light_sample_pdf_area(uint count, bool evenly, uint number) {
    GpuLight light = light_at(number);
    return evenly ? 1.0 / (float(count) * light.area) : light_pdf_area(light);
}

// What a surface sends to its eye of the light from a direction: f · cosine · radiance. `pdf_solid_angle`
// is the density with which sampling the BSDF would have taken it.
vec3 reflected_light(Domain domain, vec3 direction, vec3 radiance, out float pdf_solid_angle) {
    pdf_solid_angle = 0.0;
    if (dot(direction, domain.geometric_normal) <= 0.0) return vec3(0.0);
    vec3 incoming = to_shading(domain, direction);
    return evaluate_bsdf(domain.bsdf, domain.outgoing, incoming, pdf_solid_angle) * radiance * max(incoming.z, 0.0);
}

// The solid angle at `from` of a unit of area around a point with this normal, and the way there.
float spread_of(vec3 from, vec3 point, vec3 normal, out vec3 direction, out float cosine) {
    vec3 toward = point - from;
    float distance_squared = max(dot(toward, toward), TINY);
    direction = toward * inversesqrt(distance_squared);
    cosine = -dot(normal, direction);
    return abs(cosine) / distance_squared;
}

// The integrand in area measure: f · emission · cosine · cosine / distance², without visibility.
// `pdf_area` is the density with which sampling the BSDF would have found the point.
vec3 contribution(Domain domain, LightSample value, out float pdf_area) {
    pdf_area = 0.0;
    vec3 direction;
    float cosine;
    float spread = spread_of(domain.position, value.position, value.normal, direction, cosine);
    if (cosine <= 0.0 && !value.double_sided) return vec3(0.0);
    vec3 light = reflected_light(domain, direction, value.emission, pdf_area) * spread;
    pdf_area *= spread;
    return light;
}

// The ray that decides whether a point of a light is visible.
Ray shadow_ray(Domain domain, LightSample value) {
    vec3 direction = value.position - domain.position;
    vec3 error = light_position_error(light_at(value.light));
    vec3 from = clear_origin(domain, direction);
    vec3 to = offset_origin(value.position, error, value.normal, -direction);
    // Ends short of the light by what rounding costs along the whole way.
    return Ray(from, 1.0 - 1e-6, to - from);
}

// What a sample adds to the pixel for each unit of its weight.
vec3 contribution(Domain domain, LightSample value) {
    float pdf_area;
    return contribution(domain, value, pdf_area);
}
