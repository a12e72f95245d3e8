//! Build script. It compiles every pass (compute shader) to SPIR-V, once for each variant (a combination of a tracer and a
//! way in which shaders access the scene). It also writes two things that the crate embeds. Rust tables contain the SPIR-V,
//! so that the program runs without shader files. The GLSL sources serve to compile passes with source lines for debuggers,
//! and to find out which shaders a user has changed.

use headwater_shader_interface::compiler::{self, Sources};
use headwater_shader_interface::{self as shader_interface, Variant};
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in ["build.rs", "glsl"] {
        println!("cargo:rerun-if-changed={path}");
    }
    println!("cargo:rustc-env=HEADWATER_COMMIT={}", commit());
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let mut sources = compiler::read_folder(Path::new("glsl"))?;
    let generated = shader_interface::generated();
    let shipped: Vec<String> = sources.keys().cloned().collect();
    sources.extend(generated.map(|(name, text)| (name.to_owned(), text)));

    let shaders: Vec<(&str, Variant)> = compiler::passes(&sources)
        .flat_map(|(pass, _)| Variant::all().map(move |variant| (pass, variant)))
        .collect();
    compile_all(&shaders, &sources, &out)?;
    let mut table = String::from("&[\n");
    for (pass, variant) in &shaders {
        let key = variant.key(pass);
        writeln!(
            table,
            "    ({key:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{key}.spv\"))),"
        )?;
    }
    table.push_str("]\n");
    std::fs::write(out.join("shaders.rs"), table)?;

    // The sources travel along for tests and tools that compile shaders of their own.
    let mut listing = String::from("&[\n");
    for name in &shipped {
        let path = std::env::current_dir()?.join("glsl").join(name);
        writeln!(listing, "    ({name:?}, include_str!({path:?})),")?;
    }
    listing.push_str("]\n");
    std::fs::write(out.join("sources.rs"), listing)?;
    Ok(())
}

/// Compiles each entry of `shaders`, which names a pass and a variant of it, to a file in the folder `out`. One thread
/// per core does this work. If shaders do not compile, the function returns the error of one of them.
fn compile_all(shaders: &[(&str, Variant)], sources: &Sources, out: &Path) -> Result<(), String> {
    let next = AtomicUsize::new(0);
    let work = || -> Result<(), String> {
        while let Some((pass, variant)) = shaders.get(next.fetch_add(1, Ordering::Relaxed)) {
            compile(pass, *variant, sources, out)?;
        }
        Ok(())
    };
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .try_for_each(|thread| thread.join().map_err(|_| "a compiling thread panicked")?)
    })
}

/// Compiles one variant of the pass with the name `pass` to the file `KEY.spv` in the folder `out`; `KEY` names the pass
/// and the variant. The file `KEY.hash` stores a hash of the input. If it has the hash of the present input, nothing is
/// compiled, so that an edit of one shader file recompiles only the passes that include it.
fn compile(pass: &str, variant: Variant, sources: &Sources, out: &Path) -> Result<(), String> {
    let file = compiler::pass_file(pass, sources).ok_or("the pass has no file")?;
    let defines = variant.defines();
    let mut hasher = DefaultHasher::new();
    (include_str!("src/shader_interface/compiler.rs"), &defines).hash(&mut hasher);
    for name in compiler::closure(file, sources) {
        (name, &sources[name]).hash(&mut hasher);
    }
    let hash = hasher.finish().to_le_bytes();
    let [spirv, made_from] =
        ["spv", "hash"].map(|kind| out.join(format!("{}.{kind}", variant.key(pass))));
    if std::fs::read(&made_from).is_ok_and(|old| old == hash) {
        return Ok(());
    }
    // An interrupted build leaves no hash, and so the file is made again.
    let _ = std::fs::remove_file(&made_from);
    let words = compiler::compile(file, &sources[file], sources, &defines)?;
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let written = std::fs::write(&spirv, bytes).and_then(|()| std::fs::write(&made_from, hash));
    written.map_err(|e| format!("cannot write {}: {e}", spirv.display()))
}

/// The first 12 hexadecimal digits of the git commit from which this build is made; pictures, profiles and golden frames
/// store them. A `+` follows if tracked files had been changed when this script last ran. The text is empty outside a git
/// checkout.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = std::process::Command::new("git").args(arguments).output();
        let text = output.ok().filter(|o| o.status.success())?.stdout;
        Some(String::from_utf8(text).ok()?.trim().to_owned())
    };
    // Every commit and checkout adds to this log, in worktrees too.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"])
        && Path::new(&log).exists()
    {
        println!("cargo:rerun-if-changed={log}");
    }
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
    let mark = changed.is_some_and(|list| !list.is_empty()).then_some("+");
    git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_default() + mark.unwrap_or_default()
}
