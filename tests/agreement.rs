//! Pictures of different drivers must agree, and so must pictures of different shader variants on one driver. The test
//! writes the pictures of its driver to the folder that `HEADWATER_PICTURES` names (`tools/test --all` sets it), and
//! compares them with the pictures of the `HEADWATER_DRIVERS_BEFORE` drivers that ran earlier.

mod support;

use headwater::image::Image;
use headwater::metrics::error::Errors;
use headwater::procedural;
use headwater::render::View;
use headwater::render::presets::Preset;
use headwater::scene::Environment;
use headwater::shader_interface::{Fetch, GeometryAccess, Textures, Tracer, Variant};

/// Names of the generated scenes. With `--all`, each is rendered with every preset; otherwise only the pictures of [`FEW`]
/// are.
const SCENES: [&str; 4] = ["cornell-glossy", "two-rooms", "night-city", "conservatory"];
/// The environment of the scene `conservatory`, which also has textures, alpha and all other kinds of light.
const SKY: &str = "sky:sun=35,width=64";
/// Names of presets, each with the number of frames or samples of its pictures.
const PRESETS: [(&str, u32); 2] = [("path-tracing", 16), ("accurate", 2)];
/// The maximum difference, relative to the larger value, at which a channel of a pixel agrees.
const NEAR: f32 = 1e-3;
/// The maximum fraction of pixels that may differ. Where rounding changes a random decision, a path goes elsewhere.
const MAX_APART: f64 = 0.03;
/// The maximum relative difference of the means of two pictures, which the differing pixels may cause.
const MAX_MEAN: f64 = 1e-3;
/// Scene and preset of each picture without `--all`. They are few because compiling shaders takes most of the time, minutes
/// for `accurate` with all kinds of lights and surfaces.
const FEW: [(&str, (&str, u32)); 2] =
    [("conservatory", PRESETS[0]), ("cornell-glossy", PRESETS[1])];
/// The variant that requires least of a driver; the variant that the program selects is usually another one.
const PLAIN: Variant = Variant {
    tracer: Tracer::ComputeBvh,
    geometry: GeometryAccess::StorageBuffers,
    fetch: Fetch::Words,
    textures: Textures::Buffer,
};

/// A picture of a scene with a preset, and the name of the driver. With `None`, the shader variant is the one that the
/// program selects.
fn picture(name: &str, preset: &str, frames: u32, variant: Option<Variant>) -> (Image, String) {
    let mut scene = procedural::generate(name, &[]).unwrap();
    scene.environment =
        (name == "conservatory").then(|| Environment::open(SKY, &mut Vec::new()).unwrap());
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
