//! The choice of light candidates that `candidates=auto` makes from the scene.

use super::Settings;
use super::settings::{Candidates, DirectMode, Integrator};
use crate::tracing::GpuScene;
use crate::tracing::lights::Lights;
use std::collections::HashSet;

/// The number of lights from which on the light BVH is used. Below it, some of a pixel's candidates by power are lights that
/// matter, and walks through the tree would cost time for nothing.
const MANY_LIGHTS: usize = 64;

impl Settings {
    /// The settings for a scene: where direct light has `candidates=auto`, what fits its lights. Indirect light keeps `power`,
    /// since a walk at each vertex of a path takes longer than it saves.
    pub fn for_scene(&self, scene: &GpuScene) -> Self {
        let mut settings = self.clone();
        let draws = self.integrator == Integrator::Restir && self.direct.mode == DirectMode::Restir;
        let candidates = &mut settings.direct.resampling.candidates;
        if draws && *candidates == Candidates::Auto {
            let lights = scene.first_lights();
            let (fitting, reason) = fitting(near_light_count(lights), lamp_count(scene, lights));
            *candidates = fitting;
            log::info!("candidates of direct light: {reason}");
        }
        settings
    }
}

/// The number of lights that the light BVH can hold: those that are not infinitely far away.
fn near_light_count(lights: &Lights) -> usize {
    let all = 0..lights.choices.len();
    all.filter(|index| !lights.is_distant(*index)).count()
}

/// The number of these that are not parts of another: triangles with common corners are one lamp.
fn lamp_count(scene: &GpuScene, lights: &Lights) -> usize {
    let lamps: HashSet<u32> = scene.light_groups.iter().copied().collect();
    let others = lights.triangles.len()..lights.choices.len();
    lamps.len() + others.filter(|index| !lights.is_distant(*index)).count()
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
