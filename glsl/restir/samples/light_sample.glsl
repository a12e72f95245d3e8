#pragma once
// Samples of direct light: a point of a light. On an emissive triangle its measure is area, in the environment solid
// angle; that of a punctual light is discrete. Type, target, shadow ray, shift and packing.
#include "lights/light_point.glsl"
#include "restir/packed_reservoir.glsl"
#include "scene/shading_point.glsl"

struct LightSample {
    LightPoint point;
    // These follow from the point. They are kept so that the full format can store them instead of reading the light
    // again. Of distant lights the position is the unit direction to them.
    vec3 position;
    // Of a triangle's front; the axis of a spot.
    vec3 normal;
    // Radiance; of a punctual light intensity, or irradiance if it is distant.
    vec3 emission;
};

LightSample empty_light_sample() {
    return LightSample(LightPoint(LIGHT_NONE, NONE, vec2(0.0)), vec3(0.0), vec3(0.0), vec3(0.0));
}

// The sample at a point of a light, as reservoirs store it.
LightSample light_sample_at(LightPoint point, uint epoch) {
    if (is_environment(point.kind)) {
        vec2 uv = texel_corner(point.index) + point.uv;
        float sine;
        vec3 direction = environment_direction(uv, sine);
        return LightSample(point, direction, -direction, environment_radiance(uv));
    }
    if (is_punctual(point.kind)) {
        GpuPunctualLight light = punctual_light_at(point.index, epoch);
        vec3 position = light.kind == LIGHT_DIRECTIONAL ? -light.direction : light.position;
        return LightSample(point, position, light.direction, light.intensity);
    }
    GpuLight light = light_at(point.index, epoch);
    point.kind = is_double_sided(light) ? LIGHT_TWO_SIDED : LIGHT_TRIANGLE;
    return LightSample(point, light_position(light, point.uv), light.normal,
                       light_radiance(light, point.index, point.uv));
}

// The sample at a new point of a light, which is rounded to what reservoirs store: if it were rounded after its weight is
// known, it could cross the edge of a texel, where the target may be 0, and its light would be lost.
LightSample new_light_sample(LightPoint point) {
    point.uv = stored_uv(point.uv);
    return light_sample_at(point, CURRENT);
}

// ---- Target and shadow ray

// The radiance that arrives from a sample, its unit direction, and the solid angle per unit of the sample's measure. Of a
// punctual light the irradiance of a surface that faces it. `back_off` leads from the point to where its rays begin; 0 of points
// that are exact.
vec3 arriving_radiance(LightSample value, vec3 from, vec3 back_off, out vec3 direction, out float solid_angle) {
    solid_angle = 1.0;
    direction = value.position;
    if (is_distant(value.point.kind)) return value.emission;
    float cosine;
    solid_angle = solid_angle_per_area(from, back_off, value.position, value.normal, direction, cosine);
    if (is_punctual(value.point.kind)) {
        solid_angle = 1.0;
        GpuPunctualLight light = load_punctual_lights(value.point.index);
        // What may have been otherwise in the previous frame is in the sample.
        light.direction = value.normal;
        light.intensity = value.emission;
        return punctual_irradiance(light, direction, distance(value.position, from));
    }
    bool emits = cosine > 0.0 || (HAS_DOUBLE_SIDED_LIGHTS && value.point.kind == LIGHT_TWO_SIDED);
    return emits ? value.emission : vec3(0.0);
}

// The fraction of a sample's light that passes the medium which a surface has on its back; `direction` is that of the sample.
vec3 passed_to(ShadingPoint shading_point, LightSample value, vec3 direction) {
    if (is_distant(value.point.kind)) return vec3(1.0);
    return passed_light(medium_left(shading_point, direction), distance(shading_point.position, value.position));
}

// True if BSDF rays find the sample: not a point of a punctual light, nor of one that is blended, nor of a small one that is near.
bool found_by_rays(ShadingPoint shading_point, LightSample value) {
    if (is_punctual(value.point.kind)) return false;
    if (HAS_BLENDED_LIGHTS && is_triangle(value.point.kind) && is_blended(light_at(value.point.index, CURRENT))) return false;
    if (is_environment(value.point.kind) || !is_near(shading_point, value.position)) return true;
    return light_at(value.point.index, CURRENT).area >= square(near_distance(shading_point));
}

// The integrand in the sample's measure: f · cosine · arriving radiance · solid angle per unit of the measure, without
// visibility. `pdf_own_measure` is the density with which BSDF rays find the point.
vec3 contribution(ShadingPoint shading_point, LightSample value, out float pdf_own_measure) {
    pdf_own_measure = 0.0;
    vec3 direction;
    float solid_angle;
    vec3 radiance = arriving_radiance(value, shading_point.position, shading_point.back_off, direction, solid_angle);
    // Early out: from the back of a light.
    if (max_component(radiance) <= 0.0) return vec3(0.0);
    vec3 light = reflected_light(shading_point, direction, radiance, pdf_own_measure) * solid_angle;
    if (HAS_TRANSMISSION) light *= passed_to(shading_point, value, direction);
    pdf_own_measure = found_by_rays(shading_point, value) ? pdf_own_measure * solid_angle : 0.0;
    return light;
}

vec3 contribution(ShadingPoint shading_point, LightSample value) {
    float pdf_own_measure;
    return contribution(shading_point, value, pdf_own_measure);
}

// The ray that decides whether a sample is visible.
Ray shadow_ray(ShadingPoint shading_point, LightSample value, uint epoch) {
    if (is_distant(value.point.kind)) return Ray(ray_origin(shading_point, value.position), LARGEST, value.position);
    vec3 direction = value.position - shading_point.position;
    vec3 from = ray_origin(shading_point, direction, abs(dot(direction, shading_point.geometric_normal)));
    vec3 to = value.position;
    if (is_triangle(value.point.kind)) {
        vec3 error = light_position_error(light_at(value.point.index, epoch));
        to = offset_origin(to, error, value.normal, -direction, abs(dot(direction, value.normal)));
    }
    // Ends short of the light by the rounding error along the whole ray.
    return Ray(from, 1.0 - 1e-6, to - from);
}

// The index of a sample's light among all, or NONE.
uint light_of(LightSample value) { return value.point.kind == LIGHT_NONE ? NONE : light_index(value.point); }

// The solid angle per unit of a sample's measure, seen from a point.
float sample_solid_angle(vec3 from, LightSample value) {
    vec3 direction;
    float solid_angle;
    arriving_radiance(value, from, vec3(0.0), direction, solid_angle);
    return solid_angle;
}

// ---- Shift between frames: the sample keeps its light and its uv on it. The Jacobian is the ratio of areas; other
// measures stay as they are.

// The area of the triangle that a point lies on; 1 if it lies on none.
float point_area(LightPoint point, uint epoch) { return is_triangle(point.kind) ? light_at(point.index, epoch).area : 1.0; }

// Moves the sample from one epoch to another, and returns the ratio of its new measure to the old one; 0 if it has none in
// either.
float move_sample(inout LightSample value, uint from, uint to) {
    float old_area = point_area(value.point, from);
    value = light_sample_at(value.point, to);
    return ratio(point_area(value.point, to), old_area);
}

// The segments of a sample whose visibility can change when something moves.
uint segment_count(LightSample value) { return 1u; }

Ray segment_ray(ShadingPoint shading_point, LightSample value, uint segment, uint epoch) { return shadow_ray(shading_point, value, epoch); }

// ---- Shift between pixels: always possible, with a Jacobian of 1 in the sample's measure.

bool is_within_limits(View a, LightSample in_a, View b, LightSample in_b, float jacobian_limit, float min_distance) {
    return true;
}

// ---- Packing

void pack_point(LightPoint point, uint word, inout PackedReservoir p) {
    p.words[word] = (point.kind << LIGHT_KIND_SHIFT) | point.index;
    pack_uv(point.uv, word + 1u, p);
}

LightPoint unpack_point(PackedReservoir p, uint word) {
    return LightPoint(p.words[word] >> LIGHT_KIND_SHIFT, p.words[word] & LIGHT_MASK, unpack_uv(p, word + 1u));
}

void pack_sample(LightSample value, inout PackedReservoir p) {
    pack_point(value.point, 2u, p);
    if (RESERVOIR_FORMAT != FORMAT_FULL) return;
    uvec3 position = floatBitsToUint(value.position), emission = floatBitsToUint(value.emission);
    p.words[4] = position.x;
    p.words[5] = position.y;
    p.words[6] = position.z;
    p.words[7] = pack_octahedral(value.normal);
    p.words[8] = emission.x;
    p.words[9] = emission.y;
    p.words[10] = emission.z;
}

void unpack_sample(PackedReservoir p, uint epoch, out LightSample value) {
    LightPoint point = unpack_point(p, 2u);
    if (RESERVOIR_FORMAT != FORMAT_FULL) {
        value = light_sample_at(point, epoch);
        return;
    }
    value = LightSample(point, uintBitsToFloat(uvec3(p.words[4], p.words[5], p.words[6])),
                        unpack_octahedral(p.words[7]), uintBitsToFloat(uvec3(p.words[8], p.words[9], p.words[10])));
    // Rounding turns a spot's axis by 3e-5 radians, which is more than the width of a narrow cone. The axis alone is read again:
    // to read all of the light takes more instructions.
    if (is_punctual(point.kind)) value.normal = punctual_light_at(point.index, epoch).direction;
}

// A new sample as it will be unpacked.
LightSample as_stored(LightSample value) {
    PackedReservoir packed = empty_packed();
    pack_sample(value, packed);
    LightSample found;
    unpack_sample(packed, CURRENT, found);
    return found;
}
