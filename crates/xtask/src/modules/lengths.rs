//! The lengths of files and functions.

use std::process::Command;

use crate::setup::process;
use crate::{Result, root};

/// How many lines a source file may have, and a function in Rust, whose code rustfmt has indented.
const MAX_LINES: [usize; 2] = [600, 80];

/// What is longer, in words.
pub(super) fn too_long() -> Result<Vec<String>> {
    let mut list = Command::new("git");
    list.current_dir(root()).args(["ls-files", "*.rs", "*.py", "*.js", "*.css", "*.html", ".ci"]);
    let mut errors = Vec::new();
    let [of_files, of_functions] = MAX_LINES;
    for name in process::output(&mut list)?.lines() {
        // One that git knows may be deleted.
        let Ok(text) = std::fs::read_to_string(root().join(name)) else { continue };
        let count = text.lines().count();
        if count > of_files {
            errors.push(format!("{name}: {count} lines, {of_files} at most"));
        }
        if name.ends_with(".rs") {
            let long = functions(&text).into_iter().filter(|(_, count)| *count > of_functions);
            errors.extend(
                long.map(|(line, count)| {
                    format!("{name}:{line}: the function has {count} lines, {of_functions} at most")
                }),
            );
        }
    }
    Ok(errors)
}

/// The first lines of all functions, counted from 1, and how many lines they have.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = |line: &str| {
        let is_before =
            |word: &&str| word.starts_with("pub") || ["const", "async", "unsafe", "extern", "\"C\""].contains(word);
        line.split_whitespace().find(|word| !is_before(word)) == Some("fn")
    };
    let length = |start: usize| {
        let indent = lines[start].len() - lines[start].trim_start().len();
        let is_last = |line: &str| line.get(indent..) == Some("}") && line[..indent].trim().is_empty();
        let mut is_declared = true;
        for (k, line) in lines[start..].iter().enumerate() {
            is_declared &= !line.contains('{');
            if is_last(line) || is_declared && line.ends_with(';') || k == 0 && line.ends_with('}') {
                return k + 1;
            }
        }
        lines.len() - start
    };
    (0..lines.len()).filter(|&start| begins(lines[start])).map(|start| (start + 1, length(start))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_end_at_their_brace() {
        let text = "trait A {\n    fn declared(\n        x: u8,\n    );\n    fn short() {}\n}\n\npub(crate) const fn long() {\n    \
                    if x {\n    }\n}\n";
        assert_eq!(functions(text), [(2, 3), (5, 1), (8, 4)]);
    }
}
