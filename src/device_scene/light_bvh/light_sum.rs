//! The sums over the lights of a node, from which its boxes, its power and its normal follow.

use super::NearLight;
use glam::{DVec3, Vec3};

/// A box (min, max) that contains no point. Its union with another box is that other box. It is the box of influence of
/// lights without power, which a walk therefore does not find.
const NOWHERE: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// The sums over some lights, from which a node's box, power and normal follow: the box around the lights (`low` to `high`,
/// in the device's world space), their total power, and the sum of their normals. The sums of a parent node are those of its
/// two children together.
#[derive(Clone, Copy)]
pub(super) struct LightSum {
    /// The smallest x, y and z of the box around the lights, in the device's world space.
    pub low: Vec3,
    /// The largest x, y and z of the box around the lights, in the device's world space.
    pub high: Vec3,
    /// The sum of the lights' powers ([`NearLight::power`]), in the device's units of radiance × squared
    /// length. The radius of the box of influence is in proportion to its square root.
    pub power: f64,
    /// The sum of the lights' normals in world space, each multiplied by the power of its light. Lights that emit into all
    /// directions add zero. Divided by `power`, the sum is the mean normal of the node, whose length is at most 1. Shaders
    /// estimate from it how much of its light the node sends towards a point.
    pub normal: DVec3,
}

impl LightSum {
    /// The sums over no light: a box that contains no point, and the power 0. Every sum over lights starts
    /// from this value.
    pub const NOTHING: Self = Self {
        low: NOWHERE.0,
        high: NOWHERE.1,
        power: 0.0,
        normal: DVec3::ZERO,
    };

    /// Computes the sums over `lights`: the box around them, their power, and their weighted normals. A leaf
    /// of the light BVH is made from them.
    pub fn of<'a>(lights: impl Iterator<Item = &'a NearLight>) -> Self {
        lights.fold(Self::NOTHING, |sum, light| {
            sum.and(&Self {
                low: light.low,
                high: light.high,
                power: light.power,
                normal: light.power * light.normal.as_dvec3(),
            })
        })
    }

    /// The sums over these lights and those of `other` together. A parent node gets its sums from its two
    /// children in this way.
    pub fn and(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            power: self.power + other.power,
            normal: self.normal + other.normal,
        }
    }

    /// The box of influence (min, max) of these lights, outside of which they contribute little: the box around them,
    /// enlarged by `scale` · √power on each side. If they have no power, it contains no point.
    pub fn influence(&self, scale: f32) -> (Vec3, Vec3) {
        if self.power == 0.0 {
            return NOWHERE;
        }
        let radius = Vec3::splat(Self::radius(self.power, scale));
        (self.low - radius, self.high + radius)
    }

    /// The distance, `scale` · √`power` in the device's unit of length, by which the box of influence extends beyond lights
    /// with this total power.
    pub fn radius(power: f64, scale: f32) -> f32 {
        scale * power.sqrt() as f32
    }

    /// The box (min, max) of a node of a tree with the option [`cut`](super::LightBvhOptions::cut), in the
    /// device's world space: the box around the node's lights, enlarged on each side by `scale` times half
    /// its diagonal. If a walk searches the tree for a point inside this box, it continues with the node's
    /// children. Otherwise it skips the children, and treats all lights of the node as one light.
    pub fn surroundings(&self, scale: f32) -> (Vec3, Vec3) {
        let radius = Vec3::splat(scale * 0.5 * (self.high - self.low).length());
        (self.low - radius, self.high + radius)
    }
}
