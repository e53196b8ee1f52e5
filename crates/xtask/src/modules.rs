//! The files of every crate and what they import of each other.
//!
//! A **room** is a file or folder directly in `src/`; a file and its folder count once. A crate has at most twelve. Files
//! must not import each other in a circle, except for a file and those in its folder; neither must rooms. The level of a
//! room is the length of the longest chain of imports below it. Tests do not count. No source file has more than 600 lines,
//! no function in Rust more than 80.

mod imports;
mod lengths;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use self::imports::{File, imports};
use crate::{Result, root};

/// How many rooms a crate may have.
const MAX_ROOMS: usize = 12;

/// What files or rooms import.
type Graph<T> = BTreeMap<T, BTreeSet<T>>;

/// Prints the rooms of all crates by level.
///
/// # Errors
///
/// Circles, too many rooms, and what is too long.
pub fn run() -> Result {
    let crates = root().join("crates");
    let mut errors = lengths::too_long()?;
    for name in names(&crates)? {
        let source = crates.join(&name).join("src");
        if !source.is_dir() {
            continue;
        }
        let files = without_parents(imports(&source)?);
        let rooms = rooms(&files);
        let count = names(&source)?.iter().map(|name| name.trim_end_matches(".rs").to_owned()).collect::<BTreeSet<_>>();
        println!("{name}: {} files in {} rooms", files.len(), count.len());
        let shown = |file: &File| if file.is_empty() { "lib".into() } else { file.join("::") };
        let circles = circle(&files);
        if circles.is_empty() {
            print_levels(&rooms);
        } else {
            let circles: Vec<String> = circles.iter().map(shown).collect();
            errors.push(format!("{name}: these files import each other in a circle: {}", circles.join(" ")));
        }
        let circles = circle(&rooms);
        if !circles.is_empty() {
            errors.push(format!("{name}: these rooms import each other in a circle: {}", circles.join(" ")));
        }
        if count.len() > MAX_ROOMS {
            errors.push(format!("{name}: {} rooms, {MAX_ROOMS} at most", count.len()));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n")) }
}

/// The names in a folder, sorted.
fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut names: Vec<_> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    Ok(names)
}

/// Without the imports of files above the file: those of a file and its folder may go both ways.
fn without_parents(mut files: Graph<File>) -> Graph<File> {
    for (file, of) in &mut files {
        of.retain(|other| !file.starts_with(other));
    }
    files
}

/// The imports between rooms.
fn rooms(files: &Graph<File>) -> Graph<String> {
    let mut rooms = Graph::new();
    for (file, of) in files {
        let Some(room) = file.first() else { continue };
        let others = of.iter().filter_map(|other| other.first()).filter(|other| *other != room).cloned();
        rooms.entry(room.clone()).or_insert_with(BTreeSet::new).extend(others);
    }
    rooms
}

fn print_levels(rooms: &Graph<String>) {
    let levels = levels(rooms);
    let count = levels.values().max().map_or(0, |level| level + 1);
    for level in (0..count).rev() {
        let here: Vec<&str> = levels.iter().filter(|(_, of)| **of == level).map(|(room, _)| room.as_str()).collect();
        println!("  {level}: {}", here.join(" "));
    }
}

/// What remains when those that import nothing, and those that nothing imports, are removed repeatedly; nothing without a
/// circle.
fn circle<T: Ord + Clone>(graph: &Graph<T>) -> Vec<T> {
    let mut left = graph.clone();
    loop {
        let imported: BTreeSet<T> = left.values().flatten().cloned().collect();
        let is_free = |node: &T, of: &BTreeSet<T>| of.is_empty() || !imported.contains(node);
        let free: BTreeSet<T> =
            left.iter().filter(|(node, of)| is_free(node, of)).map(|(node, _)| node.clone()).collect();
        if free.is_empty() {
            return left.into_keys().collect();
        }
        left.retain(|node, _| !free.contains(node));
        left.values_mut().for_each(|of| of.retain(|node| !free.contains(node)));
    }
}

fn levels(rooms: &Graph<String>) -> BTreeMap<String, usize> {
    let mut levels: BTreeMap<String, usize> = rooms.keys().map(|room| (room.clone(), 0)).collect();
    // No chain is longer than the number of rooms.
    for _ in 0..rooms.len() {
        for (room, of) in rooms {
            let level = of.iter().filter_map(|below| levels.get(below)).map(|level| level + 1).max().unwrap_or(0);
            levels.insert(room.clone(), level.min(rooms.len()));
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(list: &[(&str, &[&str])]) -> Graph<String> {
        let of = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        list.iter().map(|(name, names)| ((*name).to_owned(), of(names))).collect()
    }

    #[test]
    fn circles_are_found() {
        assert!(circle(&graph(&[("a", &["b"]), ("b", &[])])).is_empty());
        let with_circle = graph(&[("a", &["b"]), ("b", &["a"]), ("c", &[]), ("d", &["a"])]);
        assert_eq!(circle(&with_circle), ["a", "b"]);
        assert_eq!(levels(&graph(&[("a", &["b"]), ("b", &["c"]), ("c", &[])]))["a"], 2);
    }

    #[test]
    fn a_file_and_its_folder_may_import_each_other() {
        let file = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<File>();
        let (parent, child, other) = (file(&["a"]), file(&["a", "b"]), file(&["c"]));
        let both_ways =
            [(parent.clone(), [child.clone()].into()), (child.clone(), [parent.clone(), other.clone()].into())];
        let files = without_parents(both_ways.into_iter().chain([(other.clone(), BTreeSet::new())]).collect());
        assert!(circle(&files).is_empty());
        assert_eq!(rooms(&files)["a"], ["c".to_owned()].into());
    }
}
