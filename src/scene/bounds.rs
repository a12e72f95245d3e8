//! Bounding boxes of meshes, instances and scenes, and the typical size of instances, from which the unit of length on the
//! device is chosen.

use super::{Instance, Mesh, Scene};
use glam::{DAffine3, DVec3};

/// An axis-aligned box. A box around a mesh is in the mesh's object space; a box around instances or a scene is in world
/// space, in scene units.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bounds {
    /// The smallest x, the smallest y and the smallest z of all points in the box: its lower corner.
    pub min: DVec3,
    /// The largest x, the largest y and the largest z of all points in the box: its upper corner.
    pub max: DVec3,
}

impl Bounds {
    /// The midpoint of the box, in the space of the box.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The lengths of the box along x, y and z, in the units of its space.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners of the box. Bit 0 of a corner's index is 0 if its x is that of [`Self::min`], and 1
    /// if it is that of [`Self::max`]. In the same way, bit 1 stands for y, and bit 2 for z.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + use<> {
        let (min, max) = (self.min, self.max);
        (0..8).map(move |i| {
            DVec3::new(
                if i & 1 == 0 { min.x } else { max.x },
                if i & 2 == 0 { min.y } else { max.y },
                if i & 4 == 0 { min.z } else { max.z },
            )
        })
    }

    /// The axis-aligned box around the eight corners of this box after `transform`. It contains the transformed contents of
    /// this box, but can be larger than the smallest box around them.
    pub(super) fn placed(&self, transform: &DAffine3) -> Self {
        let corners = self
            .corners()
            .map(|corner| transform.transform_point3(corner));
        Self::of(corners).unwrap_or(*self)
    }

    /// The smallest box that contains all `boxes`, which must be in one space; `None` if there are no boxes.
    pub fn around(boxes: impl Iterator<Item = Self>) -> Option<Self> {
        Self::of(boxes.flat_map(|bounds| [bounds.min, bounds.max]))
    }

    /// The smallest box that contains all `points`, in the space of the points; `None` if there are no
    /// points.
    pub fn of(points: impl Iterator<Item = DVec3>) -> Option<Self> {
        points.fold(None, |bounds: Option<Self>, point| {
            Some(match bounds {
                None => Self {
                    min: point,
                    max: point,
                },
                Some(bounds) => Self {
                    min: bounds.min.min(point),
                    max: bounds.max.max(point),
                },
            })
        })
    }
}

/// The maximum number of vertices, summed over instances, that `Scene::bounds` examines. For instances after this limit it
/// uses looser boxes, because exact boxes of very many instances of large meshes would take minutes.
const MOST_VERTICES: usize = 1 << 30;

/// Six functions, for the directions +X, +Y, +Z, −X, −Y and −Z, that return how far a box reaches in this direction: the
/// signed distance, in scene units, from the origin to the face of the box on that side. `Scene::bounds` sorts instances by
/// this distance, so that it examines only those that may enlarge the scene's box.
const REACHES: [fn(&Bounds) -> f64; 6] = [
    |bounds| bounds.max.x,
    |bounds| bounds.max.y,
    |bounds| bounds.max.z,
    |bounds| -bounds.min.x,
    |bounds| -bounds.min.y,
    |bounds| -bounds.min.z,
];

impl Mesh {
    /// The smallest box around the positions of the mesh, in object space; `None` for a mesh without positions.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.positions.iter().map(|p| p.as_dvec3()))
    }
}

impl Scene {
    /// The box around all instances, in world space, for cameras that show the whole scene and for reports; `None` if no
    /// instance has vertices. It is the smallest such box, unless more than 2³⁰ vertices would have to be examined. Then it
    /// can be larger.
    pub fn bounds(&self) -> Option<Bounds> {
        let boxes: Vec<Option<Bounds>> = self.meshes.iter().map(Mesh::bounds).collect();
        // Rounded transforms grow with each coordinate too, so no vertex comes to lie outside of the box around the corners.
        let placed = self.instances.iter().filter_map(|instance| {
            let mesh = boxes[instance.mesh as usize]?;
            Some((mesh.placed(&instance.object_to_world), instance))
        });
        let mut placed: Vec<(Bounds, &Instance)> = placed.collect();
        let mut bounds: Option<Bounds> = None;
        let mut vertices = 0;
        for reach in REACHES {
            // Instances that may reach farthest come first. An instance within the known box cannot enlarge
            // it, so its vertices are not examined.
            placed.sort_by(|(a, _), (b, _)| reach(b).total_cmp(&reach(a)));
            for (own, instance) in &mut placed {
                if bounds.is_some_and(|known| reach(own) <= reach(&known)) {
                    break;
                }
                vertices += self.meshes[instance.mesh as usize].positions.len();
                if vertices <= MOST_VERTICES {
                    *own = self.instance_bounds(instance).unwrap_or(*own);
                }
                bounds = Bounds::around(bounds.into_iter().chain([*own]));
            }
        }
        bounds
    }

    /// Points whose convex hull contains the whole scene, in world space, for the choice of a camera: the vertices of all
    /// instances or, if these are more than 2³⁰, the corners of the box around the scene.
    pub fn outline(&self) -> Box<dyn Iterator<Item = DVec3> + '_> {
        let mesh_of = |instance: &Instance| &self.meshes[instance.mesh as usize];
        let vertices = self.instances.iter().map(|i| mesh_of(i).positions.len());
        if vertices.sum::<usize>() > MOST_VERTICES {
            return Box::new(
                self.bounds()
                    .into_iter()
                    .flat_map(|bounds| bounds.corners()),
            );
        }
        Box::new(self.instances.iter().flat_map(move |instance| {
            let place = instance.object_to_world;
            let positions = mesh_of(instance).positions.iter();
            positions.map(move |position| place.transform_point3(position.as_dvec3()))
        }))
    }

    /// A box around each instance, in world space: the transformed box of the instance's mesh, enlarged until
    /// it is axis-aligned. The limits of a scene are checked, and the device's units are chosen, with these
    /// boxes. They are fast to compute, but can be larger than necessary. The boxes are in the order of the
    /// instances, but an instance of a mesh without positions has no box.
    pub fn loose_boxes(&self) -> Vec<Bounds> {
        let bounds: Vec<Option<Bounds>> = self.meshes.iter().map(Mesh::bounds).collect();
        self.placed_boxes(&bounds)
    }

    /// A box around each instance, in world space, as [`Scene::loose_boxes`] returns it, for callers that have already
    /// computed the boxes of the meshes. `of_meshes` lists the box of each mesh in object space, or `None` for a mesh
    /// without positions.
    pub(super) fn placed_boxes(&self, of_meshes: &[Option<Bounds>]) -> Vec<Bounds> {
        let of_instance = |instance: &Instance| {
            Some(of_meshes[instance.mesh as usize]?.placed(&instance.object_to_world))
        };
        self.instances.iter().filter_map(of_instance).collect()
    }

    fn instance_bounds(&self, instance: &Instance) -> Option<Bounds> {
        let mesh = &self.meshes[instance.mesh as usize];
        Bounds::of(
            mesh.positions
                .iter()
                .map(|p| instance.object_to_world.transform_point3(p.as_dvec3())),
        )
    }
}

/// The typical size of `boxes`, in scene units: the geometric mean of their longest edges, approximated by a power of two.
/// Boxes without an extent do not count; if no box has an extent, the result is 1. The result becomes the unit of length on
/// the device. Unlike the size of the whole scene, it hardly changes if one instance is huge, such as a ground of a thousand
/// kilometres.
pub fn usual_size(boxes: &[Bounds]) -> f64 {
    let sizes = boxes.iter().map(|bounds| bounds.size().max_element());
    let sizes = sizes.filter(|size| *size > 0.0);
    // Of integers, so that a scene that is twice as large has exactly twice the size.
    let (count, sum) = sizes.fold((0, 0), |(count, sum), size| {
        (count + 1, sum + exponent(size))
    });
    if count == 0 {
        1.0
    } else {
        2.0_f64.powi(sum.div_euclid(count) as i32)
    }
}

/// The exponent e of the largest power 2ᵉ that is not above `number`, which must be positive and normal; the device's units
/// are such powers. The exponent is read from the bits of the number. So twice the number always has an exponent that is
/// higher by exactly 1, which the rounding of a computed logarithm would not guarantee.
pub fn exponent(number: f64) -> i64 {
    (number.to_bits() >> 52) as i64 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;
    use glam::Vec3;

    #[test]
    fn boxes_follow_the_instances() {
        let mut scene = Scene {
            meshes: vec![Mesh {
                positions: vec![Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)],
                ..Mesh::default()
            }],
            ..Scene::default()
        };
        assert_eq!(scene.bounds(), None);
        for x in [-1.0, 2.0] {
            scene.instances.push(Instance {
                name: String::new(),
                mesh: 0,
                object_to_world: DAffine3::from_scale(DVec3::new(x, 1.0, 1.0)),
            });
        }
        let bounds = scene.bounds().unwrap();
        assert_eq!(bounds.min, DVec3::new(-1.0, 0.0, 0.0));
        assert_eq!(bounds.max, DVec3::new(2.0, 2.0, 3.0));
        assert_eq!(bounds.center(), DVec3::new(0.5, 1.0, 1.5));
        assert_eq!(bounds.size(), DVec3::new(3.0, 2.0, 3.0));
        assert_eq!(bounds.corners().count(), 8);
    }

    #[test]
    fn boxes_of_many_turned_instances_are_tight() {
        let mut random = Random::new(1);
        let mut unit = || f64::from(random.unit());
        let mut scene = Scene::default();
        for _ in 0..3 {
            let positions = (0..50).map(|_| DVec3::new(unit(), unit(), unit()).as_vec3());
            scene.meshes.push(Mesh {
                positions: positions.collect(),
                ..Mesh::default()
            });
        }
        for i in 0..300 {
            scene.instances.push(Instance {
                name: String::new(),
                mesh: i % 3,
                object_to_world: DAffine3::from_axis_angle(DVec3::Y, 6.0 * unit())
                    * DAffine3::from_translation(DVec3::new(unit(), unit(), unit())),
            });
        }
        let of_each = scene.instances.iter();
        let of_each = of_each.filter_map(|instance| scene.instance_bounds(instance));
        assert_eq!(scene.bounds(), Bounds::around(of_each));
    }

    #[test]
    fn instances_in_a_row_need_no_look_at_all_their_vertices() {
        let mut scene = Scene::default();
        scene.meshes.push(Mesh {
            positions: vec![Vec3::ONE; 20_000],
            ..Mesh::default()
        });
        for x in 0..1_000_000 {
            scene.instances.push(Instance {
                name: String::new(),
                mesh: 0,
                object_to_world: DAffine3::from_translation(DVec3::X * f64::from(x)),
            });
        }
        // By a look at each it would take minutes.
        assert_eq!(scene.bounds().unwrap().max.x, 1e6);
    }
}
