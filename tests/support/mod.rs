//! Helpers of the integration tests: devices, scenes, pictures, and shaders with planted faults.
#![allow(dead_code, unused_imports)] // Each test binary uses its own part.

pub mod brute_force;
pub mod random;

use glam::{DAffine3, DVec3, Vec3};
use headwater::device_scene::selection::{self, Request, Selection};
use headwater::device_scene::{GpuScene, SceneSizes};
use headwater::gpu::{Device, DeviceInfo, Features, Instance};
use headwater::render::outputs::Sums;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::camera::Projection;
use headwater::scene::{Camera, Instance as Placed, Material, Mesh, Part, Scene};
use headwater::shader_interface::{GeometryAccess, Textures, Tracer, Variant};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, LazyLock, Mutex};
use std::thread::available_parallelism;

/// A new Vulkan instance, and the device that `HEADWATER_DEVICE` names; without that variable, the CPU device. Without a
/// device it panics, and the message names what to install.
fn choose() -> (Arc<Instance>, DeviceInfo) {
    let instance = headwater::commands::open_vulkan(headwater::gpu::InstanceOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let info = match std::env::var("HEADWATER_DEVICE") {
        Ok(name) => instance.choose(Some(&name)).map(|(info, _)| info),
        Err(_) => {
            let devices = instance.devices().unwrap_or_else(|e| panic!("{e}"));
            devices.into_iter().find(DeviceInfo::is_cpu).ok_or_else(|| {
                headwater::Error::failed(
                    "no CPU device; install mesa-vulkan-drivers, or run tools/test, which brings one",
                )
            })
        }
    };
    (instance, info.unwrap_or_else(|e| panic!("{e}")))
}

/// The Vulkan instance, the properties of the tests' device, and the open devices that all tests of one process share.
struct Shared {
    instance: Arc<Instance>,
    info: DeviceInfo,
    /// Open devices, several for each set of features; a test takes one that no other test holds. All are opened before a
    /// test uses one, as [`Device::open`] requires. Each has an instance of its own, so validation messages belong to one
    /// test.
    devices: Mutex<Vec<Arc<Device>>>,
}

/// The number of devices with the same features that one test may hold at the same time; the pool has this many per test
/// thread.
const DEVICES_A_THREAD: usize = 2;

fn shared() -> &'static Shared {
    static SHARED: LazyLock<Shared> = LazyLock::new(|| {
        let (instance, info) = choose();
        let threads = std::env::var("RUST_TEST_THREADS").ok();
        let threads = threads.and_then(|count| count.parse().ok());
        let threads = threads.or_else(|| Some(available_parallelism().ok()?.get()));
        let count = DEVICES_A_THREAD * threads.unwrap_or(1);
        let [plain, addresses, ray_query] =
            [(false, false), (false, true), (true, true)].map(|(ray_query, buffer_addresses)| {
                Features {
                    ray_query,
                    buffer_addresses,
                    ..Features::default()
                }
            });
        let devices = [
            Some(plain),
            info.buffer_addresses.then_some(addresses),
            info.ray_query.then_some(ray_query),
        ]
        .into_iter()
        .flatten()
        .flat_map(|features| {
            let with_images = Features {
                image_arrays: info.image_arrays,
                ..features
            };
            let both = [features, with_images];
            both.into_iter().take(1 + usize::from(info.image_arrays))
        })
        .flat_map(|features| std::iter::repeat_n(features, count))
        .map(|features| {
            let (instance, info) = choose();
            Device::open(&instance, info, features)
        })
        .collect::<headwater::Result<_>>()
        .unwrap_or_else(|e| panic!("{e}"));
        Shared {
            instance,
            info,
            devices: Mutex::new(devices),
        }
    });
    &SHARED
}

/// The instance and the properties of the tests' device, for a test that opens it with other options than [`open_device`].
/// Such a test must be the only one that runs in its process.
pub fn tests_device() -> (Arc<Instance>, DeviceInfo) {
    (shared().instance.clone(), shared().info.clone())
}

/// The shader variants with this tracer that the tests' device can run. Empty, with a note on stderr, if the device lacks
/// ray query and it is requested.
pub fn variants(tracer: Tracer) -> Vec<Variant> {
    let info = &shared().info;
    if tracer == Tracer::RayQuery && !info.ray_query {
        // Past the test runner, which shows what a test prints only where it fails.
        static SAID: std::sync::Once = std::sync::Once::new();
        SAID.call_once(|| {
            let _ = writeln!(
                std::io::stderr(),
                "note: nothing is tested with ray query, which device '{}' lacks",
                info.name
            );
        });
        return Vec::new();
    }
    Variant::of(tracer)
        .filter(|v| v.geometry == GeometryAccess::StorageBuffers || info.buffer_addresses)
        .filter(|v| v.textures == Textures::Buffer || info.image_arrays)
        .collect()
}

/// A free open device with the features that `variant` needs, and the selection with that variant. With `None`, the variant
/// is the one that the program itself selects for the device.
pub fn open_device(variant: Option<Variant>) -> (Arc<Device>, Selection) {
    let info = &shared().info;
    let mut selection =
        selection::select(info, Request::default(), &SceneSizes::default()).unwrap();
    if let Some(variant) = variant {
        selection.variant = variant;
    }
    let mut features = selection.features();
    features.buffer_addresses |= features.ray_query;
    let devices = shared().devices.lock().unwrap();
    // Nobody else has it.
    let is_free = |device: &&Arc<Device>| Arc::strong_count(device) == 1;
    let mut suitable = devices.iter().filter(|device| device.features == features);
    let device = suitable.find(is_free);
    let device = device.unwrap_or_else(|| panic!("no device is free with {features:?}"));
    (device.clone(), selection)
}

/// True if tests include their largest scenes, other drivers and capture tools (`HEADWATER_TEST_ALL`, set by `tools/test
/// --all`).
pub fn takes_largest() -> bool {
    std::env::var_os("HEADWATER_TEST_ALL").is_some()
}

/// The folder in which tests of different drivers exchange pictures (`HEADWATER_PICTURES`; `None` if it is not set), and the
/// number of drivers that ran before this one (`HEADWATER_DRIVERS_BEFORE`).
pub fn other_drivers() -> (Option<PathBuf>, usize) {
    let before = number_in("HEADWATER_DRIVERS_BEFORE");
    (
        std::env::var_os("HEADWATER_PICTURES").map(PathBuf::from),
        before.unwrap_or(0) as usize,
    )
}

/// The value of an environment variable as a number; `None` if it is not set. It panics if the value is no number.
pub fn number_in(variable: &str) -> Option<u64> {
    let value = std::env::var(variable).ok()?;
    Some(
        value
            .parse()
            .unwrap_or_else(|_| panic!("{variable}={value} is no number")),
    )
}

/// The whole output of a command as text: stdout, then stderr.
pub fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy;
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

/// Panics if the validation layers have reported a message for the device.
pub fn assert_no_messages(device: &Device) {
    let messages = device.validation_messages();
    assert!(messages.is_empty(), "validation: {messages:#?}");
}

/// A scene with one mesh per pair of material and list of triangles, with corners in world space. It has no camera.
pub fn scene_of(parts: &[(Material, Vec<[Vec3; 3]>)]) -> Scene {
    let mut scene = Scene::default();
    for (material, triangles) in parts {
        add(&mut scene, material, triangles);
    }
    scene
}

/// Adds a mesh of one material and an instance with the identity transform to a scene, and returns the mesh.
pub fn add<'a>(scene: &'a mut Scene, material: &Material, triangles: &[[Vec3; 3]]) -> &'a mut Mesh {
    let count = triangles.len() as u32;
    let number = scene.meshes.len();
    scene.meshes.push(Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        parts: vec![Part {
            first_triangle: 0,
            triangle_count: count,
            material: scene.materials.len() as u32,
        }],
        ..Mesh::default()
    });
    scene.materials.push(material.clone());
    scene.instances.push(Placed {
        name: material.name.clone(),
        mesh: number as u32,
        object_to_world: DAffine3::IDENTITY,
    });
    &mut scene.meshes[number]
}

/// The two triangles of a parallelogram with edges `u` and `v`: (corner, corner + u, corner + u + v) and (corner, corner + u
/// + v, corner + v). The front is the side of u × v.
pub fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Vec<[Vec3; 3]> {
    vec![
        [corner, corner + u, corner + u + v],
        [corner, corner + u + v, corner + v],
    ]
}

/// The six faces of a block of the given half size around the origin: of each a corner, and its edges u and v. u × v points
/// outwards.
pub fn block(half: Vec3) -> impl Iterator<Item = [Vec3; 3]> {
    let sides = (0..3).flat_map(|axis| [-1.0_f32, 1.0].map(|side| (axis, side)));
    sides.map(move |(axis, side)| {
        let normal = Vec3::AXES[axis] * side;
        let (u, v) = (
            Vec3::AXES[(axis + 1) % 3] * side,
            Vec3::AXES[(axis + 2) % 3],
        );
        [(normal - u - v) * half, u * half * 2.0, v * half * 2.0]
    })
}

/// A camera at `eye` that looks at `target`, with a vertical field of view in radians.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, vertical_fov: f64) -> Camera {
    let back = (eye - target).normalize();
    let right = up.cross(back).normalize();
    Camera {
        name: String::new(),
        camera_to_world: DAffine3::from_cols(right, back.cross(right), back, eye),
        projection: Projection::pinhole(vertical_fov),
        aspect_ratio: None,
    }
}

/// The bits of the radiance (RGB) of the last of three frames of 64 × 48 pixels, row by row from the top. The shaders are
/// those of `variant` or, with `None`, of the variant that the program selects. It compares pictures exactly.
pub fn frame_bits(scene: &Scene, settings: &Settings, variant: Option<Variant>) -> Vec<[u32; 3]> {
    let (device, selection) = open_device(variant);
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 64,
        height: 48,
        seed: 7,
        bounces: 4,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, scene, origin, selection.variant).unwrap());
    let mut renderer = Renderer::new(&device, uploaded, &view, settings).unwrap();
    for frame in 0..3 {
        renderer.single_frame(frame).unwrap();
    }
    assert_no_messages(&device);
    assert_eq!(renderer.rejected().unwrap(), 0, "values were rejected");
    let radiance = renderer.frame_radiance().unwrap();
    radiance.iter().map(|p| p.map(f32::to_bits)).collect()
}

/// Mean radiance and squared standard error of each pixel and channel of a rendered picture.
pub struct Rendered {
    /// Mean radiance (RGB) of each pixel, row by row from the top.
    pub mean: Vec<[f64; 3]>,
    /// Squared standard error of the mean, for each pixel and channel, row by row from the top.
    pub error_squared: Vec<[f64; 3]>,
}

/// The sums of `samples` samples per pixel. `origin` is the world position that the device uses as its zero; it decides
/// where f32 is most precise.
pub fn sums(
    device: &Arc<Device>,
    scene: &Scene,
    origin: DVec3,
    variant: Variant,
    view: &View,
    settings: &Settings,
    samples: u32,
) -> Sums {
    let uploaded = Arc::new(GpuScene::new(device, scene, origin, variant).unwrap());
    let mut renderer = Renderer::new(device, uploaded, view, settings).unwrap();
    renderer.add_samples(0, samples).unwrap();
    assert_eq!(renderer.rejected().unwrap(), 0, "values were rejected");
    renderer.sums().unwrap()
}

/// The mean and the error of `samples` samples per pixel, with the camera at the origin of the device.
pub fn render(
    device: &Arc<Device>,
    scene: &Scene,
    variant: Variant,
    view: &View,
    settings: &Settings,
    samples: u32,
) -> Rendered {
    let origin = view.camera.camera_to_world.translation;
    let sums = sums(device, scene, origin, variant, view, settings, samples);
    Rendered {
        mean: sums.mean(samples).iter().map(|m| m.to_array()).collect(),
        error_squared: (sums.standard_error(samples).iter())
            .map(|e| (e * e).to_array())
            .collect(),
    }
}

/// Writes a copy of the shaders with changes (a planted fault) to `folder`. A change is (file, text, replacement); it panics
/// if the file does not contain the text.
pub fn planted(folder: &Path, changes: &[(&str, &str, &str)]) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
    let mut sources = headwater::shader_interface::compiler::read_folder(&from).unwrap();
    for (file, text, replacement) in changes {
        let source = sources.get_mut(*file).expect("no such file");
        assert!(source.contains(text), "{file} has no '{text}'");
        *source = source.replace(text, replacement);
    }
    for (name, source) in sources {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, source).unwrap();
    }
}

/// Changes of the shaders, as for [`planted`], that give every surface the two additional lobes of `toy_lobes.glsl`: one
/// inserts the file, the other registers its lobes.
pub const TOY_LOBES: [(&str, &str, &str); 2] = [
    (
        "bsdf/lobes.glsl",
        "#include \"bsdf/diffuse.glsl\"",
        concat!(
            "#include \"bsdf/diffuse.glsl\"\n",
            include_str!("toy_lobes.glsl")
        ),
    ),
    (
        "bsdf/lobes.glsl",
        "#define BSDF_LOBES(LOBE) \\",
        "#define BSDF_LOBES(LOBE) LOBE(DustLobe, dust, 0u) LOBE(TurnLobe, turn, 1u) \\",
    ),
];

/// Runs the test `test` of this test program again, alone in a new process, with a fault in the shaders: (file, text,
/// replacement). `change` adds arguments or variables to the command. Returns the output of the process.
pub fn run_with_fault(
    test: &str,
    fault: (&str, &str, &str),
    change: impl FnOnce(&mut Command) -> &mut Command,
) -> Output {
    let folder = tempfile::tempdir().unwrap();
    planted(folder.path(), &[fault]);
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", test]);
    command.env("HEADWATER_GLSL", folder.path());
    change(&mut command).output().unwrap()
}
