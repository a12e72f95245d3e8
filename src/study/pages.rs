//! Writes the HTML pages of a study: an overview, and one page with plots and pictures for each scene. They
//! show the results of the runs that are finished.

use super::comparison::{Comparison, percent, range};
use super::costs::Cost;
use super::folder;
use super::ledger::Ledger;
use super::manifest::Manifest;
use super::outputs::Results;
use super::plan::{Plan, Resolved, rendered_on};
use super::results::Row;
use super::scene_page::{Scene, facts};
use crate::base::files::write_atomically;
use crate::page::{Overview, OverviewRow, OverviewScene};
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The maximum number of characters of a scene's name that the file name of its page contains; only the last
/// ones are used.
const MOST_CHARACTERS: usize = 60;

/// The HTML pages of a study in its folder: the overview `index.html`, and the pages of the scenes in the
/// subfolder `pages`.
pub struct Pages {
    overview: PathBuf,
    /// The path of the subfolder with the pages of the scenes.
    folder: PathBuf,
    /// The file name of each scene's page, in the order of the scenes in the plan.
    names: Vec<String>,
}

impl Pages {
    /// Prepares the pages of a study of the plan `plan` in `folder`. This only stores paths, and opens
    /// nothing.
    pub fn new(folder: &Path, plan: &Plan) -> Self {
        Self {
            overview: folder.join("index.html"),
            folder: folder::pages(folder),
            names: file_names(plan.scenes.iter().map(|scene| scene.name.as_str())),
        }
    }

    /// The paths of all pages, also of those that do not exist yet.
    pub fn files(&self) -> Vec<PathBuf> {
        let pages = self.names.iter().map(|name| self.folder.join(name));
        pages.chain([self.overview.clone()]).collect()
    }

    /// Writes all pages. `results` are the results of the runs and references in `ledger`. A scene without a
    /// reference has no page yet; the overview then has no link for it.
    ///
    /// # Errors
    /// A file of a reference cannot be read, or a page cannot be written.
    pub fn write(
        &self,
        (plan, configurations): (&Plan, &[Resolved]),
        manifest: &Manifest,
        results: &Results,
        ledger: &mut Ledger,
    ) -> Result<()> {
        let mut rest = results.rows.iter().zip(&results.costs);
        let mut scenes = Vec::new();
        std::fs::create_dir_all(&self.folder).map_err(|e| Error::writing(&self.folder, e))?;
        for (planned, name) in plan.scenes.iter().zip(&self.names) {
            let scene = Scene {
                plan,
                planned,
                identity: manifest.identity(&planned.name),
                results: (rendered_on(configurations, &planned.name).zip(&mut rest))
                    .map(|(configuration, (row, cost))| (configuration, row, cost))
                    .collect(),
            };
            let comparison = Comparison::new(&scene.results, manifest.shard.is_whole());
            let file = self.folder.join(name);
            let page = scene.page(&comparison, manifest, ledger)?;
            match &page {
                Some(page) => {
                    let html = page.html()?;
                    write_atomically(&file, |file| file.write_all(html.as_bytes()))?;
                }
                // A page of an earlier plan would stand beside other results.
                None => match std::fs::remove_file(&file) {
                    Err(error) if error.kind() != ErrorKind::NotFound => {
                        return Err(Error::writing(&file, error));
                    }
                    _ => {}
                },
            }
            let link = page.map(|_| format!("pages/{name}"));
            scenes.push(overview(&scene, &comparison, link));
        }
        let html = Overview {
            title: format!(
                "Study `{}`",
                title(&manifest.request.plan).replace('`', "'")
            ),
            question: plan.purpose.clone(),
            scenes,
            facts: facts(plan, manifest),
        }
        .html()?;
        write_atomically(&self.overview, |file| file.write_all(html.as_bytes()))
    }
}

/// The section of the overview about one scene: its answer, its table, and the address `link` of its page.
fn overview(scene: &Scene<'_>, comparison: &Comparison<'_>, link: Option<String>) -> OverviewScene {
    let row = |(configuration, row, cost): &(&Resolved, &Row, &Cost)| {
        let entries = comparison.entries.iter();
        let mut entries = entries.filter(|entry| entry.configuration.name == configuration.name);
        let entry = entries.next();
        let is_first = comparison.entries.first().is_some_and(|first| {
            first.configuration.name == configuration.name && comparison.is_decided
        });
        OverviewRow {
            configuration: configuration.name.clone(),
            error_at_equal_time: match entry {
                Some(entry) if entry.is_base => Some("1".to_owned()),
                _ => cost.error_at_equal_time.map(range),
            },
            time_ratio: match entry {
                Some(entry) if entry.is_base => Some("1".to_owned()),
                _ => cost.time_ratio.map(range),
            },
            error: entry.map(percent),
            seeds: row.seeds,
            verdict: row.verdict.text().to_owned(),
            is_advised: is_first,
        }
    };
    OverviewScene {
        name: scene.planned.name.clone(),
        link,
        answer: comparison.answer(scene.size()).sentence,
        rows: scene.results.iter().map(row).collect(),
    }
}

/// The title of the overview: the name of a plan, or the name of its file without the ending.
fn title(plan: &str) -> String {
    let stem = Path::new(plan).file_stem();
    stem.map_or(plan.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Makes a different file name for each scene: the letters and digits of its name in lower case, and a number
/// if another scene already has this file name. Lower case keeps them apart on file systems that ignore case.
fn file_names<'a>(scenes: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let name = |scene: &str| {
        let words = scene.split(|c: char| !c.is_ascii_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let plain = words.join("-").to_ascii_lowercase();
        // The end of a path has the name of its file.
        let plain = &plain[plain.len().saturating_sub(MOST_CHARACTERS)..];
        let plain = if plain.is_empty() { "scene" } else { plain };
        let numbered = (2..).map(|number| format!("{plain}-{number}.html"));
        let mut names = std::iter::once(format!("{plain}.html")).chain(numbered);
        let name = names.find(|name| taken.insert(name.clone()));
        name.unwrap_or_default()
    };
    scenes.map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pages_are_plain_and_different() {
        let long = format!("/{}/a.glb", "x".repeat(300));
        let scenes = [
            "Cornell",
            "cornell",
            "cornell-2",
            "a/b c.glb",
            "../",
            "木",
            &long,
        ];
        let names = file_names(scenes.into_iter());
        let wanted = [
            "cornell.html",
            "cornell-2.html",
            "cornell-2-2.html",
            "a-b-c-glb.html",
            "scene.html",
            "scene-2.html",
        ];
        assert_eq!(&names[..6], wanted);
        assert!(
            names[6].len() < 70 && names[6].ends_with("x-a-glb.html"),
            "{names:?}"
        );
    }
}
