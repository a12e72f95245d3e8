//! Bounding boxes of meshes and scenes.

use super::{Instance, Mesh, Scene};
use glam::{DAffine3, DVec3};

/// An axis-aligned box in the world.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: DVec3,
    /// The largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The box's edge lengths.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The box's eight corners.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> {
        let (min, max) = (self.min, self.max);
        (0..8).map(move |i| {
            DVec3::new(
                if i & 1 == 0 { min.x } else { max.x },
                if i & 2 == 0 { min.y } else { max.y },
                if i & 4 == 0 { min.z } else { max.z },
            )
        })
    }

    /// A box around this one under a transform, which is not tight.
    fn placed(&self, transform: &DAffine3) -> Self {
        let corners = self
            .corners()
            .map(|corner| transform.transform_point3(corner));
        Self::of(corners).unwrap_or(*self)
    }

    /// True if another box lies inside; it may touch the edge.
    fn has_inside(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    /// The smallest box around some boxes; none if there are none.
    pub fn around(boxes: impl Iterator<Item = Self>) -> Option<Self> {
        Self::of(boxes.flat_map(|bounds| [bounds.min, bounds.max]))
    }

    /// The smallest box around some points; none if there are none.
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

impl Mesh {
    /// The box around the mesh's positions in object space.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.positions.iter().map(|p| p.as_dvec3()))
    }
}

impl Scene {
    /// The tight box around all instances; none if nothing is placed.
    pub fn bounds(&self) -> Option<Bounds> {
        let boxes: Vec<Option<Bounds>> = self.meshes.iter().map(Mesh::bounds).collect();
        let mut bounds: Option<Bounds> = None;
        for instance in &self.instances {
            // Most instances of a large mesh lie within what is known, and need no look at its vertices. Rounded
            // transforms grow with each coordinate too, so no vertex comes to lie outside of the box around the corners.
            let loose =
                boxes[instance.mesh as usize].map(|mesh| mesh.placed(&instance.object_to_world));
            let is_within = |known: Bounds| loose.is_some_and(|loose| known.has_inside(&loose));
            if !bounds.is_some_and(is_within) {
                let own = self.instance_bounds(instance);
                bounds = Bounds::around(bounds.into_iter().chain(own));
            }
        }
        bounds
    }

    /// For each instance a box around its mesh's box, which is fast to compute but not tight.
    pub fn loose_boxes(&self) -> Vec<Bounds> {
        let bounds: Vec<Option<Bounds>> = self.meshes.iter().map(Mesh::bounds).collect();
        let of_instance = |instance: &Instance| {
            Some(bounds[instance.mesh as usize]?.placed(&instance.object_to_world))
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

/// The geometric mean of the sizes of boxes, as a power of two; 1 without any. A ground of a thousand kilometres
/// hardly changes it, while it decides the size of the whole.
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

/// The exponent of the largest power of two that is not above a positive normal number. From its bits, because
/// a rounded logarithm of twice the number may not be larger by exactly 1.
pub fn exponent(number: f64) -> i64 {
    (number.to_bits() >> 52) as i64 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
