//! `scene`: procedural scenes, and what is in a file.

use super::interrupt::Interrupt;
use super::notice;
use super::{open_scene, print};
use crate::json::value_of;
use crate::scene::load::Options;
use crate::scene::requirements::Requirements;
use crate::scene::{Motion, export, procedural};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The subcommands of `scene`.
#[derive(clap::Subcommand)]
pub enum Command {
    /// The procedural scenes and their parameters.
    List {
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Write a procedural scene as .glb with its camera.
    Generate {
        /// The scene's name
        name: String,
        /// Where it goes
        #[arg(short, long, value_name = "FILE.glb")]
        output: PathBuf,
        /// A parameter; repeatable
        #[arg(long, value_name = "KEY=VALUE")]
        set: Vec<String>,
    },
    /// Triangles, lights, materials, bounds, cameras, requirements.
    Inspect {
        /// A procedural scene's name, or a file: .gltf, .glb, .obj
        scene: String,
        /// How it is loaded
        #[command(flatten)]
        load: Options,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
}

/// Runs a subcommand.
///
/// # Errors
/// Wrong arguments or input, or a disk that does not take the file.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::List { json } => list(*json),
        Command::Generate { name, output, set } => {
            if output
                .extension()
                .is_none_or(|e| !e.eq_ignore_ascii_case("glb"))
            {
                return Err(Error::input(format!(
                    "'{}': a generated scene is written as .glb",
                    output.display()
                )));
            }
            let pairs = set.iter().map(|change| {
                let (key, value) = change
                    .split_once('=')
                    .ok_or_else(|| Error::input(format!("'{change}' is not KEY=VALUE")))?;
                Ok((key.to_owned(), value.to_owned()))
            });
            let scene = procedural::generate(name, &pairs.collect::<Result<Vec<_>>>()?)?;
            export::write_glb(&scene, output)
        }
        Command::Inspect { scene, load, json } => inspect(scene, *load, *json),
    }
}

fn list(as_json: bool) -> Result<()> {
    if as_json {
        print(format_args!(
            "{:#}",
            json!({ "scenes": procedural::list() })
        ))?;
        return Ok(());
    }
    for scene in procedural::list() {
        print(format_args!("{}\n    {}", scene.name, scene.description))?;
        for parameter in scene.parameters {
            print(format_args!(
                "    --set {}={}    [{}] {}",
                parameter.name, parameter.default, parameter.values, parameter.doc
            ))?;
        }
    }
    Ok(())
}

/// What moves, and until when.
fn moves(motion: &Motion) -> Value {
    let count = |list: &[Option<u32>]| list.iter().flatten().count();
    json!({
        "instances": count(&motion.instances),
        "cameras": count(&motion.cameras),
        "emissive_materials": motion.emission.len(),
        "seconds": motion.seconds(),
    })
}

fn inspect(name: &str, load: Options, as_json: bool) -> Result<()> {
    let scene = open_scene(name, load, &Interrupt::watch()?)?;
    let requirements = Requirements::of(&scene);
    let requirements = value_of("requirements", &requirements)?;
    let bounds = scene.bounds();
    let cameras: Vec<_> = scene
        .cameras
        .iter()
        .map(|c| {
            json!({
                "name": c.name,
                "vertical_fov_degrees": c.vertical_fov.to_degrees(),
                "aspect_ratio": c.aspect_ratio,
            })
        })
        .collect();
    let summary = json!({
        "name": scene.name,
        "hash": scene.content_hash(),
        "triangles": scene.triangle_count(),
        "emissive_triangles": scene.emissive_triangle_count(),
        "meshes": scene.meshes.len(),
        "instances": scene.instances.len(),
        "materials": scene.materials.len(),
        "bounds": bounds.map(|b| json!({ "min": b.min.to_array(), "max": b.max.to_array() })),
        "cameras": cameras,
        "motion": scene.motion.as_ref().map(moves),
        "requirements": requirements,
        "notices": scene.notices,
    });
    if as_json {
        print(format_args!("{summary:#}"))?;
        return Ok(());
    }
    for text in &scene.notices {
        notice(text);
    }
    if let Some(fields) = summary.as_object() {
        for (key, value) in fields.iter().filter(|(key, _)| *key != "notices") {
            match value {
                serde_json::Value::String(text) => print(format_args!("{key:20} {text}"))?,
                value => print(format_args!("{key:20} {value}"))?,
            }
        }
    }
    Ok(())
}
