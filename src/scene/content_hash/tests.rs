//! Tests that the hash of a scene changes with each value that changes the picture, and with no other value.

use super::*;
use crate::scene::Part;
use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};

fn scene() -> Scene {
    Scene {
        name: "one".into(),
        meshes: vec![Mesh {
            name: "m".into(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![],
            colors: vec![],
            tangents: vec![],
            uvs: [vec![], vec![]],
            triangles: vec![[0, 1, 2]],
            parts: vec![Part {
                first_triangle: 0,
                triangle_count: 1,
                material: 0,
            }],
            sources: vec![],
        }],
        materials: vec![Material::default()],
        images: vec![],
        instances: vec![Instance {
            name: "i".into(),
            mesh: 0,
            object_to_world: DAffine3::IDENTITY,
        }],
        cameras: vec![crate::scene::camera::look_at(DVec3::Z, DVec3::ZERO, 1.0)],
        punctual_lights: vec![],
        environment: None,
        motion: None,
        material_variants: vec![],
        notices: vec![],
    }
}

/// Each value of a deformation changes the hash.
#[test]
fn deformations_count() {
    type Change = fn(&mut Deformation);
    let changes: [Change; 9] = [
        |_| (),
        |d| d.mesh = 1,
        |d| d.rest.positions[0].x = 2.0,
        |d| d.targets[0].weight.rest = 0.5,
        |d| d.targets[0].positions[0].y = 1.0,
        |d| d.targets[0].normals = vec![Vec3::ONE],
        |d| d.skin.as_mut().unwrap().joints[0].node = 1,
        |d| {
            d.skin.as_mut().unwrap().joints[0].inverse_bind =
                DAffine3::from_scale(DVec3::splat(2.0))
        },
        |d| d.skin.as_mut().unwrap().influences[0].weight = 0.5,
    ];
    let mut hashes: Vec<String> = (changes.iter())
        .map(|change| {
            let mut deformation = Deformation {
                mesh: 0,
                rest: Vertices {
                    positions: vec![Vec3::ZERO],
                    ..Vertices::default()
                },
                targets: vec![MorphTarget {
                    weight: Animated::still(0.0),
                    positions: vec![Vec3::ZERO],
                    normals: vec![],
                    tangents: vec![],
                }],
                skin: Some(Skin {
                    joints: vec![Joint {
                        node: 0,
                        inverse_bind: DAffine3::IDENTITY,
                    }],
                    first_influence: vec![0, 1],
                    influences: vec![Influence {
                        joint: 0,
                        weight: 1.0,
                    }],
                    world_to_object: DAffine3::IDENTITY,
                }),
            };
            change(&mut deformation);
            let mut scene = scene();
            scene.motion = Some(Motion {
                deformations: vec![deformation],
                ..Motion::default()
            });
            scene.content_hash()
        })
        .collect();
    hashes.sort();
    let all = hashes.len();
    hashes.dedup();
    assert_eq!(hashes.len(), all);
}

#[test]
fn lights_count() {
    let light = PunctualLight {
        name: "l".into(),
        light_to_world: DAffine3::IDENTITY,
        shape: PunctualShape::Point,
        intensity: Vec3::ONE,
        range: None,
    };
    let environment = Environment {
        name: "e".into(),
        width: 2,
        height: 1,
        texels: vec![Vec3::ONE; 2].into(),
        rotation: 0.0,
        intensity: 1.0,
    };
    let lit = |light: &PunctualLight, environment: &Environment| {
        let scene = Scene {
            punctual_lights: vec![light.clone()],
            environment: Some(environment.clone()),
            ..scene()
        };
        scene.content_hash()
    };
    let spot = |inner| PunctualShape::Spot { inner, outer: 1.0 };
    let lights = [
        PunctualLight {
            intensity: Vec3::X,
            ..light.clone()
        },
        PunctualLight {
            range: Some(3.0),
            ..light.clone()
        },
        PunctualLight {
            shape: spot(0.1),
            ..light.clone()
        },
        PunctualLight {
            shape: spot(0.2),
            ..light.clone()
        },
        PunctualLight {
            shape: PunctualShape::Directional,
            ..light.clone()
        },
        PunctualLight {
            light_to_world: DAffine3::from_translation(DVec3::X),
            ..light.clone()
        },
    ];
    let environments = [
        Environment {
            rotation: 1.0,
            ..environment.clone()
        },
        Environment {
            intensity: 2.0,
            ..environment.clone()
        },
        Environment {
            texels: vec![Vec3::X; 2].into(),
            ..environment.clone()
        },
        Environment {
            width: 1,
            height: 2,
            ..environment.clone()
        },
    ];
    let mut hashes = vec![scene().content_hash(), lit(&light, &environment)];
    hashes.extend(lights.iter().map(|light| lit(light, &environment)));
    hashes.extend(
        environments
            .iter()
            .map(|environment| lit(&light, environment)),
    );
    for (index, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..index].contains(hash), "{index}");
    }
    let named = PunctualLight {
        name: "x".into(),
        ..light.clone()
    };
    assert_eq!(lit(&named, &environment), lit(&light, &environment));
}

#[test]
fn names_do_not_count() {
    let mut other = scene();
    other.name = "two".into();
    other.meshes[0].name.clear();
    other.materials[0].name = "x".into();
    other.instances[0].name.clear();
    other.notices.push("n".into());
    other.material_variants.push("v".into());
    other.notices.push("n".into());
    assert_eq!(scene().content_hash(), other.content_hash());
    assert_eq!(scene().content_hash().len(), 64);
}

#[test]
fn every_value_counts() {
    let changes: [fn(&mut Scene); 29] = [
        |s| s.meshes[0].positions[1].x = 2.0,
        |s| s.meshes[0].normals = vec![Vec3::Z; 3],
        |s| s.meshes[0].triangles[0] = [1, 2, 0],
        |s| s.meshes[0].parts[0].material = 1,
        |s| s.materials[0].base_color.y = 0.5,
        |s| s.materials[0].metallic = 0.5,
        |s| s.materials[0].roughness = 0.5,
        |s| s.materials[0].specular = 0.5,
        |s| s.materials[0].ior = 1.2,
        |s| s.materials[0].layers.coat.factor = 0.5,
        |s| s.materials[0].layers.coat.roughness = 0.5,
        |s| s.materials[0].layers.coat.normal_scale = 0.5,
        |s| s.materials[0].layers.anisotropy.strength = 0.5,
        |s| s.materials[0].layers.anisotropy.rotation = 0.5,
        |s| s.materials[0].layers.transmission.factor = 0.5,
        |s| s.materials[0].layers.volume.thickness = 0.5,
        |s| s.materials[0].layers.volume.attenuation_distance = 0.5,
        |s| s.materials[0].layers.volume.attenuation_color.y = 0.5,
        |s| s.materials[0].layers.dispersion = 0.5,
        |s| s.materials[0].emission.z = 1.0,
        |s| s.materials[0].double_sided = true,
        |s| s.materials[0].culled = true,
        |s| s.instances[0].object_to_world.translation.x = 1.0,
        |s| s.cameras[0].aspect_ratio = Some(1.0),
        |s| s.cameras[0].projection = Projection::Orthographic { height: 1.0 },
        |s| {
            let lens = Lens {
                diameter: 0.1,
                focus_distance: 2.0,
            };
            s.cameras[0] = s.cameras[0].clone().with_lens(lens).unwrap();
        },
        |s| s.cameras.clear(),
        |s| s.motion = Some(Motion::default()),
        |s| {
            s.motion = Some(Motion {
                emission: vec![Emission {
                    material: 0,
                    color: Animated::still(DVec3::ONE),
                    strength: Animated::still(1.0),
                }],
                ..Motion::default()
            });
        },
    ];
    let mut seen = vec![scene().content_hash()];
    for change in changes {
        let mut scene = scene();
        change(&mut scene);
        seen.push(scene.content_hash());
    }
    seen.sort();
    let all = seen.len();
    seen.dedup();
    assert_eq!(seen.len(), all);
}

/// A scene whose material has each texture that a material can have: of base colour, metalness with roughness, normals,
/// specular reflection and its colour, and emission. The scene has two images, and the textures use the first one. The tests then change
/// one value after the other.
fn textured() -> Scene {
    let image = |value| Image {
        name: "i".into(),
        width: 2,
        height: 1,
        texels: vec![[value; 4], [9; 4]].into(),
    };
    let mut scene = scene();
    scene.images = vec![image(1), image(2)];
    scene.meshes[0].uvs = [vec![Vec2::ZERO; 3], vec![Vec2::ZERO; 3]];
    scene.meshes[0].tangents = vec![Vec4::X; 3];
    scene.meshes[0].colors = vec![Vec4::ONE; 3];
    let material = &mut scene.materials[0];
    material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    for slot in slots(material) {
        *slot = Some(Texture::plain(0));
    }
    scene
}

fn slots(material: &mut Material) -> [&mut Option<Texture>; 11] {
    [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.normal_texture,
        &mut material.specular_texture,
        &mut material.specular_color_texture,
        &mut material.emissive_texture,
        &mut material.layers.coat.texture,
        &mut material.layers.coat.roughness_texture,
        &mut material.layers.coat.normal_texture,
        &mut material.layers.anisotropy.texture,
        &mut material.layers.transmission.texture,
    ]
}

#[test]
fn every_value_of_images_and_textures_counts() {
    let whole: [fn(&mut Scene); 13] = [
        |s| s.images[0].texels = vec![[1; 4], [8; 4]].into(),
        |s| (s.images[0].width, s.images[0].height) = (1, 2),
        |s| s.images.swap(0, 1),
        |s| s.images.truncate(1),
        |s| s.meshes[0].uvs[0][1].x = 1.0,
        |s| s.meshes[0].uvs[1][1].x = 1.0,
        |s| s.meshes[0].tangents[0].w = -1.0,
        |s| s.meshes[0].colors[0].w = 0.0,
        |s| s.materials[0].normal_scale = 0.5,
        |s| s.materials[0].alpha = 0.5,
        |s| s.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.25 },
        |s| s.materials[0].alpha_mode = AlphaMode::Blend,
        |s| s.materials[0].unlit = true,
    ];
    let of_a_texture: [fn(&mut Texture); 6] = [
        |t| t.image = 1,
        |t| t.set = 1,
        |t| t.transform = Affine2::from_translation(Vec2::X),
        |t| t.wrap[0] = Wrap::Clamp,
        |t| t.wrap[1] = Wrap::Mirror,
        |t| t.nearest = true,
    ];
    let mut hashes = vec![textured().content_hash()];
    let mut check = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = textured();
        change(&mut scene);
        let hash = scene.content_hash();
        assert!(!hashes.contains(&hash), "{name}");
        hashes.push(hash);
    };
    for (index, change) in whole.iter().enumerate() {
        check(&format!("change {index}"), change);
    }
    for slot in 0..11 {
        let texture = |scene: &mut Scene, change: &dyn Fn(&mut Option<Texture>)| {
            change(slots(&mut scene.materials[0])[slot]);
        };
        check(&format!("texture {slot}"), &|scene| {
            texture(scene, &|texture| *texture = None);
        });
        for (index, change) in of_a_texture.iter().enumerate() {
            check(&format!("change {index} of texture {slot}"), &|scene| {
                texture(scene, &|texture| {
                    texture.as_mut().into_iter().for_each(change)
                });
            });
        }
    }
    let mut renamed = textured();
    renamed.images[0].name.clear();
    assert_eq!(renamed.content_hash(), hashes[0]);
}
