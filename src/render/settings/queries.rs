//! Facts that follow from the settings alone, without a scene. For example, they decide if indirect light is rendered,
//! and if the picture is unbiased.

use super::{
    Candidates, DirectMode, Far, GridMode, IndirectMode, Integrator, LightChoice, Resampling,
    ReuseMode, Secondary, Settings, Shift, WorldMode,
};
use crate::device_scene::light_bvh::LightBvhOptions;
use crate::render::lighting::Lighting;
use crate::shader_interface::{HashGrid, Mis, Visibility, WorldReservoirs};

impl Settings {
    /// True if the picture shows light that surfaces scatter. `bounces` is the maximum number of scattering events of a
    /// path. If false, the picture shows only the light that emitters send directly to the camera, so scenes with only point
    /// lights are black.
    pub fn scatters_light(&self, bounces: u32) -> bool {
        let resamples = self.integrator == Integrator::Restir;
        let indirect = !(resamples && self.indirect.mode == IndirectMode::Off);
        let direct = self.direct.mode != DirectMode::Off;
        (bounces >= 1 && direct) || (bounces >= 2 && indirect)
    }

    /// True if pictures with these settings are unbiased: no setting has a value that the documentation of the settings
    /// calls biased, or this value has no effect. Always true for path tracing.
    pub fn is_unbiased(&self) -> bool {
        if self.integrator == Integrator::PathTracing {
            return true;
        }
        let is_merged_well = |resampling: &Resampling, visibilities: &[Visibility]| match resampling
            .reuse
        {
            ReuseMode::None => resampling.visibility != Visibility::None,
            _ => resampling.mis != Mis::Constant && visibilities.contains(&resampling.visibility),
        };
        let direct = is_merged_well(
            &self.direct.resampling,
            &[Visibility::Weights, Visibility::Final],
        );
        let indirect = self.indirect.mode != IndirectMode::Restir
            || is_merged_well(&self.indirect.resampling, &[Visibility::Weights])
                && self.indirect.shift == Shift::Unbiased;
        let world = self.world_reservoirs() != WorldReservoirs::Published;
        (direct || self.direct.mode != DirectMode::Restir)
            && indirect
            && world
            && self.hash_grid() != HashGrid::Points
    }

    /// A copy of these settings with which path tracing renders a reference for them, as the command `headwater reference`
    /// does. Settings that have no effect on path tracing are set to their defaults.
    pub fn of_path_tracing(&self) -> Self {
        Self {
            integrator: Integrator::PathTracing,
            heuristic: self.heuristic,
            energy: self.energy,
            roulette: self.roulette,
            environment: self.environment,
            direct: self.direct.of_path_tracing(),
            variant: self.variant,
            ..Self::default()
        }
    }

    /// True if resampling renders this kind of light. `bounces` is the maximum number of scattering events of a path:
    /// direct light needs at least 1, indirect light at least 2. The setting `integrator` has no effect on the result.
    pub fn renders(&self, lighting: Lighting, bounces: u32) -> bool {
        match lighting {
            Lighting::Direct => bounces > 0 && self.direct.mode != DirectMode::Off,
            Lighting::Indirect => bounces > 1 && self.indirect.mode != IndirectMode::Off,
        }
    }

    /// True if resampling stores samples of this kind of light in reservoirs: always for direct light (even if it is
    /// switched off), and only with `indirect.mode=restir` for indirect light.
    pub fn uses_reservoirs(&self, lighting: Lighting) -> bool {
        lighting == Lighting::Direct || self.indirect.mode == IndirectMode::Restir
    }

    /// True if frames have reservoirs of this kind of light. `bounces` is the maximum number of scattering events of a path.
    /// False for path tracing, for light that is not rendered, and for indirect light with `indirect.mode=path`.
    pub fn has_reservoirs(&self, lighting: Lighting, bounces: u32) -> bool {
        self.integrator == Integrator::Restir
            && self.renders(lighting, bounces)
            && self.uses_reservoirs(lighting)
    }

    /// True if resampling draws light candidates by the method `candidates`, for direct or for indirect light. `bounces` is
    /// the maximum number of scattering events of a path. False for path tracing.
    pub fn has_candidates(&self, candidates: Candidates, bounces: u32) -> bool {
        self.integrator == Integrator::Restir && self.drawing_from(candidates, bounces).count() > 0
    }

    /// The settings of resampling for each kind of light (direct, then indirect) that is rendered and whose candidates are
    /// drawn by the method `candidates`; none if no light uses this method. `bounces` is the maximum number of scattering
    /// events of a path.
    fn drawing_from(
        &self,
        candidates: Candidates,
        bounces: u32,
    ) -> impl Iterator<Item = &Resampling> {
        let kinds = [
            (Lighting::Direct, &self.direct.resampling),
            (Lighting::Indirect, &self.indirect.resampling),
        ];
        (kinds.into_iter())
            .filter(move |(lighting, resampling)| {
                self.renders(*lighting, bounces) && resampling.candidates == candidates
            })
            .map(|(_, resampling)| resampling)
    }

    /// The options with which the light BVH (a tree of lights) is built; `None` if no candidates are drawn from it. Rare
    /// lights (the dimmest ones) are left out of the tree if each kind of light (direct or indirect) that draws from the
    /// tree has separate candidates for rare lights. `bounces` is the maximum number of scattering events of a path.
    pub fn light_bvh_options(&self, bounces: u32) -> Option<LightBvhOptions> {
        let settings = &self.light_bvh;
        self.has_candidates(Candidates::LightBvh, bounces)
            .then(|| LightBvhOptions {
                scale: settings.scale.number(),
                cut: settings.far == Far::Joined,
                clusters: settings.cluster,
                by_power: settings.choice == LightChoice::Contribution,
                leaves_out_rare: (self.drawing_from(Candidates::LightBvh, bounces))
                    .all(Resampling::sets_rare_lights_apart),
            })
    }

    /// True if candidates of direct light come from light lists: one pixel of each tile draws a list of lights from the
    /// light BVH, and pixels near the tile draw from the list. False if each pixel walks through the tree itself, or if
    /// candidates do not come from the tree.
    pub fn has_light_lists(&self) -> bool {
        self.direct.mode == DirectMode::Restir
            && self.direct.resampling.candidates == Candidates::LightBvh
            && self.light_bvh.tile > 1
    }

    /// The points for which the hash grid (reservoirs of direct light in cells of space) makes its reservoirs: surfaces of
    /// pixels, or points on all surfaces of the scene. [`HashGrid::None`] unless `direct.candidates=hash-grid`.
    pub fn hash_grid(&self) -> HashGrid {
        match (self.direct.resampling.candidates, self.hash_grid.mode) {
            (Candidates::HashGrid, GridMode::Unbiased) => HashGrid::Pixels,
            (Candidates::HashGrid, GridMode::Published) => HashGrid::Points,
            _ => HashGrid::None,
        }
    }

    /// The way in which path vertices reuse light samples of vertices of the previous frame. [`WorldReservoirs::None`]
    /// unless `indirect.secondary=world-reservoirs`.
    pub fn world_reservoirs(&self) -> WorldReservoirs {
        match (self.indirect.secondary, self.world_reservoirs.mode) {
            (Secondary::WorldReservoirs, WorldMode::Unbiased) => WorldReservoirs::Unbiased,
            (Secondary::WorldReservoirs, WorldMode::Published) => WorldReservoirs::Published,
            _ => WorldReservoirs::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Among the presets, only `s1` is biased. A biased value of a single setting makes another preset biased, unless the
    /// setting has no effect there.
    #[test]
    fn biased_settings_are_known() {
        for preset in crate::render::presets::PRESETS {
            let settings = preset.settings().unwrap();
            assert_eq!(
                settings.is_unbiased(),
                preset.name != "s1",
                "{}",
                preset.name
            );
        }
        let balanced = crate::render::presets::Preset::named("balanced").unwrap();
        let with = |changes: &[&str]| {
            let settings = balanced.settings().unwrap();
            let change = |settings: Settings, change: &&str| {
                settings
                    .with(&Settings::parse_change(change).unwrap())
                    .unwrap()
            };
            changes.iter().fold(settings, change).is_unbiased()
        };
        for change in [
            "direct.mis=constant",
            "direct.visibility=initial",
            "indirect.visibility=final",
            "indirect.shift=biased",
        ] {
            assert!(!with(&[change]), "{change}");
        }
        assert!(with(&["direct.visibility=final"]));
        assert!(with(&["direct.mis=constant", "direct.reuse=none"]));
        assert!(with(&["indirect.shift=biased", "indirect.mode=path"]));
        assert!(with(&["direct.mis=constant", "integrator=path-tracing"]));
    }

    /// The light BVH must contain the rare lights (the dimmest ones) if direct or indirect light draws candidates from the
    /// tree but has no separate candidates for rare lights.
    #[test]
    fn rare_lights_are_left_out_only_if_all_set_them_apart() {
        let mut settings = Settings {
            integrator: Integrator::Restir,
            ..Settings::default()
        };
        for resampling in [
            &mut settings.direct.resampling,
            &mut settings.indirect.resampling,
        ] {
            resampling.candidates = Candidates::LightBvh;
            resampling.visibility = Visibility::Weights;
        }
        assert!(settings.light_bvh_options(2).unwrap().leaves_out_rare);
        settings.direct.resampling.rare_lights = 0.0;
        assert!(!settings.light_bvh_options(2).unwrap().leaves_out_rare);
        settings.direct.resampling.candidates = Candidates::Power;
        assert!(settings.light_bvh_options(2).unwrap().leaves_out_rare);
    }
}
