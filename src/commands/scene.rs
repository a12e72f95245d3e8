//! `scene`: lists and generates procedural scenes, and prints the contents of scene files.

use super::arguments::check_files;
use super::choices::LoadArgs;
use super::interrupt::Interrupt;
use super::notice;
use super::{open_scene, print};
use crate::base::json::value_of;
use crate::base::printable::printable;
use crate::image::Image;
use crate::procedural;
use crate::scene::camera::{DEFAULT_ASPECT, Projection, framing_camera};
use crate::scene::requirements::Requirements;
use crate::scene::{Environment, Motion};
use crate::scene_files::{Options, environment_file_of, export};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The subcommands of `scene`: they list procedural scenes, write one to a file, or print the contents of any scene.
#[derive(clap::Subcommand)]
pub enum Command {
    /// List the procedural scenes and their parameters.
    List {
        /// Print the scenes as one JSON object instead of text
        #[arg(long)]
        json: bool,
    },
    /// Write a procedural scene with its camera as .glb, or a sky as .exr.
    Generate {
        /// The name of a procedural scene, or a sky such as sky:sun=40, with the sun's elevation in degrees
        name: String,
        /// The file to write: .glb for a scene, .exr for a sky
        #[arg(short, long, value_name = "FILE.glb|FILE.exr")]
        output: PathBuf,
        /// A parameter of the scene and its value, see 'headwater scene list'; may be given several times; other
        /// parameters have their defaults
        #[arg(long, value_name = "KEY=VALUE")]
        set: Vec<String>,
    },
    /// Print the triangles, lights, materials, bounds and cameras of a scene, and what it requires of the renderer.
    Inspect {
        /// The scene: the name of a procedural scene (see 'headwater scene list'), or a file, .gltf, .glb or .obj
        scene: String,
        /// Options for loading the scene: missing files, files outside of its folder, and the variant of its materials
        #[command(flatten)]
        load: LoadArgs,
        /// Print the contents as one JSON object instead of text
        #[arg(long)]
        json: bool,
    },
}

/// Runs the subcommand `list`, `generate` or `inspect` of `scene`.
///
/// # Errors
/// Wrong arguments or input, a file that cannot be written, or a signal.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::List { json } => list(*json),
        Command::Generate { name, output, set } => {
            let is_sky = environment_file_of(name).is_none();
            let [what, ending] = match is_sky {
                true => ["sky", "exr"],
                false => ["scene", "glb"],
            };
            if output
                .extension()
                .is_none_or(|e| !e.eq_ignore_ascii_case(ending))
            {
                return Err(Error::input(format!(
                    "'{}': a generated {what} is written as .{ending}",
                    output.display()
                )));
            }
            check_files([("--output", output.as_path())], [])?;
            if is_sky {
                return write_sky(name, set, output);
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
        Command::Inspect { scene, load, json } => inspect(scene, load.options(), *json),
    }
}

/// Writes the radiance of the sky `name` as an EXR file, an image by longitude and latitude with the zenith at the top.
/// Any option `--set` (in `set`) is an error, because `name` contains the parameters of the sky.
fn write_sky(name: &str, set: &[String], output: &Path) -> Result<()> {
    if let Some(change) = set.first() {
        return Err(Error::input(format!(
            "--set {change} is for scenes; a sky has its parameters in its name: sky:{change}"
        )));
    }
    let sky = Environment::open(name, &mut Vec::new())?;
    let texels: Vec<[f32; 3]> = sky.texels.iter().map(|texel| texel.to_array()).collect();
    let mut image = Image::new(sky.width, sky.height);
    image.set_vectors("", ["R", "G", "B"], &texels);
    image.write(output, 0.0)
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

/// A JSON object that describes the motion of a scene, for `scene inspect`: the numbers of instances, cameras and
/// emissive materials that change with time, and the time of the last key frame in seconds.
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
    let mut scene = open_scene(name, load, &Interrupt::watch()?)?;
    scene.surround(None)?;
    let requirements = Requirements::of(&scene);
    let features = requirements.features();
    let requirements = value_of("requirements", &requirements)?;
    let bounds = scene.bounds();
    let eyes = match scene.cameras.as_slice() {
        [] => vec![
            framing_camera(&scene, DEFAULT_ASPECT)
                .camera_to_world
                .translation,
        ],
        cameras => cameras
            .iter()
            .map(|c| c.camera_to_world.translation)
            .collect(),
    };
    let limits = scene.limits(&eyes);
    let cameras: Vec<_> = scene
        .cameras
        .iter()
        .map(|c| {
            let (key, extent) = match c.projection {
                Projection::Perspective { vertical_fov, .. } => {
                    ("vertical_fov_degrees", vertical_fov.to_degrees())
                }
                Projection::Orthographic { height } => ("orthographic_height", height),
            };
            json!({ "name": c.name, key: extent, "aspect_ratio": c.aspect_ratio })
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
        "material_variants": scene.material_variants,
        "bounds": bounds.map(|b| json!({ "min": b.min.to_array(), "max": b.max.to_array() })),
        "cameras": cameras,
        "motion": scene.motion.as_ref().map(moves),
        "requirements": requirements,
        "limits": limits,
        "notices": scene.notices,
    });
    if as_json {
        print(format_args!("{summary:#}"))?;
        return Ok(());
    }
    for text in &scene.notices {
        notice(text);
    }
    let [required, left_out] = features;
    let lists = [("requires", required), ("does without", left_out)];
    for (key, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
        print(format_args!("{key:20} {}", list.join(", ")))?;
    }
    for limit in &limits {
        let key = if limit.passed {
            "past a limit"
        } else {
            "near a limit"
        };
        print(format_args!("{key:20} {}", printable(&limit.text)))?;
    }
    let machine_readable = ["notices", "requirements", "limits"];
    if let Some(fields) = summary.as_object() {
        for (key, value) in
            (fields.iter()).filter(|(key, _)| !machine_readable.contains(&key.as_str()))
        {
            match value {
                serde_json::Value::String(text) => {
                    print(format_args!("{key:20} {}", printable(text)))?;
                }
                value => print(format_args!("{key:20} {value}"))?,
            }
        }
    }
    Ok(())
}
