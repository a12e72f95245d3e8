//! The specialisation constants whose values follow from the settings of reservoir resampling.

use super::reservoir_layout::ReservoirLayout;
use crate::device_scene::GpuScene;
use crate::render::settings::{Arrays, Candidates, Order, Resampling};
use crate::shader_interface::{PixelOrder, Specialisation};

/// A copy of the specialisation constants `base`, with those set that describe the layout of reservoirs in memory. Shaders
/// find and decode reservoirs by them.
pub fn with_layout(base: Specialisation, layout: &ReservoirLayout) -> Specialisation {
    let (pixel_order, swizzle) = match layout.settings.order {
        Order::Row => (PixelOrder::Row, 1),
        Order::Column => (PixelOrder::Column, 1),
        Order::Swizzle(side) => (PixelOrder::Swizzle, side),
    };
    Specialisation {
        reservoir_format: layout.settings.format,
        reservoir_soa: layout.settings.arrays == Arrays::Soa,
        pixel_order,
        swizzle,
        keeps_debug_words: layout.origins,
        ..base
    }
}

/// A copy of the specialisation constants `base`, with those set that select the code for the settings `resampling`, which
/// are those of direct or of indirect light. Rare lights are those of the dimmest emitters; with some settings, they are
/// drawn only by separate candidates. The code for these candidates is selected only if `scene` has rare lights, because it
/// costs time.
pub fn with_resampling(
    base: Specialisation,
    resampling: &Resampling,
    scene: &GpuScene,
) -> Specialisation {
    Specialisation {
        rare_lights: resampling.sets_rare_lights_apart() && scene.first_lights().has_rare(),
        mis: resampling.mis,
        visibility: resampling.visibility,
        light_bvh: resampling.candidates == Candidates::LightBvh,
        neighbours: resampling.most_neighbours(),
        ..base
    }
}
