#version 460
// MIS path tracing: samples are added to each pixel's sums.
//
// This is the reference that resampling is measured against. So it does not use the shading points, candidates and shadow rays
// of resampling, but repeats them in its own way: an error in one of them cannot be in both.
//
// One loop traces one ray a turn and begins the pixel's next sample when a path ends, so that no lane idles while its
// neighbours' paths are longer.
#include "bsdf/bsdf.glsl"
#include "core/roulette.glsl"
#include "core/values.glsl"
#include "core/workgroups.glsl"
#include "lights/light_point.glsl"
#include "scene/camera.glsl"
#include "scene/camera_trace.glsl"
#include "scene/medium.glsl"
#include "scene/surface.glsl"

layout(local_size_x = TILE * TILE) in;

layout(push_constant, scalar) uniform StripBlock { Strip strip; };
layout(scalar) uniform FrameBlock { FrameConstants at; } frame;
layout(scalar) buffer SumsBlock { PixelSums at[]; } sums;
// The number of each pixel's samples whose camera ray met a surface.
layout(scalar) buffer CoverageBlock { uint at[]; } coverage;

float heuristic_weight(float pdf, float other) {
    // Of the ratio, because squares of densities overflow.
    if (pdf <= 0.0) return 0.0;
    float ratio = other / pdf;
    if (frame.at.heuristic == HEURISTIC_POWER) ratio *= ratio;
    return 1.0 / (1.0 + ratio);
}

// Light that arrives from a point of a light.
struct Arrival {
    // Unit, towards the light.
    vec3 direction;
    // The distance of a point of an area light from where BSDF rays begin, or its size if that is larger; LARGEST of others.
    float nearness;
    // Radiance; of a punctual light irradiance.
    vec3 light;
    // With which the point was drawn; of a punctual light its probability.
    float pdf_solid_angle;
    // To a point that is not distant; without meaning for others.
    float distance;
    // From the surface to the point, off both by their rounding errors.
    Ray shadow_ray;
};

// `viewed` is the direction of the ray that hit the surface, `probability` that of the draw of the point's light.
Arrival arrival_at(Surface surface, vec3 viewed, LightPoint point, float probability) {
    Arrival arrival;
    arrival.nearness = LARGEST;
    arrival.distance = 0.0;
    if (is_environment(point.kind)) {
        vec2 uv = texel_corner(point.index) + point.uv;
        float sine;
        arrival.direction = environment_direction(uv, sine);
        arrival.light = environment_radiance(uv);
        arrival.pdf_solid_angle = probability * environment_pdf_solid_angle(point.index, sine);
    } else if (is_punctual(point.kind)) {
        GpuPunctualLight light = punctual_light_at(point.index, CURRENT);
        vec3 toward = light.position - surface.position;
        arrival.distance = length(toward);
        arrival.direction = light.kind == LIGHT_DIRECTIONAL ? -light.direction : normalize(toward);
        arrival.light = punctual_irradiance(light, arrival.direction, length(toward));
        arrival.pdf_solid_angle = probability;
        vec3 from = ray_origin(surface, viewed, arrival.direction, abs(dot(toward, surface.geometric_normal)));
        arrival.shadow_ray = Ray(from, 1.0 - 1e-6, light.position - from);
    } else {
        GpuLight light = light_at(point.index, CURRENT);
        vec3 position = light_position(light, point.uv), toward = position - surface.position;
        float distance_squared = dot(toward, toward);
        arrival.distance = sqrt(distance_squared);
        vec3 side = HAS_TRANSMISSION ? toward : surface.geometric_normal;
        float from_rays = length(position - ray_origin(surface, viewed, side));
        arrival.nearness = max(from_rays, sqrt(light.area));
        arrival.direction = toward * inversesqrt(max(distance_squared, TINY));
        float cosine = -dot(light.normal, arrival.direction);
        arrival.light = light_emission(light, point.index, point.uv, cosine);
        arrival.pdf_solid_angle = area_to_solid_angle(probability / light.area, distance_squared, cosine);
        vec3 from = ray_origin(surface, viewed, arrival.direction, abs(dot(toward, surface.geometric_normal)));
        float height = abs(dot(toward, light.normal));
        vec3 to = offset_origin(position, light_position_error(light), light.normal, -arrival.direction, height);
        // Ends short of the light by the rounding error along the whole ray.
        arrival.shadow_ray = Ray(from, 1.0 - 1e-6, to - from);
    }
    if (is_distant(point.kind)) {
        vec3 from = ray_origin(surface, viewed, arrival.direction);
        arrival.shadow_ray = Ray(from, LARGEST, arrival.direction);
    }
    return arrival;
}

// A narrow lobe is one below this width, a roughness of 0.1.
const float NARROW_ALPHA = 0.01;

// Beside an emitter's mirror image a smooth surface shows the tail of its lobe, whose light comes from the part of the emitter that is
// nearest to the image. One point of the emitter seldom lies there, and a ray that is drawn from the lobe seldom reaches the emitter at
// all, but then counts nearly all of its radiance: single pixels would be up to a hundred times too bright. So narrow lobes compare
// several points of the emitter that is drawn, and one of them gets the shadow ray. They are points of one emitter: points of several
// would leave the ray to the brightest, which may be hidden. Where emitters are many, what is seldom drawn is the emitter, and one point
// will do. Two other ways were tried: to draw a tenth of the rays from a wider lobe, and to draw half of the points around the mirror
// direction. Both made the image itself noisier, by a factor of up to four, and what is beside it hardly less noisy. Wider lobes have few
// such outliers, and their images would become noisier by this.
float points_of_emitter(bool narrow, float probability) { return narrow ? clamp(round(32.0 * probability), 1.0, 16.0) : 1.0; }

// The number of independent samples that they are worth in MIS weights: all of them depend on the draw of the emitter.
float samples_of_emitter(bool narrow, float probability) { return mix(1.0, points_of_emitter(narrow, probability), probability); }

// A path under construction.
struct Path {
    vec3 throughput;
    uint scatterings;
    // The density of the current ray, for the MIS weight of a light that it hits.
    float pdf_solid_angle;
    // The distance within which the ray finds no lights that are no larger: `near_distance`.
    float near;
    // True if the surface where the ray begins compares points of emitters.
    bool narrow;
    bool delta;
    // The medium of the current ray, as its start knows it, and how far the camera's ray came over surfaces that it went through.
    vec3 medium;
    float passed;
};

// Whether light that was scattered this often is wanted.
bool is_wanted(uint scatterings) { return scatterings != 1u || frame.at.without_direct_light == 0u; }

void main() {
    uvec2 pixel = tile_pixel(frame.at.view.width, strip.first_row, frame.at.view.interleave);
    if (pixel.x >= frame.at.view.width || pixel.y >= strip.first_row + strip.rows) return;
    uint index = (pixel.y - strip.first_row) * frame.at.view.width + pixel.x;
    PixelSums total = sums.at[index];

    uint sample_index = frame.at.first_sample;
    uint end = sample_index + frame.at.samples;
    Random random;
    vec3 radiance = vec3(0.0);
    Path path;
    uint purpose = RAY_NONE;
    Ray ray;
    // While a shadow ray is traced: the path's next ray and its purpose, and the light to be decided on.
    Ray next;
    uint next_purpose = RAY_NONE;
    vec3 shadowed = vec3(0.0);
    bool started = false;
    // The number of surfaces that the camera's ray has gone through.
    uint culled = 0u;
    uint covered = 0u;
    while (true) {
        if (purpose == RAY_NONE) {
            if (started) {
                radiance = accept_radiance(radiance);
                pair_add(total.sum, total.sum_low, radiance);
                pair_add(total.square, total.square_low, radiance * radiance);
                sample_index += 1u;
            }
            if (sample_index >= end) break;
            started = true;
            random = random_start(pixel.y * frame.at.view.width + pixel.x, sample_index, frame.at.view.seed);
            vec2 offset = vec2(0.5), lens = vec2(0.0);
            if (frame.at.jitter != 0u || CAMERA_MODEL == CAMERA_MODEL_THIN_LENS) {
                vec4 numbers = to_unit(random_bits(random));
                if (frame.at.jitter != 0u) offset = numbers.xy;
                lens = on_disc(numbers.zw);
            }
            ray = camera_ray(frame.at.view.camera, vec2(pixel) + offset, vec2(frame.at.view.width, frame.at.view.height), lens);
            radiance = vec3(0.0);
            path = Path(vec3(1.0), 0u, 0.0, 0.0, false, true, NO_MEDIUM, 0.0);
            purpose = RAY_PATH;
            culled = 0u;
        }
        Hit hit = trace(ray, purpose == RAY_SHADOW, purpose == RAY_SHADOW ? NO_ALPHA_RANDOM : draw_alpha_random(random));
        if (purpose == RAY_SHADOW) {
            if (hit.transmittance > 0.0) radiance += hit.transmittance * shadowed;
            ray = next;
            purpose = next_purpose;
            continue;
        }
        if (hit.instance == NONE) {
            if (sees_environment() && is_wanted(path.scatterings) && !(TRACKS_COVERAGE && path.scatterings == 0u)) {
                vec2 uv = environment_uv(ray.direction);
                float weight = 1.0;
                if (!path.delta) {
                    LightPoint point = environment_point(ray.direction);
                    float pdf_light = pdf_own_measure(point, ray.direction, light_probability(point));
                    weight = heuristic_weight(path.pdf_solid_angle, pdf_light);
                }
                radiance += path.throughput * environment_radiance(uv) * weight;
            }
            purpose = RAY_NONE;
            continue;
        }
        if (HAS_CULLED && path.scatterings == 0u && culled < MOST_CULLED) {
            TrianglePoint point;
            if (is_culled(hit, ray.direction, point)) {
                ray.origin = origin_behind(point);
                path.passed += hit.t;
                culled += 1u;
                continue;
            }
        }
        Surface surface = surface_at(hit, ray);
        if (path.scatterings == 0u) radiance += unlit_radiance(hit);
        if (TRACKS_COVERAGE && path.scatterings == 0u) covered += 1u;
        if (HAS_TRANSMISSION) path.throughput *= passed_light(path.medium, hit.t);
        if (surface.light != NONE && is_wanted(path.scatterings)) {
            GpuLight light = light_at(surface.light, CURRENT);
            float cosine = -dot(light.normal, ray.direction);
            vec3 emission = hit_emission(light, surface.light, hit.barycentrics, cosine);
            float weight = 1.0;
            if (!path.delta) {
                float distance_squared = square(hit.t);
                float probability = load_light_choices(surface.light).probability;
                float pdf_light = area_to_solid_angle(probability / light.area, distance_squared, cosine);
                weight = heuristic_weight(path.pdf_solid_angle, samples_of_emitter(path.narrow, probability) * pdf_light);
            }
            if (max(hit.t, sqrt(light.area)) >= path.near) radiance += path.throughput * emission * weight;
        }
        if (path.scatterings >= frame.at.view.bounces) {
            purpose = RAY_NONE;
            continue;
        }
        // Emitted light knows no medium that only the surface knows.
        if (HAS_TRANSMISSION && !is_medium(path.medium) && surface.layers.inside) {
            path.throughput *= passed_light(medium_behind(surface.layers), path.passed + hit.t);
        }
        float near = near_distance(surface.clearance, surface.back_off);
        vec3 tangent, bitangent;
        shading_frame(surface.shading_normal, surface.layers, tangent, bitangent);
        vec3 outgoing = -vec3(dot(ray.direction, tangent), dot(ray.direction, bitangent),
                              dot(ray.direction, surface.shading_normal));
        Bsdf bsdf = make_bsdf(surface.material, in_frame(surface.layers, tangent, bitangent, surface.shading_normal), outgoing);

        bool narrow = HAS_SPECULAR && narrow_probability(bsdf, NARROW_ALPHA) > 0.5;

        // Drawn whether they are needed or not, so that what a scene lacks does not shift the others.
        uvec4 light_bits = random_bits(random);
        vec4 bsdf_numbers = to_unit(random_bits(random));

        Ray shadow_ray;
        bool shadow = false;
        if (scene.at.light_count > 0u && is_wanted(path.scatterings + 1u)) {
            uint light = pick_light(0u, scene.at.light_count, light_bits.xy);
            float probability = load_light_choices(light).probability;
            bool several = narrow && light < scene.at.triangle_light_count;
            float points = points_of_emitter(several, probability), worth = samples_of_emitter(several, probability);
            // One of the points, in proportion to the light that each of them would add.
            float sum = 0.0, selected = 0.0;
            for (float i = 0.0; i < points; i += 1.0) {
                LightPoint point = draw_point(light, light_bits);
                Arrival arrival = arrival_at(surface, ray.direction, point, probability);
                vec3 incoming = vec3(dot(arrival.direction, tangent), dot(arrival.direction, bitangent),
                                     dot(arrival.direction, surface.shading_normal));
                if (max_component(arrival.light) > 0.0
                    && is_seen(dot(arrival.direction, surface.geometric_normal), incoming.z)) {
                    float pdf_bsdf;
                    vec3 f = evaluate_bsdf(bsdf, outgoing, incoming, pdf_bsdf);
                    if (is_punctual(point.kind) || arrival.nearness < near) pdf_bsdf = 0.0;
                    float pdf_light = arrival.pdf_solid_angle;
                    float weight = heuristic_weight(worth * pdf_light, pdf_bsdf) / (points * pdf_light);
                    vec3 added = path.throughput * f * arrival.light * (spread_cosine(incoming.z) * weight);
                    if (HAS_TRANSMISSION && !is_distant(point.kind)) {
                        vec3 medium = medium_left(medium_behind(surface.layers), surface.layers.inside, surface.geometric_normal, arrival.direction);
                        added *= passed_light(medium, arrival.distance);
                    }
                    float size = max_component(added);
                    sum += size;
                    if (size > 0.0 && (size == sum || random_choice(light_bits.xy) * sum <= size)) {
                        selected = size;
                        shadowed = added;
                        shadow_ray = arrival.shadow_ray;
                    }
                }
                if (points > 1.0) light_bits = pcg4d(light_bits);
            }
            shadow = selected > 0.0;
            if (points > 1.0 && shadow) shadowed *= sum / selected;
        }

        BsdfSample chosen = sample_bsdf(bsdf, outgoing, bsdf_numbers);
        vec3 direction = tangent * chosen.direction.x + bitangent * chosen.direction.y
            + surface.shading_normal * chosen.direction.z;
        bool alive = chosen.valid && is_seen(dot(direction, surface.geometric_normal), chosen.direction.z);
        path.throughput *= chosen.weight;
        path.scatterings += 1u;
        path.pdf_solid_angle = chosen.pdf_solid_angle;
        path.near = chosen.delta ? 0.0 : near;
        path.narrow = narrow;
        path.delta = chosen.delta;
        if (HAS_TRANSMISSION) {
            path.medium = medium_left(medium_behind(surface.layers), surface.layers.inside, surface.geometric_normal, direction);
            path.passed = 0.0;
        }
        alive = alive && max_component(path.throughput) > 0.0;
        bool survives = survives_roulette(path.throughput, path.scatterings, frame.at.view.roulette_start,
                                          frame.at.view.roulette_floor, bsdf_numbers.w);
        next = Ray(ray_origin(surface, ray.direction, direction), LARGEST, direction);
        next_purpose = alive && survives ? RAY_PATH : RAY_NONE;
        purpose = shadow ? RAY_SHADOW : next_purpose;
        ray = next;
        if (shadow) ray = shadow_ray;
    }
    // A driver may end a loop that seems endless to it; the sums would then lack light.
    if (sample_index != end) count_fault(COUNTER_CUT_SHORT);
    sums.at[index] = total;
    if (TRACKS_COVERAGE) coverage.at[index] += covered;
    count_read(PIXEL_SUMS_WORDS);
    count_written(PIXEL_SUMS_WORDS);
}
