//! Reads the materials of MTL files: base colour (`Kd`) and emission (`Ke`), roughness (`Pr`) and metalness (`Pm`) if a
//! material states them, and the textures `map_Kd`, `map_Ke`, `map_Pr`, `map_Pm` and `norm`.

use super::lines::{Line, Lines};
use super::{GREY, MAX_KINDS};
use crate::Result;
use crate::scene::Material;
use crate::scene::notices::quoted;
use glam::{Affine2, DVec3, Mat2, Vec2, Vec3};
use std::io::BufRead;
use std::path::{Path, PathBuf};

/// The statements of an MTL file that the reader ignored. The reader of the OBJ file makes notices for the
/// user from these lists.
#[derive(Default)]
pub struct Library {
    /// The keywords of unsupported textures in the file, such as `bump`, each once. There may be one more than
    /// [`MAX_KINDS`], which tells the notice that lists them to end with "and others".
    pub textures: Vec<String>,
    /// Options of supported textures that the reader ignores although they would change the picture. Each pair is the
    /// option, such as `-texres`, and where it is, such as `line 12`.
    pub options: Vec<(String, String)>,
    /// The names of the materials that the file states as transparent (`d` below 1 or `Tr` above 0). The reader does not
    /// support transparency and makes these materials opaque; a notice lists the names.
    pub transparent: Vec<String>,
}

/// The textures that an MTL file states for one material; `None` for a property without a texture. Their images are loaded
/// later, and only if a face uses the material. The textures are boxed to save memory, because only few materials have any.
#[derive(Default)]
pub struct Maps {
    pub base_color: Option<Box<Map>>,
    pub roughness: Option<Box<Map>>,
    pub metallic: Option<Box<Map>>,
    pub emission: Option<Box<Map>>,
    pub normal: Option<Box<Map>>,
    /// The keywords among `Kd`, `Ke` and `Pm` (base colour, emission, metalness) that the file states for the material. If a
    /// keyword is absent but the material has a texture for this property, the value that multiplies the texture becomes 1.
    stated: Vec<&'static str>,
}

impl Maps {
    /// Sets base colour, emission and metalness of `material` to 1 where it has a texture for the property but the file
    /// states no factor, so that the texture is not multiplied by a default. Removes the texture of emission if the material
    /// emits nothing, because the texture would have no effect.
    fn replace_unstated_factors(&mut self, material: &mut Material) {
        let alone =
            |map: &Option<Box<Map>>, factor| map.is_some() && !self.stated.contains(&factor);
        if alone(&self.base_color, "Kd") {
            material.base_color = Vec3::ONE;
        }
        if alone(&self.emission, "Ke") {
            material.emission = Vec3::ONE;
        }
        if alone(&self.metallic, "Pm") {
            material.metallic = 1.0;
        }
        // Nothing is seen of a map of what does not emit.
        if !material.is_emissive() {
            self.emission = None;
        }
    }

    /// The textures of the material, in the order of the fields: none to five. The loader reads the image
    /// file of each.
    pub fn all(&self) -> impl Iterator<Item = &Map> {
        [
            &self.base_color,
            &self.roughness,
            &self.metallic,
            &self.emission,
            &self.normal,
        ]
        .into_iter()
        .flatten()
        .map(Box::as_ref)
    }
}

/// A texture of an MTL material: the path of an image file, and how the image lies on the surface. When the image is loaded,
/// the texture of the scene's material is made from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Two possible paths of the image file, both relative to the folder of the OBJ file; the first one that exists is used.
    /// Some programs write paths relative to the MTL file (the first path), others relative to the OBJ file (the second).
    pub files: [PathBuf; 2],
    /// The transform from a vertex's texture coordinates to coordinates in the image, in which the image covers [0, 1]. It
    /// scales (option `-s`), then adds an offset (option `-o`). v points up before and after it, unlike in the scene.
    pub transform: Affine2,
    /// True if the texels at the edge continue beyond the image (option `-clamp on`); false if the image repeats.
    pub clamp: bool,
    /// The line on which the MTL file states the texture, as a text for messages: `line 12`.
    pub location: String,
}

/// Reads an MTL file. Appends its materials to `materials`, whose fields for textures stay empty, and appends to `maps` the
/// textures that the file states for each of these materials. `folder` is the path of the MTL file's folder relative to that
/// of the OBJ file. Returns what the reader ignored; errors name the line, but not the file, which the caller adds.
pub fn read(
    source: impl BufRead,
    folder: &Path,
    materials: &mut Vec<Material>,
    maps: &mut Vec<Maps>,
) -> Result<Library> {
    let mut library = Library::default();
    let first = materials.len();
    let mut lines = Lines::new(source);
    while let Some(line) = lines.next()? {
        if line.keyword == "newmtl" {
            materials.push(Material::lambert(line.rest, GREY));
            maps.push(Maps::default());
        } else if let (Some(material), Some(maps)) =
            (materials[first..].last_mut(), maps.last_mut())
        {
            for factor in ["Kd", "Ke", "Pm"] {
                if line.keyword == factor {
                    maps.stated.push(factor);
                }
            }
            let seen_through = statement(&line, material)?;
            let name = &material.name;
            if seen_through && library.transparent.last() != Some(name) {
                library.transparent.push(name.clone());
            }
            let kind = line.keyword;
            let followed = match kind {
                "map_Kd" => Some(&mut maps.base_color),
                "map_Pr" => Some(&mut maps.roughness),
                "map_Pm" => Some(&mut maps.metallic),
                "map_Ke" => Some(&mut maps.emission),
                "norm" => Some(&mut maps.normal),
                _ => None,
            };
            if let Some(slot) = followed {
                if kind.starts_with("map_P") {
                    physical(material);
                }
                *slot = Some(Box::new(map(&line, folder, &mut library.options)?));
                continue;
            }
            let texture =
                kind.starts_with("map_") || ["bump", "disp", "decal", "refl"].contains(&kind);
            if texture && library.textures.len() <= MAX_KINDS {
                let start: String = kind.chars().take(40).collect();
                let shown = start.escape_debug().to_string();
                if !library.textures.contains(&shown) {
                    library.textures.push(shown);
                }
            }
        }
    }
    for (material, maps) in materials.iter_mut().zip(maps).skip(first) {
        maps.replace_unstated_factors(material);
    }
    Ok(library)
}

/// Applies a statement to the material if it states a colour or a number that is supported, and ignores other statements.
/// Returns true if the statement makes the material transparent, which the reader does not support. Fails if the statement's
/// numbers are wrong.
fn statement(line: &Line, material: &mut Material) -> Result<bool> {
    match line.keyword {
        "Kd" => material.base_color = color(line)?,
        "Ke" => {
            material.emission = color(line)?;
            if material.emission.min_element() < 0.0 {
                return Err(line.wrong("emission must not be negative"));
            }
        }
        "Pr" => {
            physical(material);
            material.roughness = fraction(line)?;
        }
        "Pm" => {
            physical(material);
            material.metallic = fraction(line)?;
        }
        "d" => return Ok(number(line)? < 1.0),
        "Tr" => return Ok(number(line)? > 0.0),
        _ => {}
    }
    Ok(false)
}

/// Reads a statement that states a texture: its options and the path of its image file. `folder` is the path of the MTL
/// file's folder relative to that of the OBJ file. Options that are not supported are added to `ignored`, each with its
/// line. Fails if the path is missing or an option is unknown.
fn map(line: &Line, folder: &Path, ignored: &mut Vec<(String, String)>) -> Result<Map> {
    let (mut scale, mut offset, mut clamp) = (Vec2::ONE, Vec2::ZERO, false);
    let mut rest = line.rest;
    let next = |rest: &mut &str| {
        let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let word = word.to_owned();
        *rest = after.trim_start();
        word
    };
    while rest.starts_with('-') {
        let option = next(&mut rest);
        // The numbers that follow: those of the last two words may be the name of the file.
        let mut numbers = Vec::new();
        while let Some(number) = (rest.split_once(char::is_whitespace))
            .and_then(|(word, _)| word.parse::<f32>().ok().filter(|n| n.is_finite()))
        {
            numbers.push(number);
            next(&mut rest);
        }
        let pair = |default: f32| {
            let number = |i: usize| numbers.get(i).copied().unwrap_or(default);
            Vec2::new(number(0), number(1))
        };
        let is_followed = match option.as_str() {
            "-s" => {
                scale = pair(1.0);
                true
            }
            "-o" => {
                offset = pair(0.0);
                true
            }
            "-clamp" => {
                clamp = next(&mut rest) == "on";
                true
            }
            // What others do without them is done here.
            "-blendu" | "-blendv" => next(&mut rest) == "on",
            "-cc" => next(&mut rest) == "off",
            "-mm" => numbers.iter().zip([0.0, 1.0]).all(|(n, usual)| *n == usual),
            "-bm" => numbers.iter().all(|n| *n == 1.0),
            "-boost" | "-t" => numbers.iter().all(|n| *n == 0.0),
            // Roughness and metalness are red.
            "-imfchan" => next(&mut rest) == "r" && line.keyword.starts_with("map_P"),
            "-type" => {
                next(&mut rest);
                false
            }
            "-texres" => false,
            _ => {
                return Err(line.wrong(&format!(
                    "{} is not an option of a texture",
                    quoted(&option)
                )));
            }
        };
        if !is_followed {
            ignored.push((option, line.location()));
        }
    }
    if rest.is_empty() {
        return Err(line.wrong("the texture has no file"));
    }
    let file = rest.replace('\\', "/");
    Ok(Map {
        // Some programs write paths from the MTL file, others from the OBJ file.
        files: [folder.join(&file), file.into()],
        transform: Affine2::from_mat2_translation(Mat2::from_diagonal(scale), offset),
        clamp,
        location: line.location(),
    })
}

/// Adds the specular lobe of the metallic-roughness model to the material. MTL materials begin as Lambert materials, which
/// have no specular lobe, but `Pr`, `Pm` and their textures (roughness and metalness) need it.
fn physical(material: &mut Material) {
    material.specular = Material::default().specular;
}

/// The linear RGB colour that a statement such as `Kd` or `Ke` states. A single number stands for all three
/// channels. Fails if there are two words or none, or if a word is not a finite number.
fn color(line: &Line) -> Result<Vec3> {
    if line.words().count() == 1 {
        return Ok(Vec3::splat(number(line)?));
    }
    line.numbers().map(|color| DVec3::from(color).as_vec3())
}

fn fraction(line: &Line) -> Result<f32> {
    let number = number(line)?;
    if (0.0..=1.0).contains(&number) {
        return Ok(number);
    }
    Err(line.wrong(&format!("{number} is not within 0 and 1")))
}

fn number(line: &Line) -> Result<f32> {
    // `d -halo 0.5`: the number is the last word.
    let word = line
        .words()
        .last()
        .ok_or_else(|| line.wrong("a number is needed"))?;
    line.number(word).map(|number| number as f32)
}
