#pragma once
// The Lambert lobe at the bottom: the base of dielectrics.

struct DiffuseLobe {
    float choice;
    // Reflectance, before what the lobes above leave.
    vec3 color;
};

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out DiffuseLobe lobe) {
    lobe.color = material.base_color * (1.0 - material.metallic);
    if (HAS_TRANSMISSION) lobe.color *= 1.0 - layers.transmission;
}

bool transmits(DiffuseLobe lobe) { return false; }

bool reflects(DiffuseLobe lobe) { return max_component(lobe.color) > 0.0; }

float passes(DiffuseLobe lobe, float cosine) { return 1.0; }

float expected(DiffuseLobe lobe, float below, float cosine) { return luminance(lobe.color) * below; }

bool is_wide(DiffuseLobe lobe) { return true; }

vec3 evaluate(DiffuseLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    pdf_solid_angle += probability * incoming.z / PI;
    return lobe.color * (below / PI);
}

vec3 draw(DiffuseLobe lobe, vec3 outgoing, vec2 u) {
    float r = sqrt(u.x);
    return vec3(r * on_circle(u.y), sqrt(max(1.0 - u.x, 0.0)));
}

vec3 albedo(DiffuseLobe lobe, float below, float cosine) { return lobe.color * below; }

float alpha_of(DiffuseLobe lobe) { return 1.0; }

bool is_matte(DiffuseLobe lobe) { return true; }

vec3 reflect_delta(DiffuseLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = vec3(0.0);
    return vec3(0.0);
}

void summarise(DiffuseLobe lobe, float below, float cosine, inout BsdfSummary summary) {
    summary.diffuse += luminance(lobe.color) * (below / PI);
}
