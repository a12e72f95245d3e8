//! Tests of environments from files, valid and broken ones.

use crate::support::random::Random;
use glam::Vec3;
use headwater::Result;
use headwater::image::Image;
use headwater::scene::{Environment, Scene};
use std::path::Path;

/// Writes an EXR environment of 8 × 4 texels of the colour (1, 2, 3); one texel has `texel` as its green value.
fn write_exr(path: &Path, texel: f32) {
    let mut picture = Image::new(8, 4);
    let mut texels = [[1.0, 2.0, 3.0]; 32];
    texels[13][1] = texel;
    picture.set_vectors("", ["R", "G", "B"], &texels);
    picture.write(path, 0.0).unwrap();
}

/// An uncompressed HDR file of 8 × 4 texels of the radiance (1, 0.5, 0.25).
fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    bytes.extend([128, 64, 32, 129].repeat(32));
    bytes
}

fn open(path: &Path) -> Result<Environment> {
    Environment::open(path.to_str().unwrap(), &mut Vec::new())
}

#[test]
fn environments_are_read_from_exr_and_hdr() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&path, 7.0);
    let environment = open(&path).unwrap();
    assert_eq!((environment.width, environment.height), (8, 4));
    assert_eq!(environment.texels[13], Vec3::new(1.0, 7.0, 3.0));
    let path = folder.path().join("sky.HDR");
    std::fs::write(&path, hdr()).unwrap();
    let environment = open(&path).unwrap();
    assert_eq!(*environment.texels, [Vec3::new(1.0, 0.5, 0.25); 32]);
}

/// Opens an environment that must be refused, and returns the message; it must be one line that names the file.
fn refuse(name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let error = open(&path).expect_err(name);
    let line = error.to_string();
    assert!(error.exit_status() == 2 && line.contains(name), "{line}");
    assert_eq!(line.lines().count(), 1, "{line}");
    line
}

/// Bad texels are replaced, and one notice states their number and the first of them.
#[test]
fn bad_texels_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let opened = |path: &Path| {
        let mut notices = Vec::new();
        let environment = Environment::open(path.to_str().unwrap(), &mut notices).unwrap();
        assert_eq!(notices.len(), 1, "{notices:?}");
        (environment, notices.remove(0))
    };
    for (texel, replaced) in [
        (f32::NAN, 0.0),
        (f32::INFINITY, 1e12),
        (-1.0, 0.0),
        (1e13, 1e12),
    ] {
        let path = folder.path().join("made.exr");
        write_exr(&path, texel);
        let (environment, notice) = opened(&path);
        assert_eq!(environment.texels[13], Vec3::new(1.0, replaced, 3.0));
        assert_eq!(environment.texels[12], Vec3::new(1.0, 2.0, 3.0));
        let counted = "made.exr: 1 of 32 texels have a radiance that is not within 0 and 1e12, the first at x = 5, y = 1";
        assert!(notice.contains(counted), "{notice}");
    }
    // The largest number that the format has.
    let mut bright = hdr();
    let length = bright.len();
    bright[length - 1] = 255;
    let path = folder.path().join("sky.hdr");
    std::fs::write(&path, bright).unwrap();
    let (environment, notice) = opened(&path);
    assert_eq!(environment.texels[31], Vec3::splat(1e12));
    assert!(
        notice.contains(" 1 of 32 ") && notice.contains("x = 7, y = 3"),
        "{notice}"
    );
}

#[test]
fn broken_environments_end_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.exr");
    let mut nothing = Image::new(2, 1);
    nothing.set_vectors("", ["R", "G", "B"], &[[f32::NAN; 3]; 2]);
    nothing.write(&path, 0.0).unwrap();
    let line = refuse("sky.exr", &std::fs::read(&path).unwrap());
    assert!(
        line.contains("no texel has a radiance within 0 and 1e12"),
        "{line}"
    );
    for (name, content) in [
        ("empty.hdr", &b""[..]),
        ("text.hdr", b"a text"),
        ("text.exr", b"a text"),
        ("empty.exr", b""),
    ] {
        refuse(name, content);
    }
    assert!(refuse("sky.jpg", b"").contains(".exr or .hdr"));
    let missing = Environment::open("/nowhere/sky.exr", &mut Vec::new())
        .unwrap_err()
        .to_string();
    assert!(missing.contains("/nowhere/sky.exr"), "{missing}");
}

#[test]
fn sizes_that_are_none_or_a_lie_are_refused() {
    for (size, said) in [
        ("-Y 0 +X 0", "sky.hdr"),
        ("-Y 4000000 +X 4000000", "4000000 × 4000000 texels"),
        ("-Y 16384 +X 16384", "16384 × 16384 texels, the most are"),
        ("-Y 4 +X 9", "sky.hdr"),
        ("-Y 8192 +X 8192", "sky.hdr"),
        ("-Y -4 +X 8", "sky.hdr"),
        ("4 8", "sky.hdr"),
    ] {
        let lying = [
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n",
            size.as_bytes(),
            b"\n",
            &[128, 64, 32, 129].repeat(32),
        ]
        .concat();
        let line = refuse("sky.hdr", &lying);
        assert!(line.contains(said), "{size}: {line}");
    }
}

/// Names and bytes of valid files: a compressed EXR file, an HDR file without compression, and one with compression.
fn whole() -> [(&'static str, Vec<u8>); 3] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&path, 7.0);
    let mut packed = Vec::new();
    let texels: Vec<image::Rgb<f32>> = (0..32 * 16)
        .map(|i| image::Rgb([(i / 7) as f32, 1.0, 0.5]))
        .collect();
    image::codecs::hdr::HdrEncoder::new(&mut packed)
        .encode(&texels, 32, 16)
        .unwrap();
    [
        ("sky.exr", std::fs::read(&path).unwrap()),
        ("plain.hdr", hdr()),
        ("packed.hdr", packed),
    ]
}

#[test]
fn environments_that_are_cut_off_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in whole() {
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).unwrap();
        open(&path).unwrap();
        for length in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
            refuse(name, &bytes[..length]);
        }
    }
}

#[test]
fn environments_with_wrong_bytes_never_panic() {
    let mut random = Random(5);
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in whole() {
        let path = folder.path().join(name);
        for _ in 0..300 {
            let mut bytes = bytes.clone();
            for _ in 0..=random.index(3) {
                let at = random.index(bytes.len());
                bytes[at] = random.index(256) as u8;
            }
            std::fs::write(&path, &bytes).unwrap();
            match open(&path) {
                Ok(environment) => assert!(environment.brightest().is_finite()),
                Err(error) => {
                    let line = error.to_string();
                    assert_eq!(
                        (error.exit_status(), line.lines().count()),
                        (2, 1),
                        "{line}"
                    );
                }
            }
        }
    }
}

#[test]
fn environments_may_be_small_long_or_black() {
    let folder = tempfile::tempdir().unwrap();
    for (width, height, radiance) in [(1, 1, 2.0), (3, 7, 2.0), (16384, 2, 2.0), (8, 4, 0.0)] {
        let path = folder.path().join("sky.exr");
        let mut picture = Image::new(width, height);
        let texels = vec![[radiance; 3]; (width * height) as usize];
        picture.set_vectors("", ["R", "G", "B"], &texels);
        picture.write(&path, 0.0).unwrap();
        let environment = open(&path).unwrap();
        assert_eq!((environment.width, environment.height), (width, height));
        assert_eq!(environment.brightest(), radiance);
        // A black one is no light: then the program says that the scene has none.
        let scene = Scene {
            environment: Some(environment),
            ..Scene::default()
        };
        assert_eq!(scene.why_black(true, [0.0]).is_none(), radiance > 0.0);
    }
}
