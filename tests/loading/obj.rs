//! Tests of valid OBJ files.

use crate::files::Folder;
use glam::{DVec3, Vec2, Vec3};
use headwater::scene::texture::Wrap;
use headwater::scene::{Material, Scene, Texture};

/// OBJ lines with the four corners of a unit square in the plane z = 0.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(text: &str) -> Scene {
    Folder::new().load("scene.obj", format!("{SQUARE}{text}"))
}

#[test]
fn polygons_and_negative_indices() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1// 2/ 3/1 4/1/"] {
        let scene = load(face);
        assert_eq!(scene.triangle_count(), 2, "{face}");
        assert_eq!(scene.meshes[0].positions.len(), 4);
        assert!(scene.meshes[0].normals.is_empty());
        assert_eq!(scene.materials, [Material::lambert("", Vec3::splat(0.8))]);
        assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
        assert!(scene.notices[0].contains("grey"));
    }
}

/// At coordinates of 10⁷ a step of f32 is one unit, so a unit square would be lost without an offset.
#[test]
fn vertices_far_from_the_origin_keep_their_distances() {
    for far in [0.0, 1e5, 1e7, 1e12] {
        let text = format!(
            "v {far}.125 0 0\nv {far}.25 0 0\nv {far}.25 1e-1 0\nv {far}.125 1e-1 0\nf 1 2 3 4"
        );
        let scene = Folder::new().load("scene.obj", text);
        let bounds = scene.bounds().unwrap();
        let expected = DVec3::new(far + 0.125, 0.0, 0.0);
        assert!(
            (bounds.min - expected).abs().max_element() < 1e-8 + 2e-16 * far,
            "{far}: {bounds:?}"
        );
        let size = bounds.size() - DVec3::new(0.125, 0.1, 0.0);
        assert!(
            size.abs().max_element() < 1e-8 + 2e-16 * far,
            "{far}: {bounds:?}"
        );
        assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
    }
    // One mesh has one origin, so what is far away on both sides of it is held coarsely.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 1e6 0 0\nv 1000001 0 0\nv 1e6 1 0\nf 4 5 6";
    let scene = Folder::new().load("scene.obj", text);
    let coarse = |notice: &String| notice.contains("coarsely");
    assert!(scene.notices.iter().any(coarse), "{:?}", scene.notices);
    // An object of its own has an origin of its own.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no far\nv 1e7 0 0\nv 10000000.1 0 0\nv 1e7 1 0\nf 4 5 6";
    let scene = Folder::new().load("scene.obj", text);
    assert_eq!(scene.notices.len(), 1, "{:?}", scene.notices);
    let corner = scene.meshes[1].positions[1].as_dvec3();
    let transform = scene.instances[1].object_to_world;
    let corner = transform.transform_point3(corner);
    assert!((corner.x - 10_000_000.1).abs() < 1e-6, "{corner}");
    // Where all vertices come first, they have one.
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e7 0 0\nv 10000001 0 0\nv 1e7 1 0\nf 1 2 3\no far\nf 4 5 6";
    let scene = Folder::new().load("scene.obj", text);
    let notice = "meshes are so far from their origin";
    let found = scene.notices.iter().any(|line| line.starts_with(notice));
    assert!(found, "{:?}", scene.notices);
}

#[test]
fn scenes_that_are_too_small_are_refused() {
    for size in ["1e-13", "1e-20", "1e-30"] {
        let text = format!("v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nf 1 2 3");
        let line = Folder::new().refuse("scene.obj", text);
        assert!(line.contains("scale it up"), "{line}");
    }
    for size in ["1e20", "1e30"] {
        let text = format!("v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nf 1 2 3");
        let line = Folder::new().refuse("scene.obj", text);
        assert!(line.contains("scale the"), "{line}");
    }
    let scene = Folder::new().load("scene.obj", "v 0 0 0\nv 2e-12 0 0\nv 0 2e-12 0\nf 1 2 3");
    assert_eq!(scene.triangle_count(), 1);
}

#[test]
fn names_of_mtl_files_may_have_spaces() {
    let folder = Folder::new();
    folder.write("my lib.mtl", "newmtl red\nKd 1 0 0\n");
    folder.write("b.mtl", "newmtl blue\nKd 0 0 1\n");
    let text = format!("mtllib my lib.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let scene = folder.load("scene.obj", text);
    assert_eq!(scene.materials[0].name, "red");
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    // Several names are tried once all together, then each alone, however long the line is.
    let names = "lost.mtl ".repeat(1000) + "b.mtl";
    let text = format!("mtllib {names}\n{SQUARE}usemtl blue\nf 1 2 3\n");
    let scene = folder.load("scene.obj", text);
    assert_eq!(scene.materials[0].name, "blue");
    let lost = "MTL files that cannot be read are left out: line 1: \"lost.mtl\"";
    assert_eq!(scene.notices, [lost]);
    let text = folder.refuse(
        "scene.obj",
        format!("mtllib ../my lib.mtl\n{SQUARE}f 1 2 3\n"),
    );
    assert!(text.contains("\"../my lib.mtl\""), "{text}");
}

#[test]
fn objects_become_meshes_and_materials_parts() {
    let folder = Folder::new();
    folder.write(
        "a b.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl lamp light\nKd 0.5\nKe 3 2 1\n",
    );
    let scene = folder.load(
        "scene.obj",
        format!(
            "mtllib a b.mtl\n{SQUARE}o first\nusemtl red\nf 1 2 3\nusemtl lamp light\nf 1 3 4\n\
             usemtl red\nf 2 3 4\ng second\nf 1 2 4\no none\n"
        ),
    );
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["first", "second"]);
    let parts: Vec<(u32, u32, u32)> = scene.meshes[0]
        .parts
        .iter()
        .map(|part| (part.first_triangle, part.triangle_count, part.material))
        .collect();
    assert_eq!(parts, [(0, 2, 0), (2, 1, 1)]);
    assert_eq!(scene.meshes[1].parts[0].material, 0);
    let mut emitter = Material::lambert("lamp light", Vec3::splat(0.5));
    emitter.emission = Vec3::new(3.0, 2.0, 1.0);
    assert_eq!(
        scene.materials,
        [Material::lambert("red", Vec3::X), emitter]
    );
    assert_eq!(scene.emissive_triangle_count(), 1);
}

#[test]
fn physical_materials_have_a_specular_lobe() {
    let folder = Folder::new();
    folder.write(
        "m.mtl",
        "newmtl a\nPr 0.25\nnewmtl b\nPm 1\nPr 0.5\nmap_Ks x.png\n",
    );
    let text = format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n");
    let scene = folder.load("scene.obj", text);
    let found: Vec<(f32, f32, f32)> = scene
        .materials
        .iter()
        .map(|m| (m.specular, m.metallic, m.roughness))
        .collect();
    assert_eq!(found, [(1.0, 0.0, 0.25), (1.0, 1.0, 0.5)]);
    assert_eq!(
        scene.notices,
        ["textures that are not supported are ignored: map_Ks"]
    );
}

#[test]
fn normals_where_they_are_and_flat_where_not() {
    let scene = load("v 0 0 1\nvn 0 0 2\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1 3 4\nf 1//2 4//2 5//2\n");
    let mesh = &scene.meshes[0];
    let of = |t: usize| mesh.triangles[t].map(|i| mesh.normals[i as usize]);
    assert_eq!(of(0), [Vec3::Z; 3]);
    assert_eq!(of(1), [Vec3::Z; 3]);
    assert_eq!(of(2), [Vec3::X; 3]);
}

#[test]
fn wrong_normals_are_those_of_the_faces() {
    for normal in ["nan nan nan", "0 1", "", "-1.#IND 0 1", "1e99 0 0"] {
        let scene = load(&format!("vn {normal}\nvn 0 .6 .8\nf 1//1 2//2 3//1\n"));
        let tilted = Vec3::new(0.0, 0.6, 0.8);
        assert_eq!(scene.meshes[0].normals, [Vec3::Z, tilted, Vec3::Z]);
        let notice =
            "vertices without a usable normal take the geometric one: 2 times, first mesh 0";
        assert!(
            scene.notices.iter().any(|line| line == notice),
            "{:?}",
            scene.notices
        );
    }
}

#[test]
fn normals_of_some_corners_stay_with_them() {
    // Faces without normals come first, so that normals counted by corners would be misplaced.
    let scene = load("vn 0 .6 .8\nf 1 2 3\nf 1//1 3//1 4//1\nf 1//1 2 4//1\n");
    let mesh = &scene.meshes[0];
    let of = |t: usize| mesh.triangles[t].map(|i| mesh.normals[i as usize]);
    let tilted = Vec3::new(0.0, 0.6, 0.8);
    assert_eq!(of(0), [Vec3::Z; 3]);
    assert_eq!(of(1), [tilted; 3]);
    assert_eq!(of(2), [tilted, Vec3::Z, tilted]);
    let corners = mesh.triangles[2].map(|i| mesh.positions[i as usize]);
    assert_eq!(corners, [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn latin_1_is_read_where_a_line_is_no_utf_8() {
    let folder = Folder::new();
    // Two names that differ only in such a letter, in files of different encodings.
    folder.write(
        "türen.mtl",
        b"# caf\xe9\nnewmtl gr\xfcn\nKd 0 1 0\nnewmtl gr\xf6n\nKd 0 0 1\n",
    );
    let text = [
        SQUARE.as_bytes(),
        b"# \xe9\xa0\nmtllib t\xfcren.mtl\no T\xfcr \xb5\nusemtl gr\xfcn\nf 1 2 3\n",
        "usemtl grön\nf 1 3 4\n".as_bytes(),
    ];
    let scene = folder.load("scene.obj", text.concat());
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_eq!(scene.meshes[0].name, "Tür µ");
    let expected = [("grün", Vec3::Y), ("grön", Vec3::Z)];
    assert_eq!(
        scene.materials,
        expected.map(|(name, colour)| Material::lambert(name, colour))
    );
    let parts = scene.meshes[0].parts.iter();
    assert_eq!(parts.map(|p| p.material).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn a_backslash_continues_a_line() {
    for end in ["\\\n", "\\\r\n", "\\ \n\t"] {
        let folder = Folder::new();
        let library = "newmtl red\nKd 1 >0 >.5\nKe >3 2 1\n";
        folder.write("m.mtl", library.replace('>', end));
        let text =
            "mtllib >m.mtl\nv 0 >0 0\nv 1 0 >>0\nv 1 1 0\nv 0 1 0\nusemtl >red\nf 1 2 >3 4\n";
        let scene = folder.load("scene.obj", text.replace('>', end));
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        let mesh = &scene.meshes[0];
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert_eq!(mesh.positions, square);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let mut red = Material::lambert("red", Vec3::new(1.0, 0.0, 0.5));
        red.emission = Vec3::new(3.0, 2.0, 1.0);
        assert_eq!(scene.materials, [red]);
    }
}

#[test]
fn missing_materials_are_grey_with_a_warning() {
    let scene = load("mtllib lost.mtl\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n");
    assert_eq!(
        scene.notices,
        [
            "MTL files that cannot be read are left out: line 5: \"lost.mtl\"",
            "materials that are in no MTL file are grey (0.8): 2 times, first line 6: \"red\"",
            "faces without a material are given one: grey Lambert (0.8)",
        ]
    );
    assert_eq!(scene.meshes[0].parts.len(), 1);
}

#[test]
fn degenerate_faces_points_and_lines_are_left_out() {
    let scene = load("f 1 1 2\nf 1 2 3\nl 1 2\np 1\nl 2 3\nf 1 2\nf 1\nf\n");
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(
        scene.notices[..2],
        [
            "points and lines are skipped: 3 times, first line 7",
            "faces of fewer than three corners are skipped: 3 times, first line 10"
        ]
    );
    assert_eq!(
        scene.notices[3],
        "triangles without area are removed: mesh 0"
    );
}

#[test]
fn an_empty_file_is_an_empty_scene() {
    for text in ["", "# nothing\n", SQUARE] {
        let scene = Folder::new().load("scene.obj", text);
        assert!(scene.meshes.is_empty());
        assert_eq!(scene.notices.len(), 1);
    }
}

/// A folder with three images: white and black, red and blue (two texels each), and one of a single texel.
fn with_images() -> Folder {
    let folder = Folder::new();
    for (name, texels) in [
        ("grey.png", vec![[255, 255, 255, 255], [0, 0, 0, 255]]),
        (
            "dark map.png",
            vec![[102, 102, 102, 255], [51, 51, 51, 255]],
        ),
        ("one.png", vec![[9, 9, 9, 255]]),
    ] {
        let bytes: Vec<u8> = texels.concat();
        let image = image::RgbaImage::from_raw(texels.len() as u32, 1, bytes).unwrap();
        image.save(folder.path(name)).unwrap();
    }
    folder
}

const TEXTURED: &str = "vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\nf 1/1 3/3 4\n";

fn textured(folder: &Folder, mtl: &str) -> Scene {
    folder.write("m.mtl", mtl);
    folder.load("scene.obj", format!("mtllib m.mtl\n{SQUARE}{TEXTURED}"))
}

#[test]
fn textures_are_laid_as_their_options_say() {
    let folder = with_images();
    let scene = textured(
        &folder,
        "newmtl a\nmap_Kd -s 2 4 1 -o 0.5 0.25 -clamp on -mm 0 1 dark map.png\n",
    );
    let texture = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Clamp; 2]);
    let uvs = &scene.meshes[0].uvs[0];
    // From the top left, where OBJ counts from the bottom left.
    assert_eq!(uvs[..3], [Vec2::Y, Vec2::ONE, Vec2::X]);
    for uv in [Vec2::new(0.0, 0.0), Vec2::new(0.25, 1.0)] {
        let in_image = uv * Vec2::new(2.0, 4.0) + Vec2::new(0.5, 0.25);
        let found = texture
            .transform
            .transform_point2(Vec2::new(uv.x, 1.0 - uv.y));
        assert_eq!(found, Vec2::new(in_image.x, 1.0 - in_image.y));
    }
    assert_eq!(scene.images[0].texels[0], [102, 102, 102, 255]);
    assert_eq!(
        scene.notices,
        ["texture coordinates are missing, 0 is used: line 11"]
    );
}

#[test]
fn roughness_and_metalness_are_put_together() {
    let folder = with_images();
    folder.write(
        "m.mtl",
        "newmtl a\nPm 0.5\nmap_Pr grey.png\nmap_Pm dark map.png\nmap_Kd grey.png\nnewmtl b\nmap_Pr grey.png\n",
    );
    let scene = folder.load(
        "scene.obj",
        format!("mtllib m.mtl\n{SQUARE}{TEXTURED}usemtl b\nf 1/1 2/2 3/3\n"),
    );
    let [a, b] = &scene.materials[..] else {
        panic!("two materials")
    };
    let image = |texture: &Option<Texture>| &scene.images[texture.unwrap().image as usize];
    let texels = &image(&a.metallic_roughness_texture).texels;
    assert_eq!(**texels, [[255, 255, 102, 255], [255, 0, 51, 255]]);
    let texels = &image(&b.metallic_roughness_texture).texels;
    assert_eq!(**texels, [[255, 255, 255, 255], [255, 0, 255, 255]]);
    assert_eq!(image(&a.base_color_texture).texels[1], [0, 0, 0, 255]);
    assert_eq!((a.specular, a.metallic, b.metallic), (1.0, 0.5, 0.0));
    // A map stands for a factor that is not stated.
    assert_eq!(a.base_color, Vec3::ONE);
    assert_eq!(scene.images.len(), 3);
}

#[test]
fn textures_that_are_wrong_are_one_line() {
    for (mtl, parts) in [
        (
            "map_Kd none.png",
            &["line 2", "\"none.png\"", "--allow-missing"][..],
        ),
        ("map_Kd ../one.png", &["outside of the scene's folder"]),
    ] {
        let folder = with_images();
        folder.write("m.mtl", format!("newmtl a\n{mtl}\n"));
        let text = folder.refuse("scene.obj", format!("mtllib m.mtl\n{SQUARE}{TEXTURED}"));
        for part in parts {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
    // Coordinates count only where a texture uses them.
    let folder = with_images();
    folder.write("m.mtl", "newmtl a\nmap_Kd one.png\n");
    let broken = format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1/7 2/8 3/9\n");
    let text = folder.refuse("scene.obj", broken);
    assert!(
        text.contains("texture coordinate 7 is out of range"),
        "{text}"
    );
    assert!(load("f 1/7 2/8 3/9\n").meshes[0].uvs[0].is_empty());
    assert!(load("vt nan inf\nf 1/1 2/1 3/1\n").meshes[0].uvs[0].is_empty());
    let broken = format!("mtllib m.mtl\n{SQUARE}vt 0 nan\nusemtl a\nf 1/1 2/1 3/1\n");
    let scene = folder.load("scene.obj", broken);
    assert_eq!(scene.meshes[0].uvs[0], [glam::Vec2::ZERO; 3]);
    let notice = "texture coordinates are not finite, 0 is used: 3 times, first line 8";
    assert_eq!(scene.notices, [notice]);
}

#[test]
fn images_are_looked_for_beside_the_mtl_file_first() {
    let folder = with_images();
    std::fs::create_dir_all(folder.path("materials/own")).unwrap();
    let move_to = |name: &str| std::fs::rename(folder.path("grey.png"), folder.path(name)).unwrap();
    let names = |map: &str| {
        folder.write("materials/m.mtl", format!("newmtl a\nmap_Kd {map}\n"));
        let scene = folder.load(
            "scene.obj",
            format!("mtllib materials/m.mtl\n{SQUARE}{TEXTURED}"),
        );
        scene.images[0].texels.len()
    };
    move_to("materials/own/a.png");
    assert_eq!(names("own/a.png"), 2);
    assert_eq!(names("materials/own/a.png"), 2);
    // Where both have one, that of the MTL file's folder is taken.
    std::fs::copy(
        folder.path("materials/own/a.png"),
        folder.path("materials/one.png"),
    )
    .unwrap();
    assert_eq!(names("one.png"), 2);
    assert_eq!(names("../one.png"), 1);
    folder.write("materials/m.mtl", "newmtl a\nmap_Kd ../../one.png\n");
    let text = folder.refuse(
        "scene.obj",
        format!("mtllib materials/m.mtl\n{SQUARE}{TEXTURED}"),
    );
    assert!(text.contains("outside of the scene's folder"), "{text}");
}

#[test]
fn options_of_textures_that_are_not_followed_are_told() {
    let folder = with_images();
    let ignored = |line: &str| {
        let scene = textured(&folder, &format!("newmtl a\n{line} one.png\n"));
        let notices = scene.notices.iter();
        let notices = notices.filter(|notice| notice.contains("option"));
        notices.cloned().collect::<Vec<String>>()
    };
    for option in [
        "-mm 0.5 1",
        "-mm 0 2",
        "-bm 0.5",
        "-boost 2",
        "-texres 512",
        "-t 1 0 0",
        "-blendu off",
        "-blendv off",
        "-cc on",
        "-imfchan g",
        "-type sphere",
    ] {
        let name = option.split(' ').next().unwrap();
        let expected = format!("the option {name} of textures is ignored: line 2 of \"m.mtl\"");
        assert_eq!(ignored(&format!("map_Kd {option}")), [expected]);
    }
    for line in [
        "map_Kd -mm 0 1 -bm 1 -boost 0 -t 0 0 0 -blendu on -blendv on -cc off",
        "map_Kd -s 2 2 -o 1 1 -clamp on",
        "map_Pr -imfchan r",
    ] {
        assert!(ignored(line).is_empty(), "{line}");
    }
    let twice = ignored("map_Ke -bm 2 one.png\nmap_Kd -bm 3");
    assert_eq!(
        twice,
        ["the option -bm of textures is ignored: 2 times, first line 2 of \"m.mtl\""]
    );
}

#[test]
fn images_that_no_face_shows_need_not_exist() {
    let folder = with_images();
    let scene = textured(
        &folder,
        "newmtl a\nmap_Kd one.png\nnewmtl b\nmap_Kd lost.png\n",
    );
    assert_eq!(scene.images.len(), 1);
    assert!(scene.materials[1].base_color_texture.is_none());
}

#[test]
fn emission_may_be_a_texture() {
    let folder = with_images();
    for (factor, expected) in [("", 1.0), ("Ke 3 3 3\n", 3.0)] {
        let scene = textured(&folder, &format!("newmtl a\n{factor}map_Ke dark map.png\n"));
        let material = &scene.materials[0];
        assert_eq!(material.emission, Vec3::splat(expected));
        assert!(material.emissive_texture.is_some() && material.base_color_texture.is_none());
        assert_eq!(scene.emissive_triangle_count(), 2);
    }
}
