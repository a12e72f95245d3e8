//! Settings of the environment (`environment.*`), the light that surrounds a scene at infinite distance.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The rotation and the brightness of the environment, the light that surrounds a scene at infinite distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentSettings {
    /// Rotation of the environment around the upward axis, counter-clockwise seen from above. Unit: degrees.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation: f64,
    /// Factor by which the environment's radiance is multiplied. Higher is brighter; 0 switches the environment off.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub intensity: f32,
}

impl Default for EnvironmentSettings {
    fn default() -> Self {
        Self {
            rotation: 0.0,
            intensity: 1.0,
        }
    }
}
