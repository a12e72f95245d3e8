//! The choice of light candidates that `candidates=auto` makes from the scene.

use super::Settings;
use super::settings::{Candidates, DirectMode, Integrator};
use crate::tracing::GpuScene;
use std::collections::HashSet;

/// The number of lights from which on the light BVH is used. Below it, some of a pixel's candidates by power are lights that
/// matter, and walks through the tree would cost time for nothing.
const MANY_LIGHTS: usize = 64;

impl Settings {
    /// The settings for a scene: where direct light has `candidates=auto`, what fits its lights. Distant lights do not count,
    /// since the light BVH lacks them. Indirect light keeps `power`: what a walk at each vertex of a path saves is not measured.
    pub fn for_scene(&self, scene: &GpuScene) -> Self {
        let mut settings = self.clone();
        let draws = self.integrator == Integrator::Restir && self.direct.mode == DirectMode::Restir;
        let candidates = &mut settings.direct.resampling.candidates;
        if draws && *candidates == Candidates::Auto {
            let lights = scene.first_lights();
            let triangles = lights.triangles.len();
            let others = (triangles..lights.choices.len())
                .filter(|index| !lights.is_distant(*index))
                .count();
            // Triangles with common corners are one lamp.
            let lamps: HashSet<_> = scene.light_groups.iter().collect();
            let (fitting, reason) = fitting(triangles + others, lamps.len() + others);
            *candidates = fitting;
            log::info!("candidates of direct light: {reason}");
        }
        settings
    }
}

/// What fits so many lights that form so many lamps, and why.
fn fitting(lights: usize, lamps: usize) -> (Candidates, String) {
    if lights < MANY_LIGHTS {
        let reason =
            format!("by power, since there are fewer than {MANY_LIGHTS} lights ({lights})");
        (Candidates::Power, reason)
    } else if lamps < 2 {
        // In `atrium:lights=1` candidates from the light BVH have 1.05 times the clamped error in the first frames.
        let reason = format!("by power, since all lights ({lights}) form one lamp");
        (Candidates::Power, reason)
    } else {
        let reason = format!("from the light BVH, since there are many lights ({lights})");
        (Candidates::LightBvh, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_lights_and_one_lamp_are_selected_by_power_and_many_from_the_light_bvh() {
        assert_eq!(fitting(0, 0).0, Candidates::Power);
        assert_eq!(
            fitting(MANY_LIGHTS - 1, MANY_LIGHTS - 1).0,
            Candidates::Power
        );
        assert_eq!(fitting(10_000, 1).0, Candidates::Power);
        assert_eq!(fitting(MANY_LIGHTS, 2).0, Candidates::LightBvh);
    }
}
