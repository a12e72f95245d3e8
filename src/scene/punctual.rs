//! Punctual lights: without a surface, as `KHR_lights_punctual` has them.

use glam::{DAffine3, DVec3, Vec3};

/// A light without a surface. It shines along the −Z of its transform.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// Name of the node or light, possibly empty.
    pub name: String,
    /// Light to world; its scale has no effect.
    pub light_to_world: DAffine3,
    /// Point, spot or direction.
    pub shape: PunctualShape,
    /// Radiant intensity, ≥ 0; of a directional light the irradiance of a surface that faces it.
    pub intensity: Vec3,
    /// The distance from which on the light has no effect, in scene units; `None`: no limit.
    pub range: Option<f64>,
}

/// The shape of a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualShape {
    /// Equal intensity in all directions.
    Point,
    /// A cone around the axis: full intensity up to the angle `inner`, none beyond `outer`, both in radians.
    Spot {
        /// The inner angle, at least 0.
        inner: f64,
        /// The outer angle, above 0, at least `inner` and at most π/2.
        outer: f64,
    },
    /// Parallel, from infinitely far away.
    Directional,
}

#[cfg(test)]
impl PunctualLight {
    /// A white point at the origin.
    pub fn point(intensity: f32) -> Self {
        Self {
            name: String::new(),
            light_to_world: DAffine3::IDENTITY,
            shape: PunctualShape::Point,
            intensity: Vec3::splat(intensity),
            range: None,
        }
    }
}

impl PunctualLight {
    /// The position in the world.
    pub fn position(&self) -> DVec3 {
        self.light_to_world.translation
    }

    /// The unit direction in which it shines; −Z if its transform has no direction.
    pub fn direction(&self) -> DVec3 {
        let axis = self.light_to_world.matrix3 * DVec3::NEG_Z;
        // Scaled first: squares of lengths can leave the range of f64.
        let largest = axis.abs().max_element();
        (axis / largest).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// True if it is infinitely far away.
    pub fn is_distant(&self) -> bool {
        self.shape == PunctualShape::Directional
    }
}
