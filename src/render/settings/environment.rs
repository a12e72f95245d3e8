//! Settings of the environment.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The rotation and the brightness of the environment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentSettings {
    /// Rotation around the upward axis, counter-clockwise seen from above. Unit: degrees.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation: f64,
    /// Factor of the environment's radiance. Higher is brighter; 0 switches it off.
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
