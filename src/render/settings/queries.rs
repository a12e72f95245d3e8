//! Values that follow from the settings alone, without a scene.

use super::{
    Candidates, DirectMode, Far, GridMode, IndirectMode, Integrator, LightChoice, Resampling,
    Secondary, Settings, WorldMode,
};
use crate::device_scene::light_bvh::LightBvhOptions;
use crate::render::lighting::Lighting;
use crate::shader_interface::{HashGrid, WorldReservoirs};

impl Settings {
    /// True if the picture shows light that surfaces scatter, for paths with at most `bounces` scattering events. If false,
    /// it shows only what emitters send directly to the camera.
    pub fn scatters_light(&self, bounces: u32) -> bool {
        let resamples = self.integrator == Integrator::Restir;
        let indirect = !(resamples && self.indirect.mode == IndirectMode::Off);
        let direct = self.direct.mode != DirectMode::Off;
        (bounces >= 1 && direct) || (bounces >= 2 && indirect)
    }

    /// The settings of a path-traced reference for these settings: settings without an effect on path tracing have their
    /// defaults.
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

    /// True if resampling computes this kind of light, for paths with at most `bounces` scattering events.
    pub fn renders(&self, lighting: Lighting, bounces: u32) -> bool {
        match lighting {
            Lighting::Direct => bounces > 0 && self.direct.mode != DirectMode::Off,
            Lighting::Indirect => bounces > 1 && self.indirect.mode != IndirectMode::Off,
        }
    }

    /// True if resampling stores candidates of this kind of light in reservoirs: always for direct light, and with
    /// `indirect.mode=restir` for indirect light.
    pub fn uses_reservoirs(&self, lighting: Lighting) -> bool {
        lighting == Lighting::Direct || self.indirect.mode == IndirectMode::Restir
    }

    /// True if frames have reservoirs of this kind of light, for paths with at most `bounces` scattering events. Path
    /// tracing has none.
    pub fn has_reservoirs(&self, lighting: Lighting, bounces: u32) -> bool {
        self.integrator == Integrator::Restir
            && self.renders(lighting, bounces)
            && self.uses_reservoirs(lighting)
    }

    /// True if resampling draws candidates of direct or of indirect light from the distribution `candidates`, for paths with
    /// at most `bounces` scattering events.
    pub fn has_candidates(&self, candidates: Candidates, bounces: u32) -> bool {
        self.integrator == Integrator::Restir && self.drawing_from(candidates, bounces).count() > 0
    }

    /// The settings of resampling of each kind of light whose candidates are drawn from `candidates`, direct light first.
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

    /// The options with which the light BVH is built; `None` if no candidates are drawn from it. The tree leaves out rare
    /// lights (the dimmest ones) if every kind of light that draws from the tree samples them separately.
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

    /// True if candidates of direct light come from light lists: one pixel of each tile draws lights from the light BVH for
    /// all pixels of the tile.
    pub fn has_light_lists(&self) -> bool {
        self.direct.mode == DirectMode::Restir
            && self.direct.resampling.candidates == Candidates::LightBvh
            && self.light_bvh.tile > 1
    }

    /// The surfaces for which the reservoirs of the hash grid are made: those of pixels, or points on all surfaces of the
    /// scene. [`HashGrid::None`] unless `direct.candidates=hash-grid`.
    pub fn hash_grid(&self) -> HashGrid {
        match (self.direct.resampling.candidates, self.hash_grid.mode) {
            (Candidates::HashGrid, GridMode::Unbiased) => HashGrid::Pixels,
            (Candidates::HashGrid, GridMode::Published) => HashGrid::Points,
            _ => HashGrid::None,
        }
    }

    /// The way in which path vertices reuse light samples of other vertices; [`WorldReservoirs::None`] unless
    /// `indirect.secondary=world-reservoirs`.
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
    use crate::shader_interface::Visibility;

    /// The light BVH must contain the rare lights (the dimmest ones) if direct or indirect light draws candidates from it
    /// and has no separate candidates for them.
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
