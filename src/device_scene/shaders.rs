//! The shaders of all passes: those that are embedded in the program, and those that are compiled at run time from a folder
//! in which a user edits them.

use crate::base::environment_variable::is_asked_for;
use crate::base::short_hash::short;
use crate::shader_interface::Variant;
use crate::shader_interface::compiler::{self, Debug, Sources};
use crate::{Error, Result, shader_interface};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The SPIR-V of every pass in every variant: pairs of the key that names pass and variant ([`Variant::key`]), and the bytes
/// of the module. It is compiled when the program is built, so that a run needs neither a compiler nor other files.
const EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The GLSL sources embedded in the program: pairs of the path in the folder `glsl` and the text. Tests compile shaders from
/// them, and a user's edited copies are compared with them. The declarations that are generated from Rust are not in this
/// list.
const SOURCES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The SPIR-V words of the pass `name` in a variant. Usually they are taken from the program, in which all passes are
/// embedded. But the pass is compiled if `HEADWATER_GLSL` names a folder of sources, or if `HEADWATER_SHADER_DEBUG` requests
/// the source lines that profilers and debuggers show.
///
/// # Errors
/// The folder cannot be read or lacks the shader, the shader does not compile, or no pass with this name is embedded.
pub fn spirv(name: &str, variant: Variant) -> Result<Vec<u32>> {
    let with_lines = is_asked_for("HEADWATER_SHADER_DEBUG");
    let folder = edited_folder();
    if with_lines || folder.is_some() {
        let sources = sources_in_use()?;
        let file = compiler::pass_file(name, &sources).ok_or_else(|| {
            Error::input(format!(
                "HEADWATER_GLSL={} has no {name}.comp; name a copy of the folder glsl",
                folder.unwrap_or_default().display()
            ))
        })?;
        let debug = if with_lines {
            Debug::Lines
        } else {
            Debug::Names
        };
        let words = compile(file, &sources, variant, debug)?;
        let included = compiler::closure(file, &sources).into_iter();
        used_files().extend(included.map(str::to_owned));
        return Ok(words);
    }
    let key = variant.key(name);
    let (_, bytes) = EMBEDDED
        .iter()
        .find(|(embedded, _)| *embedded == key)
        .ok_or_else(|| Error::failed(format!("no shader '{key}' is embedded")))?;
    Ok(bytemuck::pod_collect_to_vec(bytes))
}

/// The folder that `HEADWATER_GLSL` names, whose shaders replace the embedded ones; `None` if the variable is not set.
fn edited_folder() -> Option<OsString> {
    std::env::var_os("HEADWATER_GLSL")
}

/// Compiles one pass, whose file has the path `file` in `sources`, to SPIR-V words. An error joins the lines of the
/// compiler's message into one line.
fn compile(file: &str, sources: &Sources, variant: Variant, debug: Debug) -> Result<Vec<u32>> {
    compiler::compile_with(file, &sources[file], sources, &variant.defines(), debug)
        .map_err(|e| Error::input(e.replace('\n', "; ")))
}

/// The paths of the GLSL files that passes compiled by [`spirv`] have included so far in this process.
/// [`changes_without_effect`] compares edited files with them, to find those that no pass uses. The set stays
/// locked while the result exists.
fn used_files() -> MutexGuard<'static, BTreeSet<String>> {
    static USED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    USED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Compiles every pass in the folder that `HEADWATER_GLSL` names, for one variant. Thus a mistake is found even in a pass
/// that this run does not use. Does nothing if the variable is not set.
///
/// # Errors
/// The folder cannot be read, or a shader does not compile.
pub fn check_folder(variant: Variant) -> Result<()> {
    if edited_folder().is_none() {
        return Ok(());
    }
    let sources = sources_in_use()?;
    let passes: Vec<(&str, &str)> = compiler::passes(&sources).collect();
    passes
        .into_par_iter()
        .try_for_each(|(_, file)| compile(file, &sources, variant, Debug::Names).map(drop))
}

/// The paths of edited GLSL files that have no effect on the picture: files in the folder of `HEADWATER_GLSL` that differ
/// from the embedded ones, but that no pass compiled in this process has included. A notice names them to the user. Empty if
/// the variable is not set.
///
/// # Errors
/// The folder cannot be read.
pub fn changes_without_effect() -> Result<Vec<String>> {
    if edited_folder().is_none() {
        return Ok(Vec::new());
    }
    let (built_in, used) = (sources(), used_files().clone());
    let changed = (sources_in_use()?.into_iter())
        .filter(|(name, text)| built_in.get(name) != Some(text) && !used.contains(name));
    Ok(changed.map(|(name, _)| name).collect())
}

/// The embedded GLSL sources, with the generated declarations that Rust and shaders share: a map from path to text. Tests
/// compile their own shaders with these sources.
pub fn sources() -> Sources {
    let mut sources: Sources = SOURCES
        .iter()
        .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()))
        .collect();
    add_generated(&mut sources);
    sources
}

/// Hashes of the GLSL sources in use, including the generated declarations. Studies store results under names
/// that contain these hashes, so that results are computed again after a change of the shaders.
pub struct Fingerprints {
    /// The first 16 hexadecimal digits of the BLAKE3 hash of the names and texts of all GLSL files. As long as it is the
    /// same, a study reuses its finished runs.
    pub all: String,
    /// The first 16 hexadecimal digits of the BLAKE3 hash of the file of the pass `path_trace` and of all files that it
    /// includes. As long as it is the same, a study reuses its reference pictures, which this pass renders.
    pub path_trace: String,
}

impl Fingerprints {
    /// Hashes the sources in use: those of the folder that `HEADWATER_GLSL` names, or the embedded ones.
    ///
    /// # Errors
    /// `HEADWATER_GLSL` names a folder that cannot be read.
    pub fn new() -> Result<Self> {
        let sources = sources_in_use()?;
        let included = compiler::closure("path_tracing/path_trace.comp", &sources);
        Ok(Self {
            all: hash_of(&sources, |_| true),
            path_trace: hash_of(&sources, |name| included.contains(name)),
        })
    }
}

/// [`Fingerprints::all`] of the shaders in the folder of `HEADWATER_GLSL`; `None` if the variable is not set, because the
/// commit of the program then identifies the embedded shaders. It is stored in the metadata of pictures. `--resume` compares
/// it, so that all samples of a picture are computed by the same shaders.
///
/// # Errors
/// The folder cannot be read.
pub fn edited_fingerprint() -> Result<Option<String>> {
    match edited_folder() {
        None => Ok(None),
        Some(_) => Fingerprints::new().map(|fingerprints| Some(fingerprints.all)),
    }
}

fn hash_of(sources: &Sources, is_wanted: impl Fn(&str) -> bool) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, text) in sources.iter().filter(|(name, _)| is_wanted(name)) {
        hasher.update(name.as_bytes()).update(b"\0");
        hasher.update(text.as_bytes()).update(b"\0");
    }
    short(&hasher.finalize())
}

/// The GLSL sources of the folder that `HEADWATER_GLSL` names or, if the variable is not set, the embedded
/// ones; in both cases with the generated declarations. Passes are compiled from them at run time, and their
/// hashes are computed.
fn sources_in_use() -> Result<Sources> {
    let Some(folder) = edited_folder() else {
        return Ok(sources());
    };
    let folder = Path::new(&folder);
    let mut sources = compiler::read_folder(folder).map_err(|e| Error::reading(folder, e))?;
    add_generated(&mut sources);
    Ok(sources)
}

fn add_generated(sources: &mut Sources) {
    let generated = shader_interface::generated();
    sources.extend(generated.map(|(name, text)| (name.to_owned(), text)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::reflection::{BindingKind, Reflection, parse};
    use crate::gpu::specialise::specialise;
    use crate::shader_interface::Specialisation;
    use crate::shader_interface::declare::{GpuStruct, SpecialisationConstant};
    use crate::shader_interface::{BUFFERS, Elements};
    use crate::shader_interface::{GpuLightEntry, GpuLightNode, GpuMaterialLayers, STRUCTS};
    use std::collections::BTreeSet;

    /// The hash of the pass that renders references must change if a file that the pass includes changes, and must not
    /// change with any other file.
    #[test]
    fn a_pass_depends_on_what_it_includes() {
        let sources = sources();
        let included = compiler::closure("path_tracing/path_trace.comp", &sources);
        for name in [
            "scene/trace_compute_bvh.glsl",
            "core/math.glsl",
            "declarations.glsl",
            "prelude.glsl",
        ] {
            assert!(included.contains(name), "{name}");
        }
        assert!(
            !included.iter().any(|name| name.starts_with("restir/")),
            "{included:?}"
        );
        let edited = |name: &str| {
            let mut edited = sources.clone();
            edited.get_mut(name).unwrap().push('\n');
            hash_of(&edited, |name| included.contains(name))
        };
        let now = hash_of(&sources, |name| included.contains(name));
        assert_eq!(edited("restir/merge.glsl"), now);
        assert_ne!(edited("lights/kinds/triangle.glsl"), now);
    }

    #[test]
    fn every_shared_structure_lies_in_every_shader_as_it_does_in_rust() {
        let mut seen = BTreeSet::new();
        for (key, bytes) in EMBEDDED {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let reflection = Reflection::new(&words).unwrap();
            seen.extend(
                reflection
                    .check_layouts(STRUCTS)
                    .unwrap_or_else(|e| panic!("{key}: {e}")),
            );
        }
        // Records are put together from words by code that is generated from their layouts.
        let is_record = |name: &str| {
            let mut elements = BUFFERS.iter().map(|access| &access.elements);
            elements.any(|e| matches!(e, Elements::Records(layout) if layout.name == name))
                || [
                    GpuLightNode::LAYOUT,
                    GpuLightEntry::LAYOUT,
                    GpuMaterialLayers::LAYOUT,
                ]
                .iter()
                .any(|layout| layout.name == name)
        };
        for layout in STRUCTS {
            assert!(
                seen.contains(layout.name) || is_record(layout.name),
                "{} is in no shader",
                layout.name
            );
        }
    }

    /// Compares the specialisation constants that Rust declares with those of all embedded shaders. Returns one line for
    /// each constant of a shader that Rust lacks or declares differently, and one for each declared constant that no shader
    /// uses.
    fn specialisation_faults(declared: &[SpecialisationConstant]) -> Vec<String> {
        let mut unused: BTreeSet<&str> = declared.iter().map(|c| c.name.as_str()).collect();
        let mut faults = Vec::new();
        for (key, bytes) in EMBEDDED {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let reflection = Reflection::new(&words).unwrap();
            for found in reflection.specialisation_constants() {
                let same = declared.iter().find(|c| {
                    (c.id, c.name.as_str(), c.glsl, c.word)
                        == (found.id, found.name.as_str(), found.glsl, found.word)
                });
                match same {
                    None => faults.push(format!("{key}: {found:?}")),
                    Some(constant) if found.is_used => drop(unused.remove(constant.name.as_str())),
                    Some(_) => {}
                }
            }
        }
        faults.extend(
            unused
                .into_iter()
                .map(|name| format!("no shader uses {name}")),
        );
        faults
    }

    #[test]
    fn specialisation_constants_are_the_same_in_rust_and_in_shaders() {
        let declared = Specialisation::default().constants();
        assert_eq!(specialisation_faults(&declared), Vec::<String>::new());
        let mut moved = declared.clone();
        moved[3].id += 1;
        assert!(!specialisation_faults(&moved).is_empty());
        let mut more = declared;
        more.push(SpecialisationConstant {
            name: "NOBODYS".into(),
            ..more[0].clone()
        });
        assert_eq!(specialisation_faults(&more), ["no shader uses NOBODYS"]);
    }

    #[test]
    fn nothing_is_left_to_specialise() {
        for (key, bytes) in EMBEDDED {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let mut module = parse(&words).unwrap();
            specialise(&mut module, &Specialisation::default().words());
            let mut globals = module.types_global_values.iter();
            let left = globals.find(|i| i.class.opname.starts_with("SpecConstant"));
            assert!(left.is_none(), "{key}: {left:?}");
        }
    }

    #[test]
    fn a_planted_layout_mismatch_is_found() {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(EMBEDDED[0].1);
        let reflection = Reflection::new(&words).unwrap();
        let layout = STRUCTS
            .iter()
            .find(|l| {
                reflection
                    .check_layouts(&[**l])
                    .is_ok_and(|f| !f.is_empty())
            })
            .unwrap();
        let mut members = layout.members.to_vec();
        members[1].offset += 4;
        let planted = crate::shader_interface::declare::StructLayout {
            members: members.leak(),
            ..*layout
        };
        assert!(reflection.check_layouts(&[planted]).is_err());
    }

    /// SwiftShader binds at most 30 storage buffers to a shader. When a scene is rendered, a pass leaves out the buffers
    /// that the scene does not need; the embedded passes tested here still have all of their buffers.
    #[test]
    fn every_shader_has_room_for_its_buffers_on_every_driver() {
        for (key, bytes) in EMBEDDED {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let interface = Reflection::new(&words).unwrap().interface().unwrap();
            let storage = (interface.bindings.iter())
                .filter(|binding| matches!(binding.kind, BindingKind::Storage { .. }));
            let names: Vec<&str> = storage.map(|binding| binding.name.as_str()).collect();
            assert!(names.len() <= 30, "{key} binds {}: {names:?}", names.len());
        }
    }

    #[test]
    fn every_shader_binds_by_name() {
        for (key, bytes) in EMBEDDED {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
            let interface = Reflection::new(&words).unwrap().interface();
            let interface = interface.unwrap_or_else(|e| panic!("{key}: {e}"));
            assert!(!interface.bindings.is_empty(), "{key}");
        }
    }
}
