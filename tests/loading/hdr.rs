//! Tests of Radiance HDR files of other programs: their headers, orientations, colour spaces and compressions.

use glam::Vec3;
use headwater::Result;
use headwater::scene::Environment;

/// Opens an HDR file of these bytes, and returns the environment and the notices about it.
fn try_open(bytes: &[u8]) -> Result<(Environment, Vec<String>)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    std::fs::write(&path, bytes).unwrap();
    let mut notices = Vec::new();
    let environment = Environment::open(path.to_str().unwrap(), &mut notices)?;
    Ok((environment, notices))
}

/// The environment of a file with these lines before the texels, and without notices.
fn open(header: &str, texels: &[u8]) -> Environment {
    let (environment, notices) = try_open(&[header.as_bytes(), texels].concat()).expect(header);
    assert!(notices.is_empty(), "{notices:?}");
    environment
}

/// The message about a file that must be refused.
fn refuse(header: &str) -> String {
    let bytes = [header.as_bytes(), &[128, 64, 32, 129].repeat(6)].concat();
    let error = try_open(&bytes).expect_err(header);
    assert_eq!(error.exit_status(), 2);
    error.to_string()
}

/// A texel of the radiance (1, 0.5, 0.25).
const TEXEL: [u8; 4] = [128, 64, 32, 129];

#[test]
fn every_magic_and_every_order_of_lines_is_read() {
    for header in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n",
        "#?AUTOPANO\n# a comment\nFORMAT=32-bit_rle_rgbe\nSOFTWARE=x\n\n-Y 1 +X 2\n",
        "#?RADIANCE\nVIEW= -vta\n\tEXPOSURE=3\nPIXASPECT=2\n\n-Y 1 +X 2\n",
        "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 2\r\n",
        "#?RGBE\n\n-Y  1  +X  2 \n",
    ] {
        let environment = open(header, &TEXEL.repeat(2));
        assert_eq!((environment.width, environment.height), (2, 1));
        assert_eq!(
            *environment.texels,
            [Vec3::new(1.0, 0.5, 0.25); 2],
            "{header}"
        );
    }
}

#[test]
fn texels_are_divided_by_exposure_and_colour_correction() {
    for (lines, divisor) in [
        ("EXPOSURE=2\n", Vec3::splat(2.0)),
        ("EXPOSURE= 2.0e0\nEXPOSURE=0.25\n", Vec3::splat(0.5)),
        ("COLORCORR=1 2 4\n", Vec3::new(1.0, 2.0, 4.0)),
        (
            "COLORCORR= 1 2 4\nEXPOSURE=0.5\nCOLORCORR=2 2 2\n",
            Vec3::new(1.0, 2.0, 4.0),
        ),
    ] {
        let header = format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
        let environment = open(&header, &TEXEL);
        assert_eq!(
            environment.texels[0],
            Vec3::new(1.0, 0.5, 0.25) / divisor,
            "{lines}"
        );
    }
}

#[test]
fn numbers_that_cannot_divide_are_ignored_with_a_notice() {
    for line in [
        "EXPOSURE=bright",
        "EXPOSURE=0",
        "EXPOSURE=-1",
        "EXPOSURE=inf",
        "COLORCORR=1 2",
    ] {
        let bytes = [
            format!("#?RADIANCE\n{line}\n\n-Y 1 +X 1\n").as_bytes(),
            &TEXEL,
        ]
        .concat();
        let (environment, notices) = try_open(&bytes).unwrap();
        assert_eq!(environment.texels[0], Vec3::new(1.0, 0.5, 0.25));
        let expected = format!("the line {line:?} has no number above 0, so it is ignored");
        assert!(
            notices.len() == 1 && notices[0].ends_with(&expected),
            "{notices:?}"
        );
    }
}

/// Texels of the grey values 1 to 6, which stand in the picture as 1 2 3 above 4 5 6.
#[test]
fn all_eight_orientations_are_one_picture() {
    for (resolution, order) in [
        ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
        ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
        ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
        ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
        ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
        ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
        ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
    ] {
        // 16 · 2^(132 − 136) is 1.
        let texels = order.map(|value: u8| [16 * value, 16 * value, 16 * value, 132]);
        let header = format!("#?RADIANCE\n\n{resolution}\n");
        let environment = open(&header, texels.as_flattened());
        assert_eq!(
            (environment.width, environment.height),
            (3, 2),
            "{resolution}"
        );
        let found: Vec<f32> = environment.texels.iter().map(|texel| texel.x).collect();
        assert_eq!(found, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{resolution}");
    }
}

/// The white point D65 in XYZ, and the primaries of sRGB.
#[test]
fn xyz_becomes_linear_srgb() {
    for (xyz, rgb) in [
        ([0.9505, 1.0, 1.089], Vec3::ONE),
        ([0.4124, 0.2126, 0.0193], Vec3::X),
        ([0.3576, 0.7152, 0.1192], Vec3::Y),
        ([0.1805, 0.0722, 0.9505], Vec3::Z),
    ] {
        // In steps of 1/256, with an exponent of 1 or 2.
        let exponent = if xyz[2] > 1.0 || xyz[1] >= 1.0 { 1 } else { 0 };
        let scale = 256.0 / f64::powi(2.0, exponent);
        let bytes = xyz.map(|value: f64| (value * scale).round() as u8);
        let texel = [bytes[0], bytes[1], bytes[2], 128 + exponent as u8];
        let header = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
        let (environment, _) = try_open(&[header.as_bytes(), &texel].concat()).unwrap();
        let found = environment.texels[0];
        assert!((found - rgb).abs().max_element() < 0.02, "{xyz:?}: {found}");
    }
}

/// Two lines of eight texels, without compression and in both forms of run-length encoding.
#[test]
fn flat_old_and_new_lines_are_one_picture() {
    let flat = TEXEL.repeat(16);
    // 1, 1, 1 repeats the texel before; a second such texel counts 256 times as much.
    let old = [&TEXEL[..], &[1, 1, 1, 7]].concat().repeat(2);
    let runs = [128, 64, 32, 129].map(|byte| [128 + 5, byte, 3, byte, byte, byte]);
    let new = [&[2, 2, 0, 8][..], runs.as_flattened()].concat().repeat(2);
    for texels in [flat, old, new] {
        let environment = open("#?RADIANCE\n\n-Y 2 +X 8\n", &texels);
        assert_eq!(
            *environment.texels,
            [Vec3::new(1.0, 0.5, 0.25); 16],
            "{texels:?}"
        );
    }
    let long = [&TEXEL[..], &[1, 1, 1, 43, 1, 1, 1, 1]].concat();
    let environment = open("#?RADIANCE\n\n-Y 1 +X 300\n", &long);
    assert_eq!(*environment.texels, [Vec3::new(1.0, 0.5, 0.25); 300]);
}

#[test]
fn headers_that_are_no_hdr_are_named() {
    for (header, said) in [
        ("RADIANCE\n\n-Y 2 +X 3\n", "does not begin with #?"),
        (
            "#?RADIANCE\nFORMAT=16-bit\n\n-Y 2 +X 3\n",
            "its format is \"16-bit\", not 32-bit_rle_rgbe",
        ),
        (
            "#?RADIANCE\n\n-Y 2 +Y 3\n",
            "its line \"-Y 2 +Y 3\" is not a size",
        ),
        ("#?RADIANCE\n\n-Z 2 +X 3\n", "is not a size"),
        ("#?RADIANCE\n\n-Y 2 +X 3 4\n", "is not a size"),
        ("#?RADIANCE\n\n-Y two +X 3\n", "is not a size"),
        ("#?RADIANCE\n\n-Y 4294967295 +X 1\n", "is not a size"),
        ("#?RADIANCE\n\n-Y 2 +X 4\n", "sky.hdr: it is cut off"),
    ] {
        let text = refuse(header);
        assert!(text.contains(said), "{header}: {text}");
    }
}
