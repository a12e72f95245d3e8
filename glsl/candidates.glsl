// Rays and points that initial candidates of direct and of indirect light begin with.

// With pilots the first BSDF candidate has a pass of its own, and others may follow it.
layout(constant_id = 10) const bool PILOTS = false;
// From one pixel's pilot to the next, in words.
layout(constant_id = 16) const uint PILOT_STRIDE = PILOT_WORDS;

// What a pixel's first BSDF ray met.
struct Pilot {
    // NONE: nothing.
    uint instance;
    uint primitive;
    vec2 barycentrics;
    // If that is a light, the luminance that it would add to the pixel as the only candidate, in units of the
    // lamps' own.
    float brightness;
};

// Where indirect light has reservoirs, pilots lie in those that it is about to write: each pixel's in its own.
uint pilot_word(uint slot, uint word) { return RESERVOIR_SOA ? word * restir.at.slots + slot : slot * PILOT_STRIDE + word; }

// GLSL passes no buffers, so this is a macro.
#define LOAD_PILOT(BUFFER, SLOT) \
    Pilot(BUFFER.at[pilot_word(SLOT, 0u)], BUFFER.at[pilot_word(SLOT, 1u)], \
          uintBitsToFloat(uvec2(BUFFER.at[pilot_word(SLOT, 2u)], BUFFER.at[pilot_word(SLOT, 3u)])), \
          uintBitsToFloat(BUFFER.at[pilot_word(SLOT, 4u)]))

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
    // A mirror is followed by itself.
    if (bsdf.alpha == 0.0) bsdf.specular_probability = 0.0;
    else if (own < 1.0) bsdf.specular_probability = mix(own, max(own, 0.75), narrowness(bsdf));
}

// The candidate's weight in the stream: target over the density that all techniques together have.
float candidate_weight(Domain domain, LightSample value, uint bsdf_samples, out float target) {
    float bsdf_pdf_area;
    target = luminance(contribution(domain, value, bsdf_pdf_area));
    float light_pdf_area = light_sample_pdf_area(restir.at.lights, restir.at.uniform_candidates != 0u, value.light);
    return target / (float(restir.at.light_samples) * light_pdf_area + float(bsdf_samples) * bsdf_pdf_area);
}

bool is_mirror(Bsdf bsdf) { return bsdf.alpha == 0.0 && bsdf.specular_probability > 0.0; }

// The ray of a direction by the BSDF, unless it would bring nothing or leaves the surface to its back.
bool sample_bsdf_ray(Domain domain, vec4 numbers, out BsdfSample chosen, out Ray ray) {
    chosen = sample_bsdf(domain.bsdf, domain.outgoing, numbers);
    vec3 direction = to_world(domain, chosen.direction);
    ray = Ray(clear_origin(domain, direction), LARGEST, direction);
    return chosen.valid && max_component(chosen.weight) > 0.0 && dot(direction, domain.geometric_normal) > 0.0;
}

// The ray of what a mirror shows, unless it leaves the surface to its back.
bool mirror_ray(Domain domain, out Ray ray) {
    vec3 direction = to_world(domain, vec3(-domain.outgoing.xy, domain.outgoing.z));
    ray = Ray(clear_origin(domain, direction), LARGEST, direction);
    return dot(direction, domain.geometric_normal) > 0.0;
}

// A pixel's first BSDF ray: that of its pilot, and the first of its path of indirect light.
bool pilot_ray(Domain domain, uvec2 pixel, out BsdfSample chosen, out Ray ray) {
    Random random = pass_random(pixel, PASS_PILOTS);
    return sample_bsdf_ray(domain, to_unit(random_bits(random)), chosen, ray);
}

// What a pilot's ray met; the distance is not kept.
Hit pilot_hit(Pilot pilot) { return Hit(0.0, pilot.instance, pilot.primitive, pilot.barycentrics); }

// The light that a ray met, or NONE.
uint light_of(Hit hit) {
    return hit.instance == NONE ? NONE : owner_of(instances.at[hit.instance], hit.primitive).light;
}
