//! Emissive triangles, and the alias table that samples them.

use super::texture::{LitTexels, srgb};
use super::{
    AlphaMode, Bounds, Material, Mesh, Part, PunctualLight, PunctualShape, Scene, Texture,
};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::collections::{BTreeSet, HashMap};

/// The fraction of the sampling probability that is uniform over the lights, so that no light's probability falls below the
/// resolution of 32 random bits, however dim it is.
pub const UNIFORM_SHARE: f64 = 0.1;

/// An emissive triangle in world space.
#[derive(Clone, Copy, Debug)]
pub struct LightTriangle {
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Corners in the scene's units.
    pub corners: [DVec3; 3],
    /// Unit normal of the counter-clockwise side, which is the one that emits.
    pub normal: DVec3,
    /// Area in squared scene units.
    pub area: f64,
    /// The mean factor of its emission: the mean of its texture, with 0 where it has holes.
    pub emission_mean: Vec3,
}

/// An emissive triangle in object space.
#[derive(Clone, Copy, Debug)]
pub struct EmitterTriangle {
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Corners in the mesh's units.
    pub corners: [DVec3; 3],
    /// Texture coordinates of the corners for its emissive texture; 0 without.
    pub uvs: [Vec2; 3],
    /// The mean factor of its emission: the mean of its texture, with 0 where it has holes.
    pub emission_mean: Vec3,
}

/// The name of an emitter: an instance and a material, whose triangles form the emitter; or no instance and the index of a
/// punctual light. The environment has the index after the last punctual light.
pub type EmitterName = (Option<u32>, u32);

impl LightTriangle {
    /// The emitter to which the triangle belongs.
    pub fn emitter(&self) -> EmitterName {
        (Some(self.instance), self.material)
    }
}

impl EmitterTriangle {
    /// The triangle in world space.
    pub fn placed(&self, object_to_world: &DAffine3) -> LightTriangle {
        // The front side is defined in object space, so a mirroring transform reverses the winding.
        let side = object_to_world.matrix3.determinant().signum();
        let corners = self.corners.map(|p| object_to_world.transform_point3(p));
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        LightTriangle {
            instance: self.instance,
            triangle: self.triangle,
            material: self.material,
            corners,
            normal: cross.normalize_or_zero() * side,
            area: 0.5 * cross.length(),
            emission_mean: self.emission_mean,
        }
    }
}

impl Scene {
    /// True if some material that is a light at any time has an emissive texture.
    pub fn has_textured_lights(&self) -> bool {
        let mut materials = self.materials.iter().zip(self.emitter_materials());
        materials.any(|(material, is_emitter)| is_emitter && material.emissive_texture.is_some())
    }

    /// True for each material that is a light: it emits now or, if the scene moves, at another time.
    pub fn emitter_materials(&self) -> Vec<bool> {
        let mut lights: Vec<bool> = self.materials.iter().map(|m| m.is_emissive()).collect();
        for emission in self.motion.iter().flat_map(|motion| &motion.emission) {
            lights[emission.material as usize] = true;
        }
        lights
    }

    /// The materials, with the largest emission that they have at any time.
    pub fn brightest_materials(&self) -> Vec<Material> {
        let mut brightest = self.materials.clone();
        for emission in self.motion.iter().flat_map(|motion| &motion.emission) {
            brightest[emission.material as usize].emission = emission.brightest();
        }
        brightest
    }
}

/// The choice of the triangles that emit at some time: all triangles with an emissive material, except where the emissive
/// texture is black over the whole triangle.
pub struct Emitters<'a> {
    scene: &'a Scene,
    /// True for each material that emits at some time.
    emitter_materials: &'a [bool],
    /// The parts that are not black, for each image that is an emissive texture.
    lit: HashMap<u32, LitTexels>,
}

impl<'a> Emitters<'a> {
    /// The choice for a scene; `emitter_materials` are its [`Scene::emitter_materials`].
    pub fn new(scene: &'a Scene, emitter_materials: &'a [bool]) -> Self {
        let materials = scene.materials.iter().zip(emitter_materials);
        let textures = materials.filter(|(_, is_emitter)| **is_emitter);
        let images: BTreeSet<u32> = textures
            .filter_map(|(material, _)| Some(material.emissive_texture?.image))
            .collect();
        let lit = images.into_iter();
        let lit = lit.map(|image| (image, LitTexels::of(&scene.images[image as usize])));
        Self {
            scene,
            emitter_materials,
            lit: lit.collect(),
        }
    }

    /// True if triangles of a mesh's part may emit.
    pub fn may_emit(&self, part: &Part) -> bool {
        self.emitter_materials[part.material as usize]
    }

    /// True if a triangle of a mesh's part emits.
    pub fn emits(&self, mesh: &Mesh, part: &Part, triangle: u32) -> bool {
        let texture = self.scene.materials[part.material as usize].emissive_texture;
        self.may_emit(part)
            && texture.is_none_or(|texture| {
                let uvs = uvs_of(mesh, &texture, triangle);
                self.lit[&texture.image].may_be_seen(&texture, uvs)
            })
    }

    /// The number of emissive triangles in a mesh's part.
    pub fn count(&self, mesh: &Mesh, part: &Part) -> u64 {
        let texture = self.scene.materials[part.material as usize].emissive_texture;
        match (self.may_emit(part), texture) {
            (false, _) => 0,
            (true, None) => part.triangle_count.into(),
            (true, Some(_)) => {
                let emit = |triangle: &u32| self.emits(mesh, part, *triangle);
                part.range().filter(emit).count() as u64
            }
        }
    }
}

/// The coordinates of a texture at the corners of a triangle.
fn uvs_of(mesh: &Mesh, texture: &Texture, triangle: u32) -> [Vec2; 3] {
    let corners = mesh.triangles[triangle as usize];
    corners.map(|i| mesh.uvs[texture.set as usize][i as usize])
}

/// The triangles that give light, for the given emissive materials, ordered by instance, then by the mesh's order of triangles.
pub fn emitter_triangles(scene: &Scene, emitter_materials: &[bool]) -> Vec<EmitterTriangle> {
    let emitters = Emitters::new(scene, emitter_materials);
    let mut triangles = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        for part in &mesh.parts {
            for triangle in part.range().filter(|t| emitters.emits(mesh, part, *t)) {
                let corners = mesh.triangles[triangle as usize];
                let material = &scene.materials[part.material as usize];
                let uvs = (material.emissive_texture.as_ref())
                    .map_or([Vec2::ZERO; 3], |texture| uvs_of(mesh, texture, triangle));
                triangles.push(EmitterTriangle {
                    instance: index as u32,
                    triangle,
                    material: part.material,
                    corners: corners.map(|i| mesh.positions[i as usize].as_dvec3()),
                    uvs,
                    emission_mean: emission_mean(scene, mesh, material, triangle),
                });
            }
        }
    }
    triangles
}

/// The mean over a triangle of the factor of its emission, from points on a grid. It is above 0, because light samples must
/// also find lit areas between the points.
fn emission_mean(scene: &Scene, mesh: &Mesh, material: &Material, triangle: u32) -> Vec3 {
    const SIDE: usize = 8;
    let mask = match material.alpha_mode {
        AlphaMode::Mask { cutoff } => Some(cutoff),
        _ => None,
    };
    if material.emissive_texture.is_none() && mask.is_none() {
        return Vec3::ONE;
    }
    let at = |texture: &Texture, weights: Vec2| {
        let [a, b, c] = uvs_of(mesh, texture, triangle);
        let uv = a + weights.x * (b - a) + weights.y * (c - a);
        texture.at(&scene.images[texture.image as usize], uv, srgb)
    };
    let alphas = match mesh.colors.is_empty() {
        true => [1.0; 3],
        false => mesh.triangles[triangle as usize].map(|i| mesh.colors[i as usize].w),
    };
    let mut sum = Vec3::ZERO;
    // The centres of the small triangles into which a grid divides the large one.
    for i in 0..SIDE {
        for j in 0..2 * (SIDE - i) - 1 {
            let third = if j % 2 == 0 { 1.0 } else { 2.0 } / 3.0;
            let weights = Vec2::new((j / 2) as f32 + third, i as f32 + third) / SIDE as f32;
            let [a, b, c] = alphas;
            let own = material.alpha * (a + weights.x * (b - a) + weights.y * (c - a));
            let texture = material.base_color_texture.as_ref();
            let alpha = own * texture.map_or(1.0, |texture| at(texture, weights).w);
            if mask.is_none_or(|cutoff| alpha >= cutoff) {
                let texture = material.emissive_texture.as_ref();
                sum += texture.map_or(Vec3::ONE, |texture| at(texture, weights).truncate());
            }
        }
    }
    if sum == Vec3::ZERO {
        // As if half of a point were lit.
        sum = Vec3::splat(0.5);
    }
    sum / (SIDE * SIDE) as f32
}

/// The scene's lights, in the order of [`emitter_triangles`].
pub fn light_triangles(scene: &Scene) -> Vec<LightTriangle> {
    emitter_triangles(scene, &scene.emitter_materials())
        .iter()
        .map(|light| light.placed(&scene.instances[light.instance as usize].object_to_world))
        .collect()
}

/// A light's sampling weight before the uniform fraction is mixed in: area × luminance, doubled for a light that emits on both
/// sides.
pub fn power(light: &LightTriangle, material: &Material) -> f64 {
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    sides * light.area * luminance(material.emission * light.emission_mean)
}

/// The powers of lights of all kinds. The power of an infinitely distant light is the power that falls on a disc around the
/// scene.
#[derive(Clone, Copy, Debug)]
pub struct LightPowers {
    /// The area of the disc over π: half the scene's diagonal, squared.
    disc: f64,
    /// The integral of the environment's luminance over the sphere.
    environment: Option<f64>,
}

impl LightPowers {
    /// The powers of a scene's lights, given the integral of the environment's luminance.
    pub fn of(scene: &Scene, environment: Option<f64>) -> Self {
        let bounds = Bounds::around(scene.loose_boxes().into_iter());
        Self {
            disc: bounds.map_or(1.0, |bounds| 0.25 * bounds.size().length_squared()),
            environment,
        }
    }

    /// The power over π of each light of all kinds, in the scene's units: of triangles as in [`power`], of punctual lights, and
    /// of the environment.
    pub fn of_all(
        &self,
        triangles: &[LightTriangle],
        materials: &[Material],
        punctual: &[PunctualLight],
    ) -> Vec<f64> {
        let powers = triangles.iter();
        let mut powers: Vec<f64> = powers
            .map(|light| power(light, &materials[light.material as usize]))
            .collect();
        powers.extend(punctual.iter().map(|light| self.punctual_power(light)));
        powers.extend(self.environment.map(|integral| integral * self.disc));
        powers
    }

    fn punctual_power(&self, light: &PunctualLight) -> f64 {
        let area = match light.shape {
            PunctualShape::Point => 4.0,
            PunctualShape::Spot { outer, .. } => 4.0 * (outer / 2.0).sin().powi(2),
            PunctualShape::Directional => self.disc,
        };
        area * luminance(light.intensity)
    }
}

/// The emitter to which each of `count` lights of all kinds belongs.
pub fn emitter_names(
    triangles: &[LightTriangle],
    count: usize,
) -> impl Iterator<Item = EmitterName> {
    let others = (0..count - triangles.len()).map(|index| (None, index as u32));
    triangles.iter().map(LightTriangle::emitter).chain(others)
}

/// Luminance of a colour in linear sRGB (ITU-R BT.709).
pub fn luminance(color: Vec3) -> f64 {
    color.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// One column of an alias table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AliasColumn {
    /// The threshold below which 32 random bits select the column's entry.
    pub keep_below: u32,
    /// The index of the entry that is selected otherwise.
    pub alias: u32,
}

/// A table that samples entry i with a probability close to `weights[i]` / Σ, mixed with a uniform fraction, in constant time
/// (Walker 1977; Vose 1991).
#[derive(Clone, Debug)]
pub struct AliasTable {
    /// One column per entry.
    pub columns: Vec<AliasColumn>,
    /// Each entry's exact probability by the table's integers; estimators divide by it.
    pub probabilities: Vec<f64>,
}

impl AliasTable {
    /// A table for finite weights ≥ 0; if all are 0, the entries are equally likely.
    pub fn new(weights: &[f64], uniform_share: f64) -> Self {
        let count = weights.len();
        let total: f64 = weights.iter().sum();
        let is_used = |weight: &f64| *weight > 0.0 || total == 0.0;
        // Entries without a weight get no share: lights without power would waste candidates.
        let used = weights.iter().filter(|weight| is_used(weight)).count();
        let share = if total > 0.0 { uniform_share } else { 1.0 };
        let uniform = share * (count as f64 / used as f64);
        // The mean height is 1: columns below it are filled up from columns above it.
        let mut heights: Vec<f64> = weights
            .iter()
            .map(|w| {
                let own = if total > 0.0 { w / total } else { 0.0 };
                let uniform = if is_used(w) { uniform } else { 0.0 };
                (1.0 - share) * own * count as f64 + uniform
            })
            .collect();
        let mut columns: Vec<AliasColumn> = (0..count as u32)
            .map(|alias| AliasColumn {
                keep_below: u32::MAX,
                alias,
            })
            .collect();
        let (mut low, mut high): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|&i| heights[i] < 1.0);
        while let (Some(&small), Some(&large)) = (low.last(), high.last()) {
            low.pop();
            columns[small] = AliasColumn {
                keep_below: (heights[small] * 2_f64.powi(32)) as u32,
                alias: large as u32,
            };
            heights[large] -= 1.0 - heights[small];
            if heights[large] < 1.0 {
                high.pop();
                low.push(large);
            }
        }
        let mut probabilities = vec![0.0; count];
        for (own, column) in columns.iter().enumerate() {
            let kept = f64::from(column.keep_below) / 2_f64.powi(32);
            probabilities[own] += kept / count as f64;
            probabilities[column.alias as usize] += (1.0 - kept) / count as f64;
        }
        Self {
            columns,
            probabilities,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_each_entry_its_weight_and_sums_to_one() {
        let weights = [0.0, 1.0, 2.0, 5.0, 1e-30, 100.0, 3.0];
        let table = AliasTable::new(&weights, UNIFORM_SHARE);
        let total: f64 = weights.iter().sum();
        assert!((table.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for (weight, got) in weights.iter().zip(&table.probabilities) {
            // The uniform share is that of the six that have a weight.
            let wanted = match *weight {
                0.0 => 0.0,
                weight => (1.0 - UNIFORM_SHARE) * weight / total + UNIFORM_SHARE / 6.0,
            };
            assert!((got - wanted).abs() < 1e-9, "{weight}: {got} {wanted}");
        }
    }

    #[test]
    fn weights_that_are_all_zero_are_picked_evenly() {
        let table = AliasTable::new(&[0.0; 5], UNIFORM_SHARE);
        assert!(table.probabilities.iter().all(|p| (p - 0.2).abs() < 1e-9));
    }

    #[test]
    fn an_empty_table_is_empty() {
        assert!(AliasTable::new(&[], UNIFORM_SHARE).columns.is_empty());
    }
}
