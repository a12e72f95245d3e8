// The camera's ray through a point of the image, in pixels from the top left corner.

Ray camera_ray(GpuCamera camera, vec2 at, vec2 size) {
    vec2 plane = 2.0 * at / size - 1.0;
    vec3 direction = camera.forward + plane.x * camera.right - plane.y * camera.up;
    return Ray(camera.position, 3.402823466e38, normalize(direction));
}
