#pragma once
// Points of lights of every kind: how they are named, selected and drawn, and with which density.
#include "lights/kinds/environment.glsl"
#include "lights/kinds/punctual.glsl"
#include "lights/kinds/triangle.glsl"

// A point of a light, as reservoirs name it.
struct LightPoint {
    // LIGHT_…
    uint kind;
    // The index of the light among those of its kind; of the environment that of a texel.
    uint index;
    // On a triangle the weights of its second and third corner, within a texel the part of its width and height.
    vec2 uv;
};

bool is_environment(uint kind) { return HAS_ENVIRONMENT && kind == LIGHT_ENVIRONMENT; }

bool is_punctual(uint kind) { return HAS_PUNCTUAL_LIGHTS && kind >= LIGHT_POINT; }

bool is_triangle(uint kind) { return !is_environment(kind) && !is_punctual(kind); }

// Whether a light is infinitely far away.
bool is_distant(uint kind) { return is_environment(kind) || (HAS_PUNCTUAL_LIGHTS && kind == LIGHT_DIRECTIONAL); }

// The index of a point's light among all: triangles first, then punctual lights, then the environment.
uint light_index(LightPoint point) {
    if (is_environment(point.kind)) return scene.at.light_count - 1u;
    return is_punctual(point.kind) ? scene.at.triangle_light_count + point.index : point.index;
}

// Where the alias table begins that light samples are drawn from: of all lights, or of those that are not rare. A third one is
// that of rare lights.
uint choices_of_samples() { return RARE_LIGHTS ? scene.at.light_count : 0u; }
uint choices_of_rare() { return 2u * scene.at.light_count; }

// Selects a light by an alias table: two random words, no search (Walker; Vose).
uint pick_light(uint table, uint count, uvec2 bits) {
    uint fraction;
    uint slot = scale_to(bits, count, fraction);
    GpuLightChoice choice = load_light_choices(table + slot);
    return fraction < choice.keep_below ? slot : choice.alias;
}

// The probability with which light samples select the light of a point.
float light_probability(LightPoint point) { return load_light_choices(choices_of_samples() + light_index(point)).probability; }

// The probability with which a candidate among rare lights selects the light of a point: 0 if it is not rare.
float rare_probability(LightPoint point) {
    return RARE_LIGHTS ? load_light_choices(choices_of_rare() + light_index(point)).probability : 0.0;
}

// Draws a point of a light, given by its index among all.
LightPoint draw_point(uint light, uvec4 bits) {
    if (HAS_ENVIRONMENT || HAS_PUNCTUAL_LIGHTS) {
        if (light >= scene.at.triangle_light_count + scene.at.punctual_light_count) {
            // The words that are left are too few for a texel and a uv in it.
            uvec4 more = pcg4d(bits);
            return LightPoint(LIGHT_ENVIRONMENT, draw_environment_texel(more.xy), to_unit(more).zw);
        }
        if (light >= scene.at.triangle_light_count) {
            uint index = light - scene.at.triangle_light_count;
            return LightPoint(load_punctual_lights(index).kind, index, vec2(0.0));
        }
    }
    return LightPoint(LIGHT_TRIANGLE, light, uniform_barycentrics(bits.zw));
}

// The density of a point of a light that is selected with some probability, in the measure of its kind: area on
// triangles, solid angle in the environment, where `direction` is the one towards it; punctual lights have no other.
float pdf_own_measure(LightPoint point, vec3 direction, float probability) {
    if (is_environment(point.kind)) {
        return probability * environment_pdf_solid_angle(point.index, max(length(direction.xz), TINY));
    }
    if (is_punctual(point.kind)) return probability;
    return probability / light_at(point.index, CURRENT).area;
}

// The point of the environment that is seen in a direction.
LightPoint environment_point(vec3 direction) {
    vec2 uv = environment_uv(direction);
    uint texel = environment_texel_at(uv);
    return LightPoint(LIGHT_ENVIRONMENT, texel, uv - texel_corner(texel));
}
