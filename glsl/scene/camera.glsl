#pragma once
// Primary rays, and the projection of points to the image.
#include "core/math.glsl"
#include "scene/trace.glsl"

// The camera's ray through a point of the image, in pixels from the top left corner.
Ray camera_ray(GpuCamera camera, vec2 at, vec2 size) {
    vec2 plane = 2.0 * at / size - 1.0;
    vec3 direction = camera.forward + plane.x * camera.right - plane.y * camera.up;
    return Ray(camera.position, LARGEST, normalize(direction));
}

// Projects a point, given relative to the camera, to pixels; false if it lies behind the camera.
bool project(GpuCamera camera, vec3 offset, vec2 size, out vec2 at) {
    float distance = dot(offset, camera.forward);
    vec2 plane = vec2(dot(offset, camera.right) / dot(camera.right, camera.right),
                      -dot(offset, camera.up) / dot(camera.up, camera.up)) / distance;
    at = (plane * 0.5 + 0.5) * size;
    return distance > 0.0;
}
