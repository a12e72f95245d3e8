#pragma once
// Primary rays, and the projection of points to the image.
#include "core/math.glsl"
#include "scene/trace.glsl"

// The camera's ray through a point of the image, in pixels from the top left corner, and, if it has a lens, through a point of
// the lens, in the unit disc.
Ray camera_ray(GpuCamera camera, vec2 at, vec2 size, vec2 lens) {
    vec2 plane = 2.0 * at / size - 1.0;
    if (CAMERA_MODEL == CAMERA_MODEL_ORTHOGRAPHIC) {
        return Ray(camera.position + plane.x * camera.right - plane.y * camera.up, LARGEST, camera.forward);
    }
    vec3 direction = camera.forward + plane.x * camera.right - plane.y * camera.up;
    if (CAMERA_MODEL == CAMERA_MODEL_PINHOLE) return Ray(camera.position, LARGEST, normalize(direction));
    // All rays of a point of the image meet at the focus distance, where the pinhole's ray is at `direction` times this distance.
    vec3 toward_rim = lens.x * normalize(camera.right) + lens.y * normalize(camera.up);
    return Ray(camera.position + camera.lens_radius * toward_rim, LARGEST, normalize(direction - camera.lens_slope * toward_rim));
}

// The point of the unit disc, for two uniform numbers.
vec2 on_disc(vec2 u) { return sqrt(u.x) * on_circle(u.y); }

// Projects a point, given relative to the camera, to pixels; false if it lies behind the camera. A lens projects like its centre.
bool project(GpuCamera camera, vec3 offset, vec2 size, out vec2 at) {
    float distance = dot(offset, camera.forward);
    vec2 plane = vec2(dot(offset, camera.right) / dot(camera.right, camera.right),
                      -dot(offset, camera.up) / dot(camera.up, camera.up));
    if (CAMERA_MODEL != CAMERA_MODEL_ORTHOGRAPHIC) plane /= distance;
    at = (plane * 0.5 + 0.5) * size;
    return distance > 0.0;
}

// The eye from whose distance a surface point is judged: what counts as close to another point. Pixels of an orthographic camera
// have the same size everywhere, so the eye goes along with the point, as far from it as the picture is high.
vec3 eye_of(GpuCamera camera, vec3 point) {
    if (CAMERA_MODEL != CAMERA_MODEL_ORTHOGRAPHIC) return camera.position;
    return point - 2.0 * length(camera.up) * camera.forward;
}
