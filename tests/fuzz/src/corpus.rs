//! Writes the corpus: valid files for each target into `FOLDER/TARGET`, and its dictionary into `FOLDER/TARGET.dict`.

mod scenes;

use headwater::render::presets::PRESETS;
use headwater::render::settings::Settings;
use headwater::study::plans::PLANS;
use headwater_fuzz::{images, words};
use std::error::Error;
use std::path::Path;

/// Files by name.
type Files = Vec<(String, Vec<u8>)>;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: corpus FOLDER")?;
    let folder = Path::new(&folder);
    let keys = Settings::default().describe()?.into_iter();
    let keys: Vec<String> = keys.map(|setting| setting.key).collect();
    let gltf_words = [words::GLTF_KEYS, words::GLTF_TEXTS].concat();
    let toml_words = words::TOML.to_owned() + &keys.join(" ");
    let pictures = || [images::exrs(), images::pngs()].concat();
    let environments = || [images::exrs(), images::hdrs()].concat();
    write(folder, "gltf", scenes::gltf(), &gltf_words)?;
    write(folder, "glb", scenes::glb()?, &gltf_words)?;
    write(folder, "obj", scenes::obj(), words::OBJ)?;
    write(folder, "texture", images::textures(), words::IMAGE)?;
    write(folder, "environment", environments(), words::IMAGE)?;
    write(folder, "picture", pictures(), words::IMAGE)?;
    write(folder, "settings", settings()?, &toml_words)?;
    write(folder, "plan", plans()?, &toml_words)?;
    Ok(())
}

fn write(folder: &Path, target: &str, files: Files, words: &str) -> Result<(), Box<dyn Error>> {
    let subfolder = folder.join(target);
    std::fs::create_dir_all(&subfolder)?;
    for (name, bytes) in files {
        std::fs::write(subfolder.join(name), bytes)?;
    }
    // libFuzzer takes a backslash, a quote and what is not ASCII by their codes.
    let code = |byte: u8| format!("\\x{byte:02X}");
    let line = |word: &str| format!("\"{}\"\n", word.bytes().map(code).collect::<String>());
    let dictionary: String = words.split_whitespace().map(line).collect();
    std::fs::write(folder.join(format!("{target}.dict")), dictionary)?;
    Ok(())
}

/// The presets, and each section of the settings as it is by default: an execution takes as long as it has keys.
fn settings() -> Result<Files, Box<dyn Error>> {
    let mut files: Files = (PRESETS.iter())
        .map(|preset| (format!("{}.toml", preset.name), preset.text.into()))
        .collect();
    let all: toml::Table = toml::to_string(&Settings::default().to_value()?)?.parse()?;
    for (key, value) in all {
        let section = toml::Table::from_iter([(key.clone(), value)]);
        files.push((
            format!("default-{key}.toml"),
            toml::to_string(&section)?.into(),
        ));
    }
    Ok(files)
}

fn plans() -> Result<Files, Box<dyn Error>> {
    let tables = r#"fps = 24
start_time = 0.5
most_seeds = 8
seeds = 2
count = true
bounces = 2
[[scenes]]
scene = "cornell"
look_at = "0,1,3,0,1,0,40"
environment = "sky:sun=40"
reference_spp = 4
[[configurations]]
name = "a"
preset = "accurate"
expect = "any"
scenes = ["cornell"]
set = { "indirect.mis" = "balance" }
"#;
    let mut files = vec![("tables.toml".into(), tables.into())];
    for (name, text) in PLANS {
        files.push((format!("{name}.toml"), with_small_sweeps(text)?.into()));
    }
    Ok(files)
}

/// A plan with at most two values in each sweep: the time of an execution is that of its configurations.
fn with_small_sweeps(plan: &str) -> Result<String, Box<dyn Error>> {
    let mut plan: toml::Table = plan.parse()?;
    let sweeps = plan.get_mut("sweeps").and_then(toml::Value::as_array_mut);
    for sweep in sweeps.into_iter().flatten() {
        let over = sweep.get_mut("over").and_then(toml::Value::as_table_mut);
        let lists = over
            .into_iter()
            .flatten()
            .filter_map(|(_, value)| value.as_array_mut());
        for (index, list) in lists.enumerate() {
            list.truncate(if index == 0 { 2 } else { 1 });
        }
    }
    Ok(toml::to_string(&plan)?)
}
