//! Tests that imports go in one direction. A room (a folder of `src`) imports only the rooms that the table in
//! `src/README.md` allows. The files of a room do not import each other in a ring: no file needs a file that needs it.
//!
//! A file and the folder of its submodules count as one. Code behind `#[cfg(test)]` is not checked, nor are `mod.rs` files
//! and exported macros.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Folders within rooms whose files are checked for rings too.
const INNER: &[&str] = &[
    "render/integrators",
    "render/integrators/restir",
    "render/light_samplers",
];

/// The room that all other rooms may import, so that no table lists it.
const BASE: &str = "base";
const PACKAGE: &str = "shader_interface";

/// The source text of each module, by its path, such as `["gpu", "buffer"]`.
type Modules = BTreeMap<Vec<String>, String>;

/// The names of the modules that a module imports, by its name; all are children of the same parent.
type Imports = BTreeMap<String, BTreeSet<String>>;

#[test]
fn rooms_import_what_their_table_lists() {
    let page = std::fs::read_to_string(source_folder().join("README.md")).unwrap();
    let listed = listed_imports(&page);
    assert!(listed.len() > 10, "{listed:?}");
    let found = imports_of_rooms(&modules());
    for (room, imports) in &found {
        let listed = (listed.get(room)).unwrap_or_else(|| panic!("src/README.md misses {room}"));
        assert_eq!(
            imports, listed,
            "imports of src/{room}, and those in src/README.md"
        );
    }
    assert_eq!(
        found.len(),
        listed.len(),
        "rooms of src/README.md that do not exist"
    );
}

#[test]
fn planted_imports_between_rooms_are_found() {
    let found = |source: &str| {
        let mut modules = modules();
        let text = modules.get_mut(&path_of("scene/bounds")).unwrap();
        text.insert_str(0, source);
        imports_of_rooms(&modules)["scene"].contains("render")
    };
    assert!(!found(""));
    assert!(!found("// crate::render::Settings\n"));
    for source in [
        "use crate::render::Settings;\n",
        "use crate::{Error, render};\n",
        "use super::super::render::Settings;\n",
        "fn f() -> crate::render::Settings {}\n",
    ] {
        assert!(found(source), "{source}");
    }
}

#[test]
fn no_files_import_each_other_in_a_ring() {
    let modules = modules();
    let rooms = imports_of_rooms(&modules);
    for folder in rooms
        .keys()
        .map(String::as_str)
        .chain(INNER.iter().copied())
    {
        if let Some(ring) = ring(&imports(&modules, &path_of(folder))) {
            panic!("src/{folder}: {}", ring.join(" → "));
        }
    }
}

#[test]
fn planted_rings_are_found() {
    let found = |sources: &[(&str, &str)]| {
        let modules = (sources.iter())
            .map(|(path, source)| (path_of(path), (*source).to_owned()))
            .collect();
        ring(&imports(&modules, &path_of("m"))).map(|ring| ring.join(" "))
    };
    let ring = Some("a b a".to_owned());
    let a = ("m/a", "use super::b::B;");
    for b in [
        "use super::a::A;",
        "use crate::{Error, m::{a::{self, A}, c}};",
        "fn f() -> $crate::m::a::A {}",
        "use crate::m::A;",
    ] {
        let parent = ("m", "mod a;\npub use a::{A, Other};");
        assert_eq!(found(&[parent, a, ("m/b", b), ("m/c", "")]), ring, "{b}");
    }
    assert_eq!(
        found(&[a, ("m/b", ""), ("m/b/part", "use super::super::a;")]),
        ring
    );
    for b in [
        "// super::a\nconst TEXT: &str = \"super::a\";",
        "use crate::other::a;",
        "use super::b::a;",
        "#[cfg(test)]\nmod tests { use super::super::a; }",
    ] {
        assert_eq!(found(&[a, ("m/b", b)]), None, "{b}");
    }
}

fn source_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every module of `src` with its source text.
fn modules() -> Modules {
    let mut modules = Modules::new();
    read(&source_folder(), &[], &mut modules);
    modules
}

/// The rooms in the table of the page, each with the rooms in its last column.
fn listed_imports(page: &str) -> Imports {
    let names = |cell: &str| -> BTreeSet<String> {
        let quoted = cell.split('`').skip(1).step_by(2);
        quoted
            .map(|name| name.trim_end_matches('/').to_owned())
            .collect()
    };
    let table = page
        .lines()
        .skip_while(|line| !line.starts_with("| room |"));
    let rows = table.skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").collect();
        let room = names(cells[0]).pop_first().unwrap();
        (room, names(cells.get(2).copied().unwrap_or_default()))
    })
    .collect()
}

/// The rooms that each room imports according to its source, without [`BASE`].
fn imports_of_rooms(modules: &Modules) -> Imports {
    let is_room = |name: &str| source_folder().join(name).is_dir();
    let mut all = imports(modules, &[]);
    all.retain(|room, _| is_room(room));
    for (room, imports) in &mut all {
        imports.retain(|import| is_room(import) && import != BASE && room != PACKAGE);
    }
    all
}

fn path_of(text: &str) -> Vec<String> {
    text.split('/').map(str::to_owned).collect()
}

/// Reads the modules below a folder, whose module path is `parent`, into `modules`.
fn read(folder: &Path, parent: &[String], modules: &mut Modules) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let mut module = parent.to_owned();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem != "mod" {
            module.push(stem.to_owned());
        }
        if path.is_dir() {
            read(&path, &module, modules);
        } else if path.extension().is_some_and(|e| e == "rs") {
            modules.insert(module, std::fs::read_to_string(&path).unwrap());
        }
    }
}

/// The imports between the children of a module, also through names that the module exports again.
fn imports(modules: &Modules, parent: &[String]) -> Imports {
    let child = |path: &[String]| Some(path.strip_prefix(parent)?.first()?.clone());
    let mut imports: Imports = (modules.keys())
        .filter_map(|path| Some((child(path)?, BTreeSet::new())))
        .collect();
    let exported: BTreeMap<String, String> = (modules.get(parent).into_iter())
        .flat_map(|source| exports(source))
        .filter_map(|path| Some((path.last()?.clone(), path.first()?.clone())))
        .filter(|(_, child)| imports.contains_key(child))
        .collect();
    for (path, source) in modules {
        let Some(from) = child(path) else { continue };
        for to in references(source, path) {
            let Some(name) = child(&to) else { continue };
            let to = exported.get(&name).unwrap_or(&name);
            if *to != from && imports.contains_key(to) {
                imports.get_mut(&from).unwrap().insert(to.clone());
            }
        }
    }
    imports
}

/// A ring among the imports, as a list of names in which the first is also the last; `None` if there is none.
fn ring(imports: &Imports) -> Option<Vec<String>> {
    fn visit(name: &str, imports: &Imports, way: &mut Vec<String>) -> Option<Vec<String>> {
        let start = way.iter().position(|n| n == name);
        way.push(name.to_owned());
        if let Some(start) = start {
            return Some(way[start..].to_vec());
        }
        let found = (imports[name].iter()).find_map(|next| visit(next, imports, way));
        way.pop();
        found
    }
    (imports.keys()).find_map(|name| visit(name, imports, &mut Vec::new()))
}

/// The absolute module paths that a source names through `crate`, `self` or `super`; `module` is the path of the source.
fn references(source: &str, module: &[String]) -> Vec<Vec<String>> {
    let tokens = tokens(source);
    let mut rest = tokens.as_slice();
    let mut found = Vec::new();
    while let Some((first, after)) = rest.split_first() {
        let is_path = after.first().is_some_and(|t| t == "::");
        if is_path && matches!(first.as_str(), "crate" | "self" | "super") {
            paths(&mut rest, &[], &mut found);
        } else {
            rest = after;
        }
    }
    let absolute = |path: Vec<String>| {
        let mut from = module.to_vec();
        let mut names = path.into_iter().peekable();
        while let Some(name) = names.next_if(|n| matches!(n.as_str(), "crate" | "self" | "super")) {
            match name.as_str() {
                "crate" => from.clear(),
                "super" => drop(from.pop()),
                _ => {}
            }
        }
        from.extend(names);
        from
    };
    found.into_iter().map(absolute).collect()
}

/// The paths in the `pub use` lines of a module.
fn exports(source: &str) -> Vec<Vec<String>> {
    let tokens = tokens(source);
    let mut found = Vec::new();
    for (index, token) in tokens.iter().enumerate().skip(1) {
        if token == "use" && matches!(tokens[index - 1].as_str(), "pub" | ")") {
            paths(&mut &tokens[index + 1..], &[], &mut found);
        }
    }
    found
}

/// Reads a path such as `a::b::{c, d::e}` from the front of the tokens, and adds every single path in it to `found`, after
/// `prefix`.
fn paths(tokens: &mut &[String], prefix: &[String], found: &mut Vec<Vec<String>>) {
    let mut path = prefix.to_vec();
    while let Some((first, rest)) = tokens.split_first() {
        *tokens = rest;
        if first == "{" {
            while tokens.first().is_some_and(|t| t != "}") {
                paths(tokens, &path, found);
                // Past `as NAME` and the comma.
                while let Some((token, rest)) = tokens.split_first()
                    && token != "}"
                {
                    *tokens = rest;
                    if token == "," {
                        break;
                    }
                }
            }
            *tokens = tokens.get(1..).unwrap_or_default();
            return;
        }
        path.push(first.clone());
        match tokens.split_first() {
            Some((colons, rest)) if colons == "::" => *tokens = rest,
            _ => break,
        }
    }
    found.push(path);
}

/// The words, `::` and other characters of a source, without comments, strings and its tests.
fn tokens(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = if is_word(first) {
            rest.find(|c| !is_word(c)).unwrap_or(rest.len())
        } else if rest.starts_with("//") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
            continue;
        } else if first == '"' {
            rest = after_string(&rest[1..]);
            continue;
        } else if rest.starts_with("'\"'") {
            3
        } else if rest.starts_with("::") {
            2
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(length);
        if !token.trim().is_empty() {
            tokens.push(token.to_owned());
        }
        rest = after;
    }
    tokens
}

/// The text after a string literal; `text` begins after the first quote of the string.
fn after_string(text: &str) -> &str {
    let mut escaped = false;
    for (index, byte) in text.bytes().enumerate() {
        match byte {
            b'"' if !escaped => return &text[index + 1..],
            b'\\' => escaped = !escaped,
            _ => escaped = false,
        }
    }
    ""
}
