//! Projections of cameras, and cameras that do not come from a file: a camera that looks at a point, and a camera that shows
//! a whole scene. This module also removes the scale from cameras that do come from a file.

use super::{Camera, Scene};
use glam::{DAffine3, DMat3, DVec3};

/// The way in which a camera projects the scene to its picture. The width of the picture follows from its height and from the
/// ratio of its sides in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Surfaces appear the smaller the further away they are.
    Perspective {
        /// Full vertical field of view, from the lower to the upper edge of the picture, in radians, in (0, π).
        vertical_fov: f64,
        /// The lens, which shows sharply only what is at its focus distance; `None` for a pinhole, which shows everything
        /// sharply.
        lens: Option<Lens>,
    },
    /// All rays are parallel to the viewing direction, so surfaces have the same size in the picture at every distance.
    Orthographic {
        /// Height of the part of the scene that the picture shows, in scene units, above 0.
        height: f64,
    },
}

/// A thin lens: rays of a pixel pass through all points of a disc around the camera's position, and meet in one point at the
/// focus distance. It does not change the brightness of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Diameter of the lens (its aperture), in scene units, above 0 and finite. What is out of focus is blurred in proportion
    /// to it.
    pub diameter: f64,
    /// Distance of the plane that the picture shows sharply, in scene units, measured from the camera's position along its
    /// viewing direction; above 0. Infinity focuses on what is infinitely far away.
    pub focus_distance: f64,
}

impl Projection {
    /// The projection of a pinhole camera with this full vertical field of view, in radians.
    pub const fn pinhole(vertical_fov: f64) -> Self {
        Self::Perspective {
            vertical_fov,
            lens: None,
        }
    }

    /// Half of the height of the picture: of an orthographic camera in scene units, of a perspective camera at the distance 1.
    pub fn half_height(&self) -> f64 {
        match self {
            Self::Perspective { vertical_fov, .. } => (0.5 * vertical_fov).tan(),
            Self::Orthographic { height } => 0.5 * height,
        }
    }
}

/// The field of view of [`framing_camera`], in radians (40°). It is measured vertically, from the lower to the upper edge of
/// the picture.
const FRAMING_FOV: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// The size of what [`framing_camera`] shows, relative to the scene: the scene fills the width or the height of the picture,
/// except for this margin.
const FRAMING_MARGIN: f64 = 1.05;

/// The aspect ratio (width ÷ height) of pictures whose camera and arguments state none.
pub const DEFAULT_ASPECT: f64 = 16.0 / 9.0;

/// A camera at the position `eye` that looks at the point `target`, both in world space. +Y is up in the picture. If the
/// camera looks straight down, the top of the picture is towards −Z; if it looks straight up, towards +Z. If `eye` equals
/// `target`, it looks along −Z. `yfov` is the full vertical field of view in radians.
pub fn look_at(eye: DVec3, target: DVec3, yfov: f64) -> Camera {
    Camera {
        name: String::new(),
        camera_to_world: DAffine3::from_mat3_translation(axes(eye - target), eye),
        projection: Projection::pinhole(yfov),
        aspect_ratio: None,
    }
}

/// A camera for scenes that have none. It shows the whole scene from the front (+Z), somewhat from the right (+X) and from
/// above (+Y), and so near that the scene fills the width or the height of a picture with the aspect ratio `aspect` (width ÷
/// height). For an empty scene, it is at (0, 0, 5) and looks at the origin.
pub fn framing_camera(scene: &Scene, aspect: f64) -> Camera {
    let axes = axes(DVec3::new(0.4, 0.3, 1.0));
    let to_camera = axes.transpose();
    let vertical = (FRAMING_FOV / 2.0).tan() / FRAMING_MARGIN;
    let horizontal = vertical * aspect;
    // A point (x, y, z) in the camera's axes is within the picture of a camera at (u, v, w) if ±(x − u) ≤ s (w − z) and
    // ±(y − v) ≤ t (w − z), where s and t are the slopes of the sides. So four numbers bound the position of the camera: the
    // largest ±x + s z and ±y + t z of all points.
    let mut reaches = [f64::NEG_INFINITY; 4];
    let mut depths = [f64::INFINITY, f64::NEG_INFINITY];
    for point in scene.outline() {
        let p = to_camera * point;
        let own = [
            p.x + horizontal * p.z,
            -p.x + horizontal * p.z,
            p.y + vertical * p.z,
            -p.y + vertical * p.z,
        ];
        for (reach, own) in reaches.iter_mut().zip(own) {
            *reach = reach.max(own);
        }
        depths = [depths[0].min(p.z), depths[1].max(p.z)];
    }
    let [right, left, top, bottom] = reaches;
    let nearest = ((right + left) / (2.0 * horizontal)).max((top + bottom) / (2.0 * vertical));
    if !nearest.is_finite() {
        return look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, FRAMING_FOV);
    }
    // The camera must be in front of points on its axis as well.
    let length = match depths[1] - depths[0] {
        0.0 => 1.0,
        depth => 0.05 * depth,
    };
    let distance = nearest.max(depths[1] + length);
    let eye = DVec3::new(0.5 * (right - left), 0.5 * (top - bottom), distance);
    Camera {
        name: String::new(),
        camera_to_world: DAffine3::from_mat3_translation(axes, axes * eye),
        projection: Projection::pinhole(FRAMING_FOV),
        aspect_ratio: None,
    }
}

/// Removes scale and shear from `matrix`, the linear part of a camera-to-world transform, so that a rotation remains, as
/// renderers need it. The viewing direction stays the same, and the camera's +Y changes as little as possible. `None` if the
/// y or z axis of `matrix` is 0, or if both axes are parallel: such a camera has no direction.
pub(crate) fn rigid(matrix: DMat3) -> Option<DMat3> {
    let unit = |axis: DVec3| (axis / axis.abs().max_element()).try_normalize();
    let z = unit(matrix.z_axis)?;
    let x = unit(unit(matrix.y_axis)?.cross(z))?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}

/// The x, y and z axis of a camera in world space, as the columns of a matrix, with the camera's +Y as far upwards as
/// possible. `back` is a vector of any length, opposite to the viewing direction; if it is 0, the camera looks along −Z.
fn axes(back: DVec3) -> DMat3 {
    // Scaled before it is normalised, since the square of a tiny or huge length is out of f64's range.
    let z = (back / back.abs().max_element())
        .try_normalize()
        .unwrap_or(DVec3::Z);
    let up = if z.x.hypot(z.z) > 1e-9 {
        DVec3::Y
    } else if z.y > 0.0 {
        DVec3::NEG_Z
    } else {
        DVec3::Z
    };
    let x = up.cross(z).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}

#[cfg(test)]
mod tests {
    use super::super::{Instance, Mesh};
    use super::*;
    use glam::{DQuat, Vec3};

    fn is_rotation(m: DMat3) -> bool {
        (m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12) && m.determinant() > 0.0
    }

    #[test]
    fn looks_at_the_target_with_the_sky_up() {
        let eye = DVec3::new(3.0, 4.0, -5.0);
        let target = DVec3::new(-1.0, 0.5, 2.0);
        let camera = look_at(eye, target, 0.5);
        let m = camera.camera_to_world;
        assert!(is_rotation(m.matrix3));
        assert_eq!(m.translation, eye);
        let seen = m.inverse().transform_point3(target);
        assert!(seen.x.abs() < 1e-12 && seen.y.abs() < 1e-12 && seen.z < 0.0);
        assert!(m.matrix3.y_axis.y > 0.0 && m.matrix3.x_axis.y.abs() < 1e-12);
    }

    #[test]
    fn every_direction_gives_a_rotation() {
        for target in [
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::ZERO,
            DVec3::Z,
            DVec3::splat(1e200),
            DVec3::splat(1e-200),
        ] {
            let m = look_at(DVec3::ZERO, target, 1.0).camera_to_world.matrix3;
            assert!(is_rotation(m), "{target}: {m}");
        }
    }

    #[test]
    fn the_scene_fills_the_picture() {
        for size in [Vec3::new(1.0, 1.0, 1.0), Vec3::new(100.0, 0.1, 3.0)] {
            let scene = Scene {
                meshes: vec![Mesh {
                    positions: vec![-size, size, Vec3::new(size.x, -size.y, size.z)],
                    triangles: vec![[0, 1, 2]],
                    ..Mesh::default()
                }],
                instances: vec![Instance {
                    name: String::new(),
                    mesh: 0,
                    object_to_world: DAffine3::from_rotation_translation(
                        DQuat::from_rotation_y(0.7),
                        DVec3::new(1e6, -20.0, 3.0),
                    ),
                }],
                ..Scene::default()
            };
            for aspect in [0.5, 1.0, 16.0 / 9.0] {
                let camera = framing_camera(&scene, aspect);
                let slope = camera.projection.half_height();
                let (mut left, mut right, mut height) = (0.0_f64, 0.0_f64, 0.0_f64);
                let place = scene.instances[0].object_to_world;
                for position in &scene.meshes[0].positions {
                    let point = place.transform_point3(position.as_dvec3());
                    let seen = camera.camera_to_world.inverse().transform_point3(point);
                    assert!(seen.z < 0.0);
                    let [x, y] = [seen.x / aspect, seen.y].map(|v| v / (slope * -seen.z));
                    (left, right) = (left.max(-x), right.max(x));
                    height = height.max(y.abs());
                }
                // The scene touches both margins of the width or of the height.
                let fills = |part: f64| (part - 1.0 / FRAMING_MARGIN).abs() < 1e-6;
                assert!(
                    left < 1.0 && right < 1.0 && height < 1.0,
                    "{left} {right} {height}"
                );
                assert!(
                    fills(left) && fills(right) || fills(height),
                    "{left} {right} {height}"
                );
            }
        }
    }

    #[test]
    fn an_empty_scene_has_a_camera_too() {
        assert!(is_rotation(
            framing_camera(&Scene::default(), DEFAULT_ASPECT)
                .camera_to_world
                .matrix3
        ));
    }
}
