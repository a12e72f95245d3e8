//! Tests that resampling agrees with path tracing on features of materials that no generated scene has. Each scene is written
//! as glTF, and a study decides.

mod support;

use glam::{Affine2, DVec3, Vec2, Vec3};
use headwater::scene::layers::{Anisotropy, Coat};
use headwater::scene::{AlphaMode, Image, Layers, Material, Scene, Texture};
use headwater::scene_files::export;
use std::process::Command;
use support::{add, planted, quad, said, takes_largest};

/// Runs a study of two presets on a scene, with changed shaders: (file, text, replacement). Returns true if it proves that
/// both are unbiased, and its output.
fn study(scene: &Scene, bounces: u32, changes: &[(&str, &str, &str)]) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let [file, plan, shaders] = ["scene.glb", "plan.toml", "glsl"].map(|n| folder.path().join(n));
    export::write_glb(scene, &file).unwrap();
    let text = format!(
        r#"
scenes = ["{}"]
width = 40
frames = 3
seeds = 64
most_seeds = 512
bounces = {bounces}
reference_spp = 4096
[[configurations]]
name = "accurate"
preset = "accurate"
[[configurations]]
name = "fast"
preset = "fast"
"#,
        file.display()
    );
    std::fs::write(&plan, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args(["study", "--plan"]).arg(&plan);
    command.arg("-o").arg(folder.path().join("results"));
    // The validation layers keep something of every submission.
    command.env_remove("HEADWATER_VALIDATION");
    if !changes.is_empty() {
        planted(&shaders, changes);
        command.env("HEADWATER_GLSL", &shaders);
    }
    let output = command.output().unwrap();
    let said = said(&output);
    println!("{said}");
    (output.status.success() && !said.contains("undecided"), said)
}

/// Studies take minutes, so they run with `tools/test --all` only.
fn assert_unbiased(scene: &Scene, bounces: u32) {
    if !takes_largest() {
        return;
    }
    let (passes, said) = study(scene, bounces, &[]);
    assert!(passes, "{said}");
}

fn assert_biased(scene: &Scene, bounces: u32, fault: (&str, &str, &str)) {
    if !takes_largest() {
        return;
    }
    let (passes, said) = study(scene, bounces, &[fault]);
    assert!(!passes && said.contains("should be unbiased"), "{said}");
}

/// A black, glossy floor and a white wall behind it, in front of the camera, with texture coordinates from 0 to 1. The first
/// material is that of the floor.
fn room(floor: Material) -> Scene {
    let mut scene = Scene::default();
    let laid = |mesh: &mut headwater::scene::Mesh| {
        let positions = mesh.positions.iter();
        mesh.uvs[0] = positions.map(|p| Vec2::new(p.x, p.z) / 4.0 + 0.5).collect();
    };
    let tiles = quad(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    laid(add(&mut scene, &floor, &tiles));
    let wall = quad(Vec3::new(-2.0, 0.0, -2.0), Vec3::X * 4.0, Vec3::Y * 3.0);
    add(
        &mut scene,
        &Material::lambert("wall", Vec3::splat(0.7)),
        &wall,
    );
    let mut camera = support::look_at(
        DVec3::new(0.0, 2.0, 5.0),
        DVec3::new(0.0, 0.6, 0.0),
        DVec3::Y,
        0.8,
    );
    camera.aspect_ratio = Some(1.0);
    scene.cameras = vec![camera];
    scene
}

/// A floor that reflects by its specular lobe alone, whose strength and colour differ from tile to tile, under an emitter.
fn specular_floor() -> Scene {
    let texture = Texture {
        transform: Affine2::from_scale(Vec2::splat(3.0)),
        ..Texture::plain(0)
    };
    let mut scene = room(Material {
        base_color: Vec3::ZERO,
        metallic: 0.0,
        roughness: 0.35,
        specular_color: Vec3::splat(12.0),
        specular_texture: Some(texture),
        specular_color_texture: Some(texture),
        ..Material::default()
    });
    scene.images = vec![tiles()];
    add_lamp(&mut scene);
    scene
}

/// An image of sixteen texels that differ in all channels.
fn tiles() -> Image {
    let texels = (0..16_u32).map(|i| [i * 53 % 256, i * 91 % 256, 255 - i * 16, i * 117 % 256]);
    Image {
        name: "tiles".into(),
        width: 4,
        height: 4,
        texels: texels.map(|texel| texel.map(|value| value as u8)).collect(),
    }
}

/// Adds an emitter above the floor of [`room`].
fn add_lamp(scene: &mut Scene) {
    let lamp = Material {
        emission: Vec3::splat(8.0),
        ..Material::lambert("lamp", Vec3::ZERO)
    };
    let corner = Vec3::new(-0.7, 2.0, -0.9);
    add(scene, &lamp, &quad(corner, Vec3::X * 1.4, Vec3::Z * 0.8));
}

/// A copper floor with a normal map, under a coat with the normal of the mesh, whose strength and roughness differ from tile
/// to tile; under an emitter.
fn coated_floor() -> Scene {
    let texture = Texture {
        transform: Affine2::from_scale(Vec2::splat(3.0)),
        ..Texture::plain(0)
    };
    let coat = Coat {
        factor: 1.0,
        texture: Some(texture),
        roughness: 0.5,
        roughness_texture: Some(texture),
        ..Coat::default()
    };
    let mut scene = room(Material {
        base_color: Vec3::new(0.95, 0.64, 0.54),
        roughness: 0.5,
        normal_texture: Some(Texture {
            image: 1,
            ..texture
        }),
        layers: Layers {
            coat,
            ..Layers::default()
        },
        ..Material::default()
    });
    // Normals that lean to different sides.
    let texels = (0..16_u32).map(|i| [80 + i * 37 % 96, 80 + i * 59 % 96, 230, 255]);
    let bumps = Image {
        name: "bumps".into(),
        texels: texels.map(|texel| texel.map(|value| value as u8)).collect(),
        ..tiles()
    };
    scene.images = vec![tiles(), bumps];
    add_lamp(&mut scene);
    scene
}

/// A floor of brushed metal, whose direction and strength differ from tile to tile, under an emitter.
fn brushed_floor() -> Scene {
    let anisotropy = Anisotropy {
        strength: 1.0,
        rotation: 0.5,
        texture: Some(Texture {
            transform: Affine2::from_scale(Vec2::splat(3.0)),
            ..Texture::plain(0)
        }),
    };
    let mut scene = room(Material {
        base_color: Vec3::splat(0.8),
        roughness: 0.35,
        layers: Layers {
            anisotropy,
            ..Layers::default()
        },
        ..Material::default()
    });
    scene.images = vec![tiles()];
    add_lamp(&mut scene);
    scene
}

/// A glossy floor, under an emitter that covers four tenths and hides a part of a brighter one; with a mirror on the wall if
/// `has_mirror`.
fn blended_lamps(has_mirror: bool) -> Scene {
    let mut scene = room(Material {
        roughness: 0.3,
        base_color: Vec3::splat(0.6),
        ..Material::default()
    });
    if has_mirror {
        let mirror = Material {
            roughness: 0.0,
            ..Material::default()
        };
        let corner = Vec3::new(-1.5, 0.5, -1.9);
        add(
            &mut scene,
            &mirror,
            &quad(corner, Vec3::X * 1.2, Vec3::Y * 1.5),
        );
    }
    for (height, alpha, emission) in [(1.6, 0.4, 4.0), (2.2, 1.0, 8.0)] {
        let lamp = Material {
            alpha,
            alpha_mode: AlphaMode::Blend,
            emission: Vec3::splat(emission),
            double_sided: true,
            ..Material::lambert("lamp", Vec3::splat(0.5))
        };
        let corner = Vec3::new(-0.7, height, -0.9);
        add(
            &mut scene,
            &lamp,
            &quad(corner, Vec3::X * 1.4, Vec3::Z * 0.8),
        );
    }
    scene
}

mod thorough {
    use super::*;

    #[test]
    fn blended_emitters_are_unbiased() {
        assert_unbiased(&blended_lamps(false), 2);
    }

    /// Without indirect light, since what the mirror throws on the floor is found by chance only.
    #[test]
    fn blended_emitters_in_a_mirror_are_unbiased() {
        assert_unbiased(&blended_lamps(true), 1);
    }

    #[test]
    fn weights_that_count_rays_which_pass_emitters_are_found() {
        let fault = (
            "restir/samples/light_sample.glsl",
            "if (HAS_BLENDED_LIGHTS &&",
            "if (false &&",
        );
        assert_biased(&blended_lamps(false), 1, fault);
    }

    #[test]
    fn specular_textures_are_unbiased() {
        assert_unbiased(&specular_floor(), 2);
    }

    #[test]
    fn a_tint_that_is_stored_wrongly_is_found() {
        let fault = (
            "restir/sample_data.glsl",
            "TINT_STEPS, vec3(more.x)",
            "TINT_STEPS, vec3(0.0)",
        );
        assert_biased(&specular_floor(), 1, fault);
    }

    #[test]
    fn coats_are_unbiased() {
        assert_unbiased(&coated_floor(), 2);
    }

    #[test]
    fn a_coat_with_the_normal_of_its_base_is_found() {
        let fault = (
            "restir/sample_data.glsl",
            "layers.coat_normal = facing_viewer(layers.coat_normal, geometric_normal(data), true, direction);",
            "layers.coat_normal = shading_normal(data);",
        );
        assert_biased(&coated_floor(), 1, fault);
    }

    #[test]
    fn anisotropic_lobes_are_unbiased() {
        assert_unbiased(&brushed_floor(), 2);
    }

    /// The path tracer turns its frame by itself.
    #[test]
    fn a_frame_that_does_not_follow_the_direction_is_found() {
        let fault = (
            "scene/shading_point.glsl",
            "shading_frame(shading_normal, layers, shading_point.tangent, shading_point.bitangent);",
            "tangent_frame(shading_normal, shading_point.tangent, shading_point.bitangent);",
        );
        assert_biased(&brushed_floor(), 1, fault);
    }
}
