// Two lobes that no material of Headwater has, for tests that the BSDF room is open to a new one.

// A wide lobe at the top, which sends most light along the normal.
struct DustLobe {
    float choice;
};

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out DustLobe lobe) { lobe.choice = 0.0; }

bool transmits(DustLobe lobe) { return false; }

bool reflects(DustLobe lobe) { return true; }

float passes(DustLobe lobe, float cosine) { return 0.8; }

vec3 albedo(DustLobe lobe, float below, float cosine) { return vec3(0.2, 0.1, 0.05) * below * cosine; }

float expected(DustLobe lobe, float below, float cosine) { return luminance(albedo(lobe, below, cosine)); }

bool is_wide(DustLobe lobe) { return true; }

// f = albedo · 3 cosine / (2π), since the integral of the squared cosine is 2π / 3.
vec3 evaluate(DustLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    pdf_solid_angle += probability * 1.5 / PI * square(incoming.z);
    return albedo(lobe, below, outgoing.z) * (1.5 / PI * incoming.z);
}

vec3 draw(DustLobe lobe, vec3 outgoing, vec2 u) {
    float z = pow(u.x, 1.0 / 3.0);
    return vec3(sqrt(max(1.0 - z * z, 0.0)) * on_circle(u.y), z);
}

float alpha_of(DustLobe lobe) { return 1.0; }

bool is_matte(DustLobe lobe) { return true; }

vec3 reflect_delta(DustLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = vec3(0.0);
    return vec3(0.0);
}

void summarise(DustLobe lobe, float below, float cosine, inout BsdfSummary summary) {
    summary.diffuse += luminance(albedo(lobe, below, cosine)) / PI;
}

// A delta lobe of perfectly smooth materials, which sends light back to where it comes from, turned by a right angle around the
// normal.
struct TurnLobe {
    float choice;
    float strength;
};

void make_lobe(GpuMaterial material, Layers layers, vec3 outgoing, out TurnLobe lobe) {
    lobe.choice = 0.0;
    lobe.strength = material.roughness < MIRROR_ROUGHNESS ? 0.05 : 0.0;
}

bool transmits(TurnLobe lobe) { return false; }

bool reflects(TurnLobe lobe) { return lobe.strength > 0.0; }

float passes(TurnLobe lobe, float cosine) { return 1.0 - lobe.strength; }

vec3 albedo(TurnLobe lobe, float below, float cosine) { return vec3(0.5, 1.0, 1.0) * (lobe.strength * below); }

float expected(TurnLobe lobe, float below, float cosine) { return luminance(albedo(lobe, below, cosine)); }

bool is_wide(TurnLobe lobe) { return false; }

vec3 evaluate(TurnLobe lobe, float below, float probability, vec3 outgoing, vec3 incoming, vec3 h, inout float pdf_solid_angle) {
    return vec3(0.0);
}

vec3 draw(TurnLobe lobe, vec3 outgoing, vec2 u) { return vec3(0.0); }

float alpha_of(TurnLobe lobe) { return 0.0; }

bool is_matte(TurnLobe lobe) { return false; }

vec3 reflect_delta(TurnLobe lobe, float below, vec3 outgoing, out vec3 direction) {
    direction = vec3(outgoing.y, -outgoing.x, outgoing.z);
    return albedo(lobe, below, outgoing.z);
}

void summarise(TurnLobe lobe, float below, float cosine, inout BsdfSummary summary) {}
