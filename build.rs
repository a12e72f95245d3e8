//! Compiles every pass in every variant to SPIR-V and embeds it, with the GLSL sources.

#![allow(dead_code)]
// The crate's own parts of shared files are marked `cfg(headwater)`.
#![allow(unexpected_cfgs)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[path = "src/gpu"]
mod gpu {
    #[macro_use]
    pub mod layout;
    pub mod compiler;
}
#[path = "src/render"]
mod render {
    pub mod specialisation;
}
#[path = "src/tracing"]
mod tracing {
    pub mod buffers;
}
#[path = "src/choices.rs"]
mod choices;
#[path = "src/layouts/mod.rs"]
mod layouts;
#[path = "src/shader_variants.rs"]
mod shader_variants;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo:rustc-cfg=headwater");
    println!("cargo:rustc-check-cfg=cfg(headwater)");
    for path in [
        "build.rs",
        "glsl",
        "src/choices.rs",
        "src/gpu/layout.rs",
        "src/gpu/compiler.rs",
        "src/layouts",
        "src/render/specialisation.rs",
        "src/shader_variants.rs",
        "src/tracing/buffers.rs",
    ] {
        println!("cargo:rerun-if-changed={path}");
    }
    println!("cargo:rustc-env=HEADWATER_COMMIT={}", commit());
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let mut sources = gpu::compiler::read_folder(Path::new("glsl"))?;
    let generated = layouts::generated();
    let shipped: Vec<String> = sources.keys().cloned().collect();
    sources.extend(generated.map(|(name, text)| (name.to_owned(), text)));

    let mut table = String::from("&[\n");
    // Every file in `glsl/passes` is a pass.
    let passes = shipped
        .iter()
        .filter_map(|file| file.strip_prefix("passes/")?.strip_suffix(".comp"));
    for pass in passes {
        for variant in shader_variants::Variant::all() {
            let key = variant.key(pass);
            let file = format!("passes/{pass}.comp");
            let source = &sources[&file];
            let words = gpu::compiler::compile(&file, source, &sources, &variant.defines())?;
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            std::fs::write(out.join(format!("{key}.spv")), bytes)?;
            writeln!(
                table,
                "    ({key:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{key}.spv\"))),"
            )?;
        }
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

/// The commit this build is made from, for metadata, with a `+` if files had been changed when this
/// script last ran; empty outside a checkout.
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
