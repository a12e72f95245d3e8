//! Meshes that stand in one place only, gathered into one.
//!
//! Boxes of whole meshes overlap where a room's walls, floor and furniture are meshes of their own:
//! a ray then enters each of them in turn. One tree over all their triangles has no such overlap.
//! What is shared by several instances stays apart, so that it is stored once.

use crate::scene::{Instance, Mesh, Part, Scene};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;

/// A scene as it is traced, and the numbers that its instances had before.
pub struct Gathered<'a> {
    /// The scene; gathered meshes and their instances stand last.
    pub scene: Cow<'a, Scene>,
    /// The number of each instance in the scene as it was; 0 for a gathered one.
    pub instance_ids: Vec<u32>,
    /// For each mesh, the number that each of its parts adds to that; empty stands for zeros.
    pub part_ids: Vec<Vec<u32>>,
    /// Which materials are lights.
    pub lamps: Vec<bool>,
}

impl<'a> Gathered<'a> {
    fn unchanged(scene: &'a Scene) -> Self {
        Self {
            scene: Cow::Borrowed(scene),
            instance_ids: (0..scene.instances.len() as u32).collect(),
            part_ids: vec![Vec::new(); scene.meshes.len()],
            lamps: scene.lamp_materials(),
        }
    }
}

/// Gathers the meshes that one instance places for good, in world space relative to `origin`: flat ones in
/// one mesh, smooth ones in another, for which alone normals are stored. Where there are fewer than
/// two such meshes the scene is left as it is.
pub fn gather(scene: &Scene, origin: DVec3) -> Gathered<'_> {
    let mut uses = vec![0_u32; scene.meshes.len()];
    for instance in &scene.instances {
        uses[instance.mesh as usize] += 1;
    }
    let moves = |number: usize| (scene.motion.as_ref()).is_some_and(|m| m.moves_instance(number));
    let single = |(number, instance): &(usize, &Instance)| {
        uses[instance.mesh as usize] == 1 && !moves(*number)
    };
    if scene.instances.iter().enumerate().filter(single).count() < 2 {
        return Gathered::unchanged(scene);
    }
    let mut left = Scene {
        materials: scene.materials.clone(),
        ..Scene::default()
    };
    let (mut instance_ids, mut part_ids) = (Vec::new(), Vec::new());
    let mut place_of = vec![None; scene.meshes.len()];
    let mut gathered: [(Mesh, Vec<u32>); 2] = Default::default();
    for (number, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        if single(&(number, instance)) {
            let (whole, ids) = &mut gathered[usize::from(!mesh.normals.is_empty())];
            let place = DAffine3::from_translation(-origin) * instance.object_to_world;
            append(whole, mesh, place);
            ids.extend(mesh.parts.iter().map(|_| number as u32));
        } else {
            let place = *place_of[instance.mesh as usize].get_or_insert_with(|| {
                left.meshes.push(mesh.clone());
                part_ids.push(Vec::new());
                left.meshes.len() as u32 - 1
            });
            left.instances.push(Instance {
                mesh: place,
                ..instance.clone()
            });
            instance_ids.push(number as u32);
        }
    }
    for (mesh, ids) in gathered {
        if !mesh.triangles.is_empty() {
            left.instances.push(Instance {
                name: String::new(),
                mesh: left.meshes.len() as u32,
                object_to_world: DAffine3::from_translation(origin),
            });
            instance_ids.push(0);
            left.meshes.push(mesh);
            part_ids.push(ids);
        }
    }
    Gathered {
        scene: Cow::Owned(left),
        instance_ids,
        part_ids,
        lamps: scene.lamp_materials(),
    }
}

/// Adds a mesh where `place` puts it.
fn append(whole: &mut Mesh, mesh: &Mesh, place: DAffine3) {
    let turn = place.matrix3.inverse().transpose();
    // A triangle's front is the side from which object space shows it counter-clockwise; a
    // mirroring transform would turn it over.
    let order = if place.matrix3.determinant() < 0.0 {
        [0, 2, 1]
    } else {
        [0, 1, 2]
    };
    let first_triangle = whole.triangles.len() as u32;
    let first = whole.positions.len() as u32;
    let positions = mesh.positions.iter().map(|p| p.as_dvec3());
    whole
        .positions
        .extend(positions.map(|p| place.transform_point3(p).as_vec3()));
    let normals = mesh.normals.iter().map(|n| n.as_dvec3());
    whole
        .normals
        .extend(normals.map(|n| (turn * n).normalize_or_zero().as_vec3()));
    let triangles = mesh.triangles.iter();
    whole
        .triangles
        .extend(triangles.map(|t| order.map(|corner| first + t[corner])));
    whole.parts.extend(mesh.parts.iter().map(|part| Part {
        first_triangle: first_triangle + part.first_triangle,
        ..*part
    }));
}
