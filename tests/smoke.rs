mod support;
use glam::{DVec3, Vec3};
use headwater::render::{Settings, View};
use headwater::scene::Material;
use headwater::tracing::Variant;

#[test]
fn smoke() {
    let white = Material::lambert("floor", Vec3::splat(0.5));
    let light = Material {
        emission: Vec3::splat(10.0),
        ..Material::lambert("light", Vec3::ZERO)
    };
    let scene = support::scene_of(&[
        (
            white,
            support::quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0),
        ),
        (
            light,
            support::quad(Vec3::new(-0.5, 2.0, -0.5), Vec3::X, Vec3::Z),
        ),
    ]);
    let view = View {
        camera: support::look_at(
            DVec3::new(0.0, 1.0, 6.0),
            DVec3::new(0.0, 1.0, 0.0),
            DVec3::Y,
            0.8,
        ),
        width: 64,
        height: 48,
        seed: 1,
        bounces: 2,
        jitter: false,
    };
    for variant in Variant::ALL {
        let (device, _) = support::open_device(Some(variant));
        let start = std::time::Instant::now();
        let image = support::render(&device, &scene, variant, &view, &Settings::default(), 16);
        let mean: f64 = image.mean.iter().map(|p| p[0]).sum::<f64>() / image.mean.len() as f64;
        println!("{variant:?} mean {mean} in {:?}", start.elapsed());
        support::assert_no_messages(&device);
    }
}
