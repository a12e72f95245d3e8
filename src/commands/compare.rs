//! `compare`: prints the errors of a picture against a reference picture, and checks them against limits.

use super::arguments::check_files;
use super::{notice, print};
use crate::base::json::value_of;
use crate::image::{Format, Image, png};
use crate::metrics::error::{Errors, NoiseFloor};
use crate::metrics::flip::{PIXELS_PER_DEGREE, flip};
use crate::{Error, Result};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The command-line arguments of `headwater compare`, which name the two pictures, and limits for their
/// errors. A limit that is not given is not checked.
#[derive(clap::Args)]
pub struct Args {
    /// The picture to examine: .exr or .png
    picture: PathBuf,
    /// The reference picture, .exr or .png, of the same size as the picture
    reference: PathBuf,
    /// Print the errors as one JSON object instead of text; values that are not finite, such as a ratio to black, are null
    #[arg(long)]
    json: bool,
    /// Write the difference of the pictures to this file: a .png shows the FLIP error (perceived difference) of each
    /// pixel as a colour, from black (no error) over violet and orange to pale yellow (error 1); an .exr contains the
    /// picture minus the reference
    #[arg(long, value_name = "FILE.png|FILE.exr")]
    diff: Option<PathBuf>,
    /// Exposure of both pictures for FLIP, in stops: radiance is multiplied by 2 to this power
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "EV"
    )]
    exposure: f32,
    /// Fail if the root mean square error of the linear RGB values, in the unit of their radiance, is above this limit
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_rmse: Option<f64>,
    /// Fail if the relative mean square error, the mean of (a − b)² / (b² + 0.01) over the values a of the picture and
    /// b of the reference, is above this limit
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_relmse: Option<f64>,
    /// Fail if the mean FLIP error (perceived difference, from 0 to 1) of the pixels is above this limit
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_flip: Option<f64>,
    /// Fail if the mean of the picture's RGB values divided by the mean of the reference's RGB values differs from 1 by
    /// more than this limit
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_mean_deviation: Option<f64>,
    /// Fail unless both pictures have the same channels with the same bits; metadata may differ
    #[arg(long)]
    exact: bool,
}

/// Compares the two pictures of the arguments: prints the errors, writes the file of `--diff`, and checks the limits that
/// are given.
///
/// # Errors
/// An argument is wrong or the pictures cannot be compared (wrong input); the difference cannot be written, or an error
/// exceeds its limit (failed work).
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    let images = [&args.picture, &args.reference].map(|path| Image::read(path));
    let [image, reference_image] = images;
    let (image, reference_image) = (image?, reference_image?);
    let (size, picture) = finite_pixels(&args.picture, &image)?;
    let (reference_size, reference) = finite_pixels(&args.reference, &reference_image)?;
    if size != reference_size {
        return Err(Error::input(format!(
            "{} is {} × {}, {} is {} × {}; only pictures of one size compare",
            args.picture.display(),
            size.0,
            size.1,
            args.reference.display(),
            reference_size.0,
            reference_size.1
        )));
    }
    note_formats(&args.picture, &args.reference)?;
    note_shared_samples(&image, &reference_image);
    let errors = Errors::between(&picture, &reference);
    let perceived = flip(&picture, &reference, size, args.exposure);
    if let Some(path) = &args.diff {
        match Format::of(path)? {
            Format::Png => png::write_bytes(path, size, &perceived.map)?,
            Format::Exr => write_difference(path, size, &picture, &reference)?,
        }
    }
    let mut rows = vec![
        ("rmse", errors.rmse),
        ("rmse_clamped", errors.rmse_clamped),
        ("relmse", errors.relmse),
        ("flip", perceived.mean),
        ("mean_ratio", errors.mean_ratio),
    ];
    if let Some(floor) = noise_floor(&reference_image, &reference) {
        rows.extend([
            ("rmse_floor", floor.rmse),
            ("relmse_floor", floor.relmse),
            ("rmse_without_floor", floor.rmse_without(errors.rmse)),
            ("relmse_without_floor", floor.relmse_without(errors.relmse)),
        ]);
    }
    if args.json {
        let mut object: serde_json::Map<_, _> = rows
            .iter()
            .map(|(name, value)| ((*name).to_owned(), json!(value)))
            .collect();
        // What FLIP says holds for one display only.
        object.insert(
            "flip_exposure".into(),
            value_of("exposure", &args.exposure)?,
        );
        object.insert(
            "flip_pixels_per_degree".into(),
            value_of("display", &PIXELS_PER_DEGREE)?,
        );
        print(format_args!("{:#}", serde_json::Value::Object(object)))?;
    } else {
        let width = rows
            .iter()
            .map(|(name, _)| name.len())
            .max()
            .unwrap_or(0)
            .max(13);
        let lines = rows
            .iter()
            .map(|(name, value)| format!("{name:width$} {}", figures(*value)));
        print(lines.collect::<Vec<_>>().join("\n"))?;
    }
    let mut broken: Vec<String> = [
        ("rmse", errors.rmse, args.max_rmse),
        ("relmse", errors.relmse, args.max_relmse),
        ("flip", perceived.mean, args.max_flip),
        (
            "mean deviation",
            (errors.mean_ratio - 1.0).abs(),
            args.max_mean_deviation,
        ),
    ]
    .into_iter()
    .filter_map(|(name, value, limit)| {
        let limit = limit?;
        // Written so that NaN breaks every limit, and with every digit, so that the two differ.
        let holds = value <= limit;
        (!holds).then(|| format!("{name} {value:?} is above {limit:?}"))
    })
    .collect();
    if args.exact {
        let different = image.different_channels(&reference_image);
        broken.extend(
            (!different.is_empty())
                .then(|| format!("channels whose bits differ: {}", different.join(", "))),
        );
    }
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Error::failed(broken.join("; ")))
    }
}

/// The part of the errors that the noise of the reference causes, if the reference has the standard error of each value, as
/// `headwater reference` writes it; otherwise `None`.
fn noise_floor(image: &Image, reference: &[[f32; 3]]) -> Option<NoiseFloor> {
    let [r, g, b] = ["stderr.R", "stderr.G", "stderr.B"].map(|name| image.floats(name));
    let errors: Vec<[f32; 3]> = (r?.iter().zip(g?).zip(b?))
        .map(|((r, g), b)| [*r, *g, *b])
        .collect();
    let is_usable = errors.len() == reference.len()
        && errors.iter().flatten().all(|e| e.is_finite() && *e >= 0.0);
    is_usable.then(|| NoiseFloor::of(reference, &errors))
}

/// Prints a note if one file is PNG and the other EXR, so that the user does not take their difference for an error of
/// rendering. Such pictures differ although nothing is wrong, because PNG has 8 bits and may be tone-mapped, and EXR is
/// linear.
fn note_formats(picture: &Path, reference: &Path) -> Result<()> {
    let (png, exr) = match (Format::of(picture)?, Format::of(reference)?) {
        (Format::Png, Format::Exr) => (picture, reference),
        (Format::Exr, Format::Png) => (reference, picture),
        _ => return Ok(()),
    };
    notice(&format!(
        "{} has 8 bits and may be tone-mapped, as Headwater's are, {} is linear: they differ where nothing is wrong",
        png.display(),
        exr.display()
    ));
    Ok(())
}

/// Prints a note if the picture consists of samples that the reference contains too, as path tracing with fewer samples and
/// the same seed makes it. Their errors are then equal in part, so the difference is too small.
fn note_shared_samples(image: &Image, reference: &Image) {
    let both = [image, reference];
    let of = |key: &str| both.map(|image| image.metadata.get(&format!("headwater.{key}")));
    let are_path_traced = of("settings").iter().all(|settings| {
        let settings = settings.and_then(|text| serde_json::from_str(text).ok());
        settings.is_some_and(|tree: serde_json::Value| tree["integrator"] == "path-tracing")
    });
    let agree = |key: &str| matches!(of(key), [Some(a), Some(b)] if a == b);
    if are_path_traced && agree("scene") && agree("seed") && !agree("samples") {
        notice(
            "both pictures are path-traced with the same seed, so they share samples, and the errors are too small; give the reference another --seed",
        );
    }
}

/// Checks the values of the limits, the exposure, and the path of `--diff`, before a picture is read. Returns an error
/// if a limit is negative or NaN, the exposure is not finite, or the file cannot be written or is one of the pictures.
fn check(args: &Args) -> Result<()> {
    for (name, limit) in [
        ("max-rmse", args.max_rmse),
        ("max-relmse", args.max_relmse),
        ("max-flip", args.max_flip),
        ("max-mean-deviation", args.max_mean_deviation),
    ] {
        if let Some(limit) = limit.filter(|limit| limit.is_nan() || *limit < 0.0) {
            return Err(Error::input(format!(
                "--{name} {limit}: it takes a number from 0 up"
            )));
        }
    }
    if !args.exposure.is_finite() {
        return Err(Error::input("--exposure takes a finite number of stops"));
    }
    if let Some(path) = &args.diff {
        Format::of(path)?;
        let read = [
            ("the picture", args.picture.as_path()),
            ("the reference", args.reference.as_path()),
        ];
        check_files([("--diff", path.as_path())], read)?;
    }
    Ok(())
}

/// Writes, for each pixel, the picture's value minus the reference's value to the EXR file at `path`, as linear channels
/// `R`, `G` and `B`.
fn write_difference(
    path: &Path,
    (width, height): (u32, u32),
    picture: &[[f32; 3]],
    reference: &[[f32; 3]],
) -> Result<()> {
    let differences: Vec<[f32; 3]> = std::iter::zip(picture, reference)
        .map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]])
        .collect();
    let mut image = Image::new(width, height);
    image.set_vectors("", ["R", "G", "B"], &differences);
    image.write(path, 0.0)
}

/// Formats a number for the table of errors: with six decimals if it is 0 or its magnitude is from 0.001 to below a
/// million, otherwise in scientific notation with six significant digits.
fn figures(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.5e}")
    }
}

/// A picture: (width, height) in pixels, and one RGB value per pixel, row by row from the top.
type Picture = ((u32, u32), Vec<[f32; 3]>);

/// The size and the RGB values of `image`, which was read from `path`. Returns an error if a value is not finite,
/// because then the errors of the picture are not defined. Prints a note if the picture is grey, or comes from a layer
/// of the EXR file.
fn finite_pixels(path: &Path, image: &Image) -> Result<Picture> {
    let colors = image.colors().map_err(|e| Error::reading(path, e))?;
    let kind = if colors.is_grey { "grey " } else { "" };
    if let Some(layer) = &colors.layer {
        let path = path.display();
        notice(&format!("{path}: its {kind}picture is the layer {layer}"));
    } else if colors.is_grey {
        notice(&format!("{}: its picture is grey", path.display()));
    }
    let pixels = colors.pixels;
    let wrong = pixels
        .iter()
        .filter(|p| p.iter().any(|v| !v.is_finite()))
        .count();
    if wrong > 0 {
        return Err(Error::reading(
            path,
            format!("{wrong} of {} pixels are not finite", pixels.len()),
        ));
    }
    Ok(((image.width, image.height), pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    /// Runs `compare` with `options` on two pictures, each filled with one of the grey `values`.
    fn compare(values: [f32; 2], options: &[&str]) -> Result<()> {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.exr", "b.exr"].map(|name| folder.path().join(name));
        for (path, value) in paths.iter().zip(values) {
            let mut image = Image::new(4, 4);
            image.set_vectors("", ["R", "G", "B"], &[[value; 3]; 16]);
            image.write(path, 0.0).unwrap();
        }
        let line = ["compare"]
            .into_iter()
            .chain(paths.iter().map(|path| path.to_str().unwrap()))
            .chain(options.iter().copied());
        run(&Line::try_parse_from(line).unwrap().args)
    }

    #[test]
    fn exact_comparison_sees_the_last_bit() {
        let next = f32::from_bits(0.25_f32.to_bits() + 1);
        compare([0.25, 0.25], &["--exact"]).unwrap();
        compare([0.25, next], &["--max-rmse=1e-6"]).unwrap();
        let error = compare([0.25, next], &["--exact"]).unwrap_err().to_string();
        assert!(
            error.ends_with("channels whose bits differ: B, G, R"),
            "{error}"
        );
    }

    #[test]
    fn each_check_fails_on_its_own_and_names_the_numbers() {
        for (option, name) in [
            ("--max-rmse=0.1", "rmse 0.25 is above 0.1"),
            ("--max-relmse=0.1", "relmse 0.2403"),
            ("--max-flip=0.1", "flip 0."),
            (
                "--max-mean-deviation=0.1",
                "mean deviation 0.5 is above 0.1",
            ),
        ] {
            let error = compare([0.75, 0.5], &[option]).unwrap_err();
            assert_eq!(error.exit_status(), 1);
            assert!(error.to_string().starts_with(name), "{error}");
            compare([0.5, 0.5], &[option]).unwrap();
        }
        let all = ["--max-rmse=0", "--max-relmse=0", "--max-flip=0", "--json"];
        let error = compare([0.75, 0.5], &all).unwrap_err().to_string();
        assert_eq!(error.matches("is above 0.0").count(), 3, "{error}");
        compare([0.5, 0.5], &all).unwrap();
        // A limit that is met exactly holds.
        compare(
            [0.75, 0.5],
            &["--max-rmse=0.25", "--max-mean-deviation=0.5"],
        )
        .unwrap();
    }

    #[test]
    fn light_against_black_breaks_any_limit_of_the_mean() {
        let error = compare([0.5, 0.0], &["--max-mean-deviation=1e300"]).unwrap_err();
        assert!(error.to_string().contains("inf"), "{error}");
        compare([0.0, 0.0], &["--max-mean-deviation=0"]).unwrap();
    }

    #[test]
    fn a_reference_with_standard_errors_has_a_noise_floor() {
        let mut image = Image::new(2, 2);
        image.set_vectors("", ["R", "G", "B"], &[[0.5; 3]; 4]);
        assert!(noise_floor(&image, &[[0.5; 3]; 4]).is_none());
        image.set_vectors("stderr.", ["R", "G", "B"], &[[0.1; 3]; 4]);
        let floor = noise_floor(&image, &[[0.5; 3]; 4]).unwrap();
        assert!((floor.rmse - 0.1).abs() < 1e-6, "{floor:?}");
        image.set_vectors("stderr.", ["R", "G", "B"], &[[f32::NAN; 3]; 4]);
        assert!(noise_floor(&image, &[[0.5; 3]; 4]).is_none());
    }

    #[test]
    fn what_cannot_be_compared_is_wrong_input() {
        for option in [
            "--max-rmse=-1",
            "--max-flip=nan",
            "--exposure=inf",
            "--diff=a",
            "--diff=a.jpg",
        ] {
            let error = compare([0.5, 0.5], &[option]).unwrap_err();
            assert_eq!(error.exit_status(), 2, "{option}: {error}");
        }
        for values in [[f32::NAN, 0.5], [0.5, f32::INFINITY]] {
            let error = compare(values, &[]).unwrap_err();
            assert_eq!(error.exit_status(), 2);
            assert!(error.to_string().contains("16 of 16 pixels"), "{error}");
        }
        let error = compare([0.5, 0.5], &["--diff=no/such/folder/a.png"]).unwrap_err();
        assert_eq!(error.exit_status(), 1);
    }

    #[test]
    fn the_difference_is_a_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.png");
        let option = format!("--diff={}", path.display());
        compare([0.5, 0.5], &[&option]).unwrap();
        let black = Image::read(&path).unwrap().rgb().unwrap();
        compare([1.0, 0.0], &[&option]).unwrap();
        let bright = Image::read(&path).unwrap().rgb().unwrap();
        assert_eq!((black.len(), bright.len()), (16, 16));
        assert!(black[0].iter().all(|v| *v < 0.01) && bright[0][0] > 0.5);

        let path = folder.path().join("d.exr");
        let option = format!("--diff={}", path.display());
        compare([0.25, 1.0], &[&option]).unwrap();
        assert_eq!(Image::read(&path).unwrap().rgb().unwrap(), [[-0.75; 3]; 16]);
    }

    #[test]
    fn numbers_keep_their_figures() {
        assert_eq!(figures(0.0), "0.000000");
        assert_eq!(figures(0.25), "0.250000");
        assert_eq!(figures(1.25e-9), "1.25000e-9");
        assert_eq!(figures(f64::INFINITY), "inf");
    }
}
