//! Where a scene's instances and lights stand at one time, as the device is told.

use super::compute_bvh::Tree;
use super::gather::Gathered;
use super::geometry::{Geometry, MeshPlace};
use crate::Result;
use crate::layouts::{GpuCarry, GpuInstance, GpuLight, NONE};
use crate::scene::lights::{self, AliasTable, LampTriangle, LightTriangle, UNIFORM_SHARE};
use crate::scene::motion::{Pose, check_place, is_flat};
use crate::scene::{Bounds, Material, Scene};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashMap;

/// What it takes to place a scene's instances and lights at any time.
pub struct Stage {
    origin: DVec3,
    actors: Vec<Actor>,
    /// Which of the actors each moving instance of the scene is.
    actor_of: HashMap<u32, usize>,
    lamps: Vec<LampTriangle>,
    materials: Vec<Material>,
    trees: bool,
    /// Levels of the tree over the instances at most.
    most_depth: u32,
}

/// An instance that is traced: where it stands unless it moves, and what never changes.
struct Actor {
    object_to_world: DAffine3,
    mesh: MeshPlace,
    fixed: GpuInstance,
}

/// Everything where it is at one time.
#[derive(Clone)]
pub struct Standing {
    /// The time in seconds.
    pub time: f64,
    /// Instances; the roots of their meshes count from the first mesh's.
    pub instances: Vec<GpuInstance>,
    /// Those of them that can be seen.
    pub visible: Vec<u32>,
    /// The tree over the visible ones; empty where the driver builds its own.
    pub top: Tree,
    /// Lights.
    pub lights: Vec<GpuLight>,
    /// The scene's moving instances, by number, with their transforms to the world.
    pub places: Vec<(u32, DAffine3)>,
}

impl Stage {
    /// Takes up a scene whose geometry is laid out; with `trees` it will build one over the
    /// instances.
    pub fn new(gathered: &Gathered<'_>, geometry: &Geometry, origin: DVec3, trees: bool) -> Self {
        let scene = &gathered.scene;
        let mut actors = Vec::with_capacity(scene.instances.len());
        let mut actor_of = HashMap::new();
        let mut light_count = 0;
        for (number, instance) in scene.instances.iter().enumerate() {
            let place = geometry.meshes[instance.mesh as usize];
            let parts = &scene.meshes[instance.mesh as usize].parts;
            let id = gathered.instance_ids[number];
            // A gathered mesh is many of the scene's instances, none of which moves.
            if gathered.part_ids[instance.mesh as usize].is_empty() {
                actor_of.insert(id, number);
            }
            actors.push(Actor {
                object_to_world: instance.object_to_world,
                mesh: place,
                fixed: GpuInstance {
                    object_to_world: [Vec3::ZERO; 4],
                    world_to_object: [Vec3::ZERO; 4],
                    first_triangle: place.first_triangle,
                    first_normal: place.first_normal,
                    first_part: place.first_part,
                    root_node: place.root_node,
                    material: parts.first().map_or(0, |p| p.material),
                    first_light: if place.lights > 0 { light_count } else { NONE },
                    id,
                },
            });
            light_count += place.lights;
        }
        Self {
            origin,
            most_depth: u32::MAX,
            actors,
            actor_of,
            lamps: lights::lamp_triangles(scene, &gathered.lamps),
            materials: scene.materials.clone(),
            trees,
        }
    }

    /// Lets no tree over the instances have more levels; a balanced one must fit.
    pub fn limit_depth(&mut self, levels: u32) {
        self.most_depth = levels;
    }

    /// Everything in a pose; what that leaves out stands where it does in the scene.
    ///
    /// # Errors
    /// An instance further away than can be rendered.
    pub fn standing(&self, time: f64, pose: Pose) -> Result<Standing> {
        let mut to_world: Vec<DAffine3> = self.actors.iter().map(|a| a.object_to_world).collect();
        for (number, place) in &pose.instances {
            let Some(&index) = self.actor_of.get(number) else {
                continue;
            };
            let (min, max) = self.actors[index].mesh.bounds;
            let bounds = Bounds {
                min: min.as_dvec3(),
                max: max.as_dvec3(),
            };
            let moved = self.relative(place, index);
            check_place(*number, &moved, Some(&bounds), time)?;
            to_world[index] = *place;
        }
        let mut materials = self.materials.clone();
        for (material, emission) in pose.emission {
            materials[material as usize].emission = emission;
        }
        let triangles: Vec<LightTriangle> = (self.lamps.iter())
            .map(|lamp| lamp.placed(&to_world[lamp.instance as usize]))
            .collect();

        let mut instances = Vec::with_capacity(to_world.len());
        let (mut visible, mut boxes) = (Vec::new(), Vec::new());
        for (index, (actor, place)) in self.actors.iter().zip(&to_world).enumerate() {
            let object_to_world = self.relative(place, index);
            let mut instance = actor.fixed;
            if !is_flat(&object_to_world) {
                instance.object_to_world = columns(object_to_world);
                instance.world_to_object = columns(object_to_world.inverse());
                visible.push(index as u32);
                boxes.push(world_box(&object_to_world, &actor.mesh));
            }
            instances.push(instance);
        }
        if !self.trees {
            boxes.clear();
        }
        Ok(Standing {
            time,
            instances,
            visible,
            top: Tree::over_boxes_within(&boxes, self.most_depth),
            lights: place_lights(&triangles, &materials, self.origin),
            places: pose.instances,
        })
    }

    /// A transform to the world as the device has it: from where the mesh was moved to, to where
    /// the origin is zero.
    fn relative(&self, object_to_world: &DAffine3, actor: usize) -> DAffine3 {
        DAffine3::from_translation(-self.origin)
            * *object_to_world
            * DAffine3::from_translation(self.actors[actor].mesh.centre)
    }

    /// For each of the scene's `count` instances, how its points go from `now` to `before`.
    pub fn carries(&self, count: usize, now: &Standing, before: &Standing) -> Vec<GpuCarry> {
        let mut carries = vec![carry(DAffine3::IDENTITY); count];
        for ((number, now), (_, before)) in now.places.iter().zip(&before.places) {
            let back = if is_flat(now) {
                DAffine3::ZERO
            } else {
                DAffine3::from_translation(-self.origin)
                    * *before
                    * now.inverse()
                    * DAffine3::from_translation(self.origin)
            };
            carries[*number as usize] = carry(back);
        }
        carries
    }
}

fn carry(now_to_before: DAffine3) -> GpuCarry {
    GpuCarry {
        now_to_before: columns(now_to_before),
    }
}

fn columns(transform: DAffine3) -> [Vec3; 4] {
    [
        transform.matrix3.x_axis,
        transform.matrix3.y_axis,
        transform.matrix3.z_axis,
        transform.translation,
    ]
    .map(|column| column.as_vec3())
}

/// The box of a placed mesh, grown by what rounding a ray into object space can move it.
fn world_box(object_to_world: &DAffine3, place: &MeshPlace) -> (Vec3, Vec3) {
    let (low, high) = (place.bounds.0.as_dvec3(), place.bounds.1.as_dvec3());
    let mut world = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        let p = object_to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
        world = (world.0.min(p), world.1.max(p));
    }
    let reach = world.0.abs().max(world.1.abs()).max_element();
    let pad = DVec3::splat(reach * 1e-6);
    ((world.0 - pad).as_vec3(), (world.1 + pad).as_vec3())
}

/// The lights of a scene as it stands, with `origin` moved to zero, as shaders pick them.
pub fn gpu_lights(scene: &Scene, origin: DVec3) -> Vec<GpuLight> {
    place_lights(&lights::light_triangles(scene), &scene.materials, origin)
}

fn place_lights(
    triangles: &[LightTriangle],
    materials: &[Material],
    origin: DVec3,
) -> Vec<GpuLight> {
    let weights: Vec<f64> = triangles
        .iter()
        .map(|light| lights::power(light, &materials[light.material as usize]))
        .collect();
    let table = AliasTable::new(&weights, UNIFORM_SHARE);
    triangles
        .iter()
        .enumerate()
        .map(|(number, light)| {
            let material = &materials[light.material as usize];
            let [a, b, c] = light.corners;
            GpuLight {
                corner: (a - origin).as_vec3(),
                edge1: (b - a).as_vec3(),
                edge2: (c - a).as_vec3(),
                normal: light.normal.as_vec3(),
                emission: material.emission,
                area: light.area as f32,
                probability: table.probabilities[number] as f32,
                double_sided: material.double_sided.into(),
                keep_below: table.columns[number].keep_below,
                alias: table.columns[number].alias,
            }
        })
        .collect()
}

/// Mean luminance of lights, weighted by the power that they send to one side; 0 without any.
pub fn lamp_luminance(lights: &[GpuLight]) -> f32 {
    let (mut power, mut weighted) = (0.0, 0.0);
    for light in lights {
        let luminance = lights::luminance(light.emission);
        power += f64::from(light.area) * luminance;
        weighted += f64::from(light.area) * luminance * luminance;
    }
    if power > 0.0 {
        (weighted / power) as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_count_by_their_power() {
        let light = |area: f32, brightness: f32| GpuLight {
            area,
            emission: Vec3::splat(brightness),
            ..bytemuck::Zeroable::zeroed()
        };
        let mean = lamp_luminance(&[light(1.0, 1.0), light(3.0, 5.0)]);
        assert!((mean - 4.75).abs() < 1e-6, "{mean}");
        assert_eq!(lamp_luminance(&[]), 0.0);
    }
}
