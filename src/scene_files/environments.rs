//! Opens environments by name: `.exr` and `.hdr` files, and skies that are generated from parameters.

use super::hdr;
use super::surroundings::NO_ENVIRONMENT;
use crate::base::input_files;
use crate::scene::Environment;
use crate::scene::environment::sky;
use crate::scene::notices::quoted;
use crate::{Error, Result, image};
use glam::Vec3;
use std::path::Path;

impl Environment {
    /// Reads the environment from the file at the path `name` (`.exr` or `.hdr`). If `name` is `sky` or `sky:KEY=VALUE,…`,
    /// generates the sky with these parameters instead; `neutral` is [`Environment::neutral`]. In texels with a radiance out
    /// of range, channels that are NaN or negative become 0, and larger ones become the limit, 10¹². One line per change is
    /// added to `notices`, such as [`Scene::notices`](crate::Scene::notices).
    ///
    /// # Errors
    /// The file cannot be read, has another extension, is damaged, or has too many texels for the limit or the memory; no
    /// texel has a radiance in range; or a parameter of the sky is wrong.
    pub fn open(name: &str, notices: &mut Vec<String>) -> Result<Self> {
        let mut environment = match name.split_once(':') {
            Some(("sky", parameters)) => sky::generate(parameters)?,
            _ if name == "sky" => sky::generate("")?,
            _ if name == "neutral" => Self::neutral(),
            _ => read(Path::new(name), notices)?,
        };
        environment.name = name.to_owned();
        environment.repair(notices)?;
        Ok(environment)
    }

    /// Checks, before long work begins, that [`Environment::open`] can probably open the environment `name`: the file
    /// exists, or the parameters of the sky are valid. The content of the file is not read.
    ///
    /// # Errors
    /// There is no plain file at this path, or a parameter of the sky is wrong.
    pub fn check_name(name: &str) -> Result<()> {
        match environment_file_of(name) {
            None if name == "neutral" || name == NO_ENVIRONMENT => Ok(()),
            None => sky::parse(name.strip_prefix("sky").unwrap_or_default()).map(drop),
            Some(path) => input_files::check(path),
        }
    }
}

/// The path of the file from which the environment `name` is read. `None` for `sky` and `sky:…`, which are
/// generated without a file. Commands refuse an output with this path, because it would overwrite the
/// environment.
pub fn environment_file_of(name: &str) -> Option<&Path> {
    let generated = matches!(name, "sky" | "neutral" | NO_ENVIRONMENT) || name.starts_with("sky:");
    (!generated).then(|| Path::new(name))
}

fn read(path: &Path, notices: &mut Vec<String>) -> Result<Environment> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let (width, height, texels) = match extension.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => {
            let picture = image::Image::read(path)?;
            let colors = picture.colors().map_err(|e| Error::reading(path, e))?;
            if let Some(layer) = colors.layer {
                notices.push(format!(
                    "{}: has no channels R, G, B without a layer, so its layer {} is shown",
                    path.display(),
                    quoted(&layer)
                ));
            }
            let texels = colors.pixels.into_iter().map(Vec3::from_array).collect();
            (picture.width, picture.height, texels)
        }
        Some("hdr") => {
            let hdr = hdr::read(path, notices)?;
            (hdr.width, hdr.height, hdr.texels.into())
        }
        _ => {
            return Err(Error::input(format!(
                "{}: is not an environment file; give an .exr or .hdr file, sky:sun=40, neutral or none",
                path.display()
            )));
        }
    };
    Ok(Environment {
        name: String::new(),
        width,
        height,
        texels,
        rotation: 0.0,
        intensity: 1.0,
    })
}
