//! Reads the materials of MTL files: base colour (`Kd`) and emission (`Ke`), opacity (`d`, `Tr`), roughness (`Pr`) and
//! metalness (`Pm`), and the textures of these properties and of normals.

use super::GREY;
use super::ignored::Ignored;
use super::lines::{Line, Lines};
use super::map_statements::{self, Map};
use crate::Result;
use crate::scene::notices::quoted;
use crate::scene::validate::BRIGHTEST;
use crate::scene::{AlphaMode, Material};
use glam::{DVec3, Vec3};
use std::io::BufRead;
use std::path::Path;

/// The keywords that state a factor or its texture, in lower case.
const FACTORS: [&str; 6] = ["kd", "ke", "pr", "pm", "d", "tr"];

/// The textures that an MTL file states for one material; `None` for a property without a texture. Their images are loaded
/// later, and only if a face uses the material. The textures are boxed to save memory, because only few materials have any.
#[derive(Default)]
pub struct Maps {
    pub base_color: Option<Box<Map>>,
    pub roughness: Option<Box<Map>>,
    pub metallic: Option<Box<Map>>,
    pub emission: Option<Box<Map>>,
    pub opacity: Option<Box<Map>>,
    pub normal: Option<Box<Map>>,
    /// The texture of `map_Bump` or `bump`: a normal map or a height map, which only its image shows.
    pub bump: Option<Box<Map>>,
    /// The keywords of [`FACTORS`] that the file states for the material. A factor that is absent beside a texture of the
    /// same property becomes 1.
    stated: Vec<&'static str>,
    /// The opacity that `Tr` states, 1 if there is no such statement.
    opacity_by_tr: f32,
}

impl Maps {
    /// Sets each factor that multiplies a texture to 1 if the file states no factor or 0, so that the texture is visible.
    /// Exporters write 0 for a property that only the texture decides. There is a notice about a stated 0.
    fn complete_factors(&mut self, material: &mut Material, ignored: &mut Ignored) {
        let stated = |keyword| self.stated.contains(&keyword);
        let is_opacity_stated = stated("d") || stated("tr");
        let name = &material.name;
        let mut zero = |keyword: &str| {
            ignored
                .tally
                .add("a factor of 0 beside a texture counts as 1", || {
                    format!("{keyword} of material {}", quoted(name))
                });
        };
        if self.base_color.is_some() && replace(&mut material.base_color, stated("kd")) {
            zero("Kd");
        }
        if self.emission.is_some() && replace(&mut material.emission, stated("ke")) {
            zero("Ke");
        }
        if self.roughness.is_some() && replace(&mut material.roughness, stated("pr")) {
            zero("Pr");
        }
        if self.metallic.is_some() && replace(&mut material.metallic, stated("pm")) {
            zero("Pm");
        }
        if self.opacity.is_some() && replace(&mut material.alpha, is_opacity_stated) {
            zero("d");
        }
    }

    /// Sets the opacity of the material from `d`, or from `Tr` (1 − `d`) if there is no `d`. There is a notice where the two
    /// contradict each other, since some programs write `Tr` with the meaning of `d`, and where nothing can be seen.
    fn complete_opacity(&mut self, material: &mut Material, ignored: &mut Ignored) {
        let has = |keyword| self.stated.contains(&keyword);
        let mut tell = |what: &str| {
            let location = || format!("material {}", quoted(&material.name));
            ignored.tally.add(what, location);
        };
        match (has("d"), has("tr")) {
            (true, true) if (material.alpha - self.opacity_by_tr).abs() > 1e-3 => {
                tell("Tr is ignored where it contradicts d");
            }
            (false, true) => material.alpha = self.opacity_by_tr,
            _ => {}
        }
        if material.alpha == 0.0 && self.opacity.is_none() {
            tell("materials of opacity 0 (d 0 or Tr 1) cannot be seen");
        }
    }

    /// The textures of the material whose images are read, in the order of the fields: none to six. `bump` is one of them
    /// only without a normal map, which otherwise takes its place.
    pub fn all(&self) -> impl Iterator<Item = &Map> {
        [
            &self.base_color,
            &self.roughness,
            &self.metallic,
            &self.emission,
            &self.opacity,
            match self.normal {
                Some(_) => &self.normal,
                None => &self.bump,
            },
        ]
        .into_iter()
        .flatten()
        .map(Box::as_ref)
    }

    /// True if `map`, one of the textures of this material, is that of `map_Bump`.
    pub fn is_bump(&self, map: &Map) -> bool {
        self.bump
            .as_deref()
            .is_some_and(|bump| std::ptr::eq(bump, map))
    }

    /// The texture that a keyword in lower case states; `None` if the keyword states no supported texture.
    fn slot(&mut self, keyword: &str) -> Option<&mut Option<Box<Map>>> {
        Some(match keyword {
            "map_kd" => &mut self.base_color,
            "map_pr" => &mut self.roughness,
            "map_pm" => &mut self.metallic,
            "map_ke" => &mut self.emission,
            "map_d" => &mut self.opacity,
            "norm" => &mut self.normal,
            "map_bump" | "bump" => &mut self.bump,
            _ => return None,
        })
    }
}

/// A colour or a number that multiplies a texture.
trait Factor: PartialEq + Sized {
    const ZERO: Self;
    const ONE: Self;
}

impl Factor for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
}

impl Factor for Vec3 {
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;
}

/// Sets a factor to 1 if it is not stated or 0. Returns true if it was stated as 0.
fn replace<F: Factor>(factor: &mut F, is_stated: bool) -> bool {
    let is_zero = is_stated && *factor == F::ZERO;
    if is_zero || !is_stated {
        *factor = F::ONE;
    }
    is_zero
}

/// Reads an MTL file. Appends its materials to `materials`, whose fields for textures stay empty, and appends to `maps` the
/// textures that the file states for each of these materials. `name` is the path of the MTL file for messages, `folder` the
/// path of its folder relative to that of the OBJ file. Adds notices about statements without effect to `ignored`. Errors
/// name the line, but not the file, which the caller adds.
pub fn read(
    source: impl BufRead,
    name: &str,
    folder: &Path,
    materials: &mut Vec<Material>,
    maps: &mut Vec<Maps>,
    ignored: &mut Ignored,
) -> Result<()> {
    let first = materials.len();
    let mut lines = Lines::new(source);
    while let Some(line) = lines.next()? {
        if line.keyword == "newmtl" {
            materials.push(Material::lambert(line.rest, GREY));
            maps.push(Maps {
                opacity_by_tr: 1.0,
                ..Maps::default()
            });
            continue;
        }
        let (Some(material), Some(maps)) = (materials[first..].last_mut(), maps.last_mut()) else {
            let what = "statements before the first newmtl are ignored";
            ignored.tally.add(what, || line.location_in(name));
            continue;
        };
        if let Some(factor) = FACTORS.iter().find(|factor| **factor == line.keyword) {
            match self::factor(&line, name, material, maps, ignored) {
                Ok(()) => maps.stated.push(factor),
                Err(fault) => {
                    let what = "statements of MTL files with wrong numbers are ignored";
                    ignored
                        .tally
                        .add(what, || format!("{}, {fault}", quoted(name)));
                }
            }
        } else if let Some(slot) = maps.slot(line.keyword) {
            if let Some(map) = map_statements::read(&line, folder, name, ignored) {
                *slot = Some(Box::new(map));
                if line.keyword.starts_with("map_p") {
                    physical(material);
                }
            }
        } else {
            other(&line, folder, name, ignored);
        }
    }
    for (material, maps) in materials.iter_mut().zip(maps).skip(first) {
        maps.complete_opacity(material, ignored);
        maps.complete_factors(material, ignored);
        if material.alpha < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
    }
    Ok(())
}

/// Applies a statement that states a factor to the material; values out of range are clamped, with a notice. `name` is the
/// path of the MTL file for messages. Fails if the statement's numbers are wrong.
fn factor(
    line: &Line,
    name: &str,
    material: &mut Material,
    maps: &mut Maps,
    ignored: &mut Ignored,
) -> Result<()> {
    let mut fraction = |line: &Line| -> Result<f32> {
        let number = number(line)?;
        let clamped = number.clamp(0.0, 1.0);
        if clamped != number {
            ignored.tally.add("values outside [0, 1] are clamped", || {
                format!("{} in {}", line.written, line.location_in(name))
            });
        }
        Ok(clamped)
    };
    match line.keyword {
        "pr" => material.roughness = fraction(line)?,
        "pm" => material.metallic = fraction(line)?,
        "d" => material.alpha = fraction(line)?,
        "tr" => maps.opacity_by_tr = 1.0 - fraction(line)?,
        keyword => {
            if matches!(line.words().next(), Some("spectral" | "xyz")) {
                let what = "colours by spectrum or XYZ are ignored";
                ignored.tally.add(what, || line.location_in(name));
            } else if keyword == "kd" {
                material.base_color = color(line)?;
            } else {
                let emission = color(line)?;
                material.emission = emission.clamp(Vec3::ZERO, Vec3::splat(BRIGHTEST));
                if material.emission != emission {
                    let what = "emission outside [0, 1e12] is clamped";
                    ignored.tally.add(what, || line.location_in(name));
                }
            }
        }
    }
    if line.keyword.starts_with('p') {
        physical(material);
    }
    if line.words().any(|word| word.eq_ignore_ascii_case("-halo")) {
        let what = "the option -halo of d is ignored";
        ignored.tally.add(what, || line.location_in(name));
    }
    Ok(())
}

/// Handles a statement that does not change the material: adds a notice to `ignored` if the statement has an effect in other
/// programs or if its keyword is unknown. `name` is the path of the MTL file for messages.
fn other(line: &Line, folder: &Path, name: &str, ignored: &mut Ignored) {
    match line.keyword {
        // The specular model of MTL is replaced: materials without `Pr` and `Pm` reflect diffusely.
        "ka" | "ks" | "ns" | "ni" | "tf" | "illum" | "sharpness" => {}
        // They shape what `Pc` and `aniso` add.
        "pcr" | "anisor" => {}
        "ps" | "pc" | "aniso" => {
            let has_effect = |word: &str| word.parse() != Ok(0.0);
            if line.words().any(has_effect) {
                let what = match line.keyword {
                    "ps" => "sheen (Ps) is not supported, it is left out",
                    "pc" => "clear coat (Pc) is not supported, it is left out",
                    _ => "anisotropy (aniso) is not supported, it is left out",
                };
                ignored.tally.add(what, || line.location_in(name));
            }
        }
        "disp" | "decal" | "refl" => unsupported_texture(line, folder, name, ignored),
        keyword if keyword.starts_with("map_") => {
            unsupported_texture(line, folder, name, ignored);
        }
        _ => ignored.unknown_keyword(line, || line.location_in(name)),
    }
}

/// Adds a notice about a texture that is not supported, or that names no file.
fn unsupported_texture(line: &Line, folder: &Path, name: &str, ignored: &mut Ignored) {
    match line.rest {
        "" => drop(map_statements::read(line, folder, name, ignored)),
        _ => ignored.unsupported_texture(line),
    }
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

fn number(line: &Line) -> Result<f32> {
    // `d -halo 0.5`: the number is the last word.
    let word = line
        .words()
        .last()
        .ok_or_else(|| line.wrong("a number is needed"))?;
    line.parse(word).map(|number| number as f32)
}
