//! `study merge`: joins the folders of the shards of a study to one folder with the results of the whole
//! study.

use super::{DeviceArgs, conduct, report};
use crate::base::input_files;
use crate::commands::choices::LoadArgs;
use crate::commands::notice;
use crate::study::folder::{self, Folder};
use crate::study::forecast::Forecast;
use crate::study::ledger::Ledger;
use crate::study::library::Library;
use crate::study::manifest::Manifest;
use crate::study::outputs::Outputs;
use crate::study::pages::Pages;
use crate::study::pictures::Pictures;
use crate::study::shard::Shard;
use crate::study::store::Store;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// The command-line arguments of `headwater study merge`, which name the folders of the shards and the folder
/// for the whole study.
#[derive(clap::Args)]
pub struct Args {
    /// The folders of the shards
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// The folder for the whole study: a new one, or one of an earlier merge of the same study
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Only join what the shards have: render nothing, neither the repetitions after a sign of bias, nor more seeds where
    /// an interval is too wide, which depend on the results of all shards
    #[arg(long)]
    no_render: bool,
    #[command(flatten)]
    load: LoadArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Joins the runs, the references and the pictures of the shards, and writes the results. If all shards are
/// complete, and `--no-render` is not given, then renders what depends on the results of all shards.
///
/// # Errors
/// A folder has no study, the studies differ, a shard is given twice or missing, or as for a study.
pub fn run(args: &Args) -> Result<()> {
    let mut manifests = Vec::new();
    for folder in &args.shards {
        let path = folder::manifest(folder);
        let manifest = Manifest::read(&path)?.ok_or_else(|| {
            Error::input(format!(
                "{} has no study: there is no file {}",
                folder.display(),
                path.display()
            ))
        })?;
        manifests.push((folder, manifest));
    }
    let Some((first_folder, first)) = manifests.first().cloned() else {
        return Err(Error::input("name the folders of the shards"));
    };
    let mut whole = first.clone();
    whole.shard = Shard::WHOLE;
    for (index, (folder, manifest)) in manifests.iter().enumerate() {
        if let Some(why) = whole.difference(manifest) {
            return Err(Error::input(format!(
                "{} and {} do not fit together: {why}",
                first_folder.display(),
                folder.display()
            )));
        }
        let same = |(_, other): &&(&PathBuf, Manifest)| other.shard == manifest.shard;
        if let Some((other, _)) = manifests[..index].iter().find(same) {
            return Err(Error::input(format!(
                "{} and {} are the same shard",
                other.display(),
                folder.display()
            )));
        }
        if manifest.shard.count != first.shard.count {
            return Err(Error::input(format!(
                "{} and {} are of studies with different numbers of shards",
                first_folder.display(),
                folder.display()
            )));
        }
        for identity in &manifest.scenes {
            whole.remember(identity);
        }
    }
    let missing = first.shard.count - manifests.len() as u64;
    let (plan, configurations) = whole.request.plan()?;
    // The order of the plan, whoever loaded a scene first.
    let order = |name: &str| plan.scenes.iter().position(|scene| scene.name == name);
    whole.scenes.sort_by_key(|identity| order(&identity.scene));
    let folder = Folder::open(&args.output)?;
    if let Some(old) = Manifest::read(&folder.manifest())? {
        let why = (old.difference(&whole))
            .or_else(|| (!old.shard.is_whole()).then(|| "it is a shard".to_owned()));
        if let Some(why) = why {
            return Err(Error::input(format!(
                "{} has another study, because {why}; name another folder with --output",
                args.output.display()
            )));
        }
    }
    let mut store = Store::open(&folder.runs())?;
    for (shard, _) in &manifests {
        for run in Store::look_into(&folder::runs(shard))?.all() {
            if store.find(&run.key, run.seed).is_none() {
                store.add(run.clone())?;
            }
        }
        copy_pictures(&folder::references(shard), &folder.references())?;
        copy_pictures(&folder::pictures(shard), &folder.pictures())?;
    }
    whole.write(&folder.manifest())?;
    let mut ledger = Ledger {
        store,
        library: Library::new(folder.references()),
        pictures: Pictures::new(folder.pictures()),
        forecast: Forecast::default(),
    };
    let outputs = Outputs::new(folder.path());
    let work = (&plan, configurations.as_slice());
    let results = outputs.write(work, &whole, &mut ledger)?;
    Pages::new(folder.path(), &plan).write(work, &whole, &results, &mut ledger)?;
    let lacking: usize = (results.rows.iter())
        .map(|row| (plan.seeds as usize).saturating_sub(row.seeds))
        .sum();
    if args.no_render || missing > 0 || lacking > 0 {
        if missing > 0 || lacking > 0 {
            notice(&format!(
                "{missing} of {} shards and {lacking} runs are missing; run the command of an incomplete shard again, and merge again",
                first.shard.count
            ));
        }
        return report(&results, Shard::WHOLE);
    }
    drop(folder);
    let request = whole.request.clone();
    let (load, device) = (&args.load, &args.device);
    conduct(
        &args.output,
        request,
        Shard::WHOLE,
        load,
        device,
        Some(&whole),
    )
}

/// Copies the EXR files from the folder `from` that the folder `to` does not have yet. Does nothing if `from`
/// does not exist.
fn copy_pictures(from: &Path, to: &Path) -> Result<()> {
    let entries = match from.read_dir() {
        Ok(entries) => entries,
        // Empty folders are often lost on the way from one machine to another.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(Error::reading(from, error)),
    };
    for entry in entries {
        let entry = entry.map_err(|e| Error::reading(from, e))?;
        let (path, copy) = (entry.path(), to.join(entry.file_name()));
        let is_picture = path.extension().is_some_and(|ending| ending == "exr");
        // Others are unfinished files of a shard that was killed.
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if is_picture && !is_hidden && !copy.exists() {
            let bytes = input_files::read(&path)?;
            crate::base::files::write_atomically(&copy, |file| {
                std::io::Write::write_all(file, &bytes)
            })?;
        }
    }
    Ok(())
}
