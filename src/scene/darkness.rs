//! Detection of scenes whose pictures would be completely black, so that the user is warned before rendering.

use super::lights::Emitters;
use super::{AlphaMode, Environment, Material, Mesh, Scene};
use std::cell::LazyCell;
use std::collections::BTreeSet;

/// The maximum number of frame times at which animated emission is examined, so that the check of a long sequence takes
/// little time. If a sequence has more frames and all examined ones are black, it is assumed to show light later, and the
/// user is not warned.
const MOST_TIMES: usize = 100_000;

impl Scene {
    /// The reason why the pictures of the scene at all `times` (in seconds) are black, as a text for the user. `None` if at
    /// least one of them may show light. `scattering` is false if the settings of the pictures, such as `--bounces 0`,
    /// exclude light that surfaces scatter.
    pub fn why_black(
        &self,
        scattering: bool,
        times: impl IntoIterator<Item = f64>,
    ) -> Option<&'static str> {
        if self.shows_unlit_surfaces() {
            return None;
        }
        let punctual = self.has_punctual_light();
        if self.has_lit_environment() || (punctual && scattering) {
            return None;
        }
        let emitters = self.emitters();
        if emitters.is_empty() {
            return Some(match punctual {
                true => {
                    "the camera sees no light, and with these --bounces and settings no surface scatters any, so the picture is black"
                }
                false => {
                    "the scene has no light, so the picture is black; --environment sky:sun=40 or neutral lights it"
                }
            });
        }
        let moving = self.motion.iter().flat_map(|motion| &motion.emission);
        let moving: Vec<_> = moving.filter(|m| emitters.contains(&m.material)).collect();
        let shines = |time: f64| moving.iter().any(|m| m.at(time).max_element() > 0.0);
        let mut times = times.into_iter();
        let lit = moving.len() < emitters.len()
            || times.by_ref().take(MOST_TIMES).any(shines)
            || times.next().is_some();
        (!lit).then_some(
            "the lights of the scene are off at the time shown, so the picture is black; another --start-time may show them",
        )
    }

    /// True if the scene has no light at any time, although it has surfaces that only light makes visible. A light of
    /// intensity 0 is no light.
    pub(crate) fn lacks_light(&self) -> bool {
        let lit_surfaces = self.shows_surfaces(|material| !material.unlit);
        let elsewhere = self.has_lit_environment() || self.has_punctual_light();
        lit_surfaces && !elsewhere && self.emitters().is_empty()
    }

    fn has_lit_environment(&self) -> bool {
        self.environment.as_ref().is_some_and(Environment::is_lit)
    }

    /// True if a punctual light has an intensity above 0.
    fn has_punctual_light(&self) -> bool {
        let mut lights = self.punctual_lights.iter();
        lights.any(|light| light.intensity.max_element() > 0.0)
    }

    /// True if an instance has triangles with an unlit material, whose colour the camera sees even if the scene has no
    /// light. The pictures of such a scene do not count as black.
    fn shows_unlit_surfaces(&self) -> bool {
        self.shows_surfaces(|material| material.unlit)
    }

    /// True if an instance has triangles with a material of the kind `is_shown`.
    fn shows_surfaces(&self, is_shown: impl Fn(&Material) -> bool) -> bool {
        let mut parts = self.placed_meshes().flat_map(|mesh| &mesh.parts);
        parts.any(|part| {
            part.triangle_count > 0 && is_shown(&self.materials[part.material as usize])
        })
    }

    /// The indices of the materials that emit light, at some time, on at least one triangle of an instance. Materials whose
    /// alpha makes the whole surface invisible are left out.
    fn emitters(&self) -> BTreeSet<u32> {
        let emitter_materials = self.emitter_materials();
        let emitters = Emitters::new(self, &emitter_materials);
        let mut found = BTreeSet::new();
        for mesh in self.placed_meshes() {
            // Computed once for all parts, because a mesh may have very many parts.
            let vertex_alpha = LazyCell::new(|| {
                let alphas = mesh.colors.iter().map(|color| color.w);
                alphas.reduce(f32::max).unwrap_or(1.0)
            });
            for part in &mesh.parts {
                let shows = |triangle| emitters.emits(mesh, part, triangle);
                if emitters.may_emit(part)
                    && !found.contains(&part.material)
                    && !self.materials[part.material as usize].is_cut_away(&vertex_alpha)
                    && part.range().any(shows)
                {
                    found.insert(part.material);
                }
            }
        }
        found
    }

    fn placed_meshes(&self) -> impl Iterator<Item = &Mesh> {
        let placed: BTreeSet<u32> = self.instances.iter().map(|i| i.mesh).collect();
        placed.into_iter().map(|mesh| &self.meshes[mesh as usize])
    }
}

impl Material {
    /// True if the alpha of the material removes every point of its surfaces, so that the material cannot emit light.
    /// `vertex_alpha` is the largest alpha of the mesh's vertex colours. Always false for a material with a base colour
    /// texture, because the texels are not examined.
    fn is_cut_away(&self, vertex_alpha: &LazyCell<f32, impl FnOnce() -> f32>) -> bool {
        let alpha = || self.alpha * **vertex_alpha;
        self.base_color_texture.is_none()
            && match self.alpha_mode {
                AlphaMode::Opaque => false,
                AlphaMode::Mask { cutoff } => alpha() < cutoff,
                AlphaMode::Blend => alpha() == 0.0,
            }
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::Emission;
    use super::super::motion::tracks::Animated;
    use super::super::{Image, Instance, Motion, Part, PunctualLight, Texture};
    use super::*;
    use glam::{DAffine3, DVec3, Vec2, Vec3};

    /// A scene with one instance of a mesh, whose only triangle has the material `material`, without other
    /// lights and motion.
    fn scene(material: Material) -> Scene {
        Scene {
            meshes: vec![Mesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::Y], Vec::new()],
                triangles: vec![[0, 1, 2]],
                parts: vec![Part {
                    first_triangle: 0,
                    triangle_count: 1,
                    material: 0,
                }],
                ..Mesh::default()
            }],
            materials: vec![material],
            instances: vec![Instance {
                name: String::new(),
                mesh: 0,
                object_to_world: DAffine3::IDENTITY,
            }],
            ..Scene::default()
        }
    }

    fn emitter() -> Material {
        Material {
            emission: Vec3::ONE,
            ..Material::default()
        }
    }

    fn why(scene: &Scene) -> &'static str {
        scene.why_black(true, [0.0]).unwrap_or_default()
    }

    #[test]
    fn black_pictures_are_found() {
        let dark = scene(Material::default());
        assert!(why(&dark).starts_with("the scene has no light"));
        assert!(why(&Scene::default()).starts_with("the scene has no light"));
        assert_eq!(why(&scene(emitter())), "");
        assert_eq!(why(&scene(Material::unlit("", Vec3::ONE))), "");

        let mut textured = scene(Material {
            emissive_texture: Some(Texture::plain(0)),
            ..emitter()
        });
        for (texel, black) in [([0; 4], true), ([9; 4], false)] {
            textured.images = vec![Image {
                name: String::new(),
                width: 1,
                height: 1,
                texels: vec![texel].into(),
            }];
            assert_eq!(!why(&textured).is_empty(), black);
        }

        let cut = |alpha| Material {
            alpha,
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..emitter()
        };
        assert_eq!(why(&scene(cut(0.6))), "");
        assert_ne!(why(&scene(cut(0.4))), "");

        let mut nowhere = scene(emitter());
        nowhere.instances.clear();
        assert_ne!(why(&nowhere), "");
    }

    #[test]
    fn lights_without_a_surface_need_surfaces_that_scatter() {
        let mut dark = scene(Material::default());
        dark.punctual_lights = vec![PunctualLight::point(0.0)];
        assert!(why(&dark).starts_with("the scene has no light"));
        dark.punctual_lights.push(PunctualLight::point(1.0));
        assert_eq!(why(&dark), "");
        let unscattered = dark.why_black(false, [0.0]);
        assert!(unscattered.unwrap().contains("--bounces"));

        let mut sky = crate::scene::environment::sky::generate("width=64").unwrap();
        dark.environment = Some(sky.clone());
        assert_eq!(dark.why_black(false, [0.0]), None);
        sky.intensity = 0.0;
        dark.environment = Some(sky);
        assert!(dark.why_black(false, [0.0]).is_some());
    }

    #[test]
    fn lights_that_are_off_are_found_by_their_times() {
        let mut sign = scene(Material::default());
        sign.motion = Some(Motion {
            emission: vec![Emission {
                material: 0,
                color: Animated::still(DVec3::ONE),
                strength: Animated::still(0.0),
            }],
            ..Motion::default()
        });
        assert!(why(&sign).contains("--start-time"));
        if let Some(motion) = &mut sign.motion {
            motion.emission[0].strength = Animated::still(1.0);
        }
        assert_eq!(why(&sign), "");
    }
}
