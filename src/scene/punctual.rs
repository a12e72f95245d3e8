//! Punctual lights, which have no surface: points, spots and directional lights, as the glTF extension `KHR_lights_punctual`
//! defines them.

use glam::{DAffine3, DVec3, Vec3};

/// A point, spot or directional light. It has no surface that a ray could hit, so only light samples find it. In its own
/// space it shines along −Z, or in all directions if it is a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// Name of the file's node or light, for messages; possibly empty.
    pub name: String,
    /// Transform from the light's own space to world space, in scene units. Its scale has no effect.
    pub light_to_world: DAffine3,
    /// The kind of light: a point, a spot with its angles, or a directional light.
    pub shape: PunctualShape,
    /// Linear RGB radiant intensity in W/sr, at least 0. For a directional light it is instead the irradiance of a surface
    /// that faces the light, in W/m².
    pub intensity: Vec3,
    /// The distance in scene units, above 0, at which the light of a point or spot has faded to 0; `None` if the light has
    /// no such limit.
    pub range: Option<f64>,
}

/// The kind of a punctual light: where its light starts, and into which directions it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualShape {
    /// The light shines from one point, with the same intensity in all directions.
    Point,
    /// The light shines from one point into a cone around −Z of the light's own space. Directions up to the angle `inner`
    /// from this axis have the full intensity, which fades to 0 at the angle `outer`.
    Spot {
        /// Half angle of the inner cone, in radians, in [0, `outer`]. Directions in this cone have the full
        /// intensity.
        inner: f64,
        /// Half angle of the whole cone, in radians, above 0 and at most π/2. At this angle, the intensity
        /// has faded to 0.
        outer: f64,
    },
    /// The light comes from infinitely far away, such as sunlight, and all its rays have the same direction.
    Directional,
}

#[cfg(test)]
impl PunctualLight {
    /// A white point light for tests, at the origin and without a range. `intensity` is its radiant intensity in every
    /// channel, in W/sr.
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
    /// The position of the light in world space, in scene units. A directional light is infinitely far away, so its position
    /// has no effect.
    pub fn position(&self) -> DVec3 {
        self.light_to_world.translation
    }

    /// The unit direction in world space in which the light shines: the −Z axis of the light's own space. If the light's
    /// transform scales that axis to 0, it is −Z of the world.
    pub fn direction(&self) -> DVec3 {
        let axis = self.light_to_world.matrix3 * DVec3::NEG_Z;
        // Scaled first: squares of lengths can leave the range of f64.
        let largest = axis.abs().max_element();
        (axis / largest).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// True if the light is directional, and so infinitely far away. Its position then has no effect, and its power depends
    /// on the size of the scene.
    pub fn is_distant(&self) -> bool {
        self.shape == PunctualShape::Directional
    }
}
