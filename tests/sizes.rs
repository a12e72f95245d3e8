//! Tests of scenes and pictures larger than a device binds at once. Most tests reduce the limits that a device reports; with
//! `HEADWATER_TEST_ALL` some exceed the real limits.

mod support;

use glam::{DVec3, Vec2, Vec3, Vec4};
use headwater::Result;
use headwater::device_scene::selection::{Request, Selection, select};
use headwater::device_scene::{GpuScene, SceneSizes};
use headwater::gpu::{Device, DeviceInfo};
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings::{DirectMode, IndirectMode, Secondary};
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{Image, Scene, Texture};
use headwater::shader_interface::{Fetch, GeometryAccess, PixelSums, Tracer};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A lock that each test of this file holds, because the tests open devices themselves, which only one test may do at a time
/// (see [`Device::open`]).
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Opens the tests' device with properties that `change` has edited, for the variant that the program selects for the scene.
fn open(scene: &Scene, change: impl FnOnce(&mut DeviceInfo)) -> (Arc<Device>, Selection) {
    let (instance, mut info) = support::tests_device();
    change(&mut info);
    let selection = select(&info, Request::default(), &SceneSizes::of(scene)).unwrap();
    let device = Device::open(&instance, info, selection.features()).unwrap();
    (device, selection)
}

fn view(scene: &Scene, width: u32, height: u32) -> View {
    View {
        camera: scene.cameras[0].clone(),
        width,
        height,
        seed: 5,
        bounces: 1,
        jitter: false,
    }
}

fn renderer(device: &Arc<Device>, selection: &Selection, scene: &Scene, view: &View) -> Renderer {
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(device, scene, origin, selection.variant).unwrap();
    Renderer::new(device, Arc::new(uploaded), view, &Settings::default()).unwrap()
}

fn bits<T: bytemuck::Pod>(values: &[T]) -> &[u8] {
    bytemuck::cast_slice(values)
}

#[test]
fn sizes_are_known_before_they_are_taken() {
    let _alone = alone();
    for name in [
        "cornell",
        "cornell-glossy",
        "terrain",
        "city-grid",
        "motion",
    ] {
        let scene = procedural::generate(name, &[]).unwrap();
        assert_sizes(name, &scene);
    }
    for name in ["cornell", "motion"] {
        let mut scene = procedural::generate(name, &[]).unwrap();
        vary(&mut scene);
        assert_sizes(&format!("{name} with textures and colours"), &scene);
        // Off at first; a scene that moves may turn them on.
        for material in &mut scene.materials {
            material.emission = Vec3::ZERO;
        }
        assert_sizes(&format!("{name} with its emitters off"), &scene);
    }
}

#[test]
fn emissive_triangles_must_fit_the_memory_of_the_host() {
    let _alone = alone();
    let (_, info) = support::tests_device();
    let scene = procedural::generate("cornell", &[]).unwrap();
    let mut sizes = SceneSizes::of(&scene);
    let selection = select(&info, Request::default(), &sizes).unwrap();
    sizes.check(&info, selection.variant).unwrap();
    // 250 GB: more than the machines of the tests have.
    sizes.triangle_lights = 1 << 29;
    let error = sizes.check(&info, selection.variant).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("536870912 emissive triangles"), "{text}");
    assert!(text.contains("more than there is memory for"), "{text}");
}

/// Gives some meshes vertex colours and others textures, with one or both sets of texture coordinates, and a texture to an
/// emitter too.
fn vary(scene: &mut Scene) {
    scene.images = vec![Image {
        name: String::new(),
        width: 3,
        height: 1,
        texels: [[255; 4]; 3].into(),
    }];
    for (index, mesh) in scene.meshes.iter_mut().enumerate() {
        let count = mesh.positions.len();
        if index % 3 != 1 {
            mesh.uvs[index % 2] = vec![Vec2::ZERO; count];
        }
        if index % 4 == 0 {
            mesh.colors = vec![Vec4::ONE; count];
        }
        for part in mesh.parts.iter().filter(|_| index % 3 != 1) {
            let texture = Some(Texture {
                set: index as u32 % 2,
                ..Texture::plain(0)
            });
            let material = &mut scene.materials[part.material as usize];
            material.base_color_texture = texture;
            material.emissive_texture = texture;
        }
    }
    for mesh in &mut scene.meshes {
        for part in &mesh.parts {
            for (_, texture) in scene.materials[part.material as usize].textures() {
                mesh.uvs[texture.set as usize] = vec![Vec2::ZERO; mesh.positions.len()];
            }
        }
    }
    scene.validate().unwrap();
}

fn assert_sizes(name: &str, scene: &Scene) {
    let (device, selection) = open(scene, |_| ());
    let uploaded = GpuScene::new(&device, scene, DVec3::ZERO, selection.variant).unwrap();
    let sizes = SceneSizes::of(scene);
    let taken = uploaded.memory();
    for ((buffer, known), (same, taken)) in sizes.bytes.named().into_iter().zip(taken) {
        assert_eq!(buffer, same);
        if buffer == "nodes" {
            let few = sizes.triangles < 100;
            assert!(few || taken < sizes.bytes.positions, "{name}");
        } else {
            // An empty buffer has 16 bytes, so that it can be bound.
            let bytes = known.max(16).next_multiple_of(16);
            // Only where some lights are rare there are three tables of them.
            let one_table = (known / 3).max(16).next_multiple_of(16);
            let has_one_table = buffer == "light_choices" && !uploaded.first_lights().has_rare();
            let bytes = if has_one_table { one_table } else { bytes };
            assert!(taken == bytes, "{name}: {buffer}, {taken} and not {bytes}");
        }
    }
}

/// Reduces the limits of a device: it binds 1 MiB per buffer, and reads at most `texels` texels.
fn pretend(info: &mut DeviceInfo, texels: u32) {
    info.max_storage_buffer_range = 1 << 20;
    info.max_texels = info.max_texels.min(texels);
}

#[test]
fn a_scene_too_large_to_bind_is_read_by_address() {
    let _alone = alone();
    let scene = procedural::generate("terrain", &[]).unwrap();
    let view = view(&scene, 160, 90);
    let picture = |change: fn(&mut DeviceInfo)| {
        let (device, selection) = open(&scene, change);
        let mut renderer = renderer(&device, &selection, &scene, &view);
        renderer.add_samples(0, 2).unwrap();
        support::assert_no_messages(&device);
        (renderer.sums().unwrap().pixels, selection)
    };
    let (whole, _) = picture(|_| ());
    if !support::tests_device().1.buffer_addresses {
        return;
    }
    // Less than its normals; texels reach less far still, or as far, or, where they can, past the
    // positions.
    for change in [
        |info: &mut DeviceInfo| pretend(info, 1000),
        |info: &mut DeviceInfo| pretend(info, 1 << 16),
        |info: &mut DeviceInfo| pretend(info, 1 << 18),
    ] {
        let (sums, selection) = picture(change);
        assert_eq!(selection.variant.geometry, GeometryAccess::BufferAddresses);
        assert!(bits::<PixelSums>(&sums) == bits(&whole), "{selection:?}");
    }
    let (_, info) = support::tests_device();
    let chosen = |range, texels| {
        let mut info = info.clone();
        (info.max_storage_buffer_range, info.max_texels) = (range, texels);
        let wanted = Request {
            tracer: Some(Tracer::ComputeBvh),
            ..Request::default()
        };
        select(&info, wanted, &SceneSizes::of(&scene)).unwrap()
    };
    assert_eq!(chosen(1 << 20, 1 << 18).variant.fetch, Fetch::Texels);
    let words = chosen(1 << 20, 1 << 17);
    assert_eq!(words.variant.fetch, Fetch::Words);
    assert!(words.fetch_reason.contains("bytes"), "{words:?}");
}

/// Settings for indirect light alone, without reuse over pixels, with world reservoirs at three vertices per path.
fn world_settings(secondary: Secondary) -> Settings {
    let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
    settings.direct.mode = DirectMode::Off;
    settings.indirect.mode = IndirectMode::Path;
    settings.indirect.secondary = secondary;
    settings.world_reservoirs.min_lights = 0;
    settings.world_reservoirs.depth = 3;
    settings
}

/// The radiance of the second frame of `cornell` with four bounces, on a device whose properties `change` has edited.
fn second_frame(
    size: u32,
    settings: &Settings,
    geometry: Option<GeometryAccess>,
    change: impl FnOnce(&mut DeviceInfo),
) -> Result<Vec<[f32; 3]>> {
    let scene = procedural::generate("cornell", &[])?;
    let (instance, mut info) = support::tests_device();
    change(&mut info);
    let wanted = Request {
        geometry,
        ..Request::default()
    };
    let selection = select(&info, wanted, &SceneSizes::of(&scene))?;
    let device = Device::open(&instance, info, selection.features())?;
    let view = View {
        bounces: 4,
        ..view(&scene, size, size)
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, &scene, origin, selection.variant)?;
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, settings)?;
    renderer.single_frame(0)?;
    renderer.single_frame(1)?;
    support::assert_no_messages(&device);
    renderer.frame_radiance()
}

#[test]
fn world_reservoirs_too_many_to_bind_are_read_by_address() {
    let _alone = alone();
    let (_, info) = support::tests_device();
    let settings = world_settings(Secondary::WorldReservoirs);
    // The points and the samples of 128 × 128 × 3 vertices take 768 KiB each.
    let few = |info: &mut DeviceInfo| info.max_storage_buffer_range = 512 << 10;
    for has_addresses in [false, true] {
        if has_addresses && !info.buffer_addresses {
            return;
        }
        let refused = second_frame(
            128,
            &settings,
            Some(GeometryAccess::StorageBuffers),
            |info| {
                few(info);
                info.buffer_addresses = has_addresses;
            },
        );
        let refused = refused.unwrap_err().to_string();
        for said in [
            "786432 bytes for its world_points",
            "lower world_reservoirs.depth, or choose",
        ] {
            assert!(refused.contains(said), "{refused}");
        }
        let way_out = "use --geometry buffer-addresses";
        assert_eq!(refused.contains(way_out), has_addresses, "{refused}");
    }
    let bound = second_frame(128, &settings, Some(GeometryAccess::StorageBuffers), |_| ()).unwrap();
    let addressed =
        second_frame(128, &settings, Some(GeometryAccess::BufferAddresses), few).unwrap();
    assert!(bits(&bound) == bits(&addressed));

    if support::takes_largest() {
        // 192 MiB each. The mean says that points and samples belong together; if both were those of another vertex,
        // there would only be more noise.
        let mean = |secondary| {
            let settings = world_settings(secondary);
            let addresses = Some(GeometryAccess::BufferAddresses);
            let picture = second_frame(2048, &settings, addresses, |_| ()).unwrap();
            let sum: f64 = picture
                .iter()
                .flatten()
                .map(|value| f64::from(*value))
                .sum();
            sum / picture.len() as f64
        };
        let ratio = mean(Secondary::WorldReservoirs) / mean(Secondary::Ris);
        assert!((ratio - 1.0).abs() < 0.002, "{ratio}");
    }
}

/// A requested geometry access must be used, or refused in one line that says what to do.
#[test]
fn geometry_can_be_asked_for_where_the_device_and_the_scene_allow_it() {
    let _alone = alone();
    let scene = procedural::generate("terrain", &[]).unwrap();
    let sizes = SceneSizes::of(&scene);
    let (_, info) = support::tests_device();
    let asked = |geometry, has_addresses, range| {
        let mut info = info.clone();
        info.buffer_addresses = has_addresses;
        (info.max_storage_buffer_range, info.max_texels) = (range, 1 << 27);
        let wanted = Request {
            tracer: Some(Tracer::ComputeBvh),
            geometry,
            ..Request::default()
        };
        select(&info, wanted, &sizes)
    };
    let large = 1 << 27;
    for (choice, access) in [
        (
            Some(GeometryAccess::StorageBuffers),
            GeometryAccess::StorageBuffers,
        ),
        (
            Some(GeometryAccess::BufferAddresses),
            GeometryAccess::BufferAddresses,
        ),
    ] {
        let selection = asked(choice, true, large).unwrap();
        assert_eq!(selection.variant.geometry, access);
        assert_eq!(selection.geometry_reason, "asked for");
    }
    let refused = |geometry, has_addresses, range, said: &str| {
        let error = asked(geometry, has_addresses, range).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains(said), "{error}");
    };
    refused(
        Some(GeometryAccess::BufferAddresses),
        false,
        large,
        "use --geometry storage-buffers",
    );
    refused(
        Some(GeometryAccess::StorageBuffers),
        true,
        1 << 20,
        "use --geometry buffer-addresses",
    );
}

#[test]
fn what_no_variant_can_read_is_refused_with_its_bytes() {
    let _alone = alone();
    let scene = procedural::generate("terrain", &[]).unwrap();
    let sizes = SceneSizes::of(&scene);
    let refused = |change: fn(&mut DeviceInfo), said: &[String]| {
        let (device, selection) = open(&scene, change);
        let error = GpuScene::new(&device, &scene, DVec3::ZERO, selection.variant);
        let error = error.err().expect("it was taken");
        assert_eq!(error.exit_status(), 2);
        let text = error.to_string();
        assert!(said.iter().all(|part| text.contains(part)), "{text}");
    };
    let bytes = sizes.bytes.corner_directions.to_string();
    refused(
        |info| {
            info.buffer_addresses = false;
            (info.max_storage_buffer_range, info.max_texels) = (1 << 20, 1 << 27);
        },
        &["corner_directions".into(), bytes, "1048576".into()],
    );
    let bytes = sizes.bytes.positions.to_string();
    refused(
        |info| (info.max_buffer_size, info.max_texels) = (1 << 21, 1 << 27),
        &["positions".into(), bytes, "2097152".into()],
    );
    refused(|info| info.device_memory = 1 << 22, &["4194304".into()]);
}

#[test]
fn a_picture_in_few_strips_in_many_and_resumed_has_the_same_bits() {
    let _alone = alone();
    let scene = procedural::generate("cornell", &[]).unwrap();
    // More pixels than a strip has, and a height that no strip divides.
    let view = view(&scene, 2048, 1030);
    let (device, selection) = open(&scene, |_| ());
    let mut few = renderer(&device, &selection, &scene, &view);
    // 40 rows a strip.
    let (device, selection) = open(&scene, |info| {
        info.max_storage_buffer_range = 40 * 2048 * size_of::<PixelSums>() as u64;
    });
    let mut many = renderer(&device, &selection, &scene, &view);
    few.add_samples(0, 1).unwrap();
    let after_one = few.sums().unwrap().pixels;
    many.add_samples(0, 1).unwrap();
    assert!(
        bits::<PixelSums>(&after_one) == bits(&many.sums().unwrap().pixels),
        "strips differ"
    );
    let lit = after_one
        .iter()
        .filter(|p| p.sum.max_element() > 0.0)
        .count();
    assert!(lit > after_one.len() / 4, "{lit} pixels are lit");
    few.add_samples(1, 1).unwrap();
    many.set_sums(&after_one, &[], 1).unwrap();
    many.add_samples(1, 1).unwrap();
    assert!(
        bits(&few.sums().unwrap().pixels) == bits(&many.sums().unwrap().pixels),
        "resumed strips differ"
    );
    let surfaces = [&mut few, &mut many].map(|r| r.primary_surfaces().unwrap());
    assert!(bits(&surfaces[0]) == bits(&surfaces[1]), "surfaces differ");
    support::assert_no_messages(&device);
}

/// A ground so large that a tenth of its triangles have normals and parts beyond the reach of a binding of 128 MiB, and most
/// of them positions beyond it. All must be read correctly.
#[test]
fn ground_past_the_limits_of_bindings_is_where_it_should_be() {
    let _alone = alone();
    if !support::takes_largest() {
        return;
    }
    let settings = [("triangles".to_owned(), "12500000".to_owned())];
    let scene = procedural::generate("terrain", &settings).unwrap();
    assert!(SceneSizes::of(&scene).bytes.corner_directions * 9 > (1 << 27) * 10);
    let mut view = view(&scene, 256, 256);
    // Straight down, so that a ray meets the ground once.
    let eye = DVec3::new(0.0, 110.0, 0.0);
    view.camera = support::look_at(eye, DVec3::ZERO, DVec3::NEG_Z, 0.8);
    let (device, selection) = open(&scene, |_| ());
    let mut renderer = renderer(&device, &selection, &scene, &view);
    let surfaces = renderer.primary_surfaces().unwrap();
    let ground = &scene.meshes[0];
    let side = ((ground.triangles.len() / 2) as f64).sqrt().round();
    let half_height = (0.4_f64).tan();
    let mut checked = 0;
    for (index, seen) in surfaces.iter().enumerate() {
        let (x, y) = ((index % 256) as f64 + 0.5, (index / 256) as f64 + 0.5);
        let plane = DVec3::new(x / 128.0 - 1.0, 0.0, y / 128.0 - 1.0) * half_height;
        let direction = (plane + DVec3::NEG_Y).normalize();
        let at = eye + direction * f64::from(seen.depth);
        let cell = (at + 50.0) / 100.0 * side;
        if cell.x < 1.0 || cell.z < 1.0 || cell.x > side - 1.0 || cell.z > side - 1.0 {
            continue;
        }
        // The cell's two triangles stand in a row; the ray met one of them.
        let first = 2 * (cell.z.floor() as usize * side as usize + cell.x.floor() as usize);
        let found = ground.triangles[first..first + 2].iter().any(|t| {
            let [a, b, c] = t.map(|i| ground.positions[i as usize].as_dvec3());
            // Weights of the corners as seen from above.
            let (u, v, p) = (b - a, c - a, at - a);
            let area = u.x * v.z - u.z * v.x;
            let weights = (
                (p.x * v.z - p.z * v.x) / area,
                (u.x * p.z - u.z * p.x) / area,
            );
            let weights = DVec3::new(1.0 - weights.0 - weights.1, weights.0, weights.1);
            let normals = t.map(|i| ground.normals[i as usize].as_dvec3());
            let mix = |of: [DVec3; 3]| of[0] * weights.x + of[1] * weights.y + of[2] * weights.z;
            // Rounding moves a point by some thousandths of a triangle.
            weights.min_element() > -0.01
                && (mix([a, b, c]).y - at.y).abs() < 1e-3
                && mix(normals).normalize().dot(seen.normal.as_dvec3()) > 0.999
        });
        assert!(found, "{seen:?} at {at}");
        assert_eq!(seen.instance, 0);
        checked += 1;
    }
    assert!(
        checked > surfaces.len() / 2,
        "{checked} pixels show the ground"
    );
    support::assert_no_messages(&device);
}
