//! Lists the emissive triangles of a scene, computes the powers of all its lights, and builds alias tables. From an alias
//! table, a light sample draws a light in constant time. The probability of each light grows with its power.

use super::texture::{LitTexels, srgb};
use super::{
    AlphaMode, Bounds, Material, Mesh, Part, PunctualLight, PunctualShape, Scene, Texture,
};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::collections::{BTreeSet, HashMap};

/// The fraction of the light samples, in [0, 1], for which all lights with a power above 0 are equally likely. For the other
/// samples, a light's probability is in proportion to its power. Without this fraction, the alias table's 32-bit thresholds
/// would round the probability of a very dim light to 0, and pictures would lack its light.
pub const UNIFORM_FRACTION: f64 = 0.1;

/// An emissive triangle in world space, where the transform of its instance places it at one time. The renderer uploads it
/// to the device as a light, and computes the light's power, which decides how often light samples choose the light. Reports
/// on the limits of a scene are also computed from such triangles.
#[derive(Clone, Copy, Debug)]
pub struct LightTriangle {
    /// Index into [`Scene::instances`]: the instance to which the triangle belongs.
    pub instance: u32,
    /// Index of the triangle in [`Mesh::triangles`] of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`]: the material that emits.
    pub material: u32,
    /// The three corners of the triangle in world space, in scene units, in the order of the triangle's indices in
    /// [`Mesh::triangles`].
    pub corners: [DVec3; 3],
    /// Unit normal, in world space, of the side that emits: the side from which the corners are counter-clockwise in object
    /// space. It is 0 if the triangle has no area. A double-sided material emits on the opposite side too.
    pub normal: DVec3,
    /// Area in world space, in squared scene units. The power of the light is in proportion to it.
    pub area: f64,
    /// The mean, over the triangle's area, of the factor that multiplies the material's emission: linear RGB in [0, 1]. The
    /// factor is the colour of the emissive texture, or 1 if there is none, times the fraction of light that the surface
    /// blocks: 0 in the holes of an alpha mask. The power of the light is computed with this mean.
    pub emission_mean: Vec3,
}

/// An emissive triangle in object space, before the transform of its instance. It does not depend on time:
/// [`EmitterTriangle::placed`] computes from it the triangle in world space at the time of each frame.
#[derive(Clone, Copy, Debug)]
pub struct EmitterTriangle {
    /// Index into [`Scene::instances`]: the instance to which the triangle belongs.
    pub instance: u32,
    /// Index of the triangle in [`Mesh::triangles`] of the instance's mesh.
    pub triangle: u32,
    /// Index into [`Scene::materials`]: the material that emits.
    pub material: u32,
    /// The three corners of the triangle in object space, in the mesh's units. [`EmitterTriangle::placed`] transforms them
    /// to world space.
    pub corners: [DVec3; 3],
    /// The corners' texture coordinates for the emissive texture, before [`Texture::transform`] maps them to the image. With
    /// them shaders look up the emission at a point of the light. They are 0 if the material has no emissive texture.
    pub uvs: [Vec2; 3],
    /// The mean, over the triangle's area, of the factor that multiplies the material's emission: linear RGB in [0, 1]. The
    /// factor is the colour of the emissive texture, or 1 if there is none, times the fraction of light that the surface
    /// blocks: 0 in the holes of an alpha mask. The power of the light is computed with this mean.
    pub emission_mean: Vec3,
}

/// The identity of an emitter. Callers sum the powers of all lights with the same identity, and messages name the emitter by
/// it. `(Some(instance), material)` identifies all triangles of one instance that have one emissive material; both numbers
/// are indices in the scene. `(None, index)` identifies the punctual light with this index, and `(None, n)` the environment,
/// where n is the number of punctual lights.
pub type EmitterName = (Option<u32>, u32);

impl LightTriangle {
    /// The emitter to which the triangle belongs, as its instance and its material. The powers of an
    /// emitter's triangles are summed by it.
    pub fn emitter(&self) -> EmitterName {
        (Some(self.instance), self.material)
    }
}

impl EmitterTriangle {
    /// Computes the triangle in world space. `object_to_world` is the transform of the triangle's instance at the wanted
    /// time.
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
    /// True if some material that emits light at some time has an emissive texture. Only then does the device store the
    /// texture coordinates of the emissive triangles.
    pub fn has_textured_lights(&self) -> bool {
        let mut materials = self.materials.iter().zip(self.emitter_materials());
        materials.any(|(material, is_emitter)| is_emitter && material.emissive_texture.is_some())
    }

    /// One entry per material of the scene: true if the material emits light at some time. A material whose emission is
    /// animated always counts as emitting, even while it is black. Textures are not examined. Triangles of the other
    /// materials are never lights.
    pub fn emitter_materials(&self) -> Vec<bool> {
        let mut lights: Vec<bool> = self.materials.iter().map(|m| m.is_emissive()).collect();
        for emission in self.motion.iter().flat_map(|motion| &motion.emission) {
            lights[emission.material as usize] = true;
        }
        lights
    }

    /// A copy of the scene's materials in which each animated emission is replaced by an upper bound of its values at the
    /// keyframes ([`Emission::brightest`](super::motion::Emission::brightest)). Comparisons of the powers of lights use
    /// these materials, because a light that is dark now may be the brightest one at another time.
    pub fn brightest_materials(&self) -> Vec<Material> {
        let mut brightest = self.materials.clone();
        for emission in self.motion.iter().flat_map(|motion| &motion.emission) {
            brightest[emission.material as usize].emission = emission.brightest();
        }
        brightest
    }
}

/// Decides which triangles are lights at some time: all triangles with a material that emits at some time, except those on
/// which the emissive texture is certainly black everywhere. Of all triangles, only the lights get light samples.
pub struct Emitters<'a> {
    scene: &'a Scene,
    /// One entry per material of the scene: true if the material emits at some time. Triangles of other materials are never
    /// lights.
    emitter_materials: &'a [bool],
    /// For each image that is the emissive texture of an emitting material: the parts of the image that are not black. The
    /// key is the image's index in [`Scene::images`]. [`Emitters::emits`] uses these parts to decide whether a triangle may
    /// emit light.
    lit: HashMap<u32, LitTexels>,
}

impl<'a> Emitters<'a> {
    /// Prepares to decide which triangles of `scene` are lights: finds the parts of emissive textures that are not black.
    /// `emitter_materials` is the result of [`Scene::emitter_materials`].
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

    /// True if the material of `part` emits at some time. Some triangles of the part may still not be lights, because the
    /// emissive texture is black there.
    pub fn may_emit(&self, part: &Part) -> bool {
        self.emitter_materials[part.material as usize]
    }

    /// True if the triangle with the index `triangle` in [`Mesh::triangles`] is a light: some point of it may emit light at
    /// some time. If it is uncertain whether the emissive texture is black on the triangle, the result is true. `part` is
    /// the part of `mesh` that contains the triangle.
    pub fn emits(&self, mesh: &Mesh, part: &Part, triangle: u32) -> bool {
        let texture = self.scene.materials[part.material as usize].emissive_texture;
        self.may_emit(part)
            && texture.is_none_or(|texture| {
                let uvs = uvs_of(mesh, &texture, triangle);
                self.lit[&texture.image].may_be_seen(&texture, uvs)
            })
    }

    /// The number of triangles of `part` that are lights, as [`Emitters::emits`] decides for each of them. Reports state the
    /// sum over the scene.
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

/// The texture coordinates of the three corners of the triangle with the index `triangle` in
/// [`Mesh::triangles`]. They are from the set that `texture` uses, before [`Texture::transform`] maps them to
/// the image. With them, the emission of a triangle is looked up.
fn uvs_of(mesh: &Mesh, texture: &Texture, triangle: u32) -> [Vec2; 3] {
    let corners = mesh.triangles[triangle as usize];
    corners.map(|i| mesh.uvs[texture.set as usize][i as usize])
}

/// The emissive triangles of all instances, ordered by the index of the instance, then by the index of the triangle in its
/// mesh. The device stores them in the same order, so that this order gives the index of each light. `emitter_materials` has
/// one entry per material of the scene: true if the material emits light at some time.
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

/// The mean of the factor that multiplies a triangle's emission: linear RGB in [0, 1]. It is computed from 64 points of the
/// triangle. The factor is the colour of the emissive texture, or 1 without a texture, times the fraction of light that the surface
/// blocks: 0 in the holes of an alpha mask. If the factor is black at all points, the mean is 1/128 instead of 0, because light samples must also find lit areas
/// between the points.
fn emission_mean(scene: &Scene, mesh: &Mesh, material: &Material, triangle: u32) -> Vec3 {
    const SIDE: usize = 8;
    if material.emissive_texture.is_none() && material.alpha_mode == AlphaMode::Opaque {
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
            let coverage = match material.alpha_mode {
                AlphaMode::Opaque => 1.0,
                AlphaMode::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
                AlphaMode::Blend => alpha.clamp(0.0, 1.0),
            };
            let texture = material.emissive_texture.as_ref();
            sum += coverage * texture.map_or(Vec3::ONE, |texture| at(texture, weights).truncate());
        }
    }
    if sum == Vec3::ZERO {
        // As if half of a point were lit.
        sum = Vec3::splat(0.5);
    }
    sum / (SIDE * SIDE) as f32
}

/// The emissive triangles of a scene in world space, where each instance's transform
/// [`object_to_world`](super::Instance::object_to_world) places them. They are ordered by the index of the instance, then by
/// the index of the triangle in its mesh. Reports on the limits of the scene are computed from them.
pub fn light_triangles(scene: &Scene) -> Vec<LightTriangle> {
    emitter_triangles(scene, &scene.emitter_materials())
        .iter()
        .map(|light| light.placed(&scene.instances[light.instance as usize].object_to_world))
        .collect()
}

/// The power that a triangle emits, divided by π: its area in squared scene units × the luminance of its mean emission,
/// doubled if both sides emit. A light sample selects a light with a probability in proportion to the light's power. For the
/// fraction [`UNIFORM_FRACTION`] of the samples, all lights with a power above 0 are equally likely instead.
pub fn power(light: &LightTriangle, material: &Material) -> f64 {
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    sides * light.area * luminance(material.emission * light.emission_mean)
}

/// Computes the powers of a scene's lights. It stores the size of the scene and the brightness of its environment, because
/// the powers of infinitely distant lights (directional lights and the environment) depend on them. The power of such a
/// light is the power that it sends through a disc whose diameter is the diagonal of the scene's bounding box.
#[derive(Clone, Copy, Debug)]
pub struct LightPowers {
    /// The square of half the diagonal of the scene's bounding box, in squared scene units; 1 for a scene without geometry.
    /// It is the area, divided by π, of the disc through which distant lights shine. The power of each such light is in
    /// proportion to it.
    disc: f64,
    /// The integral of the environment's luminance over the sphere, in the unit of radiance × sr; `None` without an
    /// environment. The environment's power divided by π is this integral × `disc`.
    environment: Option<f64>,
}

impl LightPowers {
    /// Measures the bounding box of `scene`, because the powers of distant lights depend on its size. `environment` is the
    /// integral of the environment's luminance over the sphere, in the unit of radiance × sr, or `None` if the scene has no
    /// environment.
    pub fn of(scene: &Scene, environment: Option<f64>) -> Self {
        let bounds = Bounds::around(scene.loose_boxes().into_iter());
        Self {
            disc: bounds.map_or(1.0, |bounds| 0.25 * bounds.size().length_squared()),
            environment,
        }
    }

    /// The power of each light divided by π, in squared scene units × radiance, for the choice of lights by light samples.
    /// There is one entry for each of `triangles`, computed by [`power`], then one for each of `punctual`, then one for the
    /// environment, if the scene has one. `materials` are the scene's materials with their emission at the time for which
    /// the powers are computed.
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

/// The emitter to which each light belongs. Several triangles can belong to one emitter, so callers use these names to sum
/// the powers of an emitter's lights. The order is that of [`LightPowers::of_all`]: first each of `triangles`, then each
/// punctual light, then the environment, if there is one. `count` is the number of lights of all kinds.
pub fn emitter_names(
    triangles: &[LightTriangle],
    count: usize,
) -> impl Iterator<Item = EmitterName> {
    let others = (0..count - triangles.len()).map(|index| (None, index as u32));
    triangles.iter().map(LightTriangle::emitter).chain(others)
}

/// Luminance of a linear sRGB colour (ITU-R BT.709), in the unit of the colour's channels. The powers of
/// lights are computed from luminances.
pub fn luminance(color: Vec3) -> f64 {
    color.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// One column of an [`AliasTable`]. A draw selects a column uniformly, then one of two entries of the table: the entry with
/// the column's own index, or its alias.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AliasColumn {
    /// The threshold for the 32 random bits of a draw that has selected this column. If the bits are below it, the draw
    /// returns the entry with this column's index; otherwise it returns the entry `alias`.
    pub keep_below: u32,
    /// The index of the entry that a draw returns if its random bits are not below `keep_below`.
    pub alias: u32,
}

/// A table from which an entry is drawn in constant time, with a probability that depends on the entry's weight (Walker
/// 1977; Vose 1991). Shaders draw lights and texels of the environment from such tables. [`AliasTable::new`] describes how a
/// weight determines a probability.
#[derive(Clone, Debug)]
pub struct AliasTable {
    /// One column per entry, in the order of the weights that [`AliasTable::new`] got. For each draw, shaders read one
    /// column.
    pub columns: Vec<AliasColumn>,
    /// The exact probability with which each entry is drawn, in [0, 1], after the rounding of the thresholds to 32 bits.
    /// Estimators divide by it.
    pub probabilities: Vec<f64>,
}

impl AliasTable {
    /// A table with one entry per weight; weights must be finite and ≥ 0. The fraction `uniform_fraction` of the total
    /// probability is divided equally among the entries with a weight above 0; the rest is divided in proportion to the
    /// weights. An entry with the weight 0 is drawn only if all weights are 0: then all entries are equally likely.
    pub fn new(weights: &[f64], uniform_fraction: f64) -> Self {
        let count = weights.len();
        let total: f64 = weights.iter().sum();
        let is_used = |weight: &f64| *weight > 0.0 || total == 0.0;
        // Entries without a weight get no part: lights without power would waste candidates.
        let used = weights.iter().filter(|weight| is_used(weight)).count();
        let fraction = if total > 0.0 { uniform_fraction } else { 1.0 };
        let uniform = fraction * (count as f64 / used as f64);
        // The mean height is 1: columns below it are filled up from columns above it.
        let mut heights: Vec<f64> = weights
            .iter()
            .map(|w| {
                let own = if total > 0.0 { w / total } else { 0.0 };
                let uniform = if is_used(w) { uniform } else { 0.0 };
                (1.0 - fraction) * own * count as f64 + uniform
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
        let table = AliasTable::new(&weights, UNIFORM_FRACTION);
        let total: f64 = weights.iter().sum();
        assert!((table.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for (weight, got) in weights.iter().zip(&table.probabilities) {
            // The uniform fraction is that of the six that have a weight.
            let wanted = match *weight {
                0.0 => 0.0,
                weight => (1.0 - UNIFORM_FRACTION) * weight / total + UNIFORM_FRACTION / 6.0,
            };
            assert!((got - wanted).abs() < 1e-9, "{weight}: {got} {wanted}");
        }
    }

    #[test]
    fn weights_that_are_all_zero_are_picked_evenly() {
        let table = AliasTable::new(&[0.0; 5], UNIFORM_FRACTION);
        assert!(table.probabilities.iter().all(|p| (p - 0.2).abs() < 1e-9));
    }

    #[test]
    fn an_empty_table_is_empty() {
        assert!(AliasTable::new(&[], UNIFORM_FRACTION).columns.is_empty());
    }
}
