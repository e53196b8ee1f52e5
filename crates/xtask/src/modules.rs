//! The top-level modules of every library (a file or folder directly in `src/`) and the imports between them.
//!
//! The level of a module is the length of the longest chain of imports below it. Imports must not form a cycle. Counted
//! are the paths `crate::MODULE` in code, and `crate::NAME` where `lib.rs` re-exports the name from a module; not those
//! in tests (`#[cfg(test)]` modules, files below a `tests` folder, `*tests.rs`) and in comments. `lib.rs`, `main.rs`
//! and `bin` are no modules here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::{Result, root};

/// How many top-level modules a library of [`LIMITED`] may have.
const LIMIT: usize = 14;

/// The libraries to which [`LIMIT`] applies.
const LIMITED: [&str; 1] = ["holo-render"];

/// What every module imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// Prints the modules of all libraries by level.
///
/// # Errors
///
/// Cycles, and too many modules.
pub fn run() -> Result {
    let crates = root().join("crates");
    let mut names: Vec<_> = std::fs::read_dir(&crates)
        .map_err(|why| format!("{}: {why}", crates.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("holo-") && crates.join(name).join("src/lib.rs").is_file())
        .collect();
    names.sort();
    let mut errors = Vec::new();
    for name in names {
        let imports = imports(&crates.join(&name).join("src"))?;
        let cycle = cycle(&imports);
        let levels = if cycle.is_empty() { levels(&imports) } else { BTreeMap::new() };
        let count = levels.values().max().map_or(0, |level| level + 1);
        println!("{name}: {} modules on {count} levels", imports.len());
        for level in (0..count).rev() {
            let here: Vec<&str> =
                levels.iter().filter(|(_, of)| **of == level).map(|(module, _)| module.as_str()).collect();
            println!("  {level}: {}", here.join(" "));
        }
        if !cycle.is_empty() {
            errors.push(format!("{name}: these modules import each other in a cycle: {}", cycle.join(" ")));
        }
        if LIMITED.contains(&name.as_str()) && imports.len() > LIMIT {
            errors.push(format!("{name}: {} modules, {LIMIT} at most", imports.len()));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n")) }
}

fn imports(source: &Path) -> Result<Imports> {
    let mut imports = Imports::new();
    let mut texts = Vec::new();
    collect(source, &mut texts)?;
    for (path, text) in &texts {
        let inside = path.strip_prefix(source).unwrap_or(path);
        let module = inside.iter().next().unwrap_or_default().to_string_lossy().trim_end_matches(".rs").to_owned();
        if ["lib", "main", "bin"].contains(&module.as_str()) {
            continue;
        }
        imports.entry(module).or_default().extend(imported(text));
    }
    let modules: BTreeSet<String> = imports.keys().cloned().collect();
    let root = texts.iter().find(|(path, _)| *path == source.join("lib.rs"));
    let reexports = reexports(root.map_or("", |(_, text)| text));
    for (module, of) in &mut imports {
        let resolved = of.iter().map(|name| reexports.get(name).unwrap_or(name).clone());
        *of = resolved.filter(|name| name != module && modules.contains(name)).collect();
    }
    Ok(imports)
}

/// The names that `lib.rs` re-exports, and the module of each.
fn reexports(text: &str) -> BTreeMap<String, String> {
    let mut reexports = BTreeMap::new();
    for part in text.split("pub use ").skip(1) {
        let Some((path, _)) = part.split_once(';') else { continue };
        let Some((module, names)) = path.split_once("::") else { continue };
        let names = names.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|name| !name.is_empty());
        reexports.extend(names.map(|name| (name.to_owned(), module.to_owned())));
    }
    reexports
}

fn collect(folder: &Path, texts: &mut Vec<(PathBuf, String)>) -> Result {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            collect(&path, texts)?;
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
            let text = std::fs::read_to_string(&path).map_err(|why| format!("{}: {why}", path.display()))?;
            texts.push((path, text));
        }
    }
    Ok(())
}

/// The first names after `crate::` in code, without tests and comments; `use crate::{a, b}` has both.
fn imported(text: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let code: String = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut names = BTreeSet::new();
    for (at, found) in code.match_indices("crate::") {
        let rest = &code[at + found.len()..];
        let word = |text: &str| text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("").to_owned();
        if let Some(list) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut start = true;
            for (k, c) in list.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' => start = depth == 0,
                    c if start && depth == 0 && !c.is_whitespace() => {
                        names.insert(word(&list[k..]));
                        start = false;
                    }
                    _ => {}
                }
            }
        } else {
            names.insert(word(rest));
        }
    }
    names
}

/// The modules that remain when those without imports are removed repeatedly; none without a cycle.
fn cycle(imports: &Imports) -> Vec<String> {
    let mut left = imports.clone();
    loop {
        let free: Vec<String> = left.iter().filter(|(_, of)| of.is_empty()).map(|(module, _)| module.clone()).collect();
        if free.is_empty() {
            return left.into_keys().collect();
        }
        left.retain(|module, _| !free.contains(module));
        left.values_mut().for_each(|of| of.retain(|module| !free.contains(module)));
    }
}

fn levels(imports: &Imports) -> BTreeMap<String, usize> {
    let mut levels: BTreeMap<String, usize> = imports.keys().map(|module| (module.clone(), 0)).collect();
    // Without a cycle no chain is longer than the number of modules.
    for _ in 0..imports.len() {
        for (module, of) in imports {
            let level = of.iter().map(|below| levels[below] + 1).max().unwrap_or(0);
            levels.insert(module.clone(), level);
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imports_are_taken_from_code_alone() {
        let text = "use crate::{Error, a::{x, y}, b};\n// crate::c\nfn f() { crate::d::g() }\n\
                    #[cfg(test)]\nmod tests { use crate::e; }";
        assert_eq!(imported(text), ["Error", "a", "b", "d"].map(String::from).into());
    }

    #[test]
    fn cycles_are_found() {
        let imports = |list: &[(&str, &[&str])]| {
            list.iter()
                .map(|(module, of)| ((*module).to_owned(), of.iter().map(|o| (*o).to_owned()).collect()))
                .collect()
        };
        assert!(cycle(&imports(&[("a", &["b"]), ("b", &[])])).is_empty());
        assert_eq!(cycle(&imports(&[("a", &["b"]), ("b", &["a"]), ("c", &[])])), ["a", "b"]);
        assert_eq!(levels(&imports(&[("a", &["b"]), ("b", &["c"]), ("c", &[])]))["a"], 2);
    }
}
