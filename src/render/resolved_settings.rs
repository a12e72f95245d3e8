//! Settings in which all choices that depend on the scene are made: the light candidates with `candidates=auto`, and the
//! use of world reservoirs (the reservoirs of path vertices).

use super::light_samplers::SamplerSettings;
use super::lighting::Lighting;
use super::settings::{Candidates, Integrator, LightBvhSettings, Resampling, Secondary, Settings};
use super::world_reservoirs::WorldSize;
use crate::device_scene::GpuScene;
use crate::device_scene::light_bvh::LightBvhOptions;
use crate::device_scene::lights::Lights;
use crate::shader_interface::WorldReservoirs;
use std::cell::LazyCell;
use std::collections::HashSet;
use std::ops::Deref;

/// The minimum number of lights with which `candidates=auto` selects the light BVH (a tree of lights). If there are fewer
/// lights, those that add much light at the pixel are drawn often enough by power alone, so walks through the tree would
/// cost time without benefit.
const MANY_LIGHTS: usize = 64;

/// The settings for one scene and one maximum number of bounces. With resampling, choices that the user leaves to the scene,
/// such as `candidates=auto`, are replaced by definite values for all light that is rendered. The passes and buffers of a
/// renderer are made from these settings.
#[derive(Clone, Debug)]
pub struct ResolvedSettings {
    settings: Settings,
    /// The maximum number of scattering events of a path, which decides whether there is direct and indirect light.
    bounces: u32,
}

impl Deref for ResolvedSettings {
    type Target = Settings;

    fn deref(&self) -> &Settings {
        &self.settings
    }
}

impl ResolvedSettings {
    /// The settings for a scene and for paths with at most `bounces` scattering events. `candidates=auto` becomes
    /// `light-bvh` or `power` for each kind of light that is rendered. World reservoirs (the reservoirs of path vertices)
    /// are switched off in scenes with fewer than `world_reservoirs.min_lights` lights, or with a single emitter group
    /// (emissive triangles with common corners). If `min_lights` is 0, they are never switched off. With path tracing, the
    /// settings stay as they are.
    pub fn new(settings: &Settings, scene: &GpuScene, bounces: u32) -> Self {
        let mut resolved = Self {
            settings: settings.clone(),
            bounces,
        };
        if settings.integrator == Integrator::Restir {
            resolved.decide(scene);
        }
        resolved
    }

    fn decide(&mut self, scene: &GpuScene) {
        // A scene can have hundreds of thousands of lights, so they are counted only if a setting needs it, and at most
        // once in each of two ways: with rare lights, and without.
        let counts = [false, true].map(|apart| {
            LazyCell::new(move || count(scene.first_lights(), &scene.light_groups, apart))
        });
        let counts =
            |resampling: &Resampling| *counts[usize::from(resampling.sets_rare_lights_apart())];
        let renders = [Lighting::Direct, Lighting::Indirect].map(|lighting| self.renders(lighting));
        let settings = &mut self.settings;
        for (lighting, renders, resampling) in [
            (
                Lighting::Direct,
                renders[0],
                &mut settings.direct.resampling,
            ),
            (
                Lighting::Indirect,
                renders[1],
                &mut settings.indirect.resampling,
            ),
        ] {
            if renders && resampling.candidates == Candidates::Auto {
                let (lights, emitter_groups) = counts(resampling);
                let (fitting, reason) = fitting(lights, emitter_groups);
                resampling.candidates = fitting;
                log::info!("candidates of {} light: {reason}", lighting.name());
            }
        }
        let min_lights = settings.world_reservoirs.min_lights as usize;
        if renders[1] && settings.indirect.secondary == Secondary::WorldReservoirs && min_lights > 0
        {
            let (lights, emitter_groups) = counts(&settings.indirect.resampling);
            if lights < min_lights || emitter_groups < 2 {
                settings.indirect.secondary = Secondary::Ris;
            }
        }
    }

    /// True if resampling renders this kind of light: the settings do not switch it off, and the maximum number of
    /// bounces is large enough for it. Otherwise it has no passes and buffers. The setting `integrator` has no effect on
    /// the result.
    pub fn renders(&self, lighting: Lighting) -> bool {
        self.settings.renders(lighting, self.bounces)
    }

    /// The options with which the light BVH (a tree of lights) is built; `None` if no candidates are drawn from it.
    pub fn light_bvh_options(&self) -> Option<LightBvhOptions> {
        self.settings.light_bvh_options(self.bounces)
    }

    /// The settings of the light BVH (a tree of lights) if pixels draw candidates of direct light from light lists;
    /// otherwise `None`. In each frame, one pixel of each tile of pixels draws the list of the tile from the light BVH.
    pub fn light_lists(&self) -> Option<&LightBvhSettings> {
        self.has_light_lists().then_some(&self.light_bvh)
    }

    /// The settings from which light samplers (the methods that draw lights for candidates of direct light) make their
    /// buffers; `None` if direct light is not rendered.
    pub fn light_samplers(&self) -> Option<SamplerSettings<'_>> {
        self.renders(Lighting::Direct).then(|| SamplerSettings {
            light_lists: self.light_lists(),
            filled_by: self.hash_grid(),
            hash_grid: &self.hash_grid,
            light_samples: self.direct.resampling.light_samples,
        })
    }

    /// The number of world reservoirs (the reservoirs of path vertices) and the size of the table that finds them, from
    /// which the sizes of their buffers follow. `slots` is the number of pixels of the picture, rounded up so that it fills
    /// whole tiles of `reservoirs.order`. There are no world reservoirs if the settings do not use them, or if indirect
    /// light is not rendered.
    pub fn world_size(&self, slots: u64) -> WorldSize {
        let is_used =
            self.world_reservoirs() != WorldReservoirs::None && self.renders(Lighting::Indirect);
        WorldSize::new(&self.world_reservoirs, is_used, self.bounces, slots)
    }
}

/// The number of lights, and the number of emitter groups that they form. They decide `candidates=auto`, and whether there
/// are world reservoirs. Emissive triangles with common corners form one group (`groups` lists the index of the group of
/// each emissive triangle), and each other light is a group of its own. Infinitely distant lights do not count, since the
/// light BVH does not contain them. If `sets_rare_apart` is true, rare lights (the dimmest ones) do not count either,
/// because they have separate candidates.
fn count(lights: &Lights, groups: &[u32], sets_rare_apart: bool) -> (usize, usize) {
    let counts =
        |index: &usize| !(lights.is_distant(*index) || sets_rare_apart && lights.is_rare(*index));
    let triangles = lights.triangles.len();
    let own: Vec<usize> = (0..triangles).filter(counts).collect();
    let others = (triangles..lights.choices.len()).filter(counts).count();
    let emitter_groups: HashSet<_> = own.iter().map(|index| groups[*index]).collect();
    (own.len() + others, emitter_groups.len() + others)
}

/// The method that `candidates=auto` selects in a scene with `lights` lights that form `emitter_groups` groups (see
/// [`count`]), and the reason as text for the log.
fn fitting(lights: usize, emitter_groups: usize) -> (Candidates, String) {
    if lights < MANY_LIGHTS {
        let reason =
            format!("by power, since there are fewer than {MANY_LIGHTS} lights ({lights})");
        (Candidates::Power, reason)
    } else if emitter_groups < 2 {
        // In `atrium:lights=1` candidates from the light BVH have 1.12 times the clamped error in the first frame.
        let reason = format!("by power, since all lights ({lights}) form one emitter group");
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
    fn few_lights_and_one_emitter_group_are_selected_by_power_and_many_from_the_light_bvh() {
        assert_eq!(fitting(0, 0).0, Candidates::Power);
        assert_eq!(
            fitting(MANY_LIGHTS - 1, MANY_LIGHTS - 1).0,
            Candidates::Power
        );
        assert_eq!(fitting(10_000, 1).0, Candidates::Power);
        assert_eq!(fitting(MANY_LIGHTS, 2).0, Candidates::LightBvh);
    }
}
