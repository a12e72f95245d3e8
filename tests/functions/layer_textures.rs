//! Tests of the layers of a material at a point of a surface: textures, and the direction of anisotropic lobes.

use crate::support::random::Random;
use crate::textures::{UNITS, image};
use crate::{Function, number, vector};
use glam::{Affine2, DVec2, DVec3, Vec2, Vec4};
use headwater::device_scene::materials::Materials;
use headwater::scene::layers::{Anisotropy, Coat, Transmission};
use headwater::scene::texture::{Texture, linear};
use headwater::scene::{Layers, Material, Scene};
use headwater::shader_interface::{Specialisation, Textures};

/// Random materials with layers, each value with or without a texture in an image of 8 texels. Some angles are huge.
fn textured_layers() -> Scene {
    let mut random = Random(31);
    let mut unit = || random.unit() as f32;
    let texture = |texel: usize| Texture {
        nearest: true,
        transform: Affine2::from_translation(Vec2::new((texel as f32 + 0.5) / 8.0, 0.5)),
        ..Texture::plain(0)
    };
    let materials = (0..24).map(|i| Material {
        layers: Layers {
            coat: Coat {
                factor: unit(),
                texture: (i % 4 != 0).then(|| texture(i % 8)),
                roughness: unit(),
                roughness_texture: (i % 4 != 1).then(|| texture((i + 3) % 8)),
                ..Coat::default()
            },
            anisotropy: Anisotropy {
                strength: 0.1 + 0.9 * unit(),
                rotation: [0.0, 6.0 * unit() - 3.0, 1e6 * unit()][i % 3],
                texture: (i % 4 != 2).then(|| texture((i + 5) % 8)),
            },
            transmission: Transmission {
                factor: unit(),
                texture: (i % 4 != 3).then(|| texture((i + 6) % 8)),
            },
            ..Layers::default()
        },
        ..Material::default()
    });
    Scene {
        materials: materials.collect(),
        images: vec![image(&mut Random(32), 8, 1)],
        ..Scene::default()
    }
}

/// The layers of a material where the mesh has this normal and tangent: coat, its roughness, transmission and anisotropy, and the
/// direction in which the specular lobe is wider.
fn twin_of_layers(
    layers: &Layers,
    scene: &Scene,
    normal: DVec3,
    tangent: DVec3,
) -> ([f64; 4], DVec3) {
    let at = |texture: &Option<Texture>| {
        let found = texture.as_ref();
        found.map_or(Vec4::ONE, |t| t.at(&scene.images[0], Vec2::ZERO, linear))
    };
    let (coat, anisotropy) = (&layers.coat, &layers.anisotropy);
    let values = [
        coat.factor * at(&coat.texture).x,
        coat.roughness * at(&coat.roughness_texture).y,
        layers.transmission.factor * at(&layers.transmission.texture).x,
        anisotropy.strength * at(&anisotropy.texture).z,
    ];
    let direction = match &anisotropy.texture {
        Some(_) => (at(&anisotropy.texture).truncate().truncate() * 2.0 - 1.0).as_dvec2(),
        None => DVec2::X,
    };
    let turned = DVec2::from_angle(anisotropy.rotation.into()).rotate(direction.normalize());
    let tangent = (tangent - tangent.dot(normal) * normal).normalize();
    let bitangent = normal.cross(tangent);
    let grain = turned.x * tangent + turned.y * bitangent;
    (values.map(f64::from), grain)
}

/// Textures multiply values by the channels of the glTF extensions, and the direction of anisotropy is turned from the tangent of
/// the mesh towards the bitangent.
#[test]
fn layers_have_the_channels_and_directions_of_their_textures() {
    let scene = textured_layers();
    let tables = Materials::of(&scene, &UNITS, Textures::Buffer);
    let constants = Specialisation {
        has_coat: true,
        has_anisotropy: true,
        has_transmission: true,
        surfaces_named: true,
        ..Specialisation::default()
    };
    let mut function = Function {
        includes: &["bsdf/bsdf.glsl", "scene/surface_layers.glsl"],
        // A corner direction of zeros is +Z in object space, which the instance turns to the tangent. There are 24 materials,
        // behind which are the layers.
        body: "GpuInstance instance = load_instances(0u);
            vec3 tangent = uintBitsToFloat(b.xyz), u, v;
            tangent_frame(tangent, u, v);
            instance.object_to_world[0] = u; instance.object_to_world[1] = v; instance.object_to_world[2] = tangent;
            TrianglePoint point;
            point.normal = point.shading_normal = uintBitsToFloat(a.xyz);
            Layers layers = layers_at(24u + a.w, instance, 0u, vec2(0.25), point);
            x = floatBitsToUint(vec4(layers.coat, layers.coat_roughness, layers.transmission, layers.anisotropy));
            y.xyz = floatBitsToUint(layers.grain);",
        materials: &tables.materials,
        textures: &tables.textures,
        texels: &tables.texels,
        constants: &constants.words(),
        ..Function::default()
    };
    let mut random = Random(33);
    let mut cases = Vec::new();
    while cases.len() < 2400 {
        let (normal, tangent) = (random.direction(), random.direction());
        if normal.dot(tangent).abs() < 0.9 {
            cases.push((cases.len() % 24, normal, tangent));
        }
    }
    let inputs = cases.iter().map(|(material, normal, tangent)| {
        let [n, t] = [normal, tangent].map(|d| d.as_vec3().to_array().map(f32::to_bits));
        [n[0], n[1], n[2], *material as u32, t[0], t[1], t[2], 0]
    });
    let inputs: Vec<[u32; 8]> = inputs.collect();
    let farthest = |function: &Function| {
        let gaps =
            (cases.iter().zip(function.run(&inputs))).map(|((m, normal, tangent), words)| {
                let layers = &scene.materials[*m].layers;
                let (values, grain) = twin_of_layers(layers, &scene, *normal, *tangent);
                let gaps = (0..4).map(|i| (number(words[i]) - values[i]).abs());
                gaps.fold(grain.distance(vector(&words[4..])), f64::max)
            });
        gaps.fold(0.0, f64::max)
    };
    let off = farthest(&function);
    assert!(off < 5e-6, "{off}");
    for (text, planted) in [
        (
            "(used.coat_texture, instance, primitive, weights).r",
            "(used.coat_texture, instance, primitive, weights).g",
        ),
        (
            "(used.coat_roughness_texture, instance, primitive, weights).g",
            "(used.coat_roughness_texture, instance, primitive, weights).r",
        ),
        ("layers.transmission *=", "layers.transmission +="),
        ("anisotropy *= value.b", "anisotropy *= value.r"),
        ("value.rg", "value.gr"),
        (
            "on_circle(used.anisotropy_turns)",
            "on_circle(1.0 - used.anisotropy_turns)",
        ),
        ("+ direction.y * bitangent", "- direction.y * bitangent"),
    ] {
        function.fault = Some(("scene/surface_layers.glsl", text, planted));
        assert!(farthest(&function) > 0.01, "{text}");
    }
}
