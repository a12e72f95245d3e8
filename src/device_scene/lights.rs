//! The lights of a scene at one time, as shaders read them: emissive triangles, punctual lights, and the alias tables that
//! select among these and the environment. Indices of lights of all kinds count the triangles first, then the punctual
//! lights, then the environment.

use super::rare_lights::RareLights;
use super::units::Units;
use crate::scene::lights::{
    self, AliasTable, EmitterTriangle, LightPowers, LightTriangle, UNIFORM_FRACTION,
};
use crate::scene::{AlphaMode, Environment, Material, PunctualLight, PunctualShape, Scene};
use crate::shader_interface::{
    GpuLight, GpuLightChoice, GpuPunctualLight, LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, NONE,
};
use glam::{DAffine3, DVec3, UVec3, Vec3};
use std::collections::HashMap;

/// The data of a scene's lights that do not depend on time. [`LightSources::placed`] computes the lights at one time from
/// them.
pub struct LightSources {
    /// The emissive triangles in object space, in the order in which shaders index them: by instance, then by index in the
    /// mesh.
    pub emitter_triangles: Vec<EmitterTriangle>,
    /// For each emissive triangle, the values of [`GpuLight::primitive`] and [`GpuLight::blended`]. For a material with
    /// holes or partial transparency, the first one is the triangle's index in its mesh, in the order in which the device
    /// stores triangles. Shaders look up the alpha at a point of the light with it. For other materials it is NONE.
    alphas: Vec<(u32, bool)>,
    materials: Vec<Material>,
    punctual: Vec<PunctualLight>,
    /// The mean luminance of the environment, weighted by the luminance itself, in the scene's unit of radiance. It enters
    /// [`Lights::mean_luminance`]. `None` for a scene without an environment.
    environment_mean: Option<f64>,
    light_powers: LightPowers,
    /// The classification of the lights into rare ones (far dimmer than the others), which get separate candidates, and
    /// ordinary ones. `None` if no light is rare.
    rare: Option<RareLights>,
}

/// The lights of a scene at one time in the device's units, with the alias tables that select among them. They are uploaded
/// for shaders, and the light BVH is built from them.
#[derive(Clone, Default)]
pub struct Lights {
    /// The emissive triangles in the device's world space. Shaders index them in the order of
    /// [`LightSources::emitter_triangles`].
    pub triangles: Vec<GpuLight>,
    /// The punctual lights in the device's world space, in the order of the scene. Their indices follow those of the
    /// triangles.
    pub punctual: Vec<GpuPunctualLight>,
    /// The alias table that selects a light of any kind. A fraction [`UNIFORM_FRACTION`] of the draws selects each light
    /// that has power with the same probability; the other draws select lights in proportion to their power. The table has
    /// one column per light: triangles, then punctual lights, then the environment.
    pub choices: Vec<GpuLightChoice>,
    /// The alias table, over the same lights as `choices`, that draws ordinary candidates: those that compete in reservoirs.
    /// Rare lights (far dimmer than the others) have the probability 0 in it, because separate candidates are drawn from
    /// them. Empty if no light is rare.
    pub common_choices: Vec<GpuLightChoice>,
    /// The alias table over all lights that draws the separate candidates of rare lights (far dimmer than the others). All
    /// rare emitters that have power now are equally likely, however many triangles they have. Other lights have the
    /// probability 0. Empty if no light is rare.
    pub rare_choices: Vec<GpuLightChoice>,
    /// One flag per light of all kinds: true if the light is rare, that is, far dimmer than the others. The light BVH leaves
    /// rare lights out if separate candidates are drawn from them wherever candidates are drawn from the tree. Empty if no
    /// light is rare.
    pub rare: Vec<bool>,
    /// The power of each light of all kinds, divided by π, in the device's units of radiance × squared length. From it, the
    /// light BVH computes the sizes of its boxes and the weights of its lights. The powers of distant lights (directional
    /// lights and the environment) are scaled down so that their sum is at most the sum of the powers of all other lights.
    pub powers: Vec<f64>,
    /// The mean luminance of emissive triangles and the environment, weighted by power, in the device's unit
    /// of radiance; 0 if none of them has power. Shaders divide the luminance of the light that a pixel's
    /// pilot (its first BSDF ray) finds by this mean. Pixels near a pilot with a high quotient trace
    /// additional BSDF rays.
    pub mean_luminance: f32,
}

impl Lights {
    /// True if the scene has rare lights, which are far dimmer than the others. Depending on the settings,
    /// separate candidates are drawn from them.
    pub fn has_rare(&self) -> bool {
        !self.rare.is_empty()
    }

    /// True if the light with this index among the lights of all kinds is rare, that is, far dimmer than the
    /// others. The light BVH can leave out such lights.
    pub fn is_rare(&self, index: usize) -> bool {
        self.rare.get(index).is_some_and(|is_rare| *is_rare)
    }

    /// The probability, in [0, 1], that a draw from [`Lights::choices`] selects a directional light or the environment,
    /// which the light BVH does not contain. It decides how many light samples of a pixel are drawn among all lights instead
    /// of from the light BVH.
    pub fn distant_fraction(&self) -> f32 {
        let distant = (0..self.choices.len()).filter(|index| self.is_distant(*index));
        distant.map(|index| self.choices[index].probability).sum()
    }

    /// True if the light with this index among the lights of all kinds is a directional light or the environment. Such
    /// lights have no position, and are not in the light BVH.
    pub fn is_distant(&self, index: usize) -> bool {
        let punctual = index.checked_sub(self.triangles.len());
        punctual.is_some_and(|index| {
            let light = self.punctual.get(index);
            light.is_none_or(|light| light.kind == LIGHT_DIRECTIONAL)
        })
    }
}

impl LightSources {
    /// Collects the lights of a scene. `emitter_materials` has one entry per material: true if it emits at any time.
    /// `traced_index` is called with the index of a mesh; for each triangle of the mesh, it returns the triangle's index in
    /// the order in which the device stores the mesh.
    pub fn of(
        scene: &Scene,
        emitter_materials: &[bool],
        traced_index: impl Fn(u32) -> Vec<u32>,
    ) -> Self {
        let emitter_triangles = lights::emitter_triangles(scene, emitter_materials);
        let mut traced = HashMap::new();
        let alphas = emitter_triangles.iter().map(|emitter| {
            let material = &scene.materials[emitter.material as usize];
            let mesh = scene.instances[emitter.instance as usize].mesh;
            let blends = material.blends(&scene.meshes[mesh as usize]);
            if !blends && !matches!(material.alpha_mode, AlphaMode::Mask { .. }) {
                return (NONE, false);
            }
            let indices = traced.entry(mesh).or_insert_with(|| traced_index(mesh));
            (indices[emitter.triangle as usize], blends)
        });
        let alphas = alphas.collect();
        let integrals = scene.environment.as_ref().map(Environment::integrals);
        let mut sources = Self {
            emitter_triangles,
            alphas,
            materials: scene.materials.clone(),
            punctual: scene.punctual_lights.clone(),
            environment_mean: integrals.map(|(integral, squares)| match integral > 0.0 {
                true => squares / integral,
                false => 0.0,
            }),
            light_powers: LightPowers::of(scene, integrals.map(|(integral, _)| integral)),
            rare: None,
        };
        let triangles: Vec<LightTriangle> = (sources.emitter_triangles.iter())
            .map(|emitter| {
                emitter.placed(&scene.instances[emitter.instance as usize].object_to_world)
            })
            .collect();
        // An emitter that is off now may be the brightest one later. The powers of distant lights are not
        // limited here: a sun that walls hide takes every reservoir, however seldom it is drawn.
        let brightest = scene.brightest_materials();
        let powers = (sources.light_powers).of_all(&triangles, &brightest, &sources.punctual);
        let names = lights::emitter_names(&triangles, powers.len());
        sources.rare = RareLights::find(&powers, names);
        sources
    }

    /// Computes the lights at one time. `transform_of` returns the current transform of an instance, from object to world
    /// space, and `corners_of` the current corners of an emissive triangle in object space. `emission` has pairs of the index of a material and its current emission, a linear RGB radiance in W/(m²·sr).
    /// `moved` has pairs of the index of a punctual light and its current transform to world space. All other materials and
    /// punctual lights are as in the scene.
    pub fn placed(
        &self,
        transform_of: impl Fn(u32) -> DAffine3,
        corners_of: impl Fn(&EmitterTriangle) -> [DVec3; 3],
        emission: &[(u32, Vec3)],
        moved: &[(u32, DAffine3)],
        units: &Units,
    ) -> Lights {
        let mut materials = self.materials.clone();
        for (material, emission) in emission {
            materials[*material as usize].emission = *emission;
        }
        let mut punctual = self.punctual.clone();
        for (index, transform) in moved {
            punctual[*index as usize].light_to_world = *transform;
        }
        let triangles: Vec<LightTriangle> = (self.emitter_triangles.iter())
            .map(|emitter| {
                let deformed = EmitterTriangle {
                    corners: corners_of(emitter),
                    ..*emitter
                };
                deformed.placed(&transform_of(emitter.instance))
            })
            .collect();
        let mut powers = self.light_powers.of_all(&triangles, &materials, &punctual);
        limit_distant(&mut powers, |index| {
            (index.checked_sub(triangles.len()))
                .is_some_and(|rest| punctual.get(rest).is_none_or(PunctualLight::is_distant))
        });
        let gpu_triangles: Vec<GpuLight> = (triangles.iter().zip(&self.alphas))
            .map(|(light, (primitive, blends))| GpuLight {
                primitive: *primitive,
                blended: (*blends).into(),
                ..gpu_light(light, &materials[light.material as usize], units)
            })
            .collect();
        let choices = choices(&powers, UNIFORM_FRACTION);
        let (mut common_choices, mut rare_choices) = (Vec::new(), Vec::new());
        let mut is_rare = Vec::new();
        if let Some(rare) = &self.rare {
            is_rare = rare.is_rare.clone();
            common_choices = self::choices(&rare.common_weights(&powers), UNIFORM_FRACTION);
            rare_choices = self::choices(&rare.rare_weights(&powers), 0.0);
        }
        for power in &mut powers {
            *power /= units.length * units.length * units.radiance;
        }
        let environment = self.environment_mean.zip(powers.last());
        let environment = environment.map(|(mean, power)| (*power, mean / units.radiance));
        Lights {
            mean_luminance: mean_luminance(&gpu_triangles, environment),
            triangles: gpu_triangles,
            punctual: punctual
                .iter()
                .map(|light| gpu_punctual(light, units))
                .collect(),
            choices,
            common_choices,
            rare_choices,
            rare: is_rare,
            powers,
        }
    }
}

/// Scales the powers of distant lights (directional lights and the environment) down, if needed, so that their sum is at
/// most the sum of the powers of all other lights. Distant lights then get at most half of the light candidates that are
/// drawn by power. Without the limit they could get nearly all, even in a room with windows, where little of their light
/// arrives. If the other lights have no power, nothing changes.
fn limit_distant(powers: &mut [f64], is_distant: impl Fn(usize) -> bool) {
    let (mut near, mut far) = (0.0, 0.0);
    for (index, power) in powers.iter().enumerate() {
        *(if is_distant(index) {
            &mut far
        } else {
            &mut near
        }) += power;
    }
    if near > 0.0 && far > near {
        for (index, power) in powers.iter_mut().enumerate() {
            *power *= if is_distant(index) { near / far } else { 1.0 };
        }
    }
}

/// Makes an alias table with one column per light of `powers`. The fraction `uniform_fraction` of all draws selects each
/// light that has power with the same probability; the other draws select lights in proportion to their powers.
fn choices(powers: &[f64], uniform_fraction: f64) -> Vec<GpuLightChoice> {
    let table = AliasTable::new(powers, uniform_fraction);
    let columns = table.columns.iter().zip(&table.probabilities);
    columns
        .map(|(column, probability)| GpuLightChoice {
            probability: *probability as f32,
            keep_below: column.keep_below,
            alias: column.alias,
            padding: 0,
        })
        .collect()
}

fn gpu_light(light: &LightTriangle, material: &Material, units: &Units) -> GpuLight {
    let length = 1.0 / units.length;
    let [a, b, c] = light.corners;
    GpuLight {
        corner: ((a - units.origin) * length).as_vec3(),
        edge1: ((b - a) * length).as_vec3(),
        edge2: ((c - a) * length).as_vec3(),
        normal: light.normal.as_vec3(),
        emission: (material.emission.as_dvec3() / units.radiance).as_vec3(),
        area: (light.area * length * length) as f32,
        double_sided: material.double_sided.into(),
        instance: light.instance,
        primitive: NONE,
        blended: 0,
    }
}

/// The smallest divisor in the computation of a spot's falloff. For the outer angle a and the inner angle b, the divisor is
/// 4 sin²(a/2) − 4 sin²(b/2). It would be 0 for a spot with a sharp edge (a = b); the minimum keeps the falloff finite.
const SHARPEST: f64 = 1e-30;

fn gpu_punctual(light: &PunctualLight, units: &Units) -> GpuPunctualLight {
    let (kind, offset, scale) = match light.shape {
        PunctualShape::Point => (LIGHT_POINT, 1.0, 0.0),
        PunctualShape::Directional => (LIGHT_DIRECTIONAL, 1.0, 0.0),
        PunctualShape::Spot { inner, outer } => {
            // As KHR_lights_punctual has it, except that its least difference of 0.001 dims the axis of narrow spots: at an
            // outer angle of one degree to a fortieth. Finite, so that nothing is multiplied by infinity at a sharp edge.
            // The squared distance of unit vectors at an angle tells angles of 1e-5 radians apart, where all cosines are 1.
            let squared = |angle: f64| 4.0 * (angle / 2.0).sin().powi(2);
            let scale = 1.0 / (squared(outer) - squared(inner)).max(SHARPEST);
            (LIGHT_SPOT, squared(outer) * scale, scale)
        }
    };
    // Intensity falls off by squared lengths, irradiance does not.
    let unit = match light.shape {
        PunctualShape::Directional => units.radiance,
        _ => units.radiance * units.length * units.length,
    };
    GpuPunctualLight {
        position: ((light.position() - units.origin) / units.length).as_vec3(),
        kind,
        direction: light.direction().as_vec3(),
        range: light
            .range
            .map_or(0.0, |range| (range / units.length) as f32),
        intensity: (light.intensity.as_dvec3() / unit).as_vec3(),
        angle_offset: offset as f32,
        angle_scale: scale as f32,
        padding: UVec3::ZERO,
    }
}

/// Computes the lights of a scene in the device's units, without motion and without merging static meshes. Triangles keep
/// their indices in the scene's meshes. Only tests use it; a renderer uses
/// [`GpuScene::first_lights`](super::GpuScene::first_lights).
pub fn gpu_lights(scene: &Scene, units: &Units) -> Lights {
    let transform_of = |instance: u32| scene.instances[instance as usize].object_to_world;
    let unchanged = |mesh: u32| (0..scene.meshes[mesh as usize].triangles.len() as u32).collect();
    LightSources::of(scene, &scene.emitter_materials(), unchanged).placed(
        transform_of,
        |emitter| emitter.corners,
        &[],
        &[],
        units,
    )
}

/// The mean luminance of lights, weighted by their power, for [`Lights::mean_luminance`]; 0 if none has
/// power. The power of a triangle is its area × luminance. `environment` is the pair of the environment's
/// power and mean luminance; `None` without an environment. All are in the device's units.
fn mean_luminance(lights: &[GpuLight], environment: Option<(f64, f64)>) -> f32 {
    let (mut power, mut weighted) = (0.0, 0.0);
    for light in lights {
        let luminance = lights::luminance(light.emission);
        power += f64::from(light.area) * luminance;
        weighted += f64::from(light.area) * luminance * luminance;
    }
    if let Some((own, luminance)) = environment {
        power += own;
        weighted += own * luminance;
    }
    if power > 0.0 {
        (weighted / power) as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device_scene::light_bvh::{LightBvh, LightBvhOptions};

    #[test]
    fn lights_are_weighted_by_their_power() {
        let light = |area: f32, brightness: f32| GpuLight {
            area,
            emission: Vec3::splat(brightness),
            ..bytemuck::Zeroable::zeroed()
        };
        let mean = mean_luminance(&[light(1.0, 1.0), light(3.0, 5.0)], None);
        assert!((mean - 4.75).abs() < 1e-6, "{mean}");
        let mean = mean_luminance(&[light(3.0, 5.0)], Some((15.0, 1.0)));
        assert!((mean - 3.0).abs() < 1e-6, "{mean}");
        assert_eq!(mean_luminance(&[], None), 0.0);
    }

    #[test]
    fn spots_of_any_angle_have_all_of_their_light_on_the_axis() {
        let units = Units::of(&Scene::default(), glam::DVec3::ZERO);
        for degrees in [0.0006_f64, 0.3, 1.0, 2.0, 10.0, 89.0] {
            let light = PunctualLight {
                shape: PunctualShape::Spot {
                    inner: 0.0,
                    outer: degrees.to_radians(),
                },
                ..PunctualLight::point(1.0)
            };
            let spot = gpu_punctual(&light, &units);
            let fraction = spot.angle_offset.clamp(0.0, 1.0).powi(2);
            assert!(fraction > 0.999, "{degrees}: {fraction}");
        }
    }

    fn lights_of(intensities: &[f32]) -> Lights {
        let scene = Scene {
            punctual_lights: intensities
                .iter()
                .map(|i| PunctualLight::point(*i))
                .collect(),
            ..Scene::default()
        };
        gpu_lights(&scene, &Units::of(&scene, glam::DVec3::ZERO))
    }

    fn probabilities(choices: &[GpuLightChoice]) -> Vec<f32> {
        choices.iter().map(|choice| choice.probability).collect()
    }

    #[test]
    fn rare_lights_have_a_table_of_their_own() {
        let lights = lights_of(&[1000.0, 1.0, 0.0, 2.0]);
        assert!(lights.has_rare());
        assert_eq!(probabilities(&lights.common_choices), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(probabilities(&lights.rare_choices), [0.0, 0.5, 0.0, 0.5]);
    }

    #[test]
    fn rare_lights_are_left_out_of_the_light_bvh() {
        let lights = lights_of(&[1000.0, 1.0, 800.0, 2.0]);
        for (leaves_out_rare, in_tree) in [(true, vec![0, 2]), (false, vec![0, 1, 2, 3])] {
            let options = LightBvhOptions {
                scale: None,
                cut: true,
                clusters: true,
                by_power: true,
                leaves_out_rare,
            };
            let bvh = LightBvh::new(&lights, &[], &[], options);
            let entries = bvh.contents(&lights).entries.into_iter().take(4);
            let found = entries.zip(0..).filter(|(entry, _)| entry.leaf != NONE);
            let found: Vec<i32> = found.map(|(_, light)| light).collect();
            assert_eq!(found, in_tree);
        }
    }

    #[test]
    fn lights_without_power_have_no_candidates() {
        let lights = lights_of(&[3.0, 0.0, 1.0]);
        let [bright, off, dim] = probabilities(&lights.choices)[..] else {
            panic!()
        };
        assert_eq!(off, 0.0);
        assert!((bright - 0.725).abs() < 1e-6 && (dim - 0.275).abs() < 1e-6);
    }

    #[test]
    fn distant_lights_get_half_of_the_power_at_most() {
        let limited = |mut powers: Vec<f64>| {
            limit_distant(&mut powers, |index| index >= 2);
            powers
        };
        assert_eq!(limited(vec![1.0, 3.0, 6.0, 2.0]), [1.0, 3.0, 3.0, 1.0]);
        assert_eq!(limited(vec![1.0, 3.0, 1.0, 2.0]), [1.0, 3.0, 1.0, 2.0]);
        assert_eq!(limited(vec![0.0, 0.0, 1.0, 2.0]), [0.0, 0.0, 1.0, 2.0]);
    }
}
