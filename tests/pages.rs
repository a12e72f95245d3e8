//! Tests of the pages (Markdown files): tables of measurements are what is stored, links lead to existing places, pages are
//! short, and the tests that they name exist.

use serde::Deserialize;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// The maximum number of words of a page that explains a concept.
const MOST_WORDS: usize = 1500;

/// The root folder of the project.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A question and the measurements that answer it: one JSON file of `tests/measurements`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Measurement {
    question: String,
    /// The result, and the decision that follows from it.
    answer: String,
    tables: Vec<Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    title: String,
    measured: Measured,
    #[serde(default)]
    command: Commands,
    /// The meaning of the columns.
    about: String,
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
}

/// The origin of a table: date, commit, device and driver of the measurement; `None` where one does not matter.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Measured {
    date: Option<String>,
    commit: Option<String>,
    device: Option<String>,
    driver: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(untagged)]
enum Commands {
    #[default]
    None,
    One(String),
    Several(Vec<String>),
}

impl Measurement {
    /// All measurements, each with the name of its file without ending, sorted by name.
    fn all() -> Vec<(String, Self)> {
        let folder = root().join("tests/measurements");
        let mut files: Vec<PathBuf> = (fs::read_dir(folder).unwrap())
            .map(|entry| entry.unwrap().path())
            // Registers of shaders are compared by their own tool.
            .filter(|path| {
                path.extension().is_some_and(|e| e == "json")
                    && !path.ends_with("gpu-statistics.json")
            })
            .collect();
        files.sort();
        let read = |path: &PathBuf| {
            let text = fs::read_to_string(path).unwrap();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let measurement = serde_json::from_str(&text);
            (
                name.clone(),
                measurement.unwrap_or_else(|error| panic!("{name}: {error}")),
            )
        };
        files.iter().map(read).collect()
    }

    fn page(&self, name: &str) -> String {
        let mut page = format!(
            "# {}\n\n{}\n\n*Made from `{name}.json` by `tools/measurements`.*\n",
            self.question, self.answer
        );
        for table in &self.tables {
            table.write(&mut page);
        }
        page
    }
}

impl Table {
    fn write(&self, page: &mut String) {
        write!(page, "\n## {}\n\n{}\n", self.title, self.about).unwrap();
        let commands: &[String] = match &self.command {
            Commands::None => &[],
            Commands::One(command) => std::slice::from_ref(command),
            Commands::Several(commands) => commands,
        };
        if !commands.is_empty() {
            write!(page, "\n```\n{}\n```\n", commands.join("\n")).unwrap();
        }
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let rule = self.columns.iter().map(|_| "---".to_owned()).collect();
        write!(page, "\n{}{}", row(self.columns.clone()), row(rule)).unwrap();
        for cells in &self.rows {
            assert_eq!(cells.len(), self.columns.len(), "{}: {cells:?}", self.title);
            let text = |cell: &Value| {
                cell.as_str()
                    .map_or_else(|| cell.to_string(), str::to_owned)
            };
            page.push_str(&row(cells.iter().map(text).collect()));
        }
        let Measured {
            date,
            commit,
            device,
            driver,
        } = &self.measured;
        let commit = commit.as_ref().map(|commit| format!("commit {commit}"));
        let from: Vec<&str> = [date, &commit, device, driver]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        write!(page, "\n*Measured: {}.*\n", from.join(", ")).unwrap();
    }
}

/// The pages of measurements, and the page that lists them, must be what their JSON files make. `tools/measurements` writes
/// them.
#[test]
fn measurements_are_what_is_stored() {
    let all = Measurement::all();
    assert!(all.len() > 20);
    let mut list = "# Measurements\n\nEach page answers one question. It is made from a JSON file beside it by \
                    `tools/measurements`, which also makes this list.\n\n| question | answer |\n|---|---|\n"
        .to_owned();
    let mut pages = Vec::new();
    for (name, measurement) in &all {
        writeln!(
            list,
            "| [{}]({name}.md) | {} |",
            measurement.question, measurement.answer
        )
        .unwrap();
        pages.push((name.as_str(), measurement.page(name)));
    }
    pages.push(("README", list));
    let folder = root().join("tests/measurements");
    for (name, page) in &pages {
        let path = folder.join(format!("{name}.md"));
        if std::env::var_os("HEADWATER_WRITE_PAGES").is_some() {
            fs::write(path, page).unwrap();
        } else {
            let stored = fs::read_to_string(&path).unwrap_or_default();
            assert!(
                stored == *page,
                "{name}.md is not what {name}.json makes; run tools/measurements"
            );
        }
    }
    let stored = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    assert_eq!(
        stored.filter(is_page).count(),
        pages.len(),
        "a page has no JSON file"
    );
}

/// The Markdown files that git tracks, without those that are generated.
fn written_pages() -> Vec<PathBuf> {
    let mut found = vec![
        root().join("README.md"),
        root().join(".github/CONTRIBUTING.md"),
    ];
    for folder in ["src", "glsl", "tests", "tools", "scenes"] {
        found.extend(files_below(&root().join(folder), "md"));
    }
    found.retain(|page| {
        !page.starts_with(root().join("tests/measurements"))
            && !page.starts_with(root().join("tests/fuzz"))
    });
    assert!(found.len() > 20, "{found:?}");
    found
}

#[test]
fn pages_are_short_and_name_no_commit() {
    for page in written_pages() {
        let text = fs::read_to_string(&page).unwrap();
        let words = text.split_whitespace().count();
        assert!(words <= MOST_WORDS, "{} has {words} words", page.display());
        for word in text.split(|c: char| !c.is_ascii_alphanumeric()) {
            let is_hex =
                word.len() >= 7 && word.chars().all(|c| matches!(c, '0'..='9' | 'a'..='f'));
            let is_commit = is_hex
                && word.contains(|c: char| c.is_ascii_digit())
                && word.contains(|c: char| c.is_ascii_lowercase());
            assert!(!is_commit, "{} names the commit {word}", page.display());
        }
    }
}

/// Links to files of the project, and to headings in them, must exist.
#[test]
fn links_lead_somewhere() {
    let mut links = 0;
    let mut broken = Vec::new();
    for page in written_pages() {
        let text = fs::read_to_string(&page).unwrap();
        for target in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            if target.starts_with("http") {
                continue;
            }
            links += 1;
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() {
                page.clone()
            } else {
                page.parent().unwrap().join(file)
            };
            let has_heading = || {
                headings(&fs::read_to_string(&path).unwrap())
                    .iter()
                    .any(|name| name == heading)
            };
            if !path.exists() || !heading.is_empty() && !has_heading() {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    assert!(links > 100, "{links}");
}

/// The headings of a page, in the form in which links name them.
fn headings(text: &str) -> Vec<String> {
    let lines = text.lines().filter(|line| line.starts_with('#'));
    let name = |line: &str| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title
            .chars()
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    lines.map(name).collect()
}

/// All files below a folder whose names have this ending.
fn files_below(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut found = Vec::new();
    for path in entries {
        if path.is_dir() {
            found.extend(files_below(&path, ending));
        } else if path.extension().is_some_and(|found| found == ending) {
            found.push(path);
        }
    }
    found
}

/// Each row of `tests/LIMITS.md` must name a test. Each named test must be in the test file that stands before it in the
/// row, or in `src`.
#[test]
fn limits_name_tests_that_exist() {
    let root = root();
    let page = fs::read_to_string(root.join("tests/LIMITS.md")).unwrap();
    let read = |file: &PathBuf| fs::read_to_string(file).unwrap();
    let units: String = files_below(&root.join("src"), "rs")
        .iter()
        .map(read)
        .collect();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| ")).collect();
    assert!(rows.len() > 25, "{}", rows.len());
    for row in rows.iter().filter(|row| !row.starts_with("| quantity")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        assert_eq!(cells.len(), 6, "{row}");
        let mut tests = 0;
        let mut code = units.clone();
        // Every second part of a text with backticks is code.
        for name in cells[3..]
            .iter()
            .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        {
            if name.ends_with(".rs") {
                code = read(&root.join("tests").join(name)) + &units;
            } else if name.contains('_') {
                assert!(is_test(&code, name), "{name} is no test there: {row}");
                tests += 1;
            }
        }
        assert!(tests > 0, "no test is named: {row}");
    }
}

/// True if the code has a test function with this name.
fn is_test(code: &str, name: &str) -> bool {
    let start = format!("fn {name}(");
    code.match_indices(&start).any(|(at, _)| {
        // `#[should_panic]` may stand between.
        let mut before = code[..at].lines().rev().map(str::trim);
        before
            .by_ref()
            .find(|line| !line.is_empty() && !line.starts_with("#[should_panic"))
            == Some("#[test]")
    })
}
