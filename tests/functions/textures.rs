//! Tests of shader functions: look-ups of textures.

use crate::support::brute_force::Surface;
use crate::support::{self, random::Random};
use crate::{Function, floats, number, vector};
use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};
use headwater::device_scene::materials::Materials;
use headwater::device_scene::units::Units;
use headwater::scene::texture::{Image, Texture, Wrap, linear, srgb};
use headwater::scene::{Material, Scene};
use headwater::shader_interface::{GpuMaterial, NONE, Textures};

/// The units of scenes whose numbers stay as they are.
pub const UNITS: Units = Units {
    origin: DVec3::ZERO,
    length: 1.0,
    radiance: 1.0,
};

/// An image of `width` × `height` random texels.
pub fn image(random: &mut Random, width: u32, height: u32) -> Image {
    let texel = |_| [0; 4].map(|_: u8| random.index(256) as u8);
    Image {
        name: String::new(),
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
    }
}

/// An image of `width` × `height` random texels with 16 bits per channel.
fn deep_image(random: &mut Random, width: u32, height: u32) -> Image {
    let texel = |_| [0; 4].map(|_: u16| random.index(65536) as u16);
    Image {
        texels: (0..width * height)
            .map(texel)
            .flat_map(Image::entries)
            .collect(),
        ..image(&mut Random(0), width, height)
    }
}

fn looked_up(is_color: bool) -> String {
    format!(
        "x = floatBitsToUint(texture_at(load_textures(a.z), uintBitsToFloat(a.xy), {is_color}));"
    )
}

/// The distance between the colour that the shader found in `words` for `input`, with the texture coordinates of the look-up,
/// and that of the twin in f64.
fn distance(
    texture: &Texture,
    scene: &Scene,
    is_color: bool,
    input: &[u32],
    words: [u32; 8],
) -> f32 {
    let uv = Vec2::new(f32::from_bits(input[0]), f32::from_bits(input[1]));
    let image = &scene.images[texture.image as usize];
    let expected = texture.at(image, uv, if is_color { srgb } else { linear });
    let found = Vec4::from_array([0, 1, 2, 3].map(|c| number(words[c]) as f32));
    found.distance(expected)
}

/// Look-ups with every wrap mode and filter, with a transform, near the image and far from it, must equal those of the twin
/// in f64.
#[test]
fn lookups_are_those_of_the_twin() {
    let mut random = Random(11);
    let images = vec![
        image(&mut random, 5, 3),
        image(&mut random, 1, 1),
        image(&mut random, 64, 32),
        deep_image(&mut random, 7, 4),
    ];
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let mut textures = Vec::new();
    for image in 0..images.len() as u32 {
        for (wrap, other) in [(0, 1), (1, 2), (2, 0)] {
            for nearest in [false, true] {
                let scale = Vec2::new(1.5, -0.75);
                textures.push(Texture {
                    image,
                    transform: Affine2::from_scale_angle_translation(
                        scale,
                        0.3,
                        Vec2::new(0.1, -2.0),
                    ),
                    wrap: [wraps[wrap], wraps[other]],
                    nearest,
                    ..Texture::plain(0)
                });
            }
        }
    }
    let scene = Scene {
        materials: (textures.iter())
            .map(|texture| Material {
                base_color_texture: Some(*texture),
                ..Material::default()
            })
            .collect(),
        images,
        ..Scene::default()
    };
    let tables_of = |read| Materials::of(&scene, &UNITS, read);
    let tables = tables_of(Textures::Buffer);
    let mut inputs = Vec::new();
    for texture in 0..textures.len() {
        for i in 0..400 {
            let reach = if i % 2 == 0 { 2.0 } else { 100.0 };
            let uv = [(); 2].map(|()| ((random.unit() * 2.0 - 1.0) * reach) as f32);
            let mut input = floats(&uv);
            input[2] = texture as u32;
            inputs.push(input);
        }
    }
    for is_color in [true, false] {
        let body = looked_up(is_color);
        let mut function = Function {
            includes: &["scene/textures.glsl"],
            body: &body,
            materials: &tables.materials,
            textures: &tables.textures,
            texels: &tables.texels,
            ..Function::default()
        };
        let wrong = |found: Vec<[u32; 8]>| {
            let mut wrong = 0;
            for (input, words) in inputs.iter().zip(found) {
                let texture = &textures[input[2] as usize];
                let distance = distance(texture, &scene, is_color, input, words);
                // Far from the image the position within it is rounded to a thousandth of a texel; the nearest texel may
                // then be another.
                wrong += usize::from(distance > 5e-3);
            }
            wrong
        };
        let found = function.run(&inputs);
        if support::tests_device().1.image_arrays {
            let tables = tables_of(Textures::Images);
            let mut sampled = Function {
                textures: &tables.textures,
                texels: &tables.texels,
                images: &scene.images,
                ..function.clone()
            };
            // The table of sRGB alone, for 8 and for 16 bits.
            assert_eq!(tables.texels.len(), 256 + 65536);
            assert!(
                sampled.run(&inputs) == found,
                "images give other bits than the buffer"
            );
            sampled.fault = Some(("scene/textures.glsl", "ivec2(x, y), 0", "ivec2(y, x), 0"));
            assert!(sampled.run(&inputs) != found);
        }
        let off = wrong(found);
        assert!(off * 500 < inputs.len(), "{off} of {}", inputs.len());
        function.fault = Some(("scene/textures.glsl", "period - 1 - i", "period - 2 - i"));
        assert!(wrong(function.run(&inputs)) * 20 > inputs.len());
    }
}

#[test]
fn coordinates_that_are_huge_stay_inside_the_image() {
    let mut random = Random(3);
    let scene = Scene {
        images: vec![image(&mut random, 3, 7)],
        materials: [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp]
            .map(|wrap| Material {
                base_color_texture: Some(Texture {
                    wrap: [wrap; 2],
                    ..Texture::plain(0)
                }),
                ..Material::default()
            })
            .into(),
        ..Scene::default()
    };
    let tables = Materials::of(&scene, &UNITS, Textures::Buffer);
    // Only texels of the image have this value: all others of the array would be wrong.
    let before = vec![0; tables.textures[0].index as usize];
    let texels = [&before[..], &[0x4040_4040; 21], &[0; 100]].concat();
    let function = Function {
        includes: &["scene/textures.glsl"],
        body: &looked_up(false),
        materials: &tables.materials,
        textures: &tables.textures,
        texels: &texels,
        ..Function::default()
    };
    let (infinity, nan) = (f32::INFINITY, f32::NAN);
    let huge = [
        1e9, -1e9, 3e38, -3e38, 16777217.0, -1e-30, 1.0, -1.0, 0.99999994, infinity, nan,
    ];
    let inputs: Vec<[u32; 8]> = (0..3)
        .flat_map(|texture| {
            huge.map(|u| {
                let mut input = floats(&[u, -u]);
                input[2] = texture;
                input
            })
        })
        .collect();
    for (input, words) in inputs.iter().zip(function.run(&inputs)) {
        let found = number(words[0]);
        assert!((found - 64.0 / 255.0).abs() < 1e-6, "{input:?}: {found}");
    }
}

/// The mean of stored colours must be the colour, dark colours included: otherwise a wall of one colour would be darker or
/// brighter.
#[test]
fn primary_surfaces_keep_their_colour_on_average() {
    let mut function = Function {
        includes: &["restir/sample_data.glsl"],
        body: "GpuMaterial material = material_at(0u);
            material.base_color = uintBitsToFloat(a.xyz);
            material.flags = MATERIAL_VARIES;
            vec3 sum = vec3(0.0), low = vec3(0.0);
            for (uint i = 0u; i < 4096u; i += 1u) {
                SampleData data;
                data.material_or_primitive = 0u;
                data.variation_or_weights = pack_material(material, 0u, vec3(float(i) / 4096.0));
                pair_add(sum, low, unpack_material(data).base_color);
            }
            x.xyz = floatBitsToUint((sum + low) / 4096.0);",
        materials: &[GpuMaterial {
            base_color_texture: NONE,
            metallic_roughness_texture: NONE,
            ..GpuMaterial::default()
        }],
        ..Function::default()
    };
    let colours = (0..3000).map(|i| (i as f32 / 2999.0).powi(3));
    // Vertex colours may be a little above 1.
    let colours: Vec<f32> = colours.chain([1.000_000_1, 0.3, 1.000_000_1]).collect();
    let inputs: Vec<[u32; 8]> = colours.chunks(3).map(floats).collect();
    let worst = |function: &Function| {
        let found = function.run(&inputs);
        let errors = found
            .iter()
            .zip(colours.chunks(3))
            .flat_map(|(words, colours)| {
                let error = |c: usize| {
                    (number(words[c]) - f64::from(colours[c])) / f64::from(colours[c].max(1e-5))
                };
                [error(0), error(1), error(2)]
            });
        errors.map(f64::abs).fold(0.0, f64::max)
    };
    let off = worst(&function);
    assert!(off < 2e-3, "{off}");
    function.fault = Some(("restir/sample_data.glsl", "numbers * (high", "0.5 * (high"));
    assert!(worst(&function) > 1e-2);
}

/// At the centres of texels, look-ups give all 16 bits of a texel, as colours and as numbers. Images of 8 bits in the same
/// scene stay as they are.
#[test]
fn sixteen_bits_reach_the_shader() {
    let mut random = Random(12);
    let mut images = vec![deep_image(&mut random, 64, 32), image(&mut random, 64, 32)];
    let mut texels = images[0].texels.to_vec();
    texels[..2].copy_from_slice(&Image::entries([0x8040, 1, 0, 0x8040]));
    images[0].texels = texels.into();
    let texture = |image, nearest| Texture {
        nearest,
        ..Texture::plain(image)
    };
    let material = |texture| Material {
        base_color_texture: Some(texture),
        ..Material::default()
    };
    let textures = [(0, false), (0, true), (1, false), (1, true)];
    let textures = textures.map(|(image, nearest)| texture(image, nearest));
    let scene = Scene {
        materials: textures.map(material).into(),
        images,
        ..Scene::default()
    };
    let mut inputs = Vec::new();
    for texture in 0..textures.len() as u32 {
        for (x, y) in (0..32).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let mut input = floats(&[(x as f32 + 0.5) / 64.0, (y as f32 + 0.5) / 32.0]);
            input[2] = texture;
            inputs.push(input);
        }
    }
    for read in [Textures::Buffer, Textures::Images] {
        if read == Textures::Images && !support::tests_device().1.image_arrays {
            continue;
        }
        let tables = Materials::of(&scene, &UNITS, read);
        for is_color in [true, false] {
            let body = looked_up(is_color);
            let mut function = Function {
                includes: &["scene/textures.glsl"],
                body: &body,
                materials: &tables.materials,
                textures: &tables.textures,
                texels: &tables.texels,
                images: if read == Textures::Images {
                    &scene.images
                } else {
                    &[]
                },
                ..Function::default()
            };
            let farthest = |found: Vec<[u32; 8]>| {
                let pairs = inputs.iter().zip(found);
                let distances = pairs.map(|(input, words)| {
                    let texture = &textures[input[2] as usize];
                    distance(texture, &scene, is_color, input, words)
                });
                distances.fold(0.0, f32::max)
            };
            let found = function.run(&inputs);
            let first = if is_color { 0.214_95 } else { 0.500_98 };
            assert!(
                (number(found[0][0]) - first).abs() < 5e-6,
                "{}",
                number(found[0][0])
            );
            let off = farthest(found);
            assert!(off < 1e-6, "{read:?} {is_color}: {off}");
            // The low bytes are lost.
            function.fault = Some(("scene/textures.glsl", "2u * x + 1u", "2u * x"));
            assert!(farthest(function.run(&inputs)) > 1e-3);
        }
    }
}

/// Random materials with a texture of the specular strength, of its colour, or with both, in an image of 8 texels.
fn specular_materials() -> Scene {
    let mut random = Random(13);
    let mut unit = || random.unit() as f32;
    let texture = |texel: usize| Texture {
        nearest: true,
        transform: Affine2::from_translation(Vec2::new((texel as f32 + 0.5) / 8.0, 0.5)),
        ..Texture::plain(0)
    };
    let materials = (0..24).map(|i| Material {
        base_color: Vec3::new(unit(), unit(), unit()),
        metallic: [0.0, unit(), 1.0][i / 2 % 3],
        roughness: 0.2 + 0.8 * unit(),
        specular: unit(),
        // Some of the products exceed the limit of 1.
        specular_color: Vec3::new(unit(), unit(), unit()) * 50.0,
        specular_texture: (i % 3 != 1).then(|| texture(i % 8)),
        specular_color_texture: (i % 3 != 0).then(|| texture((i + 3) % 8)),
        ..Material::default()
    });
    Scene {
        materials: materials.collect(),
        images: vec![image(&mut Random(14), 8, 1)],
        ..Scene::default()
    }
}

/// The same material with factors in place of its specular textures, each of which reads one texel.
fn with_factors(material: &Material, scene: &Scene) -> Material {
    let at = |texture: &Option<Texture>, decode: fn([u16; 4]) -> Vec4| match texture {
        Some(texture) => texture.at(&scene.images[0], Vec2::ZERO, decode),
        None => Vec4::ONE,
    };
    Material {
        specular: material.specular * at(&material.specular_texture, linear).w,
        specular_color: material.specular_color
            * at(&material.specular_color_texture, srgb).truncate(),
        ..material.clone()
    }
}

#[test]
fn specular_textures_multiply_their_factors() {
    let scene = specular_materials();
    let tables = Materials::of(&scene, &UNITS, Textures::Buffer);
    let mut function = Function {
        includes: &["bsdf/bsdf.glsl", "scene/textures.glsl"],
        body: "GpuInstance instance = load_instances(0u); instance.first_color = NONE;
            GpuMaterial material = material_at(a.w, instance, 0u, vec2(0.0));
            vec3 o = uintBitsToFloat(a.xyz); float pdf;
            x = floatBitsToUint(vec4(evaluate_bsdf(make_bsdf(material, NO_LAYERS, o), o, uintBitsToFloat(b.xyz), pdf), 0.0));",
        materials: &tables.materials,
        textures: &tables.textures,
        texels: &tables.texels,
        ..Function::default()
    };
    let mut random = Random(15);
    let mut upper = || {
        let d = random.direction();
        d.with_z(d.z.abs().max(0.05)).normalize().as_vec3()
    };
    let cases: Vec<(usize, Vec3, Vec3)> = (0..5000).map(|i| (i % 24, upper(), upper())).collect();
    let inputs = cases.iter().map(|(m, o, i)| {
        let [o, i] = [o, i].map(|d| d.to_array().map(f32::to_bits));
        [o[0], o[1], o[2], *m as u32, i[0], i[1], i[2], 0]
    });
    let inputs: Vec<[u32; 8]> = inputs.collect();
    let farthest = |function: &Function| {
        let gaps = cases
            .iter()
            .zip(function.run(&inputs))
            .map(|((m, o, i), words)| {
                let twin = Surface::new(&with_factors(&scene.materials[*m], &scene));
                let twin = twin.evaluate(o.as_dvec3(), i.as_dvec3());
                (vector(&words) - twin).abs().max_element() / twin.max_element().max(1e-6)
            });
        gaps.fold(0.0, f64::max)
    };
    let off = farthest(&function);
    assert!(off < 1e-4, "{off}");
    for fault in [
        (
            "dielectric_f90 *= texture_at(used, uv_at(instance, primitive, weights, used.set), false).a",
            "dielectric_f90 *= 1.0",
        ),
        (
            "uv_at(instance, primitive, weights, used.set), false).a;\n        index += 1u;",
            "uv_at(instance, primitive, weights, used.set), false).a;",
        ),
        (
            "min(material.dielectric_f0, vec3(1.0)) *",
            "material.dielectric_f0 *",
        ),
    ] {
        function.fault = Some(("scene/textures.glsl", fault.0, fault.1));
        assert!(farthest(&function) > 0.01, "{fault:?}");
    }
}

/// Primary surfaces keep what specular textures change: each value by its mean over many random numbers, and exactly where it
/// is 0 or 1.
#[test]
fn primary_surfaces_keep_their_specular_textures_on_average() {
    let scene = specular_materials();
    let tables = Materials::of(&scene, &UNITS, Textures::Buffer);
    let mut function = Function {
        includes: &["restir/sample_data.glsl"],
        body: "GpuInstance instance = load_instances(0u); instance.first_color = NONE;
            GpuMaterial material = material_at(a.x, instance, 0u, vec2(0.0));
            vec3 f0 = vec3(0.0), f0_low = vec3(0.0), f90 = vec3(0.0), f90_low = vec3(0.0);
            for (uint i = 0u; i < 4096u; i += 1u) {
                SampleData data;
                data.material_or_primitive = a.x;
                data.variation_or_weights = pack_material(material, a.x, to_unit(pcg4d(uvec4(i, 1u, 2u, 3u))).xyz);
                GpuMaterial found = unpack_material(data);
                pair_add(f0, f0_low, found.dielectric_f0);
                pair_add(f90, f90_low, vec3(found.dielectric_f90));
            }
            x = floatBitsToUint(vec4((f0 + f0_low) / 4096.0, (f90.x + f90_low.x) / 4096.0));
            y = floatBitsToUint(vec4(material.dielectric_f0, material.dielectric_f90));",
        materials: &tables.materials,
        textures: &tables.textures,
        texels: &tables.texels,
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = (0..24).map(|m| [m, 0, 0, 0, 0, 0, 0, 0]).collect();
    let worst = |function: &Function| {
        let found = function.run(&inputs);
        let errors = found.iter().flat_map(|words| {
            let error = |i: usize| (number(words[i]) - number(words[i + 4])).abs();
            // Relative to the strength; a step of the colour is at most a fifteenth of it.
            (0..4).map(move |i| error(i) / number(words[7]).max(0.02))
        });
        errors.fold(0.0, f64::max)
    };
    let off = worst(&function);
    assert!(off < 3e-3, "{off}");
    for fault in [
        ("TINT_STEPS, vec3(more.x)", "TINT_STEPS, vec3(0.5)"),
        (
            "strength * COARSE_STEPS + more.y",
            "strength * COARSE_STEPS",
        ),
        ("tint * tint * material", "tint * material"),
    ] {
        function.fault = Some(("restir/sample_data.glsl", fault.0, fault.1));
        assert!(worst(&function) > 8e-3, "{fault:?}");
    }
}
