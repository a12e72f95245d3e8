//! Checks the rules that every scene, loaded or generated, must fulfil before it is rendered, and repairs small faults.

mod cameras;
mod layers;
mod materials;
mod meshes;
pub(crate) mod punctual;

pub use cameras::check_camera;

use super::notices::{Tally, label};
use super::{Bounds, Instance, Material, Mesh, Scene};
use crate::{Error, Result};
use glam::{DAffine3, DMat3, Vec3};
use layers::check_volumes;
use materials::{check_image, check_material, check_textures};
use meshes::check_mesh;
use punctual::check_punctual;
use rayon::prelude::*;

/// The largest absolute coordinate that a scene may have in the world, in scene units. Scenes beyond it are refused, because
/// the squares of far larger distances overflow f32.
pub const LARGEST_COORDINATE: f64 = 1e15;

/// The smallest allowed length of the longest edge of a scene's bounding box, in scene units; a smaller scene is refused.
/// Tests check pictures of scenes down to twice this size. A scene with moving instances is never refused for its size,
/// because it may be larger at other times.
pub const SMALLEST_SCENE: f64 = 1e-12;

/// The threshold for the notice that f32 stores a mesh too coarsely. The notice appears if the spacing of f32 numbers at the
/// mesh's largest coordinate, divided by the longest edge of the mesh's bounding box, is above it.
const COARSE: f64 = 5e-3;

/// The largest emission of a material, and the largest radiance of a texel of an environment, in W/(m²·sr); more is refused.
/// A sample in a picture may be up to [`crate::shader_interface::MAX_RADIANCE`] times as bright as the brightest light. The
/// product of that factor and `BRIGHTEST` must be finite in f32.
pub const BRIGHTEST: f32 = 1e12;

/// The largest absolute determinant of a transform at which an instance counts as flat. A flat instance has no normals, so
/// it is removed, unless it moves. Before the determinant is computed, the transform's axes are scaled to lengths near 1, so
/// that small instances do not count as flat.
const SINGULAR: f64 = 1e-15;

/// True if f32 stores the positions of the mesh too coarsely, because they are much farther from the mesh's origin than from
/// each other. The user then gets a notice. The result is also true if at least one triangle in ten is much farther from the
/// origin than its corners are from each other, as in a mesh of two parts that are far apart.
fn is_coarse(mesh: &Mesh) -> bool {
    let step = |furthest: f64| furthest * f64::from(f32::EPSILON);
    let Some(bounds) = mesh.bounds() else {
        return false;
    };
    let furthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if step(furthest) > COARSE * bounds.size().max_element() {
        return true;
    }
    let is_coarse = |triangle: &&[u32; 3]| {
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let [a, b, c] = corners;
        let furthest = corners.map(|p| p.abs().max_element());
        let furthest = furthest.into_iter().fold(0.0, f32::max);
        let size = (b - a).abs().max((c - a).abs()).max_element();
        size > 0.0 && step(furthest.into()) > 2.0 * COARSE * f64::from(size)
    };
    let coarse = mesh.triangles.iter().filter(is_coarse).count();
    coarse > 0 && 10 * coarse >= mesh.triangles.len()
}

/// True if every channel is at least 0 and at most `limit`; false if a channel is NaN. A material, punctual light or
/// environment whose light is not within its limit is refused. The channels are compared one by one, because the minimum and
/// the maximum of a vector may ignore NaN.
pub(super) fn is_within(color: Vec3, limit: f32) -> bool {
    color.cmpge(Vec3::ZERO).all() && color.cmple(Vec3::splat(limit)).all()
}

impl Mesh {
    /// Checks and repairs a mesh, and makes its tangents. `index` is its index in the scene. Returns the notices about it;
    /// fails as [`check_mesh`] does. A mesh that `deforms` is only checked. Meshes are independent of each other, so they are
    /// checked in parallel.
    fn checked(&mut self, index: usize, materials: &[Material], deforms: bool) -> Result<Tally> {
        let mut tally = Tally::default();
        check_mesh(index, self, materials)?;
        check_volumes(index, self, materials, &mut tally);
        // Its rest shape is repaired where it is read: later, its vertices must keep their order.
        if deforms {
            return Ok(tally);
        }
        if is_coarse(self) {
            tally.add(
                "meshes are so far from their origin that f32 holds their vertices coarsely; move the mesh there, and its node back",
                || label("mesh", index, &self.name),
            );
        }
        self.repair(index, &mut tally);
        self.make_tangents(materials);
        Ok(tally)
    }
}

impl Scene {
    /// Checks the scene and repairs small faults: clamps base colours and vertex colours to [0, 1], makes normals and
    /// tangents unit vectors, computes missing ones, and removes triangles without area, unused vertices, flat instances
    /// that do not move, meshes without triangles, and deformations of meshes without an instance. Later instances and meshes then get new indices. Notices report these
    /// changes, except small corrections of normals and changes of tangents and unused vertices. A second check changes
    /// nothing, and an empty scene is valid.
    ///
    /// # Errors
    /// The renderer cannot use an element, which the message names: an index or a count is out of range, a number is not
    /// finite, parts do not cover the triangles of their mesh, a material or a light has a value outside its range, a camera
    /// is invalid, keyframes are not in the order of time, or the scene is too small or too far from the origin.
    pub fn validate(&mut self) -> Result<()> {
        let mut tally = Tally::default();
        if let Some(motion) = &self.motion {
            let counts = [
                self.instances.len(),
                self.cameras.len(),
                self.punctual_lights.len(),
                self.materials.len(),
            ];
            motion.check(counts)?;
            motion.check_deformations(&self.meshes)?;
        }
        self.drop_unseen_deformations();
        let deforming = self.deforming_meshes();
        for (index, material) in self.materials.iter_mut().enumerate() {
            check_material(index, material, &mut tally)?;
            check_textures(index, material, &self.images)?;
        }
        for (index, image) in self.images.iter().enumerate() {
            check_image(index, image)?;
        }
        let meshes = self.meshes.par_iter_mut().enumerate();
        let noticed: Vec<Result<Tally>> = meshes
            .map(|(index, mesh)| mesh.checked(index, &self.materials, deforming[index]))
            .collect();
        for of_mesh in noticed {
            tally.append(of_mesh?);
        }
        self.check_instances(&mut tally)?;
        self.drop_empty_meshes(&mut tally);
        for (index, camera) in self.cameras.iter().enumerate() {
            check_camera(&label("camera", index, &camera.name), camera)?;
        }
        for (index, light) in self.punctual_lights.iter().enumerate() {
            check_punctual(&label("light", index, &light.name), light)?;
        }
        self.notices.extend(tally.into_lines());
        Ok(())
    }

    fn check_instances(&mut self, tally: &mut Tally) -> Result<()> {
        let boxes: Vec<Option<Bounds>> = self.meshes.iter().map(Mesh::bounds).collect();
        let mut flat = vec![false; self.instances.len()];
        let deforming = self.deforming_meshes();
        let mut any_moves = false;
        for (index, instance) in self.instances.iter().enumerate() {
            let what = label("instance", index, &instance.name);
            let Some(bounds) = boxes.get(instance.mesh as usize) else {
                return Err(Error::input(format!(
                    "{what}: mesh {} is out of range, there are {}",
                    instance.mesh,
                    boxes.len()
                )));
            };
            check_reach(
                &what,
                &instance.object_to_world,
                bounds.as_ref(),
                LARGEST_COORDINATE,
            )?;
            any_moves |= self.moves_instance(index) || deforming[instance.mesh as usize];
            flat[index] = self.stays_flat(index);
            if flat[index] {
                tally.add(
                    "flat instances (a scale of 0, or axes in one plane) are skipped",
                    || what,
                );
            }
        }
        let all = Bounds::around(self.placed_boxes(&boxes).into_iter());
        let size = all.map_or(0.0, |bounds| bounds.size().max_element());
        // A scene that moves may be larger at other times, and one without a size shows nothing.
        if !any_moves && size > 0.0 && size < SMALLEST_SCENE {
            return Err(Error::input(format!(
                "the scene is {size:.1e} units wide, and {SMALLEST_SCENE:e} is as small as can be rendered; scale it up"
            )));
        }
        self.retain_instances(|index, _| !flat[index]);
        Ok(())
    }

    fn drop_empty_meshes(&mut self, tally: &mut Tally) {
        let mut kept = 0;
        let moved: Vec<Option<u32>> = self
            .meshes
            .iter()
            .enumerate()
            .map(|(index, mesh)| {
                if mesh.triangles.is_empty() {
                    tally.add("meshes without triangles are skipped", || {
                        label("mesh", index, &mesh.name)
                    });
                    return None;
                }
                kept += 1;
                Some(kept - 1)
            })
            .collect();
        if kept as usize == self.meshes.len() {
            return;
        }
        self.meshes.retain(|mesh| !mesh.triangles.is_empty());
        if let Some(motion) = &mut self.motion {
            motion.deformations.retain_mut(|deformation| {
                let index = moved[deformation.mesh as usize];
                deformation.mesh = index.unwrap_or(0);
                index.is_some()
            });
        }
        self.retain_instances(|_, instance| match moved[instance.mesh as usize] {
            Some(mesh) => {
                instance.mesh = mesh;
                true
            }
            None => false,
        });
    }

    /// True if the instance is flat at all times. A moving instance may be flat at some times only.
    fn stays_flat(&self, index: usize) -> bool {
        !self.moves_instance(index) && is_singular(self.instances[index].object_to_world.matrix3)
    }

    /// Removes the deformations of meshes that no instance shows. These meshes keep their shape.
    fn drop_unseen_deformations(&mut self) {
        let mut shown = vec![false; self.meshes.len()];
        for (index, instance) in self.instances.iter().enumerate() {
            // Its index is checked later.
            if let Some(shown) = shown.get_mut(instance.mesh as usize) {
                *shown |= !self.stays_flat(index);
            }
        }
        if let Some(motion) = &mut self.motion {
            let deformations = &mut motion.deformations;
            deformations.retain(|deformation| shown[deformation.mesh as usize]);
        }
    }

    /// Removes the instances for which `keep` returns false, and their entries in [`super::Motion::instances`]. `keep` is
    /// called with the index of each instance and the instance itself, which it may change.
    fn retain_instances(&mut self, mut keep: impl FnMut(usize, &mut Instance) -> bool) {
        let instances = self.instances.iter_mut().enumerate();
        let kept: Vec<bool> = instances.map(|(index, one)| keep(index, one)).collect();
        let mut next = kept.iter();
        self.instances.retain(|_| next.next() == Some(&true));
        if let Some(motion) = &mut self.motion {
            let mut next = kept.iter();
            motion.instances.retain(|_| next.next() == Some(&true));
        }
    }
}

/// Checks that `transform` places everything in the box `bounds` near enough to the origin for rendering. The box is in the
/// space before the transform; `None` stands for an empty mesh, which has no box. `farthest` is the largest absolute
/// coordinate that is allowed after the transform; `what` names the element in messages.
///
/// # Errors
/// The transform is not finite, or a transformed corner of the box has a coordinate beyond `farthest`.
pub(super) fn check_reach(
    what: &str,
    transform: &DAffine3,
    bounds: Option<&Bounds>,
    farthest: f64,
) -> Result<()> {
    if !transform.is_finite() {
        return Err(Error::input(format!(
            "{what}: its transform is not finite; correct it in the modelling tool"
        )));
    }
    let reach = bounds
        .into_iter()
        .flat_map(Bounds::corners)
        .map(|corner| transform.transform_point3(corner).abs().max_element())
        .fold(0.0, f64::max);
    if reach > farthest {
        return Err(Error::input(format!(
            "{what}: reaches {reach:.3e} from the origin, and {farthest:e} is as far as can be rendered; scale the scene down"
        )));
    }
    Ok(())
}

/// True if `matrix`, a transform without its translation, flattens everything onto a plane, a line or a point. Such a matrix
/// cannot transform normals, so an instance with this transform is not rendered.
pub(super) fn is_singular(matrix: DMat3) -> bool {
    // Axes are scaled to a length near 1 first: the product of their lengths may be out of f64's range.
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| {
        let largest = axis.abs().max_element();
        axis / if largest > 0.0 { largest } else { 1.0 }
    });
    let [x, y, z] = axes;
    DMat3::from_cols(x, y, z).determinant().abs() <= SINGULAR
}

#[cfg(test)]
mod tests {
    use super::super::Part;
    use super::super::camera::{Projection, look_at};
    use super::*;
    use glam::{DVec3, Vec3};

    /// A valid scene with one camera and one instance, whose mesh is one triangle of one material. Tests plant faults in it.
    fn scene() -> Scene {
        Scene {
            meshes: vec![Mesh {
                name: "leaf".into(),
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                normals: vec![],
                triangles: vec![[0, 1, 2]],
                parts: vec![Part {
                    first_triangle: 0,
                    triangle_count: 1,
                    material: 0,
                }],
                ..Mesh::default()
            }],
            materials: vec![Material::lambert("green", Vec3::ONE)],
            instances: vec![Instance {
                name: "branch".into(),
                mesh: 0,
                object_to_world: DAffine3::IDENTITY,
            }],
            cameras: vec![look_at(DVec3::Z, DVec3::ZERO, 1.0)],
            ..Scene::default()
        }
    }

    #[test]
    fn good_and_empty_scenes_pass_unchanged() {
        for mut scene in [scene(), Scene::default()] {
            let before = scene.content_hash();
            scene.validate().unwrap();
            assert_eq!(scene.content_hash(), before);
            assert!(scene.notices.is_empty());
        }
    }

    #[test]
    fn faults_are_named() {
        type Fault = (fn(&mut Scene), &'static str);
        let faults: [Fault; 24] = [
            (
                |s| s.materials[0].base_color.x = f32::NAN,
                "material 0 \"green\": base colour",
            ),
            (|s| s.materials[0].metallic = 1.5, "metallic is 1.5"),
            (|s| s.materials[0].roughness = -0.1, "roughness is -0.1"),
            (|s| s.materials[0].specular = f32::NAN, "specular is NaN"),
            (
                |s| s.materials[0].specular_color.x = -1.0,
                "specular colour",
            ),
            (|s| s.materials[0].ior = -0.5, "index of refraction is -0.5"),
            (
                |s| s.materials[0].ior = f32::INFINITY,
                "index of refraction",
            ),
            (|s| s.materials[0].emission.y = -1.0, "emission"),
            (|s| s.materials[0].emission.y = f32::INFINITY, "emission"),
            (
                |s| s.meshes[0].positions[1].x = f32::NAN,
                "mesh 0 \"leaf\": position 1",
            ),
            (
                |s| s.meshes[0].normals = vec![Vec3::Z],
                "1 normals for 3 positions",
            ),
            (
                |s| s.meshes[0].normals = vec![Vec3::NAN; 3],
                "normal 0 is [NaN, NaN, NaN]",
            ),
            (|s| s.meshes[0].triangles[0][2] = 3, "triangle 0"),
            (
                |s| s.meshes[0].parts[0].material = 7,
                "part 0 has material 7",
            ),
            (|s| s.meshes[0].parts[0].first_triangle = 1, "part 0 begins"),
            (
                |s| s.meshes[0].parts[0].triangle_count = u32::MAX,
                "cover 4294967295 triangles of 1",
            ),
            (|s| s.meshes[0].parts.clear(), "cover 0 triangles of 1"),
            (|s| s.instances[0].mesh = 9, "instance 0 \"branch\": mesh 9"),
            (
                |s| s.instances[0].object_to_world.translation.x = f64::NAN,
                "transform is not finite",
            ),
            (
                |s| s.instances[0].object_to_world.translation.x = 1e30,
                "scale the scene down",
            ),
            (
                |s| s.cameras[0].projection = Projection::pinhole(0.0),
                "camera 0",
            ),
            (
                |s| s.cameras[0].projection = Projection::pinhole(f64::NAN),
                "field of view",
            ),
            (|s| s.cameras[0].aspect_ratio = Some(0.0), "aspect ratio"),
            (
                |s| s.cameras[0].camera_to_world.matrix3 *= 2.0,
                "not a rotation",
            ),
        ];
        for (fault, named) in faults {
            let mut scene = scene();
            fault(&mut scene);
            let error = scene.validate().unwrap_err();
            assert_eq!(error.exit_status(), 2);
            let text = error.to_string();
            assert!(text.contains(named), "{text:?} names {named:?}");
            assert!(!text.contains('\n'));
        }
    }

    #[test]
    fn base_colours_are_clamped() {
        let mut scene = scene();
        scene.materials[0].base_color = Vec3::new(-0.5, 0.5, 1.5);
        scene.validate().unwrap();
        assert_eq!(scene.materials[0].base_color, Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(
            scene.notices,
            ["base colours outside [0, 1] are clamped: material 0 \"green\""]
        );
    }

    #[test]
    fn flat_instances_go_and_small_ones_stay() {
        let mut scene = scene();
        for scale in [
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(-1e-9, 1e9, 1e-12),
            DVec3::splat(1e-120),
        ] {
            scene.instances.push(Instance {
                name: "twig".into(),
                mesh: 0,
                object_to_world: DAffine3::from_scale(scale),
            });
        }
        scene.validate().unwrap();
        assert_eq!(scene.instances.len(), 3);
        assert_eq!(
            scene.notices,
            [
                "flat instances (a scale of 0, or axes in one plane) are skipped: instance 1 \"twig\""
            ]
        );
    }

    #[test]
    fn empty_meshes_go_and_indices_follow() {
        let mut scene = scene();
        scene.meshes.insert(0, Mesh::default());
        scene.instances[0].mesh = 1;
        scene.instances.push(Instance {
            name: String::new(),
            mesh: 0,
            object_to_world: DAffine3::IDENTITY,
        });
        scene.validate().unwrap();
        assert_eq!(scene.meshes.len(), 1);
        assert_eq!(scene.instances.len(), 1);
        assert_eq!(scene.instances[0].mesh, 0);
        assert_eq!(
            scene.notices,
            ["meshes without triangles are skipped: mesh 0"]
        );
    }
}
