//! The independent truth: a plain path tracer on the CPU in f64.
//!
//! It shares with the renderer only the scene's description. The surface model is written from
//! glTF 2.0, appendix B, the tree, the sampling and the random numbers are its own, and no roulette
//! is played; where both agree, neither has it wrong by accident.

mod random;

use glam::{DMat3, DVec3};
use headwater::scene::{Camera, Material, Scene};
use random::Draws;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};

/// Below this roughness the specular lobe is a perfect mirror.
const MIRROR_ROUGHNESS: f64 = 1e-3;
/// The weights of linear Rec. 709.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);
/// Triangles of a leaf.
const LEAF: usize = 2;

/// How a picture is made.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// 0: emission only; n: up to n scattering events.
    pub bounces: u32,
    /// Paths a pixel, all through its centre; stratified in groups of the largest power of two
    /// that divides them, so powers of two are best.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether lights are sampled too (and weighed against the surface's sampling by the balance
    /// heuristic), or else found by chance alone.
    pub nee: bool,
}

/// Row by row from the top.
pub struct Image {
    /// Mean radiance.
    pub mean: Vec<[f64; 3]>,
    /// Squared standard errors of the means.
    pub error_squared: Vec<[f64; 3]>,
    /// Independent groups of paths that each pixel's error comes from.
    pub groups: u32,
}

/// The closest crossing of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the direction.
    pub t: f64,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
}

struct Triangle {
    corners: [DVec3; 3],
    /// Unit normal of the front.
    normal: DVec3,
    /// Shading normals at the corners, carried to the world but not unit.
    corner_normals: Option<[DVec3; 3]>,
    instance: u32,
    triangle: u32,
    material: usize,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// First triangle of a leaf, or else the first of two neighbouring children.
    first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    count: u32,
}

struct Light {
    triangle: usize,
    /// Sum of the weights up to and with this light, of 1.
    cumulative: f64,
}

/// The surface model with what a material gives it.
struct Surface {
    base_color: DVec3,
    metallic: f64,
    alpha: f64,
    mirror: bool,
    dielectric_f0: DVec3,
    dielectric_f90: f64,
    emission: DVec3,
    double_sided: bool,
    /// Density of light sampling over area; 0 if it does not emit.
    light_pdf_area: f64,
}

/// A scene in world space, ready to be traced.
pub struct Tracer {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    surfaces: Vec<Surface>,
    lights: Vec<Light>,
    /// Rays that leave a surface meet nothing nearer.
    t_min: f64,
}

impl Tracer {
    /// Carries `scene` to world space and builds the tree over it.
    pub fn new(scene: &Scene) -> Self {
        let mut triangles = Vec::new();
        for (number, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh as usize];
            let to_world = instance.object_to_world;
            let normals_to_world: DMat3 = to_world.matrix3.inverse().transpose();
            for part in &mesh.parts {
                for index in part.first_triangle..part.first_triangle + part.triangle_count {
                    let corners = mesh.triangles[index as usize].map(|i| i as usize);
                    let local = corners.map(|i| mesh.positions[i].as_dvec3());
                    let cross = (local[1] - local[0]).cross(local[2] - local[0]);
                    triangles.push(Triangle {
                        corners: local.map(|p| to_world.transform_point3(p)),
                        normal: (normals_to_world * cross.normalize_or_zero()).normalize_or_zero(),
                        corner_normals: (!mesh.normals.is_empty()).then(|| {
                            corners.map(|i| normals_to_world * mesh.normals[i].as_dvec3())
                        }),
                        instance: number as u32,
                        triangle: index,
                        material: part.material as usize,
                    });
                }
            }
        }
        let nodes = build(&mut triangles);
        let scale = nodes.first().map_or(0.0, |n| (n.high - n.low).length());
        let mut tracer = Self {
            triangles,
            nodes,
            surfaces: scene.materials.iter().map(Surface::new).collect(),
            lights: Vec::new(),
            t_min: 1e-9 * scale,
        };
        tracer.list_lights();
        tracer
    }

    /// Gives each emitter its share of the picks: by area × luminance.
    fn list_lights(&mut self) {
        let mut total = 0.0;
        for (index, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = triangle.corners;
            let area = 0.5 * (b - a).cross(c - a).length();
            let weight = area * self.surfaces[triangle.material].emission.dot(LUMINANCE);
            if weight > 0.0 {
                total += weight;
                let cumulative = total;
                self.lights.push(Light {
                    triangle: index,
                    cumulative,
                });
            }
        }
        for light in &mut self.lights {
            light.cumulative /= total;
        }
        if total > 0.0 {
            for surface in &mut self.surfaces {
                surface.light_pdf_area = surface.emission.dot(LUMINANCE) / total;
            }
        }
    }

    /// The closest crossing with 0 < t < `t_max`. The direction need not be of unit length.
    pub fn closest(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        let (index, t, u, v) = self.crossing(origin, direction, 0.0, t_max, usize::MAX, false)?;
        let triangle = &self.triangles[index];
        Some(Hit {
            t,
            instance: triangle.instance,
            triangle: triangle.triangle,
            u,
            v,
        })
    }

    /// How far from the triangle's nearest edge the ray crosses its plane, positive inside and
    /// negative outside, relative to the larger of the crossing's distances from the world's and
    /// from the ray's origin; infinite where the ray does not cross the plane.
    pub fn edge_distance(
        &self,
        origin: DVec3,
        direction: DVec3,
        instance: u32,
        triangle: u32,
    ) -> f64 {
        let found = self
            .triangles
            .iter()
            .find(|t| t.instance == instance && t.triangle == triangle);
        let [a, b, c] = found.expect("no such triangle").corners;
        let normal = (b - a).cross(c - a);
        let t = (a - origin).dot(normal) / direction.dot(normal);
        if !t.is_finite() || t <= 0.0 {
            return f64::INFINITY;
        }
        let point = origin + direction * t;
        let mut inside = true;
        let mut nearest = f64::INFINITY;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = to - from;
            let along = ((point - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            nearest = nearest.min((point - from - edge * along).length());
            inside &= normal.cross(edge).dot(point - from) >= 0.0;
        }
        let relative = nearest / point.length().max(t * direction.length());
        if inside { relative } else { -relative }
    }

    /// The closest crossing, or any one, as (index, t, u, v).
    fn crossing(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_min: f64,
        t_max: f64,
        skip: usize,
        any: bool,
    ) -> Option<(usize, f64, f64, f64)> {
        // A tiny component instead of 0 keeps 0 · ∞ out of the slabs.
        let safe = |d: f64| {
            if d.abs() < 1e-150 {
                1e-150_f64.copysign(d)
            } else {
                d
            }
        };
        let inverse = DVec3::new(safe(direction.x), safe(direction.y), safe(direction.z)).recip();
        let mut best = None;
        let mut t_max = t_max;
        let enter = |n: u32, t_max: f64| self.nodes[n as usize].entered(origin, inverse, t_max);
        let mut stack = [(0_u32, 0.0); 64];
        let mut height = 0;
        if !self.nodes.is_empty() && enter(0, t_max) < f64::INFINITY {
            height = 1;
        }
        while height > 0 {
            height -= 1;
            let (number, entered) = stack[height];
            if entered > t_max {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count == 0 {
                let mut near = (node.first, enter(node.first, t_max));
                let mut far = (node.first + 1, enter(node.first + 1, t_max));
                if far.1 < near.1 {
                    (near, far) = (far, near);
                }
                for child in [far, near] {
                    if child.1 < f64::INFINITY {
                        stack[height] = child;
                        height += 1;
                    }
                }
                continue;
            }
            for index in node.first as usize..(node.first + node.count) as usize {
                if index == skip {
                    continue;
                }
                if let Some((t, u, v)) = self.triangles[index].meets(origin, direction)
                    && t > t_min
                    && t < t_max
                {
                    best = Some((index, t, u, v));
                    t_max = t;
                    if any {
                        return best;
                    }
                }
            }
        }
        best
    }

    /// The picture that `camera` sees.
    pub fn render(&self, camera: &Camera, width: u32, height: u32, options: &Options) -> Image {
        let count = (width * height) as usize;
        let mut image = Image {
            mean: vec![[0.0; 3]; count],
            error_squared: vec![[0.0; 3]; count],
            groups: options.samples / Draws::group(options.samples),
        };
        let next_row = AtomicU32::new(0);
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        let work = || {
            let mut rows = Vec::new();
            loop {
                let y = next_row.fetch_add(1, Ordering::Relaxed);
                if y >= height {
                    return rows;
                }
                let row = (0..width).map(|x| self.pixel(camera, [x, y], [width, height], options));
                rows.push((y, row.collect::<Vec<_>>()));
            }
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            for worker in workers {
                for (y, row) in worker.join().unwrap() {
                    for (x, (mean, error_squared)) in row.into_iter().enumerate() {
                        let at = y as usize * width as usize + x;
                        image.mean[at] = mean.to_array();
                        image.error_squared[at] = error_squared.to_array();
                    }
                }
            }
        });
        image
    }

    fn pixel(
        &self,
        camera: &Camera,
        [x, y]: [u32; 2],
        [width, height]: [u32; 2],
        options: &Options,
    ) -> (DVec3, DVec3) {
        let (origin, direction) = camera_ray(camera, [x, y], [width, height]);
        let group = Draws::group(options.samples);
        let groups = options.samples / group;
        let mut random = Draws::new(options.seed, u64::from(y * width + x), group);
        // Welford's running mean and sum of squared deviations, over groups: the paths of one are
        // not independent.
        let (mut mean, mut spread) = (DVec3::ZERO, DVec3::ZERO);
        for n in 1..=groups {
            random.deal();
            let mut value = DVec3::ZERO;
            for path in 0..group {
                random.path(path);
                value += self.path(origin, direction, options, &mut random);
            }
            value /= f64::from(group);
            let before = value - mean;
            mean += before / f64::from(n);
            spread += before * (value - mean);
        }
        let n = f64::from(groups);
        (mean, spread / (n * (n - 1.0).max(1.0)))
    }

    /// One path's radiance.
    fn path(
        &self,
        mut origin: DVec3,
        mut direction: DVec3,
        options: &Options,
        random: &mut Draws,
    ) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        // How the ray was sampled; none where lights could not have been sampled instead.
        let mut pdf_solid_angle = None;
        let mut skip = usize::MAX;
        let mut t_min = 0.0;
        for scatterings in 0..=options.bounces {
            let found = self.crossing(origin, direction, t_min, f64::INFINITY, skip, false);
            let Some((index, t, u, v)) = found else {
                break;
            };
            let triangle = &self.triangles[index];
            let surface = &self.surfaces[triangle.material];
            let facing = -triangle.normal.dot(direction);
            if surface.emits(facing) {
                let weight = pdf_solid_angle.map_or(1.0, |pdf: f64| {
                    pdf / (pdf + surface.light_pdf_area * t * t / facing.abs())
                });
                radiance += throughput * surface.emission * weight;
            }
            if scatterings == options.bounces {
                break;
            }
            let [a, b, c] = triangle.corners;
            let position = a * (1.0 - u - v) + b * u + c * v;
            let geometric = triangle.normal * if facing < 0.0 { -1.0 } else { 1.0 };
            let mut shading = triangle.shading_normal(geometric, u, v);
            // A normal that looks away from the eye is bent until its cosine is a hundredth.
            let facing = -shading.dot(direction);
            if facing < 0.01 {
                shading = (shading - (0.01 - facing) * direction).normalize();
            }
            let frame = Frame::new(shading, geometric);
            let outgoing = frame.to_local(-direction);
            if outgoing.z <= 0.0 {
                break;
            }

            if options.nee && !self.lights.is_empty() {
                let arrives = self.sampled_light(index, position, &frame, outgoing, random);
                radiance += throughput * arrives;
            }

            let Some(sample) = surface.sample(outgoing, random) else {
                break;
            };
            direction = frame.to_world(sample.direction);
            if direction.dot(geometric) <= 0.0 {
                break;
            }
            throughput *= sample.weight;
            pdf_solid_angle = sample.pdf_solid_angle.filter(|_| options.nee);
            origin = position;
            skip = index;
            t_min = self.t_min;
        }
        radiance
    }

    /// Light reflected to `outgoing` from one point sampled on the lights, with its MIS weight.
    fn sampled_light(
        &self,
        index: usize,
        position: DVec3,
        frame: &Frame,
        outgoing: DVec3,
        random: &mut Draws,
    ) -> DVec3 {
        let pick = random.unit();
        let picked = self.lights.partition_point(|l| l.cumulative <= pick);
        let light = &self.triangles[self.lights[picked.min(self.lights.len() - 1)].triangle];
        // Fold the square onto the triangle.
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = light.corners;
        let toward = a + (b - a) * u + (c - a) * v - position;
        let distance = toward.length();
        if distance <= self.t_min {
            return DVec3::ZERO;
        }
        let direction = toward / distance;
        let facing = -light.normal.dot(direction);
        let emitter = &self.surfaces[light.material];
        if !emitter.emits(facing) || direction.dot(frame.geometric) <= 0.0 {
            return DVec3::ZERO;
        }
        let incoming = frame.to_local(direction);
        let surface = &self.surfaces[self.triangles[index].material];
        let f = surface.evaluate(outgoing, incoming);
        if f == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let end = distance - self.t_min;
        let blocked = self.crossing(position, direction, self.t_min, end, index, true);
        if blocked.is_some() {
            return DVec3::ZERO;
        }
        let pdf_light = emitter.light_pdf_area * distance * distance / facing.abs();
        let pdf_surface = surface.pdf_solid_angle(outgoing, incoming);
        f * emitter.emission * (incoming.z / (pdf_light + pdf_surface))
    }
}

/// Origin and unit direction through a pixel's centre.
pub fn camera_ray(camera: &Camera, pixel: [u32; 2], size: [u32; 2]) -> (DVec3, DVec3) {
    let [x, y] = pixel.map(|p| f64::from(p) + 0.5);
    let [width, height] = size.map(f64::from);
    let half = (0.5 * camera.vertical_fov).tan();
    let local = DVec3::new(
        (2.0 * x / width - 1.0) * half * width / height,
        (1.0 - 2.0 * y / height) * half,
        -1.0,
    );
    let to_world = camera.camera_to_world;
    (
        to_world.translation,
        to_world.transform_vector3(local).normalize(),
    )
}

impl Triangle {
    /// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997: (t, u, v).
    fn meets(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
        let [a, b, c] = self.corners;
        let (edge1, edge2) = (b - a, c - a);
        let p = direction.cross(edge2);
        let determinant = edge1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let from = origin - a;
        let u = from.dot(p) / determinant;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = from.cross(edge1);
        let v = direction.dot(q) / determinant;
        if v < 0.0 || u + v > 1.0 {
            return None;
        }
        Some((edge2.dot(q) / determinant, u, v))
    }

    /// Unit shading normal on the side of `geometric`.
    fn shading_normal(&self, geometric: DVec3, u: f64, v: f64) -> DVec3 {
        let Some([a, b, c]) = self.corner_normals else {
            return geometric;
        };
        let normal = (a * (1.0 - u - v) + b * u + c * v).normalize_or(geometric);
        if normal.dot(geometric) < 0.0 {
            -normal
        } else {
            normal
        }
    }
}

impl Node {
    /// Where a ray comes in, before `t_max`; infinite if it does not.
    fn entered(&self, origin: DVec3, inverse: DVec3, t_max: f64) -> f64 {
        let (to_low, to_high) = (
            (self.low - origin) * inverse,
            (self.high - origin) * inverse,
        );
        let enter = to_low.min(to_high).max_element().max(0.0);
        let leave = to_low.max(to_high).min_element().min(t_max);
        if enter * (1.0 - 1e-12) <= leave {
            enter * (1.0 - 1e-12)
        } else {
            f64::INFINITY
        }
    }
}

/// A tree by splitting at the median of the widest axis of the centres; sorts the triangles.
fn build(triangles: &mut [Triangle]) -> Vec<Node> {
    let mut nodes = Vec::new();
    if triangles.is_empty() {
        return nodes;
    }
    let node = |triangles: &[Triangle], first: usize| {
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let low = corners().reduce(DVec3::min).unwrap();
        let high = corners().reduce(DVec3::max).unwrap();
        // Room for the rounding of the slabs.
        let pad = DVec3::splat(1e-13 * (low.abs().max_element() + high.abs().max_element()));
        Node {
            low: low - pad,
            high: high + pad,
            first: first as u32,
            count: triangles.len() as u32,
        }
    };
    nodes.push(node(triangles, 0));
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        let (first, count) = (nodes[at].first as usize, nodes[at].count as usize);
        if count <= LEAF {
            continue;
        }
        let own = &mut triangles[first..first + count];
        let centre = |t: &Triangle| t.corners[0] + t.corners[1] + t.corners[2];
        let low = own.iter().map(centre).reduce(DVec3::min).unwrap();
        let high = own.iter().map(centre).reduce(DVec3::max).unwrap();
        let axis = (high - low).max_position();
        let half = count / 2;
        own.select_nth_unstable_by(half, |a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
        let (left, right) = own.split_at(half);
        let children = [node(left, first), node(right, first + half)];
        nodes[at].first = nodes.len() as u32;
        nodes[at].count = 0;
        open.extend([nodes.len(), nodes.len() + 1]);
        nodes.extend(children);
    }
    nodes
}

/// A shading point's axes, the shading normal +Z.
struct Frame {
    axes: DMat3,
    geometric: DVec3,
}

impl Frame {
    fn new(shading: DVec3, geometric: DVec3) -> Self {
        let (x, y) = shading.any_orthonormal_pair();
        Self {
            axes: DMat3::from_cols(x, y, shading),
            geometric,
        }
    }

    fn to_local(&self, world: DVec3) -> DVec3 {
        self.axes.transpose() * world
    }

    fn to_world(&self, local: DVec3) -> DVec3 {
        self.axes * local
    }
}

struct Sampled {
    direction: DVec3,
    /// f · cos / pdf.
    weight: DVec3,
    /// None for a mirror.
    pdf_solid_angle: Option<f64>,
}

impl Surface {
    fn new(material: &Material) -> Self {
        let roughness = f64::from(material.roughness);
        let ior = f64::from(material.ior);
        let specular = f64::from(material.specular);
        let normal_incidence = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let tinted = material.specular_color.as_dvec3() * normal_incidence;
        Self {
            base_color: material.base_color.as_dvec3(),
            metallic: f64::from(material.metallic),
            alpha: roughness * roughness,
            mirror: roughness < MIRROR_ROUGHNESS,
            dielectric_f0: tinted.min(DVec3::ONE) * specular,
            dielectric_f90: specular,
            emission: material.emission.as_dvec3(),
            double_sided: material.double_sided,
            light_pdf_area: 0.0,
        }
    }

    /// Whether light leaves towards a direction whose cosine with the front is `facing`.
    fn emits(&self, facing: f64) -> bool {
        self.emission != DVec3::ZERO && (facing > 0.0 || (self.double_sided && facing < 0.0))
    }

    /// Fresnel reflectance of the dielectric and of the whole specular lobe (Schlick 1994).
    fn fresnel(&self, cosine: f64) -> (DVec3, DVec3) {
        let grazing = (1.0 - cosine).clamp(0.0, 1.0).powi(5);
        let schlick = |f0: DVec3, f90: f64| f0 * (1.0 - grazing) + DVec3::splat(f90 * grazing);
        let dielectric = schlick(self.dielectric_f0, self.dielectric_f90);
        let metal = schlick(self.base_color, 1.0);
        (dielectric, dielectric.lerp(metal, self.metallic))
    }

    /// f, without a mirror's lobe; directions in the shading frame.
    fn evaluate(&self, outgoing: DVec3, incoming: DVec3) -> DVec3 {
        if outgoing.z <= 0.0 || incoming.z <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (outgoing + incoming).normalize();
        let (dielectric, specular) = self.fresnel(outgoing.dot(half));
        let under = (1.0 - self.metallic) * (1.0 - dielectric.max_element());
        let mut f = self.base_color * (under / PI);
        if !self.mirror {
            // V of glTF 2.0, appendix B: Smith's masking, correlated by height, over 4 cos cos.
            let v = 0.5
                / (incoming.z * self.stretched(outgoing.z)
                    + outgoing.z * self.stretched(incoming.z));
            f += specular * (self.distribution(half.z) * v);
        }
        f
    }

    /// √(cos² (1 − α²) + α²).
    fn stretched(&self, cosine: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        (cosine * cosine * (1.0 - a2) + a2).sqrt()
    }

    /// GGX (Trowbridge and Reitz 1975; Walter et al. 2007).
    fn distribution(&self, cosine: f64) -> f64 {
        let a2 = self.alpha * self.alpha;
        let d = cosine * cosine * (a2 - 1.0) + 1.0;
        a2 / (PI * d * d)
    }

    /// Probability of sampling the specular lobe.
    fn specular_probability(&self, outgoing: DVec3) -> f64 {
        if self.metallic == 0.0 && self.dielectric_f90 == 0.0 {
            return 0.0;
        }
        let (dielectric, specular) = self.fresnel(outgoing.z);
        let below = self.base_color * (1.0 - self.metallic) * (1.0 - dielectric.max_element());
        if self.metallic == 1.0 || self.base_color == DVec3::ZERO {
            return 1.0;
        }
        let (specular, below) = (specular.dot(LUMINANCE), below.dot(LUMINANCE));
        (specular / (specular + below)).clamp(0.15, 0.85)
    }

    /// Density of [`Self::sample`], without a mirror's lobe.
    fn pdf_solid_angle(&self, outgoing: DVec3, incoming: DVec3) -> f64 {
        let chance = self.specular_probability(outgoing);
        let mut pdf = (1.0 - chance) * incoming.z / PI;
        if !self.mirror && chance > 0.0 {
            // Visible normals, G1 D (o·h) / o.z, over the reflection's 4 (o·h).
            let half = (outgoing + incoming).normalize();
            let visible = 2.0 * (outgoing.z + self.stretched(outgoing.z));
            pdf += chance * self.distribution(half.z) / visible;
        }
        pdf
    }

    fn sample(&self, outgoing: DVec3, random: &mut Draws) -> Option<Sampled> {
        let chance = self.specular_probability(outgoing);
        let (lobe, u, v) = (random.unit(), random.unit(), random.unit());
        let direction = if lobe < chance {
            if self.mirror {
                let (_, specular) = self.fresnel(outgoing.z);
                return Some(Sampled {
                    direction: DVec3::new(-outgoing.x, -outgoing.y, outgoing.z),
                    weight: specular / chance,
                    pdf_solid_angle: None,
                });
            }
            let half = self.visible_normal(outgoing, u, v);
            half * (2.0 * outgoing.dot(half)) - outgoing
        } else {
            // Cosine-weighted (Malley's method).
            let (sin, cos) = (TAU * v).sin_cos();
            DVec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt())
        };
        if direction.z <= 0.0 {
            return None;
        }
        let pdf = self.pdf_solid_angle(outgoing, direction);
        Some(Sampled {
            direction,
            weight: self.evaluate(outgoing, direction) * (direction.z / pdf),
            pdf_solid_angle: Some(pdf),
        })
    }

    /// Heitz, "Sampling the GGX Distribution of Visible Normals", 2018.
    fn visible_normal(&self, outgoing: DVec3, u: f64, v: f64) -> DVec3 {
        let alpha = DVec3::new(self.alpha, self.alpha, 1.0);
        let view = (outgoing * alpha).normalize();
        let flat = view.x * view.x + view.y * view.y;
        let across = if flat > 0.0 {
            DVec3::new(-view.y, view.x, 0.0) / flat.sqrt()
        } else {
            DVec3::X
        };
        let up = view.cross(across);
        let (sin, cos) = (TAU * v).sin_cos();
        let (x, y) = (u.sqrt() * cos, u.sqrt() * sin);
        let s = 0.5 * (1.0 + view.z);
        let y = (1.0 - s) * (1.0 - x * x).sqrt() + s * y;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let normal = across * x + up * y + view * z;
        (normal * alpha).with_z(normal.z.max(0.0)).normalize()
    }
}
