//! The values of the specialisation constants. The declarations are in `shader_interface/specialisation.rs`.

use crate::device_scene::GpuScene;
use crate::render::reservoir_layout::ReservoirLayout;
use crate::render::settings::{
    Arrays, Candidates, Energy, IndirectMode, Order, Resampling, Settings, Shift, Variant,
};
use crate::shader_interface::{PixelOrder, Specialisation};

/// The values that scene and settings decide, for all passes.
pub fn of_scene(scene: &GpuScene, settings: &Settings) -> Specialisation {
    let (full, requires) = (settings.variant == Variant::Full, &scene.requirements);
    Specialisation {
        has_specular: full || requires.specular,
        has_smooth_normals: full || requires.smooth_normals,
        has_textures: full || requires.textures,
        has_emissive_textures: full || requires.emissive_textures,
        has_alpha: full || requires.alpha,
        // It asks for more rays.
        has_blend: requires.blending,
        has_normal_maps: full || requires.normal_maps,
        has_unlit: full || requires.unlit,
        has_environment: full || requires.environment,
        has_punctual_lights: full || requires.punctual_lights > 0,
        has_vertex_colors: full || requires.vertex_colors,
        // Not in motion, where a point keeps its weights while the plane changes.
        has_large_triangles: requires.large_triangles && !scene.moves(),
        has_double_sided_lights: full || requires.double_sided_emitters,
        stack_size: scene.stack_size,
        moves: scene.moves(),
        previous_root: scene.previous_root(),
        energy_compensated: settings.energy == Energy::Compensated,
        shares: settings.indirect.mode == IndirectMode::Restir,
        biased_shift: settings.indirect.shift == Shift::Biased,
        ..Specialisation::default()
    }
}

/// `base` with the layout of reservoirs.
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

/// `base` with the way in which one kind of light is resampled in a scene.
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
