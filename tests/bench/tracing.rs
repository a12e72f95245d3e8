//! Measures rays per second of the BVH traversed in compute, of the driver's ray query, and of `obvhs` on the CPU with one
//! thread per core. All trace the same rays, in turns, and wall-clock time counts.
//!
//! `cargo bench --bench tracing [-- TRIANGLES...]` prints one line per scene, kind of ray and tracer: `tracing TRIANGLES
//! KIND TRACER mrays=… ratio=… busy=…`. `mrays` is in millions of rays per second, `ratio` is relative to the CPU (the
//! median over the rounds), and `busy` is processor time over wall-clock time.

#[path = "../support/mod.rs"]
mod support;

use glam::{DVec3, Vec3, Vec3A};
use headwater::device_scene::GpuScene;
use headwater::render::ray_list::RayTracer;
use headwater::scene::{Material, Scene};
use headwater::shader_interface::{RayQuery, Tracer};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::sync::Arc;
use std::time::{Duration, Instant};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;
const ROUNDS: usize = 7;

/// The tree of the CPU tracer, with its triangles in the order of its leaves.
struct CpuTree {
    tree: CwBvh,
    triangles: Vec<RtTriangle>,
    threads: usize,
}

impl CpuTree {
    fn new(scene: &Scene) -> Self {
        let triangles: Vec<Triangle> = scene
            .meshes
            .iter()
            .flat_map(|mesh| {
                mesh.triangles.iter().map(|t| {
                    let [a, b, c] = t.map(|i| Vec3A::from(mesh.positions[i as usize]));
                    Triangle {
                        v0: a,
                        v1: b,
                        v2: c,
                    }
                })
            })
            .collect();
        let params = BvhBuildParams {
            pre_split: false,
            max_prims_per_leaf: 3,
            ..BvhBuildParams::medium_build()
        };
        let tree = build_cwbvh_from_tris(&triangles, params, &mut Duration::default());
        let order = &tree.primitive_indices;
        Self {
            triangles: order
                .iter()
                .map(|&i| (&triangles[i as usize]).into())
                .collect(),
            tree,
            threads: std::thread::available_parallelism().map_or(1, Into::into),
        }
    }

    fn closest(&self, query: &RayQuery) -> Option<(f32, usize)> {
        let ray = cpu_ray(query);
        let mut hit = RayHit::none();
        self.tree
            .ray_traverse(ray, &mut hit, |ray, id| self.triangles[id].intersect(ray))
            .then_some((hit.t, hit.primitive_id as usize))
    }

    /// Traces all rays on all threads; a free thread takes the next 256 rays. Returns the number of hits, and the seconds of
    /// each thread.
    fn run(&self, rays: &[RayQuery]) -> (usize, Vec<f64>) {
        let next = std::sync::atomic::AtomicUsize::new(0);
        let work = || {
            let start = Instant::now();
            let mut hits = 0;
            loop {
                let first = next.fetch_add(256, std::sync::atomic::Ordering::Relaxed);
                if first >= rays.len() {
                    return (hits, start.elapsed().as_secs_f64());
                }
                for query in &rays[first..rays.len().min(first + 256)] {
                    hits += usize::from(if query.any == 1 {
                        let ray = cpu_ray(query);
                        !self
                            .tree
                            .ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
                    } else {
                        self.closest(query).is_some()
                    });
                }
            }
        };
        let results: Vec<(usize, f64)> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..self.threads).map(|_| scope.spawn(work)).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        (
            results.iter().map(|r| r.0).sum(),
            results.iter().map(|r| r.1).collect(),
        )
    }
}

fn cpu_ray(query: &RayQuery) -> Ray {
    Ray::new(
        query.origin.into(),
        query.direction.into(),
        0.0,
        query.t_max,
    )
}

/// A scene with a hilly height field of about `triangles` triangles, 100 units wide, and a sun.
fn terrain(triangles: usize) -> Scene {
    let side = ((triangles as f64 / 2.0).sqrt().round() as usize).max(1);
    let height = |x: f32, z: f32| {
        (0..6).fold(0.0, |sum: f32, octave| {
            let f = 0.08 * 2_f32.powi(octave);
            let turn = octave as f32 * 0.7;
            let (u, v) = (
                x * turn.cos() - z * turn.sin(),
                x * turn.sin() + z * turn.cos(),
            );
            sum + 4.0 * 0.45_f32.powi(octave) * (u * f).sin() * (v * f * 1.1).cos()
        })
    };
    let at = |i: usize, j: usize| {
        let x = i as f32 / side as f32 * 100.0 - 50.0;
        let z = j as f32 / side as f32 * 100.0 - 50.0;
        Vec3::new(x, height(x, z), z)
    };
    let mut faces = Vec::with_capacity(side * side * 2);
    for i in 0..side {
        for j in 0..side {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    support::scene_of(&[(Material::lambert("ground", Vec3::splat(0.5)), faces)])
}

/// Lists of rays with their names: primary rays in the order of 4×2 blocks within 8×8 tiles, and rays that begin at their
/// hits.
fn batches(cpu: &CpuTree) -> Vec<(&'static str, Vec<RayQuery>)> {
    let eye = Vec3::new(0.0, 12.0, 48.0);
    let target = Vec3::new(0.0, 0.0, 0.0);
    let back = (eye - target).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let half = 0.5_f32;
    let mut primary = Vec::new();
    for tile in 0..WIDTH.div_ceil(8) * HEIGHT.div_ceil(8) {
        for i in 0..64 {
            let x = tile % WIDTH.div_ceil(8) * 8 + ((i & 3) | ((i >> 1) & 4));
            let y = tile / WIDTH.div_ceil(8) * 8 + (((i >> 2) & 1) | ((i >> 3) & 6));
            if x < WIDTH && y < HEIGHT {
                let u = ((x as f32 + 0.5) / WIDTH as f32 * 2.0 - 1.0) * half * WIDTH as f32
                    / HEIGHT as f32;
                let v = ((y as f32 + 0.5) / HEIGHT as f32 * 2.0 - 1.0) * half;
                primary.push(RayQuery {
                    origin: eye,
                    t_max: 1e30,
                    direction: (right * u - up * v - back).normalize(),
                    any: 0,
                });
            }
        }
    }
    let mut shadow = Vec::new();
    let mut bounce = Vec::new();
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / 4_294_967_296.0
    };
    for query in &primary {
        if let Some((t, id)) = cpu.closest(query) {
            let n = Vec3::from(cpu.triangles[id].compute_normal());
            let n = if n.dot(query.direction) > 0.0 { -n } else { n };
            let origin = query.origin + query.direction * t + n * 1e-3;
            let sun = Vec3::new(30.0, 25.0, 10.0) + 4.0 * Vec3::new(random(), random(), random());
            shadow.push(RayQuery {
                origin,
                t_max: 1.0,
                direction: sun - origin,
                any: 1,
            });
            let (z, turn) = (1.0 - 2.0 * random(), std::f32::consts::TAU * random());
            let r = (1.0 - z * z).sqrt();
            let direction = (n * 1.001 + Vec3::new(r * turn.cos(), r * turn.sin(), z)).normalize();
            bounce.push(RayQuery {
                origin,
                t_max: 1e30,
                direction,
                any: 0,
            });
        }
    }
    vec![("primary", primary), ("shadow", shadow), ("bounce", bounce)]
}

fn processor_seconds() -> f64 {
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    // SAFETY: the call fills the structure it is given.
    let usage = unsafe {
        libc::getrusage(libc::RUSAGE_SELF, usage.as_mut_ptr());
        usage.assume_init()
    };
    let seconds = |t: libc::timeval| t.tv_sec as f64 + t.tv_usec as f64 * 1e-6;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let counts: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    let counts = if counts.is_empty() {
        vec![100_000, 1_000_000]
    } else {
        counts
    };
    let only_cpu_bvh = std::env::var_os("HEADWATER_BENCH_NO_RAY_QUERY").is_some();
    for count in counts {
        let scene = terrain(count);
        let cpu = CpuTree::new(&scene);
        let batches = batches(&cpu);
        let mut variants = support::variants(Tracer::ComputeBvh);
        if !only_cpu_bvh {
            variants.extend(support::variants(Tracer::RayQuery).last());
        }
        let opened: Vec<_> = variants
            .into_iter()
            .filter_map(|variant| {
                let name = [
                    variant.tracer.name(),
                    variant.geometry.name(),
                    variant.fetch.name(),
                ]
                .join("/");
                let (device, _) = support::open_device(Some(variant));
                match GpuScene::new(&device, &scene, DVec3::ZERO, variant) {
                    Ok(scene) => Some((name, device, Arc::new(scene))),
                    Err(e) => {
                        println!("tracing {count} {name} cannot: {e}");
                        None
                    }
                }
            })
            .collect();
        for (kind, rays) in &batches {
            let tracers: Vec<_> = opened
                .iter()
                .map(|(name, device, scene)| {
                    (name, RayTracer::new(device, scene.clone(), rays).unwrap())
                })
                .collect();
            let mut cpu_rates = Vec::new();
            let mut results = vec![(Vec::new(), Vec::new(), Vec::new()); tracers.len()];
            let mut threads = String::new();
            let mut hits = (0, vec![0; tracers.len()]);
            for round in 0..=ROUNDS {
                let start = Instant::now();
                let (cpu_hits, times) = cpu.run(rays);
                let cpu_rate = rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6;
                hits.0 = cpu_hits;
                for (number, (_, tracer)) in tracers.iter().enumerate() {
                    let (start, busy) = (Instant::now(), processor_seconds());
                    tracer.run().unwrap();
                    let wall = start.elapsed().as_secs_f64();
                    let rate = rays.len() as f64 / wall * 1e-6;
                    // The first round compiles the shaders.
                    if round > 0 {
                        results[number].0.push(rate);
                        results[number].1.push(rate / cpu_rate);
                        results[number].2.push((processor_seconds() - busy) / wall);
                    } else {
                        let answers = tracer.answers().unwrap();
                        hits.1[number] = answers.iter().filter(|a| a.t >= 0.0).count();
                    }
                }
                if round > 0 {
                    cpu_rates.push(cpu_rate);
                    let times: Vec<String> =
                        times.iter().map(|t| format!("{:.1}", t * 1e3)).collect();
                    threads = times.join("+");
                }
            }
            println!(
                "tracing {count} {kind} obvhs-cpu rays={} hits={} mrays={:.2} threads_ms={threads}",
                rays.len(),
                hits.0,
                median(cpu_rates)
            );
            for ((name, _), (number, (rates, ratios, busy))) in
                tracers.iter().zip(results.into_iter().enumerate())
            {
                println!(
                    "tracing {count} {kind} {name} hits={} mrays={:.2} ratio={:.2} busy={:.2}",
                    hits.1[number],
                    median(rates),
                    median(ratios),
                    median(busy)
                );
            }
        }
    }
}
