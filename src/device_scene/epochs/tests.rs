use super::super::deforming::DeformingMesh;
use super::super::geometry::Geometry;
use super::super::merge_static::merge_static;
use super::super::units::Units;
use super::*;
use crate::scene::motion::deformation::{Deformation, MorphTarget, Vertices};
use crate::scene::motion::tracks::{Animated, Interpolation, Track};
use crate::scene::{Instance, Material, Mesh, Part, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// A triangle of its own height, by which tests tell meshes apart.
fn triangle(height: f32) -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y * height],
        triangles: vec![[0, 1, 2]],
        parts: vec![Part {
            first_triangle: 0,
            triangle_count: 1,
            material: 0,
        }],
        ..Mesh::default()
    }
}

/// The deformation that moves the mesh with the index `mesh` by 1 along z until `end`, in seconds, and then stays.
fn rises(scene: &Scene, mesh: u32, end: f64) -> Deformation {
    Deformation {
        mesh,
        rest: Vertices {
            positions: scene.meshes[mesh as usize].positions.clone(),
            ..Vertices::default()
        },
        targets: vec![MorphTarget {
            weight: Animated {
                rest: 0.0,
                track: Some(Track {
                    interpolation: Interpolation::Linear,
                    times: vec![0.0, end],
                    values: vec![0.0, 1.0],
                }),
            },
            positions: vec![Vec3::Z; 3],
            normals: Vec::new(),
            tangents: Vec::new(),
        }],
        skin: None,
    }
}

/// Triangles with the heights 1 to 5. The last two rise, one for half a second and one for a second, in this order of
/// deformations. The first one rises too, but no instance shows it; the other two are merged.
fn scene() -> Scene {
    let mut scene = Scene {
        meshes: (1..=5).map(|height| triangle(height as f32)).collect(),
        materials: vec![Material::default()],
        ..Scene::default()
    };
    scene.instances = (1..5)
        .map(|mesh| Instance {
            name: String::new(),
            mesh,
            object_to_world: DAffine3::IDENTITY,
        })
        .collect();
    scene.motion = Some(Motion {
        instances: vec![None; 4],
        deformations: [(0, 0.1), (4, 0.5), (3, 1.0)]
            .map(|(mesh, end)| rises(&scene, mesh, end))
            .into(),
        ..Motion::default()
    });
    scene
}

fn moving(scene: &Scene) -> MovingScene {
    let motion = scene.motion.clone().unwrap();
    let traced = merge_static(scene, DVec3::ZERO);
    assert_eq!(traced.scene.meshes.len(), 3);
    let mut geometry = Geometry::new(&traced, true);
    let deforming = DeformingMesh::reserve(&traced, &mut geometry);
    let units = Units::of(scene, DVec3::ZERO);
    let poser = ScenePoser::new(&traced, &geometry, deforming, units, true);
    let pose = poser.pose_at(0.0, motion.pose(0.0), None).unwrap();
    MovingScene::new(motion, poser, 8, scene.instances.len(), pose)
}

/// Each mesh has its own shape at the time of each pose, and only shapes that a stored copy does not have are computed.
#[test]
fn shapes_are_computed_where_they_change() {
    let scene = scene();
    let moving = moving(&scene);
    let mut counts = Vec::new();
    for frame in 1..=6 {
        let [now, before] = [frame, frame - 1].map(|frame| f64::from(frame) / 4.0);
        let change = moving.set_times(now, before).unwrap().unwrap();
        assert_eq!(change.new, [true, false]);
        for pose in &*change.poses {
            let expected = scene.pose_at(pose.time).unwrap();
            // In the order of the instances.
            for (deformed, mesh) in pose.deformed.iter().zip(&expected.meshes[3..]) {
                assert_eq!(deformed.vertices.positions, mesh.positions);
            }
        }
        let pose = &change.poses[0];
        assert_eq!(pose.deformed.len(), 2);
        let new = pose.is_new.iter().filter(|is_new| **is_new).count();
        assert_eq!(moving.new_copies(pose).count(), new);
        counts.push(new);
    }
    // The copy that is replaced has the shape of two frames before.
    assert_eq!(counts, [2, 2, 2, 1, 1, 0]);
}
