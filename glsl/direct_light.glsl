// Samples of direct light: a point on an emissive triangle, in area measure.

struct Sample {
    // The light, and where on it: two 16-bit barycentric weights.
    uint light;
    uint barycentrics;
    // What follows from these, kept so that a format that stores it need not look up the light.
    vec3 position;
    vec3 normal;
    vec3 emission;
    bool double_sided;
};

Sample sample_at(uint number, uint barycentrics) {
    GpuLight light = light_at(number);
    vec3 position = light_position(light, unpackUnorm2x16(barycentrics));
    return Sample(number, barycentrics, position, light.normal, light.emission, light.double_sided != 0u);
}

// A point of a light that was picked by its probability, or evenly.
Sample sample_lights(uint count, bool evenly, uvec4 bits) {
    uint number = evenly ? scale_to(bits.x, count) : pick_light(count, bits.xy);
    return sample_at(number, packUnorm2x16(uniform_barycentrics(bits.zw)));
}

// Density with which `sample_lights` makes a point of a light.
float light_sample_pdf_area(uint count, bool evenly, uint number) {
    GpuLight light = light_at(number);
    return evenly ? 1.0 / (float(count) * light.area) : light_pdf_area(light);
}

// The integrand in area measure: f · emission · cosine · cosine / distance², without visibility.
// `pdf_area` is the density with which sampling the BSDF would have found the point.
vec3 direct_contribution(Domain domain, Sample value, out float pdf_area) {
    pdf_area = 0.0;
    vec3 toward = value.position - domain.position;
    float distance_squared = dot(toward, toward);
    vec3 direction = toward * inversesqrt(max(distance_squared, TINY));
    float cosine = -dot(value.normal, direction);
    if (dot(direction, domain.geometric_normal) <= 0.0 || (cosine <= 0.0 && !value.double_sided)) return vec3(0.0);
    vec3 incoming = to_shading(domain, direction);
    float pdf_solid_angle;
    vec3 f = evaluate_bsdf(domain.bsdf, domain.outgoing, incoming, pdf_solid_angle);
    float spread = abs(cosine) / max(distance_squared, TINY);
    pdf_area = pdf_solid_angle * spread;
    return f * value.emission * (max(incoming.z, 0.0) * spread);
}

// The ray that decides whether a point of a light is visible.
Ray shadow_ray(Domain domain, Sample value) {
    vec3 direction = value.position - domain.position;
    vec3 error = light_position_error(light_at(value.light));
    vec3 from = clear_origin(domain, direction);
    vec3 to = offset_origin(value.position, error, value.normal, -direction);
    // Ends short of the light by what rounding costs along the whole way.
    return Ray(from, 1.0 - 1e-6, to - from);
}

// What resampling aims at: the contribution's luminance.
float target_function(Domain domain, Sample value) {
    float pdf_area;
    return luminance(direct_contribution(domain, value, pdf_area));
}
