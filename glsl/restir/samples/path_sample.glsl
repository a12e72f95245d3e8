#pragma once
// Samples of indirect light: the second vertex of a path, which is a point of a triangle, and the radiance that arrives
// there from one direction. Type, target, shadow rays, shift and packing.
//
// Another pixel takes over the path by connecting to the second vertex itself (the reconnection shift). Densities are
// per area at the second vertex and per solid angle of the direction beyond it; punctual lights, where a path may end, have
// the discrete measure instead. None depends on the viewer, so the Jacobian of this shift is 1: the viewer's own cosine /
// distance² is part of the integrand.
#include "restir/samples/light_sample.glsl"

// How a path continues from its second vertex.
const uint PATH_NONE = 0u;
// To a point of a light, which is named so that the sample can follow it through a moving scene.
const uint PATH_TO_LIGHT = 1u;
// Over other surfaces.
const uint PATH_ONWARD = 2u;
// Either of these, but the radiance leaving the second vertex is taken to be the same for all viewers: biased.
const uint PATH_OUTGOING = 3u;

struct PathSample {
    uint kind;
    // The second vertex: a triangle, and a point on it: barycentric weights or, with HAS_LARGE_TRIANGLES, coordinates in
    // the triangle's plane, which are finest around the first camera. In a corner this point is as close to the viewer as
    // rounding permits, so it is kept in full precision.
    uint instance;
    uint primitive;
    vec2 uv;
    // PATH_TO_LIGHT: where the path ends.
    LightPoint end;
    // Unit, from the second vertex onward, and the radiance that arrives from there; with PATH_OUTGOING the radiance
    // that leaves the vertex.
    vec3 direction;
    vec3 radiance;
    // Follows from these. It is kept so that the full format can store it instead of reading the triangle again.
    TrianglePoint point;
    float clearance;
    uint material_index;
    // With its textures and vertex colours; unused where materials do not vary.
    GpuMaterial material;
    Layers layers;
};

PathSample empty_path_sample() {
    TrianglePoint point = TrianglePoint(vec3(0.0), vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, 1.0), false);
    return PathSample(PATH_NONE, NONE, 0u, vec2(0.0), LightPoint(LIGHT_NONE, NONE, vec2(0.0)), vec3(0.0, 0.0, 1.0),
                      vec3(0.0), point, 0.0, 0u, GpuMaterial(vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0, NONE, NONE, 0u, NONE, 0.0, ALPHA_OPAQUE, 1.0), NO_LAYERS);
}

// Where the hit of a ray lies on its triangle. `position` is the point that the ray and the triangle give together.
vec2 uv_of(Hit hit, vec3 position) {
    if (!HAS_LARGE_TRIANGLES) return hit.barycentrics;
    vec3 tangent, bitangent;
    tangent_frame(triangle_point(load_instances(hit.instance), hit.primitive, vec2(0.0)).normal, tangent, bitangent);
    return vec2(dot(position, tangent), dot(position, bitangent));
}

// The second vertex in an epoch, and its barycentric weights if something is interpolated by them.
TrianglePoint vertex_point(PathSample value, uint epoch, out vec2 barycentrics) {
    GpuInstance instance = instance_at(value.instance, epoch);
    barycentrics = value.uv;
    vec3 position = vec3(0.0);
    if (HAS_LARGE_TRIANGLES) {
        TrianglePoint corner = triangle_point(instance, value.primitive, vec2(0.0));
        vec3 tangent, bitangent;
        tangent_frame(corner.normal, tangent, bitangent);
        position = dot(corner.position, corner.normal) * corner.normal + value.uv.x * tangent + value.uv.y * bitangent;
        barycentrics = vec2(0.0);
        if (HAS_SMOOTH_NORMALS || VARIES) barycentrics = barycentrics_of(instance, value.primitive, position - corner.position);
    }
    TrianglePoint point = triangle_point(instance, value.primitive, barycentrics);
    if (HAS_LARGE_TRIANGLES) point.position = position;
    return point;
}

// Computes the second vertex from its triangle.
void place_vertex(inout PathSample value, uint epoch) {
    GpuInstance instance = instance_at(value.instance, epoch);
    vec2 barycentrics;
    value.point = vertex_point(value, epoch, barycentrics);
    value.clearance = clearance_of(value.point.normal, value.point.error);
    value.material_index = triangle_owner(instance, value.primitive).material;
    if (VARIES) value.material = material_at(value.material_index, instance, value.primitive, barycentrics);
    // Not without layers, where the constant would take registers in every reservoir.
    if (HAS_LAYERS) value.layers = layers_at(value.material_index, instance, value.primitive, barycentrics, value.point);
    map_normal(value.point, value.material, instance, value.primitive, barycentrics);
}

// Points the direction from the second vertex to the point of the light where the path ends. Returns the solid angle per
// unit of that point's measure.
float aim_at_light(inout PathSample value, uint epoch) {
    LightSample light = light_sample_at(value.end, epoch);
    float solid_angle;
    value.radiance = arriving_radiance(light, value.point.position, vec3(0.0), value.direction, solid_angle);
    if (HAS_TRANSMISSION && !is_distant(light.point.kind)) {
        vec3 left = medium_left(medium_behind(value.layers), false, value.point.normal, value.direction);
        value.radiance *= passed_light(left, distance(light.position, value.point.position));
    }
    return solid_angle;
}

// shading point at the second vertex for a viewer along `direction`.
ShadingPoint vertex_shading_point(PathSample value, vec3 direction) {
    GpuMaterial material = value.material;
    if (!VARIES) material = material_at(value.material_index);
    Layers layers = NO_LAYERS;
    if (HAS_LAYERS) layers = value.layers;
    layers.inside = HAS_TRANSMISSION && dot(value.point.normal, direction) > 0.0;
    vec3 geometric_normal, shading_normal;
    face_viewer(value.point, material, layers, direction, geometric_normal, shading_normal);
    return make_shading_point(value.point.position, value.clearance, 0.0, geometric_normal, shading_normal, material,
                              layers, direction);
}

// ---- Target and shadow rays

// The radiance that leaves the second vertex towards a viewer along `direction`.
vec3 outgoing_radiance(PathSample value, vec3 direction) {
    ShadingPoint vertex = vertex_shading_point(value, direction);
    float pdf_solid_angle;
    if (value.kind != PATH_OUTGOING) return reflected_light(vertex, value.direction, value.radiance, pdf_solid_angle);
    // A vertex that is lit from its other side sends nothing to this viewer, unless light comes through it.
    bool is_lit = dot(value.direction, vertex.geometric_normal) > 0.0 || lets_light_through(vertex.bsdf);
    return is_lit ? value.radiance : vec3(0.0);
}

// The integrand, per area at the second vertex and per solid angle beyond it, without visibility.
vec3 contribution(ShadingPoint shading_point, PathSample value) {
    vec3 direction;
    float cosine, pdf_solid_angle;
    // From where the ray began that found the vertex: a point in a crease may lie in the plane of the other wall.
    vec3 start = ray_start(shading_point, value.point.position);
    float solid_angle = solid_angle_per_area(start, value.point.position, value.point.normal, direction, cosine);
    vec3 light = reflected_light(shading_point, direction, vec3(solid_angle), pdf_solid_angle);
    // Early out: usually the vertex is behind the surface.
    if (max_component(light) <= 0.0) return vec3(0.0);
    if (HAS_TRANSMISSION) {
        // The medium of the segment is known from its two ends.
        vec3 behind = medium_behind(value.layers);
        vec3 medium = medium_between(medium_left(shading_point, direction), behind, dot(value.point.normal, direction) > 0.0);
        light *= passed_light(medium, distance(start, value.point.position));
    }
    return light * outgoing_radiance(value, direction);
}

// The ray that decides whether the second vertex is visible.
Ray shadow_ray(ShadingPoint shading_point, PathSample value, uint epoch) {
    vec3 direction = value.point.position - shading_point.position;
    vec3 from = ray_origin(shading_point, direction);
    float side = dot(direction, value.point.normal) < 0.0 ? value.clearance : -value.clearance;
    vec3 way = value.point.position + side * value.point.normal - from;
    // In a crease the vertex may lie behind the other wall, so the ray ends before it.
    return Ray(from, 1.0 - clamp(value.clearance * inversesqrt(max(dot(way, way), TINY)), 1e-6, 0.5), way);
}

// The index of the light where a path ends directly behind its second vertex, or NONE.
uint light_of(PathSample value) { return value.end.kind == LIGHT_NONE ? NONE : light_index(value.end); }

// The solid angle per unit area at the second vertex, seen from a point.
float sample_solid_angle(vec3 from, PathSample value) {
    vec3 direction;
    float cosine;
    return solid_angle_per_area(from, value.point.position, value.point.normal, direction, cosine);
}

// ---- Shift between pixels: its limits. Beyond them the shift does not exist, in both directions.

// Whether the reconnection between two views is within the limits of Jacobian and distance; `in_a` and `in_b` are the
// path as it is in each view. The test is symmetric, so it does not matter which view made the path. The Jacobian by
// solid angle is the ratio of both views' solid angles per area.
bool is_within_limits(View a, PathSample in_a, View b, PathSample in_b, float jacobian_limit, float min_distance) {
    float solid_angle_a = sample_solid_angle(a.position, in_a), solid_angle_b = sample_solid_angle(b.position, in_b);
    if (jacobian_limit >= 1.0
        && max(solid_angle_a, solid_angle_b) > jacobian_limit * min(solid_angle_a, solid_angle_b)) return false;
    return distance(a.position, in_a.point.position) >= min_distance * distance(a.position, a.eye)
        && distance(b.position, in_b.point.position) >= min_distance * distance(b.position, b.eye);
}

// ---- Shift between frames: the sample keeps its triangle and its light. The Jacobian is the ratio of measures.

// The area of the second vertex' triangle.
float vertex_area(PathSample value, uint epoch) {
    GpuInstance instance = instance_at(value.instance, epoch);
    vec3 a, b, c;
    triangle_corners(instance.first_triangle + value.primitive, a, b, c);
    vec3 edge1 = transform_vector(instance.object_to_world, b - a);
    vec3 edge2 = transform_vector(instance.object_to_world, c - a);
    // Scaled to their own size, because squares of areas leave the range of f32.
    float size1 = max_component(abs(edge1)), size2 = max_component(abs(edge2));
    return size1 * size2 * length(cross(edge1 / max(size1, TINY), edge2 / max(size2, TINY)));
}

// Moves the sample from one epoch to another, and returns the ratio of its new measure to the old one: of the areas of
// the second vertex' triangle, and of the solid angles of the light seen from there. 0, and the sample is no longer
// valid, if it has no measure in either, or if the path continues over surfaces that may have changed without notice.
// The biased shift ignores such changes.
float move_sample(inout PathSample value, uint from, uint to) {
    if (value.kind == PATH_ONWARD) return 0.0;
    // The areas of triangle and light, and the light's solid angle per area: apart, because products of areas leave the
    // range of f32. In a loop, because drivers inline a function as often as it is called.
    vec3 old_measure, measure = vec3(1.0);
    for (uint turn = 0u; turn < 2u; turn += 1u) {
        uint epoch = turn == 0u ? from : to;
        old_measure = measure;
        place_vertex(value, epoch);
        measure.x = vertex_area(value, epoch);
        if (value.kind == PATH_TO_LIGHT) measure.yz = vec2(point_area(value.end, epoch), aim_at_light(value, epoch));
    }
    return ratio(measure.x, old_measure.x) * ratio(measure.y, old_measure.y) * ratio(measure.z, old_measure.z);
}

// The segments of a sample whose visibility can change when something moves: from the viewer to the sample, and from
// there to the light.
uint segment_count(PathSample value) { return value.kind == PATH_TO_LIGHT ? 2u : 1u; }

Ray segment_ray(ShadingPoint shading_point, PathSample value, uint segment, uint epoch) {
    Ray first = shadow_ray(shading_point, value, epoch);
    if (segment == 0u) return first;
    return shadow_ray(vertex_shading_point(value, normalize(first.direction)), light_sample_at(value.end, epoch), epoch);
}

// ---- Packing

// In the material word of a full reservoir: the triangle's corners have normals.
const uint INTERPOLATED = 0x80000000u;

void pack_sample(PathSample value, inout PackedReservoir p) {
    p.words[2] = (value.kind << PATH_KIND_SHIFT) | value.instance;
    p.words[3] = value.primitive;
    uvec2 uv = floatBitsToUint(value.uv);
    p.words[4] = uv.x;
    p.words[5] = uv.y;
    if (value.kind == PATH_TO_LIGHT) {
        pack_point(value.end, 6u, p);
    } else {
        p.words[6] = pack_octahedral(value.direction);
        // A colour that was packed before keeps its bits.
        pack_color(pack_color(value.radiance, vec3(0.5)), 7u, p);
    }
    if (RESERVOIR_FORMAT != FORMAT_FULL) return;
    uvec3 position = floatBitsToUint(value.point.position);
    p.words[8] = position.x;
    p.words[9] = position.y;
    p.words[10] = position.z;
    p.words[11] = floatBitsToUint(value.clearance);
    p.words[12] = pack_octahedral(value.point.normal);
    p.words[13] = pack_octahedral(value.point.shading_normal);
    p.words[14] = value.material_index | (value.point.interpolated ? INTERPOLATED : 0u);
}

void unpack_sample(PackedReservoir p, uint epoch, out PathSample value) {
    value = empty_path_sample();
    value.kind = p.words[2] >> PATH_KIND_SHIFT;
    value.instance = p.words[2] & INSTANCE_MASK;
    value.primitive = p.words[3];
    value.uv = uintBitsToFloat(uvec2(p.words[4], p.words[5]));
    if (RESERVOIR_FORMAT == FORMAT_FULL) {
        value.point.position = uintBitsToFloat(uvec3(p.words[8], p.words[9], p.words[10]));
        value.clearance = uintBitsToFloat(p.words[11]);
        value.point.normal = unpack_octahedral(p.words[12]);
        value.point.shading_normal = unpack_octahedral(p.words[13]);
        // Compiled away in scenes of flat triangles, with all that bends normals.
        value.point.interpolated = (HAS_SMOOTH_NORMALS || HAS_NORMAL_MAPS) && (p.words[14] & INTERPOLATED) != 0u;
        value.material_index = p.words[14] & ~INTERPOLATED;
        if (VARIES) {
            vec2 barycentrics;
            TrianglePoint point = vertex_point(value, epoch, barycentrics);
            GpuInstance instance = instance_at(value.instance, epoch);
            value.material = material_at(value.material_index, instance, value.primitive, barycentrics);
            if (HAS_LAYERS) value.layers = layers_at(value.material_index, instance, value.primitive, barycentrics, point);
        }
    } else {
        place_vertex(value, epoch);
    }
    if (value.kind == PATH_TO_LIGHT) {
        value.end = unpack_point(p, 6u);
        aim_at_light(value, epoch);
    } else {
        value.direction = unpack_octahedral(p.words[6]);
        value.radiance = unpack_color(unpack_color(p, 7u));
    }
}

// A new sample as it will be unpacked, except for its colour.
PathSample as_stored(PathSample value) {
    PackedReservoir packed = empty_packed();
    pack_sample(value, packed);
    PathSample found;
    unpack_sample(packed, CURRENT, found);
    if (value.kind != PATH_TO_LIGHT) found.radiance = value.radiance;
    return found;
}

// Rounds the colour to what is stored, by random numbers in [0, 1). Only after the sample's weight is computed from the
// exact colour: otherwise the weight would compensate in one channel for what the rounding took from another.
void round_color(inout PathSample value, vec3 numbers) { value.radiance = unpack_color(pack_color(value.radiance, numbers)); }
