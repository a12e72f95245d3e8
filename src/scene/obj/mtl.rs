//! MTL files: `Kd`, `Ke`, and `Pr` and `Pm` where a material has them.

use super::GREY;
use super::lines::{Line, Lines};
use crate::Result;
use crate::scene::Material;
use glam::Vec3;
use std::io::BufRead;

/// What an MTL file holds.
#[derive(Default)]
pub struct Library {
    /// The materials in file order.
    pub materials: Vec<Material>,
    /// The kinds of textures it names, which are ignored.
    pub textures: Vec<String>,
    /// Names of materials that let light through, which is ignored.
    pub transparent: Vec<String>,
}

/// Reads an MTL file. Errors name the line, not the file.
pub fn read(source: impl BufRead) -> Result<Library> {
    let mut library = Library::default();
    let mut lines = Lines::new(source);
    while let Some(line) = lines.next()? {
        if line.keyword == "newmtl" {
            library.materials.push(Material::lambert(line.rest, GREY));
        } else if let Some(material) = library.materials.last_mut() {
            let seen_through = statement(&line, material)?;
            let name = &material.name;
            if seen_through && library.transparent.last() != Some(name) {
                library.transparent.push(name.clone());
            }
            let kind = line.keyword;
            let texture = kind.starts_with("map_")
                || ["norm", "bump", "disp", "decal", "refl"].contains(&kind);
            if texture && !library.textures.iter().any(|t| t == kind) {
                library.textures.push(kind.escape_debug().to_string());
            }
        }
    }
    Ok(library)
}

/// Follows a statement; tells whether it makes the material transparent.
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
            material.roughness = share(line)?;
        }
        "Pm" => {
            physical(material);
            material.metallic = share(line)?;
        }
        "d" => return Ok(number(line)? < 1.0),
        "Tr" => return Ok(number(line)? > 0.0),
        _ => {}
    }
    Ok(false)
}

/// Gives a Lambert material the specular lobe of the metallic-roughness model.
fn physical(material: &mut Material) {
    material.specular = Material::default().specular;
}

/// Red, green and blue; red alone stands for all three.
fn color(line: &Line) -> Result<Vec3> {
    if line.words().count() == 1 {
        return Ok(Vec3::splat(number(line)?));
    }
    line.floats().map(Vec3::from_array)
}

fn share(line: &Line) -> Result<f32> {
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
    line.float(word)
}
