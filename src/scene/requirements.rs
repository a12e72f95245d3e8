//! Determines which features a scene uses, such as textures or punctual lights. Shaders leave out the code of features that
//! the scene does not use, and `headwater scene inspect` lists the used and the unused ones.

use super::bounds::usual_size;
use super::lights::Emitters;
use super::texture::Image;
use super::{AlphaMode, Material, Mesh, Scene};
use crate::shader_interface::MIRROR_ROUGHNESS;

/// The features that a scene uses, and some counts for reports. Shaders leave out the code of features that the scene does
/// not use. Only meshes that have an instance are examined, with the materials of their triangles. In the descriptions of
/// the fields, a light is a material that emits light at some time.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Requirements {
    /// The number of triangles in the world, for reports. The triangles of a mesh count once for each instance of the mesh.
    pub triangles: u64,
    /// The number of triangles in the world that emit light at some time, for reports. The triangles of a mesh count once
    /// for each instance of the mesh.
    pub emissive_triangles: u64,
    /// The number of instances of meshes, for reports.
    pub instances: u64,
    /// True if some light emits on both sides; otherwise shaders assume that lights emit on their front only.
    pub double_sided_emitters: bool,
    /// The number of punctual lights (points, spots, directional lights). If it is 0, shaders leave out the code for them.
    pub punctual_lights: u64,
    /// True if the scene has an environment, even a black one; otherwise rays that leave the scene see black.
    pub environment: bool,
    /// True if some material has a specular lobe; otherwise shaders assume that all surfaces are purely Lambertian.
    pub specular: bool,
    /// True if some specular lobe or clear coat may be treated as a perfect mirror: its roughness is below
    /// [`MIRROR_ROUGHNESS`], or it has a texture, which may lower the roughness. For reports only.
    pub near_delta: bool,
    /// True if some surface has a clear coat; otherwise shaders leave out the lobe of the coat.
    pub coat: bool,
    /// True if some surface has a specular lobe that is wider in one direction; otherwise shaders assume lobes that are
    /// equally wide in all directions.
    pub anisotropy: bool,
    /// True if light passes through some surface by transmission; otherwise shaders assume opaque surfaces, apart from
    /// alpha.
    pub transmission: bool,
    /// True if some material has a texture of base colour, metalness and roughness, or of a layer; otherwise shaders do not
    /// read them.
    pub textures: bool,
    /// True if some material has a texture of its specular reflection; otherwise shaders do not read them.
    pub specular_textures: bool,
    /// True if some image of the scene has 16 bits per channel; otherwise shaders read 8 bits per channel only.
    pub deep_textures: bool,
    /// True if some surface has holes or is partly transparent (not [`AlphaMode::Opaque`]); otherwise no ray tests alpha.
    pub alpha: bool,
    /// True if some surface is partly transparent ([`Material::blends`]). Shadow rays then return the
    /// fraction of light that passes through such surfaces, instead of only 0 or 1. Where a shadow ray otherwise decides
    /// only the weight of a sample, shaders trace one more ray when they add the sample's light to the picture.
    pub blending: bool,
    /// True if some surface that may emit light is partly transparent. Light samples alone then find its light, while BSDF
    /// rays pass it.
    pub blended_lights: bool,
    /// True if some material or its clear coat has a normal map; otherwise shaders do not read normal maps or tangents.
    pub normal_maps: bool,
    /// True if some material is unlit, so that the camera sees its colour without light; otherwise shaders do not test
    /// whether a material is unlit.
    pub unlit: bool,
    /// True if the camera looks through the back of some surface; otherwise shaders do not test for this.
    pub culled: bool,
    /// True if some light has an emissive texture; otherwise shaders take the emission of a light as constant over its
    /// surface.
    pub emissive_textures: bool,
    /// True if some mesh has vertex colours; otherwise shaders do not read them.
    pub vertex_colors: bool,
    /// True if some mesh has shading normals at its vertices; otherwise shaders use geometric normals only.
    pub smooth_normals: bool,
    /// True if some triangle may have an edge longer than 10,000 times the usual size of the scene's
    /// instances. Barycentric weights in f32 are too coarse to locate points on such a triangle. If nothing
    /// moves, samples of indirect light then store points as coordinates in the triangle's plane. If
    /// something moves, they still store barycentric weights.
    pub large_triangles: bool,
    /// True if shaders need more of a primary surface than its material, its textures' values and its normals. The stored
    /// surface then names its triangle and a point on it, from which everything else is read again.
    pub named_surfaces: bool,
    /// True if some mesh has more than one part (a run of triangles with one material). For reports only.
    pub multi_part_meshes: bool,
    /// True if some mesh has more than one instance. For reports only.
    pub shared_meshes: bool,
    /// True if the transform of some instance mirrors it, so that the winding of its triangles in world space is the reverse
    /// of that in object space. For reports only.
    pub mirrored_instances: bool,
    /// True if instances, cameras, lights or emission change with time. For reports only.
    pub motion: bool,
}

impl Requirements {
    /// Determines the features that `scene` uses. [`Scene::validate`] must have accepted the scene.
    pub fn of(scene: &Scene) -> Self {
        let lights = scene.emitter_materials();
        let emitters = Emitters::new(scene, &lights);
        let mut required = Self {
            triangles: scene.triangle_count(),
            emissive_triangles: scene.count_emissive(&emitters),
            instances: scene.instances.len() as u64,
            motion: scene.motion.is_some(),
            named_surfaces: (scene.motion.as_ref())
                .is_some_and(|motion| !motion.deformations.is_empty()),
            punctual_lights: scene.punctual_lights.len() as u64,
            environment: scene.environment.is_some(),
            deep_textures: scene.images.iter().any(Image::is_deep),
            ..Self::default()
        };
        let edges: Vec<f64> = scene.meshes.iter().map(longest_edge).collect();
        let large = LARGE * usual_size(&scene.loose_boxes());
        let mut placed = vec![false; scene.meshes.len()];
        let mut layer_textures = false;
        for instance in &scene.instances {
            let seen = &mut placed[instance.mesh as usize];
            required.shared_meshes |= *seen;
            *seen = true;
            let matrix = instance.object_to_world.matrix3;
            required.mirrored_instances |= matrix.determinant() < 0.0;
            let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
            let scale = axes
                .map(|axis| axis.length())
                .into_iter()
                .fold(0.0, f64::max);
            required.large_triangles |= scale * edges[instance.mesh as usize] > large;
        }
        for (mesh, _) in scene.meshes.iter().zip(&placed).filter(|(_, seen)| **seen) {
            required.smooth_normals |= !mesh.normals.is_empty();
            required.vertex_colors |= !mesh.colors.is_empty();
            required.multi_part_meshes |= mesh.parts.len() > 1;
            for part in mesh.parts.iter().filter(|part| part.triangle_count > 0) {
                let material = &scene.materials[part.material as usize];
                required.double_sided_emitters |=
                    lights[part.material as usize] && material.double_sided;
                required.emissive_textures |=
                    lights[part.material as usize] && material.emissive_texture.is_some();
                required.textures |= material.base_color_texture.is_some()
                    || material.metallic_roughness_texture.is_some()
                    || material.layers.has_textures();
                required.specular_textures |= material.has_specular_textures();
                required.alpha |= material.alpha_mode != AlphaMode::Opaque;
                let blends = material.blends(mesh);
                required.blending |= blends;
                required.blended_lights |= blends && lights[part.material as usize];
                required.unlit |= material.unlit;
                required.culled |= material.hides_its_back();
                required.normal_maps |= material.normal_texture.is_some()
                    || material.layers.coat.normal_texture.is_some();
                required.specular |=
                    material.has_specular_lobe() || material.layers.coat.factor > 0.0;
                required.coat |= material.layers.coat.factor > 0.0;
                required.anisotropy |=
                    material.has_specular_lobe() && material.layers.anisotropy.strength > 0.0;
                layer_textures |= material.layers.has_textures();
                required.transmission |= material.layers.transmission.factor > 0.0;
                // A texture can give any point a low roughness.
                let smooth = material.roughness < MIRROR_ROUGHNESS
                    || material.metallic_roughness_texture.is_some();
                required.near_delta |= material.has_specular_lobe() && smooth;
                required.near_delta |= material.layers.coat.is_smooth();
            }
        }
        // A surface that is not named stores neither what textures change of layers, nor a direction or a second normal.
        required.named_surfaces |=
            layer_textures || required.anisotropy || (required.coat && required.normal_maps);
        required
    }

    /// The names of features, for `headwater scene inspect` and the log: first a list of those that the scene uses, then a
    /// list of those that it does not use.
    pub fn features(&self) -> [Vec<&'static str>; 2] {
        let &Self {
            triangles: _,
            emissive_triangles,
            instances: _,
            double_sided_emitters,
            punctual_lights,
            environment,
            specular,
            near_delta,
            coat,
            anisotropy,
            transmission,
            textures,
            specular_textures,
            deep_textures,
            alpha,
            blending,
            blended_lights,
            normal_maps,
            unlit,
            culled,
            emissive_textures,
            vertex_colors,
            smooth_normals,
            large_triangles,
            named_surfaces: _,
            multi_part_meshes,
            shared_meshes,
            mirrored_instances,
            motion,
        } = self;
        let features = [
            (emissive_triangles > 0, "emissive triangles"),
            (double_sided_emitters, "two-sided lights"),
            (emissive_textures, "emissive textures"),
            (punctual_lights > 0, "punctual lights"),
            (environment, "environment"),
            (specular, "specular lobes"),
            (near_delta, "mirrors"),
            (coat, "clear coats"),
            (anisotropy, "anisotropic lobes"),
            (transmission, "transmission"),
            (textures, "textures"),
            (specular_textures, "specular textures"),
            (deep_textures, "16-bit textures"),
            (vertex_colors, "vertex colours"),
            (normal_maps, "normal maps"),
            (smooth_normals, "smooth normals"),
            (alpha, "alpha"),
            (blending, "blending"),
            (blended_lights, "blended lights"),
            (unlit, "unlit surfaces"),
            (culled, "backs that the camera does not see"),
            (large_triangles, "large triangles"),
            (multi_part_meshes, "meshes of several parts"),
            (shared_meshes, "shared meshes"),
            (mirrored_instances, "mirrored instances"),
            (motion, "motion"),
        ];
        [true, false].map(|wanted| {
            let chosen = features.iter().filter(|(required, _)| *required == wanted);
            chosen.map(|(_, name)| *name).collect()
        })
    }
}

/// The ratio of a triangle's longest edge to [`usual_size`] (the usual size of the scene's instances) above which the
/// triangle counts as large. At this ratio, barycentric weights in f32 locate a point with an error of a thousandth of the
/// usual size.
const LARGE: f64 = 10_000.0;

/// The length of the longest edge of all triangles of a mesh, in object space; 0 if there are no triangles. Multiplied by
/// the largest scale of an instance, it decides whether the scene has large triangles (see [`LARGE`]).
fn longest_edge(mesh: &Mesh) -> f64 {
    let corner = |index: u32| mesh.positions[index as usize].as_dvec3();
    let edges = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    edges
        .map(|(a, b)| corner(a).distance(corner(b)))
        .fold(0.0, f64::max)
}

impl Material {
    /// True if the surface has a specular lobe: it is partly metal, or `specular` is above 0. Otherwise the surface is pure
    /// Lambert. If no surface of a scene has a specular lobe, shaders leave out the code for the lobe.
    pub fn has_specular_lobe(&self) -> bool {
        self.metallic > 0.0 || self.specular > 0.0
    }

    /// True if the camera looks through the back of the surface, as glTF asks for materials that are not double-sided. The
    /// back of a volume is the inside of its boundary, which a camera in the volume sees.
    pub fn hides_its_back(&self) -> bool {
        self.culled && !self.layers.bounds_a_volume()
    }
}

impl Scene {
    /// The number of triangles in the world, for reports. The triangles of a mesh count once for each instance of the mesh.
    pub fn triangle_count(&self) -> u64 {
        self.count_triangles(|mesh| mesh.triangles.len() as u64)
    }

    /// The number of triangles in the world that emit light at some time, for reports. The triangles of a mesh count once
    /// for each instance of the mesh.
    pub fn emissive_triangle_count(&self) -> u64 {
        self.count_emissive(&Emitters::new(self, &self.emitter_materials()))
    }

    /// True if some material has a layer that is seen. The layers of all materials are then stored on the device.
    pub fn has_layers(&self) -> bool {
        self.materials.iter().any(|m| m.layers.are_seen())
    }

    fn count_emissive(&self, emitters: &Emitters<'_>) -> u64 {
        self.count_triangles(|mesh| {
            let parts = mesh.parts.iter();
            parts.map(|part| emitters.count(mesh, part)).sum()
        })
    }

    fn count_triangles(&self, of_mesh: impl Fn(&Mesh) -> u64) -> u64 {
        let counts: Vec<u64> = self.meshes.iter().map(of_mesh).collect();
        self.instances
            .iter()
            .map(|instance| counts[instance.mesh as usize])
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::layers::{Anisotropy, Coat, Transmission};
    use super::super::{Instance, Layers, Motion, Part, PunctualLight, Texture};
    use super::*;
    use glam::{DAffine3, DVec3, Vec3, Vec4};

    fn mesh(materials: &[u32]) -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]; materials.len()],
            parts: (0..)
                .zip(materials)
                .map(|(first_triangle, &material)| Part {
                    first_triangle,
                    triangle_count: 1,
                    material,
                })
                .collect(),
            ..Mesh::default()
        }
    }

    fn instance(mesh: u32, x_scale: f64) -> Instance {
        Instance {
            name: String::new(),
            mesh,
            object_to_world: DAffine3::from_scale(DVec3::new(x_scale, 1.0, 1.0)),
        }
    }

    #[test]
    fn nothing_requires_nothing() {
        assert_eq!(Requirements::of(&Scene::default()), Requirements::default());
    }

    #[test]
    fn only_what_is_placed_counts() {
        let emissive = Material {
            emission: Vec3::ONE,
            double_sided: true,
            culled: true,
            roughness: 0.0,
            layers: Layers {
                coat: Coat {
                    factor: 0.5,
                    ..Coat::default()
                },
                anisotropy: Anisotropy {
                    strength: 0.5,
                    ..Anisotropy::default()
                },
                transmission: Transmission {
                    factor: 0.5,
                    ..Transmission::default()
                },
                ..Layers::default()
            },
            unlit: true,
            base_color_texture: Some(Texture::plain(0)),
            specular_texture: Some(Texture::plain(0)),
            ..Material::default()
        };
        let mut scene = Scene {
            meshes: vec![mesh(&[0]), mesh(&[0, 1])],
            materials: vec![Material::lambert("", Vec3::ONE), emissive],
            instances: vec![instance(0, 1.0)],
            ..Scene::default()
        };
        let plain = Requirements {
            triangles: 1,
            instances: 1,
            ..Requirements::default()
        };
        assert_eq!(Requirements::of(&scene), plain);
        scene.meshes[1].normals = vec![Vec3::Z; 3];
        scene.meshes[1].colors = vec![Vec4::ONE; 3];
        scene.instances.push(instance(1, 1.0));
        scene.instances.push(instance(1, -1.0));
        scene.motion = Some(Motion::default());
        scene.punctual_lights = vec![PunctualLight::point(1.0)];
        scene.environment = Some(crate::scene::environment::sky::generate("width=64").unwrap());
        let all = Requirements {
            triangles: 5,
            emissive_triangles: 2,
            instances: 3,
            double_sided_emitters: true,
            punctual_lights: 1,
            environment: true,
            specular: true,
            near_delta: true,
            coat: true,
            anisotropy: true,
            transmission: true,
            textures: true,
            specular_textures: true,
            deep_textures: false,
            alpha: false,
            blending: false,
            blended_lights: false,
            normal_maps: false,
            unlit: true,
            culled: true,
            emissive_textures: false,
            vertex_colors: true,
            smooth_normals: true,
            large_triangles: false,
            named_surfaces: true,
            multi_part_meshes: true,
            shared_meshes: true,
            mirrored_instances: true,
            motion: true,
        };
        assert_eq!(Requirements::of(&scene), all);
    }

    #[test]
    fn only_surfaces_that_let_light_pass_ask_for_more_rays() {
        let mut scene = Scene {
            meshes: vec![mesh(&[0])],
            materials: vec![Material {
                alpha: 0.5,
                alpha_mode: AlphaMode::Blend,
                ..Material::lambert("", Vec3::ONE)
            }],
            instances: vec![instance(0, 1.0)],
            ..Scene::default()
        };
        let blends = |scene: &Scene| {
            let required = Requirements::of(scene);
            (required.alpha, required.blending, required.blended_lights)
        };
        assert_eq!(blends(&scene), (true, true, false));
        scene.materials[0].emission = Vec3::ONE;
        assert_eq!(blends(&scene), (true, true, true));
        scene.materials[0].alpha = 1.0;
        assert_eq!(blends(&scene), (true, false, false));
        scene.meshes[0].colors = vec![Vec4::ONE; 3];
        assert_eq!(blends(&scene), (true, true, true));
    }
}
