//! Tests of MTL statements as programs write them: factors of 0 beside textures, textures without a file, options, opacity,
//! bump maps and the keywords of physically based materials.

use crate::files::Folder;
use glam::Vec3;
use headwater::scene::texture::{Image, Wrap};
use headwater::scene::{AlphaMode, Material, Scene};
use headwater::scene_files::{Options, load_watched};
use image::RgbaImage;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// Writes a PNG file with these texels in rows of `width`.
fn write_image(folder: &Folder, name: &str, width: u32, texels: &[[u8; 4]]) {
    let bytes = texels.as_flattened().to_vec();
    let image = RgbaImage::from_raw(width, texels.len() as u32 / width, bytes).unwrap();
    image.save(folder.path(name)).unwrap();
}

const GREEN: [u8; 4] = [0, 255, 0, 255];
/// A normal that leans to +x, and one that points along z.
const NORMALS: [[u8; 4]; 2] = [[218, 128, 218, 255], [128, 128, 255, 255]];

fn folder() -> Folder {
    let folder = Folder::new();
    write_image(&folder, "t.png", 1, &[GREEN]);
    write_image(&folder, "wide.png", 2, &[GREEN, [255, 0, 0, 255]]);
    write_image(&folder, "holes.png", 2, &[GREEN, [9, 9, 9, 0]]);
    write_image(&folder, "grey.png", 2, &[[51, 51, 51, 255], [255; 4]]);
    write_image(&folder, "normals.png", 2, &NORMALS);
    folder
}

fn text(folder: &Folder, mtl: &str) -> String {
    folder.write("m.mtl", format!("newmtl a\n{mtl}\n"));
    format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1/1 2/2 3/3 4/4\n")
}

fn load(folder: &Folder, mtl: &str) -> Scene {
    folder.load("scene.obj", text(folder, mtl))
}

/// Loads with the user's permission that image files are missing.
fn load_without_files(folder: &Folder, mtl: &str) -> Scene {
    let path = folder.write("scene.obj", text(folder, mtl));
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    load_watched(&path, options, &mut |_, _, _| Ok(())).unwrap()
}

/// The image of the base colour texture.
fn base_image(scene: &Scene) -> &Image {
    &scene.images[scene.materials[0].base_color_texture.unwrap().image as usize]
}

#[test]
fn a_factor_of_0_beside_a_texture_counts_as_1() {
    let folder = folder();
    let notice = |keyword: &str| {
        format!("a factor of 0 beside a texture counts as 1: {keyword} of material \"a\"")
    };
    for order in ["Kd 0 0 0\nmap_Kd t.png", "map_Kd t.png\nKd 0 0 0"] {
        let scene = load(&folder, order);
        assert_eq!(scene.materials[0].base_color, Vec3::ONE);
        assert_eq!(*base_image(&scene).texels, [GREEN]);
        assert_eq!(scene.notices, [notice("Kd")]);
    }
    let scene = load(&folder, "Kd 0 0 0\nKe 0\nmap_Ke t.png");
    let material = &scene.materials[0];
    assert_eq!(
        (material.base_color, material.emission),
        (Vec3::ZERO, Vec3::ONE)
    );
    assert!(material.emissive_texture.is_some());
    assert_eq!(scene.notices, [notice("Ke")]);
    let scene = load(&folder, "Pr 0\nPm 0\nmap_Pr grey.png\nmap_Pm grey.png");
    assert_eq!(
        (scene.materials[0].roughness, scene.materials[0].metallic),
        (1.0, 1.0)
    );
    assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
    // Without a texture 0 is black, and another factor is kept.
    let scene = load(&folder, "Kd 0 0 0");
    assert_eq!(scene.materials[0].base_color, Vec3::ZERO);
    let scene = load(&folder, "Kd 0 0.5 0\nmap_Kd t.png");
    assert_eq!(scene.materials[0].base_color, Vec3::new(0.0, 0.5, 0.0));
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
}

#[test]
fn textures_without_a_file_have_a_notice() {
    let folder = folder();
    let empty = "Kd .25 .5 .75\nmap_Kd \nmap_bump \nbump\nmap_d \nrefl \nmap_Ks";
    let scene = load(&folder, empty);
    assert_eq!(
        scene.materials,
        [Material::lambert("a", Vec3::new(0.25, 0.5, 0.75))]
    );
    assert_eq!(
        scene.notices,
        ["textures without a file name are ignored: 6 times, first map_Kd in line 3 of \"m.mtl\""]
    );
    for statement in [
        "map_Kd -s 2 2",
        "map_Kd -s 1 1 1",
        "map_Kd -o 0.5",
        "map_Bump -bm 1",
        "map_bump -bm",
        "map_Kd -clamp on",
        "map_Kd -q",
        "map_Kd -imfchan r",
        "MAP_KD\t",
    ] {
        let scene = load(&folder, statement);
        assert_eq!(
            scene.materials,
            [Material::lambert("a", Vec3::splat(0.8))],
            "{statement}"
        );
        let found = scene
            .notices
            .iter()
            .filter(|line| line.starts_with("textures without a file"));
        assert_eq!(found.count(), 1, "{statement}: {:?}", scene.notices);
    }
}

#[test]
fn unknown_options_have_a_notice() {
    let folder = folder();
    for option in [
        "-q",
        "-q 1",
        "-q 1 2 3 4",
        "-q on",
        "-q word",
        "-q word other",
        "-q\t1",
    ] {
        let scene = load(&folder, &format!("map_Kd {option} t.png"));
        assert_eq!(*base_image(&scene).texels, [GREEN], "{option}");
        assert_eq!(
            scene.notices,
            ["unknown options of textures are ignored: \"-q\" in line 2 of \"m.mtl\""]
        );
    }
}

#[test]
fn options_may_stand_behind_the_file_and_lack_their_values() {
    let folder = folder();
    write_image(&folder, "2 a t.png", 1, &[GREEN]);
    for (statement, scale, wrap) in [
        ("t.png -s 2 3", (2.0, 3.0), Wrap::Repeat),
        ("-s 2 3 1 t.png -clamp on", (2.0, 3.0), Wrap::Clamp),
        ("-S 2 3 -CLAMP ON t.png", (2.0, 3.0), Wrap::Clamp),
        ("-clamp t.png", (1.0, 1.0), Wrap::Clamp),
        ("-clamp off t.png", (1.0, 1.0), Wrap::Repeat),
        ("-bm t.png", (1.0, 1.0), Wrap::Repeat),
        ("-s 1 1 1 2 a t.png", (1.0, 1.0), Wrap::Repeat),
        ("-mm 0 1 -o 0 0 0 2 a t.png -bm 1", (1.0, 1.0), Wrap::Repeat),
    ] {
        let scene = load(&folder, &format!("map_Kd {statement}"));
        let texture = scene.materials[0].base_color_texture.unwrap();
        let matrix = texture.transform.matrix2;
        assert_eq!((matrix.x_axis.x, matrix.y_axis.y), scale, "{statement}");
        assert_eq!(texture.wrap, [wrap; 2], "{statement}");
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
}

#[test]
fn opacity_is_alpha() {
    let folder = folder();
    let contradiction = "Tr is ignored where it contradicts d: material \"a\"";
    let unseen = "materials of opacity 0 (d 0 or Tr 1) cannot be seen: material \"a\"";
    for (statements, alpha, notices) in [
        ("d 0.25", 0.25, &[][..]),
        ("Tr 0.25", 0.75, &[]),
        ("d 0.25\nTr 0.75", 0.25, &[]),
        ("Tr 0.75\nd 0.25", 0.25, &[]),
        ("d 1\nTr 0", 1.0, &[]),
        ("d 1", 1.0, &[]),
        ("Tr 0", 1.0, &[]),
        ("d 1\nTr 1", 1.0, &[contradiction]),
        ("Tr 1\nd 1.0", 1.0, &[contradiction]),
        ("d 0.5\nTr 0", 0.5, &[contradiction]),
        ("Tr 1", 0.0, &[unseen]),
        ("d 0", 0.0, &[unseen]),
        (
            "d 1.5",
            1.0,
            &["values outside [0, 1] are clamped: d in line 2 of \"m.mtl\""],
        ),
        (
            "d -halo 0.5",
            0.5,
            &["the option -halo of d is ignored: line 2 of \"m.mtl\""],
        ),
    ] {
        let scene = load(&folder, statements);
        let material = &scene.materials[0];
        let mode = if alpha < 1.0 {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        };
        assert_eq!(
            (material.alpha, material.alpha_mode),
            (alpha, mode),
            "{statements}"
        );
        assert_eq!(scene.notices, notices, "{statements}");
    }
}

#[test]
fn opacity_may_be_a_texture() {
    let folder = folder();
    // Its alpha where it has one, otherwise its grey.
    for (map, texels) in [
        ("holes.png", [[255; 4], [255, 255, 255, 0]]),
        ("grey.png", [[255, 255, 255, 51], [255; 4]]),
    ] {
        let scene = load(&folder, &format!("Kd 0.5\nmap_d {map}"));
        let material = &scene.materials[0];
        assert_eq!(*base_image(&scene).texels, texels);
        assert_eq!(
            (material.alpha_mode, material.alpha),
            (AlphaMode::Blend, 1.0)
        );
        assert_eq!(material.base_color, Vec3::splat(0.5));
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
    // Beside colours, whose size counts.
    let scene = load(&folder, "d 0.5\nmap_Kd wide.png\nmap_d grey.png");
    assert_eq!(
        *base_image(&scene).texels,
        [[0, 255, 0, 51], [255, 0, 0, 255]]
    );
    assert_eq!(scene.materials[0].alpha, 0.5);
    let scene = load(&folder, "map_Kd t.png\nmap_d grey.png");
    assert_eq!(*base_image(&scene).texels, [[0, 255, 0, 153]]);
    // The same image for both: its alpha, if it has one.
    let scene = load(&folder, "map_Kd holes.png\nmap_d holes.png");
    assert_eq!(*base_image(&scene).texels, [GREEN, [9, 9, 9, 0]]);
    for (statements, notice) in [
        (
            "map_Kd wide.png\nmap_d wide.png",
            "map_d is left out where it is the image of map_Kd and has no alpha: material \"a\"",
        ),
        (
            "map_Kd wide.png\nmap_d -s 2 2 grey.png",
            "map_d is left out where its scale, offset or clamp differs from map_Kd: material \"a\"",
        ),
    ] {
        let scene = load(&folder, statements);
        assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Opaque);
        assert_eq!(*base_image(&scene).texels, [GREEN, [255, 0, 0, 255]]);
        assert_eq!(scene.notices, [notice]);
    }
    // Without a permission a lost image is an error, with it the material is opaque.
    let line = folder.refuse("scene.obj", text(&folder, "map_d lost.png"));
    assert!(
        line.contains("\"lost.png\"") && line.contains("--allow-missing"),
        "{line}"
    );
    let scene = load_without_files(&folder, "map_d lost.png");
    assert_eq!(scene.materials[0], Material::lambert("a", Vec3::splat(0.8)));
}

#[test]
fn normal_maps_are_used_and_height_maps_are_not() {
    let folder = folder();
    for statement in [
        "norm -bm 0.5 normals.png",
        "map_Bump -bm 0.5 normals.png",
        "bump normals.png -bm 0.5",
    ] {
        let scene = load(&folder, statement);
        let material = &scene.materials[0];
        let image = material.normal_texture.unwrap().image as usize;
        assert_eq!(*scene.images[image].texels, NORMALS, "{statement}");
        assert_eq!(material.normal_scale, 0.5, "{statement}");
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    }
    write_image(&folder, "colours.png", 2, &[GREEN, [10, 20, 90, 255]]);
    std::fs::write(folder.path("heights.tga"), "no image").unwrap();
    for (statements, notice) in [
        (
            "map_Bump grey.png",
            "height maps (map_Bump) are left out: material \"a\"",
        ),
        (
            "bump colours.png",
            "height maps (map_Bump) are left out: material \"a\"",
        ),
        (
            "map_bump lost.png",
            "textures of map_Bump that cannot be read are left out: \"lost.png\" (texture in line 2 of its MTL file)",
        ),
        (
            "map_bump ../lost.png",
            "textures of map_Bump that cannot be read are left out: \"../lost.png\" (texture in line 2 of its MTL file)",
        ),
        (
            "map_bump heights.tga",
            "images that cannot be read are left out: texture in line 2 of its MTL file (\"heights.tga\"): \
             is not PNG, JPEG, WebP or KTX2; convert it to one of them",
        ),
    ] {
        let scene = load(&folder, statements);
        assert_eq!(scene.materials, [Material::lambert("a", Vec3::splat(0.8))]);
        assert!(scene.images.is_empty());
        assert_eq!(scene.notices, [notice]);
    }
    let scene = load(&folder, "norm normals.png\nmap_Bump grey.png");
    assert!(scene.materials[0].normal_texture.is_some());
    assert_eq!(scene.images.len(), 1);
    assert_eq!(
        scene.notices,
        ["map_Bump is left out beside norm: material \"a\""]
    );
}

#[test]
fn other_physical_properties_have_a_notice_each() {
    let folder = folder();
    let scene = load(
        &folder,
        "Pr 0.5\nPs 0\nPc 0\nPcr 0.03\naniso 0\nanisor 0\nNs 250\nKs 1 1 1\nNi 1.5\nillum 2",
    );
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let statements = "Ps 0.5\nPc 1\nPcr 0.3\naniso 0.1\nanisor 1\nmap_Ps t.png\nmap_Ks t.png\nmap_Ns t.png\nPr 2\nPm -1";
    let scene = load(&folder, statements);
    let material = &scene.materials[0];
    assert_eq!(
        (material.roughness, material.metallic, material.specular),
        (1.0, 0.0, 1.0)
    );
    assert_eq!(
        scene.notices,
        [
            "sheen (Ps) is not supported, it is left out: line 2 of \"m.mtl\"",
            "clear coat (Pc) is not supported, it is left out: line 3 of \"m.mtl\"",
            "anisotropy (aniso) is not supported, it is left out: line 5 of \"m.mtl\"",
            "values outside [0, 1] are clamped: 2 times, first Pr in line 10 of \"m.mtl\"",
            "textures that are not supported are ignored: map_Ps, map_Ks, map_Ns",
        ]
    );
    let scene = load(
        &folder,
        "Ke -1 2 1e30\nKd spectral a.rfl 1\nKd xyz 0.1 0.2 0.3",
    );
    let mut expected = Material::lambert("a", Vec3::splat(0.8));
    expected.emission = Vec3::new(0.0, 2.0, 1e12);
    assert_eq!(scene.materials, [expected]);
    assert_eq!(
        scene.notices,
        [
            "emission outside [0, 1e12] is clamped: line 2 of \"m.mtl\"",
            "colours by spectrum or XYZ are ignored: 2 times, first line 3 of \"m.mtl\"",
        ]
    );
}

#[test]
fn statements_with_wrong_numbers_are_ignored() {
    for (statement, fault) in [
        ("Kd 1 2", "\"Kd\": three numbers are needed"),
        ("Kd", "\"Kd\": three numbers are needed"),
        ("Kd x y z", "\"Kd\": \"x\" is not a finite number"),
        ("Ke nan", "\"Ke\": \"nan\" is not a finite number"),
        ("Pm", "\"Pm\": a number is needed"),
        ("Pr 1e99", "\"Pr\": \"1e99\" is not a finite number"),
        ("d x", "\"d\": \"x\" is not a finite number"),
    ] {
        let scene = load(&folder(), statement);
        let expected = Material::lambert("a", Vec3::splat(0.8));
        assert_eq!(scene.materials, [expected], "{statement}");
        let what = "statements of MTL files with wrong numbers are ignored";
        assert_eq!(
            scene.notices,
            [format!("{what}: \"m.mtl\", line 2, {fault}")]
        );
    }
}

#[test]
fn roughness_and_metalness_may_differ_in_size() {
    let folder = folder();
    let scene = load(&folder, "map_Pr grey.png\nmap_Pm t.png");
    let texture = scene.materials[0].metallic_roughness_texture.unwrap();
    let texels = &scene.images[texture.image as usize].texels;
    assert_eq!(**texels, [[255, 51, 0, 255], [255, 255, 0, 255]]);
    let scene = load(&folder, "map_Pr grey.png\nmap_Pm -s 2 2 grey.png");
    let texture = scene.materials[0].metallic_roughness_texture.unwrap();
    let texels = &scene.images[texture.image as usize].texels;
    assert_eq!(**texels, [[255, 51, 255, 255], [255, 255, 255, 255]]);
    assert_eq!(
        scene.notices,
        ["map_Pm is left out where its scale, offset or clamp differs from map_Pr: material \"a\""]
    );
}

#[test]
fn a_lost_image_of_emission_emits_nothing() {
    let folder = folder();
    for lost in ["lost.png", "../t.png"] {
        for factor in ["", "Ke 0 0 0\n", "Ke 3 3 3\n"] {
            let mtl = format!("Kd 0 0 0\n{factor}map_Ke {lost}");
            folder.refuse("scene.obj", text(&folder, &mtl));
            let scene = load_without_files(&folder, &mtl);
            assert_eq!(scene.materials, [Material::lambert("a", Vec3::ZERO)]);
            let [.., missing, black] = &scene.notices[..] else {
                panic!("{:?}", scene.notices)
            };
            assert!(missing.starts_with("image files are missing"), "{missing}");
            let expected = "materials without their image of emission emit nothing: material \"a\"";
            assert_eq!(black, expected);
        }
    }
}

#[test]
fn a_damaged_image_may_be_left_out() {
    let folder = folder();
    std::fs::write(folder.path("damaged.png"), "no image").unwrap();
    let mtl = "map_Bump damaged.png\nmap_Kd damaged.png\nmap_Ke damaged.png\nmap_Pr grey.png";
    let line = folder.refuse("scene.obj", text(&folder, mtl));
    assert!(line.contains("\"damaged.png\""), "{line}");
    let scene = load_without_files(&folder, mtl);
    let material = &scene.materials[0];
    assert_eq!(
        (material.base_color, material.emission),
        (Vec3::ONE, Vec3::ZERO)
    );
    assert!(material.base_color_texture.is_none() && material.emissive_texture.is_none());
    assert!(material.metallic_roughness_texture.is_some() && scene.images.len() == 1);
    let notices = [
        "images that cannot be read",
        "materials without their image of emission",
    ];
    for (notice, start) in scene.notices.iter().zip(notices) {
        assert!(notice.starts_with(start), "{notice}");
    }
    assert_eq!(scene.notices.len(), 2, "{:?}", scene.notices);
}

/// A folder in place of the image.
#[test]
fn an_image_that_cannot_be_opened_may_be_left_out() {
    let folder = folder();
    std::fs::create_dir(folder.path("images")).unwrap();
    let line = folder.refuse("scene.obj", text(&folder, "map_Kd images"));
    assert!(line.contains("it is a folder"), "{line}");
    let scene = load_without_files(&folder, "map_Kd images\nmap_d images");
    assert_eq!(scene.materials, [Material::lambert("a", Vec3::ONE)]);
    let [notice] = &scene.notices[..] else {
        panic!("{:?}", scene.notices)
    };
    assert!(
        notice.starts_with("images that cannot be read are left out: texture in line 2"),
        "{notice}"
    );
}

#[test]
fn an_mtl_file_outside_may_be_left_out() {
    let folder = folder();
    let text = format!("mtllib ../m.mtl\n{SQUARE}usemtl a\nf 1 2 3\n");
    folder.refuse("scene.obj", &text);
    let options = Options {
        allow_missing: true,
        ..Options::default()
    };
    let path = folder.path("scene.obj");
    let scene = load_watched(&path, options, &mut |_, _, _| Ok(())).unwrap();
    assert_eq!(scene.materials, [Material::lambert("", Vec3::splat(0.8))]);
    let left_out = "MTL files that cannot be read are left out: line 1: \"../m.mtl\"";
    assert_eq!(scene.notices[0], left_out);
}
