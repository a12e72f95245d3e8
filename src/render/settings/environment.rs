//! Settings of the environment (`environment.*`), the light that surrounds a scene at infinite distance.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the environment, the light that surrounds a scene at infinite distance: its rotation and its brightness. They
/// have no effect on scenes without an environment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentSettings {
    /// Rotation of the environment around the upward axis (+Y), counter-clockwise seen from above; 0 leaves it as in its
    /// file. Unit: degrees.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation: f64,
    /// Factor by which the environment's radiance is multiplied. 1 leaves the radiance as it is; higher is brighter; 0
    /// switches the environment off.
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
