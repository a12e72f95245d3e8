//! Test that shaders with only the code that a scene requires render the same picture as shaders with all code.

mod support;

use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings::{Secondary, Variant};
use headwater::scene::requirements::Requirements;

mod largest {
    use super::*;

    /// Compares a scene that requires nothing optional, and a scene that requires everything. On software drivers both kinds
    /// of shaders must give the same bits.
    #[test]
    fn a_specialised_shader_renders_what_the_full_one_does() {
        let plain = procedural::generate("cornell", &[]).unwrap();
        let mut rich = procedural::generate("cornell-glossy", &[]).unwrap();
        for material in rich.materials.iter_mut().filter(|m| m.is_emissive()) {
            material.double_sided = true;
        }
        for (scene, has) in [(plain, false), (rich, true)] {
            let required = Requirements::of(&scene);
            assert_eq!(required.specular, has);
            assert_eq!(required.smooth_normals, has);
            assert_eq!(required.double_sided_emitters, has);
            for preset in ["accurate", "s1", "path-tracing"] {
                let mut settings = Preset::named(preset).unwrap().settings().unwrap();
                // `s1` has one light sample a vertex.
                if preset == "accurate" {
                    settings.indirect.secondary = Secondary::WorldReservoirs;
                    settings.world_reservoirs.min_lights = 0;
                }
                let specialised = support::frame_bits(&scene, &settings, None);
                settings.variant = Variant::Full;
                assert!(
                    specialised == support::frame_bits(&scene, &settings, None),
                    "{} {preset}",
                    scene.name
                );
                assert!(specialised.iter().any(|p| *p != [0; 3]));
            }
        }
    }
}
