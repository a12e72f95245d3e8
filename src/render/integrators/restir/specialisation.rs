//! The specialisation constants whose values follow from the settings of reservoir resampling.

use super::reservoir_layout::ReservoirLayout;
use crate::device_scene::GpuScene;
use crate::render::settings::{Arrays, Candidates, Order, Resampling};
use crate::shader_interface::{PixelOrder, Specialisation};

/// A copy of the specialisation constants `base` in which the constants for the layout of reservoirs in memory have the
/// values of `layout`. With these constants, shaders compute where a reservoir is in its buffer, and how it is encoded.
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

/// A copy of the specialisation constants `base` in which the constants that depend on `resampling` (the settings of direct
/// or of indirect light) have the values of these settings. They select the code that is compiled. Rare lights are far
/// dimmer than the other lights, and with some settings separate candidates are drawn from them. The code for these
/// candidates costs time, so it is selected only if `scene` has rare lights.
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
