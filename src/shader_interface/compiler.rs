//! Compiles GLSL to SPIR-V with `shaderc`: at build time the shaders that the program contains, at run time the shaders of
//! tests and those in a folder that a user edits.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

/// The texts of GLSL files, among which [`compile`] finds the files that a shader includes. The key of a text is the path
/// that `#include` uses, such as `core/random.glsl` or `passes/primary.comp`.
pub type Sources = BTreeMap<String, String>;

/// The compiler that all compilations of the process share, or a message why it could not be made. It is never dropped: when
/// the last compiler is dropped, `shaderc` also drops the tables of GLSL's built-in functions, and building them again takes
/// most of the time of a compilation.
static COMPILER: LazyLock<Result<shaderc::Compiler, String>> =
    LazyLock::new(|| shaderc::Compiler::new().map_err(|e| e.to_string()));

/// The first line of a file that each compilation includes only once, however many files include it. `shaderc` does not
/// support this line, so [`compile`] removes it and leaves out later includes of the file.
const ONCE: &str = "#pragma once\n";

/// The amount of debug information in the compiled SPIR-V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Debug {
    /// The only debug information is the names of variables, functions and bindings, which the program needs to bind buffers
    /// by name.
    Names,
    /// The SPIR-V contains the names, the text of the source, and the source line of each instruction. Profilers and
    /// debuggers show them.
    Lines,
}

/// Reads all `.glsl` and `.comp` files in a folder and in its subfolders, at any depth. The keys of the result are their
/// paths relative to the folder.
///
/// # Errors
/// A folder or a file cannot be read, or a file is not UTF-8.
pub fn read_folder(folder: &Path) -> std::io::Result<Sources> {
    let mut sources = Sources::new();
    let mut folders = vec![(folder.to_owned(), String::new())];
    while let Some((folder, prefix)) = folders.pop() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("{prefix}{name}");
            if path.is_dir() {
                folders.push((path, format!("{name}/")));
            } else if name.ends_with(".glsl") || name.ends_with(".comp") {
                sources.insert(name, std::fs::read_to_string(path)?);
            }
        }
    }
    Ok(sources)
}

/// The passes (compute shaders) among the sources, as pairs of the name of the pass and the path of its file. Each file that
/// ends in `.comp` is one pass. The name is the file's name without folder and ending, such as `primary` for
/// `passes/primary.comp`.
pub fn passes(sources: &Sources) -> impl Iterator<Item = (&str, &str)> {
    sources.keys().filter_map(|file| {
        let path = file.strip_suffix(".comp")?;
        Some((path.rsplit('/').next().unwrap_or(path), file.as_str()))
    })
}

/// The path of the file of the pass with the name `pass`, which is a key of `sources`; `None` if `sources`
/// contain no such pass.
pub fn pass_file<'a>(pass: &str, sources: &'a Sources) -> Option<&'a str> {
    passes(sources)
        .find(|(name, _)| *name == pass)
        .map(|(_, file)| file)
}

/// The path `name` and the paths of all files that the file at `name` includes, directly or through other files; paths that
/// are not in `sources` are left out. The build compiles a pass again if one of these files changes.
pub fn closure<'a>(name: &'a str, sources: &'a Sources) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open = vec![name];
    while let Some(name) = open.pop() {
        let Some((name, text)) = sources.get_key_value(name) else {
            continue;
        };
        if found.insert(name.as_str()) {
            let includes = text
                .lines()
                .filter_map(|line| line.strip_prefix("#include \""));
            open.extend(includes.filter_map(|line| line.strip_suffix('"')));
        }
    }
    found
}

/// Compiles one compute shader with the text `source` to SPIR-V 1.5 (Vulkan 1.2), and returns it as 32-bit words. `name` is
/// the shader's path in messages; `defines` are pairs of the name and the value of a macro.
///
/// The names of variables and bindings stay in the SPIR-V, because the program binds buffers by name. No optimiser runs,
/// because drivers optimise anyway. Binding numbers are assigned automatically. The paths after `#include` are keys of
/// `includes`; a file that begins with `#pragma once` is included once.
///
/// # Errors
/// The shader does not compile, causes a warning, or includes a file that does not exist; the message of the compiler names
/// file and line. Or the compiler cannot be made.
pub fn compile(
    name: &str,
    source: &str,
    includes: &Sources,
    defines: &[(&str, &str)],
) -> Result<Vec<u32>, String> {
    compile_with(name, source, includes, defines, Debug::Names)
}

/// Compiles one compute shader as [`compile`] does, but with the amount of debug information that `debug` selects.
/// [`compile`] always selects [`Debug::Names`].
///
/// # Errors
/// The errors of [`compile`].
pub fn compile_with(
    name: &str,
    source: &str,
    includes: &Sources,
    defines: &[(&str, &str)],
    debug: Debug,
) -> Result<Vec<u32>, String> {
    let included = RefCell::new(BTreeSet::new());
    let compiler = COMPILER.as_ref()?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(
        shaderc::TargetEnv::Vulkan,
        shaderc::EnvVersion::Vulkan1_2 as u32,
    );
    options.set_source_language(shaderc::SourceLanguage::GLSL);
    options.set_auto_bind_uniforms(true);
    options.set_warnings_as_errors();
    if debug == Debug::Lines {
        options.set_generate_debug_info();
    }
    for (key, value) in defines {
        options.add_macro_definition(key, Some(value));
    }
    options.set_include_callback(|requested, _, from, _| {
        let content = includes
            .get(requested)
            .ok_or_else(|| format!("{from} includes {requested}, which does not exist"))?;
        // The compiler does not know the pragma.
        let content = match content.strip_prefix(ONCE) {
            Some(_) if !included.borrow_mut().insert(requested.to_owned()) => String::new(),
            Some(rest) => format!("\n{rest}"),
            None => content.clone(),
        };
        Ok(shaderc::ResolvedInclude {
            resolved_name: requested.to_owned(),
            content,
        })
    });
    let artifact = compiler
        .compile_into_spirv(
            source,
            shaderc::ShaderKind::Compute,
            name,
            "main",
            Some(&options),
        )
        .map_err(|e| e.to_string())?;
    Ok(artifact.as_binary().to_vec())
}
