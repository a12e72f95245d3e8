//! `compare`: one picture against a reference, with checks.

use crate::files::write_atomically;
use crate::image::{Format, Image};
use crate::metrics::error::Errors;
use crate::metrics::flip::flip;
use crate::{Error, Result};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(clap::Args)]
pub struct Args {
    /// The picture: .exr or .png
    picture: PathBuf,
    /// The reference it is held against
    reference: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Write the FLIP error of each pixel as a picture, dark to bright
    #[arg(long, value_name = "FILE.png")]
    diff: Option<PathBuf>,
    /// Exposure at which FLIP sees both, in stops
    #[arg(
        long,
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_name = "EV"
    )]
    exposure: f32,
    /// Fail above this root mean square error
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_rmse: Option<f64>,
    /// Fail above this relative mean square error
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_relmse: Option<f64>,
    /// Fail above this mean FLIP error
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_flip: Option<f64>,
    /// Fail if the ratio of the means is further from 1 than this
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    max_mean_deviation: Option<f64>,
}

/// Compares, prints, and checks.
///
/// # Errors
/// Pictures that cannot be compared (wrong input), or a check that does not hold.
pub fn run(args: &Args) -> Result<()> {
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
    if let Some(path) = &args.diff
        && Format::of(path)? != Format::Png
    {
        return Err(Error::input(format!(
            "--diff {}: it is written as .png",
            path.display()
        )));
    }
    let (size, picture) = read(&args.picture)?;
    let (reference_size, reference) = read(&args.reference)?;
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
    let errors = Errors::between(&picture, &reference);
    let perceived = flip(&picture, &reference, size, args.exposure);
    if let Some(path) = &args.diff {
        write_map(path, &perceived.map, size)?;
    }
    let Errors {
        rmse,
        rmse_clamped,
        relmse,
        mean_ratio,
    } = errors;
    let rows = [
        ("rmse", rmse),
        ("rmse_clamped", rmse_clamped),
        ("relmse", relmse),
        ("flip", perceived.mean),
        ("mean_ratio", mean_ratio),
    ];
    if args.json {
        let object: serde_json::Map<_, _> = rows
            .iter()
            .map(|(name, value)| ((*name).to_owned(), json!(value)))
            .collect();
        println!("{:#}", serde_json::Value::Object(object));
    } else {
        for (name, value) in rows {
            println!("{name:13} {value:.6}");
        }
    }
    let broken: Vec<String> = [
        ("rmse", rmse, args.max_rmse),
        ("relmse", relmse, args.max_relmse),
        ("flip", perceived.mean, args.max_flip),
        (
            "mean deviation",
            (mean_ratio - 1.0).abs(),
            args.max_mean_deviation,
        ),
    ]
    .into_iter()
    .filter_map(|(name, value, limit)| {
        let limit = limit?;
        // Written so that NaN breaks every limit.
        let holds = value <= limit;
        (!holds).then(|| format!("{name} {value:.6} is above {limit}"))
    })
    .collect();
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Error::failed(broken.join("; ")))
    }
}

/// Width, height and pixels.
type Picture = ((u32, u32), Vec<[f32; 3]>);

/// A picture whose pixels are all finite.
fn read(path: &Path) -> Result<Picture> {
    let image = Image::read(path)?;
    let pixels = image.rgb().map_err(|e| Error::reading(path, e))?;
    let wrong = pixels
        .iter()
        .filter(|p| p.iter().any(|v| !v.is_finite()))
        .count();
    if wrong > 0 {
        return Err(Error::reading(
            path,
            format!("{wrong} pixels are not finite"),
        ));
    }
    Ok(((image.width, image.height), pixels))
}

fn write_map(path: &Path, map: &[u8], size: (u32, u32)) -> Result<()> {
    write_atomically(path, |file| {
        PngEncoder::new(file)
            .write_image(map, size.0, size.1, ExtendedColorType::Rgb8)
            .map_err(std::io::Error::other)
    })
}
