//! What settings leave to the scene: light candidates with `candidates=auto`, and whether there are world
//! reservoirs.

use super::Settings;
use super::kind::Kind;
use super::settings::{Candidates, Integrator, Resampling, Secondary};
use crate::device_scene::GpuScene;
use crate::device_scene::lights::Lights;
use std::cell::LazyCell;
use std::collections::HashSet;

/// The number of lights from which on the light BVH is used. Below it, some of a pixel's candidates by power are lights that
/// matter, and walks through the tree would cost time for nothing.
const MANY_LIGHTS: usize = 64;

impl Settings {
    /// The settings for a scene, with at most `bounces` scattering events: with `candidates=auto` what fits its lights, and
    /// world reservoirs only with `world_reservoirs.min_lights`.
    pub fn for_scene(&self, scene: &GpuScene, bounces: u32) -> Self {
        let mut settings = self.clone();
        if self.integrator != Integrator::Restir {
            return settings;
        }
        // Hundreds of thousands of lights are counted only where something asks, and once: with rare lights, and without.
        let counts = [false, true].map(|apart| {
            LazyCell::new(move || count(scene.first_lights(), &scene.light_groups, apart))
        });
        let counts =
            |resampling: &Resampling| *counts[usize::from(resampling.sets_rare_lights_apart())];
        for (kind, resampling) in [
            (Kind::Direct, &mut settings.direct.resampling),
            (Kind::Indirect, &mut settings.indirect.resampling),
        ] {
            if kind.is_wanted(self, bounces) && resampling.candidates == Candidates::Auto {
                let (lights, lamps) = counts(resampling);
                let (fitting, reason) = fitting(lights, lamps);
                resampling.candidates = fitting;
                log::info!("candidates of {} light: {reason}", kind.name());
            }
        }
        let min_lights = self.world_reservoirs.min_lights as usize;
        if Kind::Indirect.is_wanted(self, bounces)
            && self.indirect.secondary == Secondary::WorldReservoirs
            && min_lights > 0
        {
            let (lights, lamps) = counts(&self.indirect.resampling);
            if lights < min_lights || lamps < 2 {
                settings.indirect.secondary = Secondary::Ris;
            }
        }
        settings
    }
}

/// Numbers of lights that are not distant, and of lamps that they form: triangles with common corners are one. Distant lights
/// do not count, since the light BVH lacks them, and any vertex finds them. Nor do rare lights where they are set apart, because
/// reservoirs do not hold them.
fn count(lights: &Lights, groups: &[u32], sets_rare_apart: bool) -> (usize, usize) {
    let counts =
        |index: &usize| !(lights.is_distant(*index) || sets_rare_apart && lights.is_rare(*index));
    let triangles = lights.triangles.len();
    let own: Vec<usize> = (0..triangles).filter(counts).collect();
    let others = (triangles..lights.choices.len()).filter(counts).count();
    let lamps: HashSet<_> = own.iter().map(|index| groups[*index]).collect();
    (own.len() + others, lamps.len() + others)
}

/// What fits so many lights that form so many lamps, and why.
fn fitting(lights: usize, lamps: usize) -> (Candidates, String) {
    if lights < MANY_LIGHTS {
        let reason =
            format!("by power, since there are fewer than {MANY_LIGHTS} lights ({lights})");
        (Candidates::Power, reason)
    } else if lamps < 2 {
        // In `atrium:lights=1` candidates from the light BVH have 1.12 times the clamped error in the first frame.
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
    use crate::device_scene::Units;
    use crate::device_scene::lights::gpu_lights;
    use crate::scene::{PunctualLight, Scene};

    #[test]
    fn rare_lights_that_are_set_apart_do_not_count() {
        let dim = vec![PunctualLight::point(1.0); 100];
        let scene = Scene {
            punctual_lights: [vec![PunctualLight::point(1e6); 2], dim].concat(),
            ..Scene::default()
        };
        let lights = gpu_lights(&scene, &Units::of(&scene, glam::DVec3::ZERO));
        assert_eq!(count(&lights, &[], true), (2, 2));
        assert_eq!(count(&lights, &[], false), (102, 102));
    }

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
