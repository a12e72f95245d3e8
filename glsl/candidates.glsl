// Initial candidates of direct light, and how many BSDF rays a pixel spends on them.

// With pilots the first BSDF candidate has a pass of its own, and others may follow it.
layout(constant_id = 10) const bool PILOTS = false;

// Pixels to each side whose pilots are looked at.
const int PILOT_REACH = 2;
// More candidates for each unit of a pilot's brightness.
const float MORE_FOR_BRIGHTNESS = 256.0;
// A narrow lobe's share of what is spent on bright light.
const float MORE_FOR_LOBE = 0.25;

// 1 for lobes so narrow that points on lights hardly ever fall into them, 0 for wide ones and none.
float narrowness(Bsdf bsdf) {
    return bsdf.alpha > 0.0 && bsdf.specular_probability > 0.0 ? max(1.0 - 4.0 * bsdf.alpha, 0.0) : 0.0;
}

// The domain as candidates are drawn in it: a narrow lobe gets most of the BSDF rays, since points on
// lights find the light of a wide one. Only the choice of a lobe changes, and all densities with it.
void prefer_narrow_lobe(inout Bsdf bsdf) {
    float own = bsdf.specular_probability;
    if (own < 1.0) bsdf.specular_probability = mix(own, max(own, 0.75), narrowness(bsdf));
}

// The candidate's weight in the stream: target over the density that all techniques together have.
float candidate_weight(Domain domain, Sample value, uint bsdf_samples, out float target) {
    float bsdf_pdf_area;
    target = luminance(direct_contribution(domain, value, bsdf_pdf_area));
    float light_pdf_area = light_sample_pdf_area(restir.at.lights, restir.at.uniform_candidates != 0u, value.light);
    return target / (float(restir.at.light_samples) * light_pdf_area + float(bsdf_samples) * bsdf_pdf_area);
}

// A direction by the BSDF, unless it is a mirror's or leaves the surface to its back.
bool sample_bsdf_ray(Domain domain, vec4 numbers, out Ray ray) {
    BsdfSample chosen = sample_bsdf(domain.bsdf, domain.outgoing, numbers);
    vec3 direction = to_world(domain, chosen.direction);
    ray = Ray(clear_origin(domain, direction), LARGEST, direction);
    return chosen.valid && !chosen.mirror && dot(direction, domain.geometric_normal) > 0.0;
}

// The light that a ray met, or NONE.
uint light_of(Hit hit) {
    return hit.instance == NONE ? NONE : owner_of(instances.at[hit.instance], hit.primitive).light;
}
