//! Pictures of different drivers agree, and so do those of different shader variants on one driver. The test
//! leaves its driver's pictures in the folder that `HEADWATER_PICTURES` names, as `tools/test --all` does, and
//! compares them with those that other drivers left there, of which there are `HEADWATER_DRIVERS_BEFORE`.

mod support;

use headwater::image::Image;
use headwater::metrics::error::Errors;
use headwater::procedural;
use headwater::render::View;
use headwater::render::presets::Preset;
use headwater::scene::Environment;
use headwater::shader_interface::{Fetch, GeometryAccess, Textures, Tracer, Variant};

/// The scenes; with the other largest ones all are taken with every preset, and otherwise [`FEW`].
const SCENES: [&str; 4] = ["cornell-glossy", "two-rooms", "night-city", "conservatory"];
/// The sky over the last of them, which has textures, alpha and every other kind of light.
const SKY: &str = "sky:sun=35,width=64";
/// Presets, and the number of frames or samples of each.
const PRESETS: [(&str, u32); 2] = [("path-tracing", 16), ("accurate", 2)];
/// A pixel agrees if each channel does to this part of the larger value.
const NEAR: f32 = 1e-3;
/// The share of pixels that may differ: where rounding changes a choice, a path goes elsewhere. SwiftShader and
/// lavapipe differ in .4 % of the pixels of `night-city`, and in .07 % of the others.
const MAX_APART: f64 = 0.03;
/// The relative difference of the means that these pixels may cause.
const MAX_MEAN: f64 = 1e-3;
/// The scene and the preset of each picture without `--all`. Compiling shaders takes most of the time: those of `accurate` for the last scene, which has all kinds of lights and
/// surfaces, take lavapipe five minutes.
const FEW: [(&str, (&str, u32)); 2] =
    [("conservatory", PRESETS[0]), ("cornell-glossy", PRESETS[1])];
/// The variant that needs least of a driver; what the rule chooses is usually another.
const PLAIN: Variant = Variant {
    tracer: Tracer::ComputeBvh,
    geometry: GeometryAccess::StorageBuffers,
    fetch: Fetch::Words,
    textures: Textures::Buffer,
};

/// A picture of `variant` or else of what the rule chooses, and the driver.
fn picture(name: &str, preset: &str, frames: u32, variant: Option<Variant>) -> (Image, String) {
    let mut scene = procedural::generate(name, &[]).unwrap();
    scene.environment = (name == "conservatory").then(|| Environment::open(SKY).unwrap());
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 160,
        height: 90,
        seed: 11,
        bounces: 3,
        jitter: false,
    };
    let (device, selection) = support::open_device(variant);
    let origin = view.camera.camera_to_world.translation;
    let settings = Preset::named(preset).unwrap().settings().unwrap();
    let variant = selection.variant;
    let sums = support::sums(&device, &scene, origin, variant, &view, &settings, frames);
    let mut image = Image::new(view.width, view.height);
    let means = sums.mean(frames);
    let means = means.iter().map(|p| p.as_vec3().to_array());
    image.set_vectors("", ["R", "G", "B"], &means.collect::<Vec<_>>());
    support::assert_no_messages(&device);
    (image, device.info.driver.clone())
}

fn assert_agree(own: &[[f32; 3]], other: &[[f32; 3]], what: &str) {
    let near = |a: f32, b: f32| (a - b).abs() <= NEAR * a.max(b);
    let agrees = |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).all(|(a, b)| near(*a, *b));
    let agree = own.iter().zip(other).filter(agrees).count();
    let apart = 1.0 - agree as f64 / own.len() as f64;
    let ratio = Errors::between(own, other).mean_ratio;
    println!("{what}: {apart:.4} apart, mean {ratio:.5}");
    assert!(apart <= MAX_APART, "{what}: {apart} apart");
    assert!((ratio - 1.0).abs() <= MAX_MEAN, "{what}: {ratio}");
}

mod thorough {
    use super::*;

    #[test]
    fn pictures_agree_except_for_rounding() {
        let (folder, drivers_before) = support::other_drivers();
        let (mut of_variants, mut of_drivers) = (0, 0);
        let is_plain = support::open_device(None).1.variant == PLAIN;
        let all = SCENES
            .iter()
            .flat_map(|scene| PRESETS.map(|preset| (*scene, preset)));
        let pictures = if support::takes_largest() {
            all.collect()
        } else {
            FEW.to_vec()
        };
        let each = pictures.len();
        for (scene, (preset, frames)) in pictures {
            // At the same time, since one thread compiles the shaders of a picture.
            let plain = (!is_plain)
                .then(|| std::thread::spawn(move || picture(scene, preset, frames, Some(PLAIN))));
            let (image, driver) = picture(scene, preset, frames, None);
            let own = image.rgb().unwrap();
            let name = format!("{scene}, {preset}");
            if let Some(plain) = plain {
                let plain = plain.join().unwrap().0.rgb().unwrap();
                assert_agree(&own, &plain, &format!("{name}, {driver}, plain variant"));
                of_variants += 1;
            }
            let Some(folder) = folder.as_deref() else {
                continue;
            };
            let beginning = format!("{name} by ");
            // Numbered, since two drivers may have one name.
            let driver_file = driver.replace('/', "-");
            let file_of_driver = format!("{beginning}{drivers_before} {driver_file}.exr");
            for entry in std::fs::read_dir(folder).unwrap() {
                let file = entry.unwrap().file_name().into_string().unwrap();
                if !file.starts_with(&beginning) || file == file_of_driver {
                    continue;
                }
                let other = Image::read(&folder.join(&file)).unwrap().rgb().unwrap();
                assert_agree(&own, &other, &format!("{name}, {driver} and {file}"));
                of_drivers += 1;
            }
            image.write(&folder.join(&file_of_driver), 0.0).unwrap();
        }
        println!(
            "compared {of_variants} pictures with the plain variant, {of_drivers} with other drivers"
        );
        // Where the rule chooses the plain variant there is no other to compare it with.
        assert_eq!(of_variants, if is_plain { 0 } else { each });
        assert_eq!(
            of_drivers,
            drivers_before * each,
            "HEADWATER_DRIVERS_BEFORE is {drivers_before}"
        );
    }
}
