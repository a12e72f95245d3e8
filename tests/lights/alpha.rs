//! Tests of surfaces with alpha: the light that passes them, and what the camera sees through them.

use crate::{
    ALBEDO, SEEDS, SIDE, TECHNIQUES, assert_seen, environment, floor, floor_point, from_above,
    image, picture, pictures, preset, punctual, support, total, totals,
};
use glam::{DVec3, Vec2, Vec3};
use headwater::procedural;
use headwater::render::View;
use headwater::scene::{AlphaMode, Material, PunctualShape, Scene, Texture};
use headwater::shader_interface::Tracer;
use std::f64::consts::PI;

/// Adds a square sheet at a height above the floor, parallel to it; `half` is half its side.
fn add_sheet(scene: &mut Scene, height: f32, half: f32, material: Material) {
    let corner = Vec3::new(-half, height, half);
    let sheet = support::quad(corner, Vec3::X * 2.0 * half, Vec3::NEG_Z * 2.0 * half);
    support::add(scene, &material, &sheet);
}

fn sheet(albedo: f32, alpha: f32) -> Material {
    Material {
        alpha,
        alpha_mode: AlphaMode::Blend,
        ..Material::lambert("sheet", Vec3::splat(albedo))
    }
}

/// The mean picture over several seeds, one RGB value per pixel, row by row; `None` if the device lacks the tracer.
fn mean_of_seeds(
    scene: &Scene,
    view: &View,
    technique: &str,
    tracer: Tracer,
    samples: u32,
) -> Option<Vec<[f64; 3]>> {
    let settings = preset(technique);
    let found = pictures(scene, view, &settings, tracer, samples / SEEDS, SEEDS)?;
    let of_pixel = |pixel: usize| {
        let sum: DVec3 = found.iter().map(|p| DVec3::from(p[pixel])).sum();
        (sum / f64::from(SEEDS)).to_array()
    };
    Some((0..found[0].len()).map(of_pixel).collect())
}

fn assert_mean(name: &str, found: &[[f64; 3]], expected: DVec3) {
    let found = total(found) / found.len() as f64;
    let off = found / expected.element_sum() - 1.0;
    println!("{name}: {:.3} %", 100.0 * off);
    assert!(off.abs() < 0.005, "{name}: {off}");
}

/// Asserts the mean of the picture that the camera above the floor sees, with each technique and `factor` times its samples.
fn assert_means_from_above(scene: &Scene, expected: DVec3, factor: u32) {
    let view = from_above(1, 3);
    for (technique, tracer, samples) in TECHNIQUES {
        if let Some(found) = mean_of_seeds(scene, &view, technique, tracer, factor * samples) {
            assert_mean(&format!("{technique} {tracer:?}"), &found, expected);
        }
    }
}

/// The camera looks down on a grey sheet: it must show the sheet by the fraction that it covers, and the floor by the rest.
#[test]
fn the_camera_sees_sheets_and_what_is_behind_them() {
    let (alpha, own) = (0.3_f64, 0.8_f64);
    let mut scene = floor();
    add_sheet(&mut scene, 2.0, 4000.0, sheet(own as f32, alpha as f32));
    scene.punctual_lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, -DVec3::Y)];
    // Through the centre of the picture goes the edge between the sheet's triangles, where it must not count twice.
    let light = scene.punctual_lights[0].intensity.as_dvec3() / PI;
    let expected = light * (alpha * own + (1.0 - alpha) * (1.0 - alpha) * ALBEDO);
    assert_means_from_above(&scene, expected, 2);
}

/// With `visibility=none` there are no shadows, even if a surface elsewhere has alpha mode blend.
#[test]
fn what_blends_brings_no_shadows_where_there_is_no_visibility() {
    let mut scene = floor();
    add_sheet(&mut scene, 6.0, 8.0, Material::lambert("lid", Vec3::ZERO));
    let mut blending = scene.clone();
    add_sheet(&mut blending, -1.0, 1.0, sheet(0.0, 0.5));
    let lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, -DVec3::Y)];
    let mut settings = preset("accurate");
    settings.direct.resampling.visibility = headwater::render::settings::Visibility::None;
    let [plain, found] = [scene, blending].map(|mut scene| {
        scene.punctual_lights = lights.clone();
        let view = from_above(1, 3);
        picture(&scene, &view, &settings, Tracer::ComputeBvh, 2).unwrap()
    });
    assert!(plain.iter().all(|pixel| pixel[0] > 0.0));
    assert_eq!(plain, found);
}

/// Adds an emitter that has holes everywhere except for one quarter at a corner. The emissive texture is black on half of
/// that quarter.
fn add_emitter(scene: &mut Scene, corner: Vec3, u: Vec3, v: Vec3) {
    let of_image = |image, nearest| Texture {
        nearest,
        ..Texture::plain(image)
    };
    let emitter = Material {
        emission: Vec3::new(4.0, 2.0, 1.0),
        emissive_texture: Some(of_image(1, true)),
        base_color_texture: Some(of_image(0, true)),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::lambert("lamp", Vec3::ZERO)
    };
    support::add(scene, &emitter, &support::quad(corner, u, v));
    scene.images = vec![
        image(|i| [255, 255, 255, if i % 8 < 4 && i / 8 < 4 { 255 } else { 90 }]),
        image(|i| if i / 8 < 2 { [255; 4] } else { [0, 0, 0, 255] }),
    ];
    let mesh = scene.meshes.last_mut().unwrap();
    let at = |p: &Vec3| Vec2::new((p - corner).dot(u), (p - corner).dot(v));
    let sides = Vec2::new(u.length_squared(), v.length_squared());
    mesh.uvs[0] = mesh.positions.iter().map(|p| at(p) / sides).collect();
    scene.validate().unwrap();
}

#[test]
fn light_from_the_holes_of_emitters_is_seen() {
    assert_seen(
        "alpha::thorough::emitters_may_have_holes",
        (
            "lights/kinds/triangle.glsl",
            "if (HAS_ALPHA && light.primitive != NONE)",
            "if (false)",
        ),
    );
}

#[test]
fn light_that_blended_emitters_do_not_have_is_seen() {
    assert_seen(
        "alpha::thorough::emitters_may_be_blended",
        (
            "lights/kinds/triangle.glsl",
            "if (HAS_ALPHA && light.primitive != NONE)",
            "if (false)",
        ),
    );
}

/// The mean, over the pixels, of what the floor reflects from the part of an emitter of [`add_emitter`] whose corner is at the
/// emitter's corner. The part is 1 unit deep and `width` units wide; `covers` gives the fraction of light that it emits at a
/// distance along the width.
fn lit_floor(corner: Vec3, width: usize, covers: impl Fn(f64) -> f64) -> DVec3 {
    const CELLS: usize = 64;
    let side = 1.0 / CELLS as f64;
    let of_pixel = |pixel: usize| {
        let cells = (0..width * CELLS * CELLS).map(|cell| {
            let x = (cell % (width * CELLS)) as f64 + 0.5;
            let y = (cell / (width * CELLS)) as f64 + 0.5;
            let point = corner.as_dvec3() + DVec3::new(x * side, 0.0, y * side);
            let toward = point - floor_point(pixel);
            covers(x * side) * toward.y.powi(2) / toward.length_squared().powi(2) * side * side
        });
        DVec3::new(4.0, 2.0, 1.0) * cells.sum::<f64>() * (ALBEDO / PI)
    };
    let sum: DVec3 = (0..SIDE as usize * SIDE as usize).map(of_pixel).sum();
    sum / f64::from(SIDE * SIDE)
}

/// The Cornell box with a block that covers half of the light, a block full of holes, and a sheet below the emitter.
fn box_with_alpha() -> Scene {
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    scene.images = vec![image(|i| {
        [255, 255, 255, if (i + i / 8) % 2 == 0 { 255 } else { 0 }]
    })];
    let own = |mesh: usize| scene.meshes[mesh].parts[0].material as usize;
    let blocks: Vec<usize> = scene
        .instances
        .iter()
        .rev()
        .take(2)
        .map(|i| i.mesh as usize)
        .collect();
    let originals = blocks
        .iter()
        .map(|mesh| scene.materials[own(*mesh)].clone());
    let mut made: Vec<Material> = originals.collect();
    made[0].alpha_mode = AlphaMode::Blend;
    made[0].alpha = 0.5;
    made[1].alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    made[1].base_color_texture = Some(Texture {
        nearest: true,
        ..Texture::plain(0)
    });
    for (mesh, material) in blocks.into_iter().zip(made) {
        let mesh = &mut scene.meshes[mesh];
        mesh.uvs[0] = mesh
            .positions
            .iter()
            .map(|p| Vec2::new(p.x + p.z, p.y) * 3.0)
            .collect();
        for part in &mut mesh.parts {
            part.material = scene.materials.len() as u32;
        }
        scene.materials.push(material);
    }
    let bounds = scene.bounds().unwrap();
    let height = bounds.min.lerp(bounds.max, 0.8);
    add_sheet(
        &mut scene,
        height.y as f32,
        0.25 * bounds.size().x as f32,
        sheet(0.7, 0.6),
    );
    scene.validate().unwrap();
    scene
}

mod thorough {
    use super::*;

    #[test]
    fn resampling_with_alpha_is_unbiased() {
        let scene = box_with_alpha();
        let all = support::takes_largest();
        let presets = [("accurate", 704), ("fast", 1024)];
        for (name, samples) in presets.into_iter().take(if all { 2 } else { 1 }) {
            let [off, sigma] = crate::bias(&scene, &preset(name), samples);
            println!("{name}: {:.3} ± {:.3} %", 100.0 * off, 100.0 * sigma);
            assert!(
                sigma < 0.002 && off.abs() < 0.001 + 3.1 * sigma,
                "{name}: {off} ± {sigma}"
            );
        }
    }

    #[test]
    fn both_tracers_render_alpha_to_the_same_mean() {
        let scene = box_with_alpha();
        let mean = |tracer| {
            // A little aside: through the centres of pixels some rays would meet edges, where two surfaces are equally near.
            let mut camera = scene.cameras[0].clone();
            camera.camera_to_world.translation += DVec3::new(0.013, 0.007, 0.0);
            let view = View {
                camera,
                ..from_above(3, 9)
            };
            totals(&scene, &view, &preset("path-tracing"), tracer, 2048)
        };
        let [Some(a), Some(b)] = [Tracer::ComputeBvh, Tracer::RayQuery].map(mean) else {
            return;
        };
        let difference = b.minus(&a);
        let [off, sigma] = [difference.mean, difference.standard_error].map(|x| x / a.mean);
        println!(
            "{:.3} ± {:.3} % of {SIDE}² pixels",
            100.0 * off,
            100.0 * sigma
        );
        assert!(off.abs() < 4.0 * sigma && sigma < 0.002, "{off} ± {sigma}");
    }

    #[test]
    fn candidates_that_alpha_stops_are_seen() {
        assert_seen(
            "alpha::thorough::sheets_weaken_what_passes_them",
            (
                "restir/passes/initial_direct.comp",
                "purpose == RAY_DELTA ? draw_alpha_random(random) : NO_ALPHA_RANDOM",
                "purpose == RAY_SHADOW ? NO_ALPHA_RANDOM : draw_alpha_random(random)",
            ),
        );
    }

    /// An emitter must light a floor by the part of it that has no hole and is not black, and by nothing else.
    #[test]
    fn emitters_may_have_holes() {
        let mut scene = floor();
        // From its front, which is below.
        let (corner, u, v) = (Vec3::new(-2.0, 5.0, -2.0), Vec3::X * 4.0, Vec3::Z * 4.0);
        add_emitter(&mut scene, corner, u, v);
        let expected = lit_floor(corner, 2, |_| 1.0);
        assert_means_from_above(&scene, expected, 1);
    }

    /// An emitter with alpha mode blend must light a floor by the part that it covers at each point.
    #[test]
    fn emitters_may_be_blended() {
        let mut scene = floor();
        let (corner, u, v) = (Vec3::new(-2.0, 5.0, -2.0), Vec3::X * 4.0, Vec3::Z * 4.0);
        add_emitter(&mut scene, corner, u, v);
        let emitter = scene.materials.last_mut().unwrap();
        (emitter.alpha, emitter.alpha_mode) = (0.5, AlphaMode::Blend);
        let expected = lit_floor(
            corner,
            4,
            |x| if x < 2.0 { 0.5 } else { 0.5 * 90.0 / 255.0 },
        );
        assert_means_from_above(&scene, expected, 1);
    }

    /// Two black sheets must weaken directional light equally at every pixel, and the light of an environment and of an
    /// emitter on average.
    #[test]
    fn sheets_weaken_what_passes_them() {
        let (covers, down) = ([0.4_f32, 0.25], DVec3::new(0.2, -1.0, 0.1));
        let passed: f64 = covers.iter().map(|alpha| 1.0 - f64::from(*alpha)).product();
        let mut covered = floor();
        for (height, alpha) in [6.0, 7.0].into_iter().zip(covers) {
            add_sheet(&mut covered, height, 4000.0, sheet(0.0, alpha));
        }
        let mut direct = covered.clone();
        direct.punctual_lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, down)];
        let cosine = -down.normalize().y;
        let expected =
            direct.punctual_lights[0].intensity.as_dvec3() * (passed * cosine * ALBEDO / PI);
        let mut sky = covered.clone();
        sky.environment = Some(environment(8, 4, |_, _| Vec3::new(1.0, 2.0, 0.5)));
        let of_sky = DVec3::new(1.0, 2.0, 0.5) * (passed * ALBEDO);
        for (technique, tracer, samples) in TECHNIQUES {
            if let Some(mean) = picture(&direct, &from_above(1, 3), &preset(technique), tracer, 2) {
                for found in mean {
                    let off = (DVec3::from_array(found) - expected).abs().max_element();
                    assert!(
                        off < 2e-4 * expected.x,
                        "{technique} {tracer:?}: {found:?} {expected}"
                    );
                }
            }
            if let Some(found) = mean_of_seeds(&sky, &from_above(1, 3), technique, tracer, samples)
            {
                assert_mean(&format!("sky, {technique} {tracer:?}"), &found, of_sky);
            }
        }
    }

    /// A sheet whose texture cuts out one half must cast half a shadow.
    #[test]
    fn a_mask_cuts_holes() {
        let mut scene = floor();
        let cut = Material {
            alpha: 0.8,
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            base_color_texture: Some(Texture {
                nearest: true,
                ..Texture::plain(0)
            }),
            ..Material::lambert("cut", Vec3::ZERO)
        };
        add_sheet(&mut scene, 6.0, 8.0, cut);
        // 0.8 × 140/255 is below the cutoff, 0.8 × 180/255 above it.
        scene.images = vec![image(|i| {
            [255, 255, 255, if i % 8 < 4 { 140 } else { 180 }]
        })];
        let sheet = scene.meshes.last_mut().unwrap();
        sheet.uvs[0] = (sheet.positions.iter())
            .map(|p| Vec2::new(p.x / 16.0 + 0.5, 0.5))
            .collect();
        scene.punctual_lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, -DVec3::Y)];
        scene.validate().unwrap();
        let light = scene.punctual_lights[0].intensity.as_dvec3() * (ALBEDO / PI);
        for (technique, tracer, samples) in TECHNIQUES {
            let Some(mean) =
                mean_of_seeds(&scene, &from_above(1, 3), technique, tracer, 4 * samples)
            else {
                continue;
            };
            let mut lit = Vec::new();
            for (pixel, found) in mean.iter().enumerate() {
                if floor_point(pixel).x < 0.0 {
                    lit.push(*found);
                } else {
                    assert_eq!(*found, [0.0; 3], "{technique} {tracer:?}, pixel {pixel}");
                }
            }
            // At the edge, resampling weighs pixels in light and in shadow against each other, which is noise.
            assert_mean(&format!("{technique} {tracer:?}"), &lit, light);
        }
    }

    /// A surface whose alpha equals the cutoff must be opaque, for every byte of a texture.
    #[test]
    fn a_mask_covers_at_its_cutoff() {
        let mut scene = floor();
        for byte in (1..=255_u8).step_by(2) {
            let material = Material {
                alpha_mode: AlphaMode::Mask {
                    cutoff: f32::from(byte) / 255.0,
                },
                base_color_texture: Some(Texture::plain(scene.images.len() as u32)),
                ..Material::lambert("cut", Vec3::ZERO)
            };
            scene.images.push(image(|_| [255, 255, 255, byte]));
            // One beside the other, all over the part of the floor that is seen.
            let corner = Vec3::new(f32::from(byte) / 64.0 - 2.0 - 1.0 / 64.0, 0.5, 2.0);
            let sheet = support::quad(corner, Vec3::X / 32.0, Vec3::NEG_Z * 4.0);
            support::add(&mut scene, &material, &sheet);
            let mesh = scene.meshes.last_mut().unwrap();
            mesh.uvs[0] = vec![Vec2::splat(0.5); mesh.positions.len()];
        }
        scene.punctual_lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, -DVec3::Y)];
        scene.validate().unwrap();
        for (technique, tracer, _) in TECHNIQUES {
            if let Some(mean) = picture(&scene, &from_above(1, 3), &preset(technique), tracer, 1) {
                let seen = mean.iter().filter(|found| **found != [0.0; 3]).count();
                assert_eq!(seen, 0, "{technique} {tracer:?}: pixels with holes");
            }
        }
    }

    /// A surface whose alpha is one step of f32 below the cutoff must be a hole.
    #[test]
    fn a_mask_is_a_hole_just_below_its_cutoff() {
        for (alpha, is_there) in [(0.5_f32, true), (0.5_f32.next_down(), false)] {
            let mut scene = floor();
            let sheet = Material {
                alpha,
                alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
                ..Material::lambert("sheet", Vec3::ZERO)
            };
            let corner = Vec3::new(-2.0, 0.5, 2.0);
            support::add(
                &mut scene,
                &sheet,
                &support::quad(corner, Vec3::X * 4.0, Vec3::NEG_Z * 4.0),
            );
            scene.punctual_lights =
                vec![punctual(PunctualShape::Directional, DVec3::ZERO, -DVec3::Y)];
            scene.validate().unwrap();
            for (technique, tracer, _) in TECHNIQUES {
                let Some(mean) = picture(&scene, &from_above(1, 3), &preset(technique), tracer, 1)
                else {
                    continue;
                };
                let lit = mean.iter().filter(|found| **found != [0.0; 3]).count();
                let expected = if is_there { 0 } else { mean.len() };
                assert_eq!(lit, expected, "{technique} {tracer:?}, alpha {alpha}");
            }
        }
    }

    /// The camera must see the emitter where it has no hole, and the scene behind it through its holes.
    #[test]
    fn the_camera_sees_through_the_holes_of_emitters() {
        let mut scene = floor();
        let (corner, u, v) = (Vec3::new(-0.5, 2.0, -0.5), Vec3::X, Vec3::Z);
        add_emitter(&mut scene, corner, u, v);
        // Its front, above, is what the camera sees.
        scene
            .instances
            .last_mut()
            .unwrap()
            .object_to_world
            .matrix3
            .y_axis = DVec3::NEG_Y;
        scene
            .instances
            .last_mut()
            .unwrap()
            .object_to_world
            .translation
            .y = 4.0;
        for (technique, tracer, _) in TECHNIQUES {
            let Some(mean) = picture(&scene, &from_above(1, 3), &preset(technique), tracer, 2)
            else {
                continue;
            };
            for (pixel, found) in mean.iter().enumerate() {
                // At half the distance of the floor.
                let at = floor_point(pixel) * 0.5;
                let is_lit = at.x < 0.0 && at.z < -0.25 && at.x > -0.5 && at.z > -0.5;
                let expected = if is_lit { [4.0, 2.0, 1.0] } else { [0.0; 3] };
                assert_eq!(*found, expected, "{technique} {tracer:?}, pixel {pixel}");
            }
        }
    }
}

mod largest {
    use super::*;

    #[test]
    fn a_sample_whose_own_light_is_not_weakened_is_seen() {
        assert_seen(
            "alpha::thorough::sheets_weaken_what_passes_them",
            (
                "restir/merge.glsl",
                "if (HAS_BLEND && visibility && shades) canonical_light",
                "if (false) canonical_light",
            ),
        );
    }

    #[test]
    fn alpha_that_is_missing_from_a_paths_density_is_seen() {
        assert_seen(
            "alpha::thorough::resampling_with_alpha_is_unbiased",
            (
                "restir/passes/initial_indirect.comp",
                "if (HAS_BLEND && target > 0.0) target *=",
                "if (false) target *=",
            ),
        );
    }
}
