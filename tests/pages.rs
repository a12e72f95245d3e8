//! Pages that name tests.

use std::fs;
use std::path::{Path, PathBuf};

/// All Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut found = Vec::new();
    for path in entries {
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}

/// Each row of the limits names a test, and each test that it names is in the file that it names before it, or in `src`.
#[test]
fn limits_name_tests_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("tests/LIMITS.md")).unwrap();
    let read = |file: &PathBuf| fs::read_to_string(file).unwrap();
    let units: String = sources(&root.join("src")).iter().map(read).collect();
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

/// True if some code has a test with this name.
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
