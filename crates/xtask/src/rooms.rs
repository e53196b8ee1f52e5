//! The rooms of every library - a file or folder directly in `src/` - and the imports between them.
//!
//! A room's floor is the length of the longest chain of imports below it. Imports must make no circle: then every arrow
//! points down. Counted are the paths `crate::ROOM` in code, and `crate::NAME` where `lib.rs` takes the name from a room; not in
//! tests (`#[cfg(test)]` modules, files below a `tests`
//! folder, `*tests.rs`) and not in comments; `lib.rs` and `main.rs` are doors, not rooms.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::{Result, root};

/// The rooms that a library may have at most.
const MOST_ROOMS: usize = 14;

/// Libraries that are held to [`MOST_ROOMS`].
const HELD: [&str; 1] = ["holo-render"];

/// Prints rooms and floors of all libraries; circles and too many rooms are errors.
pub fn run() -> Result {
    let crates = root().join("crates");
    let mut names: Vec<_> = std::fs::read_dir(&crates)
        .map_err(|why| format!("{}: {why}", crates.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("holo-") && crates.join(name).join("src/lib.rs").is_file())
        .collect();
    names.sort();
    let mut wrong = Vec::new();
    for name in names {
        let imports = imports(&crates.join(&name).join("src"))?;
        let circle = circle(&imports);
        let floors = if circle.is_empty() { floors(&imports) } else { BTreeMap::new() };
        let highest = floors.values().max().map_or(0, |floor| floor + 1);
        println!("{name}: {} rooms on {highest} floors", imports.len());
        for floor in (0..highest).rev() {
            let here: Vec<&str> =
                floors.iter().filter(|(_, on)| **on == floor).map(|(room, _)| room.as_str()).collect();
            println!("  {floor}: {}", here.join(" "));
        }
        if !circle.is_empty() {
            wrong.push(format!("{name}: these rooms import each other in a circle: {}", circle.join(" ")));
        }
        if HELD.contains(&name.as_str()) && imports.len() > MOST_ROOMS {
            wrong.push(format!("{name}: {} rooms, {MOST_ROOMS} at most", imports.len()));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// What every room imports.
fn imports(source: &Path) -> Result<BTreeMap<String, BTreeSet<String>>> {
    let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut texts = Vec::new();
    collect(source, &mut texts)?;
    for (path, text) in &texts {
        let inside = path.strip_prefix(source).unwrap_or(path);
        let room = inside.iter().next().unwrap_or_default().to_string_lossy().trim_end_matches(".rs").to_owned();
        if ["lib", "main", "bin"].contains(&room.as_str()) {
            continue;
        }
        imports.entry(room).or_default().extend(named(text));
    }
    let rooms: BTreeSet<String> = imports.keys().cloned().collect();
    let doors = doors(texts.iter().find(|(path, _)| *path == source.join("lib.rs")).map_or("", |(_, text)| text));
    for (room, of) in &mut imports {
        let resolved = of.iter().map(|name| doors.get(name).unwrap_or(name).clone());
        *of = resolved.filter(|name| name != room && rooms.contains(name)).collect();
    }
    Ok(imports)
}

/// The names that `lib.rs` takes from rooms, and from which.
fn doors(text: &str) -> BTreeMap<String, String> {
    let mut doors = BTreeMap::new();
    for part in text.split("pub use ").skip(1) {
        let Some((path, _)) = part.split_once(';') else { continue };
        let Some((room, names)) = path.split_once("::") else { continue };
        let names = names.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|name| !name.is_empty());
        doors.extend(names.map(|name| (name.to_owned(), room.to_owned())));
    }
    doors
}

fn collect(folder: &Path, texts: &mut Vec<(std::path::PathBuf, String)>) -> Result {
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

/// The rooms that code names, tests and comments left out; `use crate::{a, b}` names both.
fn named(text: &str) -> BTreeSet<String> {
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

/// The rooms that are left when those without imports are taken away again and again.
fn circle(imports: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let mut left = imports.clone();
    loop {
        let free: Vec<String> = left.iter().filter(|(_, of)| of.is_empty()).map(|(room, _)| room.clone()).collect();
        if free.is_empty() {
            return left.into_keys().collect();
        }
        left.retain(|room, _| !free.contains(room));
        left.values_mut().for_each(|of| of.retain(|room| !free.contains(room)));
    }
}

fn floors(imports: &BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, usize> {
    let mut floors: BTreeMap<String, usize> = imports.keys().map(|room| (room.clone(), 0)).collect();
    // There is no circle, so no chain is longer than all rooms.
    for _ in 0..imports.len() {
        for (room, of) in imports {
            let floor = of.iter().map(|below| floors[below] + 1).max().unwrap_or(0);
            floors.insert(room.clone(), floor);
        }
    }
    floors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_are_named_by_code_alone() {
        let text = "use crate::{Error, a::{x, y}, b};\n// crate::c\nfn f() { crate::d::g() }\n#[cfg(test)]\nmod tests { use crate::e; }";
        assert_eq!(named(text), ["Error", "a", "b", "d"].map(String::from).into());
    }

    #[test]
    fn circles_are_found() {
        let imports = |list: &[(&str, &[&str])]| {
            list.iter().map(|(room, of)| ((*room).to_owned(), of.iter().map(|o| (*o).to_owned()).collect())).collect()
        };
        assert!(circle(&imports(&[("a", &["b"]), ("b", &[])])).is_empty());
        assert_eq!(circle(&imports(&[("a", &["b"]), ("b", &["a"]), ("c", &[])])), ["a", "b"]);
        assert_eq!(floors(&imports(&[("a", &["b"]), ("b", &["c"]), ("c", &[])]))["a"], 2);
    }
}
