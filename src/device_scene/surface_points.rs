//! Random points on the surfaces of a scene, uniform by area. The light BVH chooses the scale of its boxes from such points.
//! The hash grid (reservoirs of direct light in cells of space) can fill its cells at them.

use crate::base::random::Random;
use crate::shader_interface::GpuInstance;
use glam::{DVec3, Vec3};

/// A random point on a surface of the scene, in the device's units. The scale of the light BVH is chosen from
/// such points, and the hash grid can be filled at them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The position of the point in the device's world space.
    pub position: Vec3,
    /// The unit normal of the triangle on which the point lies, in the device's world space. It may be on either side of the
    /// triangle, so a caller that needs the lit side must try both.
    pub normal: Vec3,
}

/// Divides the surfaces of all instances into `count` parts of equal area, and draws one random point in each part.
/// `triangle_counts` has the number of triangles of each instance's mesh, and `positions` the stored corners of the
/// triangles of all meshes. The result is empty if the total area is 0 or not finite.
pub fn surface_points(
    instances: &[GpuInstance],
    triangle_counts: &[u32],
    positions: &[[Vec3; 3]],
    count: usize,
) -> Vec<SurfacePoint> {
    let triangles = || {
        instances
            .iter()
            .zip(triangle_counts)
            .flat_map(|(instance, triangles)| {
                let [x, y, z, at] = instance.object_to_world.map(|column| column.as_dvec3());
                let first = instance.first_triangle as usize;
                positions[first..][..*triangles as usize]
                    .iter()
                    .map(move |corners| {
                        corners.map(|p| {
                            let p = p.as_dvec3();
                            x * p.x + y * p.y + z * p.z + at
                        })
                    })
            })
    };
    let cross = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    let total: f64 = triangles().map(|corners| cross(corners).length()).sum();
    let mut points = Vec::with_capacity(count);
    if !(total > 0.0 && total.is_finite()) {
        return points;
    }
    let mut random = Random::new(0);
    let part = total / count as f64;
    let mut next = part * f64::from(random.unit());
    let mut passed = 0.0;
    for corners in triangles() {
        let across = cross(corners);
        passed += across.length();
        let [a, b, c] = corners;
        while next < passed && points.len() < count {
            let root = f64::from(random.unit()).sqrt();
            let third = f64::from(random.unit()) * root;
            let position = a + (b - a) * (root - third) + (c - a) * third;
            points.push(SurfacePoint {
                position: position.as_vec3(),
                normal: across.normalize().as_vec3(),
            });
            next = part * (points.len() as f64 + f64::from(random.unit()));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws 1000 points on an instance of two triangles with the areas 1 and 3. The instance enlarges all lengths by the
    /// factor 2 × `scale`.
    fn points(scale: f32) -> Vec<SurfacePoint> {
        let instance = GpuInstance {
            object_to_world: [Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(7.0)].map(|v| v * 2.0 * scale),
            first_triangle: 1,
            ..GpuInstance::default()
        };
        let unused = [Vec3::ZERO; 3];
        let small = [Vec3::ZERO, 2.0 * Vec3::X, Vec3::Y];
        let large = [Vec3::ZERO, 6.0 * Vec3::Y, Vec3::Z].map(|p| p - Vec3::X);
        surface_points(&[instance], &[2], &[unused, small, large], 1000)
    }

    #[test]
    fn they_are_spread_by_area_and_scale_with_the_scene() {
        let plain = points(1.0);
        assert_eq!(plain.len(), 1000);
        let small = plain.iter().filter(|p| p.normal.z > 0.999).count();
        assert!((248..=252).contains(&small), "{small}");
        assert!(
            plain
                .iter()
                .all(|p| p.position.x > 11.99 && p.position.y > 13.99)
        );
        let scale = 2_f32.powi(30);
        for (far, near) in points(scale).iter().zip(plain) {
            assert_eq!(
                (far.position, far.normal),
                (near.position * scale, near.normal)
            );
        }
        assert_eq!(surface_points(&[], &[], &[], 10), []);
    }
}
