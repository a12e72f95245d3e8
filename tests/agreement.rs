//! Pictures of different drivers agree. The test leaves its driver's pictures in the folder that
//! `HEADWATER_PICTURES` names, as `tools/test --all` does, and compares them with those that other
//! drivers left there.

mod support;

use headwater::image::Image;
use headwater::metrics::error::Errors;
use headwater::render::View;
use headwater::render::presets::Preset;
use headwater::scene::procedural;
use std::path::Path;

/// Presets, and how many frames each adds up.
const PRESETS: [(&str, u32); 2] = [("path-tracing", 16), ("accurate", 2)];
/// A pixel agrees when each channel does to this part of the larger value.
const NEAR: f32 = 1e-3;
/// The part of the pixels that need not agree: where rounding turns a choice, a path goes elsewhere.
/// SwiftShader and lavapipe differ in .4 % of the night city's, and in .07 % elsewhere.
const MOST_APART: f64 = 0.03;
/// What those pixels may change of the whole picture's mean.
const MOST_MEAN: f64 = 1e-3;

fn picture(name: &str, preset: &str, frames: u32) -> (Image, String) {
    let scene = procedural::generate(name, &[]).unwrap();
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 160,
        height: 90,
        seed: 11,
        bounces: 3,
        jitter: false,
    };
    let (device, selection) = support::open_device(None);
    let origin = view.camera.camera_to_world.translation;
    let settings = Preset::named(preset).unwrap().settings().unwrap();
    let variant = selection.variant;
    let sums = support::sums(&device, &scene, origin, variant, &view, &settings, frames);
    let mut image = Image::new(view.width, view.height);
    let means = sums.iter().map(|p| p.mean(frames).as_vec3().to_array());
    image.set_vectors("", ["R", "G", "B"], &means.collect::<Vec<_>>());
    support::assert_no_messages(&device);
    (image, device.info.driver.clone())
}

#[test]
fn drivers_make_the_same_pictures_but_for_rounding() {
    let Some(folder) = std::env::var_os("HEADWATER_PICTURES") else {
        return;
    };
    let folder = Path::new(&folder);
    let scenes = ["cornell-glossy", "two-rooms", "night-city"];
    let pictures = scenes.map(|scene| PRESETS.map(|(preset, frames)| (scene, preset, frames)));
    for (scene, preset, frames) in pictures.concat() {
        let (image, driver) = picture(scene, preset, frames);
        let name = format!("{scene}, {preset}");
        let own = image.rgb().unwrap();
        let beginning = format!("{name} by ");
        let own_file = format!("{beginning}{}.exr", driver.replace('/', "-"));
        for entry in std::fs::read_dir(folder).unwrap() {
            let file = entry.unwrap().file_name().into_string().unwrap();
            if !file.starts_with(&beginning) || file == own_file {
                continue;
            }
            let other = Image::read(&folder.join(&file)).unwrap().rgb().unwrap();
            let near = |a: f32, b: f32| (a - b).abs() <= NEAR * a.max(b);
            let agrees =
                |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).all(|(a, b)| near(*a, *b));
            let agree = own.iter().zip(&other).filter(agrees).count();
            let apart = 1.0 - agree as f64 / own.len() as f64;
            let ratio = Errors::between(&own, &other).mean_ratio;
            println!("{name}, {driver} and {file}: {apart:.4} apart, mean {ratio:.5}");
            assert!(
                apart <= MOST_APART,
                "{name}, {driver} and {file}: {apart} apart"
            );
            assert!(
                (ratio - 1.0).abs() <= MOST_MEAN,
                "{name}, {driver} and {file}: {ratio}"
            );
        }
        image.write(&folder.join(&own_file), 0.0).unwrap();
    }
}
