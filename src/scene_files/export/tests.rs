//! Tests that write scenes to files, and compare them with the scenes that are read from these files.

use super::*;
use crate::procedural;
use crate::scene::camera::Projection;
use crate::scene::layers::{Anisotropy, Coat, Transmission, Volume};
use crate::scene::texture::Wrap;
use crate::scene::{
    AlphaMode, Image, Layers, Material, Mesh, PunctualLight, PunctualShape, Texture,
};
use crate::scene_files::load;
use glam::{Affine2, Vec2, Vec4};

#[test]
fn what_moves_moves_when_it_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    for (name, parameters) in [
        ("motion", vec![]),
        ("conservatory", vec![("speed".into(), "1".into())]),
    ] {
        let scene = procedural::generate(name, &parameters).unwrap();
        let path = folder.path().join("moves.glb");
        write_glb(&scene, &path).unwrap();
        let back = load::load(&path).unwrap();
        for step in 0..40 {
            let time = 0.43 * f64::from(step);
            let (a, b) = (scene.pose_at(time).unwrap(), back.pose_at(time).unwrap());
            // A file may order them differently.
            let transforms = |scene: &Scene| {
                let instances = scene
                    .instances
                    .iter()
                    .map(|i| (i.name.clone(), i.object_to_world));
                let lights = scene
                    .punctual_lights
                    .iter()
                    .map(|l| (l.name.clone(), l.light_to_world));
                let cameras = scene
                    .cameras
                    .iter()
                    .map(|c| (c.name.clone(), c.camera_to_world));
                let mut transforms: Vec<_> = instances.chain(lights).chain(cameras).collect();
                transforms.sort_by(|a, b| a.0.cmp(&b.0));
                transforms
            };
            let (ours, others) = (transforms(&a), transforms(&b));
            assert_eq!(ours.len(), others.len());
            for ((name, transform), (other_name, other)) in ours.iter().zip(&others) {
                assert_eq!(name, other_name);
                assert!(transform.abs_diff_eq(*other, 1e-5), "{name} at {time} s");
            }
            for (a, b) in a.materials.iter().zip(&b.materials) {
                let same = a.emission.abs_diff_eq(b.emission, 1e-4);
                assert!(same, "{} at {time} s", a.name);
            }
        }
        assert_ne!(
            scene.pose_at(0.0).unwrap().content_hash(),
            scene.pose_at(0.4).unwrap().content_hash()
        );
    }
}

#[test]
fn every_factor_survives() {
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    let image = |name: &str, shade: u8| Image {
        name: name.into(),
        width: 1,
        height: 2,
        texels: [[shade, 10, 20, 30], [40, 50, 60, shade]].into(),
    };
    let deep = Image {
        texels: [[0x8040, 1, 2, 3], [4, 5, 6, 0xFF00]]
            .into_iter()
            .flat_map(Image::entries)
            .collect(),
        ..image("first", 0)
    };
    scene.images = vec![deep, image("second", 255)];
    let texture = Texture {
        image: 1,
        set: 1,
        transform: Affine2::from_scale_angle_translation(
            Vec2::new(2.0, -3.0),
            0.75,
            Vec2::new(0.25, 5.0),
        ),
        wrap: [Wrap::Mirror, Wrap::Clamp],
        nearest: true,
    };
    scene.materials[0] = Material {
        name: "all of it".into(),
        base_color: Vec3::new(0.1, 0.2, 0.3),
        base_color_texture: Some(texture),
        alpha: 0.5,
        alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
        metallic: 0.4,
        roughness: 0.6,
        metallic_roughness_texture: Some(Texture { set: 0, ..texture }),
        normal_texture: Some(Texture::plain(0)),
        normal_scale: -0.5,
        specular: 0.7,
        specular_color: Vec3::new(0.8, 0.9, 1.5),
        specular_texture: Some(Texture::plain(1)),
        specular_color_texture: Some(Texture { set: 0, ..texture }),
        ior: 1.7,
        layers: Layers {
            coat: Coat {
                factor: 0.25,
                texture: Some(Texture::plain(0)),
                roughness: 0.75,
                roughness_texture: Some(Texture::plain(1)),
                normal_texture: Some(texture),
                normal_scale: 0.3,
            },
            anisotropy: Anisotropy {
                strength: 0.6,
                rotation: -1.5,
                texture: Some(Texture::plain(1)),
            },
            transmission: Transmission {
                factor: 0.1,
                texture: Some(Texture::plain(0)),
            },
            volume: Volume {
                thickness: 2.0,
                attenuation_distance: 0.4,
                attenuation_color: Vec3::new(0.9, 0.5, 0.0),
            },
            dispersion: 0.2,
        },
        emission: Vec3::new(0.0, 3.0, 1e6),
        emissive_texture: Some(Texture {
            image: 0,
            ..texture
        }),
        double_sided: !scene.materials[0].double_sided,
        culled: false,
        unlit: false,
    };
    scene.materials[1] = Material {
        alpha: 0.25,
        alpha_mode: AlphaMode::Blend,
        culled: true,
        ..Material::unlit("seen", Vec3::new(0.3, 0.2, 0.1))
    };
    for mesh in &mut scene.meshes {
        let uvs = mesh
            .positions
            .iter()
            .map(|p| Vec2::new(p.x + p.y, p.y + p.z));
        // A set that no texture uses is not read.
        if mesh.parts.iter().any(|part| part.material == 0) {
            mesh.uvs = [uvs.clone().collect(), uvs.rev().collect()];
        }
        mesh.colors = mesh
            .positions
            .iter()
            .map(|p| p.abs().extend(0.5).min(Vec4::ONE))
            .collect();
    }
    let transform = DAffine3::from_translation(glam::DVec3::new(1.0, 2.0, 3.0));
    for (shape, intensity) in [
        (PunctualShape::Point, Vec3::new(0.1, 0.2, 0.0)),
        (PunctualShape::Directional, Vec3::new(1e5, 2e4, 0.0)),
        (
            PunctualShape::Spot {
                inner: 0.25,
                outer: 1.5,
            },
            Vec3::ONE,
        ),
    ] {
        scene.punctual_lights.push(PunctualLight {
            name: "a light".into(),
            light_to_world: transform,
            shape,
            intensity,
            range: (shape == PunctualShape::Point).then_some(7.0),
        });
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.glb");
    write_glb(&scene, &path).unwrap();
    let back = load::load(&path).unwrap();
    // Tangents are made while reading.
    for mesh in &mut scene.meshes {
        mesh.make_tangents(&scene.materials);
    }
    assert_eq!(difference(&scene, &back), None);
}

#[test]
fn an_image_with_too_few_texels_is_named() {
    let mut scene = procedural::generate("conservatory", &[]).unwrap();
    scene.images[0].width += 1;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.glb");
    let error = write_glb(&scene, &path).unwrap_err().to_string();
    assert!(error.contains(&scene.images[0].name), "{error}");
    assert!(!path.exists());
}

/// Compares the elements of two scenes as texts. Returns both texts around the first difference, or the numbers of elements
/// if these differ; `None` if the scenes are equal. `b` was read from a file, which stores the emission of materials and the
/// intensity of lights as colour times strength. These RGB vectors may therefore differ by up to 1e-6 of their length.
fn difference(a: &Scene, b: &Scene) -> Option<String> {
    let mut b = b.clone();
    let settle = |ours: &mut Vec3, of: Vec3| {
        if (of - *ours).length() <= 1e-6 * of.length() {
            *ours = of;
        }
    };
    for (a, b) in a.materials.iter().zip(&mut b.materials) {
        settle(&mut b.emission, a.emission);
    }
    for (a, b) in a.punctual_lights.iter().zip(&mut b.punctual_lights) {
        settle(&mut b.intensity, a.intensity);
    }
    // A file may order meshes, corners and images differently, so they are compared by what uses them; and a file that is
    // read has no negative zeros.
    let items = |s: &Scene| {
        let corner = |m: &Mesh, i: u32| {
            let i = i as usize;
            let uvs = m.uvs.each_ref().map(|uvs| uvs.get(i).copied());
            let (normal, tangent) = (m.normals.get(i), m.tangents.get(i));
            format!(
                "{:?} {normal:?} {tangent:?} {:?} {uvs:?}",
                m.positions[i],
                m.colors.get(i)
            )
        };
        let mesh = |m: &Mesh| {
            let triangles = m.triangles.iter();
            let corners: Vec<_> = triangles.map(|t| t.map(|i| corner(m, i))).collect();
            format!("{} {:?} {corners:?}", m.name, m.parts)
        };
        let meshes: Vec<String> = s.meshes.iter().map(mesh).collect();
        // Keys are stored in f32, so moving things may differ slightly.
        let motion = s.motion.clone().unwrap_or_default();
        let still = |list: &[Option<u32>], i: usize| list.get(i).copied().flatten().is_none();
        let instances =
            (s.instances.iter().enumerate()).filter(|(i, _)| still(&motion.instances, *i));
        let placed = instances.map(|(_, i)| {
            let text = format!("{} {:?} ", i.name, i.object_to_world);
            text + &meshes[i.mesh as usize]
        });
        let lights = s.punctual_lights.iter().enumerate().map(|(i, light)| {
            let mut light = light.clone();
            if !still(&motion.lights, i) {
                light.light_to_world = DAffine3::IDENTITY;
            }
            format!("{light:?}")
        });
        let materials = s.materials.iter().map(|m| {
            // Angles are rounded.
            let textures = m
                .textures()
                .map(|(_, t)| (&s.images[t.image as usize], t.transform));
            let mut text = format!("{:.6?}", textures.collect::<Vec<_>>());
            let mut m = m.clone();
            for texture in [
                &mut m.base_color_texture,
                &mut m.metallic_roughness_texture,
                &mut m.normal_texture,
                &mut m.specular_texture,
                &mut m.specular_color_texture,
                &mut m.emissive_texture,
                &mut m.layers.coat.texture,
                &mut m.layers.coat.roughness_texture,
                &mut m.layers.coat.normal_texture,
                &mut m.layers.anisotropy.texture,
                &mut m.layers.transmission.texture,
            ]
            .into_iter()
            .flatten()
            {
                (texture.image, texture.transform) = (0, Affine2::IDENTITY);
            }
            text += &format!("{m:?}");
            text
        });
        let cameras = s.cameras.iter().map(|c| format!("{c:.12?}"));
        materials
            .chain(cameras)
            .chain(lights)
            .chain(placed)
            .map(|text| {
                let text = text.replace("-0.0,", "0.0,").replace("-0.0)", "0.0)");
                text.replace("-0.000000000000", "0.000000000000")
                    .replace("-0.000000", "0.000000")
            })
            .collect::<Vec<_>>()
    };
    let (a, b) = (items(a), items(&b));
    if a.len() != b.len() {
        return Some(format!("{} items, {} items", a.len(), b.len()));
    }
    let (a, b) = a.iter().zip(&b).find(|(a, b)| a != b)?;
    let at = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
    let near = |text: &str| {
        text.chars()
            .skip(at.saturating_sub(80))
            .take(160)
            .collect::<String>()
    };
    Some(format!("{}\n{}", near(a), near(b)))
}

mod thorough {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        for procedural in procedural::list() {
            let scene = procedural::generate(procedural.name, &[]).unwrap();
            let path = folder.path().join(format!("{}.glb", procedural.name));
            write_glb(&scene, &path).unwrap();
            let back = load::load(&path).unwrap();
            assert_eq!(back.notices, Vec::<String>::new());
            let differs = difference(&scene, &back);
            assert_eq!(differs, None, "{}", procedural.name);
        }
    }
}

#[test]
fn orthographic_cameras_are_read_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parallel.glb");
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    let mut second = scene.cameras[0].clone();
    second.projection = Projection::Orthographic { height: 3.25 };
    second.aspect_ratio = Some(1.5);
    scene.cameras.push(second);
    write_glb(&scene, &path).unwrap();
    let back = load::load(&path).unwrap();
    assert_eq!(back.notices, scene.notices);
    for (ours, theirs) in scene.cameras.iter().zip(&back.cameras) {
        assert_eq!(ours.projection, theirs.projection);
        assert_eq!(ours.aspect_ratio, theirs.aspect_ratio);
    }
    let document = std::fs::read(&path).unwrap();
    let text = String::from_utf8_lossy(&document);
    assert!(
        text.contains(r#""xmag":2.4375,"ymag":1.625,"znear":0.0,"zfar":"#),
        "{text}"
    );
}
