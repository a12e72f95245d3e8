//! The conversion of a scene's camera to the form that shaders read. From this form, shaders compute primary rays, and
//! the pixel in which a point of the scene appears.

use crate::device_scene::Units;
use crate::scene::Camera;
use crate::scene::camera::Projection;
use crate::shader_interface::{CameraModel, GpuCamera};

/// Converts `camera` to the form that shaders read, for a picture of `width` × `height` pixels, from which shaders compute
/// primary rays. `units` converts lengths and positions from scene units to the device's coordinates. The height of what the
/// picture shows is that of `camera`; the width follows from the aspect ratio of the picture.
pub fn gpu_camera(camera: &Camera, units: &Units, width: u32, height: u32) -> GpuCamera {
    let axes = camera.camera_to_world.matrix3;
    let (unit, lens) = match camera.projection {
        Projection::Perspective { lens, .. } => (1.0, lens),
        Projection::Orthographic { .. } => (units.length, None),
    };
    let half_height = camera.projection.half_height() / unit;
    let half_width = half_height * f64::from(width) / f64::from(height);
    let radius = lens.map_or(0.0, |lens| 0.5 * lens.diameter);
    let slope = lens.map_or(0.0, |lens| radius / lens.focus_distance);
    GpuCamera {
        position: units
            .to_device()
            .transform_point3(camera.camera_to_world.translation)
            .as_vec3(),
        right: (axes.x_axis.normalize() * half_width).as_vec3(),
        up: (axes.y_axis.normalize() * half_height).as_vec3(),
        forward: (-axes.z_axis.normalize()).as_vec3(),
        lens_radius: (radius / units.length) as f32,
        lens_slope: slope as f32,
    }
}

/// The model of `camera`, for which shaders are specialised.
pub const fn camera_model(camera: &Camera) -> CameraModel {
    match camera.projection {
        Projection::Perspective { lens: None, .. } => CameraModel::Pinhole,
        Projection::Perspective { lens: Some(_), .. } => CameraModel::ThinLens,
        Projection::Orthographic { .. } => CameraModel::Orthographic,
    }
}
