//! The conversion of a scene's camera to the form that shaders read. From this form, shaders compute primary rays, and
//! the pixel in which a point of the scene appears.

use crate::device_scene::Units;
use crate::scene::Camera;
use crate::shader_interface::GpuCamera;

/// Converts `camera` to the form that shaders read: a pinhole camera for a picture of `width` × `height` pixels, from which
/// shaders compute primary rays. `units` converts the camera's position from scene units to the device's coordinates. The
/// vertical field of view is that of `camera`; the horizontal one follows from the aspect ratio of the picture.
pub fn gpu_camera(camera: &Camera, units: &Units, width: u32, height: u32) -> GpuCamera {
    let axes = camera.camera_to_world.matrix3;
    let half_height = (0.5 * camera.vertical_fov).tan();
    let half_width = half_height * f64::from(width) / f64::from(height);
    GpuCamera {
        position: units
            .to_device()
            .transform_point3(camera.camera_to_world.translation)
            .as_vec3(),
        right: (axes.x_axis.normalize() * half_width).as_vec3(),
        up: (axes.y_axis.normalize() * half_height).as_vec3(),
        forward: (-axes.z_axis.normalize()).as_vec3(),
    }
}
