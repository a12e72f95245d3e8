//! Points on the surfaces of a scene, uniform by area.

use super::units::Units;
use crate::random::Random;
use crate::scene::Scene;
use glam::{DVec3, Vec3};

/// Some points on the surfaces of a scene at rest, in the device's units: one in each of `count` parts of equal area.
pub fn surface_points(scene: &Scene, units: &Units, count: usize) -> Vec<Vec3> {
    let triangles = || {
        scene.instances.iter().flat_map(|instance| {
            let mesh = &scene.meshes[instance.mesh as usize];
            let place = units.to_device() * instance.object_to_world;
            mesh.triangles.iter().map(move |corners| {
                corners.map(|corner| {
                    place.transform_point3(mesh.positions[corner as usize].as_dvec3())
                })
            })
        })
    };
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let total: f64 = triangles().map(area).sum();
    let mut points = Vec::with_capacity(count);
    if !(total > 0.0 && total.is_finite()) {
        return points;
    }
    let mut random = Random::new(0);
    let part = total / count as f64;
    let mut next = part * f64::from(random.unit());
    let mut passed = 0.0;
    for triangle in triangles() {
        passed += area(triangle);
        let [a, b, c] = triangle;
        while next < passed && points.len() < count {
            let root = f64::from(random.unit()).sqrt();
            let across = f64::from(random.unit()) * root;
            let point = a + (b - a) * (root - across) + (c - a) * across;
            points.push(point.as_vec3());
            next = part * (points.len() as f64 + f64::from(random.unit()));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural;

    #[test]
    fn they_are_spread_by_area_and_scale_with_the_scene() {
        let mut scene = procedural::generate("cornell", &[]).unwrap();
        let units = Units::of(&scene, DVec3::ZERO);
        let points = surface_points(&scene, &units, 1000);
        assert_eq!(points.len(), 1000);
        // A fifth of the box's five walls is the floor; the two blocks have less area than two walls.
        let floor = points.iter().filter(|point| point.y.abs() < 1e-4).count();
        assert!((100..220).contains(&floor), "{floor}");
        for instance in &mut scene.instances {
            instance.object_to_world =
                glam::DAffine3::from_scale(DVec3::splat(2_f64.powi(30))) * instance.object_to_world;
        }
        let units = Units::of(&scene, DVec3::ZERO);
        assert_eq!(surface_points(&scene, &units, 1000), points);
        assert_eq!(surface_points(&Scene::default(), &units, 10), []);
    }
}
